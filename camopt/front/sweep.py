"""The sweep: every design of a space through the kernels, block by block, and its Pareto set."""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from camopt.engines import Engine
from camopt.engines.threads import Threads
from camopt.front.asked import FRONT_ONLY, TABLED, SweepPlan, column_names, sweep_plan
from camopt.front.blocks import BLOCK
from camopt.front.checkpoint import Checkpoint, checkpoint_at
from camopt.front.estimate import foresee
from camopt.front.front_search import FrontSearch
from camopt.front.journal import Journal, Tell, all_batches, journal_at, recalled, what_is_kept
from camopt.front.pareto import Front, best_of_laws, front_of, thinned
from camopt.front.refine import refined
from camopt.front.streaming import Seen, gathered
from camopt.front.summary import from_summary, summary_of
from camopt.mechanisms import Designs
from camopt.mistakes import BadInput, Mistake
from camopt.problem.problem import Problem, exactly, resolve
from camopt.problem.rows import Rows, concatenate_rows
from camopt.problem.space import EDGE_OF_SPACE, Space
from camopt.progress import Progress
from camopt.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.shown import HasHtml
from camopt.storage.files import write_text
from camopt.storage.publishing import published
from camopt.storage.unit import Unit
from camopt.tables.cells import to_json
from camopt.tables.columns import bounds_shown, columns_of, joined_laws, laws_shown, with_law
from camopt.tables.design_tables import designs_table
from camopt.tables.designs import ByLaw, Design
from camopt.tables.layout import Table, table_of
from camopt.tables.table import TableWriter, arrow_schema, table_file
from camopt.verdicts.judging import Effort, bound_excesses, by_excess, evaluate_rows, least_excess

MOST_LOOKED_AT = 1 << 22  # designs for the nearest miss: to find nothing does not take twice as long
SWEEP_COMMAND, SWEEP_SCENE = "sweep", "scene.toml"
SWEEP_FILES = ("pareto.parquet", "pareto-grid.parquet", "designs.parquet", SWEEP_SCENE)
"""Names of files that sweeps write, each some of them."""


@dataclass(frozen=True)
class Sweep(HasHtml):
    """The result of a sweep: counts, files, and the best designs.

    Attributes
    ----------
    scene : Scene
        What was asked.
    designs : int
        Designs of the space.
    impossible : int or None
        Designs that cannot be assembled, such as an offset beyond the prime radius; they are in no table. None
        where boxes of designs were decided together: nobody has counted them.
    feasible : int or None
        Feasible designs; None, too, where boxes were decided.
    effort : Effort
        Designs so near a limit that they were looked at again, and in balls; and those undecided even then, which
        are not feasible, and in no table but that of all.
    pareto : int
        Designs on the Pareto front.
    files : tuple of pathlib.Path
        What was written.
    best : dict
        The best feasible design of each law: least first objective, ties by the next. ``held_by`` names the
        limits that the next smaller cam of the space would exceed. Where boxes were decided, the best on the front.
    nearest_miss : Design or None
        Where nothing is feasible: the design with the least excess, and what it exceeds under ``violated``; of more
        than four million designs, that of some blocks, evenly spread. None where boxes were decided.
    reached : float
        The largest relative half-width of an enclosure of any row kept.
    front : Front or None
        Hypervolume, ideal, nadir and knee of the Pareto front; None where nothing is feasible.
    obstacle : str
        Where no design can be put together: the condition that all of them break.
    evaluated : int
        Designs that were evaluated, one by one.
    boxes : int
        Boxes of designs that were bounded; 0 where every design was evaluated.
    decided_by_boxes : int
        Designs in boxes that were dropped. A few of them were evaluated before.
    already_done : bool
        Whether the result was in the folder already.

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> swept = camopt.sweep(camopt.find_scene("roller-1000rpm").replace(search=search))
    >>> swept.feasible, swept.best["cycloidal"]["base_radius_mm"], swept.best["cycloidal"]["held_by"]
    (1, 120.0, 'pressure_angle')
    """

    scene: Scene
    designs: int
    impossible: int | None
    feasible: int | None
    effort: Effort
    pareto: int
    files: tuple[Path, ...]
    best: dict[str, Design]
    nearest_miss: Design | None
    reached: float = 0.0
    front: Front | None = None
    obstacle: str = ""
    evaluated: int = 0
    boxes: int = 0
    decided_by_boxes: int = 0
    already_done: bool = False

    def __repr__(self) -> str:
        feasible = "" if self.feasible is None else f" {self.feasible:,} feasible,"
        return (
            f"<Sweep of {self.scene.name}: {self.designs:,} designs,{feasible} {self.pareto:,} on the Pareto front>"
        )

    def table(self) -> Table | None:
        """The best design of each law."""
        if not self.best:
            return None
        rows, search = with_law(self.best.values()), self.scene.search
        where = " on the front" if self.feasible is None else ""
        if search.refine:
            where += " of the grid" if where else " on the grid"
        title = f"The best design{' of each law' if laws_shown(rows) else ''}{where}"
        return designs_table(title, resolve(self.scene), rows, ["held_by"], (*search.minimise, *search.maximise))

    def knee_table(self) -> Table | None:
        """The knee of the front, in the columns of ``table``."""
        if self.front is None or not self.best:
            return None
        knee, search, problem = [self.front.knee], self.scene.search, resolve(self.scene)
        columns = columns_of(problem, with_law(self.best.values()), (*search.minimise, *search.maximise))
        names = [*laws_shown(knee), *(name for name in columns if not name.startswith("law"))]
        return table_of("Its knee", with_law(knee), names, bounds_shown(problem))

    @property
    def shown_cam(self) -> Scene | None:
        """The best design, where there is one alone."""
        return next(iter(self.best.values())).scene if len(self.best) == 1 else None


Beside = Callable[[Any], dict[str, Any]]
"""What gives what is kept with a result in its manifest, in what JSON takes."""


def sweep(
    scene: Scene,
    out: str | os.PathLike[str] | None = None,
    keep: str = "feasible",
    workers: int | None = None,
    progress: Progress | None = None,
    block: int = BLOCK,
    engine: Engine | None = None,
    tell: Tell | None = None,
    again: bool = False,
    beside: Beside | None = None,
) -> Sweep:
    """Evaluate every design of the grid or the sample that a scene's ``[search]`` asks for; find the Pareto front.

    Parameters
    ----------
    scene : Scene
        Limits, objectives, and in ``[search]`` the values of each size and of other numbers, such as the spring
        rate, and the laws.
    out : str or os.PathLike, optional
        Folder for ``pareto.parquet``, ``designs.parquet`` and ``scene.toml``; None writes nothing. Where
        ``[search]`` says to refine, the front of the grid goes to ``pareto-grid.parquet``.
    keep : str, default "feasible"
        Which designs go to ``designs.parquet``: "feasible", "pareto", or "all" that can be assembled. With
        "front-only" there is no such table: the front is that of the other choices, row for row, but where the
        objectives allow it boxes of designs are decided together, and nobody counts the feasible ones.
    workers : int, optional
        Threads; None takes one a core. Rows are the same for any number, and for any ``block``.
    progress : callable, optional
        Called with (designs done, designs in all); where boxes are decided, with (boxes done, and about how many
        there will be).
    block : int, default 65536
        Designs evaluated together, which bounds the memory.
    engine : Engine, optional
        What evaluates the blocks in place of threads of this process: a ``cluster``. Rows are the same.
    tell : callable, optional
        Called with sentences that a user should know: of a long sweep, how long it may take and how much room on
        the disk; and whether it goes on where an interrupted one ended, or is done already.
    again : bool, default False
        Whether to compute anew what is in the folder already. If not, and the result there is of the same question
        and version, and its files are whole, that is what is returned.
    beside : callable, optional
        Called with the result before it is published. What it gives, in what JSON takes, is kept in the manifest:
        there the command keeps what it prints, for whoever asks again.

    Returns
    -------
    Sweep
        Counts, the best design of each law, the front, and the files.

    Raises
    ------
    BadInput
        If the space cannot be swept: a range without a step, an objective that the mechanism has not; for another
        ``keep``; for more than 10,000 diameters of the shaft, for these are taken one by one.
    OSError
        If a file cannot be written, there is no room for what is kept, or another run writes to the folder.

    References
    ----------
    H. T. Kung, F. Luccio, F. P. Preparata, On finding the maxima of a set of vectors, J. ACM 22 (1975).

    Examples
    --------
    >>> search = {"base_radius": [55, 60, 65], "offset": [0, 10, 20], "law": ["cycloidal"]}
    >>> swept = camopt.sweep(camopt.find_scene("roller-1000rpm").replace(search=search))
    >>> swept.designs, swept.feasible
    (9, 0)
    """
    # without a table nobody reads its rows; the front is the same
    asked = sweep_plan(scene, keep if out is not None or keep != "feasible" else "pareto", block)
    own = Threads(workers or os.cpu_count() or 1)
    if asked.front_only and engine:
        why = "decides boxes of designs on this machine alone; pareto gives the same front"
        raise BadInput([Mistake("camopt", "keep", keep, why, bare=True)])
    if out is not None and not again and (done := swept_already(asked, out, tell)):
        return done
    if asked.front_only:
        search = FrontSearch(asked.space, asked.names, own.workers, progress)

        def found(checkpoint: Checkpoint | None, write: Write) -> Seen:
            if checkpoint is None:
                return search.run()
            checkpoint.restore(search, tell)
            return search.run(checkpoint.offer)

        return result_of(asked, out, found, progress, lambda path: checkpoint_at(path, asked, tell), beside)

    def searched(journal: Journal | None, write: Write) -> Seen:
        if journal is None:
            return gathered(asked.space, asked.batches(asked.numbers(), engine or own), block, write, progress)
        foresee(journal, own, engine or own, tell)
        return gathered(asked.space, all_batches(journal, engine or own, tell), block, write, progress)

    return result_of(asked, out, searched, progress, lambda path: journal_at(path, asked, tell=tell), beside)


Write = Callable[[Rows], None]
"""What takes rows for the table of designs."""


class Keeps(Protocol):
    """An object that keeps finished work of a stopped sweep, and says so in words."""

    @property
    def kept(self) -> str: ...


Keeper = TypeVar("Keeper", bound=Keeps)


def result_of(
    asked: SweepPlan,
    out: str | os.PathLike[str] | None,
    search: Callable[[Keeper | None, Write], Seen],
    progress: Progress | None,
    keep: Callable[[Path], AbstractContextManager[Keeper]] | None = None,
    beside: Beside | None = None,
) -> Sweep:
    """The result of a search, written to a folder if there is one, with what is kept ``beside`` it.

    There ``keep`` opens what keeps the work of the search, in a file, and stays open until the tables are whole.
    """
    scene, space, kept = asked.scene, asked.space, None
    with what_is_kept(lambda: kept.kept if kept else ""), ExitStack() as stack:
        unit = None if out is None else stack.enter_context(_published(out, asked))
        kept = stack.enter_context(keep(unit.journal)) if unit and keep else None
        tables = _tables(stack, unit, asked) if unit else {}
        seen = search(kept, tables["designs"].append if tables and asked.keep in TABLED else _nowhere)
        compared = _compared(asked, seen, progress)
        rows, grid = compared.front, compared.grid
        front = front_of(rows, asked.problem.objectives, grid if scene.search.refine else None)
        front = front and replace(front, knee=Design(front.knee, scene))
        result = Sweep(
            scene=scene,
            designs=len(space),
            impossible=None if seen.existing is None else len(space) - seen.existing,
            feasible=seen.feasible,
            effort=seen.effort,
            reached=max(seen.reached, *(_half_width(each) for each in (rows, grid))),
            pareto=rows.count,
            files=_places(asked, unit.folder) if unit else (),
            best=best_of_each_law(scene, compared),
            nearest_miss=nearest_miss_of_space(asked) if seen.feasible == 0 else None,
            front=front,
            obstacle="" if seen.existing != 0 else asked.problem.setup.mechanism.assembly,
            evaluated=seen.evaluated,
            boxes=seen.boxes,
            decided_by_boxes=seen.decided,
        )
        if unit:
            about = {"designs": len(space), "evaluated": seen.evaluated, "decided_by_boxes": seen.decided}
            tables["pareto"].describe("camopt_sweep", to_json(about))
            if front:
                tables["pareto"].describe("camopt_front", to_json(front.to_dict()))
            for table, found in (("pareto", rows), ("pareto-grid", grid), ("designs", grid)):
                if table in tables and (table != "designs" or asked.keep == "pareto"):
                    tables[table].append(found)
            write_text(unit.path(SWEEP_SCENE), scene.to_toml())
            unit.answer = summary_of(result) | (beside(result) if beside else {})
    return result


def _published(out: str | os.PathLike[str], asked: SweepPlan) -> AbstractContextManager[Unit]:
    """Where a sweep writes its files."""
    return published(out, SWEEP_COMMAND, files_of(asked), stale=SWEEP_FILES, question=asked.question().plain)


def swept_already(asked: SweepPlan, out: str | os.PathLike[str], tell: Tell | None) -> Sweep | None:
    """The result of a sweep that is in a folder already; None if it is not."""

    def found(answer: Any) -> Sweep:
        numbers = from_summary(answer, asked.scene)
        files = _places(asked, Path(out))
        return Sweep(scene=asked.scene, designs=len(asked.space), files=files, already_done=True, **numbers)

    return recalled(out, SWEEP_COMMAND, asked.question(), found, tell)


def _nowhere(rows: Rows) -> None:
    """Rows of which no table is written."""


class Compared(NamedTuple):
    """The rows that people compare, with the digits of ``evaluate``."""

    front: Rows
    """As the scene asks for it, refined and thinned."""
    grid: Rows
    """The front of the grid."""
    best: Rows
    """The best design of each pair of laws, the best law first."""
    held: list[str]
    """What the next smaller cam of the space would exceed, of each of these."""


def _compared(asked: SweepPlan, found: Seen, progress: Progress | None) -> Compared:
    """What people compare of a search."""
    space, search, objectives = asked.space, asked.scene.search, asked.problem.objectives
    rows = refined(space, found.front, progress) if search.refine else found.front
    rows = rows if search.thin is None else thinned(rows, objectives, search.thin)
    best = best_of_laws(found.best, objectives)
    index, smaller = next_smaller_cams(space, best)
    tables = [best, smaller, rows] if rows is found.front else [best, smaller, rows, found.front]
    best, smaller, *fronts = to_compare(space, frozenset(asked.names), *tables)
    return Compared(fronts[0], fronts[-1], best, binding_limits(best.count, index, smaller))


def _half_width(rows: Rows) -> float:
    """The largest relative half-width of an enclosure of any of some rows."""
    return float(np.max(rows.columns.get("relative_half_width", 0.0), initial=0.0))


def file_name(table: str) -> str:
    """The file of a table."""
    return f"{table}.parquet"


def _tables(stack: ExitStack, unit: Unit, asked: SweepPlan) -> dict[str, TableWriter]:
    """The tables of a sweep by name, open until the stack is left."""
    scene = asked.scene.to_toml()
    return {
        table: stack.enter_context(table_file(unit.path(file_name(table)), arrow_schema(kept, scene)))
        for table, kept in _columns(asked).items()
    }


def _columns(asked: SweepPlan) -> dict[str, tuple[str, ...]]:
    """The columns of the tables of a sweep, by table."""
    names, refine = asked.names, asked.scene.search.refine
    columns = {} if asked.keep == FRONT_ONLY else {"designs": names}
    columns |= {"pareto": (*names, "refined") if refine else names}
    return columns | ({"pareto-grid": names} if refine else {})


def files_of(asked: SweepPlan) -> tuple[str, ...]:
    """The names of the files that a sweep writes."""
    return (*map(file_name, _columns(asked)), SWEEP_SCENE)


def _places(asked: SweepPlan, folder: Path) -> tuple[Path, ...]:
    return tuple(folder / name for name in files_of(asked))


def best_of_each_law(scene: Scene, compared: Compared) -> dict[str, Design]:
    """The best row of each pair of laws as a design, the best law first."""
    told = ({**row, "held_by": by} for row, by in zip(compared.best.records(), compared.held, strict=True))
    return ByLaw((joined_laws(row["law_rise"], row["law_return"]), Design(row, scene)) for row in told)


def to_compare(space: Space, names: frozenset[str], *tables: Rows) -> list[Rows]:
    """Rows that people compare, with columns that ``evaluate`` gives them: equal designs have equal rows.

    Columns are in the order of the quantities, wherever the rows come from.
    """
    everywhere = names.intersection(*(rows.columns for rows in tables))
    parts, places = [], []
    for problem, index, designs in space.designs_apart(concatenate_rows(rows.only(everywhere) for rows in tables)):
        for first in range(0, index.size, BLOCK):
            some = slice(first, first + BLOCK)
            parts.append(as_evaluated(problem, designs.take(some), names))
            places.append(index[some])
    if not parts:
        return [*tables]
    found, ends = concatenate_rows(parts), np.cumsum([rows.count for rows in tables])
    order = np.split(np.argsort(np.concatenate(places)), ends[:-1])
    return [_renewed(rows, found.take(index)) for rows, index in zip(tables, order, strict=True)]


def _renewed(rows: Rows, found: Rows) -> Rows:
    """Rows with the columns that were found, in the order of the quantities."""
    columns = rows.columns | found.columns
    return replace(rows, columns={name: columns[name] for name in QUANTITIES if name in columns})


def as_evaluated(problem: Problem, designs: Designs, names: frozenset[str]) -> Rows:
    """Quantities of designs as ``evaluate`` gives them: what else it is asked for shows in their last digits."""
    return evaluate_rows(exactly(problem), designs, names | problem.wanted).only(names)


def next_smaller_cams(space: Space, rows: Rows) -> tuple[NDArray[np.intp], Rows]:
    """The rows that are not at the edge of the space, and their designs with the next smaller size of the cam.

    Of a sample, with one that is one per cent smaller.
    """
    name = space.problem.size_name
    sizes = [space.next_smaller(size) for size in rows.column(name).tolist()]
    inside = np.flatnonzero([size is not None for size in sizes])
    smaller = rows.take(inside)
    return inside, replace(smaller, columns=smaller.columns | {name: np.array([sizes[row] for row in inside])})


def binding_limits(count: int, index: NDArray[np.intp], smaller: Rows) -> list[str]:
    """The limits that bind rows: those that the next smaller cam exceeds, if there is one."""
    held = [EDGE_OF_SPACE] * count
    for row, names in zip(index, smaller.column("violated"), strict=True):
        held[row] = str(names).replace(",", ", ")
    return held


def nearest_miss_of_space(asked: SweepPlan) -> Design | None:
    """The design of the space that misses its limits the least, with its quantities; of many, of some blocks."""
    space = asked.space
    best: tuple[tuple[float, float], Problem, Designs] | None = None
    step = max(len(space) // MOST_LOOKED_AT, 1)
    for problem, first, last in islice(space.blocks(asked.block), step // 2, None, step):
        designs = space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.exists(designs, problem.programme))
        if not len(designs):
            continue
        excess = bound_excesses(problem, designs, frozenset()).outer
        i = least_excess(excess)
        key = by_excess(excess[:, i])
        if best is None or key < best[0]:
            best = key, problem, designs.take([i])
    if best is None:
        return None
    _, problem, design = best
    (row,) = as_evaluated(problem, design, frozenset(column_names(problem))).records()
    return Design(row, asked.scene)

"""The sweep: every design of a space through the kernels, block by block, and its Pareto set."""

import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from camopt.files import result_folder, write_text
from camopt.front.pareto import Archive, Front, front_of, non_dominated, ranked, thinned
from camopt.front.refine import refined
from camopt.mechanisms import Designs
from camopt.mistakes import BadInput, Mistake, nearest
from camopt.problem.problem import VERDICT, Problem, exactly, resolve
from camopt.problem.rows import Rows, joined
from camopt.problem.space import Block, Space, space_of
from camopt.quantities import QUANTITIES, motion_quantity
from camopt.scene.scene import Scene
from camopt.shown import Shown
from camopt.smallest.result import Progress
from camopt.tables.cells import to_json
from camopt.tables.designs import Design
from camopt.tables.table import TableWriter, schema, table_file
from camopt.verdicts.judging import Effort, by_excess, judged, least_excess, screened, settled, weighed

BLOCK = 32768  # designs: Python's share is small, and memory stays bounded
KEPT = ("pareto", "feasible", "all")
"""Which designs a sweep can write to its table of designs."""


@dataclass(frozen=True)
class Sweep(Shown):
    """The result of a sweep: counts, files, and the best designs. Each ``Design`` maps quantities to values."""

    scene: Scene
    designs: int
    impossible: int
    """Designs that cannot be assembled, such as an offset beyond the prime radius; they are in no table."""
    feasible: int
    effort: Effort
    """Designs so near a limit that they were looked at again, and in balls; and those undecided even then, which
    are not feasible, and in no table but that of all."""
    pareto: int
    files: tuple[Path, ...]
    best: dict[str, Design]
    """The best feasible design of each law: least first objective, ties by the next. ``held_by`` names the
    limits that the next smaller cam of the space would exceed."""
    nearest_miss: Design | None
    """Where nothing is feasible: the design with the least excess, and what it exceeds under ``violated``."""
    reached: float = 0.0
    """The largest relative half-width of an enclosure of any row kept."""
    front: Front | None = None
    """Hypervolume, ideal, nadir and knee of the Pareto front, None where nothing is feasible."""
    obstacle: str = ""
    """Where no design can be put together: the condition that all of them break."""

    def __repr__(self) -> str:
        counts = f"{self.designs:,} designs, {self.feasible:,} feasible, {self.pareto:,} on the Pareto front"
        return f"<Sweep of {self.scene.name}: {counts}>"


@dataclass(frozen=True)
class Batch:
    """What one block gave: rows for the designs file, and rows that may be on the Pareto front."""

    designs: int
    existing: int
    feasible: int
    effort: Effort
    reached: float
    kept: Rows
    front: Rows
    best: Rows
    """Its best feasible row, or none."""


def sweep(
    scene: Scene,
    out: str | os.PathLike[str] | None = None,
    keep: str = "feasible",
    workers: int | None = None,
    progress: Progress | None = None,
    block: int = BLOCK,
) -> Sweep:
    """Evaluate every design of the grid that a scene's ``[search]`` spans, and find the Pareto front.

    Parameters
    ----------
    scene
        Limits, objectives, and in ``[search]`` the values of each size and the laws.
    out
        Folder for ``pareto.parquet``, ``designs.parquet`` and ``scene.toml``; None writes nothing. Where
        ``[search]`` says to refine, the front of the grid goes to ``pareto-grid.parquet``.
    keep
        Which designs go to ``designs.parquet``: "feasible", "pareto", or "all" that can be assembled.
    workers
        Threads; None takes one a core. Rows are the same for any number, and for any ``block``.
    progress
        Called with (designs done, designs in all).
    block
        Designs evaluated together, which bounds the memory.

    Returns
    -------
    Sweep
        Counts, the best design of each law, the front, and the files.

    Raises
    ------
    BadInput
        If the space cannot be swept: a range without a step, an objective that the mechanism has not; for another
        ``keep``.
    OSError
        If a file cannot be written.

    Examples
    --------
    >>> search = {"base_radius": [55, 60, 65], "offset": [0, 10, 20], "law": ["cycloidal"]}
    >>> swept = camopt.sweep(camopt.find_scene("roller-1000rpm").replace(search=search))
    >>> swept.designs, swept.feasible
    (9, 0)
    """
    if keep not in KEPT:
        raise BadInput([Mistake("camopt", "keep", keep, f"a choice of designs; {nearest(str(keep), KEPT)}")])
    problem = with_objectives(resolve(scene))
    space = space_of(problem)
    work = partial(_batch, space, column_names(problem), keep)
    designs, existing, feasible, effort, reached = 0, 0, 0, Effort(), 0.0
    search = problem.scene.search
    archive, firsts = Archive(search, block), []
    with ExitStack() as stack:
        tables = None if out is None else _tables(stack, Path(out), problem)
        for batch in _in_order(space, work, workers or os.cpu_count() or 1, block):
            designs += batch.designs
            existing += batch.existing
            feasible += batch.feasible
            effort = effort.plus(batch.effort)
            reached = max(reached, batch.reached)
            archive.add(batch.front)
            firsts.append(batch.best)
            if tables and keep != "pareto":
                tables["designs"].append(batch.kept)
            if progress:
                progress(designs, len(space))
        grid = archive.front()
        rows = refined(space, grid, progress) if search.refine else grid
        rows = rows if search.thin is None else thinned(rows, search, search.thin)
        rows, grid = to_compare(space, rows), to_compare(space, grid) if search.refine or keep == "pareto" else grid
        front = front_of(rows, search, grid if search.refine else None)
        front = front and replace(front, knee=Design(front.knee, problem.scene))
        if tables:
            if keep == "pareto":
                tables["designs"].append(grid)
            if search.refine:
                tables["pareto-grid"].append(grid)
            if front:
                tables["pareto"].describe("camopt_front", to_json(front.to_dict()))
            tables["pareto"].append(rows)
            write_text(Path(out or "") / "scene.toml", problem.scene.to_toml())
    return Sweep(
        scene=problem.scene,
        designs=designs,
        impossible=designs - existing,
        feasible=feasible,
        effort=effort,
        reached=reached,
        pareto=rows.count,
        files=tuple(Path(out or "") / name for name in ((*map(file_name, tables), "scene.toml") if tables else ())),
        best=best_of_each_law(space, joined(firsts)),
        nearest_miss=None if feasible else nearest_miss_of_space(space, block),
        front=front,
        obstacle="" if existing else problem.setup.mechanism.assembly,
    )


def file_name(table: str) -> str:
    """The file of a table."""
    return f"{table}.parquet"


def _tables(stack: ExitStack, folder: Path, problem: Problem) -> dict[str, TableWriter]:
    """The tables of a sweep by name, open until the stack is left."""
    stack.enter_context(result_folder(folder))
    names, scene, refine = column_names(problem), problem.scene.to_toml(), problem.scene.search.refine
    columns = {"designs": names, "pareto": (*names, "refined") if refine else names}
    columns |= {"pareto-grid": names} if refine else {}
    return {
        table: stack.enter_context(table_file(folder / file_name(table), schema(kept, scene)))
        for table, kept in columns.items()
    }


def with_objectives(problem: Problem) -> Problem:
    """The problem with objectives: the scene's, or else size, peak acceleration and pressure angle.

    A flat face is square to its motion, or its pressure angle all but given: it is no objective there.
    """
    search, setup = problem.scene.search, problem.setup
    if not (search.minimise or search.maximise):
        timed = setup.omega is not None
        acceleration = motion_quantity("acceleration", "", angular=setup.angular, timed=timed)
        names = [problem.size_name, acceleration]
        names += [] if setup.mechanism.curvature is None else ["pressure_angle_max_deg"]
        return replace(problem, scene=problem.scene.replace(**{"search.minimise": names}))
    return problem


def column_names(problem: Problem) -> tuple[str, ...]:
    """The columns of a sweep: sizes, what limits and objectives need, named outputs, and the verdict."""
    numbers = {name for name in problem.needed if QUANTITIES[name].kind is float}  # the verdict tells the rest
    outputs = problem.named if problem.scene.outputs else frozenset()
    names = problem.sizes | numbers | outputs | set(VERDICT)
    return tuple(name for name in QUANTITIES if name in names)


def _batch(space: Space, names: tuple[str, ...], keep: str, block: Block) -> Batch:
    """Evaluate one block of a space."""
    problem, first, last = block
    designs = space.designs(np.arange(first, last))
    designs = designs.take(problem.setup.mechanism.exists(designs, problem.programme))
    if keep == "all":
        evaluated, effort = settled(problem, designs, frozenset(names))
    else:
        evaluated, effort = screened(problem, designs, frozenset(names))
    feasible = evaluated.take(evaluated.column("feasible").astype(bool))
    front = non_dominated(feasible, problem.scene.search)
    best = ranked(front, problem.scene.search).take(np.arange(min(front.count, 1)))
    reached = float(np.max(evaluated.columns["relative_half_width"], initial=0.0))
    return Batch(last - first, len(designs), feasible.count, effort, reached, evaluated, front, best)


def _in_order(space: Space, work: Callable[[Block], Batch], workers: int, block: int) -> Iterator[Batch]:
    """Batches in the order of the space from a few threads, never far ahead of the reader.

    The first comes from this thread, so that an interrupt ends it while it compiles kernels.
    """
    blocks = space.blocks(block)
    yield from map(work, islice(blocks, 1))
    with ThreadPoolExecutor(workers) as pool:
        running: deque[Future[Batch]] = deque()
        try:
            for item in islice(blocks, workers + 1):
                running.append(pool.submit(work, item))
            while running:
                yield running.popleft().result()
                for item in islice(blocks, 1):
                    running.append(pool.submit(work, item))
        finally:
            pool.shutdown(cancel_futures=True)


def best_of_each_law(space: Space, rows: Rows) -> dict[str, Design]:
    """The first row of each pair of laws when sorted by the objectives in turn, the best law first."""
    rows, scene = ranked(rows, space.problem.scene.search), space.problem.scene
    first: dict[str, int] = {}
    for i, row in enumerate(rows.records()):
        first.setdefault(" / ".join(dict.fromkeys((row["law_rise"], row["law_return"]))), i)
    best = to_compare(space, rows.take(np.array(list(first.values()), dtype=int))).records()
    return {
        laws: Design({**row, "held_by": held_by(space, row)}, scene) for laws, row in zip(first, best, strict=True)
    }


def to_compare(space: Space, rows: Rows) -> Rows:
    """Rows that people compare, with the digits that ``evaluate`` gives: equal designs have equal rows."""
    parts, places = [rows.take(np.arange(0))], []
    for problem, index, designs in space.designs_of(rows):
        for first in range(0, index.size, BLOCK):
            some = slice(first, first + BLOCK)
            found = as_evaluated(problem, designs.take(some), frozenset(rows.columns))
            parts.append(Rows(rows.take(index[some]).columns | found.columns, found.count))
            places.append(index[some])
    return joined(parts).take(np.argsort(np.concatenate(places))) if places else rows


def as_evaluated(problem: Problem, designs: Designs, names: frozenset[str]) -> Rows:
    """Quantities of designs as ``evaluate`` gives them: what else it is asked for shows in their last digits."""
    return judged(exactly(problem), designs, names | problem.wanted).only(names)


def held_by(space: Space, row: dict[str, Any]) -> str:
    """What the next smaller cam of the space would exceed; "edge of the space" if there is none."""
    problem = space.problem
    key = "mean_radius" if problem.setup.mechanism.grooved else "base_radius"
    smaller = space.axes.get(key, np.array([]))
    smaller = smaller[smaller < row[problem.size_name]]
    if not smaller.size:
        return "edge of the space"
    one = Rows({name: np.array([value]) for name, value in row.items()}, 1)
    problem, _, design = next(space.designs_of(one))
    design = replace(design, size=smaller.max(keepdims=True))
    return str(judged(problem, design, frozenset()).column("violated")[0]).replace(",", ", ")


def nearest_miss_of_space(space: Space, block: int) -> Design | None:
    """The design of the space that misses its limits the least, with its quantities."""
    best: tuple[tuple[float, float], Problem, Designs] | None = None
    for problem, first, last in space.blocks(block):
        designs = space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.exists(designs, problem.programme))
        if not len(designs):
            continue
        excess = weighed(problem, designs, frozenset()).outer
        i = least_excess(excess)
        key = by_excess(excess[:, i])
        if best is None or key < best[0]:
            best = key, problem, designs.take([i])
    if best is None:
        return None
    _, problem, design = best
    (row,) = as_evaluated(problem, design, frozenset(column_names(problem))).records()
    return Design(row, problem.scene)

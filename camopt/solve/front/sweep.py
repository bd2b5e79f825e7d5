"""The sweep: every design of a space through the kernels, block by block, and its Pareto set.

A scene becomes a plan (``plan``): the space of designs, and what to keep of it. An engine evaluates its blocks
(``blocks``), one batch of them after another; finished batches are kept on disk, so that a stopped sweep goes on
from there (``store``). ``gather_batches`` takes what they give, rows for the table and the front so far. In the end
people's rows get the digits of ``evaluate`` (``reported_rows``), and tables and result appear together
(``result``). Where the front alone is wanted of a large space, boxes of designs are bounded in place of blocks,
which takes seconds, and keeps nothing (``front_search``).
"""

import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import asdict, replace
from math import isinf
from pathlib import Path
from typing import Any

from camopt.core.engines import Engine
from camopt.core.engines.progress import Progress, with_progress_bar
from camopt.core.engines.threads import Threads
from camopt.core.quantities import QUANTITIES
from camopt.core.storage.files import write_text
from camopt.core.storage.publishing import Publication, publication, published_answer
from camopt.scene.arguments import SceneSource, check_count, options_by_keyword, scene_from
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.space import DesignSpace
from camopt.scene.scene import Scene
from camopt.solve.front.blocks import SpaceResult, gather_batches
from camopt.solve.front.certified_front import PROOF_COLUMN, certify_front
from camopt.solve.front.estimate import announce_estimate
from camopt.solve.front.pareto import Front, summarise_front
from camopt.solve.front.plan import FRONT_ONLY, TABLED_KEEPS, SweepPlan, sweep_plan
from camopt.solve.front.reported_rows import best_of_each_law, largest_half_width, nearest_miss_of_space
from camopt.solve.front.result import Sweep
from camopt.solve.front.store import BATCH_FILES, QUESTION_FILE, MessageSink, Store, save_at_end
from camopt.solve.tables.cells import to_json
from camopt.solve.tables.designs import Design, DesignsByLaw
from camopt.solve.tables.table_writers import TableInMemory, TableWriter, table_file
from camopt.solve.verdicts.limit_verdicts import Effort

SWEEP_COMMAND, SWEEP_SCENE = "sweep", "scene.toml"
SUMMARY_FIELDS: dict[str, Any] = {
    **dict.fromkeys(("impossible", "feasible"), int | None),
    **dict.fromkeys(("pareto", "evaluated", "boxes", "decided_by_boxes"), int),
    "reached": float | int,
    "every_cam": dict | None,
    "obstacle": str,
}
"""Fields that are kept as they are, and of which types they are."""


@options_by_keyword
@with_progress_bar("designs")
def sweep(  # noqa: PLR0913
    scene: SceneSource,
    out: str | os.PathLike[str] | None = None,
    *,
    keep: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    block: int | None = None,
    engine: Engine | None = None,
    tell: MessageSink | None = None,
    again: bool = False,
) -> Sweep:
    """Evaluate every design of the grid or the sample that a scene's ``[search]`` asks for; find the Pareto front.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        Limits, objectives, and in ``[search]`` the values of each size and of other numbers, such as the spring
        rate, and the laws.
    out : str or os.PathLike, optional
        Folder for ``pareto.parquet``, ``designs.parquet`` and ``scene.toml``; None writes nothing. Where
        ``[search]`` says to refine, the front of the grid goes to ``pareto-grid.parquet``.
    keep : str, optional
        Which designs are kept, in ``designs.parquet`` or without ``out`` in memory, for ``to_pandas("designs")``:
        "feasible", "pareto", or "all" that can be assembled. Without it "feasible" if there is ``out``, or else
        none, so that memory does not grow with the space. With
        "pareto", boxes of designs are decided together where that is sooner: in large spaces, from some 100,000
        pitch curves of each motion on, where the objectives allow it. The front is the same, row for row; nobody
        counts the feasible designs then, and the best of a law is that on the front. "front-only" is its old name,
        and writes the front alone, without such a table.
    workers : int, optional
        Threads; None takes one a core. Rows are the same for any number, and for any ``block``.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (designs done, designs in all); where boxes are
        decided, with (boxes done, and about how many there will be). If it returns False, the sweep ends.
    block : int, optional
        Designs evaluated together at most, which bounds the memory; None takes 65,536, or 262,144 of designs that
        share pitch curves.
    engine : Engine, optional
        What evaluates the blocks in place of threads of this process: a ``cluster``. Rows are the same.
    tell : callable, optional
        Called with sentences that a user should know: of a long sweep, how long it may take and how much room on
        the disk; and whether it goes on where an interrupted one ended, or is done already.
    again : bool, default False
        Whether to compute anew what is in the folder already. If not, and the result there is of the same question
        and version, and its files are whole, that is what is returned.

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
    scene = scene_from(scene)
    counted = out is None and keep is None  # designs that nobody asked to keep; the front is the same
    plan = sweep_plan(scene, FRONT_ONLY if counted else "feasible" if keep is None else keep, block)
    check_count("workers", workers)
    own = Threads(workers or os.cpu_count() or 1)
    if out is not None and not again and (done := published_sweep(plan, out, tell)):
        return done
    if plan.uses_boxes and not counted and not engine:
        from camopt.solve.front.front_search import FrontSearch

        search = FrontSearch(plan.space, plan.table_columns, own.workers, progress)
        return sweep_result(plan, out, lambda store, write: search.run(), own, progress)

    def evaluate_space(store: Store | None, write: Write) -> SpaceResult:
        if store is None:
            batches = plan.batches(plan.part_blocks(), engine or own)
        else:
            announce_estimate(store, own, engine or own, tell)
            batches = store.batches(engine or own)
        return gather_batches(plan.space, batches, plan.block, write, progress)

    return sweep_result(
        plan, out, evaluate_space, own, progress, lambda folder: Store(folder, plan, plan.sweep_key(), tell)
    )


Write = Callable[[DesignRows], None]
"""What takes rows for the table of designs."""


def sweep_result(
    plan: SweepPlan,
    out: str | os.PathLike[str] | None,
    search: Callable[[Store | None, Write], SpaceResult],
    own: Threads,
    progress: Progress | None,
    open_store: Callable[[Path], Store] | None = None,
) -> Sweep:
    """The result of a search, written to a folder if there is one; a store may keep finished work there."""
    scene, space, store = plan.scene, plan.space, None
    with ExitStack() as stack:
        unit = None if out is None else stack.enter_context(_sweep_publication(out, plan))
        store = open_store(unit.staging) if unit and open_store else None
        stack.enter_context(save_at_end(store))
        tables = _open_tables(stack, unit, plan)
        rows_of_search = tables["designs"] if plan.keep in TABLED_KEEPS else None
        seen = search(store, rows_of_search.append if rows_of_search else lambda rows: None)
        if rows_of_search:
            rows_of_search.end()
        found = certify_front(plan, seen, own, progress)
        compared, seen = found.reported_rows, found.space_result
        rows, grid = compared.front, compared.grid
        front = summarise_front(rows, plan.problem.objectives, grid if scene.search.refine else None)
        front = front and replace(front, knee=Design(front.knee, scene))
        miss = None if rows.count else nearest_miss_of_space(plan)
        result = Sweep(
            scene=scene,
            designs=len(space),
            impossible=None if seen.existing is None else len(space) - seen.existing,
            feasible=seen.feasible,
            effort=seen.effort,
            reached=max(seen.reached, *(largest_half_width(each) for each in (rows, grid))),
            pareto=rows.count,
            files=_file_paths(plan, unit.folder) if unit else (),
            best=best_of_each_law(scene, compared),
            nearest_miss=miss,
            front=front,
            obstacle=_assembly_obstacle(space, bool(rows.count or miss)),
            evaluated=seen.evaluated,
            boxes=seen.boxes,
            decided_by_boxes=seen.decided,
            every_cam=found.every_cam,
            _rows={name: table for name, table in tables.items() if isinstance(table, TableInMemory)},
            _question=plan.sweep_key().to_sweep_manifest if unit else None,
        )
        about = {"designs": len(space), "evaluated": seen.evaluated, "decided_by_boxes": seen.decided}
        tables["pareto"].describe("camopt_sweep", to_json(about))
        if front:
            tables["pareto"].describe("camopt_front", to_json(front.to_dict()))
        for table, shown in (("pareto", found.front), ("pareto-grid", grid), ("designs", grid)):
            if table in tables and (table != "designs" or plan.keep == "pareto"):
                tables[table].append(shown)
        if unit:
            write_text(unit.path(SWEEP_SCENE), scene.to_toml())
            unit.answer = sweep_summary(result)
    return result


def _assembly_obstacle(space: DesignSpace, assembled: bool) -> str:
    """Why no design can be assembled, or none with some of the trains."""
    apart = [each.setup.mechanism.assembly for each in space.problems if each.setup.mechanism.has_no_assembly]
    if apart:
        return f"{len(apart)} of {len(space.problems)} motions through a train, such as {apart[0]}"
    return "" if assembled else space.problem.setup.mechanism.assembly


def _sweep_publication(out: str | os.PathLike[str], plan: SweepPlan) -> AbstractContextManager[Publication]:
    """Where a sweep writes its files, and keeps finished work if it ends early."""
    kept = (BATCH_FILES, QUESTION_FILE)
    return publication(
        out, SWEEP_COMMAND, sweep_files(plan), question=plan.sweep_key().to_sweep_manifest, keeps=kept
    )


def published_sweep(plan: SweepPlan, out: str | os.PathLike[str], tell: MessageSink | None) -> Sweep | None:
    """The result of a sweep that is in a folder already; None if it is not."""
    question = plan.sweep_key().to_sweep_manifest
    answer = published_answer(out, SWEEP_COMMAND, question)
    with suppress(LookupError, TypeError, ValueError, AttributeError):  # a manifest may say anything
        numbers = fields_from_summary(answer, plan.scene)
        if tell:
            tell(up_to_date_message(out))
        files = _file_paths(plan, Path(out))
        numbers |= {"scene": plan.scene, "designs": len(plan.space), "_question": question}
        return Sweep(files=files, already_done=True, **numbers)
    return None


def up_to_date_message(folder: str | os.PathLike[str]) -> str:
    """The message when a folder has the result already."""
    return f"{os.fspath(folder)} is up to date; `again` computes it anew"


def table_file_name(table: str) -> str:
    """The file of a table."""
    return f"{table}.parquet"


def _open_tables(
    stack: ExitStack, unit: Publication | None, plan: SweepPlan
) -> Mapping[str, TableWriter | TableInMemory]:
    """The tables of a sweep by name: files, open until the stack is left, or in memory if there is no folder."""
    scene = plan.scene.to_toml()
    columns = {table: plan.quantities_of(names) for table, names in _table_columns(plan).items()}
    if unit is None:
        return {table: TableInMemory(quantities, scene) for table, quantities in columns.items()}
    return {
        table: stack.enter_context(table_file(unit.path(table_file_name(table)), quantities, scene))
        for table, quantities in columns.items()
    }


def _table_columns(plan: SweepPlan) -> dict[str, tuple[str, ...]]:
    """The columns of the tables of a sweep, by table."""
    names, refine = plan.table_columns, plan.scene.search.refine
    columns = {} if plan.keep == FRONT_ONLY else {"designs": names}
    columns |= {
        "pareto": (*names, *(["refined"] if refine else [PROOF_COLUMN] if plan.problem.robust_errors else []))
    }
    return columns | ({"pareto-grid": names} if refine else {})


def sweep_files(plan: SweepPlan) -> tuple[str, ...]:
    """The names of the files that a sweep writes."""
    return (*map(table_file_name, _table_columns(plan)), SWEEP_SCENE)


def _file_paths(plan: SweepPlan, folder: Path) -> tuple[Path, ...]:
    return tuple(folder / name for name in sweep_files(plan))


def sweep_summary(result: Any) -> dict[str, Any]:
    """The summary of a ``Sweep`` as plain values for JSON."""
    front, miss = result.front, result.nearest_miss
    return {
        **{name: getattr(result, name) for name in SUMMARY_FIELDS},
        "effort": [*result.effort],
        "best": {laws: _row_to_json(design) for laws, design in result.best.items()},
        "nearest_miss": miss and [_row_to_json(miss), miss.searched.to_toml()],
        "front": front and {**asdict(replace(front, knee={})), "knee": _row_to_json(front.knee)},
    }


def fields_from_summary(told: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """The same as fields of a ``Sweep``; an error of some kind if it was not ``sweep_summary`` of one."""
    front, miss = told["front"], told["nearest_miss"]
    if not all(isinstance(told[name], kind) for name, kind in SUMMARY_FIELDS.items()):
        raise TypeError
    return {
        **{name: told[name] for name in SUMMARY_FIELDS},
        "effort": Effort(*told["effort"]),
        "best": DesignsByLaw((laws, _design_from_json(row, scene)) for laws, row in told["best"].items()),
        "nearest_miss": miss and _design_from_json(miss[0], Scene.embedded(miss[1], scene.file)),
        "front": front and Front(**{**front, "knee": _design_from_json(front["knee"], scene)}),
    }


def _row_to_json(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with texts for infinite values, for which JSON has no numbers."""
    return {name: str(value) if isinstance(value, float) and isinf(value) else value for name, value in row.items()}


def _design_from_json(row: Mapping[str, Any], scene: Scene) -> Design:
    def value_of(name: str, value: Any) -> Any:
        known = name in scene.quantities or (name in QUANTITIES and QUANTITIES[name].kind is float)
        return float(value) if known else value

    return Design({name: value_of(name, value) for name, value in row.items()}, scene)

"""``camopt.sweep``: every design of a space, evaluated block by block, and the Pareto front.

1. A scene becomes a plan: the space of designs, and which of them to keep (``plan``).
2. An engine evaluates the blocks of designs in batches (``blocks``). Finished batches are kept on disk, so that an
   interrupted sweep resumes (``store``).
3. ``gather_batches`` collects rows for the table and the front so far.
4. At the end the reported rows get the digits of ``evaluate`` (``reported_rows``). All tables and the result appear
   together (``result``).

If only the front of a large space is wanted, boxes of designs are bounded instead of evaluating blocks. This takes
seconds, and keeps nothing on disk (``front_search``).
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
from camopt.core.storage.publishing import Publication, publication, published_answer_to_same_question
from camopt.scene.arguments import SceneSource, allow_positional_options, check_count, scene_from
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.space import DesignSpace
from camopt.scene.scene import Scene
from camopt.solve.front.blocks import SpaceResult, gather_batches
from camopt.solve.front.certified_front import PROOF_COLUMN, certify_front_with_resweeps
from camopt.solve.front.estimate import announce_estimate
from camopt.solve.front.pareto import Front, summarise_front
from camopt.solve.front.plan import FRONT_ONLY, TABLED_KEEPS, SweepPlan, sweep_plan
from camopt.solve.front.reported_rows import (
    best_design_of_each_law,
    largest_relative_half_width,
    nearest_miss_of_space,
)
from camopt.solve.front.result import TABLE_SUFFIX, Sweep
from camopt.solve.front.store import BATCH_FILES, QUESTION_FILE, MessageSink, Store, save_batches_on_early_end
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
"""The fields of a ``Sweep`` that its manifest stores unchanged, with their types."""


@allow_positional_options
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
    """Evaluate every design of a scene's grid or sample (``[search]``), and find the Pareto front.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        Limits, objectives, and in ``[search]`` the values of each size and of other numbers, such as the spring
        rate, and the laws.
    out : str or os.PathLike, optional
        Folder for ``pareto.parquet``, ``designs.parquet`` and ``scene.toml``; None writes nothing. With
        ``search.refine`` the front of the grid goes to ``pareto-grid.parquet``.
    keep : str, optional
        Which designs are kept for ``to_pandas("designs")``, in ``designs.parquet`` or, without ``out``, in memory:
        "feasible", "pareto", or "all" that can be assembled. The default is "feasible" with ``out``, and none
        without it, so that memory does not grow with the space.
        With "pareto", camopt decides boxes of designs together if that is faster: in large spaces, from about
        100,000 pitch curves of each motion, if the objectives allow it. The front is the same, row for row. The
        feasible designs are then not counted, and the best design of a law is the best on the front.
        "front-only" is an old name for "pareto" that writes the front without a table of designs.
    workers : int, optional
        Number of threads; None takes one per core. Rows are the same for any number, and for any ``block``.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (designs done, designs in all); if boxes are
        decided, with (boxes done, expected number of boxes). If it returns False, the sweep ends.
    block : int, optional
        Most designs evaluated together, which bounds the memory. None takes 65,536, or 262,144 for designs that
        share pitch curves.
    engine : Engine, optional
        An engine that evaluates the blocks instead of threads of this process: a ``cluster``. Rows are the same.
    tell : callable, optional
        Called with sentences for the user: the time and disk space that a long sweep will take, and whether the
        sweep resumes an interrupted one or is already done.
    again : bool, default False
        Whether to recompute a result that is already in the folder. If False, camopt returns a result there that
        has the same question and version and whole files.

    Returns
    -------
    Sweep
        Counts, the best design of each law, the front, and the files.

    Raises
    ------
    BadInput
        If the space cannot be swept: a range without a step, or an objective that the mechanism does not have. For
        another ``keep``. For more than 10,000 diameters of the shaft, which are swept one by one.
    OSError
        If a file cannot be written, the disk lacks room for the rows, or another run writes to the folder.

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
    counted_only = out is None and keep is None  # no table of designs is wanted; the front is the same
    plan = sweep_plan(scene, FRONT_ONLY if counted_only else "feasible" if keep is None else keep, block)
    check_count("workers", workers)
    threads = Threads(workers or os.cpu_count() or 1)
    if out is not None and not again and (done := published_sweep(plan, out, tell)):
        return done
    if plan.searches_front_by_boxes and not counted_only and not engine:
        from camopt.solve.front.front_search import FrontSearch

        search = FrontSearch(plan.space, plan.table_columns, threads.workers, progress)
        return run_and_publish_sweep(plan, out, lambda store, write: search.find_front(), threads, progress)

    def evaluate_space(store: Store | None, write: Write) -> SpaceResult:
        if store is None:
            batches = plan.evaluate_in_batches(plan.part_blocks(), engine or threads)
        else:
            announce_estimate(store, threads, engine or threads, tell)
            batches = store.load_or_evaluate_batches(engine or threads)
        return gather_batches(plan.space, batches, plan.block_size, write, progress)

    return run_and_publish_sweep(
        plan, out, evaluate_space, threads, progress, lambda folder: Store(folder, plan, plan.sweep_key(), tell)
    )


Write = Callable[[DesignRows], None]
"""A function that writes rows to the table of designs."""


def run_and_publish_sweep(
    plan: SweepPlan,
    out: str | os.PathLike[str] | None,
    search: Callable[[Store | None, Write], SpaceResult],
    threads: Threads,
    progress: Progress | None,
    open_store: Callable[[Path], Store] | None = None,
) -> Sweep:
    """The result of a search, written to a folder if there is one; a store keeps finished work there."""
    scene, space, store = plan.scene, plan.space, None
    with ExitStack() as stack:
        unit = None if out is None else stack.enter_context(_sweep_publication(out, plan))
        store = open_store(unit.staging) if unit and open_store else None
        stack.enter_context(save_batches_on_early_end(store))
        tables = _open_tables(stack, unit, plan)
        designs_table = tables["designs"] if plan.keep in TABLED_KEEPS else None
        space_result = search(store, designs_table.append if designs_table else lambda rows: None)
        if designs_table:
            designs_table.take_no_more_rows()
        certified = certify_front_with_resweeps(plan, space_result, threads, progress)
        space_result, reported, proved_front, every_cam = certified
        rows, grid = reported.front, reported.grid
        front = summarise_front(rows, plan.problem.objectives, grid if scene.search.refine else None)
        front = front and replace(front, knee=Design(front.knee, scene))
        miss = None if rows.count else nearest_miss_of_space(plan)
        result = Sweep(
            scene=scene,
            designs=len(space),
            impossible=None if space_result.existing is None else len(space) - space_result.existing,
            feasible=space_result.feasible,
            effort=space_result.effort,
            reached=max(space_result.reached, largest_relative_half_width(rows), largest_relative_half_width(grid)),
            pareto=rows.count,
            files=tuple(unit.folder / name for name in sweep_file_names(plan)) if unit else (),
            best=best_design_of_each_law(scene, reported),
            nearest_miss=miss,
            front=front,
            obstacle=_reason_designs_do_not_assemble(space, bool(rows.count or miss)),
            evaluated=space_result.evaluated,
            boxes=space_result.boxes,
            decided_by_boxes=space_result.decided,
            every_cam=every_cam,
            _rows={name: table for name, table in tables.items() if isinstance(table, TableInMemory)},
            _question=plan.sweep_key().sweep_manifest_entry if unit else None,
        )
        counts = {"evaluated": space_result.evaluated, "decided_by_boxes": space_result.decided}
        tables["pareto"].add_metadata_text("camopt_sweep", to_json({"designs": len(space)} | counts))
        if front:
            tables["pareto"].add_metadata_text("camopt_front", to_json(front.to_dict()))
        for table, table_rows in (("pareto", proved_front), ("pareto-grid", grid), ("designs", grid)):
            if table in tables and (table != "designs" or plan.keep == "pareto"):
                tables[table].append(table_rows)
        if unit:
            write_text(unit.staged_path(SWEEP_SCENE), scene.to_toml())
            unit.answer = sweep_summary(result)
    return result


def _reason_designs_do_not_assemble(space: DesignSpace, any_assembled: bool) -> str:
    """Why no design can be assembled, or for how many trains none can."""
    mechanisms = [problem.setup.mechanism for problem in space.problems]
    if reasons := [mechanism.assembly for mechanism in mechanisms if mechanism.has_no_assembly]:
        return f"{len(reasons)} of {len(mechanisms)} motions through a train, such as {reasons[0]}"
    return "" if any_assembled else space.problem.setup.mechanism.assembly


def _sweep_publication(out: str | os.PathLike[str], plan: SweepPlan) -> AbstractContextManager[Publication]:
    """The publication that writes a sweep's files, and keeps finished work if the sweep ends early."""
    return publication(
        out,
        SWEEP_COMMAND,
        sweep_file_names(plan),
        question=plan.sweep_key().sweep_manifest_entry,
        kept_patterns=(BATCH_FILES, QUESTION_FILE),
    )


def published_sweep(plan: SweepPlan, out: str | os.PathLike[str], tell: MessageSink | None) -> Sweep | None:
    """The result of this sweep in a folder; None if it is not there."""
    question = plan.sweep_key().sweep_manifest_entry
    answer = published_answer_to_same_question(out, SWEEP_COMMAND, question)
    with suppress(LookupError, TypeError, ValueError, AttributeError):  # a manifest may be damaged
        numbers = fields_from_summary(answer, plan.scene)
        if tell:
            tell(up_to_date_message(out))
        files = tuple(Path(out) / name for name in sweep_file_names(plan))
        numbers |= {"scene": plan.scene, "designs": len(plan.space), "_question": question}
        return Sweep(files=files, already_done=True, **numbers)
    return None


def up_to_date_message(folder: str | os.PathLike[str]) -> str:
    """The message when a folder has the result already."""
    return f"{os.fspath(folder)} is up to date; use `again` to recompute"


def _open_tables(
    stack: ExitStack, output: Publication | None, plan: SweepPlan
) -> Mapping[str, TableWriter | TableInMemory]:
    """The tables of a sweep by name: files, open until the stack is left, or in memory if there is no folder."""
    scene = plan.scene.to_toml()
    columns = {table: plan.find_quantities(names) for table, names in _table_columns(plan).items()}
    if output is None:
        return {table: TableInMemory(quantities, scene) for table, quantities in columns.items()}
    return {
        table: stack.enter_context(table_file(output.staged_path(f"{table}{TABLE_SUFFIX}"), quantities, scene))
        for table, quantities in columns.items()
    }


def _table_columns(plan: SweepPlan) -> dict[str, tuple[str, ...]]:
    names, refine = plan.table_columns, plan.scene.search.refine
    columns = {} if plan.keep == FRONT_ONLY else {"designs": names}
    columns |= {
        "pareto": (*names, *(["refined"] if refine else [PROOF_COLUMN] if plan.problem.robust_errors else []))
    }
    return columns | ({"pareto-grid": names} if refine else {})


def sweep_file_names(plan: SweepPlan) -> tuple[str, ...]:
    """The names of the files that a sweep writes."""
    return (*(f"{table}{TABLE_SUFFIX}" for table in _table_columns(plan)), SWEEP_SCENE)


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


def fields_from_summary(summary: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """The fields of a ``Sweep`` from its ``sweep_summary``; any other value raises some error."""
    front, miss = summary["front"], summary["nearest_miss"]
    if not all(isinstance(summary[name], kind) for name, kind in SUMMARY_FIELDS.items()):
        raise TypeError
    return {
        **{name: summary[name] for name in SUMMARY_FIELDS},
        "effort": Effort(*summary["effort"]),
        "best": DesignsByLaw((laws, _design_from_json(row, scene)) for laws, row in summary["best"].items()),
        "nearest_miss": miss and _design_from_json(miss[0], Scene.embedded(miss[1], scene.file)),
        "front": front and Front(**{**front, "knee": _design_from_json(front["knee"], scene)}),
    }


def _row_to_json(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with infinite values as texts, because JSON has no numbers for them."""
    return {name: str(value) if isinstance(value, float) and isinf(value) else value for name, value in row.items()}


def _design_from_json(row: Mapping[str, Any], scene: Scene) -> Design:
    numbers = scene.quantities.keys() | {name for name, quantity in QUANTITIES.items() if quantity.kind is float}
    return Design({name: float(value) if name in numbers else value for name, value in row.items()}, scene)

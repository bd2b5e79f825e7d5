"""The frontier: how free laws trade size, acceleration, jerk, loads and more, beside the known laws.

One axis is minimised for each value of the others (``axis_minimiser``). Each process builds the programme once and
solves it for all values. Each solution becomes a cam, as in ``synthesise``.
"""

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import lru_cache, partial
from itertools import chain, combinations, permutations, product
from math import ceil
from os import cpu_count
from time import monotonic
from typing import Any, NamedTuple

import moocore
import numpy as np

from camopt.core.engines import Engine
from camopt.core.engines.processes import processes
from camopt.core.engines.progress import Progress, report_progress, with_progress_bar
from camopt.core.mistakes import BadInput, Mistake, Unmet, suggest_names
from camopt.core.numerics import FloatArray
from camopt.core.quantities.function import FunctionCall
from camopt.model.effects import available_quantities, missing_keys_by_quantity
from camopt.scene.arguments import SceneSource, allow_positional_options, check_count, scene_from
from camopt.scene.problem.limits import limited_quantity_name
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.scene.synthesis import AXIS_TERMS
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.axis_minimiser import AxisMinimiser, FrontierCam
from camopt.solve.synthesis.cams import known_cam_with_objective_terms, smallest_designs_by_known_law
from camopt.solve.synthesis.frontier_result import Frontier
from camopt.solve.synthesis.iterate import Iterate
from camopt.solve.synthesis.nonconvex_constraints import load_constraints_at, load_limit_keys_by_quantity
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.relaxed_optimum import relaxation_bound
from camopt.solve.tables.cells import duration_text
from camopt.solve.tables.designs import Design

START_SECONDS = 5.0  # seconds: a search that takes less is faster in one process than in several
LONG_SECONDS = 20.0  # seconds: a shorter search needs no notice
NOTICE_FACTOR = 2.0  # a new estimate is announced if it exceeds the last one by this factor
END_WIDENING = 1e-5  # relative widening of a term's least value, so that the solver finds its laws
LOCAL_END_WIDENING = 3e-4  # the same for a quantity, so that convex steps find its laws
START_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)  # blends of the laws at two ends, from which convex steps start
LARGEST_CAM_FACTOR = 5.0  # default largest size with a load as an axis, as a multiple of the least size
LEAST_AXIS_SHARE = 1e-3  # least searched value of an axis, as a share of its largest value


class SearchTimeEstimate:
    """Estimates the time of searches that run one kind after the other, each kind on all workers.

    Searches to come are taken to be as long as those of the last kind. With a load as an axis, the first kind that
    includes it is more representative than the kinds before.
    """

    def __init__(self, kinds: Sequence[int], workers: int, tell: Callable[[str], None] | None) -> None:
        """``kinds`` are the numbers of searches of each kind, in order."""
        self._kinds, self._workers, self._tell = [*kinds], workers, tell
        self._start, self._kind_start, self._announced = (
            monotonic(),
            monotonic(),
            LONG_SECONDS / NOTICE_FACTOR,
        )

    def record_kind_and_announce_time(self) -> None:
        """Record that one kind of searches is done, and announce the total time if it is long."""
        count, now = self._kinds.pop(0), monotonic()
        if not count or not self._tell:
            return
        seconds = (now - self._kind_start) / ceil(count / self._workers)
        seconds_left = sum(ceil(kind / self._workers) for kind in self._kinds) * seconds
        total_seconds, self._kind_start = now - self._start + seconds_left, now
        if seconds_left > 0.0 and total_seconds > NOTICE_FACTOR * self._announced:
            self._announced = total_seconds
            searches = f"{sum(self._kinds):,} more searches for a motion"
            self._tell(f"{searches}, about {duration_text(total_seconds)} in all; fewer points take less")


@allow_positional_options
@with_progress_bar("points")
def frontier(
    scene: SceneSource,
    axes: Sequence[str] = ("size", "acceleration"),
    *,
    points: int = 24,
    workers: int | None = None,
    progress: Progress | None = None,
    engine: Engine | None = None,
    tell: Callable[[str], None] | None = None,
) -> Frontier:
    """Compute the trade-off between two or three axes with new motion laws.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        The limits, the ranges of sizes, and ``[synthesis]``.
    axes : sequence of str, default ("size", "acceleration")
        Terms of the objective (as in ``[synthesis] minimise``), or loads that a limit bounds from above, such as
        ``torque_peak_N_m`` and ``contact_stress_max_MPa``. Terms are convex in the motion, so that the results are
        global optima. Loads are not: with them, the results are local optima.
    points : int, default 24
        Number of values of each axis but the first, between its ends.
    workers : int, optional
        Number of processes; one per core by default. Searches that take a few seconds run in this process.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (points done, points in all). If it
        returns False, the work ends.
    engine : Engine, optional
        The engine that computes the points in place of processes of this machine: a ``cluster``.
    tell : callable, optional
        Called with a sentence on how long the work will take, if that is long.

    Returns
    -------
    Frontier
        A row for each cam, with its scene; the least value of each axis; and the known laws.

    Raises
    ------
    BadInput
        For other axes, or a scene that ``synthesise`` does not take.
    Unmet
        If no free law meets all limits.
    Stopped
        If ``progress`` returned False.

    References
    ----------
    S. Boyd, L. Vandenberghe, Convex Optimization, 4.7 (trade-offs).

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> found = camopt.frontier(coarse, points=2, workers=1)
    >>> [round(row["size"], 1) for row in found.rows]
    [30.7, 45.0]
    """
    scene = scene_from(scene)
    check_count("points", points, 0)
    check_count("workers", workers)
    scene, axes = _check_axes_and_add_outputs(scene, axes)
    problem = build_synthesis_problem(scene, {axis: 1.0 for axis in axes if axis in AXIS_TERMS})
    with nullcontext(engine) if engine else processes(workers or cpu_count() or 1, START_SECONDS) as used_engine:
        pairs = len(axes) * (len(axes) - 1)
        terms = sum(axis in AXIS_TERMS for axis in axes)
        kinds = (terms, len(axes) - terms, pairs - len(axes) + 1, points ** (len(axes) - 1))
        ends, known_cams = _axis_ends_and_known_cams(
            scene, axes, used_engine, SearchTimeEstimate(kinds, used_engine.workers, tell)
        )
        rows = list(_frontier_rows(scene, axes, ends, points, used_engine, progress))
    bounds = {
        axis: relaxation_bound(replace(problem, objective={axis: 1.0})) for axis in axes if axis in AXIS_TERMS
    }
    least = {axis: (min(row[axis] for row in (ends[axis, axis].row, *rows)), bounds.get(axis)) for axis in axes}
    # axes whose least values are local optima; with a load as an axis, rows do not count
    is_local = {axis: ends[axis, axis].row["local"] for axis in axes}
    is_local[axes[0]] |= all(axis in AXIS_TERMS for axis in axes) and any(row["local"] for row in rows)
    return Frontier(
        scene,
        axes,
        [Design(row, scene) for row in _nondominated_rows(rows, axes)],
        [known_cam_with_objective_terms(problem, cam) for cam in known_cams],
        least,
        tuple(axis for axis in axes if is_local[axis]),
    )


def _frontier_rows(
    scene: Scene,
    axes: tuple[str, ...],
    ends: "FrontierEnds",
    points: int,
    engine: Engine,
    progress: Progress | None,
) -> Iterator[dict[str, Any]]:
    """Rows of the cams with the least first axis, for values of the other axes between their ends."""
    starts = tuple(
        _blend_laws(ends[axis, axis].laws, ends[other, other].laws, share)
        for axis, other in combinations(axes, 2)
        for share in START_SHARES
    )
    grids = []
    for axis in axes[1:]:
        most = max(float(end.row[axis]) for (_, by), end in ends.items() if by == axis)
        least = max(_widened_least_value(ends[axis, axis], axis), LEAST_AXIS_SHARE * most)
        # closer together near the least value, where a frontier bends most
        grids.append(least + (most - least) * np.linspace(0.0, 1.0, points) ** 2)
    values = [dict(zip(axes[1:], map(float, point), strict=True)) for point in product(*grids)]
    tasks = [FrontierTask(axes[0], value, starts, with_bound=True) for value in values]
    for done, cam in enumerate(_task_results(scene, axes, tasks, engine), start=1):
        if cam:
            yield cam.row
        report_progress(progress, done, len(values))


def _check_axes_and_add_outputs(scene: Scene, axes: Sequence[str]) -> tuple[Scene, tuple[str, ...]]:
    """The scene with the outputs that the axes need, and the axes; BadInput if an axis does not exist."""
    scene_problem, mistakes = resolve(scene), []
    axes = (axes,) if isinstance(axes, str) else axes
    if not 2 <= len(axes) <= 3 or len(set(axes)) < len(axes):
        mistakes.append(Mistake("camopt", "axes", ",".join(axes), "two or three different axes"))
    missing_keys, loads = missing_keys_by_quantity(scene_problem.setup), load_limit_keys_by_quantity(scene_problem)
    available_loads = [name for name in loads if name in available_quantities(scene_problem.setup)]
    for axis in axes:
        name = limited_quantity_name(axis, scene_problem.setup) if axis == residual.RESIDUAL_TERM else axis
        if name in missing_keys and (axis in AXIS_TERMS or axis in loads):
            mistakes.append(Mistake("camopt", "axes", axis, f"needs {', '.join(missing_keys[name])}", bare=True))
        elif axis not in AXIS_TERMS and axis not in available_loads:
            what = f"a term of the objective or a load of this scene; {suggest_names(axis, [*AXIS_TERMS, *loads])}"
            mistakes.append(Mistake("camopt", "axes", axis, what))
        elif axis in available_loads and not load_constraints_at(scene_problem, loads[axis], 1.0):
            mistakes.append(Mistake("camopt", "axes", axis, "cannot be an axis for this follower", bare=True))
    if mistakes:
        raise BadInput(mistakes)
    load_axes = [axis for axis in axes if axis not in AXIS_TERMS]
    outputs = {"sizes", *(scene.outputs or scene_problem.evaluated_quantities), *load_axes}
    return scene.with_values({"outputs": tuple(sorted(outputs))}) if load_axes else scene, tuple(axes)


FrontierEnds = dict[tuple[str, str], FrontierCam]
"""Cams at the ends, by (axis, other): of the least axis, and then of the least other with the axis held there."""


def _axis_ends_and_known_cams(
    scene: Scene, axes: tuple[str, ...], engine: Engine, estimate: SearchTimeEstimate
) -> tuple[FrontierEnds, list[Design]]:
    """The cams with the least of each axis, and the cams of known laws.

    Terms come first, because they show how large a cam with a load may be. Known laws run beside the terms, when
    workers are free.
    """
    ends: FrontierEnds = {}
    size_bound: dict[str, float] = {}
    known_cams: list[Design] = []
    for kind_axes, other_tasks in (
        ([axis for axis in axes if axis in AXIS_TERMS], [KnownLawTask()]),
        ([axis for axis in axes if axis not in AXIS_TERMS], []),
    ):
        tasks = [FrontierTask(axis, {} if axis in AXIS_TERMS else size_bound) for axis in kind_axes]
        results = _task_results(scene, axes, [*tasks, *other_tasks], engine)
        for axis, end in zip(kind_axes, results, strict=False):
            if end is None:
                raise Unmet("no free law with this number of pieces meets all limits; increase synthesis.pieces")
            ends[axis, axis] = end
        known_cams = next(results, known_cams)
        estimate.record_kind_and_announce_time()
        size_bound = _largest_size_for_load_axes(scene, ends)
    pairs = [(axis, other) for axis, other in permutations(axes, 2) if other != axes[0]]  # which has no grid
    tasks = []
    for axis, other in pairs:
        held_values = {axis: _widened_least_value(ends[axis, axis], axis)}
        tasks.append(
            FrontierTask(
                other, held_values if other in AXIS_TERMS else size_bound | held_values, (ends[axis, axis].laws,)
            )
        )
    for (axis, other), end in zip(pairs, _task_results(scene, axes, tasks, engine), strict=True):
        ends[axis, other] = end or ends[axis, axis]
    estimate.record_kind_and_announce_time()
    return ends, known_cams


def _largest_size_for_load_axes(scene: Scene, ends: FrontierEnds) -> dict[str, float]:
    """Largest size while a load is minimised, as a load may fall for ever while the cam grows.

    It is that of [search]; otherwise the scene's own size, or a multiple of the least size.
    """
    search_ranges = (scene.search.base_radius, scene.search.mean_radius)
    if ("size", "size") not in ends or any(choice is not None for choice in search_ranges):
        return {}
    own_size = scene.cam.base_radius or scene.cam.mean_radius or 0.0
    return {"size": max(own_size, LARGEST_CAM_FACTOR * float(ends["size", "size"].row["size"]))}


def _blend_laws(first: Iterate, second: Iterate, share: float) -> Iterate:
    """Laws between those of two ends: they meet all convex limits that both meet."""
    lead, height = (low + share * (high - low) for low, high in zip(first[:2], second[:2], strict=True))
    return Iterate(
        lead,
        height,
        tuple(
            low + share * (high - low) for low, high in zip(first.coefficients, second.coefficients, strict=True)
        ),
    )


def _widened_least_value(end: FrontierCam, axis: str) -> float:
    """Least value of an axis, widened for the solver."""
    return float(end.row[axis]) * (1.0 + (END_WIDENING if axis in AXIS_TERMS else LOCAL_END_WIDENING))


# --------------------------------------------------------------------------------------------------- the points


class FrontierTask(NamedTuple):
    """An axis to minimise, the values of the held axes, and laws to start from."""

    axis: str
    held_values: Mapping[str, float]
    starts: tuple[Iterate, ...] = ()
    with_bound: bool = False

    def run_task(self, toml: str, axes: tuple[str, ...]) -> FrontierCam | None:
        """The best cam; None if none is found."""
        minimiser = _axis_minimiser(toml, axes, self.axis, tuple(self.held_values))
        return minimiser.minimise_at(self.held_values, self.starts, self.with_bound)


@lru_cache(maxsize=1)
def _axis_minimiser(toml: str, axes: tuple[str, ...], axis: str, held: tuple[str, ...]) -> AxisMinimiser:
    """The minimiser of an axis; each process keeps that of its last task."""
    return AxisMinimiser(Scene.from_dict(tomllib.loads(toml)), axes, axis, held)


class KnownLawTask(NamedTuple):
    """A task to compute the smallest cams of known laws."""

    def run_task(self, toml: str, axes: tuple[str, ...]) -> list[Design]:
        return [*smallest_designs_by_known_law(Scene.from_dict(tomllib.loads(toml))).values()]


def _task_results(
    scene: Scene, axes: tuple[str, ...], tasks: Sequence[FrontierTask | KnownLawTask], engine: Engine
) -> Iterator[Any]:
    """Results of the tasks, in order."""
    calls = [each.function_call for each in resolve(scene).setup.own_quantities.values() if each.function_call]
    for call in calls if engine.workers > 1 else ():
        call.check_importable()  # even if no other process starts
    return chain.from_iterable(engine.results_in_order(partial(_run_tasks, calls, scene.to_toml(), axes), tasks))


def _run_tasks(
    calls: Sequence[FunctionCall], toml: str, axes: tuple[str, ...], tasks: Sequence[FrontierTask | KnownLawTask]
) -> list[Any]:
    """Results of some tasks; ``calls`` bring the scene's Python functions to a worker."""
    return [task.run_task(toml, axes) for task in tasks]


def _nondominated_rows(rows: list[dict[str, Any]], axes: Sequence[str]) -> list[dict[str, Any]]:
    """The rows that no other row dominates, in the order of the first axis."""
    if not rows:
        return []
    costs: FloatArray = np.nan_to_num(np.array([[row[axis] for axis in axes] for row in rows], dtype=float))
    kept = moocore.is_nondominated(costs, keep_weakly=False)
    return sorted((row for row, keep in zip(rows, kept, strict=True) if keep), key=lambda row: float(row[axes[0]]))

"""Synthesis: free motion laws that make the cam smallest, or gentlest, under the limits of a scene.

The convex programme gives laws, and a bound that no law whatever can pass. The laws become laws of the scene, and
the smallest cam for them is found and proved as for any other: every limit of the scene holds in the end, whether
the convex programme knows it or not, and the gap to the bound says what that costs.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from camopt.core.engines.progress import Advance, Progress, report_progress, with_progress_bar
from camopt.core.mistakes import Unmet, Unsolved
from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.stroke import Stroke
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.scene import Scene
from camopt.solve.smallest.price import Prices
from camopt.solve.smallest.prices import prices
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.cams import (
    motion_holds_limits,
    programme_with_laws,
    scene_with_laws,
    smallest_cam_for_laws,
    smallest_cams,
    smallest_design,
)
from camopt.solve.synthesis.convex_model import ConvexModel, build_convex_model
from camopt.solve.synthesis.crossings import with_crossings
from camopt.solve.synthesis.iterate import Iterate, iterate_of, without_solver_error
from camopt.solve.synthesis.law_infeasibility import contradiction_error, no_cam_error
from camopt.solve.synthesis.linear_constraints import with_robust_limits
from camopt.solve.synthesis.nonconvex_constraints import nonconvex_constraints_of
from camopt.solve.synthesis.prices import prices_of_laws
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem, objective_weights, split_by_offset
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.solver import SOLVED_STATUSES, SOLVER_ERROR, solve
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, LIMIT_MARGINS, SynthesisProblem, tighten_limits
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.synthesis.term_units import objective_unit
from camopt.solve.tables.designs import joined_laws

GENTLE_SLACK = 1e-4  # of the unit of the objective, given up for the gentlest jerk among the laws that reach it
PANEL_COUNTS = (96, 64, 32, 16)  # of a stroke in the relaxation: fewer where the solver fails
MISSES_SHOWN = 3  # laws whose cams miss the limits, for what they reach
ROBUST_ROUNDS = 2  # of what tolerances take of limits: at the sizes of the optimum before
NONCONVEX_GAP = 1e-3  # relative: a cam above its convex optimum by more is held by a limit that is not convex


@options_by_keyword
@with_progress_bar("starts")
def synthesise(scene: SceneSource, *, progress: Progress | None = None) -> Synthesis:
    """Compute new motion laws for a scene, as its ``[synthesis]`` asks, and the smallest cam for them.

    With ``search.robust`` the cam is a robust one, as of ``optimise``: every cam within the tolerances of its
    numbers holds each limit. Laws hold linear limits less what tolerances take of them, and in convex steps the
    curves of all cams at the corners of the tolerances; the bound is that of nominal cams.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        The limits, the ranges of sizes, and ``[synthesis]``.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (starting points done, starting points in all).
        If it returns False, the search ends.

    Returns
    -------
    Synthesis
        The laws, the smallest cam for them with its scene, and a bound that no motion can pass.

    Raises
    ------
    BadInput
        If nothing limits the size from below, and it is part of the objective.
    Unmet
        If no new law meets all limits.
    Unsolved
        If the convex solver fails.
    Stopped
        If ``progress`` returned False.

    References
    ----------
    S. Boyd, L. Vandenberghe, Convex Optimization; C. de Boor, A Practical Guide to Splines, ch. IX.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> round(camopt.synthesise(coarse).design["base_radius_mm"], 1)
    39.8
    """
    scene = scene_from(scene)
    problems = split_by_offset(build_synthesis_problem(scene))
    bounds: list[float | None]
    if CROSSING_JERK in problems[0].objective:
        problems, bounds = map(list, zip(*map(with_crossings, problems), strict=True))
    else:
        bounds = [relaxation_bound(problem) for problem in problems]
    some = [problem for problem, bound in zip(problems, bounds, strict=True) if bound != inf]
    if not some:
        raise contradiction_error(scene, problems[0], relaxation_bound)
    best, _ = best_synthesis(scene, some, partial(report_progress, progress))
    known = [bound for bound in bounds if bound is not None]
    right = len(known) == len(bounds) and min(known) <= best.objective  # or else a solver erred
    return replace(best, bound=min(known) if right else None)


def best_synthesis(
    scene: Scene, problems: Sequence[SynthesisProblem], advance: Advance
) -> tuple[Synthesis, Iterate]:
    """The best cam of some demands of a scene, without a bound, and its free laws.

    Raises
    ------
    Unmet
        If no free laws meet any of them.
    Unsolved
        If the convex solver fails.
    """
    found, why = [], Unmet("")
    for problem in problems:
        try:
            found.append(_best_free_laws(scene, problem, advance))
        except Unmet as reason:
            why = reason
    if not found:
        raise why
    return _best_candidate(found)


def _best_free_laws(scene: Scene, problem: SynthesisProblem, advance: Advance) -> tuple[Synthesis, Iterate]:
    """The best free laws of a demand, and their cam."""
    advance(0, 1)  # as far as is known: where the convex optimum is a cam, nothing starts from other laws
    problem = robust_problem(problem)
    constraints = nonconvex_constraints_of(problem)
    for first in range(len(LIMIT_MARGINS)):
        model, start, least = solve_free_laws(problem, LIMIT_MARGINS[first:])
        cam = smallest_cam_for_laws(scene, problem, start)
        if cam or constraints:
            break  # if not, a solver's error takes the cam beyond its limits, which a wider margin mends
    found = [(cam, start)] if cam else []
    free = cam is not None and cam.objective <= least + NONCONVEX_GAP * (abs(least) + model.unit)
    steps = [] if free or not constraints else list(_convex_step_cams(scene, model, problem, start, advance))
    found += [(each, last) for each, last in steps if each]
    if not found:  # steps may end where a limit is missed by little, or that they do not know
        known = list(_known_laws_as_splines(problem, start))
        found = [(cam, laws) for laws in known if (cam := smallest_cam_for_laws(scene, problem, laws))]
    if not found:
        tried = [start, *(last for _, last in steps)][:MISSES_SHOWN]
        raise no_cam_error(scene, problem, [smallest_cams(scene_with_laws(scene, problem, each)) for each in tried])
    cam, laws = _best_candidate(found)
    return replace(cam, convex=free), laws


def robust_problem(problem: SynthesisProblem) -> SynthesisProblem:
    """The demand of a robust cam: with limits that all cams which have to hold them do, near its optimum."""
    found = problem
    for _ in range(ROBUST_ROUNDS if problem.scene_problem.robust_errors and problem.linear_constraints else 0):
        _, start, _ = solve_free_laws(found)
        found = with_robust_limits(problem, start.lead * problem.size_unit, start.height * problem.size_unit)
    return found


def _best_candidate(found: Sequence[tuple[Synthesis, Iterate]]) -> tuple[Synthesis, Iterate]:
    return min(found, key=lambda each: each[0].objective)


def relaxation_bound(problem: SynthesisProblem) -> float | None:
    """What no motion whatever can pass; infinite if none holds the limits, None if the solver gives no bound.

    Nothing convex bounds the size of a cam whose follower oscillates.
    """
    wider = tighten_limits(problem, -SOLVER_ERROR)  # then a solver's error leaves it below
    for panels in PANEL_COUNTS:
        relaxed = build_convex_model(wider, partial(RelaxedMotion, panels))
        try:
            value = relaxed.solve()
        except Unsolved:
            continue
        if relaxed.is_exact:
            unknown = "size" in problem.objective and not problem.has_convex_size and value < inf
            return None if unknown else subtract_solver_error(relaxed, value)
    return None


def subtract_solver_error(relaxed: ConvexModel, value: float) -> float:
    """An optimum less what a solver may err by."""
    return max(value - SOLVER_ERROR * (value + relaxed.unit), 0.0) if value < inf else inf


def solve_free_laws(
    problem: SynthesisProblem, margins: Sequence[float] = LIMIT_MARGINS
) -> tuple[ConvexModel, Iterate, float]:
    """The convex programme with free laws, its solution and its least objective, or what a smooth one may have.

    Among the laws that reach it the one of the gentlest jerk is taken. Margins widen until the laws hold the
    ranges of their derivatives exactly.
    """
    for margin in margins:
        model = build_convex_model(tighten_limits(problem, margin), SplineMotion)
        try:
            least = model.solve()
        except Unsolved:
            if margin == margins[-1]:
                raise
            continue  # with other numbers it may not fail
        if least == inf:
            raise Unmet("no free law with so many pieces holds all limits; try more (synthesis.pieces)")
        found = iterate_of(model)
        least_jerk = least_jerk_laws(model, least)
        for each in (least_jerk, found):
            if each is not None and motion_holds_limits(problem, programme_with_laws(problem, each)):
                return model, each, model.accepted_objective(least)
    raise Unsolved("the convex solver does not hold the limits closely enough")


def least_jerk_laws(model: ConvexModel, least: float) -> Iterate | None:
    """The laws of the least mean square of the jerk at nearly the least objective; None if the solver fails."""
    programme, most = model.least_jerk_problem
    most.value = model.accepted_objective(least) / model.unit + GENTLE_SLACK
    return iterate_of(model) if solve(programme) in SOLVED_STATUSES else None


def _convex_step_cams(
    scene: Scene, model: ConvexModel, problem: SynthesisProblem, start: Iterate, advance: Advance
) -> Iterator[tuple[Synthesis | None, Iterate]]:
    """The laws that convex steps reach from the convex optimum and from known laws, and their cams, if any."""
    starts = [start, *starting_laws(problem, start, objective_weights(scene.synthesis))]
    constraints = nonconvex_constraints_of(problem)
    steps = SequentialConvex(model, constraints)
    for number, each in enumerate(starts):
        advance(number, len(starts))
        last = steps.find_local_optimum(each, constraints)
        yield (
            smallest_cam_for_laws(scene, problem, last)
            if motion_holds_limits(problem, programme_with_laws(problem, last))
            else None,
            last,
        )


def starting_laws(problem: SynthesisProblem, start: Iterate, objective: Collection[str]) -> list[Iterate]:
    """Laws on the smallest cam for them: the known ones within the limits, and the convex optimum.

    Not the latter where the size is part of it: it lies on its smallest cam already, but for other limits.
    ``objective`` are the terms that the scene minimises.
    """
    if (
        problem.residual_limit is not None
    ):  # known laws have more of it; the steps begin at the nearest that have not
        problem = replace(
            problem,
            residual_limit=None,
            scene_problem=problem.scene_problem.without_bound(f"limits.{residual.RESIDUAL_TERM}"),
        )
    laws = [*([] if problem.has_convex_size else [start]), *_known_laws_as_splines(problem, start)]
    return [_laws_on_smallest_cam(problem, each, objective) for each in laws]


def _known_laws_as_splines(problem: SynthesisProblem, start: Iterate) -> Iterator[Iterate]:
    """The scene's own motion and the known laws, as splines of this kind or near them, where within the limits."""
    own = {id(stroke.law) for stroke in problem.free_strokes if not stroke.is_move}
    others = [law for law in LAWS.values() if own and own != {id(law)}]
    for law in (None, *others):
        fits = [_fit_spline(problem, stroke, law) for stroke in problem.free_strokes]
        known = start._replace(coefficients=without_solver_error(problem, fits))
        if motion_holds_limits(problem, programme_with_laws(problem, known)):
            yield known


def _fit_spline(problem: SynthesisProblem, stroke: Stroke, law: Law | None) -> FloatArray:
    """The spline nearest to a known law on a rise or return, or to the scene's own, which a move keeps."""
    splines = problem.splines_of(stroke)
    x = (np.arange(4 * splines.count) + 0.5) / (4 * splines.count)
    low, change = problem.law_offset_and_scale(stroke)
    own = (stroke.motion(stroke.start + x * stroke.angle)[0] / problem.motion_unit - low) / change
    values = own if law is None or stroke.is_move else law.displacement(x)
    return np.asarray(np.linalg.lstsq(splines.value_matrix(x, 0).toarray(), values, rcond=None)[0])


def _laws_on_smallest_cam(problem: SynthesisProblem, known: Iterate, objective: Collection[str]) -> Iterate:
    """Laws on the smallest cam for them, or on one that misses its limits by little."""
    cam = smallest_design(problem.scene_problem.with_given_motion(programme_with_laws(problem, known)), objective)
    if cam is None:
        return known
    lead, prime = float(cam.sense * cam.offset[0]), float(cam.size[0]) + problem.roller
    return known._replace(
        lead=lead / problem.size_unit, height=float(difference_of_squares_root(prime, lead)) / problem.size_unit
    )


@prices.register
def _prices_of_free_laws(result: Synthesis, seconds: float | None = None) -> Prices:
    """By the laws of the cam, as those of known laws."""
    laws = joined_laws(result.design["law_rise"], result.design["law_return"])
    return Prices({laws: prices_of_laws(result)}, objective_unit(result.asked))

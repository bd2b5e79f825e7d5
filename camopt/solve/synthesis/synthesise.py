"""Synthesis: free motion laws that make the cam smallest, or the motion gentlest, within the limits of a scene.

A convex programme gives the laws, and its relaxation a bound for any motion (``relaxation_bound``). The laws then
become laws of the scene, and ``optimise`` finds the smallest cam for them. So the cam meets every limit of the
scene, including those that are not convex. The gap to the bound shows what these limits cost.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from camopt.core.engines.progress import Advance, Progress, report_progress, with_progress_bar
from camopt.core.mistakes import BadInput, Unmet, Unsolved
from camopt.core.numerics import FloatArray
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.stroke import Stroke
from camopt.scene.arguments import SceneSource, allow_positional_options, scene_from
from camopt.scene.scene import Scene
from camopt.solve.smallest.price import Prices
from camopt.solve.smallest.prices import prices
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.cams import (
    motion_holds_limits,
    optimise_or_keep_irrelevant_size,
    programme_with_laws,
    scene_with_laws,
    smallest_cam_for_laws,
    smallest_or_nearest_design,
)
from camopt.solve.synthesis.convex_model import ConvexModel, build_convex_model
from camopt.solve.synthesis.crossings import with_best_crossings_and_bound
from camopt.solve.synthesis.iterate import Iterate, iterate_of, without_solver_error
from camopt.solve.synthesis.law_infeasibility import contradiction_error, no_cam_error
from camopt.solve.synthesis.linear_constraints import with_robust_limits
from camopt.solve.synthesis.nonconvex_constraints import nonconvex_constraints_of
from camopt.solve.synthesis.prices import shadow_prices_of_free_laws
from camopt.solve.synthesis.problem_from_scene import (
    build_synthesis_problem,
    objective_weights,
    split_by_listed_offset_or_arm,
)
from camopt.solve.synthesis.relaxed_optimum import RelaxedOptimum, relaxation_bound, relaxed_optimum_with_jerk_cuts
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.solver import SOLVED_STATUSES, solve
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, LIMIT_MARGINS, SynthesisProblem, tighten_limits
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.synthesis.term_units import objective_unit
from camopt.solve.tables.designs import joined_laws

GENTLE_SLACK = 5e-5  # share of the objective's unit, or of its scale if less, that is given up for the least jerk
MISSES_SHOWN = 3  # laws whose cams are searched for their nearest misses, for the message
ROBUST_ROUNDS = 2  # rounds of tightening limits by tolerances, each at the sizes of the optimum before
SMALL_GAP = 5e-4  # relative gap to the bound at which laws with more pieces are not tried
WIDE_GAP = 0.02  # relative gap to the bound at which convex steps are tried beside the splines with few pieces
EQUAL_ENDS, EQUAL_SHARE = 3, 1e-3  # starts that end this near to the best, in units of the objective, are enough
NONCONVEX_GAP = 1e-3  # relative: a nonconvex limit is active if a cam exceeds its convex optimum by more


@allow_positional_options
@with_progress_bar("starts")
def synthesise(scene: SceneSource, *, progress: Progress | None = None) -> Synthesis:
    """Compute new motion laws for a scene and its ``[synthesis]``, and the smallest cam for them.

    With ``search.robust`` the cam is robust, as with ``optimise``: every cam within the tolerances meets each
    limit. The laws then meet linear limits tightened by the tolerances. The convex steps hold the curves of all
    cams at the corners of the tolerances. The bound remains that of nominal cams.

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
    problems = split_by_listed_offset_or_arm(build_synthesis_problem(scene))
    if CROSSING_JERK in problems[0].objective:
        crossed = [with_best_crossings_and_bound(problem) for problem in problems]
        problems, optima = [problem for problem, _ in crossed], [RelaxedOptimum(bound) for _, bound in crossed]
    else:
        optima = [relaxed_optimum_with_jerk_cuts(scene, problem) for problem in problems]
    feasible = [pair for pair in zip(problems, optima, strict=True) if pair[1].bound != inf]
    if not feasible:
        raise contradiction_error(scene, problems[0], relaxation_bound)
    best, _ = best_synthesis(scene, feasible, partial(report_progress, progress))
    proven = [optimum.bound for optimum in optima if optimum.bound is not None]
    is_bound = len(proven) == len(optima) and min(proven) <= best.objective  # otherwise the solver erred
    return replace(best, bound=min(proven) if is_bound else None)


def best_synthesis(
    scene: Scene,
    problems: Sequence[tuple[SynthesisProblem, RelaxedOptimum]],
    advance: Advance,
) -> tuple[Synthesis, Iterate]:
    """The best cam of several problems of a scene, without a bound, and its free laws.

    Splines for the relaxed optimum of a problem are tried first.

    Raises
    ------
    Unmet
        If free laws meet none of the problems.
    Unsolved
        If the convex solver fails.
    """
    candidates, error = [], Unmet("")
    for problem, optimum in problems:
        try:
            near = _cam_near_relaxed_optimum(scene, optimum)
            candidates += [near] if near else []
            if near is None or near[0].objective > (optimum.bound or 0.0) * (1.0 + WIDE_GAP):
                candidates.append(_best_free_laws(scene, problem, advance))
        except Unmet as reason:
            error = reason
    if not candidates:
        raise error
    return _best_candidate(candidates)


def _best_free_laws(scene: Scene, problem: SynthesisProblem, advance: Advance) -> tuple[Synthesis, Iterate]:
    """The best free laws of a problem, and their cam."""
    advance(0, 1)  # one start, unless the convex optimum is no cam
    problem = robust_problem(problem)
    constraints = nonconvex_constraints_of(problem)
    for first in range(len(LIMIT_MARGINS)):
        model, start, least = solve_free_laws(problem, LIMIT_MARGINS[first:])
        cam = smallest_cam_for_laws(scene, problem, start)
        if cam or constraints:
            break  # otherwise a solver's error breaks a limit, and a wider margin helps
    candidates = [(cam, start)] if cam else []
    is_convex = cam is not None and _is_convex_optimum(cam, model, least)
    steps = (
        []
        if is_convex or not constraints
        else _convex_step_cams_from_starts(scene, model, problem, start, least, advance)
    )
    candidates += [(stepped, laws) for stepped, laws in steps if stepped]
    if not candidates:  # steps may miss a limit by little, or a limit that they do not include
        candidates = [
            (cam, laws)
            for laws in _permitted_known_laws_as_splines(problem)
            if (cam := smallest_cam_for_laws(scene, problem, laws))
        ]
    if not candidates:
        iterates = [start, *(iterate for _, iterate in steps)][:MISSES_SHOWN]
        raise no_cam_error(
            scene,
            problem,
            [optimise_or_keep_irrelevant_size(scene_with_laws(scene, problem, iterate)) for iterate in iterates],
        )
    cam, laws = _best_candidate(candidates)
    return replace(cam, convex=is_convex), laws


def _cam_near_relaxed_optimum(scene: Scene, optimum: RelaxedOptimum) -> tuple[Synthesis, Iterate] | None:
    """The cam near to a relaxed optimum, and its laws; None if nonconvex limits keep every cam from there."""
    best = None
    for problem in map(robust_problem, optimum.cut_problems):
        try:
            model, laws, least = solve_free_laws(problem)
            cam = smallest_cam_for_laws(scene, problem, laws)
        except (BadInput, Unmet, Unsolved):  # BadInput: these laws allow a cam of no size
            continue
        if cam is None or not _is_convex_optimum(cam, model, least):
            continue
        if best is None or cam.objective < best[0].objective:
            best = replace(cam, convex=True), laws
        if optimum.bound is not None and cam.objective - optimum.bound <= SMALL_GAP * model.scale(least):
            break
    return best


def _is_convex_optimum(cam: Synthesis, model: ConvexModel, least: float) -> bool:
    """Whether a cam is as good as the convex optimum, so that no nonconvex limit is active."""
    return cam.objective <= least + NONCONVEX_GAP * (abs(least) + model.unit)


def robust_problem(problem: SynthesisProblem) -> SynthesisProblem:
    """The problem of a robust cam: its linear limits hold for all cams within tolerances, near the optimum."""
    robust = problem
    for _ in range(ROBUST_ROUNDS if problem.scene_problem.robust_errors and problem.linear_constraints else 0):
        _, start, _ = solve_free_laws(robust)
        robust = with_robust_limits(problem, start.lead * problem.size_unit, start.height * problem.size_unit)
    return robust


def _best_candidate(candidates: Sequence[tuple[Synthesis, Iterate]]) -> tuple[Synthesis, Iterate]:
    return min(candidates, key=lambda each: each[0].objective)


def solve_free_laws(
    problem: SynthesisProblem, margins: Sequence[float] = LIMIT_MARGINS
) -> tuple[ConvexModel, Iterate, float]:
    """Solve the convex programme for free laws: the model, its solution, and its least objective.

    With ``smooth`` the objective is the largest that is accepted. Among laws that reach it, the one of least jerk
    is returned. Margins widen until the laws hold the ranges of their derivatives exactly.
    """
    for margin in margins:
        model = build_convex_model(tighten_limits(problem, margin), SplineMotion)
        try:
            least = model.solve()
        except Unsolved:
            if margin == margins[-1]:
                raise
            continue  # the next margin may not fail
        if least == inf:
            raise Unmet("no free law with this number of pieces meets all limits; increase synthesis.pieces")
        optimum = iterate_of(model)
        for laws in (least_jerk_laws(model, least), optimum):
            if laws is not None and motion_holds_limits(problem, programme_with_laws(problem, laws)):
                return model, laws, model.largest_accepted_objective(least)
    raise Unsolved("the convex solver does not hold the limits closely enough")


def least_jerk_laws(model: ConvexModel, least: float) -> Iterate | None:
    """The laws of least mean square jerk at nearly the least objective; None if the solver fails."""
    programme, largest_objective = model.least_jerk_problem
    slack = GENTLE_SLACK * min(model.unit, model.scale(least))
    largest_objective.value = (model.largest_accepted_objective(least) + slack) / model.unit
    return iterate_of(model) if solve(programme) in SOLVED_STATUSES else None


def _convex_step_cams_from_starts(
    scene: Scene, model: ConvexModel, problem: SynthesisProblem, start: Iterate, least: float, advance: Advance
) -> list[tuple[Synthesis | None, Iterate]]:
    """Laws that convex steps reach from the starts, with their cams if any.

    The starts are the convex optimum and the known laws, the most promising first. They end at a cam of the least
    convex objective, or once several cams are equally good.
    """
    starts = starting_laws(problem, start, objective_weights(scene.synthesis))
    constraints = nonconvex_constraints_of(problem)
    steps = SequentialConvex(model, constraints)
    ends: list[tuple[Synthesis | None, Iterate]] = []
    for number, laws in enumerate(steps.rank_starts(starts, constraints)):
        advance(number, len(starts))
        local_optimum = steps.find_local_optimum(laws, constraints)
        cam = (
            smallest_cam_for_laws(scene, problem, local_optimum)
            if motion_holds_limits(problem, programme_with_laws(problem, local_optimum))
            else None
        )
        ends.append((cam, local_optimum))
        objectives = [each.objective for each, _ in ends if each]
        as_good = [value for value in objectives if value <= min(objectives) + EQUAL_SHARE * model.unit]
        if len(as_good) >= EQUAL_ENDS or (as_good and min(as_good) <= least):
            break
    return ends


def starting_laws(problem: SynthesisProblem, start: Iterate | None, objective: Collection[str]) -> list[Iterate]:
    """Laws from which convex steps start, each on its smallest cam.

    They are the convex optimum ``start``, if any, and the known laws within the limits. If the size is convex, the
    optimum keeps it: apart from nonconvex limits, it lies on its smallest cam already. ``objective`` are the terms
    that the scene minimises.
    """
    if problem.residual_limit is not None:  # known laws exceed it; steps begin nearest to them
        problem = replace(
            problem,
            residual_limit=None,
            scene_problem=problem.scene_problem.without_bound(f"limits.{residual.RESIDUAL_TERM}"),
        )
    known_laws = [
        _laws_on_smallest_cam(problem, laws, objective) for laws in _permitted_known_laws_as_splines(problem)
    ]
    if start is None:
        return known_laws
    if not problem.has_convex_size_constraints:
        start = _laws_on_smallest_cam(problem, start, objective)
    return [start, *known_laws]


def _permitted_known_laws_as_splines(problem: SynthesisProblem) -> Iterator[Iterate]:
    """The scene's own motion and the known laws, each fitted by splines, if they meet the limits on the motion.

    They have no lead, and the height of the lift.
    """
    own_laws = {id(stroke.law) for stroke in problem.free_strokes if not stroke.is_move}
    other_laws = [law for law in LAWS.values() if own_laws and own_laws != {id(law)}]
    for law in (None, *other_laws):
        fits = [_fit_spline(problem, stroke, law) for stroke in problem.free_strokes]
        iterate = Iterate(0.0, 1.0, without_solver_error(problem, fits))
        if motion_holds_limits(problem, programme_with_laws(problem, iterate)):
            yield iterate


def _fit_spline(problem: SynthesisProblem, stroke: Stroke, law: Law | None) -> FloatArray:
    """Coefficients of the spline nearest to a known law; a move keeps the scene's own law."""
    splines = problem.splines_by_stroke[stroke]
    x = (np.arange(4 * splines.count) + 0.5) / (4 * splines.count)
    low, change = problem.law_offset_and_scale(stroke)
    own_values = (stroke.motion(stroke.start + x * stroke.angle)[0] / problem.motion_unit - low) / change
    values = own_values if law is None or stroke.is_move else law.displacement(x)
    return np.asarray(np.linalg.lstsq(splines.value_matrix(x, 0).toarray(), values, rcond=None)[0])


def _laws_on_smallest_cam(problem: SynthesisProblem, laws: Iterate, objective: Collection[str]) -> Iterate:
    """Laws with the sizes of their smallest cam, or of one that misses its limits by little."""
    cam = smallest_or_nearest_design(
        problem.scene_problem.with_given_motion(programme_with_laws(problem, laws)), objective
    )
    if cam is None:
        return laws
    sizes = (float(size[0]) for size in (cam.size, cam.offset, cam.arm_length))
    return Iterate(*problem.lead_and_height_of_cam(*sizes), laws.coefficients)


@prices.register
def _prices_of_free_laws(result: Synthesis, seconds: float | None = None) -> Prices:
    """Shadow prices of the free laws, by the laws of the cam."""
    laws = joined_laws(result.design["law_rise"], result.design["law_return"])
    return Prices({laws: [*shadow_prices_of_free_laws(result)]}, objective_unit(result.asked))

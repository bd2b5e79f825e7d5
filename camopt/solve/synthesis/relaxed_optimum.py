"""The optimum of the relaxation: a bound for any motion, and the places where the jerk of the best motion jumps."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf
from typing import NamedTuple

from camopt.core.mistakes import Unsolved
from camopt.scene.scene import Scene
from camopt.solve.synthesis.convex_model import ConvexModel, build_convex_model
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.solver import SOLVER_ERROR
from camopt.solve.synthesis.synthesis_problem import SynthesisProblem, tighten_limits

PANEL_COUNTS = (96, 64, 32, 16)  # panels of a stroke in the relaxation: fewer if the solver fails
FINE_PANELS = (384, 288)  # the same for a problem without nonconvex limits, whose laws come near to the bound
# pieces, and continuous derivatives at cuts, of splines cut beside jumps of the jerk: more if the gap stays wide
CUT_SPLINES = ((12, 3), (10, 2), (24, 3), (48, 2))


class RelaxedOptimum(NamedTuple):
    """The optimum of a relaxed problem: its bound, and splines for a motion that comes near to it."""

    bound: float | None
    """Lower bound of the objective for any motion; infinite if no motion meets the limits, None without a bound."""
    cut_problems: tuple[SynthesisProblem, ...] = ()
    """The problem with splines whose optimum comes near to the bound, with few pieces first."""


def relaxed_optimum_with_jerk_cuts(scene: Scene, problem: SynthesisProblem) -> RelaxedOptimum:
    """The optimum of the relaxation.

    An optimal motion within convex limits follows one limit after the other. Its jerk jumps where the next limit
    takes over. Splines with a knot on each side of these places need few pieces: one knot would have to be at the
    very place, which no relaxation knows. There are none if the scene gives the pieces or the continuity, if it
    asks for a smooth jerk, or if the constraints on the size are not convex.
    """
    settings = scene.synthesis
    is_given = settings.pieces is not None or settings.continuity is not None or settings.smooth > 0.0
    if is_given or not problem.has_convex_size_constraints:
        return RelaxedOptimum(relaxation_bound(problem))
    relaxed, bound = first_solved_relaxation_and_bound(problem, (*FINE_PANELS, *PANEL_COUNTS))
    if relaxed is None or bound == inf:
        return RelaxedOptimum(bound)
    jumps = tuple(
        motion.cuts_beside_jerk_jumps() if isinstance(motion, RelaxedMotion) else () for motion in relaxed.motions
    )
    splines = [
        replace(problem.splines, pieces=pieces, continuity_at_cuts=continuity) for pieces, continuity in CUT_SPLINES
    ]
    return RelaxedOptimum(bound, tuple(replace(problem, jerk_jumps=jumps, splines=each) for each in splines))


def relaxation_bound(problem: SynthesisProblem) -> float | None:
    """Lower bound of the objective for any motion; infinite if no motion meets the limits, None without a bound."""
    return first_solved_relaxation_and_bound(problem, PANEL_COUNTS)[1]


def first_solved_relaxation_and_bound(
    problem: SynthesisProblem, panel_counts: Sequence[int]
) -> tuple[ConvexModel | None, float | None]:
    """The relaxation with the first number of panels that the solver manages, and its bound of the objective.

    There is no bound if the solver fails, or if the size is minimised and its constraints are not convex.
    """
    widened = tighten_limits(problem, -SOLVER_ERROR)  # wider than the solver's error, so that the bound is safe
    for panels in panel_counts:
        relaxed = build_convex_model(widened, partial(RelaxedMotion, panels))
        try:
            value = relaxed.solve()
        except Unsolved:
            continue
        if relaxed.is_solved_accurately:
            has_no_bound = "size" in problem.objective and not problem.has_convex_size_constraints and value < inf
            return relaxed, None if has_no_bound else subtract_solver_error(relaxed, value)
    return None, None


def subtract_solver_error(relaxed: ConvexModel, value: float) -> float:
    """An optimum less the error that the solver may make."""
    return max(value - SOLVER_ERROR * (value + relaxed.unit), 0.0) if value < inf else inf

"""Verdicts in balls: whether a design holds its limits at every cam angle; ``camopt.certify`` has intervals.

A limit is a constraint that a curve stays below a bound, which ``deciding`` decides. The formulas are those of
the mechanisms, run on balls; the laws are exact (``laws``).
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from math import inf, isinf
from time import monotonic
from typing import Any, cast

from camopt.model.effects import EvaluationBlock
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import ASSEMBLY, Limit
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict
from support.balls.ball import as_arb, precisely
from support.balls.curves import BALL_NUMBERS, ExactCurve, in_balls
from support.balls.deciding import Largest, Side, sign_of
from support.balls.laws import NoExactForm
from support.balls.means import mean_verdict
from support.balls.motion import ExactMotion, TurnPart, exact_motion, has_monotone_strokes
from support.balls.section import integrated_rows, is_integrated

HIGHEST_ERROR = 2.0**-100  # relative


@precisely()
def exact_turn(programme: Programme) -> ExactMotion:
    """The turn of a programme in balls, its highest included, which is proved where it may be inside a stroke."""
    motion = exact_motion(programme)
    if has_monotone_strokes(programme):
        return motion
    highest = Largest(Side(ExactCurve(MotionDerivative(0))).parts(motion)).within(HIGHEST_ERROR)
    return replace(motion, highest=highest)


def sides_of(constraint: Constraint, design: Designs, motion: ExactMotion) -> Iterator[Side]:
    """The sides of a constraint for a design (in balls)."""
    curve = ExactCurve(constraint.curve(design, cast(Programme, motion)))
    return (Side(curve, constraint.kinds, sign) for sign in constraint.side_signs)


def largest_of(constraints: Iterable[Constraint], design: Designs, motion: ExactMotion) -> Largest:
    """What the curves of constraints are at most, on all their sides, for a design (in balls)."""
    parts: list[tuple[Side, TurnPart]] = []
    for constraint in constraints:
        turn = (
            constraint.curve.motion_of_tool_or_follower(motion)
            if isinstance(constraint.curve, MotionDerivative)
            else motion
        )
        for side in sides_of(constraint, design, motion):
            parts += side.parts(turn)
    return Largest(parts)


def constraint_verdict(
    problem: Problem, constraint: Constraint, design: Designs, motion: ExactMotion, until: float = inf
) -> str:
    """The verdict on a constraint for a design (in balls)."""
    if on_arcs(problem, constraint.curve):
        return worst_verdict(_on_arcs(problem, constraint, design))
    return verdict_on_constraint(largest_of((constraint,), design, motion), constraint, design, until)


def verdict_on_constraint(largest: Largest, constraint: Constraint, design: Designs, until: float = inf) -> str:
    """The verdict on a constraint for a design (in balls), from what its curves are at most."""
    return largest.verdict(
        constraint.upper_bound_of_each_side(BALL_NUMBERS), as_arb(constraint.factor(design)), until
    )


def on_arcs(problem: Problem, curve: Any) -> bool:
    """Whether a curve is the curvature of a cam that is given by its profile."""
    mechanism = problem.setup.mechanism
    return bool(problem.profile) and curve in (mechanism.curvature, mechanism.profile_radius)


def _on_arcs(problem: Problem, constraint: Constraint, design: Designs) -> Iterator[str]:
    """The verdicts on the curvature of a cam that is given by its profile: on an arc it is constant.

    A limit is often just that of the sharpest arc, and is not divided by, so that this is seen.
    """
    factor, allowed = as_arb(constraint.factor(design)), constraint.upper_bound_of_each_side(BALL_NUMBERS)
    for side, radius in product(constraint.side_signs, problem.profile):
        if isinf(radius):  # a line
            yield sign_of(-allowed)
        elif problem.setup.mechanism.flat_faced:
            yield sign_of(factor * side * radius - allowed)
        else:
            of_pitch = as_arb(design.roller_radius) + radius
            yield sign_of((factor * side - allowed * of_pitch) * of_pitch.sgn())


def _without_curves(
    problem: Problem, limit: Limit, design: Designs, exact: Designs, motion: ExactMotion, until: float
) -> str:
    """The verdict on a limit without curves: a crossing, a size, an integral, or one of the motion."""
    if limit.single_design_decider:
        broken = limit.single_design_decider(problem.setup, design, problem.programme)
        return UNDECIDED if broken is None else BROKEN if broken else HELD
    if not is_integrated(limit.required_quantities):
        case = EvaluationBlock(with_rounding_relative_error(problem).setup, problem.programme, design)
        return _quantity_verdict(limit, run_effects(case, limit.required_quantities), design)
    for rows in integrated_rows(problem, motion, design, exact, limit.required_quantities):
        found = _quantity_verdict(limit, rows, design)
        if found != UNDECIDED or monotonic() > until:
            return found
    return UNDECIDED


def _quantity_verdict(limit: Limit, rows: DesignRows, design: Designs) -> str:
    """The verdict on a limit from the enclosures of its quantities."""
    outer, inner = (limit.excess(rows.columns_shifted_by_width_share(share), design)[0] for share in (1.0, -1.0))
    return HELD if outer <= 0.0 else BROKEN if inner > 0.0 else UNDECIDED


@precisely()
def verdicts_in_balls(problem: Problem, design: Designs, until: float = inf) -> dict[str, str]:
    """The verdict on each limit for one design: held, broken or undecided, as at ``until`` (``monotonic``)."""
    if not problem.setup.mechanism.can_assemble(design, problem.programme)[0]:
        return {ASSEMBLY: BROKEN}
    try:
        motion = exact_turn(problem.programme)
    except NoExactForm:
        return {limit.name: UNDECIDED for limit in problem.limits}
    exact = in_balls(design)
    verdicts: dict[str, str] = {}
    for limit in problem.limits:
        found = [constraint_verdict(problem, constraint, exact, motion, until) for constraint in limit.constraints]
        if (presumed := verdicts.get(limit.prerequisite_limit_name, HELD)) != HELD:
            found = [presumed]
        elif limit.mean_constraint is not None:
            found = [mean_verdict(limit.mean_constraint, exact, motion, until)]
        elif not limit.constraints:
            found = [_without_curves(problem, limit, design, exact, motion, until)]
        if limit.is_infinite_on_motion(problem.programme):
            found = [BROKEN]
        verdicts[limit.name] = worst_verdict(found)
    return verdicts

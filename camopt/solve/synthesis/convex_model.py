"""The convex programme of a synthesis problem: sizes, motions of the strokes, constraints and objective.

The representation of the motion is a parameter. ``spline_motion`` uses splines whose constraints hold at every cam
angle: its optimum is a cam. ``relaxation`` uses values at nodes that every motion has: its optimum is a bound.

The motion is in units of the highest lift and sizes are in ``SynthesisProblem.size_unit``, so that numbers are
near 1.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any

import cvxpy as cp

from camopt.core.mistakes import Unsolved
from camopt.model.motion.stroke import DWELL
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.solver import (
    INFEASIBLE,
    INFEASIBLE_STATUSES,
    SOLVED,
    SOLVED_STATUSES,
    failure_message,
    solve,
)
from camopt.solve.synthesis.stroke_motion import (
    DerivativeRange,
    DerivativeRanges,
    FixedMotion,
    MotionFactory,
    Sizes,
    StrokeMotion,
)
from camopt.solve.synthesis.synthesis_problem import (
    CROSSING_JERK,
    LOST_AREA,
    RMS_TERM_ORDERS,
    TERM_ORDERS,
    MeanConstraint,
    SynthesisProblem,
)


@dataclass
class ConvexModel:
    """A convex programme and its parts."""

    problem: SynthesisProblem
    objective: cp.Expression
    """The objective divided by ``unit``."""
    constraints: list[cp.Constraint]
    unit: float
    """Magnitude of the objective, by which it is divided to be near 1."""
    sizes: Sizes
    motions: list[StrokeMotion]
    peak_variables: dict[str, cp.Variable]
    """Upper bounds of the derivatives that are minimised or bounded over the turn, in units of the lift."""

    @cached_property
    def cvxpy_problem(self) -> cp.Problem:
        return cp.Problem(cp.Minimize(self.objective), self.constraints)

    def solve(self) -> float:
        """Solve the programme: the least objective, in its own unit; infinite if no motion meets all limits.

        Raises
        ------
        Unsolved
            If the solver fails.
        """
        status = solve(self.cvxpy_problem)
        if status in INFEASIBLE_STATUSES:
            return inf
        if status not in SOLVED_STATUSES:
            raise Unsolved(failure_message(status))
        return self.unit * float(self.cvxpy_problem.value)

    @cached_property
    def least_jerk_problem(self) -> tuple[cp.Problem, cp.Parameter]:
        """The programme of least mean square jerk, and the parameter that bounds the objective in it.

        With ``smooth`` it minimises the variation of the jerk instead, over strokes and their joints.
        """
        largest_objective = cp.Parameter()
        if self.problem.smooth:
            ends = [motion.end_derivative(3, last) for motion in self.motions for last in (False, True)]
            jumps = [after - before for before, after in zip(ends[1::2], [*ends[2::2], ends[0]], strict=True)]
            jerk = cp.norm1(
                cp.hstack([*jumps, *(v for motion in self.motions for v in motion.jerk_variation_vectors())])
            )
        else:
            jerk = _root_integral_of_squares(self.motions, 3)
        return cp.Problem(
            cp.Minimize(jerk), [*self.constraints, self.objective <= largest_objective]
        ), largest_objective

    def largest_accepted_objective(self, least: float) -> float:
        """Largest objective that a smooth motion may have, for a least objective."""
        return least + self.problem.smooth * abs(least)

    def scale(self, least: float) -> float:
        """What small differences from a least objective are a share of: the prime radius, if the size is all."""
        weights, roller = self.problem.objective, self.problem.prime_less_cam_radius
        return least + weights["size"] * roller if {*weights} == {"size"} else abs(least) + self.unit

    @property
    def is_solved_accurately(self) -> bool:
        """Whether the solver reached its requested accuracy."""
        return self.cvxpy_problem.status in (SOLVED, INFEASIBLE)


def build_convex_model(
    problem: SynthesisProblem, make_motion: MotionFactory, term_bounds: Mapping[str, Any] | None = None
) -> ConvexModel:
    """The convex programme of a problem, with motions made by a factory.

    ``term_bounds`` bounds further objective terms, in their units, by numbers or cvxpy parameters.
    """
    term_bounds = term_bounds or {}
    sizes = Sizes(cp.Variable(), cp.Variable(), cp.Variable())
    names = dict.fromkeys(
        (*problem.objective, *term_bounds, *([] if problem.residual_limit is None else [residual.RESIDUAL_TERM]))
    )
    peak_variables = {name: cp.Variable() for name in names if name in (*TERM_ORDERS, CROSSING_JERK)}
    motions = [
        (make_motion if stroke.is_law_replaceable else FixedMotion)(
            problem, stroke, _stroke_derivative_ranges(problem, number, peak_variables), sizes
        )
        for number, stroke in enumerate(problem.strokes)
    ]
    lowest = _lowest_displacement(problem, motions)
    terms = {name: _term_expression(problem, name, sizes, motions, lowest, peak_variables) for name in names}
    constraints = [variable >= 0.0 for variable in (sizes.height, *peak_variables.values())]
    constraints += _lead_and_prime_radius_constraints(problem, sizes, lowest)
    constraints += _joint_constraints(problem, motions)
    for number, partner in enumerate(problem.mirror_strokes or ()):
        if number <= partner:
            motions[number].impose_mirror(motions[partner])
    for crossing in problem.crossings if CROSSING_JERK in peak_variables else ():
        motions[crossing.stroke].impose_acceleration_sign_change(crossing, peak_variables[CROSSING_JERK])
        for jerk_limit in problem.derivative_ranges[crossing.stroke].get(
            3, ()
        ):  # a larger jerk would allow no more
            constraints.append(peak_variables[CROSSING_JERK] <= abs(jerk_limit) / problem.motion_unit)
    for one, other, total in problem.opposed_pairs:
        motions[one].impose_displacement_sum(motions[other], total)
    for motion in motions:
        constraints += motion.constraints
    constraints += [
        (terms[name] - bound) / _term_magnitude(problem, name) <= 0.0 for name, bound in term_bounds.items()
    ]
    if problem.residual_limit is not None:
        constraints.append(terms[residual.RESIDUAL_TERM] / problem.residual_limit <= 1.0)
    constraints += [
        _mean_constraint(mean, motions, lowest, problem.motion_unit) for mean in problem.mean_constraints
    ]
    unit = sum(weight * _term_magnitude(problem, name) for name, weight in problem.objective.items()) or 1.0
    objective = sum((w / unit * terms[name] for name, w in problem.objective.items()), start=cp.Constant(0.0))
    return ConvexModel(problem, objective, constraints, unit, sizes, motions, peak_variables)


def _stroke_derivative_ranges(
    problem: SynthesisProblem, stroke_number: int, peak_variables: Mapping[str, Any]
) -> DerivativeRanges:
    """The ranges of a stroke's derivatives in units of the lift: its own, and those over the turn."""
    ranges: DerivativeRanges = {
        TERM_ORDERS[name]: [DerivativeRange(-1.0, 1.0, variable)]
        for name, variable in peak_variables.items()
        if name != CROSSING_JERK
    }
    for order, (low, high) in problem.derivative_ranges[stroke_number].items():
        ranges.setdefault(order, []).append(DerivativeRange(low / problem.motion_unit, high / problem.motion_unit))
    return ranges


def _lead_and_prime_radius_constraints(
    problem: SynthesisProblem, sizes: Sizes, lowest_displacement: Any
) -> list[cp.Constraint]:
    """Constraints on the ranges of the sizes, and on the prime radius where the follower is lowest.

    Without a lead in the prime radius, the height is the prime radius, and stays within its range too: convex steps
    evaluate the cam at the height.
    """
    unit = problem.size_unit
    height = sizes.height + problem.motion_unit / unit * lowest_displacement
    ranges = [(sizes.lead, problem.lead_range), (sizes.prime, problem.prime_range)]
    if problem.has_lead_in_prime_radius:
        constraints = [cp.norm(cp.hstack([sizes.lead, height])) <= sizes.prime]
    else:
        constraints = [sizes.prime >= height]
        ranges.append((height, (problem.prime_range[0], inf)))
    for size, (low, high) in ranges:
        constraints += DerivativeRange(low / unit, high / unit).constraints(size)
    return constraints


def _lowest_displacement(problem: SynthesisProblem, motions: list[StrokeMotion]) -> cp.Expression | float:
    """Displacement where the follower is lowest, in units of the lift; 0 if the scene gives its lowest position."""
    angle, strokes = problem.lowest_angle, problem.strokes
    if angle is None:
        return 0.0
    number = next((n for n, stroke in enumerate(strokes) if angle < stroke.end), len(strokes) - 1)
    x = (angle - strokes[number].start) / strokes[number].angle
    return motions[number].displacement_at(min(max(x, 0.0), 1.0))


def _joint_constraints(problem: SynthesisProblem, motions: list[StrokeMotion]) -> Iterator[cp.Constraint]:
    """Constraints where two strokes meet: rest beside a dwell, otherwise the required continuity."""
    for number, motion in enumerate(motions):
        before, stroke, last = motions[number - 1], problem.strokes[number], problem.strokes[number - 1]
        if not (stroke.is_law_replaceable or last.is_law_replaceable):
            continue
        if DWELL in (stroke.kind, last.kind):
            motion.impose_rest(problem.rest, False)
            before.impose_rest(problem.rest, True)
            continuity = 0
        else:
            continuity = problem.required_continuity_at_joint(last.end)
        for order in range(0 if stroke.is_move or last.is_move else 1, continuity + 1):
            end, start = before.end_derivative(order, True), motion.end_derivative(order, False)
            if end is not None and start is not None:
                yield end == start


def _term_magnitude(problem: SynthesisProblem, name: str) -> float:
    """Order of magnitude of an objective term, in its own unit."""
    if name == "size":
        return problem.size_unit
    if name == LOST_AREA:
        return problem.lift_times_turn_angle * problem.term_unit_factors[name]
    shortest = min(stroke.angle for stroke in problem.free_strokes)
    if name == residual.RESIDUAL_TERM:
        return (
            problem.motion_unit
            * problem.term_unit_factors[name]
            / (1.0 + (problem.train_frequency_and_damping[0] * shortest) ** 2)
        )
    order = {**TERM_ORDERS, **RMS_TERM_ORDERS, CROSSING_JERK: 3}[name]
    return problem.motion_unit * problem.term_unit_factors[name] / shortest**order


def _term_expression(
    problem: SynthesisProblem,
    name: str,
    sizes: Sizes,
    motions: list[StrokeMotion],
    lowest: Any,
    peak_variables: Mapping[str, cp.Variable],
) -> cp.Expression:
    """An objective term, in its own unit."""
    if name == "size":
        return problem.size_unit * sizes.prime - problem.prime_less_cam_radius
    if name == residual.RESIDUAL_TERM:
        return problem.term_unit_factors[name] * _largest_residual_vibration(motions)
    factor = problem.motion_unit * problem.term_unit_factors[name]
    if name in peak_variables:
        return factor * peak_variables[name]
    if name == LOST_AREA:
        return problem.lift_times_turn_angle * problem.term_unit_factors[name] - factor * _lift_area_expression(
            motions, lowest
        )
    return factor / sqrt(2.0 * pi) * _root_integral_of_squares(motions, RMS_TERM_ORDERS[name])


def _root_integral_of_squares(motions: list[StrokeMotion], order: int) -> cp.Expression:
    """√∮(y⁽ᵏ⁾)² dθ, or a lower bound of it."""
    return cp.norm(
        cp.hstack([vector for motion in motions for vector in motion.integral_of_squares_vectors(order)])
    )


def _largest_residual_vibration(motions: list[StrokeMotion]) -> cp.Expression:
    """Largest residual vibration over the dwells [mm or rad]; 0 if a motion does not know its part of it."""
    responses = [motion.residual_response() for motion in motions]
    known_responses = [response for response in responses if response]
    if not known_responses or any(response is None for response in responses):
        return cp.Constant(0.0)
    return cp.max(cp.hstack([cp.norm(sum(dwell)) for dwell in zip(*known_responses, strict=True)]))


def _mean_constraint(mean: MeanConstraint, motions: list[StrokeMotion], lowest: Any, unit: float) -> cp.Constraint:
    """A mean constraint on motions in a unit; the area counts from the displacement ``lowest``."""
    if mean.power == 1:
        return mean.side * _lift_area_expression(motions, lowest) <= mean.side * 2.0 * pi * mean.bound / unit
    return _root_integral_of_squares(motions, mean.order) <= sqrt(2.0 * pi) * mean.bound / unit


def _lift_area_expression(motions: list[StrokeMotion], lowest: Any) -> cp.Expression:
    """∮y dθ above the lowest displacement, in units of the lift."""
    return sum(motion.lift_area() for motion in motions) - 2.0 * pi * lowest

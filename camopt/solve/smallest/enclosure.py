"""Limits enclosed over boxes of designs: which boxes are empty, and which part of a box may be feasible.

A feasible design meets a limit at every cam angle. The limit's formula at one angle is evaluated over a box, with
its slopes by the sizes (``numerics.sloped_interval``). This bounds the excess of all designs of the box. If the
bound is above 0, the box is empty. If it is above 0 at one end of a size, that end is cut off.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8 (interval Newton).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, Generic, NamedTuple, TypeVar, cast

import numpy as np

from camopt.core.numerics import Curve, FloatArray
from camopt.core.numerics.curves import Linear, curve_value
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.load_tables import TrainLoadTable
from camopt.core.numerics.sloped_interval import as_quotient, as_sloped_interval
from camopt.core.numerics.state import State, TrainForces
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme, derivative_peak
from camopt.scene.problem.constraints import AnyConstraint, Constraint, TurnMeanConstraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import NumberErrors, with_added_errors
from camopt.solve.smallest.excesses import (
    EXCESS_ROUNDING,
    Excesses,
    append_weighted_sum,
    choose_cut_side,
    concatenate_excesses,
    feasible_box_ends_and_empty_boxes,
    solve_linear_programme,
)
from camopt.solve.verdicts.constraint_boxes import relative_excess
from camopt.solve.verdicts.mean_boxes import enclose_mean_excess
from camopt.solve.verdicts.sloped_designs import designs_of_sloped_intervals

ConstraintType = TypeVar("ConstraintType", bound=AnyConstraint, covariant=True)


class ProblemConstraint(NamedTuple, Generic[ConstraintType]):
    """A constraint on designs, with the problem whose motion it uses."""

    problem: Problem
    constraint: ConstraintType


def size_constraints_with_error_variants(
    problem: Problem,
    constraints_of_limit: Callable[[Limit], Sequence[Constraint]] = lambda limit: limit.constraints,
) -> list[ProblemConstraint[Constraint]]:
    """The constraints of limits that depend on sizes or numbers of the cam.

    In a robust problem there is one set for each cam with errors, with the motion of its own train.
    ``constraints_of_limit`` selects the constraints of a limit.
    """
    return [
        ProblemConstraint(variant, constraint_for_cam_with_errors(with_motion_peak_as_curve(constraint), errors))
        for variant, errors in ((problem, {}), *problem.error_variants)
        for limit in variant.limits
        if not limit.is_decided_by_motion_alone
        for constraint in constraints_of_limit(limit)
    ]


def constraint_for_cam_with_errors(constraint: Constraint, errors: NumberErrors) -> Constraint:
    """The constraint evaluated for the cam with these errors, as a constraint on nominal designs."""
    if not errors:
        return constraint
    curve, factor, unit = constraint.curve, constraint.factor, constraint.unit
    return constraint._replace(
        curve=lambda designs, programme: curve(with_added_errors(designs, errors), programme),
        factor=lambda designs: factor(with_added_errors(designs, errors)),
        unit=lambda designs: unit(with_added_errors(designs, errors)),
    )


def with_motion_peak_as_curve(constraint: Constraint) -> Constraint:
    """The constraint with a curve of designs, even if it limits a derivative of the motion alone."""
    return constraint._replace(curve=motion_peak_as_curve(constraint.curve, constraint.kinds))


def motion_peak_as_curve(curve: Curve, stroke_kinds: int) -> Curve:
    """A curve of designs; a derivative of the motion becomes its peak over the strokes, equal for all designs."""
    return (
        partial(_constant_peak_curve, derivative=curve, stroke_kinds=stroke_kinds)
        if isinstance(curve, MotionDerivative)
        else curve
    )


def _constant_peak_curve(
    designs: Designs, programme: Programme, derivative: MotionDerivative, stroke_kinds: int
) -> Linear:
    """The largest magnitude of a derivative of the motion, as a curve."""
    peak = derivative_peak(derivative.motion_of_tool_or_follower(programme), derivative.order, stroke_kinds)
    zeros = np.zeros(len(designs))
    return Linear(zeros, zeros, zeros, zeros + peak)


def size_dependent_mean_constraints(problem: Problem) -> list[ProblemConstraint[TurnMeanConstraint]]:
    """The constraints on means over the turn that depend on the size of the cam."""
    means = (limit.mean_constraint for limit in problem.limits if not limit.is_decided_by_motion_alone)
    return [ProblemConstraint(problem, mean) for mean in means if mean is not None]


def middle_designs_at_size_share(
    problem: Problem,
    low: dict[str, FloatArray],
    high: dict[str, FloatArray],
    size_share: float,
    discs: Sequence[str] = ("size",),
) -> Designs:
    """One design of each box: its middle, with the size at a share of the way from least to largest."""
    middle = {name: (low[name] + high[name]) / 2 for name in low}
    sizes = {disc: low[disc] + size_share * (high[disc] - low[disc]) for disc in discs}
    return problem.design.with_values({**middle, **sizes})


class BoxState(NamedTuple):
    """The state of n boxes after their limits are enclosed."""

    empty: Any
    """Which boxes hold no feasible design (n,)."""
    within_rounding: Any
    """Over which boxes no limit is exceeded by more than rounding (n,)."""
    inside: Designs
    """One design of each box."""
    side: Any
    """The free variable to cut next (n,)."""
    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    """The ends between which the feasible designs lie, (n,) of each free variable."""


def enclose_limits(
    problem: Problem,
    constraints: Sequence[ProblemConstraint[AnyConstraint]],
    box: Designs,
    free: list[str],
    discs: Sequence[str] = ("size",),
) -> BoxState:
    """The state of boxes from each limit at the cam angles where one design of the box exceeds it the most.

    The side to cut is the one across which the excess over the worst limit changes the most. It is the longest side
    if no design of the box is known that can be assembled.
    """
    empty = problem.setup.mechanism.cannot_assemble(box, problem.programme)
    inside, exists = assemblable_design_of_each_box(problem, box, free, ~empty)
    intervals: dict[str, Any] = box.values
    low, high = (np.array([getattr(intervals[n], end) for n in free]) for end in ("low", "high"))
    side, index, level = np.argmax(high - low, axis=0), np.flatnonzero(exists), exists.copy()
    present = [item for item in constraints if item.problem.programme.has_kinds(item.constraint.kinds)]
    if index.size and present:
        point = np.array([inside.values[n][index] for n in free])
        span = Interval(low[:, index] - point, high[:, index] - point)
        with np.errstate(all="ignore"):
            over = _box_excesses(present, box.take(index), inside.take(index), free)
            with_sums = over
            for disc in set(discs).intersection(free) if len(free) > 1 else ():
                multipliers, _ = solve_linear_programme(with_sums, span, free.index(disc))
                with_sums = append_weighted_sum(with_sums, multipliers)
            level[index] = np.all(over.most <= np.fmin(over.rounding, EXCESS_ROUNDING), axis=0)
            side[index] = choose_cut_side(over, span)
            low[:, index], high[:, index], empty[index] = feasible_box_ends_and_empty_boxes(
                with_sums, low[:, index], high[:, index], point
            )
    return BoxState(empty, level, inside, side, *(dict(zip(free, end, strict=True)) for end in (low, high)))


def constraints_on_present_strokes(problem: Problem, constraints: Sequence[Constraint]) -> list[Constraint]:
    """The constraints whose kinds of stroke occur in the motion."""
    return [constraint for constraint in constraints if problem.programme.has_kinds(constraint.kinds)]


def _box_excesses(
    constraints: Sequence[ProblemConstraint[AnyConstraint]], box: Designs, inside: Designs, free: list[str]
) -> Excesses:
    """The excesses on both sides of the cam angles where one design of each box exceeds the limits the most.

    A limit on a mean has one excess, over the whole turn.
    """
    count, parts, blocks = len(inside), [], dict[int, EvaluationBlock]()
    for problem, constraint in constraints:
        if isinstance(constraint, TurnMeanConstraint):
            parts.append(Excesses.from_sloped_value(enclose_mean_excess(problem, constraint, box, inside, free)))
            continue
        block = blocks.setdefault(id(problem), EvaluationBlock(problem.setup, problem.programme, inside))
        angles = problem.programme.one_sided_angles(
            block.extremes(constraint.curve, constraint.kinds_and_goals).where, constraint.kinds
        ).ravel()
        rows = angles.size // count
        designs, like = designs_of_sloped_intervals(box, inside, free, rows)
        state = state_enclosing_rounding(problem.programme.state(angles), problem.programme)
        value = curve_value(constraint.curve(designs, problem.programme), ..., state)
        sides = np.tile(np.repeat(constraint.side_signs, count), 2)
        excess = as_sloped_interval(relative_excess(constraint, sides, as_quotient(value), designs), like)
        parts.append(Excesses.from_sloped_value(excess, rows))
    return concatenate_excesses(parts)


def state_enclosing_rounding(state: State, programme: Programme) -> State:
    """A state at cam angles as intervals that cover the rounding of laws and of the train's forces."""
    table = programme.table
    y, y1, y2, y3 = (Interval(x - e, x + e) for x, e in zip(state[:4], table.error.max(axis=0)[:4], strict=True))
    load = state.load
    if isinstance(table.load, TrainLoadTable):
        rounding = [error for force in table.load for error in force.error[:, :2].max(axis=0)]
        forces = zip(cast(TrainForces, load), rounding, strict=True)
        load = TrainForces(*(Interval(x - e, x + e) for x, e in forces))
    return State(y, y1, y2, y3, load)


def assemblable_design_of_each_box(
    problem: Problem, box: Designs, free: list[str], wanted_boxes: Any
) -> tuple[Designs, Any]:
    """A design of each wanted box that can be assembled, and whether there is one.

    Tried in turn: the middle, the largest size with the offset nearest to zero, the least size, every corner.
    """
    intervals: dict[str, Any] = box.values
    low = {name: interval.low for name, interval in intervals.items()}
    high = {name: interval.high for name, interval in intervals.items()}
    chosen = middle_designs_at_size_share(problem, low, high, 0.5)
    nearest = np.minimum(np.maximum(low["offset"], 0.0), high["offset"])
    largest = replace(middle_designs_at_size_share(problem, low, high, 1.0), offset=nearest)
    exists = wanted_boxes & problem.setup.mechanism.can_assemble(chosen, problem.programme)
    ends = product(*((low[name], high[name]) for name in free))
    corners = (chosen.with_values(dict(zip(free, corner, strict=True))) for corner in ends)
    for other in (largest, middle_designs_at_size_share(problem, low, high, 0.0), *corners):
        if not np.any(wanted_boxes & ~exists):
            break
        better = wanted_boxes & ~exists & problem.setup.mechanism.can_assemble(other, problem.programme)
        values = {name: np.where(better, other.values[name], a) for name, a in chosen.values.items()}
        chosen, exists = chosen.with_values(values), exists | better
    return chosen, exists

"""Lower bounds of the costs of boxes of designs, and which boxes hold only designs that break a limit.

Interval arithmetic bounds sizes, and quantities that depend on the motion, over a box. The largest value of a curve
over the turn is at least its value at any one cam angle. At that angle the curve's formula, evaluated on intervals
with slopes, bounds this value for all designs of the box (``smallest.enclosure``). A limit's excess is bounded in
the same way.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, BoolArray, Curve, FloatArray, Number
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.sloped_interval import Quotient, SlopedInterval, as_quotient, as_sloped_interval
from camopt.model.effects import EvaluationBlock, Setup, find_effect, require_effect
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import Peak
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.solve.smallest.enclosure import (
    assemblable_design_of_each_box,
    constraints_on_present_strokes,
    motion_peak_as_curve,
    size_dependent_mean_constraints,
    state_enclosing_rounding,
    with_motion_peak_as_curve,
)
from camopt.solve.smallest.excesses import EXCESS_ROUNDING, UNBOUNDED_SLOPE
from camopt.solve.verdicts.constraint_boxes import relative_excess
from camopt.solve.verdicts.effect_runs import can_effect_run_on_ranges, quantities_over_box
from camopt.solve.verdicts.mean_boxes import enclose_mean_excess, enclose_mean_of_curve_power
from camopt.solve.verdicts.sloped_designs import designs_of_sloped_intervals

COARSE_SHARE = (
    1e-4  # relative error of the extremes whose cam angles are used: any angle is valid, a near one is close enough
)
BOUND_ERROR = 1e-12  # relative rounding of a quantity computed from its extreme or from sizes
KERNEL_ERROR_FACTOR = 4.0  # errors of kernels, in multiples of the requested error and of the rounding at a point


def peak_or_mean_bounding_cost(objective: str, cost_sign: float, setup: Setup) -> Peak | Mean | None:
    """The peak or mean that bounds an objective from below as a cost; ``cost_sign`` is −1 if it is maximised."""
    effect = require_effect(objective, setup)
    form = effect.peaks(setup).get(objective) or effect.means(setup).get(objective)
    return form if form is not None and form.is_least == (cost_sign < 0.0) else None


def can_bound_objective(objective: str, cost_sign: float, setup: Setup) -> bool:
    """Whether the cost of an objective has a lower bound over boxes of designs."""
    effect = find_effect(objective, setup)
    if effect is None or effect.is_of_sizes or effect.is_of_motion(setup):
        return effect is not None
    return peak_or_mean_bounding_cost(objective, cost_sign, setup) is not None


def can_bound_all_objectives(problem: Problem) -> bool:
    """Whether boxes of designs bound the costs of all objectives from below."""
    return all(can_bound_objective(name, sign, problem.setup) for name, sign in problem.objectives.items())


def is_motion_infeasible(problem: Problem) -> bool:
    """Whether no design of the problem's motion meets the limits, whatever its sizes."""
    if any(limit.is_infinite_on_motion(problem.programme) for limit in problem.limits):
        return True
    motion_limits = [limit for limit in problem.limits if limit.is_decided_by_motion_alone]
    return bool(np.any(_least_size_or_motion_excesses(problem, motion_limits, problem.design) > 0.0))


class BoxCosts(NamedTuple):
    """The bounds of n boxes of designs of one motion."""

    costs: FloatArray
    """Lower bounds of the designs' costs (n, objectives)."""
    change: FloatArray
    """Relative change of the costs across each free field (free, n)."""
    inside: Designs
    """A design of each box that can be assembled."""
    exists: BoolArray
    """Whether there is such a design (n,)."""

    def take(self, index: Any) -> "BoxCosts":
        return BoxCosts(self.costs[index], self.change[:, index], self.inside.take(index), self.exists[index])


class BoxBounds(NamedTuple):
    """Bounds for boxes of designs of one motion; ``free`` are the fields that have a range."""

    problem: Problem
    free: list[str]

    @np.errstate(all="ignore")
    def boxes_impossible_by_sizes(self, box: Designs) -> Any:
        """Which boxes hold no design that can be assembled, or only designs that break a limit on sizes (n,)."""
        limits = [
            limit for limit in self.problem.limits if not limit.constraints and not limit.is_decided_by_motion_alone
        ]
        over = _least_size_or_motion_excesses(self.problem, limits, box)
        return self.problem.setup.mechanism.cannot_assemble(box, self.problem.programme) | np.any(
            over > 0.0, axis=0
        )

    @np.errstate(all="ignore")
    def bound_costs(self, box: Designs) -> BoxCosts:
        """The lower bounds of all objectives as costs."""
        inside, exists = assemblable_design_of_each_box(self.problem, box, self.free, np.ones(len(box), dtype=bool))
        objectives, setup = self.problem.objectives, self.problem.setup
        costs, change = np.full((len(box), len(objectives)), -np.inf), np.zeros((len(self.free), len(box)))
        index = np.flatnonzero(exists)
        existing, middle = box.take(index), inside.take(index)
        for k, (name, sign) in enumerate(objectives.items()):
            if can_effect_run_on_ranges(require_effect(name, setup), setup):
                costs[:, k], cost_change = self._bound_size_or_motion_cost_and_change(name, sign, box, inside)
                change = np.maximum(change, cost_change)
            elif index.size:
                costs[index, k], cost_change = self._bound_curve_cost_and_change(name, sign, existing, middle)
                change[:, index] = np.maximum(change[:, index], cost_change)
        return BoxCosts(costs, np.maximum(change, self._relative_box_widths_of_numbers(box)), inside, exists)

    @np.errstate(all="ignore")
    def infeasible_boxes_and_excess_changes(
        self, box: Designs, box_costs: BoxCosts
    ) -> tuple[BoolArray, FloatArray]:
        """Which boxes hold only designs that break a limit (n,), and the change of the excesses (free, n).

        The change is the largest across each free size, over the limits that some designs of a box may break.
        """
        broken, change = np.zeros(len(box), dtype=bool), np.zeros((len(self.free), len(box)))
        index = np.flatnonzero(box_costs.exists)
        if not index.size:
            return broken, change
        existing, inside = box.take(index), box_costs.inside.take(index)
        width = _box_widths(existing, self.free)
        for over in self._curve_and_mean_excesses(existing, inside):
            excess_change = _cap_infinite_slopes(over.slopes.largest_magnitude) * width
            broken[index] |= over.value.low > EXCESS_ROUNDING
            change[:, index] = np.maximum(change[:, index], np.where(over.value.high > 0.0, excess_change, 0.0))
        return broken, change

    def _curve_and_mean_excesses(self, box: Designs, inside: Designs) -> Iterator[SlopedInterval]:
        """The excesses of boxes over limits on curves, where one design exceeds them the most, and on means."""
        on_size = tuple(limit for limit in self.problem.limits if not limit.is_decided_by_motion_alone)
        constraints = strictest_constraints(replace(self.problem, limits=on_size).constraints)
        for constraint in constraints_on_present_strokes(
            self.problem, [with_motion_peak_as_curve(constraint) for constraint in constraints]
        ):
            angle, side = self._most_extreme_angles_and_signs(constraint.curve, constraint.kinds_and_goals, inside)
            value, designs, like = self._enclose_curve_at_angles(constraint.curve, angle, box, inside)
            yield as_sloped_interval(relative_excess(constraint, side, as_quotient(value), designs), like)
        for _, mean in size_dependent_mean_constraints(self.problem):
            yield enclose_mean_excess(self.problem, mean, box, inside, self.free)

    def _bound_size_or_motion_cost_and_change(
        self, objective: str, cost_sign: float, box: Designs, inside: Designs
    ) -> tuple[FloatArray, FloatArray]:
        """The least cost of an objective of sizes or the motion alone, and its relative change.

        A value that is equal for all designs has the digits of each design. Sums of sizes are exact; other
        arithmetic rounds.
        """
        sloped = quantities_over_box(
            self.problem, {objective}, designs_of_sloped_intervals(box, inside, self.free, 1)[0]
        )[objective]
        if not isinstance(sloped, SlopedInterval):
            cost = cost_sign * quantities_over_box(self.problem, {objective}, inside)[objective] + np.zeros(
                len(box)
            )
            return cost, np.zeros((len(self.free), len(box)))
        value = cost_sign * as_interval(quantities_over_box(self.problem, {objective}, box)[objective]) + np.zeros(
            len(box)
        )
        change = _relative_change_across_boxes(sloped.slopes, _box_widths(box, self.free), value.largest_magnitude)
        return value.low if require_effect(
            objective, self.problem.setup
        ).is_of_sizes else _lower_cost_by_rounding_error(value.low), change

    def _bound_curve_cost_and_change(
        self, objective: str, cost_sign: float, box: Designs, inside: Designs
    ) -> tuple[FloatArray, FloatArray]:
        """The least cost of an objective that is the peak or mean of curves, and its relative change."""
        form = peak_or_mean_bounding_cost(objective, cost_sign, self.problem.setup)
        if isinstance(form, Peak):
            return self._bound_peak_cost_and_change(form, cost_sign, box, inside)
        if form is None:
            # the motion and numbers decide the objective: its cost is known for boxes with one value of each number
            cost, spread = np.full(len(box), -np.inf), np.sign(self._relative_box_widths_of_numbers(box))
            single = np.flatnonzero(~spread.any(axis=0))
            cost[single] = (
                cost_sign * quantities_over_box(self.problem, {objective}, inside.take(single))[objective]
            )
            return cost, UNBOUNDED_SLOPE * spread
        sloped = form.mean_from_power_mean(enclose_mean_of_curve_power(self.problem, form, box, inside, self.free))
        cost = cost_sign * as_interval(form.scale.quantity_from_extreme(sloped.value, box))
        change = _relative_change_across_boxes(
            sloped.slopes, _box_widths(box, self.free), sloped.at.largest_magnitude
        )
        return _lower_cost_by_rounding_error(_nan_as_minus_infinity(cost.low)), change

    def _relative_box_widths_of_numbers(self, box: Designs) -> FloatArray:
        """Relative widths of boxes in numbers that are not sizes (free, n); slopes do not contain their scales."""
        numbers: Mapping[str, Any] = box.numbers
        widths = np.zeros((len(self.free), len(box)))
        for k, name in enumerate(self.free):
            if name in numbers:
                width, largest = numbers[name].high - numbers[name].low, numbers[name].largest_magnitude
                widths[k] = np.divide(width, largest, out=widths[k], where=width > 0.0)
        return widths

    def _bound_peak_cost_and_change(
        self, peak: Peak, cost_sign: float, box: Designs, inside: Designs
    ) -> tuple[FloatArray, FloatArray]:
        """The least cost of an objective that is an extreme of curves, and its relative change."""
        extreme = np.full(len(box), 0.0 if peak.goal == LARGEST_MAGNITUDE else -np.inf)
        change, farthest, width = np.zeros((len(self.free), len(box))), extreme, _box_widths(box, self.free)
        for curve, part in self._peak_curves_by_stroke_kind(peak):
            angle, _ = self._most_extreme_angles_and_signs(curve, [(part, peak.goal)], inside)
            value, _, like = self._enclose_curve_at_angles(curve, angle, box, inside)
            sloped = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, like)
            least, at = _extreme_bounds_over_box_and_at_point(peak.goal, sloped)
            size = np.maximum(np.abs(least), np.where(np.isfinite(at), np.abs(at), 0.0))
            # the largest error by which kernels may underestimate the extreme
            error = KERNEL_ERROR_FACTOR * self.problem.setup.relative_error * size
            error = error + KERNEL_ERROR_FACTOR**3 * (sloped.at.high - sloped.at.low)
            extreme = np.maximum(extreme, _nan_as_minus_infinity(least - error))
            change = np.where(
                at > farthest, _relative_change_across_boxes(sloped.slopes, width, np.abs(at)), change
            )
            farthest = np.fmax(farthest, at)
        signed = -extreme if peak.goal == LEAST else extreme
        cost = cost_sign * as_interval(peak.scale.quantity_from_extreme(as_interval(signed), box))
        low = np.where(np.isnan(cost.low) | np.isneginf(extreme), -np.inf, cost.low)
        return _lower_cost_by_rounding_error(low), change

    def _peak_curves_by_stroke_kind(self, peak: Peak) -> Iterator[tuple[Any, int]]:
        """The curves of a peak over rises, and over returns, with their kinds of stroke.

        Both are bounded separately, because the best design may be one whose rises and returns have equal peaks.
        """
        kind = self.problem.programme.table.kind
        for curve, kinds in peak.curves:
            parts = (kinds & (RISE | DWELL), kinds & RETURN) if kinds & ALL_STROKES else (kinds,)
            yield from ((motion_peak_as_curve(curve, part), part) for part in parts if np.any(kind & part))

    def _most_extreme_angles_and_signs(
        self, curve: Curve, goals_by_kind: list[tuple[int, int]], inside: Designs
    ) -> tuple[FloatArray, FloatArray]:
        """The cam angle at which a curve is the most extreme for one design of each box, and its side of 0.

        ``goals_by_kind`` has kinds of stroke, each with a goal.
        """
        coarse = max(self.problem.setup.relative_error, COARSE_SHARE)  # enough to find the cam angles
        problem, programme = self.problem.with_relative_error(coarse), self.problem.programme
        where = EvaluationBlock(problem.setup, programme, inside).extremes(curve, goals_by_kind).where
        angles = np.concatenate(
            [programme.one_sided_angles(at, kinds) for (kinds, _), at in zip(goals_by_kind, where, strict=True)]
        )
        value = curve_value(curve(inside, programme), ..., programme.state(angles))
        goals = np.repeat([goal for _, goal in goals_by_kind], 2)[:, None]
        sides = np.where(goals == LEAST, -1.0, 1.0)
        distance = _nan_as_minus_infinity(np.where(goals == LARGEST_MAGNITUDE, np.abs(value), sides * value))
        row = np.argmax(distance, axis=0)
        return angles[row, np.arange(row.size)], sides[row, 0]

    def _enclose_curve_at_angles(
        self, curve: Curve, angle: FloatArray, box: Designs, inside: Designs
    ) -> tuple[Number, Designs, SlopedInterval]:
        """A curve over boxes, each at its own cam angle, and the boxes as designs of sloped intervals."""
        designs, like = designs_of_sloped_intervals(box, inside, self.free, 1)
        state = state_enclosing_rounding(self.problem.programme.state(angle), self.problem.programme)
        return curve_value(curve(designs, self.problem.programme), ..., state), designs, like


def _least_size_or_motion_excesses(problem: Problem, limits: list[Limit], designs: Designs) -> FloatArray:
    """The least excess over each limit on sizes or the motion alone, (limits, designs)."""
    effects = {name: require_effect(name, problem.setup) for limit in limits for name in limit.required_quantities}
    names = {name for name, effect in effects.items() if can_effect_run_on_ranges(effect, problem.setup)}
    chosen = [limit for limit in limits if names.issuperset(limit.required_quantities)]
    columns = quantities_over_box(problem, names, designs, -1.0)
    rows = [as_interval(limit.excess(columns, designs)).low + np.zeros(len(designs)) for limit in chosen]
    return np.array(rows).reshape(len(rows), len(designs))


def _extreme_bounds_over_box_and_at_point(goal: int, enclosure: SlopedInterval) -> tuple[FloatArray, FloatArray]:
    """Lower bound of the extreme that a goal names, over each box and at its point; of its negative for LEAST."""
    if goal == LARGEST:
        return enclosure.value.low, enclosure.at.low
    if goal == LEAST:
        return -enclosure.value.high, -enclosure.at.high
    return np.maximum(enclosure.value.low, -enclosure.value.high), np.maximum(enclosure.at.low, -enclosure.at.high)


def _box_widths(box: Designs, free: list[str]) -> FloatArray:
    """The widths of boxes (free, n)."""
    values: dict[str, Any] = box.values
    return np.array([values[name].high - values[name].low for name in free]).reshape(len(free), len(box))


def _relative_change_across_boxes(slopes: Interval, width: FloatArray, scale: FloatArray) -> FloatArray:
    """Change of a quantity across each side of boxes, relative to the quantity."""
    has_scale = (scale > 0.0) & np.isfinite(scale)
    return _cap_infinite_slopes(slopes.largest_magnitude) * width / np.where(has_scale, scale, 1.0)


def _lower_cost_by_rounding_error(cost: FloatArray) -> FloatArray:
    return cost - BOUND_ERROR * np.where(np.isfinite(cost), np.abs(cost), 0.0)


def _nan_as_minus_infinity(lower_bounds: FloatArray) -> FloatArray:
    """Lower bounds, with −∞ for unknown ones."""
    return np.where(np.isnan(lower_bounds), -np.inf, lower_bounds)


def _cap_infinite_slopes(slopes: FloatArray) -> FloatArray:
    return np.where(np.isfinite(slopes), slopes, UNBOUNDED_SLOPE)

"""Lower bounds of the costs of boxes of designs, and whether all designs of a box break a limit.

A size, or what the motion decides, is known over a box by arithmetic on ranges. The largest value of a curve over
the turn is at least that at any one cam angle, and there the formula of the curve, on ranges with slopes, bounds it
for all designs of the box (``smallest.enclosure``); so does that of a limit its excess.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.sloped_interval import Quotient, SlopedInterval, as_quotient, as_sloped_interval
from camopt.model.effects import EvaluationBlock, Setup, find_effect, require_effect
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import Peak
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.solve.smallest.enclosure import (
    constraint_on_designs,
    curve_of_designs,
    mean_constraints_on_size,
    present_constraints,
    representative_designs,
    state_with_rounding,
)
from camopt.solve.smallest.excesses import EXCESS_ROUNDING, UNBOUNDED_SLOPE
from camopt.solve.verdicts.box_quantities import quantities_over_box, runs_on_ranges
from camopt.solve.verdicts.constraint_boxes import excess_of
from camopt.solve.verdicts.mean_boxes import mean_excess, mean_power_over
from camopt.solve.verdicts.sloped_designs import sloped_boxes

COARSE_SHARE = (
    1e-4  # of the cam angles at which curves are evaluated: any would do, those of extremes tell the most
)
BOUND_ERROR = 1e-12  # relative, of a quantity from the extreme or the sizes that decide it
KERNEL_ERROR_FACTOR = 4.0  # the relative error asked, and the rounding at a point, by which kernels may be off


def bounding_form(name: str, sign: float, setup: Setup) -> Peak | Mean | None:
    """What bounds an objective from its better side over boxes; ``sign`` is −1 if it is maximised."""
    effect = require_effect(name, setup)
    known = effect.peaks(setup).get(name) or effect.means(setup).get(name)
    return known if known is not None and known.is_least == (sign < 0.0) else None


def is_bounded(name: str, sign: float, setup: Setup) -> bool:
    """Whether boxes of designs bound an objective from its better side, at least those of one setting."""
    effect = find_effect(name, setup)
    if effect is None or effect.is_of_sizes or effect.is_of_motion(setup):
        return effect is not None
    return bounding_form(name, sign, setup) is not None


def are_all_bounded(problem: Problem) -> bool:
    """Whether boxes of designs bound all objectives from their better sides."""
    return all(is_bounded(name, sign, problem.setup) for name, sign in problem.objectives.items())


def is_motion_infeasible(problem: Problem) -> bool:
    """Whether no design of a motion meets the limits, whatever its sizes."""
    if any(limit.is_infinite_on_motion(problem.programme) for limit in problem.limits):
        return True
    of_motion = [limit for limit in problem.limits if limit.is_of_motion]
    return bool(np.any(_excess_by_arithmetic(problem, of_motion, problem.design) > 0.0))


class BoxCosts(NamedTuple):
    """The bounds of n boxes of designs of one motion."""

    costs: FloatArray
    """What their designs cost at least (n, objectives)."""
    change: FloatArray
    """How much that changes across each free field, relative (free, n)."""
    inside: Designs
    """A design of each that can be assembled."""
    exists: Any
    """Whether one is found (n,)."""

    def take(self, index: Any) -> "BoxCosts":
        """What is known of the boxes at an index or mask."""
        return BoxCosts(self.costs[index], self.change[:, index], self.inside.take(index), self.exists[index])


class BoxBounds(NamedTuple):
    """Boxes of designs of one motion, asked for bounds; ``free`` are the fields that have a range."""

    problem: Problem
    free: list[str]

    @property
    def curve_constraints(self) -> list[Constraint]:
        """The constraints of limits on curves, without those that the motion decides."""
        on_size = tuple(limit for limit in self.problem.limits if not limit.is_of_motion)
        return present_constraints(
            self.problem,
            [
                constraint_on_designs(constraint)
                for constraint in strictest_constraints(replace(self.problem, limits=on_size).constraints)
            ],
        )

    @np.errstate(all="ignore")
    def impossible_boxes(self, box: Designs) -> Any:
        """Which boxes hold no design that can be assembled, or only such as break a limit on sizes (n,)."""
        limits = [each for each in self.problem.limits if not each.constraints and not each.is_of_motion]
        over = _excess_by_arithmetic(self.problem, limits, box)
        return self.problem.setup.mechanism.cannot_assemble(box, self.problem.programme) | np.any(
            over > 0.0, axis=0
        )

    @np.errstate(all="ignore")
    def bound_costs(self, box: Designs) -> BoxCosts:
        """The bounds of objectives."""
        inside, exists = representative_designs(self.problem, box, self.free, np.ones(len(box), dtype=bool))
        asked, setup = self.problem.objectives, self.problem.setup
        costs, change = np.full((len(box), len(asked)), -np.inf), np.zeros((len(self.free), len(box)))
        index = np.flatnonzero(exists)
        some, middle = box.take(index), inside.take(index)
        for k, (name, sign) in enumerate(asked.items()):
            if runs_on_ranges(require_effect(name, setup), setup):
                costs[:, k], moved = self._cost_by_arithmetic(name, sign, box, inside)
                change = np.maximum(change, moved)
            elif index.size:
                costs[index, k], moved = self._cost_by_form(name, sign, some, middle)
                change[:, index] = np.maximum(change[:, index], moved)
        return BoxCosts(costs, np.maximum(change, self._number_widths(box)), inside, exists)

    @np.errstate(all="ignore")
    def broken_boxes(self, box: Designs, looked: BoxCosts) -> tuple[Any, FloatArray]:
        """Which boxes hold only designs that break a limit (n,).

        And how much the excesses over limits that some designs may break change across each free size (free, n).
        """
        broken, change = np.zeros(len(box), dtype=bool), np.zeros((len(self.free), len(box)))
        index = np.flatnonzero(looked.exists)
        if not index.size:
            return broken, change
        some, inside = box.take(index), looked.inside.take(index)
        width = _box_widths(some, self.free)
        for over in self._limit_excesses(some, inside):
            moved = _finite_slopes(over.slopes.largest_magnitude) * width
            broken[index] |= over.value.low > EXCESS_ROUNDING
            change[:, index] = np.maximum(change[:, index], np.where(over.value.high > 0.0, moved, 0.0))
        return broken, change

    def _limit_excesses(self, box: Designs, inside: Designs) -> Iterator[SlopedInterval]:
        """The excesses of boxes over limits on curves, where one design exceeds them the most, and on means."""
        for constraint in self.curve_constraints:
            asked = [(constraint.kinds, LARGEST if side > 0.0 else LEAST) for side in constraint.sides]
            angle, side = self._worst_angle(constraint.curve, asked, inside)
            value, designs, like = self._curve_over_boxes(constraint.curve, angle, box, inside)
            yield as_sloped_interval(excess_of(constraint, side, as_quotient(value), designs), like)
        for _, mean in mean_constraints_on_size(self.problem):
            yield mean_excess(self.problem, mean, box, inside, self.free)

    def _cost_by_arithmetic(self, name: str, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that sizes or the motion decide, and its relative change.

        What is the same for all designs has the digits of each, and sums of sizes are exact; other arithmetic
        rounds.
        """
        sloped = quantities_over_box(self.problem, {name}, sloped_boxes(box, inside, self.free, 1)[0])[name]
        if not isinstance(sloped, SlopedInterval):
            same = sign * quantities_over_box(self.problem, {name}, inside)[name] + np.zeros(len(box))
            return same, np.zeros((len(self.free), len(box)))
        value = sign * as_interval(quantities_over_box(self.problem, {name}, box)[name]) + np.zeros(len(box))
        change = _relative_change(sloped.slopes, _box_widths(box, self.free), value.largest_magnitude)
        return value.low if require_effect(name, self.problem.setup).is_of_sizes else _lower_by_rounding(
            value.low
        ), change

    def _cost_by_form(self, name: str, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that a curve decides, and its relative change."""
        known = bounding_form(name, sign, self.problem.setup)
        if isinstance(known, Peak):
            return self._cost_by_extreme(known, sign, box, inside)
        if known is None:
            # the cost of an objective that the motion and numbers decide, of boxes that have one value of each
            cost, spread = np.full(len(box), -np.inf), np.sign(self._number_widths(box))
            one = np.flatnonzero(~spread.any(axis=0))
            cost[one] = sign * quantities_over_box(self.problem, {name}, inside.take(one))[name]
            return cost, UNBOUNDED_SLOPE * spread
        return self._cost_by_mean(known, sign, box, inside)

    def _number_widths(self, box: Designs) -> FloatArray:
        """How wide boxes are in numbers that are no sizes, relative: what scales change by them no slope tells."""
        numbers: Mapping[str, Any] = box.numbers
        wide = np.zeros((len(self.free), len(box)))
        for k, name in enumerate(self.free):
            if name in numbers:
                width, largest = numbers[name].high - numbers[name].low, numbers[name].largest_magnitude
                wide[k] = np.divide(width, largest, out=wide[k], where=width > 0.0)
        return wide

    def _cost_by_extreme(self, known: Peak, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that curves decide, and its relative change."""
        extreme = np.full(len(box), 0.0 if known.goal == LARGEST_MAGNITUDE else -np.inf)
        change, farthest, width = np.zeros((len(self.free), len(box))), extreme, _box_widths(box, self.free)
        for make, part in self._curves_by_stroke(known):
            angle, _ = self._worst_angle(make, [(part, known.goal)], inside)
            value, _, like = self._curve_over_boxes(make, angle, box, inside)
            made = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, like)
            least, at = _extreme_of_boxes(known.goal, made)
            extreme = np.maximum(extreme, _fill_unknown(least - self._kernel_error(made, least, at)))
            change = np.where(at > farthest, _relative_change(made.slopes, width, np.abs(at)), change)
            farthest = np.fmax(farthest, at)
        turned = -extreme if known.goal == LEAST else extreme
        cost = sign * as_interval(known.scale.quantity(as_interval(turned), box))
        low = np.where(np.isnan(cost.low) | np.isneginf(extreme), -np.inf, cost.low)
        return _lower_by_rounding(low), change

    def _cost_by_mean(self, mean: Mean, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that a mean decides, and its relative change."""
        made = mean.value_of_mean(mean_power_over(self.problem, mean, box, inside, self.free))
        cost = sign * as_interval(mean.scale.quantity(made.value, box))
        low = np.where(np.isnan(cost.low), -np.inf, cost.low)
        return _lower_by_rounding(low), _relative_change(
            made.slopes, _box_widths(box, self.free), made.at.largest_magnitude
        )

    def _kernel_error(self, value: SlopedInterval, least: FloatArray, at: FloatArray) -> FloatArray:
        """The largest error by which kernels may underestimate an extreme."""
        size = np.maximum(np.abs(least), np.where(np.isfinite(at), np.abs(at), 0.0))
        return KERNEL_ERROR_FACTOR * self.problem.setup.relative_error * size + KERNEL_ERROR_FACTOR**3 * (
            value.at.high - value.at.low
        )

    def _curves_by_stroke(self, known: Peak) -> Iterator[tuple[Any, int]]:
        """The curves that decide a quantity, over rises and returns apart.

        That tells more than the extreme over both: the best design may lie where they are alike.
        """
        kind = self.problem.programme.table.kind
        for make, kinds in known.curves:
            parts = (kinds & (RISE | DWELL), kinds & RETURN) if kinds & ALL_STROKES else (kinds,)
            yield from ((curve_of_designs(make, part), part) for part in parts if np.any(kind & part))

    def _worst_angle(
        self, make: Any, asked: list[tuple[int, int]], inside: Designs
    ) -> tuple[FloatArray, FloatArray]:
        """The cam angle at which a curve is the most extreme for one design of each box, and on which side of 0.

        What is asked are kinds of stroke, each with a goal.
        """
        problem, programme = with_coarse_error(self.problem), self.problem.programme
        where = EvaluationBlock(problem.setup, programme, inside).extremes(make, asked).where
        angles = np.concatenate(
            [programme.one_sided_angles(at, kinds) for (kinds, _), at in zip(asked, where, strict=True)]
        )
        value = value_of(make(inside, programme), ..., programme.state(angles))
        goals = np.repeat([goal for _, goal in asked], 2)[:, None]
        sides = np.where(goals == LEAST, -1.0, 1.0)
        far = _fill_unknown(np.where(goals == LARGEST_MAGNITUDE, np.abs(value), sides * value))
        row = np.argmax(far, axis=0)
        return angles[row, np.arange(row.size)], sides[row, 0]

    def _curve_over_boxes(
        self, make: Any, angle: FloatArray, box: Designs, inside: Designs
    ) -> tuple[Any, Designs, SlopedInterval]:
        """A curve over boxes, each at a cam angle of its own; and the boxes as designs of ranges with slopes."""
        designs, like = sloped_boxes(box, inside, self.free, 1)
        state = state_with_rounding(self.problem.programme.state(angle), self.problem.programme)
        return value_of(make(designs, self.problem.programme), ..., state), designs, like


def with_coarse_error(problem: Problem) -> Problem:
    """The problem where extremes need no digits."""
    return problem.with_relative_error(max(problem.setup.relative_error, COARSE_SHARE))


def _excess_by_arithmetic(problem: Problem, limits: list[Limit], designs: Designs) -> FloatArray:
    """The least excess over each of those limits that sizes or the motion decide, (limits, designs)."""
    effects = {name: require_effect(name, problem.setup) for limit in limits for name in limit.required_quantities}
    known = {name for name, effect in effects.items() if runs_on_ranges(effect, problem.setup)}
    chosen = [limit for limit in limits if known.issuperset(limit.required_quantities)]
    columns = quantities_over_box(problem, known, designs, -1.0)
    rows = [as_interval(limit.excess(columns, designs)).low + np.zeros(len(designs)) for limit in chosen]
    return np.array(rows).reshape(len(rows), len(designs))


def _extreme_of_boxes(goal: int, value: SlopedInterval) -> tuple[FloatArray, FloatArray]:
    """The least value of curves, or minus the largest, over each box and at its point."""
    if goal == LARGEST:
        return value.value.low, value.at.low
    if goal == LEAST:
        return -value.value.high, -value.at.high
    return np.maximum(value.value.low, -value.value.high), np.maximum(value.at.low, -value.at.high)


def _box_widths(box: Designs, free: list[str]) -> FloatArray:
    """How wide boxes are, (free, n)."""
    values: dict[str, Any] = box.values
    return np.array([values[name].high - values[name].low for name in free]).reshape(len(free), len(box))


def _relative_change(slopes: Interval, width: FloatArray, scale: FloatArray) -> FloatArray:
    """The change of a quantity across each side of boxes, relative to the quantity."""
    known = (scale > 0.0) & np.isfinite(scale)
    return _finite_slopes(slopes.largest_magnitude) * width / np.where(known, scale, 1.0)


def _lower_by_rounding(cost: FloatArray) -> FloatArray:
    """Costs less their rounding."""
    return cost - BOUND_ERROR * np.where(np.isfinite(cost), np.abs(cost), 0.0)


def _fill_unknown(least: FloatArray) -> FloatArray:
    """The lower bounds of values; −∞ for unknown ones."""
    return np.where(np.isnan(least), -np.inf, least)


def _finite_slopes(slopes: FloatArray) -> FloatArray:
    return np.where(np.isfinite(slopes), slopes, UNBOUNDED_SLOPE)

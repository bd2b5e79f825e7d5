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
from camopt.core.numerics.sloped import Quotient, Sloped, as_quotient, as_sloped
from camopt.model.effects import Case, Setup, effect_of, find_effect
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import Peak
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE
from camopt.scene.problem.claims import Claim
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, strictest
from camopt.solve.smallest.enclosure import (
    curve_of_designs,
    means_on_size,
    of_designs,
    present_claims,
    representatives,
    rounded,
)
from camopt.solve.smallest.excesses import EXCESS_ROUNDING, HUGE_SLOPE
from camopt.solve.verdicts.claim_boxes import excess_of
from camopt.solve.verdicts.mean_boxes import mean_excess, powers_over
from camopt.solve.verdicts.ranges import is_ranged, ranged
from camopt.solve.verdicts.sloped_designs import sloped_boxes

COARSE_SHARE = (
    1e-4  # of the cam angles at which curves are evaluated: any would do, those of extremes tell the most
)
BOUND_ERROR = 1e-12  # relative, of a quantity from the extreme or the sizes that decide it
TIMES = 4.0  # the relative error asked, and the rounding at a point, by which kernels may be off


def form_of(name: str, sign: float, setup: Setup) -> Peak | Mean | None:
    """What bounds an objective from its better side over boxes; ``sign`` is −1 if it is maximised."""
    effect = effect_of(name, setup)
    known = effect.peaks(setup).get(name) or effect.means(setup).get(name)
    return known if known is not None and known.is_least == (sign < 0.0) else None


def is_bounded(name: str, sign: float, setup: Setup) -> bool:
    """Whether boxes of designs bound an objective from its better side, at least those of one setting."""
    effect = find_effect(name, setup)
    if effect is None or effect.is_of_sizes or effect.is_of_motion(setup):
        return effect is not None
    return form_of(name, sign, setup) is not None


def all_bounded(problem: Problem) -> bool:
    """Whether boxes of designs bound all objectives from their better sides."""
    return all(is_bounded(name, sign, problem.setup) for name, sign in problem.objectives.items())


def is_hopeless(problem: Problem) -> bool:
    """Whether no design of a motion meets the limits, whatever its sizes."""
    if any(limit.infinite_at(problem.programme) for limit in problem.limits):
        return True
    of_motion = [limit for limit in problem.limits if limit.is_of_motion]
    return bool(np.any(_by_arithmetic(problem, of_motion, problem.design) > 0.0))


class Looked(NamedTuple):
    """The bounds of n boxes of designs of one motion."""

    costs: FloatArray
    """What their designs cost at least (n, objectives)."""
    change: FloatArray
    """How much that changes across each free field, relative (free, n)."""
    inside: Designs
    """A design of each that can be assembled."""
    exists: Any
    """Whether one is found (n,)."""

    def take(self, index: Any) -> "Looked":
        """What is known of the boxes at an index or mask."""
        return Looked(self.costs[index], self.change[:, index], self.inside.take(index), self.exists[index])


class BoxBounds(NamedTuple):
    """Boxes of designs of one motion, asked for bounds; ``free`` are the fields that have a range."""

    problem: Problem
    free: list[str]

    @property
    def claims(self) -> list[Claim]:
        """The claims of limits on curves, without those that the motion decides."""
        on_size = tuple(limit for limit in self.problem.limits if not limit.is_of_motion)
        return present_claims(
            self.problem, [of_designs(claim) for claim in strictest(replace(self.problem, limits=on_size).claims)]
        )

    @np.errstate(all="ignore")
    def impossible(self, box: Designs) -> Any:
        """Which boxes hold no design that can be assembled, or only such as break a limit on sizes (n,)."""
        limits = [each for each in self.problem.limits if not each.claims and not each.is_of_motion]
        over = _by_arithmetic(self.problem, limits, box)
        return self.problem.setup.mechanism.impossible(box, self.problem.programme) | np.any(over > 0.0, axis=0)

    @np.errstate(all="ignore")
    def look(self, box: Designs) -> Looked:
        """The bounds of objectives."""
        inside, exists = representatives(self.problem, box, self.free, np.ones(len(box), dtype=bool))
        asked, setup = self.problem.objectives, self.problem.setup
        costs, change = np.full((len(box), len(asked)), -np.inf), np.zeros((len(self.free), len(box)))
        index = np.flatnonzero(exists)
        some, middle = box.take(index), inside.take(index)
        for k, (name, sign) in enumerate(asked.items()):
            if is_ranged(effect_of(name, setup), setup):
                costs[:, k], moved = self._by_arithmetic(name, sign, box, inside)
                change = np.maximum(change, moved)
            elif index.size:
                costs[index, k], moved = self._by_form(name, sign, some, middle)
                change[:, index] = np.maximum(change[:, index], moved)
        return Looked(costs, np.maximum(change, self._of_numbers(box)), inside, exists)

    @np.errstate(all="ignore")
    def broken(self, box: Designs, looked: Looked) -> tuple[Any, FloatArray]:
        """Which boxes hold only designs that break a limit (n,).

        And how much the excesses over limits that some designs may break change across each free size (free, n).
        """
        broken, change = np.zeros(len(box), dtype=bool), np.zeros((len(self.free), len(box)))
        index = np.flatnonzero(looked.exists)
        if not index.size:
            return broken, change
        some, inside = box.take(index), looked.inside.take(index)
        width = _widths(some, self.free)
        for over in self._excesses(some, inside):
            moved = _finite(over.slopes.largest_magnitude) * width
            broken[index] |= over.value.low > EXCESS_ROUNDING
            change[:, index] = np.maximum(change[:, index], np.where(over.value.high > 0.0, moved, 0.0))
        return broken, change

    def _excesses(self, box: Designs, inside: Designs) -> Iterator[Sloped]:
        """The excesses of boxes over limits on curves, where one design exceeds them the most, and on means."""
        for claim in self.claims:
            asked = [(claim.kinds, LARGEST if side > 0.0 else LEAST) for side in claim.sides]
            angle, side = self._worst(claim.curve, asked, inside)
            value, designs, like = self._over(claim.curve, angle, box, inside)
            yield as_sloped(excess_of(claim, side, as_quotient(value), designs), like)
        for _, mean in means_on_size(self.problem):
            yield mean_excess(self.problem, mean, box, inside, self.free)

    def _by_arithmetic(self, name: str, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that sizes or the motion decide, and its relative change.

        What is the same for all designs has the digits of each, and sums of sizes are exact; other arithmetic
        rounds.
        """
        sloped = ranged(self.problem, {name}, sloped_boxes(box, inside, self.free, 1)[0])[name]
        if not isinstance(sloped, Sloped):
            same = sign * ranged(self.problem, {name}, inside)[name] + np.zeros(len(box))
            return same, np.zeros((len(self.free), len(box)))
        value = sign * as_interval(ranged(self.problem, {name}, box)[name]) + np.zeros(len(box))
        change = _relative(sloped.slopes, _widths(box, self.free), value.largest_magnitude)
        return value.low if effect_of(name, self.problem.setup).is_of_sizes else _lowered(value.low), change

    def _by_form(self, name: str, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that a curve decides, and its relative change."""
        known = form_of(name, sign, self.problem.setup)
        if isinstance(known, Peak):
            return self._by_extreme(known, sign, box, inside)
        if known is None:
            # the cost of an objective that the motion and numbers decide, of boxes that have one value of each
            cost, spread = np.full(len(box), -np.inf), np.sign(self._of_numbers(box))
            one = np.flatnonzero(~spread.any(axis=0))
            cost[one] = sign * ranged(self.problem, {name}, inside.take(one))[name]
            return cost, HUGE_SLOPE * spread
        return self._by_mean(known, sign, box, inside)

    def _of_numbers(self, box: Designs) -> FloatArray:
        """How wide boxes are in numbers that are no sizes, relative: what scales change by them no slope tells."""
        numbers: Mapping[str, Any] = box.numbers
        wide = np.zeros((len(self.free), len(box)))
        for k, name in enumerate(self.free):
            if name in numbers:
                width, largest = numbers[name].high - numbers[name].low, numbers[name].largest_magnitude
                wide[k] = np.divide(width, largest, out=wide[k], where=width > 0.0)
        return wide

    def _by_extreme(self, known: Peak, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that curves decide, and its relative change."""
        extreme = np.full(len(box), 0.0 if known.goal == LARGEST_MAGNITUDE else -np.inf)
        change, farthest, width = np.zeros((len(self.free), len(box))), extreme, _widths(box, self.free)
        for make, part in self._parts(known):
            angle, _ = self._worst(make, [(part, known.goal)], inside)
            value, _, like = self._over(make, angle, box, inside)
            made = value.divided() if isinstance(value, Quotient) else as_sloped(value, like)
            least, at = _side(known.goal, made)
            extreme = np.maximum(extreme, _known(least - self._room(made, least, at)))
            change = np.where(at > farthest, _relative(made.slopes, width, np.abs(at)), change)
            farthest = np.fmax(farthest, at)
        turned = -extreme if known.goal == LEAST else extreme
        cost = sign * as_interval(known.scale.quantity(as_interval(turned), box))
        low = np.where(np.isnan(cost.low) | np.isneginf(extreme), -np.inf, cost.low)
        return _lowered(low), change

    def _by_mean(self, mean: Mean, sign: float, box: Designs, inside: Designs) -> tuple[Any, FloatArray]:
        """The least cost of an objective that a mean decides, and its relative change."""
        made = mean.of_powers(powers_over(self.problem, mean, box, inside, self.free))
        cost = sign * as_interval(mean.scale.quantity(made.value, box))
        low = np.where(np.isnan(cost.low), -np.inf, cost.low)
        return _lowered(low), _relative(made.slopes, _widths(box, self.free), made.at.largest_magnitude)

    def _room(self, value: Sloped, least: FloatArray, at: FloatArray) -> FloatArray:
        """The largest error by which kernels may underestimate an extreme."""
        size = np.maximum(np.abs(least), np.where(np.isfinite(at), np.abs(at), 0.0))
        return TIMES * self.problem.setup.relative_error * size + TIMES**3 * (value.at.high - value.at.low)

    def _parts(self, known: Peak) -> Iterator[tuple[Any, int]]:
        """The curves that decide a quantity, over rises and returns apart.

        That tells more than the extreme over both: the best design may lie where they are alike.
        """
        kind = self.problem.programme.table.kind
        for make, kinds in known.curves:
            parts = (kinds & (RISE | DWELL), kinds & RETURN) if kinds & ALL_STROKES else (kinds,)
            yield from ((curve_of_designs(make, part), part) for part in parts if np.any(kind & part))

    def _worst(self, make: Any, asked: list[tuple[int, int]], inside: Designs) -> tuple[FloatArray, FloatArray]:
        """The cam angle at which a curve is the most extreme for one design of each box, and on which side of 0.

        What is asked are kinds of stroke, each with a goal.
        """
        problem, programme = coarse(self.problem), self.problem.programme
        where = Case(problem.setup, programme, inside).extremes(make, asked).where
        angles = np.concatenate(
            [programme.one_sided(at, kinds) for (kinds, _), at in zip(asked, where, strict=True)]
        )
        value = value_of(make(inside, programme), ..., programme.state(angles))
        goals = np.repeat([goal for _, goal in asked], 2)[:, None]
        sides = np.where(goals == LEAST, -1.0, 1.0)
        far = _known(np.where(goals == LARGEST_MAGNITUDE, np.abs(value), sides * value))
        row = np.argmax(far, axis=0)
        return angles[row, np.arange(row.size)], sides[row, 0]

    def _over(self, make: Any, angle: FloatArray, box: Designs, inside: Designs) -> tuple[Any, Designs, Sloped]:
        """A curve over boxes, each at a cam angle of its own; and the boxes as designs of ranges with slopes."""
        designs, like = sloped_boxes(box, inside, self.free, 1)
        state = rounded(self.problem.programme.state(angle), self.problem.programme)
        return value_of(make(designs, self.problem.programme), ..., state), designs, like


def coarse(problem: Problem) -> Problem:
    """The problem where extremes need no digits."""
    return problem.to_error(max(problem.setup.relative_error, COARSE_SHARE))


def _by_arithmetic(problem: Problem, limits: list[Limit], designs: Designs) -> FloatArray:
    """The least excess over each of those limits that sizes or the motion decide, (limits, designs)."""
    effects = {name: effect_of(name, problem.setup) for limit in limits for name in limit.needs}
    known = {name for name, effect in effects.items() if is_ranged(effect, problem.setup)}
    chosen = [limit for limit in limits if known.issuperset(limit.needs)]
    columns = ranged(problem, known, designs, -1.0)
    rows = [as_interval(limit.excess(columns, designs)).low + np.zeros(len(designs)) for limit in chosen]
    return np.array(rows).reshape(len(rows), len(designs))


def _side(goal: int, value: Sloped) -> tuple[FloatArray, FloatArray]:
    """The least value of curves, or minus the largest, over each box and at its point."""
    if goal == LARGEST:
        return value.value.low, value.at.low
    if goal == LEAST:
        return -value.value.high, -value.at.high
    return np.maximum(value.value.low, -value.value.high), np.maximum(value.at.low, -value.at.high)


def _widths(box: Designs, free: list[str]) -> FloatArray:
    """How wide boxes are, (free, n)."""
    values: dict[str, Any] = box.values
    return np.array([values[name].high - values[name].low for name in free]).reshape(len(free), len(box))


def _relative(slopes: Interval, width: FloatArray, scale: FloatArray) -> FloatArray:
    """The change of a quantity across each side of boxes, relative to the quantity."""
    known = (scale > 0.0) & np.isfinite(scale)
    return _finite(slopes.largest_magnitude) * width / np.where(known, scale, 1.0)


def _lowered(cost: FloatArray) -> FloatArray:
    """Costs less their rounding."""
    return cost - BOUND_ERROR * np.where(np.isfinite(cost), np.abs(cost), 0.0)


def _known(least: FloatArray) -> FloatArray:
    """The lower bounds of values; −∞ for unknown ones."""
    return np.where(np.isnan(least), -np.inf, least)


def _finite(slopes: FloatArray) -> FloatArray:
    return np.where(np.isfinite(slopes), slopes, HUGE_SLOPE)

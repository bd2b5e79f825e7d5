"""Decide whether all designs of a box hold a constraint at every cam angle, by bisection of the box and the turn.

The cam angle is one more variable of the box. Over a part of a panel, the motion is a range, and its slopes by the
cam angle are its derivatives. The formula of a constraint on ranges with slopes (``numerics.sloped_interval``)
bounds its excess over the part. A part that holds the constraint is dropped. A point that breaks it is a witness.
Any other part is cut across the variable that changes the excess the most. If the excess rises or falls with a
variable all over a part, only that end of the variable is kept.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11 (monotonicity test).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IntArray, Number
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.load_tables import LoadTable, TrainLoadTable
from camopt.core.numerics.motion_ranges import derivative_intervals_over_parts, slopes_of_function_of_angle
from camopt.core.numerics.piecewise import MotionTable
from camopt.core.numerics.sloped_interval import (
    Quotient,
    SlopedInterval,
    as_quotient,
    as_sloped_interval,
    box_variables,
    value_at_box_point,
)
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.effects.peak import MotionDerivative, NumberKind
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import AnyConstraint, Constraint, TurnMeanConstraint
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.arcs import scaled_curvature_excesses_on_arcs
from camopt.solve.verdicts.mean_boxes import enclose_mean_excess, mean_verdict_of_design
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, WORST_FIRST

CONSTRAINT_PARTS_AT_ONCE, MOST_ROUNDS = 256, 100
"""Most parts that are cut at once, and most rounds."""
CONSTRAINT_PART_CUTS = 8
"""Pieces into which a part is cut."""
MEANS_AT_ONCE, MEAN_ROUNDS = 8, 3
"""The same for means, whose parts are whole turns."""
ROUND_PARTS, PART_WORK = 100, 60.0  # work of a part, and how many parts a round takes in addition
LEAST_PART_SHARE = 2.0**-45
"""Share of a panel, or of the box, below which a part is not cut."""
LARGEST_SLOPE = 1e300
"""In place of an infinite slope."""
NumberRanges = Mapping[str, tuple[float, float]]
"""Ranges of sizes by field of ``Designs``; other sizes are those of a design."""


def _interval_of_one_pair(low: float, high: float) -> Interval:
    return Interval(np.array([low]), np.array([high]))


INTERVAL_NUMBERS = NumberKind(
    lambda number: _interval_of_one_pair(number, number),
    lambda: _interval_of_one_pair(np.pi, np.nextafter(np.pi, 4.0)),
    lambda angle: np.sin(angle) / np.cos(angle),
)
"""Intervals as the number type of bounds."""


def relative_excess(constraint: Constraint, side: FloatArray, curve: Quotient, designs: Designs) -> Number:
    """Excess over a side of a constraint, relative to its terms; above 0 the constraint is broken."""
    ranged, bound = isinstance(curve.above, (Interval, SlopedInterval)), constraint.upper_bound_of_each_side()
    value = side * curve.above * constraint.factor(designs)
    allowed = (constraint.upper_bound_of_each_side(INTERVAL_NUMBERS) if ranged else bound) * curve.below
    scale = sum(value_at_box_point(x).least_magnitude for x in (value, allowed))  # the largest may be infinite
    return (value - allowed) / (scale if bound else scale + value_at_box_point(constraint.unit(designs)).high)


class BoxVerdict(NamedTuple):
    """Verdict on a constraint for all designs of a box, and a design that breaks it, if one is known."""

    verdict: str
    witness: Designs | None = None


def verdict_on_alternatives(
    decide: Callable[[Any, NumberRanges], BoxVerdict], constraints: Sequence[Any], number_ranges: NumberRanges
) -> BoxVerdict:
    """Verdict on a condition for all designs of a box: each has to hold one of some constraints.

    ``decide`` decides a constraint over ranges. If all constraints are broken over ranges, perhaps by different
    designs, the witness against the first has to break the others too.
    """
    verdicts = [decide(constraint, number_ranges) for constraint in constraints]
    best = max(verdicts, key=lambda each: WORST_FIRST.index(each.verdict))
    if best.witness is None or not number_ranges or len(constraints) == 1:
        return best
    at_witness = {name: 2 * (float(best.witness.values[name][0]),) for name in number_ranges}
    broken = all(decide(constraint, at_witness).verdict == BROKEN for constraint in constraints)
    return best if broken else BoxVerdict(UNDECIDED)


def constraint_verdict_over_box(
    problem: Problem,
    constraint: AnyConstraint,
    design: Designs,
    number_ranges: NumberRanges,
    budget: Budget = UNLIMITED,
    enclosures: "CurveEnclosures | None" = None,
) -> BoxVerdict:
    """Verdict on a constraint for all designs whose sizes lie between ``number_ranges``.

    It is undecided if the budget is spent, and if a design of the box may fail to assemble. ``enclosures`` keeps
    the enclosures of curves for other bounds of the same design.
    """
    if not problem.programme.has_kinds(constraint.kinds):
        return BoxVerdict(HELD)
    mechanism = problem.setup.mechanism
    if (
        not number_ranges
        and problem.profile
        and isinstance(constraint, Constraint)
        and constraint.curve in (mechanism.curvature, mechanism.profile_radius)
    ):
        excesses = scaled_curvature_excesses_on_arcs(problem, constraint, design)
        return BoxVerdict(BROKEN if any(excess > 0 for excess in excesses) else HELD)
    box = design.with_values({name: _interval_of_one_pair(*limits) for name, limits in number_ranges.items()})
    for margin in mechanism.assembly_margins(box, problem.programme):
        if not np.all(as_interval(margin).low > 0.0):
            return BoxVerdict(UNDECIDED)
    if isinstance(constraint, TurnMeanConstraint):
        if not number_ranges:
            return BoxVerdict(mean_verdict_of_design(problem, constraint, design))
        return MeanConstraintSearch(problem, constraint, design, tuple(number_ranges), budget).search_for_violation(
            whole_turn_parts(constraint, number_ranges)
        )
    if isinstance(constraint.curve, MotionDerivative):
        return BoxVerdict(UNDECIDED)
    search = ConstraintSearch(problem, constraint, design, tuple(number_ranges), budget, enclosures)
    panels = np.flatnonzero(problem.programme.panels_with_kinds(constraint.kinds))
    return search.search_for_violation(BoxParts.from_panels(panels, constraint, number_ranges))


@dataclass(frozen=True)
class BoxParts:
    """Parts of panels combined with parts of the box."""

    panel: IntArray
    side: FloatArray
    """Side of the constraint."""
    low: FloatArray
    """Lower ends (1 + sizes, parts): of the place on the panel, from −1 to 1, and of each size."""
    high: FloatArray
    whole: FloatArray
    """Widths of the panel and of the box (1 + sizes, 1); 1 in place of 0."""

    @classmethod
    def from_panels(cls, panels: IntArray, constraint: AnyConstraint, number_ranges: NumberRanges) -> "BoxParts":
        """Some whole panels with the whole box, for each side of a constraint."""
        panel, side = (grid.ravel() for grid in np.meshgrid(panels, np.array(constraint.side_signs), indexing="ij"))
        low, high = np.array([(-1.0, 1.0), *number_ranges.values()]).T[..., None]
        every = np.ones(panel.size)
        return cls(panel, side, low * every, high * every, np.where(high > low, high - low, 1.0))

    @property
    def size(self) -> int:
        return self.panel.size

    def take(self, index: Any) -> "BoxParts":
        return replace(
            self, panel=self.panel[index], side=self.side[index], low=self.low[:, index], high=self.high[:, index]
        )

    def split_at_panel_place(self, panel_place: FloatArray) -> "BoxParts":
        """Cut the parts in two that have their ``panel_place`` on the panel inside."""
        inside = (self.low[0] < panel_place) & (panel_place < self.high[0])
        before, after = np.where(inside, panel_place, self.high[0]), panel_place[inside]
        low, high = np.hstack([self.low, self.low[:, inside]]), np.hstack([self.high, self.high[:, inside]])
        low[0, self.size :], high[0, : self.size] = after, before
        panel, side = (np.concatenate([column, column[inside]]) for column in (self.panel, self.side))
        return replace(self, panel=panel, side=side, low=low, high=high)

    def reduce_monotone_variables_to_ends(self, slopes: Interval) -> "BoxParts":
        """Reduce each variable with which the excess is monotone to the end with the larger excess."""
        rises, falls = slopes.low >= 0.0, slopes.high <= 0.0
        return replace(
            self, low=np.where(rises, self.high, self.low), high=np.where(falls & ~rises, self.low, self.high)
        )

    def cut_across_steepest_variable(self, slope_magnitudes: FloatArray) -> "BoxParts":
        """Cut each part across the variable that changes the excess the most, unless it is narrow."""
        width = (self.high - self.low) / self.whole
        width = np.where(width > LEAST_PART_SHARE, width, 0.0)
        steep = np.where(np.isfinite(slope_magnitudes), slope_magnitudes * self.whole, LARGEST_SLOPE)
        which, every = (steep * width).argmax(axis=0), np.arange(self.size)
        ends = np.linspace(self.low[which, every], self.high[which, every], CONSTRAINT_PART_CUTS + 1)
        low, high = (
            np.repeat(self.low[:, None], CONSTRAINT_PART_CUTS, axis=1),
            np.repeat(self.high[:, None], CONSTRAINT_PART_CUTS, axis=1),
        )
        low[which, :, every], high[which, :, every] = ends[:-1].T, ends[1:].T
        sides, shape = len(self.low), CONSTRAINT_PART_CUTS * self.size
        return replace(
            self,
            panel=np.tile(self.panel, CONSTRAINT_PART_CUTS),
            side=np.tile(self.side, CONSTRAINT_PART_CUTS),
            low=low.reshape(sides, shape),
            high=high.reshape(sides, shape),
        )

    @property
    def too_narrow_to_cut(self) -> Any:
        """Which parts are too narrow to be cut."""
        return np.all(self.high - self.low <= LEAST_PART_SHARE * self.whole, axis=0)


CurveEnclosure = tuple[Any, Designs, SlopedInterval]
"""A curve over parts, with the designs and the cam angle of the parts."""
CurveEnclosures = dict[Any, CurveEnclosure]
"""Enclosures of the curves of one design, by curve and parts. They do not depend on a bound."""


@dataclass(frozen=True)
class ConstraintSearch:
    """The search for a design of a box that breaks a constraint at a cam angle."""

    problem: Problem
    constraint: Any
    """A constraint on a curve or on a mean."""
    design: Designs
    names: tuple[str, ...]
    budget: Budget
    enclosures: CurveEnclosures | None = None
    at_once: ClassVar[int] = CONSTRAINT_PARTS_AT_ONCE
    rounds: ClassVar[int] = MOST_ROUNDS

    def search_for_violation(self, parts: BoxParts) -> BoxVerdict:
        """Search until a part breaks the constraint or all hold it; parts with the largest excess come first."""
        stack = [parts]
        for _ in range(self.rounds):
            if not stack:
                return BoxVerdict(HELD)
            parts = stack.pop()
            self.budget.spend(PART_WORK * (ROUND_PARTS + parts.size))
            with np.errstate(all="ignore"):
                excess = self.enclose_excess(parts)
            if np.any(excess.at.low > 0.0):
                worst = int(np.argmax(excess.at.low))
                middle = (parts.low[1:, worst] + parts.high[1:, worst]) / 2.0
                witness = {name: np.array([value]) for name, value in zip(self.names, middle, strict=True)}
                return BoxVerdict(BROKEN, self.design.with_values(witness))
            open_ = np.flatnonzero(~(excess.value.high <= 0.0))
            open_ = open_[np.argsort(excess.value.high[open_], kind="stable")]  # NaN comes last
            if np.any(parts.too_narrow_to_cut[open_]) or self.budget.is_spent:
                break
            parts = parts.take(open_).reduce_monotone_variables_to_ends(excess.slopes[:, open_])
            steepest = excess.slopes[:, open_].largest_magnitude
            for numbers in np.array_split(np.arange(open_.size), -(-open_.size // self.at_once) or 1):
                stack += (
                    [parts.take(numbers).cut_across_steepest_variable(steepest[:, numbers])] if numbers.size else []
                )
        return BoxVerdict(UNDECIDED)

    def enclose_excess(self, parts: BoxParts) -> SlopedInterval:
        """Excess of the designs of parts over the constraint; the curve is from the kept enclosures, if any."""
        if self.enclosures is None:
            value, designs, angle = self.enclose_curve(parts)
        else:
            key = (self.constraint.curve, parts.panel.tobytes(), parts.low.tobytes(), parts.high.tobytes())
            if key not in self.enclosures:
                self.enclosures[key] = self.enclose_curve(parts)
            value, designs, angle = self.enclosures[key]
        return as_sloped_interval(relative_excess(self.constraint, parts.side, as_quotient(value), designs), angle)

    def enclose_curve(self, parts: BoxParts) -> CurveEnclosure:
        """The constraint's curve over parts."""
        programme = self.problem.programme
        middle_place, angle, designs = self.angles_and_designs(parts, programme.table)
        fixed: Any = {name: as_interval(size) for name, size in designs.sizes.items() if name not in self.names}
        designs = designs.with_values(fixed)
        state = enclose_state(programme.table, parts.panel, middle_place, angle)
        value = curve_value(self.constraint.curve(designs, programme), ..., state)
        return value.divide() if isinstance(value, Quotient) else value, designs, angle

    def angles_and_designs(self, parts: BoxParts, table: MotionTable) -> tuple[FloatArray, SlopedInterval, Designs]:
        """The middles of parts on their panels, and their cam angles and designs, both with slopes."""
        middle, half = (parts.low + parts.high) / 2.0, table.half_width[parts.panel]
        place = Interval(parts.low[0] * half, parts.high[0] * half)
        sides = [place, *(Interval(low, high) for low, high in zip(parts.low[1:], parts.high[1:], strict=True))]
        angle, *numbers = box_variables(sides, [middle[0] * half, *middle[1:]])
        designs = self.design.take(np.zeros(parts.size, dtype=int))
        return middle[0], angle, designs.with_values(dict(zip(self.names, numbers, strict=True)))

    def box_and_middle_designs(self, parts: BoxParts) -> tuple[Designs, Designs, SlopedInterval]:
        """Designs of parts, designs in their middles, and a sloped interval of these parts as a model."""
        middle = (parts.low + parts.high) / 2.0
        sides = [Interval(low, high) for low, high in zip(parts.low, parts.high, strict=True)]
        like, *sizes = box_variables(sides, [*middle])
        designs = self.design.take(np.zeros(parts.size, dtype=int))
        boxes, inside = (dict(zip(self.names, values, strict=True)) for values in (sizes, middle[1:]))
        return designs.with_values(boxes), designs.with_values(inside), like


class MeanConstraintSearch(ConstraintSearch):
    """The search for a design of a box that breaks a constraint on a mean. Only the box is cut, not the turn."""

    at_once: ClassVar[int] = MEANS_AT_ONCE
    rounds: ClassVar[int] = MEAN_ROUNDS

    def enclose_excess(self, parts: BoxParts) -> SlopedInterval:
        _, inside, like = self.box_and_middle_designs(parts)
        ranges = {
            name: Interval(*ends) for name, *ends in zip(self.names, parts.low[1:], parts.high[1:], strict=True)
        }
        excess = enclose_mean_excess(
            self.problem, self.constraint, inside.with_values(ranges), inside, [*self.names]
        )
        rows = (np.vstack([np.zeros((1, parts.size)), end]) for end in (excess.slopes.low, excess.slopes.high))
        return replace(excess, slopes=Interval(*rows), span=like.span)


def whole_turn_parts(constraint: TurnMeanConstraint, number_ranges: NumberRanges) -> BoxParts:
    """The whole turn as one part, with the whole box."""
    parts = BoxParts.from_panels(np.zeros(1, dtype=int), constraint, number_ranges)
    low, high = parts.low.copy(), parts.high.copy()
    low[0] = high[0] = 0.0
    return replace(parts, low=low, high=high)


def enclose_state(table: MotionTable, panel: IntArray, middle_place: FloatArray, angle: SlopedInterval) -> State:
    """State of the follower over parts of panels, with slopes by the cam angle.

    ``middle_place`` is the middle of each part, as a share of half the panel.
    """
    y, y1, y2, y3, y4 = derivative_intervals_over_parts(table, panel, middle_place, angle, 4)
    load: Any = table.load
    if isinstance(load, LoadTable):
        slope = Interval(*(load.slope[panel] + side * load.error[panel, 1] for side in (-1.0, 1.0)))
        straight = angle * load.slope[panel] + Interval(
            *(load.centre[panel] + side * load.error[panel, 0] for side in (-1.0, 1.0))
        )
        load = Load(replace(straight, slopes=slopes_of_function_of_angle(angle, slope)), slope)
    elif isinstance(load, TrainLoadTable):
        still, carried = (derivative_intervals_over_parts(force, panel, middle_place, angle, 1) for force in load)
        load = TrainForces(*still, *carried)
    return State(y, y1, y2, y3, load, y4)

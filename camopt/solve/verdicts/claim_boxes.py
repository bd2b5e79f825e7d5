"""Whether every design of a box holds a claim at every cam angle, decided by bisection of box and turn at once.

The cam angle is one more variable of the box: over a part of a panel the motion is a range whose slopes by the
cam angle are its own derivatives. The formula of a claim, run on both with slopes (``numerics.sloped``), bounds its
excess over the part. A part that surely holds it is done with; one point that surely breaks it is a witness; what
is neither is cut, across the variable that changes the excess the most. Where the excess surely rises or falls with
a variable, only that end of it is left.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11 (monotonicity test).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.clock import now
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.loading import LoadTable, TrainLoadTable
from camopt.core.numerics.motion_ranges import by_angle, derivatives_over
from camopt.core.numerics.piecewise import MotionTable
from camopt.core.numerics.sloped import Quotient, Sloped, as_quotient, as_sloped, at_point, variables
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.effects.peak import Derivative, NumberKind
from camopt.model.mechanisms import Designs
from camopt.scene.problem.claims import AnyClaim, Claim, MeanClaim
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.arcs import arcs_verdict, is_on_arcs
from camopt.solve.verdicts.mean_boxes import mean_excess, mean_verdict
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED

AT_ONCE, MOST_ROUNDS = 256, 100
"""How many parts are cut at once, and how often."""
CUTS = 8
"""Of a part that is cut."""
MEANS_AT_ONCE, MEAN_ROUNDS = 8, 3
"""The same of means, of which each part is a turn."""
LEAST_SHARE = 2.0**-45
"""Parts this narrow, of a panel or of the box, are not cut."""
HUGE_SLOPE = 1e300
"""In place of a slope without bounds."""
Ends = Mapping[str, tuple[float, float]]
"""Between which values sizes are, by field of ``Designs``; the others are those of a design."""


def _enclosed(number: float) -> Interval:
    """A number as an interval."""
    return Interval(np.array([number]), np.array([number]))


INTERVALS = NumberKind(
    _enclosed,
    lambda: Interval(np.array([np.pi]), np.array([np.nextafter(np.pi, 4.0)])),
    lambda angle: np.sin(angle) / np.cos(angle),
)
"""The kind of number, for bounds."""


def excess_of(claim: Claim, side: FloatArray, found: Quotient, designs: Designs) -> Any:
    """The excess over a side of a claim, relative to the terms of the claim: above 0 it does not hold."""
    ranged, bound = isinstance(found.above, (Interval, Sloped)), claim.allowed()
    value = side * found.above * claim.factor(designs)
    allowed = (claim.allowed(INTERVALS) if ranged else bound) * found.below
    scale = sum(at_point(x).least_magnitude for x in (value, allowed))  # the largest may be infinite
    return (value - allowed) / (scale if bound else scale + at_point(claim.unit(designs)).high)


class Answer(NamedTuple):
    """Whether all designs of a box hold a claim, and one that does not, if one is found."""

    verdict: str
    witness: Designs | None = None


def over_box(problem: Problem, claim: AnyClaim, design: Designs, ends: Ends, until: float = inf) -> Answer:
    """Whether all designs that differ from one by sizes between their ends hold a claim.

    Undecided after ``until`` (``clock.now``), and where a design may be one that cannot be assembled.
    """
    if not problem.programme.has(claim.kinds):
        return Answer(HELD)
    if not ends and isinstance(claim, Claim) and is_on_arcs(problem, claim):
        return Answer(arcs_verdict(problem, claim, design))
    box = design.with_values({name: _wide(*each) for name, each in ends.items()})
    for margin in problem.setup.mechanism.assembly_margins(box, problem.programme):
        if not np.all(as_interval(margin).low > 0.0):
            return Answer(UNDECIDED)
    if isinstance(claim, MeanClaim):
        if not ends:
            return Answer(mean_verdict(problem, claim, design))
        return Means(problem, claim, design, tuple(ends), until).run(over_turn(claim, ends))
    if isinstance(claim.curve, Derivative):
        return Answer(UNDECIDED)
    return Search(problem, claim, design, tuple(ends), until).run(Parts.first(problem, claim, ends))


def _wide(low: float, high: float) -> Any:
    return Interval(np.array([low]), np.array([high]))


@dataclass(frozen=True)
class Parts:
    """Parts of panels, with parts of the box."""

    panel: IntArray
    side: FloatArray
    """Of the claim."""
    low: FloatArray
    """Of the place on the panel, from −1 to 1, and of each size (1 + sizes, parts)."""
    high: FloatArray
    whole: FloatArray
    """Widths of the panel and of the box (1 + sizes, 1); 1 where it has none."""

    @classmethod
    def first(cls, problem: Problem, claim: AnyClaim, ends: Ends) -> "Parts":
        """Whole panels of the kinds of a claim, with the whole box, for each side of it."""
        return cls.of(np.flatnonzero(problem.programme.panels_of(claim.kinds)), claim, ends)

    @classmethod
    def of(cls, panels: IntArray, claim: AnyClaim, ends: Ends) -> "Parts":
        """Some whole panels with the whole box, for each side of a claim."""
        panel, side = (each.ravel() for each in np.meshgrid(panels, np.array(claim.sides), indexing="ij"))
        low, high = np.array([(-1.0, 1.0), *ends.values()]).T[..., None]
        every = np.ones(panel.size)
        return cls(panel, side, low * every, high * every, np.where(high > low, high - low, 1.0))

    @property
    def size(self) -> int:
        return self.panel.size

    def take(self, index: Any) -> "Parts":
        return replace(
            self, panel=self.panel[index], side=self.side[index], low=self.low[:, index], high=self.high[:, index]
        )

    def parted(self, place: FloatArray) -> "Parts":
        """With those parts cut in two that have a place of their panel, one for each, inside."""
        inside = (self.low[0] < place) & (place < self.high[0])
        before, after = np.where(inside, place, self.high[0]), place[inside]
        low, high = np.hstack([self.low, self.low[:, inside]]), np.hstack([self.high, self.high[:, inside]])
        low[0, self.size :], high[0, : self.size] = after, before
        panel, side = (np.concatenate([each, each[inside]]) for each in (self.panel, self.side))
        return replace(self, panel=panel, side=side, low=low, high=high)

    def monotone(self, slopes: Interval) -> "Parts":
        """With that end alone of each variable with which the excess surely rises or falls."""
        rises, falls = slopes.low >= 0.0, slopes.high <= 0.0
        return replace(
            self, low=np.where(rises, self.high, self.low), high=np.where(falls & ~rises, self.low, self.high)
        )

    def cut(self, steepest: FloatArray) -> "Parts":
        """Each part in some, across the variable that changes the excess the most; not what is narrow."""
        width = (self.high - self.low) / self.whole
        width = np.where(width > LEAST_SHARE, width, 0.0)
        steep = np.where(np.isfinite(steepest), steepest * self.whole, HUGE_SLOPE)
        which, every = (steep * width).argmax(axis=0), np.arange(self.size)
        ends = np.linspace(self.low[which, every], self.high[which, every], CUTS + 1)
        low, high = np.repeat(self.low[:, None], CUTS, axis=1), np.repeat(self.high[:, None], CUTS, axis=1)
        for number in range(CUTS):
            low[which, number, every], high[which, number, every] = ends[number], ends[number + 1]
        sides, shape = len(self.low), CUTS * self.size
        return replace(
            self,
            panel=np.tile(self.panel, CUTS),
            side=np.tile(self.side, CUTS),
            low=low.reshape(sides, shape),
            high=high.reshape(sides, shape),
        )

    @property
    def narrow(self) -> Any:
        """Which of them are not to be cut."""
        return np.all(self.high - self.low <= LEAST_SHARE * self.whole, axis=0)


@dataclass(frozen=True)
class Search:
    """The search for a design of a box that breaks a claim at a cam angle."""

    problem: Problem
    claim: Any
    """A claim, or one on a mean."""
    design: Designs
    names: tuple[str, ...]
    until: float
    at_once: ClassVar[int] = AT_ONCE
    rounds: ClassVar[int] = MOST_ROUNDS

    def run(self, parts: Parts) -> Answer:
        """Whether there is none, or one, or neither is found: those parts first that exceed the claim the most."""
        stack = [parts]
        for _ in range(self.rounds):
            if not stack:
                return Answer(HELD)
            parts = stack.pop()
            with np.errstate(all="ignore"):
                excess = self.excess(parts)
            if np.any(excess.at.low > 0.0):
                return Answer(BROKEN, self.point(parts, int(np.argmax(excess.at.low))))
            left = np.flatnonzero(~(excess.value.high <= 0.0))
            left = left[np.argsort(excess.value.high[left], kind="stable")]  # what is not known comes last
            if np.any(parts.narrow[left]) or now() > self.until:
                break
            parts = parts.take(left).monotone(excess.slopes[:, left])
            steepest = excess.slopes[:, left].largest_magnitude
            for some in np.array_split(np.arange(left.size), -(-left.size // self.at_once) or 1):
                stack += [parts.take(some).cut(steepest[:, some])] if some.size else []
        return Answer(UNDECIDED)

    def excess(self, parts: Parts) -> Sloped:
        """By how much designs of parts exceed the claim."""
        value, designs, angle = self.curve_over(parts)
        return as_sloped(excess_of(self.claim, parts.side, as_quotient(value), designs), angle)

    def curve_over(self, parts: Parts) -> tuple[Any, Designs, Sloped]:
        """The curve of the claim over parts, and of what designs and cam angles it is."""
        programme, middle = self.problem.programme, (parts.low + parts.high) / 2.0
        half = programme.table.half_width[parts.panel]
        place = Interval(parts.low[0] * half, parts.high[0] * half)
        sides = [place, *(Interval(low, high) for low, high in zip(parts.low[1:], parts.high[1:], strict=True))]
        angle, *sizes = variables(sides, [middle[0] * half, *middle[1:]])
        designs = self.design.take(np.zeros(parts.size, dtype=int))
        fixed: dict[str, Any] = {name: as_interval(each) for name, each in designs.sizes.items()}
        designs = designs.with_values(fixed | dict(zip(self.names, sizes, strict=True)))
        state = state_over(programme.table, parts.panel, middle[0], angle)
        value = value_of(self.claim.curve(designs, programme), ..., state)
        return value.divided() if isinstance(value, Quotient) else value, designs, angle

    def point(self, parts: Parts, number: int) -> Designs:
        """The design in the middle of a part."""
        middle = (parts.low[1:, number] + parts.high[1:, number]) / 2.0
        return self.design.with_values({n: np.array([v]) for n, v in zip(self.names, middle, strict=True)})


class Means(Search):
    """The search for a design of a box that breaks a claim on a mean: parts are of the box alone."""

    at_once: ClassVar[int] = MEANS_AT_ONCE
    rounds: ClassVar[int] = MEAN_ROUNDS

    def excess(self, parts: Parts) -> Sloped:
        _, inside, like = boxes_of(self.design, self.names, parts)
        ranges = {
            name: Interval(*ends) for name, *ends in zip(self.names, parts.low[1:], parts.high[1:], strict=True)
        }
        found = mean_excess(self.problem, self.claim, inside.with_values(ranges), inside, [*self.names])
        rows = (np.vstack([np.zeros((1, parts.size)), end]) for end in (found.slopes.low, found.slopes.high))
        return replace(found, slopes=Interval(*rows), span=like.span)


def over_turn(claim: MeanClaim, ends: Ends) -> Parts:
    """All of a turn at once, with the whole box."""
    parts = Parts.of(np.zeros(1, dtype=int), claim, ends)
    low, high = parts.low.copy(), parts.high.copy()
    low[0] = high[0] = 0.0
    return replace(parts, low=low, high=high)


def boxes_of(design: Designs, names: tuple[str, ...], parts: Parts) -> tuple[Designs, Designs, Sloped]:
    """The designs of parts of a box, those in their middles, and what has the slopes of these parts."""
    middle = (parts.low + parts.high) / 2.0
    like, *sizes = variables([Interval(*ends) for ends in zip(parts.low, parts.high, strict=True)], [*middle])
    every = design.take(np.zeros(parts.size, dtype=int))
    boxes, inside = (dict(zip(names, each, strict=True)) for each in (sizes, middle[1:]))
    return every.with_values(boxes), every.with_values(inside), like


def state_over(table: MotionTable, panel: IntArray, u: FloatArray, angle: Sloped) -> State:
    """The state of the follower over parts of panels, with slopes by the cam angle from the panel's middle.

    ``u`` is the middle of each part, as a share of half the panel.
    """
    y, y1, y2, y3, y4 = derivatives_over(table, panel, u, angle, 4)
    return State(y, y1, y2, y3, _load_over(table, panel, u, angle), y4)


def _load_over(table: MotionTable, panel: IntArray, u: FloatArray, angle: Sloped) -> Any:
    """What a load brings over parts of panels."""
    load = table.load
    if isinstance(load, LoadTable):
        slope = Interval(*(load.slope[panel] + side * load.error[panel, 1] for side in (-1.0, 1.0)))
        straight = angle * load.slope[panel] + Interval(
            *(load.centre[panel] + side * load.error[panel, 0] for side in (-1.0, 1.0))
        )
        return Load(replace(straight, slopes=by_angle(angle, slope)), slope)
    if isinstance(load, TrainLoadTable):
        still, carried = (derivatives_over(force, panel, u, angle, 1) for force in load)
        return TrainForces(*still, *carried)
    return None

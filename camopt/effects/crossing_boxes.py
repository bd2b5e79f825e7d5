"""Boxes of designs of which all cross themselves, and designs that cross themselves near known cam angles.

Two parts of the profile of one design that meet do so throughout a box of designs if they reach further across each
other than they move against each other within the box. How they move with each size follows from ranges with
slopes (``numerics.sloped``), the cam angle within a part being one of the variables. A crossing moves little from
design to design: those known are tried first.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.case import Setup
from camopt.effects.crossing import across, cross, find_crossing
from camopt.effects.parts import (
    WIDEST,
    Cover,
    IntArray,
    Parts,
    cover,
    ends_of,
    motion_at,
    points_at,
    profile,
    start_of,
)
from camopt.mechanisms.design import BoolArray, Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Quotient, Sloped, variables

MOST_KNOWN = 4
UNKNOWN = -1  # which size to cut
STEPS, SHORT = 8, 1e-7  # of Newton's method; of its difference quotients, rad
HALVINGS = 24  # from the widest part round a crossing to the narrowest
LARGE = 1e300  # in place of what is lost without bounds
CAREFUL = 1.001  # far more than what rounding of ranges takes, where they are narrow, too
START = "start"

Sides = dict[str, tuple[Interval, FloatArray]]
"""Boxes of some variables of designs (free sizes, or START), and a point in each."""


class Met(NamedTuple):
    """Two parts of each of n profiles, and how far they reach across each other, mm; −∞ where neither is shown."""

    parts: tuple[Parts, Parts]
    covers: tuple[Cover, Cover]
    reach: FloatArray
    """(2, n): of the first part across the second, and the other way."""

    @property
    def least(self) -> FloatArray:
        """How far both reach, (n,); above 0 where they surely meet."""
        return np.asarray(self.reach.min(axis=0))

    def take(self, index: IntArray) -> "Met":
        """Those of some of the profiles."""
        one, other = (Parts(*(x[index] for x in each)) for each in self.parts)
        return Met((one, other), (self.covers[0].take(index), self.covers[1].take(index)), self.reach[:, index])


class KnownCrossings:
    """A search among the cams of a programme, and where their profiles were found to cross."""

    def __init__(self, setup: Setup, programme: Programme) -> None:
        self._setup, self._programme = setup, programme
        self._known: list[tuple[float, ...]] = []
        """Pairs of cam angles in rad, the latest first."""

    def excluded(self, box: Designs, inside: Designs, free: Sequence[str]) -> tuple[BoolArray, IntArray]:
        """Of which boxes (Intervals) all designs are shown to cross themselves; and which free size to cut next.

        ``inside`` is one design of each. Where no known crossing shows that it crosses itself, another one is
        looked for, at the box of the smallest cams. −1 where the design inside cannot be assembled, or is not seen
        to cross itself, so that nothing tells which size to cut.
        """
        sides: dict[str, Any] = box.sizes
        crossing, cut = np.zeros(len(box), dtype=bool), np.full(len(box), UNKNOWN)
        index = np.flatnonzero(self._setup.mechanism.exists(inside, self._programme))
        met = self._met(inside.take(index))
        unseen = index[met.least <= 0.0]
        if unseen.size and self.learn(inside.take(unseen[[np.argmin(sides["size"].low[unseen])]])):
            met = self._met(inside.take(index))
        seen = np.flatnonzero(met.least > 0.0)
        if seen.size:
            some = index[seen]
            crossing[some], cut[some] = throughout(
                self._setup, inside.take(some), box.take(some), free, self._programme, met.take(seen)
            )
        return crossing, cut

    def shown(self, designs: Designs) -> BoolArray:
        """Which designs are seen to cross themselves where others do."""
        return np.asarray(self._met(designs).least > 0.0)

    def learn(self, design: Designs) -> bool:
        """Whether a design is shown to cross itself; where it does is then known."""
        found = find_crossing(self._setup, design, self._programme)
        if found.shown:
            self._known = [found.at, *self._known][:MOST_KNOWN]
        return found.shown is True

    def _met(self, designs: Designs) -> Met:
        """Of each design the parts that reach furthest across each other, of those near the known crossings."""
        known = np.array(self._known or [(0.0, 0.0)])
        count = len(designs) * len(known)
        near = np.tile(known, (len(designs), 1))
        met = met_near(self._setup, designs.take(np.arange(count) // len(known)), self._programme, near)
        best = met.least.reshape(len(designs), len(known)).argmax(axis=1)
        return met.take(np.arange(0, count, len(known)) + best)


def met_near(setup: Setup, designs: Designs, programme: Programme, near: FloatArray) -> Met:
    """The two parts of each profile near two cam angles in rad, (n, 2), of the widths that reach furthest."""
    column, every = designs.take((slice(None), None)), np.arange(len(designs))
    parts = [_around(programme, root) for root in _roots(setup, column, programme, near).T]
    covers = [cover(setup, column, programme, each) for each in parts]
    far = [across(covers[k], ends_of(setup, column, programme, parts[k]), covers[1 - k]) for k in (0, 1)]
    first, second = far[0][:, :, None] - covers[1].bulge[:, None], far[1][:, None] - covers[0].bulge[:, :, None]
    least = np.minimum(first, second).reshape(len(designs), HALVINGS**2)
    widths = np.unravel_index(least.argmax(axis=1), (HALVINGS, HALVINGS))
    best = [(every, width) for width in widths]
    one, other = (
        Parts(*(np.broadcast_to(x, far[0].shape)[at] for x in part)) for part, at in zip(parts, best, strict=True)
    )
    reach = np.stack([each[every, *widths] for each in (first, second)])
    return Met((one, other), (covers[0].take(best[0]), covers[1].take(best[1])), reach)


def throughout(
    setup: Setup, designs: Designs, box: Designs, free: Sequence[str], programme: Programme, met: Met
) -> tuple[BoolArray, IntArray]:
    """In which boxes the parts that meet do so throughout; and which free size moves them the most.

    Seen by the free sizes, or with the follower's height or angle at displacement 0 in place of the cam's size: by
    the size that changes without bounds where a follower can only just be assembled.
    """
    sides: dict[str, Any] = box.sizes
    others = {name: (sides[name], designs.sizes[name]) for name in free}
    by_size = moves(setup, designs, others, programme, met)
    others[START] = as_interval(start_of(setup, box)), start_of(setup, designs)
    del others["size"]
    by_start = moves(setup, designs, others, programme, met)
    shown = [np.all(moved.sum(axis=0) * CAREFUL < met.reach, axis=0) for moved in (by_size, by_start)]
    width, most = np.array([sides[name].high - sides[name].low for name in free]), by_size.max(axis=1)
    return np.logical_or(*shown), np.argmax(np.where(np.isfinite(most), most, LARGE * width), axis=0)


def moves(setup: Setup, designs: Designs, sides: Sides, programme: Programme, met: Met) -> FloatArray:
    """How much of its reach across the other a part may lose in boxes of some variables: (variables, 2, n), mm."""
    shifts = [shift(setup, designs, sides, programme, each) for each in met.parts]
    apart = [one - other for one, other in zip(*shifts, strict=True)]
    half = np.array([np.maximum(side.high - point, point - side.low) for side, point in sides.values()])
    lost = [
        (found.tangent.real * apart[1] - found.tangent.imag * apart[0]).largest_magnitude * half
        for found in reversed(met.covers)
    ]
    return np.stack(lost, axis=1)


def shift(
    setup: Setup, designs: Designs, sides: Sides, programme: Programme, parts: Parts
) -> tuple[Interval, Interval]:
    """The ranges of ∂x and ∂y of the profile on the cam, by each variable, over boxes and parts: (variables, n)."""
    turn = Interval(parts.middle - parts.half, parts.middle + parts.half)
    boxes, points = zip(*sides.values(), (turn, parts.middle), strict=True)
    *within, angle = variables(boxes, points)
    sizes: dict[str, Any] = dict(zip(sides, within, strict=True))
    start = sizes.pop(START, None)
    y, y1 = motion_at(programme.table, parts.middle)
    velocity = np.minimum(parts.velocity, np.abs(y1) + parts.half * parts.acceleration)
    with np.errstate(all="ignore"):
        some = replace(designs, **sizes)
        start = start_of(setup, some) if start is None else start
        speed = _moving(angle, y1, parts.acceleration, parts)
        places = profile(setup, some, start + _moving(angle, y, velocity, parts), speed)
        x, z = (place.divided() if isinstance(place, Quotient) else place for place in places)
    cosine, sine = np.cos(angle), designs.sense * np.sin(angle)
    across_x, across_y = x * cosine + z * sine, z * cosine - x * sine
    return across_x.slopes[:-1], across_y.slopes[:-1]


def _moving(angle: Sloped, value: FloatArray, slope: FloatArray, parts: Parts) -> Sloped:
    """What changes with the cam angle alone, from its value in the middle of a part and the bound of its slope."""
    away = parts.half * slope + parts.error
    bound = np.zeros_like(angle.slopes.low)
    bound[-1] = slope
    at = Interval(value - parts.error, value + parts.error)
    return Sloped(Interval(value - away, value + away), at, Interval(-bound, bound), angle.span)


def _around(programme: Programme, angles: FloatArray) -> Parts:
    """Parts (n, HALVINGS) round cam angles (n,), ever narrower, with what bounds the motion in the widest."""
    table = programme.table
    away = np.abs(np.mod(angles[:, None] - table.centre + np.pi, 2 * np.pi) - np.pi)
    touched = away <= table.half_width + 1.01 * WIDEST
    velocity, acceleration, *errors = (
        np.max(np.where(touched, row, 0.0), axis=1, keepdims=True)
        for row in (*table.most[: table.centre.size, 1:3].T, *table.error[: table.centre.size, :2].T)
    )
    half = np.broadcast_to(WIDEST * 0.5 ** np.arange(HALVINGS), (angles.size, HALVINGS))
    return Parts(np.broadcast_to(angles[:, None], half.shape), half, velocity, acceleration, np.maximum(*errors))


def _roots(setup: Setup, designs: Designs, programme: Programme, near: FloatArray) -> FloatArray:
    """The two cam angles (n, 2) of about one point of each profile (n, 1), by Newton's method from those given."""
    angles = near
    for _ in range(STEPS):
        points = points_at(setup, designs, programme, np.concatenate([angles, angles + SHORT], axis=1))
        gap, (along, across) = points[:, 1] - points[:, 0], ((points[:, 2:] - points[:, :2]) / SHORT).T
        turned = cross(along, across)
        step = np.stack([cross(gap, across), cross(gap, along)], axis=1)
        step = step / np.where(turned == 0.0, np.inf, turned)[:, None]
        angles = angles + np.clip(step, -WIDEST, WIDEST)
    return np.asarray(np.mod(angles, 2 * np.pi))

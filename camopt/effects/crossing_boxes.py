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

from camopt.effects.case import Subject
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


class KnownCrossings:
    """A search among the cams of a programme, and where their profiles were found to cross."""

    def __init__(self, subject: Subject, programme: Programme) -> None:
        self._subject, self._programme = subject, programme
        self._known: list[tuple[float, ...]] = []
        """Pairs of cam angles in rad, the latest first."""

    def excluded(self, box: Designs, free: Sequence[str]) -> tuple[BoolArray, IntArray]:
        """Of which boxes (Intervals) all designs are shown to cross themselves; and which free size to cut next.

        Where no known crossing shows it, another one is looked for, at the box of the smallest cams. −1 where the
        middle of a box is not seen to cross itself, so that nothing tells which size to cut.
        """
        sides: dict[str, Any] = box.sizes
        middles = replace(box, **{name: (side.low + side.high) / 2 for name, side in sides.items()})
        crossing, cut = np.zeros(len(box), dtype=bool), np.full(len(box), UNKNOWN)
        left = np.flatnonzero(self._subject.mechanism.exists(middles, self._programme))
        for near in self._known:
            left = self._try(near, middles, box, free, left, crossing, cut)
        if left.size:
            smallest = left[np.argmin(sides["size"].low[left])]
            if self.learn(middles.take([smallest])):
                self._try(self._known[0], middles, box, free, left, crossing, cut)
        return crossing, cut

    def shown(self, designs: Designs) -> BoolArray:
        """Which designs are seen to cross themselves where others do."""
        crossing, left = np.zeros(len(designs), dtype=bool), np.arange(len(designs))
        for near in self._known:
            met = met_near(self._subject, designs.take(left), self._programme, near)
            crossing[left] = np.all(met.reach > 0.0, axis=0)
            left = left[~crossing[left]]
        return crossing

    def learn(self, design: Designs) -> bool:
        """Whether a design is shown to cross itself; where it does is then known."""
        found = find_crossing(self._subject, design, self._programme)
        if found.shown:
            self._known = [found.at, *self._known][:MOST_KNOWN]
        return found.shown is True

    def _try(
        self,
        near: tuple[float, ...],
        middles: Designs,
        box: Designs,
        free: Sequence[str],
        left: IntArray,
        crossing: BoolArray,
        cut: IntArray,
    ) -> IntArray:
        """Mark those of the boxes left that cross themselves throughout near two cam angles; the rest of them."""
        met = met_near(self._subject, middles.take(left), self._programme, near)
        index = np.flatnonzero(np.all(met.reach > 0.0, axis=0))
        if not index.size:
            return left
        some = left[index]
        shown, side = throughout(
            self._subject, middles.take(some), box.take(some), free, self._programme, taken(met, index)
        )
        crossing[some], cut[some] = shown, side
        return left[~crossing[left]]


def taken(met: Met, index: IntArray) -> Met:
    """Those of some of the profiles."""
    parts = tuple(Parts(*(x[index] for x in each)) for each in met.parts)
    return Met((parts[0], parts[1]), (met.covers[0].take(index), met.covers[1].take(index)), met.reach[:, index])


def met_near(subject: Subject, designs: Designs, programme: Programme, near: tuple[float, ...]) -> Met:
    """The two parts of each profile near two cam angles in rad, of all widths, that reach furthest across."""
    column, every = designs.take((slice(None), None)), np.arange(len(designs))
    parts = [_around(programme, root) for root in _roots(subject, column, programme, near).T]
    covers = [cover(subject, column, programme, each) for each in parts]
    ends = [ends_of(subject, column, programme, each) for each in parts]
    reach = np.stack([across(covers[k], ends[k], covers[1 - k]) for k in (0, 1)])
    best = every, np.argmax(reach.min(axis=0), axis=-1)
    one, other = (Parts(*(np.broadcast_to(x, reach.shape[1:])[best] for x in each)) for each in parts)
    return Met((one, other), (covers[0].take(best), covers[1].take(best)), reach[:, best[0], best[1]])


def throughout(
    subject: Subject, designs: Designs, box: Designs, free: Sequence[str], programme: Programme, met: Met
) -> tuple[BoolArray, IntArray]:
    """In which boxes the parts that meet do so throughout; and which free size moves them the most.

    Seen by the free sizes, or with the follower's height or angle at displacement 0 in place of the cam's size: by
    the size that changes without bounds where a follower can only just be assembled.
    """
    sides: dict[str, Any] = box.sizes
    others = {name: (sides[name], designs.sizes[name]) for name in free}
    by_size = moves(subject, designs, others, programme, met)
    others[START] = as_interval(start_of(subject, box)), start_of(subject, designs)
    del others["size"]
    by_start = moves(subject, designs, others, programme, met)
    shown = [np.all(moved.sum(axis=0) * CAREFUL < met.reach, axis=0) for moved in (by_size, by_start)]
    return np.logical_or(*shown), np.argmax(np.nan_to_num(by_size.max(axis=1), nan=np.inf), axis=0)


def moves(subject: Subject, designs: Designs, sides: Sides, programme: Programme, met: Met) -> FloatArray:
    """How much of its reach across the other a part may lose in boxes of some variables: (variables, 2, n), mm."""
    shifts = [shift(subject, designs, sides, programme, each) for each in met.parts]
    apart = [one - other for one, other in zip(*shifts, strict=True)]
    half = np.array([np.maximum(side.high - point, point - side.low) for side, point in sides.values()])
    lost = [
        (found.tangent.real * apart[1] - found.tangent.imag * apart[0]).largest_magnitude * half
        for found in reversed(met.covers)
    ]
    return np.stack(lost, axis=1)


def shift(
    subject: Subject, designs: Designs, sides: Sides, programme: Programme, parts: Parts
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
        start = start_of(subject, some) if start is None else start
        speed = _moving(angle, y1, parts.acceleration, parts)
        places = profile(subject, some, start + _moving(angle, y, velocity, parts), speed)
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


def _roots(subject: Subject, designs: Designs, programme: Programme, near: tuple[float, ...]) -> FloatArray:
    """The two cam angles (n, 2) of about one point of each profile (n, 1), by Newton's method from those given."""
    angles = np.tile(np.array(near), (len(designs), 1))
    for _ in range(STEPS):
        points = points_at(subject, designs, programme, np.concatenate([angles, angles + SHORT], axis=1))
        gap, (along, across) = points[:, 1] - points[:, 0], ((points[:, 2:] - points[:, :2]) / SHORT).T
        turned = cross(along, across)
        step = np.stack([cross(gap, across), cross(gap, along)], axis=1)
        step = step / np.where(turned == 0.0, np.inf, turned)[:, None]
        angles = angles + np.clip(step, -WIDEST, WIDEST)
    return np.asarray(np.mod(angles, 2 * np.pi))

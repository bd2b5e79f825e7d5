"""Boxes of designs of which all cross themselves, and designs that do so near known cam angles.

The profile P = C − R_r·n of a cam that is not undercut crosses itself if, and only if, the roller at some cam angle
b, with its centre C(b) on the pitch curve, cuts into the profile at another one: |P(a) − C(b)| < R_r.

- If: C does not meet itself, since two points of C at one distance from the centre are at one displacement, and so
  at one cam angle. It encloses an area A and has the length L. Where nothing is undercut, a profile that does not
  cross itself encloses A − L·R_r + π·R_r², and every point inside C that is further than R_r from C. The area of
  these points is no smaller: the border of those further than r is no longer than L − 2πr. So it is just as long
  for each r up to R_r, nothing is cut off the curves C − r·n, and no P(a) is nearer to C than R_r.
- Only if: where one part of the profile crosses another, it enters the roller that touches the other there.

With Δ = C(a) − C(b) the condition is 2·R_r·Δ·n(a) − |Δ|² > 0, one inequality for each pair of cam angles. Ranges
with slopes (``numerics.sloped``) bound it over a box. The pair at which one design of the box overlaps the most
moves little from box to box: it is looked for from those that are known.

Source: B. Sz.-Nagy, Über Parallelmengen nichtkonvexer ebener Bereiche, Acta Sci. Math. 20 (1959), for the lengths.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from camopt.effects.case import Setup
from camopt.effects.crossing import find_crossing
from camopt.effects.parts import drawn, motion_at, start_of
from camopt.mechanisms.design import BoolArray, Designs
from camopt.motion.programme import Programme
from camopt.numerics import GIVEN, FloatArray
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, variables, widened

MOST_KNOWN = 4
STEPS, FIRST = 16, np.pi / 45  # of the search for the deepest overlap; how far the first one goes, rad
MOVES = np.array([(0, 0), *((a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b)])
LOST = 16.0 * GIVEN  # relative, of the height or angle at displacement 0 by rounding
START = "start"


class KnownCrossings:
    """A search among the cams of a programme, and where their profiles were found to cross."""

    def __init__(self, setup: Setup, programme: Programme) -> None:
        self._setup, self._programme = setup, programme
        self._known: list[FloatArray] = []
        """Pairs of cam angles in rad, the latest first."""

    def excess(self, box: Designs, inside: Designs, free: Sequence[str]) -> Sloped:
        """Over boxes (Intervals), a quantity above 0 only where a design crosses itself or is undercut.

        ``inside`` is one design of each, which can be assembled. Where no known crossing shows that it crosses
        itself, another one is looked for, at the box of the smallest cams.
        """
        found = self._excess(box, inside, free)
        unseen = np.flatnonzero(found.at.low <= 0.0)
        if unseen.size and self.learn(inside.take(unseen[[np.argmin(as_interval(box.size).low[unseen])]])):
            found = self._excess(box, inside, free)
        return found

    def shown(self, designs: Designs) -> BoolArray:
        """Which designs are seen to cross themselves where others do."""
        return np.asarray(self._excess(designs, designs, ("size",)).at.low > 0.0)

    def learn(self, design: Designs) -> bool:
        """Whether a design is shown to cross itself; where it does is then known."""
        found = find_crossing(self._setup, design, self._programme)
        if found.shown:
            pair = deepest(self._setup, design, self._programme, np.array([found.at]))
            self._known = [pair, *self._known][:MOST_KNOWN]
        return found.shown is True

    def _excess(self, box: Designs, inside: Designs, free: Sequence[str]) -> Sloped:
        known = np.concatenate(self._known or [np.zeros((1, 2))])
        nearest = known[depth(self._setup, inside, self._programme, known[None]).argmax(axis=1)]
        pairs = deepest(self._setup, inside, self._programme, nearest)
        return overlap_in(self._setup, box, inside, free, self._programme, pairs)


def overlap(
    setup: Setup, designs: Designs, start: Any, angles: FloatArray, motion: Any, other: Any
) -> tuple[Any, Any]:
    """(2·R_r·Δ·n(a) − |Δ|²)·|C'(a)| in mm³/rad, and |C'(a)|. Numbers, ranges or ranges with slopes.

    ``start`` is the height or angle at displacement 0, ``angles`` are (..., 2) pairs (a, b) in rad, ``motion`` is
    (y, y') at a and ``other`` y at b. Vectors are in the ground frame at a.
    """
    assert setup.mechanism.trace_point is not None
    (x, z), (along, up) = drawn(setup, designs, start + motion[0], motion[1])
    u, w = setup.mechanism.trace_point(designs, start + other)
    turn = designs.sense * (angles[..., 1] - angles[..., 0])
    cosine, sine = np.cos(turn), np.sin(turn)
    gap_x, gap_z = x - (u * cosine + w * sine), z - (w * cosine - u * sine)
    speed = np.sqrt(np.square(along) + np.square(up))
    outwards = designs.sense * (gap_z * along - gap_x * up)
    return 2.0 * designs.roller_radius * outwards - (np.square(gap_x) + np.square(gap_z)) * speed, speed


def depth(setup: Setup, designs: Designs, programme: Programme, angles: FloatArray) -> FloatArray:
    """R_r² − |P(a) − C(b)|² in mm² of n designs, (n, m), at pairs of cam angles in rad, (n or 1, m, 2)."""
    column, table = designs.take((slice(None), None)), programme.table
    motion, (other, _) = motion_at(table, angles[..., 0]), motion_at(table, angles[..., 1])
    found, speed = overlap(setup, column, start_of(setup, column), angles, motion, other)
    return np.asarray(found / speed)


def deepest(setup: Setup, designs: Designs, programme: Programme, near: FloatArray) -> FloatArray:
    """Pairs of cam angles (n, 2) in rad, uphill from those near: a local maximum of the depth of n designs."""
    every, pairs, step = np.arange(len(designs)), near, np.full((len(designs), 1), FIRST)
    for _ in range(STEPS):
        moved = pairs[:, None] + step[:, None] * MOVES
        best = depth(setup, designs, programme, moved).argmax(axis=1)
        pairs, step = moved[every, best], np.where(best[:, None] == 0, step / 2, step)
    return pairs


def overlap_in(
    setup: Setup, box: Designs, inside: Designs, free: Sequence[str], programme: Programme, pairs: FloatArray
) -> Sloped:
    """The overlap at one pair of cam angles each, over boxes of designs, and how it changes with the free sizes.

    Its range is that by the free sizes, and that with the follower's height or angle at displacement 0 in place of
    the cam's size, by which it changes without bounds where a follower can only just be assembled.
    """
    sizes: dict[str, Any] = box.sizes
    sides = {name: (as_interval(sizes[name]), inside.sizes[name]) for name in free}
    error = programme.table.error.max(axis=0)
    (y, y1), (y_b, _) = (motion_at(programme.table, angles) for angles in pairs.T)
    motion, other = (_rounded(y, error[0]), _rounded(y1, error[1])), _rounded(y_b, error[0])

    def sloped(sides: dict[str, tuple[Interval, FloatArray]]) -> Sloped:
        found: dict[str, Any] = dict(zip(sides, variables(*zip(*sides.values(), strict=True)), strict=True))
        start = found.pop(START, None)
        designs = replace(inside, **found)
        start = start_of(setup, designs) if start is None else start
        over: Sloped = overlap(setup, designs, start, pairs, motion, other)[0]
        return over

    with np.errstate(all="ignore"):
        by_size = sloped(sides)
        del sides["size"]
        by_start = sloped(
            {START: (widened(as_interval(start_of(setup, box)), LOST), start_of(setup, inside))} | sides
        )
    value = Interval(
        np.fmax(by_size.value.low, by_start.value.low), np.fmin(by_size.value.high, by_start.value.high)
    )
    return replace(by_size, value=value)


def _rounded(value: FloatArray, error: float) -> Interval:
    return Interval(value - error, value + error)

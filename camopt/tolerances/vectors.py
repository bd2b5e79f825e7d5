"""Proofs of errors of which some have a direction: each is a vector with two coordinates, no longer than ε.

With the slopes g by both of its coordinates, over a part with the middle p,

    g·(x − p) ≤ ε·|g| − g·p,    g·(x − p) ≤ gₙ·(ε − p·n) + |gₜ|·|x − p|

along the direction n of the middle slopes and across it, so that hardly more than the cam angle is cut. The worst
vector is as long as it may be, and along its slopes: of a part those alone are left that have a direction of them.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms import Designs
from camopt.numerics import GIVEN, FloatArray
from camopt.numerics.interval import INTERVAL_RULES, Interval, as_interval
from camopt.numerics.sloped import Sloped
from camopt.tolerances.bounded import Tried
from camopt.tolerances.errors import is_way, polar, way_of
from camopt.verdicts.claim_boxes import Ends, Parts, Search

NARROW = 0.5
"""Within which angle of the middle one slopes have to be, rad, for a vector to be taken along them."""
ROOM = 1e-9
"""Relative, for rounding of how long vectors are."""


def box_of(ends: Ends) -> dict[str, tuple[float, float]]:
    """Between which values each number of errors is, with both coordinates of those that have a way."""
    found = dict[str, tuple[float, float]]()
    for key, (low, high) in ends.items():
        if not is_way(key):
            found |= dict.fromkeys((key, way_of(key)), (-high, high)) if way_of(key) in ends else {key: (low, high)}
    return found


@dataclass(frozen=True)
class VectorSearch(Search):
    """The search for a cam that exceeds a bound, which knows how long vectors are."""

    ends: Ends = field(default_factory=dict)
    """Between which values errors are, with those that have a way as a length and an angle."""

    def tried(self, parts: Parts) -> Tried:
        """Whether there is none, and one by length and angle, if one is found."""
        answer = self.run(parts)
        if answer.witness is None:
            return Tried(answer.verdict)
        numbers = {key: float(answer.witness.numbers[key][0]) for key in self.names}
        cam = {key: float(each) for key, each in polar(numbers, self.ends).items()}
        return Tried(answer.verdict, cam | {key: min(cam[key], self.ends[key][1]) for key in self._with_way})

    @cached_property
    def _with_way(self) -> dict[str, str]:
        return {key: way_of(key) for key in self.ends if not is_way(key) and way_of(key) in self.ends}

    @cached_property
    def _vectors(self) -> list[tuple[list[int], float]]:
        """The rows of both coordinates in parts, and the largest length."""
        rows = {name: 1 + number for number, name in enumerate(self.names)}
        return [([rows[key], rows[way]], self.ends[key][1]) for key, way in self._with_way.items()]

    def excess(self, parts: Parts) -> Sloped:
        """With what vectors that are no longer than they may be bring at most."""
        found = super().excess(parts)
        moved, sides = found.slopes * found.span, (found.slopes * found.span).high
        beyond, inside = np.zeros(parts.size), np.ones(parts.size, dtype=bool)
        for both, longest in self._vectors:
            nearest = np.maximum(np.maximum(parts.low[both], -parts.high[both]), 0.0)
            inside &= np.hypot(*nearest) <= longest * (1.0 + ROOM)
            beyond += np.fmin(_brought(parts, found.slopes, both, longest), sides[both].sum(axis=0))
            sides[both] = 0.0
        top = found.at.high + sides.sum(axis=0) + beyond
        top += GIVEN * (np.abs(found.at.high) + moved.largest_magnitude.sum(axis=0) + np.abs(beyond))
        top = np.where(inside, np.fmin(found.value.high, top), -1.0)
        at = Interval(self._least(parts, found), found.at.high)
        return replace(found, value=Interval(np.minimum(found.value.low, top), top), at=at)

    def _least(self, parts: Parts, found: Sloped) -> FloatArray:
        """The excess of a cam of each part at least (``point``)."""
        low, known = found.at.low.copy(), np.ones(parts.size, dtype=bool)
        for both, longest in self._vectors:
            to = _end(parts, found.slopes, both, longest)
            known &= np.all((parts.low[both] <= to) & (to <= parts.high[both]), axis=0)
            low += (found.slopes[both] * (to - _middle(parts, both))).low.sum(axis=0)
        return np.where(known, low - GIVEN * np.abs(low), -inf)

    def point(self, parts: Parts, number: int) -> Designs:
        part = parts.take(np.array([number]))
        with np.errstate(all="ignore"):
            slopes, found = super().excess(part).slopes, super().point(part, 0)
        ends = dict[str, FloatArray]()
        for both, longest in self._vectors:
            names = [self.names[each - 1] for each in both]
            ends |= dict(zip(names, _end(part, slopes, both, longest), strict=True))
        return found.with_values(ends)

    def narrowed(self, parts: Parts, slopes: Interval) -> Parts:
        """By the slopes of what has no way; and of vectors with those alone that may be the worst."""
        low, high = slopes.low.copy(), slopes.high.copy()
        for both, _ in self._vectors:
            low[both], high[both] = -1.0, 1.0  # neither end alone is left
        found = parts.monotone(Interval(low, high))
        low, high = found.low.copy(), found.high.copy()
        for both, longest in self._vectors:
            (along, off), way = _turned(slopes, both)
            across: Any = INTERVAL_RULES[np.arctan2](off, as_interval(along.low))
            chosen = (along.low > 0.0) & (across.largest_magnitude < NARROW)
            ends = Interval(across.low + way, across.high + way)
            for row, each in zip(both, (np.cos(ends), np.sin(ends)), strict=True):
                low[row] = np.where(chosen, np.maximum(low[row], longest * (each.low - ROOM)), low[row])
                high[row] = np.where(chosen, np.minimum(high[row], longest * (each.high + ROOM)), high[row])
            high[both] = np.maximum(low[both], high[both])  # one stands for none
        return replace(found, low=low, high=high)

    def steepness(self, slopes: Interval) -> FloatArray:
        """Of vectors how much their slopes change: that is what cuts take off."""
        found = slopes.largest_magnitude
        for both, _ in self._vectors:
            found[both] = slopes[both].high - slopes[both].low
        return found


def _brought(parts: Parts, slopes: Interval, both: list[int], longest: float) -> FloatArray:
    """What a vector of a part brings at most, beyond the one in the middle."""
    middle, half = _middle(parts, both), (parts.high[both] - parts.low[both]) / 2.0
    longest *= 1.0 + ROOM
    anywhere = longest * np.hypot(*slopes[both].largest_magnitude) - (slopes[both] * middle).low.sum(axis=0)
    (along, across), way = _turned(slopes, both)
    cosine, sine = np.abs(np.cos(way)), np.abs(np.sin(way))
    out, aside = cosine * half[0] + sine * half[1], sine * half[0] + cosine * half[1]
    room = longest - (np.cos(way) * middle[0] + np.sin(way) * middle[1])
    further = along * Interval(-out, np.clip(room, -out, out))
    return np.asarray(np.fmin(anywhere, further.high + across.largest_magnitude * aside))


def _end(parts: Parts, slopes: Interval, both: list[int], longest: float) -> FloatArray:
    """A vector of each part: in its middle, or where it brings the most if it may have any direction."""
    middle, way = _middle(parts, both), (slopes[both].low + slopes[both].high) / 2.0
    any_way = _any(parts, both, longest)
    to = np.where(any_way, way, middle)
    size = np.hypot(*to)
    short = np.where(any_way, longest, np.minimum(size, longest)) * (1.0 - ROOM)
    return np.asarray(to / np.where(size > 0.0, size, 1.0) * short)


def _any(parts: Parts, both: list[int], longest: float) -> NDArray[np.bool_]:
    """Of which parts a vector may have any direction."""
    return np.asarray(np.all((parts.low[both] <= -longest) & (parts.high[both] >= longest), axis=0))


def _turned(slopes: Interval, both: list[int]) -> tuple[tuple[Interval, Interval], FloatArray]:
    """Slopes by both coordinates, along the middle ones and across them, and the direction of these."""
    x, y = slopes[both[0]], slopes[both[1]]
    way = np.arctan2(y.low + y.high, x.low + x.high)
    return (x * np.cos(way) + y * np.sin(way), y * np.cos(way) - x * np.sin(way)), way


def _middle(parts: Parts, rows: list[int]) -> FloatArray:
    return np.asarray((parts.low[rows] + parts.high[rows]) / 2.0)

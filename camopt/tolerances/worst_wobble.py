"""How far the tool of any cam within the tolerances moves while it should dwell: a bound and a witness.

On the arc of a dwell y is constant, so that the exact place of a follower (``mechanisms.rest``) depends on nothing
that changes along the arc but the direction of the bore's axis in the ground, which goes on with the cam by the
angle a from one place to another, and the profile, which may be off otherwise there. All else that is off is the
same at both places. What a cam wobbles is the difference of both exact places,

    Δ = f*(y + moved₁) − f*(y + moved₂)

with its own links in f*. Run on ranges with slopes, what both have in common cancels in the slopes, and the bound
is proved as that of the displacement (``tolerances.worst_case``): of errors, of a direction, and of a.

An error of the profile with at most n waves in a turn, within ±t, differs at two places by at most 2·t·sin(n·a/2),
up to n·a = π (Boas), as a sine of n waves does. It is taken as p at one and as p − d at the other, with any p
within ±t and d up to this: what p − d is beyond −t is of second order. Where n·a can be π both are anything in ±t.

Sources: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11; R. P. Boas,
Entire Functions, ch. 11.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.motion import scale
from camopt.mechanisms import Designs
from camopt.motion.stroke import Stroke
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST, FloatArray
from camopt.numerics.clock import now, share
from camopt.numerics.curves import formula
from camopt.problem.claims import Claim, Plain
from camopt.tolerances.bounded import SECONDS, Bounded, Gaps, Tried, Values, bounded
from camopt.tolerances.errors import BORE, BORE_WAY, flat, polar, turned_on
from camopt.tolerances.off_train import between
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.vectors import box_of
from camopt.tolerances.worst_case import Proof, WorstSearch
from camopt.tolerances.worst_pairs import worst_search
from camopt.verdicts.claim_boxes import Ends, Parts

GAPS = Gaps((1e-2,), (1e-3, 1e-4))
"""By no more than this, relative, a cam is worse than the worst found: the last that is proved."""
LAG = "lag"
"""The variable that is the cam angle from the highest place to the lowest one, rad."""
LOWEST = " (lowest)"
"""After the key of a profile: how far it is off at the lowest place, mm; with few waves a share of otherwise."""
COARSE, FINE, ZOOMS = 33, 17, 3
"""How many directions and lags are looked at, and how many closer about the best, so often."""
WIDER = 1.5
"""How far to either side of the best it is looked at next, of the step before."""


class WorstWobble(NamedTuple):
    """The largest distance that the tool of any cam within the tolerances moves in a dwell.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(tolerances={"bore_eccentricity": 0.01})
    >>> worst = camopt.tolerance(scene).dwells[0].worst_case
    >>> worst.change <= worst.bound, worst.unproved
    (True, '')
    """

    bound: float
    """No cam within the tolerances moves the tool further on the arc of the dwell, proved; infinite if that is not
    known. mm (deg)."""
    change: float
    """How far a cam moves it that has these ``errors``, by exact contact, mm (deg)."""
    highest_deg: float
    """The cam angle at which it is the furthest out."""
    lowest_deg: float
    errors: dict[str, float]
    """Of that cam, by key of ``[tolerances]``, mm and deg, as those of ``WorstCase``; of the profile where the tool
    is highest."""
    at_lowest: dict[str, float]
    """What is off otherwise where it is lowest: the profile, mm."""
    unproved: str = ""
    """Why no bound is proved; "" if one is."""

    @property
    def gap(self) -> float:
        """By how much some cam may be worse than that one."""
        return self.bound - self.change


class Wobble(NamedTuple):
    """How much higher the tool is at one place of a dwell than at another, mm (rad); on ranges with slopes."""

    search: "WobbleSearch"
    design: Designs
    errors: Mapping[str, Any]


@formula(Wobble)
def wobble(f, i, at):  # type: ignore[no-untyped-def]
    of = f.search.of
    first, second = (of.resting(f.design, each, at) for each in f.search.both(f.errors))
    return between(of.problem, f.errors, first, second, at.y), 0.0


@dataclass(frozen=True)
class WobbleSearch:
    """The search for the cam that wobbles the most in a dwell."""

    of: WorstSearch
    stroke: Stroke
    """The dwell (``Programme.dwells``)."""

    @cached_property
    def profiles(self) -> dict[str, float]:
        """The zone of each profile, by its key."""
        return {key: high for key, (_, high) in self.of.ends.items() if key.partition(" ")[0] == "profile"}

    @cached_property
    def ends(self) -> dict[str, tuple[float, float]]:
        """Between which values each variable is: the errors first."""
        most = min(self.stroke.angle, pi)
        lag = {LAG: (-most, most)} if BORE_WAY in self.of.ends or (self.profiles and self.slow) else {}
        lowest = {key + LOWEST: (-1.0, 1.0) if self.slow else self.of.ends[key] for key in self.profiles}
        return {**self.of.ends, **lag, **lowest}

    @property
    def slow(self) -> int:
        """The number of waves, if a profile cannot go from one end of its zone to the other in the dwell."""
        waves = self.of.turn.scene.tolerances.waves or 0
        return waves if waves * self.stroke.angle < pi else 0

    @property
    def wobbles(self) -> bool:
        """Whether anything changes along the arc."""
        return bool(self.profiles) or BORE_WAY in self.of.ends

    def both(self, values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Errors at the highest place and at the lowest one, flat."""
        first = {key: values[key] for key in self.of.ends}
        second = turned_on(first, values[LAG] * self.of.problem.design.sense) if BORE_WAY in first else dict(first)
        for key in self.profiles:
            lowest = values[key + LOWEST]
            second[key] = first[key] - self._swung(key, values) * 2.0 if self.slow else lowest
        return first, second

    def _swung(self, key: str, values: Mapping[str, Any]) -> Any:
        """By how much a profile with few waves is off its middle at both places, mm."""
        return np.sin(np.absolute(values[LAG]) * (0.5 * self.slow)) * (values[key + LOWEST] * self.profiles[key])

    def cam(self, values: Values) -> Values:
        """Values that a cam has: a sine of few waves is as far off on either side."""
        return values | {key: float(self._swung(key, values)) for key in self.profiles if self.slow}

    def run(self, until: float) -> WorstWobble:
        """The worst cam that is found, and what no cam exceeds."""
        if not self.wobbles:
            start = degrees(self.stroke.start)
            return WorstWobble(0.0, 0.0, start, start, {}, {})
        values = self.highest()
        return self._told(bounded(self._change(values), values, self.proof, self._worse, until, GAPS, SECONDS))

    def _told(self, found: Bounded[Values]) -> WorstWobble:
        middle, half = self.stroke.start + 0.5 * self.stroke.angle, 0.5 * found.cam.get(LAG, self.stroke.angle)
        cams = [polar(each, self.of.ends) for each in self.both(flat(found.cam))]
        (start, highest), (end, lowest) = (
            self._at(errors, place) for errors, place in zip(cams, (middle - half, middle + half), strict=True)
        )
        unit, otherwise = scale(self.of.problem.setup, 0), {key: lowest[key] for key in self.profiles}
        return WorstWobble(unit * found.bound, unit * found.found, start, end, highest, otherwise, found.unproved)

    def _at(self, errors: Values, place: float) -> tuple[float, Values]:
        """The cam angle at which a cam touches, deg, and its errors in mm and deg."""
        angle = self.of.contact(errors, np.array([place])).angle
        return degrees(float(self.of.within(angle)[0])), self.of.said(errors, place, float(angle[0]))

    def proof(self, bound: float, until: float) -> Tried:
        """Whether no cam within the tolerances wobbles more."""
        return self._proof(bound, until).tried(self._parts)

    def _proof(self, bound: float, until: float) -> Proof:
        problem = self.of.problem
        return Proof(problem, self._claim(bound), problem.design, tuple(self._box), until, self.ends)

    @cached_property
    def _box(self) -> Ends:
        return box_of(self.ends)

    def _claim(self, bound: float) -> Claim:
        def curve(designs: Designs, programme: Any) -> Any:
            return Wobble(self, designs, {key: designs.numbers[key] for key in self._box})

        return Claim(curve, ALL_STROKES, LARGEST, Plain(bound))

    @cached_property
    def _parts(self) -> Parts:
        """All cams, with a panel of the dwell."""
        table, middle = self.of.problem.programme.table, self.stroke.start + 0.5 * self.stroke.angle
        panel = np.searchsorted(table.centre + table.half_width, self.of.within(np.array([middle])))
        return Parts.of(panel, self._claim(1.0), self._box)

    def _change(self, values: Values) -> float:
        return float(self._changes([values])[0])

    def _worse(self, values: Values, bound: float) -> tuple[float, Values]:
        """What a cam has that was found to exceed a bound."""
        cam = self.cam(values)
        return self._change(cam), cam

    def _changes(self, cams: Sequence[Values]) -> FloatArray:
        """How much higher the tools of cams are at the first place than at the second one."""
        parts = self._parts.take(np.zeros(len(cams), dtype=int))
        place = np.array([[0.0, *(each[key] for key in self._box)] for each in map(flat, cams)]).T
        with np.errstate(all="ignore"):
            found, *_ = self._proof(1.0, inf).curve_over(replace(parts, low=place, high=place))
        return np.asarray((found.at.low + found.at.high) / 2.0)

    def highest(self) -> Values:
        """The cam that wobbles the most, or nearly so."""
        best = {key: high for key, (_, high) in self.ends.items()}
        best |= {key + LOWEST: -zone for key, zone in self.profiles.items() if not self.slow}
        ranges = {key: self.ends[key] for key in (BORE_WAY, LAG) if key in self.ends}
        for count in (COARSE, *[FINE] * ZOOMS):
            tried = product(*(np.linspace(*each, count) for each in ranges.values()))
            best = self._best([best | dict(zip(ranges, map(float, each), strict=True)) for each in tried])
            ranges = {key: self._about(key, best[key], each, count) for key, each in ranges.items()}
            best = self._with_ends(best)
        return self.cam(best)

    def _with_ends(self, best: Values) -> Values:
        """With the better end of each error, and the better sense of each profile."""
        two = [(key, key + LOWEST) for key in self.profiles]
        of_two = {each for pair in two for each in pair}
        other = [{key: self.of.ends[key][0]} for key in self.of.ends if key not in (BORE_WAY, BORE, *of_two)]
        other += [{key: -best[key] for key in pair} for pair in two]
        alone, *changed = self._changes([self.cam(best | each) for each in ({}, *other)])
        for each, found in zip(other, changed, strict=True):
            best |= each if found > alone else {}
        return best

    def _best(self, cams: Sequence[Values]) -> Values:
        return cams[int(self._changes([self.cam(each) for each in cams]).argmax())]

    def _about(self, key: str, place: float, before: tuple[float, float], count: int) -> tuple[float, float]:
        """The range to look at next, about the best place of the one before."""
        half = WIDER * (before[1] - before[0]) / (count - 1)
        low, high = (-inf, inf) if key == BORE_WAY else self.ends[key]
        return max(place - half, low), min(place + half, high)


def worst_wobbles(turn: TurnErrors) -> Iterator[tuple[Stroke, WorstWobble]]:
    """The dwells of the motion with what cams wobble in each, in the order of the turn."""
    of, until = worst_search(turn), now() + SECONDS
    dwells = turn.problem.programme.tool.dwells
    for number, stroke in enumerate(dwells):
        yield stroke, WobbleSearch(of, stroke).run(share(until, len(dwells) - number))

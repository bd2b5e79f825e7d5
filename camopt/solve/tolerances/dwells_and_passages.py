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

When tools pass a position, of all cams within tolerances, proved by exact contact.

A cam passes a level about the cam angle of the nominal one. If at the cam angle θ no cam within the tolerances is
at the level yet,

    f(y(θ)) + δ(θ; x) ≤ level    for all errors x,

none passes it outward before θ; after θ, if at θ all are at the level or beyond it. Inward it is the other way
round. δ(θ; x) is the exact error at a given cam angle: each contact touches at a place φ with φ + turned(φ) = θ
(``tolerances.contact_ahead``), and

    δ = Σ (±moved + y(φ) − y(θ)) / contacts

comes through the train as that of the worst case does. Whether any cam is beyond is decided over boxes of errors at
the one cam angle. The cam that passes the first or the last is at those ends of its errors that move the tool the
furthest there; the proof is asked a little further out.

To first order the tool stands at y + upper or y + lower of its errors at worst (``tolerances.turn``). It may have
passed a level outward as soon as the first of them is there, and surely has when the second one is; inward the
other way round. No velocity divides an error: where the tool is slow, an angle is as far off as the motion takes to
make up for it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import product
from math import degrees, inf, isinf, pi
from operator import add
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import now, share
from camopt.core.numerics.sloped import as_sloped
from camopt.model.effects.motion import scale
from camopt.model.motion.stroke import Stroke
from camopt.solve.tolerances.bound import Bound, BoundSearch, Quantity, Values, box_of, first_parts, late
from camopt.solve.tolerances.enclosures import ContactAhead, Place, RestingContact, between, through
from camopt.solve.tolerances.errors import BORE, BORE_WAY, Errors, flat, polar, turned_on
from camopt.solve.tolerances.real_cam import TOUCHES, Moved, RealCam
from camopt.solve.tolerances.turn import TurnErrors, worst_ends
from camopt.solve.tolerances.worst_case import CORNERS, WorstSearch, worst_search
from camopt.solve.verdicts.claim_boxes import Parts

GAP = 1e-4
"""By no more than this, relative, a cam may wobble more than the worst found."""
SECONDS = 10.0
"""For the bounds of all dwells of a motion, and for those of all passages of a lift."""
GAPS = 1e-5, 1e-4, 1e-3, 1e-2
"""Relative, of the distance from the nominal passage: by no more than this a cam is further, the first proved."""
WORSE = 8
"""How often a worse cam than the worst so far is taken for it, for one gap."""
STEPS, FINER, ZOOMS = 1440, 33, 8
"""Cam angles of a turn that are looked at, and how often, and with how many, between two of them."""
NEVER = "some cam never passes it"
BEYOND = 1e-10
"""How much further out the proof is asked at least, rad."""
LAG = "lag"
"""The variable that is the cam angle from the highest place to the lowest one, rad."""
LOWEST = " (lowest)"
"""After the key of a profile: how far it is off at the lowest place, mm; with few waves a share of otherwise."""
COARSE, FINE, CLOSER = 33, 17, 3
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
        lag = values[LAG] * self.of.problem.design.sense if BORE_WAY in first else 0.0
        second = turned_on(first, BORE, lag)
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
        found = self.proof.run(self._parts, self._change(values), GAP, until)
        if found.cam is not None:
            values = max(values, self.cam(found.cam), key=self._change)
        return self._told(values, found.high, late(found.high, SECONDS, until))

    def _told(self, cam: Values, bound: float, unproved: str) -> WorstWobble:
        middle, half = self.stroke.start + 0.5 * self.stroke.angle, 0.5 * cam.get(LAG, self.stroke.angle)
        cams = [polar(each, self.of.ends) for each in self.both(flat(cam))]
        (start, highest), (end, lowest) = (
            self._at(errors, place) for errors, place in zip(cams, (middle - half, middle + half), strict=True)
        )
        unit, otherwise = scale(self.of.problem.setup, 0), {key: lowest[key] for key in self.profiles}
        return WorstWobble(unit * bound, unit * self._change(cam), start, end, highest, otherwise, unproved)

    def _at(self, errors: Values, place: float) -> tuple[float, Values]:
        """The cam angle at which a cam touches, deg, and its errors in mm and deg."""
        angle = self.of.contact(errors, np.array([place])).angle
        return degrees(float(self.of.cam.within(angle)[0])), self.of.said(errors, place, float(angle[0]))

    @cached_property
    def proof(self) -> BoundSearch:
        """The search for the bound of how much higher the tool of any cam is at one place than at another."""
        return BoundSearch(self.of.problem, self.wobble, self.ends, box_of(self.ends), frozenset({LAG}))

    def wobble(self, errors: Errors, at: Place) -> Any:
        """How much higher the tool is at one place of a dwell than at another, mm (rad), over boxes of errors."""
        cam = self.of.cam

        def moved(own: Errors) -> Any:
            rest = cam.rest(0, cam.problem.design, cam.own(0, own), at.motion, 0)
            first, turned = rest.moved.terms[0], rest.turned.terms[0]
            if len(cam.contacts) == 1:
                return first
            second = RestingContact(cam, 1, errors, own, at)
            return (first + second.moved(second.ahead(turned))) * 0.5

        first, second = map(moved, self.both(errors))
        return between(cam.problem, errors, first, second, at.y)

    @cached_property
    def _parts(self) -> Parts:
        """All cams, with a panel of the dwell."""
        table, middle = self.of.problem.programme.table, self.stroke.start + 0.5 * self.stroke.angle
        panel = np.searchsorted(table.centre + table.half_width, self.of.cam.within(np.array([middle])))
        return first_parts(self.of.problem, self.proof.box, panel, (1.0,))

    def _change(self, values: Values) -> float:
        return float(self._changes([values])[0])

    def _changes(self, cams: Sequence[Values]) -> FloatArray:
        """How much higher the tools of cams are at the first place than at the second one."""
        flat_ones = [flat(each) for each in cams]
        first, second = self.both({key: np.array([each[key] for each in flat_ones]) for key in self.proof.box})
        return self._stands(first) - self._stands(second)

    def _stands(self, errors: Errors) -> FloatArray:
        """How much further out the tools of cams (m,) are in the middle of the arc."""
        cam, size = self.of.cam, len(errors[next(iter(errors))])
        angle = cam.within(np.full(size, self.stroke.start + 0.5 * self.stroke.angle))

        def rest(number: int, ahead: Any = 0.0) -> Moved:
            contact = cam.contacts[number]
            motion = [*contact.programme.at(angle, 1)]
            return cam.rest(number, contact.design, cam.own(number, errors, ahead), motion, 0)

        found = rest(0)
        if len(cam.contacts) == 2:
            second = rest(1)
            for _ in range(TOUCHES):
                second = rest(1, found.turned.terms[0] - second.turned.terms[0])
            found = found._replace(moved=(found.moved - second.moved * cam.back) * 0.5)
        return cam.at_tool(errors, angle, [found.moved.terms[0] + np.zeros(size)]).error

    def highest(self) -> Values:
        """The cam that wobbles the most, or nearly so."""
        best = {key: high for key, (_, high) in self.ends.items()}
        best |= {key + LOWEST: -zone for key, zone in self.profiles.items() if not self.slow}
        ranges = {key: self.ends[key] for key in (BORE_WAY, LAG) if key in self.ends}
        for count in (COARSE, *[FINE] * CLOSER):
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


class WorstPassage(NamedTuple):
    """The cam angle before which, or after which, no cam within the tolerances passes a lift.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(tolerances={"profile": 0.01})
    >>> first = camopt.timing(scene, [1.0]).worst[0]
    >>> first.passage, first.end, first.bound_deg < first.found_deg < 34.1269
    ('rises', 'earliest', True)
    """

    lift: float
    """mm (deg), from the lowest position."""
    passage: str
    """"rises" where the tool passes outward, "falls" where inward."""
    end: str
    """"earliest" or "latest"."""
    bound_deg: float
    """No cam passes sooner, or later, proved; infinite if that is not known, or where some cam does not pass."""
    found_deg: float
    """A cam with these ``errors`` has passed then already, or not yet before, by exact contact."""
    errors: dict[str, float]
    """Of that cam, by key of ``[tolerances]``, mm and deg, as those of ``WorstCase``."""
    unproved: str = ""
    """Why there is no bound: none is proved, or some cam never passes; "" if there is one."""

    @property
    def gap_deg(self) -> float:
        """By how much some cam may be sooner or later than that one."""
        return 0.0 if self.bound_deg == self.found_deg else abs(self.bound_deg - self.found_deg)


Cams = Callable[[FloatArray], dict[str, FloatArray]]
"""Errors of cams by the places with which they touch."""


def angle_error(cam: RealCam) -> Quantity:
    """The exact error of the tool at a cam angle, mm (rad), over boxes of errors."""

    def error(errors: Errors, at: Place) -> Any:
        contacts = [ContactAhead(cam, number, errors, errors, at) for number in range(len(cam.contacts))]
        moved = reduce(add, (each.moved(each.ahead(as_sloped(0.0, at.y))) for each in contacts))
        return through(cam.problem, errors, [moved * (1.0 / len(contacts))], at.motion.__getitem__)

    return error


@dataclass(frozen=True)
class PassageSearch:
    """The search for the cam that passes a level the first, or the last."""

    of: WorstSearch
    level: float
    """mm (rad)."""
    angle: float
    """Where the nominal cam passes, rad."""
    way: float
    """−1 for the earliest, 1 for the latest."""
    side: float
    """1 where cams that stand out the most decide, −1 where those that stand back do."""

    def run(self, until: float) -> tuple[float, float, Values, str]:
        """How far from the nominal one no cam passes, and one with some errors does, rad; why nothing is proved."""
        place = self._passes(self.angle, self._corner)
        if isinf(place):
            return inf, inf, {}, NEVER
        found, errors = self._touching(place, self._corner)
        if self.of.problem.programme.corners:
            return inf, found, errors, CORNERS
        for gap in GAPS:
            for _ in range(WORSE):
                distance = found * (1.0 + gap)
                bound = self.proof(distance, until)
                if bound.high <= 0.0:
                    return distance, found, errors, ""
                if bound.cam is None or not bound.found > 0.0:
                    break
                more, other = self._beyond(bound.cam, distance)
                if more <= found:
                    break
                found, errors = more, other
        return inf, found, errors, late(inf, SECONDS, until)

    def _corner(self, places: FloatArray) -> dict[str, FloatArray]:
        """The errors of the furthest cams, where they touch with places."""
        return self.of.corner(self.of.cam.within(places), self.side)

    def _passes(self, start: float, errors: Cams) -> float:
        """The place with which cams touch that pass the furthest from a start."""

        def beyond(places: FloatArray) -> FloatArray:
            found = self.of.contact(errors(places), places)
            return self.side * (self._tool(found.angle) + found.error - self.level)

        return until(start, self.way, beyond)

    def _touching(self, place: float, errors: Cams) -> tuple[float, Values]:
        """How far from the nominal passage a cam touches with a place, and its errors at that cam angle."""
        cam = {key: float(each[0]) for key, each in errors(np.array([place])).items()}
        angle = float(self.of.contact(cam, np.array([place])).angle[0])
        if BORE_WAY in cam:  # in the ground at that cam angle, not where the point is touched
            cam[BORE_WAY] += self.of.problem.design.sense * (angle - place)
        return max(self.way * (angle - self.angle), 0.0), cam

    def _beyond(self, values: Values, distance: float) -> tuple[float, Values]:
        """Where a cam passes that is at the level, or beyond it, at a distance from the nominal passage."""
        angle, sense = self.angle + self.way * (distance + BEYOND), self.of.problem.design.sense

        def errors(places: FloatArray) -> dict[str, FloatArray]:
            found = {key: np.full(places.size, each) for key, each in values.items()}
            if BORE_WAY in found:
                found[BORE_WAY] += sense * (places - angle)
            return found

        place = np.array([angle])
        for _ in range(TOUCHES):
            place = place - (self.of.contact(errors(place), place).angle - angle)
        return self._touching(self._passes(float(place[0]), errors), errors)

    def _tool(self, angles: FloatArray) -> FloatArray:
        return np.asarray(self.of.problem.programme.tool.at(self.of.cam.within(angles))[0])

    def proof(self, distance: float, until: float) -> Bound:
        """By how much any cam is beyond the level already, or short of it still, at a distance from the passage."""
        table, error = self.of.problem.programme.table, angle_error(self.of.cam)
        angle = self.of.cam.within(np.array([self.angle + self.way * (distance + BEYOND)]))
        level = self.level - float(self._tool(angle)[0])
        search = self.of.proof(lambda errors, at: error(errors, at) - level)
        panel = np.minimum(np.searchsorted(table.centre + table.half_width, angle), table.centre.size - 1)
        parts = first_parts(self.of.problem, self.of.box, panel, (self.side,))
        parts.low[0] = parts.high[0] = (angle - table.centre[panel]) / table.half_width[panel]
        return search.run(parts, 0.0, 0.0, until, 0.0)

    def said(self, values: Values, distance: float) -> Values:
        """Errors in mm and deg, with the direction of the bore as the cam has it."""
        angle = self.angle + self.way * distance
        return self.of.said(values, angle, angle)


class Asked(NamedTuple):
    """A passage of the nominal cam."""

    lift: float
    """As it is told."""
    level: float
    """mm (rad)."""
    passage: str
    angle: float
    """rad."""


ENDS = {"earliest": -1.0, "latest": 1.0}
SIDES = {
    ("rises", "earliest"): 1.0,
    ("rises", "latest"): -1.0,
    ("falls", "earliest"): -1.0,
    ("falls", "latest"): 1.0,
}


def worst_passages(turn: TurnErrors, asked: list[Asked]) -> Iterator[WorstPassage]:
    """Those of the passages of the nominal cam, the earliest and the latest of each.

    BadInput for tolerances so large that a follower has no place on its cam.
    """
    of, until = worst_search(turn), now() + SECONDS
    every = [(each, end) for each in asked for end in ENDS]
    try:
        for number, (each, end) in enumerate(every):
            yield _worst(of, each, end, share(until, len(every) - number))
    except FloatingPointError:
        raise of.lost() from None


def _worst(of: WorstSearch, asked: Asked, end: str, until: float) -> WorstPassage:
    way = ENDS[end]
    search = PassageSearch(of, asked.level, asked.angle, way, SIDES[asked.passage, end])
    distance, found, cam, unproved = search.run(until)
    bound, passed = (degrees(asked.angle + way * each) for each in (distance + BEYOND, found))
    errors = search.said(cam, found) if cam else {}
    return WorstPassage(asked.lift, asked.passage, end, bound, passed, errors, unproved)


class PassedBetween(NamedTuple):
    """The cam angles between which all cams pass a level, rad: beyond the turn if need be; infinite if never."""

    earliest: float
    latest: float


@dataclass(frozen=True)
class Passing:
    """A level of the tool, and the turn of a cam with tolerances."""

    turn: TurnErrors
    level: float
    """mm (rad)."""

    def about(self, angle: float, *, outward: bool) -> PassedBetween:
        """When the cams pass that level which the nominal one passes at a cam angle, rad."""
        first, last = (1.0, -1.0) if outward else (-1.0, 1.0)
        return PassedBetween(self._until(angle, -1.0, first), self._until(angle, 1.0, last))

    def _until(self, angle: float, way: float, side: float) -> float:
        """How far backward or forward some cam still is at the level, at the upper or lower end of its error."""
        return until(angle, way, lambda angles: side * self._above(angles, side))

    def _above(self, angles: FloatArray, side: float) -> FloatArray:
        """How far above the level the tool is at an end of its error."""
        within = np.mod(angles, 2 * pi)
        ends = worst_ends(self.turn.at(within), 0)
        y = self.turn.problem.programme.tool.at(within)[0]
        return np.asarray(y + (ends.upper if side > 0.0 else ends.lower) - self.level)


def until(angle: float, way: float, above: Callable[[FloatArray], FloatArray]) -> float:
    """Up to which place, backward or forward from one, a value stays 0 or more; infinite if all over the turn."""
    near, far = 0.0, 2 * pi
    for count in (STEPS, *[FINER] * ZOOMS):
        steps = np.linspace(near, far, count)
        reached = above(angle + way * steps) >= 0.0
        reached[0] = True
        if reached.all():
            return way * inf if far == 2 * pi else angle + way * far
        first = int(np.argmin(reached))
        near, far = float(steps[first - 1]), float(steps[first])
    return angle + way * (near + far) / 2

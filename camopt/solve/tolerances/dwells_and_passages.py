"""How far the tool of any cam within the tolerances moves while it should dwell: a bound and a witness.

On the arc of a dwell y is constant, so that the exact place of a follower (``mechanisms.contact_errors``) depends
on nothing that changes along the arc but the direction of the bore's axis in the ground, which goes on with the cam
by the angle a from one place to another, and the profile, which may be off otherwise there. All else that is off is
the same at both places. What a cam wobbles is the difference of both exact places,

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
from camopt.core.numerics.clock import clock_seconds, time_share
from camopt.core.numerics.sloped_interval import as_sloped_interval
from camopt.model.effects.motion import motion_scale
from camopt.model.motion.stroke import Stroke
from camopt.solve.tolerances.bound_search import (
    BoundedQuantity,
    BoundSearch,
    ErrorValues,
    ProvedBound,
    coordinate_box,
    missing_bound_reason,
    whole_panel_parts,
)
from camopt.solve.tolerances.enclosures import (
    ContactAhead,
    PartMotion,
    RestingContact,
    difference_through_train,
    error_through_train,
)
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, Errors, flat_errors, polar_errors, turn_error
from camopt.solve.tolerances.real_cam import CONTACT_ROUNDS, ContactShiftSeries, RealCam
from camopt.solve.tolerances.turn_errors import TurnErrors, worst_case_range
from camopt.solve.tolerances.worst_case import CORNERS_REASON, WorstSearch, worst_search
from camopt.solve.verdicts.constraint_boxes import BoxParts

WOBBLE_GAP = 1e-4
"""By no more than this, relative, a cam may wobble more than the worst found."""
MOTION_PROOF_SECONDS = 10.0
"""For the bounds of all dwells of a motion, and for those of all passages of a lift."""
PASSAGE_GAPS = 1e-5, 1e-4, 1e-3, 1e-2
"""Relative, of the distance from the nominal passage: by no more than this a cam is further, the first proved."""
WORSE_PASSAGES = 8
"""How often a worse cam than the worst so far is taken for it, for one gap."""
TURN_STEPS, FINER_STEPS, PASSAGE_ZOOMS = 1440, 33, 8
"""Cam angles of a turn that are looked at, and how often, and with how many, between two of them."""
NEVER_PASSES = "some cam never passes it"
PROOF_OFFSET = 1e-10
"""How much further out the proof is asked at least, rad."""
LAG_KEY = "lag"
"""The variable that is the cam angle from the highest place to the lowest one, rad."""
LOWEST_SUFFIX = " (lowest)"
"""After the key of a profile: how far it is off at the lowest place, mm; with few waves a share of otherwise."""
COARSE_GRID, FINE_GRID, GRID_ZOOMS = 33, 17, 3
"""How many directions and lags are looked at, and how many closer about the best, so often."""
ZOOM_WIDTH = 1.5
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

    cam_search: WorstSearch
    stroke: Stroke
    """The dwell (``Programme.dwells``)."""

    @cached_property
    def profile_zones(self) -> dict[str, float]:
        """The zone of each profile, by its key."""
        return {
            key: high
            for key, (_, high) in self.cam_search.error_ranges.items()
            if key.partition(" ")[0] == "profile"
        }

    @cached_property
    def variable_ranges(self) -> dict[str, tuple[float, float]]:
        """Between which values each variable is: the errors first."""
        most = min(self.stroke.angle, pi)
        lag = (
            {LAG_KEY: (-most, most)}
            if BORE_DIRECTION in self.cam_search.error_ranges or (self.profile_zones and self.slow_waves)
            else {}
        )
        lowest = {
            key + LOWEST_SUFFIX: (-1.0, 1.0) if self.slow_waves else self.cam_search.error_ranges[key]
            for key in self.profile_zones
        }
        return {**self.cam_search.error_ranges, **lag, **lowest}

    @property
    def slow_waves(self) -> int:
        """The number of waves, if a profile cannot go from one end of its zone to the other in the dwell."""
        waves = self.cam_search.turn.scene.tolerances.waves or 0
        return waves if waves * self.stroke.angle < pi else 0

    @property
    def can_wobble(self) -> bool:
        """Whether anything changes along the arc."""
        return bool(self.profile_zones) or BORE_DIRECTION in self.cam_search.error_ranges

    def errors_at_both_places(self, values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Errors at the highest place and at the lowest one, flat."""
        first = {key: values[key] for key in self.cam_search.error_ranges}
        lag = values[LAG_KEY] * self.cam_search.problem.design.sense if BORE_DIRECTION in first else 0.0
        second = turn_error(first, BORE, lag)
        for key in self.profile_zones:
            lowest = values[key + LOWEST_SUFFIX]
            second[key] = first[key] - self._profile_swing(key, values) * 2.0 if self.slow_waves else lowest
        return first, second

    def _profile_swing(self, key: str, values: Mapping[str, Any]) -> Any:
        """By how much a profile with few waves is off its middle at both places, mm."""
        return np.sin(np.absolute(values[LAG_KEY]) * (0.5 * self.slow_waves)) * (
            values[key + LOWEST_SUFFIX] * self.profile_zones[key]
        )

    def cam_values(self, values: ErrorValues) -> ErrorValues:
        """Values that a cam has: a sine of few waves is as far off on either side."""
        return values | {
            key: float(self._profile_swing(key, values)) for key in self.profile_zones if self.slow_waves
        }

    def run(self, until: float) -> WorstWobble:
        """The worst cam that is found, and what no cam exceeds."""
        if not self.can_wobble:
            start = degrees(self.stroke.start)
            return WorstWobble(0.0, 0.0, start, start, {}, {})
        values = self.largest_wobble()
        found = self.bound_search.run(self._dwell_parts, self._height_change(values), WOBBLE_GAP, until)
        if found.witness is not None:
            values = max(values, self.cam_values(found.witness), key=self._height_change)
        return self._make_worst_wobble(
            values, found.high, missing_bound_reason(found.high, MOTION_PROOF_SECONDS, until)
        )

    def _make_worst_wobble(self, cam: ErrorValues, bound: float, unproved: str) -> WorstWobble:
        middle, half = self.stroke.start + 0.5 * self.stroke.angle, 0.5 * cam.get(LAG_KEY, self.stroke.angle)
        cams = [
            polar_errors(each, self.cam_search.error_ranges)
            for each in self.errors_at_both_places(flat_errors(cam))
        ]
        (start, highest), (end, lowest) = (
            self._contact_angle_and_errors(errors, place)
            for errors, place in zip(cams, (middle - half, middle + half), strict=True)
        )
        unit, otherwise = (
            motion_scale(self.cam_search.problem.setup, 0),
            {key: lowest[key] for key in self.profile_zones},
        )
        return WorstWobble(unit * bound, unit * self._height_change(cam), start, end, highest, otherwise, unproved)

    def _contact_angle_and_errors(self, errors: ErrorValues, place: float) -> tuple[float, ErrorValues]:
        """The cam angle at which a cam touches, deg, and its errors in mm and deg."""
        angle = self.cam_search.contact_error(errors, np.array([place])).angle
        return degrees(float(self.cam_search.cam.angles_in_turn(angle)[0])), self.cam_search.errors_in_mm_and_deg(
            errors, place, float(angle[0])
        )

    @cached_property
    def bound_search(self) -> BoundSearch:
        """The search for the bound of how much higher the tool of any cam is at one place than at another."""
        return BoundSearch(
            self.cam_search.problem,
            self.enclose_wobble,
            self.variable_ranges,
            coordinate_box(self.variable_ranges),
            frozenset({LAG_KEY}),
        )

    def enclose_wobble(self, errors: Errors, at: PartMotion) -> Any:
        """How much higher the tool is at one place of a dwell than at another, mm (rad), over boxes of errors."""
        cam = self.cam_search.cam

        def follower_shift(own: Errors) -> Any:
            rest = cam.contact_shift(0, cam.problem.design, cam.errors_of_contact(0, own), at.motion, 0)
            first, turned = rest.follower_shift.terms[0], rest.cam_turn.terms[0]
            if len(cam.contacts) == 1:
                return first
            second = RestingContact(cam, 1, errors, own, at)
            return (first + second.follower_shift(second.angle_ahead(turned))) * 0.5

        first, second = map(follower_shift, self.errors_at_both_places(errors))
        return difference_through_train(cam.problem, errors, first, second, at.y)

    @cached_property
    def _dwell_parts(self) -> BoxParts:
        """All cams, with a panel of the dwell."""
        table, middle = self.cam_search.problem.programme.table, self.stroke.start + 0.5 * self.stroke.angle
        panel = np.searchsorted(
            table.centre + table.half_width, self.cam_search.cam.angles_in_turn(np.array([middle]))
        )
        return whole_panel_parts(self.cam_search.problem, self.bound_search.box, panel, (1.0,))

    def _height_change(self, values: ErrorValues) -> float:
        return float(self._height_changes([values])[0])

    def _height_changes(self, cams: Sequence[ErrorValues]) -> FloatArray:
        """How much higher the tools of cams are at the first place than at the second one."""
        flat_ones = [flat_errors(each) for each in cams]
        first, second = self.errors_at_both_places(
            {key: np.array([each[key] for each in flat_ones]) for key in self.bound_search.box}
        )
        return self._tool_heights(first) - self._tool_heights(second)

    def _tool_heights(self, errors: Errors) -> FloatArray:
        """How much further out the tools of cams (m,) are in the middle of the arc."""
        cam, size = self.cam_search.cam, len(errors[next(iter(errors))])
        angle = cam.angles_in_turn(np.full(size, self.stroke.start + 0.5 * self.stroke.angle))

        def rest(number: int, ahead: Any = 0.0) -> ContactShiftSeries:
            contact = cam.contacts[number]
            motion = [*contact.programme.motion_at(angle, 1)]
            return cam.contact_shift(
                number, contact.design, cam.errors_of_contact(number, errors, ahead), motion, 0
            )

        found = rest(0)
        if len(cam.contacts) == 2:
            second = rest(1)
            for _ in range(CONTACT_ROUNDS):
                second = rest(1, found.cam_turn.terms[0] - second.cam_turn.terms[0])
            found = found._replace(
                follower_shift=(found.follower_shift - second.follower_shift * cam.second_motion_sign) * 0.5
            )
        return cam.error_at_tool(errors, angle, [found.follower_shift.terms[0] + np.zeros(size)]).error

    def largest_wobble(self) -> ErrorValues:
        """The cam that wobbles the most, or nearly so."""
        best = {key: high for key, (_, high) in self.variable_ranges.items()}
        best |= {key + LOWEST_SUFFIX: -zone for key, zone in self.profile_zones.items() if not self.slow_waves}
        ranges = {
            key: self.variable_ranges[key] for key in (BORE_DIRECTION, LAG_KEY) if key in self.variable_ranges
        }
        for count in (COARSE_GRID, *[FINE_GRID] * GRID_ZOOMS):
            tried = product(*(np.linspace(*each, count) for each in ranges.values()))
            best = self._best_cam([best | dict(zip(ranges, map(float, each), strict=True)) for each in tried])
            ranges = {key: self._narrower_range(key, best[key], each, count) for key, each in ranges.items()}
            best = self._with_better_ends(best)
        return self.cam_values(best)

    def _with_better_ends(self, best: ErrorValues) -> ErrorValues:
        """With the better end of each error, and the better sense of each profile."""
        two = [(key, key + LOWEST_SUFFIX) for key in self.profile_zones]
        of_two = {each for pair in two for each in pair}
        other = [
            {key: self.cam_search.error_ranges[key][0]}
            for key in self.cam_search.error_ranges
            if key not in (BORE_DIRECTION, BORE, *of_two)
        ]
        other += [{key: -best[key] for key in pair} for pair in two]
        alone, *changed = self._height_changes([self.cam_values(best | each) for each in ({}, *other)])
        for each, found in zip(other, changed, strict=True):
            best |= each if found > alone else {}
        return best

    def _best_cam(self, cams: Sequence[ErrorValues]) -> ErrorValues:
        return cams[int(self._height_changes([self.cam_values(each) for each in cams]).argmax())]

    def _narrower_range(
        self, key: str, place: float, before: tuple[float, float], count: int
    ) -> tuple[float, float]:
        """The range to look at next, about the best place of the one before."""
        half = ZOOM_WIDTH * (before[1] - before[0]) / (count - 1)
        low, high = (-inf, inf) if key == BORE_DIRECTION else self.variable_ranges[key]
        return max(place - half, low), min(place + half, high)


def worst_wobbles(turn: TurnErrors) -> Iterator[tuple[Stroke, WorstWobble]]:
    """The dwells of the motion with what cams wobble in each, in the order of the turn."""
    of, until = worst_search(turn), clock_seconds() + MOTION_PROOF_SECONDS
    dwells = turn.problem.programme.tool.dwells
    for number, stroke in enumerate(dwells):
        yield stroke, WobbleSearch(of, stroke).run(time_share(until, len(dwells) - number))


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


ErrorsByPlace = Callable[[FloatArray], dict[str, FloatArray]]
"""Errors of cams by the places with which they touch."""


def error_at_cam_angle(cam: RealCam) -> BoundedQuantity:
    """The exact error of the tool at a cam angle, mm (rad), over boxes of errors."""

    def error(errors: Errors, at: PartMotion) -> Any:
        contacts = [ContactAhead(cam, number, errors, errors, at) for number in range(len(cam.contacts))]
        moved = reduce(
            add, (each.follower_shift(each.angle_ahead(as_sloped_interval(0.0, at.y))) for each in contacts)
        )
        return error_through_train(cam.problem, errors, [moved * (1.0 / len(contacts))], at.motion.__getitem__)

    return error


@dataclass(frozen=True)
class PassageSearch:
    """The search for the cam that passes a level the first, or the last."""

    cam_search: WorstSearch
    level: float
    """mm (rad)."""
    angle: float
    """Where the nominal cam passes, rad."""
    direction: float
    """−1 for the earliest, 1 for the latest."""
    side: float
    """1 where cams that stand out the most decide, −1 where those that stand back do."""

    def run(self, until: float) -> tuple[float, float, ErrorValues, str]:
        """How far from the nominal one no cam passes, and one with some errors does, rad; why nothing is proved."""
        place = self._passage_place(self.angle, self._extreme_errors)
        if isinf(place):
            return inf, inf, {}, NEVER_PASSES
        found, errors = self._passage_distance(place, self._extreme_errors)
        if self.cam_search.problem.programme.corners:
            return inf, found, errors, CORNERS_REASON
        for gap in PASSAGE_GAPS:
            for _ in range(WORSE_PASSAGES):
                distance = found * (1.0 + gap)
                bound = self.bound_at_distance(distance, until)
                if bound.high <= 0.0:
                    return distance, found, errors, ""
                if bound.witness is None or not bound.witness_value > 0.0:
                    break
                more, other = self._passage_of_witness(bound.witness, distance)
                if more <= found:
                    break
                found, errors = more, other
        return inf, found, errors, missing_bound_reason(inf, MOTION_PROOF_SECONDS, until)

    def _extreme_errors(self, places: FloatArray) -> dict[str, FloatArray]:
        """The errors of the furthest cams, where they touch with places."""
        return self.cam_search.extreme_errors(self.cam_search.cam.angles_in_turn(places), self.side)

    def _passage_place(self, start: float, errors: ErrorsByPlace) -> float:
        """The place with which cams touch that pass the furthest from a start."""

        def distance_beyond_level(places: FloatArray) -> FloatArray:
            found = self.cam_search.contact_error(errors(places), places)
            return self.side * (self._tool_positions(found.angle) + found.error - self.level)

        return sign_change_place(start, self.direction, distance_beyond_level)

    def _passage_distance(self, place: float, errors: ErrorsByPlace) -> tuple[float, ErrorValues]:
        """How far from the nominal passage a cam touches with a place, and its errors at that cam angle."""
        cam = {key: float(each[0]) for key, each in errors(np.array([place])).items()}
        angle = float(self.cam_search.contact_error(cam, np.array([place])).angle[0])
        if BORE_DIRECTION in cam:  # in the ground at that cam angle, not where the point is touched
            cam[BORE_DIRECTION] += self.cam_search.problem.design.sense * (angle - place)
        return max(self.direction * (angle - self.angle), 0.0), cam

    def _passage_of_witness(self, values: ErrorValues, distance: float) -> tuple[float, ErrorValues]:
        """Where a cam passes that is at the level, or beyond it, at a distance from the nominal passage."""
        angle, sense = self.angle + self.direction * (distance + PROOF_OFFSET), self.cam_search.problem.design.sense

        def errors(places: FloatArray) -> dict[str, FloatArray]:
            found = {key: np.full(places.size, each) for key, each in values.items()}
            if BORE_DIRECTION in found:
                found[BORE_DIRECTION] += sense * (places - angle)
            return found

        place = np.array([angle])
        for _ in range(CONTACT_ROUNDS):
            place = place - (self.cam_search.contact_error(errors(place), place).angle - angle)
        return self._passage_distance(self._passage_place(float(place[0]), errors), errors)

    def _tool_positions(self, angles: FloatArray) -> FloatArray:
        return np.asarray(
            self.cam_search.problem.programme.tool.motion_at(self.cam_search.cam.angles_in_turn(angles))[0]
        )

    def bound_at_distance(self, distance: float, until: float) -> ProvedBound:
        """By how much any cam is beyond the level already, or short of it still, at a distance from the passage."""
        table, error = self.cam_search.problem.programme.table, error_at_cam_angle(self.cam_search.cam)
        angle = self.cam_search.cam.angles_in_turn(
            np.array([self.angle + self.direction * (distance + PROOF_OFFSET)])
        )
        level = self.level - float(self._tool_positions(angle)[0])
        search = self.cam_search.bound_search(lambda errors, at: error(errors, at) - level)
        panel = np.minimum(np.searchsorted(table.centre + table.half_width, angle), table.centre.size - 1)
        parts = whole_panel_parts(self.cam_search.problem, self.cam_search.box, panel, (self.side,))
        parts.low[0] = parts.high[0] = (angle - table.centre[panel]) / table.half_width[panel]
        return search.run(parts, 0.0, 0.0, until, 0.0)

    def errors_in_mm_and_deg(self, values: ErrorValues, distance: float) -> ErrorValues:
        """Errors in mm and deg, with the direction of the bore as the cam has it."""
        angle = self.angle + self.direction * distance
        return self.cam_search.errors_in_mm_and_deg(values, angle, angle)


class NominalPassage(NamedTuple):
    """A passage of the nominal cam."""

    lift: float
    """As it is told."""
    level: float
    """mm (rad)."""
    passage: str
    angle: float
    """rad."""


PASSAGE_DIRECTIONS = {"earliest": -1.0, "latest": 1.0}
PASSAGE_SIDES = {
    ("rises", "earliest"): 1.0,
    ("rises", "latest"): -1.0,
    ("falls", "earliest"): -1.0,
    ("falls", "latest"): 1.0,
}


def worst_passages(turn: TurnErrors, asked: list[NominalPassage]) -> Iterator[WorstPassage]:
    """Those of the passages of the nominal cam, the earliest and the latest of each.

    BadInput for tolerances so large that a follower has no place on its cam.
    """
    of, until = worst_search(turn), clock_seconds() + MOTION_PROOF_SECONDS
    every = [(each, end) for each in asked for end in PASSAGE_DIRECTIONS]
    try:
        for number, (each, end) in enumerate(every):
            yield _worst_passage(of, each, end, time_share(until, len(every) - number))
    except FloatingPointError:
        raise of.no_contact_error() from None


def _worst_passage(of: WorstSearch, asked: NominalPassage, end: str, until: float) -> WorstPassage:
    way = PASSAGE_DIRECTIONS[end]
    search = PassageSearch(of, asked.level, asked.angle, way, PASSAGE_SIDES[asked.passage, end])
    distance, found, cam, unproved = search.run(until)
    bound, passed = (degrees(asked.angle + way * each) for each in (distance + PROOF_OFFSET, found))
    errors = search.errors_in_mm_and_deg(cam, found) if cam else {}
    return WorstPassage(asked.lift, asked.passage, end, bound, passed, errors, unproved)


class PassageRange(NamedTuple):
    """The cam angles between which all cams pass a level, rad: beyond the turn if need be; infinite if never."""

    earliest: float
    latest: float


@dataclass(frozen=True)
class LevelPassages:
    """A level of the tool, and the turn of a cam with tolerances."""

    turn: TurnErrors
    level: float
    """mm (rad)."""

    def passage_range(self, angle: float, *, outward: bool) -> PassageRange:
        """When the cams pass that level which the nominal one passes at a cam angle, rad."""
        first, last = (1.0, -1.0) if outward else (-1.0, 1.0)
        return PassageRange(self._passage_end(angle, -1.0, first), self._passage_end(angle, 1.0, last))

    def _passage_end(self, angle: float, way: float, side: float) -> float:
        """How far backward or forward some cam still is at the level, at the upper or lower end of its error."""
        return sign_change_place(angle, way, lambda angles: side * self._height_above_level(angles, side))

    def _height_above_level(self, angles: FloatArray, side: float) -> FloatArray:
        """How far above the level the tool is at an end of its error."""
        within = np.mod(angles, 2 * pi)
        ends = worst_case_range(self.turn.contributions_at(within), 0)
        y = self.turn.problem.programme.tool.motion_at(within)[0]
        return np.asarray(y + (ends.upper if side > 0.0 else ends.lower) - self.level)


def sign_change_place(angle: float, way: float, above: Callable[[FloatArray], FloatArray]) -> float:
    """Up to which place, backward or forward from one, a value stays 0 or more; infinite if all over the turn."""
    near, far = 0.0, 2 * pi
    for count in (TURN_STEPS, *[FINER_STEPS] * PASSAGE_ZOOMS):
        steps = np.linspace(near, far, count)
        reached = above(angle + way * steps) >= 0.0
        reached[0] = True
        if reached.all():
            return way * inf if far == 2 * pi else angle + way * far
        first = int(np.argmin(reached))
        near, far = float(steps[first - 1]), float(steps[first])
    return angle + way * (near + far) / 2

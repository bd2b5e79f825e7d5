"""Dwells and passages of all cams within tolerances: bounds and witnesses by exact contact.

**Dwells: how far the tool moves while it should dwell.** On the arc of a dwell y is constant. The exact position of
the follower (``mechanisms.contact_errors_from_flat_errors``) then depends on only two things that change along the
arc. One is the direction of the bore's axis in the ground, which turns with the cam by the angle a from one place
to the other. The other is the error of the profile. All other errors are the same at both places. The wobble is the
difference of both exact positions,

    Δ = f*(y + m₁) − f*(y + m₂)

with f* of the train with errors, and m as in ``tolerances.real_cam``. Run on ranges with slopes, the common parts
cancel in the slopes. The bound is proved as that of the displacement (``tolerances.worst_case``), over the errors,
a direction and a.

An error of the profile within ±t with at most n waves in a turn differs at two places by at most 2·t·sin(n·a/2) up
to n·a = π (Boas), as a sine of n waves does. The proof takes it as p at one place and p − d at the other, with any
p within ±t and d up to this difference; the amount by which p − d exceeds ±t is of second order. Where n·a can
reach π, both errors are anything in ±t.

**Passages: when the tool passes a level.** A real cam passes a level near the cam angle of the nominal one. If at
the cam angle θ

    f(y(θ)) + δ(θ; x) ≤ level    for all errors x,

no cam passes the level outward before θ. If all cams are at the level or beyond it at θ, none passes it after θ.
Inward passages are the other way round. δ(θ; x) is the exact error at a given cam angle. Each contact touches with
a place φ of which φ + τ(φ) = θ (``tolerances.enclosures``), and

    δ = Σ (±m + y(φ) − y(θ)) / contacts

acts through the train as in the worst case. The proof decides over boxes of errors at a single cam angle whether
any cam is beyond the level. The first or last cam has its errors at the ends that move the tool furthest; the proof
is made a little further out.

To first order the tool is between y + lower and y + upper of its error (``tolerances.turn_errors``). It may pass a
level outward when the upper end reaches it, and has passed when the lower end does; inward the other way round. No
error is divided by a velocity: where the tool is slow, the angle follows from the motion itself.

Sources: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11; R. P. Boas,
Entire Functions, ch. 11.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, reduce
from itertools import product
from math import degrees, inf, isinf, pi
from operator import add
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.sloped_interval import as_sloped_interval
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion.stroke import Stroke
from camopt.solve.tolerances.bound_search import (
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
    highest_order_tool_error,
    tool_position_difference,
)
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    Errors,
    flat_from_polar_errors,
    polar_from_flat_errors,
    with_turned_vector_error,
)
from camopt.solve.tolerances.real_cam import CONTACT_ROUNDS, ContactShiftSeries
from camopt.solve.tolerances.turn_errors import TurnErrors, worst_case_range
from camopt.solve.tolerances.worst_case import CORNERS_REASON, WorstSearch, make_worst_cam_search

WOBBLE_GAP = 1e-4
"""Relative gap between bound and worst cam at which a proof of a dwell ends."""
MOTION_PROOF_WORK = 10e6
"""Work of the bounds of all dwells of a motion, and for those of all passages of a lift."""
PASSAGE_GAPS = 1e-5, 1e-4, 1e-3, 1e-2
"""Gaps that a proof of a passage tries until one is proved, relative to the distance from the nominal passage."""
WORSE_PASSAGES = 8
"""Number of times, for one gap, that a worse cam replaces the worst so far."""
TURN_STEPS, FINER_STEPS, PASSAGE_ZOOMS = 1440, 33, 8
"""Number of cam angles of a turn, of finer ones between two of them, and of refinements."""
NEVER_PASSES = "some cam never passes it"
PROOF_OFFSET = 1e-10
"""Least distance of the proof's angle beyond the passage [rad]."""
LAG_KEY = "lag"
"""Key of the variable a: the cam angle from the highest place to the lowest one [rad]."""
LOWEST_SUFFIX = " (lowest)"
"""Suffix of a profile's key for its error at the lowest place [mm]; with few waves, a share of its change."""
COARSE_GRID, FINE_GRID, GRID_ZOOMS = 33, 17, 3
"""Number of directions and lags in the first grid, in finer grids about the best one, and of these grids."""
ZOOM_WIDTH = 1.5
"""Half width of a finer grid, in steps of the grid before."""


class WorstWobble(NamedTuple):
    """Largest movement of the tool in a dwell, over all cams within the tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(tolerances={"bore_eccentricity": 0.01})
    >>> worst = camopt.tolerance(scene).dwells[0].worst_case
    >>> worst.change <= worst.bound, worst.unproved
    (True, '')
    """

    bound: float
    """Proven upper bound of the movement on the arc of the dwell, mm (deg); infinite if no bound is proved."""
    change: float
    """Movement of the worst cam found, by exact contact, mm (deg)."""
    highest_deg: float
    """Cam angle at which that tool is highest [deg]."""
    lowest_deg: float
    """Cam angle at which that tool is lowest [deg]."""
    errors: dict[str, float]
    """Errors of the worst cam found, as in ``WorstCase``; that of the profile where the tool is highest."""
    at_lowest: dict[str, float]
    """Error of the profile where the tool is lowest, by key, mm."""
    unproved: str = ""
    """Why no bound is proved; "" if one is."""

    @property
    def gap(self) -> float:
        """Difference between the bound and the movement of the worst cam found."""
        return self.bound - self.change


@dataclass(frozen=True)
class WobbleSearch:
    """Search for the cam with the largest movement in a dwell."""

    cam_search: WorstSearch
    stroke: Stroke
    """The dwell (``Programme.dwells``)."""

    @cached_property
    def profile_zones(self) -> dict[str, float]:
        return {
            key: high
            for key, (_, high) in self.cam_search.error_ranges.items()
            if key.partition(" ")[0] == "profile"
        }

    @cached_property
    def variable_ranges(self) -> dict[str, tuple[float, float]]:
        """Range of each variable; the errors first."""
        most = min(self.stroke.angle, pi)
        lag = (
            {LAG_KEY: (-most, most)}
            if BORE_DIRECTION in self.cam_search.error_ranges
            or (self.profile_zones and self.waves_if_too_few_to_cross_zone)
            else {}
        )
        lowest = {
            key + LOWEST_SUFFIX: (-1.0, 1.0)
            if self.waves_if_too_few_to_cross_zone
            else self.cam_search.error_ranges[key]
            for key in self.profile_zones
        }
        return {**self.cam_search.error_ranges, **lag, **lowest}

    @property
    def waves_if_too_few_to_cross_zone(self) -> int:
        """Number of waves if the profile cannot cross its whole zone within the dwell; else 0."""
        waves = self.cam_search.turn.scene.tolerances.waves or 0
        return waves if waves * self.stroke.angle < pi else 0

    def errors_at_highest_and_lowest_place(
        self, values: Mapping[str, Any]
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Errors at the highest and at the lowest place, in flat form."""
        first = {key: values[key] for key in self.cam_search.error_ranges}
        lag = values[LAG_KEY] * self.cam_search.problem.design.sense if BORE_DIRECTION in first else 0.0
        profiles = {
            key: first[key] - self._profile_deviation_with_few_waves(key, values) * 2.0
            if self.waves_if_too_few_to_cross_zone
            else values[key + LOWEST_SUFFIX]
            for key in self.profile_zones
        }
        return first, with_turned_vector_error(first, BORE, lag) | profiles

    def _profile_deviation_with_few_waves(self, key: str, values: Mapping[str, Any]) -> Number:
        """Deviation of a profile with few waves from its mean at both places [mm]."""
        return np.sin(np.absolute(values[LAG_KEY]) * (0.5 * self.waves_if_too_few_to_cross_zone)) * (
            values[key + LOWEST_SUFFIX] * self.profile_zones[key]
        )

    def with_few_wave_profile_deviation(self, values: ErrorValues) -> ErrorValues:
        """The values of a real cam: a sine of few waves has equal errors to both sides."""
        return values | {
            key: float(self._profile_deviation_with_few_waves(key, values))
            for key in self.profile_zones
            if self.waves_if_too_few_to_cross_zone
        }

    def find_worst_wobble(self, budget: Budget) -> WorstWobble:
        """The worst cam found, and the proven bound."""
        if not self.profile_zones and BORE_DIRECTION not in self.cam_search.error_ranges:  # no error changes
            start = degrees(self.stroke.start)
            return WorstWobble(0.0, 0.0, start, start, {}, {})
        values, table = self.cam_with_largest_wobble(), self.cam_search.problem.programme.table
        middle = self.stroke.start + 0.5 * self.stroke.angle
        at = self.cam_search.cam.angles_in_turn(np.array([middle]))
        panel = np.searchsorted(table.centre + table.half_width, at)
        parts = whole_panel_parts(self.cam_search.problem, self.bound_search.box, panel, (1.0,))
        bound = self.bound_search.prove_upper_bound(parts, self._wobble_of_cam(values), WOBBLE_GAP, budget)
        if bound.witness is not None:
            values = max(values, self.with_few_wave_profile_deviation(bound.witness), key=self._wobble_of_cam)
        half = 0.5 * values.get(LAG_KEY, self.stroke.angle)
        flat = self.errors_at_highest_and_lowest_place(flat_from_polar_errors(values))
        (start, highest), (end, lowest) = (
            self.cam_search.contact_angle_and_errors_in_deg(
                polar_from_flat_errors(errors, self.cam_search.error_ranges), place
            )
            for errors, place in zip(flat, (middle - half, middle + half), strict=True)
        )
        unit = motion_unit_factor(self.cam_search.problem.setup, 0)
        return WorstWobble(
            unit * bound.high,
            unit * self._wobble_of_cam(values),
            start,
            end,
            highest,
            {key: lowest[key] for key in self.profile_zones},
            missing_bound_reason(bound.high, budget),
        )

    @cached_property
    def bound_search(self) -> BoundSearch:
        """Search for the bound of the wobble of all cams."""
        return BoundSearch(
            self.cam_search.problem,
            self.enclose_wobble,
            self.variable_ranges,
            coordinate_box(self.variable_ranges),
            frozenset({LAG_KEY}),
        )

    def enclose_wobble(self, errors: Errors, at: PartMotion) -> Number:
        """Difference of the tool's heights at two places of a dwell, mm (rad), over boxes of errors."""
        cam = self.cam_search.cam

        def follower_shift(place_errors: Errors) -> Number:
            rest = cam.contact_shift(0, place_errors, at.motion, 0)
            first, turn = rest.follower_shift.terms[0], rest.cam_turn.terms[0]
            if len(cam.contacts) == 1:
                return first
            second = RestingContact(cam, 1, errors, place_errors, at)
            return (first + second.follower_shift(second.enclose_angle_ahead(turn))) * 0.5

        first, second = map(follower_shift, self.errors_at_highest_and_lowest_place(errors))
        return tool_position_difference(cam.problem, errors, first, second, at.y)

    def _wobble_of_cam(self, values: ErrorValues) -> float:
        return float(self._wobbles_of_cams([values])[0])

    def _wobbles_of_cams(self, cams: Sequence[ErrorValues]) -> FloatArray:
        """Wobble of cams: heights of their tools at the first place less those at the second."""
        flat = [flat_from_polar_errors(self.with_few_wave_profile_deviation(each)) for each in cams]
        first, second = self.errors_at_highest_and_lowest_place(
            {key: np.array([each[key] for each in flat]) for key in self.bound_search.box}
        )
        return self._tool_height_errors_at_mid_dwell(first) - self._tool_height_errors_at_mid_dwell(second)

    def _tool_height_errors_at_mid_dwell(self, errors: Errors) -> FloatArray:
        """Errors of the tool's height of cams in the middle of the arc, mm (rad)."""
        cam, size = self.cam_search.cam, len(errors[next(iter(errors))])
        angle = cam.angles_in_turn(np.full(size, self.stroke.start + 0.5 * self.stroke.angle))

        def contact_shift_at_rest(number: int, ahead: Number = 0.0) -> ContactShiftSeries:
            motion = [*cam.contacts[number].programme.motion_at(angle, 1)]
            return cam.contact_shift(number, errors, motion, 0, ahead)

        first = contact_shift_at_rest(0)
        shift = first.follower_shift
        if len(cam.contacts) == 2:
            second = contact_shift_at_rest(1)
            for _ in range(CONTACT_ROUNDS):
                second = contact_shift_at_rest(1, first.cam_turn.terms[0] - second.cam_turn.terms[0])
            shift = (shift - second.follower_shift * cam.second_motion_sign) * 0.5
        return cam.tool_error_of_highest_order(errors, angle, [shift.terms[0] + np.zeros(size)]).error

    def cam_with_largest_wobble(self) -> ErrorValues:
        """Values of the cam with the largest wobble, or nearly so."""
        best = {key: high for key, (_, high) in self.variable_ranges.items()} | {
            key + LOWEST_SUFFIX: -zone
            for key, zone in self.profile_zones.items()
            if not self.waves_if_too_few_to_cross_zone
        }
        ranges = {
            key: self.variable_ranges[key] for key in (BORE_DIRECTION, LAG_KEY) if key in self.variable_ranges
        }
        for count in (COARSE_GRID, *[FINE_GRID] * GRID_ZOOMS):
            grid = product(*(np.linspace(*each, count) for each in ranges.values()))
            cams = [best | dict(zip(ranges, map(float, each), strict=True)) for each in grid]
            best = cams[int(self._wobbles_of_cams(cams).argmax())]
            for key, (low, high) in ranges.items():  # the next range is about the best value of this one
                half = ZOOM_WIDTH * (high - low) / (count - 1)
                least, most = (-inf, inf) if key == BORE_DIRECTION else self.variable_ranges[key]
                ranges[key] = max(best[key] - half, least), min(best[key] + half, most)
            best = self._with_better_error_ends(best)
        return self.with_few_wave_profile_deviation(best)

    def _with_better_error_ends(self, best: ErrorValues) -> ErrorValues:
        """The cam with the better end of each error, and the better sign of each profile."""
        pairs = [(key, key + LOWEST_SUFFIX) for key in self.profile_zones]
        paired = {key for pair in pairs for key in pair}
        changes = [
            {key: self.cam_search.error_ranges[key][0]}
            for key in self.cam_search.error_ranges
            if key not in (BORE_DIRECTION, BORE, *paired)
        ] + [{key: -best[key] for key in pair} for pair in pairs]
        before, *after = self._wobbles_of_cams([best | each for each in ({}, *changes)])
        for change, wobble in zip(changes, after, strict=True):
            best |= change if wobble > before else {}
        return best


class WorstPassage(NamedTuple):
    """Earliest or latest passage of a lift over all cams within the tolerances.

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
    """"rises" for an outward passage, "falls" for an inward one."""
    end: str
    """"earliest" or "latest"."""
    bound_deg: float
    """Proven bound of the cam angle [deg]; infinite if none is proved, or some cam never passes."""
    found_deg: float
    """Cam angle at which the worst cam found passes, by exact contact [deg]."""
    errors: dict[str, float]
    """Errors of the worst cam found, as in ``WorstCase``."""
    unproved: str = ""
    """Why there is no bound: none is proved, or some cam never passes; "" if there is one."""

    @property
    def gap_deg(self) -> float:
        """Difference between the bound and the worst cam found [deg]."""
        return 0.0 if self.bound_deg == self.found_deg else abs(self.bound_deg - self.found_deg)


ErrorsByPlace = Callable[[FloatArray], dict[str, FloatArray]]
"""Computes the errors of cams from the places with which they touch."""


@dataclass(frozen=True)
class PassageSearch:
    """Search for the first, or the last, cam that passes a level."""

    cam_search: WorstSearch
    level: float
    """Level of the tool, mm (rad)."""
    angle: float
    """Cam angle of the nominal passage [rad]."""
    direction: float
    """−1 for the earliest passage, 1 for the latest."""
    side: float
    """1 if the cams with the highest tools decide, −1 if those with the lowest do."""

    def bound_and_worst_passage_distance(self, budget: Budget) -> tuple[float, float, ErrorValues, str]:
        """Proven bound of the distance from the nominal passage, that of the worst cam found, its errors [rad].

        The last value is the reason why no bound is proved, or "".
        """
        place = self._furthest_passage_place(self.angle, self._extreme_errors)
        if isinf(place):
            return inf, inf, {}, NEVER_PASSES
        worst, errors = self._passage_distance_and_errors(place, self._extreme_errors)
        if self.cam_search.problem.programme.corners:
            return inf, worst, errors, CORNERS_REASON
        for gap in PASSAGE_GAPS:
            for _ in range(WORSE_PASSAGES):
                distance = worst * (1.0 + gap)
                bound = self.bound_beyond_level_at_distance(distance, budget)
                if bound.high <= 0.0:
                    return distance, worst, errors, ""
                if bound.witness is None or not bound.witness_value > 0.0:
                    break
                further, further_errors = self._distance_of_witness_passage(bound.witness, distance)
                if further <= worst:
                    break
                worst, errors = further, further_errors
        return inf, worst, errors, missing_bound_reason(inf, budget)

    def _extreme_errors(self, places: FloatArray) -> dict[str, FloatArray]:
        """Errors of the extreme cams that touch with places."""
        return self.cam_search.part_errors_moving_tool_furthest(
            self.cam_search.cam.angles_in_turn(places), self.side
        )

    def _furthest_passage_place(self, start: float, errors: ErrorsByPlace) -> float:
        """Place of the passage that is furthest from a start, for cams with the errors."""

        def distance_beyond_level(places: FloatArray) -> FloatArray:
            contact = self.cam_search.tool_error_at_contact(errors(places), places)
            return self.side * (self._nominal_tool_positions(contact.angle) + contact.error - self.level)

        return sign_change_place(start, self.direction, distance_beyond_level)

    def _passage_distance_and_errors(self, place: float, errors: ErrorsByPlace) -> tuple[float, ErrorValues]:
        """Distance of a cam's contact with a place from the nominal passage [rad], and its errors at that angle."""
        cam = {key: float(each[0]) for key, each in errors(np.array([place])).items()}
        angle = float(self.cam_search.tool_error_at_contact(cam, np.array([place])).angle[0])
        if BORE_DIRECTION in cam:  # the direction in the ground at that cam angle instead of the place's
            cam[BORE_DIRECTION] += self.cam_search.problem.design.sense * (angle - place)
        return max(self.direction * (angle - self.angle), 0.0), cam

    def _distance_of_witness_passage(self, values: ErrorValues, distance: float) -> tuple[float, ErrorValues]:
        """Distance of the witness's furthest passage from the nominal one, and its errors there."""
        angle, sense = self.angle + self.direction * (distance + PROOF_OFFSET), self.cam_search.problem.design.sense

        def witness_errors_at_places(places: FloatArray) -> dict[str, FloatArray]:
            repeated = {key: np.full(places.size, each) for key, each in values.items()}
            if BORE_DIRECTION in repeated:
                repeated[BORE_DIRECTION] += sense * (places - angle)
            return repeated

        place = np.array([angle])
        for _ in range(CONTACT_ROUNDS):
            place = place - (
                self.cam_search.tool_error_at_contact(witness_errors_at_places(place), place).angle - angle
            )
        return self._passage_distance_and_errors(
            self._furthest_passage_place(float(place[0]), witness_errors_at_places), witness_errors_at_places
        )

    def _nominal_tool_positions(self, angles: FloatArray) -> FloatArray:
        return np.asarray(
            self.cam_search.problem.programme.tool.motion_at(self.cam_search.cam.angles_in_turn(angles))[0]
        )

    def bound_beyond_level_at_distance(self, distance: float, budget: Budget) -> ProvedBound:
        """Bound of the distance by which any cam is beyond the level, at a distance from the nominal passage."""
        cam, table = self.cam_search.cam, self.cam_search.problem.programme.table
        angle = cam.angles_in_turn(np.array([self.angle + self.direction * (distance + PROOF_OFFSET)]))
        level = self.level - float(self._nominal_tool_positions(angle)[0])

        def enclose_height_above_level(errors: Errors, at: PartMotion) -> Number:
            contacts = [ContactAhead(cam, number, errors, errors, at) for number in range(len(cam.contacts))]
            ahead = (each.enclose_angle_ahead(as_sloped_interval(0.0, at.y)) for each in contacts)
            shifts = (each.follower_shift(angle_ahead) for each, angle_ahead in zip(contacts, ahead, strict=True))
            delta = reduce(add, shifts) * (1.0 / len(contacts))
            return highest_order_tool_error(cam.problem, errors, [delta], at.motion.__getitem__) - level

        search = self.cam_search.bound_search(enclose_height_above_level)
        panel = np.minimum(np.searchsorted(table.centre + table.half_width, angle), table.centre.size - 1)
        parts = whole_panel_parts(self.cam_search.problem, self.cam_search.box, panel, (self.side,))
        parts.low[0] = parts.high[0] = (angle - table.centre[panel]) / table.half_width[panel]
        return search.prove_upper_bound(parts, 0.0, 0.0, budget, 0.0)


class NominalPassage(NamedTuple):
    """A passage of the nominal cam."""

    lift: float
    """The lift as shown, mm (deg)."""
    level: float
    """The level of the tool, mm (rad)."""
    passage: str
    angle: float
    """Cam angle of the passage [rad]."""


PASSAGE_DIRECTIONS = {"earliest": -1.0, "latest": 1.0}
PASSAGE_SIDES = {
    ("rises", "earliest"): 1.0,
    ("rises", "latest"): -1.0,
    ("falls", "earliest"): -1.0,
    ("falls", "latest"): 1.0,
}


def worst_passages(turn: TurnErrors, passages: list[NominalPassage]) -> Iterator[WorstPassage]:
    """The earliest and the latest of each nominal passage over all cams.

    Raises BadInput if the tolerances are so large that a follower may not touch its cam.
    """
    search, until = make_worst_cam_search(turn), Budget(MOTION_PROOF_WORK)
    pairs = [(passage, end) for passage in passages for end in PASSAGE_DIRECTIONS]
    try:
        for number, (passage, end) in enumerate(pairs):
            yield _worst_passage(search, passage, end, until.share(len(pairs) - number))
    except FloatingPointError:
        raise search.tolerance_too_large_error() from None


def _worst_passage(
    cam_search: WorstSearch, nominal: NominalPassage, passage_end: str, budget: Budget
) -> WorstPassage:
    direction = PASSAGE_DIRECTIONS[passage_end]
    proved, worst, cam, unproved = PassageSearch(
        cam_search, nominal.level, nominal.angle, direction, PASSAGE_SIDES[nominal.passage, passage_end]
    ).bound_and_worst_passage_distance(budget)
    bound, found = (nominal.angle + direction * each for each in (proved + PROOF_OFFSET, worst))
    errors = cam_search.errors_in_mm_and_deg(cam, found, found) if cam else {}
    ends = degrees(bound), degrees(found)
    return WorstPassage(nominal.lift, nominal.passage, passage_end, *ends, errors, unproved)


class PassageRange(NamedTuple):
    """Cam angles between which all cams pass a level [rad]; they may exceed the turn, and are infinite if never."""

    earliest: float
    latest: float


def passage_range(turn: TurnErrors, level: float, nominal_angle: float, *, outward: bool) -> PassageRange:
    """Cam angles between which all cams pass a level [mm or rad], to first order.

    The nominal cam passes the level at ``nominal_angle`` [rad].
    """

    def distance_beyond_level(side: float, angles: FloatArray) -> FloatArray:
        within = np.mod(angles, 2 * pi)
        ends = worst_case_range(turn.contributions_at(within), 0)
        y = turn.problem.programme.tool.motion_at(within)[0]
        return np.asarray(side * (y + (ends.upper if side > 0.0 else ends.lower) - level))

    first = 1.0 if outward else -1.0
    return PassageRange(
        sign_change_place(nominal_angle, -1.0, partial(distance_beyond_level, first)),
        sign_change_place(nominal_angle, 1.0, partial(distance_beyond_level, -first)),
    )


def sign_change_place(angle: float, direction: float, value_at_angles: Callable[[FloatArray], FloatArray]) -> float:
    """Place, backward (−1) or forward (1) from an angle, up to which a value stays 0 or more.

    Infinite if it does so all over the turn.
    """
    near, far = 0.0, 2 * pi
    for count in (TURN_STEPS, *[FINER_STEPS] * PASSAGE_ZOOMS):
        steps = np.linspace(near, far, count)
        reached = value_at_angles(angle + direction * steps) >= 0.0
        reached[0] = True
        if reached.all():
            return direction * inf if far == 2 * pi else angle + direction * far
        first = int(np.argmin(reached))
        near, far = float(steps[first - 1]), float(steps[first])
    return angle + direction * (near + far) / 2

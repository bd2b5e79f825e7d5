"""Worst cases: the largest error of the tool's motion over all cams within the tolerances, as bound and witness.

The exact error of a cam in displacement, velocity or acceleration (orders 0 to 2) is one formula of its errors and
of the point that is touched (``tolerances.real_cam``). The formula is run on ranges with slopes, which gives a
bound over all errors. The turn is divided where this bound is highest (``tolerances.bound_search``). With two
contacts, both errors are taken at the same cam angle; the place of the second contact is enclosed by its own
equation (``tolerances.enclosures``).

Where y'' jumps, a late cam has the whole jump as an error of its acceleration until it reaches the jump. The
*reach* is how late or early any cam can be. Within reach of a jump, the proof counts the jump for every cam: the
bound is the jump plus all other errors. With two contacts, a jump of y'' or y''' near φ may lie between φ and θ or
not, and between φ and the place of the second contact or not. Each of these cases is proved for all cams. In each
case the motion has no jump, so the slopes are those of one side of it.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.budget import Budget
from camopt.model.effects.curvature import CONVEX_RADIUS
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion.programme import JUMP_SIDE, Jump, find_jumps
from camopt.scene.problem.problem import Problem
from camopt.scene.tolerances import ANGLE_TOLERANCES
from camopt.solve.tolerances.bound_search import (
    LENGTH_ROUNDING,
    BoundedQuantity,
    BoundSearch,
    ErrorValues,
    JumpCase,
    ProvedBound,
    coordinate_box,
    missing_bound_reason,
    whole_panel_parts,
)
from camopt.solve.tolerances.enclosures import ContactAhead, MotionAhead, PartMotion, highest_order_tool_error
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    PROFILE_LEVEL,
    WAVE_PHASE,
    Errors,
    direction_key,
    direction_keys,
    error_ranges_by_key_at_all_contacts,
    flat_from_polar_errors,
    is_direction,
    polar_from_flat_errors,
)
from camopt.solve.tolerances.real_cam import CONTACT_ROUNDS, ContactError, RealCam, follower_errors
from camopt.solve.tolerances.turn_errors import TurnErrors, angle_of_largest_value
from camopt.solve.verdicts.constraint_boxes import NumberRanges
from camopt.solve.verdicts.effect_runs import run_effects

DISPLACEMENT_GAP, RATE_GAP = 1e-5, 1e-3
"""Relative gap between bound and worst cam at which a proof ends: for displacement, and for its derivatives."""
DISPLACEMENT_WORK, RATE_WORK = 20e6, 9e6
"""Work of the proof of each bound."""
PROFILE_PLACES = "tolerances.profile (part.profile_tolerance)"
CORNERS_REASON = "the velocity of the motion jumps"
SLOPES_REASON = "the slope of the profile's error has no bound without tolerances.waves"
HOLLOWS_REASON = "the profile's waves are so high and short that a flat face touches only their crests"
TOLERANCE_HALVINGS = 12
"""Number of halvings in the search for the largest tolerance that is possible."""
QUARTER_TURNS = (0.0, 0.5 * pi, pi, -0.5 * pi)
DIRECTION_STEPS = (pi, *(side * each for each in (1.0, 0.3, 0.1, 0.03, 0.01) for side in (-1.0, 1.0)))
"""Changes of a direction in the search for a worse cam [rad]."""
CLIMB_ROUNDS = 2
"""Number of rounds in which each error is changed in this search."""
DELAY_WEIGHTS = tuple(side * each for side in (1.0, -1.0) for each in (0.1, 1.0, 10.0))
"""Weights of a cam's delay in the search for the worst cam at a jump."""
JUMP_SIDE_DISTANCE = 1e-9
"""Distance of both sides from a jump [rad]."""
CAMS_BETWEEN, CAM_ZOOMS = 9, 6
"""Number of cams between two, and of refinements between the neighbours of the worst one."""


class WorstCase(NamedTuple):
    """Largest error of displacement, velocity or acceleration of the tool over all cams within the tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(tolerances={"follower.offset": 0.02})
    >>> worst = camopt.tolerance(scene).worst_case
    >>> round(worst.bound, 5), round(worst.error, 5), worst.errors
    (0.01778, -0.01778, {'follower.offset': 0.02})
    """

    bound: float
    """Proven upper bound of the error, in mm or deg, or in the unit of velocity or acceleration.

    Infinite if no bound is proved.
    """
    error: float
    """Error of the worst cam found, by exact contact; negative where the tool is too low."""
    at_deg: float
    """Cam angle of that error [deg]."""
    errors: dict[str, float]
    """Errors of the worst cam found, by key of ``[tolerances]``, in mm and deg.

    ``bore_eccentricity_way`` is the direction of the profile's axis from the bore's, in the fixed frame at the cam
    angle 0. A profile with n waves has the error ``profile`` times cos(nφ − ``profile_way``) at the cam angle φ.
    """
    unproved: str = ""
    """Why no bound is proved; "" if one is."""

    @property
    def gap(self) -> float:
        """Difference between the bound and the error of the worst cam found."""
        return self.bound - abs(self.error)


NO_ERROR = WorstCase(0.0, 0.0, 0.0, {})
"""The worst case if no tolerance moves the tool."""


def tool_motion_error_at_contact_maker(cam: RealCam, order: int) -> BoundedQuantity:
    """Exact error of the tool's position, velocity or acceleration at the first contact, over boxes of errors.

    In mm (rad) by powers of rad.
    """
    problem = cam.problem

    def enclose_tool_error(errors: Errors, at: PartMotion) -> Number:
        shift = cam.contact_shift(0, errors, at.motion, order)
        ahead = MotionAhead(problem.programme, at, shift.cam_turn.terms[0], at.jumps_at_contact)
        deltas = follower_errors(
            shift, at.motion, ahead.derivative_change_to_ahead, at.jumps_at_contact.y2_jump, order
        )
        if len(cam.contacts) > 1:
            second = ContactAhead(cam, 1, errors, errors, at)
            both = zip(deltas, second.errors_at_first_contact(ahead, order), strict=True)
            deltas = [(a + b * second.motion_sign) * 0.5 for a, b in both]
        return highest_order_tool_error(problem, errors, deltas, ahead.derivative_ahead)

    return enclose_tool_error


class CandidateCam(NamedTuple):
    """Errors of a cam (mm and rad), with its largest error of the motion and the place of the profile (rad)."""

    errors: ErrorValues
    angle: float
    error: float


@dataclass(frozen=True)
class WorstSearch:
    """Search for the worst cam within tolerances, with one contact or two."""

    turn: TurnErrors
    error_ranges: NumberRanges
    """Least and largest value of each error (``errors.error_ranges_by_key_at_all_contacts``)."""
    order: int = 0
    """Order of the derivative: 0 displacement, 1 velocity, 2 acceleration."""

    @property
    def problem(self) -> Problem:
        return self.turn.problem

    @cached_property
    def cam(self) -> RealCam:
        """The cams; a profile without waves, and any profile for order 0, has a constant error."""
        return RealCam(self.problem, (self.turn.scene.tolerances.waves or 0) if self.order else 0)

    def find_worst_cam(self) -> WorstCase:
        """The worst cam found, and the proven bound.

        Raises BadInput if the tolerances are so large that a follower may not touch its cam.
        """
        try:
            worst = self._make_candidate(self.errors_of_nearly_worst_cam())
            high, unproved = inf, self.no_bound_reason
            if not unproved:
                budget = Budget(RATE_WORK if self.order else DISPLACEMENT_WORK)
                bound = self.prove_error_bound(
                    abs(worst.error), RATE_GAP if self.order else DISPLACEMENT_GAP, budget
                )
                if bound.witness is not None:
                    worst = max(
                        worst,
                        self._make_candidate({key: bound.witness[key] for key in self.error_ranges}),
                        key=lambda each: abs(each.error),
                    )
                high, unproved = bound.high, missing_bound_reason(bound.high, budget)
            unit = motion_unit_factor(self.problem.setup, self.order)
            shown = self.contact_angle_and_errors_in_deg(worst.errors, worst.angle)
            return WorstCase(unit * high, unit * worst.error, *shown, unproved)
        except FloatingPointError:
            raise self.tolerance_too_large_error() from None

    def contact_angle_and_errors_in_deg(self, errors: ErrorValues, place: float) -> tuple[float, ErrorValues]:
        """Cam angle at which a cam touches with a place [deg], and its errors in mm and deg."""
        angle = self.tool_error_at_contact(errors, np.array([place])).angle
        shown = self.errors_in_mm_and_deg(errors, place, float(angle[0]))
        return degrees(float(self.cam.angles_in_turn(angle)[0])), shown

    @property
    def no_bound_reason(self) -> str:
        """Why no bound exists; "" where one may exist."""
        problem, tolerances = self.problem, self.turn.scene.tolerances
        if problem.programme.corners:
            return CORNERS_REASON
        if not self.order or not tolerances.profile:
            return ""
        if tolerances.waves is None:
            return SLOPES_REASON
        if not problem.setup.mechanism.flat_faced:
            return ""
        # a flat face may not follow the waves if the radius ρ + w + w'' with the wave w reaches 0
        block = EvaluationBlock(problem.setup, problem.programme, problem.design)
        radius = run_effects(block, frozenset({CONVEX_RADIUS})).columns[CONVEX_RADIUS]
        return HOLLOWS_REASON if radius[0] <= (self.cam.waves**2 - 1) * tolerances.profile else ""

    def _make_candidate(self, errors: ErrorValues) -> CandidateCam:
        return CandidateCam(errors, *self.place_and_largest_error(errors))

    def prove_error_bound(
        self, reached_value: float, gap: float, budget: Budget, sufficient_bound: float = inf
    ) -> ProvedBound:
        """Upper bound of the error over all cams within the tolerances; some cam reaches ``reached_value``.

        Ends at the relative gap, when the budget is spent, or when a cam exceeds ``sufficient_bound``.
        """
        search = self.bound_search(
            tool_motion_error_at_contact_maker(self.cam, self.order), self.largest_early_or_late_angle
        )
        parts = search.split_at_reach_of_jumps(whole_panel_parts(self.problem, self.box))
        bound, cases = ProvedBound(-inf, reached_value), list[JumpCase]([(None, None)])
        if len(self.cam.contacts) > 1:  # jumps already passed or not, one case after the other for parts near jumps
            first = (False, True) if self._acceleration_jumps_of_two_contacts else (None,)
            cases = [*product(first, (False, True))]
        for remaining, case in zip(range(len(cases), 0, -1), cases, strict=True):
            more = replace(search, jump_case=case).prove_upper_bound(
                parts, bound.witness_value, gap, budget.share(remaining), sufficient_bound
            )
            cam = bound.witness if more.witness is None else more.witness
            bound = ProvedBound(max(bound.high, more.high), max(bound.witness_value, more.witness_value), cam)
            parts = parts.take(np.flatnonzero(search.is_part_near_jump(parts)))
            if not parts.size:
                break
        return bound

    def bound_search(self, quantity: BoundedQuantity, jump_reach: float = 0.0) -> BoundSearch:
        """Search for the bound of a quantity over all cams."""
        return BoundSearch(self.problem, quantity, self.error_ranges, self.box, jumps=self.jumps, reach=jump_reach)

    @cached_property
    def box(self) -> NumberRanges:
        """Range of each coordinate of the errors, and of each other variable of the proof."""
        box = coordinate_box(self.error_ranges)
        phases = [key for key in box if self.order == 2 and key.startswith(WAVE_PHASE)]
        return box | {key.replace(WAVE_PHASE, PROFILE_LEVEL): box[key] for key in phases}

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps of y'' and y''' that matter if the motion is taken at another angle than the place's own."""
        orders = range(2, self.order + len(self.cam.contacts))
        return tuple(each for order in orders for each in find_jumps(self.problem.programme, (order,)))

    @cached_property
    def _acceleration_jumps_of_two_contacts(self) -> list[Jump]:
        """Jumps of y'' that two contacts have as an error of the acceleration."""
        two = len(self.cam.contacts) > 1
        return [jump for jump in self.jumps if jump.order == self.order == 2 and two]

    @cached_property
    def largest_early_or_late_angle(self) -> float:
        """Largest angle by which any cam is late or early [rad]; 0 where no jump matters."""
        if not self.jumps:
            return 0.0
        cam, parts = self.cam, whole_panel_parts(self.problem, self.box, sides=(1.0,))

        def enclose_angle_ahead(contact_number: int, errors: Errors, at: PartMotion) -> Number:
            """Angle from a place to its contact's cam angle, or to the second contact's place [rad]."""
            turn = cam.contact_shift(0, errors, at.motion, 0).cam_turn.terms[0]
            return ContactAhead(cam, 1, errors, errors, at).enclose_angle_ahead(turn) if contact_number else turn

        parts = parts.cut_across_steepest_variable(np.eye(1, len(parts.low)).T + np.zeros(parts.size))
        proofs = (self.bound_search(partial(enclose_angle_ahead, number)) for number in range(len(cam.contacts)))
        with np.errstate(all="ignore"):
            angles = [proof.enclose_quantity_times_side(parts).value.largest_magnitude.max() for proof in proofs]
        return (1.0 + LENGTH_ROUNDING) * float(max(angles))

    def tool_error_at_contact(
        self, errors: Errors, angles: FloatArray, *, include_jumps: bool = True
    ) -> ContactError:
        """Contact of cams with the places ``angles`` (rad), and their errors of this order, from polar errors.

        Without ``include_jumps``, the jumps of y'' between place and cam angle do not count.
        """
        return self.cam.tool_error_at_contact(
            flat_from_polar_errors(errors), angles, self.order, include_jumps=include_jumps
        )

    def errors_of_nearly_worst_cam(self) -> dict[str, float]:
        """Errors of the worst cam, or nearly so, at the worst cam angle; most of them are at their ends.

        Where y'' jumps, both contacts have the whole jump as an error of cams that are hardly late. These cams lie
        between late cams and those that are the worst without the jump.
        """
        cams = [self._extreme_cam(side) for side in (1.0, -1.0)]
        if self.jumps:
            cams += [self._extreme_cam_at_jump(side, weight) for side in (1.0, -1.0) for weight in DELAY_WEIGHTS]
        usual = self._worsen_errors_one_at_a_time(max(cams, key=lambda cam: cam.error))
        if not self._acceleration_jumps_of_two_contacts:
            return usual
        starts = {side: self._extreme_cam_at_jump(side, 0.0) for side in (1.0, -1.0)}
        between = [
            self._worst_cam_on_line_between(starts[side], self._extreme_cam_at_jump(side, weight))
            for side in starts
            for weight in DELAY_WEIGHTS
        ]
        best = max(between, key=lambda cam: cam.error)
        return best.errors if best.error > abs(self.place_and_largest_error(usual)[1]) else usual

    def _extreme_cam(self, side: float) -> CandidateCam:
        """The cam with the largest error to a side (1 or −1), at the worst cam angle."""

        def signed_error(angles: FloatArray) -> FloatArray:
            return side * self.motion_errors(self.part_errors_moving_tool_furthest(angles, side), angles)

        return self._extreme_cam_at(angle_of_largest_value(self.turn.nodes, signed_error), side, 0.0)

    def _extreme_cam_at_jump(self, side: float, delay_weight: float) -> CandidateCam:
        """The cam with the largest error beside a jump; the larger the weight, the later or earlier it is."""
        jumps, turn = np.array([each.at for each in self.jumps]), self.problem.programme.strokes[-1].end
        angles = np.mod(np.concatenate([jumps - JUMP_SIDE, jumps + JUMP_SIDE]), turn)
        magnitudes = np.abs(
            self.motion_errors(self.part_errors_moving_tool_furthest(angles, side, delay_weight), angles)
        )
        return self._extreme_cam_at(float(angles[magnitudes.argmax()]), side, delay_weight)

    def _extreme_cam_at(self, angle: float, side: float, delay_weight: float) -> CandidateCam:
        at = np.array([angle])
        errors = self.part_errors_moving_tool_furthest(at, side, delay_weight)
        most = float(np.abs(self.motion_errors(errors, at))[0])
        return CandidateCam({key: float(each[0]) for key, each in errors.items()}, angle, most)

    def _worsen_errors_one_at_a_time(self, cam: CandidateCam) -> dict[str, float]:
        """Errors of a worse cam at the same place, by changing one error at a time."""
        errors, angle, most = cam
        for _ in range(CLIMB_ROUNDS):
            for key, ends in self.error_ranges.items():
                values = errors[key] + np.array(DIRECTION_STEPS) if is_direction(key) else np.array(ends)
                trials = {name: np.full(values.size, each) for name, each in errors.items()} | {key: values}
                magnitudes = np.abs(self.motion_errors(trials, np.full(values.size, angle)))
                if magnitudes.max() > most:
                    most, errors = float(magnitudes.max()), {**errors, key: float(values[magnitudes.argmax()])}
        return errors

    def _worst_cam_on_line_between(self, first_cam: CandidateCam, second_cam: CandidateCam) -> CandidateCam:
        """The worst cam on the straight line between the errors of two cams, beside a jump."""
        ends, low, high = [flat_from_polar_errors(each.errors) for each in (first_cam, second_cam)], 0.0, 1.0
        for _ in range(CAM_ZOOMS):
            shares = np.linspace(low, high, CAMS_BETWEEN)
            errors = polar_from_flat_errors(
                {key: (1.0 - shares) * ends[0][key] + shares * ends[1][key] for key in ends[0]}, self.error_ranges
            )
            places = self._contact_places_beside_jumps(errors)
            repeated = {key: np.tile(each, len(places)) for key, each in errors.items()}
            magnitudes = np.abs(self.motion_errors(repeated, places.ravel())).reshape(places.shape)
            row, k = (int(each) for each in np.unravel_index(magnitudes.argmax(), magnitudes.shape))
            low, high = shares[max(k - 1, 0)], shares[min(k + 1, CAMS_BETWEEN - 1)]
        return CandidateCam(
            {key: float(each[k]) for key, each in errors.items()}, float(places[row, k]), float(magnitudes[row, k])
        )

    def _contact_places_beside_jumps(self, errors: Mapping[str, FloatArray]) -> FloatArray:
        """Places just before and after each place where a jump starts or stops to act, shape (places, cams)."""
        jumps = [jump.at for jump in self._acceleration_jumps_of_two_contacts]
        flat = flat_from_polar_errors({key: np.tile(each, len(jumps)) for key, each in errors.items()})
        count = len(next(iter(errors.values())))
        at = np.repeat(jumps, count)
        first, second = at, at  # places of the first contact as it, or as the second contact, touches at a jump
        for _ in range(CONTACT_ROUNDS):
            turns = [self.cam.cam_turn_angles_at_contact(flat, each) for each in (first, second)]
            first, second = at - turns[0], at - self.cam.second_contact_lead(flat, second, turns[1])
        places = np.reshape([at, first, second], (-1, count))
        return self.cam.angles_in_turn(np.concatenate([places - JUMP_SIDE_DISTANCE, places + JUMP_SIDE_DISTANCE]))

    def part_errors_moving_tool_furthest(
        self, angles: FloatArray, side: float, delay_weight: float = 0.0
    ) -> dict[str, FloatArray]:
        """Errors at the ends of their ranges that move the tool furthest to a side, for each cam angle.

        A weight also counts how late the errors make the cam, relative to the delay with all errors at one end.
        """
        rows, upper_ends = list[ErrorValues](), {key: high for key, (_, high) in self.error_ranges.items()}
        ways = direction_keys(self.error_ranges)
        for key, ends in self.error_ranges.items():
            if key in ways:
                rows += [{key: ends[1], ways[key]: each} for each in QUARTER_TURNS]
            elif not is_direction(key):
                rows += [{key: end} for end in ends]
        # movement of the tool by each cam, plus its weighted delay in units of the last cam's delay
        cams = [*rows, upper_ends]
        repeated = {key: np.repeat([cam.get(key, 0.0) for cam in cams], angles.size) for key in self.error_ranges}
        places = np.tile(angles, len(cams))
        contact = self._tool_error_at_contact_or_raise(repeated, places, include_jumps=False)
        error, delay = (each.reshape(len(cams), -1) for each in (contact.error, contact.angle - places))
        weight = np.abs(error[-1]) / np.maximum(np.abs(delay[-1]), JUMP_SIDE)
        shifts, errors = iter(side * error + delay_weight * weight * delay), dict[str, FloatArray]()
        for key, (low, high) in self.error_ranges.items():
            if key in ways:
                right, up, left, down = (next(shifts) for _ in QUARTER_TURNS)
                errors |= {key: np.full(angles.size, high), ways[key]: np.arctan2(up - down, right - left)}
            elif not is_direction(key):
                errors[key] = np.where(next(shifts) > next(shifts), low, high)
        return errors

    def motion_errors(self, errors: Mapping[str, Any], angles: FloatArray) -> FloatArray:
        """Errors of the motion of cams that touch with the places ``angles`` (rad)."""
        return self._tool_error_at_contact_or_raise(errors, angles).error

    def _tool_error_at_contact_or_raise(
        self, errors: Mapping[str, Any], angles: FloatArray, *, include_jumps: bool = True
    ) -> ContactError:
        """As ``tool_error_at_contact``; raises FloatingPointError if a follower does not touch its cam."""
        with np.errstate(invalid="ignore"):
            contact = self.tool_error_at_contact(errors, angles, include_jumps=include_jumps)
        if not np.isfinite(contact.error).all():
            raise FloatingPointError
        return contact

    def tolerance_too_large_error(self) -> BadInput:
        """The error for tolerances so large that a follower may not touch its cam: for the first one, or all."""
        singles = [[key, direction_key(key)] for key in self.error_ranges if not is_direction(key)]
        keys = next(
            (each for each in singles if not self._follower_touches_over_whole_turn(each, 1.0)),
            [*self.error_ranges],
        )
        low, high = 0.0, 1.0
        for _ in range(TOLERANCE_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._follower_touches_over_whole_turn(keys, middle) else (low, middle)
        why = "too large: the follower does not touch its cam all over the turn, or cannot be assembled"
        if keys == [*self.error_ranges] and len(singles) > 1:
            why = f"{why}; use at most {100.0 * low:.3g} % of each"
            return BadInput([Mistake(self.problem.file, "tolerances", None, why, bare=True)])
        unit = degrees(1.0) if keys[0] in ANGLE_TOLERANCES else 1.0
        most = unit * max(map(abs, self.error_ranges[keys[0]]))
        why = f"{why}; use at most about {low * most:.3g}"
        place = PROFILE_PLACES if keys[0] == "profile" else f"tolerances.{keys[0]}"
        return BadInput([Mistake(self.problem.file, place, most, why, bare=True)])

    def _follower_touches_over_whole_turn(self, keys: list[str], share: float) -> bool:
        """Whether followers touch all over the turn with the errors of these keys only, up to a share of each."""
        ends = {key: self.error_ranges[key] for key in keys if key in self.error_ranges}
        shared = {key: (low * share, high * share) for key, (low, high) in ends.items()}
        try:
            search = replace(self, error_ranges=shared | {key: ends[key] for key in ends if is_direction(key)})
            search.place_and_largest_error(search.errors_of_nearly_worst_cam())
        except FloatingPointError:
            return False
        return True

    def place_and_largest_error(self, errors: Mapping[str, float]) -> tuple[float, float]:
        """Place on its profile (rad) at which a cam has its largest error, and that error."""
        angle = angle_of_largest_value(self.turn.nodes, lambda angles: np.abs(self.motion_errors(errors, angles)))
        usual = angle, float(self.motion_errors(errors, np.array([angle]))[0])
        if not self._acceleration_jumps_of_two_contacts:
            return usual
        places = self._contact_places_beside_jumps({key: np.array([each]) for key, each in errors.items()}).ravel()
        at_jumps = self.motion_errors({key: np.full(places.size, each) for key, each in errors.items()}, places)
        most = np.abs(at_jumps).argmax()
        return (float(places[most]), float(at_jumps[most])) if abs(at_jumps[most]) > abs(usual[1]) else usual

    def errors_in_mm_and_deg(self, errors: Mapping[str, float], place: float, angle: float) -> dict[str, float]:
        """Errors in mm and deg, of a cam that touches with a place at a cam angle (rad).

        The direction of the bore is that in the cam's frame. The phase of waves is that of a crest on the cam.
        """
        shown, sense = dict(errors), self.problem.design.sense
        if BORE in errors:
            developed, length = self.problem.setup.mechanism.body.developed, errors[BORE]
            cam_angle = angle + errors.get("phase", 0.0) if developed else place
            way = errors.get(BORE_DIRECTION, 0.0 if length >= 0.0 else pi)
            shown |= {BORE: abs(length), BORE_DIRECTION: way - sense * cam_angle}
        waves = [key for key in errors if key.startswith(WAVE_PHASE)]
        shown |= {key: self.cam.waves * self.profile_place(key, errors, place) - errors[key] for key in waves}
        in_deg = {key: degrees(each) for key, each in shown.items() if is_direction(key) or key in ANGLE_TOLERANCES}
        return shown | {key: each % 360.0 if is_direction(key) else each for key, each in in_deg.items()}

    def profile_place(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        """Place of the profile (rad) at which a key's error acts when the first contact is at ``angle``."""
        if not key.endswith(SECOND_CONTACT_SUFFIX):
            return angle
        at, flat = np.array([angle]), flat_from_polar_errors(errors)
        return angle + float(
            self.cam.second_contact_lead(flat, at, self.cam.cam_turn_angles_at_contact(flat, at))[0]
        )


def make_worst_cam_search(
    turn: TurnErrors, order: int = 0, changed_error_ranges: Mapping[str, tuple[float, float]] | None = None
) -> WorstSearch:
    """Search for the worst cam in displacement (order 0), velocity (1) or acceleration (2).

    ``changed_error_ranges`` has ranges of errors that replace those of the scene.
    """
    return WorstSearch(
        turn,
        {**error_ranges_by_key_at_all_contacts(turn.scene, turn.problem, order), **(changed_error_ranges or {})},
        order,
    )

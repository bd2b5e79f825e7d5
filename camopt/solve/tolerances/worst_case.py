"""The largest errors of the motion of the tool, of all cams within the tolerances: bounds and witnesses.

The exact error of a cam in displacement, velocity or acceleration, the orders 0 to 2, is one formula of its errors
and of the point that is touched (``tolerances.real_cam``). Run on ranges with slopes, its bound over all errors is
cut along the turn, where it is the highest (``tolerances.bound_search``). Of two contacts both errors are those at
one cam angle; the place of the second one is enclosed by its own equation (``tolerances.enclosures``).

Where y'' jumps, a cam that is late has the whole jump for an error of its acceleration until it is there. Within
reach of a jump, as far as any cam is late or early, the proof counts it with every cam: its bound is the jump and
what else is off. With two contacts a jump of y'' or y''' next to φ may lie between φ and θ or not, and between φ
and the place of the second contact or not. Each of these cases is proved of all cams: the motion has no jump then,
so that slopes of errors are those of one side of it.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds, time_share
from camopt.model.effects.curvature import CONVEX_RADIUS
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX
from camopt.model.effects.motion import motion_scale
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
from camopt.solve.tolerances.enclosures import ContactAhead, MotionAhead, PartMotion, error_through_train
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    PROFILE_LEVEL,
    WAVE_PHASE,
    Errors,
    contact_error_ranges,
    direction_key,
    flat_errors,
    is_direction,
    polar_errors,
)
from camopt.solve.tolerances.real_cam import CONTACT_ROUNDS, ContactError, RealCam, follower_errors
from camopt.solve.tolerances.turn_errors import TurnErrors, angle_of_largest
from camopt.solve.verdicts.constraint_boxes import NumberRanges
from camopt.solve.verdicts.effect_runs import run_effects

DISPLACEMENT_GAP, RATE_GAP = 1e-5, 1e-3
"""By no more than this, relative, a cam may be worse than the worst found: in displacement, and in the others."""
DISPLACEMENT_SECONDS, RATE_SECONDS = 20.0, 9.0
"""For each bound."""
PROFILE_PLACES = "tolerances.profile (part.profile_tolerance)"
CORNERS_REASON = "the velocity of the motion jumps"
SLOPES_REASON = "the slope of the profile's error has no bound without tolerances.waves"
HOLLOWS_REASON = (
    "a flat face lies on the crests of waves as high and short as those of the profile, and does not follow them"
)
TOLERANCE_HALVINGS = 12
"""Of a tolerance that is too large, for the largest one that is not."""
QUARTER_TURNS = (0.0, 0.5 * pi, pi, -0.5 * pi)
DIRECTION_STEPS = (pi, *(side * each for each in (1.0, 0.3, 0.1, 0.03, 0.01) for side in (-1.0, 1.0)))
"""By how much a way is changed to find a worse cam, rad."""
CLIMB_ROUNDS = 2
"""How often each error is changed for it."""
DELAY_WEIGHTS = tuple(side * each for side in (1.0, -1.0) for each in (0.1, 1.0, 10.0))
"""How much it counts how late a cam is, to find the worst one at a jump."""
JUMP_SIDE_DISTANCE = 1e-9
"""Of a jump, rad."""
CAMS_BETWEEN, CAM_ZOOMS = 9, 6
"""Cams between two that are looked at, and how often between the neighbours of the worst one."""


class WorstCase(NamedTuple):
    """The largest error of a displacement, velocity or acceleration of the tool of any cam within the tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(tolerances={"follower.offset": 0.02})
    >>> worst = camopt.tolerance(scene).worst_case
    >>> round(worst.bound, 5), round(worst.error, 5), worst.errors
    (0.01778, -0.01778, {'follower.offset': 0.02})
    """

    bound: float
    """No cam within the tolerances has a larger error, proved; infinite if that is not known. mm (deg), or in the
    unit of the velocity or the acceleration."""
    error: float
    """That of a cam which has these ``errors``, by exact contact; below 0 where the tool is too low."""
    at_deg: float
    """The cam angle at which it has it."""
    errors: dict[str, float]
    """Of that cam, by key of ``[tolerances]``, mm and deg; ``bore_eccentricity_way`` is the direction in which the
    axis of the profile is off that of the bore, in the frame of the cam that does not turn, at the cam angle 0. A
    profile with n waves stands out by ``profile`` times cos(nφ − ``profile_way``) at the cam angle φ."""
    unproved: str = ""
    """Why no bound is proved; "" if one is."""

    @property
    def gap(self) -> float:
        """By how much some cam may be worse than that one."""
        return self.bound - abs(self.error)


NO_ERROR = WorstCase(0.0, 0.0, 0.0, {})
"""That of cams with tolerances that move no tool."""


def tool_error(cam: RealCam, order: int) -> BoundedQuantity:
    """The exact error of a derivative of the tool's motion where the first contact touches, over boxes of errors.

    In mm (rad) by powers of rad.
    """
    problem = cam.problem

    def error(errors: Errors, at: PartMotion) -> Any:
        moved = cam.contact_shift(0, problem.design, cam.errors_of_contact(0, errors), at.motion, order)
        further = MotionAhead(problem.programme, at, moved.cam_turn.terms[0], at.jumps_at_contact)
        found = follower_errors(moved, at.motion, further.derivative_change, at.jumps_at_contact.y2_jump, order)
        if len(cam.contacts) > 1:
            second = ContactAhead(cam, 1, errors, errors, at)
            both = zip(found, second.errors_at_first_contact(further, order), strict=True)
            found = [(a + b * second.motion_sign) * 0.5 for a, b in both]
        return error_through_train(problem, errors, found, further.derivative_ahead)

    return error


def angle_ahead_of_place(cam: RealCam, number: int) -> BoundedQuantity:
    """How far from the cam angle of a place the motion counts, rad: where the cam touches, or a second contact."""

    def enclose_angle_ahead(errors: Errors, at: PartMotion) -> Any:
        found = cam.contact_shift(
            0, cam.problem.design, cam.errors_of_contact(0, errors), at.motion, 0
        ).cam_turn.terms[0]
        return ContactAhead(cam, 1, errors, errors, at).angle_ahead(found) if number else found

    return enclose_angle_ahead


class CandidateCam(NamedTuple):
    """A cam that is off, mm and rad, with the cam angle of its profile where it is the most, and by how much."""

    errors: ErrorValues
    angle: float
    error: float


@dataclass(frozen=True)
class WorstSearch:
    """The search for the worst of the cams within tolerances, with one contact or two."""

    turn: TurnErrors
    error_ranges: NumberRanges
    """Between which values each error is (``errors.ends_of``)."""
    order: int = 0
    """Of the derivative of the motion that is looked at: displacement, velocity, acceleration."""

    @property
    def problem(self) -> Problem:
        return self.turn.problem

    @cached_property
    def cam(self) -> RealCam:
        """The cams; a profile without waves counts as off by a constant, and to order 0 any."""
        return RealCam(self.problem, (self.turn.scene.tolerances.waves or 0) if self.order else 0)

    def run(self) -> WorstCase:
        """The worst cam that is found, and what no cam exceeds.

        BadInput for tolerances so large that a follower has no place on its cam.
        """
        try:
            worst = self._make_candidate(self.nearly_worst_errors())
            if why := self.no_bound_reason:
                return self._make_worst_case(worst, inf, why)
            seconds = RATE_SECONDS if self.order else DISPLACEMENT_SECONDS
            until = clock_seconds() + seconds
            bound = self.prove_bound(abs(worst.error), RATE_GAP if self.order else DISPLACEMENT_GAP, until)
            if bound.witness is not None:
                worst = max(
                    worst,
                    self._make_candidate(self.errors_of_witness(bound.witness)),
                    key=lambda each: abs(each.error),
                )
            return self._make_worst_case(worst, bound.high, missing_bound_reason(bound.high, seconds, until))
        except FloatingPointError:
            raise self.no_contact_error() from None

    def _make_worst_case(self, found: CandidateCam, bound: float, unproved: str) -> WorstCase:
        unit, (errors, angle, error) = motion_scale(self.problem.setup, self.order), found
        there = float(self.contact_error(errors, np.array([angle])).angle[0])
        at = degrees(float(self.cam.angles_in_turn(np.array([there]))[0]))
        return WorstCase(unit * bound, unit * error, at, self.errors_in_mm_and_deg(errors, angle, there), unproved)

    def errors_of_witness(self, cam: ErrorValues) -> ErrorValues:
        """The errors of a cam without other variables of a proof."""
        return {key: cam[key] for key in self.error_ranges}

    @property
    def no_bound_reason(self) -> str:
        """Why there is no bound; "" where there may be one."""
        given = self.turn.scene.tolerances
        if self.problem.programme.corners:
            return CORNERS_REASON
        if not self.order or not given.profile:
            return ""
        return (
            SLOPES_REASON if given.waves is None else HOLLOWS_REASON if self._lies_on_crests(given.profile) else ""
        )

    def _lies_on_crests(self, zone: float) -> bool:
        """Whether a flat face does not follow waves: with w the radius of the profile is ρ + w + w''."""
        problem, convex = self.problem, frozenset({CONVEX_RADIUS})
        if not problem.setup.mechanism.flat_faced:
            return False
        found = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), convex).columns[
            CONVEX_RADIUS
        ]
        return bool(found[0] <= (self.cam.waves**2 - 1) * zone)

    def _make_candidate(self, errors: ErrorValues) -> CandidateCam:
        return CandidateCam(errors, *self.largest_error(errors))

    def prove_bound(self, least: float, gap: float, until: float, enough: float = inf) -> ProvedBound:
        """What no cam within the tolerances exceeds, nor ``least`` times 1 + gap if that is proved until a time.

        Or a cam that exceeds what is ``enough``.
        """
        search = self.bound_search(tool_error(self.cam, self.order), self.reach)
        parts, found = search.split_at_jumps(whole_panel_parts(self.problem, self.box)), ProvedBound(-inf, least)
        cases = [*self.jump_cases]
        for left, passed in zip(range(len(cases), 0, -1), cases, strict=True):
            more = replace(search, jump_case=passed).run(
                parts, found.witness_value, gap, time_share(until, left), enough
            )
            cam = found.witness if more.witness is None else more.witness
            found = ProvedBound(max(found.high, more.high), max(found.witness_value, more.witness_value), cam)
            parts = parts.take(np.flatnonzero(search.parts_near_jump(parts)))
            if not parts.size:
                break
        return found

    def bound_search(self, quantity: BoundedQuantity, reach: float = 0.0) -> BoundSearch:
        """The search for the bound of a quantity of all cams."""
        return BoundSearch(self.problem, quantity, self.error_ranges, self.box, jumps=self.jumps, reach=reach)

    @property
    def jump_cases(self) -> Iterable[JumpCase]:
        """What is proved one after the other of parts within reach of jumps."""
        if len(self.cam.contacts) == 1:
            return [(None, None)]
        return product((False, True) if self._whole_jumps else (None,), (False, True))

    @cached_property
    def box(self) -> NumberRanges:
        """Between which values each number of an error is."""
        found = coordinate_box(self.error_ranges)
        level = [key for key in found if self.order == 2 and key.startswith(WAVE_PHASE)]
        return found | {key.replace(WAVE_PHASE, PROFILE_LEVEL): found[key] for key in level}

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps that count, where the motion is taken elsewhere than at the place: of y'' and of y'''."""
        orders = range(2, self.order + len(self.cam.contacts))
        return tuple(each for order in orders for each in find_jumps(self.problem.programme, (order,)))

    @cached_property
    def _whole_jumps(self) -> list[Jump]:
        """The jumps of y'' where two contacts have the whole of them for an error of the acceleration."""
        two = len(self.cam.contacts) > 1
        return [jump for jump in self.jumps if jump.order == self.order == 2 and two]

    @cached_property
    def reach(self) -> float:
        """As far as any cam is late or early, rad; 0 where no jump counts."""
        if not self.jumps:
            return 0.0
        parts = whole_panel_parts(self.problem, self.box, sides=(1.0,))
        parts = parts.cut_steepest(np.eye(1, len(parts.low)).T + np.zeros(parts.size))
        proofs = (
            self.bound_search(angle_ahead_of_place(self.cam, number)) for number in range(len(self.cam.contacts))
        )
        with np.errstate(all="ignore"):
            found = [proof.enclose_quantity(parts).value.largest_magnitude.max() for proof in proofs]
        return (1.0 + LENGTH_ROUNDING) * float(max(found))

    def contact_error(self, errors: Errors, angles: FloatArray, *, jumps: bool = True) -> ContactError:
        """Where cams touch, and those of their motion there; or these but for what jumps of y'' make of them."""
        return self.cam.contact_error(flat_errors(errors), angles, self.order, jumps=jumps)

    def nearly_worst_errors(self) -> dict[str, float]:
        """Errors that are the worst, or nearly so, at the worst cam angle: most of them at their ends.

        Where y'' jumps, both contacts have the whole jump for an error of cams that are hardly late: these are
        between late ones and those that are the worst but for it.
        """
        found = [self._extreme_cam(side) for side in (1.0, -1.0)]
        if self.jumps:
            found += [self._extreme_cam_at_jump(side, way) for side in (1.0, -1.0) for way in DELAY_WEIGHTS]
        usual = self._climb_errors(max(found, key=lambda each: each.error))
        if not self._whole_jumps:
            return usual
        starts = {side: self._extreme_cam_at_jump(side, 0.0) for side in (1.0, -1.0)}
        between = [
            self._worst_between(starts[side], self._extreme_cam_at_jump(side, way))
            for side in starts
            for way in DELAY_WEIGHTS
        ]
        best = max(between, key=lambda each: each.error)
        return best.errors if best.error > abs(self.largest_error(usual)[1]) else usual

    def _extreme_cam(self, side: float) -> CandidateCam:
        """Those that are furthest off to a side, at the worst cam angle."""

        def signed_error(angles: FloatArray) -> FloatArray:
            return side * self.motion_errors(self.extreme_errors(angles, side), angles)

        return self._extreme_cam_at(angle_of_largest(self.turn.nodes, signed_error), side, 0.0)

    def _extreme_cam_at_jump(self, side: float, late: float) -> CandidateCam:
        """Those at the worst side of a jump, the more of cams that are late or early the larger ``late`` is."""
        places, turn = np.array([each.at for each in self.jumps]), self.problem.programme.strokes[-1].end
        angles = np.mod(np.concatenate([places - JUMP_SIDE, places + JUMP_SIDE]), turn)
        found = np.abs(self.motion_errors(self.extreme_errors(angles, side, late), angles))
        return self._extreme_cam_at(float(angles[found.argmax()]), side, late)

    def _extreme_cam_at(self, angle: float, side: float, late: float) -> CandidateCam:
        at = np.array([angle])
        errors = self.extreme_errors(at, side, late)
        most = float(np.abs(self.motion_errors(errors, at))[0])
        return CandidateCam({key: float(each[0]) for key, each in errors.items()}, angle, most)

    def _climb_errors(self, found: CandidateCam) -> dict[str, float]:
        """Errors that are worse at a cam angle, each changed by itself."""
        errors, angle, most = found
        for _ in range(CLIMB_ROUNDS):
            for key, ends in self.error_ranges.items():
                values = errors[key] + np.array(DIRECTION_STEPS) if is_direction(key) else np.array(ends)
                tried = {name: np.full(values.size, each) for name, each in errors.items()} | {key: values}
                off = np.abs(self.motion_errors(tried, np.full(values.size, angle)))
                if off.max() > most:
                    most, errors = float(off.max()), {**errors, key: float(values[off.argmax()])}
        return errors

    def _worst_between(self, one: CandidateCam, other: CandidateCam) -> CandidateCam:
        """The worst of the cams between two, next to a jump."""
        ends, low, high = [flat_errors(each.errors) for each in (one, other)], 0.0, 1.0
        for _ in range(CAM_ZOOMS):
            shares = np.linspace(low, high, CAMS_BETWEEN)
            errors = polar_errors(
                {key: (1.0 - shares) * ends[0][key] + shares * ends[1][key] for key in ends[0]}, self.error_ranges
            )
            places = self._jump_contact_places(errors)
            every = {key: np.tile(each, len(places)) for key, each in errors.items()}
            found = np.abs(self.motion_errors(every, places.ravel())).reshape(places.shape)
            row, k = (int(each) for each in np.unravel_index(found.argmax(), found.shape))
            low, high = shares[max(k - 1, 0)], shares[min(k + 1, CAMS_BETWEEN - 1)]
        return CandidateCam(
            {key: float(each[k]) for key, each in errors.items()}, float(places[row, k]), float(found[row, k])
        )

    def _jump_contact_places(self, errors: Mapping[str, FloatArray]) -> FloatArray:
        """The places next to which jumps begin and end to count for cams (m,), on both sides: (places, m)."""
        count, jumps = len(next(iter(errors.values()))), [jump.at for jump in self._whole_jumps]
        every, at = {key: np.tile(each, len(jumps)) for key, each in errors.items()}, np.repeat(jumps, count)
        found = np.reshape([at, *self._places_at_angles(every, at)], (-1, count))
        return self.cam.angles_in_turn(np.concatenate([found - JUMP_SIDE_DISTANCE, found + JUMP_SIDE_DISTANCE]))

    def _places_at_angles(self, errors: Mapping[str, FloatArray], angles: FloatArray) -> list[FloatArray]:
        """The places of the first contact when it touches at cam angles, and when the second one touches there."""
        known, found = flat_errors(errors), [angles, angles]
        for _ in range(CONTACT_ROUNDS):
            turned = [self.cam.cam_turns(known, each) for each in found]
            found = [angles - turned[0], angles - self.cam.second_contact_lead(known, found[1], turned[1])]
        return found

    def extreme_errors(self, angles: FloatArray, side: float, late: float = 0.0) -> dict[str, FloatArray]:
        """For each cam angle the ends of errors that move the tool furthest to a side.

        With as much of how late they make the cam, in units of what all errors of one end make of both.
        """
        rows, every = list[ErrorValues](), {key: high for key, (_, high) in self.error_ranges.items()}
        for key, ends in self.error_ranges.items():
            if (way := direction_key(key)) in self.error_ranges and not is_direction(key):
                rows += [{key: ends[1], way: each} for each in QUARTER_TURNS]
            elif not is_direction(key):
                rows += [{key: end} for end in ends]
        found, moved = dict[str, FloatArray](), iter(self._tool_shifts([*rows, every], angles, side, late))
        for key, (low, high) in self.error_ranges.items():
            if (way := direction_key(key)) in self.error_ranges and not is_direction(key):
                right, up, left, down = (next(moved) for _ in QUARTER_TURNS)
                found |= {key: np.full(angles.size, high), way: np.arctan2(up - down, right - left)}
            elif not is_direction(key):
                found[key] = np.where(next(moved) > next(moved), low, high)
        return found

    def _tool_shifts(self, cams: list[ErrorValues], angles: FloatArray, side: float, late: float) -> FloatArray:
        """How far cams move the tool to a side, with so much of how late they are; in units of the last of them."""
        errors = {key: np.repeat([cam.get(key, 0.0) for cam in cams], angles.size) for key in self.error_ranges}
        every = np.tile(angles, len(cams))
        found = self._finite_contact_error(errors, every, jumps=False)
        error, ahead = (each.reshape(len(cams), -1) for each in (found.error, found.angle - every))
        weight = np.abs(error[-1]) / np.maximum(np.abs(ahead[-1]), JUMP_SIDE)
        return np.asarray(side * error + late * weight * ahead)

    def motion_errors(self, errors: Mapping[str, Any], angles: FloatArray) -> FloatArray:
        """Those of the motion of cams where they touch."""
        return self._finite_contact_error(errors, angles).error

    def _finite_contact_error(
        self, errors: Mapping[str, Any], angles: FloatArray, *, jumps: bool = True
    ) -> ContactError:
        """FloatingPointError where a follower does not touch its cam."""
        with np.errstate(invalid="ignore"):
            found = self.contact_error(errors, angles, jumps=jumps)
        if not np.isfinite(found.error).all():
            raise FloatingPointError
        return found

    def no_contact_error(self) -> BadInput:
        """The message on tolerances so large that a follower has no place on its cam: the first such, or all."""
        alone = [[key, direction_key(key)] for key in self.error_ranges if not is_direction(key)]
        of = next((each for each in alone if not self._touches_all_over(each, 1.0)), [*self.error_ranges])
        low, high = 0.0, 1.0
        for _ in range(TOLERANCE_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._touches_all_over(of, middle) else (low, middle)
        why = "so far off, a follower does not touch its cam all over the turn, or cannot be put together"
        if of == [*self.error_ranges] and len(alone) > 1:
            why = f"{why}: at most {100.0 * low:.3g} % of these"
            return BadInput([Mistake(self.problem.file, "tolerances", None, why, bare=True)])
        unit = degrees(1.0) if of[0] in ANGLE_TOLERANCES else 1.0
        most = unit * max(map(abs, self.error_ranges[of[0]]))
        why = f"{why}: at most about {low * most:.3g}"
        place = PROFILE_PLACES if of[0] == "profile" else f"tolerances.{of[0]}"
        return BadInput([Mistake(self.problem.file, place, most, why, bare=True)])

    def _touches_all_over(self, keys: list[str], share: float) -> bool:
        """Whether followers touch cams all over the turn with errors of some keys alone, up to a share of each."""
        ends = {key: self.error_ranges[key] for key in keys if key in self.error_ranges}
        shared = {key: (low * share, high * share) for key, (low, high) in ends.items()}
        try:
            search = replace(self, error_ranges=shared | {key: ends[key] for key in ends if is_direction(key)})
            search.largest_error(search.nearly_worst_errors())
        except FloatingPointError:
            return False
        return True

    def largest_error(self, errors: Mapping[str, float]) -> tuple[float, float]:
        """Where on its profile a cam has its largest error, and this."""
        angle = angle_of_largest(self.turn.nodes, lambda angles: np.abs(self.motion_errors(errors, angles)))
        usual = angle, float(self.motion_errors(errors, np.array([angle]))[0])
        if not self._whole_jumps:
            return usual
        places = self._jump_contact_places({key: np.array([each]) for key, each in errors.items()}).ravel()
        found = self.motion_errors({key: np.full(places.size, each) for key, each in errors.items()}, places)
        most = np.abs(found).argmax()
        return (float(places[most]), float(found[most])) if abs(found[most]) > abs(usual[1]) else usual

    def errors_in_mm_and_deg(self, errors: Mapping[str, float], place: float, angle: float) -> dict[str, float]:
        """Errors in mm and deg, of a cam that is touched at a place at a cam angle.

        With the direction of the bore as the cam has it, and where waves have a crest.
        """
        found, sense = dict(errors), self.problem.design.sense
        if BORE in errors:
            developed, long = self.problem.setup.mechanism.body.developed, errors[BORE]
            turned = angle + errors.get("phase", 0.0) if developed else place
            way = errors.get(BORE_DIRECTION, 0.0 if long >= 0.0 else pi)
            found |= {BORE: abs(long), BORE_DIRECTION: way - sense * turned}
        for key in errors:
            if key.startswith(WAVE_PHASE):
                found[key] = self.cam.waves * self.profile_place(key, errors, place) - errors[key]
        shown = {key: degrees(each) for key, each in found.items() if is_direction(key) or key in ANGLE_TOLERANCES}
        return found | {key: each % 360.0 if is_direction(key) else each for key, each in shown.items()}

    def profile_place(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        """The cam angle of the place of the profile that an error is of, where the first contact touches at one."""
        if not key.endswith(SECOND_CONTACT_SUFFIX):
            return angle
        at, known = np.array([angle]), flat_errors(errors)
        return angle + float(self.cam.second_contact_lead(known, at, self.cam.cam_turns(known, at))[0])


def worst_search(
    turn: TurnErrors, order: int = 0, changed: Mapping[str, tuple[float, float]] | None = None
) -> WorstSearch:
    """The search for the worst cam in displacement (0), velocity (1) or acceleration (2), within its tolerances.

    ``changed`` are other ends of errors than those of the scene.
    """
    return WorstSearch(turn, {**contact_error_ranges(turn.scene, turn.problem, order), **(changed or {})}, order)

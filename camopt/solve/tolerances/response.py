"""How the motion of one design answers to a small error, at the tool: f'·δ with the ratio f' of the train.

What the follower answers is ``effects.answers``; of a number p of the train the tool moves by ∂f/∂p.

Errors of a follower with two contacts are half of the difference of both, and their sum is what holds these apart.
Each contact, as of an ordinary cam with the motion of its own (``mechanisms.pairs``), would move the follower by e₁
outward, or by e₂ back, more than is asked. Both are equally stiff (``effects.preload``), so that a follower which
both hold stands in the middle, and they are nearer to each other by the sum:

    δ = (e₁ − e₂)/2,    s = e₁ + e₂,    P = k·(δ₀ + s)

with the interference δ₀ against the stiffness k; where δ₀ + s is below 0 there is a clearance as large. What the
preload stores, ½·k·(δ₀ + s)², changes over a turn, and so it turns the camshaft back and forth by the torque P·s':
that is 0 of the nominal cam. Where the nominal follower has a clearance, δ is that of the middle of it.

What is of one disc or its roller counts at one contact: sizes under ``[drive]``, the angle between the discs and a
profile of its own at the second. The pivot, the angle on the shaft and the bore of both discs count at both. So do
the arms of two rollers about a rib, which are of one length, and the distance of these, by half at each; its two
flanks and rollers are off each by itself.
Another base radius has the motion that is asked, and moves the roller by ∂s₀/∂R_b: that is an error of s alone.

Source: Rothbart, Cam Design Handbook, ch. 3 (conjugate and yoke cams).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.effects.error_response import (
    RESPONSE_ORDERS,
    SECOND_CONTACT_SUFFIX,
    ContactResponse,
    ErrorAtContacts,
    SignedKey,
    errors_by_contact,
    largest_profile_response,
    link_response,
    second_motion_sign,
    second_profile_sign,
    series_derivatives,
)
from camopt.model.mechanisms import Designs
from camopt.model.motion.tool_drive import train_ratio_series
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import number_zones, tool_zones
from camopt.scene.problem.variables import is_train_key
from camopt.scene.scene import Scene
from camopt.solve.tolerances.errors import BORE, contact_problems, is_second_mirrored

BASE_RADII = "cam.base_radius", "drive.base_radius"
BASE_RADIUS_STEP = 1e-6
"""Of a base radius, relative, for the slope of where its roller stands."""


@dataclass(frozen=True)
class ToolResponse:
    """The answers of the motion of one design at cam angles (m,) in rad: δ, δ' and δ'' of the tool, each (3, m).

    In mm or rad by mm or rad of the error; the derivatives by the cam angle in rad.
    """

    problem: Problem
    angles: FloatArray

    @cached_property
    def follower_response(self) -> ContactResponse:
        """Those of the follower."""
        return ContactResponse(
            self.problem.setup.mechanism, self.problem.design, self.problem.programme, self.angles
        )

    def number_response(self, key: str) -> FloatArray:
        """To a number that is larger than it should be, by its key: a size of the follower, a link, or an angle."""
        return (
            self._link_response(key)
            if is_train_key(key)
            else self._through_train(self.follower_response.number_response(key))
        )

    def response_rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """To an error of a key of ``[tolerances]``, to its real and its imaginary part."""
        if key == "bore_eccentricity":
            return self.bore_responses
        if key == "profile":
            return self.wave_responses(waves) if waves else (self.profile_response,)
        return (self.number_response(key),)

    def size_response(self, field: str) -> FloatArray:
        """To a size of the follower, by field of ``Designs``, that is larger than it should be."""
        return self._through_train(self.follower_response.size_response(field))

    @cached_property
    def profile_response(self) -> FloatArray:
        """To a profile that stands out along its normal everywhere, as to a roller that is larger by as much."""
        return self._through_train(self.follower_response.profile_response)

    def wave_responses(self, count: int) -> tuple[FloatArray, FloatArray]:
        """To a profile that stands out as a cosine, and as a sine, of so many waves in a turn."""
        cosine, sine = map(self._through_train, self.follower_response.wave_responses(count))
        return cosine, sine

    @cached_property
    def bore_responses(self) -> tuple[FloatArray, FloatArray]:
        """To a profile whose axis is off that of the bore, in each of two directions that turn with the cam."""
        first, second = map(self._through_train, self.follower_response.bore_responses)
        return first, second

    @cached_property
    def train_ratio(self) -> Series | None:
        """The ratio of the train; None without one."""
        train = self.problem.setup.train
        return None if train is None else train_ratio_series(train, self.problem.programme, self.angles)

    def _link_response(self, key: str) -> FloatArray:
        """To a number of the train, from the series of the tool by it, whose terms are series by the cam angle."""
        problem, train = self.problem, self.problem.setup.train
        assert train is not None
        made = problem.trains_with_numbers({key: Taylor([problem.nominal_numbers[key], 1.0])})
        return self._angle_derivatives(link_response(made, train, problem.programme, self.angles))

    def _through_train(self, found: Series) -> FloatArray:
        """What a series of the follower is at the tool."""
        return self._angle_derivatives(found if self.train_ratio is None else found * self.train_ratio)

    def _angle_derivatives(self, found: Series) -> FloatArray:
        return series_derivatives(found, self.angles.shape)


def wider_profiles(problem: Problem) -> ErrorAtContacts:
    """Both profiles that stand out alike: what holds the contacts further apart."""
    return ErrorAtContacts(("profile", 1.0), ("profile", second_profile_sign(problem.setup.mechanism)))


@dataclass(frozen=True)
class PairResponse:
    """The answers of both contacts, and of the tool, at cam angles (m,), rad."""

    problem: Problem
    angles: FloatArray

    @cached_property
    def contacts(self) -> tuple[ToolResponse, ToolResponse]:
        first, second = (ToolResponse(each, self.angles) for each in contact_problems(self.problem))
        return first, second

    def error_response(self, at: ErrorAtContacts) -> FloatArray:
        """Of the tool, to an error, (3, m)."""
        return self.through_train(
            (self._contact_response(0, at.first) - self._contact_response(1, at.second)) / 2.0
        )

    def separation_response(self, at: ErrorAtContacts) -> FloatArray:
        """Of what both contacts are apart, to an error, (m,)."""
        return np.asarray(self.separation_derivatives(at)[0])

    def separation_derivatives(self, at: ErrorAtContacts) -> FloatArray:
        """The same with its derivatives by the cam angle, (3, m)."""
        return self._contact_response(0, at.first) + self._contact_response(1, at.second)

    @cached_property
    def bore_responses(self) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """To the axis of the bore in two directions that turn with the cam, at both contacts; y in the mirror."""
        (x, y), (across, up) = (each.bore_responses for each in self.contacts)
        way = second_motion_sign(self.problem.setup.mechanism)
        return (x, way * across), (y, -way * up if is_second_mirrored(self.problem) else way * up)

    @property
    def tool_ratio(self) -> FloatArray:
        """Of the tool to the follower, (m,)."""
        return np.asarray(self.through_train(np.ones((RESPONSE_ORDERS, self.angles.size)))[0])

    def through_train(self, found: FloatArray) -> FloatArray:
        """What derivatives at the follower are at the tool."""
        if self.problem.setup.train is None:
            return found
        moved = Taylor([found[0], found[1], found[2] / 2.0]) * ToolResponse(self.problem, self.angles).train_ratio
        return series_derivatives(moved, self.angles.shape)

    def response_rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """To an error of one key, to its real and its imaginary part."""
        if key == BORE:
            return tuple(self.through_train((first - second) / 2.0) for first, second in self.bore_responses)
        if is_train_key(key):
            return (ToolResponse(self.problem, self.angles).number_response(key),)
        at = errors_by_contact(self.problem.setup.mechanism, key.removesuffix(SECOND_CONTACT_SUFFIX))[key]
        if not (waves and key.startswith("profile")):
            return (self.error_response(at),)
        place, sign = self._contact_and_sign(at)
        half = 0.5 - place  # of e₁, or of −e₂
        return tuple(self.through_train(half * sign * each) for each in self.contacts[place].wave_responses(waves))

    def separation_rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """The same of what both contacts are apart, (m,) each: of a base radius too, 0 of a number of the train."""
        if key == BORE:
            return tuple((first + second)[0] for first, second in self.bore_responses)
        if key in BASE_RADII:
            return (np.full(self.angles.size, _start_slopes(self.problem)[key]),)
        if is_train_key(key):
            return (np.zeros(self.angles.size),)
        at = errors_by_contact(self.problem.setup.mechanism, key.removesuffix(SECOND_CONTACT_SUFFIX))[key]
        if not (waves and key.startswith("profile")):
            return (self.separation_response(at),)
        place, sign = self._contact_and_sign(at)
        return tuple(sign * each[0] for each in self.contacts[place].wave_responses(waves))

    def _contact_and_sign(self, at: ErrorAtContacts) -> tuple[int, float]:
        """The contact that an error is of alone, and its sign there."""
        return (
            (0, 1.0) if at.second is None else (1, second_motion_sign(self.problem.setup.mechanism) * at.second[1])
        )

    def _contact_response(self, place: int, own: SignedKey | None) -> FloatArray:
        if own is None:
            return np.zeros((RESPONSE_ORDERS, self.angles.size))
        key, sign = own
        answers = self.contacts[place]
        sign *= second_motion_sign(self.problem.setup.mechanism) if place else 1.0
        return sign * (answers.profile_response if key == "profile" else answers.number_response(key))


class SeparationRange(NamedTuple):
    """By how much both contacts are held further apart at least and at most, mm (rad), at each cam angle."""

    low: FloatArray
    high: FloatArray

    @property
    def lowest(self) -> float:
        return float(self.low.min())

    @property
    def highest(self) -> float:
        return float(self.high.max())


def separation_range(scene: Scene, problem: Problem, angles: FloatArray) -> SeparationRange:
    """s of all cams within the tolerances, at cam angles, to first order."""
    found, none = [*separation_by_key(scene, problem, angles)], np.zeros(angles.size)
    return SeparationRange(*(sum((each[end] for _, each in found), none) for end in (0, 1)))


class SeparationResponse(NamedTuple):
    """What errors of a tolerance make of s, at cam angles, and between which values they are."""

    key: str
    rows: FloatArray
    """For each of the errors that the tolerance is of, (k, m)."""
    lower: float
    upper: float

    @property
    def range_over_turn(self) -> SeparationRange:
        return SeparationRange(*np.sort([self.lower * self.rows, self.upper * self.rows], axis=0).sum(axis=1))

    def separation_of_cams(self, off: FloatArray | None, end: int) -> FloatArray:
        """What it makes at least (0) or at most (1); of cams (n,) that are off so, at all of them, (n, m)."""
        return self.range_over_turn[end] if off is None else np.multiply.outer(off, self.rows.sum(axis=0))


def separation_by_key(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[tuple[str, SeparationRange]]:
    """What each tolerance makes of s, by its key."""
    for each in separation_responses(scene, problem, angles):
        yield each.key, each.range_over_turn


def separation_responses(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[SeparationResponse]:
    """The answers of s to all that tolerances are of; that of the bore is in the direction with the largest."""
    answers, given = PairResponse(problem, angles), scene.tolerances
    zones = {key: (zone.lower, zone.upper) for key, zone in tool_zones(scene, problem.nominal_numbers).items()}
    if given.profile:
        zones["profile"] = -given.profile, given.profile
    for key, ends in zones.items():
        if not is_train_key(key):
            every = [
                answers.separation_response(at) for at in errors_by_contact(problem.setup.mechanism, key).values()
            ]
            yield SeparationResponse(key, np.array(every), *ends)
    if bore := given.bore_eccentricity:
        most = np.hypot(*(first[0] + second[0] for first, second in answers.bore_responses))
        yield SeparationResponse(BORE, most[None], -bore, bore)
    for key, (lower, upper) in _base_radius_zones(scene, problem).items():
        yield SeparationResponse(key, np.full((1, angles.size), _start_slopes(problem)[key]), lower, upper)


def fastest_separation(scene: Scene, problem: Problem, angles: FloatArray) -> FloatArray:
    """The largest |s'| by the cam angle of all cams within the tolerances, to first order.

    Infinite for a profile without a number of waves.
    """
    answers, given, found = PairResponse(problem, angles), scene.tolerances, np.zeros(angles.size)
    for key, zone in tool_zones(scene, problem.nominal_numbers).items():
        if not is_train_key(key):
            for at in errors_by_contact(problem.setup.mechanism, key).values():
                found += max(-zone.lower, zone.upper) * np.abs(answers.separation_derivatives(at)[1])
    if given.profile:
        for at in errors_by_contact(problem.setup.mechanism, "profile").values():
            found += largest_profile_response(answers.separation_derivatives(at), given.profile, given.waves)[1]
    if given.bore_eccentricity:
        found += given.bore_eccentricity * np.hypot(
            *(first[1] + second[1] for first, second in answers.bore_responses)
        )
    return found


def _base_radius_zones(scene: Scene, problem: Problem) -> dict[str, tuple[float, float]]:
    """By how much base radii may be off, mm."""
    zones = number_zones(scene, problem.nominal_numbers)
    return {key: (zones[key].lower, zones[key].upper) for key in BASE_RADII if key in zones}


def _start_slopes(problem: Problem) -> dict[str, float]:
    """By how much both contacts stand further apart for a larger base radius, mm/mm (rad/mm)."""
    mechanism = problem.setup.mechanism
    start = mechanism.start or (lambda designs: designs.size)

    def slope(designs: Designs) -> float:
        step = BASE_RADIUS_STEP * designs.size
        ends = (start(replace(designs, size=designs.size + side * step)) for side in (1.0, -1.0))
        return float(((next(ends) - next(ends)) / (2.0 * step))[0])

    if mechanism.has_rib:
        return {"cam.base_radius": 0.0}  # both stand further out alike
    first, second = slope(problem.design), slope(mechanism.further_contacts[0].local_designs(problem.design))
    if mechanism.drive.one_disc:
        return {"cam.base_radius": first + second}
    return {"cam.base_radius": first, "drive.base_radius": second}


def motion_response(problem: Problem, angles: FloatArray) -> ToolResponse | PairResponse:
    """The answers of the motion of a problem, with one contact or two."""
    return (PairResponse if problem.setup.mechanism.further_contacts else ToolResponse)(problem, angles)

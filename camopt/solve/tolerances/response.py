"""First-order response of one design's motion to small errors, at the tool.

``effects.tool_response`` has the response δ of the follower. The tool moves by f'·δ, with the ratio f' of the
train. An error of a number p of the train moves the tool by ∂f/∂p.

**Two contacts.** Each contact alone, as that of an ordinary cam (``mechanisms.pairs``), would move the follower too
far: the first by e₁ outward, the second by e₂ back. Both are equally stiff (``effects.preload``), so a follower
held by both is in the middle, and errors increase their interference by the sum s:

    δ = (e₁ − e₂)/2,    s = e₁ + e₂,    P = k·(δ₀ + s)

δ₀ is the interference and k the stiffness. If δ₀ + s is negative, there is a clearance of that size; δ is then the
error of its middle. The energy ½·k·(δ₀ + s)² of the preload changes over a turn, which loads the camshaft with an
alternating torque P·s'. This torque is 0 for the nominal cam.

An error of one disc or its roller acts at one contact. Sizes under ``[drive]``, the angle between the discs, and
the second disc's own profile act at the second. Errors of the pivot, of the angle on the shaft, and of the common
bore act at both. So do the arm of both rollers about a rib, and the distance of these rollers, by half at each. The
two flanks and the two rollers of a rib have independent errors. An error of a base radius does not change the
motion, but moves the roller by ∂s₀/∂R_b: it is an error of s only.

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
    SignedKey,
    errors_at_contacts_by_key,
    largest_error_by_profile_zone,
    second_contact_motion_error_sign,
    series_derivatives,
    tool_response_to_train_error,
)
from camopt.model.mechanisms import Designs
from camopt.model.motion.tool_drive import train_ratio_series
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import tolerance_zones_of_numbers, tolerance_zones_that_move_tool
from camopt.scene.problem.variables import is_train_key
from camopt.scene.scene import Scene
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    contact_problems,
    error_keys_at_contacts,
    error_ranges_at_one_contact,
    reverses_cam_at_second_contact,
)

BASE_RADII = "cam.base_radius", "drive.base_radius"
BASE_RADIUS_STEP = 1e-6
"""Relative step of a base radius, for the derivative of the roller's position."""


@dataclass(frozen=True)
class ToolResponse:
    """Response of the tool of one design to errors of 1, at cam angles (rad): δ, δ' and δ'', shape (3, angles).

    In mm or rad per mm or rad of the error; the derivatives are by the cam angle in rad.
    """

    problem: Problem
    angles: FloatArray

    @cached_property
    def follower_response(self) -> ContactResponse:
        return ContactResponse(
            self.problem.setup.mechanism, self.problem.design, self.problem.programme, self.angles
        )

    def number_response(self, key: str) -> FloatArray:
        """Response to an error of a number, by its key: a size of the follower, a link of the train or an angle."""
        return (
            self._link_response(key)
            if is_train_key(key)
            else self._tool_derivatives(self.follower_response.response_to_error(key))
        )

    def response_rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """Responses to the error of a key of ``[tolerances]``: one, or those to its real and imaginary part."""
        if key == "bore_eccentricity":
            return self.bore_responses_in_two_directions
        if key == "profile":
            return self.wave_responses(waves) if waves else (self.profile_response,)
        return (self.number_response(key),)

    @cached_property
    def profile_response(self) -> FloatArray:
        """Response to a profile that is too high by a constant along its normal; a larger roller has the same."""
        return self._tool_derivatives(self.follower_response.profile_response)

    def wave_responses(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Responses to a cosine and to a sine error of the profile with ``count`` waves in a turn."""
        cosine, sine = map(self._tool_derivatives, self.follower_response.cosine_and_sine_wave_responses(count))
        return cosine, sine

    @cached_property
    def bore_responses_in_two_directions(self) -> tuple[FloatArray, FloatArray]:
        """Responses to an eccentricity of the bore in two directions that turn with the cam."""
        first, second = map(self._tool_derivatives, self.follower_response.bore_responses_in_two_directions)
        return first, second

    @cached_property
    def train_ratio(self) -> Series | None:
        """Ratio of the train, a series; None without a train."""
        train = self.problem.setup.train
        return None if train is None else train_ratio_series(train, self.problem.programme, self.angles)

    def _link_response(self, key: str) -> FloatArray:
        problem, train = self.problem, self.problem.setup.train
        assert train is not None
        # the series of the tool by the number, whose terms are series by the cam angle
        trains = problem.trains_with_numbers({key: Taylor([problem.nominal_numbers[key], 1.0])})
        return series_derivatives(
            tool_response_to_train_error(trains, train, problem.programme, self.angles), self.angles.shape
        )

    def _tool_derivatives(self, series: Series) -> FloatArray:
        """Derivatives at the tool of a series of the follower."""
        return series_derivatives(
            series if self.train_ratio is None else series * self.train_ratio, self.angles.shape
        )


@dataclass(frozen=True)
class PairResponse:
    """Response of both contacts, and of the tool, to errors of 1 at cam angles (rad)."""

    problem: Problem
    angles: FloatArray

    @cached_property
    def contact_responses(self) -> tuple[ToolResponse, ToolResponse]:
        first, second = (ToolResponse(each, self.angles) for each in contact_problems(self.problem))
        return first, second

    @cached_property
    def bore_responses_in_two_directions(
        self,
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """Responses of both contacts to an eccentricity of the bore, in two directions that turn with the cam.

        The second direction changes its sign at a mirrored second contact.
        """
        (x, y), (across, up) = (each.bore_responses_in_two_directions for each in self.contact_responses)
        sign = second_contact_motion_error_sign(self.problem.setup.mechanism)
        return (x, sign * across), (
            y,
            -sign * up if reverses_cam_at_second_contact(self.problem) else sign * up,
        )

    def tool_derivatives(self, derivatives: FloatArray) -> FloatArray:
        """Derivatives at the tool, from those at the follower, shape (3, angles)."""
        if self.problem.setup.train is None:
            return derivatives
        follower = Taylor([derivatives[0], derivatives[1], derivatives[2] / 2.0])
        return series_derivatives(follower * ToolResponse(self.problem, self.angles).train_ratio, self.angles.shape)

    def response_rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """Responses of the tool to the error of a key: one, or those to its real and imaginary part."""
        if is_train_key(key):
            return (ToolResponse(self.problem, self.angles).number_response(key),)
        both = self.responses_of_contacts(key, waves)
        return tuple(self.tool_derivatives((first - second) / 2.0) for first, second in both)

    def separation_rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """Responses of the separation s to the error of a key: one, or those to its real and imaginary part.

        A base radius changes s too; a number of the train does not.
        """
        if key in BASE_RADII:
            return (np.full(self.angles.size, _separation_slopes_by_base_radius(self.problem)[key]),)
        if is_train_key(key):
            return (np.zeros(self.angles.size),)
        return tuple((first + second)[0] for first, second in self.responses_of_contacts(key, waves))

    def responses_of_contacts(self, key: str, waves: int = 0) -> Sequence[tuple[FloatArray, FloatArray]]:
        """Responses e₁ and e₂ to the error of a key: one pair, or those to its real and imaginary part."""
        if key == BORE:
            return self.bore_responses_in_two_directions
        mechanism, (first, second) = self.problem.setup.mechanism, self.contact_responses
        at = errors_at_contacts_by_key(mechanism, key.removesuffix(SECOND_CONTACT_SUFFIX))[key]
        if not (waves and key.startswith("profile")):
            return ((self._contact_response(0, at.first), self._contact_response(1, at.second)),)
        none = np.zeros((RESPONSE_ORDERS, self.angles.size))
        if at.second is None:
            return [(each, none) for each in first.wave_responses(waves)]
        sign = second_contact_motion_error_sign(mechanism) * at.second[1]
        return [(none, sign * each) for each in second.wave_responses(waves)]

    def _contact_response(self, contact_number: int, signed_key: SignedKey | None) -> FloatArray:
        if signed_key is None:
            return np.zeros((RESPONSE_ORDERS, self.angles.size))
        key, sign = signed_key
        contact = self.contact_responses[contact_number]
        sign *= second_contact_motion_error_sign(self.problem.setup.mechanism) if contact_number else 1.0
        return sign * (contact.profile_response if key == "profile" else contact.number_response(key))


class SeparationRange(NamedTuple):
    """Least and largest separation s, by which errors force both contacts apart, at each cam angle, mm (rad)."""

    low: FloatArray
    high: FloatArray


def separation_range(scene: Scene, problem: Problem, angles: FloatArray) -> SeparationRange:
    """Range of the separation s over all cams within the tolerances, at cam angles (rad), to first order."""
    ranges = [each.range_over_turn for each in separation_responses_by_tolerance(scene, problem, angles)]
    return SeparationRange(*(sum((each[end] for each in ranges), np.zeros(angles.size)) for end in (0, 1)))


class SeparationResponse(NamedTuple):
    """Response of the separation s to the errors of one tolerance, at cam angles, and the range of these errors."""

    key: str
    rows: FloatArray
    """One row for each error of the tolerance, shape (errors, angles)."""
    lower: float
    upper: float

    @property
    def range_over_turn(self) -> SeparationRange:
        return SeparationRange(*np.sort([self.lower * self.rows, self.upper * self.rows], axis=0).sum(axis=1))


def separation_responses_by_tolerance(
    scene: Scene, problem: Problem, angles: FloatArray
) -> Iterator[SeparationResponse]:
    """Response of the separation s to each tolerance; for the bore in the direction of the largest response."""
    response = PairResponse(problem, angles)
    for key, ends in error_ranges_at_one_contact(scene, problem).items():
        if not is_train_key(key) and key not in (BORE, BORE_DIRECTION):
            rows = [response.separation_rows(each, 0)[0] for each in error_keys_at_contacts(problem, key)]
            yield SeparationResponse(key, np.array(rows), *ends)
    if bore := scene.tolerances.bore_eccentricity:
        yield SeparationResponse(BORE, np.hypot(*response.separation_rows(BORE, 0))[None], -bore, bore)
    for key, zone in tolerance_zones_of_numbers(scene, problem.nominal_numbers).items():
        if key in BASE_RADII:
            slope = _separation_slopes_by_base_radius(problem)[key]
            yield SeparationResponse(key, np.full((1, angles.size), slope), zone.lower, zone.upper)


def largest_separation_slope_at_angles(scene: Scene, problem: Problem, angles: FloatArray) -> FloatArray:
    """Largest |s'| at each cam angle over all cams within the tolerances, to first order [mm/rad or rad/rad].

    Infinite for a profile without a limit of its waves.
    """
    response, tolerances, speed = PairResponse(problem, angles), scene.tolerances, np.zeros(angles.size)
    for key, zone in tolerance_zones_that_move_tool(scene, problem.nominal_numbers).items():
        if not is_train_key(key):
            for error_key in error_keys_at_contacts(problem, key):
                ((first, second),) = response.responses_of_contacts(error_key)
                speed += max(-zone.lower, zone.upper) * np.abs((first + second)[1])
    if tolerances.profile:
        for error_key in error_keys_at_contacts(problem, "profile"):
            ((first, second),) = response.responses_of_contacts(error_key)
            speed += largest_error_by_profile_zone(first + second, tolerances.profile, tolerances.waves)[1]
    if tolerances.bore_eccentricity:
        speed += tolerances.bore_eccentricity * np.hypot(
            *(first[1] + second[1] for first, second in response.bore_responses_in_two_directions)
        )
    return speed


def _separation_slopes_by_base_radius(problem: Problem) -> dict[str, float]:
    """Increase of the separation s with each base radius [mm/mm or rad/mm]."""
    mechanism = problem.setup.mechanism
    start = mechanism.start or (lambda designs: designs.size)

    def separation_slope_by_size(designs: Designs) -> float:
        step = BASE_RADIUS_STEP * designs.size
        ends = (start(replace(designs, size=designs.size + side * step)) for side in (1.0, -1.0))
        return float(((next(ends) - next(ends)) / (2.0 * step))[0])

    if mechanism.has_rib:
        return {"cam.base_radius": 0.0}  # both contacts move outwards by the same amount
    first, second = (
        separation_slope_by_size(problem.design),
        separation_slope_by_size(mechanism.further_contacts[0].local_designs(problem.design)),
    )
    if mechanism.drive.one_disc:
        return {"cam.base_radius": first + second}
    return {"cam.base_radius": first, "drive.base_radius": second}


def motion_response(problem: Problem, angles: FloatArray) -> ToolResponse | PairResponse:
    """Response of the motion of a problem, with one contact or two."""
    return (PairResponse if problem.setup.mechanism.further_contacts else ToolResponse)(problem, angles)

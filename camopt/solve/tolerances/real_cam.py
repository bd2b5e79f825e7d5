"""Real cams: exact contact of a cam with errors, and the resulting error of its tool.

A nominal cam touches its follower with the point φ at the cam angle φ. A cam with errors touches with this point at
θ = φ + τ, and its follower stands at y(φ) + m (``mechanisms.contact_errors_from_flat_errors``). Both τ and m are
series in φ, so the velocity there is (y' + m')/(1 + τ'). A prime is the derivative by φ, and d_k = y⁽ᵏ⁾(θ) −
y⁽ᵏ⁾(φ) the change of the programmed motion from φ to θ. The errors at the cam angle θ, and their derivatives by θ,
are

    δ = m − d₀,    δ' = (m' − τ'·y'(θ) − d₁)/(1 + τ')
    δ'' = (m'' − τ''·(y'(θ) + δ') − τ'·(2 + τ')·y''(θ) − d₂)/(1 + τ')²

This is one formula of all errors and of φ, for numbers and for ranges with slopes. It subtracts nothing large and
iterates nothing. As φ goes round the turn, so does θ: the largest error over φ is the largest over θ. The error of
a tool behind a train is f*(y(θ) + δ) − f(y(θ)), with f* of the train with errors. Both count from the start
position, in which the train is set (``tolerances.enclosures``).

With two contacts, the first touches with φ and the second with φ + a at the same cam angle, a = τ₁(φ) − τ₂(φ + a).
The follower stands in the middle: δ = (e₁ − e₂)/2 (``tolerances.response``).

The axis of a bore with the eccentricity (x, y) in the ground turns with the cam: its derivative by φ is (−y, x).

A profile error w with at most n waves in a turn, as the follower feels it, obeys Szegő's inequality, w'² + n²w² ≤
n²t². So w = x and w' = −ny at the point, with some vector (x, y) no longer than t. The inequality also holds for
w'/n. Where w'' counts, w' and w'' = −n²x are taken from this one, and w is anywhere within ±t (``PROFILE_LEVEL``);
for a cosine of n waves w is x as well. w is the error of the curve that the roller's centre (or the flat face)
follows. The error of the profile itself differs by half the radius times the square of the wave's slope: 0.03 µm of
2 µm in 50 waves on a cam of 40 mm.

Sources: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7), varied twice;
R. Boas, Entire Functions, ch. 11.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.error_response import second_contact_motion_error_sign
from camopt.model.mechanisms import Designs
from camopt.model.motion.tool_drive import tool_position
from camopt.scene.problem.problem import Problem
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    PROFILE_LEVEL,
    WAVE_PHASE,
    CamErrors,
    Errors,
    contact_errors_from_flat_errors,
    contact_problems,
    direction_key,
    errors_at_contact,
    with_turned_vector_error,
)

CONTACT_ROUNDS = 3
"""Number of iterations for the place that a cam touches at a cam angle."""
BORE_ROUNDS = 4
"""Number of iterations for the cam angle of a cylinder's contact, which decides its bore error."""
TERM_FACTORIALS = 1.0, 1.0, 2.0


class ContactShiftSeries(NamedTuple):
    """m and τ, each a series in φ."""

    follower_shift: Taylor
    cam_turn: Taylor


class ContactError(NamedTuple):
    """Cam angles at which cams touch with points of their profiles, and the errors of their motion there."""

    angle: FloatArray
    """Cam angle θ [rad]."""
    error: FloatArray
    """Error of the tool's position, or of a derivative, mm (rad) by powers of rad."""


class FollowerContact(NamedTuple):
    """Contact of cams with points of their profiles, at the follower."""

    cam_turn: FloatArray
    """τ [rad]."""
    errors: list[FloatArray]
    """δ of the follower and its derivatives by the cam angle θ."""


@dataclass(frozen=True)
class RealCam:
    """Cams of one design, each cut and assembled with its own errors."""

    problem: Problem
    waves: int = 0
    """Number of waves of the profile's error in a turn; 0 for a constant error."""

    @cached_property
    def contacts(self) -> tuple[Problem, ...]:
        """One problem for each contact of the follower, as an ordinary cam without a train."""
        return contact_problems(self.problem)

    @property
    def second_motion_sign(self) -> float:
        """Sign of the second contact's own motion in e₂ (``effects.error_response.second_motion_sign``)."""
        return second_contact_motion_error_sign(self.problem.setup.mechanism)

    @property
    def is_developed(self) -> bool:
        """Whether the cam is a developed cylinder."""
        return self.problem.setup.mechanism.body.developed

    def contact_shift(
        self,
        contact_number: int,
        errors: Errors,
        motion: Sequence[Any],
        order: int,
        angle_ahead: Number = 0.0,
        *,
        errors_in_cam_frame: bool = False,
    ) -> ContactShiftSeries:
        """m and τ of one contact (0 or 1) at the point that the nominal follower touches, from flat errors.

        ``motion`` is y, y', y'' and y''' of the contact there. ``angle_ahead`` is the lead of its point over that
        of the first contact [rad]. All values are numbers, arrays, or ranges with slopes.
        """
        problem, design = self.contacts[contact_number], self.contacts[contact_number].design
        mechanism, sense = problem.setup.mechanism, design.sense
        errors = errors_at_contact(self.problem, contact_number, errors)
        if not self.is_developed:  # the axis of the bore turns with the cam
            errors = with_turned_vector_error(errors, BORE, angle_ahead * sense)
        if errors_in_cam_frame:
            errors = with_turned_vector_error(errors, "profile", angle_ahead * self.waves)
        y, slope = (_motion_series(motion[k:], order) for k in (0, 1))
        constant = {
            key: each
            for key, each in errors.items()
            if key not in (WAVE_PHASE, PROFILE_LEVEL, BORE, BORE_DIRECTION)
        }
        if WAVE_PHASE in errors:
            constant["profile"] = _profile_wave_series(errors, self.waves, order)
        at_contact = contact_errors_from_flat_errors(constant)
        if BORE in errors and not self.is_developed:
            at_contact = at_contact._replace(bore=_profile_eccentricity_in_ground_frame(errors, sense, order))
        rest = mechanism.shifted_contact(design, problem.programme.lift, y, slope, at_contact)
        shift, turn = (_carry_out_quotients(y * 0.0 + each) for each in rest)
        if BORE in errors and self.is_developed:
            turn = _cam_turn_with_bore_along_surface(turn, errors, design)
        return ContactShiftSeries(shift, turn - errors.get("phase", 0.0))

    def tool_error_at_contact(
        self,
        errors: Errors,
        places: FloatArray,
        order: int = 0,
        *,
        include_jumps: bool = True,
        errors_in_cam_frame: bool = False,
    ) -> ContactError:
        """Contact of cams with the points ``places`` of their profiles (rad), and the error of the tool there.

        ``places`` are the cam angles at which the nominal follower touches these points. Errors are flat, as they
        are when the point is touched. With ``errors_in_cam_frame`` they are those of the cam, so that the wave at a
        second contact is taken where that contact touches. A cam that touches before a jump of y'' instead of after
        it, or the other way round, has the jump as its error, unless ``include_jumps`` is False.
        """
        contact = self.cam_turn_and_follower_errors(
            errors, places, order, include_jumps=include_jumps, errors_in_cam_frame=errors_in_cam_frame
        )
        return self.tool_error_of_highest_order(errors, places + contact.cam_turn, contact.errors)

    def cam_turn_and_follower_errors(
        self,
        errors: Errors,
        places: FloatArray,
        order: int = 0,
        *,
        include_jumps: bool = True,
        errors_in_cam_frame: bool = False,
    ) -> FollowerContact:
        """As ``tool_error_at_contact``, with the errors of the follower in the middle of its contacts."""
        first = self._single_contact_at_places(0, errors, places, 0.0, order, include_jumps=include_jumps)
        if len(self.contacts) == 1:
            return first
        ahead = self.second_contact_lead(errors, places, first.cam_turn, errors_in_cam_frame=errors_in_cam_frame)
        second = self._single_contact_at_places(
            1,
            errors,
            places,
            ahead,
            order,
            include_jumps=include_jumps,
            errors_in_cam_frame=errors_in_cam_frame,
        )
        both = zip(first.errors, second.errors, strict=True)
        return FollowerContact(
            first.cam_turn, [(one - self.second_motion_sign * other) / 2.0 for one, other in both]
        )

    def second_contact_lead(
        self, errors: Errors, places: FloatArray, first_cam_turns: FloatArray, *, errors_in_cam_frame: bool = False
    ) -> FloatArray:
        """Lead a of the second contact's point over that of the first [rad]."""
        ahead = np.zeros_like(first_cam_turns)
        for _ in range(CONTACT_ROUNDS):
            ahead = first_cam_turns - self.cam_turn_angles_at_contact(
                errors, places, 1, ahead, errors_in_cam_frame=errors_in_cam_frame
            )
        return ahead

    def tool_error_of_highest_order(
        self, errors: Errors, angles: FloatArray, follower_error_derivatives: Sequence[FloatArray]
    ) -> ContactError:
        """Error of the tool of the last order, from the follower's errors of all orders at cam angles (rad)."""
        train, order = self.problem.setup.train, len(follower_error_derivatives) - 1
        if train is None:
            return ContactError(angles, follower_error_derivatives[-1])
        y = self.problem.programme.motion_at(self.angles_in_turn(angles), order)
        delta, nominal = (
            Taylor([e / part for e, part in zip(each, TERM_FACTORIALS, strict=False)])
            for each in (follower_error_derivatives, y)
        )
        nominal = nominal + follower_offset_in_train(self.problem)
        error = self.problem.train_with_errors(errors).tool_displacement(nominal + delta) - train.tool_displacement(
            nominal
        )
        return ContactError(angles, np.asarray(error.derivative(order) + np.zeros_like(angles)))

    def angles_in_turn(self, angles: FloatArray) -> FloatArray:
        """Cam angles reduced to one turn [rad]."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def motion_errors(self, errors: CamErrors, places: FloatArray, order: int) -> FloatArray:
        """Error of position, velocity or acceleration (order 0, 1, 2) of each cam, in mm or rad by powers of rad.

        ``places`` has one point (rad) for each cam, at whose contact the error is taken.
        """
        return self.tool_error_at_contact(
            self.flat_errors_in_ground_frame(errors, places), places, order, errors_in_cam_frame=True
        ).error

    def tool_positions(self, errors: CamErrors, places: FloatArray) -> FloatArray:
        """Position of the tool above its lowest, when cams touch with places, mm (rad)."""
        contact = self.tool_error_at_contact(
            self.flat_errors_in_ground_frame(errors, places), places, errors_in_cam_frame=True
        )
        return np.asarray(
            self.problem.programme.tool.motion_at(self.angles_in_turn(contact.angle), 0)[0] + contact.error
        )

    def contact_angles(self, errors: CamErrors, places: FloatArray) -> FloatArray:
        """Cam angles at which cams touch with places [rad]."""
        return np.asarray(
            places + self.cam_turn_angles_at_contact(self.flat_errors_in_ground_frame(errors, places), places)
        )

    def contact_places(self, errors: CamErrors, angles: FloatArray) -> FloatArray:
        """Places with which cams touch at cam angles [rad]."""
        places = angles
        for _ in range(CONTACT_ROUNDS):
            places = places - (self.contact_angles(errors, places) - angles)
        return places

    def flat_errors_in_ground_frame(self, errors: CamErrors, places: FloatArray) -> dict[str, Any]:
        """Errors of cams in flat form, as they are when the cams touch with places."""
        flat = {key: each for key, each in errors.items() if key != BORE and not np.iscomplexobj(each)}
        for key in errors.keys() - flat.keys() - {BORE}:
            crest = np.conj(errors[key]) * np.exp(1j * self.waves * places)
            flat |= {key: crest.real, direction_key(key): crest.imag}
        angles, sense = places, self.problem.design.sense
        rounds = BORE_ROUNDS if BORE in errors and self.is_developed else int(BORE in errors)
        for remaining in reversed(range(rounds)):
            bore = errors[BORE] * np.exp(1j * sense * angles)
            flat |= {BORE: bore.real, BORE_DIRECTION: bore.imag}
            angles = (
                places + self.cam_turn_angles_at_contact(flat, places) + errors.get("phase", 0.0)
                if remaining
                else angles
            )
        return flat

    def cam_turn_angles_at_contact(
        self,
        errors: Errors,
        places: FloatArray,
        contact_number: int = 0,
        angle_ahead: Number = 0.0,
        *,
        errors_in_cam_frame: bool = False,
    ) -> FloatArray:
        """τ of a contact that touches with the points ``places + ahead`` [rad]."""
        programme = self.contacts[contact_number].programme
        motion = [*programme.motion_at(self.angles_in_turn(places + angle_ahead), 1)]
        shift = self.contact_shift(
            contact_number, errors, motion, 0, angle_ahead, errors_in_cam_frame=errors_in_cam_frame
        )
        return np.asarray(shift.cam_turn.terms[0] + np.zeros_like(places))

    def _single_contact_at_places(
        self,
        contact_number: int,
        errors: Errors,
        places: FloatArray,
        angle_ahead: FloatArray | float,
        order: int,
        *,
        include_jumps: bool,
        errors_in_cam_frame: bool = False,
    ) -> FollowerContact:
        """One contact with the points that its nominal follower touches at ``places + angle_ahead`` (rad)."""
        programme, base = self.contacts[contact_number].programme, self.angles_in_turn(places + angle_ahead)
        motion = [*programme.motion_at(base, order + 1)]
        shift = self.contact_shift(
            contact_number, errors, motion, order, angle_ahead, errors_in_cam_frame=errors_in_cam_frame
        )
        cam_turn = shift.cam_turn.terms[0] + np.zeros_like(base)
        at_contact, passed = programme.motion_at(self.angles_in_turn(base + cam_turn), order), np.zeros_like(base)
        turn = programme.strokes[-1].end
        for jump in programme.jumps if order == 2 else ():
            ahead, behind = np.mod(jump.at - base, turn), np.mod(base - jump.at, turn)
            passed += jump.size * ((cam_turn > ahead) * 1.0 - (-cam_turn > behind))

        def derivative_change_at_contact(k: int) -> FloatArray:
            return np.asarray(at_contact[k] - motion[k] - (passed if k == 2 else 0.0))

        deltas = follower_errors(
            shift, motion, derivative_change_at_contact, passed if include_jumps else 0.0, order
        )
        return FollowerContact(cam_turn, [each + np.zeros_like(base) for each in deltas])


def follower_errors(
    shift: ContactShiftSeries,
    motion: Sequence[Any],
    derivative_change: Callable[[int], Any],
    acceleration_jump: Number,
    order: int,
) -> list[Any]:
    """δ and its derivatives by the cam angle θ, up to an order.

    ``derivative_change(k)`` is d_k without the jumps of y'' between φ and θ. ``acceleration_jump`` is their sum.
    """
    m, t = shift
    errors = [m.terms[0] - derivative_change(0)]
    if order == 0:
        return errors
    rate, velocity = t.terms[1] + 1.0, motion[1] + derivative_change(1)
    errors.append((m.terms[1] - t.terms[1] * velocity - derivative_change(1)) / rate)
    if order == 1:
        return errors
    d2 = derivative_change(2) + acceleration_jump
    bend = (velocity + errors[1]) * t.terms[2] * 2.0 + t.terms[1] * (t.terms[1] + 2.0) * (motion[2] + d2)
    return [*errors, (m.terms[2] * 2.0 - bend - d2) / np.square(rate)]


def follower_offset_in_train(problem: Problem) -> float:
    """Displacement of the follower from the start position of its train, where the turn's displacement is 0."""
    programme, first, train = problem.programme, np.zeros(1), problem.setup.train
    assert train is not None
    return float(
        (train.follower_displacement_at(tool_position(programme, first)) - programme.motion_at(first)[0])[0]
    )


def _motion_series(motion: Sequence[Any], order: int) -> Taylor:
    return Taylor([each * (1.0, 1.0, 0.5)[k] for k, each in enumerate(motion[: order + 1])])


def _profile_wave_series(errors: Errors, waves: int, order: int) -> Taylor:
    """Error of the profile as a series in φ."""
    x, y, n = errors["profile"], errors[WAVE_PHASE], float(waves)
    return Taylor([errors.get(PROFILE_LEVEL, x), y * -n, x * (-0.5 * n * n)][: order + 1])


def _profile_eccentricity_in_ground_frame(errors: Errors, sense: float, order: int) -> tuple[Taylor, Taylor]:
    """Eccentricity of a disc's profile in the ground, x and y as series in φ."""
    x, y = errors[BORE], errors.get(BORE_DIRECTION, 0.0)
    return Taylor([x, y * -sense, x * -0.5][: order + 1]), Taylor([y, x * sense, y * -0.5][: order + 1])


def _cam_turn_with_bore_along_surface(exact_cam_turn: Taylor, errors: Errors, design: Designs) -> Taylor:
    """τ of a cylinder whose axis has the error x along its surface, which changes with θ."""
    x, slope = errors[BORE] / design.size, errors.get(BORE_DIRECTION, 0.0) / design.size * -design.sense
    terms = [exact_cam_turn.terms[0] + x]
    if len(exact_cam_turn.terms) > 1:
        rate = (exact_cam_turn.terms[1] + 1.0) / (1.0 - slope)
        terms.append((exact_cam_turn.terms[1] + slope) / (1.0 - slope))
    if len(exact_cam_turn.terms) > 2:
        terms.append((exact_cam_turn.terms[2] - x * np.square(rate) * 0.5) / (1.0 - slope))
    return Taylor(terms)


def _carry_out_quotients(series: Taylor) -> Taylor:
    """The series with the quotients of its ranges carried out."""
    return Taylor([each.divide() if hasattr(each, "divide") else each for each in series.terms])

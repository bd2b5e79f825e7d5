"""The response of the motion to small errors of cam and follower, to first order.

A nominal follower touches a point of the cam at the cam angle φ. The real follower touches the same point when the
cam has turned on by τ, and has moved further by m (``mechanisms.contact_errors``). At that cam
angle its error is m − (y(φ + τ) − y(φ)), and to first order

    δ = m − y'·τ

with the derivatives of m and τ by the error. The formula runs on numbers of two terms, a value and its derivatives
by all errors. The terms of second order that are left out are below 0.05 µm for errors of 10 µm. The errors of
velocity and acceleration follow from the Taylor series of δ by the cam angle.

A follower with two equally stiff contacts has the error δ = (e₁ − e₂)/2, with the error of the motion at each
contact (``tolerances.response``).

A profile within ±t with at most n waves in a turn is a trigonometric polynomial δn of degree n. Bernstein's and
Szegő's inequality bounds its slope, δn'² + n²·δn² ≤ n²·t², and likewise that of δn' with n·t. With the response g
to the profile

    |gδn| ≤ |g|·t,    |(gδn)'| ≤ t·√(g'² + n²g²),    |(gδn)''| ≤ t·(|g''| + n·√(4g'² + n²g²))

A cosine of n waves attains the first two bounds. Without n no slope is bounded.

Sources: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7), varied;
S. Bernstein, Sur l'ordre de la meilleure approximation des fonctions continues, 1912; R. Boas, Entire
Functions, ch. 11 (Szegő's form).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor, cosine_and_sine_series
from camopt.model.effects.contacts import all_follower_contacts
from camopt.model.effects.effect import Setup
from camopt.model.mechanisms.contact_errors import ContactErrors
from camopt.model.mechanisms.design import FIELDS, Designs, Mechanism
from camopt.model.motion.programme import Programme
from camopt.model.motion.tool_drive import follower_series
from camopt.model.trains.train import Train

RESPONSE_ORDERS = 3
"""Number of terms of each series: displacement, velocity and acceleration."""
SECOND_CONTACT_SUFFIX = " (second)"
"""The end of an error's key at the second contact, if both contacts have an error of that key."""
SHARED_ERRORS = ("follower.centre_distance", "phase", "face_tilt", "bore_eccentricity")
"""Errors that are the same at both contacts."""
SHARED_SIZES = ("offset", "arm_length", "roller_spacing")
"""Sizes whose error is the same at both contacts, if the second contact has no sizes of its own."""
SignedKey = tuple[str, float]
"""The key of an error at a contact, and its sign there."""


class ErrorAtContacts(NamedTuple):
    """The key and sign of an error at each contact; None at a contact that does not have it."""

    first: SignedKey | None
    second: SignedKey | None


def errors_at_contacts_by_key(mechanism: Mechanism, tolerance_key: str) -> dict[str, ErrorAtContacts]:
    """The errors of one tolerance at both contacts of a follower, by key of the error."""
    table, _, name = tolerance_key.partition(".")
    if tolerance_key in SHARED_ERRORS:
        return {
            tolerance_key: ErrorAtContacts(
                (tolerance_key, 1.0), (tolerance_key, -1.0 if tolerance_key == "face_tilt" else 1.0)
            )
        }
    if tolerance_key == "disc_phase":
        return {tolerance_key: ErrorAtContacts(None, ("phase", 1.0))}
    if table == "drive":
        return {tolerance_key: ErrorAtContacts(None, (f"follower.{name}", 1.0))}
    alike = not mechanism.second_contact_size_keys
    if alike and name in SHARED_SIZES:
        return {tolerance_key: ErrorAtContacts((tolerance_key, 1.0), (tolerance_key, 1.0))}
    first = {tolerance_key: ErrorAtContacts((tolerance_key, 1.0), None)}
    if tolerance_key == "profile" or alike:
        return {
            **first,
            f"{tolerance_key}{SECOND_CONTACT_SUFFIX}": ErrorAtContacts(
                None, (tolerance_key, second_contact_profile_shift_sign(mechanism))
            ),
        }
    return first


def second_contact_motion_error_sign(mechanism: Mechanism) -> float:
    """Sign of the second contact's error e₂: 1 if that contact has the follower's motion reversed, else −1."""
    (further,) = mechanism.further_contacts
    return 1.0 if further.mechanism.reverses else -1.0


def second_contact_profile_shift_sign(mechanism: Mechanism) -> float:
    """Sign of the shift along the normal by an outward profile error, or a larger roller, at the second contact."""
    (further,) = mechanism.further_contacts
    return -further.mechanism.flanks[0].side


def largest_error_by_profile_zone(response: FloatArray, zone: float, most_waves: int | None) -> FloatArray:
    """Largest magnitude of the error by a profile within a zone, with at most ``waves`` in a turn, (orders, …)."""
    g, most, n = np.abs(response), [np.abs(response[0])], inf if most_waves is None else float(most_waves)
    if most_waves is None:
        most += [np.full_like(g[0], inf)] * (len(g) - 1)
    elif len(g) > 1:
        most += [np.hypot(g[1], n * g[0]), *(g2 + n * np.hypot(2.0 * g[1], n * g[0]) for g2 in g[2:])]
    return zone * np.array(most)


def series_derivatives(series: Series, shape: tuple[int, ...], order_count: int = RESPONSE_ORDERS) -> FloatArray:
    """Derivatives of a series by the cam angle, (orders, *shape)."""
    return np.array([np.broadcast_to(series.derivative(order), shape) for order in range(order_count)])


def tool_response_to_train_error(
    perturbed_train: Train, train: Train, programme: Programme, angles: FloatArray
) -> Series:
    """Motion of the tool for an error of a number p of its train, ∂f/∂p, as a series by the cam angle.

    ``perturbed_train`` is the train as a series in p.
    """
    position = follower_series(train, programme, angles)
    response: Series = perturbed_train.tool_displacement(Taylor([position, position * 0.0])).terms[1]
    return response


@dataclass(frozen=True)
class ContactResponse:
    """The responses of the follower at one contact, as series by the cam angle at some angles [rad].

    The unit is mm or rad per mm or rad of the error. ``designs`` is one design, or one for each row of angles; its
    arrays are then columns.
    """

    mechanism: Mechanism
    designs: Designs
    programme: Programme
    angles: FloatArray
    orders: int = RESPONSE_ORDERS
    """Number of terms of the series."""

    def response_to_error(self, key: str) -> Series:
        """Response to an error by key: of a size, of an angle, or of the profile along its normal."""
        if key == "phase":
            return self.displacement_and_velocity_series[1]
        return (
            self._unit_responses[key]
            if key in ("profile", "face_tilt")
            else self.response_to_size(FIELDS[key.rpartition(".")[2]])
        )

    def response_to_size(self, field: str) -> Series:
        """Response to a larger size of the follower, by field of ``Designs``."""
        return self._unit_responses["profile" if field == "roller_radius" else field]

    @property
    def profile_response(self) -> Series:
        """Response to a profile that is further out along its normal everywhere, as to a larger roller.

        A roller in a groove is held from both sides; there it is the middle of the groove that is further out.
        """
        return self._unit_responses["profile"]

    def cosine_and_sine_wave_responses(self, waves_per_turn: int) -> tuple[Series, Series]:
        """Responses to a profile error that is a cosine and one that is a sine, with ``waves_per_turn`` waves."""
        cosine, sine = cosine_and_sine_series(self._multiple_angle_series(float(waves_per_turn)))
        return self.profile_response * cosine, self.profile_response * sine

    @cached_property
    def bore_responses_in_two_directions(self) -> tuple[Series, Series]:
        """Responses to an eccentricity of the bore, in two directions that turn with the cam.

        On a cylinder only the part along the surface counts; across it the groove is only deeper.
        """
        x, y = self._unit_responses["x"], self._unit_responses["y"]
        cosine, sine = cosine_and_sine_series(self._multiple_angle_series(self.designs.sense))
        if self.mechanism.body.developed:
            x, y = -(self.displacement_and_velocity_series[1] / self.designs.size), y * 0.0
        return x * cosine + y * sine, y * cosine - x * sine

    @cached_property
    def displacement_and_velocity_series(self) -> tuple[Series, Series]:
        """Displacement and velocity of the follower."""
        y, y1, y2, y3 = self.programme.motion_at(self.angles)
        return Taylor([y, y1, y2 / 2][: self.orders]), Taylor([y1, y2, y3 / 2][: self.orders])

    @cached_property
    def _unit_responses(self) -> dict[str, Series]:
        """Responses to unit errors of each size, the profile, a face's tilt, and the bore's x and y in the ground.

        A profile error shifts the point of contact along the normal, as an error of the bore does.
        """
        sizes = [field for field in self.mechanism.sizes if field != "roller_radius"]
        names, zero = (
            [*sizes, "x", "y", *["face_tilt"] * self.mechanism.flat_faced],
            self.displacement_and_velocity_series[0] * 0.0,
        )
        shape = np.broadcast_shapes(self.angles.shape, np.shape(self.designs.size))
        units = np.eye(len(names)).reshape(len(names), len(names), *[1] * len(shape))
        unit_errors = {name: Taylor([zero, zero + unit]) for name, unit in zip(names, units, strict=True)}
        errors = ContactErrors(
            {field: unit_errors[field] for field in sizes},
            bore=(unit_errors["x"], unit_errors["y"]),
            tilt=unit_errors.get("face_tilt", 0.0),
        )
        y, y1 = (Taylor([series, zero]) for series in self.displacement_and_velocity_series)
        moved, turned = self.mechanism.shifted_contact(self.designs, self.programme.lift, y, y1, errors)
        response = moved.terms[1] - self.displacement_and_velocity_series[1] * turned.terms[1]
        terms = [np.broadcast_to(term, (len(names), *shape)) for term in response.terms]
        responses = {name: Taylor([term[k] for term in terms]) for k, name in enumerate(names)}
        point = self.mechanism.contact(
            self.designs,
            self.programme.lift,
            self._multiple_angle_series(1.0),
            *self.displacement_and_velocity_series,
        )
        length = (point.across * point.across + point.up * point.up).root()
        along_normal = (responses["x"] * point.across + responses["y"] * point.up) / length
        return responses | {"profile": along_normal}

    def _multiple_angle_series(self, factor: float) -> Taylor:
        """``factor`` times the cam angle, as a series."""
        terms = factor * self.angles, np.full_like(self.angles, factor), np.zeros_like(self.angles)
        return Taylor(terms[: self.orders])


def contact_responses(
    setup: Setup, designs: Designs, programme: Programme, angles: FloatArray, order_count: int = RESPONSE_ORDERS
) -> list[ContactResponse]:
    """The responses at all contacts of a follower, each for the motion at that contact."""
    first, *others = all_follower_contacts(setup)
    responses = [ContactResponse(first.mechanism, designs, programme, angles, order_count)]
    for contact in others:
        motion = contact.mechanism.contact_programme(replace(programme, tool_programme=None))
        local = contact.local_designs(designs)
        responses.append(ContactResponse(contact.mechanism, local, motion, angles, order_count))
    return responses

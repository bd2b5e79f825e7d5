"""How the motion answers to a small error of cam or follower, to first order: one formula for all errors.

A real follower touches the point that a nominal one touches at the cam angle φ when the cam has turned on by τ, and
stands further out by m then (``mechanisms.contact_errors``). So it is off by m − (y(φ + τ) − y(φ)) at that cam
angle, and to first order by

    δ = m − y'·τ

with the derivatives of both by the error: the formula is run on numbers of two terms, the value and its derivatives
by all errors.
What is left out is of second order: below 0.05 µm for errors of 10 µm. Velocity and acceleration are those of the
series of δ by the cam angle, which come of the motion's own. Of two contacts that are equally stiff, each with the
error of its own motion, the follower is off by δ = (e₁ − e₂)/2 (``tolerances.contact_notes``).

A profile within ±t with at most n waves in a turn is a trigonometric polynomial δn of degree n. Its slopes are
bounded by Bernstein's and Szegő's inequality, δn'² + n²·δn² ≤ n²·t², and the same of δn' with n·t: with the answer
g to the profile

    |gδn| ≤ |g|·t,    |(gδn)'| ≤ t·√(g'² + n²g²),    |(gδn)''| ≤ t·(|g''| + n·√(4g'² + n²g²))

The first two are attained by a cosine of n waves. Without n no slope is bounded.

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
from camopt.core.numerics.taylor import Series, Taylor, direction
from camopt.model.effects.contacts import follower_contacts
from camopt.model.effects.effect import Setup
from camopt.model.mechanisms.contact_errors import ContactErrors
from camopt.model.mechanisms.design import FIELDS, Designs, Mechanism
from camopt.model.motion.programme import Programme
from camopt.model.motion.tool_drive import follower_series
from camopt.model.trains.train import Train

RESPONSE_ORDERS = 3
"""Displacement, velocity and acceleration: the terms of each series."""
SECOND_CONTACT_SUFFIX = " (second)"
"""What the key of an error has after it that is of the second contact, where one key is of both."""
SHARED_ERRORS = ("follower.centre_distance", "phase", "face_tilt", "bore_eccentricity")
"""Errors that are the same at both contacts."""
SHARED_SIZES = ("offset", "arm_length", "roller_spacing")
"""And sizes of a follower whose second contact has none of its own."""
SignedKey = tuple[str, float]
"""The key of an error at a contact, and its sign there."""


class ErrorAtContacts(NamedTuple):
    """What an error is at both contacts; None where it is of the other one."""

    first: SignedKey | None
    second: SignedKey | None


def errors_by_contact(mechanism: Mechanism, key: str) -> dict[str, ErrorAtContacts]:
    """What a tolerance is of, at both contacts of a follower, by the key of the error."""
    table, _, name = key.partition(".")
    if key in SHARED_ERRORS:
        return {key: ErrorAtContacts((key, 1.0), (key, -1.0 if key == "face_tilt" else 1.0))}
    if key == "disc_phase":
        return {key: ErrorAtContacts(None, ("phase", 1.0))}
    if table == "drive":
        return {key: ErrorAtContacts(None, (f"follower.{name}", 1.0))}
    alike = not mechanism.second_keys
    if alike and name in SHARED_SIZES:
        return {key: ErrorAtContacts((key, 1.0), (key, 1.0))}
    first = {key: ErrorAtContacts((key, 1.0), None)}
    if key == "profile" or alike:
        return {
            **first,
            f"{key}{SECOND_CONTACT_SUFFIX}": ErrorAtContacts(None, (key, second_profile_sign(mechanism))),
        }
    return first


def second_motion_sign(mechanism: Mechanism) -> float:
    """What its own motion at the second contact is to e₂: 1 where it is that of the follower reversed, else −1."""
    (further,) = mechanism.further_contacts
    return 1.0 if further.mechanism.reverses else -1.0


def second_profile_sign(mechanism: Mechanism) -> float:
    """How far along the normal a profile of the second contact that stands out, or its larger roller, moves it."""
    (further,) = mechanism.further_contacts
    return -further.mechanism.flanks[0].side


def largest_profile_response(answer: FloatArray, zone: float, waves: int | None) -> FloatArray:
    """The largest magnitude of what a profile within a zone makes, with so many waves in a turn, (orders, …)."""
    g, most, n = np.abs(answer), [np.abs(answer[0])], inf if waves is None else float(waves)
    if waves is None:
        most += [np.full_like(g[0], inf)] * (len(g) - 1)
    elif len(g) > 1:
        most += [np.hypot(g[1], n * g[0]), *(each + n * np.hypot(2.0 * g[1], n * g[0]) for each in g[2:])]
    return zone * np.array(most)


def series_derivatives(found: Series, shape: tuple[int, ...], orders: int = RESPONSE_ORDERS) -> FloatArray:
    """Those of a series by the cam angle, (orders, *shape): to that of the acceleration unless told."""
    return np.array([np.broadcast_to(found.derivative(order), shape) for order in range(orders)])


def link_response(made: Train, train: Train, programme: Programme, angles: FloatArray) -> Series:
    """∂f/∂p, how far the tool moves for a number p of its train that is larger, as a series by the cam angle.

    ``made`` is the series of trains by p.
    """
    stands = follower_series(train, programme, angles)
    moved: Series = made.tool(Taylor([stands, stands * 0.0])).terms[1]
    return moved


@dataclass(frozen=True)
class ContactResponse:
    """The answers of the follower of one contact, as series by the cam angle at some angles, rad.

    In mm or rad by mm or rad of the error. ``designs`` are one, or as many as there are rows of angles: of these
    each array is a column.
    """

    mechanism: Mechanism
    designs: Designs
    programme: Programme
    angles: FloatArray
    orders: int = RESPONSE_ORDERS
    """How many terms series have."""

    def number_response(self, key: str) -> Series:
        """To a size of the follower or an angle that is larger than it should be, or a profile that stands out."""
        if key == "phase":
            return self.motion[1]
        return (
            self._unit_responses[key]
            if key in ("profile", "face_tilt")
            else self.size_response(FIELDS[key.rpartition(".")[2]])
        )

    def size_response(self, field: str) -> Series:
        """To a size of the follower, by field of ``Designs``, that is larger than it should be."""
        return self._unit_responses["profile" if field == "roller_radius" else field]

    @property
    def profile_response(self) -> Series:
        """To a profile that stands out along its normal everywhere, as to a roller that is larger by as much.

        A roller in a groove is held from both sides: there it is the middle of the groove that is off.
        """
        return self._unit_responses["profile"]

    def wave_responses(self, count: int) -> tuple[Series, Series]:
        """To a profile that stands out as a cosine, and as a sine, of so many waves in a turn."""
        cosine, sine = direction(self._angle_series(float(count)))
        return self.profile_response * cosine, self.profile_response * sine

    @cached_property
    def bore_responses(self) -> tuple[Series, Series]:
        """To a profile whose axis is off that of the bore, in each of two directions that turn with the cam.

        On a cylinder the part along the surface counts; what is across makes the groove deeper, and moves nothing.
        """
        x, y = self._unit_responses["x"], self._unit_responses["y"]
        cosine, sine = direction(self._angle_series(self.designs.sense))
        if self.mechanism.body.developed:
            x, y = -(self.motion[1] / self.designs.size), y * 0.0
        return x * cosine + y * sine, y * cosine - x * sine

    @cached_property
    def motion(self) -> tuple[Series, Series]:
        """Displacement and velocity of the follower."""
        y, y1, y2, y3 = self.programme.motion_at(self.angles)
        return Taylor([y, y1, y2 / 2][: self.orders]), Taylor([y1, y2, y3 / 2][: self.orders])

    @cached_property
    def _unit_responses(self) -> dict[str, Series]:
        """To each size by field, the profile, the tilt of a face, and the bore's axis in the ground; all at once.

        A profile that stands out moves the point that is touched as a bore does, along the normal.
        """
        sizes = [field for field in self.mechanism.sizes if field != "roller_radius"]
        names, zero = [*sizes, "x", "y", *["face_tilt"] * self.mechanism.flat_faced], self.motion[0] * 0.0
        shape = np.broadcast_shapes(self.angles.shape, np.shape(self.designs.size))
        units = np.eye(len(names)).reshape(len(names), len(names), *[1] * len(shape))
        of = {name: Taylor([zero, zero + unit]) for name, unit in zip(names, units, strict=True)}
        off = ContactErrors(
            {field: of[field] for field in sizes}, bore=(of["x"], of["y"]), tilt=of.get("face_tilt", 0.0)
        )
        y, y1 = (Taylor([each, zero]) for each in self.motion)
        moved, turned = self.mechanism.shifted_contact(self.designs, self.programme.lift, y, y1, off)
        found = moved.terms[1] - self.motion[1] * turned.terms[1]
        every = [np.broadcast_to(term, (len(names), *shape)) for term in found.terms]
        to = {name: Taylor([term[k] for term in every]) for k, name in enumerate(names)}
        at = self.mechanism.contact(self.designs, self.programme.lift, self._angle_series(1.0), *self.motion)
        length = (at.across * at.across + at.up * at.up).root()
        return to | {"profile": (to["x"] * at.across + to["y"] * at.up) / length}

    def _angle_series(self, count: float) -> Taylor:
        """So many turns in one of the cam."""
        terms = count * self.angles, np.full_like(self.angles, count), np.zeros_like(self.angles)
        return Taylor(terms[: self.orders])


def contact_responses(
    setup: Setup, designs: Designs, programme: Programme, angles: FloatArray, orders: int = RESPONSE_ORDERS
) -> list[ContactResponse]:
    """Those of all contacts of a follower, each of its own motion."""
    first, *others = follower_contacts(setup)
    found = [ContactResponse(first.mechanism, designs, programme, angles, orders)]
    for each in others:
        own = each.mechanism.contact_programme(replace(programme, tool_programme=None))
        found.append(ContactResponse(each.mechanism, each.local_designs(designs), own, angles, orders))
    return found

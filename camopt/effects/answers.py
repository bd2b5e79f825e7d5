"""How the motion answers to a small error of cam or follower, to first order: one formula for all errors.

With the outward normal N of the pitch curve (of a flat face: of the face) where the follower touches, an error that
moves the trace point by δq while the displacement stays, and a profile that stands out by δn along the normal, the
follower moves by

    δ = (|N|·δn − N·δq) / (N·u),    u = ∂q/∂y

What is left out is of second order: below 0.05 µm for errors of 10 µm. Velocity and acceleration are those of the
series of δ by the cam angle, which come of the motion's own. Of two contacts that are equally stiff, each with the
error of its own motion, the follower is off by δ = (e₁ − e₂)/2 (``tolerances.two_contacts``).

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

from camopt.effects.case import Setup
from camopt.effects.contacts import contacts_of
from camopt.mechanisms.design import FIELDS, Designs, Mechanism
from camopt.mechanisms.rest import ContactPoint, Shift
from camopt.motion.driven import train_follower
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Series, Taylor
from camopt.trains.train import Train

ORDERS = 3
"""Displacement, velocity and acceleration: the terms of each series."""
SECOND = " (second)"
"""What the key of an error has after it that is of the second contact, where one key is of both."""
AT_BOTH = ("follower.centre_distance", "phase", "face_tilt", "bore_eccentricity")
"""Errors that are the same at both contacts."""
OF_BOTH = ("offset", "arm_length", "roller_spacing")
"""And sizes of a follower whose second contact has none of its own."""
Own = tuple[str, float]
"""The key of an error at a contact, and its sign there."""


class At(NamedTuple):
    """What an error is at both contacts; None where it is of the other one."""

    first: Own | None
    second: Own | None


def errors_at(mechanism: Mechanism, key: str) -> dict[str, At]:
    """What a tolerance is of, at both contacts of a follower, by the key of the error."""
    table, _, name = key.partition(".")
    if key in AT_BOTH:
        return {key: At((key, 1.0), (key, -1.0 if key == "face_tilt" else 1.0))}
    if key == "disc_phase":
        return {key: At(None, ("phase", 1.0))}
    if table == "drive":
        return {key: At(None, (f"follower.{name}", 1.0))}
    alike = not mechanism.second_keys
    if alike and name in OF_BOTH:
        return {key: At((key, 1.0), (key, 1.0))}
    first = {key: At((key, 1.0), None)}
    if key == "profile" or alike:
        return {**first, f"{key}{SECOND}": At(None, (key, outward_of(mechanism)))}
    return first


def back_of(mechanism: Mechanism) -> float:
    """What its own motion at the second contact is to e₂: 1 where it is that of the follower reversed, else −1."""
    (further,) = mechanism.further
    return 1.0 if further.mechanism.reverses else -1.0


def outward_of(mechanism: Mechanism) -> float:
    """How far along the normal a profile of the second contact that stands out, or its larger roller, moves it."""
    (further,) = mechanism.further
    return -further.mechanism.flanks[0].side


def most_of_profile(answer: FloatArray, zone: float, waves: int | None) -> FloatArray:
    """The largest magnitude of what a profile within a zone makes, with so many waves in a turn, (3, …)."""
    g, g1, g2 = np.abs(answer)
    if waves is None:
        return zone * np.array([g, np.full_like(g, inf), np.full_like(g, inf)])
    n = float(waves)
    return zone * np.array([g, np.hypot(g1, n * g), g2 + n * np.hypot(2.0 * g1, n * g)])


def derivatives_of(found: Series, shape: tuple[int, ...]) -> FloatArray:
    """Those of a series by the cam angle, to the order of the acceleration, (3, *shape)."""
    return np.array([np.broadcast_to(found.derivative(order), shape) for order in range(ORDERS)])


def moved_by_link(made: Train, train: Train, programme: Programme, angles: FloatArray) -> Series:
    """∂f/∂p, how far the tool moves for a number p of its train that is larger, as a series by the cam angle.

    ``made`` is the series of trains by p.
    """
    stands = train_follower(train, programme, angles)
    moved: Series = made.tool(Taylor([stands, stands * 0.0])).terms[1]
    return moved


@dataclass(frozen=True)
class Answers:
    """The answers of the follower of one contact, as series by the cam angle at some angles, rad.

    In mm or rad by mm or rad of the error. ``designs`` are one, or as many as there are rows of angles: of these
    each array is a column.
    """

    mechanism: Mechanism
    designs: Designs
    programme: Programme
    angles: FloatArray

    def to_number(self, key: str) -> Series:
        """To a size of the follower or an angle that is larger than it should be, or a profile that stands out."""
        if key == "profile":
            return self.to_profile
        if key == "phase":
            return self.motion[1]
        return self.to_tilt if key == "face_tilt" else self.to_size(FIELDS[key.rpartition(".")[2]])

    def to_size(self, field: str) -> Series:
        """To a size of the follower, by field of ``Designs``, that is larger than it should be."""
        return self.to_profile if field == "roller_radius" else self._to_shift(self._shifts[field])

    @cached_property
    def to_profile(self) -> Series:
        """To a profile that stands out along its normal everywhere, as to a roller that is larger by as much.

        A roller in a groove is held from both sides: there it is the middle of the groove that is off.
        """
        return self._answer(self._length)

    def to_waves(self, count: int) -> tuple[Series, Series]:
        """To a profile that stands out as a cosine, and as a sine, of so many waves in a turn."""
        turned = self._straight(count * self.angles, float(count))
        cosine, sine = (self._answer(self._length * each) for each in (np.cos(turned), np.sin(turned)))
        return cosine, sine

    @cached_property
    def to_bore(self) -> tuple[Series, Series]:
        """To a profile whose axis is off that of the bore, in each of two directions that turn with the cam.

        On a cylinder the part along the surface counts; what is across makes the groove deeper, and moves nothing.
        """
        sense = self.designs.sense
        turned = self._straight(sense * self.angles, sense)
        cosine, sine, still = np.cos(turned), np.sin(turned), turned * 0.0
        developed = self.mechanism.body.developed
        ways = ((cosine, still), (-sine, still)) if developed else ((cosine, sine), (-sine, cosine))
        first, second = (-self._to_shift(each) for each in ways)
        return first, second

    @cached_property
    def to_tilt(self) -> Series:
        """To a translating flat face that is tilted about where the axis of its stem meets it."""
        return self._to_shift((0.0, self._contact.x - self.designs.offset))

    @cached_property
    def motion(self) -> tuple[Series, Series]:
        """Displacement and velocity of the follower."""
        y, y1, y2, y3 = self.programme.at(self.angles)
        return Taylor([y, y1, y2 / 2]), Taylor([y1, y2, y3 / 2])

    def _to_shift(self, shift: Shift) -> Series:
        """To a shift of the trace point while the displacement stays."""
        return self._answer(-self._along(shift))

    def _answer(self, off: Series) -> Series:
        """To a normal of N that is off by a series, in units of |N|."""
        return off / self._along(self._shifts["displacement"])

    def _along(self, shift: Shift) -> Series:
        """N·shift."""
        return self._contact.across * shift[0] + self._contact.up * shift[1]

    @cached_property
    def _contact(self) -> ContactPoint:
        angle = self._straight(self.angles, 1.0)
        return self.mechanism.contact(self.designs, self.programme.lift, angle, *self.motion)

    @cached_property
    def _length(self) -> Series:
        """|N|."""
        normal = self._contact
        return (normal.across * normal.across + normal.up * normal.up).root()

    @cached_property
    def _shifts(self) -> dict[str, Shift]:
        return self.mechanism.shifts(self.designs, self.programme.lift, *self.motion)

    def _straight(self, value: FloatArray, slope: float) -> Series:
        """A series that is straight."""
        return Taylor([value, np.full_like(value, slope), np.zeros_like(value)])


def answers_of(setup: Setup, designs: Designs, programme: Programme, angles: FloatArray) -> list[Answers]:
    """Those of all contacts of a follower, each of its own motion."""
    first, *others = contacts_of(setup)
    found = [Answers(first.mechanism, designs, programme, angles)]
    for each in others:
        own = each.mechanism.prescribed(replace(programme, asked=None))
        found.append(Answers(each.mechanism, each.seen(designs), own, angles))
    return found

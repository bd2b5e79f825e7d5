"""Real cams a second way: the motion as a curve (θ(φ), y(φ)), for comparison with ``tolerances.real_cam``.

The point that a nominal follower touches at the cam angle φ is touched with the displacement y(φ) when the cam has
turned to the angle θ(φ), both in closed form by each mechanism (``mechanisms.contact_errors_from_flat_errors``). So

    dy/dθ = y'/θ',    d²y/dθ² = (y'' − y'θ''/θ')/θ'²

by the Taylor series of both in φ. The error is that of the tool from where it is asked to be at θ. Of two contacts
each one has an iteration of its own for the place that it touches at a cam angle.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Taylor, cosine_and_sine_series
from camopt.model.effects.error_response import second_contact_motion_error_sign
from camopt.model.mechanisms.contact_errors import Shift
from camopt.model.motion.tool_drive import tool_position
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    CamErrors,
    contact_errors_from_flat_errors,
    contact_problems,
    errors_at_contact,
    flat_from_polar_errors,
)
from camopt.solve.tolerances.real_cam import RealCam

PAIR_TOUCHES = 3
FACTORIALS = 1.0, 1.0, 2.0
TOUCHES = 2
"""How often the place is found anew that is touched at a cam angle."""
TURNS = 4
"""How often the cam angle at which a cylinder touches is found anew, by which its bore is off along the surface."""


class RealMotion(NamedTuple):
    """The motion of tools by the contact's place φ on their cams."""

    angle: Taylor
    """Of the cam, rad."""
    tool: Taylor
    """Its position from the start of the train, or without one the displacement of the follower; mm or rad."""

    def by_angle(self, order: int) -> FloatArray:
        """Position, velocity or acceleration of the tool, by the cam angle."""
        if order == 0:
            return np.asarray(self.tool.terms[0])
        turned, y = self.angle.terms, self.tool.terms
        speed = y[1] / turned[1]
        return np.asarray(speed if order == 1 else 2.0 * (y[2] - speed * turned[2]) / turned[1] ** 2)


@dataclass(frozen=True)
class RealCams:
    """Cams cut by one design, each with errors of its own and a follower that is put together with others."""

    problem: Problem
    waves: int = 0
    """Of the error of the profile, in a turn; 0 if it is the same all over."""

    def motion_errors(self, off: CamErrors, places: FloatArray, order: int) -> FloatArray:
        """The errors of position, velocity or acceleration (order 0, 1, 2) of cams (n,), where each is touched at
        the cam angle of ``places`` (n,), rad; in mm or rad by powers of rad."""
        return self.beyond(self.motion(off, places, order), order)

    def beyond(self, moved: RealMotion, order: int) -> FloatArray:
        """By how much a derivative of real motions is off that of the motion that is asked, at its cam angles."""
        return moved.by_angle(order) - self._asked(self.angles_in_turn(moved.angle.terms[0]), order)

    def _asked(self, angles: FloatArray, order: int) -> FloatArray:
        """Where the tool is asked to be, from where the train starts, or a derivative of it."""
        asked = self.problem.programme.tool.motion_at(angles, order)[order]
        return np.asarray(asked + (self._tool_zero if order == 0 else 0.0))

    def angles_in_turn(self, angles: FloatArray) -> FloatArray:
        """Cam angles within the turn, rad."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def contact_places(self, off: CamErrors, angles: FloatArray) -> FloatArray:
        """The places where cams are touched at cam angles."""
        places = angles
        for _ in range(TOUCHES):
            places = places - (self.contact_angles(off, places) - angles)
        return places

    def contact_angles(self, off: CamErrors, places: FloatArray) -> FloatArray:
        """The cam angles at which cams are touched at places, rad."""
        return np.asarray(self._rest(off, places, 0).angle.terms[0] - off.get("phase", 0.0))

    def motion(self, off: CamErrors, places: FloatArray, order: int) -> RealMotion:
        """The motion at these places, with derivatives up to an order."""
        angle, follower = self._rest(off, places, order)
        angle, train = angle - off.get("phase", 0.0), self.problem.setup.train
        if train is None:
            return RealMotion(angle, follower)
        return RealMotion(
            angle, self.problem.train_with_errors(off).tool_displacement(follower + self._follower_zero)
        )

    def _rest(self, off: CamErrors, places: FloatArray, order: int) -> RealMotion:
        """The cam angle, but for the phase, and the displacement of the follower."""
        problem = self.problem
        y = problem.programme.motion_at(self.angles_in_turn(places), order + 1)
        motion = _series(y[:-1]), _series(y[1:])
        mechanism, place = problem.setup.mechanism, _line(places, order)
        given, angle = (
            contact_errors_from_flat_errors({**off, "profile": self._standing(off, places, order)}),
            place,
        )
        for _ in range(TURNS if mechanism.body.developed and BORE in off else 1):
            given = given._replace(bore=self._axis(off, angle))
            rest = mechanism.shifted_contact(problem.design, problem.programme.lift, *motion, given)
            angle = place + rest.turned
        return RealMotion(angle, motion[0] + rest.moved)

    def _axis(self, off: CamErrors, angle: Taylor) -> Shift:
        """How far the axis of the profile is off at a cam angle; of a cylinder along its surface."""
        if BORE not in off:
            return 0.0, 0.0
        bore, way = off[BORE], cosine_and_sine_series(angle * self.problem.design.sense)
        x = way.cosine * bore.real - way.sine * bore.imag
        if self.problem.setup.mechanism.body.developed:
            return x, 0.0
        return x, way.sine * bore.real + way.cosine * bore.imag

    def _standing(self, off: CamErrors, places: FloatArray, order: int) -> Taylor:
        """By how much the curve that the follower's centre follows stands out along its normal."""
        phasor = np.conj(off.get("profile", 0.0)) * np.exp(1j * self.waves * places)
        return Taylor([((1j * self.waves) ** k * phasor).real / (1.0, 1.0, 2.0)[k] for k in range(order + 1)])

    @cached_property
    def _tool_zero(self) -> float:
        """Where the tool is asked to be at 0, from where the train starts."""
        programme = self.problem.programme
        if self.problem.setup.train is None:
            return 0.0
        return float((tool_position(programme, np.zeros(1)) - programme.tool.motion_at(np.zeros(1))[0])[0])

    @cached_property
    def _follower_zero(self) -> float:
        """Where the follower is at displacement 0, from where the train starts."""
        programme, train = self.problem.programme, self.problem.setup.train
        assert train is not None
        start = np.zeros(1)
        return float(
            (train.follower_displacement_at(tool_position(programme, start)) - programme.motion_at(start)[0])[0]
        )


def _series(derivatives: FloatArray) -> Taylor:
    """That of a value and its derivatives, one row each."""
    return Taylor([each / (1.0, 1.0, 2.0)[k] for k, each in enumerate(derivatives)])


def _line(values: FloatArray, order: int) -> Taylor:
    """A series that grows by 1."""
    return Taylor([values, np.ones_like(values), np.zeros_like(values)][: order + 1])


@dataclass(frozen=True)
class PairCams:
    """The exact errors of cams that are off, at cam angles."""

    problem: Problem

    @cached_property
    def contacts(self) -> tuple[Problem, Problem]:
        return contact_problems(self.problem)

    def at(self, errors: Mapping[str, Any], angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """δ of the follower, and s, mm (rad), of cams whose errors are numbers or arrays (m,)."""
        first, own = (self._of(place, errors, angles) for place in (0, 1))
        second = second_contact_motion_error_sign(self.problem.setup.mechanism) * own
        return (first - second) / 2.0, first + second

    def _of(self, place: int, errors: Mapping[str, Any], angles: FloatArray) -> FloatArray:
        """The errors of the motion of a contact, of which the place is found that touches at each cam angle."""
        own, problem, places = errors_at_contact(self.problem, place, errors), self.contacts[place], angles
        way, developed = own.pop(BORE_DIRECTION, None), problem.setup.mechanism.body.developed
        for _ in range(PAIR_TOUCHES):
            given = dict(own)
            if way is not None and developed:  # along the surface of the cylinder, where it is touched
                there = angles + own.get("phase", 0.0)
                given[BORE] = own[BORE] * np.cos(way + problem.design.sense * there)
            elif way is not None:  # in the ground
                given[BORE_DIRECTION] = way + problem.design.sense * places
            found = RealCam(problem).tool_error_at_contact(flat_from_polar_errors(given), places)
            places = places - (found.angle - angles)
        return found.error


@dataclass(frozen=True)
class RealPairs(RealCams):
    """Cams with two contacts of the follower; places are those of the first one."""

    @cached_property
    def contacts(self) -> tuple[RealCams, RealCams]:
        first, second = (RealCams(each, self.waves) for each in contact_problems(self.problem))
        return first, second

    def motion_errors(self, off: CamErrors, places: FloatArray, order: int) -> FloatArray:
        return self._errors(self.contacts[0].motion(self._own(0, off), places, order), off, order)

    def _errors(self, first: RealMotion, off: CamErrors, order: int) -> FloatArray:
        """The same from the motion of the first contact."""
        train = self.problem.setup.train
        if train is None:
            return next(self._moved(first, off, [order]))
        orders, angles = range(order + 1), self.angles_in_turn(first.angle.terms[0])
        asked = zip(
            self.problem.programme.motion_at(angles), self._moved(first, off, orders), FACTORIALS, strict=False
        )
        follower = Taylor([(stands + moved) / factor for stands, moved, factor in asked])
        tool = self.problem.train_with_errors(off).tool_displacement(follower + self._follower_zero).terms[order]
        return np.asarray(tool * FACTORIALS[order] - self._asked(angles, order))

    def contact_angles(self, off: CamErrors, places: FloatArray) -> FloatArray:
        return self.contacts[0].contact_angles(self._own(0, off), places)

    def motion(self, off: CamErrors, places: FloatArray, order: int) -> RealMotion:
        """The cam angle by the place, and to order 0 the tool."""
        found = self.contacts[0].motion(self._own(0, off), places, order)
        if order > 0:
            return found
        asked = self._asked(self.angles_in_turn(found.angle.terms[0]), 0)
        return RealMotion(found.angle, Taylor([asked + self._errors(found, off, 0)]))

    def _moved(self, first: RealMotion, off: CamErrors, orders: Iterable[int]) -> Iterator[FloatArray]:
        """The errors of the follower, in the middle of both contacts, and their derivatives by the cam angle."""
        (one, second), other = self.contacts, self._own(1, off)
        places = second.contact_places(other, first.angle.terms[0])
        for order in orders:
            moved = second_contact_motion_error_sign(self.problem.setup.mechanism) * second.motion_errors(
                other, places, order
            )
            yield (one.beyond(first, order) - moved) / 2.0

    def _own(self, place: int, off: CamErrors) -> CamErrors:
        """Errors as a contact has them."""
        return errors_at_contact(
            self.problem, place, {key: each for key, each in off.items() if not is_train_key(key)}
        )


def cams_of(problem: Problem, waves: int) -> RealCams:
    """Real cams of a problem, with one contact or two."""
    return (RealPairs if problem.setup.mechanism.further_contacts else RealCams)(problem, waves)

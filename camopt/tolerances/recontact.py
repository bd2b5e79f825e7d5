"""The exact motion of cams that are off: no linear model, but where each follower comes to rest on its own profile.

The point that a nominal follower touches at the cam angle φ is touched with the displacement y(φ) when the cam has
turned to the angle θ(φ), both in closed form by each mechanism (``mechanisms.rest``). So the motion is known as a
curve (θ(φ), y(φ)), and

    dy/dθ = y'/θ',    d²y/dθ² = (y'' − y'θ''/θ')/θ'²

are exact too, by the Taylor series of both in φ. The error is that of the tool from where it is asked to be at θ.

An error of the profile with waves is that of the curve that the roller's centre (a flat face) follows. The profile
itself is off by the same but for half of the radius times the square of the wave's slope: 0.03 µm of 2 µm in 50
waves on a cam of 40 mm.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.mechanisms.rest import Shift
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor, direction
from camopt.problem.problem import Problem
from camopt.scene.tolerances import ANGLES
from camopt.tolerances.errors import BORE, is_way, off_by, way_of

Off = Mapping[str, FloatArray]
"""By how much cams are off, each (n,), by key of ``[tolerances]``, in mm or rad; complex of a profile with
waves (a + ib stands out by a·cos nφ + b·sin nφ) and of the bore's axis (x + iy in the frame of the cam)."""
TOUCHES = 2
"""How often the place is found anew that is touched at a cam angle."""
TURNS = 4
"""How often the cam angle at which a cylinder touches is found anew, by which its bore is off along the surface."""


def off_of(errors: Mapping[str, float], count: int) -> Off:
    """The errors of one cam in mm and deg, as those of the worst cam are told, for a number of places on it."""
    found: dict[str, FloatArray] = {}
    for key, value in errors.items():
        if way_of(key) in errors and not is_way(key):
            found[key] = np.full(count, value * np.exp(1j * np.radians(errors[way_of(key)])))
        elif not is_way(key):
            found[key] = np.full(count, np.radians(value) if key in ANGLES else value)
    return found


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

    def errors(self, off: Off, places: FloatArray, order: int) -> FloatArray:
        """The errors of position, velocity or acceleration (order 0, 1, 2) of cams (n,), where each is touched at
        the cam angle of ``places`` (n,), rad; in mm or rad by powers of rad."""
        return self.beyond(self.motion(off, places, order), order)

    def beyond(self, moved: RealMotion, order: int) -> FloatArray:
        """By how much a derivative of real motions is off that of the motion that is asked, at its cam angles."""
        return moved.by_angle(order) - self._asked(self.within(moved.angle.terms[0]), order)

    def _asked(self, angles: FloatArray, order: int) -> FloatArray:
        """Where the tool is asked to be, from where the train starts, or a derivative of it."""
        asked = self.problem.programme.tool.at(angles, order)[order]
        return np.asarray(asked + (self._tool_zero if order == 0 else 0.0))

    def within(self, angles: FloatArray) -> FloatArray:
        """Cam angles within the turn, rad."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def touched(self, off: Off, angles: FloatArray) -> FloatArray:
        """The places where cams are touched at cam angles."""
        places = angles
        for _ in range(TOUCHES):
            places = places - (self.angle(off, places) - angles)
        return places

    def angle(self, off: Off, places: FloatArray) -> FloatArray:
        """The cam angles at which cams are touched at places, rad."""
        return np.asarray(self._rest(off, places, 0).angle.terms[0] - off.get("phase", 0.0))

    def motion(self, off: Off, places: FloatArray, order: int) -> RealMotion:
        """The motion at these places, with derivatives up to an order."""
        angle, follower = self._rest(off, places, order)
        angle, train = angle - off.get("phase", 0.0), self.problem.setup.train
        if train is None:
            return RealMotion(angle, follower)
        return RealMotion(angle, self.problem.train_off(off).tool(follower + self._follower_zero))

    def _rest(self, off: Off, places: FloatArray, order: int) -> RealMotion:
        """The cam angle, but for the phase, and the displacement of the follower."""
        problem = self.problem
        y = problem.programme.at(self.within(places), order + 1)
        motion = _series(y[:-1]), _series(y[1:])
        mechanism, place = problem.setup.mechanism, _line(places, order)
        given, angle = off_by({**off, "profile": self._standing(off, places, order)}), place
        for _ in range(TURNS if mechanism.body.developed and BORE in off else 1):
            given = given._replace(bore=self._axis(off, angle))
            rest = mechanism.rest(problem.design, problem.programme.lift, *motion, given)
            angle = place + rest.turned
        return RealMotion(angle, motion[0] + rest.moved)

    def _axis(self, off: Off, angle: Taylor) -> Shift:
        """How far the axis of the profile is off at a cam angle; of a cylinder along its surface."""
        if BORE not in off:
            return 0.0, 0.0
        bore, way = off[BORE], direction(angle * self.problem.design.sense)
        x = way.cosine * bore.real - way.sine * bore.imag
        if self.problem.setup.mechanism.body.developed:
            return x, 0.0
        return x, way.sine * bore.real + way.cosine * bore.imag

    def _standing(self, off: Off, places: FloatArray, order: int) -> Taylor:
        """By how much the curve that the follower's centre follows stands out along its normal."""
        phasor = np.conj(off.get("profile", 0.0)) * np.exp(1j * self.waves * places)
        return Taylor([((1j * self.waves) ** k * phasor).real / (1.0, 1.0, 2.0)[k] for k in range(order + 1)])

    @cached_property
    def _tool_zero(self) -> float:
        """Where the tool is asked to be at 0, from where the train starts."""
        programme = self.problem.programme
        if self.problem.setup.train is None:
            return 0.0
        return float((tool_position(programme, np.zeros(1)) - programme.tool.at(np.zeros(1))[0])[0])

    @cached_property
    def _follower_zero(self) -> float:
        """Where the follower is at displacement 0, from where the train starts."""
        programme, train = self.problem.programme, self.problem.setup.train
        assert train is not None
        start = np.zeros(1)
        return float((train.follower_at(tool_position(programme, start)) - programme.at(start)[0])[0])


def _series(derivatives: FloatArray) -> Taylor:
    """That of a value and its derivatives, one row each."""
    return Taylor([each / (1.0, 1.0, 2.0)[k] for k, each in enumerate(derivatives)])


def _line(values: FloatArray, order: int) -> Taylor:
    """A series that grows by 1."""
    return Taylor([values, np.ones_like(values), np.zeros_like(values)][: order + 1])

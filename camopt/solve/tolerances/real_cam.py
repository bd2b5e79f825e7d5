"""Real cams: where one that is off touches with a point, and how far its tool is off then.

A cam that is off touches with the point φ at θ = φ + τ, where its follower stands at y(φ) + m
(``mechanisms.contact_errors``). Both are series in φ, so that its velocity is (y' + m')/(1 + τ') there. With a
prime for the derivative by φ, and d_k = y⁽ᵏ⁾(θ) − y⁽ᵏ⁾(φ), by what the motion that is asked differs, the errors are

    δ = m − d₀,    δ' = (m' − τ'·y'(θ) − d₁)/(1 + τ')
    δ'' = (m'' − τ''·(y'(θ) + δ') − τ'·(2 + τ')·y''(θ) − d₂)/(1 + τ')²

by the cam angle θ: a formula of all errors and of φ, for numbers and for ranges with slopes, in which nothing large
is subtracted and nothing is iterated. As φ goes round the turn, θ does: the largest error over one is the largest
over the other. The tool of a train is off by f*(y(θ) + δ) − f(y(θ)), with the f* of its own links: both count from
the start position, in which a train is set (``tolerances.enclosures``).

Of two contacts the first touches φ, and the second one φ + a at the same cam angle, with a = τ₁(φ) − τ₂(φ + a); the
follower stands in the middle: δ = (e₁ − e₂)/2 (``tolerances.response``).

An axis of the bore that is off by (x, y) in the ground turns with the cam: it moves by (−y, x).

A profile with at most n waves in a turn, as the follower feels it, stands out by w = x there, with w' = −ny, of
some (x, y) no longer than t: that is Szegő's inequality, w'² + n²w² ≤ n²t². It holds of w'/n too: where w'' counts,
w' is that and w'' = −n²x, with w anywhere within ±t (``LEVEL``). Of a cosine of n waves it is x as well. It is the
error of the curve that the roller's centre (a flat face) follows. The profile itself is off by the same but for
half of the radius times the square of the wave's slope: 0.03 µm of 2 µm in 50 waves on a cam of 40 mm.

Sources: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7), varied twice;
R. Boas, Entire Functions, ch. 11.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.error_response import second_motion_sign
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
    contact_errors,
    contact_problems,
    direction_key,
    errors_at_contact,
    turn_error,
)

CONTACT_ROUNDS = 3
"""How often the place is found anew that is touched at a cam angle."""
BORE_ROUNDS = 4
"""How often the cam angle at which a cylinder touches is found anew, by which its bore is off along the surface."""
TERM_FACTORIALS = 1.0, 1.0, 2.0


class ContactShiftSeries(NamedTuple):
    """m and τ, each a series in φ."""

    follower_shift: Taylor
    cam_turn: Taylor


class ContactError(NamedTuple):
    """Where cams touch with points of their profiles, and the errors of their motion there."""

    angle: FloatArray
    """The cam angle θ, rad."""
    error: FloatArray
    """Of the tool, or of a derivative of its motion, mm (rad) by powers of rad."""


class FollowerContact(NamedTuple):
    """Cams that touch with places of their profiles."""

    cam_turn: FloatArray
    """τ, rad."""
    errors: list[FloatArray]
    """δ of the follower and its derivatives by the cam angle θ."""


@dataclass(frozen=True)
class RealCam:
    """Cams cut by one design, each with errors of its own and a follower that is put together with others."""

    problem: Problem
    waves: int = 0
    """Of the error of the profile, in a turn; 0 if it is the same all over."""

    @cached_property
    def contacts(self) -> tuple[Problem, ...]:
        """Each contact of the follower, as that of an ordinary cam without a train."""
        return contact_problems(self.problem)

    @property
    def second_motion_sign(self) -> float:
        """What its own motion at the second contact is to e₂ (``effects.error_response.back_of``)."""
        return second_motion_sign(self.problem.setup.mechanism)

    @property
    def is_developed(self) -> bool:
        """Whether the cam is a cylinder."""
        return self.problem.setup.mechanism.body.developed

    def contact_shift(
        self, number: int, design: Designs, errors: Errors, motion: Sequence[Any], order: int
    ) -> ContactShiftSeries:
        """Where the follower of a contact rests on the point that a nominal one touches, with flat errors.

        ``motion`` are y, y', y'' and y''' of the contact there; all are numbers, arrays, or ranges with slopes.
        """
        problem = self.contacts[number]
        mechanism, sense = problem.setup.mechanism, design.sense
        y, slope = (_motion_series(motion[k:], order) for k in (0, 1))
        known = {
            key: each
            for key, each in errors.items()
            if key not in (WAVE_PHASE, PROFILE_LEVEL, BORE, BORE_DIRECTION)
        }
        if WAVE_PHASE in errors:
            known["profile"] = _profile_wave_series(errors, self.waves, order)
        off = contact_errors(known)
        if BORE in errors and not self.is_developed:
            off = off._replace(bore=_bore_axis_series(errors, sense, order))
        rest = mechanism.shifted_contact(design, problem.programme.lift, y, slope, off)
        moved, turned = (_without_kept_quotients(y * 0.0 + each) for each in rest)
        if BORE in errors and self.is_developed:
            turned = _shift_along_surface(turned, errors, design)
        return ContactShiftSeries(moved, turned - errors.get("phase", 0.0))

    def contact_error(
        self, errors: Errors, places: FloatArray, order: int = 0, *, jumps: bool = True, fixed: bool = False
    ) -> ContactError:
        """The contact of cams (m,) with the points that a nominal follower touches at cam angles, and their errors.

        Errors are flat, each as it is where the point is touched; ``fixed`` are those of the cam, so that the wave
        of a second contact goes on to where that touches. A cam that touches before a jump of y'' where it should
        be after it, or the other way, has the jump for an error, unless ``jumps`` are left out.
        """
        found = self.follower_contact(errors, places, order, jumps=jumps, fixed=fixed)
        return self.error_at_tool(errors, places + found.cam_turn, found.errors)

    def follower_contact(
        self, errors: Errors, places: FloatArray, order: int = 0, *, jumps: bool = True, fixed: bool = False
    ) -> FollowerContact:
        """The same of the follower, in the middle of its contacts."""
        first = self._contact_of_one(0, self.errors_of_contact(0, errors), places, order, jumps)
        if len(self.contacts) == 1:
            return first
        ahead = self.second_contact_lead(errors, places, first.cam_turn, fixed=fixed)
        second = self._contact_of_one(
            1, self.errors_of_contact(1, errors, ahead, fixed=fixed), places + ahead, order, jumps
        )
        both = zip(first.errors, second.errors, strict=True)
        return FollowerContact(
            first.cam_turn, [(one - self.second_motion_sign * other) / 2.0 for one, other in both]
        )

    def second_contact_lead(
        self, errors: Errors, places: FloatArray, turned: FloatArray, *, fixed: bool = False
    ) -> FloatArray:
        """How far ahead of the first contact the second one touches."""
        ahead = np.zeros_like(turned)
        for _ in range(CONTACT_ROUNDS):
            ahead = turned - self.cam_turns(errors, places, 1, ahead, fixed=fixed)
        return ahead

    def error_at_tool(self, errors: Errors, angles: FloatArray, found: Sequence[FloatArray]) -> ContactError:
        """The error of the last order at the tool, from those of a follower up to it at cam angles."""
        train = self.problem.setup.train
        if train is None:
            return ContactError(angles, found[-1])
        y = self.problem.programme.motion_at(self.angles_in_turn(angles), len(found) - 1)
        off, asked = (
            Taylor([e / part for e, part in zip(each, TERM_FACTORIALS, strict=False)]) for each in (found, y)
        )
        asked = asked + follower_start(self.problem)
        moved = self.problem.train_with_errors(errors).tool(asked + off) - train.tool(asked)
        return ContactError(angles, np.asarray(moved.derivative(len(found) - 1) + np.zeros_like(angles)))

    def angles_in_turn(self, angles: FloatArray) -> FloatArray:
        """Cam angles within the turn, rad."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def motion_errors(self, off: CamErrors, places: FloatArray, order: int) -> FloatArray:
        """The errors of position, velocity or acceleration (order 0, 1, 2) of cams (n,), where each is touched at
        the cam angle of ``places`` (n,), rad; in mm or rad by powers of rad."""
        return self.contact_error(self.errors_in_ground(off, places), places, order, fixed=True).error

    def tool_positions(self, off: CamErrors, places: FloatArray) -> FloatArray:
        """Where the tool is when cams are touched at places, from its lowest position, mm (rad)."""
        found = self.contact_error(self.errors_in_ground(off, places), places, fixed=True)
        return np.asarray(
            self.problem.programme.tool.motion_at(self.angles_in_turn(found.angle), 0)[0] + found.error
        )

    def contact_angles(self, off: CamErrors, places: FloatArray) -> FloatArray:
        """The cam angles at which cams are touched at places, rad."""
        return np.asarray(places + self.cam_turns(self.errors_in_ground(off, places), places))

    def contact_places(self, off: CamErrors, angles: FloatArray) -> FloatArray:
        """The places where cams are touched at cam angles."""
        places = angles
        for _ in range(CONTACT_ROUNDS):
            places = places - (self.contact_angles(off, places) - angles)
        return places

    def errors_in_ground(self, off: CamErrors, places: FloatArray) -> dict[str, Any]:
        """Errors of cams as they are when places are touched, flat; the profile's there."""
        found = {key: each for key, each in off.items() if key != BORE and not np.iscomplexobj(each)}
        for key in off.keys() - found.keys() - {BORE}:
            crest = np.conj(off[key]) * np.exp(1j * self.waves * places)
            found |= {key: crest.real, direction_key(key): crest.imag}
        angles, sense = places, self.problem.design.sense
        for left in reversed(range(BORE_ROUNDS if BORE in off and self.is_developed else int(BORE in off))):
            bore = off[BORE] * np.exp(1j * sense * angles)
            found |= {BORE: bore.real, BORE_DIRECTION: bore.imag}
            angles = places + self.cam_turns(found, places) + off.get("phase", 0.0) if left else angles
        return found

    def cam_turns(
        self, errors: Errors, places: FloatArray, number: int = 0, ahead: Any = 0.0, *, fixed: bool = False
    ) -> FloatArray:
        """How much further the cam is turned where a contact touches places that are ahead."""
        own, programme = self.errors_of_contact(number, errors, ahead, fixed=fixed), self.contacts[number].programme
        motion = [*programme.motion_at(self.angles_in_turn(places + ahead), 1)]
        found = self.contact_shift(number, self.contacts[number].design, own, motion, 0)
        return np.asarray(found.cam_turn.terms[0] + np.zeros_like(places))

    def errors_of_contact(
        self, number: int, errors: Errors, ahead: Any = 0.0, *, fixed: bool = False
    ) -> dict[str, Any]:
        """Errors as a contact has them that touches ahead; the axis of the bore as it is then in the ground."""
        found = errors_at_contact(self.problem, number, errors)
        if not self.is_developed:
            found = turn_error(found, BORE, ahead * self.contacts[number].design.sense)
        return turn_error(found, "profile", ahead * self.waves) if fixed else found

    def _contact_of_one(
        self, number: int, errors: Errors, places: FloatArray, order: int = 0, jumps: bool = True
    ) -> FollowerContact:
        """The contact with the points that a nominal follower touches at cam angles, with errors of its own."""
        problem, base = self.contacts[number], self.angles_in_turn(places)
        programme = problem.programme
        motion = [*programme.motion_at(base, order + 1)]
        moved = self.contact_shift(number, problem.design, errors, motion, order)
        turned = moved.cam_turn.terms[0] + np.zeros_like(base)
        there, passed = programme.motion_at(self.angles_in_turn(base + turned), order), np.zeros_like(base)
        turn = programme.strokes[-1].end
        for jump in programme.jumps if order == 2 else ():
            ahead, behind = np.mod(jump.at - base, turn), np.mod(base - jump.at, turn)
            passed += jump.size * ((turned > ahead) * 1.0 - (-turned > behind))

        def differs(k: int) -> FloatArray:
            return np.asarray(there[k] - motion[k] - (passed if k == 2 else 0.0))

        found = follower_errors(moved, motion, differs, passed if jumps else 0.0, order)
        return FollowerContact(turned, [each + np.zeros_like(base) for each in found])


def follower_errors(
    moved: ContactShiftSeries, motion: Sequence[Any], differs: Callable[[int], Any], jumped: Any, order: int
) -> list[Any]:
    """δ and its derivatives by the cam angle, to an order.

    ``differs`` has d_k but for the jumps of y'' between φ and θ, which are ``jumped``.
    """
    m, t = moved
    found = [m.terms[0] - differs(0)]
    if order == 0:
        return found
    speed, there = t.terms[1] + 1.0, motion[1] + differs(1)
    found.append((m.terms[1] - t.terms[1] * there - differs(1)) / speed)
    if order == 1:
        return found
    bent = differs(2) + jumped
    curved = (there + found[1]) * t.terms[2] * 2.0 + t.terms[1] * (t.terms[1] + 2.0) * (motion[2] + bent)
    return [*found, (m.terms[2] * 2.0 - curved - bent) / np.square(speed)]


def follower_start(problem: Problem) -> float:
    """The displacement of the follower from the start position of its train, where that of the turn is 0."""
    programme, first, train = problem.programme, np.zeros(1), problem.setup.train
    assert train is not None
    return float((train.follower_at(tool_position(programme, first)) - programme.motion_at(first)[0])[0])


def _motion_series(motion: Sequence[Any], order: int) -> Taylor:
    return Taylor([each * (1.0, 1.0, 0.5)[k] for k, each in enumerate(motion[: order + 1])])


def _profile_wave_series(errors: Errors, waves: int, order: int) -> Taylor:
    """By how much a profile stands out, as a series in φ."""
    x, y, n = errors["profile"], errors[WAVE_PHASE], float(waves)
    return Taylor([errors.get(PROFILE_LEVEL, x), y * -n, x * (-0.5 * n * n)][: order + 1])


def _bore_axis_series(errors: Errors, sense: float, order: int) -> tuple[Taylor, Taylor]:
    """How far the axis of the profile of a disc is off, in the ground."""
    x, y = errors[BORE], errors.get(BORE_DIRECTION, 0.0)
    return Taylor([x, y * -sense, x * -0.5][: order + 1]), Taylor([y, x * sense, y * -0.5][: order + 1])


def _shift_along_surface(turned: Taylor, errors: Errors, design: Designs) -> Taylor:
    """With a cylinder whose axis is off along its surface by x, which changes as θ grows."""
    x, slope = errors[BORE] / design.size, errors.get(BORE_DIRECTION, 0.0) / design.size * -design.sense
    terms = [turned.terms[0] + x]
    if len(turned.terms) > 1:
        rate = (turned.terms[1] + 1.0) / (1.0 - slope)
        terms.append((turned.terms[1] + slope) / (1.0 - slope))
    if len(turned.terms) > 2:
        terms.append((turned.terms[2] - x * np.square(rate) * 0.5) / (1.0 - slope))
    return Taylor(terms)


def _without_kept_quotients(series: Taylor) -> Taylor:
    """Ranges without kept quotients."""
    return Taylor([each.divide() if hasattr(each, "divide") else each for each in series.terms])

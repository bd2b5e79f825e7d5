"""How the motion answers to a small error of cam or follower, to first order: one formula for all errors.

With the outward normal N of the pitch curve (of a flat face: of the face) where the follower touches, an error that
moves the trace point by δq while the displacement stays, and a profile that stands out by δn along the normal, the
follower moves by

    δ = (|N|·δn − N·δq) / (N·u),    u = ∂q/∂y

and the tool by f'·δ, with the ratio f' of the train. What is left out is of second order: below 0.05 µm for errors
of 10 µm. Velocity and acceleration are those of the series of δ by the cam angle, which come of the motion's own.

A profile within ±t with at most n waves in a turn is a trigonometric polynomial δn of degree n. Its slopes are
bounded by Bernstein's and Szegő's inequality, δn'² + n²·δn² ≤ n²·t², and the same of δn' with n·t: with the answer
g to the profile

    |gδn| ≤ |g|·t,    |(gδn)'| ≤ t·√(g'² + n²g²),    |(gδn)''| ≤ t·(|g''| + n·√(4g'² + n²g²))

The first two are attained by a cosine of n waves. Without n no slope is bounded.

Sources: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7), varied;
S. Bernstein, Sur l'ordre de la meilleure approximation des fonctions continues, 1912; R. Boas, Entire
Functions, ch. 11 (Szegő's form).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from camopt.mechanisms import FIELDS
from camopt.mechanisms.rest import ContactPoint, Shift
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Series, Taylor
from camopt.problem.problem import Problem
from camopt.scene.tolerances import ANGLES

ORDERS = 3
"""Displacement, velocity and acceleration: the terms of each series."""


def most_of_profile(answer: FloatArray, zone: float, waves: int | None) -> FloatArray:
    """The largest magnitude of what a profile within a zone makes, with so many waves in a turn, (3, m)."""
    g, g1, g2 = np.abs(answer)
    if waves is None:
        return zone * np.array([g, np.full_like(g, inf), np.full_like(g, inf)])
    n = float(waves)
    return zone * np.array([g, np.hypot(g1, n * g), g2 + n * np.hypot(2.0 * g1, n * g)])


@dataclass(frozen=True)
class Responses:
    """The answers of the motion of one design at cam angles (m,) in rad: δ, δ' and δ'' of the tool, each (3, m).

    In mm or rad by mm or rad of the error; the derivatives by the cam angle in rad.
    """

    problem: Problem
    angles: FloatArray

    def to_number(self, key: str) -> FloatArray:
        """To a number that is larger than it should be, by its key: a size of the follower, a link, or an angle."""
        table, _, name = key.partition(".")
        if key in ANGLES:
            return self.to_phase if key == "phase" else self.to_tilt
        return self._to_link(key) if table == "train" else self.to_size(FIELDS[name])

    def rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """To an error of a key of ``[tolerances]``, to its real and its imaginary part."""
        if key == "bore_eccentricity":
            return self.to_bore
        if key == "profile":
            return self.to_waves(waves) if waves else (self.to_profile,)
        return (self.to_number(key),)

    def to_size(self, field: str) -> FloatArray:
        """To a size of the follower, by field of ``Designs``, that is larger than it should be."""
        if field == "roller_radius":
            return self.to_profile
        return self._to_shift(self._shifts[field])

    @cached_property
    def to_profile(self) -> FloatArray:
        """To a profile that stands out along its normal everywhere, as to a roller that is larger by as much.

        A roller in a groove is held from both sides: there it is the middle of the groove that is off.
        """
        return self._answer(self._length)

    def to_waves(self, count: int) -> tuple[FloatArray, FloatArray]:
        """To a profile that stands out as a cosine, and as a sine, of so many waves in a turn."""
        turned = self._series(count * self.angles, np.full(self.angles.size, float(count)))
        return self._off(np.cos(turned)), self._off(np.sin(turned))

    @cached_property
    def to_bore(self) -> tuple[FloatArray, FloatArray]:
        """To a profile whose axis is off that of the bore, in each of two directions that turn with the cam.

        On a cylinder the part along the surface counts; what is across makes the groove deeper, and moves nothing.
        """
        design, developed = self.problem.design, self.problem.setup.mechanism.body.developed
        turned = self._series(design.sense * self.angles, np.full(self.angles.size, design.sense))
        cosine, sine, still = np.cos(turned), np.sin(turned), turned * 0.0
        ways = ((cosine, still), (-sine, still)) if developed else ((cosine, sine), (-sine, cosine))
        first, second = (-self._to_shift(each) for each in ways)
        return first, second

    @cached_property
    def to_phase(self) -> FloatArray:
        """To a cam that is ahead on its shaft."""
        return self._tool(self._slope)

    @cached_property
    def to_tilt(self) -> FloatArray:
        """To a translating flat face that is tilted about where the axis of its stem meets it."""
        return self._to_shift((0.0, self._contact.x - self.problem.design.offset))

    def _to_link(self, key: str) -> FloatArray:
        """To a number of the train, from the series of the tool by it, whose terms are series by the cam angle."""
        problem = self.problem
        made = problem.trains({key: Taylor([problem.nominal[key], 1.0])})
        moved = made.tool(Taylor([self._follower, self._follower * 0.0])).terms[1]
        return self._terms(moved)

    def _to_shift(self, shift: Shift) -> FloatArray:
        """To a shift of the trace point while the displacement stays."""
        return self._answer(-self._along(shift))

    def _off(self, standing: Series) -> FloatArray:
        """To a profile that stands out along its normal by a series."""
        return self._answer(self._length * standing)

    def _answer(self, off: Series) -> FloatArray:
        """To a normal of N that is off by a series, in units of |N|."""
        return self._tool(off / self._along(self._shifts["displacement"]))

    def _along(self, shift: Shift) -> Series:
        """N·shift."""
        return self._contact.across * shift[0] + self._contact.up * shift[1]

    def _tool(self, found: Series) -> FloatArray:
        """What a series of the follower is at the tool."""
        return self._terms(found if self.ratio is None else found * self.ratio)

    def _terms(self, found: Series) -> FloatArray:
        return np.array([np.broadcast_to(found.derivative(order), self.angles.shape) for order in range(ORDERS)])

    @cached_property
    def _motion(self) -> tuple[Series, Series]:
        """Displacement and velocity of the follower."""
        y, y1, y2, y3 = self.problem.programme.at(self.angles)
        return Taylor([y, y1, y2 / 2]), Taylor([y1, y2, y3 / 2])

    @property
    def _slope(self) -> Series:
        return self._motion[1]

    @cached_property
    def _contact(self) -> ContactPoint:
        problem = self.problem
        angle = self._series(self.angles, np.ones_like(self.angles))
        return problem.setup.mechanism.contact(problem.design, problem.programme.lift, angle, *self._motion)

    @cached_property
    def _length(self) -> Series:
        """|N|."""
        normal = self._contact
        return (normal.across * normal.across + normal.up * normal.up).root()

    @cached_property
    def _shifts(self) -> dict[str, Shift]:
        problem = self.problem
        return problem.setup.mechanism.shifts(problem.design, problem.programme.lift, *self._motion)

    @cached_property
    def ratio(self) -> Series | None:
        """The ratio of the train; None without one."""
        train = self.problem.setup.train
        return None if train is None else train.joints(self._follower)[-1].ratio

    @cached_property
    def _follower(self) -> Series:
        """Where the follower is from the start of its train."""
        train, programme = self.problem.setup.train, self.problem.programme
        assert train is not None
        _, z1, z2, _ = programme.tool.at(self.angles)
        return train.follower(Taylor([tool_position(programme, self.angles), z1, z2 / 2]))

    def _series(self, value: FloatArray, slope: FloatArray) -> Series:
        """A series that is straight."""
        return Taylor([value, slope, np.zeros_like(value)])

"""A four-bar linkage: a crank that turns a rocker by a coupler.

Crank a, coupler b and rocker c, with their pivots at the distance d; angles are measured from the direction of the
crank's pivot to the rocker's. With A = a·e^{iφ} − d the rocker is at (law of cosines)

    ψ = arg A ∓ acos((|A|² + c² − b²)/(2·c·|A|)),    and back    φ = arg B ± acos((|B|² + a² − b²)/(2·a·|B|))

with B = d + c·e^{iψ}; the upper sign for the open linkage, the lower for the crossed one. Dead points are where
crank and coupler are in line, |B| = |a ± b|, and where coupler and rocker are, |A| = |b ± c|.

Source: Norton, Design of Machinery, ch. 4 (position analysis of the fourbar linkage).
"""

from cmath import phase, rect
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import triangle_angle
from camopt.core.numerics.taylor import Series, angle_of, direction, series_quotient
from camopt.model.trains.crank import CRANK_IN_LINE
from camopt.model.trains.link import (
    FLAT_TOLERANCE,
    RADIAN,
    AssemblyFault,
    Bar,
    Coupler,
    DeadPoint,
    Force,
    Keys,
    StageKind,
    Vector,
    acute_angle,
    choose_form,
    nearest_ends,
    position_at,
    require_positive,
    unit_series,
    value_at_start,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, bar

ROCKER_IN_LINE = "coupler and rocker are in line"


@dataclass(frozen=True)
class FourBar:
    """From the angle of the crank to that of the rocker; mm and rad."""

    ground: Any
    start: Any
    asked_start: Any
    """The rocker's angle at the start."""
    crank: Bar
    rocker: Bar

    @property
    def turns(self) -> tuple[bool, bool]:
        return True, True

    @property
    def ends(self) -> tuple[DeadPoint, DeadPoint]:
        places = [*self._in_line_with_rocker(), *self._in_line_with_crank()]
        return nearest_ends(each._replace(at=each.at - self.start) for each in places)

    def _in_line_with_rocker(self) -> Iterator[DeadPoint]:
        """Where |A| is |b ± c|."""
        a, b, c, d = self.crank.length, self.crank.other, self.rocker.length, self.ground
        for far in (b + c, abs(b - c)):
            if _forms_triangle(a, d, far):
                angle = float(triangle_angle(a, d, far))
                yield from (DeadPoint(sign * angle, ROCKER_IN_LINE) for sign in (1.0, -1.0))

    def _in_line_with_crank(self) -> Iterator[DeadPoint]:
        """Where |B| is |a ± b|, with the linkage assembled as at the start."""
        a, b, c, d = self.crank.length, self.crank.other, self.rocker.length, self.ground
        for far in (a + b, a - b):
            for sign in (1.0, -1.0) if far and _forms_triangle(c, d, abs(far)) else ():
                arm = rect(c, sign * (pi - float(triangle_angle(c, d, abs(far)))))
                turned = phase((d + arm) / far)
                if phase(arm / (rect(a, turned) - d)) * self.rocker.side >= 0.0:
                    yield DeadPoint(turned, CRANK_IN_LINE)

    def forward(self, given: Series) -> Series:
        return self.rocker.angle(*_aim_from_origin(given + self.start, self.crank.length, -self.ground))

    def ratio(self, given: Series) -> Series:
        """Both ends of the coupler are as fast along it: a·φ'·sin(φ − δ) = c·ψ'·sin(ψ − δ), with δ its angle."""
        return series_quotient(*self._levers(given))

    def _levers(self, given: Series) -> tuple[Series, Series]:
        """The moments of the coupler, as a force b, about both pivots: b·a·sin(δ − φ) and b·c·sin(δ − ψ)."""
        (c1, s1), (c2, s2) = direction(given + self.start), direction(self.forward(given) + self.asked_start)
        a, c = self.crank.length, self.rocker.length
        along, across = c2 * c - c1 * a + self.ground, s2 * c - s1 * a
        return (c1 * across - s1 * along) * a, (c2 * across - s2 * along) * c

    @property
    def forces(self) -> tuple[Force]:
        """1/(c·sin(δ − ψ)) in the coupler."""
        return (Force("coupler", "joint", self._coupler_share, way=self._coupler_direction),)

    def _coupler_direction(self, given: FloatArray) -> FloatArray:
        _, (along, across) = self._rocker_and_coupler(given)
        return np.asarray(np.arctan2(across, along))

    def _coupler_share(self, given: Series) -> Series:
        return series_quotient(unit_series(given) * self.crank.other, self._levers(given)[1])

    @property
    def couplers(self) -> tuple[Coupler, None]:
        """Between coupler and rocker, which the crank drives; none where the rocker drives, as no train does."""
        places = tuple(k * pi - self.start for k in range(-2, 3))
        return Coupler(lambda turned: acute_angle(*self._rocker_and_coupler(turned)), places), None

    def _rocker_and_coupler(self, turned: Any) -> tuple[Vector, Vector]:
        """From the rocker's pivot to its pin, and from the crank's pin there."""
        a, c, phi = self.crank.length, self.rocker.length, turned + self.start
        psi = position_at(self.forward, turned) + self.asked_start
        x, y = np.cos(psi) * c, np.sin(psi) * c
        return (x, y), (x + self.ground - np.cos(phi) * a, y - np.sin(phi) * a)

    def sketch(self, given: FloatArray, asked: FloatArray, size: float, *, back: bool = False) -> LinkSketch:
        """Crank, coupler and rocker."""
        pin = self.crank.length * np.exp(1j * (self.start + given))
        end = self.ground + self.rocker.length * np.exp(1j * (self.asked_start + asked))
        fixed = np.zeros_like(pin)
        return LinkSketch(
            [bar((fixed, pin)), bar((fixed + self.ground, end)), bar((pin, end))],
            [Support("pivot", 0.0), Support("pivot", self.ground)],
            Port(0.0, 1.0),
            Port(self.ground, 1.0),
        )

    def backward(self, asked: Series) -> Series:
        return self.crank.angle(*_aim_from_origin(asked + self.asked_start, self.rocker.length, self.ground))


def _forms_triangle(one: float, other: float, far: float) -> bool:
    """Whether three sides form a triangle; a flat one counts, even where rounding opens it."""
    room = FLAT_TOLERANCE * (one + other + far)
    return abs(one - other) - room <= far <= one + other + room


def _aim_from_origin(angle: Series, radius: Any, offset: Any) -> tuple[Series, Series]:
    """The direction and the squared distance of r·e^{iθ} + d, from the origin.

    As the angle of the larger of both and what the other adds to it, which is less than a right angle, the
    direction never jumps by a turn; that of d below 0 is taken off.
    """
    cosine, sine = direction(angle)
    square = cosine * (radius * offset * 2.0) + (radius * radius + offset * offset)
    towards = choose_form(
        radius - abs(offset),
        lambda: angle + angle_of(cosine * offset + radius, sine * -offset),
        lambda: angle_of(cosine * (radius / offset) + 1.0, sine * (radius / offset)),
    )
    return towards, square


def four_bar(crank: Any, coupler: Any, rocker: Any, ground: Any, angle: Any, *, crossed: bool) -> FourBar:
    """A linkage with the crank's start angle in deg.

    Raises
    ------
    Unassembled
        If the coupler does not reach from the crank to the rocker.
    """
    start = angle * RADIAN
    cosine, sine = np.cos(start), np.sin(start)
    back, down = ground - cosine * crank, -(sine * crank)
    square = cosine * (crank * ground * -2.0) + (crank * crank + ground * ground)
    along = square + (rocker - coupler) * (rocker + coupler)
    room = square * (rocker * rocker * 4.0) - along * along
    apart = "coupler and rocker ({:g} and {:g}) do not meet with the crank at {:g} deg"
    require_positive(room, lambda: apart.format(coupler, rocker, angle))
    side = 1.0 if crossed else -1.0
    asked = np.arctan2(down, back) + np.arctan2(np.sqrt(room), along) * side + pi
    pin = np.cos(asked) * rocker + ground, np.sin(asked) * rocker
    bars = Bar(crank, coupler, np.sign(sine * pin[0] - cosine * pin[1])), Bar(rocker, coupler, side)
    bare = FourBar(ground, start, asked, *bars)
    rests = value_at_start(bare.backward, room), value_at_start(bare.forward, room)
    return FourBar(ground, start, asked, *(replace(bar, rest=rest) for bar, rest in zip(bars, rests, strict=True)))


def _four_bar_links(keys: Keys, turns: bool) -> tuple[FourBar]:
    if not turns:
        raise AssemblyFault("its crank takes an angle, and what comes to it is a length")
    sizes = (keys[name] for name in FOUR_BAR_KEYS)
    return (four_bar(*sizes, crossed=keys.get("crossed", False)),)


FOUR_BAR_KEYS = ("crank", "coupler", "rocker", "ground", "angle")
STAGE = StageKind(
    "four-bar", "a four-bar linkage", FOUR_BAR_KEYS, ("crossed",), lambda keys, turns: True, _four_bar_links
)

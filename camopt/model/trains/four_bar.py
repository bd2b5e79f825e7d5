"""A four-bar linkage: a crank that turns a rocker by a coupler.

The crank has the length a, the coupler b, the rocker c; the distance of the pivots is d. The angles φ of the crank
and ψ of the rocker are measured from the line that leads from the crank's pivot to the rocker's. By the law of
cosines, with A = a·e^{iφ} − d and B = d + c·e^{iψ},

    ψ = arg A ∓ acos((|A|² + c² − b²)/(2·c·|A|)),    and back    φ = arg B ± acos((|B|² + a² − b²)/(2·a·|B|))

The upper sign is for the open linkage, the lower for the crossed one. Dead points are where crank and coupler are
in line, |B| = |a ± b|, and where coupler and rocker are in line, |A| = |b ± c|.

Source: Norton, Design of Machinery, ch. 4 (position analysis of the fourbar linkage).
"""

from cmath import phase, rect
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import triangle_angle
from camopt.core.numerics.taylor import Series, cosine_and_sine_series, series_quotient, vector_angle
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
    choose_formula_by_sign,
    constant_one_series,
    formula_value_at,
    formula_value_at_start,
    nearest_dead_points,
    require_positive,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, bar_member

ROCKER_IN_LINE = "coupler and rocker are in line"


@dataclass(frozen=True)
class FourBar:
    """Turns the angle of the crank into that of the rocker [rad]; lengths in mm."""

    ground: Any
    start: Any
    rocker_start: Any
    """The rocker's angle at the start."""
    crank: Bar
    rocker: Bar

    driver_and_driven_angular = (True, True)

    @property
    def dead_points(self) -> tuple[DeadPoint, DeadPoint]:
        a, b, c, d = self.crank.length, self.crank.other, self.rocker.length, self.ground
        places = list[DeadPoint]()
        for far in (b + c, abs(b - c)):  # |A| with coupler and rocker in line
            if _forms_triangle(a, d, far):
                angle = float(triangle_angle(a, d, far))
                places += (DeadPoint(sign * angle, ROCKER_IN_LINE) for sign in (1.0, -1.0))
        for far in (a + b, a - b):  # ± |B| with crank and coupler in line, on the branch of the start position
            for sign in (1.0, -1.0) if far and _forms_triangle(c, d, abs(far)) else ():
                arm = rect(c, sign * (pi - float(triangle_angle(c, d, abs(far)))))
                turned = phase((d + arm) / far)
                if phase(arm / (rect(a, turned) - d)) * self.rocker.side >= 0.0:
                    places.append(DeadPoint(turned, CRANK_IN_LINE))
        return nearest_dead_points(each._replace(at=each.at - self.start) for each in places)

    def driven_displacement(self, driver: Series) -> Series:
        return self.rocker.angle(
            *_direction_and_squared_distance(driver + self.start, self.crank.length, -self.ground)
        )

    def velocity_ratio(self, driver: Series) -> Series:
        """Velocity ratio ψ'/φ', as both ends of the coupler have the same velocity along it.

        With the coupler at the angle δ, a·φ'·sin(φ − δ) = c·ψ'·sin(ψ − δ).
        """
        return series_quotient(*self._coupler_moments(driver))

    def _coupler_moments(self, driver: Series) -> tuple[Series, Series]:
        """Moments of a force b along the coupler about both pivots: b·a·sin(δ − φ) and b·c·sin(δ − ψ)."""
        (c1, s1), (c2, s2) = (
            cosine_and_sine_series(driver + self.start),
            cosine_and_sine_series(self.driven_displacement(driver) + self.rocker_start),
        )
        a, c = self.crank.length, self.rocker.length
        along, across = c2 * c - c1 * a + self.ground, s2 * c - s1 * a
        return (c1 * across - s1 * along) * a, (c2 * across - s2 * along) * c

    @property
    def joint_forces(self) -> tuple[Force]:
        """The force in the coupler, 1/(c·sin(δ − ψ))."""
        return (Force("coupler", "joint", self._coupler_force_share, way=self._coupler_direction),)

    def _coupler_direction(self, driver: FloatArray) -> FloatArray:
        _, (along, across) = self._rocker_and_coupler(driver)
        return np.asarray(np.arctan2(across, along))

    def _coupler_force_share(self, driver: Series) -> Series:
        return series_quotient(constant_one_series(driver) * self.crank.other, self._coupler_moments(driver)[1])

    @property
    def couplers_by_driving_side(self) -> tuple[Coupler, None]:
        """The coupler driven by the crank, with its angle to the rocker; no train drives the rocker."""
        places = tuple(k * pi - self.start for k in range(-2, 3))
        return Coupler(lambda driver: acute_angle(*self._rocker_and_coupler(driver)), places), None

    def _rocker_and_coupler(self, driver: Any) -> tuple[Vector, Vector]:
        """The rocker from its pivot to its pin, and the coupler from the crank's pin to the rocker's."""
        a, c, phi = self.crank.length, self.rocker.length, driver + self.start
        psi = formula_value_at(self.driven_displacement, driver) + self.rocker_start
        x, y = np.cos(psi) * c, np.sin(psi) * c
        return (x, y), (x + self.ground - np.cos(phi) * a, y - np.sin(phi) * a)

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        pin = self.crank.length * np.exp(1j * (self.start + driver))
        end = self.ground + self.rocker.length * np.exp(1j * (self.rocker_start + driven))
        fixed = np.zeros_like(pin)
        return LinkSketch(
            [bar_member((fixed, pin)), bar_member((fixed + self.ground, end)), bar_member((pin, end))],
            [Support("pivot", 0.0), Support("pivot", self.ground)],
            Port(0.0, 1.0),
            Port(self.ground, 1.0),
        )

    def driver_displacement(self, driven: Series) -> Series:
        return self.crank.angle(
            *_direction_and_squared_distance(driven + self.rocker_start, self.rocker.length, self.ground)
        )


def _forms_triangle(first_side: float, second_side: float, third_side: float) -> bool:
    """Whether three sides form a triangle; flat ones count, also those that rounding has opened."""
    tolerance = FLAT_TOLERANCE * (first_side + second_side + third_side)
    return abs(first_side - second_side) - tolerance <= third_side <= first_side + second_side + tolerance


def _direction_and_squared_distance(angle: Series, radius: Any, offset: Any) -> tuple[Series, Series]:
    """Direction [rad] and squared distance of the point r·e^{iθ} + d, seen from the origin.

    The direction is the angle of the larger summand plus what the smaller one adds, less than a right angle: so it
    never jumps by a turn. For d < 0 it is measured from the direction of d.
    """
    cosine, sine = cosine_and_sine_series(angle)
    square = cosine * (radius * offset * 2.0) + (radius * radius + offset * offset)
    towards = choose_formula_by_sign(
        radius - abs(offset),
        lambda: angle + vector_angle(cosine * offset + radius, sine * -offset),
        lambda: vector_angle(cosine * (radius / offset) + 1.0, sine * (radius / offset)),
    )
    return towards, square


def assemble_four_bar(crank: Any, coupler: Any, rocker: Any, ground: Any, angle: Any, *, crossed: bool) -> FourBar:
    """A four-bar linkage from its lengths [mm] and the crank's start angle [deg].

    Raises
    ------
    AssemblyFault
        If the coupler does not reach from the crank to the rocker.
    """
    start = angle * RADIAN
    cosine, sine = np.cos(start), np.sin(start)
    back, down = ground - cosine * crank, -(sine * crank)
    square = cosine * (crank * ground * -2.0) + (crank * crank + ground * ground)
    along = square + (rocker - coupler) * (rocker + coupler)
    discriminant = square * (rocker * rocker * 4.0) - along * along
    apart = "coupler and rocker ({:g} and {:g} mm) do not meet with the crank at {:g} deg"
    require_positive(discriminant, lambda: apart.format(coupler, rocker, angle))
    side = 1.0 if crossed else -1.0
    psi = np.arctan2(down, back) + np.arctan2(np.sqrt(discriminant), along) * side + pi
    pin = np.cos(psi) * rocker + ground, np.sin(psi) * rocker
    bars = Bar(crank, coupler, np.sign(sine * pin[0] - cosine * pin[1])), Bar(rocker, coupler, side)
    linkage = FourBar(ground, start, psi, *bars)
    zeros = (
        formula_value_at_start(linkage.driver_displacement, discriminant),
        formula_value_at_start(linkage.driven_displacement, discriminant),
    )
    return FourBar(ground, start, psi, *(replace(bar, zero=zero) for bar, zero in zip(bars, zeros, strict=True)))


def _four_bar_links(keys: Keys, input_angular: bool) -> tuple[FourBar]:
    if not input_angular:
        raise AssemblyFault("it is driven by a length, but its crank needs an angle")
    return (assemble_four_bar(*(keys[name] for name in FOUR_BAR_KEYS), crossed=keys.get("crossed", False)),)


FOUR_BAR_KEYS = ("crank", "coupler", "rocker", "ground", "angle")
STAGE = StageKind(
    "four-bar", "a four-bar linkage", FOUR_BAR_KEYS, ("crossed",), lambda keys, turns: True, _four_bar_links
)

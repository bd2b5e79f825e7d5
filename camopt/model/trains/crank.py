"""A crank that moves a slide by a coupler; and the slider-crank, where an angle drives it, or a length its slide.

The crank has the length a, the coupler b. The line of the slide has the offset e from the crank's pivot. With the
crank at the angle φ from the slide's motion, the pin of the slide is ahead of the pivot by

    x = a·cos φ + Q,    Q = √(b² − S²),    S = a·sin φ − e        x′ = −a·sin φ − S·a·cos φ/Q

From the position of the slide follows the angle of the crank:

    φ = arg(x + i·e) ± acos((x² + e² + a² − b²)/(2·a·√(x² + e²)))

Dead points are where crank and coupler are in line, (a ± b)·sin φ = e, and where the coupler is square to the
slide's motion, |S| = b.

Source: Norton, Design of Machinery, ch. 4 (the offset slider-crank).
"""

from dataclasses import dataclass
from math import asin, atan2, pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.core.numerics.taylor import Series, cosine_and_sine_series, series_quotient, series_root, vector_angle
from camopt.model.trains.link import (
    FLAT_TOLERANCE,
    RADIAN,
    Bar,
    Coupler,
    DeadPoint,
    Force,
    Keys,
    Link,
    ReversedLink,
    StageKind,
    Vector,
    acute_angle,
    constant_one_series,
    formula_value_at,
    nearest_dead_points,
    perpendicular_direction,
    require_positive,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, bar_member, sliding_member

CRANK_IN_LINE = "crank and coupler are in line"
COUPLER_SQUARE = "the coupler is square to the slide"


@dataclass(frozen=True)
class Crank:
    """Turns an angle [rad] into a length [mm], positive away from the pivot."""

    crank: Any
    coupler: Any
    offset: Any
    start: Any
    place: Any
    """x in the start position."""
    bar: Bar
    """The crank when the slide drives it."""

    driver_and_driven_angular = (True, False)

    @property
    def dead_points(self) -> tuple[DeadPoint, DeadPoint]:
        a, b, e = self.crank, self.coupler, self.offset
        places = [DeadPoint(asin(e / (a + b)), CRANK_IN_LINE)]
        if abs(e) <= abs(a - b) and a != b:
            places.append(DeadPoint(pi - asin(e / (a - b)), CRANK_IN_LINE))
        for across in (e + b, e - b):
            if abs(across) <= a + FLAT_TOLERANCE * (a + b + abs(e)):
                angle = atan2(across, difference_of_squares_root(a, across))
                places += [DeadPoint(angle, COUPLER_SQUARE), DeadPoint(pi - angle, COUPLER_SQUARE)]
        return nearest_dead_points(each._replace(at=each.at - self.start) for each in places)

    def driven_displacement(self, driver: Series) -> Series:
        cosine, sine = cosine_and_sine_series(driver + self.start)
        across = sine * self.crank - self.offset
        return cosine * self.crank + series_root(-((across - self.coupler) * (across + self.coupler))) - self.place

    def velocity_ratio(self, driver: Series) -> Series:
        cosine, sine = cosine_and_sine_series(driver + self.start)
        along, across = self._coupler_along_and_across(sine)
        return (sine + series_quotient(across * cosine, along)) * -self.crank

    def _coupler_along_and_across(self, sine: Series) -> tuple[Series, Series]:
        """Q and S, the parts of the coupler along and across the slide's motion."""
        across = sine * self.crank - self.offset
        return series_root(-((across - self.coupler) * (across + self.coupler))), across

    @property
    def joint_forces(self) -> tuple[Force, ...]:
        """b/Q in the coupler, and S/Q on the guide of the slide."""
        guide = Force("guide", "guide", self._guide_force_share, way=perpendicular_direction)
        return Force("coupler", "joint", self._coupler_force_share, way=self._coupler_direction), guide

    def _coupler_direction(self, driver: FloatArray) -> FloatArray:
        along, across = self._coupler_vector(driver + self.start)
        return np.asarray(np.arctan2(across, along))

    def _coupler_force_share(self, driver: Series) -> Series:
        along, _ = self._coupler_along_and_across(cosine_and_sine_series(driver + self.start).sine)
        return series_quotient(constant_one_series(driver) * self.coupler, along)

    def _guide_force_share(self, driver: Series) -> Series:
        along, across = self._coupler_along_and_across(cosine_and_sine_series(driver + self.start).sine)
        return series_quotient(across, along)

    @property
    def couplers_by_driving_side(self) -> tuple[Coupler, Coupler]:
        """The coupler driven by the crank, and driven by the slide.

        The first angle is that to the line square to the slide's motion, the second that to the crank.
        """
        places = (k * pi / 2 - self.start for k in range(-5, 6, 2))
        by_crank = Coupler(
            lambda driver: acute_angle((0.0, 1.0), self._coupler_vector(driver + self.start)), tuple(places)
        )
        return by_crank, Coupler(self._transmission_angle_to_crank, (-self.place,))

    def _coupler_vector(self, angle: Any) -> Vector:
        """The coupler from the crank's pin to the slide's."""
        across = self.crank * np.sin(angle) - self.offset
        return np.sqrt((self.coupler - across) * (self.coupler + across)), -across

    def _transmission_angle_to_crank(self, slide: Any) -> Number:
        angle = formula_value_at(self.driver_displacement, slide) + self.start
        return acute_angle((np.cos(angle), np.sin(angle)), self._coupler_vector(angle))

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        pin = self.crank * np.exp(1j * (self.start + driver))
        slide, half = driven + self.place + 1j * self.offset, 0.035 * size
        block = half * np.array([-1.8 - 1j, 1.8 - 1j, 1.8 + 1j, -1.8 + 1j])
        first, way = complex(self.place, self.offset), complex(float(np.ptp(driven)) / 2 + 3 * half)
        middle = first + float(driven.min() + driven.max()) / 2
        return LinkSketch(
            [
                sliding_member("slide", block, slide),
                bar_member((np.zeros_like(pin), pin)),
                bar_member((pin, slide)),
            ],
            [Support("guide", middle, way), Support("pivot", 0.0)],
            Port(0.0, 1.0),
            Port(first, 1.0),
        )

    def driver_displacement(self, driven: Series) -> Series:
        x = driven + self.place
        towards = vector_angle(x * self.place + self.offset * self.offset, driven * -self.offset)
        return self.bar.angle(towards, x * x + self.offset * self.offset)


def assemble_crank(length: Any, coupler: Any, offset: Any, angle: Any) -> Crank:
    """A crank from its lengths [mm] and its start angle [deg].

    Raises
    ------
    AssemblyFault
        If the coupler does not reach the slide's line, or is square to it at the start.
    """
    start = angle * RADIAN
    cosine, sine = np.cos(start), np.sin(start)
    across = sine * length - offset
    far = "the coupler ({:g} mm) does not reach the slide: it is {:g} mm away"
    require_positive(coupler - abs(across), lambda: far.format(coupler, abs(across)))
    place = cosine * length + np.sqrt((coupler - across) * (coupler + across))
    x, y = cosine * place + sine * offset, sine * place - cosine * offset
    return Crank(length, coupler, offset, start, place, Bar(length, coupler, np.sign(y), np.arctan2(y, x)))


def _slider_crank_links(keys: Keys, input_angular: bool) -> tuple[Link]:
    link = assemble_crank(keys["crank"], keys["coupler"], keys.get("offset", 0.0), keys["angle"])
    return (link if input_angular else ReversedLink(link),)


SLIDER_CRANK_KEYS = ("crank", "coupler", "angle")
STAGE = StageKind(
    "slider-crank",
    "a slider-crank",
    SLIDER_CRANK_KEYS,
    ("offset",),
    lambda keys, turns: not turns,
    _slider_crank_links,
)

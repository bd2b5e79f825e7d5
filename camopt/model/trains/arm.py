"""An arm with a roller or a rounded pad at its end, which pushes a slide; and a rocker with two such arms.

The face of the slide is square to the slide's motion. The start angle α is measured from the line square to that
motion. An arm of length l that has turned by φ moves the slide by

    z = l·(sin(α + φ) − sin α)        z′ = l·cos(α + φ)

The radius of the roller or pad has no effect, because the face is square to the motion. The arm is at a dead point
where it points along the motion.

A rocker, as in valve trains, has a ratio that changes with its angle. The driving slide lifts its first arm, and
its second arm moves the output slide:

    y = l₁·(sin(α₁ + φ) − sin α₁)        z = l₂·(sin(α₂ + φ) − sin α₂)

An oscillating follower is the first arm itself.

Source: Norton, Design of Machinery, ch. 2 (the Scotch yoke is the same pairing).
"""

from cmath import rect
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, cosine_and_sine_series, series_root, vector_angle
from camopt.model.trains.link import (
    NO_COUPLERS,
    RADIAN,
    AssemblyFault,
    DeadPoint,
    Force,
    Keys,
    Link,
    ReversedLink,
    StageKind,
    constant_one_series,
    require_positive,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, bar_member, sliding_member

ARM_IN_LINE = "the arm points along the motion of the slide"


@dataclass(frozen=True)
class Arm:
    """Turns an angle [rad] into a length [mm]."""

    length: Any
    start: Any
    cosine: Any
    """Cosine of the start angle."""
    sine: Any
    """Sine of the start angle."""
    couplers_by_driving_side = NO_COUPLERS
    joint_forces = (Force("roller", "joint", constant_one_series, touches=True),)

    driver_and_driven_angular = (True, False)

    @property
    def dead_points(self) -> tuple[DeadPoint, DeadPoint]:
        return DeadPoint(-pi / 2 - self.start, ARM_IN_LINE), DeadPoint(pi / 2 - self.start, ARM_IN_LINE)

    def driven_displacement(self, driver: Series) -> Series:
        cosine, sine = cosine_and_sine_series(driver)
        return (sine * self.cosine + (cosine - 1.0) * self.sine) * self.length

    def driver_displacement(self, driven: Series) -> Series:
        sine = driven / self.length + self.sine
        cosine = series_root(-((sine - 1.0) * (sine + 1.0)))
        return vector_angle(cosine * self.cosine + sine * self.sine, sine * self.cosine - cosine * self.sine)

    def velocity_ratio(self, driver: Series) -> Series:
        cosine, sine = cosine_and_sine_series(driver)
        return (cosine * self.cosine - sine * self.sine) * self.length

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        """The arm with its roller and the slide; if the slide drives the arm, the link before draws it."""
        end = self.length * np.exp(1j * (self.start + driver))
        first, roller = complex(rect(self.length, self.start)), 0.035 * size
        members = [bar_member((np.zeros_like(end), end)), sliding_member("roller", np.array([roller]), end)]
        standing = [Support("pivot", 0.0)]
        if driven_backwards:
            return LinkSketch(members, standing, Port(0.0, -1.0), Port(first - 1j * roller, 1j))
        thick, half, travel = 0.03 * size, 0.02 * size, float(np.ptp(driven))
        guide, low, high = 2 * thick + travel, end.real.min() - first.real, end.real.max() - first.real
        top, ends = guide + 0.25 * size, (min(low, 0.0) - roller, max(high, 0.0) + roller)
        face = np.array([ends[0], ends[1], ends[1] + 1j * thick, half + 1j * thick, half + 1j * top])
        face = np.append(face, [-half + 1j * top, -half + 1j * thick, ends[0] + 1j * thick])
        members.append(sliding_member("slide", face, first + 1j * (driven + roller)))
        place = first + 1j * (roller + float(driven.min()) + guide + 0.07 * size)
        return LinkSketch(
            members,
            [*standing, Support("guide", place, 0.06j * size)],
            Port(0.0, 1.0),
            Port(first + 1j * (roller + top), 1j),
        )


def assemble_arm(length: Any, angle: Any) -> Arm:
    """An arm from its length [mm] and its start angle [deg].

    Raises
    ------
    AssemblyFault
        If the angle is not between −90 and 90.
    """
    why = "an arm at {:g} deg is at or beyond its dead point: its angle must be within ±90 deg"
    require_positive(90.0 - abs(angle), lambda: why.format(angle))
    start = angle * RADIAN
    return Arm(length, start, np.cos(start), np.sin(start))


def input_arm_links(keys: Keys, input_angular: bool) -> tuple[Link, ...]:
    """The input arm of a rocker or bell crank; none if an angle drives it."""
    if input_angular:
        if {"input_arm", "input_angle"} & keys.keys():
            raise AssemblyFault("it is driven by an angle, and so has no input_arm")
        return ()
    if "input_arm" not in keys:
        raise AssemblyFault("it is driven by a length, and so needs an input_arm (mm)")
    return (ReversedLink(assemble_arm(keys["input_arm"], keys.get("input_angle", 0.0))),)


def _rocker_links(keys: Keys, input_angular: bool) -> tuple[Link, ...]:
    output: Arm = assemble_arm(keys["output_arm"], keys.get("output_angle", 0.0))
    return (*input_arm_links(keys, input_angular), output)


STAGE = StageKind(
    "rocker",
    "a rocker",
    ("output_arm",),
    ("output_angle", "input_arm", "input_angle"),
    lambda keys, turns: False,
    _rocker_links,
)

"""A link of constant ratio: its output is a factor times its input; and the stage of a lever, gears, belt or rack.

    output = i·input;        a pinion turns an angle φ into the length r·φ, and a length s into the angle s/r

The stage's key ``ratio`` is i, negative if input and output move opposite ways. Its key ``radius`` is r, the radius
of the pinion or drum.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series
from camopt.model.trains.link import (
    NO_COUPLERS,
    NO_DEAD_POINTS,
    AssemblyFault,
    Force,
    Keys,
    StageKind,
    constant_one_series,
    require_positive,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, bar_member, sliding_member, wheel_member


@dataclass(frozen=True)
class ConstantRatio:
    """Output = factor·input: gears, racks, belts, levers, wedges."""

    factor: Any
    driver_and_driven_angular: tuple[bool, bool]
    couplers_by_driving_side = NO_COUPLERS
    dead_points = NO_DEAD_POINTS

    def driven_displacement(self, driver: Series) -> Series:
        return driver * self.factor

    def driver_displacement(self, driven: Series) -> Series:
        return driven / self.factor

    def velocity_ratio(self, driver: Series) -> Series:
        return constant_one_series(driver) * self.factor

    @property
    def joint_forces(self) -> tuple[Force, ...]:
        """The force on a pinion's teeth along the rack, or the forces at a lever's ends and pivot.

        Two wheels have none, because a ratio does not give their radii.
        """
        if self.driver_and_driven_angular == (True, True):
            return ()
        if self.driver_and_driven_angular != (False, False):
            along = 1.0 if self.driver_and_driven_angular[0] else self.factor
            return (Force("teeth", "joint", lambda driver: constant_one_series(driver) * along, touches=True),)
        ends = Force("input end", "joint", self.velocity_ratio), Force("output end", "joint", constant_one_series)
        return (*ends, Force("pivot", "pivot", lambda driver: constant_one_series(driver) * (1.0 - self.factor)))

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        """Wheels in mesh or with a belt, a pinion on its rack, or a lever between two slides."""
        if self.driver_and_driven_angular == (False, True):
            rack = ConstantRatio(1.0 / self.factor, (True, False))
            return rack.sketch(driven, driver, size, driven_backwards=not driven_backwards).reversed_sketch
        return {(True, True): self._sketch_wheels, (True, False): self._sketch_rack}.get(
            self.driver_and_driven_angular, self._sketch_lever
        )(driver, driven, size)

    def _sketch_wheels(self, driver: FloatArray, driven: FloatArray, size: float) -> LinkSketch:
        """Two wheels: in mesh if they turn opposite ways, with a belt if they turn the same way."""
        large, small = 0.3 * size, 0.3 * size * min(abs(self.factor), 1.0 / abs(self.factor))
        one, other = (large, small) if abs(self.factor) >= 1.0 else (small, large)
        away = one + other + (0.0 if self.factor < 0.0 else 0.3 * size)
        wheels = [wheel_member(one, 0.0, driver), wheel_member(other, away, driven)]
        if self.factor > 0.0:
            tilt = np.array([1j, -1j]) * np.exp(np.array([-1j, 1j]) * np.arcsin((one - other) / away))
            belt = [bar_member((wheels[0].at + one * side, wheels[1].at + other * side)) for side in tilt]
            wheels += [each._replace(shape="belt") for each in belt]
        return LinkSketch(wheels, [Support("pivot", 0.0), Support("pivot", away)], Port(0.0), Port(away))

    def _sketch_rack(self, driver: FloatArray, driven: FloatArray, size: float) -> LinkSketch:
        touch, half = -1j * self.factor, float(np.ptp(driven)) + 0.3 * size
        thick = touch / abs(touch) * 0.05 * size
        teeth = np.array([-half, half, half + thick, -half + thick])
        parts = [sliding_member("slide", teeth, touch + driven + 0j), wheel_member(abs(self.factor), 0.0, driver)]
        return LinkSketch(parts, [Support("pivot", 0.0)], Port(0.0), Port(touch, 1.0))

    def _sketch_lever(self, driver: FloatArray, driven: FloatArray, size: float) -> LinkSketch:
        """A lever between two slides side by side; its pivot is the fixed point on the line through both."""
        length, half = 0.5 * size, 0.03 * size
        ends = 1j * driver, length + 1j * driven
        block = half * np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j])
        still = length / (1.0 - self.factor) if self.factor != 1.0 else np.inf
        points, pivots = [(0.0, ends[0]), (length, ends[1])], list[Support]()
        if abs(still) < 4 * length:
            points.append((still, np.full(driver.size, complex(still))))
            pivots.append(Support("pivot", still))
        (_, left), *_, (_, right) = sorted(points, key=lambda point: point[0])
        blocks = [sliding_member("slide", block, end) for end in ends]
        return LinkSketch([*blocks, bar_member((left, right))], pivots, Port(0.0, 1j), Port(length, 1j))


LEAST_RATIO = 1e-9
"""Smallest magnitude of a ratio or radius: a smaller one leads to numbers that doubles cannot hold."""


def _ratio_links(keys: Keys, input_angular: bool) -> tuple[ConstantRatio]:
    if len(keys) != 1:
        raise AssemblyFault("it has either a ratio, or the radius of a pinion or drum (mm)")
    ((name, factor),) = keys.items()
    require_positive(
        abs(factor) - LEAST_RATIO, lambda: f"a {name} below {LEAST_RATIO:g} in size does not move the tool"
    )
    if name == "ratio":
        return (ConstantRatio(factor, (input_angular, input_angular)),)
    return (ConstantRatio(factor if input_angular else 1.0 / factor, (input_angular, not input_angular)),)


STAGE = StageKind(
    "ratio",
    "a constant ratio",
    (),
    ("ratio", "radius"),
    lambda keys, turns: turns != ("radius" in keys),
    _ratio_links,
)

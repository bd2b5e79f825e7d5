"""A link of constant ratio: its output is a factor times its input."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series
from camopt.model.trains.link import NO_COUPLERS, NO_DEAD_POINTS, DeadPoint, Force, unit_series
from camopt.model.trains.sketch import LinkSketch, Port, Support, bar, sliding_member, wheel


@dataclass(frozen=True)
class ConstantRatio:
    """Output = factor·input: gears, racks, belts, levers, wedges."""

    factor: Any
    turns: tuple[bool, bool]
    couplers = NO_COUPLERS

    @property
    def ends(self) -> tuple[DeadPoint, DeadPoint]:
        return NO_DEAD_POINTS

    def forward(self, driver: Series) -> Series:
        return driver * self.factor

    def backward(self, driven: Series) -> Series:
        return driven / self.factor

    def ratio(self, driver: Series) -> Series:
        return unit_series(driver) * self.factor

    @property
    def forces(self) -> tuple[Force, ...]:
        """The force on a pinion's teeth along the rack, or the forces at a lever's ends and pivot.

        Two wheels have none, because a ratio does not give their radii.
        """
        if self.turns == (True, True):
            return ()
        if self.turns != (False, False):
            along = 1.0 if self.turns[0] else self.factor
            return (Force("teeth", "joint", lambda driver: unit_series(driver) * along, touches=True),)
        ends = Force("input end", "joint", self.ratio), Force("output end", "joint", unit_series)
        return (*ends, Force("pivot", "pivot", lambda driver: unit_series(driver) * (1.0 - self.factor)))

    def sketch(self, driver: FloatArray, driven: FloatArray, size: float, *, back: bool = False) -> LinkSketch:
        """Wheels in mesh or with a belt, a pinion on its rack, or a lever between two slides."""
        if self.turns == (False, True):
            rack = ConstantRatio(1.0 / self.factor, (True, False))
            return rack.sketch(driven, driver, size, back=not back).reversed_sketch
        return {(True, True): self._sketch_wheels, (True, False): self._sketch_rack}.get(
            self.turns, self._sketch_lever
        )(driver, driven, size)

    def _sketch_wheels(self, driver: FloatArray, driven: FloatArray, size: float) -> LinkSketch:
        """Two wheels: in mesh if they turn opposite ways, with a belt if they turn the same way."""
        large, small = 0.3 * size, 0.3 * size * min(abs(self.factor), 1.0 / abs(self.factor))
        one, other = (large, small) if abs(self.factor) >= 1.0 else (small, large)
        away = one + other + (0.0 if self.factor < 0.0 else 0.3 * size)
        wheels = [wheel(one, 0.0, driver), wheel(other, away, driven)]
        if self.factor > 0.0:
            tilt = np.array([1j, -1j]) * np.exp(np.array([-1j, 1j]) * np.arcsin((one - other) / away))
            belt = [bar((wheels[0].at + one * side, wheels[1].at + other * side)) for side in tilt]
            wheels += [each._replace(shape="belt") for each in belt]
        return LinkSketch(wheels, [Support("pivot", 0.0), Support("pivot", away)], Port(0.0), Port(away))

    def _sketch_rack(self, driver: FloatArray, driven: FloatArray, size: float) -> LinkSketch:
        touch, half = -1j * self.factor, float(np.ptp(driven)) + 0.3 * size
        thick = touch / abs(touch) * 0.05 * size
        teeth = np.array([-half, half, half + thick, -half + thick])
        parts = [sliding_member("slide", teeth, touch + driven + 0j), wheel(abs(self.factor), 0.0, driver)]
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
        return LinkSketch([*blocks, bar((left, right))], pivots, Port(0.0, 1j), Port(length, 1j))

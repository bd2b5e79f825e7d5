"""A slide on an incline: a wedge that moves with what drives it, and lifts what is guided across.

    z = y·sin α/sin(γ + α)

with the incline at α to the motion that drives it, and the guide of what it lifts at γ to that motion; square to
it, γ = 90°, z = y·tan α.
"""

from cmath import rect
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.trains.constant_ratio import ConstantRatio
from camopt.model.trains.link import (
    RADIAN,
    AssemblyFault,
    Force,
    Keys,
    StageKind,
    require_positive,
    square_direction,
    unit_series,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, sliding_member


@dataclass(frozen=True)
class Wedge(ConstantRatio):
    """A wedge and what it lifts; rad."""

    incline: Any
    guide: Any
    pressed: Any
    """The force on its face for one along the guide, 1/sin(γ + α)."""
    wedge_thrust: Any
    """What the guide of the wedge takes then, cos α/sin(γ + α)."""
    slide_thrust: Any
    """And that of the slide, cos(γ + α)/sin(γ + α)."""

    @property
    def forces(self) -> tuple[Force, ...]:
        return (
            Force(
                "face",
                "joint",
                lambda given: unit_series(given) * self.pressed,
                touches=True,
                way=self._face_direction,
            ),
            Force(
                "guide of the wedge",
                "guide",
                lambda given: unit_series(given) * self.wedge_thrust,
                way=square_direction,
            ),
            Force(
                "guide of the slide",
                "guide",
                lambda given: unit_series(given) * self.slide_thrust,
                way=square_direction,
            ),
        )

    def _face_direction(self, given: FloatArray) -> FloatArray:
        """The normal of the face, from the guide of the slide."""
        return np.asarray(np.zeros_like(given) + (pi / 2 - self.incline - self.guide))

    def sketch(self, given: FloatArray, asked: FloatArray, size: float, *, back: bool = False) -> LinkSketch:
        """The wedge moves along, and a block on its incline moves along the guide."""
        along, lifted, half = rect(1.0, -self.incline), rect(1.0, self.guide), 0.03 * size
        travel = float(np.ptp(given))
        ends = [(-0.1 * size - 1.2 * travel) / abs(along.real), (0.1 * size + 1.2 * travel) / abs(along.real)]
        low = min((along * end).imag for end in ends) - 0.1 * size
        wedge = np.array([along * ends[0], along * ends[1], (along * ends[1]).real + 1j * low])
        wedge = np.append(wedge, (along * ends[0]).real + 1j * low)
        above = half * lifted
        block = half * np.array([-1, 1]) * along
        block = np.concatenate([block, block[::-1] + 8 * above])
        middle = (lifted * float(asked.min() + asked.max()) / 2) + 5 * above
        return LinkSketch(
            [sliding_member("wedge", wedge, given + 0j), sliding_member("slide", block, asked * lifted)],
            [Support("guide", middle, 0.06 * size * lifted)],
            Port(complex(wedge[0] + wedge[3]) / 2, 1.0),
            Port(8 * above, lifted),
        )


LEAST_INCLINE = 1e-9
"""An incline nearer to 0, in deg, lifts nothing that doubles hold."""


def _incline_links(keys: Keys, turns: bool) -> tuple[Wedge]:
    if turns:
        raise AssemblyFault("its wedge takes a length, and what comes to it is an angle")
    incline, guide = keys["angle"], keys.get("guide", 90.0)
    together = guide + incline
    margins = abs(incline) - LEAST_INCLINE, 90.0 - abs(incline), guide, 180.0 - guide, together, 180.0 - together
    why = "an incline of {:g} deg does not lift along a guide at {:g} deg: both are below 180 deg together, {}"
    for margin in margins:
        require_positive(margin, lambda: why.format(incline, guide, "and the incline is between 0 and ±90"))
    slope, across = incline * RADIAN, guide * RADIAN
    lifted, sine = np.sin(across + slope), np.sin(slope)
    shares = 1.0 / lifted, np.cos(slope) / lifted, np.cos(across + slope) / lifted
    return (Wedge(sine / lifted, (False, False), slope, across, *shares),)


STAGE = StageKind(
    "incline", "a slide on an incline", ("angle",), ("guide",), lambda keys, turns: False, _incline_links
)

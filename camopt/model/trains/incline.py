"""A slide on an incline: a wedge that is driven along a line lifts a slide in its guide.

    z = y·sin α/sin(γ + α)

The incline is at the angle α to the motion of the wedge, the guide of the slide at γ. With a guide square to the
motion, γ = 90°, z = y·tan α.
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
    constant_one_series,
    perpendicular_direction,
    require_positive,
)
from camopt.model.trains.sketch import LinkSketch, Port, Support, sliding_member


@dataclass(frozen=True)
class Wedge(ConstantRatio):
    """A wedge and its slide; angles in rad, forces for a force of 1 along the slide's guide."""

    incline: Any
    guide: Any
    face_force: Any
    """Force on the face, 1/sin(γ + α)."""
    wedge_thrust: Any
    """Force on the guide of the wedge, cos α/sin(γ + α)."""
    slide_thrust: Any
    """Force on the guide of the slide, cos(γ + α)/sin(γ + α)."""

    @property
    def joint_forces(self) -> tuple[Force, ...]:
        return (
            Force(
                "face",
                "joint",
                lambda driver: constant_one_series(driver) * self.face_force,
                touches=True,
                # the direction of the face's normal, from the slide's motion
                way=lambda driver: np.asarray(np.zeros_like(driver) + (pi / 2 - self.incline - self.guide)),
            ),
            Force(
                "guide of the wedge",
                "guide",
                lambda driver: constant_one_series(driver) * self.wedge_thrust,
                way=perpendicular_direction,
            ),
            Force(
                "guide of the slide",
                "guide",
                lambda driver: constant_one_series(driver) * self.slide_thrust,
                way=perpendicular_direction,
            ),
        )

    def sketch(
        self, driver: FloatArray, driven: FloatArray, size: float, *, driven_backwards: bool = False
    ) -> LinkSketch:
        """The wedge, and on its incline a block that moves along the guide."""
        along, lifted, half = rect(1.0, -self.incline), rect(1.0, self.guide), 0.03 * size
        travel = float(np.ptp(driver))
        ends = [(-0.1 * size - 1.2 * travel) / abs(along.real), (0.1 * size + 1.2 * travel) / abs(along.real)]
        low = min((along * end).imag for end in ends) - 0.1 * size
        wedge = np.array([along * ends[0], along * ends[1], (along * ends[1]).real + 1j * low])
        wedge = np.append(wedge, (along * ends[0]).real + 1j * low)
        above = half * lifted
        block = half * np.array([-1, 1]) * along
        block = np.concatenate([block, block[::-1] + 8 * above])
        middle = (lifted * float(driven.min() + driven.max()) / 2) + 5 * above
        return LinkSketch(
            [sliding_member("wedge", wedge, driver + 0j), sliding_member("slide", block, driven * lifted)],
            [Support("guide", middle, 0.06 * size * lifted)],
            Port(complex(wedge[0] + wedge[3]) / 2, 1.0),
            Port(8 * above, lifted),
        )


LEAST_INCLINE = 1e-9
"""Smallest incline [deg]: a smaller one lifts less than doubles resolve."""


def _incline_links(keys: Keys, input_angular: bool) -> tuple[Wedge]:
    if input_angular:
        raise AssemblyFault("it is driven by an angle, but its wedge needs a length")
    incline, guide = keys["angle"], keys.get("guide", 90.0)
    together = guide + incline
    margins = abs(incline) - LEAST_INCLINE, 90.0 - abs(incline), guide, 180.0 - guide, together, 180.0 - together
    why = "an incline of {:g} deg does not lift along a guide at {:g} deg: {}"
    allowed = "the incline must be between 0 and ±90 deg, and the guide and their sum between 0 and 180 deg"
    for margin in margins:
        require_positive(margin, lambda: why.format(incline, guide, allowed))
    slope, across = incline * RADIAN, guide * RADIAN
    lifted, sine = np.sin(across + slope), np.sin(slope)
    shares = 1.0 / lifted, np.cos(slope) / lifted, np.cos(across + slope) / lifted
    return (Wedge(sine / lifted, (False, False), slope, across, *shares),)


STAGE = StageKind(
    "incline", "a slide on an incline", ("angle",), ("guide",), lambda keys, turns: False, _incline_links
)

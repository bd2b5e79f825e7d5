"""The smallest cam with a pressure angle of at most 30°: the scene, and the same by a root of samples.

camopt is asked through its public functions, and the rival uses nothing of it.
"""

from collections.abc import Callable

import numpy as np
from rival_numpy import Array, turn_of
from scipy import optimize

from camopt import Scene, find_scene

ROLLER, LIMIT = 5.0, 30.0  # mm, deg
RADII, OFFSETS = (1.0, 300.0), (-40.0, 40.0)  # mm
ANGLES = 3600
Answer = tuple[float, float]
"""Base radius and lead, mm."""


def smallest_cam(law: str, offset: str) -> Scene:
    """The 1000 rpm scene with the pressure angle as its only limit and one law."""
    search = {
        "law": [law],
        **({"offset": dict(zip(("start", "stop"), OFFSETS, strict=True))} if offset == "free" else {}),
    }
    limits = {"pressure_angle": LIMIT, "pressure_angle_return": LIMIT}
    sizes = {"follower.offset": 0, "follower.roller_radius": ROLLER}
    return find_scene("roller-1000rpm").replace(**sizes, limits=limits, search=search)


def sampled_turn(law: str) -> tuple[Array, Array]:
    """y and y' at even cam angles of both strokes."""
    x = np.linspace(0.0, 1.0, ANGLES // 2)
    rows = [stroke.motion(x)[:2] for stroke in turn_of(law)]
    y, y1 = (np.concatenate(each) for each in zip(*rows, strict=True))
    return y, y1


def sampled_tangents(law: str) -> Callable[[float, float], Array]:
    """tan β over the turn as a function of base radius and lead."""
    y, y1 = sampled_turn(law)

    def tangents(radius: float, lead: float) -> Array:
        height = np.sqrt(max((radius + ROLLER) ** 2 - lead**2, 0.0))
        return (y1 - lead) / (height + y + 1e-12)

    return tangents


def by_brentq(law: str) -> Answer:
    """A root of the largest sampled pressure angle."""
    tangents, limit = sampled_tangents(law), np.tan(np.radians(LIMIT))
    return float(
        optimize.brentq(lambda radius: np.abs(tangents(radius, 0.0)).max() - limit, *RADII, xtol=1e-10)
    ), 0.0

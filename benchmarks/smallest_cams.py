"""The smallest radial cam with a pressure angle of at most 30°: the scene, and the same by a root of samples.

camopt is asked through its public functions, and the rival uses nothing of it.
"""

import numpy as np
from rival_numpy import turn_of
from scipy import optimize

from camopt import Scene, find_scene

ROLLER, LIMIT = 5.0, 30.0  # mm, deg
RADII = (1.0, 300.0)  # mm
ANGLES = 3600


def smallest_cam(law: str) -> Scene:
    """The 1000 rpm scene with the pressure angle as its only limit and one law."""
    limits = {"pressure_angle": LIMIT, "pressure_angle_return": LIMIT}
    sizes = {"follower.offset": 0, "follower.roller_radius": ROLLER}
    return find_scene("roller-1000rpm").replace(**sizes, limits=limits, search={"law": [law]})


def by_brentq(law: str) -> float:
    """The base radius [mm] at which the largest sampled pressure angle is the limit."""
    x = np.linspace(0.0, 1.0, ANGLES // 2)
    rows = [stroke.motion(x)[:2] for stroke in turn_of(law)]
    y, y1 = (np.concatenate(each) for each in zip(*rows, strict=True))
    limit = np.tan(np.radians(LIMIT))

    def excess(radius: float) -> float:
        return float(np.abs(y1 / (radius + ROLLER + y)).max() - limit)

    return float(optimize.brentq(excess, *RADII, xtol=1e-10))

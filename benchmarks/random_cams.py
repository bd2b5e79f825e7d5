"""Pressure angle and curvature of many random roller cams: the scene with its designs, and the same by numpy."""

import numpy as np
import pandas as pd
from rival_numpy import Cams, Extremes, polished

from camopt import Scene, find_scene

DESIGNS = 20_000
SAMPLES = 72  # the fewest, of those tried, by which numpy agrees to 1e-9 for each law
QUANTITIES = ("pressure_angle_max_deg", "pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm")


def random_cams(law: str, count: int = DESIGNS) -> tuple[Scene, pd.DataFrame]:
    """The 1000 rpm scene with one law, and random sizes of its cam [mm]."""
    rng = np.random.default_rng(20240611)
    ranges = {"base_radius_mm": (30, 150), "offset_mm": (-25, 25), "roller_radius_mm": (5, 20)}
    frame = pd.DataFrame({name: rng.uniform(*ends, count) for name, ends in ranges.items()})
    return find_scene("roller-1000rpm").replace(outputs=list(QUANTITIES)), frame.assign(law=law)


def by_numpy(law: str, frame: pd.DataFrame) -> Extremes:
    """The same by numpy; the cam turns clockwise: the lead is the offset with the other sign."""
    prime = (frame["base_radius_mm"] + frame["roller_radius_mm"]).to_numpy()
    return polished(Cams(prime, -frame["offset_mm"].to_numpy()), law, SAMPLES)

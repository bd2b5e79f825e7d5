"""Write measured/*.csv: two cams that are known in closed form, as they are measured.

    python tests/data/make_measured.py

inlet-lift.csv     the inlet lobe: cam angle, and lift of its flat tappet, each degree; errors of 2 µm
inlet-profile.csv  the same lobe: cam angle, and distance of the centre of a ball of 1.5 mm; errors of 2 µm
worn-cam.csv       the worn cam: x and y of the centre of a ball of 3 mm at 720 points, from an x-axis anywhere;
                   errors of 1.5 µm

The cams are those of tests/support/measured_cams.py.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from support.measured_cams import (  # noqa: E402
    along_the_profile,
    at_polar_angles,
    probe_centres,
    valve_lift,
    valve_profile,
    worn_profile,
    xy,
)

DEGREES = np.arange(360.0)
BALL, LARGER_BALL = 1.5, 3.0  # mm
TURNED = 0.6  # rad: the worn cam on its machine


def tables() -> dict[str, tuple[str, Any]]:
    """The heading and the rows of each file."""
    lift = valve_lift(np.radians(DEGREES))[0] + 0.002 * np.random.default_rng(1).normal(size=360)
    met = at_polar_angles(valve_profile, BALL, np.radians(DEGREES))
    distance = np.abs(probe_centres(valve_profile, met, BALL, 0.002, seed=2))
    worn = probe_centres(worn_profile, along_the_profile(worn_profile, 720), LARGER_BALL, 0.0015, seed=3)
    return {
        "inlet-lift.csv": ("angle_deg,lift_mm", np.column_stack([DEGREES, lift])),
        "inlet-profile.csv": ("angle_deg,radius_mm", np.column_stack([DEGREES, distance])),
        "worn-cam.csv": ("x_mm,y_mm", xy(worn * np.exp(1j * TURNED))),
    }


def main() -> None:
    for name, (heading, rows) in tables().items():
        lines = [heading, *(",".join(f"{value:.4f}" for value in row) for row in rows)]
        (HERE / "measured" / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

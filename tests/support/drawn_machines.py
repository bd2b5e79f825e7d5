"""Machines for tests of pictures: random phases and ratios, many stations, long names."""

import numpy as np

from camopt.scene.machine import Machine

SCENES = (
    *("two-pauses", "oscillating-roller", "feeder-with-stop", "slide-by-bell-crank", "belt-matching"),
    *("press-feed-by-pair", "barrel-traverse", "pusher-by-lever", "indexing-overlap", "tangent-cam"),
    *("face-groove-shutter", "valve-with-rocker"),
)
"""Discs, cylinders and pairs, with and without trains, strokes and moves."""
LONG = "gripper of the second transfer arm, which lays cartons onto the pallet"


def random_machine(count, seed=0, **more):
    """A machine with stations of different scenes at random phases and ratios; some names are long."""
    rng = np.random.default_rng(seed)
    stations = [
        {
            "name": f"{LONG} {number}" if number % 5 == 4 else f"station {number}",
            "scene": SCENES[number % len(SCENES)],
            "phase": round(float(rng.uniform(-400.0, 400.0)), 2),
            "ratio": int(rng.integers(1, 4)),
        }
        for number in range(count)
    ]
    return Machine(name="Random machine", station=stations, **more)

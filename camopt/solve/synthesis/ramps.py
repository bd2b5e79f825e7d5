"""Stretches of constant velocity in laws of the user, such as ramps of measured valve cams; free laws have none."""

from collections.abc import Iterator
from math import degrees

import numpy as np

from camopt.model.motion.stroke import Stroke
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene

RAMP_SAMPLES = 2000  # samples of a stroke
STEADY_SHARE = 0.02  # share of the largest acceleration and velocity that counts as zero
LEAST_RAMP_SHARE = 0.04
"""Least length of a ramp, as a share of the stroke.

A shorter stretch lies about a turning point of the velocity, as in a harmonic law (0.0125).
"""


def dropped_ramps_in_words(scene: Scene) -> Iterator[str]:
    """A sentence on each rise and return whose own law has a ramp, which a free law has not."""
    rows = {f"motion.{number}": row for number, row in enumerate(scene.motion, start=1)}
    for stroke in resolve(scene).programme.tool.strokes:
        row = rows.get(stroke.key)
        if stroke.is_law_replaceable and row and row.law in scene.laws:
            start, end = (degrees(angle) for angle in longest_constant_velocity_angles(stroke))
            if end - start > LEAST_RAMP_SHARE * degrees(stroke.angle):
                ramp = f"from {start:.3g} to {end:.3g} deg the law of {stroke.key} has a ramp of constant velocity"
                yield f"{ramp}, which a free law drops; to keep it, give it a constant-velocity segment"


def longest_constant_velocity_angles(stroke: Stroke) -> tuple[float, float]:
    """The longest stretch of a stroke without acceleration, as two cam angles [rad], from samples."""
    angles = np.linspace(stroke.start, stroke.end, RAMP_SAMPLES + 1)[1:-1]
    _, y1, y2, *_ = np.abs(stroke.motion(angles))
    steady = (y2 <= STEADY_SHARE * y2.max()) & (y1 > STEADY_SHARE * y1.max())
    changes = np.flatnonzero(np.diff(steady, prepend=False, append=False))
    starts, ends = changes[::2], changes[1::2] - 1
    if not starts.size:
        return stroke.start, stroke.start
    longest = int(np.argmax(ends - starts))
    return float(angles[starts[longest]]), float(angles[ends[longest]])

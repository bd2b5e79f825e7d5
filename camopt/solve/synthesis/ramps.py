"""Stretches at constant velocity within laws of the user, as ramps of measured valve cams: free laws know none."""

from collections.abc import Iterator
from math import degrees

import numpy as np

from camopt.model.motion.stroke import Stroke
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene

RAMP_SAMPLES = 2000  # cam angles of a stroke
STEADY_SHARE = 0.02  # of the largest acceleration, and of the largest velocity: less is none
LEAST_RAMP_SHARE = 0.04
"""Of a stroke: a shorter stretch is that about a turning point of the velocity, as of a harmonic law (0.0125)."""


def ramps_in_words(scene: Scene) -> Iterator[str]:
    """A sentence on each rise and return whose own law has constant velocity on the way: a free law has not."""
    rows = {f"motion.{number}": row for number, row in enumerate(scene.motion, start=1)}
    for stroke in resolve(scene).programme.tool.strokes:
        row = rows.get(stroke.key)
        if stroke.is_free and row and row.law in scene.laws:
            start, end = (degrees(each) for each in longest_steady_stretch(stroke))
            if end - start > LEAST_RAMP_SHARE * degrees(stroke.angle):
                where = (
                    f"from {start:.3g} to {end:.3g} deg the law of {stroke.key} has constant velocity, as a ramp"
                )
                yield f"{where}; a free law replaces it without the ramp; segments constant-velocity stay"


def longest_steady_stretch(stroke: Stroke) -> tuple[float, float]:
    """Between which cam angles, rad, it moves the longest without an acceleration, as far as samples tell."""
    angles = np.linspace(stroke.start, stroke.end, RAMP_SAMPLES + 1)[1:-1]
    _, y1, y2, *_ = np.abs(stroke.motion(angles))
    steady = (y2 <= STEADY_SHARE * y2.max()) & (y1 > STEADY_SHARE * y1.max())
    changes = np.flatnonzero(np.diff(steady, prepend=False, append=False))
    starts, ends = changes[::2], changes[1::2] - 1
    if not starts.size:
        return stroke.start, stroke.start
    longest = int(np.argmax(ends - starts))
    return float(angles[starts[longest]]), float(angles[ends[longest]])

"""Curvature of the curve that a trace point draws on the cam.

In the cam's frame the trace point moves with a speed N along a direction that makes the angle β with that of no
pressure: tan β = w/s and N² = w² + s², for a w and an s that each mechanism has. The direction turns by β', and
with the frame that it is measured in, so

    κ = (frame − β')/N,    β' = (w'·s − w·s')/N²

A sum of squares keeps N apart from zero, and its bounds close, wherever the formula runs: on numbers, arrays,
intervals and jets.
"""

import numpy as np

from camopt.kernels.compile import inlined


@inlined
def speed_change(w, w1, w2, s, s1, s2):
    """N' and N'' from w and s, and their derivatives by the cam angle."""
    speed = np.sqrt(np.square(w) + np.square(s))
    first = (w * w1 + s * s1) / speed
    second = (np.square(w1) + w * w2 + np.square(s1) + s * s2 - np.square(first)) / speed
    return first, second


@inlined
def trace_curvature(w, w1, w2, s, s1, s2, frame, frame1):
    """κ and κ' from w and s, the turning of the frame, and their derivatives by the cam angle."""
    square = np.square(w) + np.square(s)
    root = np.sqrt(square)
    turn = (w1 * s - w * s1) / square
    half = w * w1 + s * s1
    turn1 = (w2 * s - w * s2 - 2.0 * turn * half) / square
    curvature = (frame - turn) / root
    return curvature, (frame1 - turn1) / root - curvature * half / square

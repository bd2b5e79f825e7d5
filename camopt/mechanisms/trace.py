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
from camopt.numerics.trigonometry import turned


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


@inlined
def course_of_arm(f, i, at):
    """w and s of the trace point on an arm over a disc, each with two derivatives by the cam angle."""
    c, l = f.centre_distance[i], f.arm_length[i]  # noqa: E741
    cosine, sine = turned(f.cosine[i], f.sine[i], at.y)
    q, sense = 1.0 + f.sense[i] * at.y1, f.sense[i]
    w, s, along = sense * (l * q - c * cosine), c * sine, c * cosine
    w1, s1 = l * at.y2 + sense * s * at.y1, along * at.y1
    w2, s2 = l * at.y3 + sense * (s1 * at.y1 + s * at.y2), along * at.y2 - s * np.square(at.y1)
    return w, w1, w2, s, s1, s2


@inlined
def course_over_cylinder(f, i, at):
    """w and s of the trace point on an arm over a cylinder, each with two derivatives by the cam angle."""
    r, l, sense = f.mean_radius[i], f.arm_length[i], f.sense[i]  # noqa: E741
    cosine, sine = turned(f.cosine[i], f.sine[i], at.y)
    s, across = r * cosine, r * sine
    w = -(l * at.y1 + sense * across)
    w1, s1 = -(l * at.y2 + sense * s * at.y1), -(across * at.y1)
    w2, s2 = -(l * at.y3 + sense * (s1 * at.y1 + s * at.y2)), -(s * np.square(at.y1) + across * at.y2)
    return w, w1, w2, s, s1, s2

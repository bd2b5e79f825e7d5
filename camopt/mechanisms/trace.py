"""Curvature of the curve that a trace point draws on the cam.

In the cam's frame the trace point moves with a speed N along a direction that makes the angle β with that of no
pressure: tan β = w/s and N² = w² + s², for a w and an s that each mechanism has. The direction turns by β', and
with the frame that it is measured in, so

    κ = (frame − β')/N,    β' = (w'·s − w·s')/N²

A sum of squares keeps N apart from zero, and its bounds close, wherever the formula runs: on numbers, arrays,
intervals and jets.
"""

import numpy as np

from camopt.kernels.compile import overloaded
from camopt.numerics.trigonometry import turned


@overloaded
def speed_change(w, w1, s, s1):
    """N' from w and s, and their derivatives by the cam angle."""
    return (w * w1 + s * s1) / np.sqrt(np.square(w) + np.square(s))


@overloaded
def trace_curvature(w, w1, s, s1, frame):
    """κ from w and s, their derivatives by the cam angle, and the turning of the frame."""
    square = np.square(w) + np.square(s)
    return (frame - (w1 * s - w * s1) / square) / np.sqrt(square)


@overloaded
def course_of_arm(at, centre_distance, arm_length, cosine, sine, sense):
    """w and s of the trace point on an arm over a disc, each with its derivative by the cam angle."""
    cosine, sine = turned(cosine, sine, at.y)
    s, along = centre_distance * sine, centre_distance * cosine
    w = sense * (arm_length * (1.0 + sense * at.y1) - along)
    return w, arm_length * at.y2 + sense * s * at.y1, s, along * at.y1


@overloaded
def course_over_cylinder(at, mean_radius, arm_length, cosine, sine, sense):
    """w and s of the trace point on an arm over a cylinder, each with its derivative by the cam angle."""
    cosine, sine = turned(cosine, sine, at.y)
    s, across = mean_radius * cosine, mean_radius * sine
    w, w1 = -(arm_length * at.y1 + sense * across), -(arm_length * at.y2 + sense * s * at.y1)
    return w, w1, s, -(across * at.y1)

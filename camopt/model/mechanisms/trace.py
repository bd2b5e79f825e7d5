"""Curvature of the pitch curve, which the trace point draws on the cam.

In the cam's frame the trace point moves with the speed N. Its direction makes the pressure angle β with the
direction of no pressure: tan β = w/s and N² = w² + s², with a formula for w and s from each mechanism. The
direction turns with β and with the frame that β is measured in, so

    κ = (frame − β')/N,    β' = (w'·s − w·s')/N²

As a sum of squares N² has close bounds that exclude zero, on numbers, arrays, intervals and jets.
"""

from typing import Any

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels_by_overload
from camopt.core.numerics.dual import Dual
from camopt.core.numerics.trigonometry import cosine_and_sine_of_sum


@inline_in_kernels_by_overload
def tangential_acceleration(w, w1, s, s1):
    """N' from w, s and their derivatives by the cam angle."""
    return (w * w1 + s * s1) / np.sqrt(np.square(w) + np.square(s))


def pressure_rate_and_trace_speed(w: Any, w1: Any, s: Any, s1: Any) -> Any:
    """β' and N from w, s and their derivatives by the cam angle."""
    return (
        _dual_pressure_rate_and_trace_speed
        if type(w) is Dual and type(s1) is Dual
        else _pressure_rate_and_trace_speed
    )(w, w1, s, s1)


def _pressure_rate_and_trace_speed(w, w1, s, s1):
    square = np.square(w) + np.square(s)
    return (w1 * s - w * s1) / square, np.sqrt(square)


def _dual_pressure_rate_and_trace_speed(w, w1, s, s1):
    """In dual numbers, with fewer operations than the chain rule takes, which cannot use that w' is ``w1``."""
    square, half = np.square(w.value) + np.square(s.value), w.value * w1.value + s.value * s1.value
    turn, speed = (w1.value * s.value - w.value * s1.value) / square, np.sqrt(square)
    turn1 = (w1.slope * s.value - w.value * s1.slope - 2.0 * turn * half) / square
    return Dual(turn, turn1), Dual(speed, half / speed)


@chosen_by_type(pressure_rate_and_trace_speed)
def _compiled_pressure_rate_and_speed(w, w1, s, s1):
    return _dual_pressure_rate_and_trace_speed if w is Dual and s1 is Dual else _pressure_rate_and_trace_speed


@inline_in_kernels_by_overload
def trace_curvature(w, w1, s, s1, frame_turning_rate):
    """κ from w, s, their derivatives by the cam angle, and the rate at which the frame turns."""
    turn, speed = pressure_rate_and_trace_speed(w, w1, s, s1)
    return (frame_turning_rate - turn) / speed


@inline_in_kernels_by_overload
def disc_arm_velocity_components(at, centre_distance, arm_length, cosine, sine, sense):
    """w and s of an oscillating follower on a disc, each with its derivative by the cam angle."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, at.y)
    s, along = centre_distance * sine, centre_distance * cosine
    w = sense * (arm_length * (1.0 + sense * at.y1) - along)
    return w, arm_length * at.y2 + sense * s * at.y1, s, along * at.y1


@inline_in_kernels_by_overload
def cylinder_arm_velocity_components(at, mean_radius, arm_length, cosine, sine, sense):
    """w and s of an oscillating follower on a cylinder, each with its derivative by the cam angle."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, at.y)
    s, across = mean_radius * cosine, mean_radius * sine
    w, w1 = -(arm_length * at.y1 + sense * across), -(arm_length * at.y2 + sense * s * at.y1)
    return w, w1, s, -(across * at.y1)

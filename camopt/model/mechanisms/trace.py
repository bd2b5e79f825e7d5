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
from camopt.core.numerics import Number
from camopt.core.numerics.dual import Dual
from camopt.core.numerics.state import State
from camopt.core.numerics.trigonometry import cosine_and_sine_of_sum


@inline_in_kernels_by_overload
def tangential_acceleration(across, across_rate, along, along_rate):
    """N' from w, s and their derivatives by the cam angle."""
    return (across * across_rate + along * along_rate) / np.sqrt(np.square(across) + np.square(along))


def pressure_rate_and_trace_speed(across: Any, across_rate: Any, along: Any, along_rate: Any) -> Any:
    """β' and N from w, s and their derivatives by the cam angle."""
    return (
        _dual_pressure_rate_and_trace_speed
        if type(across) is Dual and type(along_rate) is Dual
        else _pressure_rate_and_trace_speed
    )(across, across_rate, along, along_rate)


def _pressure_rate_and_trace_speed(across, across_rate, along, along_rate):
    square = np.square(across) + np.square(along)
    return (across_rate * along - across * along_rate) / square, np.sqrt(square)


def _dual_pressure_rate_and_trace_speed(across, across_rate, along, along_rate):
    """In dual numbers: the chain rule takes more operations, since it cannot use that w' is ``across_rate``."""
    square, half = (
        np.square(across.value) + np.square(along.value),
        across.value * across_rate.value + along.value * along_rate.value,
    )
    turn, speed = (across_rate.value * along.value - across.value * along_rate.value) / square, np.sqrt(square)
    turn1 = (across_rate.slope * along.value - across.value * along_rate.slope - 2.0 * turn * half) / square
    return Dual(turn, turn1), Dual(speed, half / speed)


@chosen_by_type(pressure_rate_and_trace_speed)
def _compiled_pressure_rate_and_speed(across, across_rate, along, along_rate):
    return (
        _dual_pressure_rate_and_trace_speed
        if across is Dual and along_rate is Dual
        else _pressure_rate_and_trace_speed
    )


@inline_in_kernels_by_overload
def trace_curvature(across, across_rate, along, along_rate, frame_turning_rate):
    """κ from w, s, their derivatives by the cam angle, and the rate at which the frame turns."""
    turn, speed = pressure_rate_and_trace_speed(across, across_rate, along, along_rate)
    return (frame_turning_rate - turn) / speed


@inline_in_kernels_by_overload
def disc_arm_velocity_components(
    state: State, centre_distance: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """w and s of an oscillating follower on a disc, each with its derivative by the cam angle."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    s, along = centre_distance * sine, centre_distance * cosine
    w = sense * (arm_length * (1.0 + sense * state.y1) - along)
    return w, arm_length * state.y2 + sense * s * state.y1, s, along * state.y1


@inline_in_kernels_by_overload
def cylinder_arm_velocity_components(
    state: State, mean_radius: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """w and s of an oscillating follower on a cylinder, each with its derivative by the cam angle."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    s, across = mean_radius * cosine, mean_radius * sine
    w, w1 = -(arm_length * state.y1 + sense * across), -(arm_length * state.y2 + sense * s * state.y1)
    return w, w1, s, -(across * state.y1)

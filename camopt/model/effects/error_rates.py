"""Curves of the errors of velocity and acceleration within tolerances, to first order.

They are derivatives of the error of position. An error along the outward normal has the factor G = √(1 + T²) with
T = tan β, divided by the length of an arm; on a swinging face G = 1/t with the reach t (``effects.motion_errors``).
In the cam's frame the normal turns at the rate χ'. With derivatives by the cam angle, the errors are at most

    roller, face                  |G'|,                 |G''|
    profile within ±t, n waves    t·√(G'² + n²G²),      t·(|G''| + n·√(4G'² + n²G²))
    bore eccentric by ε           ε·√(G'² + G²χ'²),     ε·√((G'' − Gχ'²)² + (2G'χ' + Gχ'')²)

The row of the profile uses Bernstein's and Szegő's inequality (``effects.error_response``). On a cylinder the error
of the bore has the factor y', in two directions. The factors of the other errors are derivatives of T, of
sin ψ − T·cos ψ and of y'.

Sources: S. Bernstein, Sur l'ordre de la meilleure approximation des fonctions continues, 1912; R. Boas, Entire
Functions, ch. 11.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.marks import inline_in_kernels
from camopt.core.numerics import Curve, FloatArray
from camopt.core.numerics.curves import (
    cosine_and_sine_derivatives_of_sum,
    curve_derivatives,
    value_and_slope,
    value_and_slope_formula,
)
from camopt.model.effects.effect import Setup
from camopt.model.effects.effect_numbers import NO_BAND, ToleranceBands
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme

TINY_SQUARE = 1e-60
"""Smaller than any square that counts; it gives the root of two squares a slope where both are 0."""


@inline_in_kernels
def band_effect_and_slope(band_half_width, band_middle, response, response_slope):
    """half·|c| + middle·c with its slope."""
    return band_half_width * np.abs(response) + band_middle * response, (
        band_half_width * np.sign(response) + band_middle
    ) * response_slope


@inline_in_kernels
def hypotenuse_and_slope(a, a1, b, b1):
    """√(a² + b²) with its slope."""
    root = np.sqrt(np.square(a) + np.square(b) + TINY_SQUARE)
    return root, (a * a1 + b * b1) / root


@inline_in_kernels
def normal_error_rate_and_slope(curve, design, normal_response_derivatives, normal_angle_derivatives):
    """Errors along the normal with their slope, from G and χ' with their derivatives."""
    (g0, g1, g2, g3), (x1, x2, x3) = normal_response_derivatives, normal_angle_derivatives
    n = curve.waves[design]
    if curve.order == 1:
        waved, waved1 = hypotenuse_and_slope(g1, g2, n * g0, n * g1)
        turned, turned1 = hypotenuse_and_slope(g1, g2, g0 * x1, g1 * x1 + g0 * x2)
        other, other1 = band_effect_and_slope(curve.half[design], curve.middle[design], g1, g2)
    else:
        steep, steep1 = hypotenuse_and_slope(2.0 * g1, 2.0 * g2, n * g0, n * g1)
        waved, waved1 = np.abs(g2) + n * steep, np.sign(g2) * g3 + n * steep1
        square = np.square(x1)
        out, across = g2 - g0 * square, 2.0 * g1 * x1 + g0 * x2
        out1, across1 = g3 - g1 * square - 2.0 * g0 * x1 * x2, 2.0 * g2 * x1 + 3.0 * g1 * x2 + g0 * x3
        turned, turned1 = hypotenuse_and_slope(out, out1, across, across1)
        other, other1 = band_effect_and_slope(curve.half[design], curve.middle[design], g2, g3)
    value = curve.profile[design] * waved + curve.bore[design] * turned + other
    return value, curve.profile[design] * waved1 + curve.bore[design] * turned1 + other1


@inline_in_kernels
def phase_and_bore_error_rate_and_slope(curve, design, state):
    """Errors with the factor y', with their slope."""
    if curve.order == 1:
        ahead, ahead1 = band_effect_and_slope(curve.turning[design], curve.ahead[design], state.y2, state.y3)
        across, across1 = hypotenuse_and_slope(state.y2, state.y3, state.y1, state.y2)
    else:
        ahead, ahead1 = band_effect_and_slope(curve.turning[design], curve.ahead[design], state.y3, state.y4)
        across, across1 = hypotenuse_and_slope(
            state.y3 - state.y1, state.y4 - state.y2, 2.0 * state.y2, 2.0 * state.y3
        )
    return ahead + curve.around[design] * across, ahead1 + curve.around[design] * across1


@inline_in_kernels
def derivative_of_order_and_next(order, c1, c2, c3):
    """The derivative of an order and the next one."""
    return (c1, c2) if order == 1 else (c2, c3)


class NormalErrors(NamedTuple):
    """Errors along the normal for the velocity (order 1) or acceleration (2), in mm; over an arm's length in rad.

    In the cam's frame the normal turns at the rate χ' = 1 + swing·y' − way·β'.
    """

    order: int
    profile: FloatArray
    waves: FloatArray
    bore: FloatArray
    half: FloatArray
    middle: FloatArray


class MotionRates(NamedTuple):
    """Errors with the factor y': turning·|y''| + ahead·y'' and around·√(y''² + y'²), or their next derivatives."""

    order: int
    turning: FloatArray
    ahead: FloatArray
    around: FloatArray


class TraceErrorRates(NamedTuple):
    """Errors of a trace point: along the normal, of the motion, and half·|T'| + middle·T' of an offset or arm."""

    pressure: Any
    normal: NormalErrors
    motion: MotionRates
    swing: FloatArray
    way: FloatArray
    half: FloatArray
    middle: FloatArray


class ArmErrorRates(NamedTuple):
    """Errors of a trace point on an arm: with half·|g'| + middle·g' of the centre distance, g = sin ψ − T·cos ψ."""

    trace: TraceErrorRates
    cosine: FloatArray
    sine: FloatArray
    half: FloatArray
    middle: FloatArray


class FaceErrorRates(NamedTuple):
    """Errors of a translating face [mm]: ``steady``, and those of the motion, the tilt among them."""

    steady: FloatArray
    motion: MotionRates


class SwingingFaceErrorRates(NamedTuple):
    """Errors of a swinging face: along the normal, of the motion, and half·|h'| + middle·h' with h = sin ψ/t."""

    reach: Any
    normal: NormalErrors
    motion: MotionRates
    cosine: FloatArray
    sine: FloatArray
    sense: FloatArray
    half: FloatArray
    middle: FloatArray


@value_and_slope_formula(TraceErrorRates)
def trace_point_error_rate_and_slope(curve, design, state):
    t, t1, t2, t3 = curve_derivatives(curve.pressure, design, state)
    square = 1.0 + np.square(t)
    g0 = np.sqrt(square)
    b1 = t1 / square
    b2 = (t2 - 2.0 * t * t1 * b1) / square
    b3 = (t3 - 2.0 * b1 * (np.square(t1) + t * t2) - 4.0 * t * t1 * b2) / square
    g1 = t * t1 / g0
    g2 = (np.square(t1) + t * t2 - np.square(g1)) / g0
    g3 = (3.0 * t1 * t2 + t * t3 - 3.0 * g1 * g2) / g0
    swing, way = curve.swing[design], curve.way[design]
    chi = (1.0 + swing * state.y1 - way * b1, swing * state.y2 - way * b2, swing * state.y3 - way * b3)
    normal, normal1 = normal_error_rate_and_slope(curve.normal, design, (g0, g1, g2, g3), chi)
    motion, motion1 = phase_and_bore_error_rate_and_slope(curve.motion, design, state)
    c, c1 = derivative_of_order_and_next(curve.normal.order, t1, t2, t3)
    along, along1 = band_effect_and_slope(curve.half[design], curve.middle[design], c, c1)
    return normal + motion + along, normal1 + motion1 + along1


@value_and_slope_formula(ArmErrorRates)
def arm_error_rate_and_slope(curve, design, state):
    value, slope = value_and_slope(curve.trace, design, state)
    t, t1, t2, t3 = curve_derivatives(curve.trace.pressure, design, state)
    (c, c1, c2, c3), (_, s1, s2, s3) = cosine_and_sine_derivatives_of_sum(
        curve.cosine[design], curve.sine[design], state
    )
    g1, g2 = s1 - t1 * c - t * c1, s2 - t2 * c - 2.0 * t1 * c1 - t * c2
    g3 = s3 - t3 * c - 3.0 * t2 * c1 - 3.0 * t1 * c2 - t * c3
    g, next_ = derivative_of_order_and_next(curve.trace.normal.order, g1, g2, g3)
    error, error1 = band_effect_and_slope(curve.half[design], curve.middle[design], g, next_)
    return value + error, slope + error1


@value_and_slope_formula(FaceErrorRates)
def face_error_rate_and_slope(curve, design, state):
    value, slope = phase_and_bore_error_rate_and_slope(curve.motion, design, state)
    return curve.steady[design] + value, slope


@value_and_slope_formula(SwingingFaceErrorRates)
def swinging_face_error_rate_and_slope(curve, design, state):
    t, t1, t2, t3 = curve_derivatives(curve.reach, design, state)
    g0 = 1.0 / t
    g1 = -g0 * t1 / t
    g2 = -(2.0 * g1 * t1 + g0 * t2) / t
    g3 = -(3.0 * g2 * t1 + 3.0 * g1 * t2 + g0 * t3) / t
    sense = curve.sense[design]
    chi = (1.0 + sense * state.y1, sense * state.y2, sense * state.y3)
    normal, normal1 = normal_error_rate_and_slope(curve.normal, design, (g0, g1, g2, g3), chi)
    motion, motion1 = phase_and_bore_error_rate_and_slope(curve.motion, design, state)
    _, (s, s1, s2, s3) = cosine_and_sine_derivatives_of_sum(curve.cosine[design], curve.sine[design], state)
    h1, h2 = s1 * g0 + s * g1, s2 * g0 + 2.0 * s1 * g1 + s * g2
    h3 = s3 * g0 + 3.0 * s2 * g1 + 3.0 * s1 * g2 + s * g3
    h, next_ = derivative_of_order_and_next(curve.normal.order, h1, h2, h3)
    error, error1 = band_effect_and_slope(curve.half[design], curve.middle[design], h, next_)
    return normal + motion + error, normal1 + motion1 + error1


def worst_error_rate_curve(
    setup: Setup,
    bands: ToleranceBands,
    derivative_order: int,
    error_sign: float,
    designs: Designs,
    programme: Programme,
) -> Curve:
    """Curve of the worst error of velocity (1) or acceleration (2) to one side, +1 or −1 [mm or rad per radⁿ]."""
    mechanism, zeros = setup.mechanism, np.zeros(len(designs))
    sizes = {field: bands.sizes.get(field, NO_BAND) for field in mechanism.sizes}
    face = mechanism.flat_faced and not setup.angular
    turning, ahead = bands.phase.half_range, error_sign * bands.phase.middle
    if face:
        turning, ahead = turning + bands.tilt.half_range, ahead - error_sign * designs.sense * bands.tilt.middle
    developed, waves = mechanism.body.developed, float(bands.waves or 0)
    around = bands.bore / designs.size if developed else zeros
    motion = MotionRates(derivative_order, zeros + turning, zeros + ahead, zeros + around)
    if face:
        return FaceErrorRates(zeros + bands.profile * waves**derivative_order + bands.bore, motion)
    pressure, length_of = mechanism.pressure(designs, programme), designs.arm_length if setup.angular else 1.0
    swinging, bore = mechanism.flat_faced, 0.0 if developed else bands.bore
    body = sizes["face_offset"] if swinging else sizes.get("roller_radius", NO_BAND)
    scale, sign = (1.0, -error_sign) if swinging else (length_of, error_sign)
    normal = NormalErrors(
        derivative_order,
        zeros + bands.profile / scale,
        zeros + waves,
        zeros + bore / scale,
        zeros + body.half_range / scale,
        zeros + sign * body.middle / scale,
    )
    sense = np.full(len(designs), designs.sense)
    if mechanism.reach:
        reach, centre = mechanism.reach(designs, programme), sizes["centre_distance"]
        half, middle = zeros + centre.half_range, zeros - error_sign * centre.middle
        return SwingingFaceErrorRates(reach, normal, motion, pressure.cosine, pressure.sine, sense, half, middle)
    longer = sizes.get("arm_length", sizes.get("offset", NO_BAND))
    lean = designs.sense if not setup.angular else -designs.sense if developed else -1.0
    swing, way = (sense, sense) if setup.angular else (zeros, zeros + 1.0)
    half, middle = zeros + longer.half_range / length_of, zeros + error_sign * lean * longer.middle / length_of
    trace = TraceErrorRates(pressure, normal, motion, swing, way, half, middle)
    if "centre_distance" not in sizes:
        return trace
    centre = sizes["centre_distance"]
    half, middle = zeros + centre.half_range / length_of, zeros - error_sign * centre.middle / length_of
    return ArmErrorRates(trace, pressure.cosine, pressure.sine, half, middle)

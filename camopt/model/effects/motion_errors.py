"""Errors of the motion within the tolerances of a scene, to first order: the largest over the turn, and in dwells.

A small error moves the follower by δ = (|N|·δn − N·δq)/(N·u). N is the outward normal at the contact, and u the
direction in which the trace point moves with the follower. δn is an error along the normal, δq an error of the
trace point. With the tangent T = tan β of the pressure angle, a unit error moves the follower by

    roller, profile, bore of a disc:  √(1 + T²)      offset, arm:  ± T      centre distance:  sin ψ − T·cos ψ

divided by the length l of an arm. For a translating flat face the factor is 1, for its tilt the distance of the
contact from the stem. For a swinging face it is 1/t with the reach t, for its centre distance sin ψ/t. For the
phase, and for a cylinder's bore over R_m, it is y'. In the worst case all errors are at those ends of their zones
that move the follower in the same direction, −1 or +1.

In a dwell the follower moves only by waves of the profile, and by the bore, which turns with the cam.

Source: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7), varied.
"""

from collections.abc import Mapping
from functools import partial
from math import inf, pi, sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, Curve, FloatArray
from camopt.core.numerics.curves import curve_value, value_and_slope, value_and_slope_formula
from camopt.core.numerics.trigonometry import cosine_and_sine_of_sum
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.effect_numbers import NO_BAND, ToleranceBands
from camopt.model.effects.error_extremes import largest_dwell_position_changes, largest_tool_errors
from camopt.model.effects.error_rates import worst_error_rate_curve
from camopt.model.effects.motion import motion_error_quantity_names, motion_unit_factor, motion_unit_scale
from camopt.model.effects.peak import DegreeScale, MultipleScale, Peak, PerDesignFactorScale, Scale
from camopt.model.effects.peak_columns import peak_column
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import LEAST_JUMP, Programme
from camopt.model.motion.stroke import ALL_STROKES

TOLERANCE_KEYS, WAVE_KEYS = ("tolerances",), ("tolerances.waves",)
"""Missing keys of a scene: without tolerances, and for the slope of the profile."""


class TraceError(NamedTuple):
    """Error with a trace point, out·√(1 + T²) + along·|T| + leaning·T + turning·|y'| + ahead·y' [mm or rad]."""

    pressure: Any
    out: FloatArray
    along: FloatArray
    leaning: FloatArray
    turning: FloatArray
    ahead: FloatArray


class ArmError(NamedTuple):
    """Error of a trace point on an arm, ``trace`` and across·|g| + nearer·g with g = sin ψ − T·cos ψ [rad]."""

    trace: TraceError
    cosine: FloatArray
    sine: FloatArray
    across: FloatArray
    nearer: FloatArray


class FaceError(NamedTuple):
    """Error of a translating face, out + turning·|y'| + ahead·y' + tilting·|x| + leaning·x, x = ±y' − e [mm]."""

    offset: FloatArray
    sense: FloatArray
    out: FloatArray
    turning: FloatArray
    ahead: FloatArray
    tilting: FloatArray
    leaning: FloatArray


class SwingingFaceError(NamedTuple):
    """Error of a swinging face, (out + across·|sin ψ| + nearer·sin ψ)/t + turning·|y'| + ahead·y' [rad]."""

    reach: Any
    cosine: FloatArray
    sine: FloatArray
    out: FloatArray
    across: FloatArray
    nearer: FloatArray
    turning: FloatArray
    ahead: FloatArray


@value_and_slope_formula(TraceError)
def trace_point_error_and_slope(curve, design, state):
    t, t1 = value_and_slope(curve.pressure, design, state)
    root = np.sqrt(1.0 + np.square(t))
    value = curve.out[design] * root + curve.along[design] * np.abs(t) + curve.leaning[design] * t
    value = value + curve.turning[design] * np.abs(state.y1) + curve.ahead[design] * state.y1
    slope = (curve.out[design] * t / root + curve.along[design] * np.sign(t) + curve.leaning[design]) * t1
    return value, slope + (curve.turning[design] * np.sign(state.y1) + curve.ahead[design]) * state.y2


@value_and_slope_formula(ArmError)
def arm_error_and_slope(curve, design, state):
    value, slope = value_and_slope(curve.trace, design, state)
    t, t1 = value_and_slope(curve.trace.pressure, design, state)
    cosine, sine = cosine_and_sine_of_sum(curve.cosine[design], curve.sine[design], state.y)
    g, g1 = sine - t * cosine, (cosine + t * sine) * state.y1 - t1 * cosine
    value = value + curve.across[design] * np.abs(g) + curve.nearer[design] * g
    return value, slope + (curve.across[design] * np.sign(g) + curve.nearer[design]) * g1


@value_and_slope_formula(FaceError)
def face_error_and_slope(curve, design, state):
    x, x1 = curve.sense[design] * state.y1 - curve.offset[design], curve.sense[design] * state.y2
    value = curve.out[design] + curve.turning[design] * np.abs(state.y1) + curve.ahead[design] * state.y1
    value = value + curve.tilting[design] * np.abs(x) + curve.leaning[design] * x
    slope = (curve.turning[design] * np.sign(state.y1) + curve.ahead[design]) * state.y2
    return value, slope + (curve.tilting[design] * np.sign(x) + curve.leaning[design]) * x1


@value_and_slope_formula(SwingingFaceError)
def swinging_face_error_and_slope(curve, design, state):
    t, t1 = value_and_slope(curve.reach, design, state)
    cosine, sine = cosine_and_sine_of_sum(curve.cosine[design], curve.sine[design], state.y)
    along = curve.out[design] + curve.across[design] * np.abs(sine) + curve.nearer[design] * sine
    along1 = (curve.across[design] * np.sign(sine) + curve.nearer[design]) * cosine * state.y1
    value = along / t + curve.turning[design] * np.abs(state.y1) + curve.ahead[design] * state.y1
    return value, (along1 - along * t1 / t) / t + (
        curve.turning[design] * np.sign(state.y1) + curve.ahead[design]
    ) * state.y2


def worst_error_curve(
    setup: Setup, bands: ToleranceBands, error_sign: float, designs: Designs, programme: Programme
) -> Curve:
    """Curve of the follower's worst error to one side, +1 or −1 [mm or rad]."""
    mechanism, zeros = setup.mechanism, np.zeros(len(designs))
    sizes = {field: bands.sizes.get(field, NO_BAND) for field in mechanism.sizes}
    out = zeros + (bands.profile + sizes.get("roller_radius", NO_BAND).largest_error_to_side(error_sign))
    turning, ahead = zeros + bands.phase.half_range, zeros + error_sign * bands.phase.middle
    if mechanism.body.developed:
        turning = turning + bands.bore / designs.size
    else:
        out = out + bands.bore
    if mechanism.flat_faced and not setup.angular:
        tilting, leaning = zeros + bands.tilt.half_range, zeros - error_sign * bands.tilt.middle
        sense = np.full(len(designs), designs.sense)
        return FaceError(zeros + designs.offset, sense, out, turning, ahead, tilting, leaning)
    pressure = mechanism.pressure(designs, programme)
    if mechanism.reach:
        out, centre = out + sizes["face_offset"].largest_error_to_side(-error_sign), sizes["centre_distance"]
        across, nearer = zeros + centre.half_range, zeros - error_sign * centre.middle
        reach = mechanism.reach(designs, programme)
        return SwingingFaceError(reach, pressure.cosine, pressure.sine, out, across, nearer, turning, ahead)
    length = designs.arm_length if setup.angular else 1.0
    longer = sizes.get("arm_length", sizes.get("offset", NO_BAND))
    way = designs.sense if not setup.angular else -designs.sense if mechanism.body.developed else -1.0
    along, leaning = (zeros + longer.half_range) / length, (zeros + error_sign * way * longer.middle) / length
    trace = TraceError(pressure, out / length, along, leaning, turning, ahead)
    if "centre_distance" not in sizes:
        return trace
    centre = sizes["centre_distance"]
    across, nearer = (zeros + centre.half_range) / length, (zeros - error_sign * centre.middle) / length
    return ArmError(trace, pressure.cosine, pressure.sine, across, nearer)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    bands, names = setup.errors, motion_error_quantity_names(setup)
    if bands is None:
        return dict.fromkeys(names, TOLERANCE_KEYS)
    return dict.fromkeys(names[1:3], WAVE_KEYS) if bands.profile and bands.waves is None else {}


def _sole_contact_train_ratio(setup: Setup) -> float | None:
    """The constant ratio of a train that one contact drives; 1 without a train.

    None if there is no curve of the errors (``effects.error_extremes``): with two contacts, with another train, or
    with tolerances in the train.
    """
    if setup.mechanism.further_contacts:
        return None
    if setup.errors is not None and setup.errors.links:
        return None
    return 1.0 if setup.train is None else setup.train.constant_ratio


def peaks(setup: Setup) -> Mapping[str, Peak]:
    bands, ratio = setup.errors, _sole_contact_train_ratio(setup)
    if bands is None or ratio is None:
        return {}
    factor = abs(ratio)
    scale: Scale = DegreeScale(1, factor) if setup.tool_turns else MultipleScale(factor)
    asymmetric = any(band.middle for band in (*bands.sizes.values(), bands.phase, bands.tilt))
    sides = (1.0, -1.0) if asymmetric else (1.0,)
    curves = tuple((partial(worst_error_curve, setup, bands, side), ALL_STROKES) for side in sides)
    names = motion_error_quantity_names(setup)
    errors = {names[0]: Peak(curves, LARGEST, scale)}
    for order in (1, 2) if bands.waves or not bands.profile else ():
        rates = tuple((partial(worst_error_rate_curve, setup, bands, order, side), ALL_STROKES) for side in sides)
        unit = motion_unit_scale(setup, order)
        unit = unit if factor == 1.0 else PerDesignFactorScale(unit, lambda designs: factor)
        errors[names[order]] = Peak(rates, LARGEST, unit, partial(_jumps_make_error_infinite, setup, bands, order))
    return errors


def _jumps_make_error_infinite(setup: Setup, bands: ToleranceBands, order: int, programme: Programme) -> bool:
    """Whether a jump of the motion makes an error of velocity (1) or acceleration (2) infinite, in every design.

    Every jump that changes the normal does. If the pressure angle is 0 there, errors along the normal have the
    factor √(1 + T²), whose slope does not jump.
    """
    if setup.mechanism.flat_faced and not setup.angular and bands.phase == NO_BAND and bands.tilt == NO_BAND:
        return False
    along = bands.is_square and not bands.bore and bands.phase == NO_BAND
    jumps = [jump for jump in programme.jumps if jump.order <= order]
    if along and bands.sizes.keys() <= {"roller_radius"} and order == 2 and not programme.corners:
        speeds = programme.motion_at(np.array([jump.at for jump in jumps]))[1] if jumps else np.empty(0)
        return bool(np.any(np.abs(speeds) > LEAST_JUMP * programme.table.most[:, 1].max()))
    return bool(jumps)


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    *rates, dwell = motion_error_quantity_names(case.setup)
    orders = {name: order for order, name in enumerate(rates) if name in wanted_quantities}
    ratio, columns = _sole_contact_train_ratio(case.setup), dict[str, Any]()
    if ratio is not None:
        curves = peaks(case.setup)
        columns |= {name: peak_column(case, curves[name]) for name in orders}
    elif orders:  # there is no curve of the errors: they are sampled at cam angles
        for (name, order), error in zip(orders.items(), largest_tool_errors(case, [*orders.values()]), strict=True):
            columns[name] = motion_unit_factor(case.setup_per_design, order) * error
    if dwell in wanted_quantities:
        columns[dwell] = (
            motion_unit_factor(case.setup, 0) * largest_dwell_position_changes(case)
            if ratio is None
            else _dwell_position_changes_of_sole_contact(case, ratio)
        )
    return columns


def _dwell_position_changes_of_sole_contact(case: EvaluationBlock, train_ratio: float) -> FloatArray:
    """Largest change of the position in a dwell [mm or deg]."""
    setup, bands = case.setup, case.setup.errors
    assert bands is not None
    unit_profile = ToleranceBands({}, profile=1.0)
    changes = [np.zeros(len(case.designs))]
    for stroke in case.programme.tool.dwells:
        at = case.programme.state(np.array([stroke.start + 0.5 * stroke.angle]))
        response = curve_value(
            worst_error_curve(setup, unit_profile, 1.0, case.designs, case.programme), slice(None), at
        )
        waves = 2.0 * bands.profile * sin(min(0.5 * stroke.angle * (bands.waves or inf), 0.5 * pi))
        bore = 2.0 * bands.bore * sin(min(0.5 * stroke.angle, 0.5 * pi))
        changes.append(response * (waves + (0.0 if setup.mechanism.body.developed else bore)))
    unit = np.degrees(1.0) if setup.tool_turns else 1.0
    return np.asarray(abs(train_ratio) * unit * np.max(changes, axis=0))


EFFECT = Effect(
    "motion_errors",
    lambda setup: motion_error_quantity_names(setup),  # of this module: the reference finds it by this function
    evaluate_columns,
    missing_keys_by_quantity=missing_keys_by_quantity,
    peaks=peaks,
    holds_between_speeds=True,
)

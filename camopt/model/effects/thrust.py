"""Normal force, side thrust, and the loads of guide and stem of the follower.

    N = F/(cos β − sgn(F·y')·μ·q·|sin β|),  q = (2a + b)/b,    S = N·sin β
    guide reaction S·(a + b)/b,    bending stress of the stem 32·S·a/(π·d³),    jams where μ·q·|tan β| = 1

The guide has the length b; the overhang a = a₀ − y is the distance from the trace point to the near end of the
guide. Both ends of the guide bear on the stem, together with S·(a + b)/b + S·a/b = q·S. Their friction acts against
the motion, by the sign of y'; at rest it is taken as 0. Where F < 0 an open cam has lost contact, and there is no
load. The follower may jam while it is driven outward, in a groove inward too. Without a guide there is no friction.
An oscillating follower has S along its arm, and no guide.

Source: Rothbart, Cam Design Handbook, ch. 6; Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from collections.abc import Callable
from functools import partial
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, Curve
from camopt.model.effects import force
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup, multiple_scale
from camopt.model.effects.effect_numbers import FollowerDynamics
from camopt.model.effects.loads import (
    curve_variants_by_friction,
    force_along_motion_curve,
    guide_friction_line_coefficients,
    has_guide_friction,
    jamming_ratio_curve,
    jamming_stroke_kinds,
    normal_force_curve,
    side_thrust_times_lever,
)
from camopt.model.effects.peak import (
    OneMinusScale,
    Peak,
    Scale,
    is_infinite_by_velocity_jumps,
    unit_weight,
)
from camopt.model.effects.peak_columns import peak_column
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme

GUIDE = ("guide_length", "overhang")
THRUST_NEEDS = {  # keys of [follower.dynamics] besides those of a force
    "guide_reaction_max_N": GUIDE,
    "stem_bending_stress_max_MPa": ("stem_diameter", "overhang"),
}
JAMMING = ("jamming_margin", "jamming_angle_deg")


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    if setup.mechanism.flat_faced:
        return ("normal_force_max_N",)
    names = ("normal_force_max_N", "side_thrust_max_N")
    return names if setup.angular or setup.mechanism.further_contacts else (*names, *THRUST_NEEDS, *JAMMING)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    missing, loads = {}, force.missing_force_keys(setup)
    for name in applicable_quantities(setup):
        keys = ("friction", *GUIDE) if name in JAMMING else THRUST_NEEDS.get(name, ())
        if absent := (*_missing_dynamics_keys(setup, keys), *(() if name in JAMMING else loads)):
            missing[name] = absent
    return missing


def _missing_dynamics_keys(setup: Setup, keys: tuple[str, ...]) -> tuple[str, ...]:
    """Those of some keys of ``[follower.dynamics]`` that the scene lacks; an overhang may be 0."""
    values = {key: getattr(setup.dynamics, key) for key in keys}
    return tuple(
        f"follower.dynamics.{key}"
        for key, value in values.items()
        if (value is None if key == "overhang" else not value)
    )


def side_thrust_curve(
    setup: Setup, designs: Designs, programme: Programme, velocity_sign: float, *, quantity_name: str
) -> Curve:
    """Curve of S·(arm + reach·y) for a quantity of side thrust, while the follower moves in one direction."""
    ones, pressure = np.ones(len(designs)), setup.mechanism.pressure(designs, programme)
    arm, reach, _ = LEVERS[quantity_name](setup.with_design_numbers(designs).dynamics)
    return side_thrust_times_lever(
        force_along_motion_curve(setup, designs, programme, velocity_sign), pressure, arm * ones, reach * ones
    )


def peaks(setup: Setup) -> dict[str, Peak]:
    normal = curve_variants_by_friction(normal_force_curve, setup)
    goal = LARGEST_MAGNITUDE if setup.mechanism.can_pull_follower else LARGEST
    loads = {"normal_force_max_N": Peak(normal, goal, jumps=is_infinite_by_velocity_jumps)}
    if has_guide_friction(setup):
        drag = ((partial(jamming_ratio_curve, setup), jamming_stroke_kinds(setup)),)
        loads["jamming_margin"] = Peak(drag, LARGEST_MAGNITUDE, OneMinusScale(), unit=unit_weight)
    for name in LEVERS if setup.mechanism.curvature else ():
        if _missing_dynamics_keys(setup, THRUST_NEEDS.get(name, ())):
            continue
        curves = curve_variants_by_friction(partial(side_thrust_curve, quantity_name=name), setup)
        loads[name] = Peak(curves, LARGEST_MAGNITUDE, _thrust_scale(setup, name), is_infinite_by_velocity_jumps)
    return loads


def _thrust_scale(setup: Setup, quantity_name: str) -> Scale:
    """The scale from S·(arm + reach·y) to a quantity of side thrust."""
    return multiple_scale(setup, lambda numbers: LEVERS[quantity_name](numbers.dynamics)[2])


def evaluate_pitch_curve_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    setup, known, sound = case.setup, peaks(case.setup), True
    columns: dict[str, Any] = {}
    if has_guide_friction(setup):
        margin = columns["jamming_margin"] = peak_column(case, known["jamming_margin"])
        count = len(case.designs) if case.designs.numbers else 1
        drag, _ = guide_friction_line_coefficients(case.setup_per_design.dynamics, count, 1.0)
        angle = np.degrees(np.arctan2(1.0, drag))
        columns["jamming_angle_deg"] = angle if case.designs.numbers else float(angle[0])
        sound = margin.value + margin.outward > 0.0
    loads = wanted_quantities & known.keys() - {"jamming_margin"}
    return columns | {name: peak_column(case, known[name], sound) for name in loads}


LEVERS: dict[str, Callable[[FollowerDynamics], tuple[Any, Any, Any]]] = {
    "side_thrust_max_N": lambda dynamics: (1.0, 0.0, 1.0),
    "guide_reaction_max_N": lambda dynamics: (
        1.0 + dynamics.overhang / dynamics.guide_length,
        -1.0 / dynamics.guide_length,
        1.0,
    ),
    "stem_bending_stress_max_MPa": lambda dynamics: (
        dynamics.overhang,
        -1.0,
        32.0 / (pi * dynamics.stem_diameter**3),
    ),
}
"""The factors of side thrust in each quantity: arm and reach of the line arm + reach·y, and a number."""


EFFECT = Effect(
    "thrust",
    applicable_quantities,
    missing_keys_by_quantity=missing_keys_by_quantity,
    evaluate_pitch_curve_columns=evaluate_pitch_curve_columns,
    peaks=peaks,
    is_per_contact=True,
)

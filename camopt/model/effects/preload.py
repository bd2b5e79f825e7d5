"""Preload of two contacts that are mounted with an interference δ₀, with the stiffness k between them.

At rest each contact has the force P = k·δ₀. Two equally stiff contacts share a force F along the motion as long as
both touch; then one bears it alone:

    F₁ = max(F, P + F/2, 0) = F/2 + max(|F|/2, P),    F₂ = F₁ − F

No contact is lost up to |F| = 2·P. So the required preload is max |F|/2, and the required interference is that
divided by k. The preload ratio is 2·P/max |F|; below 1 a contact is lost. The torque of the camshaft depends on F
only, and not on the preload. With an oscillating follower P and F are moments, k is a moment per angle δ₀, and
forces are those at the rollers.

Source: the joint of two preloaded springs, such as a bolted joint: Shigley, Mechanical Engineering Design, ch. 8.
"""

from functools import partial
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.model.effects import force
from camopt.model.effects.effect import (
    Effect,
    EvaluationBlock,
    Setup,
    multiple_scale,
    scale_per_design_if_varied,
)
from camopt.model.effects.force import follower_force_curve
from camopt.model.effects.peak import (
    InverseScale,
    MultipleScale,
    Peak,
    is_infinite_by_velocity_jumps,
)
from camopt.model.effects.peak_columns import peak_column
from camopt.model.motion.stroke import ALL_STROKES

INTERFERENCE_KEY, STIFFNESS_KEY = "drive.interference", "drive.stiffness"
PRELOAD_RATIO = "pair_preload_ratio"


def preload_quantity_names(setup: Setup) -> tuple[str, str, str, str]:
    """Names of the preload, the required preload, the required interference and the preload ratio."""
    unit = "N_m" if setup.angular else "N"
    angle = "deg" if setup.angular else "mm"
    return f"pair_preload_{unit}", f"pair_preload_required_{unit}", f"interference_required_{angle}", PRELOAD_RATIO


def first_contact_force(force: float, preload: float) -> float:
    """Force on one of two preloaded contacts, F₁, from the force along the motion."""
    return force / 2.0 + max(abs(force) / 2.0, preload)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    if not setup.mechanism.further_contacts:
        return {}
    numbers, missing = setup.given, force.missing_force_keys(setup)
    interference, stiffness = ((key,) if numbers[key] is None else () for key in (INTERFERENCE_KEY, STIFFNESS_KEY))
    preloaded = numbers[INTERFERENCE_KEY] and setup.dynamics.pair_preload != 0.0  # the smallest numbers round to 0
    positive = () if preloaded else (INTERFERENCE_KEY,)
    needs = (interference + stiffness, missing, missing + stiffness, missing + positive + stiffness)
    return {name: keys for name, keys in zip(preload_quantity_names(setup), needs, strict=True) if keys}


def peaks(setup: Setup) -> dict[str, Peak]:
    if not setup.mechanism.further_contacts or setup.omega is None:
        return {}
    _, least, interference, _ = preload_quantity_names(setup)
    unit, angle = (1e-3, 180.0 / pi) if setup.angular else (1.0, 1.0)
    curves = ((partial(follower_force_curve, setup), ALL_STROKES),)
    loads = {least: Peak(curves, LARGEST_MAGNITUDE, MultipleScale(0.5 * unit), is_infinite_by_velocity_jumps)}
    if setup.given[STIFFNESS_KEY]:
        scale = multiple_scale(setup, lambda each: 0.5 * angle / each.dynamics.pair_stiffness)
        loads[interference] = Peak(curves, LARGEST_MAGNITUDE, scale, is_infinite_by_velocity_jumps)
    if preload := setup.dynamics.pair_preload:
        ratio = scale_per_design_if_varied(
            setup, InverseScale(2.0 * preload), InverseScale(1.0), lambda each: 0.5 / each.dynamics.pair_preload
        )
        loads[PRELOAD_RATIO] = Peak(curves, LARGEST_MAGNITUDE, ratio)
    return loads


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    setup, known = case.setup, peaks(case.setup)
    columns: dict[str, Any] = {name: peak_column(case, known[name]) for name in wanted_quantities & known.keys()}
    preload = case.setup_per_design.dynamics.pair_preload
    if preload is not None:
        columns[preload_quantity_names(setup)[0]] = preload * (1e-3 if setup.angular else 1.0) + np.zeros(
            len(case.designs)
        )
    return columns


EFFECT = Effect(
    "preload",
    lambda setup: preload_quantity_names(setup) if setup.mechanism.further_contacts else (),
    evaluate_columns,
    missing_keys_by_quantity,
    is_of_motion=lambda setup: True,
    peaks=peaks,
)

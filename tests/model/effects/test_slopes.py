"""The slope of every curve is that of differences of its values, on every mechanism that has it."""

from functools import cache, partial

import numpy as np
import pytest
from support.cams import CONTACTS, FREE, GUIDED, STEEL, SWUNG, WORN, cam_with

import camopt.solve.tolerances  # noqa: F401
from camopt import Scene, find_scene
from camopt.core.mistakes import BadInput
from camopt.core.numerics.curves import (
    CURVE_FORMULAS,
    DERIVATIVE_FORMULAS,
    curve_derivatives,
    curve_value,
    value_and_slope,
)
from camopt.core.numerics.state import State, TrainForces
from camopt.model.effects import EFFECTS, missing_keys_by_quantity
from camopt.model.effects.bearing_radii import flat_face_radius_shortfall, roller_load_utilisation
from camopt.model.effects.loads import normal_force_curve
from camopt.model.mechanisms.pairs import CONTACT_CURVES
from camopt.scene.problem.problem import resolve_design
from camopt.scene.sources import shipped_scenes

STEP = 1e-2
WEIGHTS = {1: 0.8, 2: -0.2, 3: 4.0 / 105.0, 4: -1.0 / 280.0}
"""Of differences of the eighth order (Fornberg, Math. Comp. 51 (1988))."""
ROOMS = ("camopt.model.effects", "camopt.model.mechanisms", "camopt.core.numerics")
"""Whose curves are asked for their slopes."""
TOLERANCES = {"profile": 0.02, "waves": 12, "bore_eccentricity": 0.015, "phase": {"plus": 0.04, "minus": 0.1}}
DRIVES = ("spring", "groove", "rib", "conjugate")
CURVES = sorted(
    (each for each in CURVE_FORMULAS if each.__module__.startswith(ROOMS)), key=lambda each: each.__name__
)


def scenes():
    """The shipped scenes, and data of every contact with every drive and load, some of which no cam has."""
    yield from (find_scene(name).to_dict() for name in shipped_scenes())
    for contact, follower in CONTACTS.items():
        swings = follower["motion"] == "oscillating"
        for rotation in ("ccw", "cw"):
            loads = (
                {**SWUNG, "load": [[0, 1.0], [180, 9.0]]} if swings else {**GUIDED, "load": [[0, 9.0], [180, 70]]}
            )
            yield cam_with(contact, rotation=rotation, dynamics=loads, materials=WORN)
            for drive in DRIVES:
                made = cam_with(contact, rotation=rotation, dynamics=SWUNG if swings else FREE, materials=STEEL)
                made["tolerances"] = {key: TOLERANCES[key] for key in TOLERANCES if drive in ("spring", "groove")}
                made["drive"] = {"kind": drive, **({"clearance": 0.07} if drive in ("groove", "rib") else {})}
                made["drive"] |= {"stiffness": 900, "interference": 0.03} if drive == "conjugate" else {}
                made["follower"] |= {"roller_spacing": 47} if drive == "rib" else {}
                yield made


def records_of(problem):
    """The curves of peaks and means of a scene, and those of its mechanism."""
    setup, design, turn = problem.setup, problem.design, problem.programme
    for effect in EFFECTS.values():
        for name, asked in (*effect.peaks(setup).items(), *effect.means(setup).items()):
            yield from (
                make(design, turn) for make, *_ in asked.curves if name not in missing_keys_by_quantity(setup)
            )
    mechanisms = [setup.mechanism, *(each.mechanism for each in setup.mechanism.further_contacts)]
    for mechanism in mechanisms:
        yield from (
            getattr(mechanism, name)(design, turn)
            for name in CONTACT_CURVES
            if name not in ("outline", "path") and getattr(mechanism, name)
        )
        yield from (mechanism.path(design, turn) for _ in [mechanism.path] if mechanism.path)
        yield from (mechanism.outline(design, turn, np.array([-3.0])) for _ in [0] if mechanism.outline)
    if setup.omega is not None and setup.dynamics.mass is not None:
        normal, one = normal_force_curve(setup, design, turn), np.ones(1)
        bent, radius = setup.mechanism.curvature, setup.mechanism.profile_radius
        yield (
            roller_load_utilisation(normal, bent(design, turn), 0.3 * one, one)
            if bent
            else flat_face_radius_shortfall(normal, radius(design, turn), 0.3 * one)
        )


def parts_of_curve(record):
    """A curve and all that it is made of."""
    if type(record) in CURVE_FORMULAS:
        yield record
    for each in record if isinstance(record, tuple) else ():
        yield from parts_of_curve(each)


@cache
def every_record():
    """By curve, those of all scenes, each with the lift of its motion."""
    found = {each: [] for each in CURVES}
    for data in scenes():
        try:
            problem = resolve_design(Scene.from_dict(data))
        except BadInput:
            continue
        for record in records_of(problem):
            for each in parts_of_curve(record):
                found.setdefault(type(each), []).append((each, problem.programme.lift))
    return found


def state(angle, lift):
    """A motion with loads, as smooth functions of the cam angle."""
    shift = np.array([0.3, 1.1, 1.9, 2.2, 3.7])
    y, y1, y2, y3, y4 = (
        lift
        * (
            (order == 0) * 0.5
            + 0.31 * np.sin(angle + 0.5 * np.pi * order)
            + 0.02 * 3.0**order * np.sin(3.0 * angle + 0.5 * np.pi * order)
        )
        for order in range(5)
    )
    forces = [210.0 + 70.0 * np.sin(angle + shift[0]), 70.0 * np.cos(angle + shift[0])]
    carried = [0.02 * np.sin(angle + shift[1]), 0.02 * np.cos(angle + shift[1])]
    return State(y, y1, y2, y3, TrainForces(*forces, *carried), y4)


def differences(function, angles):
    """The slope of a function by the cam angle."""
    sides = ((k, weight) for k, weight in WEIGHTS.items())
    return sum(w * (function(angles + k * STEP) - function(angles - k * STEP)) for k, w in sides) / STEP


@pytest.mark.parametrize("owner", CURVES, ids=lambda each: each.__name__)
def test_a_slope_is_that_of_differences(owner):
    angles = np.random.default_rng(len(owner._fields)).uniform(0.0, 2.0 * np.pi, 40)
    records = every_record()[owner]
    assert records
    for record, lift in records[:: 1 + len(records) // 40]:
        value, slope = value_and_slope(record, 0, state(angles, lift))
        assert np.array_equal(value, curve_value(record, 0, state(angles, lift)), equal_nan=True)
        found = differences(partial(value_at, record, lift), angles)
        off = np.abs(found - slope) / (np.max(np.abs(value)) + np.max(np.abs(slope)) + 1e-300)
        assert np.median(off) < 1e-10
        assert np.mean(off < 1e-6) > 0.7  # beside a kink differences are of no use


def value_at(record, lift, angle):
    return curve_value(record, 0, state(angle, lift)) + 0.0 * angle


@pytest.mark.parametrize(
    "owner", sorted(DERIVATIVE_FORMULAS, key=lambda each: each.__name__), ids=lambda each: each.__name__
)
def test_further_slopes_are_those_of_differences(owner):
    angles = np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, 40)
    for record, lift in every_record().get(owner, [])[:8]:
        exact = curve_derivatives(record, 0, state(angles, lift))
        for order in range(3):
            found = differences(partial(higher_derivative, record, lift, order), angles)
            assert found == pytest.approx(exact[order + 1], rel=1e-6, abs=1e-6 * np.max(np.abs(exact[order + 1])))


def higher_derivative(record, lift, order, angle):
    return curve_derivatives(record, 0, state(angle, lift))[order]

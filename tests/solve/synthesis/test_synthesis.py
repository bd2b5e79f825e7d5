"""Free motion laws: exact classical optima, textbook laws, proofs of every limit, and bounds that motions keep."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from math import inf, pi, radians, sqrt, tan

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly, BSpline
from scipy.optimize import linprog
from support.depth import times
from support.pictures import drawn_texts, faults_of

import camopt.solve.synthesis.convex_model
from camopt import BadInput, Scene, Unmet, Unsolved, evaluate, find_scene, optimise, plot
from camopt.cli.main import main
from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.model.motion import LAWS
from camopt.model.motion.programme import (
    Programme,
    derivative_peak,
    derivative_root_mean_square,
    law_peaks,
    weighted_derivative_range,
)
from camopt.model.motion.stroke import ALL_STROKES, RISE, Stroke
from camopt.scene.problem.problem import resolve
from camopt.scene.synthesis import AXIS_TERMS, SynthesisSettings
from camopt.solve.front.sweep import sweep
from camopt.solve.synthesis.cams import (
    optimise_or_keep_irrelevant_size,
    scene_with_laws,
    smallest_designs_by_known_law,
)
from camopt.solve.synthesis.convex_model import build_convex_model
from camopt.solve.synthesis.iterate import Iterate, free_stroke_motions, without_solver_error
from camopt.solve.synthesis.known_law_cams import build_known_law_cams
from camopt.solve.synthesis.law_infeasibility import no_cam_error
from camopt.solve.synthesis.nonconvex_constraints import (
    SampledConstraints,
    nonconvex_constraints_of,
    stroke_sample_positions,
)
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem, default_peak_factors
from camopt.solve.synthesis.ramps import dropped_ramps_in_words
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.relaxed_optimum import relaxation_bound
from camopt.solve.synthesis.solver import SOLVED_STATUSES, solve
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.splines import Splines, elevate_degree
from camopt.solve.synthesis.synthesise import solve_free_laws, synthesise
from camopt.solve.tables.cells import number_text
from camopt.solve.verdicts.certify import certify

MOTION = [
    {"segment": "rise", "angle": 120, "lift": 50, "law": "poly345"},
    {"segment": "dwell", "angle": 60},
    {"segment": "return", "angle": 90, "lift": 50, "law": "poly345"},
    {"segment": "dwell", "angle": 90},
]
ROLLER = {
    "cam": {"form": "disc", "rotation": "cw", "rpm": 1000, "base_radius": 80},
    "follower": {"motion": "translating", "contact": "roller", "roller_radius": 5},
    "motion": MOTION,
    "limits": {"pressure_angle": 30},
    "search": {"offset": {"start": -30, "stop": 30}},
    "synthesis": {"pieces": 20},
}
FLAT = ROLLER | {
    "cam": {"form": "disc", "rpm": 100, "base_radius": 100},
    "follower": {"motion": "translating", "contact": "flat", "offset": 4},
    "limits": {"curvature_radius": 5},
    "search": {},
}
KNIFE = ROLLER | {"follower": {"motion": "translating", "contact": "knife"}}
SPHERE = ROLLER | {"follower": {"motion": "translating", "contact": "spherical", "face_radius": 8}}
GROOVE = ROLLER | {"cam": {"form": "cylindrical", "rpm": 100, "mean_radius": 100}, "search": {}}
VALVE = find_scene("exhaust-valve").to_dict() | {
    "limits": {"pressure_angle": 50, "curvature_radius": 3},
    "search": {"offset": {"start": -20, "stop": 20}},
    "synthesis": {"pieces": 20},
}
DYNAMICS = {"mass": 0.5, "spring_rate": 30, "preload": 3000}
STRAIGHT_DOWN = [
    {"segment": "rise", "angle": 150, "lift": 40, "law": "poly345"},
    {"segment": "return", "angle": 120, "lift": 40, "law": "poly345"},
    {"segment": "dwell", "angle": 90},
]
NO_DWELL = [STRAIGHT_DOWN[0], STRAIGHT_DOWN[1] | {"angle": 210}]
SEVERAL = [
    {"segment": "rise", "angle": 90, "lift": 20, "law": "poly345"},
    {"segment": "rise", "angle": 60, "lift": 10, "law": "poly345"},
    {"segment": "dwell", "angle": 40},
    {"segment": "return", "angle": 120, "lift": 30, "law": "poly345"},
    {"segment": "dwell", "angle": 50},
]


def changed_scene(base=ROLLER, **changes):
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    return Scene.from_dict(base).replace(**keys)


@cache
def free(scene):
    return synthesise(scene)


def span_of(programme, order, kinds=ALL_STROKES):
    return weighted_derivative_range(programme, (0.0,) * order + (1.0,), kinds)


def sound(result):
    """A result that its own scene, evaluated and proved at every cam angle, confirms."""
    assert Scene.from_dict(result.scene.to_dict()) == result.scene
    found = evaluate(result.scene)
    assert found["feasible"], found["violated"]
    assert set(certify(result.scene).values()) <= {"held"}
    size = "base_radius_mm" if result.scene.cam.form == "disc" else "mean_radius_mm"
    assert found[size] == result.design[size]
    if result.bound is not None:
        assert result.bound <= result.objective * (1 + 1e-9)
    programme, rest = resolve(result.scene).programme, result.scene.synthesis.rest
    assert not [jump for jump in programme.jumps if jump.order <= rest]
    for stroke in programme.strokes:
        if stroke.law:
            least, largest = weighted_derivative_range(Programme((stroke,)), (1.0,), ALL_STROKES)
            assert min(stroke.low, stroke.high) - 1e-12 * 50 <= least
            assert largest <= max(stroke.low, stroke.high) + 1e-12 * 50
    return found


# ------------------------------------------------------------------------------------------------- the issue


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("law", "own", "trial"),
    [("poly345", 68.9, 56.3), ("cycloidal", 74.5, 66.4), ("poly4567", 83.4, 52.8), ("modified-sine", None, 55.3)],
)
def test_a_free_law_beats_the_textbook_law_with_its_peaks(law, own, trial):
    scene = changed_scene(search__law=[law], synthesis__pieces=48)
    known = optimise(scene).best["prime_radius_mm"]
    assert own is None or known == pytest.approx(own, abs=0.06)
    result = free(scene.replace(**{"synthesis.peak_acceleration": law, "synthesis.peak_jerk": law}))
    found = result.design["prime_radius_mm"]
    assert found <= min(known, trial)
    assert result.bound <= result.objective == pytest.approx(found - 5, abs=1e-12)
    assert result.gap < 0.02
    allowed = law_peaks(LAWS[law])
    for peaks in result.peaks.values():
        assert peaks["peak_acceleration"] <= allowed["peak_acceleration"]
        assert peaks["peak_jerk"] <= allowed["peak_jerk"]
        assert peaks["jumps"] == ""
    sound(result)


# ------------------------------------------------------------------------------------- exact classical optima

WIDE = {"synthesis.peak_acceleration": 1e3}
CLASSICAL = {  # of the unit stroke: least largest velocity; bang-bang; bang-bang jerk; cubic; quintic
    "velocity": (1.0, 1, {"synthesis.peak_acceleration": 1e4}, 0.03),
    "acceleration": (4.0, 1, {}, 0.02),
    "jerk": (32.0, 2, WIDE, 0.02),
    "acceleration_rms": (sqrt(12.0), 1, {}, 2e-4),
    "jerk_rms": (sqrt(720.0), 2, WIDE, 2e-4),
}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("term", CLASSICAL)
def test_classical_optima_of_the_calculus_of_variations(term):
    """4: constant acceleration, then deceleration; 32: three constant jerks; ∫s''² ≥ 12; ∫s'''² ≥ 720."""
    factor, rest, peaks, close = CLASSICAL[term]
    level, b, lift = [120, 60, 120, 60], radians(120), 50.0
    motion = [segment | {"angle": angle} for segment, angle in zip(MOTION, level, strict=True)]
    scene = changed_scene(
        motion=motion, cam__rpm=None, cam__base_radius=1000, synthesis__minimise=term, synthesis__rest=rest
    )
    order = {"velocity": 1, "acceleration": 2, "jerk": 3}[term.removesuffix("_rms")]
    exact = factor * lift / b**order
    if term.endswith("_rms"):
        exact *= sqrt(2 * b / (2 * pi))
    result = free(scene.replace(**peaks))
    assert exact * (1 - 2e-3) <= result.bound <= exact
    assert exact * (1 - 1e-9) <= result.objective <= exact * (1 + close)
    assert result.gap <= close


@pytest.mark.slow
@pytest.mark.parametrize("peak", [5.0, 20.0])
def test_the_largest_lift_area_within_an_acceleration_is_that_of_two_parabolas_and_a_rest(peak):
    """Up at once and as fast as may be, up after 2·√(1/a) of the stroke: √(1/a) of its area is lost."""
    scene = changed_scene(
        synthesis__minimise="lost_lift_area", synthesis__rest=1, synthesis__peak_acceleration=peak
    )
    exact = 50 * (120 + 90) / sqrt(peak) + 50 * 90
    result = free(scene.replace(**{"cam.base_radius": 300}))
    assert exact * (1 - 1e-3) <= result.bound <= exact
    assert exact * (1 - 1e-9) <= result.objective <= exact * (1 + 6e-3)
    lift_area = evaluate(result.scene.replace(outputs=["lift_area_mm_deg"]))["lift_area_mm_deg"]
    assert lift_area == pytest.approx(50 * 360 - result.objective, rel=1e-9)


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("speed", [None, 60, 1e-4, 1e6])
def test_units_of_the_objective_and_any_speed(speed):
    scene = changed_scene(cam__rpm=speed, synthesis__minimise="acceleration", cam__base_radius=80)
    result = free(scene)
    name = "acceleration_max_m_s2" if speed else "acceleration_max_mm_per_rad2"
    assert result.objective == pytest.approx(sound(result)[name], rel=1e-12)
    assert result.gap < 0.04
    assert result.gap == pytest.approx(free(changed_scene(synthesis__minimise="acceleration")).gap, abs=2e-4)


def test_no_bound_is_below_zero():
    """A knife edge under a limit that hardly matters: the least size is next to nothing."""
    problem = build_synthesis_problem(changed_scene(KNIFE, limits__pressure_angle=89))
    assert 0.0 <= relaxation_bound(problem) < 1.0


def test_the_gentlest_laws_are_the_quintic():
    """Without a limit that matters, the least mean square jerk is that of the 3-4-5 polynomial."""
    result = free(changed_scene(cam__base_radius=1000, synthesis__minimise="jerk_rms"))
    x = np.linspace(0, 1, 101)
    for law in result.laws.values():
        np.testing.assert_allclose(law.displacement(x), LAWS["poly345"].displacement(x), atol=1e-4)


# -------------------------------------------------------------------------------------------------- the bound


def random_laws(draw):
    """Laws at rest at their ends, with s within [0, 1]."""
    splines = Splines(5, draw(st.integers(3, 9)), draw(st.integers(2, 4)))
    inner = st.lists(st.floats(0, 1), min_size=splines.count - 6, max_size=splines.count - 6)
    both = [draw(inner), draw(inner)]
    if draw(st.booleans()):
        both = [sorted(each) for each in both]
    each = zip(("free-rise", "free-return"), both, strict=True)
    return [splines.unit_stroke_law(name, np.array([0.0, 0, 0, *c, 1, 1, 1])) for name, c in each]


@st.composite
def motions(draw):
    """A scene, and random laws or textbook laws within the peaks that it allows: just those of the laws."""
    base = draw(st.sampled_from([ROLLER, FLAT, GROOVE, KNIFE]))
    laws = random_laws(draw)
    spans = [span_of(Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),)), k) for law in laws for k in (1, 2, 3)]
    ranges = {}
    for place, name in enumerate(("peak_velocity", "peak_acceleration", "peak_jerk")):
        both = spans[place], spans[place + 3]
        low, high = min(s[0] for s in both), max(s[1] for s in both)
        if name != "peak_velocity" or draw(st.booleans()):
            ranges[f"synthesis.{name}"] = [low * (1 + 1e-12) - 1e-12, high * (1 + 1e-12) + 1e-12]
    term = draw(st.sampled_from([term for term in AXIS_TERMS if term != "residual_vibration"]))
    weights = {"size": draw(st.floats(0.1, 10)), term: draw(st.floats(0.01, 1))}
    scene = Scene.from_dict(base).replace(**ranges, **{"synthesis.minimise": weights})
    return scene, laws


def smallest_size(scene, y, y1, y2):
    """By the formulas of the mechanisms on samples, and on a grid of offsets."""
    tangent = tan(radians(30))
    if scene.follower.contact == "flat":
        return max(5.0, 5.0 - (y + y2).min())
    if scene.cam.form == "cylindrical":
        return np.abs(y1).max() / tangent
    primes = []
    for lead in np.linspace(-30, 30, 121):
        height = (np.abs(y1 - lead) / tangent - y).max()
        primes.append(np.hypot(lead, max(height, 0.0)))
    return min(primes) - (scene.follower.roller_radius or 0.0)


def objective(scene, programme, weights):
    """By sums over a fine grid of the motion's panels: neither spans nor Gauss's rule."""
    omega = scene.cam.rpm * pi / 30
    angles = (np.arange(36000) + 0.5) * (2 * pi / 36000)
    values = programme.motion_at(angles)
    knots = [
        s.start + s.angle * np.unique(getattr(s.law, "knots", (0.0, 1.0))) for s in programme.strokes if s.law
    ]  # accelerations bend there, and jerks jump
    beside = np.concatenate([angles, *knots, *(np.subtract(each, 1e-9) for each in knots)])
    densely = programme.motion_at(beside % (2 * pi))
    total = weights.get("size", 0.0) * smallest_size(scene, *densely[:3])
    for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
        per = omega**order / 1e3
        total += weights.get(name, 0.0) * per * np.abs(densely[order]).max()
        total += weights.get(f"{name}_rms", 0.0) * per * np.sqrt(np.mean(values[order] ** 2))
    return total + weights.get("lost_lift_area", 0.0) * 360 * np.mean(50 - values[0])


@pytest.mark.slow
@settings(max_examples=times(4, deep=100), suppress_health_check=list(HealthCheck))
@given(motions())
def test_no_motion_passes_the_bound(case):
    """Of any motion within the ranges, the values at the nodes hold every inequality of the relaxation."""
    scene, laws = case
    programme = resolve(scene).programme.with_laws(*laws)
    problem = build_synthesis_problem(scene)
    relaxed = build_convex_model(problem, partial(RelaxedMotion, 12))
    angles = [stroke.start + stroke.angle * np.linspace(0, 1, 13) for stroke in problem.strokes]
    fixed = []
    for stroke, motion, at in zip(programme.strokes, relaxed.motions, angles, strict=True):
        if stroke.is_law_replaceable:
            x, change = (at - stroke.start) / stroke.angle, (stroke.high - stroke.low) / problem.motion_unit
            s = stroke.law
            for unknown, value, room in (
                (motion.y, stroke.low / problem.motion_unit + change * s.displacement(x), 1e-7),
                (motion.v, change * s.velocity(x), 1e-7),
                (motion.a, change * s.acceleration(x), 1e-6),
            ):
                fixed.append(cp.abs(unknown - value) <= room)
    at_nodes = cp.Problem(cp.Minimize(relaxed.objective), relaxed.constraints + fixed)
    assert solve(at_nodes) in SOLVED_STATUSES
    true = objective(scene, programme, dict(scene.synthesis.minimise))
    assert relaxed.unit * at_nodes.value <= true * (1 + 1e-4)
    least = relaxed.solve()
    assert least <= true * (1 + 1e-4)


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("base", [ROLLER, FLAT, GROOVE], ids=["roller", "flat", "groove"])
@pytest.mark.parametrize("minimise", ["size", "jerk"])
def test_the_bound_grows_with_the_panels_and_stays_below_free_laws(base, minimise):
    problem = build_synthesis_problem(changed_scene(base, synthesis__minimise=minimise))
    bounds = [build_convex_model(problem, partial(RelaxedMotion, panels)).solve() for panels in (4, 8, 16, 32, 64)]
    assert all(after >= before * (1 - 1e-6) for before, after in pairwise(bounds))
    assert bounds[-1] <= solve_free_laws(problem)[2]


def least_on_grid(acceleration, jerk, panels, cost):
    """The least cost of the places of motions within the peaks, as a linear programme of accelerations."""
    n, h = panels + 1, 1.0 / panels
    velocity, place = np.zeros((n, n)), np.zeros((n, n))
    for k in range(panels):
        velocity[k + 1], place[k + 1] = velocity[k], place[k] + h * velocity[k]
        velocity[k + 1, k : k + 2] += h / 2
        place[k + 1, k : k + 2] += h * h / 3, h * h / 6
    slope = np.diff(np.eye(n), axis=0) / h
    ends = np.vstack([velocity[-1], place[-1], np.eye(n)[0], np.eye(n)[-1]])
    rows = np.vstack([slope, -slope, place, -place])
    most = np.concatenate([np.full(2 * panels, jerk), np.ones(n), np.zeros(n)])
    return linprog(cost @ place, rows, most, ends, [0, 1, 0, 0], (-acceleration, acceleration)).fun


def least_at_middle(acceleration, jerk, panels=120):
    """The least and largest s(½) of motions within the peaks."""
    middle = np.eye(panels + 1)[panels // 2]
    return tuple(sign * least_on_grid(acceleration, jerk, panels, sign * middle) for sign in (1, -1))


@pytest.mark.slow
@pytest.mark.parametrize(("acceleration", "jerk"), [(10 / sqrt(3), 60.0), (8.0, 100.0), (1e3, 40.0)])
def test_the_largest_lift_area_within_acceleration_and_jerk_is_that_of_a_linear_programme(acceleration, jerk):
    weights = np.full(121, 1 / 120)
    weights[[0, -1]] /= 2
    lost = 1 + least_on_grid(acceleration, jerk, 120, -weights)
    exact = 50 * (120 + 90) * lost + 50 * 90
    peaks = {"synthesis.peak_acceleration": acceleration, "synthesis.peak_jerk": jerk, "cam.base_radius": 300}
    result = free(changed_scene(synthesis__minimise="lost_lift_area").replace(**peaks))
    assert exact * (1 - 6e-3) <= result.bound <= exact * (1 + 1e-4)
    assert exact * (1 - 1e-4) <= result.objective <= exact * (1 + 9e-3)


@pytest.mark.slow
def test_what_no_motion_holds_is_said_and_what_one_holds_is_not():
    """How far a motion within the peaks of 3-4-5 can be from the middle: by a linear programme on a fine grid."""
    least, largest = least_at_middle(10 / sqrt(3), 60.0)
    assert least == pytest.approx(0.4298, abs=1e-3)
    assert largest == pytest.approx(1 - least, abs=1e-9)
    beyond, inside = (changed_scene(synthesis__points=[[60, 50 * least + off]]) for off in (-0.3, 0.3))
    assert relaxation_bound(build_synthesis_problem(beyond)) == inf
    assert relaxation_bound(build_synthesis_problem(inside)) < inf
    with pytest.raises(Unmet, match="no motion meets"):
        synthesise(beyond)
    assert (
        relaxation_bound(build_synthesis_problem(changed_scene(synthesis__peak_acceleration=4, synthesis__rest=1)))
        < inf
    )
    assert (
        relaxation_bound(
            build_synthesis_problem(changed_scene(synthesis__peak_acceleration=3.9, synthesis__rest=1))
        )
        == inf
    )


@pytest.mark.slow
def test_a_stroke_of_a_hundredth_of_a_degree_has_a_bound_below_its_cam():
    motion = [MOTION[0] | {"angle": 0.01}, {"segment": "dwell", "angle": 179.99}, *MOTION[2:]]
    result = free(changed_scene(motion=motion))
    assert result.bound < result.objective
    assert result.gap < 0.03


# ------------------------------------------------------------------------------------------------- vibration

TRAIN = {"follower.dynamics": {"natural_frequency": 110, "damping_ratio": 0.05}, "outputs": ["sizes", "vibration"]}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("motion", [MOTION, STRAIGHT_DOWN, SEVERAL], ids=["two dwells", "one", "several rises"])
@pytest.mark.parametrize(("frequency", "damping"), [(110, 0.05), (9, 0.3), (3000, 0.0)])
def test_the_residual_vibration_of_coefficients_is_that_of_the_response(motion, frequency, damping):
    """Linear in the coefficients: any motion has what the sum over its coefficients says."""
    train = {"natural_frequency": frequency + 1 / 3, "damping_ratio": damping}
    asked = changed_scene(motion=motion, follower__dynamics=train, synthesis__pieces=8)
    problem = build_synthesis_problem(asked)
    model = build_convex_model(replace(problem, objective={"residual_vibration": 1.0}), SplineMotion)
    random = np.random.default_rng(4)
    each = [np.sort(random.random(problem.splines.count)) for _ in free_stroke_motions(model)]
    found = Iterate(0.0, 1.0, without_solver_error(problem, each))
    for stroke, coefficients in zip(free_stroke_motions(model), found.coefficients, strict=True):
        stroke.coefficients.value = coefficients
    scene = scene_with_laws(asked, problem, found).replace(outputs=["vibration"])
    wanted = evaluate(scene)["residual_vibration_max_mm"]
    assert model.unit * float(model.objective.value) == pytest.approx(wanted, rel=1e-7)


@pytest.mark.slow
def test_the_least_residual_vibration_is_the_effects_own():
    scene = changed_scene(**TRAIN, **{"cam.base_radius": 60.0, "synthesis.minimise": "residual_vibration"})
    calm = free(scene.replace(**{"cam.base_radius": 53.0}))
    assert calm.bound == 0.0
    assert calm.objective == sound(calm)["residual_vibration_max_mm"]
    least = solve_free_laws(build_synthesis_problem(scene.replace(**{"cam.base_radius": 53.0})))[2]
    assert least > 0.01
    assert calm.objective == pytest.approx(least, rel=1e-3)
    smallest = free(changed_scene(**TRAIN))
    assert calm.objective < 0.7 * sound(smallest)["residual_vibration_max_mm"]
    roomy = free(scene)
    assert roomy.objective < 1e-2 * calm.objective


def test_a_limit_on_the_residual_vibration_is_held_by_the_motion():
    scene = changed_scene(**TRAIN)
    tight = free(scene.replace(**{"limits.residual_vibration": 0.01}))
    assert sound(tight)["residual_vibration_max_mm"] <= 0.01
    assert tight.convex
    assert tight.objective > free(scene).objective


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cam.rpm": None}, "needs cam.rpm, follower.dynamics.natural_frequency"),
        ({}, "needs follower.dynamics.natural_frequency"),
        ({"follower.dynamics": {"natural_frequency": 100}}, "the undamped train resonates"),
        (TRAIN | {"motion": NO_DWELL}, "needs a dwell"),
    ],
)
def test_a_residual_vibration_needs_a_train_a_speed_and_a_dwell(changes, message):
    scene = changed_scene(**changes, **{"synthesis.minimise": "residual_vibration"})
    with pytest.raises(BadInput, match=message):
        synthesise(scene)


# -------------------------------------------------------------------------------------------------- matrices


@pytest.mark.parametrize("splines", [Splines(5, 4, 4), Splines(4, 3, 2), Splines(9, 2, 2)], ids=str)
@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_bernstein_coefficients_are_those_of_the_spline(splines, order):
    coefficients = np.random.default_rng(1).random(splines.count)
    x = np.linspace(0, 1, 301)[1:-1]
    wanted = BSpline(splines.knots, coefficients, splines.degree).derivative(order)(x) if order else None
    wanted = BSpline(splines.knots, coefficients, splines.degree)(x) if order == 0 else wanted
    parts = 2 * splines.pieces
    for up in (0, order):
        rows = splines.bernstein_matrix(order)
        rows = elevate_degree(rows, splines.degree - order, up) @ coefficients
        peer = BPoly(rows.reshape(parts, -1).T, np.linspace(0, 1, parts + 1))
        np.testing.assert_allclose(peer(x), wanted, atol=1e-9 * np.abs(wanted).max())
        repeated = np.setdiff1d(
            np.arange(rows.size), splines.indices_of_distinct_coefficients(order, splines.degree - order + up)
        )
        np.testing.assert_allclose(rows[repeated], rows[repeated - 1], atol=1e-9 * np.abs(wanted).max())
        assert repeated.size == parts - (1 if order <= splines.continuity else splines.pieces)
    np.testing.assert_allclose(
        splines.value_matrix(x, order) @ coefficients, wanted, atol=1e-9 * np.abs(wanted).max()
    )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_root_mean_squares_by_a_fine_sum(order):
    result = free(changed_scene())
    programme = resolve(result.scene).programme
    angles = (np.arange(200000) + 0.5) * (2 * pi / 200000)
    fine = np.sqrt(np.mean(programme.motion_at(angles)[order] ** 2))
    assert derivative_root_mean_square(programme, order) == pytest.approx(fine, rel=1e-5)


# --------------------------------------------------------------------------------------------------- limits

LIMITS = {
    "velocity": (ROLLER, {"limits.velocity": 5.6}),
    "acceleration": (ROLLER, {"limits.acceleration": 1200}),
    "jerk": (ROLLER, {"limits.jerk": 5e5}),
    "pressure angles": (ROLLER, {"limits.pressure_angle": 25, "limits.pressure_angle_return": 40}),
    "return only": (ROLLER, {"limits.pressure_angle": None, "limits.pressure_angle_return": 25}),
    "curvature": (ROLLER, {"limits.curvature_radius": 10}),
    "shaft": (ROLLER, {"cam.shaft_diameter": 120}),
    "contact force": (ROLLER, {"follower.dynamics": DYNAMICS, "limits.contact_force_min": 50}),
    "jump speed": (ROLLER, {"follower.dynamics": DYNAMICS, "limits.jump_speed": 1010}),
    "monotone": (ROLLER, {"synthesis.monotone": True}),
    "points": (ROLLER, {"synthesis.points": [[60, 23], [220, 30]]}),
    "rest 1": (ROLLER, {"synthesis.rest": 1}),
    "rest 3": (ROLLER, {"synthesis.rest": 3}),
    "one-sided acceleration": (ROLLER, {"synthesis.peak_acceleration": [-5, 7], "synthesis.peak_jerk": 80}),
    "velocity never back": (ROLLER, {"synthesis.peak_velocity": [0, 1.85]}),
    "names": (ROLLER, {"synthesis.peak_velocity": "poly345", "synthesis.peak_acceleration": "modified-sine"}),
    "degree 9": (ROLLER, {"synthesis.degree": 9, "synthesis.continuity": 5, "synthesis.pieces": 8}),
    "degree 4": (ROLLER, {"synthesis.degree": 4}),
    "offset 0": (ROLLER, {"follower.offset": 20, "search.offset": [0]}),
    "listed offsets": (ROLLER, {"search.offset": [0, 14], "search.roller_radius": [4, 8]}),
    "ccw": (ROLLER, {"cam.rotation": "ccw"}),
    "straight down": (ROLLER, {"motion": STRAIGHT_DOWN}),
    "no dwell": (ROLLER, {"motion": NO_DWELL}),
    "several rises": (ROLLER, {"motion": SEVERAL}),
    "flat": (FLAT, {}),
    "face reach": (FLAT, {"limits.face_reach": 62.5}),
    "knife": (KNIFE, {}),
    "sphere": (SPHERE, {}),
    "groove": (GROOVE, {}),
    "two sizes": (ROLLER, {"search.roller_radius": {"start": 4, "stop": 8}}),
    "weights": (ROLLER, {"synthesis.minimise": {"size": 1, "acceleration": 0.02}}),
    "one size": (ROLLER, {"synthesis.minimise": "jerk", "search.base_radius": [60]}),
    "own size": (ROLLER, {"synthesis.minimise": "acceleration", "cam.base_radius": 60}),
}


IN_DEEP = (  # of each of these, another case has its kind of limit, or another test
    "return only", "velocity never back", "names", "degree 4", "listed offsets", "ccw",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long) if name in IN_DEEP else name for name in LIMITS]
)
def test_every_limit_holds_over_the_whole_turn(name):  # noqa: C901
    base, changes = LIMITS[name]
    scene = Scene.from_dict(base).replace(**{"synthesis.pieces": 14, **changes})
    result, asked = free(scene), scene.synthesis
    sound(result)
    assert result.convex
    programme = resolve(result.scene).programme
    for law in result.laws.values():
        least = span_of(Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),)), 1)[0]
        if asked.monotone or asked.peak_velocity == (0.0, 1.85):
            assert least >= -1e-12
        for key, value in {
            "peak_velocity": asked.peak_velocity,
            "peak_acceleration": asked.peak_acceleration,
        }.items():
            if isinstance(value, str):
                assert law_peaks(law)[key] <= law_peaks(LAWS[value])[key]
        if isinstance(asked.peak_acceleration, tuple):
            low, high = span_of(Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),)), 2)
            assert asked.peak_acceleration[0] <= low < high <= asked.peak_acceleration[1]
        if not {"straight down", "no dwell", "several rises"} & {name}:
            ends = np.array([0.0, 1.0])
            for order, verb in enumerate((law.velocity, law.acceleration, law.jerk), start=1):
                assert order > asked.rest or verb(ends).tolist() == [0.0, 0.0]
    for angle, y in asked.points:
        assert programme.motion_at(np.array([radians(angle)]))[0, 0] == pytest.approx(y, abs=1e-5)
    if name == "one size":
        assert result.scene.cam.base_radius == 60
    if name == "own size":
        assert result.design["base_radius_mm"] <= 60
    if name == "offset 0":
        assert result.scene.follower.offset == 0.0
    if name == "listed offsets":
        ones = [free(scene.replace(**{"search.offset": [each]})) for each in (0, 14)]
        assert result.objective == min(one.objective for one in ones)
        assert result.bound == min(one.bound for one in ones)
    if name == "rest 1":
        assert result.objective < free(scene.replace(**{"synthesis.rest": None})).objective


@pytest.mark.slow
def test_a_known_law_is_never_better_than_free_laws_with_its_peaks():
    for name in ("flat", "knife", "sphere", "groove", "straight down", "several rises"):
        base, changes = LIMITS[name]
        scene = Scene.from_dict(base).replace(**{"synthesis.pieces": 14, **changes})
        known, result = optimise(scene).best, free(scene)
        assert result.objective <= known[resolve(result.scene).size_quantity_name] * (1 + 1e-3)


def test_a_sweep_of_the_synthesised_scene(tmp_path):
    result = free(changed_scene())
    size = result.design["base_radius_mm"]
    scene = result.scene.replace(**{"search.base_radius": [size - 1, size + 0.01, size + 1]})
    found = sweep(scene.replace(**{"search.offset": None}), tmp_path, keep="all", workers=1)
    assert (found.designs, found.feasible) == (3, 2)


# ------------------------------------------------------------------------------------------------- symmetries


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(("offset", "other"), [(12.0, -12.0), (-7.0, 7.0)])
def test_a_mirrored_cam_is_as_large(offset, other):
    """The other sense of rotation with the other side of the offset is the mirror image."""
    one = free(changed_scene(search__offset=None, follower__offset=offset, cam__rotation="cw"))
    two = free(changed_scene(search__offset=None, follower__offset=other, cam__rotation="ccw"))
    assert one.objective == pytest.approx(two.objective, rel=1e-6)
    assert one.bound == pytest.approx(two.bound, rel=1e-5)
    wrong = free(changed_scene(search__offset=None, follower__offset=other, cam__rotation="cw"))
    assert wrong.objective != pytest.approx(one.objective, rel=0.02)


@pytest.mark.parametrize("factor", [1e-3, 1e4])
def test_a_scaled_cam(factor):
    motion = [s | ({"lift": factor * s["lift"]} if "lift" in s else {}) for s in MOTION]
    scaled = changed_scene(
        motion=motion, follower__roller_radius=5 * factor, cam__base_radius=80 * factor,
        search__offset={"start": -30 * factor, "stop": 30 * factor},
    )  # fmt: skip
    assert free(scaled).objective == pytest.approx(factor * free(changed_scene()).objective, rel=1e-5)
    assert free(scaled).bound == pytest.approx(factor * free(changed_scene()).bound, rel=1e-5)


def test_the_turn_backwards_is_as_large():
    """Run backwards, rises are returns and the offset changes sides."""
    swapped = [MOTION[2] | {"segment": "rise"}, MOTION[1], MOTION[0] | {"segment": "return"}, MOTION[3]]
    assert free(changed_scene(motion=swapped)).objective == pytest.approx(free(changed_scene()).objective, rel=1e-5)


# ------------------------------------------------------------------------------------- curvature, not convex


@pytest.mark.slow
def test_curvature_by_convex_steps():
    scene = Scene.from_dict(VALVE)
    result = free(scene)
    found = sound(result)
    assert not result.convex
    assert found["profile_radius_min_mm"] >= 3
    known = optimise(scene.replace(**{"search.law": ["poly345"]})).best
    assert result.bound < result.objective <= known["base_radius_mm"] * (1 + 1e-9)


@pytest.mark.slow
def test_curvature_alone_decides():
    """Without a limit on the pressure angle, the convex limits say nothing of the size."""
    scene = changed_scene(VALVE, limits__pressure_angle=None, synthesis__pieces=12)
    result = free(scene)
    sound(result)
    assert not result.convex
    assert result.objective <= optimise(scene.replace(**{"search.law": ["poly345"]})).best["base_radius_mm"]


LOADED = {
    "follower.dynamics": DYNAMICS | {"load": [[0, 40], [90, 40], [90, 300], [180, 40]]},
    "materials": {"cam": "steel", "follower": "steel", "face_width": 12},
    "limits.torque": 200,
    "limits.contact_stress": 1500,
    "limits.normal_force": 9000,
}


@pytest.mark.parametrize("base", [ROLLER, SPHERE, GROOVE, FLAT], ids=["roller", "sphere", "groove", "flat"])
def test_planes_are_tangent_to_the_curves_of_limits(base):
    """Whatever the curve: against its values a little away, in the motion and the sizes together."""
    problem = build_synthesis_problem(Scene.from_dict(base).replace(**LOADED, **{"synthesis.pieces": 6}))
    constraints, random, unit = nonconvex_constraints_of(problem), np.random.default_rng(2), problem.motion_unit
    for stroke in problem.strokes:
        sampled = SampledConstraints(problem, stroke)
        orders = np.arange(4)[:, None]
        state = (
            unit
            * random.uniform(0.3, 0.7, (4, stroke_sample_positions(problem, stroke).size))
            / stroke.angle**orders
        )
        away = random.normal(size=state.shape) / stroke.angle**orders
        sizes, aside = np.array([4.0, 90.0]), random.normal(size=2)
        planes = sampled.tangent_planes(constraints, state, tuple(sizes))
        assert len(planes.values) == sum(1 + (c.goal == LARGEST_MAGNITUDE) for c in constraints)
        risen = np.einsum("kcn,kn->cn", planes.motion, away) + planes.lead * aside[0] + planes.height * aside[1]
        step, ends = 1e-4, []
        for k in (-step, step):
            ends.append(
                sampled.ratios_to_bounds(constraints, state + k * unit * away, tuple(sizes + k * unit * aside))
            )
        slopes = (ends[1] - ends[0]) / (2 * step)
        np.testing.assert_allclose(risen, slopes, rtol=1e-5, atol=1e-5 * np.abs(slopes).max())


def test_values_of_nonconvex_constraints_by_hand():
    """The pitch curvature and the torque from their textbook formulas."""
    problem = build_synthesis_problem(changed_scene(VALVE, synthesis__pieces=6))
    (curvature,) = nonconvex_constraints_of(problem)
    assert curvature.factor(problem.scene_problem.design).item() == 23
    stroke = problem.strokes[0]
    y, y1, y2, _ = state = np.random.default_rng(2).uniform(1, 20, (4, 288))
    a, w = 50 + y, y1 - 7
    kappa = (a**2 + w * (2 * y1 - 7) - a * y2) / np.hypot(a, w) ** 3
    np.testing.assert_allclose(
        SampledConstraints(problem, stroke).ratios_to_bounds([curvature], state, (7.0, 50.0))[0], 23 * kappa
    )
    problem = build_synthesis_problem(
        changed_scene(follower__dynamics=DYNAMICS, limits__torque=200, synthesis__pieces=6)
    )
    (constraint,) = [c for c in nonconvex_constraints_of(problem) if c.goal == LARGEST_MAGNITUDE]
    omega = 1000 * pi / 30
    torque = (0.5e-3 * omega**2 * y2 + 30 * y + 3000) * y1
    found = SampledConstraints(problem, stroke).ratios_to_bounds([constraint], state, (7.0, 50.0))
    np.testing.assert_allclose(found, [torque / 200e3, -torque / 200e3])


@pytest.mark.slow
def test_a_limit_on_torque_is_held_by_the_motion():
    """No size holds it: the torque is that of the motion. The textbook law of these peaks breaks it."""
    scene = changed_scene(follower__dynamics=DYNAMICS, outputs=["sizes", "torque"])
    least = free(scene)
    bent = free(scene.replace(**{"limits.torque": 205}))
    assert sound(bent)["torque_peak_N_m"] <= 205
    assert not bent.convex
    assert sound(least)["torque_peak_N_m"] > 215
    assert least.objective <= bent.objective * (1 + 1e-6)


@pytest.mark.parametrize("motion", [STRAIGHT_DOWN, NO_DWELL, SEVERAL], ids=["down", "no dwell", "several"])
def test_a_solvers_error_at_a_joint_is_no_jump(motion):
    asked = changed_scene(motion=motion)
    problem = build_synthesis_problem(asked)
    found = solve_free_laws(problem)[1]
    random = np.random.default_rng(3)
    noisy = without_solver_error(problem, [c + 1e-8 * random.normal(size=c.size) for c in found.coefficients])
    scene = scene_with_laws(asked, problem, found._replace(coefficients=noisy))
    assert not resolve(scene).programme.jumps


# ------------------------------------------------------------------------------------------------ mistakes

MISTAKES = {
    "minimise": ("weight", "a term of the objective"),
    "peak_jerk": ("nolaw", "must be a motion law"),
    "peak_acceleration": ("uniform", "a law whose peak acceleration is finite"),
    "peak_velocity": ([0.5, 2], "a range that contains 0"),
    "rest": (4, "at most 3"),
    "monotone": (3, "monotone"),
    "degree": (3, "at least 4"),
    "pieces": (1, "at least 2"),
    "continuity": (5, "below the degree (5)"),
    "points": ([[150, 50]], "a cam angle inside a rise, return or move"),
}


@pytest.mark.parametrize("peak", [(-1e9, 1e9), (0.0, 1e-300), 1e9])
def test_peaks_may_be_as_far_as_numbers_go(peak):
    assert SynthesisSettings(peak_velocity=peak).peak_velocity == peak


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def call(scene, *arguments):
        if isinstance(scene, dict):
            import tomli_w

            (tmp_path / "scene.toml").write_text(tomli_w.dumps(scene))
        code = main(["synthesise", "scene.toml" if isinstance(scene, dict) else scene, *arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return code, out, err

    return call


@pytest.mark.parametrize("key", MISTAKES)
def test_mistakes_are_said_and_nothing_is_written(key, run, tmp_path):
    value, message = MISTAKES[key]
    code, out, err = run(ROLLER | {"synthesis": {key: value}})
    assert (code, out) == (2, "")
    assert f"synthesis.{key}" in err
    assert message in err
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"synthesis": {"rest": 1, "peak_jerk": 60}}, "synthesis.rest"),
        ({"synthesis": {"rest": 1, "minimise": "jerk_rms"}}, "synthesis.rest"),
        ({"synthesis": {"points": [[60, 51]]}}, "a displacement from 0 to 50"),
        ({"synthesis": {"points": [[60, 20], [60.001, 21]]}}, "synthesis.points.2"),
        ({"synthesis": {"points": [[60, 20, 1]]}}, "two numbers"),
        ({"synthesis": {"minimise": {}}}, "synthesis.minimise"),
        ({"synthesis": {"minimise": {"size": -1}}}, "synthesis.minimise.size"),
        ({"synthesis": {"piece": 2}}, "synthesis.piece"),
        ({"limits": {}}, "nothing limits the size"),
    ],
)
def test_more_mistakes(changes, message, run):
    code, _, err = run(ROLLER | changes)
    assert code == 2
    assert message in err


def test_a_size_that_nothing_limits_stays_where_the_objective_is_another():
    """The least mean square of the jerk between two dwells is that of the quintic; the cam stays as large."""
    result = free(changed_scene(limits=None, synthesis__minimise="jerk_rms", search=None))
    assert result.design["base_radius_mm"] == 80
    assert result.gap < 1e-5
    assert result.peaks["free-rise"]["peak_velocity"] == pytest.approx(1.875, rel=1e-3)
    known = smallest_designs_by_known_law(changed_scene(limits=None, synthesis__minimise="jerk_rms"))
    assert {row["base_radius_mm"] for row in known.values()} == {80}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"limits.acceleration": 300},  # of constant acceleration, 4h/θ² on the return, it would be 888.89
            r"one alone is impossible: limits.acceleration \(at least 888\.88\d m/s² with the rest\)",
        ),
        (
            {"limits.jerk": 5e5, "limits.acceleration": 950},
            r"contradict each other: limits.acceleration \(at least .* m/s².*\), limits.jerk \(at least .* m/s³",
        ),
        (
            {"search.base_radius": {"start": 20, "stop": 30}},
            r"the size \(search.base_radius\) \(at least .* mm with the rest\) within the default limits of jerk .*"
            "; set limits.acceleration or limits.jerk, or synthesis.peak_acceleration or synthesis.peak_jerk to",
        ),
        ({"limits.acceleration": 300, "limits.jerk": 1e4}, "one alone is impossible: limits.jerk"),
    ],
)
def test_what_cannot_be_met_names_the_limits_that_stand_in_the_way(changes, words):
    with pytest.raises(Unmet, match=words):
        synthesise(changed_scene().replace(**changes))


@pytest.mark.slow
def test_a_limit_that_no_cam_holds_is_told_with_what_was_reached():
    """Its ramps of 0.8 mm/rad at 3000 rev/min take up the lash at 0.2513 m/s, whatever the law between them."""
    scene = find_scene("bucket-valve").replace(**{"synthesis.pieces": 12, "limits.lash_speed": 0.05})
    words = (
        r"limits.lash_speed \(best lash_speed_max_m_s = (\S+), limit ≤ 0.05 m/s\); set a larger limits.lash_speed"
    )
    with pytest.raises(Unmet, match=words) as error:
        synthesise(scene)
    assert float(re.search(words, str(error.value))[1]) == pytest.approx(0.8e-3 * 3000 * 2 * pi / 60, rel=1e-5)


JUNK = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from([*LAWS, "size"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=2),
    max_leaves=4,
)


@settings(max_examples=times(75, deep=1500))
@given(st.dictionaries(st.sampled_from([*SynthesisSettings.model_fields, "x"]), JUNK, min_size=1, max_size=3))
def test_junk_is_bad_input_or_a_problem(junk):
    problem, told = None, []
    try:
        problem = build_synthesis_problem(Scene.from_dict(ROLLER | {"synthesis": junk}))
    except BadInput as error:
        told = [mistake.key for mistake in error.mistakes]
    assert all(key.startswith("synthesis.") for key in told)
    assert bool(told) != bool(problem and problem.splines.count > problem.splines.degree)


GENTLE = (10.0, 100.0)  # peaks that a spline of ten pieces has


@pytest.mark.slow
@settings(max_examples=times(2, deep=60), suppress_health_check=list(HealthCheck))
@example(pieces=10, degree=5, rest=2, acceleration=GENTLE[0], jerk=GENTLE[1], lift=50.0)
@given(
    pieces=st.integers(2, 12),
    degree=st.integers(4, 9),
    rest=st.integers(2, 3),
    acceleration=st.floats(1e-3, 1e9),
    jerk=st.floats(1e-3, 1e9),
    lift=st.floats(10, 1e6),
)
def test_any_size_of_a_problem_is_solved_or_said(pieces, degree, rest, acceleration, jerk, lift):
    motion = [s | ({"lift": lift} if "lift" in s else {}) for s in MOTION]
    asked = {"pieces": pieces, "degree": degree, "rest": rest, "peak_acceleration": acceleration, "peak_jerk": jerk}
    try:
        result = synthesise(Scene.from_dict(ROLLER | {"motion": motion, "synthesis": asked}))
    except (Unmet, Unsolved):
        assert (acceleration, jerk) != GENTLE  # which are met
    else:
        assert evaluate(result.scene)["feasible"]
        assert result.bound is None or result.bound <= result.objective


# --------------------------------------------------------------------------------------------- command line


@pytest.mark.slow
def test_the_command_writes_a_scene_and_its_laws(run, tmp_path):
    code, out, _ = run(ROLLER, "--json", "--plot", "both.svg", "--out", "there")
    found = json.loads(out, parse_constant=lambda text: pytest.fail(text))
    assert code == 0
    assert found["bound"] < found["objective"] == found["base_radius_mm"]
    assert found["gap"] == pytest.approx(1 - found["bound"] / found["objective"])
    assert set(found["known_laws"]) <= {f"{law}" for law in LAWS}
    scene = Scene.from_toml(tmp_path / "there" / "synthesised.toml")
    assert scene.cam.base_radius == found["base_radius_mm"]
    assert evaluate(scene)["feasible"]
    rows = np.genfromtxt(tmp_path / "there" / "laws.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    laws = resolve(scene).laws
    for row in rows[::60]:
        law = laws[row["law"]]
        assert row["s"] == law.displacement(row["x"])
        assert row["jerk"] == law.jerk(row["x"])
    written = (tmp_path / "both.svg").read_text(encoding="utf-8")
    assert ">best known law" in written or ">law of the scene" in written
    assert "DejaVuSans-" not in written
    assert main(["certify", "there/synthesised.toml", "--quiet"]) == 0


def test_the_american_spelling(run):
    assert main(["synthesize", "--help"]) == 0


def test_what_cannot_be_met_ends_with_1_and_nothing_written(run, tmp_path):
    code, out, err = run(ROLLER | {"synthesis": {"peak_acceleration": 3}})
    assert (code, out) == (1, "")
    assert "no motion meets" in err
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


def test_a_picture_of_no_known_kind_is_bad_input_and_nothing_is_written(run, tmp_path):
    code, _, err = run(ROLLER, "--plot", "both.bmp")
    assert code == 2
    assert "--plot" in err
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


def test_a_solver_that_fails_is_said(run, monkeypatch):
    monkeypatch.setattr(camopt.solve.synthesis.convex_model, "solve", lambda programme: "solver_error")
    code, out, err = run(ROLLER)
    assert (code, out) == (4, "")
    assert "solver" in err
    assert main(["frontier", "scene.toml", "--workers", "1"]) == 4


@pytest.mark.slow
def test_the_result_never_replaces_the_users_scene(run, tmp_path):
    run(ROLLER, "--out", "there", "--quiet")
    own = (tmp_path / "there" / "synthesised.toml").read_bytes()
    assert main(["synthesise", "there/synthesised.toml", "--out", "there"]) == 2
    assert (tmp_path / "there" / "synthesised.toml").read_bytes() == own


@pytest.mark.slow
def test_what_solves_no_convex_programme_imports_no_cvxpy(tmp_path):
    """Its import takes longer than most answers."""
    works = [
        "camopt.optimise(camopt.find_scene('roller-1000rpm'))",
        "camopt.report(camopt.find_scene('roller-1000rpm'), 'cam.html')",
        "camopt.compare('roller-1000rpm', 'two-pauses')",
    ]
    code = f"import sys, camopt; {'; '.join(works)}; assert not {{'cvxpy', 'scipy.stats'}} & {{*sys.modules}}"
    run = subprocess.run([sys.executable, "-c", code], check=False, stdout=subprocess.DEVNULL, cwd=tmp_path)
    assert run.returncode == 0


VALVE_LIFT = [
    {"segment": "move", "angle": 12, "to": 0.08, "velocity": 0.8, "acceleration": 0},
    {"segment": "constant-velocity", "angle": 12, "velocity": 0.8},
    {"segment": "move", "angle": 60, "to": 9},
    {"segment": "move", "angle": 60},
    {"segment": "constant-velocity", "angle": 12, "to": 0.08, "velocity": -0.8},
    {"segment": "move", "angle": 12, "to": 0},
    {"segment": "dwell", "angle": 192},
]


def test_what_keeps_a_cam_from_being_larger_is_named_with_what_is_by_default():
    """Where acceleration is minimised the cam is no larger than the scene's own: a limit as any other."""
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rpm": 3000, "base_radius": 21.5},
            "follower": {"motion": "translating", "contact": "flat"},
            "motion": VALVE_LIFT,
            "limits": {"curvature_radius": 3},
            "synthesis": {"minimise": "acceleration"},
        }
    )
    problem, own = build_synthesis_problem(scene), optimise_or_keep_irrelevant_size(scene)
    least = own.best["base_radius_mm"]
    assert least > 21.5
    why = str(no_cam_error(scene, problem, [own]))
    assert f"cam.base_radius (best base_radius_mm = {number_text(least)}, limit 21.5 mm)" in why
    assert "a larger cam.base_radius, or a range in [search]" in why
    moves = resolve(scene).programme
    jerk = 1.25 * derivative_peak(moves, 3, ALL_STROKES) * (3000 * pi / 30) ** 3 / 1e3
    assert f"default limits: jerk of at most {number_text(jerk)} m/s³" in why
    asked = scene.replace(**{"limits.jerk": 2e7})
    known = build_known_law_cams(asked)
    assert known.broken_limits == {"own moves": "cam.base_radius of at most 21.5 mm"}
    assert evaluate(known.rows["own moves"].scene)["feasible"]  # of its own size
    assert "default limits" not in str(no_cam_error(asked, build_synthesis_problem(asked), [own]))


def test_known_laws_are_those_of_the_search_and_the_scenes_own():
    assert list(smallest_designs_by_known_law(changed_scene(search__law=["poly345"]))) == ["poly345"]
    assert set(smallest_designs_by_known_law(changed_scene(search__law=["cycloidal"]))) == {"cycloidal", "poly345"}
    assert set(smallest_designs_by_known_law(changed_scene())) <= set(LAWS)


ASKED = {"motion": [segment | ({"law": "cycloidal"} if "law" in segment else {}) for segment in MOTION]}
SMOOTH = {"synthesis__peak_jerk": "modified-sine", "synthesis__peak_acceleration": "cycloidal"}


def test_free_laws_are_compared_with_the_best_known_law_within_the_same_limits_and_with_the_scenes_own():
    """The caps of acceleration and jerk here let the scene's own law through, and others that make smaller cams."""
    known = build_known_law_cams(changed_scene(ROLLER | ASKED, search__law=["poly4567", "modified-sine"], **SMOOTH))
    assert known.own_law == "cycloidal"
    assert {law: row["within"] for law, row in known.rows.items()} == {
        "modified-sine": True, "cycloidal": True, "poly4567": False,
    }  # fmt: skip
    sizes = {law: row["base_radius_mm"] for law, row in known.rows.items()}
    assert known.best == "modified-sine" == min(sizes, key=sizes.get)
    for law in known.rows:
        cam = evaluate(known.rows[law].scene)
        assert cam["feasible"]
        assert cam["law_rise"] == law
        assert cam["base_radius_mm"] == sizes[law] == known.rows[law]["objective"]


def test_the_scenes_own_law_is_the_best_where_it_is_better():
    known = build_known_law_cams(changed_scene(search__law=["cycloidal"]))  # the caps are those of 3-4-5
    assert (known.own_law, known.best) == ("poly345", "poly345")


@pytest.mark.slow
def test_a_law_that_breaks_a_limit_is_never_drawn_as_the_one_before():
    scene = changed_scene(
        search__law=["harmonic", "cycloidal"], synthesis__peak_jerk=45, synthesis__peak_acceleration=7
    )
    known = build_known_law_cams(
        scene.replace(motion=[s | ({"law": "parabolic"} if "law" in s else {}) for s in MOTION])
    )
    assert known.best == "cycloidal"
    known = build_known_law_cams(
        changed_scene(search__law=["harmonic"], synthesis__peak_jerk=55, synthesis__peak_acceleration=7)
    )
    assert (known.own_law, known.best) == ("poly345", None)
    result = synthesise(
        changed_scene(search__law=["harmonic"], synthesis__peak_jerk=55, synthesis__peak_acceleration=7)
    )
    figure = plot(result, known=known)
    assert faults_of(figure) == []
    words = [text.get_text() for text, _ in drawn_texts(figure)[0]]
    assert any("no known law meets all limits" in text for text in words)
    assert not any("known law:" in text for text in words)


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("base", [ROLLER, FLAT, GROOVE, VALVE], ids=["roller", "flat", "groove", "valve"])
def test_the_picture_before_and_after_has_its_texts_apart(base):
    assert faults_of(plot(free(changed_scene(base)))) == []


@pytest.mark.slow
def test_the_limits_taken_by_default_are_printed(run):
    code, out, _ = run(ROLLER | {"search": {"offset": {"start": -30, "stop": 30}, "law": ["poly345"]}})
    assert code == 0
    assert "peak acceleration 5.7735 and peak jerk 60" in out
    assert re.search(r"Minimised: [\d.]+ mm\. Lower bound for any motion within the convex limits: [\d.]+ mm,", out)
    code, out, _ = run(ROLLER | {"limits": {"pressure_angle": 30, "jerk": 2e6}}, "--json")
    assert json.loads(out)["default_peaks"] == {}


def test_default_peaks_are_those_of_the_problem():
    scene = changed_scene()
    peaks = default_peak_factors(scene)
    assert peaks == pytest.approx({"peak_acceleration": 10 / 3**0.5, "peak_jerk": 60.0})
    given = build_synthesis_problem(scene.replace(**{f"synthesis.{name}": value for name, value in peaks.items()}))
    assert given.derivative_ranges == build_synthesis_problem(scene).derivative_ranges
    assert list(default_peak_factors(scene, ("size", "acceleration"))) == ["peak_jerk"]
    assert default_peak_factors(changed_scene(limits__jerk=1e6)) == {}


@pytest.mark.slow
def test_a_load_that_presses_over_the_turn_is_no_limit():
    """A table that never lacks is as good as its least value: neither the bound nor the laws may forget it."""
    base = find_scene("roller-1000rpm").replace(
        **{
            "cam.rpm": 900,
            "follower.dynamics": {"mass": 1, "spring_rate": 10, "preload": 100},
            "limits.contact_force_min": 50,
            "search.roller_radius": [5],
            "synthesis.pieces": 20,
        }
    )
    constant, table = (
        synthesise(base.replace(**{"follower.dynamics.load": load})) for load in (2000, [[0, 2000], [180, 2001]])
    )
    assert table.bound == pytest.approx(constant.bound, rel=1e-5)
    assert table.objective == pytest.approx(constant.objective, rel=1e-4)
    assert certify(table.scene)["contact_force_min"] == "held"


@pytest.mark.parametrize("steady", [0.0, 0.25])
def test_a_ramp_that_a_free_law_does_not_keep_is_told(steady):
    """A quarter of each stroke at constant velocity, in its middle; and a law without."""
    rows = [{"segment": word, "angle": 120, "lift": 20, "law": "own"} for word in ("rise", "return")]
    motion = [*rows, {"segment": "dwell", "angle": 120}]
    laws = {"own": {"scca": [0.3, 0.3, 0.4 - steady, *([steady] if steady else [])]}}
    told = list(dropped_ramps_in_words(find_scene("roller-1000rpm").replace(motion=motion, laws=laws)))
    ends = [float(text) for line in told for text in re.findall(r"[\d.]+(?= to| deg)", line)]
    assert ends == (pytest.approx([45, 75, 165, 195], abs=0.5) if steady else [])


def test_a_ramp_that_will_be_lost_is_told_first(tmp_path, capsys):
    """Also where no cam is found in the end."""
    rows = [{"segment": word, "angle": 120, "lift": 20, "law": "own"} for word in ("rise", "return")]
    motion, laws = [*rows, {"segment": "dwell", "angle": 120}], {"own": {"scca": [0.3, 0.3, 0.15, 0.25]}}
    scene = find_scene("roller-1000rpm").replace(motion=motion, laws=laws, **{"limits.acceleration": 1.0})
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    assert main(["synthesise", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "out")]) == 1
    first, second, last = capsys.readouterr().err.splitlines()
    assert "the law of motion.1 has a ramp of constant velocity, which a free law drops" in first
    assert "the law of motion.2 has a ramp of constant velocity" in second
    assert "no motion" in last

"""Hertz contact of a spherical face: elliptic integrals at 50 digits, published coefficients, geometry, limits."""

from functools import cache

import mpmath as mp
import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ellipe, ellipk
from support.balls.ball import Ball, ball_between, precisely
from support.depth import times
from support.published import ELLIPSES

import camopt
from camopt.core.kernels.compile import compiled
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.jet import Jet
from camopt.core.numerics.point_contact import (
    PRESSURE_ERROR,
    carlson_integrals,
    contact_half_axis_ratio,
    pressure_factor_and_derivative,
    pressure_factor_coefficients,
    pressure_factor_derivatives,
)
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve
from camopt.solve.verdicts.certify import certify

TABLE = pressure_factor_coefficients()
RATIOS = st.floats(-22.9, 22.9).map(lambda x: float(np.exp(x)))
SCENE = {
    "cam": {"form": "disc", "base_radius": 20.0, "rpm": 1500.0},
    "follower": {
        "motion": "translating",
        "contact": "spherical",
        "face_radius": 300.0,
        "dynamics": {"mass": 0.2, "spring_rate": 30.0, "preload": 300.0},
    },
    "motion": [
        {"segment": "rise", "angle": 90.0, "lift": 6.0, "law": "modified-sine"},
        {"segment": "dwell", "angle": 20.0},
        {"segment": "return", "angle": 90.0, "lift": 6.0, "law": "cycloidal"},
        {"segment": "dwell", "angle": 160.0},
    ],
    "materials": {"cam": "steel", "follower": "grey-cast-iron"},
    "outputs": ["hertz"],
}


@cache
def exact(t):
    """h and μ by Johnson's own elliptic integrals, at 50 digits."""
    with mp.workdps(60):
        t = mp.mpf(t)
        turned = t < 1  # Johnson's R' is the larger of the two radii
        ratio = 1 / t if turned else t

        def logarithmic_gap(x):
            k = mp.exp(2 * x)  # (b/a)², by the logarithm of b/a
            e, first = mp.ellipe(1 - k), mp.ellipk(1 - k)
            return mp.log((e / k - first) / (first - e)) - mp.log(ratio)

        guess = -0.6 * mp.log(ratio)
        if abs(ratio - 1) < mp.mpf(10) ** -12:
            slender = ratio ** (-mp.mpf(2) / 3)  # Johnson 4.30: right to the square of what is left
        else:
            slender = mp.exp(mp.findroot(logarithmic_gap, (guess, guess - 0.01), tol=1e-80, maxsteps=200))
        k = slender**2
        e, first = mp.ellipe(1 - k), mp.ellipk(1 - k)
        shape = mp.pi / 4 if k == 1 else (first - e) / (1 - k)
        # A = (p₀/E*)·(b/a²)·(K − E)/e² = 1/(2·R') and N = 2/3·p₀·π·a·b, with R' of the larger radius
        larger = mp.mpf(1) if turned else t
        h = 3 / (8 * mp.pi * larger**2 * slender**3 * shape**2)
        return h, (1 / slender if turned else slender)


@given(RATIOS)
@settings(max_examples=times(30, deep=600))
def test_pressure_and_ellipse_against_fifty_digits(t):
    h, mu = exact(t)
    assert abs(float(pressure_factor_and_derivative(t, TABLE)[0] / h - 1)) <= PRESSURE_ERROR
    assert abs(float(contact_half_axis_ratio(t) / mu - 1)) <= 5e-15


@given(RATIOS)
@settings(max_examples=times(8, deep=150))
def test_slope_of_the_pressure_against_fifty_digits(t):
    with mp.workdps(60):
        slope = (exact(mp.mpf(t) * (1 + mp.mpf(10) ** -15))[0] - exact(mp.mpf(t) * (1 - mp.mpf(10) ** -15))[0]) / (
            2 * mp.mpf(t) * mp.mpf(10) ** -15
        )
        assert abs(float(pressure_factor_and_derivative(t, TABLE)[1] / slope - 1)) <= 1e-12


@given(RATIOS)
@settings(max_examples=times(4, deep=60))
def test_bends_of_the_pressure_against_fifty_digits(t):
    with mp.workdps(60):
        step = mp.mpf(t) * mp.mpf(10) ** -7
        twice_before, before, here, after, twice_after = (exact(mp.mpf(t) + k * step)[0] for k in range(-2, 3))
        second = (before - 2 * here + after) / step**2
        third = (twice_after - 2 * after + 2 * before - twice_before) / (2 * step**3)
        _, _, h2, h3 = pressure_factor_derivatives(np.array(t), TABLE)
        assert abs(float(h2 / second - 1)) <= 1e-9
        assert abs(float(h3 / third - 1)) <= 1e-7


def test_a_sphere_on_a_flat():
    h, h1 = pressure_factor_and_derivative(1.0, TABLE)
    assert h == pytest.approx(6 / np.pi**3, rel=1e-15)
    assert h1 == pytest.approx(-6 / np.pi**3, rel=1e-14)  # both radii alike: t·h is at rest
    assert float(contact_half_axis_ratio(1.0)) == pytest.approx(1.0, rel=1e-15)


@given(RATIOS)
def test_the_two_radii_may_change_places(t):
    """p₀ is that of the same contact turned by a right angle: h(t)/R'' ² = h(1/t)/R'²."""
    assert pressure_factor_and_derivative(t, TABLE)[0] == pytest.approx(
        pressure_factor_and_derivative(1 / t, TABLE)[0] / t**2, rel=1e-14
    )
    assert float(contact_half_axis_ratio(t) * contact_half_axis_ratio(1 / t)) == pytest.approx(1.0, rel=1e-13)


PUBLISHED = {**ELLIPSES, 90: ("1", "1")}


@pytest.mark.parametrize("angle", PUBLISHED)
def test_published_coefficients(angle):
    """a = m·∛(3·N/(4·E*·(A + B))), b = n·∛(…) and cos θ = (B − A)/(A + B), 2·A = 1/R' and 2·B = 1/R''."""
    m, n = map(float, PUBLISHED[angle])
    cosine = np.cos(np.radians(angle))
    t = (1 + cosine) / (1 - cosine)
    half_sum = 0.5 * (1 + 1 / t)
    assert float(1 / contact_half_axis_ratio(t)) == pytest.approx(m / n, rel=4e-3)
    assert float(pressure_factor_and_derivative(t, TABLE)[0]) == pytest.approx(
        6 * half_sum**2 / (np.pi * m * n) ** 3, rel=6e-3
    )


@pytest.mark.parametrize("t", [1e-5, 1e-8, 1e-10])
def test_a_slender_contact_is_nearly_a_line(t):
    """Its half-width becomes that of a line under the pressure of its middle, a = 2·R'·p₀/E*."""
    mu = contact_half_axis_ratio(t)
    b, _ = carlson_integrals(mu)
    assert float(b / (mu * t)) == pytest.approx(1.0, abs=3 * np.log(4 * mu) / mu**2)


def test_signs_on_which_the_bounds_rest():
    h, h1, h2, h3 = pressure_factor_derivatives(np.exp(np.linspace(-23, 23, 40001)), TABLE)
    assert np.all(h > 0) and np.all(h1 < 0) and np.all(h2 > 0) and np.all(h3 < 0)  # noqa: PT018


@compiled
def of_jet(a, table, found):
    z = pressure_factor_and_derivative(Jet(a[0], a[1], a[2], a[3], a[4], a[5]), table)[0]
    found[0], found[1], found[2], found[3], found[4], found[5] = z.low, z.high, z.error, z.first, z.second, z.third


@pytest.mark.one_in(4)
@pytest.mark.parametrize("width", [1e-6, 0.1, 2.0])
@pytest.mark.parametrize("low", [1e-6, 0.01, 0.5, 1.0, 30.0])
def test_jets_hold_the_pressure_over_a_stretch(low, width):
    """t = low + w·(1 − cos s)/2 and t = low + w·(s + s³)/2 over 0 ≤ s ≤ 1: derivatives by s at 50 digits."""
    w = low * width
    for path, jet in (
        (lambda s: low + w * (1 - mp.cos(s)) / 2, (low, low + w / 2, 0.0, w / 2, w / 2, w / 2)),
        (lambda s: low + w * (s + s**3) / 2, (low, low + w, 0.0, 2 * w, 3 * w, 3 * w)),
    ):
        found = np.empty(6)
        of_jet(np.array(jet), TABLE, found)
        uncompiled = pressure_factor_and_derivative(Jet(*jet), TABLE)[0]
        assert [getattr(uncompiled, name) for name in Jet.__slots__] == pytest.approx(list(found), rel=1e-12)
        with mp.workdps(50):
            for s in (0.0, 0.3, 0.7, 1.0):
                value, first, second, third = mp.taylor(lambda x, p=path: exact(p(x))[0], s, 3, h=mp.mpf(10) ** -8)
                assert found[0] * (1 - 1e-14) <= value <= found[1] * (1 + 1e-14)
                for k, (bound, term) in enumerate(zip(found[3:], (first, 2 * second, 6 * third), strict=True)):
                    assert abs(term) <= bound * (1 + 1e-6), k


@given(RATIOS, st.floats(0.0, 3.0))
@settings(max_examples=times(13, deep=250))
@precisely()
def test_balls_and_intervals_hold_the_pressure(low, width):
    high = low * (1 + width)
    interval, slope = pressure_factor_and_derivative(Interval(np.array(low), np.array(high)), TABLE)
    ball, ball_slope = pressure_factor_and_derivative(Ball(ball_between(arb(low), arb(high))), TABLE)
    for share in (0.0, 0.4, 1.0):
        t = min(low + share * (high - low), np.exp(23))
        h, h1 = (float(v) for v in pressure_factor_and_derivative(t, TABLE))
        room = 1e-13 * h
        assert interval.low - room <= h <= interval.high + room
        assert slope.low * (1 + 1e-12) <= h1 <= slope.high * (1 - 1e-12)
        assert ball.arb.lower() - room <= h <= ball.arb.upper() + room
        assert float(ball_slope.arb.lower()) * (1 + 1e-9) <= h1 <= float(ball_slope.arb.upper()) * (1 - 1e-9)


@precisely()
def test_a_ball_has_far_more_digits_than_a_number():
    ball = pressure_factor_and_derivative(Ball(0.03), TABLE)[0].arb
    assert float(ball.rad()) < 1e-50
    assert abs(mp.mpf(ball.mid().str(45, radius=False)) / exact(0.03)[0] - 1) < 1e-43


@precisely()
def test_outside_the_table():
    for t in (0.0, -1.0, 1e-11):
        jet = pressure_factor_and_derivative(Jet(t, 1.0, 0.0, 1.0, 1.0, 1.0), TABLE)[0]
        assert jet.high == np.inf
        assert jet.second == np.inf
        interval = pressure_factor_and_derivative(Interval(np.array(t), np.array(1.0)), TABLE)[0]
        assert interval.high == np.inf
        assert not pressure_factor_and_derivative(Ball(min(t, 0.0)), TABLE)[0].arb < 1e300
    assert pressure_factor_and_derivative(Interval(np.array(1.0), np.array(1e11)), TABLE)[0].low == 0.0
    assert np.isfinite(pressure_factor_and_derivative(np.array([-1.0, 0.0, 1e-300, 1e300]), TABLE)).all()


def sampled_stress(scene):
    """Largest p₀ on a grid: force along the normal, Johnson's K and E, curvature by differences of the points.

    These are off by the step where y''' jumps.
    """
    problem = resolve(scene)
    programme, setup, design = problem.programme, problem.setup, problem.design
    angles = np.linspace(0, 2 * np.pi, 14401)[:-1]
    curves = cam_curves(setup.mechanism, design, programme, angles)
    points, step = curves.profile[0], angles[1]
    first = (np.roll(points, -1) - np.roll(points, 1)) / (2 * step)
    second = (np.roll(points, -1) - 2 * points + np.roll(points, 1)) / step**2
    bend = (np.conj(first) * second).imag / np.abs(first) ** 3 * -design.sense
    y, _, y2, _ = programme.motion_at(angles)
    d = setup.dynamics
    force = d.mass * setup.omega**2 * y2 + d.stiffness * y + d.preload
    normal = curves.normal * np.exp(1j * design.sense * angles)  # in the ground frame
    force = force / normal.imag
    sphere = design.roller_radius[0]
    curvatures = np.sort([1 / sphere + bend, np.full_like(bend, 1 / sphere)], axis=0)
    low, high = np.full(bend.shape, 1e-9), np.full(bend.shape, 1 - 1e-9)
    for _ in range(60):  # Johnson 4.28: (b/a)² by halving
        k = 0.5 * (low + high)
        e, first = ellipe(1 - k), ellipk(1 - k)
        slenderer = (e / k - first) / (first - e) > curvatures[1] / curvatures[0]
        low, high = np.where(slenderer, k, low), np.where(slenderer, high, k)
    k = 0.5 * (low + high)
    shape = (ellipk(1 - k) - ellipe(1 - k)) / (1 - k)
    modulus = setup.bodies.modulus
    a = np.cbrt(3 * force / (np.pi * modulus) * shape / curvatures[0])
    return np.max(3 * force / (2 * np.pi * a * a * np.sqrt(k)))


CASES = {
    "translating": {},
    "small face": {"follower.face_radius": 15.0, "cam.base_radius": 35.0, "follower.offset": 4.0},
    "swinging": {
        "follower.motion": "oscillating", "follower.arm_length": 80.0, "follower.centre_distance": 110.0,
        "follower.face_radius": 60.0, "cam.base_radius": 40.0,
        "follower.dynamics": {"inertia": 1e-3, "spring_rate": 40.0, "preload": 20.0},
    },
}  # fmt: skip


@pytest.mark.parametrize("case", ["translating", "small face"])
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_stress_of_a_cam_against_its_points(case, rotation):
    scene = camopt.Scene.from_dict(SCENE).replace(**CASES[case], **{"cam.rotation": rotation})
    assert camopt.evaluate(scene)["contact_stress_max_MPa"] == pytest.approx(sampled_stress(scene), rel=5e-5)


@pytest.mark.parametrize("case", CASES)
def test_half_axes_carry_the_load(case):
    """N = 2/3·π·a·b·p₀ where the stress is largest: no more than the largest force, and scaling of all with it."""
    scene = camopt.Scene.from_dict(SCENE).replace(**CASES[case], outputs=["hertz", "thrust"])
    found = camopt.evaluate(scene)
    a, b, p = (found[f"contact_{n}"] for n in ("half_width_mm", "half_length_mm", "stress_max_MPa"))
    assert 0 < 2 / 3 * np.pi * a * b * p <= found["normal_force_max_N"] * (1 + 1e-9)
    dynamics = {name: 8 * value for name, value in scene.follower.dynamics if value is not None}
    heavier = camopt.evaluate(scene.replace(**{"follower.dynamics": dynamics}))
    for name in ("contact_stress_max_MPa", "contact_half_width_mm", "contact_half_length_mm"):
        assert heavier[name] == pytest.approx(2 * found[name], rel=1e-6)


def test_base_circle_at_rest_under_preload():
    """A hard spring and no speed: the stress is that of the base circle or the top, by Johnson's formula."""
    scene = camopt.Scene.from_dict(SCENE).replace(
        **{"cam.rpm": 1e-3, "follower.dynamics": {"mass": 0.2, "preload": 500.0}, "motion": [
            {"segment": "rise", "angle": 170.0, "lift": 1e-6, "law": "cycloidal"},
            {"segment": "return", "angle": 170.0, "lift": 1e-6, "law": "cycloidal"},
            {"segment": "dwell", "angle": 20.0}]}
    )  # fmt: skip
    found, modulus = camopt.evaluate(scene), resolve(scene).setup.bodies.modulus
    t = 20 / 320
    pressure = (float(exact(t)[0]) * 500 * (modulus / 300) ** 2) ** (1 / 3)
    assert found["contact_stress_max_MPa"] == pytest.approx(pressure, rel=1e-6)
    assert found["contact_half_length_mm"] / found["contact_half_width_mm"] == pytest.approx(
        float(exact(t)[1]), rel=1e-6
    )


@pytest.mark.slow
def test_the_limit_in_evaluate_certify_and_optimise():
    scene = camopt.Scene.from_dict(SCENE)
    stress = camopt.evaluate(scene)["contact_stress_max_MPa"]
    for factor, held in ((1 + 1e-9, True), (1 - 1e-9, False)):
        limited = scene.replace(**{"limits.contact_stress": stress * factor})
        assert camopt.evaluate(limited)["feasible"] is held
        assert certify(limited)["contact_stress"] == ("held" if held else "broken")
    space = {"limits.contact_stress": 640.0, "search.base_radius": {"start": 12.0, "stop": 40.0, "step": 0.5}}
    swept = camopt.sweep(scene.replace(**space, **{"search.minimise": "base_radius_mm"}))
    (best,) = swept.best.values()
    assert best["base_radius_mm"] == 20.0
    bound = camopt.evaluate(scene.replace(**{"cam.base_radius": 25.0}))["contact_stress_max_MPa"]
    least = camopt.optimise(scene.replace(**{**space, "limits.contact_stress": bound})).best
    assert least["base_radius_mm"] == pytest.approx(25.0, rel=1e-8)
    assert least["contact_stress_max_MPa"] == pytest.approx(bound, rel=1e-8)


def test_what_is_missing_is_named():
    with pytest.raises(camopt.BadInput, match=r"needs materials\.cam, materials\.follower"):
        camopt.evaluate(camopt.Scene.from_dict({**SCENE, "materials": {}, "limits": {"contact_stress": 900.0}}))


def test_a_corner_of_the_motion_has_no_finite_stress():
    motion = [{**m, "law": "uniform"} if "law" in m else m for m in SCENE["motion"]]
    found = camopt.evaluate(camopt.Scene.from_dict({**SCENE, "motion": motion}))
    assert found["contact_stress_max_MPa"] == np.inf
    assert not np.isnan([v for v in found.values() if isinstance(v, float)]).any()

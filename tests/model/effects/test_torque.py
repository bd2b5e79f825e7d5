"""Torque of the camshaft: against 50 digits, closed forms, balances and identities."""

import json
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import comb, cos, inf, isnan, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import fp, mp
from numpy.polynomial import chebyshev, polynomial
from support import naive, own
from support.depth import times
from support.dynamics import Dynamics

from camopt import BadInput, Scene, certify, evaluate, load, optimise, sweep
from camopt.core.numerics.panel_series import integrate_series, largest_value_of_series, turn_integral
from camopt.core.numerics.piecewise import powers_to_bernstein_matrix
from camopt.model.effects import force
from camopt.model.effects.torque import torque_over_turn, torque_polynomials_by_panel
from camopt.model.motion import LAWS
from camopt.model.motion.law import is_symmetric
from camopt.model.motion.programme import Programme

SYMMETRIC = [law for law in own.STILL if is_symmetric(own.EVERY[law])]
RPM = 750.0
FULL = {
    "mass": 0.4,
    "spring_rate": 3.0,
    "preload": 40.0,
    "damping": 0.02,
    "load": 15.0,
    "fluctuation": 0.05,
}
SWINGING = {
    "inertia": 0.006,
    "spring_rate": 20.0,
    "preload": 4.0,
    "damping": 0.05,
    "load": -1.0,
    "fluctuation": 0.02,
}
UP_DOWN = (("rise", 110), ("dwell", 50), ("return", 95), ("dwell", 105))


def motion(law, lift=30.0, strokes=UP_DOWN):
    moving = {"lift": lift, "law": law}
    return [{"segment": kind, "angle": angle, **(moving if kind != "dwell" else {})} for kind, angle in strokes]


def cam(segments, dynamics, *, swinging=False, rpm=RPM, **more):
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 8}
    if swinging:
        follower |= {"motion": "oscillating", "arm_length": 110, "centre_distance": 130}
    return Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 60, "rpm": rpm},
            "follower": {**follower, "dynamics": dynamics},
            "motion": segments,
            "outputs": ["torque"],
            **more,
        }
    )


def programme(*segments, angular=False):
    return Programme.from_segments(segments, angular=angular, laws=own.EVERY)


def turn(law, lift=30.0):
    return programme(*((kind, angle, lift if kind != "dwell" else 0.0, law) for kind, angle in UP_DOWN))


def approx_value(value, rel=1e-12):
    return pytest.approx(float(value), rel=rel)


# ------------------------------------------------------------------------------------------------ 50 digits


def slow_torque(dynamics, swinging, ctx):
    """T in N·m as a state of ``naive``: SI units throughout."""
    given = {key: ctx.mpf(value) for key, value in dynamics.items()}
    omega = ctx.mpf(RPM) * 2 * ctx.pi / 60
    inertia = given["inertia" if swinging else "mass"]
    length, per_length = (1, 1) if swinging else (ctx.mpf(1) / 1000, 1000)  # mm to m, N/mm to N/m

    def state(theta, jet):
        y, y1, y2 = (derivative * length for derivative in jet[:3])
        force = inertia * omega**2 * y2 + given["preload"] + given["load"]
        force += per_length * (given["damping"] * omega * y1 + given["spring_rate"] * y)
        return {"torque": force * y1}

    return state


def crossings(function, rough, start, end, count=400):
    """Where a function changes its sign: bracketed in floats, found at 50 digits."""
    nodes = [start + (end - start) * k / count for k in range(count + 1)]
    signs = [rough(float(node)) > 0 for node in nodes]
    found = []
    for (low, high), (a, b) in zip(pairwise(nodes), pairwise(signs), strict=True):
        if a != b:
            found.append(mp.findroot(function, (low, high), solver="anderson", verify=False))
    return found


def slow_quantities(segments, dynamics, swinging):
    """Every quantity of a smooth motion, by quadrature of T; W as the running integral of T less its mean."""
    with mp.workdps(50):
        pieces, coarse = (naive.programme(segments, ctx, swinging) for ctx in (mp, fp))
        state, rough = (slow_torque(dynamics, swinging, ctx) for ctx in (mp, fp))
        found = naive.spans(pieces, coarse, state, rough)
        omega = mp.mpf(RPM) * 2 * mp.pi / 60

        def torque(piece, state=state):
            return lambda theta: state(theta, piece.jet(theta))["torque"]

        def quad(function, start, end):
            return mp.quad(function, (start, end), method="gauss-legendre")  # all is analytic on a piece

        def squared_torque(piece):
            return lambda theta: torque(piece)(theta) ** 2

        def excess(piece, state=state):
            return lambda theta: torque(piece, state)(theta) - mean

        moving = [p for p in pieces if p.kind != "dwell"]
        mean = sum(quad(torque(p), p.start, p.end) for p in moving) / (2 * mp.pi)
        square = sum(quad(squared_torque(p), p.start, p.end) for p in moving) / (2 * mp.pi)
        work = [mp.zero]
        for p, q in zip(pieces, coarse, strict=True):
            inside = crossings(excess(p), excess(q, rough), p.start, p.end) if p.kind != "dwell" else []
            for low, high in pairwise([p.start, *inside, p.end]):
                work.append(work[-1] + quad(excess(p), low, high))
        peak, energy = naive.turn_abs(found, "torque", naive.TURN)[0], max(work) - min(work)
        return {
            "torque_max_N_m": naive.turn_max(found, "torque", naive.TURN)[0],
            "torque_min_N_m": naive.turn_min(found, "torque", naive.TURN)[0],
            "torque_peak_N_m": peak,
            "torque_mean_N_m": mean,
            "torque_rms_N_m": mp.sqrt(square),
            "power_peak_W": peak * omega,
            "power_mean_W": mean * omega,
            "energy_fluctuation_J": energy,
            "flywheel_inertia_kg_m2": energy / (mp.mpf(dynamics["fluctuation"]) * omega**2),
        }


@cache
def expected_quantities(law, swinging):
    return slow_quantities(motion(law, 15.0 if swinging else 30.0), SWINGING if swinging else FULL, swinging)


@pytest.mark.one_in(9)
@pytest.mark.parametrize("swinging", [False, True])
@pytest.mark.parametrize("law", [law for law in own.STILL if law in LAWS])
def test_all_quantities_against_fifty_digits(law, swinging):
    segments = motion(law, 15.0 if swinging else 30.0)
    dynamics = SWINGING if swinging else FULL
    found = evaluate(cam(segments, dynamics, swinging=swinging))
    for name, expected in expected_quantities(law, swinging).items():
        assert found[name] == approx_value(expected), name


# --------------------------------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("stiffness", [0.0, 0.4, 2.0, 30.0])
@pytest.mark.parametrize("preload", [0.0, 20.0, 300.0])
def test_a_sinusoidal_follower(stiffness, preload):
    """y = h/2·(1 − cos θ) without damping: T = A·sin θ + B·sin θ·cos θ, W = A·(1 − cos θ) + B/2·sin² θ."""
    h, mass, omega = 0.02, 0.5, 60 * 2 * pi  # SI
    dynamics = {"mass": mass, "spring_rate": stiffness, "preload": preload, "fluctuation": 0.04}
    whole = motion("harmonic", 1e3 * h, [("rise", 180), ("return", 180)])
    found = evaluate(cam(whole, dynamics, rpm=3600))
    k = 1e3 * stiffness
    a, b = h / 2 * (k * h / 2 + preload), h**2 / 4 * (mass * omega**2 - k)
    roots = [(-a + side * sqrt(a * a + 8 * b * b)) / (4 * b) for side in (1, -1)]
    peak = max(abs((a + b * x) * sqrt(1 - x * x)) for x in roots if abs(x) <= 1)
    works = [0.0, 2 * a, *([(a + b) ** 2 / (2 * b)] if abs(a) < abs(b) else [])]
    energy = max(works) - min(works)
    assert found["torque_max_N_m"] == approx_value(peak)
    assert found["torque_min_N_m"] == approx_value(-peak)
    assert found["power_peak_W"] == approx_value(peak * omega)
    assert found["torque_rms_N_m"] == approx_value(sqrt((a * a + b * b / 4) / 2))
    assert found["torque_mean_N_m"] == 0.0
    assert found["energy_fluctuation_J"] == approx_value(energy)
    assert found["flywheel_inertia_kg_m2"] == approx_value(energy / (0.04 * omega**2))


def test_a_damped_sinusoidal_follower_takes_what_the_damper_takes():
    """P = c·v² on average: c·(ω·h/2)²/2."""
    scene = cam(motion("harmonic", 20.0, [("rise", 180), ("return", 180)]), {"mass": 0.1, "damping": 0.05})
    omega, h = RPM * pi / 30, 0.02
    assert evaluate(scene)["power_mean_W"] == approx_value(50.0 * (omega * h / 2) ** 2 / 2)


@pytest.mark.parametrize("law", ["modified-sine", "poly345", "modified-trapezoid"])
def test_a_turn_that_takes_nothing_has_no_mean_torque(law):
    """What goes into mass and spring comes back: what rounding leaves of it is no torque."""
    dynamics = {"mass": 3.0, "spring_rate": 2.0, "preload": 70.0}
    found = evaluate(cam(motion(law, 60.0), dynamics))
    assert (found["torque_mean_N_m"], found["power_mean_W"]) == (0.0, 0.0)
    assert found["torque_rms_N_m"] > 0.1


PRODUCTS = {"harmonic": pi**3 / 8, "parabolic": 8.0, "cycloidal": 1.5 * sqrt(3) * pi}


@pytest.mark.parametrize("law", PRODUCTS)
def test_inertia_torque_has_the_known_product_of_velocity_and_acceleration(law):
    """Largest v·a of the unit stroke, the torque characteristic; ``support.published`` has it of two more laws."""
    h, angle, omega, mass = 0.03, radians(110), RPM * pi / 30, 0.4
    found = evaluate(cam(motion(law, strokes=[("rise", 110), ("dwell", 70), ("return", 180)]), {"mass": mass}))
    characteristic = found["torque_max_N_m"] / (mass * omega**2 * h**2 / angle**3)
    assert characteristic == approx_value(PRODUCTS[law])


# ------------------------------------------------------------------------------------- balances, identities


def over_turn(shape, dynamics, omega):
    return torque_over_turn(shape, *force.force_factors_with_train(dynamics, omega))


def series_of(shape, dynamics, omega):
    return torque_polynomials_by_panel(shape, force.force_factors_with_train(dynamics, omega))[:, 0]


@pytest.mark.parametrize("law", own.STILL)
def test_the_energy_balance_closes(law):
    """∮T dθ is what the damper takes: by the panels' integrals, and by Gauss points on the laws themselves."""
    shape, dynamics, omega = turn(law), Dynamics(4e-4, 0.02, 3.0, 40.0, 15.0), RPM * pi / 30
    found, series = over_turn(shape, dynamics, omega), series_of(shape, dynamics, omega)
    assert abs(turn_integral(shape.table.half_width, series) - 2 * pi * found.mean) < 1e-13 * found.rms
    nodes, weights = np.polynomial.legendre.leggauss(24)
    taken = 0.0
    for centre, half in zip(shape.table.centre, shape.table.half_width, strict=True):
        taken += half * weights @ shape.motion_at(centre + half * nodes)[1] ** 2
    assert 2 * pi * found.mean == approx_value(dynamics.damping * omega * taken)
    assert (
        abs(integrate_series(shape.table.half_width, series).sum(axis=0)[-1] - 2 * pi * found.mean)
        < 1e-13 * found.rms
    )


@pytest.mark.parametrize("law", own.STILL)
def test_inertia_is_linear_in_mass_and_square_in_speed(law):
    light, heavy = (over_turn(turn(law), Dynamics(mass), 50.0) for mass in (1e-3, 2e-3))
    fast = over_turn(turn(law), Dynamics(1e-3), 100.0)
    assert heavy == tuple(2.0 * value for value in light)
    assert fast == tuple(4.0 * value for value in light)
    full = {"damping": 0.02, "stiffness": 3.0, "preload": 40.0}
    once, twice = (series_of(turn(law), Dynamics(mass, **full), 50.0) for mass in (1e-3, 2e-3))
    alone = series_of(turn(law), Dynamics(1e-3), 50.0)
    assert np.abs(twice - once - alone).max() < 1e-14 * np.abs(twice).max()


@pytest.mark.parametrize("law", SYMMETRIC)
def test_the_programme_backwards_mirrors_the_torque(law):
    """y(−θ): what stores energy turns its torque round, what takes it does not."""
    low, high = ("dwell", 90, 0, None), ("dwell", 40, 0, None)
    there = programme(("rise", 100, 20, law), high, ("return", 130, 20, law), low)
    back = programme(low, ("rise", 130, 20, law), high, ("return", 100, 20, law))
    free, damped = Dynamics(1e-3, 0.0, 3.0, 40.0), Dynamics(1e-3, 0.05, 3.0, 40.0)
    a, b = over_turn(there, free, 70.0), over_turn(back, free, 70.0)
    assert (a.largest, -a.least) == (approx_value(-b.least), approx_value(b.largest))
    assert (a.rms, a.fluctuation) == (approx_value(b.rms), approx_value(b.fluctuation))
    assert over_turn(there, damped, 70.0).mean == approx_value(over_turn(back, damped, 70.0).mean)


def test_units_of_a_swinging_follower_are_those_of_a_translating_one():
    """A moment of 1 N·m over 1 rad is a force of 1 N over 1 m, as is any other pair of the keys."""
    slide = {"mass": 0.2, "spring_rate": 0.015, "preload": 30.0, "damping": 0.0004}
    swing = {"inertia": 0.2, "spring_rate": 15.0, "preload": 30.0, "damping": 0.4}
    along = evaluate(cam(motion("poly345", 1e3 * radians(15.0)), slide))
    about = evaluate(cam(motion("poly345", 15.0), swing, swinging=True))
    for name in ("torque_max_N_m", "torque_min_N_m", "torque_rms_N_m", "power_mean_W", "energy_fluctuation_J"):
        assert along[name] == approx_value(about[name]), name


positive = st.floats(1e-3, 1e3)
either = st.floats(-1e3, 1e3)


@given(
    st.sampled_from(sorted(own.EVERY)),
    st.sampled_from(sorted(own.EVERY)),
    st.tuples(*[st.floats(1e-6, 1e3)] * 2),
    st.tuples(*[st.floats(0.0, 1e3)] * 4, either).map(lambda given: Dynamics(*given)),
    positive,
)
@settings(max_examples=times(75, deep=1500))
def test_any_dynamics_gives_numbers_in_their_order(rise, fall, sizes, dynamics, omega):
    lift, share = sizes[0], sizes[1] / (sizes[1] + 10.0)
    up = 1e-3 + 358.0 * share
    shape = programme(("rise", up, lift, rise), ("return", 360.0 - up, lift, fall))
    found = over_turn(shape, dynamics, omega)
    assert not any(map(isnan, found))
    slack = 1e-9 * max(abs(v) for v in (*found, 1e-300) if abs(v) < inf)
    assert found.least - slack <= found.mean <= found.largest + slack
    assert abs(found.mean) - slack <= found.rms <= max(found.largest, -found.least) + slack
    assert 0.0 <= found.fluctuation < inf
    if found.rms < inf:
        samples = polynomial.polyval(np.linspace(-1, 1, 33), series_of(shape, dynamics, omega))
        assert found.least - slack <= samples.min()
        assert samples.max() <= found.largest + slack


# -------------------------------------------------------------------------------------------------- corners


def test_corners_make_the_torque_infinite_and_say_why():
    scene = cam(motion("uniform"), FULL)
    found = evaluate(scene)
    assert (found["torque_max_N_m"], found["torque_min_N_m"]) == (inf, -inf)
    assert found["torque_peak_N_m"] == found["torque_rms_N_m"] == found["power_peak_W"] == inf
    infinite = [name for name, value in found.items() if value in (inf, -inf)]
    assert {"torque_max_N_m", "power_peak_W"} <= set(infinite) == set(found.unbounded)
    assert found.unbounded["torque_rms_N_m"].startswith("the velocity jumps at 0°, 110°, 160°, 255°, by at most ")
    json.dumps(found.to_dict(), allow_nan=False)
    omega = RPM * pi / 30
    squares = 0.03**2 / radians(110) + 0.03**2 / radians(95)  # ∮y'² dθ of straight lines, m²
    assert found["torque_mean_N_m"] == approx_value(20.0 * omega * squares / (2 * pi))


@pytest.mark.parametrize("strokes", [UP_DOWN, [("rise", 110), ("return", 250)]])
def test_energy_at_corners_is_the_kinetic_energy_they_give_and_take(strokes):
    """A mass alone: W = m·v²/2, and 0 within a corner that turns the motion round."""
    found = evaluate(cam(motion("uniform", strokes=strokes), {"mass": 0.4}))
    fastest = 0.03 / radians(min(angle for kind, angle in strokes if kind != "dwell")) * RPM * pi / 30
    assert found["energy_fluctuation_J"] == approx_value(0.4 * fastest**2 / 2)


def test_a_corner_where_the_speed_only_grows_is_infinite_upwards_only():
    kicked = {"degree": 3, "knots": [0.0] * 4 + [1.0] * 4, "coefficients": [0.0, 0.5, 1.0, 1.0]}
    segments = motion("poly345")
    segments[0]["law"] = "kicked"
    found = evaluate(cam(segments, FULL, laws={"kicked": kicked}))
    assert (found["torque_max_N_m"], found["torque_rms_N_m"]) == (inf, inf)
    assert -inf < found["torque_min_N_m"] < 0.0
    assert "torque_min_N_m" not in found.unbounded


# --------------------------------------------------------------------------------------------------- limits


@pytest.mark.slow
@pytest.mark.parametrize("swinging", [False, True])
@pytest.mark.parametrize(("limit", "quantity"), [("torque", "torque_peak_N_m"), ("power", "power_peak_W")])
def test_limits_hold_on_one_side_of_the_fifty_digit_peak_and_break_on_the_other(limit, quantity, swinging):
    segments, dynamics = motion("modified-sine", 15.0 if swinging else 30.0), SWINGING if swinging else FULL
    peak = float(expected_quantities("modified-sine", swinging)[quantity])
    for share, verdict in ((1e-12, "held"), (-1e-12, "broken")):
        scene = cam(segments, dynamics, swinging=swinging, limits={limit: peak * (1.0 + share)})
        assert certify(scene)[limit] == verdict
        found = evaluate(scene)
        assert (limit in found["violated"].split(",")) == (verdict == "broken")
        assert found["status"] == "certified"


def test_a_limit_at_a_corner_is_broken():
    scene = cam(motion("uniform"), FULL, limits={"torque": 1e9, "power": 1e9})
    assert {certify(scene)[name] for name in ("torque", "power")} == {"broken"}
    assert {"torque", "power"} <= set(evaluate(scene)["violated"].split(","))


def test_the_smallest_cam_is_blamed_on_the_torque_that_no_size_mends():
    search = {"base_radius": {"start": 30, "stop": 90}, "law": ["modified-sine", "cycloidal"]}
    scene = cam(motion("cycloidal"), FULL, search=search)
    peaks = {law: evaluate(scene.replace(motion=motion(law)))["torque_peak_N_m"] for law in search["law"]}
    assert peaks["modified-sine"] < peaks["cycloidal"]
    bound = sqrt(peaks["modified-sine"] * peaks["cycloidal"])
    found = optimise(scene.replace(limits={"torque": bound, "pressure_angle": 30}))
    assert found.best["law_rise"] == "modified-sine"
    assert found.best["torque_peak_N_m"] <= bound
    assert found.obstacles == {"cycloidal": "torque"}


def test_a_sweep_drops_the_designs_of_a_law_that_exceeds_the_torque(tmp_path):
    search = {"base_radius": {"start": 40, "stop": 60, "step": 10}, "law": ["modified-sine", "cycloidal"]}
    scene = cam(motion("cycloidal"), FULL, search=search)
    peaks = [evaluate(scene.replace(motion=motion(law)))["torque_peak_N_m"] for law in search["law"]]
    sweep(scene.replace(limits={"torque": sum(peaks) / 2}), tmp_path, keep="feasible")
    found = load(tmp_path / "designs.parquet")
    assert set(found["law_rise"]) == {"modified-sine"}
    assert found["torque_peak_N_m"].to_numpy() == pytest.approx(peaks[0], rel=1e-15)


@pytest.mark.parametrize(
    ("dynamics", "rpm", "asked", "lacks"),
    [
        ({"spring_rate": 3}, 100, "torque_rms_N_m", "needs follower.dynamics.mass"),
        ({"mass": 3}, None, "power_mean_W", "needs cam.rpm"),
        ({"mass": 3}, 100, "flywheel_inertia_kg_m2", "needs follower.dynamics.fluctuation"),
    ],
)
def test_what_a_quantity_lacks_is_named(dynamics, rpm, asked, lacks):
    with pytest.raises(BadInput) as raised:
        evaluate(cam(motion("poly345"), dynamics, rpm=rpm).replace(outputs=[asked]))
    assert lacks in str(raised.value)


def test_a_limit_on_torque_needs_a_mass_and_a_speed():
    with pytest.raises(BadInput) as raised:
        evaluate(cam(motion("poly345"), {"spring_rate": 3}, rpm=None, limits={"torque": 3, "power": 5}))
    assert str(raised.value).count("needs cam.rpm, follower.dynamics.mass") == 2


# ------------------------------------------------------------------------------------------------- numerics


@pytest.mark.parametrize("degree", [1, 3, 12, 24])
def test_bernstein_coefficients_are_those_of_powers(degree):
    u, t = Fraction(1, 3), Fraction(2, 3)
    basis = [comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)]
    for power, column in enumerate(powers_to_bernstein_matrix(degree).T):
        found = sum(b * Fraction(float(c)) for b, c in zip(basis, column, strict=True))
        assert abs(found - u**power) < Fraction(1, 2**52)
        assert np.abs(column).max() == 1.0


@given(st.lists(st.floats(-1.0, 1.0, allow_subnormal=False), min_size=2, max_size=25))
def test_largest_of_a_series_against_the_roots_of_its_slope(coefficients):
    series = polynomial.polymul(chebyshev.cheb2poly(coefficients), [1.0])
    slope = chebyshev.chebder(np.array(coefficients))
    roots = chebyshev.chebroots(chebyshev.chebtrim(slope, 1e-13 * np.abs(slope).max()))
    inside = roots.real[np.abs(roots.real) < 1.0]
    values = chebyshev.chebval(np.array([-1.0, 1.0, *inside, *np.linspace(-1, 1, 99)]), coefficients)
    scale = max(np.abs(series).sum(), 1e-300)
    assert largest_value_of_series(series[:, None]) == pytest.approx(values.max(), abs=1e-12 * scale)


def test_largest_of_flat_and_of_waving_series():
    assert largest_value_of_series(np.full((1, 5), 3.0)) == 3.0
    assert largest_value_of_series(np.zeros((8, 3))) == 0.0
    waves = chebyshev.cheb2poly([0.0] * 9 + [1.0])[:, None]
    assert largest_value_of_series(waves) == pytest.approx(1.0, abs=1e-12)
    third = np.array([cos(pi / 9), sin(pi / 9), -1.0])[:, None]  # a parabola: its top has a closed form
    assert largest_value_of_series(third) == pytest.approx(cos(pi / 9) + sin(pi / 9) ** 2 / 4, rel=1e-14)

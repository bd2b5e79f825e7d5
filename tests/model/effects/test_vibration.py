"""The elastic follower train against 50 digits, an integrator of differential equations, and closed forms."""

from math import inf, isfinite, isinf, pi

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from support import own
from support.depth import times
from support.dynamics import Dynamics

import camopt
from camopt.core.numerics import wave_extremes
from camopt.core.numerics.oscillator import is_resonant
from camopt.core.numerics.wave_extremes import wave_maximum, wave_minimum, wave_peak_magnitude
from camopt.model.effects.force import force_weights_and_constant
from camopt.model.effects.vibration import (
    dynamic_factor,
    least_elastic_contact_force,
    mass_acceleration_wave,
    steady_vibration_wave,
    velocity_jump_by_panel,
    vibration_extremes,
)
from camopt.model.motion.programme import Programme, derivative_peak
from camopt.model.motion.stroke import ALL_STROKES, DWELL

mp = mpmath.MPContext()
mp.dps = 50
U = np.linspace(-1.0, 1.0, 9)
RATIOS = (1e-4, 0.03, 0.4, 0.97, 1.02, 2.6, 7.3, 19.8, 45.1, 130.7, 1000.4, 1e5 + 0.3)


def programme(*segments):
    return Programme.from_segments(segments, angular=False, laws=own.EVERY)


def two_strokes(rise, fall):
    return programme(
        ("rise", 100, 20, rise), ("dwell", 60, 0, None), ("return", 120, 20, fall), ("dwell", 80, 0, None)
    )


# ------------------------------------------------------------------------------------------------ 50 digits

PI = +mp.pi
A_SINE, A_TRAPEZOID = 4 * PI**2 / (4 + PI), 8 * PI / (2 + PI)


def sine(size, rate, shift):
    """size·sin(rate·(x − shift)) as (coefficient, exponent) of exponentials e^{iκx}."""
    turned = mp.expj(-rate * shift)
    return [(size * turned / 2j, rate), (-size * mp.conj(turned) / 2j, -rate)]


ACCELERATIONS = {  # pieces (from, to, exponentials) of the acceleration of the unit stroke
    "cycloidal": [(0, 1, sine(2 * PI, 2 * PI, 0))],
    "harmonic": [(0, 1, sine(-(PI**2) / 2, PI, mp.mpf(1) / 2))],
    "parabolic": [(0, 0.5, [(4, 0)]), (0.5, 1, [(-4, 0)])],
    "uniform": [],
    "modified-sine": [
        (0, 0.125, sine(A_SINE, 4 * PI, 0)),
        (0.125, 0.875, sine(-A_SINE, 4 * PI / 3, mp.mpf(1) / 2)),
        (0.875, 1, sine(A_SINE, 4 * PI, 1)),
    ],
    "modified-trapezoid": [
        (0, 0.125, sine(A_TRAPEZOID, 4 * PI, 0)),
        (0.125, 0.375, [(A_TRAPEZOID, 0)]),
        (0.375, 0.625, sine(-A_TRAPEZOID, 4 * PI, 0.5)),
        (0.625, 0.875, [(-A_TRAPEZOID, 0)]),
        (0.875, 1, sine(A_TRAPEZOID, 4 * PI, 1)),
    ],
}


def forces(turn):
    """−y″ as (from, to, exponentials) by cam angle, and −Δy′ as (angle, size), for 50 digits."""
    pieces, kicks = [], []
    for stroke in turn.strokes:
        start, angle = mp.mpf(stroke.start), mp.mpf(stroke.angle)
        lift = mp.mpf(stroke.high) - mp.mpf(stroke.low)
        if stroke.law is None:
            continue
        for low, high, terms in ACCELERATIONS[stroke.law.NAME]:
            moved = [(-lift / angle**2 * c * mp.expj(-k * start / angle), k / angle) for c, k in terms]
            pieces.append((start + low * angle, start + high * angle, moved))
        if stroke.law.NAME == "uniform":
            kicks += [(start, -lift / angle), (start + angle, lift / angle)]
    return pieces, kicks


def exact_response(turn, ratio, damping, angle):
    """z and z′ at a cam angle inside a panel, from q′ = μq − y″ with μ = r(−ζ + i·w): z = Im q/(r·w)."""
    r, damping, angle = mp.mpf(ratio), mp.mpf(damping), mp.mpf(angle)
    w = mp.sqrt(1 - damping**2)
    mu, turned = r * mp.mpc(-damping, w), 2 * PI
    pieces, kicks = forces(turn)
    total = mp.mpc(0)
    repeated = 1 / (1 - mp.exp(mu * turned))  # of all turns before
    for low, high, terms in pieces:
        for begin, end, back in ((low, min(high, angle), 0), (max(low, angle), high, turned)):
            if begin < end:
                for c, k in terms:
                    rate = mp.mpc(0, k) - mu
                    grown = mp.exp(rate * end + mu * (angle + back)) - mp.exp(rate * begin + mu * (angle + back))
                    total += c * grown / rate
    for at, size in kicks:
        total += size * mp.exp(mu * (angle - at + (0 if at < angle else turned)))
    q = total * repeated
    return mp.im(q) / (r * w), mp.im(mu * q) / (r * w)


TURNS = {
    "smooth": two_strokes("cycloidal", "modified-sine"),
    "jumps": two_strokes("parabolic", "harmonic"),
    "corners": two_strokes("uniform", "modified-trapezoid"),
}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("damping", [0.0, 0.03, 0.9])
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("turn", TURNS)
def test_the_response_against_fifty_digits(turn, ratio, damping):
    table, wave = TURNS[turn].table, steady_vibration_wave(TURNS[turn], ratio, damping)
    u = np.array([-0.83, 0.41])
    z, slope = wave.values_on_all_panels(u)[:, 0], wave.slope().values_on_all_panels(u)[:, 0]
    scale, steepest = np.abs(wave.values_on_all_panels(U)).max(), np.abs(wave.slope().values_on_all_panels(U)).max()
    for panel in range(0, len(table.centre), 5):
        for k in range(2):
            at = mp.mpf(table.centre[panel]) + mp.mpf(u[k]) * mp.mpf(table.half_width[panel])
            expected = exact_response(TURNS[turn], ratio, damping, at)
            room = 1e-13 + 1e-15 * ratio  # the rounding of the phase
            assert abs(expected[0] - z[k, panel]) <= room * scale
            assert abs(expected[1] - slope[k, panel]) <= room * steepest


@pytest.mark.parametrize("damping", [0.0, 0.2, 0.7])
@pytest.mark.parametrize("ratio", [0.2, 1.7, 12.3, 400.5, 1e4 + 0.4])
def test_a_harmonic_motion_over_the_whole_turn_in_closed_form(ratio, damping):
    h, omega = 20.0, 30.0
    turn = programme(("rise", 180, h, "harmonic"), ("return", 180, h, "harmonic"))
    r = mp.mpf(ratio)
    stiff = r**2 + 2j * damping * r
    z, x = (-h / 2) / (stiff - 1), (-h / 2) * stiff / (stiff - 1)
    found = vibration_extremes(turn, ratio, damping)
    assert found.overshoot == pytest.approx(float(abs(z)), rel=1e-12)
    assert found.acceleration == pytest.approx(float(abs(x)), rel=1e-12)
    assert found.residual == 0.0  # no dwell
    train = Dynamics(mass=2e-3, damping=0.04, stiffness=3.0, preload=10.0, load=4.0, damping_ratio=damping)
    swing = abs(-train.mass * omega**2 * x + (3.0 + 0.04j * omega) * (-h / 2))
    expected = 3.0 * h / 2 + 14.0 - swing
    force, _ = least_elastic_contact_force(turn, *force_weights_and_constant(train, omega), ratio, damping)
    assert force == pytest.approx(float(expected), abs=1e-12 * float(swing))


def rest_to_dwell(law, ratio, damping):
    """The amplitude after one rise from rest, by the integral of Duhamel in 50 digits."""
    r = 2 * PI * mp.mpf(ratio)
    w = mp.sqrt(1 - mp.mpf(damping) ** 2)
    mu = r * mp.mpc(-mp.mpf(damping), w)
    q = mp.mpc(0)
    for low, high, terms in ACCELERATIONS[law]:
        for c, k in terms:
            rate = mp.mpc(0, k) - mu
            q -= c * (mp.exp(mu + rate * high) - mp.exp(mu + rate * low)) / rate
    if law == "uniform":
        q += 1 - mp.exp(mu)
    z, slope = mp.im(q) / (r * w), mp.im(mu * q) / (r * w)
    return float(mp.sqrt(z**2 + ((slope / r + damping * z) / w) ** 2))


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.6])
@pytest.mark.parametrize("law", ACCELERATIONS)
def test_spectra_against_fifty_digits(law, damping):
    ratios = np.array([0.1, 0.37, 0.8, 1.3, 2.2, 3.6, 5.7, 9.9, 77.3])
    found = camopt.response_spectrum(law, ratios, damping_ratio=damping)["residual"]
    expected = [rest_to_dwell(law, ratio, damping) for ratio in ratios]
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-16)


# ------------------------------------------------------------------------------------- known behaviour


def test_a_cycloidal_rise_leaves_nothing_at_whole_period_ratios():
    ratios = np.linspace(0.1, 10.0, 397)
    found = camopt.response_spectrum("cycloidal", ratios)["residual"]
    with np.errstate(invalid="ignore", divide="ignore"):
        closed = np.abs(np.sin(pi * ratios)) / (pi * ratios * np.abs(ratios**2 - 1.0))
    closed[np.abs(ratios - 1.0) < 1e-9] = 0.5
    assert found == pytest.approx(closed, rel=1e-11, abs=1e-15)
    whole = np.isin(np.round(ratios, 9), range(2, 11))
    assert whole.sum() == 9
    assert found[whole].max() < 1e-15


def test_undamped_the_mass_overshoots_by_what_is_left_over():
    found = camopt.response_spectrum("modified-trapezoid", np.linspace(0.1, 10.0, 100))
    assert np.all(found["overshoot"] >= found["residual"] * (1 - 1e-12))
    assert np.all(found["deflection"] >= found["residual"] * (1 - 1e-12))


def test_the_laws_in_their_known_order_on_a_stiff_train():
    """At long rises the mass follows the law, with its own peaks; a jump of the acceleration doubles its effect."""
    peaks = {law: camopt.response_spectrum(law, [400.0])["acceleration"][0] for law in ACCELERATIONS}
    assert peaks["modified-trapezoid"] == pytest.approx(4.8881, rel=0.01)
    assert peaks["modified-sine"] == pytest.approx(5.5280, rel=0.01)
    assert peaks["cycloidal"] == pytest.approx(2 * pi, rel=0.01)
    assert peaks["harmonic"] == pytest.approx(pi**2, rel=0.01)
    # envelopes over the lobes from 5 to 6 and beyond: the cycloidal leaves the least of these
    ratios = np.linspace(5.0, 7.0, 201)
    left = {law: camopt.response_spectrum(law, ratios)["residual"].max() for law in ACCELERATIONS}
    assert left["cycloidal"] < left["modified-trapezoid"] < left["harmonic"] < left["uniform"]
    assert left["cycloidal"] < left["modified-sine"] < left["harmonic"]


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_a_stiff_train_bends_with_the_acceleration(damping):
    turn = two_strokes("poly4567", "poly56789")
    table, ratio = turn.table, 3e5 + 0.3
    z = steady_vibration_wave(turn, ratio, damping).values_on_all_panels(U)[:, 0]
    angles = (table.centre + U[:, None] * table.half_width)[1:-1]
    expected = -turn.motion_at(angles)[2] / ratio**2
    assert z[1:-1] == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
    found = vibration_extremes(turn, ratio, damping)
    assert dynamic_factor(found.acceleration, derivative_peak(turn, 2, ALL_STROKES)) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("damping", [0.0, 0.3, 0.9])
def test_on_a_soft_train_the_mass_stays_at_the_mean(damping):
    turn = two_strokes("cycloidal", "poly345")
    table = turn.table
    mean = 20.0 * (50 + 60 + 60) / 360  # symmetric laws pass half their stroke's area
    for ratio in (1e-4, 1e-8):
        x = (
            steady_vibration_wave(turn, ratio, damping)
            .plus_polynomial(table.coefficients.T)
            .values_on_all_panels(U)
        )
        assert x == pytest.approx(mean, abs=60 * ratio)


def test_a_dwell_loses_the_energy_that_the_damper_takes():
    wave = steady_vibration_wave(TURNS["jumps"], 9.3, 0.04)
    table = TURNS["jumps"].table
    (first, second) = table.first_panel[:-1][(table.kind & DWELL) != 0]
    for panel in (first, second):
        u = np.linspace(-1.0, 1.0, 50)
        z, slope = wave.values_on_all_panels(u)[:, 0, panel], wave.slope().values_on_all_panels(u)[:, 0, panel]
        energy = 0.5 * slope**2 + 0.5 * 9.3**2 * z**2
        assert np.all(np.diff(energy) < 0.0)
        angle = table.half_width[panel] * (u + 1.0)
        taken = 2 * 0.04 * 9.3 * np.trapezoid(slope**2, angle)
        assert energy[0] - energy[-1] == pytest.approx(taken, rel=0.01)
        ends = np.hypot(z, (slope / 9.3 + 0.04 * z) / np.sqrt(1 - 0.04**2))
        assert ends[-1] / ends[0] == pytest.approx(np.exp(-0.04 * 9.3 * angle[-1]), rel=1e-12)


def test_resonance_is_infinite_and_damping_bounds_it():
    turn = TURNS["smooth"]
    assert is_resonant(7.0, 0.0)
    assert not is_resonant(7.0, 1e-6)
    assert not is_resonant(7.0 + 1e-12, 0.0)
    assert not is_resonant(1e-20, 0.0)
    found = vibration_extremes(turn, 7.0, 0.0)
    assert found.overshoot == found.overshoot_bound == found.acceleration == found.acceleration_bound == inf
    assert found.residual == inf
    assert least_elastic_contact_force(turn, *force_weights_and_constant(Dynamics(mass=1.0), 1.0), 7.0, 0.0) == (
        -inf,
        -inf,
    )
    # near it the response grows as 1/ζ and as 1/(r − n)
    sizes = [vibration_extremes(turn, 7.0, damping).overshoot for damping in (1e-5, 1e-6)]
    assert sizes[1] / sizes[0] == pytest.approx(10.0, rel=1e-3)
    sizes = [vibration_extremes(turn, 7.0 + apart, 0.0).overshoot for apart in (1e-5, 1e-6)]
    assert sizes[1] / sizes[0] == pytest.approx(10.0, rel=1e-3)


def test_dynamic_factor_at_its_ends():
    assert dynamic_factor(3.0, inf) == 0.0
    assert dynamic_factor(inf, inf) == inf
    assert dynamic_factor(0.0, 0.0) == 1.0


# ------------------------------------------------------------------------------------- random scenes

ratios = st.one_of(st.floats(0.05, 0.9), st.floats(1.1, 40.0)).filter(lambda r: abs(r - round(r)) > 0.02)
dampings = st.one_of(st.just(0.0), st.floats(0.0, 0.95))
laws = st.sampled_from([law for law in own.EVERY if law != "own-spline"])


@st.composite
def turns(draw):
    angles = np.array([draw(st.floats(0.1, 1.0)) for _ in range(4)])
    rise, stay, fall, rest = (angles / angles.sum() * 360.0).tolist()
    lift = draw(st.floats(0.5, 50.0))
    return (
        ("rise", rise, lift, draw(laws)),
        ("dwell", stay, 0, None),
        ("return", fall, lift, draw(laws)),
        ("dwell", rest, 0, None),
    )


@settings(max_examples=times(4, deep=200))
@given(turns(), ratios, dampings)
def test_against_an_integrator(segments, ratio, damping):
    """Integrated panel by panel from the given start, the response comes back to where the next panel starts."""
    turn = programme(*segments)
    table, wave, kicks = turn.table, steady_vibration_wave(turn, ratio, damping), velocity_jump_by_panel(turn)
    (z_left, z_right), (v_left, v_right) = (
        wave.values_on_all_panels(U[[0, -1]])[:, 0],
        wave.slope().values_on_all_panels(U[[0, -1]])[:, 0],
    )
    scale = np.array(
        [np.abs(wave.values_on_all_panels(U)).max(), np.abs(wave.slope().values_on_all_panels(U)).max()]
    )
    z, v = z_left[0], v_left[0]
    for panel, (centre, half) in enumerate(zip(table.centre, table.half_width, strict=True)):
        if panel:
            v -= kicks[panel]

        def moved(angle, state, centre=centre, half=half, panel=panel):
            series = np.polynomial.polynomial.polyder(table.coefficients[panel], 2) / half**2
            pull = np.polynomial.polynomial.polyval((angle - centre) / half, series)
            return [state[1], -pull - 2 * damping * ratio * state[1] - ratio**2 * state[0]]

        assert np.abs(np.array([z, v]) - [z_left[panel], v_left[panel]]) == pytest.approx(
            0.0, abs=1e-8 * scale.max()
        )
        span = (centre - half, centre + half)
        z, v = solve_ivp(moved, span, [z, v], "DOP853", rtol=1e-11, atol=1e-13 * scale.min()).y[:, -1]
        assert abs(z - z_right[panel]) <= 1e-8 * scale[0]
        assert abs(v - v_right[panel]) <= 1e-8 * scale[1]


@settings(max_examples=times(8, deep=400))
@given(turns(), ratios, dampings)
def test_the_order_of_the_segments_does_not_matter(segments, ratio, damping):
    """A turn that starts in its last dwell is the same turn."""
    one, other = (
        vibration_extremes(programme(*order), ratio, damping) for order in (segments, (segments[3], *segments[:3]))
    )
    room = 1e-9
    assert one.overshoot == pytest.approx(other.overshoot, rel=room)
    assert one.acceleration == pytest.approx(other.acceleration, rel=room)
    assert one.residual == pytest.approx(other.residual, rel=room, abs=room * one.overshoot)


@settings(max_examples=times(10, deep=600))
@given(turns(), st.floats(0.05, 3e3).filter(lambda r: not is_resonant(r, 0.0)), dampings)
def test_extremes_enclose_every_sample(segments, ratio, damping):
    turn = programme(*segments)
    wave = steady_vibration_wave(turn, ratio, damping)
    samples = np.linspace(-1.0, 1.0, 301)
    for each in (wave, mass_acceleration_wave(wave, ratio)):
        values = each.values_on_all_panels(samples)
        scale = np.max(np.abs(each.polynomial).sum(axis=0) + each.amplitude)
        top, bottom, size = wave_maximum(each), wave_minimum(each), wave_peak_magnitude(each)
        assert values.max() <= top.bound[0] + 1e-13 * scale
        assert values.min() >= bottom.bound[0] - 1e-13 * scale
        assert np.abs(values).max() <= size.bound[0] + 1e-13 * scale
        assert top.value[0] <= top.bound[0] <= top.value[0] + 1e-12 * scale
        assert size.value[0] == max(top.value[0], -bottom.value[0])


def test_many_trains_together_are_each_what_it_is_alone(monkeypatch):
    """Soft, stiff and resonant ones, in any order, and where intervals are too many for all of them together."""
    turn = two_strokes("cycloidal", "poly345")
    ratios, shares = np.array([0.3, 7.0, 7.0, 41.3, 7.0, 0.3]), np.array([0.0, 0.0, 0.1, 0.02, 0.0, 0.5])
    factors = force_weights_and_constant(
        Dynamics(mass=1e-3, damping=0.01, stiffness=3.0, preload=np.linspace(10, 20, 6)), 30.0
    )
    pressed = [
        least_elastic_contact_force(turn, *each)
        for each in zip(*np.broadcast_arrays(*factors, ratios, shares), strict=True)
    ]
    for most in (wave_extremes.MOST_INTERVALS, 200):  # more than one train has, fewer than all
        monkeypatch.setattr(wave_extremes, "MOST_INTERVALS", most)
        alone = [vibration_extremes.__wrapped__(turn, ratios[k : k + 1], shares[k : k + 1]) for k in range(6)]
        together = np.array(vibration_extremes.__wrapped__(turn, ratios, shares))
        assert np.array_equal(together, np.concatenate(alone, axis=1))
    assert np.array_equal(least_elastic_contact_force(turn, *factors, ratios, shares), np.array(pressed).T)
    none = vibration_extremes(turn, ratios[:0], shares[:0])
    assert [each.shape for each in none] == [(0,)] * 5


# ------------------------------------------------------------------------------------- as a user meets it

TRAIN = {"mass": 1.0, "spring_rate": 10.0, "preload": 150.0, "natural_frequency": 301.0, "damping_ratio": 0.05}
SCENE = {
    "cam": {"form": "disc", "rpm": 600.0, "base_radius": 60.0},
    "follower": {"motion": "translating", "contact": "roller", "roller_radius": 15.0, "dynamics": TRAIN},
    "motion": [
        {"segment": "rise", "angle": 100, "lift": 20, "law": "cycloidal"},
        {"segment": "dwell", "angle": 60},
        {"segment": "return", "angle": 120, "lift": 20, "law": "modified-sine"},
        {"segment": "dwell", "angle": 80},
    ],
    "outputs": ["vibration", "force", "motion"],
}


def test_quantities_in_their_units():
    found = camopt.evaluate(camopt.Scene.from_dict(SCENE))
    omega, ratio = 20 * pi, 30.1
    exact = vibration_extremes(two_strokes("cycloidal", "modified-sine"), ratio, 0.05)
    assert found["overshoot_max_mm"] == pytest.approx(exact.overshoot, rel=1e-9)
    assert found["residual_vibration_max_mm"] == pytest.approx(exact.residual, rel=1e-9)
    assert found["acceleration_elastic_max_m_s2"] == pytest.approx(exact.acceleration * omega**2 / 1e3, rel=1e-9)
    assert found["dynamic_factor"] == pytest.approx(
        found["acceleration_elastic_max_m_s2"] / found["acceleration_max_m_s2"], rel=1e-12
    )
    stiff = camopt.Scene.from_dict(SCENE).replace(**{"follower.dynamics.natural_frequency": 1e7})
    found = camopt.evaluate(stiff)
    assert found["contact_force_elastic_min_N"] == pytest.approx(found["contact_force_min_N"], rel=1e-4)


def swinging_scene(contact="roller"):
    train = {**TRAIN, "inertia": 1e-3, "spring_rate": 1.0, "preload": 3.0}
    del train["mass"]
    sizes = {"roller_radius": 10.0, "arm_length": 80.0} if contact == "roller" else {"face_offset": 5.0}
    follower = {"motion": "oscillating", "contact": contact, "centre_distance": 120.0, **sizes}
    return camopt.Scene.from_dict({**SCENE, "follower": {**follower, "dynamics": train}})


def test_an_oscillating_follower_has_angles_and_a_force_at_its_trace_point():
    found = camopt.evaluate(swinging_scene())
    exact = vibration_extremes(two_strokes("cycloidal", "modified-sine"), 30.1, 0.05)  # deg for mm
    assert found["overshoot_max_deg"] == pytest.approx(exact.overshoot, rel=1e-9)
    assert found["residual_vibration_max_deg"] == pytest.approx(exact.residual, rel=1e-9)
    assert found["acceleration_elastic_max_rad_s2"] == pytest.approx(
        np.radians(exact.acceleration) * (20 * pi) ** 2, rel=1e-9
    )
    stiff = camopt.evaluate(swinging_scene().replace(**{"follower.dynamics.natural_frequency": 1e7}))
    assert stiff["contact_force_elastic_min_N"] == pytest.approx(stiff["contact_force_min_N"], rel=1e-4)
    flat = camopt.evaluate(swinging_scene("flat").replace(outputs=["vibration"]))
    assert "overshoot_max_deg" in flat
    assert "contact_force_elastic_min_N" not in flat


def test_limits_on_what_is_left_over_and_on_the_elastic_contact():
    scene = camopt.Scene.from_dict(SCENE)
    found = camopt.evaluate(scene)
    reached = {
        "residual_vibration": found["residual_vibration_max_mm"],
        "contact_force_elastic": found["contact_force_elastic_min_N"],
    }
    for name, value in reached.items():
        for share, verdict in ((0.99, "broken"), (1.01, "held")):
            bound = value * (share if name == "residual_vibration" else 2 - share)
            limited = scene.replace(**{f"limits.{name}": bound})
            assert camopt.certify(limited)[name] == verdict
            assert (name in camopt.evaluate(limited)["violated"].split(",")) == (verdict == "broken")


def test_an_optimiser_says_that_no_size_helps_against_vibration():
    scene = camopt.Scene.from_dict(SCENE).replace(
        **{"limits.residual_vibration": 1e-9, "search.base_radius": {"start": 40.0, "stop": 90.0}, "outputs": None}
    )
    found = camopt.optimise(scene)
    assert not found.by_law
    assert (
        "residual_vibration" in found.obstacles["cycloidal, modified-sine"]
        if "," in next(iter(found.obstacles))
        else "residual_vibration" in next(iter(found.obstacles.values()))
    )


def test_resonance_is_explained():
    scene = camopt.Scene.from_dict(SCENE)
    changes = {"follower.dynamics.natural_frequency": 300.0, "follower.dynamics.damping_ratio": 0.0}
    found = camopt.evaluate(scene.replace(**changes))
    assert found["overshoot_max_mm"] == inf
    assert found["contact_force_elastic_min_N"] == -inf
    assert "in resonance" in found.unbounded["dynamic_factor"]


@pytest.mark.parametrize("value", [1.0, -0.1])
def test_a_damping_ratio_out_of_range(value):
    scene = camopt.Scene.from_dict(SCENE)
    with pytest.raises(camopt.BadInput, match="damping_ratio = "):
        scene.replace(**{"follower.dynamics.damping_ratio": value})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cycloid",), "law = "),
        (("cycloidal", [0.5, float("nan")]), "ratios = nan"),
        (("cycloidal", [[1.0]]), "in one dimension"),
        (("cycloidal", "many"), "ratios = "),
        (("cycloidal", [1.0], {"damping_ratio": 1.0}), "damping_ratio = 1.0"),
        (("cycloidal", [0.0], {"damping_ratio": -1.0}), "2 mistakes|ratios = 0.0"),
    ],
)
def test_mistakes_in_a_spectrum(arguments, message):
    options = arguments[2] if len(arguments) > 2 else {}
    with pytest.raises(camopt.BadInput, match=message):
        camopt.response_spectrum(*arguments[:2], **options)


@pytest.mark.slow
def test_a_spectrum_is_written_and_drawn(tmp_path):
    from camopt.show.studies.spectrum import SPECTRUM, SPECTRUM_COLUMNS, spectra_of

    spectra = spectra_of(camopt.Scene.from_dict(SCENE))
    assert set(spectra.rows.columns) == set(SPECTRUM_COLUMNS)
    table, picture = SPECTRUM
    spectra.write(tmp_path / "new")
    frame = camopt.load(tmp_path / "new" / table)
    assert spectra.to_pandas().equals(frame)
    assert list(frame.columns) == list(SPECTRUM_COLUMNS)
    assert frame.attrs["units"]["residual"] == "lift"
    assert set(frame["damping_ratio"]) == {0.05}
    assert np.isfinite(frame.drop(columns="law").to_numpy()).all()
    text = (tmp_path / "new" / picture).read_text()
    assert "modified-sine" in text
    spectra.write(tmp_path / "other")
    assert (tmp_path / "other" / picture).read_text() == text


@settings(max_examples=times(10, deep=600))
@given(
    turns(),
    st.floats(-6.0, 12.0).map(lambda power: 10.0**power),
    st.one_of(st.just(0.0), st.floats(0.0, 1.0, exclude_max=True)),
)
def test_no_scene_gives_what_is_no_number(segments, frequency, damping):
    changes = {"follower.dynamics.natural_frequency": frequency, "follower.dynamics.damping_ratio": damping}
    keys = ("segment", "angle", "lift", "law")
    motion = [{k: v for k, v in zip(keys, segment, strict=True) if v} for segment in segments]
    scene = camopt.Scene.from_dict(
        {**SCENE, "motion": motion, "laws": {n: own.TABLES[n] for n in own.TABLES}, "outputs": ["vibration"]}
    )
    found = camopt.evaluate(scene.replace(**changes))
    values = [v for name, v in found.items() if camopt.QUANTITIES[name].effect == "vibration"]
    assert len(values) == 5
    assert all(isfinite(v) or (isinf(v) and damping == 0.0) for v in values)

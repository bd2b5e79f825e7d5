"""Forces, thrust and contact stress against dense samples of the textbook formulas, and identities."""

from itertools import product
from math import inf, pi, sqrt

import numpy as np
import pytest
from support.depth import covering_cases

from camopt import certify, evaluate, find_scene, optimise, sweep
from camopt.cli.main import main
from camopt.core.mistakes import BadInput
from camopt.model.effects import EFFECTS
from camopt.model.effects.hertz import SHEAR_DEPTH, SHEAR_SHARE
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.problem import resolve

SPRING = {"mass": 1.5, "spring_rate": 15, "preload": 450, "damping": 0.03}
GUIDE = {"guide_length": 90, "overhang": 80, "friction": 0.15, "stem_diameter": 16}
BODIES = {"cam": "steel", "follower": "bronze", "face_width": 10}
MODULUS = 1 / ((1 - 0.292**2) / 207e3 + (1 - 0.349**2) / 111e3)
RPM = 300.0
OMEGA = RPM * pi / 30


def with_law(scene, law):
    motion = [{**s.model_dump(exclude_none=True), **({"law": law} if s.law else {})} for s in scene.motion]
    return scene.replace(motion=motion)


VALVE = find_scene("exhaust-valve").replace(
    **{"cam.rpm": RPM, "outputs": ["all"], "follower.dynamics": {**SPRING, **GUIDE}, "materials": BODIES}
)
FLAT = find_scene("flat-reciprocating").replace(
    **{"cam.rpm": RPM, "outputs": ["all"], "follower.dynamics": SPRING, "materials": BODIES}
)
SWING = find_scene("oscillating-roller").replace(
    **{
        "cam.rpm": RPM,
        "outputs": ["all"],
        "follower.dynamics": {"inertia": 4e-3, "spring_rate": 20, "preload": 15, "damping": 0.01},
        "materials": BODIES,
    }
)


def sample_motion(scene, points=100_000):
    """Cam angles, motion, and the kind of stroke at each."""
    programme = resolve(scene).programme
    angles = np.linspace(0, 2 * pi, points, endpoint=False) + 1e-7
    kind = np.zeros(points)
    for stroke in programme.strokes:
        kind[(angles >= stroke.start) & (angles < stroke.end)] = stroke.kind
    return kind, *programme.motion_at(angles)


def agree(found, expected, jumps):
    """Largest values of samples never exceed those found, and come close."""
    for name, value in expected.items():
        assert value <= found[name] * (1 + 1e-12) + 1e-9, name
        assert found[name] == pytest.approx(value, rel=1e-4 if jumps else 1e-6), name


@pytest.mark.one_in(5)
@pytest.mark.parametrize("law", ["cycloidal", "parabolic", "poly345", "modified-trapezoid"])
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("friction", [0.0, 0.15])
def test_a_translating_roller_in_its_guide(law, rotation, friction):
    changes = {"cam.rotation": rotation, "follower.offset": 6.0, "follower.dynamics.friction": friction}
    scene = with_law(VALVE, law).replace(**changes)
    kind, y, y1, y2, _ = sample_motion(scene)
    e, s = (6.0 if rotation == "ccw" else -6.0), np.sqrt(60.0**2 - 36.0) + y
    beta = np.arctan((y1 - e) / s)
    force = 1.5e-3 * OMEGA**2 * y2 + 0.03 * OMEGA * y1 + 15 * y + 450
    b, a = 90.0, 80.0 - y
    side = np.where(kind == RISE, -1, np.where(kind == RETURN, 1, 0)) * friction * (2 * a + b) / b
    normal = force / (np.cos(beta) + side * np.abs(np.sin(beta)))
    thrust = np.abs(normal * np.sin(beta))
    curvature = (s * s + (y1 - e) * (2 * y1 - e) - s * y2) / (s * s + (y1 - e) ** 2) ** 1.5
    radius = 20 * (1 - 20 * curvature)
    pressure = np.sqrt(normal / 10 * MODULUS / (pi * radius))
    found = evaluate(scene)
    expected = {
        "contact_force_max_N": force.max(),
        "normal_force_max_N": normal.max(),
        "side_thrust_max_N": thrust.max(),
        "guide_reaction_max_N": (thrust * (a + b) / b).max(),
        "stem_bending_stress_max_MPa": (32 * thrust * a / (pi * 16**3)).max(),
        "contact_stress_max_MPa": pressure.max(),
    }
    agree(found, expected, law == "parabolic")
    assert found["contact_force_min_N"] == pytest.approx(force.min(), rel=1e-6)
    k = pressure.argmax()
    half_width = 2 * np.sqrt(normal[k] * radius[k] / (pi * 10 * MODULUS))
    assert found["contact_half_width_mm"] == pytest.approx(half_width, rel=1e-4)
    assert found["contact_shear_depth_mm"] == pytest.approx(SHEAR_DEPTH * found["contact_half_width_mm"], rel=1e-12)
    if friction:
        drag = friction * (2 * a + b) / b * np.abs(np.tan(beta))
        assert found["jamming_margin"] == pytest.approx(1 - drag[kind == RISE].max(), rel=1e-5)


@pytest.mark.parametrize("law", ["cycloidal", "poly4567", "harmonic"])
def test_a_flat_face(law):
    scene = with_law(FLAT, law)
    _, y, y1, y2, _ = sample_motion(scene)
    force = 1.5e-3 * OMEGA**2 * y2 + 0.03 * OMEGA * y1 + 15 * y + 450
    radius = scene.cam.base_radius + y + y2
    found = evaluate(scene)
    agree(found, {"normal_force_max_N": force.max()}, law == "harmonic")
    if radius.min() > 0:
        pressure = np.sqrt(force / 10 * MODULUS / (pi * radius)).max()
        agree(found, {"contact_stress_max_MPa": pressure}, law == "harmonic")
    else:
        assert found["contact_stress_max_MPa"] == inf


def test_an_oscillating_roller():
    problem = resolve(SWING)
    _, y, y1, y2, _ = sample_motion(SWING)
    design, sense = problem.design, problem.design.sense
    c, l, r = (float(getattr(design, n)[0]) for n in ("centre_distance", "arm_length", "prime_radius"))  # noqa: E741
    psi = np.arccos((c * c + l * l - r * r) / (2 * c * l)) + y
    q = 1 + sense * y1
    tangent = (l * q - c * np.cos(psi)) / (c * np.sin(psi))
    moment = 4.0 * OMEGA**2 * y2 + 10 * OMEGA * y1 + 20e3 * y + 15e3
    force, normal = moment / l, moment / l * np.sqrt(1 + tangent**2)
    speed = l * l * q * q + c * c - 2 * c * l * q * np.cos(psi)
    top = l * l * q**3 + c * c - c * l * np.cos(psi) * q * (1 + q) - c * l * y2 * np.sin(psi)
    size = float(design.roller_radius[0])
    radius = size * (1 - size * top / speed**1.5)
    found = evaluate(SWING)
    expected = {
        "contact_force_max_N": force.max(),
        "normal_force_max_N": normal.max(),
        "side_thrust_max_N": np.abs(force * tangent).max(),
    }
    agree(found, expected, True)
    if radius.min() > 0:
        agree(found, {"contact_stress_max_MPa": np.sqrt((normal / radius).max() / 10 * MODULUS / pi)}, True)


LAWS_AND_DAMPING = [*product(("cycloidal", "parabolic", "modified-sine"), (0.0, 0.03, 2.0))]


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize(("law", "damping"), covering_cases(LAWS_AND_DAMPING, enumerate))
def test_the_jump_speed_is_where_the_least_force_is_zero(law, damping):
    scene = with_law(VALVE, law).replace(**{"follower.dynamics.damping": damping})
    speed = evaluate(scene)["jump_speed_rpm"]
    at, above, below = (
        evaluate(scene.replace(**{"cam.rpm": speed * x}))["contact_force_min_N"] for x in (1, 1 + 1e-6, 1 - 1e-6)
    )
    assert abs(at) < 1e-9
    assert above < 0 < below


ECCENTRIC = FLAT.replace(
    motion=[{"segment": kind, "angle": 180, "lift": 20, "law": "harmonic"} for kind in ("rise", "return")],
    outputs=["force"],
    **{"follower.dynamics": {"mass": 0.5, "spring_rate": 2}, "cam.base_radius": 40},
)


@pytest.mark.parametrize("preload", [None, 1e-9, 40.0])
def test_an_eccentric_jumps_at_the_top_whether_it_is_preloaded_or_not(preload):
    """F = m·ω²·h/2·cos θ + k·h/2·(1 − cos θ) + F₀ is least at 180°: ω² = 2·(k·h + F₀)/(m·h)."""
    found = evaluate(ECCENTRIC.replace(**{"follower.dynamics.preload": preload}))
    expected = sqrt(2 * (2 * 20 + (preload or 0.0)) / (0.5e-3 * 20)) * 30 / pi
    assert found["jump_speed_rpm"] == pytest.approx(expected, rel=1e-13)
    if preload is None:
        assert found["jump_speed_rpm"] == pytest.approx(854.115, abs=5e-4)


@pytest.mark.parametrize("law", ["cycloidal", "poly345", "modified-sine", "parabolic"])
def test_a_follower_that_nothing_preloads_jumps_as_with_a_preload_that_vanishes(law):
    bare = with_law(VALVE, law).replace(
        outputs=["force"], **{"follower.dynamics": {"mass": 1.5, "spring_rate": 15, "damping": 0.002}}
    )
    slight = bare.replace(**{"follower.dynamics.preload": 1e-9})
    speed = evaluate(bare)["jump_speed_rpm"]
    assert speed > 100
    assert speed == pytest.approx(evaluate(slight)["jump_speed_rpm"], rel=1e-9)
    lost = evaluate(bare.replace(**{"cam.rpm": 1.001 * speed}))["contact_force_min_N"]
    kept = evaluate(bare.replace(**{"cam.rpm": 0.999 * speed}))["contact_force_min_N"]
    assert lost < -1e-3
    assert kept > -1e-10


@pytest.mark.parametrize("dynamics", [{"mass": 0.5}, {"mass": 0.5, "damping": 0.1}, {"mass": 0.5, "load": -5.0}])
def test_what_nothing_presses_has_no_jump_speed(dynamics):
    assert evaluate(ECCENTRIC.replace(**{"follower.dynamics": dynamics}))["jump_speed_rpm"] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("given", [{"cam.rpm": None}, {"follower.dynamics": None}, {}])
def test_the_stress_of_a_knife_edge_has_no_bound_whatever_is_known_of_the_force(given):
    follower = {"motion": "translating", "contact": "knife", "dynamics": SPRING}
    limited = VALVE.replace(outputs=[], follower=follower, limits={"contact_stress": 900}).replace(**given)
    found = evaluate(limited)
    assert (found["contact_stress_max_MPa"], found["violated"]) == (inf, "contact_stress")
    assert certify(limited)["contact_stress"] == "broken"
    best = optimise(limited)
    assert best.best is None
    assert set(best.obstacles.values()) == {"contact_stress"}


@pytest.mark.slow
def test_what_is_required_is_just_enough():
    scene = with_law(VALVE, "cycloidal").replace(**{"cam.rpm": 900})
    found = evaluate(scene)
    assert found["contact_force_min_N"] < 0
    for key, name in (("preload", "preload_required_N"), ("spring_rate", "spring_rate_required_N_per_mm")):
        enough = evaluate(scene.replace(**{f"follower.dynamics.{key}": found[name]}))
        assert enough["contact_force_min_N"] == pytest.approx(0.0, abs=1e-8 * found["contact_force_max_N"])


def test_no_preload_is_required_by_rounding():
    """On a slow cam that nothing pushes back the least force is the preload, of a dwell."""
    slow = with_law(VALVE, "cycloidal").replace(**{"cam.rpm": 30})
    for preload in (32 / 7, 281 / 7, 232 / 7):
        trained = {"mass": 0.5, "spring_rate": 60, "preload": preload}
        assert evaluate(slow.replace(**{"follower.dynamics": trained}))["preload_required_N"] == 0.0


def test_hertz_constants_are_those_of_the_stress_field_below_a_line_contact():
    z = np.linspace(0.7, 0.9, 2_000_001)  # depth over half-width; Johnson, Contact Mechanics, eq. 4.46
    shear = z - z**2 / np.sqrt(1 + z**2)
    assert shear.max() == pytest.approx(SHEAR_SHARE, rel=1e-10)
    assert z[shear.argmax()] == pytest.approx(SHEAR_DEPTH, abs=1e-6)


def test_corners_are_impulses_and_a_knife_has_no_width():
    uniform = with_law(VALVE, "uniform")
    found = evaluate(uniform)
    assert found["contact_force_min_N"] == -inf
    assert found["normal_force_max_N"] == found["contact_stress_max_MPa"] == inf
    assert found["jump_speed_rpm"] == 0.0
    follower = {"motion": "translating", "contact": "knife", "dynamics": SPRING}
    assert evaluate(VALVE.replace(follower=follower))["contact_stress_max_MPa"] == inf


def test_a_nearly_conforming_flank_has_hardly_any_stress():
    """A roller as large as the hollow it runs in: the relative radius grows without end."""
    scene = with_law(VALVE, "cycloidal").replace(**{"follower.dynamics.friction": 0.0})
    stresses = []
    for roller in (20.0, 60.0, 200.0):
        found = evaluate(scene.replace(**{"follower.roller_radius": roller, "cam.base_radius": 200.0}))
        stresses.append(found["contact_stress_max_MPa"])
        assert np.isfinite(found["contact_half_width_mm"])
    assert stresses == sorted(stresses, reverse=True)


def test_more_effects_change_no_column_and_zero_is_as_good_as_nothing():
    geometry, everything = evaluate(VALVE.replace(outputs=[])), evaluate(VALVE)
    common = geometry.keys() & everything.keys() - {"relative_half_width"}
    assert len(common) > 20
    assert all(geometry[name] == everything[name] for name in common)
    nothing = VALVE.replace(**{"follower.dynamics.friction": None, "follower.dynamics.damping": None})
    zero = VALVE.replace(**{"follower.dynamics.friction": 0.0, "follower.dynamics.damping": 0.0})
    assert dict(evaluate(zero)) == dict(evaluate(nothing))


def test_what_nobody_calls_for_does_not_run(monkeypatch):
    def fail(case, wanted):
        raise AssertionError("an effect that nobody called for ran")

    for name in ("force", "thrust", "hertz", "torque", "vibration"):
        monkeypatch.setitem(EFFECTS, name, EFFECTS[name]._replace(evaluate_columns=fail))
    evaluate(VALVE.replace(outputs=[]))
    with pytest.raises(AssertionError, match="nobody called"):
        evaluate(VALVE)


def test_missing_keys_are_named(tmp_path, capsys):
    bare = find_scene("exhaust-valve").replace(**{"limits.contact_stress": 900, "limits.jump_speed": 500})
    with pytest.raises(BadInput) as caught:
        evaluate(bare)
    lines = str(caught.value).splitlines()
    keys = "cam.rpm, follower.dynamics.mass, materials.cam, materials.follower, materials.face_width"
    assert any(f"limits.contact_stress = 900.0: needs {keys}" in line for line in lines)
    assert any("limits.jump_speed = 500.0: needs follower.dynamics.mass" in line for line in lines)
    path = tmp_path / "bare.toml"
    path.write_text(bare.to_toml(), encoding="utf-8")
    assert main(["evaluate", str(path)]) == 2
    assert "needs follower.dynamics.mass" in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.parametrize(
    ("limit", "share"),
    [
        pytest.param("contact_stress", 0.8, marks=pytest.mark.long),  # as of other followers in test_loads
        pytest.param("side_thrust", 0.8, marks=pytest.mark.long),
        ("normal_force", 0.95),
    ],
)
def test_the_smallest_cam_under_a_load_is_that_of_bisection(limit, share):
    scene = with_law(VALVE, "cycloidal").replace(outputs=["sizes"])
    name = {"contact_stress": "contact_stress_max_MPa"}.get(limit, f"{limit}_max_N")
    bound = evaluate(scene.replace(outputs=[name]))[name] * share
    limited = scene.replace(**{f"limits.{limit}": bound})
    best = optimise(limited).best
    low, high = 20.0, 2000.0
    while high - low > 1e-7:
        middle = (low + high) / 2
        found = evaluate(limited.replace(**{"cam.base_radius": middle}))
        low, high = (low, middle) if found["feasible"] else (middle, high)
    assert best["base_radius_mm"] == pytest.approx(high, abs=1e-6)
    assert best["binding"] == [limit]
    assert best["proved"]
    assert certify(limited.replace(**{"cam.base_radius": best["base_radius_mm"]}))[limit] == "held"
    assert certify(limited.replace(**{"cam.base_radius": high - 1e-6}))[limit] == "broken"


def test_a_limit_of_the_motion_alone_stops_every_size():
    found = optimise(VALVE.replace(**{"limits.jump_speed": 5000, "limits.pressure_angle": 30}))
    assert found.best is None
    assert "jump_speed" in next(iter(found.obstacles.values()))


def test_a_sweep_holds_its_limits_on_loads():
    search = {"base_radius": {"start": 40, "stop": 90, "step": 5}, "law": ["cycloidal", "poly345", "uniform"]}
    scene = VALVE.replace(
        **{"search": search, "limits.contact_stress": 500, "limits.jump_speed": 400, "outputs": []}
    )
    result = sweep(scene)
    assert 0 < result.feasible < result.designs
    assert all(row["contact_stress_max_MPa"] <= 500 for row in result.best.values())
    assert set(result.best) == {"cycloidal", "poly345"}

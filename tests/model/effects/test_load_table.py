"""An external load as a table over the turn: identities, balances, verdicts, input. 50 digits: test_loads.py."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import fp
from support import naive
from support.cams import CORNERED, JUMPING, MOMENT, SWUNG, UNGUIDED, cam_with
from support.depth import times

from camopt import BadInput, Scene, certify, evaluate, load, optimise, sweep
from camopt.core.numerics import LARGEST
from camopt.core.numerics.curves import value_and_slope
from camopt.model.effects import EvaluationBlock, loads, surface
from camopt.model.effects.vibration import mass_acceleration_wave, steady_vibration_wave
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.problem import resolve

TABLES = {"cornered": CORNERED, "jumping": JUMPING}
OF_MOTION = ["force", "torque"]  # effects that need no kernel
RPM, OMEGA = 420, 420 * np.pi / 30


def cam_under_load(rows, contact="flat", dynamics=None, **more):
    given = dynamics if dynamics is not None else SWUNG if contact == "arm" else UNGUIDED
    made = {key: value for key, value in given.items() if key != "load"}
    return cam_with(contact, dynamics=made if rows is None else {**made, "load": rows}, **more)


def quantities_under_load(rows, contact="flat", dynamics=None, **more):
    return dict(
        evaluate(Scene.from_dict(cam_under_load(rows, contact, dynamics, **{"outputs": OF_MOTION, **more})))
    )


def assert_close(one, other, rel=1e-11):
    for name, value in one.items():
        if isinstance(value, float):
            assert other[name] == pytest.approx(value, rel=rel, abs=1e-9), name


# ------------------------------------------------------------------------------------------------ identities


@pytest.mark.parametrize("rows", [[[90, 12.0]], [[0, 12.0], [200, 12.0]], [[10, 12], [10, 12], [360, 12]]])
def test_a_table_of_one_value_is_that_constant(rows):
    assert quantities_under_load(rows) == quantities_under_load(12.0)


def test_a_table_of_zeros_is_no_load():
    assert quantities_under_load([[0, 0.0], [180, 0.0]]) == quantities_under_load(None)


@pytest.mark.parametrize("rows", TABLES.values(), ids=TABLES)
def test_a_constant_moves_from_the_table_to_the_preload(rows):
    raised = [[angle, value + 55.0] for angle, value in rows]
    names = ("contact_force_min_N", "contact_force_max_N", "torque_max_N_m", "torque_rms_N_m", "power_mean_W")
    one, other = (
        quantities_under_load(raised),
        quantities_under_load(rows, dynamics={**UNGUIDED, "preload": UNGUIDED["preload"] + 55.0}),
    )
    assert_close({name: one[name] for name in (*names, "energy_fluctuation_J", "jump_speed_rpm")}, other)


@pytest.mark.parametrize("rows", TABLES.values(), ids=TABLES)
@pytest.mark.parametrize("outputs", [OF_MOTION, ["thrust", "hertz"]])
def test_motion_and_table_turned_together_give_the_same(rows, outputs):
    scene = cam_under_load(rows, "flat", outputs=outputs)
    *strokes, last = scene["motion"]
    turned = [[(angle + last["angle"]) % 360, value] for angle, value in rows]
    first = min(range(len(turned)), key=lambda k: (turned[k][0], -k))
    moved = cam_under_load(turned[first:] + turned[:first], "flat", outputs=outputs)
    moved["motion"] = [last, *strokes]
    ours, theirs = (evaluate(Scene.from_dict(each)) for each in (scene, moved))
    assert_close({n: v for n, v in ours.items() if not n.endswith("_at_deg")}, theirs)


def test_rows_on_the_line_change_nothing():
    halved = [row for (a, p), (b, q) in pairwise(CORNERED) for row in ([a, p], [(a + b) / 2, (p + q) / 2])]
    assert_close(quantities_under_load(CORNERED), quantities_under_load([*halved, CORNERED[-1]]))


@given(st.lists(st.tuples(st.integers(0, 359), st.integers(-99, 99)), min_size=1, unique_by=lambda row: row[0]))
def test_the_load_between_rows_is_that_of_linear_interpolation(rows):
    rows = sorted(rows)
    angles = np.linspace(0.0, 360.0, 1441)[:-1]
    ours, slope = ExternalLoad(rows, 1.0).load_and_slope(np.radians(angles))
    assert ours == pytest.approx(np.interp(angles, *zip(*rows, strict=True), period=360), abs=1e-9)
    step = 1e-3
    ahead = np.interp(angles + step, *zip(*rows, strict=True), period=360)
    assert slope * np.radians(step) == pytest.approx(ahead - ours, abs=1e-9)


# --------------------------------------------------------------------------------------- torque and its energy


def slow_force(rows, dynamics, moving):
    """Cam angle, weight of quadrature, y, F and y' over a turn (N, mm, rad), by Gauss's rule in 200 parts each."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    found = []
    for piece, line in naive.under_load(naive.programme(moving, fp), rows, fp):
        edges = np.linspace(float(piece.start), float(piece.end), 201)
        for low, high in pairwise(edges):
            for node, weight in zip(nodes, weights, strict=True):
                theta = (low + high) / 2 + (high - low) / 2 * node
                y, y1, y2, _ = piece.jet(theta)
                force = dynamics["mass"] * 1e-3 * OMEGA**2 * y2 + dynamics["damping"] * OMEGA * y1
                force += dynamics["spring_rate"] * y + dynamics["preload"] + dynamics["mass"] * 9.81
                found.append((theta, weight * (high - low) / 2, y, force + naive.on_line(line, theta), y1))
    return np.array(found).T


@pytest.mark.parametrize("rows", TABLES.values(), ids=TABLES)
def test_torque_and_its_energy_against_quadrature(rows):
    ours, moving = quantities_under_load(rows), cam_under_load(rows)["motion"]
    theta, weight, y, force, y1 = slow_force(rows, UNGUIDED, moving)
    torque = force * y1 / 1e3
    mean = np.sum(weight * torque) / (2 * np.pi)
    assert ours["torque_mean_N_m"] == pytest.approx(mean, rel=1e-10)
    assert ours["power_mean_W"] == pytest.approx(mean * OMEGA, rel=1e-10)
    assert ours["torque_rms_N_m"] == pytest.approx(np.sqrt(np.sum(weight * torque**2) / (2 * np.pi)), rel=1e-10)
    assert torque.max() <= ours["torque_max_N_m"] == pytest.approx(torque.max(), rel=1e-3)
    assert torque.min() >= ours["torque_min_N_m"] == pytest.approx(torque.min(), rel=1e-3)
    work = np.cumsum(weight * (torque - mean))
    assert ours["energy_fluctuation_J"] == pytest.approx(np.ptp(work), rel=1e-3)
    # by parts, the work of the load is that of its slope on the displacement, and of its jumps
    damped = UNGUIDED["damping"] * OMEGA * np.sum(weight * y1**2)
    parts = naive.under_load(naive.programme(moving, fp), rows, fp)
    ends = sum(naive.on_line(k, p.end) * p.jet(p.end)[0] for p, k in parts)
    ends -= sum(naive.on_line(k, p.start) * p.jet(p.start)[0] for p, k in parts)
    slopes = ExternalLoad(rows, 1.0).load_and_slope(theta)[1]
    assert ours["torque_mean_N_m"] * 2e3 * np.pi == pytest.approx(
        damped + ends - np.sum(weight * slopes * y), rel=1e-10
    )


# ------------------------------------------------------------------------------- springs, speed, elastic train


@pytest.mark.parametrize("rows", TABLES.values(), ids=TABLES)
def test_what_is_required_is_just_enough(rows):
    ours = quantities_under_load(rows)
    at_jump = quantities_under_load(rows, rpm=ours["jump_speed_rpm"])
    assert at_jump["contact_force_min_N"] == pytest.approx(0.0, abs=1e-9 * at_jump["contact_force_max_N"])
    weak = {**UNGUIDED, "preload": 20.0}
    lost = quantities_under_load(rows, dynamics=weak)
    assert lost["contact_force_min_N"] < 0.0
    pressed = quantities_under_load(rows, dynamics={**weak, "preload": lost["preload_required_N"]})
    assert pressed["contact_force_min_N"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("rows", TABLES.values(), ids=TABLES)
def test_the_elastic_contact_force_against_a_scan(rows):
    train = {**UNGUIDED, "natural_frequency": 90.0, "damping_ratio": 0.04}
    scene = Scene.from_dict(cam_under_load(rows, dynamics=train, outputs=["vibration"]))
    asked, ratio = resolve(scene), 2 * np.pi * 90.0 / OMEGA
    table = asked.programme.table
    u = np.linspace(-1.0, 1.0, 2001)
    inertia = mass_acceleration_wave(
        steady_vibration_wave(asked.programme, ratio, 0.04), ratio
    ).values_on_all_panels(u)[:, 0]
    least = np.inf
    lines = naive.lines(rows, fp)
    for panel, (centre, half) in enumerate(zip(table.centre, table.half_width, strict=True)):
        theta = centre + half * u
        y, y1 = asked.programme.motion_at(np.clip(theta, 0.0, 2 * np.pi - 1e-12))[:2]
        line = next(each for each in lines if each[0] <= centre <= each[2])
        held = UNGUIDED["damping"] * OMEGA * y1 + UNGUIDED["spring_rate"] * y + UNGUIDED["preload"]
        outside = naive.on_line(line, theta) + 9.81 * UNGUIDED["mass"]
        least = min(least, np.min(UNGUIDED["mass"] * 1e-3 * OMEGA**2 * inertia[:, panel] + held + outside))
    ours = evaluate(scene)["contact_force_elastic_min_N"]
    assert ours == pytest.approx(least, abs=1e-4)
    changes = {"follower.dynamics.natural_frequency": 1e7, "outputs": ["force", "vibration"]}
    stiff = evaluate(scene.replace(**changes))
    assert stiff["contact_force_elastic_min_N"] == pytest.approx(stiff["contact_force_min_N"], rel=1e-4)


# ------------------------------------------------------------------------------------------- kernels, searches

WORN = {"wear_rate": 1e-9, "viscosity": 30, "pressure_viscosity": 15, "roughness": 0.4}


def test_wear_and_film_are_those_of_a_scan():
    scene = cam_under_load(JUMPING)
    scene["cam"]["base_radius"] = 160  # so that the lubricant is carried one way
    asked = resolve(Scene.from_dict({**scene, "materials": {**scene["materials"], **WORN}}))
    case = EvaluationBlock(asked.setup, asked.programme, asked.design)
    jump = np.radians(70.0)
    theta = np.array([jump - 1e-12, jump + 1e-12, *np.linspace(0.0, 2 * np.pi, 200_001)[:-1]])
    state = asked.programme.state(theta)
    for make in (
        partial(surface.wear_load_curve, asked.setup),
        partial(loads.normal_force_curve, asked.setup),
        *(each for each, _ in surface.wear_or_film_curve_variants(surface.FILM_RATIO, asked.setup)),
    ):
        scanned = value_and_slope(make(asked.design, asked.programme), 0, state)[0].max()
        exact = case.extremes(make, [(ALL_STROKES, LARGEST)])
        assert scanned <= exact.value[0, 0] * (1 + 1e-12)
        assert scanned == pytest.approx(exact.value[0, 0], rel=1e-6)


LIMITS = {
    "normal_force": "normal_force_max_N",
    "contact_stress": "contact_stress_max_MPa",
    "torque": "torque_peak_N_m",
    "power": "power_peak_W",
    "contact_force_min": "contact_force_min_N",
}


@pytest.mark.slow
@pytest.mark.parametrize(("contact", "rows"), [("flat", JUMPING), ("flat", CORNERED), ("arm", MOMENT)])
def test_verdicts_turn_at_the_value_itself(contact, rows):
    scene = Scene.from_dict(cam_under_load(rows, contact, outputs=[*OF_MOTION, "thrust", "hertz"]))
    ours = evaluate(scene)
    for limit, name in LIMITS.items():
        side = -1 if limit == "contact_force_min" else 1
        for share, verdict in ((1e-11, "held"), (-1e-11, "broken")):
            limited = scene.replace(**{f"limits.{limit}": ours[name] * (1 + side * share)})
            assert certify(limited)[limit] == verdict, (limit, share)
            assert (limit in evaluate(limited)["violated"].split(",")) == (verdict == "broken")


@pytest.mark.slow
def test_searches_read_the_table(tmp_path):
    scene = Scene.from_dict(
        {
            **cam_under_load(JUMPING, outputs=["thrust", "hertz"]),
            "limits": {"contact_stress": 160.0},
            "search": {"base_radius": {"start": 40, "stop": 140, "step": 20}, "law": ["cycloidal", "poly345"]},
        }
    )
    sweep(scene, tmp_path)
    table = load(tmp_path / "designs.parquet")
    assert len(table)
    row = table.iloc[0]
    moved = {"cam.base_radius": float(row["base_radius_mm"])}
    motion = [{**s, "law": row["law_rise"]} if s["segment"] != "dwell" else s for s in scene.to_dict()["motion"]]
    one = evaluate(scene.replace(**moved, motion=motion))
    assert row["contact_stress_max_MPa"] == pytest.approx(one["contact_stress_max_MPa"], rel=1e-8)
    least = optimise(scene.replace(**{"search.law": None})).best["base_radius_mm"]
    for share, held in ((1 + 1e-7, True), (1 - 1e-4, False)):
        limited = evaluate(scene.replace(**{"cam.base_radius": least * share}))
        assert ("contact_stress" not in limited["violated"].split(",")) == held


# ------------------------------------------------------------------------------------------------------- input


def test_a_csv_file_is_its_rows(tmp_path):
    lines = ["angle, load, remark", *(f"{angle!r},{value!r},x" for angle, value in JUMPING)]
    (tmp_path / "gas.csv").write_text("\n".join(lines))
    plain = Scene.from_dict(cam_under_load(JUMPING))
    text = plain.replace(**{"follower.dynamics.load": 1.0}).to_toml().replace("load = 1.0", 'load = "gas.csv"')
    (tmp_path / "scene.toml").write_text(text)
    made = Scene.from_toml(tmp_path / "scene.toml")
    assert made.follower == plain.follower
    assert Scene.from_dict(made.to_dict()) == made
    assert hash(made) == hash(Scene.from_dict(made.to_dict()))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "load: has 0 rows"),
        ([[0, 1]] * 2001, "has 2001 rows"),
        ("none.csv", "load = 'none.csv': must be a CSV file with columns angle and load"),
        (True, "load = True: must be a number"),
        ([[0, 1], 3], r"load.2 = 3: must be a row \[cam angle in deg, load\]"),
        ([[0, 1, 2]], r"load.1 = \[0, 1, 2\]: must be a row"),
        ([[0, float("nan")]], "load.1 = .* must be a row"),
        ([[-1, 0]], "load.1 = -1: must have a cam angle from 0 to 360"),
        ([[0, 2e9]], "load.1 = 2000000000.0: must have a load"),
        ([[5, 1], [3, 1]], "load.2 = 3: must have a cam angle equal to the 5 deg"),
        ([[5, 1], [5 + 1e-9, 1]], "load.2 = "),
        ([[0, 1], [359.9999999, 3]], "load.2 = 359.9999999: must be the first cam angle"),
        ([[0, 1], [0, 2], [360, 3]], "load.1 = 0.0: more than two rows have this cam angle"),
    ],
)
def test_mistakes_in_a_table(rows, message):
    with pytest.raises(BadInput, match=message) as raised:
        Scene.from_dict(cam_under_load(rows))
    assert len(raised.value.mistakes) == 1


ANYTHING = st.one_of(st.none(), st.booleans(), st.text(max_size=3), st.floats(), st.integers(), st.floats(0, 360))
ROWS = st.lists(st.one_of(st.lists(ANYTHING, max_size=3), st.lists(st.floats(0, 360), min_size=2, max_size=2)))


@settings(max_examples=times(30, deep=2000))
@given(ROWS)
def test_any_table_makes_a_scene_or_one_mistake(rows):
    try:
        scene = Scene.from_dict(cam_under_load(rows))
    except BadInput as wrong:
        (mistake,) = wrong.mistakes
        assert mistake.key.startswith("follower.dynamics.load")
    else:
        assert Scene.from_dict(scene.to_dict()) == scene
        ours = evaluate(scene.replace(outputs=OF_MOTION))
        assert ours["contact_force_min_N"] <= ours["contact_force_max_N"]

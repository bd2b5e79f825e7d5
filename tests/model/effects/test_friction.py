"""Friction in the guide: against the equilibrium of the follower (``friction.py``), balances, signs and limits."""

from functools import cache
from math import pi, radians

import numpy as np
import pytest
from support import friction
from support.balls.ball import Ball
from support.depth import covering_cases

from camopt import BadInput, Scene, certify, evaluate, find_scene, optimise
from camopt.core.kernels.compile import compiled
from camopt.core.numerics.curves import Linear, value_and_slope
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.jet import Jet
from camopt.core.numerics.state import State
from camopt.model.effects.loads import force_with_guide_friction, pushing_force
from camopt.model.mechanisms import MECHANISMS
from camopt.model.motion.law_panels import turning_points
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import INWARD, OUTWARD, RESTING, WAYS
from camopt.scene.own_laws import make_own_law_from_values
from camopt.scene.problem.problem import resolve

# each mechanism once, laws that turn back, loads that change, contact that is lost, a follower that jams, and a
# speed that rounds to below 0 where a rise ends
SEEDS = [4, 6, 7, 9, 8, 13, 134, 20, 33, 21]


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_loads_are_those_of_the_follower_in_equilibrium(seed):
    _, apart = friction.differences(friction.random_scene(seed))
    assert apart
    assert max(apart.values()) < 1e-9, apart


@pytest.mark.long
@pytest.mark.parametrize("seed", [seed for seed in range(200) if seed not in SEEDS])
def test_loads_of_random_scenes_are_those_of_the_follower_in_equilibrium(seed):
    try:
        _, apart = friction.differences(friction.random_scene(seed))
    except (BadInput, ValueError) as refused:  # by the package, by the model
        pytest.skip(f"no cam: {refused}")
    assert apart
    assert max(apart.values()) < 1e-9, apart


def test_the_random_scenes_try_every_mechanism():
    scenes = [Scene.from_dict(friction.random_scene(seed)) for seed in range(len(friction.CONTACTS))]
    assert {resolve(scene).setup.mechanism.name for scene in scenes} == {m.name for m in MECHANISMS.values()}


# ------------------------------------------------------------------------------------------------- the ways


def guided_cam(**changes):
    """A roller in its guide that thrusts to the rise's side on a part of its return: e is on the far side."""
    scene = {
        "cam": {"form": "disc", "base_radius": 45, "rpm": 250},
        "follower": {
            "motion": "translating",
            "contact": "roller",
            "roller_radius": 12,
            "offset": -20,
            "dynamics": {
                "mass": 1.2,
                "spring_rate": 6,
                "preload": 150,
                "friction": 0.15,
                "guide_length": 60,
                "overhang": 50,
                "stem_diameter": 14,
            },
        },
        "motion": [
            {"segment": "rise", "angle": 110, "lift": 20, "law": "cycloidal"},
            {"segment": "dwell", "angle": 40},
            {"segment": "return", "angle": 130, "lift": 20, "law": "poly345"},
            {"segment": "dwell", "angle": 80},
        ],
        "outputs": ["thrust", "torque"],
    }
    return Scene.from_dict(scene).replace(**changes)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("offset", [-25, 0, 25])
def test_a_return_is_eased_by_friction_to_whichever_side_it_thrusts(offset):
    """A load that has its peak at one cam angle of the return, and pulls elsewhere: N there is the sheet's."""
    rows = [[0, -300], [200, -300], [215, 900], [230, -300]]
    scene = guided_cam(**{"follower.dynamics.load": rows, "follower.offset": offset, "outputs": ["thrust"]})
    y, y1, y2, _ = resolve(scene).programme.motion_at(np.array([radians(215)]))[:, 0]
    tangent = (y1 - offset) / (np.sqrt(57.0**2 - offset**2) + y)
    assert np.sign(tangent) == (1 if offset < 0 else -1)
    force = 1.2e-3 * (250 * pi / 30) ** 2 * y2 + 6 * y + 150 + 900
    q = (2 * (50 - y) + 60) / 60
    expected = force * np.hypot(1, tangent) / (1 + 0.15 * q * abs(tangent))
    found = evaluate(scene)
    assert found["normal_force_max_N"] == pytest.approx(expected, rel=1e-12)
    assert found["side_thrust_max_N"] == pytest.approx(expected * abs(np.sin(np.arctan(tangent))), rel=1e-12)


@pytest.mark.slow
def test_where_an_open_cam_would_pull_nothing_is_counted():
    scene = guided_cam(**{"follower.dynamics.load": -5000.0, "outputs": ["thrust"]})
    found = evaluate(scene)
    names = ("normal_force_max_N", "side_thrust_max_N", "guide_reaction_max_N", "stem_bending_stress_max_MPa")
    assert [found[name] for name in names] == [0.0] * 4
    free = scene.replace(**{"follower.dynamics.friction": 0.0})
    assert [evaluate(free)[name] for name in names] == [0.0] * 4


@pytest.mark.slow
def test_at_rest_no_friction_is_counted():
    """A load on the dwells alone: its normal force is F/cos β."""
    rows = [[0, -400], [112, -400], [118, 900], [140, 900], [148, -400]]
    scene = guided_cam(**{"follower.dynamics.load": rows, "outputs": ["thrust"]})
    height, e = np.sqrt(57.0**2 - 20.0**2) + 20, -20.0
    normal = (6 * 20 + 150 + 900) * np.hypot(1, e / height)
    assert evaluate(scene)["normal_force_max_N"] == pytest.approx(normal, rel=1e-12)


def test_the_work_of_the_torque_is_what_guide_damper_and_load_take():
    scene = friction.random_scene(13)
    scene["follower"]["dynamics"]["damping"] = 0.05
    model, found = friction.expected_quantities(scene), evaluate(Scene.from_dict(scene))
    omega, taken = scene["cam"]["rpm"] * pi / 30, 0.0
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for piece, line in friction.turn(scene):
        half = (piece.end - piece.start) / 2
        for u, w in zip(nodes, weights, strict=True):
            theta = (piece.start + piece.end) / 2 + half * u
            speed = float(piece.jet(theta)[1])
            taken += half * w * (0.05 * omega * speed + friction.naive.on_line(line, theta)) * speed
    assert model["lost"] > 0.01 * abs(taken)
    assert 2 * pi * found["torque_mean_N_m"] * 1e3 == pytest.approx(taken + model["lost"], rel=1e-9)


def test_without_friction_the_torque_is_that_of_the_motion_to_the_bit():
    free = guided_cam(**{"follower.dynamics.friction": 0.0})
    bare = guided_cam(
        **{f"follower.dynamics.{key}": None for key in ("friction", "guide_length", "overhang", "stem_diameter")}
    )
    torque = {name: value for name, value in evaluate(bare).items() if "torque" in name or "power" in name}
    assert len(torque) > 5
    assert {name: evaluate(free)[name] for name in torque} == torque


# ------------------------------------------------------------------------- certificates, boxes, convex steps

LIMITS = {
    "normal_force": "normal_force_max_N",
    "side_thrust": "side_thrust_max_N",
    "guide_reaction": "guide_reaction_max_N",
    "torque": "torque_peak_N_m",
    "power": "power_peak_W",
    "jamming_margin": "jamming_margin",
}


BOTH = [(limit, seed) for k, limit in enumerate(LIMITS) for seed in ((13, 185), (185, 13))[k % 2]]


@cache
def of_random_scene(seed):
    return evaluate(Scene.from_dict(friction.random_scene(seed)))


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("limit", "seed"), covering_cases(BOTH, lambda pair: pair[:1]))
def test_balls_and_doubles_meet_at_the_bound(limit, seed):
    scene = {**friction.random_scene(seed), "outputs": [LIMITS[limit]]}
    value = of_random_scene(seed)[LIMITS[limit]]
    side = -1.0 if limit == "jamming_margin" else 1.0
    for share, verdict in ((1e-10, "held"), (-1e-10, "broken")):
        limited = Scene.from_dict({**scene, "limits": {limit: value * (1.0 + side * share)}})
        assert certify(limited)[limit] == verdict
        assert (limit in evaluate(limited)["violated"].split(",")) == (verdict == "broken")


def test_the_smallest_cam_under_a_torque_that_friction_makes_depend_on_the_size():
    scene = guided_cam(search={"base_radius": {"start": 44, "stop": 46}})
    peaks = [evaluate(guided_cam(**{"cam.base_radius": size}))["torque_peak_N_m"] for size in (30.0, 45.0, 90.0)]
    assert peaks == sorted(peaks, reverse=True)
    best = optimise(scene.replace(**{"limits.torque": peaks[1]})).best
    assert best["base_radius_mm"] == pytest.approx(45.0, rel=1e-6)
    assert best["proved"]


@pytest.mark.parametrize("number", [Ball, lambda x: Interval(np.array([x]), np.array([x])), np.float64])
@pytest.mark.parametrize(("force", "lean"), [(80.0, 0.3), (80.0, -0.3), (-80.0, 0.3), (-80.0, -0.3), (0.0, 0.3)])
def test_number_systems_agree_on_the_guide(number, force, lean):
    """G of a force that is constant and a slope that is y' itself, with an open cam's and a groove's force."""
    ones = np.ones(1)
    given = Linear(0 * ones, 0 * ones, 0 * ones, force * ones)
    tangent = Linear(0 * ones, ones, 0 * ones, 0 * ones)
    for made, expected in ((given, force / (1.0 - 0.5 * np.sign(force) * abs(lean))), (pushing_force(given), None)):
        guide = force_with_guide_friction(made, tangent, 0.5 * ones, 0 * ones)
        value = value_and_slope(guide, 0, State(number(0.0), number(lean), number(0.0), number(0.0)))[0]
        value = value.arb if isinstance(value, Ball) else value.low if isinstance(value, Interval) else value
        wanted = expected if expected is not None else max(force, 0.0) / (1.0 - 0.5 * abs(lean))
        assert float(
            np.ravel(np.asarray(float(value.mid()) if hasattr(value, "mid") else value))[0]
        ) == pytest.approx(wanted)


@compiled
def corner_bounds(a, found):
    """What has a corner, of the jet a: low, high and the bound of the second derivative."""
    p = Jet(a[0], a[1], a[2], a[3], a[4], a[5])
    jets = np.absolute(p), np.sign(p), np.maximum(p, 0.0)
    for k, z in enumerate(jets):
        found[k, 0], found[k, 1], found[k, 2] = z.low, z.high, z.second


def test_jets_know_corners():
    """|a|, max(a, 0) and the sign of a jet hold what they are of every number in its range."""
    for low, high in ((-2.0, 3.0), (1.0, 2.0), (-3.0, -1.0), (0.0, 1.0)):
        inside, rows = np.linspace(low, high, 101), np.empty((3, 3))
        corner_bounds(np.array([low, high, 1e-16, 2.0, 3.0, 4.0]), rows)
        for function, found in zip((np.abs, np.sign, lambda x: np.maximum(x, 0.0)), rows, strict=True):
            values = function(inside)
            assert found[0] <= values.min()
            assert values.max() <= found[1]
            smooth = low >= 0.0 if function is not np.sign else low > 0.0
            assert np.isfinite(found[2]) == (smooth or high < 0.0)


# ------------------------------------------------------------------------------------------- which way it moves


def test_a_law_that_turns_back_is_cut_where_it_does():
    law = make_own_law_from_values("wavy", friction.WAVY["wavy"])
    places = turning_points(law, 24)
    assert len(places) == 2
    assert np.abs(law.velocity(np.array(places))).max() < 1e-12
    programme = Programme.from_segments(
        [("rise", 150.0, 10.0, "wavy"), ("dwell", 40.0, 0.0, None), ("return", 170.0, 10.0, "wavy")],
        angular=False,
        laws={"wavy": law},
    )
    table, ends = programme.table, [*programme.piece_starts, 2 * pi]
    for start, end, kind in zip(ends[:-1], ends[1:], table.kind, strict=True):
        speed = programme.motion_at(np.linspace(start, end, 101)[1:-1])[1]
        way = {OUTWARD: 1.0, INWARD: -1.0, RESTING: 0.0}[int(kind) & WAYS]
        assert (np.sign(speed) == way).all()
    assert np.min(
        np.abs(np.subtract.outer(radians(150.0) * np.array(places), programme.piece_starts)), axis=1
    ) == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("scene", ["roller-1000rpm", "oscillating-roller", "valve-rod-offset"])
def test_laws_that_never_turn_back_are_not_cut(scene):
    programme = resolve(find_scene(scene)).programme
    for law in resolve(find_scene(scene)).laws.values():
        assert turning_points(law, 24) == ()
    ways = {1: OUTWARD, 2: INWARD, 4: RESTING}
    assert all(int(kind) & WAYS == ways[int(kind) & 7] for kind in programme.table.kind)

"""Preload of two contacts, against two springs that can only push."""

import numpy as np
import pytest
from support.cams import STEEL, SWUNG, WORN, cam_with, turn_of
from support.pairs import pair

from camopt import BadInput, Scene, cam_points, certify, evaluate, optimise
from camopt.core.numerics.curves import Linear, value_and_slope
from camopt.core.numerics.jet import Jet
from camopt.core.numerics.state import State
from camopt.model.effects.loads import preloaded_contact_force
from camopt.scene.problem.problem import resolve_design


def borne_by_springs(force, preload):
    """What each of two equal springs bears that press on both sides of a body with a preload; by bisection."""
    stiffness, low, high = 1.0, -10.0 * (abs(force) + preload), 10.0 * (abs(force) + preload)
    for _ in range(200):
        moved = 0.5 * (low + high)
        one, other = (max(preload + side * stiffness * moved, 0.0) for side in (1.0, -1.0))
        low, high = (moved, high) if one - other < force else (low, moved)
    return one, other


def test_two_contacts_share_a_force_as_two_springs_do():
    rng = np.random.default_rng(5)
    for force, preload in zip(rng.uniform(-100, 100, 60), rng.uniform(0, 60, 60), strict=True):
        zero, each = np.zeros(1), np.array([force])
        state = resolve_design(Scene.from_dict(pair(rng, "translating"))).programme.state(np.zeros(1))
        found = [
            value_and_slope(
                preloaded_contact_force(Linear(zero, zero, zero, side * each), np.array([preload])), ..., state
            )[0][0]
            for side in (1.0, -1.0)
        ]
        assert found == pytest.approx(borne_by_springs(force, preload), abs=1e-9)


def test_a_contact_that_is_never_touched_bears_nothing_over_a_whole_range():
    """With F/2 + |F|/2 it would be a range about 0, which a search of the largest force cuts up without end."""
    way = np.array([1.0])
    force = Linear(way, 0.0 * way, 0.0 * way, 0.0 * way)  # F is the displacement
    at = State(Jet(-5.0, -3.0, 0.0, 2.0, 2.0, 2.0), *(Jet(0.0, 0.0, 0.0, 0.0, 0.0, 0.0) for _ in range(3)))
    borne, _ = value_and_slope(preloaded_contact_force(force, way), 0, at)
    assert (borne.low, borne.high, borne.first, borne.second, borne.third) == (0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("motion", ["translating", "oscillating"])
def test_the_stress_of_each_contact_is_that_of_its_share(motion):
    swings = motion == "oscillating"
    scene = pair(np.random.default_rng(8), motion)
    scene["follower"]["dynamics"] = SWUNG if swings else {"mass": 3.0, "spring_rate": 2.0, "load": -30.0}
    scene["drive"] |= {"interference": 0.01, "stiffness": 30_000 if swings else 9_000}
    scene |= {"materials": STEEL, "outputs": ["hertz", "pair", "preload"]}
    cam, problem = evaluate(Scene.from_dict(scene)), resolve_design(Scene.from_dict(scene))
    angles, setup, mechanism = np.linspace(0.0, 2.0 * np.pi, 20001), problem.setup, problem.setup.mechanism
    state, unit = problem.programme.state(angles), 1e3 if swings else 1.0
    mass, damping, rate, rest = (
        setup.dynamics.mass,
        setup.dynamics.damping,
        setup.dynamics.stiffness,
        setup.dynamics,
    )
    force = mass * setup.omega**2 * state.y2 + damping * setup.omega * state.y1 + rate * state.y + rest.preload
    force = force + rest.load
    preload = 0.01 * (np.pi / 180.0 if swings else 1.0) * scene["drive"]["stiffness"] * unit
    shares = np.array([borne_by_springs(each, preload) for each in force[::20]]).T
    modulus, width = setup.bodies.modulus, STEEL["face_width"]
    points = cam_points(Scene.from_dict(scene), np.degrees(angles[::20][5::50]))
    second = mechanism.further_contacts[0]
    for place, (form, design), share in zip(
        ("first", "second"),
        ((mechanism, problem.design), (second.mechanism, second.local_designs(problem.design))),
        shares,
        strict=True,
    ):
        tangent, kappa = (
            value_and_slope(made(design, problem.programme), ..., state)[0][::20]
            for made in (form.pressure, form.curvature)
        )
        along = share / (design.arm_length[0] if swings else 1.0)
        assert points[f"{place}_contact_force_N"] == pytest.approx(along[5::50], abs=1e-6 * along.max())
        normal = along * np.hypot(1.0, tangent)
        radius = design.roller_radius[0] * (1.0 - kappa * design.roller_radius[0])
        seen = np.sqrt(normal * modulus / (np.pi * width * radius)).max()
        assert seen == pytest.approx(cam[f"{place}_contact_stress_max_MPa"], rel=1e-4)
    least = max(abs(force.min()), abs(force.max())) / 2.0
    names = ("N_m", "deg") if swings else ("N", "mm")
    assert cam[f"pair_preload_{names[0]}"] == pytest.approx(preload / unit, rel=1e-13)
    assert cam[f"pair_preload_required_{names[0]}"] == pytest.approx(least / unit, rel=1e-6)
    share = cam[f"interference_required_{names[1]}"] / 0.01
    assert share == pytest.approx(least / preload, rel=1e-6)
    assert cam["pair_preload_ratio"] == pytest.approx(preload / least, rel=1e-6)
    assert bool(cam.warnings) == (cam["pair_preload_ratio"] < 1.0)


def test_a_limit_on_the_preload_holds_up_to_the_speed_at_which_a_contact_lets_go():
    """The force of the inertia alone grows with the square of the speed, and so the speed is known by hand."""
    scene = pair(np.random.default_rng(8), "translating")
    scene["follower"]["dynamics"] = {"mass": 3.0}
    scene["drive"] |= {"interference": 0.01, "stiffness": 9_000}
    scene |= {"limits": {"pair_preload_ratio": 1.0}}
    ratio = evaluate(Scene.from_dict(scene))["pair_preload_ratio"]
    speed = scene["cam"]["rpm"] * np.sqrt(ratio)
    for rpm, held in ((speed * (1 - 1e-9), True), (speed * (1 + 1e-9), False)):
        cam = evaluate(Scene.from_dict(scene | {"cam": scene["cam"] | {"rpm": rpm}}))
        assert cam["feasible"] is held
        assert not cam.warnings
    search = {"search": {"drive.interference": {"start": 0.001, "stop": 0.02}}}
    free = {"limits": {"pair_preload_ratio": 1.0, "pressure_angle": 60}, **search}
    best = optimise(Scene.from_dict(scene | free)).best
    assert best["pair_preload_ratio"] >= 1.0


@pytest.mark.parametrize("interference", [0, 5e-324])
def test_an_interference_whose_preload_rounds_to_0_is_none(interference):
    """5e-324° is 0 in radians."""
    scene = pair(np.random.default_rng(8), "oscillating")
    scene |= {"follower": scene["follower"] | {"dynamics": SWUNG}}
    scene |= {"outputs": ["pair_preload_N_m"]}
    scene["drive"] |= {"interference": interference, "stiffness": 7e5}
    cam = evaluate(Scene.from_dict(scene))
    assert cam["pair_preload_N_m"] == 0.0
    assert not cam.warnings
    with pytest.raises(BadInput, match=r"limits\.pair_preload_ratio = 1\.0: needs drive\.interference"):
        evaluate(Scene.from_dict(scene | {"limits": {"pair_preload_ratio": 1}}))


DRIVES = {
    "flat": {"kind": "breadth"},
    "roller": {"kind": "diameter"},
    "arm": {"kind": "conjugate", "roller_radius": 12},
    "groove": {"kind": "rib"},
}


def loaded_scene(contact, load, **more):
    """A cam with two contacts that a load presses on one of them, in the direction of its sign."""
    dynamics = {"inertia": 6e-3, "load": 0.1 * load} if contact == "arm" else {"mass": 0.8, "load": load}
    data = cam_with(
        contact, "poly345", dynamics, materials=WORN, outputs=["surface"], drive=DRIVES[contact], **more
    )
    if contact == "groove":
        data["follower"]["roller_spacing"] = 45
    if contact in ("flat", "roller"):
        data["motion"] = turn_of("poly345", 24, (110, 70, 110, 70))
    return Scene.from_dict(data)


@pytest.mark.parametrize("load", [500, -500])
@pytest.mark.parametrize("contact", DRIVES)
def test_a_contact_that_never_bears_needs_no_film(contact, load):
    film = evaluate(loaded_scene(contact, load))["film_ratio_min"]
    if load > 0 and contact != "groove":
        alone = loaded_scene(contact, load).replace(drive=None)
        assert film == pytest.approx(evaluate(alone)["film_ratio_min"], rel=1e-12)
    for share, verdict in ((1 - 1e-9, "held"), (1 + 1e-9, "broken")):
        limited = loaded_scene(contact, load, limits={"film_ratio": share * film})
        assert certify(limited)["film_ratio"] == verdict
        assert ("film_ratio" in evaluate(limited)["violated"]) == (verdict == "broken")


def test_a_robust_yoke_behind_an_uncertain_train_is_undecided():
    """Its halves of a turn have to be the same, of which parts of the turn do not tell."""
    zone = {"train.1.ratio": 0.02}
    more = {"train": [{"stage": "ratio", "ratio": 1.1}], "tolerances": zone, "search": {"robust": True}}
    assert certify(loaded_scene("flat", 500, limits={"film_ratio": 1e-6}, **more))["film_ratio"] == "undecided"


def test_a_yoke_has_the_same_film_on_either_face():
    assert evaluate(loaded_scene("flat", -500))["film_ratio_min"] == pytest.approx(
        evaluate(loaded_scene("flat", 500))["film_ratio_min"], rel=1e-12
    )


@pytest.mark.parametrize(("load", "error", "verdict"), [(500, 10, "held"), (70, 30, "broken"), (5, 1, "broken")])
def test_contacts_open_at_some_loads_within_a_tolerance(load, error, verdict):
    """The force of inertia is 58 N: with 70 N one face bears all over the turn, with 40 N both do."""
    zone = {"follower.dynamics.load": error}
    scene = loaded_scene("flat", load, limits={"film_ratio": 1e-6}, tolerances=zone, search={"robust": True})
    assert (evaluate(scene)["film_ratio_min"] > 0.0) == (load > 58)
    assert certify(scene)["film_ratio"] == verdict


@pytest.mark.parametrize(
    ("table", "key", "says"),
    [
        ("limits", "jump_speed", "limits.pair_preload_ratio = 1"),
        ("limits", "contact_force_min", "limits.pair_preload_ratio = 1"),
        ("limits", "contact_force_elastic", "limits.pair_preload_ratio = 1"),
        ("limits", "crossing_speed", "limits.pair_preload_ratio = 1"),
        ("drive", "interference", "needs drive.stiffness, which is missing"),
        ("drive", "stiffness", "needs drive.interference, which is missing"),
        ("drive", "offset", "an oscillating follower has none; it has drive.arm_length"),
    ],
)
def test_what_two_contacts_have_not_is_refused_with_what_they_have(table, key, says):
    scene = pair(np.random.default_rng(8), "oscillating")
    scene |= {"follower": scene["follower"] | {"dynamics": SWUNG}}
    with pytest.raises(BadInput, match=says) as refused:
        evaluate(Scene.from_dict(scene | {table: scene.get(table, {}) | {key: 0.2}}))
    (mistake,) = refused.value.mistakes
    assert mistake.key == f"{table}.{key}"

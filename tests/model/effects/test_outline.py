"""Outer radius and clearance of a pivot: against points of the profile, closed forms, and what limits leave."""

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy import optimize
from support.cams import CONTACTS, cam_with

from camopt import (
    BadInput,
    Scene,
    cam_points,
    certify,
    evaluate,
    find_scene,
    load,
    optimise,
    shipped_scenes,
    sweep,
)
from camopt.model.effects import EvaluationBlock, outline
from camopt.model.effects.peak_columns import peak_extremes
from camopt.model.motion import LAWS
from camopt.scene.problem.problem import resolve
from camopt.solve.front.curve_verdicts import limits_decided_by_pitch_curves

OPEN = [contact for contact in CONTACTS if not contact.startswith("groove")]


def scene_of(contact, law="cycloidal", rotation="ccw", **more):
    return Scene.from_dict(cam_with(contact, law, rotation=rotation, outputs=["outer_radius_mm"], **more))


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", OPEN)
def test_no_point_of_the_profile_is_farther_and_one_is_as_far(contact, rotation):
    scene = scene_of(contact, rotation=rotation)
    points = cam_points(scene, step=0.05)
    farthest = np.max(np.hypot(points["profile_x_mm"], points["profile_y_mm"]))
    assert evaluate(scene)["outer_radius_mm"] == pytest.approx(farthest, rel=1e-12)  # a dwell at the highest


def distances(contact, sizes, y):
    """Of the farthest point of the follower's contact from the cam's axis, from the triangle of each position."""
    base, centre, arm, roller, offset, face = (
        sizes[k] for k in ("base", "centre", "arm", "roller", "offset", "face")
    )
    if contact == "flat":
        return base + y
    if contact == "swinging-face":
        return face + centre * np.sin(np.arcsin((base - face) / centre) + y)
    if contact == "arm":
        first = np.arccos((centre**2 + arm**2 - (base + roller) ** 2) / (2 * centre * arm))
        return np.sqrt(centre**2 + arm**2 - 2 * centre * arm * np.cos(first + y)) - roller
    return np.hypot(offset, np.sqrt((base + roller) ** 2 - offset**2) + y) - roller


SIZE_KEYS = {
    "centre": "follower.centre_distance",
    "arm": "follower.arm_length",
    "roller": "follower.roller_radius",
    "offset": "follower.offset",
    "face": "follower.face_offset",
}
SIZES_OF = {
    "roller": ("roller",),
    "offset-roller": ("roller", "offset"),
    "flat": (),
    "arm": ("roller", "arm", "centre"),
    "swinging-face": ("face", "centre"),
}


@pytest.mark.parametrize("contact", SIZES_OF)
def test_a_scan_finds_the_farthest_where_the_follower_is_highest(contact):
    rng = np.random.default_rng(911)
    for law in rng.choice(list(LAWS), 6, replace=False):
        ranges = {"base": (45, 75), "centre": (110, 150), "arm": (85, 125), "roller": (5, 15)}
        ranges |= {"offset": (-20, 20), "face": (-9, 20)}
        sizes = {name: rng.uniform(*ends) for name, ends in ranges.items()}
        sizes["offset"] *= contact == "offset-roller"
        swings = contact in ("arm", "swinging-face")
        lift = rng.uniform(5.0, 25.0)
        y = (np.radians(lift) if swings else lift) * LAWS[law].displacement(rng.uniform(size=20_000))
        y = np.append(y, np.radians(lift) if swings else lift)
        seen = distances(contact, sizes, np.sort(y))
        assert np.all(np.diff(seen) >= -1e-14 * seen[-1])
        motion = [each | ({"lift": lift} if "lift" in each else {}) for each in cam_with(contact, law)["motion"]]
        given = {SIZE_KEYS[name]: sizes[name] for name in SIZES_OF[contact]}
        outputs = ["outer_radius_mm", *(["pivot_clearance_min_mm"] if swings else [])]
        scene = scene_of(contact, law, rng.choice(["ccw", "cw"]), motion=motion).replace(
            **{"cam.base_radius": sizes["base"], "outputs": outputs, **given}
        )
        found = evaluate(scene)
        assert found["outer_radius_mm"] == pytest.approx(seen.max(), rel=1e-12)
        if swings:
            room = sizes["centre"] - seen.max()
            assert found["pivot_clearance_min_mm"] == pytest.approx(room, abs=1e-12 * sizes["centre"])


@pytest.mark.parametrize("name", [n for n in shipped_scenes() if find_scene(n).mechanism.outline])
def test_the_closed_form_is_what_a_search_over_the_turn_finds(name):
    """Behind trains and with measured profiles too."""
    problem = resolve(find_scene(name))
    case = EvaluationBlock(problem.setup, problem.programme, problem.design)
    for peak in outline.peaks(problem.setup).values():
        searched = peak_extremes(case, peak._replace(at_ends=False)).value
        np.testing.assert_allclose(peak_extremes(case, peak).value, searched, rtol=1e-12, atol=1e-11)


@pytest.mark.parametrize("contact", ["arm", "swinging-face"])
def test_the_turning_cam_stays_as_far_from_the_pivot_as_the_nearest_point_of_its_profile(contact):
    """In the cam's frame the pivot goes round it: the least distance of its path from any point of the profile."""
    scene = scene_of(contact).replace(outputs=["pivot_clearance_min_mm"])
    points = cam_points(scene, step=0.25)
    profile = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    centre = scene.numbers(["follower.centre_distance"])["follower.centre_distance"]
    path = centre * np.exp(1j * np.radians(np.arange(0.0, 360.0, 0.25)))
    nearest = min(np.abs(path - each).min() for each in profile)
    assert evaluate(scene)["pivot_clearance_min_mm"] == pytest.approx(nearest, rel=1e-4)


@pytest.mark.long
def test_no_cam_of_a_grid_that_stays_clear_of_the_pivot_is_smaller():
    """With the centre distance free, a clearance makes it larger: that of the smallest cam at all leaves 8.3 mm."""
    search = {"base_radius": {"start": 20, "stop": 150}, "centre_distance": {"start": 60, "stop": 180}}
    limits = {"pressure_angle": 35, "pivot_clearance_min_mm": 15.0}
    scene = scene_of("swinging-face", limits=limits, search=search)
    best = optimise(scene).best
    assert best["proved"]
    assert evaluate(best.scene)["pivot_clearance_min_mm"] == pytest.approx(15.0, rel=1e-7)
    search["base_radius"]["stop"] = 20 + np.ceil(best["base_radius_mm"] - 20 + 0.5)  # larger cams say nothing
    steps = {name: ends | {"step": 0.2} for name, ends in search.items()}
    seen = sweep(scene.replace(**{f"search.{name}": each for name, each in steps.items()})).best["cycloidal"]
    assert 0.0 <= seen["base_radius_mm"] - best["base_radius_mm"] < 0.5


def farthest(contact, base, centre, arm=110.0, roller=14.0, face=10.0):
    """The farthest point of a cam of ``scene_of`` from its axis, from the triangle at the highest position."""
    rise = np.radians(14.0)
    if contact == "swinging-face":
        return face + centre * np.sin(np.arcsin((base - face) / centre) + rise)
    first = np.arccos((centre**2 + arm**2 - (base + roller) ** 2) / (2 * centre * arm))
    return np.sqrt(centre**2 + arm**2 - 2 * centre * arm * np.cos(first + rise)) - roller


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["arm", "swinging-face"])
def test_a_cam_that_runs_through_the_pivot_is_never_feasible(contact, tmp_path):
    """By the closed form: verdict, proof, sweep, boxes and search, without a limit of the scene."""
    rng = np.random.default_rng(57)
    middle = 97.7 if contact == "arm" else 105.3
    search = {
        "base_radius": {"start": 69.3, "stop": 98.1, "step": 1.7},
        "centre_distance": (middle + rng.uniform(-9, 9, 7)).tolist(),
    }
    scene = scene_of(contact, limits={"pressure_angle": 85}, search=search)
    sweep(scene, out=tmp_path, keep="all")
    found = load(tmp_path / "designs.parquet")
    through = farthest(contact, found["base_radius_mm"], found["centre_distance_mm"]) > found["centre_distance_mm"]
    assert 20 < through.sum() < len(found) - 20
    assert (found["violated"].str.contains("pivot_in_cam") == through).all()
    assert not (found["feasible"] & through).any()
    row = found[~through & found["feasible"]].iloc[-1]
    base = row["base_radius_mm"]
    edge = optimize.brentq(lambda c: farthest(contact, base, c) - c, 60.0 + base / 4, 150.0, xtol=1e-13)
    for share, verdict in ((1.0 + 1e-9, "held"), (1.0 - 1e-9, "broken")):
        own = scene.replace(**{"cam.base_radius": base, "follower.centre_distance": edge * share, "search": {}})
        assert certify(own)["pivot_in_cam"] == verdict
        assert evaluate(own)["violated"] == ("" if verdict == "held" else "pivot_in_cam")
    tight = scene.replace(
        **{"search.centre_distance": edge, "search.base_radius": {"start": base + 0.1, "stop": base + 9.0}}
    )
    none = optimise(tight)
    assert none.best is None
    assert "pivot_in_cam" in none.obstacles["cycloidal"]
    wide = scene.replace(
        **{"search.centre_distance": {"start": edge * 0.9, "stop": edge * 1.1}, "search.base_radius": base}
    )
    assert evaluate(optimise(wide).best.scene)["pivot_clearance_min_mm"] >= 0.0


@pytest.mark.parametrize(("contact", "body"), [("arm", "roller_radius"), ("swinging-face", "face_offset")])
def test_pitch_curves_tell_which_cams_run_through_the_pivot(contact, body, tmp_path):
    """Designs that share a pitch curve are decided together: the same as each by its own closed form."""
    search = {
        "base_radius": {"start": 61.3, "stop": 97.9, "step": 1.1},
        body: {"start": 4.3, "stop": 21.7, "step": 1.7},
    }
    limits = {"pressure_angle": 85} if contact == "arm" else {"curvature_radius": 1.0}
    scene = scene_of(contact, limits=limits, search=search).replace(
        **{"follower.centre_distance": 101.3, "outputs": []}
    )
    problem = resolve(scene)
    assert limits_decided_by_pitch_curves(problem.limits, frozenset())
    found = sweep(scene)
    sweep(scene, out=tmp_path, keep="all")
    every = load(tmp_path / "designs.parquet")
    shift = {"roller": every["roller_radius_mm"]} if contact == "arm" else {"face": every["face_offset_mm"]}
    through = farthest(contact, every["base_radius_mm"], 101.3, **shift) > 101.3
    assert 20 < through.sum() < len(every) - 20
    held = every["feasible"] & ~through
    assert found.feasible == held.sum() == every["feasible"].sum()
    assert found.best["cycloidal"]["base_radius_mm"] == every["base_radius_mm"][held].min()


@pytest.mark.parametrize("law", LAWS)
def test_without_a_dwell_at_the_highest_it_is_reached_at_one_angle(law):
    """√(e² + (s₀ + h)²) − R_r in 50 digits."""
    motion = cam_with("offset-roller", law)["motion"]
    turn = [motion[0] | {"angle": 130}, motion[2] | {"angle": 120}, {"segment": "dwell", "angle": 110}]
    with mp.workdps(50):
        height = mp.sqrt(mpf(84) ** 2 - mpf(11) ** 2)
        exact = mp.sqrt(mpf(11) ** 2 + (height + 24) ** 2) - 14
    found = evaluate(scene_of("offset-roller", law, motion=turn))["outer_radius_mm"]
    assert found == pytest.approx(float(exact), rel=1e-13)


@pytest.mark.long
def test_the_smallest_cam_fits_its_housing_or_there_is_none():
    search = {"base_radius": {"start": 20, "stop": 120}, "law": ["cycloidal"]}
    wide = scene_of("offset-roller", limits={"pressure_angle": 30}, search=search)
    free = optimise(wide).best
    within = optimise(wide.replace(**{"limits.outer_radius": free["outer_radius_mm"] * (1 + 1e-6)})).best
    assert within["proved"]
    assert within["base_radius_mm"] == pytest.approx(free["base_radius_mm"], rel=1e-7)
    assert optimise(wide.replace(**{"limits.outer_radius": free["base_radius_mm"] + 24.0 - 1.0})).best is None


def test_other_cams_have_none():
    with pytest.raises(BadInput, match="only a disc cam has one"):
        scene_of("groove", limits={"outer_radius": 100})
    with pytest.raises(BadInput, match="outer_radius_mm"):
        evaluate(scene_of("groove"))
    with pytest.raises(BadInput, match="this mechanism has no pivot_clearance_min_mm"):
        evaluate(scene_of("roller", limits={"pivot_clearance_min_mm": 10}))

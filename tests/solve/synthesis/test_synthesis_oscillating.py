"""Free laws for oscillating followers, by convex steps: against known laws, long arms, mirrors and curves."""

from math import degrees, pi

import numpy as np
import pytest
from support.depth import is_deep, times
from test_synthesis import free, sound

from camopt import Scene, find_scene, optimise
from camopt.core.mistakes import BadInput, Unmet
from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.model.motion.programme import derivative_root_mean_square
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis.frontier import frontier
from camopt.solve.synthesis.nonconvex_constraints import (
    SampledConstraints,
    nonconvex_constraints_of,
    stroke_sample_positions,
)
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.synthesise import synthesise

MOTION = [
    {"segment": "rise", "angle": 110, "lift": 18, "law": "poly345"},
    {"segment": "dwell", "angle": 40},
    {"segment": "return", "angle": 100, "lift": 18, "law": "poly345"},
    {"segment": "dwell", "angle": 110},
]
ARM = {
    "cam": {"form": "disc", "rotation": "ccw", "rpm": 300, "base_radius": 40},
    "follower": {
        "motion": "oscillating",
        "contact": "roller",
        "roller_radius": 8,
        "arm_length": 110,
        "centre_distance": 120,
    },
    "motion": MOTION,
    "limits": {"pressure_angle": 38},
    "synthesis": {"pieces": times(8, deep=12)},
}
FACE = ARM | {
    "follower": {"motion": "oscillating", "contact": "flat", "face_offset": 6, "centre_distance": 120},
    "limits": {"curvature_radius": 8, "face_reach": 140},
}
KNIFE = ARM | {"follower": ARM["follower"] | {"contact": "knife", "roller_radius": None}}
GROOVE = ARM | {
    "cam": {"form": "cylindrical", "rpm": 300, "mean_radius": 60},
    "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 8, "arm_length": 110},
}
SWUNG = {"arm": ARM, "knife": KNIFE, "face": FACE, "groove": GROOVE}
"""Every mechanism whose follower oscillates."""


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", SWUNG)
def test_free_laws_beat_the_known_law_with_their_peaks(name):
    scene = Scene.from_dict(SWUNG[name])
    known, result = optimise(scene).best, free(scene)
    sound(result)
    size = resolve(scene).size_quantity_name
    assert result.objective == result.design[size] < 0.97 * known[size]
    assert result.bound is None
    assert not result.convex
    peaks = [result.peaks[law] for law in result.laws]
    assert max(peak["peak_acceleration"] for peak in peaks) <= 10 / 3**0.5 * (1 + 1e-9)  # those of poly345
    assert max(peak["peak_jerk"] for peak in peaks) <= 60 * (1 + 1e-9)


@pytest.mark.long
def test_a_long_arm_is_a_follower_that_translates():
    """Its pivot far away, the offset e = l − c on one side: the radius differs as 1/l, to either side alike."""
    along = ARM["follower"] | {"motion": "translating", "arm_length": None, "centre_distance": None, "offset": 5}
    motion = [{**s, "lift": 30} if "lift" in s else s for s in MOTION]
    straight = free(Scene.from_dict(ARM | {"follower": along, "motion": motion}))
    assert straight.convex
    errors = []
    for arm in (2e3, 2e4):
        swing = [{**s, "lift": degrees(30 / arm)} if "lift" in s else s for s in MOTION]
        ends = []
        for rotation, distance in (("ccw", arm + 5), ("cw", arm - 5)):
            follower = ARM["follower"] | {"arm_length": arm, "centre_distance": distance}
            cam = ARM["cam"] | {"rotation": rotation}
            ends.append(free(Scene.from_dict(ARM | {"cam": cam, "follower": follower, "motion": swing})).objective)
        assert min(ends) < straight.objective < max(ends)
        errors.append(max(ends) - min(ends))
    assert errors[1] == pytest.approx(errors[0] / 10, rel=0.1)
    assert sum(ends) / 2 == pytest.approx(straight.objective, rel=1e-3)


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["arm", "face"])
def test_the_mirrored_cam_with_the_turn_backwards_is_as_large(name):
    scene = SWUNG[name]
    backwards = [{**s, "segment": {"rise": "return", "return": "rise"}.get(s["segment"], "dwell")} for s in MOTION]
    dwells_first = [backwards[k] for k in (2, 1, 0, 3)]
    mirrored = scene | {"cam": scene["cam"] | {"rotation": "cw"}, "motion": dwells_first}
    one, other = free(Scene.from_dict(scene)), free(Scene.from_dict(mirrored))
    assert one.objective == pytest.approx(other.objective, rel=1e-3)


@pytest.mark.parametrize("name", SWUNG)
def test_planes_are_tangent_to_the_curves_of_limits(name):
    problem = build_synthesis_problem(Scene.from_dict(SWUNG[name]).replace(**{"synthesis.pieces": 6}))
    constraints, random = nonconvex_constraints_of(problem), np.random.default_rng(2)
    assert constraints
    for stroke in problem.strokes:
        sampled, orders = SampledConstraints(problem, stroke), np.arange(4)[:, None]
        state = random.uniform(0.1, 0.25, (4, stroke_sample_positions(problem, stroke).size)) / stroke.angle**orders
        away = random.normal(size=state.shape) / stroke.angle**orders
        sizes, aside = np.array([0.0, 60.0]), np.array([0.0, random.normal()])
        planes = sampled.tangent_planes(constraints, state, tuple(sizes))
        here = [c for c in constraints if c.kinds & stroke.kind]
        assert len(planes.values) == sum(1 + (c.goal == LARGEST_MAGNITUDE) for c in here)
        risen = np.einsum("kcn,kn->cn", planes.motion, away) + planes.height * aside[1]
        step, ends = 1e-4, []
        for k in (-step, step):
            moved = state + k * problem.motion_unit * away, tuple(sizes + k * problem.size_unit * aside)
            ends.append(sampled.ratios_to_bounds(constraints, *moved))
        slopes = (ends[1] - ends[0]) / (2 * step)
        np.testing.assert_allclose(risen, slopes, rtol=1e-5, atol=1e-5 * max(1.0, np.abs(slopes).max()))


@pytest.mark.slow
def test_a_pressure_angle_that_no_known_law_holds_smoothly():
    """The oscillating cam of the sources at 30°: every known law with a finite jerk is beyond it at any size."""
    scene = find_scene("oscillating-roller").replace(**{"limits.pressure_angle": 30, "synthesis.pieces": 12})
    found = optimise(scene.replace(**{"search.law": ["poly345", "poly4567", "cycloidal", "modified-sine"]}))
    assert found.best is None
    assert not any("not proved" in why for why in found.obstacles.values())
    row = sound(free(scene))
    assert row["pressure_angle_max_deg"] <= 30


def test_the_least_residual_vibration_is_the_effects_own():
    train = {"natural_frequency": 21.3, "damping_ratio": 0.02}
    scene = Scene.from_dict(ARM).replace(
        **{
            "cam.rpm": 600,
            "follower.dynamics": train,
            "synthesis.minimise": {"residual_vibration": 1.0, "jerk_rms": 1e-6},
            "outputs": ["sizes", "vibration"],
        }
    )
    result = free(scene)
    jerk = 1e-6 * derivative_root_mean_square(resolve(result.scene).programme, 3) * (600 * pi / 30) ** 3
    assert result.objective - jerk == pytest.approx(result.design["residual_vibration_max_deg"], rel=1e-9)


@pytest.mark.long
def test_a_tighter_residual_vibration_asks_for_hardly_more():
    """The steps start from known laws too, which have more of it."""
    train = {"natural_frequency": 120, "damping_ratio": 0.05}
    scene = find_scene("oscillating-roller").replace(**{"cam.rpm": 600, "limits.pressure_angle": 35})
    scene, sizes = scene.replace(**{"follower.dynamics": train, "synthesis.pieces": 16}), []
    for limit in (0.03, 1e-3, 1e-5) if is_deep() else (0.03, 1e-5):
        found = free(scene.replace(**{"limits.residual_vibration": limit}))
        assert sound(found)["residual_vibration_max_deg"] <= limit
        sizes.append(found.objective)
    assert sizes == pytest.approx([free(scene).objective] * len(sizes), rel=0.05)


@pytest.mark.slow
def test_points_are_in_degrees():
    scene = Scene.from_dict(ARM).replace(**{"synthesis.points": [[50, 6.5]], "synthesis.pieces": 12})
    programme = resolve(free(scene).scene).programme
    assert np.degrees(programme.motion_at(np.radians([50.0]))[0, 0]) == pytest.approx(6.5, abs=1e-4)


@pytest.mark.long
def test_a_frontier_of_local_optima_is_below_the_known_laws():
    scene = Scene.from_dict(ARM).replace(**{"synthesis.pieces": 8})
    found = frontier(scene, points=4, workers=1)
    assert found.local == ("size",)
    assert found.least["size"][0] <= synthesise(scene).objective * (1.0 + 1e-6)
    assert all(row["bound"] is None for row in found.rows)
    assert found.least["size"][1] is None
    assert found.least["acceleration"][1] <= found.least["acceleration"][0]
    sizes, rough = (np.array([row[axis] for row in found.rows]) for axis in found.axes)
    for known in (row for row in found.known if row["within"]):
        better = sizes[rough <= known["acceleration"]]
        assert better.size
        assert better.min() < known["size"]


@pytest.mark.slow
def test_a_contact_force_on_an_arm_is_a_moment_about_its_pivot():
    """At rest the preload of 5 N·m presses the roller at 110 mm with 45.45 N: no motion has more there."""
    dynamics = {"inertia": 1e-3, "spring_rate": 20.0, "preload": 5.0}
    pressed = Scene.from_dict(ARM).replace(**{"follower.dynamics": dynamics, "cam.rpm": 100})
    with pytest.raises(Unmet, match=r"no motion meets .* limits\.contact_force_min"):
        synthesise(pressed.replace(**{"limits.contact_force_min": 45.5}))
    held = synthesise(pressed.replace(**{"limits.contact_force_min": 45.4}))
    assert held.design["contact_force_min_N"] >= 45.4
    listed = {"limits.contact_force_min": 48, "search.arm_length": [100, 110]}
    assert synthesise(pressed.replace(**listed)).design["arm_length_mm"] == 100
    with pytest.raises(BadInput, match="free laws start from this length"):
        synthesise(pressed.replace(**listed, **{"follower.arm_length": None}))


@pytest.mark.slow
def test_the_arm_within_its_range_is_free_with_the_laws():
    """Laws for the scene's own arm of 75 mm need 21.26 mm on the best arm for them."""
    found = synthesise("face-groove-shutter")
    assert found.design["base_radius_mm"] < 19.71
    assert found.design["arm_length_mm"] > 78.0

"""Windows of feasibility: sizes between two opposing limits are found, or proved absent, wherever they lie."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import BadInput, Scene, evaluate, find_scene, optimise
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.space import search_boxes
from camopt.solve.smallest.cutting_planes import cutting_plane_optimum
from camopt.solve.smallest.grid_search import find_nearest_miss
from camopt.solve.smallest.infeasibility import round_size_up
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.verdicts.certify import certify_limits
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts, quantities_with_excess_bounds

STEEL = {"cam": "steel", "follower": "steel", "face_width": 10}
TURN = [
    {"segment": "rise", "angle": 120, "lift": 10, "law": "cycloidal"},
    {"segment": "dwell", "angle": 60},
    {"segment": "return", "angle": 120, "lift": 10, "law": "cycloidal"},
    {"segment": "dwell", "angle": 60},
]
BUCKET = {
    "cam": {"form": "disc", "rpm": 300, "base_radius": 47.35},
    "follower": {
        "motion": "translating",
        "contact": "flat",
        "dynamics": {"mass": 0.5, "spring_rate": 5, "preload": 100},
    },
    "motion": TURN,
    "materials": STEEL,
}


def bucket(limits, **changes):
    return Scene.from_dict({**BUCKET, "limits": limits}).replace(**changes)


def rows_at_sizes(problem, sizes):
    """The rows of a scene's design at other sizes of the cam."""
    designs = problem.design.take(np.zeros(len(sizes), dtype=int))
    return evaluate_with_verdicts(problem, replace(designs, size=np.asarray(sizes, dtype=float)), frozenset())


@pytest.mark.long
def test_a_window_that_no_coarse_grid_sees_is_found():
    """Proved absent before: 0.2 % of R wide, with no upper end of the size, where an empty grid was believed."""
    best = optimise(bucket({"contact_stress": 108.882980573962, "sliding_speed": 1.8032741831605414})).best
    assert best["proved"]
    assert best["base_radius_mm"] == pytest.approx(47.3, abs=1e-6)
    assert best["binding"] == ["contact_stress"]


FOLLOWERS = {
    "bucket": ({"motion": "translating", "contact": "flat"}, "contact_stress", "sliding_speed"),
    "knife": ({"motion": "translating", "contact": "knife"}, "pressure_angle", "sliding_speed"),
    "spherical": (
        {"motion": "translating", "contact": "spherical", "face_radius": 20, "offset": 3},
        "pressure_angle",
        "sliding_speed",
    ),
    "flat swing": (
        {"motion": "oscillating", "contact": "flat", "centre_distance": 90, "face_offset": 6},
        "curvature_radius",
        "sliding_speed",
    ),
}
QUANTITIES = {
    "contact_stress": "contact_stress_max_MPa",
    "sliding_speed": "sliding_speed_max_m_s",
    "pressure_angle": "pressure_angle_max_deg",
    "curvature_radius": "profile_radius_min_mm",
}


def window_of(name, radius, width, lift, there):
    """A scene whose limits hold between radius·(1 ∓ width/2) alone, or nowhere: the bounds then pass each other."""
    follower, falling, growing = FOLLOWERS[name]
    swings = follower["motion"] == "oscillating"
    motion = [{**s, **({"lift": lift} if "lift" in s else {})} for s in TURN]
    dynamics = {"inertia" if swings else "mass": 0.01 if swings else 0.5, "spring_rate": 20, "preload": 100}
    raw = {**BUCKET, "motion": motion, "follower": {**follower, "dynamics": dynamics}}
    ends = [
        evaluate(Scene.from_dict({**raw, "cam": {**BUCKET["cam"], "base_radius": end}, "outputs": ["all"]}))
        for end in (radius * (1 - width / 2), radius * (1 + width / 2))
    ]
    low, high = ends if there else ends[::-1]
    limits = {falling: low[QUANTITIES[falling]], growing: high[QUANTITIES[growing]]}
    if falling == "pressure_angle":
        limits["pressure_angle_return"] = limits[falling]
    assume(min(limits.values()) > 0.0)
    return Scene.from_dict({**raw, "limits": limits})


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", FOLLOWERS)
@given(
    place=st.floats(1.4, 1.9),
    narrowness=st.floats(1.0, 4.0),
    lift=st.floats(6.0, 14.0),
    there=st.booleans(),
)
@settings(max_examples=times(1, deep=60))
def test_windows_are_found_or_proved_absent(name, place, narrowness, lift, there):
    """A scan of sizes, dense around the window, is the referee."""
    radius, width = 10.0**place, 10.0**-narrowness
    scene = window_of(name, radius, width, lift, there)
    problem = with_rounding_relative_error(resolve(scene))
    (bounds,) = search_boxes(problem)
    answer = solve_smallest_cam(problem, bounds)
    near, far = np.linspace(1 - 2 * width, 1 + 2 * width, 1601) * radius, np.geomspace(1e-2, 1e4, 1200)
    sizes = np.unique(np.concatenate([near, far]))
    held = rows_at_sizes(problem, sizes).column("feasible")
    assert answer.is_proved
    assert answer.size <= np.min(sizes[held], initial=inf) * (1 + 1e-9)
    if answer.design is None:
        assert not rows_at_sizes(problem, answer.nearest.size).column("feasible")[0]
    else:
        assert rows_at_sizes(problem, answer.design.size).column("feasible")[0]


# Reasons


@pytest.mark.parametrize(
    ("limits", "ends", "reason"),
    [
        (
            {"curvature_radius": 60},
            (40, 59.9),
            "curvature_radius, for base_radius = 40 to 59.9 mm (the smallest feasible cam has 65.332 mm)",
        ),
        (
            {"contact_stress": 90},
            (10, 60),
            "contact_stress, for base_radius = 10 to 60 mm (the smallest feasible cam has 66.9106 mm)",
        ),
        (
            {"contact_stress": 90},
            (60, 60),
            "contact_stress, for base_radius = 60 mm (the smallest feasible cam has 66.9106 mm)",
        ),
        (
            {"sliding_speed": 1},
            (50, 60),
            "sliding_speed, for base_radius = 50 to 60 mm (the smallest feasible cam has 5.332 mm)",
        ),
        ({"curvature_radius": 60, "acceleration": 1}, (40, 59.9), "acceleration, curvature_radius"),
        ({"face_reach": 2, "acceleration": 1, "contact_stress": 90}, None, "acceleration, face_reach"),
        (
            {"contact_stress": 108.8, "sliding_speed": 1.79, "face_reach": 30},
            None,
            "contact_stress and sliding_speed together",
        ),
    ],
)
def test_obstacles_are_named(limits, ends, reason):
    """Each limit that stops all alone; else those that do together; and the range, where it is the range."""
    search = {} if ends is None else {"search.base_radius": {"start": ends[0], "stop": ends[1]}}
    found = optimise(bucket(limits, **search))
    assert found.obstacles == {"cycloidal": reason}
    assert found.nearest_miss["violated"]
    for name in limits:
        assert (name in reason) == limit_stops_all(name, limits, ends) or "together" in reason


def limit_stops_all(name, limits, ends):
    """Whether none of many sizes within the range holds this limit alone."""
    problem = resolve(bucket({name: limits[name]}))
    sizes = np.linspace(*ends, 2000) if ends else np.geomspace(1e-2, 1e6, 4000)
    return not rows_at_sizes(problem, sizes).column("feasible").any()


def test_a_cam_that_cannot_be_assembled_is_named():
    follower = {"motion": "translating", "contact": "knife", "offset": 20}
    scene = Scene.from_dict({**BUCKET, "follower": follower, "limits": {"pressure_angle": 30}})
    found = optimise(scene.replace(**{"search.base_radius": {"start": 5, "stop": 15}}))
    (reason,) = found.obstacles.values()
    assert reason.startswith("assembly: the offset has to be smaller than the prime radius, for base_radius = ")


def two_rollers(limits, radii, base):
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 5}
    scene = Scene.from_dict({**BUCKET, "follower": follower, "limits": limits})
    return scene.replace(search={"base_radius": base, "roller_radius": radii})


def test_a_reason_that_all_choices_share_is_told_once_with_the_smallest_cam():
    scene = two_rollers({"pressure_angle": 10}, [4, 8], {"start": 5, "stop": 7})
    (reason,) = optimise(scene).obstacles.values()
    least = {r: optimise(scene.replace(search={"roller_radius": [r]})).best["base_radius_mm"] for r in (4, 8)}
    assert least[8] < least[4]
    assert reason == (
        "pressure_angle, pressure_angle_return, for base_radius = 5 to 7 mm "
        f"(the smallest feasible cam has {round_size_up(least[8]):.6g} mm, with roller_radius = 8)"
    )


def test_reasons_that_differ_are_told_with_the_choices_that_they_are_of():
    """The larger roller needs 30.15 mm, of which the outer radius leaves 29.85; the smaller one more than 31 mm."""
    scene = two_rollers({"pressure_angle": 12, "outer_radius": 39.85}, [4, 10], {"start": 20, "stop": 31})
    (reason,) = optimise(scene).obstacles.values()
    assert reason == (
        "pressure_angle, pressure_angle_return, if roller_radius = 4; "
        "pressure_angle_return and outer_radius together, if roller_radius = 10"
    )


def test_a_cam_that_the_closed_form_puts_beyond_the_range_is_proved_without_a_search(monkeypatch):
    scene = two_rollers({"pressure_angle": 10}, [4], {"start": 5, "stop": 7})
    problem = resolve(scene)
    (bounds,) = search_boxes(problem)
    monkeypatch.setattr(
        "camopt.solve.smallest.branch_and_bound.BoxSearch.size_bound_by_bisection",
        lambda *_: pytest.fail("searched"),
    )
    answer = solve_smallest_cam(problem, bounds)
    assert answer.design is None
    assert answer.is_proved
    assert answer.nearest is not None


@given(st.floats(1e-6, 1e8))
def test_a_size_told_in_six_digits_is_no_smaller(size):
    told = float(f"{round_size_up(size):.6g}")
    assert size * (1 - 1e-8) <= told <= size * (1 + 1.01e-5)


# Time


def test_out_of_time_the_best_so_far_is_told_with_its_gap():
    scene = bucket({"contact_stress": 90})
    whole, cut = optimise(scene), optimise(scene, seconds=1e-9)
    assert (whole.out_of_time, cut.out_of_time) == (False, True)
    assert whole.best["proved"]
    assert not cut.best["proved"]
    assert cut.best["feasible"]
    assert 0.0 <= cut.best["base_radius_mm"] - whole.best["base_radius_mm"] <= cut.best["gap_mm"]


def test_what_a_budget_leaves_of_a_search_is_a_lower_bound():
    """However early it stops."""
    problem = with_rounding_relative_error(resolve(bucket({"contact_stress": 90})))
    (bounds,) = search_boxes(problem)
    least = solve_smallest_cam(problem, bounds).size
    for work in (0.0, 1e3, 1e4, 3e4):
        answer = solve_smallest_cam(problem, bounds, Budget(work))
        assert answer.floor <= least <= answer.size


def test_out_of_time_without_a_design_nothing_is_called_proved():
    found = optimise(bucket({"contact_stress": 108.8, "sliding_speed": 1.79}), seconds=1e-9)
    assert found.best is None
    assert found.out_of_time
    assert all(why.endswith("(not proved)") for why in found.obstacles.values())


def test_a_proof_stops_with_its_budget():
    scene = find_scene("roller-1000rpm")
    most = evaluate(scene.replace(limits=None))["pressure_angle_max_deg"]
    problem = with_rounding_relative_error(resolve(scene.replace(limits={"pressure_angle": most * (1.0 + 1e-9)})))
    whole, cut = (certify_limits(problem, problem.design, budget) for budget in (UNLIMITED, Budget(0.0)))
    assert (whole["pressure_angle"], cut["pressure_angle"]) == ("held", "undecided")


def test_the_nearest_miss_is_looked_for_within_the_budget():
    problem = with_rounding_relative_error(resolve(bucket({"contact_stress": 80, "sliding_speed": 1.5})))
    (bounds,) = search_boxes(problem)
    near, start = find_nearest_miss(problem, bounds, problem.design), problem.design
    assert find_nearest_miss(problem, bounds, start, Budget(0.0)) is start
    worst = [quantities_with_excess_bounds(problem, design, frozenset()).outer.max() for design in (near, start)]
    assert worst[0] < worst[1]


def test_cutting_planes_stop_early_with_a_size_that_no_cam_undercuts():
    scene = find_scene("oscillating-roller").replace(limits={"pressure_angle": 35}, search=None)
    problem = with_rounding_relative_error(resolve(scene))
    (bounds,) = search_boxes(problem)
    whole, cut = cutting_plane_optimum(problem, bounds), cutting_plane_optimum(problem, bounds, Budget(0.0))
    assert cut.design is None
    assert 0.9 * whole.floor < cut.floor < whole.floor


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), "ten"])
def test_time_is_a_number_above_zero(seconds):
    with pytest.raises(BadInput, match="seconds"):
        optimise(bucket({"contact_stress": 90}), seconds=seconds)

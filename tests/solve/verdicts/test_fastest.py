"""Highest speeds beside closed forms, certificates at their ends, and scans of all speeds and cam angles."""

import json
from functools import cache
from math import inf, isfinite, pi, radians, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.depth import is_deep, times
from support.loaded_scenes import GUIDED, MOVED, STEEL, SURFACE, turn

import camopt
from camopt import BadInput, Scene, certify, evaluate, fastest, find_scene, shipped_scenes
from camopt.cli.main import main
from camopt.model.effects import EFFECTS, EvaluationBlock, available_quantities
from camopt.scene.problem.problem import resolve_design
from camopt.solve.verdicts.effect_runs import run_effects

WITH_SPEED = [name for name in shipped_scenes() if find_scene(name).cam.rpm]
SIDES = (1 - 1e-9, 1 + 1e-9)
FASTEST_BY_SCENE = {
    "valve-with-rocker": (1648.4670826728675, "acceleration"),
    "press-ram-by-four-bar": (104.18214487759947, "acceleration"),
    "pusher-by-lever": (123.29035646983954, "acceleration"),
    "clamp-by-wedge": (271.568175866741, "contact_force_min"),
    "bottle-filler-by-rib": (145.258546159301, "pair_preload_ratio"),
    "press-feed-by-pair": (1982.5555824017638, "contact_stress"),
    "barrel-traverse": (489.4273266633444, "slip_speed"),
    "bucket-valve": (3580.9862195676446, "lash_speed"),
    "three-arc-valve": (inf, ""),
    "roller-1000rpm": (None, ""),
}


def loaded(limits, rpm=300, dynamics=MOVED, **more):
    """A roller cam with loads."""
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 15, "dynamics": dynamics}
    cam = {"form": "disc", "base_radius": 60, "rpm": rpm}
    surfaces = {"materials": {**STEEL, **SURFACE}}
    return Scene.from_dict(
        {"cam": cam, "follower": follower, "motion": turn(20), "limits": limits, **surfaces, **more}
    )


def at_speed(scene, rpm, **more):
    return scene.replace(**{"cam.rpm": rpm}, **more)


def scanned_least_force(speeds, load, mass, damping, rate, preload):
    """Least force over 120,000 cam angles at each speed [N]."""
    theta = np.linspace(0, 2 * pi, 120_001)
    y, y1, y2, _ = resolve_design(loaded({})).programme.motion_at(theta)
    rest = rate * y + preload + np.interp(np.degrees(theta), *np.transpose(load))
    omega = np.asarray(speeds) * pi / 30
    return np.array([np.min(mass * y2 * each**2 + damping * y1 * each + rest) for each in omega])


@cache
def shipped_fastest(name):
    return fastest(find_scene(name))


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [name for name in WITH_SPEED if is_deep() or name in FASTEST_BY_SCENE])
def test_each_limit_holds_just_below_its_speed_and_breaks_just_above(name):
    scene, result = find_scene(name), shipped_fastest(name)
    assert [limit.limit for limit in result.limits if limit.rpm is None] == [
        limit for limit, verdict in certify(scene).items() if verdict == "broken" and result.rpm is None
    ]
    for limit in result.limits:
        if limit.rpm is None or limit.rpm == inf:
            continue
        verdicts = [certify(at_speed(scene, limit.rpm * side))[limit.limit] for side in SIDES]
        assert verdicts == ["held", "broken"], limit.limit
        broken = [evaluate(at_speed(scene, limit.rpm * side))["violated"].split(",") for side in SIDES]
        assert [limit.limit in each for each in broken] == [False, True]


@pytest.mark.parametrize("name", FASTEST_BY_SCENE)
def test_the_highest_speeds_of_shipped_scenes(name):
    result, (rpm, limit) = shipped_fastest(name), FASTEST_BY_SCENE[name]
    assert result.deciding_limit == limit
    assert result.rpm is rpm if rpm is None else result.rpm == pytest.approx(rpm, rel=1e-10)
    assert result.exit_code == (1 if rpm is None else 4 if limit == "slip_speed" else 0)


def test_the_acceleration_of_a_cycloidal_rise_in_closed_form():
    """The largest acceleration is 2π·h·ω²/β², with the lift h and the angle β of the shorter stroke."""
    scene = loaded({"acceleration": 120}, motion=turn(20, (100, 60, 140, 60)))
    (limit,) = [each for each in fastest(scene).limits if each.limit == "acceleration"]
    rpm = sqrt(120e3 / (2 * pi * 20)) * radians(100) * 30 / pi
    assert limit.rpm == pytest.approx(rpm, rel=1e-12)
    assert limit.rpm_per_unit == pytest.approx(rpm / (2 * 120), rel=1e-8)
    assert limit.rpm_per_percent == pytest.approx(rpm / 200, rel=1e-8)


def test_velocity_and_jerk_follow_powers_of_the_speed():
    own = evaluate(loaded({"velocity": 9e9, "jerk": 9e9}))
    values = own["velocity_max_m_s"], own["jerk_max_m_s3"]
    result = fastest(loaded({"velocity": 2 * values[0], "jerk": 2 * values[1]}))
    speeds = {limit.limit: limit.rpm for limit in result.limits}
    assert speeds["velocity"] == pytest.approx(600, rel=1e-12)
    assert speeds["jerk"] == pytest.approx(300 * 2 ** (1 / 3), rel=1e-12)
    assert (result.deciding_limit, result.limits[1].limit) == ("jerk", "velocity")


def test_the_jump_speed_is_the_speed_at_which_the_contact_force_is_lost():
    """Beside a scan of the force over 1e5 cam angles at each speed of a bisection."""
    result = fastest(loaded({"contact_force_min": 0}))
    assert result.rpm == pytest.approx(evaluate(loaded({"jump_speed": 1}))["jump_speed_rpm"], rel=1e-9)
    low, high = 300.0, 3000.0
    while high - low > 1e-9 * high:
        middle = (low + high) / 2
        least = scanned_least_force([middle], [[0, 0], [360, 0]], 0.5e-3, 0.0, 5.0, 100.0)[0]
        low, high = (middle, high) if least > 0 else (low, middle)
    assert result.rpm == pytest.approx(low, rel=1e-8)
    assert result.limits[0].rpm_per_percent is None


@pytest.mark.slow
def test_a_limit_that_is_broken_only_within_a_narrow_range_of_speeds():
    """A load pulls near the end of the return, where the damper's pull rises faster than the inertia at first."""
    load = [[270, 0], [276, -100], [282, 0]]
    dynamics = {"mass": 0.5, "spring_rate": 5, "preload": 100, "damping": 0.05, "load": load}
    numbers = load, 0.5e-3, 0.05, 5.0, 100.0
    speeds = np.linspace(60, 300, 481)
    least = scanned_least_force(speeds, *numbers)
    dip = int(np.argmin(least))
    bound = float(least[dip]) + 0.002
    window = speeds[least < bound]
    start = float(speeds[dip]) / 2**0.375  # the first speeds tried are 1/8 of an octave beside the dip
    assert start * 2**0.25 < window[0] <= window[-1] < min(start * 2**0.5, speeds[-1])
    (limit, *_) = fastest(loaded({"contact_force_min": bound}, rpm=start, dynamics=dynamics)).limits
    finer = np.linspace(window[0] - 2, speeds[dip], 2001)
    first = finer[np.argmax(scanned_least_force(finer, *numbers) < bound)]
    assert limit.rpm == pytest.approx(first, rel=1e-4)
    assert limit.proof == "proved"


LOADS = ("normal_force", "side_thrust", "guide_reaction", "contact_stress", "torque", "power")


@pytest.mark.slow
@settings(deadline=None, max_examples=times(4, 100))
@given(
    st.sampled_from(LOADS),
    st.floats(1.001, 6.0),
    st.sampled_from([0.0, 0.1, 0.4]),
    st.floats(0.0, 0.15),
    st.integers(0, 1000),
)
def test_any_load_holds_below_its_speed_and_breaks_just_above(name, share, damping, friction, seed):
    dynamics = {**GUIDED, "damping": damping, "friction": friction}
    own = evaluate(loaded({name: 1e9}, dynamics=dynamics))
    (quantity,) = {each for each in own if each.startswith(name) and each.endswith(("_N", "_MPa", "_m", "_W"))} & {
        f"{name}_max_N",
        f"{name}_max_MPa",
        f"{name}_peak_N_m",
        f"{name}_peak_W",
    }
    assume(isfinite(own[quantity]))
    scene = loaded({name: share * own[quantity]}, dynamics=dynamics)
    (limit,) = [each for each in fastest(scene).limits if each.limit == name]
    assert limit.proof == "proved"
    speeds = np.random.default_rng(seed).uniform(300, limit.rpm, 5)
    values = [evaluate(at_speed(scene, each))[quantity] for each in (*speeds, limit.rpm * (1 - 1e-8))]
    assert max(values) <= limit.bound < evaluate(at_speed(scene, limit.rpm * (1 + 1e-8)))[quantity]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["contact_stress", "contact_force_min", "normal_force"])
def test_the_gain_is_the_slope_between_two_bounds(name):
    bound = {"contact_stress": 600, "contact_force_min": 20, "normal_force": 900}[name]
    steps = [bound * (1 + share) for share in (-1e-4, 1e-4)]
    below, above = (fastest(loaded({name: each})).rpm for each in steps)
    limit = fastest(loaded({name: bound})).limits[0]
    assert limit.rpm_per_unit == pytest.approx((above - below) / (steps[1] - steps[0]), rel=1e-6)
    assert limit.rpm_per_percent == pytest.approx(limit.rpm_per_unit * bound / 100, rel=1e-12)


def test_a_scene_that_is_too_fast_already_has_a_highest_speed_from_rest():
    slow, fast = (fastest(loaded({"acceleration": 120}, rpm=rpm)) for rpm in (300, 900))
    assert fast.rpm == pytest.approx(slow.rpm, rel=1e-12)
    assert (slow.from_rpm, fast.from_rpm, fast.exit_code) == (300, 1e-9, 0)
    assert [limit.limit for limit in fast.limits if not limit.is_held_at_scene_speed] == ["acceleration"]
    assert "Broken at 900 rev/min: acceleration." in fast.answer
    assert "from rest to 618.039 rev/min" in fast.answer


@pytest.mark.slow
def test_limits_that_no_speed_holds_together_are_shown_each_for_itself():
    """The film needs a high speed, and the acceleration a low one."""
    film = evaluate(loaded({"film_ratio": 1e-6}))["film_ratio_min"]
    result = fastest(loaded({"film_ratio": 1.5 * film, "acceleration": 20}))
    assert (result.rpm, result.from_rpm, result.deciding_limit, result.exit_code) == (None, None, "", 1)
    assert "No speed was found that holds all limits. Broken at 300 rev/min:" in result.answer
    assert {limit.limit for limit in result.limits if limit.rpm not in (None, inf)} >= {"acceleration"}
    assert result.to_dict()["rpm"] is None


def test_a_limit_without_speed_that_is_broken_leaves_no_speed():
    result = fastest(find_scene("roller-1000rpm"))
    assert (result.limits[0].limit, result.limits[0].rpm, result.limits[0].proof) == (
        "pressure_angle",
        None,
        "proved",
    )


def test_a_limit_that_no_speed_breaks_is_proved_to_the_highest_speed_tried():
    """A follower of 1e-12 kg has no inertia."""
    result = fastest(loaded({"normal_force": 1000}, dynamics={**MOVED, "mass": 1e-12}))
    (limit,) = [each for each in result.limits if each.limit == "normal_force"]
    assert (limit.rpm, limit.proof, result.exit_code) == (inf, "proved to 307200 rev/min", 0)


def test_a_robust_scene_holds_its_limits_for_every_cam_within_the_tolerances():
    robust = {"tolerances": {"cam": {"rpm": 10}}, "search": {"robust": True}}
    limits = {"acceleration": 120, "contact_force_min": 5}
    nominal, worst = fastest(loaded(limits)), fastest(loaded(limits, **robust))
    for name in limits:
        first, second = (
            next(limit.rpm for limit in each.limits if limit.limit == name) for each in (nominal, worst)
        )
        assert second == pytest.approx(first - 10, rel=1e-9)
    wide = {
        "tolerances": {"follower": {"dynamics": {"preload": 3, "spring_rate": 0.2}}},
        "search": {"robust": True},
    }
    scene = loaded({"contact_force_min": 5}, **wide)
    (limit, *_) = fastest(scene).limits
    assert limit.proof == "proved"
    weakest = loaded({"contact_force_min": 5}, dynamics={**MOVED, "spring_rate": 4.8, "preload": 97})
    assert limit.rpm == pytest.approx(fastest(weakest).rpm, rel=1e-9)
    assert [certify(at_speed(scene, limit.rpm * side))["contact_force_min"] for side in SIDES] == ["held", "broken"]


@pytest.mark.long
def test_a_train_within_tolerances():
    scene = find_scene("clamp-by-wedge").replace(**{"search.robust": True, "tolerances.train.1.angle": 0.2})
    nominal = {limit.limit: limit.rpm for limit in fastest(find_scene("clamp-by-wedge")).limits}
    result = fastest(scene)
    assert result.exit_code == 0
    for limit in result.limits:
        assert limit.rpm <= nominal[limit.limit]
        if isfinite(limit.rpm):
            verdicts = [certify(at_speed(scene, limit.rpm * side))[limit.limit] for side in SIDES]
            assert verdicts == ["held", "broken"]


@pytest.mark.parametrize("name", WITH_SPEED)
def test_quantities_that_need_no_speed_do_not_depend_on_it(name):
    problem = resolve_design(find_scene(name))
    free = {*available_quantities(problem.setup.with_numbers({"cam.rpm": None}))} & problem.evaluated_quantities
    faster = problem.with_numbers({"cam.rpm": 3.7 * find_scene(name).cam.rpm})
    columns = [
        run_effects(EvaluationBlock(each.setup, each.programme, each.design), free).columns
        for each in (problem, faster)
    ]
    assert columns[0].keys() == columns[1].keys()
    for quantity, value in columns[0].items():
        assert np.array_equal(value, columns[1][quantity]), quantity


@pytest.mark.parametrize("name", ["clamp-by-wedge", "pusher-by-lever", "slide-by-bell-crank", "bucket-valve"])
def test_effects_that_hold_between_speeds_have_no_peak_between(name):
    scene = find_scene(name).replace(outputs=["joints" if find_scene(name).train else "lash"])
    problem = resolve_design(scene)
    marked = {effect.name for effect in EFFECTS.values() if effect.holds_between_speeds}
    assert marked == {"joints", "lash", "motion_errors"}
    names = [each for each in problem.evaluated_quantities if each.endswith("_max_N") or "_speed_max_" in each]
    speeds = scene.cam.rpm * np.geomspace(0.1, 10, 41)
    free = problem.with_keys_per_design(["cam.rpm"])
    designs = free.design.take(np.zeros(speeds.size, dtype=int)).with_values({"cam.rpm": speeds})
    columns = run_effects(EvaluationBlock(free.setup, free.programme, designs), names).columns
    for values in map(np.asarray, columns.values()):
        peaks = np.minimum(np.maximum.accumulate(values), np.maximum.accumulate(values[::-1])[::-1])
        assert np.all(values <= peaks * (1 + 1e-12))


@pytest.mark.slow
def test_motion_errors_are_powers_of_the_speed():
    tolerances = {"profile": 0.01, "waves": 20, "follower": {"roller_radius": 0.02}}
    limits = {"acceleration_error": 1.0, "velocity_error": 0.05}
    scene = loaded(limits, rpm=100, tolerances=tolerances)
    own, result = evaluate(scene), fastest(scene)
    for name, quantity, power in (
        ("acceleration_error", "acceleration_error_max_m_s2", 2),
        ("velocity_error", "velocity_error_max_m_s", 1),
    ):
        (limit,) = [each for each in result.limits if each.limit == name]
        assert limit.rpm == pytest.approx(100 * (limits[name] / own[quantity]) ** (1 / power), rel=1e-12)
        assert limit.proof == "proved"
        verdicts = [certify(at_speed(scene, limit.rpm * side))[name] for side in SIDES]
        assert verdicts == ["held", "broken"]


@pytest.mark.slow
def test_guide_friction_leaves_the_normal_force_convex_in_the_square_of_the_speed():
    scene = loaded({"normal_force": 1e9}, dynamics=GUIDED)
    squares = np.linspace(1e4, 4e6, 60)
    values = [evaluate(at_speed(scene, sqrt(each)))["normal_force_max_N"] for each in squares]
    assert np.min(np.diff(values, 2)) > -1e-9 * max(values)


def test_the_speed_of_a_crank_is_shown_as_the_scene_gives_it():
    given_cam = loaded({"acceleration": 120})
    by_crank = given_cam.replace(**{"cam.rpm": None, "cam.rpm_of_crank": 600})
    results = fastest(given_cam), fastest(by_crank)
    assert results[0].rpm == results[1].rpm
    assert "to 1236.08 rev/min of the crankshaft" in results[1].answer
    assert results[1].to_dict()["rpm_of_crank"] == 2 * results[1].rpm
    cells = [next(row for row in each.table().rows if row[0].text == "acceleration") for each in results]
    assert [row[2].text for row in cells] == ["618.039", "1236.08"]


def test_cams_on_one_shaft_share_the_smallest_speed():
    """A cam that turns twice as fast as the shaft has half of its speed at the shaft."""
    first, second = fastest(loaded({"acceleration": 120})), fastest(loaded({"acceleration": 120}, rpm=600))
    assert min(first.rpm / 1, second.rpm / 2) == pytest.approx(first.rpm / 2)


def test_a_scene_without_a_speed_is_refused():
    with pytest.raises(BadInput, match=r"cam\.rpm: missing; .*cam\.rpm_of_crank"):
        fastest(find_scene("exhaust-valve"))


def test_velocities_per_second_keep_the_motion_and_say_so():
    (note,) = fastest(find_scene("belt-matching")).notes
    assert note.startswith("motion.2.per, motion.4.per = 's': the cam keeps its motion")
    assert fastest(find_scene("clamp-by-wedge")).notes == ()


@pytest.mark.slow
def test_the_command_prints_the_table_or_json(capsys):
    assert main(["evaluate", "barrel-traverse", "--fastest"]) == 4
    out = capsys.readouterr().out
    assert "Above this speed slip_speed is" in out
    assert "not proved between" in out
    assert main(["evaluate", "valve-with-rocker", "--fastest", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["limits"][0]["limit"] == document["deciding_limit"] == "acceleration"
    assert document["limits"][1] | {"unbounded": ["rpm"]} == document["limits"][1]
    frame = fastest(find_scene("valve-with-rocker")).to_pandas()
    assert frame["limit"][0] == "acceleration"
    assert frame["rpm"].iloc[1:].eq(inf).all()
    assert camopt.Fastest.__doc__

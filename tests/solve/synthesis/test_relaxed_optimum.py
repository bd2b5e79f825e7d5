"""Free laws come near to the optimum of all motions: closed forms, shipped scenes, and knots."""

from itertools import pairwise
from math import exp, radians, tan
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq
from support.convex_scenes import random_convex_scene

from camopt import certify, find_scene
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.relaxed_optimum import relaxed_optimum_with_jerk_cuts
from camopt.solve.synthesis.synthesise import SMALL_GAP, synthesise

CONVEX = (
    "roller-1000rpm",
    "feeder-with-stop",
    "press-with-drift",
    *(
        pytest.param(name, marks=pytest.mark.long)
        for name in (
            "belt-matching",
            "bottle-filler-by-rib",
            "bucket-valve",
            "indexing-overlap",
        )
    ),
)
MOST_NUMBERS = 40  # of a law in the scene that is written


def advance(state, jerk, angle):
    """y, y', y'' after an angle of constant jerk."""
    y, v, a = state
    return (
        y + v * angle + a * angle**2 / 2 + jerk * angle**3 / 6,
        v + a * angle + jerk * angle**2 / 2,
        a + jerk * angle,
    )


def optimal_rise(steady, slope, acceleration, jerk, lift):
    """The angle of the fastest rise within y' ≤ slope·(c + y) that holds its acceleration over ``steady``, and c.

    Its jerk is +j, 0, −j until the motion is tangent to the limit; it follows the limit as an exponential; then the
    jerk is −j, 0, +j.
    """
    ramp = acceleration / jerk
    state = advance(advance((0.0, 0.0, 0.0), jerk, ramp), 0.0, steady)
    easing = brentq(lambda angle: (lambda y, v, a: a - slope * v)(*advance(state, -jerk, angle)), 0.0, 2 * ramp)
    y, v, _ = advance(state, -jerk, easing)
    c = v / slope - y

    def stop_after(arc):
        height = (c + y) * exp(slope * arc)
        state = (height - c, slope * height, slope**2 * height)
        fall = (state[2] + acceleration) / jerk
        state = advance(state, -jerk, fall)
        braking = (state[1] - acceleration**2 / (2 * jerk)) / acceleration
        state = advance(advance(state, 0.0, braking), jerk, ramp)
        return state[0] - lift, fall + braking + ramp

    arc = brentq(lambda angle: stop_after(angle)[0], 0.0, 3.0 / slope)
    return ramp + steady + easing + arc + stop_after(arc)[1], c


def optimal_radius(angle, slope, acceleration, jerk, lift):
    """Least prime radius of a radial roller cam for a rise over an angle; peaks of the unit stroke."""
    limits = slope, acceleration * lift / angle**2, jerk * lift / angle**3, lift

    def angle_left(steady):
        try:
            return optimal_rise(steady, *limits)[0] - angle
        except ValueError:  # no such motion
            return None

    steadies = [steady for steady in np.linspace(0.0, angle, 400) if angle_left(steady) is not None]
    brackets = [pair for pair in pairwise(steadies) if angle_left(pair[0]) * angle_left(pair[1]) <= 0.0]
    return optimal_rise(brentq(angle_left, *brackets[0]), *limits)[1]


def radial_cam(rise, fall, lift, pressure_angle, acceleration, jerk):
    strokes = [(f"{kind}", angle) for kind, angle in (("rise", rise), ("return", fall))]
    dwells = [{"segment": "dwell", "angle": each} for each in (30, 330 - rise - fall)]
    motion = [
        item
        for (kind, angle), dwell in zip(strokes, dwells, strict=True)
        for item in ({"segment": kind, "angle": angle, "lift": lift, "law": "poly345"}, dwell)
    ]
    return find_scene("roller-1000rpm").replace(
        motion=motion,
        **{
            "follower.offset": 0,
            "search": None,
            "limits": {"pressure_angle": pressure_angle},
            "synthesis": {"peak_acceleration": acceleration, "peak_jerk": jerk},
        },
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 12))])
def test_bound_and_cam_enclose_the_optimum_in_closed_form(seed):
    random = np.random.default_rng(seed)
    rise, fall = random.integers(90, 140, 2).tolist()
    lift, pressure_angle = random.uniform(20, 60), random.uniform(24, 36)
    acceleration, jerk = random.uniform(5.6, 8.0), random.uniform(60, 110)
    scene = radial_cam(rise, fall, lift, pressure_angle, acceleration, jerk)
    result = synthesise(scene)
    slope, roller = tan(radians(pressure_angle)), scene.follower.roller_radius
    exact = max(optimal_radius(radians(angle), slope, acceleration, jerk, lift) for angle in (rise, fall)) - roller
    assert result.bound <= exact <= result.objective <= exact + 5e-4 * (exact + roller)
    assert {*certify(result.scene).values()} == {"held"}  # though it lies on the pressure angle over an arc


@pytest.mark.slow
def test_without_limits_on_the_acceleration_the_profile_tends_to_a_spiral():
    angle, slope, lift = radians(120), tan(radians(30)), 40.0
    spiral = lift / (exp(slope * angle) - 1.0)  # the pressure angle is 30° everywhere
    excess = [optimal_radius(angle, slope, 20 * k, 800 * k * k, lift) - spiral for k in (1, 2, 4, 8)]
    assert all(0.0 < less < 0.6 * more for more, less in pairwise(excess))
    scene = radial_cam(120, 120, lift, 30, 40, 3200)
    least = synthesise(scene).objective + scene.follower.roller_radius
    assert excess[1] < least - spiral < excess[1] + 0.01 * (spiral + lift)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CONVEX)
def test_convex_scenes_come_near_to_their_bound_with_few_numbers(name):
    result = synthesise(find_scene(name))
    assert result.convex
    unit = max(stroke.high for stroke in resolve(result.scene).programme.strokes)
    assert 0.0 <= result.objective - result.bound <= SMALL_GAP * (result.objective + unit)
    for law in result.scene.to_dict()["laws"].values():
        assert len(law.get("coefficients") or law["positions"]) <= MOST_NUMBERS


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [2, 6, 19, 24, *(pytest.param(each, marks=pytest.mark.long) for each in (0, 13, 17, 23, 31, 41))]
)
def test_random_convex_scenes_come_near_to_their_bound_and_hold_every_limit(seed):
    result = synthesise(random_convex_scene(seed))
    prime = result.objective + build_synthesis_problem(result.scene).prime_less_cam_radius
    assert 0.0 <= result.objective - result.bound <= SMALL_GAP * prime
    assert {*certify(result.scene).values()} == {"held"}
    for law in result.scene.to_dict()["laws"].values():
        assert len(law.get("coefficients") or law["positions"]) <= MOST_NUMBERS


@pytest.mark.parametrize("seed", range(5))
def test_jumps_of_the_jerk_are_found_between_nodes(seed):
    random = np.random.default_rng(seed)
    nodes = np.linspace(0.0, 1.0, random.integers(150, 400))
    places = (np.arange(1, 6) + random.uniform(-0.3, 0.3, 5)) / 6
    levels = random.permutation([-60.0, 0.0, 60.0, 2.0, -60.0, 25.0])
    at_places = np.concatenate([nodes, places])
    order = np.argsort(at_places)
    steps = levels[np.searchsorted(places, (at_places[order][1:] + at_places[order][:-1]) / 2)]
    integral = np.concatenate([[0.0], np.cumsum(steps * np.diff(at_places[order]))])
    acceleration = integral[np.isin(order, np.arange(nodes.size))]
    motion = SimpleNamespace(a=SimpleNamespace(value=acceleration), h=np.diff(nodes), x=nodes)
    jumps = np.abs(np.diff(levels)) > 0.25 * np.abs(levels).max()
    assert RelaxedMotion.jerk_jumps(motion) == pytest.approx(places[jumps], abs=1e-9)


@pytest.mark.parametrize("changes", [{"pieces": 48}, {"continuity": 4}, {"smooth": 0.01}])
def test_pieces_continuity_and_a_smooth_jerk_are_as_the_scene_says(changes):
    scene = find_scene("roller-1000rpm").replace(**{f"synthesis.{key}": value for key, value in changes.items()})
    assert not relaxed_optimum_with_jerk_cuts(scene, build_synthesis_problem(scene)).cut_problems

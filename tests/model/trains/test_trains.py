"""The kinematics of trains: against loops closed by root finding at 50 digits, and printed examples."""

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from support.trains import LOOPS, exact, random_train

from camopt.core.numerics.taylor import Taylor
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.four_bar import assemble_four_bar
from camopt.model.trains.link import AssemblyFault
from camopt.model.trains.train import StageFault, assemble_train


@pytest.mark.one_in(15)
@pytest.mark.parametrize("seed", range(200))
def test_trains_are_those_of_closed_loops(seed):
    rng = np.random.default_rng(seed)
    stages, train, angular = random_train(rng)
    low, high = (float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends)
    tool = low + (high - low) * rng.uniform(0.15, 0.85)
    follower = float(train.follower_displacement(Taylor([tool])).terms[0])
    with mpmath.workdps(50):
        terms = mpmath.taylor(lambda x: exact(stages, angular, x), mpf(follower), 3)
    found = train.tool_displacement(Taylor([follower, 1.0, 0.0, 0.0]))
    back = train.follower_displacement(Taylor([float(each) for each in terms]))
    scale = max(map(abs, terms))
    assert [float(abs(a - b) / scale) for a, b in zip(found.terms, terms, strict=True)] == pytest.approx(
        [0.0] * 4, abs=1e-11
    )
    assert found.terms[0] == pytest.approx(tool, abs=1e-11 * max(abs(tool), 1.0))
    curl = max(1.0, *(float(abs(each / terms[1])) for each in terms)) ** 3
    assert back.terms == pytest.approx((follower, 1.0, 0.0, 0.0), abs=1e-12 * curl * max(1.0, abs(follower)))


@pytest.mark.parametrize("seed", range(40))
def test_up_to_its_dead_points_a_train_goes_one_way(seed):
    """At its dead points the tool stands still, or its follower does."""
    _, train, _ = random_train(np.random.default_rng(1000 + seed))
    low, high = (float(np.clip(end.at, -1e3, 1e3)) for end in train.tool_travel_ends)
    near = 1e-6 * (high - low)
    tool = np.linspace(low + near, high - near, 400)
    slope = train.follower_displacement(Taylor([tool, 0.0 * tool + 1.0])).terms[1]
    assert np.isfinite(slope).all()
    assert (slope > 0.0).all() or (slope < 0.0).all()
    middle = np.median(np.abs(slope))
    for end, there in zip(train.tool_travel_ends, (slope[0], slope[-1]), strict=True):
        turned = "half a turn" in end.why or not np.isfinite(end.at)
        assert turned or not 1e-2 < abs(there) / middle < 1e2


def test_a_four_bar_of_norton():
    """Norton, Design of Machinery, example 4-1: links of 100, 40, 120 and 80 mm, the crank at 40 deg."""
    found = [
        assemble_four_bar(40.0, 120.0, 80.0, 100.0, 40.0, crossed=crossed).rocker_start for crossed in (False, True)
    ]
    assert np.degrees(found) == pytest.approx([57.33, -98.01 + 360.0], abs=0.006)


def nearest_angles(start, places):
    """The nearest of some angles below and above a start, rad; at most half a turn away."""
    above = min((each - start) % (2 * np.pi) for each in places)
    below = max((each - start) % (2 * np.pi) - 2 * np.pi for each in places)
    return max(below, -np.pi), min(above, np.pi)


def test_a_parallelogram_stops_where_it_is_flat():
    """Of random sizes: rounding opened every eighth, whose crank then went through the dead point."""
    rng = np.random.default_rng(57)
    for _ in range(300):
        (crank, coupler), angle = rng.uniform(20.0, 120.0, 2).tolist(), float(rng.uniform(5.0, 175.0))
        link = assemble_four_bar(crank, coupler, crank, coupler, angle, crossed=False)
        assert [end.at for end in link.dead_points] == pytest.approx(
            nearest_angles(link.start, [0.0, np.pi]), abs=1e-6
        )


def test_a_slider_crank_stops_where_its_coupler_just_gets_square():
    """Sizes of one decimal with crank = coupler ± offset, which rounding kept off it one time in forty."""
    rng, seen = np.random.default_rng(57), 0
    for _ in range(300):
        crank, coupler = rng.integers(200, 900, 2).tolist()
        offset, angle = (crank - coupler) / 10.0, float(rng.uniform(5.0, 85.0))
        try:
            train = assemble_train(
                [
                    (
                        "slider-crank",
                        {"crank": crank / 10, "coupler": coupler / 10, "offset": offset, "angle": angle},
                    )
                ],
                angular=True,
            )
        except StageFault:
            continue
        seen += 1
        link = train.links[0]
        assert link.dead_points[1].at <= nearest_angles(link.start, [np.pi / 2])[1] + 1e-6  # type: ignore[attr-defined]
    assert seen > 100


def test_a_slider_crank_of_norton():
    """Norton, Design of Machinery, example 4-2: crank 40, coupler 120, offset −20 mm, the crank at 60 deg."""
    train = assemble_train(
        [("slider-crank", {"crank": 40.0, "coupler": 120.0, "offset": -20.0, "angle": 60.0})], angular=True
    )
    assert train.links[0].place == pytest.approx(126.84, abs=0.005)  # type: ignore[attr-defined]


def test_a_slider_crank_is_driven_from_either_end():
    keys = {"crank": 40.0, "coupler": 120.0, "offset": 10.0, "angle": 60.0}
    forth, back = (assemble_train([("slider-crank", keys)], angular=angular) for angular in (True, False))
    turned = np.linspace(-0.4, 0.4, 9)
    slide = forth.tool_displacement(Taylor([turned, 1.0, 0.0, 0.0]))
    assert back.tool_displacement(slide).terms[0] == pytest.approx(turned, abs=1e-14)


def test_the_ratio_of_a_rocker_is_that_of_its_arms_at_the_start():
    keys = {"input_arm": 25.0, "input_angle": -10.0, "output_arm": 40.0, "output_angle": -15.0}
    slope = assemble_train([("rocker", keys)], angular=False).tool_displacement(Taylor([0.0, 1.0])).terms[1]
    assert slope == pytest.approx(40.0 * np.cos(np.radians(15.0)) / (25.0 * np.cos(np.radians(10.0))), rel=1e-15)


WRONG = {
    "a length for a four-bar": (
        [("four-bar", {"crank": 30, "coupler": 90, "rocker": 60, "ground": 80, "angle": 50})],
        False,
    ),
    "an angle for a wedge": ([("incline", {"angle": 30})], True),
    "a ratio of nothing": ([("ratio", {})], False),
    "a ratio of 0": ([("ratio", {"ratio": 0.0})], False),
    "both a ratio and a radius": ([("ratio", {"ratio": 2.0, "radius": 3.0})], False),
    "a key missing": ([("slider-crank", {"crank": 30, "angle": 60})], True),
    "a key of another": ([("slider-crank", {"crank": 30, "coupler": 90, "angle": 60, "ground": 3})], True),
    "a coupler too short": ([("slider-crank", {"crank": 60, "coupler": 30, "angle": 60})], True),
    "links that do not meet": (
        [("four-bar", {"crank": 30, "coupler": 20, "rocker": 20, "ground": 90, "angle": 50})],
        True,
    ),
    "a start at a dead point": ([("slider-crank", {"crank": 30, "coupler": 90, "angle": 0})], True),
    "an arm along the motion": ([("rocker", {"output_arm": 30, "output_angle": 90})], True),
    "no arm for a length": ([("rocker", {"output_arm": 30})], False),
    "an arm for an angle": ([("rocker", {"output_arm": 30, "input_arm": 20})], True),
    "a wedge along its guide": ([("incline", {"angle": 80, "guide": 120})], False),
}


@pytest.mark.parametrize(("stages", "angular"), WRONG.values(), ids=WRONG)
def test_what_cannot_be_put_together_is_told(stages, angular):
    with pytest.raises(StageFault) as told:
        assemble_train([("ratio", {"ratio": 1.0}), *stages], angular=angular)
    assert isinstance(told.value, AssemblyFault)
    assert told.value.number == 2
    assert "\n" not in str(told.value)


def test_each_stage_has_a_loop():
    assert TRAIN_STAGES.keys() == LOOPS.keys()

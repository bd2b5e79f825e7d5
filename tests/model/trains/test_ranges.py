"""Links made from ranges with slopes enclose every linkage of a box; made from arrays they are many linkages."""

import numpy as np
import pytest
from support.depth import times
from support.trains import random_train

from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import (
    LinkageInterval,
    SlopedInterval,
    box_variables,
    range_of,
    value_at_box_point,
)
from camopt.core.numerics.taylor import Taylor
from camopt.model.trains.train import StageFault, Train, assemble_train, assemble_train_with_arrays

SAMPLES = 40


def numbers_of(stages):
    """The place of each number of some stages: (stage, key)."""
    return [(n, key) for n, (_, keys) in enumerate(stages) for key, each in keys.items() if type(each) is float]


def with_numbers(stages, places, values):
    changed = [(name, dict(keys)) for name, keys in stages]
    for (number, key), value in zip(places, values, strict=True):
        changed[number][1][key] = value
    return changed


def drawn_box(rng, stages, count):
    """Up to three numbers of some stages, the ends of ranges around them, and numbers within (free, count)."""
    places = numbers_of(stages)
    chosen = [places[k] for k in rng.permutation(len(places))[:3]]
    own = np.array([stages[n][1][key] for n, key in chosen])
    width = np.abs(own) * 10.0 ** rng.uniform(-7.0, -0.7, own.size) + 1e-9
    low = own - rng.uniform(size=own.size) * width
    high = low + width
    inside = low[:, None] + rng.uniform(size=(own.size, count)) * (high - low)[:, None]
    return chosen, low, high, inside


def motion_ranges(stages, angular, chosen, low, high, tool):
    """The follower's motion over a box as ranges, and the radicands."""
    radicands = []
    box = [Interval(np.array([a]), np.array([b])) for a, b in zip(low, high, strict=True)]
    middle = [np.array([(a + b) / 2.0]) for a, b in zip(low, high, strict=True)]
    ranges = [LinkageInterval.from_sloped_interval(each, radicands) for each in box_variables(box, middle)]
    train = assemble_train_with_arrays(with_numbers(stages, chosen, ranges), angular=angular)
    with np.errstate(all="ignore"):
        return train, train.follower_displacement(Taylor(tool)), radicands


@pytest.mark.one_in(30)
@pytest.mark.parametrize("seed", range(times(75, deep=3000)))
def test_no_linkage_of_a_box_is_outside_of_its_enclosure(seed):
    """Motion of the follower up to the jerk, velocity ratios of joints, least transmission angles, and roots."""
    rng = np.random.default_rng(seed)
    stages, train, angular = random_train(rng)
    chosen, low, high, inside = drawn_box(rng, stages, SAMPLES)
    ends = [float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends]
    tool = [ends[0] + (ends[1] - ends[0]) * rng.uniform(0.1, 0.9), 1.0, 0.3, -0.2]
    trains, follower, radicands = motion_ranges(stages, angular, chosen, low, high, tool)
    with np.errstate(all="ignore"):
        ratios = [joint.ratio for joint in trains.joint_motions(follower)]
        travel = sorted((tool[0], ends[0] + (ends[1] - ends[0]) * rng.uniform(0.1, 0.9)))
        angle = range_of(trains.least_transmission_angle_over_travel(*travel)) if trains.has_couplers else None
    seen = 0
    for values in inside.T:
        try:
            one = assemble_train(with_numbers(stages, chosen, values.tolist()), angular=angular)
        except StageFault:
            continue
        if not one.tool_travel_ends[0].at < tool[0] < one.tool_travel_ends[1].at:
            continue
        seen += 1
        assert not any((each.value.high < 0.0).any() for each in radicands)
        moved = one.follower_displacement(Taylor(tool))
        for part, whole in zip(moved.terms, follower.terms, strict=True):
            assert range_of(whole).low <= part <= range_of(whole).high
        for joint, whole in zip(one.joint_motions(moved), ratios, strict=True):
            for part, over in zip(joint.ratio.terms, whole.terms, strict=True):
                assert range_of(over).low <= part <= range_of(over).high
        if angle is not None and one.tool_travel_ends[0].at < travel[0] <= travel[1] < one.tool_travel_ends[1].at:
            assert angle.low <= one.least_transmission_angle_over_travel(*travel) <= angle.high
    assert seen > 0 or np.max((high - low) / np.abs(low)) > 1e-3


@pytest.mark.parametrize("seed", range(times(20, deep=400)))
def test_enclosures_are_close_over_narrow_boxes(seed):
    """The excess width of an enclosure falls with the square of the box's width."""
    rng = np.random.default_rng(5000 + seed)
    stages, train, angular = random_train(rng)
    (number, key), *_ = (numbers_of(stages)[k] for k in rng.permutation(len(numbers_of(stages))))
    own = stages[number][1][key]
    low, high = np.sort([own * (1.0 - 1e-6), own * (1.0 + 1e-6)])
    ends = [float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends]
    tool = [ends[0] + (ends[1] - ends[0]) * rng.uniform(0.3, 0.7), 1.0, 0.3]
    _, follower, _ = motion_ranges(stages, angular, [(number, key)], [low], [high], tool)
    sampled = [
        assemble_train(with_numbers(stages, [(number, key)], [float(x)]), angular=angular)
        .follower_displacement(Taylor(tool))
        .terms
        for x in np.linspace(low, high, 5)
    ]
    for over, seen in zip(follower.terms, np.array(sampled).T, strict=True):
        width = float(np.max(range_of(over).high - range_of(over).low))
        assert width <= 1.5 * np.ptp(seen) + 1e-10 * max(1.0, abs(seen[2]))
        assert value_at_box_point(over).low <= seen[2] <= value_at_box_point(over).high or width < 1e-12


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", range(times(6, deep=1000)))
def test_slopes_by_a_number_of_a_link_are_enclosed(seed):
    """The tool and its velocity by each number of random trains, by differences between trains of a box."""
    rng = np.random.default_rng(7000 + seed)
    stages, train, angular = random_train(rng)
    ends = np.clip(
        [
            train.follower_displacement_at(float(np.clip(end.at, -20.0, 20.0)) * 0.9)
            for end in train.tool_travel_ends
        ],
        -9,
        9,
    )
    start = ends[0] + (ends[1] - ends[0]) * rng.uniform(0.2, 0.8)

    def constant_interval(low, high):
        none = Interval(np.zeros((1, 1)), np.zeros((1, 1)))
        value = Interval(np.array([low]), np.array([high]))
        return LinkageInterval.from_sloped_interval(SlopedInterval(value, value, none, none), [])

    for number, key in numbers_of(stages):
        own = stages[number][1][key]
        half, step = 1e-4 * abs(own), 1e-6 * abs(own)
        ranged = with_numbers(stages, [(number, key)], [Taylor([constant_interval(own - half, own + half), 1.0])])
        place = Taylor([constant_interval(start, start), constant_interval(1.0, 1.0)])
        slopes = (
            assemble_train_with_arrays(ranged, angular=angular)
            .tool_displacement(Taylor([place, place * 0.0]))
            .terms[1]
            .terms
        )
        at = own + rng.uniform(-0.9, 0.9) * half
        one, other = (
            assemble_train(with_numbers(stages, [(number, key)], [at + by]), angular=angular).tool_displacement(
                Taylor([start, 1.0])
            )
            for by in (step, -step)
        )
        for over, a, b in zip(slopes, one.terms, other.terms, strict=True):
            known, within = (a - b) / (2.0 * step), range_of(over)
            room = 1e-6 * max(1.0, abs(known))
            assert within.low - room <= known <= within.high + room


@pytest.mark.parametrize("seed", range(times(15, deep=300)))
def test_links_of_arrays_are_many_linkages(seed):
    rng = np.random.default_rng(9000 + seed)
    stages, train, angular = random_train(rng)
    chosen, *_, inside = drawn_box(rng, stages, SAMPLES)
    tool = [0.5 * sum(float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends), 1.0, 0.3, -0.2]
    with np.errstate(all="ignore"):
        many = assemble_train_with_arrays(
            with_numbers(stages, chosen, inside), angular=angular
        ).follower_displacement(Taylor(tool))
    for number, values in enumerate(inside.T.tolist()):
        try:
            one: Train = assemble_train(with_numbers(stages, chosen, values), angular=angular)
        except StageFault:
            continue
        if not one.tool_travel_ends[0].at < tool[0] < one.tool_travel_ends[1].at:
            continue
        found = [np.broadcast_to(term, SAMPLES)[number] for term in many.terms]
        assert found == pytest.approx(one.follower_displacement(Taylor(tool)).terms, rel=1e-13, abs=1e-13)

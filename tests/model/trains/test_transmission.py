"""Transmission angles: against closed loops sampled all over the travel, printed examples, and limits."""

import numpy as np
import pytest
from support.cams import cam_with, turn_of
from support.trains import random_train

from camopt import Scene, certify, evaluate
from camopt.core.numerics.taylor import Taylor
from camopt.model.trains.train import assemble_train

NEAR = 1e-9


def acute_angle(one, other):
    """Acute angle between two directions [rad], by their scalar product."""
    cosine = np.abs((one * np.conj(other)).real) / (np.abs(one) * np.abs(other))
    return np.arccos(np.minimum(cosine, 1.0))


def sampled_least_angle(stages, train, tool):
    """Least transmission angle over positions of the tool, from the pins of the couplers [rad]."""
    joints = [
        joint.displacement.terms[0]
        for joint in train.joint_motions(Taylor([train.follower_displacement(Taylor([tool])).terms[0]]))
    ]
    least = []
    for number, (name, keys) in enumerate(stages, start=1):
        last = max(k for k, stage in enumerate(train.stages, start=1) if stage == number)
        given, asked = joints[last - 1], joints[last]
        start = np.radians(keys.get("angle", 0.0))
        if name == "four-bar":
            link = train.links[last - 1]
            rocker = keys["rocker"] * np.exp(1j * (asked + link.rocker_start))
            least.append(
                acute_angle(rocker, keys["ground"] + rocker - keys["crank"] * np.exp(1j * (given + start)))
            )
        if name in ("bell-crank", "slider-crank"):
            by_slide = not train.links[last - 1].driver_and_driven_angular[0]
            turned = (asked if by_slide else given) + start
            pin = keys["crank"] * np.exp(1j * turned)
            along = np.sqrt(keys["coupler"] ** 2 - (pin.imag - keys["offset"]) ** 2)
            coupler = along + 1j * (keys["offset"] - pin.imag)
            least.append(acute_angle(pin, coupler) if by_slide else acute_angle(np.array(1j), coupler))
    return np.min(least)


@pytest.mark.parametrize("seed", range(120))
def test_the_least_angle_is_that_of_a_dense_scan(seed):
    rng = np.random.default_rng(seed)
    stages, train, _ = random_train(rng)
    if not train.has_couplers:
        pytest.skip("no coupler")
    low, high = (float(np.clip(end.at, -60.0, 60.0)) for end in train.tool_travel_ends)
    low, high = low + (high - low) * np.sort(rng.uniform(0.03, 0.97, 2))
    dense = sampled_least_angle(stages, train, np.linspace(low, high, 20001))
    found = train.least_transmission_angle_over_travel(low, high)
    assert found <= dense + 1e-9
    assert found == pytest.approx(dense, abs=1e-6)


def test_the_extremes_of_a_crank_rocker():
    """Norton, Design of Machinery, ch. 3: with the crank on the line of the pivots, cos μ = (b²+c²−(d−a)²)/2bc."""
    a, b, c, d = 40.0, 120.0, 80.0, 100.0
    keys = {"crank": a, "coupler": b, "rocker": c, "ground": d, "angle": 10.0}
    train = assemble_train([("four-bar", keys)], angular=True)
    low, high = sorted(float(train.tool_displacement(Taylor([np.radians(x)])).terms[0]) for x in (-40.0, 10.0))
    cosine = (b * b + c * c - (d - a) ** 2) / (2 * b * c)
    assert train.least_transmission_angle_over_travel(low, high) == pytest.approx(np.arccos(cosine), rel=1e-14)


SLIDE = {"stage": "bell-crank", "crank": 90, "coupler": 180, "offset": -70, "angle": -110}
FOUR_BAR = {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70}


@pytest.mark.parametrize("stage", [SLIDE, FOUR_BAR])
def test_a_limit_is_decided_next_to_its_bound(stage):
    scene = {**cam_with("arm"), "motion": turn_of("poly4567", 14), "train": [stage], "outputs": ["transmission"]}
    value = evaluate(Scene.from_dict(scene))["transmission_angle_min_deg"]
    assert 0.0 < value < 90.0
    for share in (1.0 - NEAR, 1.0 + NEAR):
        limited = Scene.from_dict({**scene, "limits": {"transmission_angle_min_deg": value * share}})
        assert certify(limited)["transmission_angle_min_deg"] == ("held" if share < 1.0 else "broken")
        assert (evaluate(limited)["violated"] == "transmission_angle_min_deg") == (share > 1.0)


def test_a_train_without_couplers_has_none():
    rocker = {"stage": "rocker", "output_arm": 55}
    scene = Scene.from_dict({**cam_with("arm"), "motion": turn_of("poly4567", 14), "train": [rocker]})
    assert "transmission_angle_min_deg" not in evaluate(scene)

"""Random scenes with trains: evaluated limits against proofs in ball arithmetic."""

import numpy as np
import pytest
from support.cams import CONTACTS, STEEL, cam_with, turn_of
from support.depth import times
from support.trains import random_train

import camopt
from camopt import Scene
from camopt.core.mistakes import BadInput
from camopt.core.quantities import AT_LEAST, QUANTITIES
from camopt.model.trains import TRAIN_STAGES

NEAR = 1e-9
LAWS = ("cycloidal", "poly345", "poly4567", "modified-sine", "modified-trapezoid", "harmonic", "double-harmonic")
LIMITS = 5  # of a scene


def random_carried_keys(rng, keys, turns):
    """The loads of a stage; none in half of the cases."""
    if rng.integers(2):
        return {}
    inertia, per = ("inertia", 1e-4) if turns else ("mass", 1.0)
    return {
        inertia: float(rng.uniform(0.1, 1.5)) * per,
        "spring_rate": float(rng.uniform(0.1, 2.0)),
        "preload": float(rng.uniform(5.0, 60.0)) * (0.05 if turns else 1.0),
        "load": float(rng.uniform(-5.0, 20.0)) * (0.05 if turns else 1.0),
        "friction_force": float(rng.uniform(0.0, 4.0)) * (0.05 if turns else 1.0),
        **({"arm_inertia": 1e-4} if "input_arm" in keys else {}),
    }


def drawn_scene(rng):
    """A scene with a random train, follower, law and lift; None if the cam cannot be made."""
    stages, train, angular = random_train(rng)
    turns, rows = angular, []
    for name, keys in stages:
        turns = TRAIN_STAGES[name].turns(keys, turns)
        rows.append({"stage": name, **keys, **random_carried_keys(rng, keys, turns)})
    lift = float(rng.uniform(0.15, 0.8) * min(train.tool_travel_ends[1].at, 0.7 if train.angular else 30.0))
    contacts = [each for each, keys in CONTACTS.items() if (keys["motion"] == "oscillating") == angular]
    raw = cam_with(
        contacts[rng.integers(len(contacts))],
        rotation=("ccw", "cw")[rng.integers(2)],
        rpm=float(rng.uniform(60, 600)),
        materials=STEEL,
        train=rows,
        motion=turn_of(LAWS[rng.integers(len(LAWS))], np.degrees(lift) if train.angular else lift),
    )
    try:
        return Scene.from_dict(raw), camopt.evaluate(Scene.from_dict(raw))
    except BadInput:
        return None


def random_case(seed):
    """A scene whose limits are a billionth or a tenth from what its cam has, and the limits that are broken."""
    rng = np.random.default_rng(seed)
    found = None
    while found is None or "assembly" in found[1]["violated"]:
        found = drawn_scene(rng)
    scene, cam = found
    names = [each for each in cam if each in QUANTITIES and QUANTITIES[each].relation_to_limit]
    names = [each for each in names if np.isfinite(cam[each]) and (cam[each] > 1e-6 or QUANTITIES[each].signed)]
    limits, broken = {}, set()
    for name in rng.permutation(names)[:LIMITS]:
        share, beyond = float(rng.choice([NEAR, 0.1])), bool(rng.integers(2))
        side = 1.0 if (QUANTITIES[name].relation_to_limit == AT_LEAST) == beyond else -1.0
        limits[str(name)] = float(cam[name] + side * share * abs(cam[name]))
        broken |= {str(name)} if beyond else set()
    return scene.replace(limits=limits, outputs=None), broken


@pytest.mark.parametrize("seed", range(times(3, 100)))
def test_limits_of_a_random_scene_are_certified_as_they_are_evaluated(seed):
    scene, broken = random_case(seed)
    verdicts, cam = camopt.certify(scene), camopt.evaluate(scene)
    crossing = verdicts.pop("self_crossing", "held")
    assert {*verdicts.values()} <= {"held", "broken"}
    assert {name for name in scene.to_dict()["limits"] if verdicts[name] == "broken"} == broken
    assert {*cam["violated"].split(",")} - {""} == {each for each in verdicts if verdicts[each] == "broken"}
    assert cam.get("self_crossing", False) == (crossing == "broken")

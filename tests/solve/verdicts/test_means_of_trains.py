"""Limits on means over the turn of every cam with every train within tolerances: against d'Alembert's own sums."""

import numpy as np
import pytest

import camopt
from camopt.scene.problem.problem import resolve_design
from camopt.solve.tolerances.margins import ToleranceBox
from camopt.solve.verdicts.limit_boxes import limit_verdict_over_box

LEVER = "pusher-by-lever"
OFF = {"train.1.ratio": 0.02, "follower.dynamics.mass": 0.02, "cam.rpm": 0.5, "follower.roller_radius": 0.02}
NAMES = ("torque_rms_N_m", "torque_mean_N_m", "power_mean_W")
LOAD = [[0, 20, 90, 100], [0, 25, 25, 0]]


def scene_of(**limits):
    return camopt.find_scene(LEVER).replace(part={}, limits=limits, tolerances=OFF)


def means(problem, ratio, mass, rpm):
    """By the motion of the pusher z = r·y: T = z'·(m_f·z''/r² + m·z'' + F(z) + load + friction)."""
    angles = np.linspace(0.0, 2.0 * np.pi, 40_001)[:-1] + 1e-6
    z, z1, z2, *_ = problem.programme.tool.motion_at(angles)
    omega = rpm * np.pi / 30.0
    load = np.interp(np.degrees(angles), *LOAD)
    force = 1e-3 * omega**2 * z2 * (mass / ratio**2 + 1.2) + 0.4 * z + 35.0 + load + 4.0 * np.sign(z1)
    torque = 1e-3 * z1 * force
    return np.sqrt(np.mean(torque**2)), np.mean(torque), omega * np.mean(torque)


@pytest.fixture(scope="module")
def found():
    scene = scene_of(**dict.fromkeys(NAMES, 1e4))
    return resolve_design(scene), {each.limit: each for each in camopt.tolerance(scene).margins}


@pytest.mark.long
def test_no_cam_with_a_train_within_the_tolerances_has_a_mean_beyond_what_is_proved(found):
    problem, told = found
    rng = np.random.default_rng(2)
    shares = rng.uniform(-1.0, 1.0, (60, 3))
    shares[:30] = np.sign(shares[:30])
    nominal, ends = np.array([2.0, 0.8, 100.0]), np.array([0.02, 0.02, 0.5])
    seen = np.array([means(problem, *(nominal + share * ends)) for share in shares]).max(axis=0)
    for name, most in zip(NAMES, seen, strict=True):
        margin = told[name]
        assert margin.verdict == "held"
        assert margin.gap <= 1.001e-3 * margin.worst
        assert margin.worst == pytest.approx(most, rel=1e-5)
        assert most <= (margin.worst + margin.gap) * (1.0 + 1e-6)
        sizes = (margin.sizes[key] for key in ("train.1.ratio", "follower.dynamics.mass", "cam.rpm"))
        assert means(problem, *sizes)[NAMES.index(name)] == pytest.approx(margin.worst, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.001, 0.999])
def test_the_verdict_on_a_mean_changes_where_the_worst_cam_meets_the_bound(found, share):
    name = NAMES[0]
    scene = scene_of(**{name: float(found[1][name].worst) * share})
    box = ToleranceBox.from_scene(scene, resolve_design(scene))
    (limit,) = (each for each in box.problem.limits if each.name == name)
    answer = limit_verdict_over_box(box.problem, limit, box.problem.design, box.number_ranges)
    assert answer.verdict == ("held" if share > 1.0 else "broken")


def test_the_mean_of_the_motion_that_is_asked_is_the_same_with_every_train():
    scene = scene_of(acceleration_rms_m_s2=20.0).replace(tolerances={"train.1.ratio": 0.02})
    (margin, *_) = camopt.tolerance(scene).margins
    assert (margin.verdict, margin.gap, margin.limit) == ("held", 0.0, "acceleration_rms_m_s2")

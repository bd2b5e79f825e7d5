"""Results of the motion and numbers of the scene: many settings together against each alone, and samples."""

from math import inf, pi

import numpy as np
import pytest
from support import own
from support.cams import CONTACTS, UNGUIDED, cam_with

from camopt import Scene
from camopt.core.quantities import QUANTITIES
from camopt.model.effects import EvaluationBlock, available_quantities
from camopt.model.effects.force import jump_speed, required_spring_rate
from camopt.model.effects.lash import angle_span_above_level, lash_speeds
from camopt.model.effects.torque import torque_over_turn
from camopt.model.motion.programme import Programme
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.sample import sweep_space
from camopt.solve.verdicts.effect_runs import run_effects

MANY = 300  # more than are found together


def turn(law):
    segments = [("rise", 100, 20, law), ("dwell", 60, 0, None), ("return", 120, 20, law), ("dwell", 80, 0, None)]
    return Programme.from_segments(segments, angular=False, laws=own.EVERY)


def random_numbers(*ends):
    """Numbers between ends; every third setting is that before it again."""
    random = np.random.default_rng(0)
    numbers = [random.uniform(low, high, MANY) for low, high in ends]
    for each in numbers:
        each[2::3] = each[1::3]
    return numbers


FORCES = [
    *random_numbers((0, 20), (0, 0.4), (2e-4, 2e-3), (-5, 300)),
    np.ones(MANY),
]  # the last of what no train carries
CASES = {
    "jump speed": (jump_speed, FORCES),
    "spring rate": (required_spring_rate, [FORCES[1], 1e3 * FORCES[2], *FORCES[3:]]),
    "torque": (torque_over_turn, FORCES),
    "angle above": (angle_span_above_level, random_numbers((-1, 21))),
    "speeds": (lash_speeds, random_numbers((-1, 10), (10, 21))),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("law", ["cycloidal", "parabolic", "uniform"])
@pytest.mark.parametrize("case", CASES)
def test_many_settings_together_are_each_what_it_is_alone(case, law):
    find, numbers = CASES[case]
    together = np.atleast_2d(np.array(find(turn(law), *numbers)))
    for k in range(0, MANY, 29):
        alone = np.atleast_1d(np.array(find(turn(law), *(float(each[k]) for each in numbers))))
        assert together[:, k].tolist() == alone.tolist()
    none = find(turn(law), *(each[:0] for each in numbers))
    assert np.atleast_2d(np.array(none)).shape == (len(together), 0)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["cycloidal", "parabolic", "poly345"])
def test_a_jump_speed_is_the_first_at_which_a_sampled_force_is_below_zero(law):
    """Damping that is light, and so heavy that contact is lost, won and lost again."""
    programme = turn(law)
    starts = programme.piece_starts[1:]  # of pieces: there y'' may jump
    angles = np.concatenate([np.linspace(0.0, 2 * pi, 4001)[:-1], starts - 1e-9, starts + 1e-9])
    y, y1, y2, _ = programme.motion_at(angles)[:4, :, None]
    stiffness, mass, constant, heavy = 2.0, 1e-3, 40.0, 0
    for damping in (0.0, 0.01, 0.3, 1.0, 3.0):
        found = jump_speed(programme, stiffness, damping, mass, constant, 1.0)
        omega = found * np.linspace(0.0, 1.0 - 1e-9, 801)
        force = stiffness * y + damping * omega * y1 + mass * omega**2 * y2 + constant
        assert force.min() >= -1e-6 * np.abs(force).max()
        above = found * 1.001
        after = stiffness * y + damping * above * y1 + mass * above**2 * y2 + constant
        assert after.min() < 0.0
        faster = jump_speed(programme, stiffness, 0.0, mass, constant, 1.0)
        heavy += found < 0.9 * faster
    assert heavy


def test_a_spring_that_is_required_keeps_contact_and_one_that_is_weaker_does_not():
    programme, angles = turn("poly345"), np.linspace(0.0, 2 * pi, 20001)[:-1]
    y, y1, y2, _ = programme.motion_at(angles)[:4]
    for damping, mass, constant in [(0.0, 5.0, 20.0), (3.0, 4.0, 10.0), (0.0, 1e-3, 50.0)]:
        rate = required_spring_rate(programme, damping, mass, constant, 1.0)
        rest = damping * y1 + mass * y2 + constant
        assert (rate * y + rest).min() == pytest.approx(max(rest.min(), 0.0) if rate == 0.0 else 0.0, abs=1e-4)
        assert rate == pytest.approx(np.max(-rest[y > 1e-3] / y[y > 1e-3], initial=0.0), rel=1e-5)
    assert required_spring_rate(programme, 0.0, 1e3, -1.0, 1.0) == inf


@pytest.mark.one_in(3)
@pytest.mark.parametrize("contact", CONTACTS)
def test_a_quantity_has_the_same_bits_whatever_else_is_asked(contact):
    """And whatever designs are beside: bounds, fronts and tables ask for different quantities."""
    arm = CONTACTS[contact]["motion"] == "oscillating"
    train = {"natural_frequency": 90.0, "damping_ratio": 0.05, "fluctuation": 0.02}
    scene = Scene.from_dict(cam_with(contact, "poly345", None if arm else UNGUIDED))
    scene = scene.replace(**{f"follower.dynamics.{key}": value for key, value in train.items()})
    size = "mean_radius" if contact.startswith("groove") else "base_radius"
    sizes, springs = [getattr(scene.cam, size) * share for share in (1.0, 1.07, 1.13)], [9.0, 11.3]
    scene = scene.replace(**{f"search.{size}": sizes, "search.follower.dynamics.spring_rate": springs})
    space = sweep_space(resolve(scene))
    problem, designs = space.problem, space.designs(np.arange(6))
    names = [name for name in available_quantities(problem.setup) if QUANTITIES[name].effect != "surface"]

    def bits(wanted, which):
        rows = run_effects(
            EvaluationBlock(problem.setup, problem.programme, designs.take(np.array(which))), frozenset(wanted)
        )
        return {name: rows.column(name).tolist() for name in wanted}

    together = bits(names, [0, 1, 2, 3, 4, 5])
    for name in names:
        assert bits([name], [4, 1]) == {name: [together[name][k] for k in (4, 1)]}, name

"""Variables: each is in the scene, in designs and in tables what it says of itself."""

from dataclasses import replace

import numpy as np
import pytest

from camopt import evaluate, evaluate_designs, find_scene, shipped_scenes
from camopt.core.quantities import QUANTITIES
from camopt.scene.choices import StepRange
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.variables import Variable, variables_of_scene

MOTIONS = {name: find_scene(name).to_dict().get("motion", []) for name in shipped_scenes()}
SCENES = [name for name, motion in MOTIONS.items() if motion and not any("per" in row for row in motion)]


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize("name", SCENES)
def test_a_variable_is_the_same_in_the_scene_in_designs_and_in_tables(name):
    """Of each that the scene gives: a table of designs that has it at another value, and the scene that has it."""
    scene = find_scene(name)
    for each in variables_of_scene(scene):
        (own,) = scene.numbers([each.key]).values()
        assert QUANTITIES[each.quantity].effect == "sizes"
        if not isinstance(own, float) or own == 0.0:
            continue
        value = 1.25 * own if each.is_size else own / 1.25
        found = evaluate_designs(scene, {each.quantity: [value]})
        assert found[each.quantity][0] == value
        expected = evaluate(scene.replace(**{each.key: value}))
        for quantity in ("acceleration_max_m_s2", "contact_force_max_N", "pressure_angle_max_deg"):
            if quantity in expected:
                assert found[quantity][0] == pytest.approx(expected[quantity], rel=1e-8)


@pytest.mark.parametrize("name", SCENES)
def test_what_search_names_is_the_variable_of_that_key(name):
    scene = find_scene(name).replace(search={})
    for each in resolve(scene).variables:
        (own,) = scene.numbers([each.key]).values()
        if not isinstance(own, float) or own <= 0.0:
            continue
        varied = resolve(scene.replace(**{each.search_key: [own, 1.5 * own]})).search_space.variables
        assert varied == {each.field: replace(each, choice=(own, 1.5 * own))}
        assert varied[each.field].range_ends == (own, 1.5 * own)


def test_angles_are_variables_of_their_segments():
    scene = find_scene("roller-1000rpm").replace(
        search={"angle_rise": {"start": 60, "stop": 200}, "angle_dwell": {"start": 0, "stop": 50}}
    )
    problem = resolve(scene)
    angles = problem.search_space.angles
    assert [problem.segments[each.segment].segment for each in angles] == ["rise", "dwell", "dwell"]
    for each in angles:
        (table, number, name) = each.key.split(".")
        assert scene.to_dict()[table][int(number) - 1][name] == problem.segments[each.segment].angle
        assert each.unit == "deg"
        assert each.shared_angle == sum(problem.segments[a.segment].angle for a in angles)


@pytest.mark.parametrize("enters", ["size", "number"])
@pytest.mark.parametrize(("stop", "step", "count"), [(0.3, 0.1, 4), (0.35, 0.1, 4), (0.7, 0.1, 8), (2.3, 0.1, 24)])
def test_no_value_of_a_range_is_beyond_its_end(enters, stop, step, count):
    values = Variable("", enters, "", "", choice=StepRange(start=0.0, stop=stop, step=step)).grid_values
    assert values.size == count
    assert values[0] == 0.0
    assert values[-1] <= stop
    assert np.diff(values) == pytest.approx(step)

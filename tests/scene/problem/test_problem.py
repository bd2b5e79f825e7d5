"""A problem is made of its scene once: what searches set in it is what a scene that says so gives."""

from dataclasses import fields

import pytest

from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.scene import Scene, find_scene
from camopt.solve.front.plan import sweep_plan, with_default_objectives
from camopt.solve.front.sweep import sweep
from camopt.solve.synthesis.axis_minimiser import AxisMinimiser
from camopt.solve.synthesis.cams import smallest_or_nearest_design
from camopt.solve.synthesis.nonconvex_constraints import load_constraints_at, nonconvex_constraints_of

LOADED = find_scene("roller-1000rpm").replace(
    **{"limits.pressure_angle": 30, "limits.normal_force": 900, "synthesis.pieces": 6, "cam.shaft_diameter": 10},
    **{"follower.dynamics": {"mass": 0.5, "spring_rate": 10, "preload": 200}},
)
SEARCHED = {"base_radius": {"start": 80, "stop": 140, "step": 20}, "offset": [0, 10], "law": ["cycloidal"]}
CHANGES = [
    ("cam.rpm", 500.0),
    ("cam.shaft_diameter", 25.0),
    ("cam.shaft_diameter", None),
    ("follower.dynamics.spring_rate", 3.0),
    ("limits.pressure_angle", 20.0),
    ("limits.pressure_angle", None),
    ("limits.normal_force", 700.0),
    ("limits.jump_speed", 1500.0),
]


@pytest.fixture
def unread(monkeypatch):
    """No scene can be read and checked."""

    def fill(*_):
        raise AssertionError("a scene is read again")

    monkeypatch.setattr(Scene, "_fill_and_check", fill)


@pytest.mark.parametrize(("key", "value"), CHANGES)
def test_numbers_and_bounds_that_are_set_are_those_of_a_scene_that_gives_them(key, value):
    found = resolve(LOADED).with_numbers({key: value})
    expected = resolve(LOADED.replace(**{key: value}))
    assert found.setup == expected.setup
    assert [(each.key, each.bound) for each in found.limits] == [(each.key, each.bound) for each in expected.limits]


def test_a_problem_keeps_no_scene_but_for_other_numbers():
    assert {field.name for field in fields(Problem) if "Scene" in str(field.type)} == {"_scene"}


@pytest.mark.usefixtures("_boxes")
@pytest.mark.parametrize("keep", ["pareto", "front-only"])
def test_default_objectives_are_those_of_a_scene_that_names_them(keep, request):
    plain = find_scene("roller-1000rpm").replace(search=SEARCHED)
    named = plain.replace(**{"search.minimise": list(with_default_objectives(resolve(plain)).objectives)})
    expected = sweep(named, keep=keep)
    assert sweep_plan(plain, keep).scene == named
    request.getfixturevalue("unread")
    found = sweep(plain, keep=keep)
    assert found.front == expected.front is not None
    assert found.scene == named


def test_bounds_of_a_frontier_are_those_of_a_scene_that_sets_them(request):
    held = {"normal_force_max_N": 700.0}
    stricter = LOADED.replace(**{"limits.normal_force": 700})
    expected = [
        constraint.upper_bound_of_each_side()
        for constraint in nonconvex_constraints_of(AxisMinimiser(stricter, ("size",), "size", ()).problem)
    ]
    request.getfixturevalue("unread")
    least = AxisMinimiser(LOADED, ("size", *held), "size", (*held,))
    assert [
        constraint.upper_bound_of_each_side()
        for constraint in nonconvex_constraints_of(least._problem_with_held_limits(held))
    ] == expected
    (constraint,) = load_constraints_at(resolve(LOADED), "normal_force", 5.0)
    assert constraint.upper_bound_of_each_side() == 5.0


@pytest.mark.parametrize(("changes", "own"), [({}, True), ({"limits.pressure_angle": 30}, False)])
def test_a_size_that_nothing_bears_on_is_the_scenes_own(changes, own, request):
    free = find_scene("roller-1000rpm").replace(limits=None, search=None, **changes)
    request.getfixturevalue("unread")
    problem = resolve(free)
    found = smallest_or_nearest_design(problem, ("jerk",)).size[0]
    assert (found == pytest.approx(free.cam.base_radius, rel=1e-9)) == own


def test_choices_are_what_the_search_gives():
    search = {"offset": [1, 2], "base_radius": {"start": 40, "stop": 50}, "law_rise": ["cycloidal", "poly345"]}
    search |= {
        "cam": {"rpm": [100, 200]},
        "angle_rise": {"start": 90, "stop": 180},
        "angle_dwell": {"start": 0, "stop": 90},
    }
    found = resolve(find_scene("two-pauses").replace(search=search)).search_space
    assert [each.name for each in found.sizes] == ["offset", "base_radius"]
    assert [(each.key, each.choice) for each in found.numbers] == [("cam.rpm", (100.0, 200.0))]
    assert found.laws == (("cycloidal", None), ("poly345", None))
    assert {each.name for each in found.angles} == {"angle_rise", "angle_dwell"}

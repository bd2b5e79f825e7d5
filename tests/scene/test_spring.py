"""A straight spring on the arm of an oscillating follower."""

from math import cos, radians, sin

import pytest

from camopt import BadInput, Scene, evaluate, evaluate_designs, find_scene, sweep
from camopt.scene.numbers_with_units import numbers_with_units
from camopt.scene.problem.problem import resolve
from camopt.scene.scene_file import text_of_scene

ARM = find_scene("rocker-valve")


def rocker(**dynamics):
    data = ARM.to_dict()
    data["follower"]["dynamics"] = {"inertia": 2e-4, "lash": 0.1, **dynamics}
    return Scene.from_dict(data)


@pytest.mark.parametrize(("rate", "preload", "lever"), [(30, 200, 45), ("30 N/mm", "0.2 kN", "4.5 cm")])
def test_it_is_a_spring_about_the_pivot(rate, preload, lever):
    scene = rocker(spring_rate=rate, preload=preload, spring_at=lever)
    inside = resolve(scene).setup.dynamics  # N·mm/rad, N·mm
    assert inside.stiffness == pytest.approx(30 * 45**2, rel=1e-15)
    assert inside.preload == pytest.approx(200 * 45, rel=1e-15)
    assert Scene.embedded(scene.to_toml(), "again") == scene


def test_its_moment_is_that_of_the_force_on_its_lever():
    """With the spring anchored far away: the lever turns, the force keeps its direction."""
    rate, preload, lever, swing = 30.0, 200.0, 45.0, radians(5.0)
    moment = (preload + rate * lever * sin(swing)) * lever * cos(swing) / 1e3
    inside = resolve(rocker(spring_rate=rate, preload=preload, spring_at=lever)).setup.dynamics
    assert (inside.preload + inside.stiffness * swing) / 1e3 == pytest.approx(moment, rel=6e-3)
    turning, straight = (
        evaluate(rocker(spring_rate=60.75, preload=9.0)),
        evaluate(rocker(spring_rate=rate, preload=preload, spring_at=lever)),
    )
    assert dict(turning) == dict(straight)


def test_a_moment_is_none_of_it():
    with pytest.raises(
        BadInput, match=r"follower\.dynamics\.preload = '2 N\*m': .* a number in N, or a text with a unit"
    ):
        rocker(spring_rate=30, preload="2 N*m", spring_at=45)
    assert rocker(spring_rate=30, preload="2 N*m").follower.dynamics.preload == 2.0


@pytest.mark.parametrize("lever", [0, -1, "long", "2 kg", True])
def test_what_is_no_lever(lever):
    with pytest.raises(BadInput, match=r"follower\.dynamics\.spring_at = .*: must be"):
        rocker(spring_rate=30, spring_at=lever)


def test_it_goes_with_a_spring_and_with_an_arm():
    with pytest.raises(BadInput, match=r"spring_at = 45: needs spring_rate in N/mm or preload in N"):
        rocker(spring_at=45)
    spring = {"mass": 1.0, "spring_rate": 3.0, "spring_at": 45}
    with pytest.raises(BadInput, match=r"spring_at = 45: .*a translating roller follower has none"):
        find_scene("roller-1000rpm").replace(**{"follower.dynamics": spring})


def with_pivot_spring(scene):
    """The same scene with a spring about the pivot."""
    own = scene.follower.dynamics
    lever = own.spring_at / 1e3
    turning = {"spring_rate": own.spring_rate * lever**2 * 1e3, "preload": own.preload * lever, "spring_at": None}
    return scene.replace(**{f"follower.dynamics.{key}": value for key, value in turning.items()})


@pytest.mark.parametrize("change", [{"spring_rate": 20}, {"preload": "150 N"}, {"spring_at": 50}])
def test_a_change_is_in_the_units_of_the_scene(change):
    scene = rocker(spring_rate=30, preload=200, spring_at=45)
    changed = scene.replace(**{f"follower.dynamics.{key}": value for key, value in change.items()})
    forces = [
        evaluate(each.replace(outputs=["force"]))["contact_force_max_N"]
        for each in (changed, with_pivot_spring(changed))
    ]
    assert forces[0] == pytest.approx(forces[1], rel=1e-12)
    assert forces[0] != evaluate(scene.replace(outputs=["force"]))["contact_force_max_N"]


def test_a_search_is_in_the_units_of_the_scene():
    free = {
        "spring_rate": ["25 N/mm", 30],
        "preload": {"start": 150, "stop": "0.2 kN", "step": 50},
        "spring_at": [40, 45],
    }
    search = {f"search.follower.dynamics.{key}": choice for key, choice in free.items()}
    scene = rocker(spring_rate=30, spring_at=45).replace(search={}, outputs=["force"], **search)
    rows = evaluate_designs(
        scene,
        {"spring_rate_N_per_mm": [25.0, 30.0], "preload_N": [150.0, 200.0], "spring_at_mm": [40.0, 45.0]},
    )
    for row in rows.to_dict("records"):
        keys = {"spring_rate": "spring_rate_N_per_mm", "preload": "preload_N", "spring_at": "spring_at_mm"}
        own = {f"follower.dynamics.{key}": row[name] for key, name in keys.items()}
        expected = evaluate(with_pivot_spring(scene.replace(search={}, **own)))
        assert row["contact_force_max_N"] == pytest.approx(expected["contact_force_max_N"], rel=1e-9)
    swept = sweep(scene)
    assert swept.designs == 8 * len(swept.best)


def test_a_table_of_results_names_the_units_of_the_scene():
    straight = dict(numbers_units(rocker(spring_rate=30, preload=200, spring_at=45)))
    turning = dict(numbers_units(rocker(spring_rate=60, preload=9)))
    assert (straight["spring_rate"], straight["preload"], straight["spring_at"]) == ("N/mm", "N", "mm")
    assert (turning["spring_rate"], turning["preload"]) == ("N·m/rad", "N·m")


def numbers_units(scene):
    return [(each.key.rpartition(".")[2], each.unit) for each in numbers_with_units(scene)]


def test_a_written_scene_keeps_the_straight_spring(tmp_path):
    file = tmp_path / "arm.toml"
    dynamics = (
        "[follower.dynamics]\ninertia = 2e-4\nlash = 0.1\nspring_rate = 30 # of the catalogue\nspring_at = 45\n"
    )
    text = ARM.replace(**{"follower.dynamics": None}).to_toml()
    file.write_text(f"{text}\n{dynamics}")
    scene = find_scene(file)
    written = text_of_scene(scene.replace(**{"cam.base_radius": 21.0}))
    assert dynamics in written
    other = scene.replace(**{"follower.dynamics.spring_rate": 50.0})
    assert Scene.embedded(text_of_scene(other), "x").follower.dynamics.spring_rate == 50.0

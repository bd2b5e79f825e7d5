"""A straight spring on the arm of an oscillating follower."""

from math import cos, radians, sin

import pytest

from camopt import BadInput, Scene, evaluate, find_scene
from camopt.scene.written import text_of_scene

ARM = find_scene("rocker-valve")


def rocker(**dynamics):
    data = ARM.to_dict()
    data["follower"]["dynamics"] = {"inertia": 2e-4, "lash": 0.1, **dynamics}
    return Scene.from_dict(data)


@pytest.mark.parametrize(("rate", "preload", "lever"), [(30, 200, 45), ("30 N/mm", "0.2 kN", "4.5 cm")])
def test_it_is_a_spring_about_the_pivot(rate, preload, lever):
    scene = rocker(spring_rate=rate, preload=preload, spring_at=lever)
    assert scene.follower.dynamics.spring_rate == pytest.approx(30 * 45**2 / 1e3, rel=1e-15)
    assert scene.follower.dynamics.preload == pytest.approx(200 * 0.045, rel=1e-15)
    assert "spring_at" not in scene.to_toml()
    assert Scene.embedded(scene.to_toml(), "again") == scene


def test_its_moment_is_that_of_the_force_on_its_lever():
    """With the spring anchored far away: the lever turns, the force keeps its direction."""
    rate, preload, lever, swing = 30.0, 200.0, 45.0, radians(5.0)
    moment = (preload + rate * lever * sin(swing)) * lever * cos(swing) / 1e3
    dynamics = rocker(spring_rate=rate, preload=preload, spring_at=lever).follower.dynamics
    assert dynamics.preload + dynamics.spring_rate * swing == pytest.approx(moment, rel=6e-3)
    about, straight = (
        rocker(spring_rate=60.75, preload=9.0),
        rocker(spring_rate=rate, preload=preload, spring_at=lever),
    )
    assert evaluate(about) == evaluate(straight)


def test_a_moment_is_none_of_it():
    with pytest.raises(BadInput, match=r"follower\.dynamics\.preload = '2 N\*m': .* a number in N, or with a unit"):
        rocker(spring_rate=30, preload="2 N*m", spring_at=45)
    assert rocker(spring_rate=30, preload="2 N*m").follower.dynamics.preload == 2.0


@pytest.mark.parametrize("lever", [0, -1, "long", "2 kg", True])
def test_what_is_no_lever(lever):
    with pytest.raises(BadInput, match=r"follower\.dynamics\.spring_at = .*: must be"):
        rocker(spring_rate=30, spring_at=lever)


def test_it_goes_with_a_spring_and_with_an_arm():
    with pytest.raises(BadInput, match=r"spring_at = 45: goes with spring_rate in N/mm or preload in N"):
        rocker(spring_at=45)
    spring = {"mass": 1.0, "spring_rate": 3.0, "spring_at": 45}
    with pytest.raises(BadInput, match=r"spring_at = 45: only an oscillating follower has one"):
        find_scene("roller-1000rpm").replace(**{"follower.dynamics": spring})


def test_it_is_no_number_to_search():
    with pytest.raises(BadInput, match=r"spring_at = .*: not a number of this table"):
        rocker(spring_rate=30).replace(search={"follower": {"dynamics": {"spring_at": [40, 50]}}})


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

"""Scenes written as files: an equal scene, in the words of the file that it came from."""

import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import Scene, find_scene, shipped_scenes
from camopt.scene.scene_file import text_of_scene, write_scene
from camopt.scene.sources import shipped_toml

OWN = """\
# The feeder of line 3.
[cam]
rpm = 1_000          # of the drive
base_radius = "2 in" # as on the old drawing
form = "disc"

[follower] # from stock
contact = "roller"
motion = "translating"
roller_radius = 10

[[motion]]
segment = "rise" # to the transfer
lift = 20
angle = 150
law = "cycloidal"

[[motion]] # back, slower
segment = "return"
lift = 20
angle = 210
law = "cycloidal"
"""


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "feeder.toml"
    path.write_text(OWN)
    return find_scene(path)


def comments_in(text):
    return re.findall(r"#.*", text)


def test_what_changes_stands_where_it_stood(own):
    text = text_of_scene(own.replace(**{"cam.base_radius": 47.25, "motion.2.law": "poly345"}))
    unnamed = re.sub(r'name = "feeder"\n\n?', "", text)  # newer versions of tomlkit put an empty line below it
    assert unnamed.replace("47.25 ", '"2 in" ').replace("poly345", "cycloidal") == OWN
    assert "base_radius = 47.25 # as on the old drawing" in text


def test_what_is_new_comes_after_what_is_there(own):
    more = {"follower.dynamics": {"mass": 2.0}, "limits.pressure_angle": 30, "follower.offset": 3}
    changed = own.replace(**more)
    text = text_of_scene(changed)
    assert comments_in(text) == comments_in(OWN)
    assert "roller_radius = 10\noffset = 3.0\n\n[follower.dynamics]\nmass = 2.0\n\n[[motion]]" in text
    assert text.endswith('law = "cycloidal"\n\n[limits]\npressure_angle = 30.0\n')
    assert Scene.embedded(text, own.file) == changed


def test_what_is_taken_away_is_gone_and_nothing_else(own):
    moved = own.replace(**{"follower.offset": 4, "limits": {"pressure_angle": 30, "outer_radius": 200}})
    write_scene(Path(own.file), moved)
    text = text_of_scene(find_scene(own.file).replace(**{"limits.pressure_angle": None}))
    assert "pressure_angle" not in text
    assert "outer_radius = 200" in text
    assert comments_in(text) == comments_in(OWN)


@pytest.mark.parametrize("left", [{}, {"angle": [70.0, 80.0]}])
def test_tables_that_lose_their_last_key_are_gone(left):
    """The numbers of a train in [search] stand in the file as dotted keys of one table."""
    press = find_scene("press-ram-by-four-bar")
    asked = press.replace(**{"search.train.1.coupler": None, "search.train.1.angle": left.get("angle")})
    assert asked.to_dict()["search"].get("train") == ({"1": left} if left else None)
    text = text_of_scene(asked)
    assert Scene.embedded(text, press.file) == asked
    assert comments_in(text) == comments_in(shipped_toml(press.file))


def test_another_number_of_segments_is_written_whole(own):
    motion = [*own.to_dict()["motion"][:1], {"segment": "dwell", "angle": 60.0}, own.to_dict()["motion"][1]]
    motion[2]["angle"] = 150.0
    changed = own.replace(motion=motion)
    text = text_of_scene(changed)
    assert Scene.embedded(text, own.file) == changed
    assert "# as on the old drawing" in text


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_shipped_scene_keeps_its_comments(name):
    scene, source = find_scene(name), shipped_toml(name)
    assert text_of_scene(scene) == source
    faster = scene.replace(**{"cam.rpm": 123.0, "limits.pressure_angle": 45.6})
    text = text_of_scene(faster)
    assert Scene.embedded(text, name) == faster
    assert [line for line in comments_in(source) if line not in text] == []


LOAD_FILE = "angle,load\n0,10\n180,30\n360,10\n"


def test_what_other_files_hold_is_written_out(own, tmp_path, monkeypatch):
    """The new file stands alone, wherever it lies."""
    (tmp_path / "load.csv").write_text(LOAD_FILE)
    dynamics = '[follower.dynamics]\nmass = 2\nload = "load.csv" # measured\n'
    loaded = OWN.replace("\n[[motion]]", f"\n{dynamics}\n[[motion]]", 1)
    (tmp_path / "loaded.toml").write_text(loaded)
    scene = find_scene(tmp_path / "loaded.toml")
    text = text_of_scene(scene)
    (tmp_path / "load.csv").unlink()
    assert Scene.embedded(text, scene.file) == scene
    assert comments_in(text) == comments_in(loaded)


@pytest.mark.parametrize("lost", ["gone", "another scene", "no scene", "no text"])
def test_without_its_file_a_scene_is_written_plainly(lost, own, tmp_path):
    changed, path = own.replace(**{"cam.rpm": 700.0}), tmp_path / "feeder.toml"
    if lost == "gone":
        path.unlink()
    elif lost == "another scene":
        path.write_text(shipped_toml("slide-by-bell-crank"))
    else:
        path.write_bytes(b"[cam" if lost == "no scene" else b"\xff\xfe\x00")
    text = text_of_scene(changed)
    assert Scene.embedded(text, own.file) == changed
    if lost != "another scene":
        assert text == changed.to_toml()


@pytest.mark.one_in(3)
@settings(max_examples=times(5, deep=200))
@given(data=st.data())
@pytest.mark.parametrize("name", shipped_scenes())
def test_any_scene_may_come_of_any_file(name, data, tmp_path_factory):
    """A file that was another scene is no harm: what is written is the scene that was asked for."""
    other = find_scene(data.draw(st.sampled_from(shipped_scenes())))
    scene = Scene.from_dict(other.to_dict(), name)
    assert Scene.embedded(text_of_scene(scene), name) == scene


def test_python_and_commands_write_alike(own, command, tmp_path):
    code, _, _ = command("optimise", own.file, "--set", "limits.pressure_angle=30", "--out", "best", "--quiet")
    assert code == 0
    (file,) = (tmp_path / "best").glob("*.toml")
    written = file.read_text()
    assert [each for each in comments_in(OWN) if each not in written] == []
    assert tomllib.loads(written)["limits"] == {"pressure_angle": 30.0}

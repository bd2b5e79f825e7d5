"""Scenes to start from: they run, with what they have switched off too, and say what the code says."""

import shutil
import tomllib
from pathlib import Path

import pytest

import camopt
from camopt.cli.main import main
from camopt.scene.scene import SCENE_TABLES
from camopt.scene.scene_templates import PAIRINGS, PURPOSES, starting_machine, starting_scene
from camopt.scene.sources import MACHINES
from camopt.scene.table_places import key_record

NAMES = [*PURPOSES, *camopt.shipped_scenes()]
TEXTS = {name: starting_scene(name) for name in NAMES}
TEXTS |= {words: starting_scene(None, *words.split()) for words in PAIRINGS}


def enable_all_lines(lines):
    """The text with all switched-off lines enabled."""
    return "\n".join(line[1:] if line[:1] == "#" and line[1:2] not in (" ", ":", "") else line for line in lines)


@pytest.mark.parametrize("name", NAMES)
def test_a_named_one_is_the_shipped_scene(name):
    assert camopt.Scene.from_dict(tomllib.loads(TEXTS[name])) == camopt.find_scene(PURPOSES.get(name, name))


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize("words", PAIRINGS)
def test_one_of_a_mechanism_runs_and_is_optimised_with_all_switched_on(words):
    plain = camopt.Scene.from_dict(tomllib.loads(TEXTS[words]))
    assert f"{plain.cam.form} {plain.follower.motion}-{plain.follower.contact}" == words
    assert camopt.evaluate(plain)["feasible"]
    whole = camopt.Scene.from_dict(tomllib.loads(enable_all_lines(TEXTS[words].splitlines())))
    assert camopt.optimise(whole).best["feasible"]


@pytest.mark.parametrize("name", TEXTS)
def test_what_is_switched_off_is_allowed(name):
    on = camopt.Scene.from_dict(tomllib.loads(enable_all_lines(TEXTS[name].splitlines())))
    assert on.follower.dynamics
    assert on.materials.cam
    assert {"pressure_angle", "face_reach"} & on.limits.bounds_by_key.keys()


@pytest.mark.parametrize("words", PAIRINGS)
def test_the_spring_of_a_mechanism_presses_with_a_usual_force(words):
    """On the trace point of an arm, as on a follower in a guide: from 50 to 200 N at the lowest position."""
    on = camopt.Scene.from_dict(tomllib.loads(enable_all_lines(TEXTS[words].splitlines())))
    lever = (on.follower.arm_length or on.follower.centre_distance) / 1e3 if on.mechanism.motion.angular else 1.0
    assert 50.0 <= on.follower.dynamics.preload / lever <= 200.0


@pytest.mark.parametrize("name", TEXTS)
def test_comments_are_what_the_code_says(name):
    said = {key_record(model, key).sentence for model in SCENE_TABLES.values() for key in model.model_fields}
    comments = [line.partition("  # ")[2] for line in TEXTS[name].splitlines() if "  # " in line]
    assert len(comments) > 20
    assert {comment.partition(": ")[2] for comment in comments} | {*comments} >= {*comments}
    assert [each for each in comments if each not in said and each.partition(": ")[2] not in said] == []
    assert len({*comments}) == len(comments)


@pytest.mark.parametrize("name", TEXTS)
def test_nothing_in_it_is_of_this_machine(name):
    """It is sent to others."""
    assert "file:" not in TEXTS[name]
    assert str(Path(camopt.__file__).parents[1]) not in TEXTS[name]


def test_a_shipped_scene_that_is_printed_has_nothing_of_this_machine_either(capsys):
    assert main(["scenes", "two-pauses"]) == 0
    text = capsys.readouterr().out
    assert camopt.Scene.from_dict(tomllib.loads(text)) == camopt.find_scene("two-pauses")
    assert "file:" not in text


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (("valv",), "did you mean valve?"),
        (("valve", None, "oscillating-roller"), "give either a name, or a form and a follower"),
        ((None, "cylindrical", "translating-flat"), "known: "),
    ],
)
def test_what_there_is_not_is_told(asked, why):
    with pytest.raises(camopt.BadInput, match=why):
        starting_scene(*asked)


def test_a_machine_to_start_from_runs_with_all_switched_on(tmp_path):
    plain, whole = tmp_path / "plain.toml", tmp_path / "whole.toml"
    text = starting_machine()
    plain.write_text(text, encoding="utf-8")
    whole.write_text(enable_all_lines(text.splitlines()), encoding="utf-8")
    shutil.copy(MACHINES / "pick-and-place" / "motors.csv", tmp_path)
    assert camopt.evaluate_machine(plain).verdict == "held"
    found = camopt.evaluate_machine(whole)
    assert found.verdict == "held"
    assert any(use.fits for use in found.motors)
    assert camopt.optimise_phases(whole).peak < found.shaft.peak

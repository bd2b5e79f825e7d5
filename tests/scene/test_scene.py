"""Scenes: TOML and mappings in and out, and every mistake told in plain words, all at once."""

import copy
import json
import pickle
import subprocess
import sys
import tomllib
from math import inf, nan
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import Field
from support import own
from support.depth import times

from camopt import BadInput, Scene, find_scene, shipped_scenes
from camopt.core.mistakes import Mistake
from camopt.scene.choices import StepRange
from camopt.scene.sources import shipped_toml
from camopt.scene.tables import Cam, InnerTable, Length, SceneTable, Segment

WORKED = json.loads((Path(__file__).parents[1] / "data" / "worked-examples.json").read_text())
JARGON = ("Input should", "input should", "extra_forbidden", "tuple[", "Range.", "pydantic", "validation error")
DELETED = object()

BASES = {
    "roller": find_scene("roller-1000rpm").to_dict(),
    "arm": find_scene("oscillating-roller").to_dict(),
    "flat": find_scene("flat-reciprocating").to_dict(),
    "knife": find_scene("uniform-knife-radial").to_dict(),
    "swinging face": {
        "cam": {"form": "disc", "base_radius": 30.0},
        "follower": {"motion": "oscillating", "contact": "flat", "centre_distance": 80.0, "face_offset": 5.0},
        "motion": [
            {"segment": "rise", "angle": 180.0, "lift": 15.0, "law": "cycloidal"},
            {"segment": "return", "angle": 180.0, "lift": 15.0, "law": "cycloidal"},
        ],
    },
    "own laws": {
        "cam": {"form": "disc", "base_radius": 30.0},
        "follower": {"motion": "translating", "contact": "knife"},
        "motion": [
            {"segment": "rise", "angle": 180.0, "lift": 15.0, "law": "own-spline"},
            {"segment": "return", "angle": 180.0, "lift": 15.0, "law": "own-table"},
        ],
        "laws": own.TABLES,
    },
    "groove": {
        "cam": {"form": "cylindrical", "mean_radius": 50.0, "rpm": 100.0},
        "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 5.0, "arm_length": 60.0},
        "motion": [
            {"segment": "rise", "angle": 180.0, "lift": 20.0, "law": "poly345"},
            {"segment": "return", "angle": 180.0, "lift": 20.0, "law": "poly345"},
        ],
    },
}


def with_values(base, changes):
    """A copy of a mapping, with values by dotted key; segments count from 1, as in messages."""
    data = copy.deepcopy(base)
    for key, value in changes.items():
        *tables, last = key.split(".")
        table = data
        for name in tables:
            table = table[int(name) - 1] if isinstance(table, list) else table.setdefault(name, {})
        if value is DELETED:
            del table[last]
        else:
            table[last] = value
    return data


def mistakes(data, file="cam.toml"):
    with pytest.raises(BadInput) as caught:
        Scene.from_dict(data, file)
    lines = str(caught.value).split("\n")
    assert len(lines) == len(caught.value.mistakes)
    assert not [word for word in JARGON for line in lines if word in line]
    assert all(line.startswith(f"{file}: ") for line in lines)
    return lines


# ------------------------------------------------------------------------------------------ what is right


@pytest.mark.parametrize("name", WORKED)
def test_a_shipped_scene_is_that_of_the_source(name):
    scene, expected = find_scene(name), WORKED[name]["scene"]
    segments = [[s.segment, s.angle, s.law, s.lift] for s in scene.motion]
    assert segments == [[kind, float(angle), law, float(lift)] for kind, angle, law, lift in expected["segs"]]
    assert f"{scene.follower.motion}-{scene.follower.contact}" == expected["follower"]
    sizes = {**scene.follower.model_dump(), **scene.cam.model_dump()}
    for key in expected.keys() - {"segs", "follower"}:
        value = expected[key]
        assert sizes[key] == (value if key == "rotation" else float(value)), key


def test_every_worked_example_is_shipped():
    """Motions of practice come beside them; these have numbers of their own (``test_moves``, ``test_arcs``)."""
    practice = {
        "belt-matching",
        "bucket-valve",
        "feeder-with-stop",
        "indexing-overlap",
        "press-with-drift",
        "rocker-valve",
    }
    trains = {
        "press-ram-by-four-bar",
        "slide-by-bell-crank",
        "valve-with-rocker",
        "pusher-by-lever",
        "clamp-by-wedge",
    }
    profiles = {"tangent-cam", "three-arc-valve", "eccentric-rocker"}
    drives = {"face-groove-shutter", "press-feed-by-pair", "pump-of-constant-breadth"}
    drives |= {"barrel-traverse", "bottle-filler-by-rib"}
    assert set(shipped_scenes()) - set(WORKED) == practice | trains | profiles | drives
    assert not set(WORKED) - set(shipped_scenes())


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_scene_survives_mappings_toml_and_files(name, tmp_path):
    scene = find_scene(name)
    assert Scene.from_dict(scene.to_dict()) == scene
    assert Scene.from_dict(tomllib.loads(scene.to_toml())) == scene
    assert Scene.from_dict(tomllib.loads(shipped_toml(name))) == scene
    file = tmp_path / "scene.toml"
    file.write_text(scene.to_toml(), encoding="utf-8")
    assert Scene.from_toml(file) == scene == find_scene(str(file))


@pytest.mark.parametrize("base", BASES)
def test_bases_of_the_tables_below_are_right(base):
    assert Scene.from_dict(BASES[base]).to_dict() == {"name": "scene", **BASES[base]}


def test_a_scene_is_named_after_its_file(tmp_path):
    file = tmp_path / "my cam.toml"
    file.write_text(find_scene("two-pauses").to_toml().split("\n", 1)[1], encoding="utf-8")
    assert Scene.from_toml(file).name == "my cam"


def test_tables_and_mappings_make_the_same_scene():
    data = BASES["knife"]
    motion = tuple(Segment(**segment) for segment in data["motion"])
    assert Scene(**{**data, "cam": Cam(**data["cam"]), "motion": motion}) == Scene.from_dict(data)


def test_replace_sets_adds_and_clears_by_dotted_key():
    scene = find_scene("roller-1000rpm")
    other = scene.replace(**{
        "cam.rpm": 500, "follower.dynamics.mass": 2, "limits.pressure_angle": None, "search.law": "harmonic",
        "search.offset": StepRange(start=0, stop=5), "accuracy.relative_error": None, "name": "slow",
    })  # fmt: skip
    assert (other.name, other.cam.rpm, other.follower.dynamics.mass) == ("slow", 500.0, 2.0)
    assert other.limits.pressure_angle is None
    assert other.limits.pressure_angle_return == 30.0
    assert other.search.law == ("harmonic",)
    assert other.search.offset == StepRange(start=0.0, stop=5.0)
    assert scene == find_scene("roller-1000rpm")
    assert Scene.from_dict(other.to_dict()) == other


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        ("cam.rmp", 5, "roller-1000rpm: cam.rmp = 5: not a known key; did you mean rpm?"),
        ("name.first", 5, "roller-1000rpm: name.first = 5: name is not a table: set name itself"),
        (
            "motion.1",
            5,
            "roller-1000rpm: motion.1 = 5: set a key of this table, such as motion.1.segment, or set motion itself",
        ),
        (
            "motion.9.law",
            "harmonic",
            "roller-1000rpm: motion.9.law = 'harmonic': there is no table 9: [[motion]] has 4",
        ),
        ("cam.rpm", -1, "roller-1000rpm: cam.rpm = -1: must be at least 1e-09"),
    ],
)
def test_a_mistaken_replacement_is_told(key, value, line):
    with pytest.raises(BadInput) as caught:
        find_scene("roller-1000rpm").replace(**{key: value})
    assert line in str(caught.value)


def test_a_choice_may_be_one_value_a_list_or_a_range():
    search = Scene.from_dict(
        with_values(BASES["roller"], {"search.offset": 3, "search.roller_radius": [1, 2]})
    ).search
    assert (search.offset, search.roller_radius) == ((3.0,), (1.0, 2.0))
    assert search.base_radius == StepRange(start=20.0, stop=150.0, step=0.5)


# ------------------------------------------------------------------------------------------ what is wrong

NO_SEGMENT = {"segment": "rise", "angle": 90.0, "lift": 5.0, "law": "harmonic"}

ONE_MISTAKE = [
    # keys
    ("roller", {"cam.base_raduis": 50}, "cam.base_raduis = 50: not a known key; did you mean base_radius? known:"),
    ("roller", {"search.spring_rate": [5]}, "search.spring_rate = [5]: not a known key; did you mean follower.dynamics.spring_rate?"),
    ("roller", {"search.minimise": "size"}, "search.minimise.1 = 'size': must be a quantity; did you mean base_radius_mm?"),
    ("roller", {"synthesis": {"minimise": "torque"}}, "synthesis.minimise = 'torque': must be a term of the objective; loads such as torque_peak_N_m are axes of a frontier only"),
    ("roller", {"limts": {}}, "limts = {}: not a known key; did you mean limits? known: name, cam, follower"),
    ("roller", {"motion.1.lfit": 3}, "motion.1.lfit = 3: not a known key; did you mean lift? known: segment, angl"),
    ("roller", {"follower.dynamics.mas": 1}, "follower.dynamics.mas = 1: not a known key; did you mean mass?"),
    ("roller", {"limits.presure_angle": 3}, "limits.presure_angle = 3: not a known key; did you mean pressure_ang"),
    ("roller", {"search.base_radios": [5]}, "search.base_radios = [5]: not a known key; did you mean base_radius?"),
    ("roller", {"search.offset": {"start": 0, "stop": 1, "stpe": 1}}, "search.offset.stpe = 1: not a known key; d"),
    ("roller", {"accuracy.tol": 0}, "accuracy.tol = 0: not a known key; known: relative_error"),
    ("roller", {"self": 1}, "self = 1: not a known key; known: name, cam,"),
    ("roller", {"cam.self": 1}, "cam.self = 1: not a known key; known: form,"),
    ("roller", {"cam.range": 1}, "cam.range = 1: not a known key; "),
    ("roller", {"search.values": 1}, "search.values = 1: not a known key; "),
    ("roller", {"__file__": "x"}, "__file__ = 'x': not a known key; "),
    ("roller", {"": 1}, " = 1: not a known key; "),
    ("roller", {"cam.form": DELETED}, "cam.form: missing"),
    ("roller", {"cam": DELETED}, "cam: missing"),
    ("roller", {"follower": DELETED}, "follower: missing"),
    # kinds
    ("roller", {"cam": []}, "cam = []: must be a table"),
    ("roller", {"cam": 5}, "cam = 5: must be a table"),
    ("roller", {"search": []}, "search = []: must be a table"),
    ("roller", {"follower.dynamics": 3}, "follower.dynamics = 3: must be a table"),
    ("roller", {"cam.base_radius": "50"}, "cam.base_radius = '50': must be a number"),
    ("roller", {"cam.base_radius": True}, "cam.base_radius = True: must be a number"),
    ("roller", {"cam.base_radius": [50]}, "cam.base_radius = [50]: must be a number"),
    ("roller", {"cam.base_radius": nan}, "cam.base_radius = nan: must be a finite number"),
    ("roller", {"cam.rpm": inf}, "cam.rpm = inf: must be a finite number"),
    ("roller", {"cam.base_radius": 10**400}, "cam.base_radius = 1000"),
    ("roller", {"cam.base_radius": "x" * 5000}, "cam.base_radius = 'xxx"),
    ("roller", {"name": 5}, "name = 5: must be a text"),
    # magnitudes
    ("roller", {"cam.base_radius": -50}, "cam.base_radius = -50: must be at least 1e-09"),
    ("knife", {"cam.base_radius": 0}, "cam.base_radius = 0: must be at least 1e-09"),
    ("roller", {"cam.base_radius": 1e12}, "cam.base_radius = 1000000000000.0: must be at most 1e+09"),
    ("knife", {"cam.base_radius": 1e-12}, "cam.base_radius = 1e-12: must be at least 1e-09"),
    ("roller", {"follower.roller_radius": -1}, "follower.roller_radius = -1: must be at least 1e-09"),
    ("roller", {"cam.rpm": 0}, "cam.rpm = 0: must be at least 1e-09"),
    ("roller", {"cam.rpm": 1e300}, "cam.rpm = 1e+300: must be at most 1e+15"),
    ("roller", {"limits.pressure_angle": 90}, "limits.pressure_angle = 90: must be below 90"),
    ("roller", {"limits.pressure_angle": 0}, "limits.pressure_angle = 0: must be at least 1e-09"),
    ("roller", {"limits.curvature_radius": 0}, "limits.curvature_radius = 0: must be at least 1e-09"),
    ("roller", {"materials.cam_poisson": 0.5}, "materials.cam_poisson = 0.5: must be below 0.5"),
    ("roller", {"accuracy.relative_error": 1e-20}, "accuracy.relative_error = 1e-20: must be at least 1e-14"),
    ("roller", {"accuracy.relative_error": 0}, "accuracy.relative_error = 0: must be at least 1e-14"),
    ("roller", {"accuracy.relative_error": 1}, "accuracy.relative_error = 1: must be at most 0.01"),
    # names
    ("roller", {"cam.form": "disk"}, "cam.form = 'disk': must be one of 'disc' or 'cylindrical'"),
    ("roller", {"cam.form": {}}, "cam.form = {}: must be one of 'disc' or 'cylindrical'"),
    ("roller", {"cam.rotation": "clockwise"}, "cam.rotation = 'clockwise': must be one of 'ccw' or 'cw'"),
    ("roller", {"follower.contact": "knfe"}, "follower.contact = 'knfe': must be one of 'knife', 'roller', 'flat'"),
    ("roller", {"follower.motion": "rolling"}, "follower.motion = 'rolling': must be one of 'translating' or"),
    ("roller", {"motion.1.segment": "raise"}, "motion.1.segment = 'raise': must be one of 'rise', 'dwell', 'return', 'move' or"),
    ("roller", {"motion.1.segment": []}, "motion.1.segment = []: must be one of 'rise', 'dwell', 'return', 'move' or"),
    ("roller", {"motion.1.law": "parabollic"}, "motion.1.law = 'parabollic': must be a motion law; did you mean p"),
    ("roller", {"motion.3.law": {}}, "motion.3.law = {}: must be the name of a motion law"),
    ("roller", {"search.law": ["harmonik"]}, "search.law.1 = 'harmonik': must be a motion law; did you mean harmo"),
    ("roller", {"search.law": [[]]}, "search.law.1 = []: must be the name of a motion law"),
    ("roller", {"search.minimise": ["base_radius"]}, "search.minimise.1 = 'base_radius': must be a quantity; did"),
    ("roller", {"search.minimise": ["undercut"], "search.maximise": "undercut"}, "search.maximise = 'undercut': is minimised too: leave one of them"),
    ("roller", {"search.thin": 0}, "search.thin = 0: must be at least 1e-09"),
    ("roller", {"search.thin": 1}, "search.thin = 1: must be below 1"),
    ("roller", {"search.thin": "fine"}, "search.thin = 'fine': must be a number"),
    ("roller", {"search.refine": 1}, "search.refine = 1: must be true or false"),
    ("roller", {"outputs": ["undercutt"]}, "outputs.1 = 'undercutt': must be a quantity, an effect (camopt effects lists them) or all; did you mean undercut?"),
    # motion
    ("roller", {"motion": DELETED}, "motion: missing"),
    ("roller", {"motion": []}, "motion = []: must be a list of at least one value"),
    ("roller", {"motion": {}}, "motion = {}: must be a list"),
    ("roller", {"motion": [5]}, "motion.1 = 5: must be a table"),
    ("roller", {"motion.1.angle": 110}, "motion.angle: the angles add up to 350 deg, not to 360"),
    ("roller", {"motion.4.angle": 90.001}, "motion.angle: the angles add up to 360.001 deg, not to 360"),
    ("roller", {"motion.1.angle": nan}, "motion.1.angle = nan: must be a finite number"),
    ("roller", {"motion.1.lift": 40}, "motion.3.lift = 50.0: must be at most 40: the follower never goes below"),
    ("roller", {"motion.1.lift": 60}, "motion.lift: the follower ends 10 above its start: rises and returns must"),
    ("roller", {"motion.2.lift": 5}, "motion.2.lift = 5: a dwell has none"),
    ("roller", {"motion.2.law": "harmonic"}, "motion.2.law = 'harmonic': a dwell has none"),
    ("roller", {"motion.1.law": DELETED, "search.law": DELETED}, "motion.1.law: missing; a rise or return needs a motion law"),
    ("roller", {"motion": [{"segment": "dwell", "angle": 360}]}, "motion: has no rise"),
    ("roller", {"motion.1.angle": 0, "motion.2.angle": 180}, "motion.1.angle = 0: must be at least 1e-06 in a rise"),
    ("roller", {"motion.1.angle": 1e-9, "motion.2.angle": 180}, "motion.1.angle = 1e-09: must be at least 1e-06 in"),
    ("roller", {"motion.4.angle": 90.000001}, "motion.angle: the angles add up to 360.000001 deg, not to 360"),
    # mechanisms
    ("roller", {"follower.roller_radius": DELETED, "search": DELETED}, "follower.roller_radius: missing; a disc cam"),
    ("roller", {"follower.face_radius": 5}, "follower.face_radius = 5: a disc cam with a translating roller follo"),
    ("roller", {"cam.mean_radius": 50}, "cam.mean_radius = 50: a disc cam with a translating roller follower has"),
    ("roller", {"follower.offset": 55}, "follower.offset = 55.0: must be smaller than the prime radius (55)"),
    ("roller", {"follower.offset": -60}, "follower.offset = -60.0: must be smaller than the prime radius (55)"),
    ("roller", {"cam.shaft_diameter": 101}, "cam.shaft_diameter = 101.0: must be at most twice the base radius (1"),
    (
        "arm",
        {"follower.dynamics.mass": 3},
        "follower.dynamics.mass = 3: a disc cam with an oscillating roller follower has none; it has inertia, ",
    ),
    ("arm", {"follower.offset": 3}, "follower.offset = 3: a disc cam with an oscillating roller follower has none"),
    ("roller", {"follower.roller_diameter": 20}, "follower.roller_diameter = 20: not a known key; give follower.roller_r"),
    (
        "groove",
        {"cam.base_radius": 40},
        "cam.base_radius = 40: a cylindrical cam with an oscillating roller follower has none: its size is "
        "cam.mean_radius",
    ),
    ("arm", {"follower.arm_length": 500}, "follower.arm_length = 500.0: no triangle: the prime radius (50) must l"),
    ("arm", {"motion.1.lift": 170.0, "motion.2.lift": 170.0}, "motion.lift: the arm starts at 22.6199 deg and ris"),
    ("swinging face", {"follower.centre_distance": 25}, "follower.centre_distance = 25.0: must be above the diffe"),
    ("swinging face", {"motion.1.lift": 80, "motion.2.lift": 80}, "motion.lift: the face starts at 18.2"),
    ("groove", {"follower.contact": "flat", "follower.roller_radius": DELETED}, "follower.contact = 'flat': must"),
    ("groove", {"cam.shaft_diameter": 10}, "cam.shaft_diameter = 10: a cylindrical cam with an oscillating roller"),
    ("groove", {"motion.1.lift": 180, "motion.2.lift": 180}, "motion.lift: the arm swings 180 deg; a swing stays"),
    # limits
    ("knife", {"limits.acceleration": 5}, "limits.acceleration = 5: needs cam.rpm"),
    ("roller", {"limits.face_reach": 10}, "limits.face_reach = 10: only a flat face has a reach"),
    # search
    ("roller", {"search.offset": {"start": 9, "stop": 2, "step": 1}}, "search.offset = {'start': 9, 'stop': 2, 's"),
    ("roller", {"search.offset": {"start": 0, "stop": 2, "step": 0}}, "search.offset.step = 0: must be at least 1e-09"),
    ("roller", {"search.offset": {"start": 0, "stop": 2, "step": -1}}, "search.offset.step = -1: must be at least 1e-09"),
    ("roller", {"search.offset": {"start": 0}}, "search.offset.stop: missing"),
    ("roller", {"search.offset": {"start": "a", "stop": 1}}, "search.offset.start = 'a': must be a number"),
    ("roller", {"search.offset": []}, "search.offset = []: must be a list of at least one value"),
    ("roller", {"search.offset": ["a"]}, "search.offset.1 = 'a': must be a number"),
    ("roller", {"search.offset": [0, nan]}, "search.offset.2 = nan: must be a finite number"),
    ("roller", {"search.offset": True}, "search.offset = True: must be a list"),
    ("roller", {"search.base_radius": [-5]}, "search.base_radius = [-5]: must be above 0"),
    ("roller", {"search.base_radius": {"start": 0, "stop": 9}}, "search.base_radius = {'start': 0, 'stop': 9}: mu"),
    ("roller", {"search.law": []}, "search.law = []: must be a list of at least one value"),
    ("roller", {"search.law_rise": ["harmonic"]}, "search.law = ['parabolic', 'harmonic', "),
    ("roller", {"search.arm_length": [50]}, "search.arm_length = [50]: a disc cam with a translating roller follo"),
    ("roller", {"search.mean_radius": [50]}, "search.mean_radius = [50]: a disc cam with a translating roller fol"),
]  # fmt: skip


@pytest.mark.parametrize(("base", "changes", "line"), ONE_MISTAKE)
def test_a_mistake_is_told_by_file_key_value_and_what_is_allowed(base, changes, line):
    (found,) = mistakes(with_values(BASES[base], changes))
    assert found.startswith(f"cam.toml: {line}")
    assert len(found) < 1200


def turn_of_segments(count):
    """A turn of so many segments."""
    pair = [{"segment": kind, "angle": 360.0 / count, "lift": 1.0, "law": "poly345"} for kind in ("rise", "return")]
    return with_values(BASES["roller"], {"motion": pair * (count // 2)})


def test_a_turn_has_a_thousand_segments_at_most():
    """One line, without the ten thousand; so many as are allowed make a scene."""
    assert mistakes(turn_of_segments(10_000)) == ["cam.toml: motion: has 10,000 entries; at most 1,000 are allowed"]
    assert len(Scene.from_dict(turn_of_segments(1_000)).motion) == 1_000


def test_all_mistakes_are_told_at_once():
    wrong = {"cam.rmp": 900, "follower.roller_radius": -5, "motion.1.angle": 110}
    lines = mistakes(with_values(BASES["roller"], wrong))
    assert len(lines) == 3
    assert lines[0].startswith("cam.toml: cam.rmp = 900: not a known key; did you mean rpm?")
    assert lines[1] == "cam.toml: follower.roller_radius = -5: must be at least 1e-09"
    assert lines[2] == "cam.toml: motion.angle: the angles add up to 350 deg, not to 360"


def test_mistakes_are_told_from_another_process():
    told = BadInput(
        [Mistake("a.toml", "cam", 1, "a table"), Mistake("a.toml", "limits", None, "nothing", bare=True)]
    )
    back = pickle.loads(pickle.dumps(told))
    assert back.mistakes == told.mistakes
    assert str(back) == "a.toml: cam = 1: must be a table\na.toml: limits: nothing"


def test_lifts_too_small_to_compute_with_are_told():
    lines = mistakes(with_values(BASES["roller"], {"motion.1.lift": 1e-12, "motion.3.lift": 1e-12}))
    assert lines == [
        f"cam.toml: motion.{n}.lift = 1e-12: must be at least 1e-09 in a rise or return" for n in (1, 3)
    ]


def test_mistakes_in_every_table_are_told_at_once():
    wrong = {
        "name": 3, "cam.form": "disk", "follower.contact": "knfe", "motion.2.segment": "dwel", "limits.jerk": "x",
        "search.offset": {"start": "a", "stpe": 1}, "search.roller_radius": ["a", 5, nan],
        "materials.cam_modulus": -1, "accuracy.relative_error": True, "outputs": ["x"], "zzz": 1,
    }  # fmt: skip
    lines = mistakes(with_values(BASES["roller"], wrong))
    keys = [line.split(": ")[1].split(" = ")[0] for line in lines]
    assert sorted(keys) == sorted([
        "name", "cam.form", "follower.contact", "motion.2.segment", "limits.jerk", "search.offset.start",
        "search.offset.stop", "search.offset.stpe", "search.roller_radius.1", "search.roller_radius.3",
        "materials.cam_modulus", "accuracy.relative_error", "outputs.1", "zzz",
    ])  # fmt: skip


def test_a_segment_that_is_no_table_leaves_the_numbers_of_the_others():
    data = with_values(BASES["roller"], {"motion.3.law": DELETED, "search.law": DELETED})
    data["motion"][0] = 5
    lines = mistakes(data)
    assert lines[0] == "cam.toml: motion.1 = 5: must be a table"
    assert lines[1] == "cam.toml: motion.3.law: missing; a rise or return needs a motion law, here or in [search]"


@pytest.mark.parametrize(
    ("search", "laws"),
    [
        ({"law": ["poly345", "harmonic"]}, ("poly345", "poly345")),
        ({"law": "SHM"}, ("harmonic", "harmonic")),
        ({"law_rise": ["cubic"], "law_return": ["cycloidal", "cubic"]}, ("cubic", "cycloidal")),
    ],
)
def test_a_law_may_be_left_to_those_that_a_search_tries(search, laws):
    data = find_scene("roller-1000rpm").to_dict()
    data["search"] = search
    for row in data["motion"]:
        row.pop("law", None)
    given = [row.law for row in Scene.from_dict(data).motion if row.law]
    kinds = [row["segment"] for row in data["motion"] if row["segment"] != "dwell"]
    assert given == [laws[kind == "return"] for kind in kinds]


def test_a_law_that_a_search_leaves_out_or_misspells_is_one_mistake():
    data = find_scene("roller-1000rpm").to_dict()
    for row in data["motion"]:
        row.pop("law", None)
    (line,) = mistakes({**data, "search": {"law": ["cubc"]}})
    assert line.startswith("cam.toml: search.law.1 = 'cubc': must be a motion law; did you mean cubic?")
    (line,) = mistakes({**data, "search": {"law_rise": "cubic"}})
    assert ".law: missing; a rise or return needs a motion law" in line


def test_a_mistaken_size_makes_no_mistakes_of_others():
    assert len(mistakes(with_values(BASES["roller"], {"cam.base_radius": -50}))) == 1
    assert len(mistakes(with_values(BASES["roller"], {"follower.roller_radius": "5", "follower.offset": 52}))) == 1
    assert len(mistakes(with_values(BASES["arm"], {"follower.arm_length": -1}))) == 1
    assert len(mistakes(with_values(BASES["swinging face"], {"follower.centre_distance": 0}))) == 1


@pytest.mark.parametrize("data", [None, [], 5, "cam", [("cam", 1)]])
def test_a_scene_is_made_from_a_mapping(data):
    (line,) = mistakes(data)
    assert "must be a mapping of tables" in line


def test_keys_that_are_no_texts_are_told():
    lines = mistakes({**with_values(BASES["roller"], {}), 5: 1, None: 2})
    assert [line.split(":")[1] for line in lines] == [" 5 = 1", " None = 2"]
    (line,) = mistakes(with_values(BASES["roller"], {"cam": {**BASES["roller"]["cam"], 7: 1}}))
    assert line.startswith("cam.toml: cam.7 = 1: not a known key")


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"", "cam: missing"),
        (b"# only a comment\n", "cam: missing"),
        (b"[cam\nform = 'disc'", "TOML: not valid: "),
        (b"a = 1\na = 2", "TOML: not valid: "),
        (b"name = '\xff\xfe'", "TOML: not valid: "),
        (b"\xff\xfe[\x00c\x00a\x00m\x00]\x00", "TOML: not valid: "),
        (b"a = " + b"9" * 10_000, "TOML: not valid: "),
        (b"a = " + b"[" * 100_000, "TOML: not valid: "),
        (b"\x00", "TOML: not valid: "),
        (b'{"cam": {"form": "disc"}}', "TOML: not valid: "),
        (b"cam = 3\nfollower = []\nmotion = 'x'\n", "cam = 3: must be a table"),
        (b"name = 1979-05-27", "name = datetime.date(1979, 5, 27): must be a text"),
    ],
)
def test_a_file_that_is_no_scene_is_told_by_its_name(tmp_path, content, line):
    file = tmp_path / "bad.toml"
    file.write_bytes(content)
    with pytest.raises(BadInput) as caught:
        find_scene(str(file))
    lines = str(caught.value).split("\n")
    assert any(each.startswith(f"{file}: {line}") for each in lines), lines
    assert not [word for word in JARGON for each in lines if word in each]


def test_a_file_with_windows_line_ends_or_a_mark_of_byte_order_is_read(tmp_path):
    text = find_scene("two-pauses").to_toml()
    for content in (text.replace("\n", "\r\n").encode(), b"\xef\xbb\xbf" + text.encode()):
        file = tmp_path / "scene.toml"
        file.write_bytes(content)
        assert Scene.from_toml(file) == find_scene("two-pauses")


@pytest.mark.parametrize(
    ("name", "meant"),
    [("roler-1000rpm", "roller-1000rpm"), ("two_pauses", "two-pauses"), ("exhaust", "exhaust-valve"), ("", None)],
)
def test_a_misspelt_scene_gets_the_nearest_name(name, meant):
    with pytest.raises(BadInput) as caught:
        find_scene(name)
    assert (f"did you mean {meant}?" in str(caught.value)) == (meant is not None)
    assert all(shipped in str(caught.value) for shipped in shipped_scenes())


@pytest.mark.parametrize("table", [Cam, StepRange, Segment])
def test_a_table_alone_tells_its_mistakes_too(table):
    with pytest.raises(BadInput) as caught:
        table(self=1, rpm="x", law=5)
    assert not [word for word in JARGON if word in str(caught.value)]
    assert "self = 1: not a known key" in str(caught.value)


# ------------------------------------------------------------------------------------------ anything at all

JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 400),
    st.sampled_from([10**400, -(10**400), 2**63, 1e300, 5e-324, -0.0, 0.0, 1e12, 1e-12, 1e9, 1e-9, nan, inf, -inf]),
    st.floats(-400, 400),
    st.text(max_size=8),
    st.sampled_from(
        ["rise", "dwell", "return", "disc", "cylindrical", "knife", "flat", "spherical", "oscillating"]
    ),
    st.sampled_from(["harmonic", "uniform", "base_radius_mm", "\ud800", "\x00", "range", "values", "self"]),
    st.sampled_from(
        [[], {}, [[]], [{}], {"": 1}, [nan], {"start": 1, "stop": 0}, {"start": 1, "stop": 2}, ["a", 1]]
    ),
)
KEYS = st.sampled_from([
    "name", "cam", "follower", "motion", "limits", "search", "materials", "accuracy", "outputs", "form", "rpm",
    "base_radius", "mean_radius", "offset", "arm_length", "face_offset", "roller_radius", "face_radius", "start",
    "stop", "step", "lift", "angle", "segment", "law_rise", "minimise", "maximise", "dynamics", "self", "", "range",
    "values", "__file__", "jerk", "face_reach", "torque", "shaft_diameter", "centre_distance", "tolerance", "0",
    "a.b", "law", "laws", "degree", "knots", "coefficients", "x", "s", "file",
])  # fmt: skip


def places(value):
    """Every container inside a value."""
    if isinstance(value, (dict, list)):
        yield value
        for each in value.values() if isinstance(value, dict) else value:
            yield from places(each)


@st.composite
def mutate_mapping(draw):
    data = copy.deepcopy(draw(st.sampled_from(list(BASES.values()))))
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.sampled_from(list(places(data))))
        if isinstance(place, dict):
            key = draw(st.one_of(st.sampled_from(sorted(place) or [""]), KEYS))
            if draw(st.booleans()):
                place[key] = copy.deepcopy(draw(JUNK))
            else:
                place.pop(key, None)
        elif place and draw(st.booleans()):
            place.pop(draw(st.integers(0, len(place) - 1)))
        else:
            place.insert(draw(st.integers(0, len(place))), copy.deepcopy(draw(JUNK)))
    return data


@settings(max_examples=times(150, deep=20000))
@given(mutate_mapping())
def test_whatever_is_given_makes_a_scene_or_a_bad_input(data):
    before = copy.deepcopy(data)
    try:
        scene = Scene.from_dict(data, "cam.toml")
    except BadInput:
        mistakes(data)
    else:
        assert Scene.from_dict(scene.to_dict()) == scene
        assert Scene.from_dict(tomllib.loads(scene.to_toml())) == scene
        scene.to_toml().encode("utf-8")
    assert repr(data) == repr(before)


def test_a_former_key_is_read_and_written_under_its_name_of_today():
    old = find_scene("roller-1000rpm").replace(**{"accuracy.tolerance": 1e-7})
    assert old == find_scene("roller-1000rpm").replace(**{"accuracy.relative_error": 1e-7})
    assert "relative_error = 1e-07" in old.to_toml()
    assert "tolerance" not in old.to_toml()
    data = old.to_dict()
    data["accuracy"] = {"tolerance": 1e-7}
    assert Scene.from_dict(data) == old
    data["accuracy"]["relative_error"] = 1e-8
    with pytest.raises(BadInput, match=r"accuracy\.tolerance = 1e-07: is the old name of accuracy\.relative_error"):
        Scene.from_dict(data)


AT_ONCE = """
import sys, threading
from camopt import find_scene
sys.setswitchinterval(1e-6)
begin, names, found = threading.Barrier(8), ["roller-1000rpm", "exhaust-valve"] * 4, []
def find(name):
    begin.wait()
    found.append(find_scene(name))
threads = [threading.Thread(target=find, args=(name,)) for name in names]
[each.start() for each in threads], [each.join() for each in threads]
assert len(found) == len(threads)
"""


def test_threads_may_read_the_first_scenes_at_once():
    """What checks a table is made when it is there first."""
    subprocess.run([sys.executable, "-P", "-c", AT_ONCE], check=True)


def test_a_table_that_pydantic_never_checked_is_written():
    """Tables at their defaults are not checked, so that pydantic has not made them ready when one is changed."""

    class Plate(SceneTable):
        thickness: Length | None = None

    class Machine(SceneTable):
        plate: InnerTable[Plate] = Plate.model_construct()
        plates: tuple[InnerTable[Plate], ...] = ()
        named: dict[str, InnerTable[Plate]] = Field(default_factory=dict)

    thick = Plate.model_construct().model_copy(update={"thickness": 3.25})
    written = {"thickness": 3.25}
    machine = Machine.model_construct(plate=thick, plates=(thick,), named={"a": thick})
    assert machine.model_dump(mode="json", exclude_none=True, exclude_defaults=True) == {
        "plate": written,
        "plates": [written],
        "named": {"a": written},
    }


def test_checks_see_a_scene_without_its_wrong_values_and_quote_what_was_written():
    """A wrong size keeps no other mistake from being told, and none follows from it."""
    data = find_scene("roller-1000rpm").to_dict()
    data["cam"] |= {"shaft_diameter": 400, "base_radius": "wide"}
    data["search"] = {"mean_radius": {"start": 40, "stop": 1e300}, "offset": [1, 2]}
    with pytest.raises(BadInput) as told:
        Scene.from_dict(data)
    assert {mistake.key: mistake.value for mistake in told.value.mistakes} == {
        "cam.base_radius": "wide",
        "search.mean_radius.stop": 1e300,
        "search.mean_radius": {"start": 40, "stop": 1e300},
    }

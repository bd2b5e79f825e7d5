"""What hands type: each mistake is told in one line that names the place and what is meant to be there."""

import io
import json
import os
import tomllib
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.depth import is_deep
from support.fuzzed import KINDS, keys

import camopt
from camopt import BadInput, Scene, evaluate, find_scene, shipped_scenes, sweep
from camopt.cli.main import main
from camopt.core.mistakes import LONGEST_LINE, MOST_SHOWN, shorten
from camopt.scene.problem.problem import resolve_design
from camopt.scene.sources import shipped_toml
from camopt.scene.toml_text import DEEPEST_NESTING, parse_toml
from camopt.scene.unusual_values import missing_wall_notes, unusual_value_notes
from camopt.show.drawing.picture import Picture
from camopt.show.reporting.cams import cam_sentences

TEXT = find_scene("roller-1000rpm").to_toml()
MOVE = {"segment": "move", "angle": 360, "to": 1}
FEW = 9  # a share of the types for each key, in every run


def message_of_scene(text, tmp_path, name="mine.toml"):
    """The one line that a scene file gets."""
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(BadInput) as error:
        Scene.from_toml(path)
    (line,) = str(error.value).splitlines()
    assert line.isprintable()
    assert line.startswith(str(path))
    return line


@pytest.mark.parametrize(
    ("before", "after", "line"),
    [
        ("rpm = 1000.0", "rpm = 1000,5", "'rpm = 1000,5': a number has a decimal point, not a comma"),
        ("rpm = 1000.0", "rpm = 1000 rpm", "'rpm = 1000 rpm': a number with a unit is a text: in quotes"),
        ("rpm = 1000.0", "rpm = 1e3rpm", "a number with a unit is a text: in quotes"),
        ("rpm = 1000.0", "rpm = 30°", "a number with a unit is a text: in quotes"),
        ("rpm = 1000.0", "rpm = .5", "a number has digits on both sides of its decimal point"),
        ("rpm = 1000.0", "rpm = 5. # slow", "a number has digits on both sides of its decimal point"),
        ("rpm = 1000.0", "rpm: 1000", "'rpm: 1000': a key and its value have = between them"),
        ('form = "disc"', "form = disc", "'form = disc': a text is in quotes, and a switch is true or false"),
        ('form = "disc"', "form = “disc”", "'form = “disc”': a text has straight quotes"),
        ('form = "disc"', "form = ‘disc’", "a text has straight quotes"),
        ('form = "disc"', 'form = "disc', "'form = \"disc': a text has no closing quote"),
    ],
)
def test_the_line_that_is_no_toml_is_shown(tmp_path, before, after, line):
    assert before in TEXT
    number = TEXT[: TEXT.index(before)].count("\n") + 1
    found = message_of_scene(TEXT.replace(before, after), tmp_path)
    assert f"TOML: not valid: line {number}, " in found
    assert line in found


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"PK\x03\x04 a workbook", "is an Excel workbook"),
        (b"PAR1 a table", "is a Parquet table"),
        (TEXT.encode("utf-16"), "is text in UTF-16; save it in UTF-8"),
        (b'name = "caf\xe9"', "is not UTF-8 text: line 1 has the byte 0xe9"),
        (b"a = " + b"[" * 100_000, "nested too deep"),
        (b"a." * 5000 + b"a = 1", "nested too deep"),
        (b"a = " + b"9" * 5000, "TOML: not valid: "),
        (b" " * ((1 << 24) + 1), "a file of at most 16 MiB"),
    ],
)
def test_a_file_that_is_no_scene_is_named(tmp_path, content, line):
    path = tmp_path / "mine.toml"
    path.write_bytes(content)
    with pytest.raises(BadInput) as error:
        Scene.from_toml(path)
    assert line in str(error.value)
    assert len(str(error.value)) < 400


def test_keys_and_names_reach_no_terminal_raw(tmp_path):
    bell = '"\\u001b[2J\\nroot" = 1\n'
    assert "\\x1b[2J\\nroot" in message_of_scene(bell + TEXT, tmp_path)
    folder = tmp_path / "a\nb"
    folder.mkdir()
    with pytest.raises(BadInput) as error:
        find_scene(folder / "absent.toml")
    assert str(error.value).isprintable()


@given(text=st.text(max_size=300) | st.binary(max_size=300))
def test_any_text_is_tables_or_a_mistake_in_a_line(text):
    told = ""
    try:
        assert isinstance(parse_toml(text, "mine.toml"), dict)
    except BadInput as error:
        told = str(error)
    assert told.isprintable()


@given(depth=st.integers(0, 3 * DEEPEST_NESTING), key=st.text(min_size=1, max_size=9))
def test_tables_within_tables_are_a_mistake_however_deep(depth, key):
    tables = 1
    for _ in range(depth):
        tables = {key: tables}
    with pytest.raises(BadInput) as error:
        Scene.from_dict(tables if depth else {key: 1})
    assert all(line.isprintable() for line in str(error.value).split("\n"))
    endless = {}
    endless["cam"] = endless
    with pytest.raises(BadInput, match="too deep"):
        Scene.from_dict(endless)


@pytest.mark.slow
def test_a_key_of_any_type_is_told_or_taken():
    """Every key of the schema that a scene of moves with conditions can have, with types that are not its own."""
    text = shipped_toml("indexing-overlap") + "[laws.own]\nlaw = 'cycloidal'\ncrossing = 0.4\n"
    data, told = tomllib.loads(text), 0
    places = keys(data, Random(0))
    for number, (table, key) in enumerate(places):
        before = dict(table)
        for value in KINDS if is_deep() else KINDS[number % FEW :: FEW]:
            table[key] = value
            try:
                Scene.from_dict(data)
            except BadInput:
                told += 1
        table.clear()
        table.update(before)
    assert told > len(places)


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        (
            "motion",
            [{"segment": "move", "angle": 360, "to": 1, "through": 5}],
            "motion.1.through = 5: must be a list",
        ),
        ("laws", {"own": 1}, "laws.own = 1: must be a table"),
        ("laws", {"own": {"law": 1}}, "laws.own.law = 1: must be the name of a motion law"),
    ],
)
def test_what_is_of_another_type_is_one_mistake(key, value, line):
    with pytest.raises(BadInput) as error:
        find_scene("indexing-overlap").replace(**{key: value})
    assert str(error.value) == f"indexing-overlap: {line}"


@pytest.mark.parametrize(
    ("name", "key", "value", "line"),
    [
        ("barrel-traverse", "drive.kind", [], "drive.kind = []: must be one of 'spring', 'groove'"),
        ("barrel-traverse", "drive", [[]], "drive = [[]]: must be a table"),
        ("press-ram-by-four-bar", "train.2.stage", {}, "train.2.stage = {}: must be one of"),
        ("press-ram-by-four-bar", "train", [{"stage": []}], "train.1.stage = []: must be one of"),
        ("two-pauses", "motion.2.segment", [], "motion.2.segment = []: must be one of 'rise'"),
        (
            "rocker-valve",
            "tolerances.follower.roller_radius",
            {"plus": 0.1, "distribution": []},
            "tolerances.follower.roller_radius.distribution = []: must be one of 'normal'",
        ),
        ("rocker-valve", "tolerances.follower.arm_length", 10**400, "arm_length = 1000"),
        ("rocker-valve", "tolerances.phase", 10**400, "tolerances.phase = 1000"),
        ("two-pauses", "cam.rotation", 10**400, "cam.rotation = 1000"),
        ("two-pauses", "laws", {"own": []}, "laws.own = []: must be a table"),
        ("two-pauses", "synthesis.minimise", {"size": []}, "synthesis.minimise.size = []: must be a number"),
    ],
)
def test_a_list_or_an_endless_number_where_a_word_or_a_number_belongs_is_one_mistake(name, key, value, line):
    with pytest.raises(BadInput) as error:
        find_scene(name).replace(**{key: value})
    (said,) = [mistake for mistake in str(error.value).splitlines() if mistake.startswith(f"{name}: {key}")]
    assert line in said


@pytest.mark.parametrize("last", ["crank", "ratio"])
def test_a_tolerance_of_a_stage_that_is_none_is_no_error_of_camopt(last):
    with pytest.raises(BadInput, match=r"train\.1\.stage = 'none': must be one of"):
        find_scene("press-ram-by-four-bar").replace(**{"train.1.stage": "none", f"tolerances.train.1.{last}": 0.1})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"cam.rotation": "a" * 10**6}, "cam.rotation = 'aaa"),
        ({"a" * 10**6: 1}, "aaaa = 1: not a known key"),
        ({"laws": {f"{n}" + "b" * 5000: 1 for n in range(50)}}, "and 30 more mistakes"),
        ({"search.law": ["x"], "laws": {f"{n}" * 900: {"law": "cycloidal"} for n in range(50)}}, "more"),
        ({"outputs": ["x" * 900] * 999}, "and 979 more mistakes"),
        ({"name": ["\n" * 10**6]}, "\\n"),
        ({"limits.velocity": [[0.0] * 10**4] * 10}, "limits.velocity = [[0.0, 0.0"),
    ],
    ids=["value", "key", "mistakes", "names", "repeated", "ends of lines", "lists"],
)
def test_a_message_is_no_longer_than_one_reads(changes, words):
    with pytest.raises(BadInput) as error:
        find_scene("roller-1000rpm").replace(**changes)
    lines = str(error.value).splitlines()
    assert words in str(error.value)
    assert max(map(len, lines)) <= LONGEST_LINE
    assert len(lines) <= MOST_SHOWN + 1
    assert str(error.value).replace("\n", "").isprintable()


@given(text=st.text(max_size=50), most=st.integers(3, 40))
def test_a_long_text_is_cut_in_its_middle(text, most):
    found = shorten(text, most)
    assert len(found) == min(len(text), most)
    start, _, end = (found, "", "") if found == text else found.partition("…")
    assert text.startswith(start)
    assert text.endswith(end)


# ------------------------------------------------------------------------------------------------- names of scenes


def test_a_scene_is_found_by_a_path(tmp_path):
    (tmp_path / "mine.toml").write_text(TEXT, encoding="utf-8")
    assert find_scene(tmp_path / "mine.toml") == find_scene(str(tmp_path / "mine.toml"))
    assert find_scene(Path("two-pauses")) == find_scene("two-pauses")


@pytest.mark.parametrize("name", ["nowhere.toml", "folder/nowhere", Path("nowhere.toml"), "./pauses"])
def test_a_file_that_is_not_there_is_not_answered_by_a_list_of_scenes(name):
    with pytest.raises(BadInput, match="there is no such file") as error:
        find_scene(name)
    assert not [scene for scene in shipped_scenes() if scene in str(error.value)]


def test_other_names_are_refused():
    with pytest.raises(BadInput, match="this is a folder"):
        find_scene(".")
    for name in (None, 5, io.StringIO(TEXT)):
        with pytest.raises(BadInput, match="the path of a TOML file"):
            find_scene(name)
    with pytest.raises(BadInput, match="did you mean two-pauses"):
        find_scene("two_pauses")


def test_a_pipe_is_no_file_of_a_law_or_load(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    scene = find_scene("roller-1000rpm").to_dict()
    for path in (tmp_path / "pipe", tmp_path, "/dev/zero"):
        with pytest.raises(BadInput, match="must be a regular file"):
            Scene.from_dict({**scene, "laws": {"mine": {"file": str(path)}}})


# ------------------------------------------------------------------------------------------------- values


def test_a_negative_speed_is_a_matter_of_rotation():
    with pytest.raises(
        BadInput, match=r"rpm = -100: must be at least 1e-09; set the sense of rotation with cam\.rotation"
    ):
        find_scene("two-pauses").replace(**{"cam.rpm": -100})


def test_a_return_before_the_rise_is_told_as_such():
    scene = find_scene("two-pauses").to_dict()
    turned = [*scene["motion"][2:], *scene["motion"][:2]]
    kinds = [segment["segment"] for segment in turned]
    assert kinds.index("return") < kinds.index("rise")
    with pytest.raises(BadInput, match="the turn starts where the follower is lowest: a rise must come before"):
        Scene.from_dict({**scene, "motion": turned})


@pytest.mark.parametrize("value", [1, 0, "yes", 1.0])
def test_a_switch_is_true_or_false(value):
    with pytest.raises(BadInput, match=r"synthesis\.monotone = .*: must be true or false"):
        find_scene("two-pauses").replace(**{"synthesis.monotone": value})


@pytest.mark.parametrize("keep", ["paretto", "", 5])
def test_what_a_sweep_keeps_is_one_of_three(keep):
    with pytest.raises(BadInput, match=r"a choice of designs;.* known: pareto, feasible, all") as error:
        sweep(find_scene("two-pauses"), keep=keep)
    assert keep != "paretto" or "did you mean pareto?" in str(error.value)


def test_a_space_beyond_what_can_be_counted_is_a_mistake():
    fine = {"start": 1, "stop": 900, "step": 1e-4}
    axes = {f"search.{name}": fine for name in ("base_radius", "offset", "roller_radius")}
    with pytest.raises(BadInput, match=r"must be a space of at most 9\.2e\+18 designs; this one has 5\.1e\+21"):
        sweep(find_scene("roller-1000rpm").replace(**axes))


def test_an_axis_of_a_frontier_is_told_the_nearest_name(capsys, tmp_path):
    for axis, name in (
        ("velocty", "velocity"),
        ("torque", "torque_peak_N_m"),
        ("contact_stres", "contact_stress_max"),
    ):
        assert main(["frontier", "--axes", f"size,{axis}", "--out", str(tmp_path / "out")]) == 2
        assert f"did you mean {name}" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_sizes_that_are_hardly_meant_are_asked_about(capsys, monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    metres = find_scene("two-pauses").replace(
        **{"cam.base_radius": 0.05, "cam.shaft_diameter": None, "cam.rpm": 2e5}
    )
    found = unusual_value_notes(metres)
    assert [sentence.partition(" = ")[0] for sentence in found] == ["cam.rpm", "cam.base_radius"]
    assert found[1] == "cam.base_radius = 0.05 mm: is this what you mean? 0.1 to 10000 mm is usual"
    assert [scene for scene in shipped_scenes() if unusual_value_notes(find_scene(scene))] == []


WALLS = [
    ({"cam.shaft_diameter": 50}, "the wall between bore and base circle is 0 mm"),
    ({"cam.shaft_diameter": 49.9}, ""),
    ({"cam.shaft_diameter": 50, "limits.hub_wall": 1e-9}, ""),
    ({"cam.shaft_diameter": None}, ""),
    ({"cam.shaft_diameter": None, "part.bore": 30, "part.keyway_width": 8, "part.keyway_depth": 9.0}, ""),
]


@pytest.mark.parametrize(("changes", "told"), WALLS)
def test_a_cam_without_a_wall_about_its_bore_is_told_where_none_is_asked(changes, told, tmp_path):
    """Where it is evaluated, and on its page."""
    scene = find_scene("two-pauses").replace(**{"cam.base_radius": 25.0, **changes})
    found = missing_wall_notes(scene)
    assert found == [line for line in unusual_value_notes(scene) if "wall between" in line]
    assert [line.partition(": ")[0] for line in found] == ([told] if told else [])
    assert all("limits.hub_wall" in line for line in found)
    lines = cam_sentences(Picture(scene, resolve_design(scene)))
    assert [line for line in lines if "wall between" in line] == [f"T{line[1:]}." for line in found]


@pytest.mark.parametrize(("bore", "told"), [(30.0, False), (34.0, True)])
def test_a_hub_that_a_keyway_leaves_thin_is_told(bore, told):
    """Of less than 1.5 bores; the wall is from the corner of the keyway to the base circle, or to the hub."""
    part = {"thickness": 10, "bore": bore, "keyway_width": 8, "keyway_depth": 3.3}
    scene = find_scene("two-pauses").replace(**{"cam.base_radius": 25.0, "cam.shaft_diameter": None}, part=part)
    found = [line for line in unusual_value_notes(scene) if "keyed hub" in line]
    wall = 25.0 - ((bore / 2 + 3.3) ** 2 + 16.0) ** 0.5
    assert bool(found) is told
    assert all(f"a wall of {wall:.4g} mm is left" in line and f"{1.8 * bore:.4g} mm" in line for line in found)
    assert not [
        line for line in unusual_value_notes(scene.replace(**{"limits.hub_wall": 2})) if "keyed hub" in line
    ]


@pytest.mark.parametrize(
    ("part", "reach", "what"),
    [
        ({"bore": 90}, 45.0, "bore"),
        ({"bore": 20, "keyway_width": 6, "keyway_depth": 30}, (40.0**2 + 3.0**2) ** 0.5, "keyway"),
    ],
)
def test_a_smallest_cam_held_by_its_bore_or_keyway_is_told_to_have_no_wall(part, reach, what, capsys, tmp_path):
    """A base circle within a bore or keyway is that of no scene."""
    bored = {"part": part, "cam.base_radius": 60, "cam.shaft_diameter": None}
    (tmp_path / "mine.toml").write_text(find_scene("two-pauses").replace(**bored).to_toml())
    assert main(["optimise", str(tmp_path / "mine.toml"), "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["base_radius_mm"] == pytest.approx(reach, rel=1e-8)
    assert json.loads(out)["binding"] == [what]
    assert f"the wall between {what} and base circle is 0 mm" in err


def test_the_smallest_cam_round_its_shaft_is_told_to_have_no_wall(capsys, tmp_path):
    """The smallest cam is as wide as its shaft; with a wall that is asked, nothing is told."""
    for limits, told in (({}, 1), ({"hub_wall": 2}, 0)):
        (tmp_path / "mine.toml").write_text(find_scene("two-pauses").replace(limits=limits).to_toml())
        assert main(["optimise", str(tmp_path / "mine.toml")]) == 0
        assert capsys.readouterr().err.count("hub_wall, the least wall, is not set") == told
    assert main(["evaluate", "two-pauses", "--rpm", "2e5"]) == 0
    assert "camopt: cam.rpm = 200000 rev/min: is this what you mean?" in capsys.readouterr().err
    assert main(["evaluate", "two-pauses", "--rpm", "2e5", "--quiet"]) == 0
    assert "is this what you mean?" not in capsys.readouterr().err


def test_python_names_the_same_things(tmp_path):
    with pytest.raises(BadInput, match="must be a TOML file or a shipped scene; this is a folder"):
        camopt.find_scene(tmp_path)
    with pytest.raises(BadInput, match="must be a regular file, not a folder"):
        camopt.load(tmp_path)


LAWFUL = [name for name in shipped_scenes() if any(segment.law for segment in find_scene(name).motion)]


@pytest.mark.parametrize("name", LAWFUL)
def test_a_law_that_is_not_there_is_told_in_every_turn(name):
    data = find_scene(name).to_dict()
    named = [(k, row) for k, row in enumerate(data.get("motion", ()), start=1) if row.get("law")]
    for _, row in named:
        row["law"] = "cycloydal"
    with pytest.raises(BadInput) as error:
        Scene.from_dict(data)
    assert {f"motion.{k}.law" for k, _ in named} <= {mistake.key for mistake in error.value.mistakes}


def numbers_in(data):
    """All places of a number, as (table, its key there)."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        yield from [(data, key)] if isinstance(value, float | int) else numbers_in(value)


@pytest.mark.one_in(11)
@pytest.mark.parametrize("value", [1e300, -1e300, 5e-324, pytest.param(10**400, id="10**400")])
@pytest.mark.parametrize("name", shipped_scenes())
def test_a_number_of_any_size_is_a_mistake_at_most(name, value):
    data = find_scene(name).to_dict()
    for table, last in numbers_in(data):
        before, table[last] = table[last], value
        told = []
        try:
            found = [*evaluate(Scene.from_dict(data)).values()]
        except BadInput as error:
            found, told = [], str(error).splitlines()
        assert not any(number != number for number in found)
        assert all(line.startswith("scene: ") for line in told)
        assert bool(found) != bool(told)
        table[last] = before

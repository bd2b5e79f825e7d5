"""``camopt check``: each file of a result is whole, or it is said what it is instead; no file is left out."""

import json
import os
import shutil

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support import hostile
from support.depth import times
from support.plain import not_plain

import camopt
from camopt import BadInput, check, find_scene, sweep
from camopt.cli.exits import BAD_INPUT, FILE_TROUBLE
from camopt.cli.main import main
from camopt.front.certified import certify_table
from camopt.storage.manifest import manifest_of
from camopt.storage.records import JOURNAL_MAGIC as JOURNAL
from camopt.storage.sealed import read_table

SEARCH = {"search.offset": [10], "search.roller_radius": [5], "search.law": ["harmonic", "cycloidal"]}
FILES = ("designs.parquet", "manifest.json", "pareto.parquet", "scene.toml")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A result, and one of another run."""
    folder = tmp_path_factory.mktemp("made")
    for name, sizes in (("one", [60, 100]), ("other", [70, 110])):
        sweep(find_scene("roller-1000rpm").replace(**SEARCH, **{"search.base_radius": sizes}), folder / name, "all")
    return folder


@pytest.fixture
def result(made, tmp_path):
    return shutil.copytree(made / "one", tmp_path / "one")


def states(*files):
    return {each.file.name: each.state for each in check(*files)}


WHOLE = dict.fromkeys(FILES, "whole")


def test_a_result_is_whole(result):
    found = check(result)
    assert {each.file.name: each.state for each in found} == WHOLE
    assert all(each.is_whole for each in found)
    rows = {each.file.name: each.rows for each in found if each.rows is not None}
    front = len(camopt.load(result / "pareto.parquet"))
    assert rows == {"designs.parquet": 4, "pareto.parquet": front}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("trials", [120, pytest.param(20_000, marks=pytest.mark.long)], ids=["some", "many"])
def test_a_flipped_bit_in_any_file_is_found(result, name, trials):
    whole = (result / name).read_bytes()
    bits = 8 * len(whole)
    places = {
        *np.linspace(0, bits - 1, min(trials, bits)).astype(int).tolist(),
        *range(32),
        *range(bits - 96, bits),
    }
    for bit in sorted(places):
        (result / name).write_bytes(hostile.flipped(whole, bit))
        (found,) = check(result / name)
        expected = "changed" if name == "scene.toml" else "damaged"
        assert (found.state, found.is_whole) == (expected, False), (bit, found)


@pytest.mark.parametrize("name", FILES)
def test_a_file_cut_short_is_found(result, name):
    whole = (result / name).read_bytes()
    for length in {*np.linspace(0, len(whole) - 1, 60).astype(int).tolist(), *range(16), len(whole) - 1}:
        (result / name).write_bytes(whole[:length])
        assert check(result / name)[0].state != "whole", length


def test_files_that_are_missing_or_of_another_run_are_told(made, result):
    (result / "scene.toml").unlink()
    shutil.copy(made / "other" / "designs.parquet", result)
    assert states(result) == {**WHOLE, "scene.toml": "missing", "designs.parquet": "changed"}
    told = {each.file.name: each.told for each in check(result)}
    assert told["designs.parquet"] == "whole, but not the one that manifest.json names: it is of another run"
    assert told["scene.toml"] == "missing, though manifest.json names it"


def test_a_table_that_is_certified_stays_a_part_of_its_result(made, result):
    before = read_table(result / "designs.parquet")
    assert certify_table(result / "designs.parquet").total() == before.num_rows
    assert states(result) == WHOLE
    assert sorted(os.listdir(result)) == sorted(FILES)
    assert read_table(result / "designs.parquet").drop_columns(["proof"]).equals(before)
    shutil.copy(made / "other" / "manifest.json", result)  # and where the manifest is that of another run
    certify_table(result / "designs.parquet")
    assert states(result)["designs.parquet"] == "whole"
    for text in ("{}", "", '{"camopt": "0.1.0", "results"'):
        (result / "manifest.json").write_text(text, encoding="utf-8")
        certify_table(result / "designs.parquet")
        assert (result / "manifest.json").read_text(encoding="utf-8") == text
        assert states(result)["designs.parquet"] == "whole"


def test_what_nothing_is_known_of_is_not_whole(result, tmp_path):
    (result / "notes.txt").write_text("mine", encoding="utf-8")
    assert states(result) == {**WHOLE, "notes.txt": "unknown"}
    for path in (result / "notes.txt", tmp_path / "empty", os.devnull):
        (tmp_path / "empty").mkdir(exist_ok=True)
        assert main(["check", str(path)]) == BAD_INPUT
    os.mkfifo(tmp_path / "pipe")
    assert states(tmp_path / "pipe") == {"pipe": "unknown"}
    assert [each.state for each in check("a\0b", "x" * 5000)] == ["unknown", "unreadable"]
    with pytest.raises(BadInput, match="at least one file"):
        check()


def test_folders_inside_a_folder_are_checked_and_hidden_ones_are_not(made, result, tmp_path):
    shutil.copytree(made / "other", result / "inner" / "other")
    (result / ".camopt").mkdir()
    (result / ".camopt" / "left").write_text("x", encoding="utf-8")
    (result / "inner" / "again").symlink_to(result)
    found = check(tmp_path)
    assert [each.file.name for each in found] == ["manifest.json", *sorted({*FILES} - {"manifest.json"})] * 2
    assert all(each.is_whole for each in found)
    (result / "inner" / "other" / "pareto.parquet").unlink()
    assert [each.told for each in check(tmp_path) if not each.is_whole] == [
        "missing, though manifest.json names it"
    ]


def test_a_folder_that_cannot_be_read_is_told(result, monkeypatch):
    def refusing(path):
        raise PermissionError(13, "Permission denied", os.fspath(path))

    monkeypatch.setattr("os.scandir", refusing)
    assert [(each.file, each.state) for each in check(result)] == [(result, "unreadable")]


def test_a_table_is_whole_without_a_manifest(result, made):
    (result / "manifest.json").unlink()
    assert states(result) == {"designs.parquet": "whole", "pareto.parquet": "whole", "scene.toml": "unknown"}
    (result / "manifest.json").write_text("{}", encoding="utf-8")
    assert states(result)["manifest.json"] == "unknown"


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    scene = find_scene("roller-1000rpm").replace(**SEARCH, **{"search.base_radius": [60, 100]})
    return camopt.sweep_part(scene, (1, 2), tmp_path_factory.mktemp("part")).file


def test_a_part_of_a_sweep_is_known_wherever_it_is(part, tmp_path):
    whole = part.read_bytes()
    for name in ("part.sweep", "renamed"):
        shutil.copy(part, tmp_path / name)
        assert states(tmp_path / name) == {name: "whole"}
    copy = tmp_path / "part.sweep"
    for bit in {*np.linspace(0, 8 * len(whole) - 1, 300).astype(int).tolist(), *range(0, 8 * 150, 3)}:
        copy.write_bytes(hostile.flipped(whole, bit))
        assert check(copy)[0].state == "damaged", bit
    for length in {*np.linspace(0, len(whole) - 1, 100).astype(int).tolist(), *range(60), len(whole) - 1}:
        copy.write_bytes(whole[:length])
        assert check(copy)[0].state == "damaged", length
    copy.write_bytes(whole + b"\0")
    assert check(copy)[0].told == f"damaged, or cut short, after {len(whole):,} bytes"


def test_a_record_says_how_long_it_is_and_no_memory_is_taken_for_that(part, tmp_path):
    whole = part.read_bytes()
    for place in range(len(JOURNAL), len(JOURNAL) + 8):
        (tmp_path / "long.sweep").write_bytes(hostile.flipped(whole, 8 * place + 7))
        assert check(tmp_path / "long.sweep")[0].told == f"damaged, or cut short, after {len(JOURNAL)} bytes"


def test_all_files_are_checked_after_a_bad_one(result, tmp_path, capsys):
    (result / "pareto.parquet").write_bytes((result / "pareto.parquet").read_bytes()[:-1])
    paths = [tmp_path / "nowhere", result / "pareto.parquet", result / "designs.parquet"]
    assert main(["check", *map(str, paths)]) == FILE_TROUBLE
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(": ")[0] for line in lines] == [str(path) for path in paths]
    assert lines[0].endswith(": no such file")
    assert ": cut short after " in lines[1]
    assert lines[2].endswith(": whole, 4 rows")


def test_the_exit_code_says_the_worst(result, capsys):
    assert main(["check", str(result)]) == 0
    (result / "notes.txt").write_text("mine", encoding="utf-8")
    assert main(["check", str(result)]) == BAD_INPUT
    (result / "scene.toml").write_text("name = 'x'\n", encoding="utf-8")
    assert main(["check", str(result), "--json"]) == FILE_TROUBLE
    out = capsys.readouterr().out
    assert not json.loads(out[out.index("{") :])["whole"]


def test_the_json_document_is_plain(result, monkeypatch):
    found = []
    monkeypatch.setattr("camopt.cli.commands.check_report.print_json", found.append)
    assert main(["check", str(result), "--json"]) == 0
    (document,) = found
    assert not not_plain(document)
    assert document["whole"]
    assert [each["file"] for each in document["files"]] == [
        str(result / name) for name in sorted(FILES, key=lambda n: n != "manifest.json")
    ]


def test_no_hostile_table_is_whole(made, tmp_path):
    """Without a seal, or damaged; one that is rightly sealed by another hand is as that hand wrote it."""
    table, path = read_table(made / "one" / "designs.parquet"), tmp_path / "t.parquet"
    for what, bytes_of in hostile.tables(table):
        path.write_bytes(bytes_of())
        sealed = what.endswith(", sealed")
        assert (check(path)[0].state in ("damaged", "unknown")) != sealed, what


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["camopt", "results", "files", "run", "sha256", "x"]), inner, max_size=4)
    ),
    max_leaves=12,
)


@settings(max_examples=times(60, deep=2000), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(["a.parquet", "a.sweep", "a.toml", "manifest.json"]),
    start=st.sampled_from([b"", b"PAR1", JOURNAL, b'{"camopt": "1", "results": ']),
    content=st.binary(max_size=80) | JSON.map(lambda value: json.dumps(value).encode()),
    end=st.sampled_from([b"", b"}", b"PAR1", b"\x10\0\0\0PAR1"]),
)
def test_what_camopt_did_not_write_is_never_whole(tmp_path, name, start, content, end):
    folder = tmp_path / "any"
    folder.mkdir(exist_ok=True)
    (folder / name).write_bytes(start + content + end)
    assert not [each for each in check(folder, folder / name) if each.is_whole]
    (folder / name).unlink()


def test_a_disk_that_fails_is_told(result, monkeypatch):
    def failing(path):
        raise OSError(5, "Input/output error", os.fspath(path))

    monkeypatch.setattr("camopt.storage.checking.settled_file", failing)
    assert states(result) == {**dict.fromkeys(FILES, "unreadable"), "manifest.json": "whole"}
    assert main(["check", str(result)]) == FILE_TROUBLE


def test_names_with_escapes_are_told_in_a_line(tmp_path, capsys):
    path = tmp_path / "[red]\x1b[31m\nname.parquet"
    path.write_bytes(b"PAR1")
    assert main(["check", str(path)]) == FILE_TROUBLE
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    assert "\x1b" not in out
    assert "[red]" in out


def test_a_manifest_names_each_file_of_a_result(result):
    assert {*manifest_of(result).files} == {*FILES} - {"manifest.json"}
    assert camopt.check is check

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
from support.plain import places_of_objects

import camopt
from camopt import BadInput, check, find_scene, sweep
from camopt.cli.exits import BAD_INPUT, FILE_TROUBLE
from camopt.cli.main import main
from camopt.core.storage.manifest import read_manifest
from camopt.core.storage.tables import read_table
from camopt.solve.front.table_certificate import certify_table

SEARCH = {"search.offset": [10], "search.roller_radius": [5], "search.law": ["harmonic", "cycloidal"]}
FILES = ("designs.parquet", "manifest.json", "pareto.parquet", "scene.toml")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A result, and one of another run."""
    folder = tmp_path_factory.mktemp("made")
    for name, sizes in (("one", [60, 100]), ("other", [70, 110])):
        sweep(
            find_scene("roller-1000rpm").replace(**SEARCH, **{"search.base_radius": sizes}),
            folder / name,
            keep="all",
        )
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


@pytest.mark.slow
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
        (result / name).write_bytes(hostile.flip_bit(whole, bit))
        (found,) = check(result / name)
        expected = "damaged" if name == "manifest.json" else "changed"
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
    assert told["designs.parquet"].startswith("damaged or changed since it was written, or of another run (")
    assert told["scene.toml"] == "missing, though manifest.json names it"


def test_a_table_that_is_certified_stays_a_part_of_its_result(made, result):
    table = result / "designs.parquet"
    before = read_table(table)
    assert certify_table(table).total() == before.num_rows
    assert states(result) == WHOLE
    assert sorted(os.listdir(result)) == [".camopt", *sorted(FILES)]
    assert read_table(table).drop_columns(["proof"]).equals(before)
    shutil.copy(made / "other" / "manifest.json", result)
    with pytest.raises(BadInput, match=r"it differs from the file that manifest\.json names"):
        certify_table(table)
    for text in ("", '{"camopt": "0.1.0", "results"'):
        (result / "manifest.json").write_text(text, encoding="utf-8")
        with pytest.raises(BadInput, match="damaged, or of another version"):
            certify_table(table)
        assert (result / "manifest.json").read_text(encoding="utf-8") == text
    (result / "manifest.json").write_text("{}", encoding="utf-8")  # another program's says nothing of it
    assert certify_table(table).total() == before.num_rows
    assert (result / "manifest.json").read_text(encoding="utf-8") == "{}"


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
    (result / ".camopt").mkdir(exist_ok=True)
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
    def refuse_access(path):
        raise PermissionError(13, "Permission denied", os.fspath(path))

    monkeypatch.setattr("os.scandir", refuse_access)
    assert [(each.file, each.state) for each in check(result)] == [(result, "unreadable")]


def test_nothing_is_known_to_be_whole_without_a_manifest(result):
    (result / "manifest.json").unlink()
    assert states(result) == dict.fromkeys({*FILES} - {"manifest.json"}, "unknown")
    (result / "manifest.json").write_text("{}", encoding="utf-8")
    assert states(result) == dict.fromkeys(FILES, "unknown")


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    scene = find_scene("roller-1000rpm").replace(**SEARCH, **{"search.base_radius": [60, 100]})
    return camopt.sweep_part(scene, (1, 2), out=tmp_path_factory.mktemp("part")).folder


def test_a_part_of_a_sweep_is_checked_by_its_manifest(part, tmp_path):
    copy = shutil.copytree(part, tmp_path / "renamed")
    assert {*states(copy).values()} == {"whole"}
    for file in copy.iterdir():
        if file.is_file():
            whole = file.read_bytes()
            for bit in {*np.linspace(0, 8 * len(whole) - 1, 100).astype(int).tolist()}:
                file.write_bytes(hostile.flip_bit(whole, bit))
                assert check(file)[0].state in ("changed", "damaged"), (file.name, bit)
            for length in {*np.linspace(0, len(whole) - 1, 30).astype(int).tolist(), len(whole) - 1}:
                file.write_bytes(whole[:length])
                assert check(file)[0].state in ("changed", "damaged"), (file.name, length)
            file.write_bytes(whole)


def test_all_files_are_checked_after_a_bad_one(result, tmp_path, capsys):
    (result / "pareto.parquet").write_bytes((result / "pareto.parquet").read_bytes()[:-1])
    paths = [tmp_path / "nowhere", result / "pareto.parquet", result / "designs.parquet"]
    assert main(["check", *map(str, paths)]) == FILE_TROUBLE
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(": ")[0] for line in lines] == [str(path) for path in paths]
    assert lines[0].endswith(": no such file")
    assert ": damaged or changed since it was written, or of another run (" in lines[1]
    assert lines[2].endswith(": whole, 4 rows")


def test_the_exit_code_says_the_worst(result, capsys):
    assert main(["check", str(result)]) == 0
    (result / "notes.txt").write_text("mine", encoding="utf-8")
    assert main(["check", str(result)]) == BAD_INPUT
    (result / "scene.toml").write_text("name = 'x'\n", encoding="utf-8")
    assert main(["check", str(result), "--json"]) == FILE_TROUBLE
    out = capsys.readouterr().out
    assert not json.loads(out[out.index("{") :])["whole"]


def test_the_json_document_is_plain(result):
    document = check(result).to_dict()
    assert not places_of_objects(document)
    assert document["whole"]
    assert [each["file"] for each in document["files"]] == [
        str(result / name) for name in sorted(FILES, key=lambda n: n != "manifest.json")
    ]


@pytest.mark.slow
def test_no_hostile_table_is_the_one_that_the_manifest_names(made, result):
    path = result / "designs.parquet"
    table, whole = read_table(path), path.read_bytes()
    for what, bytes_of in hostile.tables(table):
        if (data := bytes_of()) != whole:
            path.write_bytes(data)
            assert check(path)[0].state == "changed", what


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["camopt", "results", "files", "run", "sha256", "x"]), inner, max_size=4)
    ),
    max_leaves=12,
)


@settings(max_examples=times(30, deep=2000), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(["a.parquet", "a.toml", "manifest.json"]),
    start=st.sampled_from([b"", b"PAR1", b'{"camopt": "1", "results": ']),
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
    def fail_to_read(path):
        raise OSError(5, "Input/output error", os.fspath(path))

    monkeypatch.setattr("camopt.solve.tables.file_checks.open_regular_file", fail_to_read)
    assert states(result) == {**dict.fromkeys(FILES, "unreadable"), "manifest.json": "whole"}
    assert main(["check", str(result)]) == FILE_TROUBLE


def test_names_with_escapes_are_told_in_a_line(tmp_path, capsys):
    path = tmp_path / "[red]\x1b[31m\nname.parquet"
    path.write_bytes(b"PAR1")
    assert main(["check", str(path)]) == BAD_INPUT
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    assert "\x1b" not in out
    assert "[red]" in out


def test_a_manifest_names_each_file_of_a_result(result):
    assert {*read_manifest(result).files} == {*FILES} - {"manifest.json"}
    assert camopt.check is check

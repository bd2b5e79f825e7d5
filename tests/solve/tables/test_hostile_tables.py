"""Tables that camopt did not write: each is refused in one line, or certified; no traceback, nothing by halves."""

import os
from itertools import islice

import pandas as pd
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support import hostile
from support.depth import times

import camopt
from camopt import BadInput, Scene, find_scene, sweep
from camopt.cli.exits import BAD_INPUT, FILE_TROUBLE, INTERNAL_ERROR
from camopt.cli.main import main
from camopt.core.storage.publishing import publication
from camopt.core.storage.tables import read_table, write_table
from camopt.solve.front.table_certificate import certify_table

CHANGES = {
    "search.base_radius": [60, 100],
    "search.offset": [10],
    "search.roller_radius": [5],
    "search.law": ["harmonic", "cycloidal"],
    "limits": {"pressure_angle": 30},
}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    folder = tmp_path_factory.mktemp("table")
    sweep(find_scene("roller-1000rpm").replace(**CHANGES), folder, keep="all")
    return read_table(folder / "designs.parquet")


@pytest.fixture
def certified(tmp_path, capsys):
    """Certify the bytes of a table: exit code, what is told, and whether the file stayed as it was."""

    def call(data):
        path = tmp_path / "t.parquet"
        path.write_bytes(data)
        code = main(["certify", str(path), "--quiet"])
        told = capsys.readouterr().err.strip()
        try:
            assert isinstance(camopt.load(path), pd.DataFrame)
        except (BadInput, OSError):
            assert code in (BAD_INPUT, FILE_TROUBLE)
        return code, told, path.read_bytes() == data

    return call


@pytest.mark.slow
def test_a_hostile_table_is_refused_in_a_line(table, certified):
    """Those that are certified hold only what a design of the scene may be."""
    tried = 0
    for what, made in islice(hostile.tables(table), 0, None, times(4, deep=1)):
        code, told, same = certified(made())
        tried += 1
        assert code != INTERNAL_ERROR, (what, told)
        assert "\n" not in told, (what, told)
        assert same == (code in (BAD_INPUT, FILE_TROUBLE)), what
        if what in NO_DESIGNS or (" as " in what and not what.endswith("as string")):
            assert code == BAD_INPUT, what
    assert tried >= times(75, deep=300)


@pytest.mark.parametrize("name", ["offset_mm", "roller_radius_mm", "base_radius_mm", "law_rise"])
def test_a_table_without_a_size_or_law_is_not_given_the_scene_s(table, certified, name):
    code, told, same = certified(hostile.in_bytes(table.drop_columns([name])))
    assert (code, same) == (BAD_INPUT, True)
    assert name in told


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("offset_mm", float("nan")),
        ("base_radius_mm", -1.0),
        ("law_rise", "no-law"),
    ],
)
def test_a_row_that_is_no_design_is_refused(table, certified, name, value):
    code, told, same = certified(hostile.in_bytes(hostile.replace_first_value(table, name, value)))
    assert (code, same) == (BAD_INPUT, True)
    assert told.startswith("camopt: table = ")


@pytest.fixture(scope="module")
def published(table, tmp_path_factory):
    """A table in a folder with its manifest."""
    folder = tmp_path_factory.mktemp("published")
    with publication(folder, "sweep", ("t.parquet",)) as unit:
        write_table(table, unit.staged_path("t.parquet"))
    return folder / "t.parquet"


@settings(max_examples=times(30, deep=600))
@given(data=st.data())
def test_a_damaged_table_never_says_anything_else(table, published, data):
    """Flipped bits and cuts: each is found by the manifest."""
    whole = damaged = published.read_bytes()
    for bit in data.draw(st.lists(st.integers(0, 8 * len(whole) - 1), max_size=3)):
        damaged = hostile.flip_bit(damaged, bit)
    damaged = damaged[: data.draw(st.integers(0, len(whole)) | st.just(len(whole)))]
    published.write_bytes(damaged)
    try:
        if damaged == whole:
            assert read_table(published).equals(table)
        else:
            with pytest.raises(BadInput, match=r"it differs from the file that manifest\.json names"):
                read_table(published)
    finally:
        published.write_bytes(whole)


@settings(max_examples=times(30, deep=600), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.binary(max_size=200), framed=st.booleans())
def test_what_is_no_table_is_refused(tmp_path, content, framed):
    path = tmp_path / "t.parquet"
    path.write_bytes(b"PAR1" + content + b"PAR1" if framed else content)
    for call in (camopt.load, certify_table):
        with pytest.raises(BadInput, match="a Parquet table that camopt wrote"):
            call(path)


def test_pipes_devices_and_folders_are_no_tables(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, "/dev/zero", "a\0b"):
        with pytest.raises(BadInput, match="must be a regular file"):
            camopt.load(path)
        with pytest.raises(BadInput, match="must be a regular file"):
            certify_table(path)
    with pytest.raises(FileNotFoundError, match=r"absent\.parquet"):
        camopt.load(tmp_path / "absent.parquet")


def test_addresses_are_files_that_are_not_there(capsys):
    assert main(["certify", "s3://bucket/table.parquet"]) == FILE_TROUBLE
    assert capsys.readouterr().err == "camopt: s3://bucket/table.parquet: No such file or directory\n"


def test_a_scene_in_a_table_names_no_files(table, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for key, where in (("laws.mine", "laws.mine.file"), ("follower.dynamics", "follower.dynamics.load")):
        text = table.schema.metadata[b"camopt_scene"].decode()
        named = f'\n[{key}]\n{where.rpartition(".")[2]} = "{tmp_path}/pipe"\n'
        with pytest.raises(BadInput, match="cannot name files"):
            Scene.embedded(text + named, "t.parquet")
        odd = hostile.with_metadata(table, b"camopt_scene", (text + named).encode())
        (tmp_path / "t.parquet").write_bytes(hostile.in_bytes(odd))
        with pytest.raises(BadInput, match="cannot name files"):
            certify_table(tmp_path / "t.parquet")


def test_a_scene_with_files_is_whole_in_its_table(tmp_path):
    (tmp_path / "lift.csv").write_text("x,s\n0,0\n0.2,0.1\n0.5,0.5\n0.8,0.9\n1,1\n", encoding="utf-8")
    scene = find_scene("roller-1000rpm").replace(**CHANGES).to_dict()
    scene["laws"] = {"mine": {"file": str(tmp_path / "lift.csv")}}
    scene["search"]["law"] = ["mine"]
    sweep(Scene.from_dict(scene), tmp_path / "out", keep="all")
    (tmp_path / "lift.csv").unlink()
    assert certify_table(tmp_path / "out" / "designs.parquet").total() == 2


def test_a_table_whose_rows_were_chosen_is_certified(table, tmp_path):
    write_table(table.slice(1, 2), tmp_path / "t.parquet")
    assert certify_table(tmp_path / "t.parquet").total() == 2
    assert certify_table(tmp_path / "t.parquet").total() == 2  # with its column of proofs
    assert camopt.load(tmp_path / "t.parquet")["proof"].isin({"held", "broken"}).all()
    assert read_table(tmp_path / "t.parquet").schema.field("proof").type == pa.string()


def test_an_odd_table_has_no_page_and_its_rows_are_no_cams(table, tmp_path, capsys):
    """With columns or metadata that no command writes: one line names the file."""
    odd = {what: change for what, change in hostile.changes(table) if what in ODD}
    fronts, counts = ("1", "[]", '"x"', "{}", '{"points": "x"}'), ("1", "[]", "{}", '{"designs": null}')
    odd |= {f"a front of {text}": with_text(b"camopt_front", text) for text in fronts}
    odd |= {f"counts of {text}": with_text(b"camopt_sweep", text) for text in counts}
    path, page = tmp_path / "t.parquet", tmp_path / "page.html"
    for what, change in odd.items():
        path.write_bytes(hostile.in_bytes(change(table)))
        assert main(["report", str(path), "--out", str(page), "--quiet"]) == BAD_INPUT, what
        (told,) = capsys.readouterr().err.splitlines()
        assert str(path) in told or path.name in told, (what, told)
        assert not page.exists(), what
        if what.startswith(("a front", "counts", "a column")):
            assert main(["evaluate", str(path), "--row", "0", "--quiet"]) == BAD_INPUT, what
            assert str(path) in capsys.readouterr().err
    assert len(odd) == len(ODD) + 9


NO_DESIGNS = [f"without {name}" for name in ("base_radius_mm", "roller_radius_mm", "law_rise", "law_return")]
ODD = ("without law_rise", "without law_return", "a column twice", "a front of NaN", "counts of NaN", "no rows")


def with_text(key, text):
    return lambda table: hostile.with_metadata(table, key, text.encode())

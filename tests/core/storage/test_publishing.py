"""Results of several files: published as one, by one run at a time, with nothing left over."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from errno import EBADF, EINVAL, EIO, ENOSPC, ENOTSUP
from hashlib import sha256
from pathlib import Path
from unittest.mock import patch

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support import hostile
from support.depth import times

from camopt import BadInput
from camopt.cli.exits import BAD_INPUT
from camopt.cli.main import main
from camopt.core.storage.files import WORK_FOLDER, write_text
from camopt.core.storage.manifest import (
    MANIFEST,
    DamagedManifest,
    open_checked_result_file,
    read_manifest,
)
from camopt.core.storage.publishing import (
    finish_interrupted_publication,
    path_to_revise_file,
    publication,
    published_answer_to_same_question,
)
from camopt.core.storage.tables import write_table

MAY_WRITE = ("a.txt", "b.txt", "c.txt")


def publish(folder, texts, command="sweep", may_write=MAY_WRITE, then=lambda unit: None):
    with publication(folder, command, may_write) as unit:
        for name, text in texts.items():
            write_text(unit.staged_path(name), text)
        then(unit)


def fail_to_write(unit):
    raise RuntimeError("no result")


def file_texts(folder):
    """What a reader sees: the text of each file of the folder, by name."""
    return {path.name: path.read_text() for path in folder.iterdir() if path.name not in (MANIFEST, WORK_FOLDER)}


def names(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != WORK_FOLDER)


def test_files_get_their_names_and_the_manifest_names_them(tmp_path):
    publish(tmp_path / "out", {"a.txt": "one", "b.txt": "two"})
    assert names(tmp_path / "out") == ["a.txt", "b.txt", MANIFEST]
    files = read_manifest(tmp_path / "out").results["sweep"].files
    assert {name: (fact.sha256, fact.bytes) for name, fact in files.items()} == {
        name: (sha256(text.encode()).hexdigest(), 3) for name, text in (("a.txt", "one"), ("b.txt", "two"))
    }


def test_a_result_replaces_the_earlier_one_as_a_whole(tmp_path):
    publish(tmp_path, {"a.txt": "1", "b.txt": "1"})
    publish(tmp_path, {"b.txt": "2", "c.txt": "2"})
    assert file_texts(tmp_path) == {"b.txt": "2", "c.txt": "2"}
    publish(tmp_path, {})
    assert file_texts(tmp_path) == {}
    assert read_manifest(tmp_path).results["sweep"].files == {}


def own_table(path):
    """A table of the user."""
    pq.write_table(pa.table({"x": [1.0]}), path)


def rewrite_table(path):
    write_table(pa.table({"x": [1.0]}), path)
    pq.write_table(pq.read_table(path), path)


def flip_bit(path):
    write_table(pa.table({"x": [1.0]}), path)
    path.write_bytes(hostile.flip_bit(path.read_bytes(), 8 * 200))


TABLES = ("a.parquet", "b.parquet")
FOREIGN = {
    "text": lambda path: path.write_text("precious, and longer than the end of any table"),
    "a word": lambda path: path.write_text("mine"),
    "nothing": lambda path: path.write_text(""),
    "a table": own_table,
    "a table of camopt's, changed and saved by another program": rewrite_table,
    "a table of camopt's, damaged": flip_bit,
}


@pytest.mark.parametrize("of_a_run", [False, True], ids=["no manifest", "a manifest"])
@pytest.mark.parametrize("kind", FOREIGN)
def test_files_of_the_user_are_neither_replaced_nor_removed(tmp_path, kind, of_a_run):
    if of_a_run:
        publish(tmp_path, {"b.parquet": "1"}, may_write=TABLES)
    FOREIGN[kind](tmp_path / "a.parquet")
    before = {name: (tmp_path / name).read_bytes() for name in names(tmp_path)}
    with pytest.raises(BadInput, match=r"a\.parquet.* no manifest names"), publication(tmp_path, "sweep", TABLES):
        raise AssertionError("nothing is worked at before")
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before
    for text in "23":
        with publication(tmp_path, "sweep", ("b.parquet",)) as unit:
            write_text(unit.staged_path("b.parquet"), text)
        assert (tmp_path / "a.parquet").read_bytes() == before["a.parquet"]
        assert (tmp_path / "b.parquet").read_text() == text


def test_a_text_that_was_edited_is_neither_replaced_nor_removed(tmp_path):
    publish(tmp_path, {"cam-1.txt": "1"}, may_write=("cam-*.txt",))
    (tmp_path / "cam-1.txt").write_text("edited")
    for may_write in (MAY_WRITE, ("cam-*.txt",)):
        with pytest.raises(BadInput, match=r"cam-1\.txt.* edited"), publication(tmp_path, "sweep", may_write):
            raise AssertionError("nothing is worked at before")
    (tmp_path / "cam-1.txt").rename(tmp_path / "cam-mine.txt")
    publish(tmp_path, {"cam-2.txt": "2"}, may_write=("cam-*.txt",))
    assert file_texts(tmp_path) == {"cam-2.txt": "2", "cam-mine.txt": "edited"}
    with pytest.raises(BadInput, match=r"cam-mine\.txt.* no manifest names"):
        publish(tmp_path, {"cam-mine.txt": "3"}, may_write=("cam-*.txt",))
    assert file_texts(tmp_path) == {"cam-2.txt": "2", "cam-mine.txt": "edited"}


def test_a_file_that_is_edited_during_the_work_is_not_replaced_and_the_work_is_kept(tmp_path):
    def edit(unit):
        (tmp_path / "a.txt").write_text("edited")

    publish(tmp_path, {"a.txt": "1"})
    with pytest.raises(BadInput, match="edited"):
        publish(tmp_path, {"a.txt": "2"}, then=edit)
    assert file_texts(tmp_path) == {"a.txt": "edited"}


def test_a_damaged_table_is_replaced(tmp_path):
    publish(tmp_path, {"a.parquet": "1"}, may_write=TABLES)
    (tmp_path / "a.parquet").write_text("")
    publish(tmp_path, {"a.parquet": "2"}, may_write=TABLES)
    assert file_texts(tmp_path) == {"a.parquet": "2"}


def test_a_sweep_leaves_tables_of_the_user_alone(tmp_path, capsys):
    """One that it would not write stays; one that it would is told before the work."""
    asked = "--law cycloidal --base-radius 60:80:10 --offset 0 --roller-radius 20 --quiet"
    command = ["sweep", *asked.split(), "--out", str(tmp_path)]
    own = tmp_path / "pareto-grid.parquet"
    own.write_text("precious")
    for _ in range(2):
        assert main(command) == 0
        assert own.read_text() == "precious"
    capsys.readouterr()
    assert main([*command, "--refine"]) == BAD_INPUT
    assert capsys.readouterr().err == (
        f"camopt: --out = {str(own)!r}: no manifest names this as a file of camopt, and it would be replaced; "
        "choose another folder, or move the file\n"
    )
    assert names(tmp_path) == ["designs.parquet", MANIFEST, "pareto-grid.parquet", "pareto.parquet", "scene.toml"]


def test_names_by_pattern_go_only_if_an_earlier_result_had_them(tmp_path):
    (tmp_path / "cam-mine.txt").write_text("mine")
    publish(tmp_path, {"cam-1.txt": "1"}, may_write=("cam-*.txt",))
    publish(tmp_path, {"cam-2.txt": "2"}, may_write=("cam-*.txt",))
    assert file_texts(tmp_path) == {"cam-2.txt": "2", "cam-mine.txt": "mine"}


def test_results_of_other_commands_stay(tmp_path):
    publish(tmp_path, {"a.txt": "1", "c.txt": "1"})
    publish(tmp_path, {"d.txt": "2", "c.txt": "2"}, "frontier", ("c.txt", "d.txt"))
    assert file_texts(tmp_path) == {"a.txt": "1", "c.txt": "2", "d.txt": "2"}
    assert {c: [*r.files] for c, r in read_manifest(tmp_path).results.items()} == {
        "sweep": ["a.txt"],
        "frontier": ["c.txt", "d.txt"],
    }
    publish(tmp_path, {"a.txt": "3"})
    assert file_texts(tmp_path) == {"a.txt": "3", "c.txt": "2", "d.txt": "2"}


def test_a_run_that_fails_leaves_the_earlier_result_and_nothing_else(tmp_path):
    for old in ({}, {"a.txt": "1"}):
        folder = tmp_path / f"out-{len(old)}"
        if old:
            publish(folder, old)
        before = names(folder) if old else None
        with pytest.raises(RuntimeError, match="no result"):
            publish(folder, {"a.txt": "2"}, then=fail_to_write)
        assert (names(folder) if folder.exists() else None) == before
        assert not old or file_texts(folder) == old


def test_the_same_files_have_the_same_manifest(tmp_path):
    texts = {"a.txt": "1", "b.txt": "2"}
    publish(tmp_path / "one", texts)
    publish(tmp_path / "two", {"c.txt": "1"})
    publish(tmp_path / "two", texts)
    assert (tmp_path / "one" / MANIFEST).read_bytes() == (tmp_path / "two" / MANIFEST).read_bytes()


def test_a_run_with_nothing_leaves_no_folder(tmp_path):
    publish(tmp_path / "deep" / "out", {})
    assert names(tmp_path) == []


def test_the_second_of_two_runs_is_told_of_the_first(tmp_path):
    with publication(tmp_path, "sweep", MAY_WRITE):
        with pytest.raises(BlockingIOError, match="another run writes to this folder") as caught:
            publish(tmp_path, {"a.txt": "2"})
        assert caught.value.filename == str(tmp_path)
    publish(tmp_path, {"a.txt": "3"})
    assert file_texts(tmp_path) == {"a.txt": "3"}


DIES = """
import os, sys
from pathlib import Path
from camopt.core.storage.publishing import publication
with publication(sys.argv[1], "sweep", ("a.txt",), kept_patterns=("blocks-*",)) as unit:
    unit.staged_path("a.txt").write_text("lost")
    (unit.staging / "blocks-1").write_text("kept")
    os._exit(9)
"""


def test_files_of_a_dead_run_go_but_not_its_finished_work(tmp_path):
    assert subprocess.run([sys.executable, "-c", DIES, str(tmp_path)], check=False).returncode == 9
    publish(tmp_path, {"d.txt": "1"}, "frontier", ("d.txt",))
    with publication(tmp_path, "sweep", MAY_WRITE, kept_patterns=("blocks-*",)) as unit:
        assert {each.name: each.read_text() for each in unit.staging.iterdir()} == {"blocks-1": "kept"}
        write_text(unit.staged_path("a.txt"), "2")
    assert (names(tmp_path), file_texts(tmp_path)) == (["a.txt", "d.txt", MANIFEST], {"a.txt": "2", "d.txt": "1"})


def test_new_files_have_the_mode_that_the_user_wants(tmp_path):
    old = os.umask(0o027)
    try:
        publish(tmp_path, {"a.txt": "1"})
        write_text(tmp_path / "single.txt", "1")
    finally:
        os.umask(old)
    assert {path.stat().st_mode & 0o777 for path in tmp_path.glob("*.txt")} == {0o640}


def test_the_manifest_of_another_program_is_never_replaced(tmp_path):
    (tmp_path / MANIFEST).write_text('{"name": "a web page"}')
    with pytest.raises(BadInput, match="another program's"):
        publish(tmp_path, {"a.txt": "1"})
    assert names(tmp_path) == [MANIFEST]


def test_a_damaged_manifest_is_told_and_replaced(tmp_path):
    publish(tmp_path, {"a.txt": "1"})
    whole = (tmp_path / MANIFEST).read_text()
    for damaged in (whole.replace("a.txt", "b.txt"), whole[:-9], whole.replace('"bytes": 1', '"bytes": 2')):
        (tmp_path / MANIFEST).write_text(damaged)
        with pytest.raises(DamagedManifest, match="damaged"):
            read_manifest(tmp_path)
        with pytest.raises(BadInput, match="no manifest names"):  # what is there may be anyone's
            publish(tmp_path, {"a.txt": "1"})


def test_a_manifest_that_is_no_json_is_damaged_wherever_it_is_cut(tmp_path):
    publish(tmp_path, {"a.txt": "1"})
    whole = (tmp_path / MANIFEST).read_bytes()
    for damaged in (*(whole[:length] for length in range(len(whole))), bytes(len(whole)), b"\xff" * 9):
        (tmp_path / MANIFEST).write_bytes(damaged)
        with pytest.raises(DamagedManifest, match="damaged"):
            read_manifest(tmp_path)


@pytest.mark.parametrize("text", ["null", "[]", "{}", '{"camopt": 1}', "[" * 100_000])
def test_json_that_camopt_did_not_write_is_of_another_program(tmp_path, text):
    (tmp_path / MANIFEST).write_text(text)
    assert read_manifest(tmp_path) is None
    with pytest.raises(BadInput, match="another program's"):
        publish(tmp_path, {"a.txt": "1"})


def test_what_is_no_folder_is_told_so(tmp_path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for name in ("file", "link", "link/deeper"):
        with pytest.raises(OSError, match="neither a folder") as caught:
            publish(tmp_path / name, {"a.txt": "1"})
        assert caught.value.filename == str(tmp_path / name.split("/")[0])
    assert names(tmp_path) == ["file", "link"]
    assert (tmp_path / "file").read_text() == "mine"


def test_no_folder_is_not_the_current_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match="empty"):
        publish("", {"a.txt": "1"})
    assert names(tmp_path) == []


@pytest.mark.parametrize("name", ["../a.txt", "/etc/passwd", ".", "..", "a\\b", ".camopt", ""])
def test_a_manifest_names_no_files_elsewhere(tmp_path, name):
    publish(tmp_path, {"a.txt": "1"})
    about = json.loads((tmp_path / MANIFEST).read_text())
    del about["digest"]
    about["results"]["sweep"]["files"] = {name: {"sha256": "0" * 64, "bytes": 1}}
    digest = sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
    (tmp_path / MANIFEST).write_text(json.dumps({**about, "digest": digest}))
    with pytest.raises(DamagedManifest, match="this one is damaged"):
        read_manifest(tmp_path)


def test_an_odd_work_folder_is_not_emptied(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").write_text("mine")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / WORK_FOLDER).symlink_to(tmp_path / "mine")
    with pytest.raises(NotADirectoryError, match=WORK_FOLDER):
        publish(tmp_path / "out", {"a.txt": "1"})
    assert names(tmp_path / "mine") == ["file"]


def test_trouble_names_the_file_of_the_result(tmp_path):
    (tmp_path / "a.txt").mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        publish(tmp_path, {"a.txt": "1"})
    assert caught.value.filename == str(tmp_path / "a.txt")
    assert names(tmp_path) == ["a.txt"]
    with pytest.raises(FileNotFoundError) as caught:
        publish(
            tmp_path, {}, then=lambda unit: write_text(unit.staged_path("b.txt").with_name("none") / "b.txt", "1")
        )
    assert caught.value.filename == str(tmp_path / "b.txt")


@pytest.mark.parametrize("place", ["pipe", "device"])
def test_a_file_replaces_no_pipe_and_no_device(tmp_path, place):
    path = tmp_path / place
    if place == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/null")
    with pytest.raises(OSError, match="Invalid argument"):
        write_text(path, "1")
    assert names(tmp_path) == [place]
    assert Path("/dev/null").is_char_device()


def test_a_file_is_written_anew_as_a_part_of_the_result_that_has_it(tmp_path):
    publish(tmp_path, {"a.txt": "1", "b.txt": "1"})
    with publication(tmp_path, "sweep", MAY_WRITE, revises=True):
        publish_in_vain = path_to_revise_file(tmp_path / "a.txt")
        with pytest.raises(BlockingIOError, match="another run writes to this folder"):
            publish_in_vain.__enter__()
    with path_to_revise_file(tmp_path / "a.txt") as place:
        write_text(place, "22")
    assert file_texts(tmp_path) == {"a.txt": "22", "b.txt": "1"}
    assert {name: fact.bytes for name, fact in read_manifest(tmp_path).results["sweep"].files.items()} == {
        "a.txt": 2,
        "b.txt": 1,
    }
    with path_to_revise_file(tmp_path / "other.txt") as place:
        write_text(place, "3")
    assert file_texts(tmp_path) == {"a.txt": "22", "b.txt": "1", "other.txt": "3"}


def test_a_folder_that_may_not_be_read_is_written_to(tmp_path):
    with patch("os.open", side_effect=PermissionError):  # of what would be synced
        write_text(tmp_path / "a.txt", "1")
    assert names(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("trouble", [EINVAL, EBADF, ENOTSUP])
def test_a_disk_that_cannot_sync_takes_results(tmp_path, trouble):
    with patch("os.fsync", side_effect=OSError(trouble, "no")):
        publish(tmp_path, {"a.txt": "1"})
    assert file_texts(tmp_path) == {"a.txt": "1"}


@pytest.mark.parametrize("trouble", [EIO, ENOSPC])
def test_a_disk_that_fails_to_sync_takes_none(tmp_path, trouble):
    publish(tmp_path, {"a.txt": "1"})
    with pytest.raises(OSError, match="no") as caught, patch("os.fsync", side_effect=OSError(trouble, "no")):
        publish(tmp_path, {"a.txt": "2"})
    assert (caught.value.errno, caught.value.filename) == (trouble, str(tmp_path / "a.txt"))
    assert file_texts(tmp_path) == {"a.txt": "1"}


def test_runs_at_the_same_time_do_not_disturb_each_other(tmp_path):
    def run(number):
        with suppress(BlockingIOError):
            publish(tmp_path, {"a.txt": str(number), "b.txt": str(number)})

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(run, range(times(50, 1000))))
    assert names(tmp_path) == ["a.txt", "b.txt", MANIFEST]
    assert len({*file_texts(tmp_path).values()}) == 1


def test_trouble_after_a_result_is_published_is_told_and_the_command_has_succeeded(tmp_path, capsys):
    """The folder fails to sync from the moment on at which the new manifest is there."""
    sync = os.fsync

    def fails(descriptor):
        if (tmp_path / "out" / MANIFEST).exists():
            raise OSError(EIO, "Input/output error")
        sync(descriptor)

    asked = "--law cycloidal --base-radius 60:80:10 --offset 0 --roller-radius 20 --quiet"
    with patch("os.fsync", fails):
        assert main(["sweep", *asked.split(), "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().err == f"camopt: {tmp_path / 'out'}: published; tidying failed: Input/output error\n"
    assert names(tmp_path / "out") == ["designs.parquet", MANIFEST, "pareto.parquet", "scene.toml"]


def write_staged_file(unit):
    (unit.staging / "blocks-1.txt").write_text("done")


def test_finished_work_is_kept_where_a_run_fails_and_goes_where_one_ends_well(tmp_path):
    for then in (fail_to_write, lambda unit: (tmp_path / "a.txt").write_text("edited")):
        with (
            suppress(RuntimeError, BadInput),
            publication(tmp_path, "sweep", MAY_WRITE, kept_patterns=("blocks-*",)) as unit,
        ):
            write_staged_file(unit)
            write_text(unit.staged_path("a.txt"), "1")
            then(unit)
        assert names(tmp_path / WORK_FOLDER / "sweep") == ["blocks-1.txt"]
    (tmp_path / "a.txt").unlink()
    with publication(tmp_path, "sweep", MAY_WRITE, kept_patterns=("blocks-*",)) as unit:
        assert (unit.staging / "blocks-1.txt").read_text() == "done"
    assert names(tmp_path / WORK_FOLDER) == ["lock"]


@pytest.mark.parametrize("renamed", range(4))
def test_a_run_that_died_while_it_published_is_finished_by_the_next_one(tmp_path, renamed):
    """Killed between any two renames: plain readers find one result, ours refuse what no manifest names."""
    publish(tmp_path, {"a.txt": "1", "b.txt": "1", "c.txt": "1"})
    replace, count = os.replace, iter(range(9))

    def dies(source, target):
        if Path(source).parent.name == "sweep" and Path(target).parent == tmp_path and next(count) == renamed:
            raise KeyboardInterrupt
        replace(source, target)

    with suppress(KeyboardInterrupt), patch("os.replace", dies):
        publish(tmp_path, {"a.txt": "2", "b.txt": "2"})
    assert {*file_texts(tmp_path).values()} <= {"2"}
    for name in file_texts(tmp_path) if renamed < 3 else ():
        with (
            pytest.raises(BadInput, match="it differs from the file that manifest"),
            open_checked_result_file(tmp_path / name),
        ):
            pass
    finish_interrupted_publication(tmp_path)
    assert file_texts(tmp_path) == {"a.txt": "2", "b.txt": "2"}
    assert {*read_manifest(tmp_path).results["sweep"].files} == {"a.txt", "b.txt"}


def test_an_answer_is_given_to_the_same_question_where_each_file_is_whole(tmp_path):
    with publication(tmp_path, "sweep", MAY_WRITE, question={"of": "a"}) as unit:
        write_text(unit.staged_path("a.txt"), "1")
        unit.answer = {"rows": 3}
    assert published_answer_to_same_question(tmp_path, "sweep", {"of": "a"}) == {"rows": 3}
    assert published_answer_to_same_question(tmp_path, "sweep", {"of": "b"}) is None
    assert published_answer_to_same_question(tmp_path, "optimise", {"of": "a"}) is None
    (tmp_path / "a.txt").write_text("2")
    assert published_answer_to_same_question(tmp_path, "sweep", {"of": "a"}) is None


def test_what_the_manifest_does_not_name_or_that_differs_is_not_read(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with open_checked_result_file(tmp_path / "mine.txt") as file:
        assert file.read() == b"mine"
    publish(tmp_path, {"a.txt": "1"})
    with pytest.raises(BadInput, match="does not name it"), open_checked_result_file(tmp_path / "mine.txt"):
        pass
    with open_checked_result_file(tmp_path / "a.txt") as file:
        assert file.read() == b"1"
    (tmp_path / "a.txt").write_text("2")
    with pytest.raises(BadInput, match="it differs from"), open_checked_result_file(tmp_path / "a.txt"):
        pass


def test_a_link_in_the_place_of_the_lock_is_not_followed(tmp_path):
    (tmp_path / WORK_FOLDER).mkdir()
    (tmp_path / "precious").write_text("mine")
    (tmp_path / WORK_FOLDER / "lock").symlink_to(tmp_path / "precious")
    with pytest.raises(OSError, match=r"lock|link"):
        publish(tmp_path, {"a.txt": "1"})
    assert (tmp_path / "precious").read_text() == "mine"


def test_a_file_that_cannot_be_read_is_not_called_edited(tmp_path, monkeypatch):
    publish(tmp_path, {"a.txt": "1"})

    def fail_to_read(path):
        raise OSError(EIO, os.strerror(EIO), os.fspath(path))

    monkeypatch.setattr("camopt.core.storage.manifest.open_regular_file", fail_to_read)
    with pytest.raises(OSError, match=os.strerror(EIO)):
        publish(tmp_path, {"a.txt": "2"})

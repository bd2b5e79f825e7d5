"""Interrupted sweeps that go on, parts of a sweep, and what they are put together to."""

import json
import signal
import subprocess
import sys
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import camopt
from camopt.core.engines.threads import Threads
from camopt.core.mistakes import BadInput, Stopped
from camopt.core.storage.manifest import read_manifest
from camopt.core.storage.publishing import publication
from camopt.solve.front import estimate, store
from camopt.solve.front.blocks import merge_batches
from camopt.solve.front.estimate import SweepEstimate, bytes_in_words, check_disk_room, estimate_sweep
from camopt.solve.front.plan import sweep_plan
from camopt.solve.front.store import BrokenBatch, interrupted_key, read_batch, sorted_batch_files, write_batch
from camopt.solve.front.sweep import sweep
from camopt.solve.front.table_certificate import certify_table

LAWS = ["harmonic", "cycloidal"]
SEARCH = {"base_radius": {"start": 30, "stop": 149, "step": 1}, "offset": {"start": 0, "stop": 18, "step": 2}}
SCENE = camopt.find_scene("roller-1000rpm").replace(search=SEARCH | {"law": LAWS})
BLOCK = 100  # of 2,400 designs
KEPT = "are done and kept; the same command goes on from there"


def run(out, **asked):
    return sweep(SCENE, out, block=BLOCK, workers=2, **asked)


def stop_after(at):
    """A caller that stops a sweep after so many designs."""
    return lambda done, total: done < at


@pytest.fixture
def saving_at_once(monkeypatch):
    """A store that writes a file for each batch."""
    monkeypatch.setattr(store, "SAVE_SECONDS", 0.0)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """What one run writes, by the designs that it keeps: files by name."""

    def files(keep):
        return {file.name: file.read_bytes() for file in run(tmp_path_factory.mktemp(keep), keep=keep).files}

    return {keep: files(keep) for keep in ("feasible", "all", "pareto")}


def files_in(folder):
    return {
        file.name: file.read_bytes() for file in folder.iterdir() if file.name not in ("manifest.json", ".camopt")
    }


def kept_files(out):
    """The files of the finished work of a stopped sweep."""
    return [path for _, path in sorted_batch_files((out / ".camopt" / "sweep").iterdir())]


@pytest.mark.slow
@pytest.mark.parametrize("keep", ["feasible", "all", "pareto"])
def test_an_interrupted_sweep_goes_on_where_it_ended(keep, tmp_path, whole, saving_at_once):
    told, seen = [], []
    with pytest.raises(Stopped, match=r"1,[0-9]00 of 2,400 designs are done and kept; the same command goes on"):
        run(tmp_path, keep=keep, progress=stop_after(1200))
    assert [each.name for each in tmp_path.iterdir()] == [".camopt"]
    run(tmp_path, keep=keep, tell=told.append, progress=lambda done, total: seen.append(done))
    assert len(told) == 1
    assert told[0].startswith("resuming an interrupted sweep: 1,")
    assert seen == [*range(BLOCK, 2401, BLOCK)]
    assert files_in(tmp_path) == whole[keep]
    assert [each.name for each in (tmp_path / ".camopt").iterdir()] == ["lock"]


def test_who_stops_while_what_is_kept_is_read_is_told_of_all_of_it(tmp_path, saving_at_once):
    with pytest.raises(Stopped, match=KEPT):
        run(tmp_path, progress=stop_after(1200))
    with pytest.raises(Stopped, match=r"1,[0-9]00 of 2,400 designs are done and kept"):
        run(tmp_path, progress=stop_after(BLOCK))


def test_what_is_kept_is_not_evaluated_again(tmp_path, saving_at_once):
    with pytest.raises(Stopped, match=KEPT):
        run(tmp_path, progress=stop_after(1200))
    done = sorted_batch_files(kept_files(tmp_path))
    middle, lost = done.pop(4)
    lost.unlink()
    evaluated = []

    class Noted(Threads):
        def results_in_order(self, work, items, sample=()):
            evaluated.extend(items)
            return Threads.results_in_order(self, work, items, sample)

    run(tmp_path, engine=Noted(1))
    assert sum(len(blocks) for blocks, _ in done) >= 11
    assert evaluated == [*middle, *range(done[-1][0].stop, 24)]


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, Stopped])
def test_who_stops_a_sweep_is_told_what_is_kept(interrupt, tmp_path):
    def stop(done, total):
        if done == 300:
            raise interrupt

    with pytest.raises(interrupt, match=r"interrupted; 300 of 2,400 designs are done and kept"):
        run(tmp_path, progress=stop)


def test_another_error_has_a_note_of_what_is_kept(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("camopt.solve.front.certified_front.report_rows", full)
    with pytest.raises(OSError, match="No space") as trouble:
        run(tmp_path)
    assert trouble.value.__notes__ == [
        "2,400 of 2,400 designs are done and kept; the same command goes on from there"
    ]


@pytest.mark.usefixtures("_few_levels")
def test_an_interrupted_refinement_evaluates_no_block_again(tmp_path):
    refined = SCENE.replace(**{"search.refine": True, "search.law": ["cycloidal"]})

    def stop(done, total):
        if total != 1200:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="1,200 of 1,200"):
        sweep(refined, tmp_path, progress=stop)
    told = []
    sweep(refined, tmp_path, tell=told.append)
    assert told == ["resuming an interrupted sweep: 1,200 of 1,200 designs are done"]


def test_a_sweep_that_is_shorter_than_a_second_keeps_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "monotonic", lambda: 0.0)  # however busy the machine is
    monkeypatch.setattr(store, "write_batch", None)
    run(tmp_path)


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"limits.pressure_angle": 25.0}, "limits.pressure_angle"),
        ({"search.law": ["cycloidal", "harmonic"]}, "search.law"),
        ({"cam.rpm": 900}, "cam.rpm"),
    ],
)
def test_another_question_starts_anew_and_says_so(change, named, tmp_path, saving_at_once):
    with pytest.raises(Stopped, match=KEPT):
        run(tmp_path, progress=stop_after(1200))
    told, other = [], SCENE.replace(**change)
    sweep(other, tmp_path, block=BLOCK, tell=told.append)
    assert told == [f"the folder has an interrupted sweep that differs in {named}; the new sweep replaces it"]
    sweep(other, tmp_path / "fresh", block=BLOCK)
    assert {**files_in(tmp_path / "fresh")}.items() <= {
        name: (tmp_path / name).read_bytes() for name in ("pareto.parquet", "designs.parquet", "scene.toml")
    }.items()


def test_an_older_result_stays_until_there_is_a_new_one(tmp_path, whole, saving_at_once):
    run(tmp_path)
    with pytest.raises(Stopped, match=KEPT):
        sweep(SCENE.replace(**{"cam.rpm": 900}), tmp_path, block=BLOCK, progress=stop_after(1200))
    kept = {name: (tmp_path / name).read_bytes() for name in whole["feasible"]}
    assert kept == whole["feasible"]


def test_many_rows_are_written_before_a_second_is_over(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "SAVE_SECONDS", inf)
    monkeypatch.setattr(store, "SAVE_ROWS", 100)
    with pytest.raises(Stopped, match=KEPT):
        run(tmp_path, progress=stop_after(1500))
    asked = sweep_plan(SCENE, "feasible", BLOCK)
    counts = [read_batch(path, asked).kept.count for path in kept_files(tmp_path)]
    assert len(counts) > 2
    assert all(100 <= rows < 100 + BLOCK for rows in counts[:-1])


@pytest.fixture(scope="module")
def interrupted_files(tmp_path_factory):
    """The files of a sweep that was stopped."""
    folder = tmp_path_factory.mktemp("kept")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(store, "SAVE_SECONDS", 0.0)
        with pytest.raises(Stopped, match=KEPT):
            run(folder, progress=stop_after(600))
    return kept_files(folder)


@given(place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7), cut=st.booleans())
def test_a_batch_that_is_cut_or_changed_is_not_read(place, bit, cut, interrupted_files, tmp_path_factory):
    whole = interrupted_files[1].read_bytes()
    where = int(place * len(whole))
    changed = bytearray(whole[:where] if cut else whole)
    if not cut:
        changed[where] ^= 1 << bit
    path = tmp_path_factory.mktemp("broken") / interrupted_files[1].name
    path.write_bytes(changed)
    with pytest.raises(BrokenBatch, match="damaged"):
        read_batch(path, sweep_plan(SCENE, "feasible", BLOCK))


@pytest.mark.parametrize(
    "fault", ["cut", "gone", "of other blocks", "of another sweep", "twice", "no question", "odd"]
)
def test_a_sweep_goes_on_to_the_same_rows_from_whatever_is_whole(fault, interrupted_files, tmp_path, whole):
    folder = tmp_path / ".camopt" / "sweep"
    folder.mkdir(parents=True)
    for path in (*interrupted_files, interrupted_files[0].parent / "question.json"):
        (folder / path.name).write_bytes(path.read_bytes())
    chosen = folder / interrupted_files[2].name
    match fault:
        case "cut":
            chosen.write_bytes(chosen.read_bytes()[:-1])
        case "gone":
            chosen.unlink()
        case "of other blocks":
            chosen.rename(folder / interrupted_files[2].name.replace("blocks-00000000", "blocks-00000001"))
        case "of another sweep":
            other = sweep_plan(SCENE.replace(**{"cam.rpm": 900}), "all", BLOCK)
            write_batch(other.blocks.evaluate_block(2), other.searched_row_quantities, folder)
        case "twice":
            asked = sweep_plan(SCENE, "feasible", BLOCK)
            three = merge_batches(
                [asked.blocks.evaluate_block(number) for number in (1, 2, 3)], asked.problem.objectives
            )
            write_batch(three, asked.searched_row_quantities, folder)
        case "no question":
            (folder / "question.json").unlink()
        case "odd":
            (folder / "question.json").write_bytes(bytes(range(256)))
    run(tmp_path)
    assert files_in(tmp_path) == whole["feasible"]


def test_a_batch_is_the_same_from_its_file(tmp_path):
    asked = sweep_plan(SCENE.replace(**{"limits.pressure_angle": None}), "all", BLOCK)
    batch = merge_batches(
        [asked.blocks.evaluate_block(n) for n in (11, 12)], asked.problem.objectives
    )  # of two laws
    write_batch(batch, asked.searched_row_quantities, tmp_path)
    ((blocks, path),) = sorted_batch_files(tmp_path.iterdir())
    again = read_batch(path, asked)
    assert blocks == range(batch.first, batch.last)
    for name in ("first", "last", "designs", "existing", "feasible", "effort", "reached"):
        assert getattr(again, name) == getattr(batch, name)
    for name in ("kept", "front", "best"):
        ours, theirs = getattr(batch, name), getattr(again, name)
        assert ours.count == theirs.count
        for column in asked.table_columns:
            assert np.array_equal(ours.column(column), theirs.column(column)), column


def test_a_disk_that_takes_no_batch_does_not_end_the_sweep(tmp_path, whole, saving_at_once, monkeypatch):
    calls = []

    def third_fails(*args):
        calls.append(args)
        if len(calls) > 2:
            raise OSError(28, "No space left on device")
        write_batch(*args)

    monkeypatch.setattr(store, "write_batch", third_fails)
    run(tmp_path)
    assert files_in(tmp_path) == whole["feasible"]
    assert len(calls) == 3


# -------------------------------------------------------------------------------------------------- many machines


@pytest.mark.one_in(5)
@pytest.mark.parametrize("parts", [1, 3, 12])
@pytest.mark.parametrize("keep", ["feasible", "pareto"])
def test_parts_are_merged_to_what_one_run_writes(parts, keep, tmp_path, whole):
    counts = [
        camopt.sweep_part(SCENE, (part, parts), out=tmp_path / "parts", keep=keep) for part in range(1, parts + 1)
    ]
    assert sum(part.designs for part in counts) == 2400
    result = camopt.merge([tmp_path / "parts"], tmp_path / "merged")
    assert files_in(tmp_path / "merged") == whole[keep]
    assert result.feasible == sum(part.feasible for part in counts)


def test_parts_may_lie_anywhere(tmp_path, whole):
    one = camopt.sweep_part(SCENE, (1, 2), out=tmp_path / "here")
    two = camopt.sweep_part(SCENE, (2, 2), out=tmp_path / "there")
    camopt.merge([two.folder, one.folder.parent], tmp_path / "merged")
    assert files_in(tmp_path / "merged") == whole["feasible"]


def test_an_interrupted_part_goes_on(tmp_path, saving_at_once, monkeypatch):
    monkeypatch.setattr("camopt.solve.front.plan.BLOCK_SIZE", BLOCK)
    monkeypatch.setattr("camopt.solve.front.parts.sweep_plan", lambda scene, keep: sweep_plan(scene, keep, BLOCK))
    told = []
    with pytest.raises(Stopped, match=r"[67]00 of 1,200 designs are done"):
        camopt.sweep_part(SCENE, (2, 2), out=tmp_path, progress=stop_after(600))
    found = camopt.sweep_part(SCENE, (2, 2), out=tmp_path, tell=told.append)
    assert found.designs == 1200
    assert len(told) == 1


def test_parts_are_of_equal_size(tmp_path):
    counts = [camopt.sweep_part(SCENE, (part, 7), out=tmp_path).designs for part in range(1, 8)]
    assert sum(counts) == 2400
    assert max(counts) - min(counts) <= 2 * 2400 / (8 * 7)


def test_all_that_keeps_parts_from_being_merged_is_named(tmp_path):
    for part in (1, 2, 4):
        camopt.sweep_part(SCENE, (part, 5), out=tmp_path / "parts")
    camopt.sweep_part(SCENE, (1, 5), out=tmp_path / "again")
    camopt.sweep_part(SCENE.replace(**{"cam.rpm": 900}), (3, 5), out=tmp_path / "other", keep="pareto")
    (cut,) = (tmp_path / "parts" / "part-2-of-5").glob("blocks-*")
    cut.write_bytes(cut.read_bytes()[:-1])
    (tmp_path / "parts" / "part-9-of-9").mkdir()
    with pytest.raises(BadInput) as refused:
        camopt.merge([tmp_path / name for name in ("parts", "again", "other")], tmp_path / "out")
    told = [f"{mistake.key} {mistake.allowed}" for mistake in refused.value.mistakes]
    assert len(told) == 5
    assert "damaged" in told[0], told
    assert not (tmp_path / "out").exists()


def test_places_without_parts(tmp_path):
    with pytest.raises(BadInput, match="must be a folder with parts of a sweep; this has none"):
        camopt.merge(tmp_path)
    with pytest.raises(FileNotFoundError, match="nowhere"):
        camopt.merge(tmp_path / "nowhere")


def test_parts_are_not_merged_into_a_folder_with_another_interrupted_sweep(tmp_path, saving_at_once, whole):
    camopt.sweep_part(SCENE, (1, 1), out=tmp_path / "parts")
    with pytest.raises(Stopped, match=KEPT):
        sweep(SCENE.replace(**{"cam.rpm": 900}), tmp_path / "out", block=BLOCK, progress=stop_after(1200))
    with pytest.raises(BadInput, match="must be another folder: an interrupted sweep is kept in this one"):
        camopt.merge([tmp_path / "parts"], tmp_path / "out")
    assert interrupted_key(tmp_path / "out", "sweep")
    with pytest.raises(Stopped, match=KEPT):
        run(tmp_path / "same", progress=stop_after(1200))
    camopt.merge([tmp_path / "parts"], tmp_path / "same")
    assert files_in(tmp_path / "same") == whole["feasible"]


def test_an_interrupt_while_tables_are_finished_says_what_is_kept(tmp_path, monkeypatch, saving_at_once):
    def interrupt(self):
        raise KeyboardInterrupt

    monkeypatch.setattr("camopt.solve.tables.table_writers.TableWriter.wait_until_written", interrupt)
    with pytest.raises(KeyboardInterrupt, match=r"interrupted; 2,[0-9]00 of 2,400 designs are done and kept"):
        run(tmp_path)


@given(place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7), manifest=st.booleans())
def test_a_damaged_part_is_refused(place, bit, manifest, tmp_path_factory):
    part = tmp_path_factory.getbasetemp() / "damaged" / "part-1-of-1"
    if not part.exists():
        camopt.sweep_part(SCENE, (1, 1), out=part.parent)
    (file,) = part.glob("manifest.json" if manifest else "blocks-*")
    whole = file.read_bytes()
    data = bytearray(whole)
    data[int(place * len(data))] ^= 1 << bit
    file.write_bytes(data)
    try:
        with pytest.raises(BadInput, match=r"damaged"):
            camopt.merge([part], part.parent / "out")
    finally:
        file.write_bytes(whole)
    assert not (part.parent / "out").exists()


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ((0, 3), r"part = \(0, 3\): must be the number of a part, from 1 to 3"),
        ((4, 3), r"part = \(4, 3\): must be the number of a part, from 1 to 3"),
        ((1, 0), r"part = \(1, 0\): must be one of at most 100,000 parts"),
        ("1/3", "part = '1/3': must be two numbers, such as "),
    ],
)
def test_a_part_that_does_not_exist(part, message, tmp_path):
    with pytest.raises(BadInput, match=message):
        camopt.sweep_part(SCENE, part, out=tmp_path)


# ------------------------------------------------------------------------------------------------------- foreseen


def test_a_long_sweep_is_foreseen(tmp_path, monkeypatch):
    monkeypatch.setattr(estimate, "LEAST_BLOCKS", 8)
    asked = sweep_plan(SCENE, "feasible", 3 * BLOCK)  # in smaller blocks there is little else than heads of files
    found = estimate_sweep(asked, asked.part_blocks(), Threads(2), 2, tmp_path)
    run(tmp_path)
    table = (tmp_path / "designs.parquet").stat().st_size
    assert found.designs == 2400
    assert 0.0 < found.seconds < 600.0
    assert 0.1 * table < found.table_bytes < 10.0 * table  # small files are mostly not rows
    assert estimate_sweep(asked, asked.part_blocks(1, 4), Threads(2), 2, tmp_path) is None
    assert (
        estimate_sweep(sweep_plan(SCENE, "pareto", BLOCK), asked.part_blocks(), Threads(2), 2, tmp_path).table_bytes
        == 0
    )


def test_the_time_and_the_room_are_told_first(tmp_path, monkeypatch):
    monkeypatch.setattr(estimate, "LEAST_BLOCKS", 8)
    told = []
    run(tmp_path, tell=told.append)
    assert len(told) == 1
    assert told[0].startswith("2,400 designs take about 0:00:0")
    assert told[0].endswith("are free")


def test_a_sweep_without_room_does_not_start(tmp_path):
    with pytest.raises(
        OSError, match='about 144 GB are needed and 63 GB are free; keep="pareto" keeps the Pareto front alone'
    ):
        check_disk_room(SweepEstimate(3_300_000_000, 3300.0, 72e9, 63e9), tmp_path)
    check_disk_room(SweepEstimate(3_300_000_000, 3300.0, 30e9, 63e9), tmp_path)


@pytest.mark.parametrize(
    ("size", "words"), [(0.0, "0 B"), (999.0, "999 B"), (12_300.0, "12.3 kB"), (72e9, "72 GB"), (5e16, "5e+04 TB")]
)
def test_sizes_in_words(size, words):
    assert bytes_in_words(size) == words


# ------------------------------------------------------------------------------------------------ the command line


def interrupt(out):
    with pytest.raises(Stopped, match=KEPT):
        sweep(SCENE, out, progress=stop_after(1))


def test_resume_takes_the_question_from_the_folder(tmp_path, command, whole):
    interrupt(tmp_path / "camopt-out")
    code, _, err = command("sweep", "--resume")
    assert code == 0
    assert "camopt: resuming an interrupted sweep: 1,200 of 2,400 designs are done" in err
    assert files_in(tmp_path / "camopt-out") == whole["feasible"]


def test_resume_refuses_another_question(tmp_path, command):
    interrupt(tmp_path / "out")
    code, out, err = command("sweep", "roller-1000rpm", "--resume", "--out", "out", "--rpm", "900")
    assert (code, out) == (2, "")
    assert err.startswith("camopt: --resume: cannot resume the sweep in out: it differs in cam.rpm, search.")
    assert command("sweep", "--resume", "--out", "out", "--rpm", "900")[2] == (
        "camopt: --resume: cannot resume the sweep in out: it differs in cam.rpm\n"
    )
    assert interrupted_key(tmp_path / "out", "sweep")


def test_parts_on_the_command_line(tmp_path, command, whole):
    (tmp_path / "own.toml").write_text(SCENE.to_toml())
    for part in (1, 2):
        code, out, err = command("sweep", "own.toml", "--part", f"{part}/2", "--out", "parts")
        assert code == 0
        assert out.startswith(f"1000 rpm roller cam, part {part} of 2: 1,200 designs, ")
        assert f"wrote parts/part-{part}-of-2" in err
    code, out, _ = command("merge", "parts", "--out", "merged", "--json")
    assert code == 0
    assert json.loads(out)["designs"] == 2400
    assert files_in(tmp_path / "merged") == whole["feasible"]
    code, out, _ = command("sweep", "own.toml", "--part", "1/2", "--out", "again", "--json")
    assert json.loads(out)["part"] == 1


@pytest.mark.parametrize("part", ["3", "a/b", "/", "-1/3", "1/", "0/3", "4/3"])
def test_what_is_no_part(part, command):
    code, _, err = command("sweep", "--part", part)
    assert code == 2
    assert "is not PART/PARTS with 1 <= PART <= PARTS, such as 3/100" in err


@pytest.mark.slow
def test_a_killed_sweep_goes_on(tmp_path):
    """As it happens: the process dies at once, in the middle, and the same command is given again."""
    (tmp_path / "own.toml").write_text(SCENE.to_toml())
    dying = (
        "import os, sys; import camopt; from camopt.solve.front import store;"
        "from camopt.solve.front.sweep import sweep;"
        "store.SAVE_SECONDS = 0.0; scene = camopt.find_scene('own.toml');"
        "sweep(scene, 'out', block=100, progress=lambda done, total: done < 1500 or os.kill(os.getpid(), 9))"
    )
    died = subprocess.run([sys.executable, "-c", dying], cwd=tmp_path, check=False, capture_output=True)
    assert died.returncode == -signal.SIGKILL
    told = []
    sweep(camopt.find_scene(tmp_path / "own.toml"), tmp_path / "out", block=BLOCK, tell=told.append)
    assert told[0].startswith("resuming an interrupted sweep: 1,")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "designs.parquet", "pareto.parquet", "scene.toml", "manifest.json", ".camopt"
    }  # fmt: skip


# ------------------------------------------------------------------------------------------------ done already

SMALL = SCENE.replace(search={"base_radius": [60, 80, 120], "offset": [0, 10], "law": LAWS, "roller_radius": [20]})
DONE = "{} is up to date; use `again` to recompute"
QUESTIONS = {
    "feasible": {},
    "infinite values": {"outputs": ["all"]},
    "a refined front": {"search.refine": True, "search.law": ["cycloidal"]},
    "nothing feasible": {"limits.pressure_angle": 1.0},
    "nothing feasible, and a number that varies": {"limits.pressure_angle": 1.0, "search.cam.rpm": [900, 1000]},
    "no design can be assembled": {"search.offset": [100]},
}


def fail_if_called(*_):
    raise AssertionError("it is evaluated again")


@pytest.mark.usefixtures("_few_levels", "_boxes")
@pytest.mark.parametrize("keep", ["feasible", "front-only"])
@pytest.mark.parametrize("what", QUESTIONS)
def test_a_sweep_that_is_done_is_given_back_as_it_was(what, keep, tmp_path, monkeypatch):
    """All that it says is that of the first run, without a design being evaluated, or a byte written."""
    scene, told = SMALL.replace(**QUESTIONS[what]), []
    first = sweep(scene, tmp_path, keep=keep, tell=told.append)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    monkeypatch.setattr("camopt.solve.front.sweep.run_and_publish_sweep", fail_if_called)
    again = sweep(scene, tmp_path, keep=keep, block=50, tell=told.append)
    assert told == [DONE.format(tmp_path)]
    assert (first.already_done, again.already_done) == (False, True)
    assert replace(again, already_done=False) == first
    designs = [[*filter(None, (each.nearest_miss, *each.best.values()))] for each in (first, again)]
    for ours, theirs in zip(*designs, strict=True):
        assert ours.scene == theirs.scene
        assert [*map(type, ours.values())] == [*map(type, theirs.values())]
    assert what != "infinite values" or any(inf in design.values() for design in designs[1])
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


@pytest.fixture
def done(tmp_path):
    """A folder with a finished sweep; a function that does it again, and says what was told."""
    sweep(SMALL, tmp_path / "out")

    def again(scene=SMALL, keep="feasible", **how):
        told = []
        result = sweep(scene, tmp_path / "out", keep=keep, tell=told.append, **how)
        assert told == ([DONE.format(tmp_path / "out")] if result.already_done else [])
        return result.already_done

    again.folder = tmp_path / "out"
    return again


def test_it_is_done_again_if_one_asks_so_or_asks_something_else(done, monkeypatch):
    assert done()
    assert not done(again=True)
    for scene in (SMALL.replace(**{"cam.rpm": 900}), SMALL.replace(name="another name"), SMALL):
        assert not done(scene)
        assert done(scene)
    assert not done(keep="all")
    monkeypatch.setattr("camopt.core.storage.version.VERSION", "99")
    assert not done(keep="all")
    assert done(keep="all")


def test_it_is_done_again_unless_every_file_is_whole(done):
    for name in ("pareto.parquet", "designs.parquet"):
        whole = (done.folder / name).read_bytes()
        for data in (whole[:-1], whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:], b"", None):
            if data is None:
                (done.folder / name).unlink()
            else:
                (done.folder / name).write_bytes(data)
            assert not done(), (name, data)
            assert (done.folder / name).read_bytes() == whole
            assert done()
    (done.folder / "scene.toml").unlink()
    assert not done()
    manifest = (done.folder / "manifest.json").read_bytes()
    (done.folder / "manifest.json").write_bytes(manifest[:-1])
    with pytest.raises(BadInput, match="no manifest names this as a file of camopt"):
        done()
    (done.folder / "manifest.json").write_bytes(manifest)
    (done.folder / "scene.toml").write_text("edited")
    with pytest.raises(BadInput, match="edited since camopt wrote it"):
        done()


def test_a_file_that_another_command_has_taken_over_is_computed_anew(done):
    with publication(done.folder, "synthesise", ("scene.toml",)) as unit:
        unit.staged_path("scene.toml").write_text("of another command")
    assert not done()


def test_a_proof_in_a_table_stays_where_its_sweep_is_done_already(done):
    counts = certify_table(done.folder / "designs.parquet")
    assert done()
    assert camopt.load(done.folder / "designs.parquet")["proof"].value_counts().to_dict() == dict(counts)


@pytest.mark.parametrize("answer", [{}, [], 1, "text", {"best": 1}, None])
def test_a_manifest_that_says_odd_things_of_its_result_is_not_believed(done, answer):
    manifest = read_manifest(done.folder)
    odd = manifest.results["sweep"]._replace(answer=answer)
    (done.folder / "manifest.json").write_text(manifest.with_result("sweep", odd).to_json())
    assert not done()


def test_an_interrupted_sweep_of_another_question_stays_where_the_result_is_done(done, saving_at_once):
    other = SCENE.replace(**{"cam.rpm": 900})
    with pytest.raises(Stopped, match=KEPT):
        sweep(other, done.folder, block=BLOCK, progress=stop_after(1200))
    assert done()
    assert "rpm = 900.0" in interrupted_key(done.folder, "sweep").scene


def test_a_requeued_array_of_parts_evaluates_nothing(tmp_path, command, monkeypatch):
    (tmp_path / "own.toml").write_text(SMALL.to_toml())
    array = [("sweep", "own.toml", "--part", f"{number}/5", "--out", "parts", "--json") for number in range(1, 6)]
    first = [command(*each) for each in array]
    merged = command("merge", "parts", "--json")
    monkeypatch.setattr("camopt.solve.front.parts.gather_batches", fail_if_called)
    for number, each in enumerate(array, 1):
        code, out, err = command(*each)
        assert (code, out) == first[number - 1][:2] == (0, out)
        assert err == f"camopt: {DONE.format(f'parts/part-{number}-of-5')}\n"
    code, out, err = command("merge", "parts", "--json")
    assert (code, out) == merged[:2]
    assert err == f"camopt: {DONE.format('camopt-out')}\n"
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    code, out, err = command(*array[0], "--again")
    assert (code, out) == first[0][:2]
    assert "wrote parts/part-1-of-5" in err


def test_resume_begins_where_there_is_nothing_to_go_on_with(tmp_path, command, whole):
    (tmp_path / "own.toml").write_text(SCENE.to_toml())
    (tmp_path / "empty").mkdir()
    (tmp_path / "begun" / ".camopt" / "sweep").mkdir(parents=True)
    (tmp_path / "begun" / ".camopt" / "sweep" / "question.json").write_bytes(b'{"sce')
    for folder in ("absent", "empty", "begun"):
        assert command("sweep", "own.toml", "--resume", "--out", folder, "--quiet")[0] == 0
        assert files_in(tmp_path / folder) == whole["feasible"]


def test_resume_of_what_is_done_says_so_whoever_asked_it(tmp_path, command, whole):
    (tmp_path / "own.toml").write_text(SCENE.to_toml())
    command("sweep", "own.toml", "--resume", "--out", "out")
    for asked in (("own.toml",), ()):
        code, _, err = command("sweep", *asked, "--resume", "--out", "out")
        assert (code, err) == (0, f"camopt: {DONE.format('out')}\n")
    code, _, err = command("sweep", "--resume", "--out", "out", "--rpm", "900")
    assert (code, err) == (2, "camopt: --resume: cannot resume the sweep in out: it differs in cam.rpm\n")
    assert files_in(tmp_path / "out") == whole["feasible"]


def test_resume_replaces_no_result_of_which_nothing_tells_what_was_asked(tmp_path, command):
    with publication(tmp_path / "out", "sweep", ("scene.toml",)) as unit:
        unit.staged_path("scene.toml").write_text("of an older camopt")
    code, _, err = command("sweep", "--resume", "--out", "out")
    assert code == 2
    assert (
        err == "camopt: --resume = 'out': needs SCENE: the manifest of this folder does not record the scene of "
        "its sweep\n"
    )

"""Commands that publish a folder, given again: each says that it is done, and prints what it printed before."""

import os
import subprocess
import sys

import pytest
from support.faults import tree_of

from camopt import find_scene
from camopt.cli import once
from camopt.storage.manifest import manifest_of

SPECTRUM = "camopt.studies.spectrum.spectrum"
COMMANDS = {
    "optimise": (["optimise", "two-pauses", "--out", "out"], "camopt.smallest.optimise.optimise"),
    "effects": (["effects", "--spectrum", "--out", "out"], SPECTRUM),
    "synthesise": (["synthesise", "--out", "out"], "camopt.synthesis.synthesise.synthesise"),
}


def never(*_):
    raise AssertionError("it is computed again")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_that_is_done_prints_what_it_printed(name, command, tmp_path, monkeypatch):
    arguments, work = COMMANDS[name]
    code, text, err = command(*arguments)
    assert "wrote out/" in err
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out").iterdir()}
    with monkeypatch.context() as patched:
        patched.setattr(work, never)
        assert command(*arguments)[:2] == (code, text)
        document = command(*arguments, "--json", "--quiet")
        said = command(*arguments)[2]
    assert "wrote" not in said
    assert said.endswith(
        "camopt: already done: out has the whole result of the same question and version; "
        "`again` computes it anew\n"
    )
    assert document[2] == ""
    assert {path.name: path.stat().st_mtime_ns for path in (tmp_path / "out").iterdir()} == before
    (tmp_path / "out" / next(iter(before.keys() - {"manifest.json"}))).unlink()
    code, again, err = command(*arguments, "--json", "--quiet")
    assert (code, again) == document[:2]


SWEEP = ["sweep", "two-pauses", "--out", "out"]
FRONTIER = ["frontier", "--values", "2", "--out", "out"]


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "arguments",
    [*(each[0] for each in COMMANDS.values()), FRONTIER, SWEEP, [*SWEEP, "--part", "1/2"]],
    ids=" ".join,
)
def test_a_command_that_is_done_needs_no_package_but_that_of_its_options(arguments, command, tmp_path):
    """An array of jobs that is queued again asks hundreds of times: what reads a scene would take most of each."""
    first = command(*arguments)
    code = (
        "import sys\nbefore = set(sys.modules)\nfrom camopt.cli.main import main\nmain(sys.argv[1:])\n"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "sys.exit(str(new - sys.stdlib_module_names))"
    )
    again = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(again, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    *said, modules = done.stderr.strip().splitlines()
    assert "camopt: already done" in said[-1]
    assert done.stdout == first[1]
    assert eval(modules) == {"camopt", "click", "lazy_loader"}


def test_it_computes_for_another_question_and_for_who_asks_it_to(command):
    asked = COMMANDS["optimise"][0]
    command(*asked)
    for more in (["--again"], ["--seconds", "59"], ["--rpm", "99"]):
        assert "wrote out/" in command(*asked, *more)[2], more
    assert command("optimise", "two-pauses", "--again")[0] == 2


# ----------------------------------------------------------------------------------------- in the same words

PART = ["sweep", "own.toml", "--base-radius", "60:80:10", "--part", "1/2", "--out", "parts"]
FOLDER = "parts/part-1-of-2"
TABLE = "follower.dynamics.load"


@pytest.fixture
def part(command, tmp_path, monkeypatch):
    """A part of a sweep whose scene names a file, done; whether it is known to be done before its scene is read."""
    scene = find_scene("roller-1000rpm").replace(**{"search.law": ["cycloidal"]})
    (tmp_path / "own.toml").write_text(f"{scene.to_toml()}\n[follower.dynamics]\nmass = 1\nload = 'load.csv'\n")
    (tmp_path / "load.csv").write_text("angle,load\n0,10\n180,20\n")

    def at_once(*more, words=PART):
        before = tree_of(tmp_path)
        with monkeypatch.context() as patched:
            patched.setattr("camopt.cli.options.scene_at", never)
            code, _, err = command(*words, *more)
        assert tree_of(tmp_path) == before
        return code == 0 and "already done" in err

    assert command(*PART)[0] == 0
    assert at_once()
    return at_once


def test_what_asks_for_no_other_result_is_no_other_question(part):
    for more in (["--workers", "1"], ["--scheduler", "tcp://127.0.0.1:1"], ["--json"], ["--no-such-option"]):
        assert part(*more) == (more != ["--no-such-option"]), more
    options = [*zip(PART[2::2], PART[3::2], strict=True)]
    assert part(words=[*PART[:2], *(word for option in reversed(options) for word in option)])


def test_other_words_are_looked_at(part, tmp_path):
    for more in (["--again"], ["--rpm", "999"], ["--keep", "all"], ["--law", "cycloidal"], ["--resume"]):
        assert not part(*more), more
    assert not part(words=[word.replace("1/2", "2/2") for word in PART])
    assert not part(words=[word.replace("parts", str(tmp_path / "parts")) for word in PART])
    assert not part(words=[word.replace("60:80:10", "60:80:5") for word in PART])


@pytest.mark.parametrize("name", ["own.toml", "load.csv", f"{FOLDER}/part-1-of-2.sweep", f"{FOLDER}/manifest.json"])
def test_no_byte_may_differ(part, tmp_path, name):
    path = tmp_path / name
    whole = path.read_bytes()
    for data in (whole[:-2], whole + b" ", whole[:9] + bytes([whole[9] ^ 1]) + whole[10:], b"", None):
        path.unlink(missing_ok=True)
        if data is not None:
            path.write_bytes(data)
        assert not part(), data
    path.write_bytes(whole)
    assert part()


def test_nor_may_the_version(part, monkeypatch):
    monkeypatch.setattr("camopt.cli.once.version_of_rows", lambda: "99")
    assert not part()


def test_nor_may_a_run_be_at_work(part, tmp_path):
    (tmp_path / FOLDER / ".camopt").mkdir()
    assert not part()


def test_a_scene_that_changes_while_it_is_read_is_not_known_by_its_words(part, command, tmp_path, monkeypatch):
    """Whoever asks next would be told of a text that nobody has read."""
    own, read = (tmp_path / "own.toml"), []
    text = own.read_text()
    words = once.words_read

    def read_late():
        own.write_text(text.replace("rpm = 1000", "rpm = 999"))
        read.append(words())
        return read[-1]

    monkeypatch.setattr("camopt.cli.once.words_read", read_late)
    monkeypatch.setattr("camopt.cli.commands.sweep.words_read", read_late)
    command(*PART, "--again")
    assert read == [""]
    assert not part()


def test_an_answer_that_is_odd_is_not_repeated(part, tmp_path):
    manifest = manifest_of(tmp_path / FOLDER)
    result = manifest.results["part"]
    for name, value in {"text": 1, "json": None, "code": "0", "notes": 3, "words": ""}.items():
        odd = result._replace(answer={**result.answer, name: value})
        (tmp_path / FOLDER / "manifest.json").write_text(manifest.with_result("part", odd).to_json())
        assert not part(), name


def test_what_was_not_exact_enough_is_said_each_time(command):
    asked = [*SWEEP, "--relative-error", "1e-14"]
    first = command(*asked)
    assert first[0] == 4
    assert "relative error of 1e-14 not reached" in first[2]
    assert [each[:2] for each in (first, command(*asked))] == [first[:2]] * 2
    assert "relative error of 1e-14 not reached" in command(*asked)[2]


def test_a_table_is_printed_anew_for_a_screen_that_it_does_not_fit(monkeypatch):
    said = once.KeptReport("a wide table\n", "{}", 0, [], "words")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    for columns, fits in ((11, False), (12, True)):
        monkeypatch.setattr(once, "get_terminal_size", lambda columns=columns: os.terminal_size((columns, 20)))
        assert said.fits(False) == fits
        assert said.fits(True)

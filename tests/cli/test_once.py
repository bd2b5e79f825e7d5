"""Commands that publish a folder, given again: each says that it is done, and prints what it printed before."""

import subprocess
import sys

import pytest

SPECTRUM = "camopt.studies.spectrum.spectrum"
COMMANDS = {
    "optimise": (["optimise", "two-pauses", "--out", "out"], "camopt.smallest.optimise.optimise"),
    "effects": (["effects", "--spectrum", "--out", "out"], SPECTRUM),
    "synthesise": (["synthesise", "--out", "out"], "camopt.synthesis.synthesise.synthesise"),
}


def never(*_):
    raise AssertionError("it is computed again")


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
FRONTIER = ["frontier", "--points", "2", "--out", "out"]


@pytest.mark.parametrize(
    "arguments",
    [*(each[0] for each in COMMANDS.values()), FRONTIER, SWEEP, [*SWEEP, "--part", "1/2"]],
    ids=" ".join,
)
def test_a_command_that_is_done_needs_neither_compiler_nor_solver(arguments, command, tmp_path):
    """An array of jobs that is queued again asks hundreds of times: numba would take a quarter of each."""
    command(*arguments)
    code = (
        "import sys\nfrom camopt.cli.main import main\nmain(sys.argv[1:])\n"
        "sys.exit(str({'numba', 'cvxpy', 'matplotlib'} & set(sys.modules)))"
    )
    again = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(again, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    *said, modules = done.stderr.strip().splitlines()
    assert "camopt: already done" in said[-1]
    assert modules == "set()"


def test_it_computes_for_another_question_and_for_who_asks_it_to(command):
    asked = COMMANDS["optimise"][0]
    command(*asked)
    for more in (["--again"], ["--seconds", "59"], ["--rpm", "99"]):
        assert "wrote out/" in command(*asked, *more)[2], more
    assert command("optimise", "two-pauses", "--again")[0] == 2

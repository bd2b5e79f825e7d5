"""How far a command is: shown by a bar in a terminal, and by a line now and then in a log."""

import os
import pty
import re
import subprocess
import sys
import termios
from contextlib import suppress
from itertools import groupby

import pytest

import camopt
from camopt import find_scene
from camopt.core.engines import progress
from camopt.core.engines.progress import progress_bar

LINE = re.compile(r"^ *(\d+)%\|.*\| *(\S+)/(\S+) \[.* (\w+)(/s)?\]$")


@pytest.fixture
def every_line(monkeypatch):
    """A log that gets a line for each step."""
    monkeypatch.setattr(progress, "LOG_DELAY", 0.0)
    monkeypatch.setattr(progress, "LOG_INTERVAL", 0.0)


def log_lines(capsys):
    """The lines of a log: percent, done, total and unit of each."""
    return [LINE.match(line).groups()[:4] for line in capsys.readouterr().err.splitlines()]


@pytest.mark.parametrize(
    ("steps", "lines"),
    [
        ([(0, 3), (1, 3), (3, 3)], [("0", "0", "3"), ("33", "1", "3"), ("100", "3", "3")]),
        ([(0, 4), (2, 8)], [("0", "0", "4"), ("25", "2", "8")]),  # the total changes
        ([(7_000, 28_000), (14_000, 28_000)], [("25", "7.00k", "28.0k"), ("50", "14.0k", "28.0k")]),
        ([(2, 2), (1, 4)], [("100", "2", "2"), ("25", "1", "4")]),  # another phase begins
    ],
)
@pytest.mark.usefixtures("every_line")
def test_lines_of_a_log_tell_what_is_done(steps, lines, capsys):
    with progress_bar("designs") as advance:
        for done, total in steps:
            advance(done, total)
    found = log_lines(capsys)
    assert [each for each, _ in groupby(found)] == [(*line, "designs") for line in lines]


def test_short_work_has_no_lines_in_a_log(capsys):
    with progress_bar("designs") as advance:
        for done in range(100):
            advance(done, 99)
    assert capsys.readouterr().err == ""


def test_work_of_no_size_and_work_that_fails_leave_no_trace(capsys):
    with progress_bar("designs") as advance:
        advance(0, 0)
    with suppress(ZeroDivisionError), progress_bar("designs") as advance:
        advance(1, 2**62)
        raise ZeroDivisionError
    with progress_bar("designs"):
        pass
    assert capsys.readouterr().err == ""


FEW = find_scene("two-pauses").replace(**{"search.law": ["cycloidal", "poly345"]})
"""A scene with few laws and designs, which takes a moment."""
SWEPT = FEW.replace(search={"base_radius": [61, 67], "law": ["cycloidal"]})
WORKS = {
    "optimise": lambda folder, progress: camopt.optimise(FEW, progress=progress),
    "optimise by place": lambda folder, progress: camopt.optimise(FEW, progress=progress),
    "sweep": lambda folder, progress: camopt.sweep(SWEPT, progress=progress),
    "sweep_part": lambda folder, progress: camopt.sweep_part(SWEPT, (1, 1), out=folder, progress=progress),
    "merge": lambda folder, progress: camopt.merge(folder, progress=progress),
    "synthesise": lambda folder, progress: camopt.synthesise(FEW, progress=progress),
}


@pytest.mark.usefixtures("every_line")
@pytest.mark.parametrize("name", WORKS)
def test_work_shows_a_bar_where_progress_is_true(name, tmp_path, capsys):
    if name == "merge":
        WORKS["sweep_part"](tmp_path, None)
    WORKS[name](tmp_path, False)
    WORKS[name](tmp_path, None)
    assert capsys.readouterr().err == ""
    calls = []
    WORKS[name](tmp_path / "other" if name != "merge" else tmp_path, lambda *call: calls.append(call))
    WORKS[name](tmp_path / "third" if name != "merge" else tmp_path, True)
    units = {"optimise": "laws", "synthesise": "starts"}
    unit = units.get(name.partition(" ")[0], "designs")
    found = log_lines(capsys)
    assert {(done, total, each) for _, done, total, each in found} == {
        (str(done), str(total), unit) for done, total in calls
    }


COMMAND = """
import sys
from camopt.core.engines import progress
progress.LOG_DELAY = progress.LOG_INTERVAL = 0.0
from camopt.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def line(tmp_path):
    """A command over few laws, which takes a moment."""
    path = tmp_path / "few.toml"
    path.write_text(FEW.to_toml(), encoding="utf-8")
    return [sys.executable, "-c", COMMAND, "optimise", str(path)]


@pytest.mark.slow
def test_a_command_in_a_log_has_lines_and_none_if_it_is_quiet(line):
    told, quiet = (
        subprocess.run([*line, *more], capture_output=True, text=True, timeout=300) for more in ([], ["--quiet"])
    )
    assert (told.returncode, quiet.returncode) == (0, 0)
    assert any(LINE.match(each) for each in told.stderr.splitlines())
    assert quiet.stderr == ""
    assert told.stdout == quiet.stdout


@pytest.mark.slow
def test_a_short_command_in_a_log_has_no_bar(line):
    run = subprocess.run([sys.executable, "-m", "camopt", *line[3:]], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0
    assert "%|" not in run.stderr


@pytest.mark.slow
def test_a_command_in_a_terminal_has_a_bar_below_its_messages(line):
    ours, its = pty.openpty()
    termios.tcsetwinsize(its, (30, 100))
    with subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=its, env={**os.environ, "TERM": "xterm"}) as run:
        os.close(its)
        said = b""
        try:
            while some := os.read(ours, 1 << 16):
                said += some
        except OSError:  # as Linux tells the end of a terminal
            pass
    os.close(ours)
    assert run.returncode == 0
    *drawn, last = said.decode().rstrip("\r").split("\r")
    assert any(re.search(r"^ *\d+%\|.* laws/s\]", each) for each in drawn)
    assert last.strip() == ""

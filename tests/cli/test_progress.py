"""How far a command is: shown by a bar in a terminal, and by a line now and then in a log."""

import os
import pty
import re
import subprocess
import sys
from itertools import pairwise
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from camopt import find_scene
from camopt.cli import pace
from camopt.cli.pace import LogLines, Pace, rate_of, time_left


class Clock:
    seconds = 100.0

    def __call__(self):
        return self.seconds


def lines(calls):
    """The lines of a work with calls (seconds since its start, done, total), with when each came."""
    clock, found = Clock(), []
    shown = LogLines("designs", clock, lambda text: found.append((clock.seconds - Clock.seconds, text)))
    for seconds, done, total in calls:
        clock.seconds = Clock.seconds + seconds
        shown(done, total)
    return found


@pytest.mark.parametrize(
    ("first", "seconds", "done", "total", "rate", "left"),
    [
        (0, 3.0, 1, 21, "0.33 designs/s", "0:01:00 left"),
        (0, 2.0, 4, 4, "2 designs/s", "0:00:00 left"),
        (0, 10.0, 1, 1000, "0.1 designs/s", "2:46:30 left"),
        (0, 10.0, 123_456, 246_912, "12,346 designs/s", "0:00:10 left"),
        (500, 10.0, 510, 600, "1 designs/s", "0:01:30 left"),  # the rest was kept by an earlier run
        (500, 10.0, 500, 600, "", ""),
        (0, 100.0, 1, 3, "", "0:03:20 left"),
        (0, 1.0, 1, 2**62, "1 designs/s", "more than 1,000 years left"),
    ],
)
def test_rate_and_time_left_are_those_since_the_first_call(first, seconds, done, total, rate, left):
    clock = Clock()
    since = Pace(clock)
    assert since(first, total) == (0.0, inf)
    clock.seconds += seconds
    now, rest = since(done, total)
    assert (rate_of(now, "designs"), time_left(rest)) == (rate, left)


def test_lines_are_plain():
    assert lines([(0.1, 0, 4000), (20.1, 1000, 4000)]) == [
        (pytest.approx(20.1), "camopt: 1,000 of 4,000 designs (25%), 50 designs/s, 0:01:00 left")
    ]


def test_short_work_has_no_lines():
    assert lines([(0.1 * k, k, 99) for k in range(100)]) == []


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 400)), max_size=60), st.integers(0, 10_000))
def test_lines_come_now_and_then(steps, total):
    calls, seconds, done = [], 0, 0
    for pause, more in steps:
        seconds, done = seconds + pause, min(done + more, total)
        calls.append((seconds, done, total))
    found = [when for when, _ in lines(calls)]
    times = [when for when, *_ in calls]
    assert found[:1] == [when for when in times if when >= pace.QUIET_SECONDS][:1]
    assert len(found) <= 1 + seconds / pace.LINE_SECONDS + 1 / pace.PACE_SHARE
    for one, other in pairwise([*found, inf]):
        assert not any(one + pace.LINE_SECONDS <= when < other for when in times)


COMMAND = """
import sys
from camopt.cli import pace
pace.QUIET_SECONDS = pace.PACE_SHARE = 0.0
from camopt.cli.main import main
sys.exit(main(sys.argv[1:]))
"""
LINE = re.compile(r"camopt: \d+ of \d+ laws \(\d+%\)")


@pytest.fixture
def line(tmp_path):
    """A command over few laws, which takes a moment."""
    path = tmp_path / "few.toml"
    scene = find_scene("two-pauses").replace(**{"search.law": ["cycloidal", "poly345"]})
    path.write_text(scene.to_toml(), encoding="utf-8")
    return [sys.executable, "-c", COMMAND, "optimise", str(path)]


def test_a_command_in_a_log_has_lines_and_none_if_it_is_quiet(line):
    told, quiet = (
        subprocess.run([*line, *more], capture_output=True, text=True, timeout=300) for more in ([], ["--quiet"])
    )
    assert (told.returncode, quiet.returncode) == (0, 0)
    assert any(LINE.match(each) for each in told.stderr.splitlines())
    assert quiet.stderr == ""
    assert told.stdout == quiet.stdout


def test_a_command_in_a_terminal_has_a_bar(line):
    ours, its = pty.openpty()
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
    assert "laws" in said.decode()
    assert not any(LINE.match(each) for each in said.decode().splitlines())

"""Processes that work for another one: their results, and that none outlives it."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import psutil
import pytest

from camopt import BadInput
from camopt.core.engines.processes import THREAD_SETTINGS, processes
from camopt.core.mistakes import Mistake

FOLDER = str(Path(__file__).parent)


def squares(items):
    print("no part of what the command prints")
    return [os.getpid(), *(item**2 for item in items)]


def bad(items):
    raise BadInput([Mistake("here", "key", items[0], "another")])


def limits_of_threads(items):
    return [os.environ.get(name) for name in THREAD_SETTINGS]


def kill_first_process(folder, items):
    """The first process that comes here is killed, as for want of memory."""
    try:
        Path(folder, str(items[0])).mkdir()
    except FileExistsError:
        return items[0]
    return kill_process(items)


def kill_process(items):
    os.kill(os.getpid(), signal.SIGKILL)


def slow(items):
    time.sleep(60)


def slow_but_first(items):
    time.sleep(60 * (items[0] > 0))
    return items[0]


@pytest.fixture
def engine():
    with processes(2) as engine:
        yield engine


def test_results_are_in_order(engine, capfd):
    workers = set()
    for _ in range(2):
        found = list(engine.results_in_order(squares, range(6)))
        assert [value for _, value in found] == [0, 1, 4, 9, 16, 25]
        workers |= {process for process, _ in found}
    assert os.getpid() not in workers
    assert len(workers) <= 2  # the same for more than one call
    assert capfd.readouterr() == ("", "")


def test_processes_share_the_cores(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 7)
    monkeypatch.setenv(THREAD_SETTINGS[0], "5")  # set by the user
    for name in THREAD_SETTINGS[1:]:
        monkeypatch.delenv(name, raising=False)
    with processes(2) as engine:
        assert [*engine.results_in_order(limits_of_threads, range(2))] == 2 * [["5", "3", "3", "3"]]


@pytest.mark.parametrize(("count", "items"), [(1, 3), (2, 1)])
def test_one_process_is_this_one(count, items):
    with processes(count) as engine:
        assert {process for process, _ in engine.results_in_order(squares, range(items))} == {os.getpid()}


def test_processes_start_once_the_items_left_take_long():
    with processes(2, start_seconds=60.0) as engine:
        assert {process for process, _ in engine.results_in_order(squares, range(9))} == {os.getpid()}
    with processes(2, start_seconds=1e-9) as engine:
        found = list(engine.results_in_order(squares, range(9)))
    assert [value for _, value in found] == [item**2 for item in range(9)]
    assert found[0][0] == os.getpid()
    assert os.getpid() not in {process for process, _ in found[1:]}


def test_an_exception_is_that_of_the_work(engine):
    with pytest.raises(BadInput, match="here: key = 3: must be another") as error:
        list(engine.results_in_order(bad, [3, 4]))
    assert "test_processes.py" in str(error.value.__cause__)


@pytest.mark.slow
def test_what_a_killed_process_did_is_done_by_another(engine, tmp_path):
    assert list(engine.results_in_order(partial(kill_first_process, str(tmp_path)), range(3))) == [0, 1, 2]


@pytest.mark.slow
def test_what_kills_each_process_is_told(engine):
    with pytest.raises(OSError, match="was killed from outside 2 times; perhaps the memory is too small"):
        list(engine.results_in_order(kill_process, range(2)))


def test_the_end_of_the_block_ends_what_they_are_at():
    with processes(2) as engine:
        found = engine.results_in_order(slow_but_first, range(9))
        assert next(found) == 0
        workers = [each for each in psutil.Process().children() if "LokyProcess" in " ".join(each.cmdline())]
        assert len(workers) == 2
    assert not [each for each in workers if each.is_running()]
    with pytest.raises(RuntimeError, match="after shutdown"):
        list(engine.results_in_order(slow_but_first, range(9)))


STARTER = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # which who starts the tests may ignore
sys.path.insert(0, {folder!r})
from test_processes import slow, squares
from camopt.core.engines.processes import processes
if True:  # without the guard that multiprocessing asks scripts for
    with processes(2) as engine:
        list(engine.results_in_order(squares, range(4)))
        print("begun", flush=True)
        list(engine.results_in_order(slow, range(4)))
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGKILL", "SIGTERM", "SIGINT"])
def test_none_outlives_what_started_it(name):
    line = [sys.executable, "-c", STARTER.format(folder=FOLDER)]
    with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        assert running.stdout.readline() == "begun\n"
        running.send_signal(signal.Signals[name])
        running.communicate(timeout=30)  # all have standard error: its end is that of the last one
    assert running.returncode


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_frontier_leaves_none(name, code, tmp_path):
    line = [sys.executable, "-m", "camopt", "frontier", "--workers", "2", "--out", str(tmp_path / "out")]
    with subprocess.Popen(line, stderr=subprocess.PIPE, text=True) as running:
        while not _children(running.pid):
            time.sleep(0.05)
            assert running.poll() is None
        running.send_signal(signal.Signals[name])
        _, err = running.communicate(timeout=60)
    assert (running.returncode, err.strip()) == (code, "camopt: interrupted")
    assert list(tmp_path.iterdir()) == []


def _children(process):
    """The processes that one started; the system must say."""
    try:
        return Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8") or any(
            each.read_text(encoding="utf-8") for each in Path(f"/proc/{process}/task").glob("*/children")
        )
    except OSError:
        pytest.skip("no list of processes")

"""Work that is stopped from outside: by the ``progress`` of a caller, by signals."""

import inspect
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest

import camopt
from camopt.cli.main import main
from camopt.show.studies.accuracy import measure_accuracy_costs
from camopt.solve.front.table_certificate import certify_table

COARSE = camopt.find_scene("roller-1000rpm").replace(
    **{
        "synthesis.pieces": 12,
        "search.law": ["harmonic", "cycloidal"],
        "search.base_radius": {"start": 60, "stop": 100, "step": 10},
        "search.offset": [0],
        "search.roller_radius": [5],
    }
)
WORK = {
    "sweep": lambda progress, folder: camopt.sweep(COARSE, folder / "s", progress=progress, keep="front-only"),
    "optimise": lambda progress, _: camopt.optimise(COARSE, progress=progress),
    "synthesise": lambda progress, _: camopt.synthesise(COARSE, progress=progress),
    "frontier": lambda progress, _: camopt.frontier(COARSE, points=2, workers=1, progress=progress),
    "sweep_part": lambda progress, folder: camopt.sweep_part(COARSE, (1, 2), out=folder.parent, progress=progress),
    "merge": lambda progress, folder: camopt.merge([folder / "parts"], progress=progress),
    "certify_table": lambda progress, folder: certify_table(folder / "designs.parquet", progress),
    "measure": lambda progress, _: measure_accuracy_costs(COARSE, progress),
}
"""Whatever takes ``progress``."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("swept")
    camopt.sweep(COARSE, folder)
    camopt.sweep_part(COARSE, (1, 1), out=folder / "parts")
    return folder


def test_all_that_takes_a_progress_is_here():
    public = {name: getattr(camopt, name) for name in camopt.__all__ if inspect.isfunction(getattr(camopt, name))}
    assert {name for name, f in public.items() if "progress" in inspect.signature(f).parameters} <= set(WORK)


@pytest.mark.usefixtures("_boxes")  # blocks leave a journal
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", WORK)
def test_false_stops_at_once(name, folder):
    calls = []

    def progress(done, total):
        calls.append((done, total))
        return False

    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    with pytest.raises(camopt.Stopped, match="stopped by the caller"):
        WORK[name](progress, folder)
    ((done, total),) = calls
    assert 0 <= done <= total
    assert before == {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize("answer", [None, 0, True, []])
def test_no_other_answer_stops(answer):
    assert camopt.optimise(COARSE, progress=lambda done, total: answer).best is not None


# --------------------------------------------------------------------------- signals

SIGNALS = {"SIGINT": 130, "SIGTERM": 143, "SIGHUP": 129}
WAITING = """
import signal, sys, time
from camopt.cli import interrupts
from camopt.cli.main import camopt
from camopt.__main__ import main
interrupts.REPEAT_SECONDS = {once}
def work(context):
    try:
        print("begun", flush=True)
        time.sleep(30)
    finally:
        print("ending", flush=True)
        time.sleep({ending})
camopt.invoke = work
sys.exit(main())
"""


@contextmanager
def waiting_command(ignored=(), once=60.0, ending=0.0):
    """A command that has begun and waits for a signal."""

    def dispositions():
        for name in SIGNALS:
            signal.signal(signal.Signals[name], signal.SIG_IGN if name in ignored else signal.SIG_DFL)

    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    line = [sys.executable, "-c", WAITING.format(once=once, ending=ending), "laws"]
    with subprocess.Popen(line, preexec_fn=dispositions, **pipes) as running:
        try:
            assert running.stdout.readline() == "begun\n"
            yield running
        finally:
            running.kill()


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_ends_a_command_in_order(name):
    with waiting_command() as running:
        running.send_signal(signal.Signals[name])
        out, err = running.communicate(timeout=20)
        assert (running.returncode, out, err.strip()) == (SIGNALS[name], "ending\n", "camopt: interrupted")


IMPORTING = """
import os, signal, sys, weakref
from camopt.__main__ import main

def signalled(*_):
    os.kill(os.getpid(), signal.{name})

class Named:  # an exception in it is a RuntimeError before Python 3.12
    __set_name__ = signalled

class Dropped:
    pass

def in_a_name():
    type("Owner", (), {{"named": Named()}})

def as_an_import_error():  # as extensions of C do
    try:
        signalled()
    except BaseException as trouble:
        raise ImportError("the module failed to import") from None

def in_a_callback():  # where no exception gets out, as of the locks of imports
    dropped = Dropped()
    reference = weakref.ref(dropped, signalled)
    del dropped
    for _ in range(10**8):
        pass

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            {how}()

sys.meta_path.insert(0, Finder())
sys.argv[1:] = ["evaluate", "two-pauses"]
sys.exit(main())
"""


@pytest.mark.parametrize("module", ["camopt.cli.main", "camopt.cli.commands.design", "camopt.scene.turn"])
@pytest.mark.parametrize("how", ["in_a_name", "as_an_import_error", "in_a_callback"])
@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_signal_during_an_import_ends_a_command_as_any_other(name, how, module):
    script = IMPORTING.format(name=name, how=how, module=module)
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stdout, ended.stderr.strip()) == (SIGNALS[name], "", "camopt: interrupted")


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_that_was_ignored_stays_ignored(name):
    with waiting_command(ignored=[name]) as running:
        running.send_signal(signal.Signals[name])
        with pytest.raises(subprocess.TimeoutExpired, match="timed out"):
            running.wait(timeout=0.3)


def test_signals_that_come_together_are_one():
    with waiting_command(ending=0.3) as running:
        for name in ("SIGHUP", "SIGTERM", "SIGHUP"):
            running.send_signal(signal.Signals[name])
        running.stdout.readline()
        running.send_signal(signal.SIGINT)
        _, err = running.communicate(timeout=20)
        assert running.returncode in SIGNALS.values()  # the system may deliver them in another order
        assert err.strip() == "camopt: interrupted"


@pytest.mark.slow
@pytest.mark.parametrize("name", SIGNALS)
def test_a_second_signal_kills_what_does_not_end(name):
    with waiting_command(once=0.0, ending=30.0) as running:
        running.send_signal(signal.SIGTERM)
        assert running.stdout.readline() == "ending\n"
        running.send_signal(signal.Signals[name])
        _, err = running.communicate(timeout=20)
        assert (running.returncode, err) == (-signal.Signals[name], "")


@pytest.mark.parametrize("end", [KeyboardInterrupt("half is kept in x"), camopt.Stopped("half is kept in x")])
def test_an_interrupt_may_say_what_is_kept(end, capsys, monkeypatch):
    def command(context):
        raise end

    monkeypatch.setattr("camopt.cli.main.camopt.invoke", command)
    assert main(["laws"]) == 130
    assert capsys.readouterr().err.strip() == "camopt: half is kept in x"

"""What holds for all tests: how many of their cases are tried (``one_in``), and when slow ones are (``slow``)."""

import gc
import os
import signal
from collections import Counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is imported: as for commands

import pytest
from hypothesis import settings
from support.depth import has_turn, is_deep, is_shared, number_of_commit
from support.ways import boxes_for_front_only

from camopt.core.numerics.workspace import keep_freed_memory

gc.set_threshold(1_000_000)  # until tests are collected: what is made by then stays

settings.register_profile("ci", deadline=None, derandomize=True, max_examples=12)
settings.register_profile("deep", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile("ci")  # before --hypothesis-profile is read


def pytest_configure():
    """Under ``nohup``, or in the background, commands that tests start would ignore signals that tests send."""
    number_of_commit()  # before there are other processes
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    """Leave out what other commits run: cases of ``one_in``, and slow tests unless paths are named."""
    commit, names_paths = number_of_commit(), config.args != config.getini("testpaths")
    cases = Counter((item.path, item.originalname) for item in items)
    met, kept, left = Counter(), [], []
    for item in items:
        mark, test = item.get_closest_marker("one_in"), (item.path, item.originalname)
        runs = is_deep() or (
            (not mark or is_shared(met[test], min(mark.args[0], cases[test]), commit))
            and (names_paths or not item.get_closest_marker("slow") or has_turn(item.nodeid, commit))
        )
        (kept if runs else left).append(item)
        met[test] += 1
    config.hook.pytest_deselected(items=left)
    items[:] = kept


def pytest_collection_finish():
    """From here on garbage is looked for among what tests make alone, and seldom; freed memory is kept."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    keep_freed_memory()


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Run a command in an empty folder: exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    from camopt.cli.main import main

    def call(*arguments):
        code = main([*map(str, arguments)])
        return code, *capsys.readouterr()

    return call


@pytest.fixture
def _few_levels(monkeypatch):
    """A refined front has a dozen rows on each curve in place of a thousand."""
    from camopt.solve.front import refine

    monkeypatch.setattr(refine, "CURVE_LEVELS", 12)


@pytest.fixture
def _boxes():
    with boxes_for_front_only():
        yield

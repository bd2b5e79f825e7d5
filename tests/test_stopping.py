"""Work that is stopped from outside: by the ``progress`` of a caller."""

import inspect

import pytest

import camopt
from camopt.front.certified import certify_table
from camopt.studies.accuracy import measure

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
    "optimise": lambda progress, _: camopt.optimise(COARSE, progress),
    "synthesise": lambda progress, _: camopt.synthesise(COARSE, progress),
    "frontier": lambda progress, _: camopt.frontier(COARSE, points=2, workers=1, progress=progress),
    "certify_table": lambda progress, folder: certify_table(folder / "designs.parquet", progress),
    "measure": lambda progress, _: measure(COARSE, progress),
}
"""Whatever takes ``progress``."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("swept")
    camopt.sweep(COARSE, folder)
    return folder


def test_all_that_takes_a_progress_is_here():
    public = {name: getattr(camopt, name) for name in camopt.__all__ if inspect.isfunction(getattr(camopt, name))}
    assert {name for name, f in public.items() if "progress" in inspect.signature(f).parameters} <= set(WORK)


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
    assert camopt.optimise(COARSE, lambda done, total: answer).best is not None

"""``camopt warm``: what first runs need is compiled, and they compile nothing."""

import json

import pytest

from camopt.core.kernels import compile, dispatchers, kernel_cache
from camopt.core.kernels.compile import TieredKernel

pytestmark = pytest.mark.skipif(compile.NEVER_COMPILE, reason="nothing is compiled")
SMALLEST = "roller-1000rpm"


@pytest.fixture(autouse=True)
def _rule(monkeypatch):
    """The command sets when kernels are compiled for the whole process."""
    for name in ("COMPILATION", "LOADING"):
        monkeypatch.setattr(compile, name, getattr(compile, name))


@pytest.fixture
def nothing_but_machine_code(monkeypatch):
    """A function that, once called, has every kernel fail that is not there."""

    def fail(*_):
        raise AssertionError("a kernel is not there")

    def forbid():
        monkeypatch.setattr(dispatchers, "object_code", fail)
        monkeypatch.setattr(TieredKernel, "run_uncompiled", fail)

    return forbid


@pytest.mark.slow
@pytest.mark.parametrize(
    "first_runs",
    [("optimise", SMALLEST), ("sweep", SMALLEST, "--quiet", "--out", "results"), ("certify", SMALLEST)],
    ids=lambda words: words[0],
)
def test_first_runs_find_what_they_need(first_runs, command, nothing_but_machine_code):
    assert command("warm", SMALLEST, "--quiet")[0] == 0
    nothing_but_machine_code()
    assert command(*first_runs)[0] in (0, 1)


@pytest.mark.slow
def test_a_cam_without_a_size_is_optimised(command, tmp_path, nothing_but_machine_code):
    (tmp_path / "scene.toml").write_text(
        command("scenes", SMALLEST)[1].replace("\nbase_radius =", "\n# base_radius =")
    )
    changed = command("warm", "scene.toml", "--json")
    assert changed[0] == 0, changed
    found = json.loads(changed[1])
    assert found["folder"] == str(kernel_cache.kernel_folder())
    assert found["kernels"] > 0
    nothing_but_machine_code()
    assert command("optimise", "scene.toml")[0] == 0


def test_no_place_for_kernels_is_trouble_with_a_file(command, monkeypatch):
    monkeypatch.setattr("camopt.show.studies.first_runs.kernel_folder", lambda: kernel_cache.NO_FOLDER)
    code, printed, said = command("warm", SMALLEST)
    assert (code, printed) == (3, "")
    assert said == "camopt: there is no folder for compiled kernels; set NUMBA_CACHE_DIR to a folder\n"


def test_a_scene_that_is_none_compiles_nothing(command, nothing_but_machine_code):
    nothing_but_machine_code()
    assert command("warm", SMALLEST, "no-such-scene")[0] == 2

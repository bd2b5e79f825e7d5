"""Fronts, bounds and ties with the linear algebra, the vectors and the instructions of other processors."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.depth import is_deep
from support.ties import results_by_seed

from camopt import load

TESTS = Path(__file__).parents[2]
VECTORS = " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", []))
PROCESSORS = {
    "here": {},
    **{kernel: {"OPENBLAS_CORETYPE": kernel} for kernel in ("Prescott", "Haswell", "SkylakeX")},
    "narrow vectors": {"NPY_DISABLE_CPU_FEATURES": VECTORS},
    "any processor": {"NUMBA_CPU_NAME": "generic"},
}
OTHERS = [name for name in PROCESSORS if name != "here"]
PRODUCT = "import numpy as np; np.ones((688, 416)) @ np.eye(416)"
OTHER_DIGITS = {"narrow vectors"}  # numpy's exponentials and inverse functions of angles are others there
FEW, MANY = (
    (10, 2, 3),
    (0, 200, 1),
)  # spaces of every run, and of .ci/deep: first, count, step


def run(processor, *arguments, cwd=TESTS):
    """What a Python prints under the settings of a processor."""
    environment = {**os.environ, **PROCESSORS[processor]}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode and subprocess.run([sys.executable, "-c", PRODUCT], env=environment, check=False).returncode:
        pytest.skip(f"numpy itself does not run here as on {processor}")
    assert done.returncode == 0, f"{processor}: {done.returncode}\n{done.stderr}"
    return done.stdout


@cache
def ties_on_processor(processor, *spaces):
    """What ``support.ties`` tells of spaces: seed, digest of the table, rows of the front, ties."""
    if processor == "here":
        lines = results_by_seed(*spaces)
    else:
        lines = run(processor, "-m", "support.ties", *map(str, spaces)).splitlines()
    return [line.split() for line in lines]


@pytest.mark.one_in(len(OTHERS))
@pytest.mark.parametrize("processor", OTHERS)
def test_fronts_keep_all_ties_on_every_processor(processor):
    """Boxes give the front of the full sweep, by blocks of any size, and tables are the same bytes."""
    spaces = MANY if is_deep() else FEW
    here, there = ties_on_processor("here", *spaces), ties_on_processor(processor, *spaces)
    assert len(here) == spaces[1]
    assert [line for line in [*here, *there] if line[1] == "failed"] == []
    assert sum(int(ties) for *_, ties in here) >= spaces[1]
    compared = slice(2, None) if processor in OTHER_DIGITS else slice(None)
    assert [line[compared] for line in there] == [line[compared] for line in here]


@pytest.fixture(scope="session")
def main_job(tmp_path_factory):
    """The default sweep with all its designs, by processor, done once."""

    @cache
    def swept(processor):
        out = tmp_path_factory.mktemp("swept")
        run(processor, "-m", "camopt", "sweep", "--rpm", "1000", "--quiet", "--keep", "all", "--out", str(out))
        return out

    return swept


@pytest.mark.long
@pytest.mark.parametrize("processor", OTHERS)
def test_the_default_sweep_row_for_row(processor, main_job):
    """The same rows, and numbers that differ by less than is told, of the larger of a curve's two extremes."""
    for name in ("designs.parquet", "pareto.parquet"):
        here, there = (main_job(each) / name for each in ("here", processor))
        if processor not in OTHER_DIGITS:
            assert here.read_bytes() == there.read_bytes()
        here, there = load(here), load(there)
        told = np.maximum(here.pop("relative_half_width"), there.pop("relative_half_width"))
        numbers = here.select_dtypes(float).columns
        assert here.drop(columns=numbers).equals(there.drop(columns=numbers))
        scale = here[numbers].abs()
        ends = ["pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm"]
        scale[ends] = np.tile(scale[ends].max(axis=1).to_numpy()[:, None], 2)
        apart = np.abs(here[numbers] - there[numbers])
        assert (apart.le(scale.mul(told, axis=0)) | here[numbers].eq(there[numbers])).all(axis=None)

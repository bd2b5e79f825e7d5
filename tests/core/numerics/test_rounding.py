"""Ranges have room for every rounding: random formulas against balls of 200 bits, with several kernels."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from support.balls.ball import precisely
from support.depth import times
from support.formulas import count_missed

TESTS = Path(__file__).parents[2]
KERNELS = {
    "as they are": {},
    "without wide vectors": {
        "OPENBLAS_CORETYPE": "Haswell",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    },
    "without vectors": {
        "OPENBLAS_CORETYPE": "Nehalem",
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    },
}
FORMULAS = times(30, deep=20_000)


@pytest.mark.parametrize("seed", range(3))
@precisely()
def test_ranges_of_formulas_hold_their_exact_values(seed):
    assert count_missed(seed, FORMULAS) == 0


@pytest.mark.long
@pytest.mark.parametrize("kernels", KERNELS)
def test_so_they_do_with_the_kernels_of_other_processors(kernels):
    environment = {**os.environ, **KERNELS[kernels], "PYTHONPATH": str(TESTS)}
    command = [sys.executable, "-W", "ignore", "-m", "support.formulas", "7", "5000"]
    ran = subprocess.run(command, env=environment, cwd=TESTS, capture_output=True, text=True, check=True)
    assert ran.stdout == "0\n"

"""While kernels are compiled: the seconds are counted once, whatever compiles what, and a word is said once."""

import pytest

from camopt.core.kernels import compile_clock, dispatchers
from camopt.core.kernels.compile_clock import COMPILE_CLOCK, CompileClock, compilation_notice


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by hand."""
    time = [0.0]
    monkeypatch.setattr(compile_clock, "monotonic", lambda: time[0])
    return time


def test_a_kernel_that_compiles_another_counts_once(clock):
    found = CompileClock()
    found.begin_compilation()
    clock[0] = 2.0
    found.begin_compilation()
    clock[0] = 3.0
    found.end_compilation()
    assert found.seconds == 0.0
    clock[0] = 7.0
    found.end_compilation()
    clock[0] = 9.0
    assert found.seconds == 7.0


def test_a_word_is_said_at_the_first_kernel_of_a_block():
    said = []
    with compilation_notice(lambda: said.append("compiling")):
        for _ in range(3):
            COMPILE_CLOCK.begin_compilation()
            COMPILE_CLOCK.end_compilation()
    COMPILE_CLOCK.begin_compilation()
    COMPILE_CLOCK.end_compilation()
    assert said == ["compiling"]
    assert COMPILE_CLOCK.depth == 0


def test_numba_tells_it():
    numba = dispatchers.numba
    before, said = COMPILE_CLOCK.seconds, []
    with compilation_notice(lambda: said.append("compiling")):
        assert numba.njit(lambda x: x + 1)(1) == 2
    jit = not numba.config.DISABLE_JIT
    assert (COMPILE_CLOCK.seconds > before, said) == (jit, ["compiling"] if jit else [])

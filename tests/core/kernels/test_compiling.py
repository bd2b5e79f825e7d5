"""A word is said once, when the first kernel of a block is compiled."""

from camopt.core.kernels import dispatchers
from camopt.core.kernels.compile_notice import announce_compilation, compilation_notice


def test_a_word_is_said_at_the_first_kernel_of_a_block():
    said = []
    with compilation_notice(lambda: said.append("compiling")):
        for _ in range(3):
            announce_compilation()
    announce_compilation()
    assert said == ["compiling"]


def test_a_block_without_a_compilation_leaves_no_word():
    with compilation_notice(lambda: 1 / 0):
        pass
    announce_compilation()


def test_numba_tells_it():
    numba, said = dispatchers.numba, []
    with compilation_notice(lambda: said.append("compiling")):
        assert numba.njit(lambda x: x + 1)(1) == 2
    assert said == ([] if numba.config.DISABLE_JIT else ["compiling"])

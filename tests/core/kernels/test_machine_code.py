"""Machine code takes what numba says it takes, and runs in a process that has not imported numba."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numba import typeof
from numba.core.registry import cpu_target

from camopt.core.kernels import compile
from camopt.core.kernels.arguments import (
    NONE,
    argument_c_types,
    as_pinned_tuple,
    flatten_to_machine_arguments,
    kernel_argument_type,
)
from camopt.core.kernels.compile import compiled
from camopt.core.kernels.numba_types import numba_type
from camopt.core.numerics.extremes import SEARCH_ADDRESS, Precision

compiles = pytest.mark.skipif(compile.NEVER_COMPILE, reason="nothing is compiled")
MANY = np.arange(24.0)
ARGUMENTS = [
    *(3, 2.5, True, None, np.float64(0.5), np.int64(-4), (), (1, (2.0, None)), Precision(1e-9, np.inf)),
    *(MANY, MANY.reshape(4, 6), MANY.reshape(4, 6).T, MANY[::2], MANY.reshape(2, 3, 4)[:, ::2], MANY > 3),
    *(np.arange(5), np.empty((0, 3)), (MANY, (MANY,))),
]


@pytest.mark.parametrize("value", ARGUMENTS)
def test_the_type_of_an_argument_is_numbas(value):
    assert numba_type(kernel_argument_type(value)) == typeof(value)


IN_LLVM = {"c_void_p": "pointer", "c_long": "i64", "c_double": "double", "c_bool": "i8"}


def test_a_tuple_that_lasts_is_taken_for_what_it_is():
    value = Precision(MANY, (MANY[::2], None))
    kept = as_pinned_tuple(value)
    assert (kernel_argument_type(kept), flatten_to_machine_arguments([kept, 2])) == (
        kernel_argument_type(value),
        flatten_to_machine_arguments([value, 2]),
    )
    assert kept.location[0] is value.location[0]


@pytest.mark.parametrize("value", [*ARGUMENTS, SEARCH_ADDRESS])
def test_machine_code_takes_the_numbers_that_numba_makes_of_an_argument(value):
    kind = kernel_argument_type(value)
    convention = cpu_target.target_context.call_conv
    shape = convention.get_function_type(numba_type(NONE), (numba_type(kind),))
    asked = ["pointer" if each.is_pointer else str(each) for each in shape.args[2:]]  # after result and error
    assert [IN_LLVM[each.__name__] for each in argument_c_types([kind])] == asked


@pytest.mark.parametrize("value", ARGUMENTS)
def test_a_number_for_each_type(value):
    made = [
        kind(number).value
        for kind, number in zip(
            argument_c_types([kernel_argument_type(value)]), flatten_to_machine_arguments([value]), strict=True
        )
    ]
    assert all(number is None or isinstance(number, int | float) for number in made)


@pytest.mark.parametrize(
    "value", [[1.0], MANY.astype(np.float32), MANY.astype(">f8"), np.array(["a"]), np.array(7.0), "a"]
)
def test_what_no_kernel_takes_is_refused(value):
    with pytest.raises(TypeError, match="a kernel takes numbers, arrays of them, and tuples, not"):
        kernel_argument_type((1.0, value))


@compiled
def add_values(values, way, out):
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            out[0] += way * values[i, j] * (i + 10 * j)


@compiles
@pytest.mark.parametrize("values", [MANY.reshape(4, 6), MANY.reshape(4, 6).T, MANY.reshape(4, 6)[::2, 1:4]])
def test_arrays_of_every_layout_are_read_as_in_python(values):
    found, plain = np.zeros((2, 1))
    add_values(values, 0.5, found)
    add_values.py_func(values, 0.5, plain)
    assert found[0] == plain[0] > 0.0


def raises(x):
    if x[0] > 0.0:
        raise ValueError


@compiles
def test_an_error_in_a_kernel_is_no_silence():
    kernel = compiled(raises)
    kernel(np.zeros(1))
    with pytest.raises(RuntimeError, match="a kernel raised an error"):
        kernel(np.ones(1))


PROGRAMME = """
import math, sys
import numpy as np
from camopt.core.kernels.compile import compiled

@compiled
def halves(x, out):
    for i in range(x.size):
        out[i] = 0.5 * x[i]

@compiled
def doubles(x, out):
    for i in range(x.size):
        out[i] = math.ldexp(x[i], 1)

out = np.empty(3)
globals()[sys.argv[1]](np.arange(3.0), out)
print(out.tolist(), "numba" in sys.modules)
"""


@compiles
@pytest.mark.parametrize(
    ("kernel", "numbers", "numba"), [("halves", [0.0, 0.5, 1.0], False), ("doubles", [0.0, 2.0, 4.0], True)]
)
def test_the_next_process_imports_no_numba_unless_a_kernel_calls_functions_of_its_own(
    tmp_path, kernel, numbers, numba
):
    """``math.ldexp`` is one of numba's: such a kernel is compiled anew."""
    (tmp_path / "programme.py").write_text(PROGRAMME, encoding="utf-8")
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(tmp_path / "kernels"),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }

    def said():
        command = [sys.executable, tmp_path / "programme.py", kernel]
        return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout.strip()

    assert [said(), said()] == [f"{numbers} True", f"{numbers} {numba}"]

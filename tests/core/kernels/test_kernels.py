"""Kernels are compiled where that pays, and give the same bits as plain Python; none takes many arguments."""

import ast
import os
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import TypingError
from support.cams import WORN, cam_with

import camopt
from camopt.core.kernels import compile, dispatchers, kernel_cache
from camopt.core.kernels.address_calls import (
    AddressedKernel,
    address_of_values,
    call_by_address,
    called_by_address,
    function_address,
)
from camopt.core.kernels.arguments import COUNT, NUMBER, ArgumentKind, Record
from camopt.core.kernels.compile import (
    FORMULA_CALL_WORK,
    PLAIN_RUN,
    TieredKernel,
    compiled,
    compiled_once_it_pays,
    nested_curve_count,
)
from camopt.core.kernels.kernel_cache import KernelFile
from camopt.core.kernels.marks import called_by_kernels, inline_in_kernels
from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, workspace
from camopt.core.numerics.extremes import SEARCH_WORK, search_curve, write_all_extremes_of_curve
from camopt.core.numerics.jet import Jet, jet_power
from camopt.core.numerics.workspace import TILE
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.surface import inverse_film_curve
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.scene import Scene, find_scene

pytestmark = pytest.mark.skipif(compile.NEVER_COMPILE, reason="nothing is compiled")


@inline_in_kernels
def half(x):
    return 0.5 * x


def kernel_of_halves(work=0.0, size=1.0):
    """A kernel, each run of which does ``work`` uncompiled, but does not say so before."""

    def start():
        pass

    begin = called_by_kernels(start)
    begin.array_version(lambda: PLAIN_RUN.add_formula_work_within_limit(work - FORMULA_CALL_WORK))

    def halves(x, out):
        begin()
        for i in range(out.size):
            out[i] = half(x[i])

    return TieredKernel(halves, size=size, work=1.0)


def compiles_for(kernel, count):
    """Call the kernel for so many numbers: whether it is compiled then."""
    x, out = np.arange(float(count)), np.empty(count)
    kernel(x, out)
    assert np.array_equal(out, x / 2)
    return bool(kernel.loaded)


def cost_of(kernel):
    """The work for which it is compiled."""
    return kernel.work_left_until_compiling_pays((ArgumentKind(NUMBER.name, 1),) * 2)


@pytest.fixture
def _no_disk(monkeypatch):
    """No kernel is found in the cache, and none is written."""
    monkeypatch.setattr(kernel_cache, "kernel_folder", lambda: Path(os.devnull))


@pytest.mark.usefixtures("_no_disk")
def test_a_few_numbers_compile_nothing_and_many_do(monkeypatch):
    """A run that does more work than compiling, as its numbers alone tell, is not begun."""
    monkeypatch.setattr(compile, "COMPILATION", 997.0)
    kernel = kernel_of_halves()
    many = int(cost_of(kernel))
    assert [compiles_for(kernel, count) for count in (many // 2, many // 3, many, 1)] == [False, False, True, True]
    assert PLAIN_RUN.work == 0.0


@pytest.mark.usefixtures("_no_disk")
@pytest.mark.parametrize("size", [0.37, 1.0, 5.3])
def test_a_kernel_is_compiled_when_its_runs_have_done_the_work_of_that(size):
    kernel = kernel_of_halves(work=0.31 * compile.COMPILATION, size=size)
    runs = int(cost_of(kernel) / (0.31 * compile.COMPILATION))
    assert [compiles_for(kernel, 3) for _ in range(runs + 1)] == [False] * runs + [True]


@pytest.mark.usefixtures("_no_disk")
def test_a_run_that_takes_longer_than_compiling_is_given_up():
    kernel = kernel_of_halves(work=1.01 * cost_of(kernel_of_halves()))
    assert compiles_for(kernel, 3)
    assert kernel.plain_work.total() > compile.COMPILATION


@pytest.mark.usefixtures("_no_disk")
def test_the_same_is_compiled_whatever_the_clock_says(monkeypatch):
    """Seconds decide nothing: a machine that is a thousand times as slow compiles no earlier."""
    for name in ("thread_time", "perf_counter", "monotonic", "process_time", "time"):
        clock = iter(np.arange(0.0, 1e9, 1e3))
        monkeypatch.setattr(time, name, lambda clock=clock: next(clock))
    kernel = kernel_of_halves(work=0.09 * compile.COMPILATION)
    assert [compiles_for(kernel, 2) for _ in range(10)] == [False] * 10


def test_the_import_of_numba_is_part_of_the_cost(monkeypatch):
    import numba

    assert numba
    loaded = cost_of(kernel_of_halves())
    monkeypatch.delitem(sys.modules, "numba")
    assert cost_of(kernel_of_halves()) == loaded + compile.NUMBA_SHARE * compile.COMPILATION


def test_curves_of_curves_take_longer_to_compile():
    curve = Record(tuple, (NUMBER, Record(tuple, (NUMBER, Record(tuple, (NUMBER,)))), Record(tuple, (NUMBER,))))
    assert [nested_curve_count(kind) for kind in (NUMBER, Record(tuple, (NUMBER, NUMBER)), curve)] == [1, 1, 4]


def test_a_kernel_on_disk_is_taken_at_once(monkeypatch, tmp_path):
    monkeypatch.setattr(kernel_cache, "kernel_folder", lambda: tmp_path)
    monkeypatch.setattr(compile, "LOADING", 0.0)
    with monkeypatch.context() as patch:
        patch.setattr(compile, "COMPILATION", 0.0)
        assert compiles_for(kernel_of_halves(), 1)
    again = kernel_of_halves()
    assert compiles_for(again, 1)
    assert "dispatcher" not in vars(again)


def test_the_work_of_a_process_is_no_matter_to_the_next(monkeypatch, tmp_path):
    """Each process has kernels of its own; nothing of them is on disk but machine code."""
    monkeypatch.setattr(kernel_cache, "kernel_folder", lambda: tmp_path)
    assert [compiles_for(kernel_of_halves(0.75 * compile.COMPILATION), 1) for _ in range(3)] == [False] * 3
    assert [*tmp_path.iterdir()] == []


def test_a_process_that_runs_little_imports_nothing_to_load_kernels(monkeypatch):
    monkeypatch.delitem(sys.modules, "llvmlite")
    monkeypatch.setattr(compile.TieredKernel, "whole_work", 0.0)
    kernel = kernel_of_halves()
    assert not compiles_for(kernel, 1)
    assert not kernel.files
    monkeypatch.setattr(compile.TieredKernel, "whole_work", compile.LOADING)
    assert not compiles_for(kernel, 1)
    assert kernel.files


def test_evaluating_a_design_compiles_nothing(monkeypatch):
    def refuse(*_):
        raise AssertionError("a kernel is compiled for a single design")

    monkeypatch.setattr(KernelFile, "exists", False)
    monkeypatch.setattr(dispatchers.Dispatcher, "compile", refuse)
    problem = with_rounding_relative_error(resolve(find_scene("roller-1000rpm")))
    fresh = compiled_once_it_pays(work=SEARCH_WORK)(search_curve.py_func)
    monkeypatch.setattr("camopt.core.numerics.extremes.search_curve", fresh)
    found = curve_of(problem, problem.setup.mechanism.pressure, 1)
    assert np.isfinite(found.value).all()


QUESTIONS = [(15, LARGEST), (15, LEAST), (15, LARGEST_MAGNITUDE), (1, LARGEST)]
MANY = 50  # designs


def curve_of(problem, make, count):
    """Extremes of a curve of a question's mechanism, of designs around the scene's own."""
    rng, sizes = np.random.default_rng(4), problem.design.sizes
    drawn = {name: values[0] * rng.uniform(1.0, 1.3, count) for name, values in sizes.items()}
    case = EvaluationBlock(problem.setup, problem.programme, Designs(**drawn, sense=problem.design.sense))
    return case.extremes(make, QUESTIONS, exact_angles=True)


@pytest.mark.parametrize("name", ["roller-1000rpm", "oscillating-roller", "knife-300rpm-offset"])
@pytest.mark.parametrize("curve", ["pressure", "curvature"])
def test_compiled_and_plain_extremes_are_the_same_bits(name, curve, monkeypatch):
    """Of more designs than there are in a tile; that of the plain form is made as small as the other one."""
    problem = with_rounding_relative_error(resolve(find_scene(name)))
    make = getattr(problem.setup.mechanism, curve)
    monkeypatch.setattr(compile, "COMPILATION", 0.0)
    compiled = curve_of(problem, make, TILE + 1)
    monkeypatch.setattr("camopt.core.numerics.extremes.search_curve", search_curve.py_func)
    monkeypatch.setattr(workspace, "PLAIN_TILE", TILE)
    plain = curve_of(problem, make, TILE + 1)
    for one, other in zip(compiled, plain, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.long
@pytest.mark.parametrize(("contact", "designs"), [("roller", 24), pytest.param("flat", 10, marks=pytest.mark.long)])
def test_a_film_has_the_same_bits_compiled_and_plain(monkeypatch, contact, designs):
    """Its powers are those of the C library; numpy's of arrays differ in the last digit, one time in sixteen.

    The film of a flat face is none where its speed is 0, and takes a hundred times as long.
    """
    problem = with_rounding_relative_error(resolve(Scene.from_dict(cam_with(contact, materials=WORN))))
    film = partial(inverse_film_curve, problem.setup)
    monkeypatch.setattr(compile, "COMPILATION", 0.0)
    compiled = curve_of(problem, film, designs)
    monkeypatch.setattr("camopt.core.numerics.extremes.search_curve", search_curve.py_func)
    plain = curve_of(problem, film, designs)
    for one, other in zip(compiled, plain, strict=True):
        assert np.array_equal(one, other, equal_nan=True)


def machine_code(compiled):
    """The address of a compiled function; 0 if there is none."""
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)


@called_by_kernels
def third(x):
    return x / 3.0


@pytest.mark.usefixtures("_no_disk")
@pytest.mark.parametrize("part", [half, third])
def test_what_kernels_call_becomes_machine_code_with_them_only(part):
    def parts(x, out):
        for i in range(out.size):
            out[i] = part(x[i])

    kernel, x, out = compiled(parts), np.arange(11.0), np.empty(11)
    kernel(x, out)
    assert np.array_equal(out, [part.py_func(number) for number in x])
    assert [machine_code(one) for one in part.dispatcher.overloads.values()] == [0]
    assert all(machine_code(one) for one in kernel.dispatcher.overloads.values())


def test_one_compiled_search_serves_every_curve(monkeypatch):
    monkeypatch.setattr(compile, "COMPILATION", 0.0)
    problem = with_rounding_relative_error(resolve(find_scene("roller-1000rpm")))
    mechanism = problem.setup.mechanism
    for make in (mechanism.pressure, mechanism.curvature, mechanism.sliding):
        curve_of(problem, make, MANY)
    assert len(write_all_extremes_of_curve.loaded) == 1
    assert len(search_curve.loaded) >= 3


@called_by_address(NUMBER, NUMBER, COUNT)
def scaled_power(made, x, power):
    factor, shift = made[0]
    return factor * x**power + shift


@compiled
def scale_each(factor, shift, x, out):
    made = (factor, shift)
    place, code = address_of_values(made), function_address(scaled_power, made)
    for i in range(x.size):
        out[i] = call_by_address(code, (place, x[i], 2))


@compiled
def scaled_wrongly(factor, shift, x):
    made = (factor, shift)
    x[0] = call_by_address(function_address(scaled_power, made), (address_of_values(made), x))


@pytest.mark.usefixtures("_no_disk")
def test_what_is_called_by_address_is_what_is_called_from_python():
    x = np.array([1.0, 2.0, 3.0])
    for factor, shift in ((2.0, 1.0), (2, 1.5)):  # other types: another function at another address
        out, plain = np.empty((2, 3))
        scale_each(factor, shift, x, out)
        scale_each.py_func(factor, shift, x, plain)
        assert out.tolist() == plain.tolist() == [2.0 + shift, 8.0 + shift, 18.0 + shift]


@pytest.mark.usefixtures("_no_disk")
def test_arguments_that_an_address_does_not_take_are_refused():
    with pytest.raises(TypingError, match="No implementation of function"):
        scaled_wrongly(1.0, 1.0, np.ones(2))


@compiled
def halve_all(x):
    for i in range(x.size):
        x[i] *= 0.5


@compiled
def by_address(x, code):
    call_by_address(code, (x,))


@pytest.mark.usefixtures("_no_disk")
def test_an_interrupt_while_a_kernel_is_compiled_that_another_calls_is_an_interrupt(monkeypatch):
    """An address that was never made ended the process."""

    def interrupted(*_):
        raise KeyboardInterrupt("while it is compiled")

    x, kernel = np.ones(2), AddressedKernel(halve_all, (ArgumentKind(NUMBER.name, 1),))
    with monkeypatch.context() as patch:
        patch.setattr(halve_all.dispatcher, "get_compile_result", interrupted)
        with pytest.raises(KeyboardInterrupt, match="while it is compiled"):
            by_address(x, kernel)
    by_address(x, kernel)
    assert np.array_equal(x, [0.5, 0.5])


@pytest.mark.parametrize("exponent", [0.13, -0.35, -0.43])
@pytest.mark.parametrize("low", [-1.0, 0.0])
def test_a_power_of_what_may_be_zero_has_no_bounds_in_plain_python_either(low, exponent):
    with np.errstate(all="ignore"):
        found = jet_power(Jet(np.float64(low), *np.array([1.0, 0.0, 1.0, 1.0, 1.0])), exponent)
    assert found.high == np.inf
    assert not np.isfinite([found.error, found.first, found.second, found.third]).any()


MOST_ARGUMENTS = 8
MARKS = {
    "inline_in_kernels",
    "inline_in_kernels_by_overload",
    "called_by_kernels",
    "compiled",
    "compiled_once_it_pays",
    "called_by_address",
    "value_and_slope_formula",
    "derivative_formula",
    "chosen_by_load_type",
}


def marks(function):
    """The names in a function's decorators."""
    return {node.id for line in function.decorator_list for node in ast.walk(line) if isinstance(node, ast.Name)}


def kernels_of_the_package():
    """All functions that numba compiles: (file, name, number of arguments)."""
    package = Path(camopt.__file__).parent
    for path in sorted(package.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and marks(node) & MARKS:
                given = node.args
                count = len([*given.posonlyargs, *given.args, *given.kwonlyargs])
                yield path.relative_to(package).as_posix(), node.name, count


def test_no_kernel_takes_more_than_eight_arguments():
    found = set(kernels_of_the_package())
    assert {
        ("core/numerics/curve_kernels.py", "evaluate_on_panel", 8),
        ("core/numerics/climbing.py", "shrink_illinois_bracket", 3),
    } <= found
    assert {kernel for kernel in found if kernel[2] > MOST_ARGUMENTS} == set()

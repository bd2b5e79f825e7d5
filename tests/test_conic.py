"""Convex programmes: their expressions are those of numpy, their answers those of a modelling language (cvxpy)."""

from functools import partial

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import find_scene
from camopt.problem.problem import resolve
from camopt.synthesis.conic import (
    ABOVE,
    INFEASIBLE,
    OPTIMAL,
    ZERO,
    Norm,
    Program,
    Variable,
    cones,
    constant,
    stacked,
    within,
    zero,
)
from camopt.synthesis.convex import convex
from camopt.synthesis.from_scene import demand_of
from camopt.synthesis.relaxation import RelaxedMotion
from camopt.synthesis.spline_motion import SplineMotion


@pytest.fixture
def two():
    """A variable of one element and one of four, with values."""
    random = np.random.default_rng(1)
    x, y = Variable(), Variable(4)
    x.found, y.found = random.normal(size=1), random.normal(size=4)
    return x, y


def test_expressions_are_those_of_numpy(two):
    matrix, row = np.random.default_rng(2).normal(size=(2, 3, 4))[0], np.arange(1.0, 5.0)
    formulas = [
        lambda x, y: x + y - 2.0,
        lambda x, y: 3.0 - (row * y - y / row) / 7.0,
        lambda x, y: row * x + 2.0 * (y - y),
        lambda x, y: (matrix @ (y - row))[1:] - x,
        lambda x, y: y[::-1][[0, 0, 2]] + -x,
        lambda x, y: y[-1] * 4.0 + row,
    ]
    x, y = two
    for formula in formulas:
        wanted = formula(x.found, y.found)
        np.testing.assert_allclose(formula(x, y).value, wanted, rtol=1e-13, atol=1e-13)
        assert formula(x, y).size == wanted.size
    np.testing.assert_array_equal(stacked([y, constant(5.0), x]).value, [*y.found, 5.0, *x.found])
    assert Norm(y - row, x).value == pytest.approx(max(np.linalg.norm(y.found - row), abs(x.found)))


def test_a_limit_tells_how_far_it_is_broken(two):
    x, y = two
    x.found, y.found = np.array([2.0]), np.array([3.0, -4.0, 0.0, 1.0])
    assert zero(y - 1.0).broken_by == 5.0
    assert (y >= -1.0).broken_by == (-y <= 1.0).broken_by == 3.0
    assert (y <= 3.0).broken_by == 0.0
    assert max(limit.broken_by for limit in within(y, x)) == 2.0
    assert cones(constant([4.0, 0.0]), y[:2], x).broken_by == pytest.approx(20**0.5)
    (own,) = Norm(y).limits
    assert own.broken_by == 0.0


def of_cvxpy(program):
    """The least goal of the same programme, and what the modelling language says of it."""
    twins = {}

    def twin(expression):
        found = expression.constant
        for variable, matrix in expression.parts.items():
            found = found + matrix @ twins.setdefault(variable, cp.Variable(variable.size))
        return cp.Constant(found) if isinstance(found, np.ndarray) else found

    goal, todo, seen, limits = cp.sum(twin(program.goal)), list(program.limits), set(), []
    while todo or twins.keys() - seen:
        todo += [own for variable in twins.keys() - seen for own in variable.limits]
        seen |= twins.keys()
        for expression, cone in todo:
            value = twin(expression)
            if cone in (ZERO, ABOVE):
                limits.append(value == 0 if cone == ZERO else value >= 0)
            else:
                limits += [cp.norm(value[n + 1 : n + cone]) <= value[n] for n in range(0, expression.size, cone)]
        todo = []
    problem = cp.Problem(cp.Minimize(goal), limits)
    problem.solve(solver=cp.CLARABEL)
    return problem.value, problem.status


@settings(max_examples=times(20, deep=300))
@given(st.integers(0, 2**32 - 1))
def test_random_programmes_have_the_answers_of_a_modelling_language(seed):
    """Within a ball, under planes and cones, some of which exclude each other."""
    random = np.random.default_rng(seed)
    x, t = Variable(random.integers(2, 6)), Variable(positive=True)
    planes = random.normal(size=(random.integers(1, 5), x.size)) @ x - random.normal()
    norm = Norm(x - random.normal(size=x.size), random.normal(size=(3, x.size)) @ x)
    limits = [Norm(x) <= 3.0, planes <= t, cones(t + 1.0 + planes, x[0] - t, 2.0 * x[1])]
    limits += [zero(x[:1] - 0.3), *within(x, 2.0 + t)]
    program = Program(random.normal(size=(1, x.size)) @ x + 3.0 * t + norm + 5.0, limits)
    wanted, status = of_cvxpy(program)
    found = program.solve()
    assert {cp.OPTIMAL: OPTIMAL, cp.INFEASIBLE: INFEASIBLE}[status] == found
    if found == OPTIMAL:
        assert program.value == pytest.approx(wanted, abs=1e-6)
        assert program.goal.value == pytest.approx(wanted, abs=1e-6)
        assert max(limit.broken_by for limit in limits) < 1e-6


@pytest.mark.parametrize("make", [SplineMotion, partial(RelaxedMotion, 8)], ids=["free", "relaxed"])
@pytest.mark.parametrize(
    ("name", "minimise"),
    [
        ("roller-1000rpm", "size"),
        ("flat-reciprocating", {"size": 1, "jerk_rms": 1e-4}),
        ("two-pauses", "acceleration"),
    ],
)
def test_programmes_of_scenes_have_the_answers_of_a_modelling_language(name, minimise, make):
    scene = find_scene(name).replace(**{"synthesis.pieces": 8, "synthesis.minimise": minimise})
    programme = convex(demand_of(resolve(scene)), make)
    wanted, status = of_cvxpy(Program(programme.goal, programme.limits))
    assert status == cp.OPTIMAL
    assert programme.solve() == pytest.approx(programme.unit * wanted, rel=1e-5, abs=1e-6)
    assert programme.exact


def test_what_has_no_answer_says_so():
    x = Variable(2)
    assert Program(x[0], [x >= 1.0, x[1] <= 0.0]).solve() == INFEASIBLE
    assert Program(x[0], [x <= 1.0]).solve() == "DualInfeasible"

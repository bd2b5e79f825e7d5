"""The solver: a compiled programme with other rows is the same as a new one of cvxpy."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from camopt.solve.synthesis.solver import INFEASIBLE_STATUSES, SOLVED, CompiledProgramme, failure_message, solve


@given(st.integers(0, 10**6))
def test_a_compiled_programme_with_rows_is_that_of_cvxpy(seed):
    """Optimum, values and multipliers of random programmes with constraints of each kind, solved three times."""
    rng = np.random.default_rng(seed)
    x, z, y, room = cp.Variable(4), cp.Variable(), cp.Variable(2), cp.Parameter(2)
    equal, side, root = (rng.normal(size=(count, 4)) for count in (1, 2, 3))
    inside, cost = rng.normal(size=4), rng.normal(size=4)
    constraints = [
        equal @ x == equal @ inside,
        cp.norm(cp.hstack([side @ x, root @ x + 1.0])) <= z,
        z <= 50.0,
        cp.abs(y - x[:2]) <= room,
    ]
    goal = cost @ x + 3.0 * z - cp.sum(y) + 0.25
    compiled = CompiledProgramme(cp.Problem(cp.Minimize(goal), constraints), [y, x])
    for _ in range(3):
        room.value = rng.uniform(0.1, 2.0, 2)
        compiled.compile_to_matrices()
        rows = rng.normal(size=(5, 6))
        most = rows @ np.concatenate([inside[:2], inside]) + rng.uniform(0.0, 1.0, 5)
        assert compiled.solve(sparse.csr_array(rows), most) == SOLVED
        ours = compiled.value, x.value, y.value, compiled.row_multipliers
        compiled.set_variables_and_multipliers()
        duals = [each.dual_value for each in constraints]
        limits = [*constraints, rows @ cp.hstack([y, x]) <= most]
        theirs = cp.Problem(cp.Minimize(goal), limits)
        assert solve(theirs) == SOLVED
        assert ours[0] == pytest.approx(theirs.value, rel=1e-6, abs=1e-6)
        for value, expected in zip(ours[1:], (x.value, y.value, limits[-1].dual_value), strict=True):
            assert value == pytest.approx(expected, rel=1e-3, abs=1e-3)
        for value, each in zip(duals, constraints, strict=True):
            assert value == pytest.approx(each.dual_value, rel=1e-3, abs=1e-3)


def test_rows_that_nothing_holds_are_said():
    x = cp.Variable()
    compiled = CompiledProgramme(cp.Problem(cp.Minimize(x), [x >= 2.0]), [x])
    compiled.compile_to_matrices()
    assert compiled.solve(sparse.csr_array([[1.0]]), np.array([1.0])) in INFEASIBLE_STATUSES
    assert compiled.solve(sparse.csr_array([[1.0]]), np.array([3.0])) == SOLVED
    assert (compiled.value, x.value) == (pytest.approx(2.0), pytest.approx(2.0))
    assert solve(cp.Problem(cp.Minimize(x), [x >= 2.0, x <= 1.0])) in INFEASIBLE_STATUSES


def test_a_solver_that_fails_has_a_status_and_a_message(monkeypatch):
    def fail(*given, **options):
        raise cp.SolverError("no")

    monkeypatch.setattr(cp.Problem, "solve", fail)
    x = cp.Variable()
    status = solve(cp.Problem(cp.Minimize(x), [x >= 2.0]))
    assert failure_message(status) == "the convex solver found no solution (it says solver error)"

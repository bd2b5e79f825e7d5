"""Convex programmes of cvxpy, solved by Clarabel: once, or many times with different rows.

Sources: S. Diamond, S. Boyd, CVXPY: a Python-embedded modeling language for convex optimization, J. Mach. Learn.
Res. 17, 2016; P. J. Goulart, Y. Chen, Clarabel: an interior-point solver for conic programs with quadratic
objectives, 2024.
"""

import warnings
from collections.abc import Sequence

import clarabel
import cvxpy as cp
import numpy as np
from cvxpy.reductions.solvers.conic_solvers.clarabel_conif import CLARABEL, dims_to_solver_cones
from scipy import sparse

from camopt.core.numerics import FloatArray

SOLVED = cp.OPTIMAL
SOLVED_STATUSES = (SOLVED, cp.OPTIMAL_INACCURATE)
"""Statuses with a solution; the caller checks an inaccurate one."""
INFEASIBLE = cp.INFEASIBLE
INFEASIBLE_STATUSES = (INFEASIBLE, cp.INFEASIBLE_INACCURATE)
SOLVER_ERROR = 1e-6  # relative error of an optimum


def solve(programme: cp.Problem) -> str:
    """Solve a programme and return its status."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Solution may be inaccurate")
        try:
            programme.solve(
                solver=cp.CLARABEL, warm_start=False
            )  # with one, digits would depend on the last solution
        except cp.SolverError:
            return str(cp.SOLVER_ERROR)
    return str(programme.status)


def failure_message(status: str) -> str:
    """A message for a solver status that is not in ``SOLVED_STATUSES``."""
    return f"the convex solver found no solution (it says {status.replace('_', ' ')})"


class CompiledProgramme:
    """A programme that is solved hundreds of times, each time with different linear rows on some variables.

    cvxpy writes the programme as matrices once, and Clarabel gets these matrices with the rows appended. To cvxpy,
    new rows would be a new programme, and writing it takes longer than solving it.
    """

    def __init__(self, programme: cp.Problem, variables: Sequence[cp.Variable]) -> None:
        self.programme, self.variables = programme, variables
        self.value, self.point = np.inf, np.empty(0)
        self.row_multipliers = np.empty(0)
        """Fall of the least objective per unit of slack in each row."""

    def compile_to_matrices(self) -> None:
        """Write the programme as matrices, with the present values of its parameters."""
        self._data, self._chain, self._inverse = self.programme.get_problem_data(cp.CLARABEL, solver_opts={})
        first = self._data["param_prob"].var_id_to_col
        self._columns = np.concatenate([first[each.id] + np.arange(each.size) for each in self.variables])

    def solve(self, rows: sparse.csr_array, upper_bounds: FloatArray) -> str:
        """Solve with rows·variables ≤ ``upper_bounds``, set the variables, and return the solver's status."""
        data, entries = self._data, rows.tocoo()
        shape = (upper_bounds.size, data["c"].size)
        row_matrix = sparse.csc_array((entries.data, (entries.row, self._columns[entries.col])), shape=shape)
        cones = [*dims_to_solver_cones(data["dims"]), clarabel.NonnegativeConeT(upper_bounds.size)]
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        matrix, bounds = (
            sparse.vstack([data["A"], row_matrix], format="csc"),
            np.concatenate([data["b"], upper_bounds]),
        )
        quadratic = sparse.csc_array((shape[1], shape[1]))
        solution = clarabel.DefaultSolver(quadratic, data["c"], matrix, bounds, cones, settings).solve()
        status = str(CLARABEL.STATUS_MAP.get(str(solution.status), cp.SOLVER_ERROR))
        if status in SOLVED_STATUSES:
            self._solution = solution
            self.value = float(solution.obj_val) + float(self._inverse[-1]["offset"])
            self.row_multipliers = np.array(solution.z[-upper_bounds.size :])
            self.point, start = np.array(solution.x)[self._columns], 0
            for variable in self.variables:
                variable.value = self.point[start : start + variable.size].reshape(variable.shape)
                start += variable.size
        return status

    def set_variables_and_multipliers(self) -> None:
        """Set all variables and multipliers of constraints from the last solution."""
        self.programme.unpack_results(self._solution, self._chain, self._inverse)

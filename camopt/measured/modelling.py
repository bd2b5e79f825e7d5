"""cvxpy as ``cp``, imported without ``scipy.stats``, and its problems solved by Clarabel.

cvxpy takes one function from there, the entropy, for expressions that camopt has no use for; to import the module
takes 0.5 s, three quarters of the import of cvxpy. So something else stands for it meanwhile, which hands on to the
module itself whatever is asked of it, by cvxpy or by another thread.
"""

import sys
import warnings
from importlib import import_module
from types import ModuleType
from typing import Any

STATISTICS = "scipy.stats"


class StandIn(ModuleType):
    """The module, imported when something is asked of it."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if sys.modules.get(STATISTICS) is self:
            del sys.modules[STATISTICS]
        return getattr(import_module(STATISTICS), name)


def imported_quickly() -> Any:
    """The module cvxpy."""
    if STATISTICS in sys.modules or "cvxpy" in sys.modules:
        return import_module("cvxpy")
    stand_in = StandIn(STATISTICS)
    vars(stand_in)["entropy"] = lambda *values, **options: stand_in.__getattr__("entropy")(*values, **options)
    sys.modules[STATISTICS] = stand_in
    try:
        return import_module("cvxpy")
    finally:
        if sys.modules.get(STATISTICS) is stand_in:
            del sys.modules[STATISTICS]


cp = imported_quickly()
SOLVER_ENDS = (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)


def solve(problem: Any) -> str:
    """Solve a problem: its status. What is inaccurate is looked at by whoever uses it."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Solution may be inaccurate")
        try:
            problem.solve(solver=cp.CLARABEL, warm_start=False)  # or digits depend on what was solved before
        except cp.SolverError:
            return str(cp.SOLVER_ERROR)
    return str(problem.status)

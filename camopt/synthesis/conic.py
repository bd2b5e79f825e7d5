"""Convex programmes: a linear goal under limits that are linear or second-order cones. Clarabel solves them.

A modelling language takes longer to import, and to translate such a programme, than the solver to solve it. Whether
a programme is convex is not checked: a norm may only be minimised, or bounded from above.

Source: Goulart and Chen, Clarabel: an interior-point solver for conic programs with quadratic objectives, 2024.
"""

from collections.abc import Iterable, Sequence
from math import nan
from typing import Any, NamedTuple, Union

import clarabel
import numpy as np
from scipy import sparse

from camopt.numerics import FloatArray

Numbers = FloatArray | float
Term = Union["Affine", Numbers]
"""What an expression is added to or compared with."""


class Affine:
    """A vector that is linear in variables: M₁·x₁ + M₂·x₂ + … + b. One of length 1 goes with any other."""

    __array_ufunc__ = None  # numpy leaves operators to those here

    def __init__(self, parts: "dict[Variable, sparse.csr_array]", constant: FloatArray) -> None:
        self.parts, self.constant = parts, constant

    @property
    def size(self) -> int:
        """How many elements it has."""
        return self.constant.size

    @property
    def value(self) -> FloatArray:
        """What it is at the values of its variables."""
        return sum((matrix @ variable.value for variable, matrix in self.parts.items()), self.constant)

    def __getitem__(self, rows: Any) -> "Affine":
        kept = np.atleast_1d(np.arange(self.size)[rows])
        return Affine({variable: matrix[kept] for variable, matrix in self.parts.items()}, self.constant[kept])

    def repeated(self, size: int) -> "Affine":
        """Its one element so many times."""
        return self if self.size == size else self[np.zeros(size, dtype=int)]

    def __add__(self, other: Term) -> "Affine":
        if not isinstance(other, Affine):
            other = constant(other)
        size = max(self.size, other.size)
        parts = dict(self.repeated(size).parts)
        for variable, matrix in other.repeated(size).parts.items():
            parts[variable] = parts[variable] + matrix if variable in parts else matrix
        return Affine(parts, self.constant + other.constant)

    def __mul__(self, factor: Numbers) -> "Affine":
        """Element by element."""
        factors = np.array(factor, dtype=float, ndmin=1)
        each = self.repeated(max(self.size, factors.size))
        by_row = np.broadcast_to(factors, each.size)
        return Affine({v: _scaled(matrix, by_row) for v, matrix in each.parts.items()}, each.constant * factors)

    def __rmatmul__(self, matrix: Any) -> "Affine":
        parts = {variable: sparse.csr_array(matrix @ part) for variable, part in self.parts.items()}
        return Affine(parts, matrix @ self.constant)

    def __neg__(self) -> "Affine":
        return self * -1.0

    def __sub__(self, other: Term) -> "Affine":
        return self + -other

    def __rsub__(self, other: Term) -> "Affine":
        return -self + other

    def __truediv__(self, divisor: Numbers) -> "Affine":
        return self * (1.0 / divisor)

    def __ge__(self, other: Term) -> "Limit":
        return Limit(self - other, ABOVE)

    def __le__(self, other: Term) -> "Limit":
        return Limit(other - self, ABOVE)

    __radd__, __rmul__ = __add__, __mul__


class Variable(Affine):
    """A vector that a programme finds, of elements that are positive or not."""

    def __init__(self, size: int = 1, *, positive: bool = False) -> None:
        super().__init__({self: sparse.eye_array(size, format="csr")}, np.zeros(size))
        self.found = np.full(size, nan)
        """Its values: those of a solution, or set by hand."""
        self.limits = [self >= 0.0] if positive else []

    @property
    def value(self) -> FloatArray:
        return self.found


class Norm(Variable):
    """A variable no less than the norms of some expressions. Its value is the largest of these."""

    def __init__(self, *each: Affine) -> None:
        super().__init__()
        self.each = each
        self.limits = [Limit(stacked([self, one]), 1 + one.size) for one in each]

    @property
    def value(self) -> FloatArray:
        return np.array([max(float(np.linalg.norm(one.value)) for one in self.each)])


def _scaled(matrix: sparse.csr_array, factors: FloatArray) -> sparse.csr_array:
    """Each row of a matrix times a factor."""
    data = matrix.data * np.repeat(factors, np.diff(matrix.indptr))
    return sparse.csr_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)


def constant(value: Numbers) -> Affine:
    """What no variable changes."""
    return Affine({}, np.array(value, dtype=float, ndmin=1))


def stacked(each: Sequence[Affine]) -> Affine:
    """Expressions one below another."""
    ends = np.cumsum([one.size for one in each])

    def rows(variable: Variable) -> sparse.csr_array:
        counts = np.zeros(ends[-1] + 1, dtype=int)
        found = [(end, one.parts[variable]) for end, one in zip(ends, each, strict=True) if variable in one.parts]
        for end, part in found:
            counts[end + 1 - part.shape[0] : end + 1] = np.diff(part.indptr)
        data, columns = (np.concatenate([getattr(part, of) for _, part in found]) for of in ("data", "indices"))
        return sparse.csr_array((data, columns, np.cumsum(counts)), shape=(ends[-1], variable.size))

    variables = dict.fromkeys(variable for one in each for variable in one.parts)
    return Affine({v: rows(v) for v in variables}, np.concatenate([one.constant for one in each]))


# --------------------------------------------------------------------------------------------------- limits

ZERO, ABOVE = 0, 1


class Limit(NamedTuple):
    """An expression that is 0, no less than 0, or in second-order cones."""

    expression: Affine
    cone: int
    """ZERO, ABOVE, or the dimension of the cones √(b² + c² + …) ≤ a, whose elements follow each other."""

    @property
    def broken_by(self) -> float:
        """How far the values of the variables are beyond it; 0 within it."""
        value = self.expression.value
        if self.cone == ZERO:
            return float(np.abs(value).max())
        top, *others = value.reshape(-1, self.cone).T
        return float(np.max(np.sqrt(sum(other**2 for other in others)) - top, initial=0.0))


def zero(expression: Affine) -> Limit:
    """The limit that an expression is 0."""
    return Limit(expression, ZERO)


def within(expression: Affine, most: Term) -> list[Limit]:
    """The limits of the magnitude of each element."""
    return [expression <= most, expression >= -most]


def cones(top: Affine, *others: Affine) -> Limit:
    """The limit √(b² + c² + …) ≤ a for each element a of ``top`` and those of the others beside it."""
    each = (top, *others)
    size, dimension = max(one.size for one in each), len(each)
    by_cone = np.arange(dimension * size).reshape(dimension, size).T.ravel()
    return Limit(stacked([one.repeated(size) for one in each])[by_cone], dimension)


# ----------------------------------------------------------------------------------------------- programmes

OPTIMAL, NEARLY_OPTIMAL = "Solved", "AlmostSolved"
INFEASIBLE, NEARLY_INFEASIBLE = "PrimalInfeasible", "AlmostPrimalInfeasible"
SOLVED = (OPTIMAL, NEARLY_OPTIMAL)


class Program:
    """A goal to minimise under limits, and what became of it.

    After ``solve``, ``status`` is what the solver says, and of a solution ``value`` is the least goal.
    """

    def __init__(self, goal: Affine, limits: Iterable[Limit]) -> None:
        self.goal, self.limits = goal, tuple(limits)
        self.status, self.value = "", nan

    def solve(self) -> str:
        """Solve it: the status. If there is a solution, exact or not, the variables have its values then."""
        limits = sorted(self._limits(), key=lambda limit: min(limit.cone, 2))
        rows = stacked([self.goal, *(limit.expression for limit in limits)])
        matrix = sparse.hstack(list(rows.parts.values()), format="csr")
        matrix.eliminate_zeros()
        settings, none = clarabel.DefaultSettings(), sparse.csc_array((matrix.shape[1],) * 2)
        settings.verbose = False
        every = [cone for limit in limits for cone in _cones(limit)]
        cost, above = matrix[[0]].toarray()[0], sparse.csc_array(-matrix[1:])
        solution = clarabel.DefaultSolver(none, cost, above, rows.constant[1:], every, settings).solve()
        self.status = str(solution.status)
        if self.status in SOLVED:
            self.value = solution.obj_val + rows.constant[0].item()
            ends = np.cumsum([variable.size for variable in rows.parts])
            for variable, values in zip(rows.parts, np.split(np.array(solution.x), ends), strict=False):
                variable.found = values
        return self.status

    def _limits(self) -> list[Limit]:
        """Its own limits, and those that its variables have."""
        seen = dict(self.goal.parts)
        limits = [*self.limits, *(limit for variable in seen for limit in variable.limits)]
        for limit in limits:  # which grow
            for variable in limit.expression.parts:
                limits += () if variable in seen else variable.limits
            seen |= limit.expression.parts
        return limits


def _cones(limit: Limit) -> list[Any]:
    """The solver's cones of a limit."""
    size, dimension = limit.expression.size, limit.cone
    if dimension in (ZERO, ABOVE):
        return [(clarabel.ZeroConeT, clarabel.NonnegativeConeT)[dimension](size)]
    return [clarabel.SecondOrderConeT(dimension)] * (size // dimension)

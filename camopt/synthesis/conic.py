"""Convex programmes with linear limits and cones, solved by Clarabel.

    minimise g(x) + ‖F(x)‖²    with    rows(x) = 0,  rows(x) ≥ 0,  ‖sides(x)‖ ≤ most(x)

All of it is linear in the unknowns, and collected as ``rows``.

Sources: S. Boyd, L. Vandenberghe, Convex Optimization, ch. 4 and 5; P. J. Goulart, Y. Chen, Clarabel: an
interior-point solver for conic programs with quadratic objectives, 2024.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import clarabel
import numpy as np
from scipy import sparse

from camopt.numerics import FloatArray
from camopt.synthesis.rows import AffineRows, ConvexRows, LinearSum, Parameter, Unknown, stacked

SOLVED, NEARLY_SOLVED, INFEASIBLE = "Solved", "AlmostSolved", "PrimalInfeasible"
SOLVER_ENDS = (SOLVED, NEARLY_SOLVED)
"""What the solver says where there is a solution; what is nearly one is looked at by whoever uses it."""
NO_SOLUTION = (INFEASIBLE, "AlmostPrimalInfeasible")


class ConicProgramme:
    """The least of a sum, and of the squares of sums, under the limits of some rows."""

    def __init__(self, goal: LinearSum, *limits: ConvexRows, squares: Sequence[LinearSum] = ()) -> None:
        self.goal, self.limits = stacked([goal]), limits
        self.status, self.value = "", np.inf
        self.squared: Unknown | None = None
        if squares:  # by unknowns of their own: the cost is near 0 where they are, and exact
            every, equal = stacked(squares), ConvexRows()
            self.squared = Unknown(every.constant.size)
            equal.zero((-np.eye(self.squared.count), self.squared), *every.terms)
            self.limits = (*limits, equal)

    @property
    def unknowns(self) -> list[Unknown]:
        """All that it is solved for."""
        rows = [self.goal, *(kind for each in self.limits for kind in each.kinds.every)]
        every = dict.fromkeys(unknown for each in rows for unknown in each.unknowns)
        return [unknown for unknown in every if not isinstance(unknown, Parameter)]

    def solve(self) -> str:
        """Solve it, which gives the unknowns their values and rows their multipliers; what the solver says."""
        unknowns = self.unknowns
        ends = np.cumsum([0, *(unknown.count for unknown in unknowns)])
        columns = {unknown: int(start) for unknown, start in zip(unknowns, ends[:-1], strict=True)}
        parts, cones = self._parts()
        matrix, constant = _in_columns([part for _, part in parts], columns, int(ends[-1]))
        cost, at_rest = _in_columns([self.goal], columns, int(ends[-1]))
        quadratic = np.zeros(ends[-1])
        if self.squared:
            quadratic[columns[self.squared] :][: self.squared.count] = 2.0
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        found = clarabel.DefaultSolver(
            sparse.csc_matrix(sparse.diags_array(quadratic)),
            cost.toarray()[0],
            sparse.csc_matrix(-matrix),
            constant,
            cones,
            settings,
        ).solve()
        self.status = str(found.status)
        if self.status in SOLVER_ENDS:
            solution, multipliers = np.array(found.x), -np.array(found.z)
            self.value = float(found.obj_val) + float(at_rest[0])
            for unknown, start in columns.items():
                part = solution[start : start + unknown.count]
                unknown.value = part if unknown.is_vector else float(part[0])
            self._tell(parts, multipliers)
        return self.status

    def _parts(self) -> tuple[list[tuple[ConvexRows, AffineRows]], list[Any]]:
        """The rows in the order of the solver's cones, each with the limits that they are of; and these cones."""
        zero = [(each, rows) for each in self.limits if (rows := each.kinds.zero) is not None]
        at_least = [(each, rows) for each in self.limits if (rows := each.kinds.at_least) is not None]
        round_ = [(each, cones) for each in self.limits if (cones := each.kinds.cones) is not None]
        counts = [sum(rows.constant.size for _, rows in some) for some in (zero, at_least)]
        plain = [clarabel.ZeroConeT(counts[0]), clarabel.NonnegativeConeT(counts[1])]
        found = [cone for cone, count in zip(plain, counts, strict=True) if count]
        sizes = (size for _, cones in round_ for size in cones.sizes)
        found += [clarabel.SecondOrderConeT(size) if size > 1 else clarabel.NonnegativeConeT(1) for size in sizes]
        return [*zero, *at_least, *((each, cones.rows) for each, cones in round_)], found

    def _tell(self, parts: Iterable[tuple[ConvexRows, AffineRows]], multipliers: FloatArray) -> None:
        """Give each of the limits the multipliers of its rows."""
        told: dict[int, list[FloatArray]] = {id(each): [] for each in self.limits}
        start = 0
        for limits, rows in parts:
            told[id(limits)].append(multipliers[start : start + rows.constant.size])
            start += rows.constant.size
        for limits in self.limits:
            limits.multipliers = np.concatenate([np.empty(0), *told[id(limits)]])


def _in_columns(parts: Sequence[AffineRows], columns: dict[Unknown, int], count: int) -> tuple[Any, FloatArray]:
    """AffineRows one below another, as a matrix of given columns and a constant: parameters are in that."""
    found: list[tuple[FloatArray, Any, Any]] = []
    constants, start = [np.empty(0)], 0
    for rows in parts:
        constant = rows.constant
        if rows.unknowns:
            each = rows.matrix.tocoo()
            to = np.concatenate(
                [np.arange(u.count) + columns[u] if u in columns else np.full(u.count, -1) for u in rows.unknowns]
            )
            free = to[each.col] >= 0
            found.append((each.data[free], start + each.row[free], to[each.col][free]))
            if not free.all():
                given = [np.zeros(u.count) if u in columns else np.ravel(u.value) for u in rows.unknowns]
                constant = constant + rows.matrix @ np.concatenate(given)
        constants.append(constant)
        start += constant.size
    if not found:
        return sparse.csr_array((start, count)), np.concatenate(constants)
    data, *at = (np.concatenate(each) for each in zip(*found, strict=True))
    return sparse.csr_array((data, tuple(at)), shape=(start, count)), np.concatenate(constants)

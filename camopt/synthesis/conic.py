"""Convex programmes with linear limits and cones, solved by Clarabel.

    minimise g(x) + ‖F(x)‖²    with    rows(x) = 0,  rows(x) ≥ 0,  ‖sides(x)‖ ≤ most(x)

All of it is linear in the unknowns, and collected as rows. A row is a sum of terms, each a coefficient and what it
multiplies: a matrix and a vector of unknowns, or a weight for each row and one unknown or a number. The rows of a
kind are one sparse matrix, made once; a modelling language takes longer over the expressions of a hundred small
limits than the solver over the programme.

Sources: S. Boyd, L. Vandenberghe, Convex Optimization, ch. 4 and 5; P. J. Goulart, Y. Chen, Clarabel: an
interior-point solver for conic programs with quadratic objectives, 2024.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import clarabel
import numpy as np
from scipy import sparse

from camopt.numerics import FloatArray

LinearTerm = tuple[Any, Any]
"""A coefficient and what it multiplies."""
LinearSum = Sequence[LinearTerm]

SOLVED, NEARLY_SOLVED, INFEASIBLE = "Solved", "AlmostSolved", "PrimalInfeasible"
SOLVER_ENDS = (SOLVED, NEARLY_SOLVED)
"""What the solver says where there is a solution; what is nearly one is looked at by whoever uses it."""
NO_SOLUTION = (INFEASIBLE, "AlmostPrimalInfeasible")


class Unknown:
    """A variable of programmes, or a vector of them, with the value that the last programme gave it."""

    def __init__(self, count: int | None = None) -> None:
        self.count, self.is_vector = 1 if count is None else count, count is not None
        self.value: Any = None


class Parameter(Unknown):
    """What stands in programmes as an unknown does, but has a value when they are solved."""


class AffineRows(NamedTuple):
    """Sums of terms one below another: a matrix times unknowns, and a constant."""

    matrix: Any
    unknowns: tuple[Unknown, ...]
    constant: FloatArray

    @property
    def value(self) -> FloatArray:
        """At the values of the unknowns."""
        if not self.unknowns:
            return self.constant
        return np.asarray(self.matrix @ np.concatenate([np.ravel(u.value) for u in self.unknowns]) + self.constant)

    @property
    def terms(self) -> list[LinearTerm]:
        """The same as one sum of terms."""
        ends, found = np.cumsum([0, *(u.count for u in self.unknowns)]), list[LinearTerm]()
        for unknown, start, end in zip(self.unknowns, ends[:-1], ends[1:], strict=True):
            part = self.matrix[:, start:end]
            found.append((part if unknown.is_vector else part.toarray()[:, 0], unknown))
        return [*found, (self.constant, 1.0)]


def value_of(terms: LinearSum) -> FloatArray:
    """The rows of a sum of terms at the values of the unknowns."""
    return stacked([terms]).value


def times(factor: Any, terms: LinearSum) -> list[LinearTerm]:
    """A sum of terms times a number, or each of its rows times one."""
    if not np.ndim(factor):
        return [(factor * coefficient, unknown) for coefficient, unknown in terms]
    return [(_rows_times(factor, coefficient), unknown) for coefficient, unknown in terms]


def _rows_times(factors: FloatArray, coefficient: Any) -> Any:
    if np.ndim(coefficient) < 2:  # a sparse matrix has two dimensions, too
        return factors * coefficient
    return sparse.diags_array(factors, format="csr") @ sparse.csr_array(coefficient)


def negated(terms: LinearSum) -> list[LinearTerm]:
    """The terms of a sum with the other sign."""
    return times(-1.0, terms)


def stacked(sums: Sequence[LinearSum]) -> AffineRows:
    """Sums of terms one below another."""
    counts = [max((_row_count(coefficient) for coefficient, _ in terms), default=1) for terms in sums]
    ends = np.cumsum([0, *counts])
    constant, places, found = np.zeros(ends[-1]), _Places(), []
    for terms, count, start in zip(sums, counts, ends[:-1], strict=True):
        rows = np.arange(start, start + count)
        for coefficient, unknown in terms:
            if not isinstance(unknown, Unknown):
                constant[rows] += np.asarray(coefficient) * unknown
                continue
            column = places[unknown]
            if unknown.is_vector:
                part = sparse.csr_array(coefficient)
                found.append((part.data, np.repeat(rows, np.diff(part.indptr)), column + part.indices))
            else:
                found.append((np.broadcast_to(coefficient, count), rows, np.full(count, column)))
    if not found:
        return AffineRows(None, (), constant)
    data, *at = (np.concatenate(parts) for parts in zip(*found, strict=True))
    matrix = sparse.csr_array((data, tuple(at)), shape=(ends[-1], places.size))
    return AffineRows(matrix, tuple(places.columns), constant)


def _row_count(coefficient: Any) -> int:
    return int(np.shape(coefficient)[0]) if np.ndim(coefficient) else 1


class _Places:
    """The column at which each unknown of some rows starts."""

    def __init__(self) -> None:
        self.columns: dict[Unknown, int] = {}
        self.size = 0

    def __getitem__(self, unknown: Unknown) -> int:
        if unknown not in self.columns:
            self.columns[unknown] = self.size
            self.size += unknown.count
        return self.columns[unknown]


@dataclass(frozen=True)
class Cones:
    """Second-order cones: in the rows of each the largest, and then the sides."""

    rows: AffineRows
    sizes: tuple[int, ...]


class RowKinds(NamedTuple):
    """The rows of some limits by kind, each None if there are none."""

    zero: AffineRows | None
    at_least: AffineRows | None
    cones: Cones | None

    @property
    def every(self) -> list[AffineRows]:
        """One kind after the other."""
        kinds = (self.zero, self.at_least, self.cones.rows if self.cones else None)
        return [each for each in kinds if each is not None]


class ConvexRows:
    """Limits on unknowns: some of those of a programme, and what it knows of them once it is solved."""

    def __init__(self) -> None:
        self._at_least: list[LinearSum] = []
        self._zero: list[LinearSum] = []
        self._products: list[tuple[LinearSum, LinearSum, LinearSum]] = []
        self._cones: list[tuple[LinearSum, list[LinearSum]]] = []
        self.multipliers = np.empty(0)
        """What the least objective gains for each of ``all`` rows, if it were one higher."""

    def at_least(self, *terms: LinearTerm) -> None:
        """Hold the sum of some terms at 0 or above."""
        self._at_least.append(terms)

    def zero(self, *terms: LinearTerm) -> None:
        """Hold the sum of some terms at 0."""
        self._zero.append(terms)

    def product(self, one: LinearSum, other: LinearSum, root: LinearSum) -> None:
        """Hold the product of two sums, both at least 0, at the square of a third or above: a rotated cone."""
        self._products.append(([*one, *other], times(2.0, root), [*one, *negated(other)]))

    def cone(self, most: LinearSum, sides: Sequence[LinearSum]) -> None:
        """Hold the root of the sum of squares of all rows of some sums at another sum or below."""
        self._cones.append((most, list(sides)))

    def add(self, other: "ConvexRows") -> None:
        """Hold what other rows hold as well."""
        self._at_least += other._at_least
        self._zero += other._zero
        self._products += other._products
        self._cones += other._cones

    @cached_property
    def kinds(self) -> RowKinds:
        """Rows that are 0, rows that are at least 0, and cones; nothing may be added after that."""
        zero, at_least = (stacked(sums) if sums else None for sums in (self._zero, self._at_least))
        return RowKinds(zero, at_least, self._as_cones())

    def _as_cones(self) -> Cones | None:
        sums = [each for most, sides in self._cones for each in (most, *sides)]
        sizes = [1 + stacked(sides).constant.size for _, sides in self._cones]
        if self._products:
            apart = stacked([each for place in range(3) for one in self._products for each in (one[place],)])
            count = apart.constant.size // 3
            order = np.arange(3 * count).reshape(3, count).T.ravel()
            together = AffineRows(apart.matrix[order], apart.unknowns, apart.constant[order])
            sums += [together.terms]
            sizes += [3] * count
        return Cones(stacked(sums), tuple(sizes)) if sums else None

    @property
    def all(self) -> FloatArray:
        """All rows at the values of the unknowns, one kind after the other."""
        return np.concatenate([np.empty(0), *(each.value for each in self.kinds.every)])

    @property
    def broken_by(self) -> float:
        """How far the values of the unknowns are beyond the limit that they break the most; 0 if they hold all."""
        zero, at_least, cones = self.kinds
        found = [0.0]
        found += [] if zero is None else [float(np.abs(zero.value).max(initial=0.0))]
        found += [] if at_least is None else [float(-at_least.value.min(initial=0.0))]
        if cones is not None:
            for cone in np.split(cones.rows.value, np.cumsum(cones.sizes)[:-1]):
                found.append(float(np.linalg.norm(cone[1:]) - cone[0]))
        return max(found)


class ConicProgramme:
    """The least of a sum, and of the squares of sums, under the limits of some rows."""

    def __init__(self, goal: LinearSum, *limits: ConvexRows, squares: Sequence[LinearSum] = ()) -> None:
        self.goal, self.limits = stacked([goal]), limits
        self.status, self.value = "", np.inf
        self.squared = Unknown(stacked(squares).constant.size) if squares else None
        if self.squared:  # by unknowns of their own: the cost is near 0 where they are, and exact
            equal, start = ConvexRows(), 0
            for each in squares:
                count = stacked([each]).constant.size
                rows = np.eye(self.squared.count)[start : start + count]
                equal.zero((-rows, self.squared), *each)
                start += count
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
        found += [clarabel.SecondOrderConeT(size) for _, cones in round_ for size in cones.sizes]
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

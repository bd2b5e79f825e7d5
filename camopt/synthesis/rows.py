"""Limits on unknowns as rows: sums of terms, one below another in a sparse matrix for each kind of limit.

A row is a sum of terms, each a coefficient and what it multiplies: a matrix and a vector of unknowns, or a weight
for each row and one unknown or a number. The rows of a kind are one matrix, made once: a modelling language takes
longer over the expressions of a hundred small limits than the solver over the programme.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from camopt.numerics import FloatArray

LinearTerm = tuple[Any, Any]
"""A coefficient and what it multiplies."""
LinearSum = Sequence[LinearTerm]


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
    return [(_product(factor, coefficient), unknown) for coefficient, unknown in terms]


def _product(factor: Any, coefficient: Any) -> Any:
    if np.ndim(factor) and np.ndim(coefficient) == 2:  # of each row; a sparse matrix has two dimensions, too
        return sparse.diags_array(factor, format="csr") @ sparse.csr_array(coefficient)
    return factor * coefficient


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
            apart = stacked([product[place] for place in range(3) for product in self._products])
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

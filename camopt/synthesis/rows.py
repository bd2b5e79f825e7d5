"""The limits of a convex programme, collected as the rows of one matrix for each kind of limit.

A row is a sum of terms, each a coefficient and what it multiplies: a matrix and a vector of variables, or a weight
for each row and one variable or a number. cvxpy takes longer over the expressions of a hundred small limits than a
solver over the programme; a matrix is one expression.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from camopt.synthesis.modelling import cp

LinearTerm = tuple[Any, Any]
"""A coefficient and what it multiplies."""


class ConvexRows:
    """The limits of a motion, or of a whole programme."""

    def __init__(self) -> None:
        self._at_least: list[Sequence[LinearTerm]] = []
        self._zero: list[Sequence[LinearTerm]] = []
        self._cones: list[tuple[Sequence[LinearTerm], Sequence[LinearTerm], Sequence[LinearTerm]]] = []

    def at_least(self, *terms: LinearTerm) -> None:
        """Hold the sum of some terms at 0 or above."""
        self._at_least.append(terms)

    def zero(self, *terms: LinearTerm) -> None:
        """Hold the sum of some terms at 0."""
        self._zero.append(terms)

    def product(self, one: Sequence[LinearTerm], other: Sequence[LinearTerm], root: Sequence[LinearTerm]) -> None:
        """Hold the product of two sums, both at least 0, at the square of a third or above: a rotated cone."""
        self._cones.append(([*one, *other], _times(2.0, root), [*one, *negated(other)]))

    def add(self, other: "ConvexRows") -> None:
        """Hold what other rows hold as well."""
        self._at_least += other._at_least
        self._zero += other._zero
        self._cones += other._cones

    @property
    def limits(self) -> list[Any]:
        """One limit of each kind, if there is any."""
        found = [stacked(self._at_least) >= 0.0] if self._at_least else []
        found += [stacked(self._zero) == 0.0] if self._zero else []
        if self._cones:
            most, *sides = (stacked(sums) for sums in zip(*self._cones, strict=True))
            found.append(cp.SOC(most, cp.vstack(sides)))
        return found


def negated(terms: Sequence[LinearTerm]) -> list[LinearTerm]:
    """The terms of a sum with the other sign."""
    return _times(-1.0, terms)


def _times(factor: float, terms: Sequence[LinearTerm]) -> list[LinearTerm]:
    return [(factor * coefficient, unknown) for coefficient, unknown in terms]


def stacked(sums: Sequence[Sequence[LinearTerm]]) -> Any:
    """Sums of terms one below another, as one expression."""
    counts = [max(np.shape(coefficient)[0] if np.ndim(coefficient) else 1 for coefficient, _ in s) for s in sums]
    ends = np.cumsum(counts)
    constant, places, found = np.zeros(ends[-1]), _Places(), []
    for terms, count, end in zip(sums, counts, ends, strict=True):
        start, rows = end - count, np.arange(end - count, end)
        for coefficient, unknown in terms:
            if not isinstance(unknown, cp.Expression):
                constant[start:end] += np.asarray(coefficient) * unknown
                continue
            column = places[unknown]
            if unknown.ndim:
                part = sparse.csr_array(coefficient)
                found.append((part.data, np.repeat(rows, np.diff(part.indptr)), column + part.indices))
            else:
                found.append((np.broadcast_to(coefficient, count), rows, np.full(count, column)))
    if not found:
        return cp.Constant(constant)
    data, *at = (np.concatenate(parts) for parts in zip(*found, strict=True))
    matrix = sparse.csr_array((data, tuple(at)), shape=(ends[-1], places.size))
    return matrix @ cp.hstack(places.unknowns) + constant


class _Places:
    """The column at which each variable of some rows starts."""

    def __init__(self) -> None:
        self.unknowns: list[Any] = []
        self.size = 0
        self._columns: dict[int, int] = {}

    def __getitem__(self, unknown: Any) -> int:
        if unknown.id not in self._columns:
            self._columns[unknown.id] = self.size
            self.unknowns.append(unknown)
            self.size += unknown.size
        return self._columns[unknown.id]

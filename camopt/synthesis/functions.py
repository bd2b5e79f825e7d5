"""Convex functions of unknowns: what limits hold below a bound, and what programmes minimise."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camopt.synthesis.rows import ConvexRows, LinearSum, Unknown, negated, stacked, times


class ConvexFunction(Protocol):
    """A function that is convex in unknowns."""

    @property
    def value(self) -> float:
        """At the values of the unknowns."""

    def times(self, factor: float) -> "ConvexFunction":
        """The function times a number above 0."""

    def below(self, bound: LinearSum, rows: ConvexRows) -> None:
        """Hold it at a sum or below."""


@dataclass(frozen=True)
class Linear:
    """A sum of terms."""

    terms: LinearSum

    @property
    def value(self) -> float:
        return float(stacked([self.terms]).value[0])

    def times(self, factor: float) -> "Linear":
        return Linear(times(factor, self.terms))

    def below(self, bound: LinearSum, rows: ConvexRows) -> None:
        rows.at_least(*bound, *negated(self.terms))


@dataclass(frozen=True)
class Norm:
    """The root of the sum of the squares of all rows of some sums; 0 of none."""

    sums: list[LinearSum]

    @property
    def value(self) -> float:
        return float(np.linalg.norm(stacked(self.sums).value)) if self.sums else 0.0

    def times(self, factor: float) -> "Norm":
        return Norm([times(factor, each) for each in self.sums])

    def below(self, bound: LinearSum, rows: ConvexRows) -> None:
        rows.cone(bound, self.sums)


@dataclass(frozen=True)
class LargestNorm:
    """The largest of some norms."""

    norms: list[Norm]

    @property
    def value(self) -> float:
        return max(each.value for each in self.norms)

    def times(self, factor: float) -> "LargestNorm":
        return LargestNorm([each.times(factor) for each in self.norms])

    def below(self, bound: LinearSum, rows: ConvexRows) -> None:
        for each in self.norms:
            each.below(bound, rows)


@dataclass(frozen=True)
class Magnitudes:
    """The sum of the magnitudes of all rows of some sums."""

    sums: list[LinearSum]

    @property
    def value(self) -> float:
        return float(np.abs(stacked(self.sums).value).sum()) if self.sums else 0.0

    def times(self, factor: float) -> "Magnitudes":
        return Magnitudes([times(factor, each) for each in self.sums])

    def below(self, bound: LinearSum, rows: ConvexRows) -> None:
        if not self.sums:
            rows.at_least(*bound)
            return
        each = stacked(self.sums)
        above = Unknown(each.constant.size)
        one = np.eye(each.constant.size)
        rows.at_least((one, above), *each.terms)
        rows.at_least((one, above), *negated(each.terms))
        rows.at_least(*bound, (-np.ones((1, above.count)), above))

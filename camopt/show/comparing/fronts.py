"""Compares two Pareto fronts: dominated points, hypervolume and distance, in one normalisation.

A front covers another if each point of the other is dominated by, or equal to, one of its points. It is better if
it covers the other and is not covered by it (Zitzler et al. 2003). Hypervolume, IGD⁺ (Ishibuchi et al. 2015) and
the additive ε use costs normalised between the ideal and the nadir of both fronts together.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.solve.front.pareto import cost_scale, hypervolume_and_exactness, is_non_dominated


@dataclass(frozen=True)
class FrontSide:
    """One of two fronts, compared with the other."""

    points: int
    hypervolume: float
    """Front quality, 0 to 1, higher is better.

    It is the dominated share of the box between the ideal of both fronts and a point a tenth beyond their nadir.
    """
    exact: bool
    """Whether the hypervolume is exact."""
    dominated: int
    """Number of points that the other front dominates."""
    shared: int
    """Number of points that both fronts have."""
    behind_mean: float | None
    """IGD⁺: mean distance by which the other front is ahead; 0 if this front covers it."""
    behind_most: float | None
    """Additive ε: the smallest shift of this front, in all objectives, with which it covers the other.

    It is below 0 if this front is ahead everywhere. Like the mean, it is None if a front has no finite point.
    """

    @property
    def uncovered_point_count(self) -> int:
        """Number of points that the other front does not cover."""
        return self.points - self.dominated - self.shared


@dataclass(frozen=True, eq=False)
class Fronts:
    """The comparison of two fronts with the same objectives."""

    a: FrontSide
    b: FrontSide
    costs: tuple[FloatArray, FloatArray]
    """Costs of each front, (points, objectives)."""

    @property
    def has_same_points(self) -> bool:
        """Whether both fronts have the same points."""
        return not self.a.points - self.a.shared and not self.b.points - self.b.shared

    @property
    def verdict_sentence(self) -> str:
        """A sentence on which front is better, and where."""
        a, b = self.a, self.b
        if not (a.points and b.points):
            return (
                "Only A has a front." if a.points else "Only B has a front." if b.points else "Neither has a front."
            )
        if self.has_same_points:
            return "The fronts are the same."
        if a.uncovered_point_count and b.uncovered_point_count:
            ahead = {"A": b.behind_most, "B": a.behind_most}
            shares = [f"{name}'s by at most {lead:.3g}" for name, lead in ahead.items() if lead is not None]
            size = f": {', '.join(shares)} of the range of an objective" if shares else ""
            return f"Each front is better in places{size}."
        better, side = ("A", b) if a.uncovered_point_count else ("B", a)
        where = "everywhere" if side.dominated == side.points else "in places, and equal elsewhere"
        return f"{better}'s front is better {where}."

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain values."""
        return {
            "same": self.has_same_points,
            "told": self.verdict_sentence,
            "a": asdict(self.a),
            "b": asdict(self.b),
        }


def compare_fronts(a: FloatArray, b: FloatArray) -> Fronts:
    """Compare two fronts, given as costs of non-dominated points, (points, objectives)."""
    a, b = a + 0.0, b + 0.0  # no −0
    both = np.concatenate([a, b])
    normalised = cost_scale(both).normalise_costs(both)
    one, other = normalised[: len(a)], normalised[len(a) :]
    kept = is_non_dominated(both) if len(both) else np.zeros(0, bool)
    return Fronts(
        _compare_front_with_other(a, b, one, other, int(np.sum(~kept[: len(a)]))),
        _compare_front_with_other(b, a, other, one, int(np.sum(~kept[len(a) :]))),
        (a, b),
    )


def _compare_front_with_other(
    costs: FloatArray,
    other_costs: FloatArray,
    normalised_costs: FloatArray,
    other_normalised_costs: FloatArray,
    dominated_count: int,
) -> FrontSide:
    """One front compared with the other: costs of both, then normalised costs of both."""
    import moocore  # noqa: PLC0415, not needed to compare two cams

    volume, exact = hypervolume_and_exactness(normalised_costs) if len(normalised_costs) else (0.0, True)
    other_points = {tuple(row) for row in other_costs.tolist()}
    normalised_costs, other_normalised_costs = map(
        _finite_clipped_points, (normalised_costs, other_normalised_costs)
    )
    have_distances = bool(len(normalised_costs) and len(other_normalised_costs))
    return FrontSide(
        points=len(costs),
        hypervolume=volume,
        exact=exact,
        dominated=dominated_count,
        shared=sum(tuple(row) in other_points for row in costs.tolist()),
        behind_mean=float(moocore.igd_plus(normalised_costs, ref=other_normalised_costs))
        if have_distances
        else None,
        behind_most=float(moocore.epsilon_additive(normalised_costs, ref=other_normalised_costs))
        if have_distances
        else None,
    )


def _finite_clipped_points(normalised_costs: FloatArray) -> FloatArray:
    """Points without an infinite cost, which have a distance; an infinite gain becomes the ideal."""
    return np.maximum(normalised_costs[np.all(normalised_costs < np.inf, axis=1)], 0.0)

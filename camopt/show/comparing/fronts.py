"""Two Pareto fronts: what each dominates of the other, hypervolume and distance in one normalisation.

Of two fronts one is better if it covers the other, each point of which is dominated by or equal to one of its own,
and is not covered in turn (Zitzler et al. 2003). Hypervolume, IGD⁺ (Ishibuchi et al. 2015) and the additive ε are
of costs between the ideal and the nadir of both fronts together.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.solve.front.pareto import cost_scale, hypervolume, is_non_dominated


@dataclass(frozen=True)
class FrontSide:
    """One of two fronts, seen from the other."""

    points: int
    hypervolume: float
    """The share dominated of the box between the ideal of both fronts and a point a tenth beyond their nadir."""
    exact: bool
    """Whether the hypervolume is exact."""
    dominated: int
    """Points that a point of the other front dominates."""
    shared: int
    """Points whose objectives a point of the other front has too."""
    behind_mean: float | None
    """IGD⁺: how far the points of the other front are ahead of this one, in the mean; 0 if it covers them."""
    behind_most: float | None
    """Additive ε: the most by which they are ahead, in the objective where they are so the least; below 0 if this
    front is ahead of each of them. Like the mean it is None where a front has no point of finite costs."""

    @property
    def uncovered_points(self) -> int:
        """Points that the other front does not cover."""
        return self.points - self.dominated - self.shared


@dataclass(frozen=True, eq=False)
class Fronts:
    """Two fronts of the same objectives."""

    a: FrontSide
    b: FrontSide
    costs: tuple[FloatArray, FloatArray]
    """Of each front, (points, objectives)."""

    @property
    def has_same_points(self) -> bool:
        """Whether each front has the points of the other, in objectives."""
        return not self.a.points - self.a.shared and not self.b.points - self.b.shared

    @property
    def verdict_sentence(self) -> str:
        """Which front is better, and where, in words."""
        a, b = self.a, self.b
        if not (a.points and b.points):
            return (
                "Only A has a front." if a.points else "Only B has a front." if b.points else "Neither has a front."
            )
        if self.has_same_points:
            return "The fronts are the same."
        if a.uncovered_points and b.uncovered_points:
            ahead = {"A": b.behind_most, "B": a.behind_most}
            shares = [f"{name}'s by at most {most:.3g}" for name, most in ahead.items() if most is not None]
            of = f": {', '.join(shares)} of the range of an objective" if shares else ""
            return f"Each front is better in places{of}."
        better, side = ("A", b) if a.uncovered_points else ("B", a)
        where = "everywhere" if side.dominated == side.points else "in places, and as good elsewhere"
        return f"{better}'s front is better {where}."

    def to_dict(self) -> dict[str, Any]:
        """The same as plain values."""
        return {
            "same": self.has_same_points,
            "told": self.verdict_sentence,
            "a": asdict(self.a),
            "b": asdict(self.b),
        }


def compare_fronts(a: FloatArray, b: FloatArray) -> Fronts:
    """Two fronts as costs, (points, objectives); each has no point that another of it dominates."""
    a, b = a + 0.0, b + 0.0  # no −0
    scale = cost_scale(np.concatenate([a, b]))
    normalised = scale.normalise_costs(np.concatenate([a, b]))
    one, other = normalised[: len(a)], normalised[len(a) :]
    kept = is_non_dominated(np.concatenate([a, b])) if len(a) + len(b) else np.zeros(0, bool)
    return Fronts(
        _front_side(a, b, one, other, int(np.sum(~kept[: len(a)]))),
        _front_side(b, a, other, one, int(np.sum(~kept[len(a) :]))),
        (a, b),
    )


def _front_side(
    mine: FloatArray, others: FloatArray, here: FloatArray, there: FloatArray, dominated: int
) -> FrontSide:
    """One front beside the other: costs, then both normalised."""
    import moocore  # noqa: PLC0415, two cams are compared without it

    volume, exact = hypervolume(here) if len(here) else (0.0, True)
    known = {tuple(row) for row in others.tolist()}
    here, there = _finite_points(here), _finite_points(there)
    known_distances = bool(len(here) and len(there))
    return FrontSide(
        points=len(mine),
        hypervolume=volume,
        exact=exact,
        dominated=dominated,
        shared=sum(tuple(row) in known for row in mine.tolist()),
        behind_mean=float(moocore.igd_plus(here, ref=there)) if known_distances else None,
        behind_most=float(moocore.epsilon_additive(here, ref=there)) if known_distances else None,
    )


def _finite_points(normalised: FloatArray) -> FloatArray:
    """The points to which there is a distance: without an infinite cost; an infinite gain is the ideal."""
    return np.maximum(normalised[np.all(normalised < np.inf, axis=1)], 0.0)

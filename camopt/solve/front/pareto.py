"""Pareto fronts: the non-dominated rows, a thinned set that represents them, hypervolume and knee.

Objectives are compared as costs: unchanged if minimised, negated if maximised. An infinite cost is worse than any
finite one, an infinite gain better. Rows that share an infinite value compare by their other objectives.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, FloatArray
from camopt.scene.problem.rows import DesignRows, Objectives, QuantityColumns, join_and_release_rows
from camopt.solve.tables.result import to_json_values

LARGEST_COST = np.finfo(float).max
REFERENCE_POINT = 1.1  # in normalised objectives: a tenth beyond the nadir, so that the ends of a front count
INFINITE_COST = 1e6  # stands for an infinite cost in a sum
EXACT_WORK = 1e9  # an exact hypervolume takes seconds up to this value of points^(objectives − 2)
SAMPLED_WORK = 1e9  # points × directions of an approximate hypervolume that takes as long


def objective_costs(columns: QuantityColumns, count: int, objectives: Objectives) -> FloatArray:
    """The objectives as numbers to minimise, (rows, objectives)."""
    return np.column_stack([sign * columns[name] + np.zeros(count) for name, sign in objectives.items()])


def row_costs(rows: DesignRows, objectives: Objectives) -> FloatArray:
    """The objectives of each row as numbers to minimise, (rows, objectives)."""
    return objective_costs(rows.columns, rows.count, objectives)


def best_row_of_each_law(rows: DesignRows, objectives: Objectives) -> DesignRows:
    """The first row of each pair of laws when sorted by the objectives in turn, the best law first."""
    if rows.count:
        rows = rows.take(np.lexsort(row_costs(rows, objectives).T[::-1]))
    if not any(np.ndim(rows.columns[laws]) for laws in ("law_rise", "law_return")):
        return rows.take(np.arange(min(rows.count, 1)))
    first: dict[tuple[str, str], int] = {}
    for i, laws in enumerate(zip(rows.column("law_rise"), rows.column("law_return"), strict=True)):
        first.setdefault(laws, i)
    return rows.take(np.array([*first.values()], dtype=int))


def non_dominated(rows: DesignRows, objectives: Objectives) -> DesignRows:
    """The rows that no other row dominates, in their order.

    Rows that are equal in all objectives are all kept: they are different designs.
    """
    return rows.take(is_non_dominated(row_costs(rows, objectives))) if rows.count else rows


def is_non_dominated(costs: FloatArray) -> BoolArray:
    """Which costs (rows, objectives) no other ones dominate; equal costs are all kept."""
    import moocore

    return np.asarray(moocore.is_nondominated(np.nan_to_num(costs), keep_weakly=True))


class FrontArchive:
    """The exact front of rows that arrive in blocks; it holds at most a few times as many rows as the front.

    Rows are filtered column by column, so that few columns are in memory twice at a time.
    """

    def __init__(self, objectives: Objectives, least_new_rows: int) -> None:
        """Filter the rows whenever the new ones exceed ``least_new_rows`` and the number of kept rows."""
        self._objectives, self._least = objectives, least_new_rows
        self._parts: list[DesignRows] = []
        self._kept = self._new = 0

    def add(self, rows: DesignRows) -> None:
        self._parts.append(DesignRows({**rows.columns}, rows.count))
        self._new += rows.count
        if self._new > max(self._kept, self._least):
            self.front()

    def front(self) -> DesignRows:
        """The non-dominated rows so far, in the order in which they were added."""
        if self._new:
            costs = np.concatenate([row_costs(part, self._objectives) for part in self._parts])
            masks = np.split(is_non_dominated(costs), np.cumsum([part.count for part in self._parts])[:-1])
            kept = [
                part.take_and_release(mask) for part, mask in zip(self._parts, masks, strict=True) if mask.any()
            ]
            self._parts = [join_and_release_rows(kept)]
            self._kept, self._new = self._parts[0].count, 0
        return DesignRows({**self._parts[0].columns}, self._kept)

    def take_front(self) -> DesignRows:
        """The front; the archive is empty afterwards."""
        front, self._parts = self.front(), []
        return front


class CostScale(NamedTuple):
    """The least and the largest finite cost of each objective over a front, (objectives,)."""

    ideal: FloatArray
    nadir: FloatArray

    def normalise_costs(self, costs: FloatArray) -> FloatArray:
        """Costs with the ideal at 0 and the nadir at 1; infinite costs stay, or are 0 if a whole objective is."""
        width = self.nadir - self.ideal
        finite = np.isfinite(costs)
        share = (np.where(finite, costs, self.ideal) - self.ideal) / np.where(width > 0.0, width, 1.0)
        return np.where(finite, share, np.where(finite.any(axis=0), costs, 0.0))


def cost_scale(costs: FloatArray) -> CostScale:
    """The scale of a front from its finite costs; 0 to 0 for an objective without any."""
    finite = np.isfinite(costs)
    ideal = np.min(costs, axis=0, where=finite, initial=LARGEST_COST)
    nadir = np.max(costs, axis=0, where=finite, initial=-LARGEST_COST)
    has_finite = finite.any(axis=0)
    return CostScale(np.where(has_finite, ideal, 0.0), np.where(has_finite, nadir, 0.0))


def hypervolume_and_exactness(normalised: FloatArray) -> tuple[float, bool]:
    """Share of the box from 0 to REFERENCE_POINT that points (n, objectives) dominate, and whether it is exact.

    Points with an infinite cost dominate nothing. An objective that is 0 for all points does not change the share.
    If the exact hypervolume takes too long, it is averaged over directions (Deng and Zhang 2019).
    """
    import moocore

    counted = np.maximum(normalised[np.all(normalised < REFERENCE_POINT, axis=1)], 0.0)
    counted = counted[:, np.any(counted > 0.0, axis=0)]
    points, many = counted.shape
    if not points or not many:
        return float(points > 0), True
    reference, box = [REFERENCE_POINT] * many, REFERENCE_POINT**many
    if float(points) ** (many - 2) <= EXACT_WORK:
        return float(moocore.hypervolume(counted, ref=reference)) / box, True
    directions = max(int(SAMPLED_WORK / points), 1000)
    return float(moocore.hv_approx(counted, ref=reference, nsamples=directions)) / box, False


def knee_index(normalised: FloatArray) -> int:
    """The row with the least sum of normalised costs, the first of several.

    With two objectives it is the row furthest below the chord between the ends of the front. With more, it is the
    row furthest below the plane through the nadir of each objective.
    """
    return int(np.argmin(_cost_sums(normalised)))


def _cost_sums(normalised: FloatArray) -> FloatArray:
    """The sum of each row's normalised costs; infinite gains count as the ideal, costs as INFINITE_COST."""
    sums: FloatArray = np.clip(normalised, 0.0, INFINITE_COST).sum(axis=1)
    return sums


def thin_front(rows: DesignRows, objectives: Objectives, epsilon: float) -> DesignRows:
    """Rows that represent a front: for each row of the front, one of them costs at most ε more in every objective.

    Objectives are normalised over the front. In each box of side ε that no other box dominates (Laumanns et al.
    2002) the row with the least sum is kept. The ends and the knee of the front are kept too.
    """
    if not rows.count:
        return rows
    import moocore

    costs = row_costs(rows, objectives)
    normalised = cost_scale(costs).normalise_costs(costs)
    sums, boxes = _cost_sums(normalised), np.nan_to_num(np.floor(normalised / epsilon))
    order = np.argsort(sums, kind="stable")
    kept = order[moocore.is_nondominated(boxes[order], keep_weakly=False)]
    ends = [np.lexsort((sums, column))[0] for column in normalised.T]
    return rows.take(np.unique([*kept, *ends, knee_index(normalised)]))


@dataclass(frozen=True)
class Front:
    """The summary of a front."""

    points: int
    hypervolume: float
    """The dominated share of the box between the ideal and a point a tenth beyond the nadir."""
    exact: bool
    """Whether the hypervolume is exact."""
    ideal: dict[str, float]
    """The best finite value of each objective on the front."""
    nadir: dict[str, float]
    """The worst finite value of each objective on the front."""
    knee: dict[str, Any]
    """The row with the least sum of objectives, normalised from ideal to nadir."""
    grid_points: int | None = None
    """For a refined front: the number of points on the front of the grid."""
    grid_hypervolume: float | None = None
    """For a refined front: the hypervolume of the grid's front, between the same ideal and nadir."""

    def to_dict(self) -> dict[str, Any]:
        """The summary as plain values, with None for infinite ones."""
        return dict(to_json_values(self))


def summarise_front(rows: DesignRows, objectives: Objectives, grid: DesignRows | None = None) -> Front | None:
    """The summary of a front, and of the grid's front that it refines; None if it is empty."""
    if not rows.count:
        return None
    costs = row_costs(rows, objectives)
    scale = cost_scale(costs)
    normalised = scale.normalise_costs(costs)
    volume, exact = hypervolume_and_exactness(normalised)
    before = (
        None if grid is None else hypervolume_and_exactness(scale.normalise_costs(row_costs(grid, objectives)))[0]
    )
    return Front(
        points=rows.count,
        hypervolume=volume,
        exact=exact,
        ideal=_objective_values(scale.ideal, objectives),
        nadir=_objective_values(scale.nadir, objectives),
        knee=rows.take(np.array([knee_index(normalised)])).records()[0],
        grid_points=None if grid is None else grid.count,
        grid_hypervolume=before,
    )


def _objective_values(costs: FloatArray, objectives: Objectives) -> dict[str, float]:
    return {name: sign * float(cost) + 0.0 for (name, sign), cost in zip(objectives.items(), costs, strict=True)}

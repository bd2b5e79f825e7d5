"""Find the points of a set that known points dominate.

The known points are the leaves of a tree of neighbours. A branch has the lowest and the highest cost in each
objective, which often decide: a point that costs no less than the highest is dominated by the whole branch, and a
point that costs less than the lowest in some objective is dominated by none of it.

Source: H. T. Kung, F. Luccio, F. P. Preparata, On finding the maxima of a set of vectors, J. ACM 22 (1975), for the
question; the tree is one of bounding boxes.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camopt.core.kernels.compile import compiled_once_it_pays
from camopt.core.numerics import BoolArray, FloatArray, IndexArray, IntArray

TREE_BRANCHES = 8
REBUILD_SHARE = 0.25  # share of new points at which the large tree is built again
COMPARE_WORK = 30.0  # work of comparing one point with a tree, in values of a curve
COMPARED_AT_ONCE = 8192  # points that are compared at once, so that they fit into the cache


class BoundTree(NamedTuple):
    """Lowest and highest costs of branches (nodes, objectives), level by level from the root."""

    least: FloatArray
    most: FloatArray
    starts: IntArray
    """First node of each level, then the number of nodes (levels + 1,). Each branch of a level has eight nodes."""


class Dominators:
    """Known points, as costs (m, objectives); infinities as the largest number."""

    def __init__(self, costs: FloatArray) -> None:
        least = most = costs[neighbour_order(costs)]
        levels = [(least, most)]
        while len(least) > 1:
            least, most = _group_by_branch(least).min(axis=1), _group_by_branch(most).max(axis=1)
            levels.append((least, most))
        least, most = (np.concatenate([_pad_to_branches(level[k]) for level in levels[::-1]]) for k in (0, 1))
        sizes = [len(_pad_to_branches(level)) for level, _ in levels[::-1]]
        self._tree = BoundTree(least, most, np.concatenate([[0], np.cumsum(sizes)]))

    def mask_dominated_points(self, costs: FloatArray) -> BoolArray:
        """Which points (n, objectives) a known point dominates (n,): it costs no more in any and less in one."""
        found = np.zeros(len(costs), dtype=bool)
        stack = np.empty((2, TREE_BRANCHES * len(self._tree.starts)), np.int64)
        mark_dominated_points(self._tree, np.ascontiguousarray(costs), found, stack)
        return found


def _pad_to_branches(costs: FloatArray) -> FloatArray:
    """Fill nodes up to a multiple of a branch with nodes that dominate nothing."""
    return np.concatenate([costs, np.full((-len(costs) % TREE_BRANCHES, costs.shape[1]), np.inf)])


def _group_by_branch(costs: FloatArray) -> FloatArray:
    """Nodes grouped by the branches of the level above."""
    return _pad_to_branches(costs).reshape(-1, TREE_BRANCHES, costs.shape[1])


@compiled_once_it_pays(work=COMPARE_WORK)
def mark_dominated_points(tree, costs, dominated, stack):
    """Mark the points that a known point of a tree dominates."""
    objectives, last = costs.shape[1], tree.starts.size - 2
    for i in range(costs.shape[0]):
        waiting = 0
        for k in range(min(TREE_BRANCHES, tree.starts[1])):
            stack[0, waiting], stack[1, waiting] = 0, k
            waiting += 1
        while waiting:
            waiting -= 1
            level, place = stack[0, waiting], stack[1, waiting]
            node = tree.starts[level] + place
            some, every, less = True, True, False
            for m in range(objectives):
                mine = costs[i, m]
                some &= tree.least[node, m] <= mine
                every &= tree.most[node, m] <= mine
                less |= tree.most[node, m] < mine
            if every and less:
                dominated[i] = True
                break
            if some and level < last:
                for k in range(TREE_BRANCHES):
                    stack[0, waiting], stack[1, waiting] = level + 1, TREE_BRANCHES * place + k
                    waiting += 1


@mark_dominated_points.array_version
def _mark_dominated_points_in_python(tree, all_costs, dominated, stack):
    """Mark many points together, level by level."""
    roots = int(tree.starts[1])
    for first in range(0, len(all_costs), COMPARED_AT_ONCE):
        costs, found = (column[first : first + COMPARED_AT_ONCE] for column in (all_costs, dominated))
        point, branch = np.repeat(np.arange(len(costs)), roots), np.tile(np.arange(roots), len(costs))
        for start in tree.starts[:-1]:
            least, most, mine = tree.least[start + branch], tree.most[start + branch], costs[point]
            found[point[np.all(most <= mine, axis=1) & np.any(most < mine, axis=1)]] = True
            open_ = np.all(least <= mine, axis=1) & ~found[point]
            point, branch = (np.repeat(index[open_], TREE_BRANCHES) for index in (point, branch))
            branch = TREE_BRANCHES * branch + np.arange(branch.size) % TREE_BRANCHES


class PointTree:
    """A growing set of points, which finds the points that it dominates.

    Most points are in a large tree, which is built again when the set has grown by a share. The others are in a
    small tree.
    """

    def __init__(self, objectives: int) -> None:
        none = np.empty((0, objectives))
        self._most, self._recent, self._count = Dominators(none), [none], 0

    def add_and_find_dominated(self, costs: FloatArray) -> BoolArray:
        """Add points (n, objectives); return a mask (n,) of those that a point of the large tree dominates."""
        dominated = self._most.mask_dominated_points(costs)
        self._recent.append(costs[~dominated])
        return dominated

    def dominators(self, all_undominated: Callable[[], FloatArray]) -> "Dominators | TreePair":
        """The points as dominators.

        ``all_undominated`` returns all undominated points, if the large tree is built again.
        """
        recent = np.concatenate(self._recent)
        if len(recent) > max(REBUILD_SHARE * self._count, COMPARED_AT_ONCE):
            costs, recent = all_undominated(), np.empty((0, recent.shape[1]))
            self._most, self._count = Dominators(costs), len(costs)
        self._recent = [recent]
        return TreePair(self._most, Dominators(recent)) if len(recent) else self._most


class TreePair(NamedTuple):
    """Known points in two trees."""

    most: Dominators
    recent: Dominators

    def mask_dominated_points(self, costs: FloatArray) -> BoolArray:
        """Which points a known point dominates; see ``Dominators``."""
        dominated = self.most.mask_dominated_points(costs)
        dominated[~dominated] = self.recent.mask_dominated_points(costs[~dominated])
        return dominated


def neighbour_order(costs: FloatArray) -> IndexArray:
    """Order of points in which the points of a branch are near each other.

    The points are sorted by the objective in which their ranks have the largest spread. Then each half is sorted in
    the same way, and so on.
    """
    ranks = np.column_stack([_normalised_ranks(column) for column in costs.T]).astype(np.float32)
    order, size = np.arange(len(costs)), TREE_BRANCHES
    while size < len(costs):
        size *= TREE_BRANCHES
    while size > TREE_BRANCHES and len(costs):
        here, part = ranks[order], np.arange(len(order)) // size
        first = np.arange(0, len(order), size)
        spread = np.maximum.reduceat(here, first) - np.minimum.reduceat(here, first)
        along = np.take_along_axis(here, np.argmax(spread, axis=1)[part][:, None], axis=1)[:, 0]
        order, size = order[np.lexsort((along, part))], size // 2
    return order


def _normalised_ranks(values: FloatArray) -> FloatArray:
    """Rank of each value among the different values, from 0 to 1."""
    different, rank = np.unique(values, return_inverse=True)
    return np.asarray(rank / max(len(different) - 1, 1))

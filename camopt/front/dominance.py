"""The points of a set that known points dominate.

The known points are the leaves of a tree of neighbours. Of a branch, the least cost in each objective and the
largest often tell enough: a point that costs no less than the largest is dominated by the whole branch, and one
that costs less than the least in some objective by none of it.

Source: H. T. Kung, F. Luccio, F. P. Preparata, On finding the maxima of a set of vectors, J. ACM 22 (1975), for the
question; the tree is one of bounding boxes.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from camopt.numerics import FloatArray

BRANCHES = 8
GROWN = 0.25  # after which the large tree is made anew
COMPARED_AT_ONCE = 8192  # points, so that what is compared fits the cache


class Dominators:
    """Known points, as costs (m, objectives); infinities as the largest number."""

    def __init__(self, costs: FloatArray) -> None:
        depth = 0
        while BRANCHES**depth < len(costs):
            depth += 1
        room = np.full((BRANCHES**depth - len(costs), costs.shape[1]), np.inf)  # these dominate nothing
        leaves = np.concatenate([costs[neighbours(costs)], room])
        self._least, self._most = [leaves], [leaves]
        for _ in range(depth):
            self._least.append(self._least[-1].reshape(-1, BRANCHES, costs.shape[1]).min(axis=1))
            self._most.append(self._most[-1].reshape(-1, BRANCHES, costs.shape[1]).max(axis=1))

    def dominate(self, costs: FloatArray) -> Any:
        """Which points (n, objectives) some known point dominates (n,): it costs no more, and in some less."""
        parts = [costs[first : first + COMPARED_AT_ONCE] for first in range(0, len(costs), COMPARED_AT_ONCE)]
        return np.concatenate([np.zeros(0, dtype=bool), *map(self._some, parts)])

    def _some(self, costs: FloatArray) -> Any:
        found = np.zeros(len(costs), dtype=bool)
        point, branch = np.arange(len(costs)), np.zeros(len(costs), dtype=np.int64)
        for level in reversed(range(len(self._least))):
            least, most, mine = self._least[level][branch], self._most[level][branch], costs[point]
            found[point[np.all(most <= mine, axis=1) & np.any(most < mine, axis=1)]] = True
            open_ = np.all(least <= mine, axis=1) & ~found[point]
            point, branch = (np.repeat(each[open_], BRANCHES) for each in (point, branch))
            branch = BRANCHES * branch + np.arange(branch.size) % BRANCHES
        return found


class Known:
    """Points that come in parts, and are asked in between which others they dominate.

    Most are in one tree, which is made anew when they have grown by a share; the others in a small one.
    """

    def __init__(self, objectives: int) -> None:
        self._most, self._recent, self._count = (
            Dominators(np.empty((0, objectives))),
            [np.empty((0, objectives))],
            0,
        )

    def add(self, costs: FloatArray) -> Any:
        """Take points (n, objectives); which of them others dominate that are in the large tree (n,)."""
        dominated = self._most.dominate(costs)
        self._recent.append(costs[~dominated])
        return dominated

    def dominators(self, every: Callable[[], FloatArray]) -> "Dominators | Both":
        """What the points dominate so far; ``every`` gives all of them that none dominates, if they are needed."""
        recent = np.concatenate(self._recent)
        if len(recent) > max(GROWN * self._count, COMPARED_AT_ONCE):
            costs = every()
            self._most, self._count, recent = Dominators(costs), len(costs), recent[:0]
        self._recent = [recent]
        return Both(self._most, Dominators(recent)) if len(recent) else self._most


class Both(NamedTuple):
    """Two trees of known points."""

    most: Dominators
    recent: Dominators

    def dominate(self, costs: FloatArray) -> Any:
        """As of ``Dominators``."""
        found = self.most.dominate(costs)
        found[~found] = self.recent.dominate(costs[~found])
        return found


def neighbours(costs: FloatArray) -> Any:
    """The points in an order in which those of a branch are near each other.

    They are sorted by the objective in which they are spread the most, by rank, and then each half is, and so on.
    """
    ranks = np.column_stack([_share(column) for column in costs.T])
    order, size = np.arange(len(costs)), BRANCHES
    while size < len(costs):
        size *= BRANCHES
    while size > BRANCHES and len(costs):
        here, part = ranks[order], np.arange(len(order)) // size
        first = np.arange(0, len(order), size)
        spread = np.maximum.reduceat(here, first) - np.minimum.reduceat(here, first)
        along = np.take_along_axis(here, np.argmax(spread, axis=1)[part][:, None], axis=1)[:, 0]
        order, size = order[np.lexsort((along, part))], size // 2
    return order


def _share(values: FloatArray) -> FloatArray:
    """The rank of each value among the different ones, from 0 to 1."""
    known, rank = np.unique(values, return_inverse=True)
    return np.asarray(rank / max(len(known) - 1, 1))

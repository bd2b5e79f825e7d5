"""Boxes of designs as arrays, how they are cut, and the loop that all searches for the smallest cam share.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import reduce
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds
from camopt.core.numerics.interval import Interval
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.grid_search import spaced_sizes
from camopt.solve.smallest.result import RELATIVE_GAP

NARROW_SIDE = 1e-3 * RELATIVE_GAP  # of a size, or of the scale where that is larger
LEAST_BATCH = 32  # boxes examined together, at least: fewer take no less time


@dataclass(frozen=True)
class DesignBoxes:
    """Boxes of designs: the least and largest of each variable, arrays (boxes,), and the side to be cut next."""

    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    side: Any
    """Index into ``free``."""
    free: tuple[str, ...]
    """What boxes have a range of, by field."""
    scale: float
    """Up to this size boxes are cut in the middle, mm; beyond, where one spans multiples, at the geometric mean."""
    units: dict[str, float]
    """What each of them is of the order of."""
    discs: tuple[str, ...] = ("size",)
    """The sizes, by field, the largest of which is to be least."""

    @classmethod
    def single_box(
        cls,
        ends: SizeBounds,
        scale: float,
        variables: Mapping[str, Variable] | None = None,
        discs: tuple[str, ...] = ("size",),
    ) -> "DesignBoxes":
        """The box between the given ends; what is none of the variables is a length."""
        low, high = ({n: np.array([end[k]]) for n, end in ends.items()} for k in (0, 1))
        free = tuple(n for n, (a, b) in ends.items() if b > a)
        known = variables or {}
        units = {n: known[n].magnitude(scale) if n in known else scale for n in free}
        side = next(free.index(disc) for disc in discs if disc in free)
        return cls(low, high, np.array([side]), free, scale, units, discs)

    def __len__(self) -> int:
        return int(self.low["size"].size)

    @property
    def least_sizes(self) -> FloatArray:
        """The least size of each."""
        return reduce(np.maximum, (self.low[disc] for disc in self.discs))

    @property
    def largest_sizes(self) -> FloatArray:
        """The largest size of each."""
        return reduce(np.maximum, (self.high[disc] for disc in self.discs))

    @property
    def is_narrow(self) -> Any:
        """Which boxes are so narrow that there is no use in cutting them."""
        return np.all(self._relative_widths < 1.0, axis=0)

    @property
    def _relative_widths(self) -> FloatArray:
        """How many times each side is as wide as one that is not to be cut (sides, boxes)."""
        least = [NARROW_SIDE * np.maximum(self.units[n], np.abs(self.low[n])) for n in self.free]
        wide = np.array([self.high[n] - self.low[n] for n in self.free])
        return np.where(wide > 0.0, wide, 0.0) / np.array(least)

    def take(self, index: Any) -> "DesignBoxes":
        low, high = ({n: v[index] for n, v in ends.items()} for ends in (self.low, self.high))
        return replace(self, low=low, high=high, side=self.side[index])

    def cap_sizes(self, most: float) -> "DesignBoxes":
        """The boxes without what is larger than a size."""
        return replace(self, high={**self.high, **{d: np.minimum(self.high[d], most) for d in self.discs}})

    def with_ends(self, low: dict[str, FloatArray], high: dict[str, FloatArray], side: Any) -> "DesignBoxes":
        """The boxes with other ends of the sizes that have a range, and other sides to be cut, if wide enough."""
        left = replace(self, low={**self.low, **low}, high={**self.high, **high}, side=side)
        width = left._relative_widths
        cut = np.take_along_axis(width, side[None], axis=0)[0] >= 1.0
        return replace(left, side=np.where(cut, side, np.argmax(width, axis=0)))

    def append_boxes(self, other: "DesignBoxes") -> "DesignBoxes":
        """These boxes and others."""
        low = {n: np.concatenate([v, other.low[n]]) for n, v in self.low.items()}
        high = {n: np.concatenate([v, other.high[n]]) for n, v in self.high.items()}
        return replace(self, low=low, high=high, side=np.concatenate([self.side, other.side]))

    def as_designs(self, like: Designs) -> Designs:
        """The boxes as designs of Intervals, of cams that turn as another one."""
        return like.with_values({n: Interval(self.low[n], self.high[n]) for n in self.low})

    def middle_designs(self, like: Designs) -> Designs:
        """The design in the middle of each, likewise."""
        return like.with_values({n: (low + self.high[n]) / 2.0 for n, low in self.low.items()})

    def halve_boxes(self) -> "DesignBoxes":
        """Each box cut in two across its side."""
        below, above = dict(self.high), dict(self.low)
        for k, name in enumerate(self.free):
            middle = self._middle_of_side(name)
            below[name] = np.where(self.side == k, middle, self.high[name])
            above[name] = np.where(self.side == k, middle, self.low[name])
        return replace(self, high=below).append_boxes(replace(self, low=above))

    def _middle_of_side(self, name: str) -> FloatArray:
        low, high = self.low[name], self.high[name]
        even = (low + high) / 2
        if name not in self.discs:
            return even
        wide = high > 2.0 * np.maximum(low, self.scale)
        return np.where(wide, spaced_sizes(low, high, self.scale, 3)[1], even)


class Bisection(ABC):
    """A search in progress for the least size over boxes of the free variables."""

    most_boxes: int
    """After which the search is given up."""
    floor: float = inf
    """The least size of the boxes that are not shown to be empty and not worth another look."""

    @abstractmethod
    def select_batch(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """The boxes to look at next, and the rest."""

    @abstractmethod
    def contract_boxes(self, boxes: DesignBoxes) -> DesignBoxes:
        """Those of some boxes that may hold a smaller cam and can be cut, narrower, with the side to cut."""

    def bisect(self, boxes: DesignBoxes, until: float) -> float:
        """Search all boxes, or as many as there is time for (``clock.now``); a size that no cam undercuts."""
        seen = 0
        while len(boxes) and seen < self.most_boxes and clock_seconds() < until:
            while len(boxes) < LEAST_BATCH:
                boxes = boxes.halve_boxes()
            chosen, rest = self.select_batch(boxes)
            seen += len(chosen)
            boxes = rest.append_boxes(self.contract_boxes(chosen).halve_boxes())
        return float(np.min(boxes.least_sizes, initial=self.floor))

    def drop_finished(self, boxes: DesignBoxes, done: Any) -> DesignBoxes:
        """The boxes without those that need no further search, though they may hold a feasible cam."""
        self.floor = float(np.min(boxes.least_sizes[done], initial=self.floor))
        return boxes.take(~done)

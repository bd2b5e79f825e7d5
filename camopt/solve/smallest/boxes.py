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
from camopt.core.numerics.clock import now
from camopt.core.numerics.interval import Interval
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.first_look import spread
from camopt.solve.smallest.result import GAP

NARROW_SIDE = 1e-3 * GAP  # of a size, or of the scale where that is larger
LEAST_BATCH = 32  # boxes examined together, at least: fewer take no less time


@dataclass(frozen=True)
class Boxes:
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
    def one(
        cls,
        ends: SizeBounds,
        scale: float,
        variables: Mapping[str, Variable] | None = None,
        discs: tuple[str, ...] = ("size",),
    ) -> "Boxes":
        """The box between the given ends; what is none of the variables is a length."""
        low, high = ({n: np.array([end[k]]) for n, end in ends.items()} for k in (0, 1))
        free = tuple(n for n, (a, b) in ends.items() if b > a)
        known = variables or {}
        units = {n: known[n].order(scale) if n in known else scale for n in free}
        side = next(free.index(disc) for disc in discs if disc in free)
        return cls(low, high, np.array([side]), free, scale, units, discs)

    def __len__(self) -> int:
        return int(self.low["size"].size)

    @property
    def least(self) -> FloatArray:
        """The least size of each."""
        return reduce(np.maximum, (self.low[disc] for disc in self.discs))

    @property
    def most(self) -> FloatArray:
        """The largest size of each."""
        return reduce(np.maximum, (self.high[disc] for disc in self.discs))

    @property
    def narrow(self) -> Any:
        """Which boxes are so narrow that there is no use in cutting them."""
        return np.all(self._width < 1.0, axis=0)

    @property
    def _width(self) -> FloatArray:
        """How many times each side is as wide as one that is not to be cut (sides, boxes)."""
        least = [NARROW_SIDE * np.maximum(self.units[n], np.abs(self.low[n])) for n in self.free]
        wide = np.array([self.high[n] - self.low[n] for n in self.free])
        return np.where(wide > 0.0, wide, 0.0) / np.array(least)

    def take(self, index: Any) -> "Boxes":
        low, high = ({n: v[index] for n, v in ends.items()} for ends in (self.low, self.high))
        return replace(self, low=low, high=high, side=self.side[index])

    def below(self, most: float) -> "Boxes":
        """The boxes without what is larger than a size."""
        return replace(self, high={**self.high, **{d: np.minimum(self.high[d], most) for d in self.discs}})

    def narrowed(self, low: dict[str, FloatArray], high: dict[str, FloatArray], side: Any) -> "Boxes":
        """The boxes with other ends of the sizes that have a range, and other sides to be cut, if wide enough."""
        left = replace(self, low={**self.low, **low}, high={**self.high, **high}, side=side)
        width = left._width
        cut = np.take_along_axis(width, side[None], axis=0)[0] >= 1.0
        return replace(left, side=np.where(cut, side, np.argmax(width, axis=0)))

    def and_(self, other: "Boxes") -> "Boxes":
        """These boxes and others."""
        low = {n: np.concatenate([v, other.low[n]]) for n, v in self.low.items()}
        high = {n: np.concatenate([v, other.high[n]]) for n, v in self.high.items()}
        return replace(self, low=low, high=high, side=np.concatenate([self.side, other.side]))

    def designs(self, like: Designs) -> Designs:
        """The boxes as designs of Intervals, of cams that turn as another one."""
        return like.with_values({n: Interval(self.low[n], self.high[n]) for n in self.low})

    def middles(self, like: Designs) -> Designs:
        """The design in the middle of each, likewise."""
        return like.with_values({n: (low + self.high[n]) / 2.0 for n, low in self.low.items()})

    def halved(self) -> "Boxes":
        """Each box cut in two across its side."""
        below, above = dict(self.high), dict(self.low)
        for k, name in enumerate(self.free):
            middle = self._middle(name)
            below[name] = np.where(self.side == k, middle, self.high[name])
            above[name] = np.where(self.side == k, middle, self.low[name])
        return replace(self, high=below).and_(replace(self, low=above))

    def _middle(self, name: str) -> FloatArray:
        low, high = self.low[name], self.high[name]
        even = (low + high) / 2
        if name not in self.discs:
            return even
        wide = high > 2.0 * np.maximum(low, self.scale)
        return np.where(wide, spread(low, high, self.scale, 3)[1], even)


class Bisection(ABC):
    """A search in progress for the least size over boxes of the free variables."""

    most_boxes: int
    """After which the search is given up."""
    floor: float = inf
    """The least size of the boxes that are not shown to be empty and not worth another look."""

    @abstractmethod
    def split(self, boxes: Boxes) -> tuple[Boxes, Boxes]:
        """The boxes to look at next, and the rest."""

    @abstractmethod
    def narrowed(self, boxes: Boxes) -> Boxes:
        """Those of some boxes that may hold a smaller cam and can be cut, narrower, with the side to cut."""

    def bisect(self, boxes: Boxes, until: float) -> float:
        """Search all boxes, or as many as there is time for (``clock.now``); a size that no cam undercuts."""
        seen = 0
        while len(boxes) and seen < self.most_boxes and now() < until:
            while len(boxes) < LEAST_BATCH:
                boxes = boxes.halved()
            chosen, rest = self.split(boxes)
            seen += len(chosen)
            boxes = rest.and_(self.narrowed(chosen).halved())
        return float(np.min(boxes.least, initial=self.floor))

    def left(self, boxes: Boxes, done: Any) -> Boxes:
        """The boxes without those that need no further search, though they may hold a feasible cam."""
        self.floor = float(np.min(boxes.least[done], initial=self.floor))
        return boxes.take(~done)

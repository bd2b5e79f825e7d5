"""Bisection of boxes, many at once: the loop that all searches for the smallest cam share.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from abc import ABC, abstractmethod
from math import inf
from typing import Any

import numpy as np

from camopt.numerics.clock import now
from camopt.smallest.boxes import Boxes

LEAST_BATCH = 32  # boxes examined together, at least: fewer take no less time


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

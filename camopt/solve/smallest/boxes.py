"""Boxes of designs as arrays, with the bisection that all proofs of the smallest cam share.

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
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.interval import Interval
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.grid_search import linear_then_geometric_sizes
from camopt.solve.smallest.result import RELATIVE_GAP

NARROW_SIDE = 1e-3 * RELATIVE_GAP  # relative to a size, or to its unit if that is larger
LEAST_BATCH = 32  # boxes examined together, at least: fewer take no less time


@dataclass(frozen=True)
class DesignBoxes:
    """Boxes of designs: the least and largest value of each variable, arrays (boxes,), and the side to cut next."""

    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    side: Any
    """Index into ``free``."""
    free: tuple[str, ...]
    """The fields that have a range."""
    scale: float
    """Boxes are cut in the middle up to this size, mm; wide boxes beyond it are cut at the geometric mean."""
    units: dict[str, float]
    """The order of magnitude of each free variable."""
    discs: tuple[str, ...] = ("size",)
    """The fields of the sizes whose maximum is minimised."""

    @classmethod
    def single_box(
        cls,
        variable_ranges: SizeBounds,
        scale: float,
        variables: Mapping[str, Variable],
        discs: tuple[str, ...] = ("size",),
    ) -> "DesignBoxes":
        """The box between the given ends; a field without a ``Variable`` is a length."""
        low, high = ({n: np.array([end[k]]) for n, end in variable_ranges.items()} for k in (0, 1))
        free = tuple(n for n, (a, b) in variable_ranges.items() if b > a)
        units = {n: variables[n].order_of_magnitude(scale) if n in variables else scale for n in free}
        side = next(free.index(disc) for disc in discs if disc in free)
        return cls(low, high, np.array([side]), free, scale, units, discs)

    def __len__(self) -> int:
        return int(self.low["size"].size)

    @property
    def least_sizes(self) -> FloatArray:
        """Least size in each box [mm]."""
        return reduce(np.maximum, (self.low[disc] for disc in self.discs))

    @property
    def largest_sizes(self) -> FloatArray:
        """Largest size in each box [mm]."""
        return reduce(np.maximum, (self.high[disc] for disc in self.discs))

    @property
    def too_narrow_to_cut(self) -> Any:
        """Which boxes are too narrow to be cut."""
        return np.all(self._widths_over_least_cut_width < 1.0, axis=0)

    @property
    def _widths_over_least_cut_width(self) -> FloatArray:
        """Width of each side over the least width that is cut (sides, boxes)."""
        least = [NARROW_SIDE * np.maximum(self.units[n], np.abs(self.low[n])) for n in self.free]
        widths = np.array([self.high[n] - self.low[n] for n in self.free])
        return np.where(widths > 0.0, widths, 0.0) / np.array(least)

    def take(self, index: Any) -> "DesignBoxes":
        low, high = ({n: v[index] for n, v in ends.items()} for ends in (self.low, self.high))
        return replace(self, low=low, high=high, side=self.side[index])

    def cap_sizes(self, largest_size: float) -> "DesignBoxes":
        """The boxes without their parts above a size, mm."""
        return replace(self, high={**self.high, **{d: np.minimum(self.high[d], largest_size) for d in self.discs}})

    def with_ends_and_cut_side(
        self, low: dict[str, FloatArray], high: dict[str, FloatArray], cut_side: Any
    ) -> "DesignBoxes":
        """The boxes with other ends of their free variables.

        Next ``cut_side`` is cut, or the widest if it is narrow.
        """
        boxes = replace(self, low={**self.low, **low}, high={**self.high, **high}, side=cut_side)
        widths = boxes._widths_over_least_cut_width
        wide = np.take_along_axis(widths, cut_side[None], axis=0)[0] >= 1.0
        return replace(boxes, side=np.where(wide, cut_side, np.argmax(widths, axis=0)))

    @property
    def with_widest_side_cut(self) -> "DesignBoxes":
        """The boxes; next their widest sides are cut."""
        return replace(self, side=np.argmax(self._widths_over_least_cut_width, axis=0))

    def append_boxes(self, other: "DesignBoxes") -> "DesignBoxes":
        """These boxes, followed by others."""
        low = {n: np.concatenate([v, other.low[n]]) for n, v in self.low.items()}
        high = {n: np.concatenate([v, other.high[n]]) for n, v in self.high.items()}
        return replace(self, low=low, high=high, side=np.concatenate([self.side, other.side]))

    def as_interval_designs(self, template_design: Designs) -> Designs:
        """The boxes as designs of Intervals, with the other fields of the design ``template_design``."""
        return template_design.with_values({n: Interval(self.low[n], self.high[n]) for n in self.low})

    def middle_designs(self, template_design: Designs) -> Designs:
        """The design in the middle of each box, with the other fields of ``template_design``."""
        return template_design.with_values({n: (low + self.high[n]) / 2.0 for n, low in self.low.items()})

    def cams_at_point_of_first_box(self, point: FloatArray) -> "DesignBoxes":
        """The cams of the first box at a point of its free variables, of any size from that of the point on."""
        box = self.take(slice(1))
        at = {n: np.clip(point[[k]], box.low[n], box.high[n]) for k, n in enumerate(self.free)}
        return replace(box, low={**box.low, **at}, high={**box.high, **at, "size": box.high["size"]})

    def halve_boxes(self) -> "DesignBoxes":
        """The boxes, each cut in two across its side."""
        below, above = dict(self.high), dict(self.low)
        for k, name in enumerate(self.free):
            low, high = self.low[name], self.high[name]
            middle = (low + high) / 2
            if name in self.discs:
                geometric = linear_then_geometric_sizes(low, high, self.scale, 3)[1]
                middle = np.where(high > 2.0 * np.maximum(low, self.scale), geometric, middle)
            below[name] = np.where(self.side == k, middle, high)
            above[name] = np.where(self.side == k, middle, low)
        return replace(self, high=below).append_boxes(replace(self, low=above))


class Bisection(ABC):
    """A search for the least size by bisection of boxes of the free variables."""

    problem: Problem
    budget: Budget
    most_boxes: int
    """The search ends after this many boxes."""
    floor: float = inf
    """Least size of the boxes that were dropped without being proved empty, mm."""

    @abstractmethod
    def select_batch(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """The boxes to examine next, and the rest."""

    @abstractmethod
    def contract_boxes_and_improve_incumbent(self, boxes: DesignBoxes) -> DesignBoxes:
        """The boxes that may hold a smaller cam and can be cut, made narrower, with the side to cut."""

    def size_bound_by_bisection(self, boxes: DesignBoxes) -> float:
        """Lower bound of the size over all boxes [mm], by as many cuts as the budget allows."""
        examined = 0
        while len(boxes) and examined < self.most_boxes and not self.budget.is_spent:
            while len(boxes) < LEAST_BATCH:
                boxes = boxes.halve_boxes().with_widest_side_cut
            batch, rest = self.select_batch(boxes)
            examined += len(batch)
            self.budget.spend(self.problem.evaluation_work(0, len(batch)))
            boxes = rest.append_boxes(self.contract_boxes_and_improve_incumbent(batch).halve_boxes())
        return float(np.min(boxes.least_sizes, initial=self.floor))

    def drop_finished_and_lower_floor(self, boxes: DesignBoxes, is_finished: Any) -> DesignBoxes:
        """The boxes without the finished ones, whose least size goes into ``floor``."""
        self.floor = float(np.min(boxes.least_sizes[is_finished], initial=self.floor))
        return boxes.take(~is_finished)

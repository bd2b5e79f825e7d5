"""Boxes of designs of a grid: a motion, and on each axis the first and the last value in the box."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.interval import Interval
from camopt.model.mechanisms import Designs
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.pareto import LARGEST_COST


@dataclass(frozen=True)
class Grid:
    """A space with sorted axes, so that a box of places on the axes is a box of sizes."""

    space: DesignSpace

    @cached_property
    def sorted_axis_indices(self) -> list[IntArray]:
        """For each axis, the indices of its values in rising order."""
        return [np.argsort(values, kind="stable") for values in self.space.axes.values()]

    @cached_property
    def axes(self) -> dict[str, FloatArray]:
        """The rising values of each axis, by field of ``Designs``."""
        ordered = zip(self.space.axes.items(), self.sorted_axis_indices, strict=True)
        return {field: values[order] for (field, values), order in ordered}

    @cached_property
    def varied_fields(self) -> list[str]:
        """The sizes and numbers with several values."""
        return [name for name, values in self.axes.items() if values.size > 1]

    def whole_box_of_each_motion(self, objective_count: int) -> "GridBoxes":
        """One box for each problem with all of its designs; their costs are unknown."""
        motion = np.arange(len(self.space.problems))
        last = np.array([values.size - 1 for values in self.axes.values()], dtype=np.int64)
        high = np.tile(last, (motion.size, 1))
        return GridBoxes(motion, np.zeros_like(high), high, np.full((motion.size, objective_count), -LARGEST_COST))

    def boxes_as_interval_designs(self, boxes: "GridBoxes") -> Designs:
        """Boxes as designs of Intervals."""
        fixed = self.space.problem.design
        ends: dict[str, Any] = {}
        for name, value in fixed.sizes.items():
            values = np.broadcast_to(value, len(boxes))
            ends[name] = Interval(values, values)
        for k, (name, values) in enumerate(self.axes.items()):
            ends[name] = Interval(values[boxes.low[:, k]], values[boxes.high[:, k]])
        return fixed.with_values(ends)

    def design_numbers_at_places(self, places: IntArray) -> IntArray:
        """The numbers of designs of a motion in the space, from their places on the axes (designs, axes)."""
        shape = tuple(values.size for values in self.axes.values())
        where = tuple(order[place] for order, place in zip(self.sorted_axis_indices, places.T, strict=True))
        return np.asarray(np.ravel_multi_index(where, shape) if shape else np.zeros(len(places), dtype=np.int64))

    def design_numbers_in_boxes(self, boxes: "GridBoxes") -> IntArray:
        """The numbers of all designs of boxes, one box after the other."""
        shape, counts = boxes.high - boxes.low + 1, boxes.design_counts
        box = np.repeat(np.arange(len(boxes)), counts)
        rest = np.arange(box.size) - np.repeat(np.cumsum(counts) - counts, counts)
        places = np.empty((box.size, shape.shape[1]), dtype=np.int64)
        for k in reversed(range(shape.shape[1])):
            rest, place = np.divmod(rest, shape[box, k])
            places[:, k] = boxes.low[box, k] + place
        return self.design_numbers_at_places(places)


@dataclass(frozen=True)
class GridBoxes:
    """n boxes of a grid of d axes."""

    motion: IntArray
    """The number of the motion (n,)."""
    low: IntArray
    """The place of the least value on each axis (n, d)."""
    high: IntArray
    """The place of the largest value, inclusive (n, d)."""
    costs: FloatArray
    """Lower bounds of the designs' costs (n, objectives)."""

    def __len__(self) -> int:
        return int(self.motion.size)

    @property
    def design_counts(self) -> IntArray:
        """Number of designs in each box (n,)."""
        counts: IntArray = np.prod(self.high - self.low + 1, axis=1, dtype=np.int64)
        return counts

    @property
    def middle_places(self) -> IntArray:
        """The places of a design in the middle of each box (n, d)."""
        return (self.low + self.high) // 2

    def take(self, index: Any) -> "GridBoxes":
        return GridBoxes(*(values[index] for values in (self.motion, self.low, self.high, self.costs)))

    def halve_boxes(self, cut_axes: IntArray) -> "GridBoxes":
        """The boxes, each cut in two across an axis (n,) with several values; halves are neighbours."""
        cut = np.arange(len(self)), cut_axes
        below, above, middle = self.high.copy(), self.low.copy(), self.middle_places[cut]
        below[cut], above[cut] = middle, middle + 1
        order = np.arange(2 * len(self)).reshape(2, -1).T.ravel()
        return concatenate_grid_boxes([replace(self, high=below), replace(self, low=above)]).take(order)


def concatenate_grid_boxes(parts: list[GridBoxes]) -> GridBoxes:
    """The boxes of all parts, one part after the other."""
    fields = ("motion", "low", "high", "costs")
    return GridBoxes(*(np.concatenate([getattr(part, name) for part in parts]) for name in fields))

"""Ranges of a motion and its derivatives over stretches of the turn, which may cross panels.

A stretch is given by distances from the centre of one panel, so that an end on the border of two panels is clearly
on one side.
"""

from typing import NamedTuple

import numpy as np

from camopt.core.numerics import INPUT_ROUNDOFF, BoolArray, FloatArray, IntArray
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.panels import fourth_derivative, value_and_three_derivatives
from camopt.core.numerics.piecewise import MotionTable

MOTION_ORDERS = 5
"""y and four derivatives by the cam angle."""
MOST_STRETCH_PANELS = 6
"""Most panels to either side of the first; a longer stretch counts as the whole turn."""


class PartRanges(NamedTuple):
    """y and four derivatives at the middles of parts of panels, and their ranges over the whole parts."""

    middle: list[Interval]
    whole: list[Interval]


def motion_ranges_over_parts(
    table: MotionTable, panel: IntArray, u: FloatArray, half_width_rad: FloatArray
) -> PartRanges:
    """Ranges over parts of panels with middle u and ``half_width_rad``, by the mean value theorem."""
    motion = (*value_and_three_derivatives(table, panel, u), fourth_derivative(table, panel, u))
    most, error, way = table.most[panel], table.error[panel], Interval(-half_width_rad, half_width_rad)
    middle, whole, slope = list[Interval](), list[Interval](), Interval(-most[:, 5], most[:, 5])
    for order in reversed(range(MOTION_ORDERS)):
        at_middle = Interval(motion[order] - error[:, order], motion[order] + error[:, order])
        mean_value = at_middle + slope * way
        low, high = table.low[panel, order] - error[:, order], table.high[panel, order] + error[:, order]
        slope = Interval(np.maximum(mean_value.low, low), np.minimum(mean_value.high, high))
        middle.insert(0, at_middle)
        whole.insert(0, slope)
    return PartRanges(middle, whole)


class StretchRanges(NamedTuple):
    """Ranges of a motion over stretches of the turn."""

    ranges: list[Interval]
    """Ranges of y and four derivatives."""
    pieces: BoolArray
    """Whether each stretch crosses from one smooth piece of the motion to another."""

    def split(self, count: int) -> list["StretchRanges"]:
        """Split the stretches into ``count`` parts of equal size."""
        size = self.pieces.size // count
        parts = [slice(number * size, (number + 1) * size) for number in range(count)]
        return [StretchRanges([interval[part] for interval in self.ranges], self.pieces[part]) for part in parts]


def motion_ranges_over_stretches(
    table: MotionTable, panel: IntArray, low: FloatArray, high: FloatArray
) -> StretchRanges:
    """Ranges of a motion over stretches from ``low`` to ``high`` [rad from the centres of panels]."""
    half, count = table.half_width, table.half_width.size
    ends = np.full((2, MOTION_ORDERS, panel.size), np.inf) * np.array([1.0, -1.0])[:, None, None]
    pieces, first = np.zeros(panel.size, dtype=bool), np.isin(np.arange(count), table.first_panel)
    unknown = ~(low <= high)

    def include_part(
        stretch_mask: BoolArray, panel_of_stretch: IntArray, start: FloatArray, end: FloatArray
    ) -> None:
        if stretch_mask.any():
            h = half[panel_of_stretch[stretch_mask]]
            sides = np.clip(start[stretch_mask], -h, h), np.clip(end[stretch_mask], -h, h)
            ranges = motion_ranges_over_parts(
                table,
                panel_of_stretch[stretch_mask],
                (sides[0] + sides[1]) / (2.0 * h),
                (sides[1] - sides[0]) * (0.5 + INPUT_ROUNDOFF),
            ).whole
            for order, interval in enumerate(ranges):
                ends[0, order, stretch_mask] = np.minimum(ends[0, order, stretch_mask], interval.low)
                ends[1, order, stretch_mask] = np.maximum(ends[1, order, stretch_mask], interval.high)

    include_part((low <= half[panel]) & (high >= -half[panel]), panel, low, high)
    for way in (1, -1):
        on, start, end = panel, low, high
        for _ in range(MOST_STRETCH_PANELS):
            beyond, inside = _leaves_panel_and_starts_in_it(half[on], start, end, way)
            if not beyond.any():
                break
            pieces |= first[on if way < 0 else np.mod(on + 1, count)] & beyond & inside
            neighbour = np.mod(on + way, count)
            distance = way * (half[on] + half[neighbour])
            on, start, end = neighbour, start - distance, end - distance
            include_part(beyond & _leaves_panel_and_starts_in_it(half[on], start, end, way)[1], on, start, end)
        unknown |= _leaves_panel_and_starts_in_it(half[on], start, end, way)[0]
    if (unknown := unknown | ~(ends[0, 0] <= ends[1, 0])).any():
        rows = slice(count)
        ends[0][:, unknown] = (table.low[rows] - table.error[rows]).min(axis=0)[:, None]
        ends[1][:, unknown] = (table.high[rows] + table.error[rows]).max(axis=0)[:, None]
        pieces |= unknown
    return StretchRanges([Interval(*low_high) for low_high in ends.transpose(1, 0, 2)], pieces)


def _leaves_panel_and_starts_in_it(
    panel_half_width: FloatArray, low: FloatArray, high: FloatArray, direction: int
) -> tuple[BoolArray, ...]:
    """Whether each stretch goes past the panel in one direction, and starts before the panel's end."""
    return (
        (high > panel_half_width, low <= panel_half_width)
        if direction > 0
        else (low < -panel_half_width, high >= -panel_half_width)
    )

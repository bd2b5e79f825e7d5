"""Parts of the panels of a motion."""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.panel_series import derivative_polynomials_by_panel
from camopt.core.numerics.piecewise import (
    MotionTable,
    external_load_polynomials_by_panel,
    train_inertia_polynomials_by_panel,
)
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.motion.load import TrainLoad
from camopt.model.motion.programme import Programme


class PanelParts(NamedTuple):
    """Parts of panels (n,), each with its panel and its ends in u."""

    panel: IntArray
    low: FloatArray
    high: FloatArray

    def panel_places_of_part_places(self, part_places: FloatArray) -> FloatArray:
        """The panels' u at places from −1 to 1 of each part."""
        return 0.5 * ((1.0 - part_places) * self.low + (1.0 + part_places) * self.high)

    def take(self, index: Any) -> "PanelParts":
        return PanelParts(self.panel[index], self.low[index], self.high[index])


def cut_panels(table: MotionTable, cuts: Iterable[tuple[int, float]]) -> PanelParts:
    """All panels of a motion, cut at places (panel, u)."""
    whole = [(panel, -1.0) for panel in range(len(table.centre))]
    panel, low = (np.array(column) for column in zip(*sorted([*whole, *cuts]), strict=True))
    last = np.diff(panel, append=len(table.centre)) != 0
    return PanelParts(panel, low, np.where(last, 1.0, np.append(low[1:], 1.0)))


def part_states(programme: Programme, parts: PanelParts, part_places: FloatArray) -> State:
    """The state at places (…, n) of parts, without y'''; slopes of curves are not valid."""
    table = programme.table
    y, y1, y2 = (
        polynomial.polyval(part_places, series[:, parts.panel], tensor=False)
        for series in motion_polynomials_to_order_2(programme)
    )
    if programme.load is None:
        return State(y, y1, y2, 0.0)
    load, carried = (
        polynomial.polyval(part_places, series[:, parts.panel], tensor=False)
        for series in (external_load_polynomials_by_panel(table), train_inertia_polynomials_by_panel(table))
    )
    if isinstance(programme.load, TrainLoad):
        return State(y, y1, y2, 0.0, TrainForces(load, 0.0, carried, 0.0))
    return State(y, y1, y2, 0.0, Load(load, 0.0))


@lru_cache(maxsize=64)
def motion_polynomials_to_order_2(programme: Programme) -> tuple[FloatArray, ...]:
    """The polynomials of y, y' and y'' in u, by panel; cached for bisections."""
    return tuple(derivative_polynomials_by_panel(programme.table, order) for order in range(3))

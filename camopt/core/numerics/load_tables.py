"""Tables of external loads that change over the turn, for kernels. Curves read them with the motion (``state``)."""

from types import NoneType
from typing import NamedTuple

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels
from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray, IndexArray, IntArray
from camopt.core.numerics.jet import Jet
from camopt.core.numerics.panels import (
    displacement_jets_over_part,
    displacement_jets_over_row,
    value_and_three_derivatives,
)
from camopt.core.numerics.state import Load, TrainForces

LOAD_ERRORS, ANGLE_ERRORS = 8.0, 64.0  # errors of a load, in roundings of the largest; of cam angles, of 1 rad


class LoadTable(NamedTuple):
    """An external load for kernels, linear on each panel; sizes and rows as in a MotionTable."""

    centre: FloatArray  # (P,) at u = 0
    nodes: FloatArray  # (N, 2) load and slope by the cam angle
    slope: FloatArray  # (P + G,)
    low: FloatArray  # (P + G,) smallest load
    high: FloatArray  # (P + G,) largest load
    error: FloatArray  # (P + G, 2) bounds of the error of load and slope


class ForceTable(NamedTuple):
    """A force on the panels; sizes and rows as in a MotionTable."""

    coefficients: FloatArray
    half_width: FloatArray
    nodes: FloatArray
    low: FloatArray
    high: FloatArray
    most: FloatArray
    error: FloatArray


class TrainLoadTable(NamedTuple):
    """Forces of a train on the follower, for kernels."""

    still: ForceTable  # load at rest
    carried: ForceTable  # inertia force divided by ω²


def tabulated_load(
    centre_loads: FloatArray,
    slope: FloatArray,
    largest_load: float,
    half_width: FloatArray,
    first_panel: IntArray,
    group: IntArray,
) -> LoadTable:
    """Table of a load that is linear on each piece, from its values and slopes at the centres of panels.

    Its rounding error is that of the largest magnitude in the turn, plus the slope times that of the cam angle.
    """
    rise = slope * half_width
    low, high = centre_loads - np.abs(rise), centre_loads + np.abs(rise)
    error = UNIT_ROUNDOFF * (LOAD_ERRORS * largest_load + ANGLE_ERRORS * np.abs(slope))
    errors = np.transpose([error, error / half_width])
    piece = np.repeat(np.arange(len(first_panel) - 1), np.diff(first_panel))
    nodes = np.empty((len(centre_loads) + len(first_panel) - 1, 2))
    for side in (0, 1):
        nodes[np.arange(len(centre_loads)) + piece + side] = np.transpose(
            [centre_loads + (2 * side - 1) * rise, slope]
        )
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    return LoadTable(
        centre_loads,
        nodes,
        np.concatenate([slope, slope[starts]]),
        np.concatenate([low, np.minimum.reduceat(low, starts)]),
        np.concatenate([high, np.maximum.reduceat(high, starts)]),
        np.vstack([errors, np.maximum.reduceat(errors, starts)]),
    )


ROW_FIELDS = ("low", "high", "most", "error")


def load_as_columns(load: LoadTable | TrainLoadTable) -> LoadTable | TrainLoadTable:
    """The load for formulas on all rows or nodes at once (index ``...``): numbers become columns (rows, 1)."""
    if isinstance(load, TrainLoadTable):
        names = ("nodes", *ROW_FIELDS)
        return TrainLoadTable(
            *(force._replace(**{name: getattr(force, name).T[:, :, None] for name in names}) for force in load)
        )
    columns = {name: getattr(load, name)[:, None] for name in ("nodes", "slope", "low", "high")}
    return load._replace(**columns, error=load.error.T[:, :, None])


def select_load_rows(load: LoadTable | TrainLoadTable, rows: IndexArray) -> LoadTable | TrainLoadTable:
    """The load on some panels or groups."""
    if isinstance(load, TrainLoadTable):
        return TrainLoadTable(
            *(force._replace(**{name: getattr(force, name)[rows] for name in ROW_FIELDS}) for force in load)
        )
    return load._replace(**{name: getattr(load, name)[rows] for name in ("slope", "low", "high", "error")})


def chosen_by_load_type(train_function):
    """Mark a function (load, row, place) of a LoadTable.

    ``train_function`` takes a train's load, and None stays None.
    """

    def register(function):
        def load_function(load, row, angle_from_middle):
            if load is None:
                return None
            return (
                train_function(load, row, angle_from_middle)
                if isinstance(load, TrainLoadTable)
                else function(load, row, angle_from_middle)
            )

        @chosen_by_type(load_function)
        def function_for_load_type(load, row, angle_from_middle):
            if load is NoneType:
                return lambda load, row, angle_from_middle: None
            return train_function if load is TrainLoadTable else function

        return load_function

    return register


def _train_forces_on_panel(load, row, angle_from_middle):
    u = angle_from_middle / load.still.half_width[row]
    value, slope, _, _ = value_and_three_derivatives(load.still, row, u)
    carried, carried_slope, _, _ = value_and_three_derivatives(load.carried, row, u)
    return TrainForces(value, slope, carried, carried_slope)


def _train_forces_at_node(load, row, angle_from_middle):
    still, carried = load.still.nodes[row], load.carried.nodes[row]
    return TrainForces(still[0], still[1], carried[0], carried[1])


def _train_forces_over_row(load, row, angle_from_middle):
    value, slope, _, _ = displacement_jets_over_row(load.still, row)
    carried, carried_slope, _, _ = displacement_jets_over_row(load.carried, row)
    return TrainForces(value, slope, carried, carried_slope)


def _train_forces_over_part(load, row, angle_from_middle):
    h = load.still.half_width[row]
    value, slope, _, _ = displacement_jets_over_part(
        load.still, row, angle_from_middle[0] / h, angle_from_middle[1] / h
    )
    carried, carried_slope, _, _ = displacement_jets_over_part(
        load.carried, row, angle_from_middle[0] / h, angle_from_middle[1] / h
    )
    return TrainForces(value, slope, carried, carried_slope)


@chosen_by_load_type(_train_forces_on_panel)
def load_on_panel(load, row, angle_from_middle):
    """The load on a panel at the cam angle ``angle_from_middle`` from its middle."""
    return Load(load.centre[row] + load.slope[row] * angle_from_middle, load.slope[row])


@chosen_by_load_type(_train_forces_at_node)
def load_at_node(load, row, angle_from_middle):
    """The load at a node."""
    return Load(load.nodes[row, 0], load.nodes[row, 1])


@chosen_by_load_type(_train_forces_over_row)
def load_over_row(load, row, angle_from_middle):
    """The load over a panel or group, in jets."""
    return load_and_slope_jets(load, row, load.low[row], load.high[row])


@chosen_by_load_type(_train_forces_over_part)
def load_over_part(load, row, angle_from_middle):
    """The load over a part of a panel, in jets; ``angle_from_middle`` is the part's middle and half-width."""
    value, room = (
        load.centre[row] + load.slope[row] * angle_from_middle[0],
        abs(load.slope[row]) * angle_from_middle[1],
    )
    return load_and_slope_jets(load, row, value - room, value + room)


@inline_in_kernels
def load_and_slope_jets(load, row, low, high):
    """Jets of a load and its slope."""
    slope, error = load.slope[row], load.error[row]
    return Load(Jet(low, high, error[0], abs(slope), 0.0, 0.0), Jet(slope, slope, error[1], 0.0, 0.0, 0.0))

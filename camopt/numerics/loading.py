"""An external load that changes over the turn, for kernels: curves get it with the motion (``numerics.state``)."""

from types import NoneType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.kernels.compile import chosen_by_type, inlined
from camopt.numerics import UNIT, FloatArray
from camopt.numerics.jet import Jet
from camopt.numerics.state import Load

LOAD_ERRORS, ANGLE_ERRORS = (
    8.0,
    64.0,
)  # errors of a load, in roundings of the largest; of its cam angles, in those of 1 rad


class LoadTable(NamedTuple):
    """An external load for the kernels, straight on each panel; sizes and rows as in a MotionTable."""

    centre: FloatArray  # (P,) at u = 0
    nodes: FloatArray  # (N, 2) load and slope by the cam angle
    slope: FloatArray  # (P + G,)
    low: FloatArray  # (P + G,) least load
    high: FloatArray  # (P + G,) and the largest
    error: FloatArray  # (P + G, 2) bounds of the error of load and slope


def tabulated_load(
    centre: FloatArray,
    slope: FloatArray,
    largest: float,
    half_width: FloatArray,
    first_panel: NDArray[np.int64],
    group: NDArray[np.int64],
) -> LoadTable:
    """A load that is straight on each piece, from its values at the centres of panels and its slopes there.

    Its rounding is that of the largest magnitude in the turn, and what rounding of cam angles makes of its slope.
    """
    rise = slope * half_width
    low, high = centre - np.abs(rise), centre + np.abs(rise)
    error = UNIT * (LOAD_ERRORS * largest + ANGLE_ERRORS * np.abs(slope))
    errors = np.transpose([error, error / half_width])
    piece = np.repeat(np.arange(len(first_panel) - 1), np.diff(first_panel))
    nodes = np.empty((len(centre) + len(first_panel) - 1, 2))
    for side in (0, 1):
        nodes[np.arange(len(centre)) + piece + side] = np.transpose([centre + (2 * side - 1) * rise, slope])
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    return LoadTable(
        centre,
        nodes,
        np.concatenate([slope, slope[starts]]),
        np.concatenate([low, np.minimum.reduceat(low, starts)]),
        np.concatenate([high, np.maximum.reduceat(high, starts)]),
        np.vstack([errors, np.maximum.reduceat(errors, starts)]),
    )


def load_of_all_rows(load: LoadTable) -> LoadTable:
    """The load as formulas take it for all rows or nodes at once, ``...``: numbers are columns, (rows, 1)."""
    columns = {name: getattr(load, name)[:, None] for name in ("nodes", "slope", "low", "high")}
    return load._replace(**columns, error=load.error.T[:, :, None])


def load_of_some_rows(load: LoadTable, rows: NDArray[np.intp]) -> LoadTable:
    """The load on some panels or groups."""
    return load._replace(**{name: getattr(load, name)[rows] for name in ("slope", "low", "high", "error")})


def where_loaded(function):
    """Mark what kernels make of a load, (load, row, place): None without one."""

    def marked(load, row, place):
        return None if load is None else function(load, row, place)

    @chosen_by_type(marked)
    def _chosen(load, row, place):
        return (lambda load, row, place: None) if load is NoneType else function

    return marked


@where_loaded
def loaded(load, row, place):
    """The load on a panel, ``place`` from its middle by the cam angle."""
    return Load(load.centre[row] + load.slope[row] * place, load.slope[row])


@where_loaded
def loaded_node(load, row, place):
    """As ``loaded``, at a node."""
    return Load(load.nodes[row, 0], load.nodes[row, 1])


@where_loaded
def loaded_row(load, row, place):
    """As ``loaded``, in jets over a whole panel or group."""
    return load_jets(load, row, load.low[row], load.high[row])


@where_loaded
def loaded_part(load, row, place):
    """As ``loaded``, in jets over a part of a panel: ``place`` is (its middle, half its width) by the cam angle."""
    value, room = load.centre[row] + load.slope[row] * place[0], abs(load.slope[row]) * place[1]
    return load_jets(load, row, value - room, value + room)


@inlined
def load_jets(load, row, low, high):
    """Jets of load and slope."""
    slope, error = load.slope[row], load.error[row]
    return Load(Jet(low, high, error[0], abs(slope), 0.0, 0.0), Jet(slope, slope, error[1], 0.0, 0.0, 0.0))

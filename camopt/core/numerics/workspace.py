"""The tables of the search for extremes for a tile of designs, made once and used for every tile."""

from threading import local
from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.arguments import BOOLEAN, NUMBER, ArgumentKind, Record, pin_arrays
from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.piecewise import COUNTS, NUMBERS

TILE = 256  # designs whose tables (about 70 × 256 × 8 bytes each) stay in the second-level cache
ROW_LENGTH = TILE + 8  # a row of a tile: not a power of two, whose columns would all share one cache set
PLAIN_TILE = 4096  # of them uncompiled: a call of numpy takes as long as some thousand numbers in it
LARGEST_KEPT = 31 << 20  # bytes, just below what glibc allows for
DEPTH = 50  # halvings of a panel
MOST_KEPT_WORKSPACES = 8  # workspaces of a thread, each of about a megabyte

# rows of the table of climbs, one column for each that goes on
LOW, HIGH, RISING, FALLING, SIDE, BEST, AT, BOUND, CONCAVITY, GAIN, SLOPE, NEXT, EXACT = range(13)
VALUE, GRADIENT, STATES = 13, 14, 15  # the last two next to each other, as the values and slopes looked at


MATRIX_KIND = ArgumentKind(NUMBER.name, 2)


class PanelBounds(NamedTuple):
    """Bounds by jets of each row of the motion table, a panel or a group of panels: (rows, ROW).

    By how much a curve may exceed both its end values in a panel, a bound of |f'''|, and one of rounding errors.
    """

    excess: FloatArray
    third: FloatArray
    error: FloatArray


class TileExtremes(NamedTuple):
    """The extreme of each design, oriented: largest value, its node and angle, bound, rounding error; (TILE,)."""

    best: FloatArray
    node: IntArray
    at: FloatArray
    top: FloatArray
    rounding: FloatArray


class Climbs(NamedTuple):
    """Unfinished climbs: the design of each within its tile, and its column of the table (STATES, 2·ROW)."""

    design: IntArray
    state: FloatArray


class Halves(NamedTuple):
    """Parts of a panel that are to be halved: the design of each and its ends; and the stack of halves of one."""

    design: IntArray
    ends: FloatArray
    stack: FloatArray


class Workspace(NamedTuple):
    """All tables of a tile.

    values: of the curve at the table's nodes, (nodes, ROW)
    looked: whether the bounds of a row are known, (rows,)
    chosen: designs to be searched in a panel, (TILE + 1,)
    opened: those of them that the panel's ends do not settle, (TILE,)
    again: designs that are to be looked at again, (TILE + 1,)
    middle: u of the middle of a panel, once for each, (TILE,)
    sides: oriented values and slopes at the left end of the panel, its right end and its middle, (3, 2, ROW)
    """

    values: FloatArray
    looked: BoolArray
    bounds: PanelBounds
    found: TileExtremes
    chosen: IntArray
    sides: FloatArray
    opened: IntArray
    again: IntArray
    middle: FloatArray
    climbs: Climbs
    parts: Halves


BOUNDS_RECORD = Record(PanelBounds, (MATRIX_KIND, MATRIX_KIND, MATRIX_KIND))
WORKSPACE_RECORD = Record(
    Workspace,
    (
        MATRIX_KIND,
        ArgumentKind(BOOLEAN.name, 1),
        BOUNDS_RECORD,
        Record(TileExtremes, (NUMBERS, COUNTS, NUMBERS, NUMBERS, NUMBERS)),
        COUNTS,
        ArgumentKind(NUMBER.name, 3),
        COUNTS,
        COUNTS,
        NUMBERS,
        Record(Climbs, (COUNTS, MATRIX_KIND)),
        Record(Halves, (COUNTS, MATRIX_KIND, MATRIX_KIND)),
    ),
)


class ThreadWorkspaces(local):
    """The tables that a thread has made, by their numbers of nodes and rows."""

    def __init__(self) -> None:
        self.made: dict[tuple[int, int], Workspace] = {}


THREAD_WORKSPACES = ThreadWorkspaces()


def workspace(panels: Any) -> Workspace:
    """The thread's tables for a turn that is divided into ``Panels``."""
    size, made = _table_size(panels), THREAD_WORKSPACES.made
    if size not in made:
        if len(made) >= MOST_KEPT_WORKSPACES:
            made.clear()
        made[size] = pin_arrays(_make_workspace(*size, TILE))
    return made[size]


def plain_workspace(panels: Any) -> Workspace:
    """Larger tables, for what is not compiled."""
    return _make_workspace(*_table_size(panels), PLAIN_TILE)


def keep_freed_memory() -> None:
    """Let memory that is freed be used again; else it goes back to the system, which clears each page of the next.

    glibc keeps blocks as large as the largest that was freed before (mallopt(3), M_MMAP_THRESHOLD), and at the end
    of its heap twice as much. Formulas of many designs make and free arrays of about a megabyte all the time. The
    block that is freed here is never written to, so it takes no memory. Elsewhere this does nothing.
    """
    np.empty(LARGEST_KEPT, np.uint8)


def _table_size(panels: Any) -> tuple[int, int]:
    return panels.kind.size + panels.centre.size, panels.rows


def _make_workspace(nodes: int, rows: int, tile: int) -> Workspace:
    row = tile + ROW_LENGTH - TILE
    return Workspace(
        np.empty((nodes, row)),
        np.empty(rows, np.bool_),
        PanelBounds(np.empty((rows, row)), np.empty((rows, row)), np.empty((rows, row))),
        TileExtremes(np.empty(tile), np.empty(tile, np.int64), np.empty(tile), np.empty(tile), np.empty(tile)),
        np.empty(tile + 1, np.int64),
        np.empty((3, 2, row)),
        np.empty(tile, np.int64),
        np.empty(tile + 1, np.int64),
        np.zeros(tile),
        Climbs(np.empty(2 * tile, np.int64), np.empty((STATES, 2 * row))),
        Halves(np.empty(2 * tile, np.int64), np.empty((2 * tile, 6)), np.empty((DEPTH + 2, 6))),
    )

"""Tables of the search for extremes for a tile of designs. They are made once and used for every tile."""

from threading import local
from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.arguments import BOOLEAN, NUMBER, ArgumentKind, Record, as_pinned_tuple
from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.piecewise import COUNTS, NUMBERS

TILE = 256  # designs whose tables (about 70 × 256 × 8 bytes each) stay in the second-level cache
ROW_LENGTH = TILE + 8  # length of a row: with a power of two, all columns would share one cache set
PLAIN_TILE = 4096  # designs of a tile uncompiled: a numpy call takes as long as a thousand numbers in it
LARGEST_KEPT = 31 << 20  # bytes, just below the limit of glibc
DEPTH = 50  # most halvings of a panel
MOST_KEPT_WORKSPACES = 8  # most workspaces of a thread, about a megabyte each

# rows of the table of climbs, which has one column for each unfinished climb
LOW, HIGH, RISING, FALLING, SIDE, BEST, AT, BOUND, CONCAVITY, GAIN, SLOPE, NEXT, EXACT = range(13)
VALUE, GRADIENT, STATES = 13, 14, 15  # values and slopes must be neighbours


MATRIX_KIND = ArgumentKind(NUMBER.name, 2)


class PanelBounds(NamedTuple):
    """Bounds by jets for each row of the motion table, a panel or a group of panels (rows, ROW_LENGTH).

    ``excess`` bounds how far a curve exceeds its end values in a panel, ``third`` |f'''|, and ``error`` its
    rounding.
    """

    excess: FloatArray
    third: FloatArray
    error: FloatArray


class TileExtremes(NamedTuple):
    """Oriented extremes of the designs (TILE,): largest value, its node and angle, bound, and rounding error."""

    best: FloatArray
    node: IntArray
    at: FloatArray
    top: FloatArray
    rounding: FloatArray


class Climbs(NamedTuple):
    """Unfinished climbs: the design of each in its tile, and the table of states (STATES, 2·ROW_LENGTH)."""

    design: IntArray
    state: FloatArray


class Halves(NamedTuple):
    """Parts of a panel to be halved: the design of each and its ends, and the stack of halves of one part."""

    design: IntArray
    ends: FloatArray
    stack: FloatArray


class Workspace(NamedTuple):
    """All tables of a tile.

    values: the curve at the table's nodes, (nodes, ROW_LENGTH)
    looked: whether the bounds of a row are known, (rows,)
    chosen: designs to be searched in a panel, (TILE + 1,)
    opened: chosen designs that the panel's ends leave open, (TILE,)
    again: designs to be searched again, (TILE + 1,)
    middle: u of the middle of a panel for each design, (TILE,)
    sides: oriented values and slopes at the left end, right end and middle of the panel, (3, 2, ROW_LENGTH)
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
    """Workspaces of a thread, by their numbers of nodes and rows."""

    def __init__(self) -> None:
        self.by_size: dict[tuple[int, int], Workspace] = {}


THREAD_WORKSPACES = ThreadWorkspaces()


def thread_workspace(panels: Any) -> Workspace:
    """The thread's workspace for ``Panels``."""
    size, workspaces = _node_and_row_counts(panels), THREAD_WORKSPACES.by_size
    if size not in workspaces:
        if len(workspaces) >= MOST_KEPT_WORKSPACES:
            workspaces.clear()
        workspaces[size] = as_pinned_tuple(_make_workspace(*size, TILE))
    return workspaces[size]


def empty_workspace_for_uncompiled_search(panels: Any) -> Workspace:
    """A larger workspace for uncompiled searches."""
    return _make_workspace(*_node_and_row_counts(panels), PLAIN_TILE)


def keep_freed_memory() -> None:
    """Make glibc keep freed memory for the next arrays; else the system takes it back and clears each new page.

    glibc keeps blocks up to the size of the largest block freed before (mallopt(3), M_MMAP_THRESHOLD), and twice
    that at the end of its heap. Formulas for many designs often make and free arrays of about a megabyte. The block
    that is freed here is never written to, so it takes no memory. With other C libraries this does nothing.
    """
    np.empty(LARGEST_KEPT, np.uint8)


def _node_and_row_counts(panels: Any) -> tuple[int, int]:
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

"""Non-dominated designs of a set of rows."""

import numpy as np
from numpy.typing import NDArray

from camopt.rows import Rows
from camopt.scene import Search


def objectives(rows: Rows, search: Search) -> NDArray[np.float64]:
    """The objectives of each row as numbers to minimise, (rows, objectives)."""
    signed = [(name, 1.0) for name in search.minimise] + [(name, -1.0) for name in search.maximise]
    return np.column_stack([sign * rows.column(name) for name, sign in signed])


def ranked(rows: Rows, search: Search) -> Rows:
    """The rows sorted by the first objective, ties by the next, and so on."""
    return rows.take(np.lexsort(objectives(rows, search).T[::-1])) if rows.count else rows


def non_dominated(rows: Rows, search: Search) -> Rows:
    """The rows that no other row betters in one objective without losing in another.

    Exact ties are all kept. An infinite objective counts as the largest finite number, so that rows compare by
    their other objectives.
    """
    if not rows.count:
        return rows
    import moocore

    costs = np.nan_to_num(objectives(rows, search))
    return rows.take(moocore.is_nondominated(costs, keep_weakly=True))

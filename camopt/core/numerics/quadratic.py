"""Least squares under linear limits.

Source: Lawson & Hanson, Solving Least Squares Problems, ch. 23 (problem LDP, by non-negative least squares).
"""

import numpy as np

from camopt.core.numerics import FloatArray

LIMIT_TOLERANCE = 1e-9  # of the largest number of a limit: what counts as holding it
LEAST_LIMIT = 1e-3  # of the largest such number: a limit whose own numbers are less has that room
RANK_TOLERANCE = 1e-10  # of the largest singular value: a row with less follows from others
LEAST_ROW = 1e-12  # of the longest row: one that x hardly changes
INFEASIBLE_RESIDUAL = 1e-8  # of a residual: with less of it nothing holds all limits


def constrained_least_squares(
    factor: FloatArray, offset: FloatArray, rows: FloatArray, least: FloatArray, size: float = 0.0
) -> FloatArray | None:
    """The x of the least |R·x + d| with rows·x ≥ least, R of full rank; None if no x meets these limits.

    ``size`` is that of the numbers that ``least`` is made of, whose rounding it may have.
    """
    if not factor.shape[1]:
        return np.empty(0) if np.all(least <= _allowed_violation(rows, least, np.empty(0), size)) else None
    turned, root = np.linalg.qr(factor)  # with z = U·(x − bottom) the norm is |z|, but for what x cannot change
    bottom = np.asarray(np.linalg.solve(root, -(turned.T @ offset)), dtype=float)
    if _holds_limits(rows, least, bottom, size):
        return bottom
    from scipy.optimize import nnls

    by_z = np.linalg.solve(root.T, rows.T).T
    missing = least - rows @ bottom
    lengths = np.linalg.norm(by_z, axis=1)
    some = lengths > LEAST_ROW * lengths.max()
    if np.any(missing[~some] > _allowed_violation(rows, least, bottom, size)[~some]):  # x does not change these
        return None
    by_z, missing = by_z[some] / lengths[some, None], missing[some] / lengths[some]
    unit = float(missing.max())
    system = np.vstack([by_z.T, missing / unit])
    wanted = np.append(np.zeros(bottom.size), 1.0)
    forces = nnls(system, wanted)[0]
    left = wanted - system @ forces
    if left[-1] <= INFEASIBLE_RESIDUAL:
        return None
    active = forces > 0.0
    z = np.linalg.lstsq(by_z[active], missing[active], rcond=None)[0]  # the nearest point of those planes
    found = np.asarray(bottom + np.linalg.solve(root, z), dtype=float)
    return found if _holds_limits(rows, least, found, size) else None


def solve_equations(
    rows: FloatArray, values: FloatArray, size: float = 0.0
) -> tuple[FloatArray, FloatArray] | None:
    """The x with rows·x = values: the shortest, and directions in which there are others; None if there is none.

    Rows may follow from each other.
    """
    count = rows.shape[1]
    if not rows.size:
        return np.zeros(count), np.eye(count)
    lengths = np.linalg.norm(rows, axis=1)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    left, sizes, right = np.linalg.svd(rows / lengths[:, None])
    rank = int((sizes > RANK_TOLERANCE * sizes[0]).sum())
    shortest = right[:rank].T @ ((left.T[:rank] @ (values / lengths)) / sizes[:rank])
    missed = np.abs(rows @ shortest - values)
    if np.any(missed > _allowed_violation(rows, values, shortest, size)):
        return None
    return shortest, right[rank:].T


def least_violation(rows: FloatArray, least: FloatArray, same: FloatArray, values: FloatArray) -> float:
    """By what share of their own numbers any x must miss limits rows·x ≥ least and same·x = values; 0 if none.

    0 too where the linear programme is not solved.
    """
    from scipy.optimize import linprog

    every = np.concatenate([rows, same, -same])
    wanted = np.concatenate([least, values, -values])
    room = np.abs(wanted) + LEAST_LIMIT * np.abs(wanted).max(initial=0.0)
    room[room == 0.0] = 1.0
    system = np.column_stack([every / room[:, None], np.ones(len(every))])
    bounds = [(None, None)] * rows.shape[1] + [(0.0, None)]
    cost = np.append(np.zeros(rows.shape[1]), 1.0)
    found = linprog(cost, -system, -wanted / room, bounds=bounds, method="highs")
    return float(found.fun) if found.status == 0 else 0.0


def _holds_limits(rows: FloatArray, least: FloatArray, x: FloatArray, size: float) -> bool:
    return bool(np.all(least - rows @ x <= _allowed_violation(rows, least, x, size)))


def _allowed_violation(rows: FloatArray, least: FloatArray, x: FloatArray, size: float) -> FloatArray:
    """The amount by which each limit may be missed."""
    values = np.abs(rows) @ np.abs(x) + np.abs(least)
    return np.asarray(LIMIT_TOLERANCE * (values + LEAST_LIMIT * values.max(initial=size)))

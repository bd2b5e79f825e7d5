"""Least squares under linear limits, and linear equations that may depend on each other.

Source: Lawson & Hanson, Solving Least Squares Problems, ch. 23 (problem LDP, by non-negative least squares).
"""

import numpy as np

from camopt.core.numerics import FloatArray

LIMIT_TOLERANCE = 1e-9  # allowed violation of a limit, as a share of the largest number in it
LEAST_LIMIT = 1e-3  # smallest such number that counts, as a share of the largest in all limits
RANK_TOLERANCE = 1e-10  # share of the largest singular value below which rows depend on others
LEAST_ROW = 1e-12  # share of the longest row below which x hardly changes a limit
INFEASIBLE_RESIDUAL = 1e-8  # residual below which no x holds all limits


def constrained_least_squares(
    factor: FloatArray, offset: FloatArray, rows: FloatArray, lower_limits: FloatArray, rounding_scale: float = 0.0
) -> FloatArray | None:
    """The x with the smallest |R·x + d| and rows·x ≥ lower_limits, for R of full rank; None if there is none.

    ``rounding_scale`` is the size of the numbers from which ``lower_limits`` was computed: it gives the rounding.
    """
    if not factor.shape[1]:
        return np.empty(0) if _holds_limits(rows, lower_limits, np.empty(0), rounding_scale) else None
    turned, root = np.linalg.qr(factor)  # with z = U·(x − bottom) the norm is |z|, up to a constant
    bottom = np.asarray(np.linalg.solve(root, -(turned.T @ offset)), dtype=float)
    if _holds_limits(rows, lower_limits, bottom, rounding_scale):
        return bottom
    from scipy.optimize import nnls

    by_z = np.linalg.solve(root.T, rows.T).T
    missing = lower_limits - rows @ bottom
    lengths = np.linalg.norm(by_z, axis=1)
    changeable = lengths > LEAST_ROW * lengths.max()
    if np.any(missing[~changeable] > _allowed_violation(rows, lower_limits, bottom, rounding_scale)[~changeable]):
        return None
    by_z, missing = by_z[changeable] / lengths[changeable, None], missing[changeable] / lengths[changeable]
    unit = float(missing.max())
    system = np.vstack([by_z.T, missing / unit])
    target = np.append(np.zeros(bottom.size), 1.0)
    forces = nnls(system, target)[0]
    residual = target - system @ forces
    if residual[-1] <= INFEASIBLE_RESIDUAL:
        return None
    active = forces > 0.0
    z = np.linalg.lstsq(by_z[active], missing[active], rcond=None)[0]  # the nearest point of the active planes
    x = np.asarray(bottom + np.linalg.solve(root, z), dtype=float)
    return x if _holds_limits(rows, lower_limits, x, rounding_scale) else None


def shortest_solution_and_null_space(
    rows: FloatArray, values: FloatArray, rounding_scale: float
) -> tuple[FloatArray, FloatArray] | None:
    """The shortest x with rows·x = values, and the directions of all other solutions; None if there is none.

    Rows may depend on each other.
    """
    count = rows.shape[1]
    if not rows.size:
        return np.zeros(count), np.eye(count)
    lengths = np.linalg.norm(rows, axis=1)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    left, sizes, right = np.linalg.svd(rows / lengths[:, None])
    rank = int((sizes > RANK_TOLERANCE * sizes[0]).sum())
    shortest = right[:rank].T @ ((left.T[:rank] @ (values / lengths)) / sizes[:rank])
    if np.any(np.abs(rows @ shortest - values) > _allowed_violation(rows, values, shortest, rounding_scale)):
        return None
    return shortest, right[rank:].T


def least_relative_violation(
    rows: FloatArray, lower_limits: FloatArray, equality_rows: FloatArray, equality_values: FloatArray
) -> float:
    """Smallest relative violation of the inequalities and equalities by any x; 0 if an x holds them all.

    It is also 0 if the linear programme is not solved.
    """
    from scipy.optimize import linprog

    all_rows = np.concatenate([rows, equality_rows, -equality_rows])
    bound = np.concatenate([lower_limits, equality_values, -equality_values])
    room = np.abs(bound) + LEAST_LIMIT * np.abs(bound).max(initial=0.0)
    room[room == 0.0] = 1.0
    system = np.column_stack([all_rows / room[:, None], np.ones(len(all_rows))])
    bounds = [(None, None)] * rows.shape[1] + [(0.0, None)]
    cost = np.append(np.zeros(rows.shape[1]), 1.0)
    solution = linprog(cost, -system, -bound / room, bounds=bounds, method="highs")
    return float(solution.fun) if solution.status == 0 else 0.0


def _holds_limits(rows: FloatArray, lower_limits: FloatArray, x: FloatArray, rounding_scale: float) -> bool:
    return bool(np.all(lower_limits - rows @ x <= _allowed_violation(rows, lower_limits, x, rounding_scale)))


def _allowed_violation(
    rows: FloatArray, lower_limits: FloatArray, x: FloatArray, rounding_scale: float
) -> FloatArray:
    """Allowed violation of each limit."""
    values = np.abs(rows) @ np.abs(x) + np.abs(lower_limits)
    return np.asarray(LIMIT_TOLERANCE * (values + LEAST_LIMIT * values.max(initial=rounding_scale)))

"""The minimum of a quadratic form under linear limits.

Source: Lawson & Hanson, Solving Least Squares Problems, ch. 23 (problem LDP, by non-negative least squares).
"""

import numpy as np

from camopt.numerics import FloatArray

ROOM = 1e-9  # of the largest number of a limit: what counts as holding it
SLIGHT = 1e-3  # of the largest such number: a limit whose own numbers are less has that room
NONE = 1e-8  # of a residual: with less of it nothing holds all limits


def least_within(square: FloatArray, pull: FloatArray, rows: FloatArray, least: FloatArray) -> FloatArray | None:
    """The x of the least xᵀ·S·x/2 + p·x with rows·x ≥ least, S positive definite; None if no x holds that."""
    bottom = np.asarray(np.linalg.solve(square, -pull), dtype=float)
    if _hold(rows, least, bottom):
        return bottom
    from scipy.optimize import nnls

    root = np.linalg.cholesky(square)  # with z = Lᵀ·(x − bottom) the form is |z|²/2
    turned = np.linalg.solve(root, rows.T).T
    missing = least - rows @ bottom
    lengths = np.linalg.norm(turned, axis=1)
    some = lengths > 0.0
    if np.any(missing[~some] > 0.0):
        return None
    turned, missing = turned[some] / lengths[some, None], missing[some] / lengths[some]
    unit = float(missing.max())
    system = np.vstack([turned.T, missing / unit])
    wanted = np.append(np.zeros(bottom.size), 1.0)
    forces = nnls(system, wanted)[0]
    left = wanted - system @ forces
    if left[-1] <= NONE:
        return None
    active = forces > 0.0
    z = np.linalg.lstsq(turned[active], missing[active], rcond=None)[0]  # the nearest point of those planes
    found = np.asarray(bottom + np.linalg.solve(root.T, z), dtype=float)
    return found if _hold(rows, least, found) else None


def _hold(rows: FloatArray, least: FloatArray, x: FloatArray) -> bool:
    values = np.abs(rows) @ np.abs(x) + np.abs(least)
    return bool(np.all(rows @ x >= least - ROOM * (values + SLIGHT * values.max(initial=0.0))))

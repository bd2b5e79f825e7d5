"""Least squares under linear limits.

Source: Lawson & Hanson, Solving Least Squares Problems, ch. 23 (problem LDP, by non-negative least squares).
"""

import numpy as np

from camopt.numerics import FloatArray

ROOM = 1e-9  # of the largest number of a limit: what counts as holding it
SLIGHT = 1e-3  # of the largest such number: a limit whose own numbers are less has that room
NONE = 1e-8  # of a residual: with less of it nothing holds all limits


def least_within(factor: FloatArray, offset: FloatArray, rows: FloatArray, least: FloatArray) -> FloatArray | None:
    """The x of the least |R·x + d| with rows·x ≥ least, R of full rank; None if no x holds that."""
    turned, root = np.linalg.qr(factor)  # with z = U·(x − bottom) the norm is |z|, but for what x cannot change
    bottom = np.asarray(np.linalg.solve(root, -(turned.T @ offset)), dtype=float)
    if _hold(rows, least, bottom):
        return bottom
    from scipy.optimize import nnls

    by_z = np.linalg.solve(root.T, rows.T).T
    missing = least - rows @ bottom
    lengths = np.linalg.norm(by_z, axis=1)
    some = lengths > 0.0
    if np.any(missing[~some] > 0.0):
        return None
    by_z, missing = by_z[some] / lengths[some, None], missing[some] / lengths[some]
    unit = float(missing.max())
    system = np.vstack([by_z.T, missing / unit])
    wanted = np.append(np.zeros(bottom.size), 1.0)
    forces = nnls(system, wanted)[0]
    left = wanted - system @ forces
    if left[-1] <= NONE:
        return None
    active = forces > 0.0
    z = np.linalg.lstsq(by_z[active], missing[active], rcond=None)[0]  # the nearest point of those planes
    found = np.asarray(bottom + np.linalg.solve(root, z), dtype=float)
    return found if _hold(rows, least, found) else None


def _hold(rows: FloatArray, least: FloatArray, x: FloatArray) -> bool:
    values = np.abs(rows) @ np.abs(x) + np.abs(least)
    return bool(np.all(rows @ x >= least - ROOM * (values + SLIGHT * values.max(initial=0.0))))

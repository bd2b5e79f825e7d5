"""Combined excesses of limits: two limits together bound a size more closely than each alone.

With e_j ≤ 0 the claims of a feasible cam, and weights w_j ≥ 0, Σ w_j·e_j ≤ 0 holds too. Where a cam is held by
several limits at once, the right weights cancel the slopes by all angles and sizes but the cam's own, and the sum
bounds that: they are the multipliers of the linear programme that the claims are at the middle of a box.

Source: A. Neumaier, Interval Methods for Systems of Equations, ch. 5 (preconditioning).
"""

from math import inf

import numpy as np
import scipy

from camopt.numerics import FloatArray
from camopt.numerics.interval import Interval
from camopt.smallest.excesses import SIDE_ROUNDING, Excesses, chained_excesses


def combined(over: Excesses, span: Interval, size: int) -> Excesses:
    """Excesses (m, n) and, after them, their sum with the weights that bound a size of the first box the most.

    The weights serve all boxes, those near the first one best. ``span`` is each box from its middle (d, n).
    """
    weights = _multipliers(over, span, size)
    some = np.flatnonzero(weights)
    if some.size < 2:
        return over
    ends = [
        np.tensordot(weights[some], end[:, some], (0, 1))[:, None] for end in (over.slopes.low, over.slopes.high)
    ]
    at = (weights[some] @ over.at[some])[None]
    rounding, bound = (weights[some] @ over.rounding[some])[None], np.full(at.shape, inf)
    at = at - SIDE_ROUNDING * (weights[some] @ np.abs(over.at[some]))
    return chained_excesses([over, Excesses(-bound, bound, at, Interval(*ends), rounding)])


def _multipliers(over: Excesses, span: Interval, size: int) -> FloatArray:
    """The multiplier of each claim where the size is least over the first box, whatever its range there."""
    width = span.high[:, 0] - span.low[:, 0]
    width = np.where(width > 0.0, width, 1.0)
    rows = width * (over.slopes.low + over.slopes.high)[..., 0].T / 2.0
    scale = np.abs(rows).max(axis=1)  # near 1, for the residuals of the solver
    usable = np.flatnonzero(np.isfinite(scale) & (scale > 0.0) & np.isfinite(over.at[:, 0]))
    weights = np.zeros(scale.size)
    if usable.size:
        ends = np.array([span.low[:, 0], span.high[:, 0]]).T / width[:, None]
        ends[size] = -inf, inf
        by = scale[usable]
        found = scipy.optimize.linprog(
            np.arange(width.size) == size, rows[usable] / by[:, None], -over.at[usable, 0] / by, bounds=ends
        )
        if found.status == 0:
            weights[usable] = np.maximum(-found.ineqlin.marginals, 0.0) / by
    return weights

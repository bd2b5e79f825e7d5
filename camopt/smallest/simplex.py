"""Descents by the simplex method of Nelder and Mead that end when the time is over.

Source: J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7 (1965).
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from camopt.numerics import FloatArray
from camopt.numerics.clock import now

DEAR = 1e9  # mm, what is without a feasible design costs a descent


def descend(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    steps: FloatArray,
    closest: tuple[float, float],
    moves: int,
    until: float,
    ends: tuple[float, float] | None = None,
) -> FloatArray:
    """Where a simplex of a start and a step along each variable comes to by so many moves for each, or ``until``.

    It ends where steps and costs differ by no more than ``closest``; ``ends`` are those of all variables.
    """

    def stop(intermediate_result: Any) -> None:
        if now() > until:
            raise StopIteration

    corners = start + np.vstack([np.zeros(start.size), np.diag(steps)])
    step, change = closest
    options = {"initial_simplex": corners, "xatol": step, "fatol": change, "maxfev": moves * start.size}
    bounds = None if ends is None else [ends] * start.size
    return np.asarray(
        scipy.optimize.minimize(cost, start, bounds=bounds, method="Nelder-Mead", callback=stop, options=options).x
    )

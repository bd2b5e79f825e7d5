"""Stretches of a fit where the motion stays on one side of the points by more than errors explain.

The mean of m independent errors is within σ/√m of 0 in two of three stretches. It is rarely six times as large in
any stretch of a file. Such a stretch shows a motion of large jerk: a corner, or a ramp that is too short for the
dwell beside it.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray

FEWEST_POINTS, MOST_POINT_SHARE = 4, 0.25  # least number of points, and largest share of all points
LENGTH_RATIO = 1.2  # ratio of successive lengths of stretches
MEAN_SIGMAS = 6.0  # least mean of a stretch, in standard deviations of the mean


class OneSidedStretch(NamedTuple):
    """A stretch between two places of the points, and the mean deviation of the motion from them."""

    first: int
    last: int
    points: int
    mean: float


def one_sided_stretches(deviations: FloatArray, noise: float) -> list[OneSidedStretch]:
    """Separate stretches round the turn with deviations on one side, in their order."""
    is_taken, stretches = np.zeros(deviations.size, dtype=bool), []
    for _, first, count in sorted(_biased_stretches(deviations, noise), reverse=True):
        places = np.arange(first, first + count) % deviations.size
        if not is_taken[places].any():
            is_taken[places] = True
            stretches.append(OneSidedStretch(first, int(places[-1]), count, float(deviations[places].mean())))
    return sorted(stretches)


def _biased_stretches(deviations: FloatArray, noise: float) -> Iterator[tuple[float, int, int]]:
    """Stretches with a far mean: the mean in its standard deviations, the first place, and the number of points."""
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([deviations, deviations]))])
    count = FEWEST_POINTS
    while count <= MOST_POINT_SHARE * deviations.size:
        distances = np.abs(sums[count : count + deviations.size] - sums[: deviations.size]) / (
            noise * np.sqrt(count)
        )
        yield from ((float(distances[k]), int(k), count) for k in np.flatnonzero(distances > MEAN_SIGMAS))
        count = max(count + 1, round(LENGTH_RATIO * count))

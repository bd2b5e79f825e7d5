"""Stretches of a fit where the motion is on one side of the points by more than their errors are.

The mean of m independent errors is within σ/√m of 0 in two of three stretches; of all stretches of a file, hardly
any is six times as far off. Where one is, what was measured is no motion of little jerk there: a corner, or a ramp
that is too short for the dwell beside it.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray

FEWEST_POINTS, MOST_POINT_SHARE = 4, 0.25  # points; of all points
LENGTH_RATIO = 1.2  # from each length that is looked at to the next
MEAN_SIGMAS = 6.0  # standard deviations of the mean


class OneSidedStretch(NamedTuple):
    """A stretch from one place of the points to another, and the mean of what the motion is off them by."""

    first: int
    last: int
    points: int
    mean: float


def one_sided_stretches(off: FloatArray, noise: float) -> list[OneSidedStretch]:
    """The stretches round the turn where deviations are on one side, in their order; none is in another."""
    taken, found = np.zeros(off.size, dtype=bool), []
    for _, first, count in sorted(_far_stretches(off, noise), reverse=True):
        places = np.arange(first, first + count) % off.size
        if not taken[places].any():
            taken[places] = True
            found.append(OneSidedStretch(first, int(places[-1]), count, float(off[places].mean())))
    return sorted(found)


def _far_stretches(off: FloatArray, noise: float) -> Iterator[tuple[float, int, int]]:
    """Each stretch that is far off: how far its mean is, in its deviations, where it starts, and its points."""
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([off, off]))])
    count = FEWEST_POINTS
    while count <= MOST_POINT_SHARE * off.size:
        far = np.abs(sums[count : count + off.size] - sums[: off.size]) / (noise * np.sqrt(count))
        yield from ((float(far[k]), int(k), count) for k in np.flatnonzero(far > MEAN_SIGMAS))
        count = max(count + 1, round(LENGTH_RATIO * count))

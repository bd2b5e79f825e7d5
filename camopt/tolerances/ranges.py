"""Ranges of what is off, and numbers over boxes, as the proofs of errors take them."""

from typing import Any

import numpy as np

from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Placed, Sloped


def none_of(x: Interval) -> Interval:
    """Nothing, of as many."""
    return as_interval(x * 0.0)


def from_0(x: Interval) -> Interval:
    """All from 0 to a range."""
    return Interval(np.minimum(x.low, 0.0), np.maximum(x.high, 0.0))


def still(x: Interval) -> Placed:
    """Ranges without slopes, for the formulas of links."""
    none = as_interval(np.zeros((1, x.size)))
    return Placed.of(Sloped(x, x, none, none), [])


def plain(x: Any, like: Sloped) -> Any:
    """A number over boxes as what has no kept quotient."""
    return x.divided() if hasattr(x, "divided") else x + like * 0.0


def along_turn(like: Sloped) -> Interval:
    """The slopes of the cam angle itself, which is the first of the variables."""
    one = np.zeros(like.slopes.low.shape)
    one[0] = 1.0
    return Interval(one, one)

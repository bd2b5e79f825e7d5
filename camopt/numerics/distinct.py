"""Distinct numbers, without ``numpy.unique``: that looks for masks, and so imports ``numpy.ma``."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)


def distinct(values: NDArray[Number]) -> NDArray[Number]:
    """The distinct numbers of some, none of them NaN, in ascending order."""
    ordered = np.sort(values, axis=None)
    fresh = np.ones(ordered.size, dtype=bool)
    fresh[1:] = ordered[1:] != ordered[:-1]
    return np.asarray(ordered[fresh])

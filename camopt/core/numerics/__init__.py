"""Mathematics: piecewise polynomials, exact extremes, intervals, jets and series."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
Number = Any
"""What a formula runs on: a float, an array, a ``Dual``, a ``Taylor``, an ``Interval``, a ``SlopedInterval`` or a
number of ``mpmath``. A number that a scene need not give is ``None`` where it is absent."""
Curve = Any
"""A function of the cam angle for each of some designs: an instance of a curve type (``numerics.curves``)."""

LARGEST, LEAST, LARGEST_MAGNITUDE = 0, 1, 2
"""Goals of a question about a curve's extremes."""

UNIT_ROUNDOFF = 2.0**-53  # relative rounding error of one operation
INPUT_ROUNDOFF = 4.0 * UNIT_ROUNDOFF  # relative error of an input
BISECTIONS = 60  # halvings of a bracket until its ends are neighbouring doubles

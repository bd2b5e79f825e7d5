"""Numerical machinery: compilation, piecewise polynomials, exact extremes. Knows nothing of files or scenes."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

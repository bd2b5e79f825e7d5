"""Laws as panel polynomials (``numerics.piecewise``), and the kinds of stroke."""

from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from camopt.motion.law import Law
from camopt.numerics import FloatArray
from camopt.numerics.piecewise import DEGREE

RISE, RETURN, DWELL = 1, 2, 4  # bits, so that a question can ask for several kinds at once
TURN = RISE | RETURN | DWELL

JERK_DEGREE = DEGREE - 3


def _chebyshev_projection() -> tuple[FloatArray, FloatArray]:
    """Nodes inside (−1, 1) and the matrix from values there to power-basis coefficients."""
    count = JERK_DEGREE + 1
    u = chebyshev.chebpts1(count)
    to_chebyshev = np.linalg.inv(chebyshev.chebvander(u, JERK_DEGREE))
    to_powers = np.array([np.pad(chebyshev.cheb2poly(row), (0, count))[:count] for row in np.eye(count)]).T
    return u, to_powers @ to_chebyshev


NODES, TO_POWERS = _chebyshev_projection()


@lru_cache(maxsize=256)
def stroke_coefficients(law: Law, panels: int) -> tuple[FloatArray, FloatArray, tuple[int, ...]]:
    """A law as panel polynomials on the unit stroke.

    The jerk is interpolated at Chebyshev points strictly inside each panel and integrated three times, with
    the constants taken from the law at the panel's centre: so no derivative loses digits to differentiation.

    Returns the coefficients (P, DEGREE + 1) of s in powers of u, the panel ends (P + 1,), and the number of
    panels in each piece. ``panels`` is the least number in a stroke.
    """
    counts = [max(1, round(panels * (b - a))) for a, b in zip(law.BREAKS, law.BREAKS[1:], strict=False)]
    ends = [np.linspace(a, b, m + 1) for a, b, m in zip(law.BREAKS, law.BREAKS[1:], counts, strict=False)]
    low = np.concatenate([e[:-1] for e in ends])
    high = np.concatenate([e[1:] for e in ends])
    centre, half = (low + high) / 2, (high - low) / 2
    series = law.jerk(centre[:, None] + half[:, None] * NODES) @ TO_POWERS.T
    for constant in (law.acceleration(centre), law.velocity(centre), law.displacement(centre)):
        series = polynomial.polyint(series, axis=1) * half[:, None]
        series[:, 0] = constant
    series.flags.writeable = False
    return series, np.append(low, 1.0), tuple(counts)

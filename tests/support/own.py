"""Laws as a scene brings them, for the tests that try every law; and what they are to 50 digits.

A spline is the sum of the basis functions of Cox and de Boor, derivatives by their recursion: neither the package's
steps between coefficients nor its polynomials of a span. A polynomial is solved for, a law of the
SCCA family integrated from its acceleration and scaled then, a skewed law is the law stretched.
"""

from functools import cache

import mpmath

from camopt.model.motion import LAWS
from camopt.model.motion.derived_laws import SkewedLaw
from camopt.model.motion.law import rests_at_both_ends
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.spline import SplineLaw
from camopt.scene.own_laws import make_own_law_from_values
from support import naive

X = [0.0, 0.06, 0.15, 0.2, 0.31, 0.4, 0.52, 0.6, 0.73, 0.8, 0.88, 0.95, 1.0]
TABLES = {
    "own-spline": {
        "degree": 5,
        "knots": [0.0] * 6 + [0.3, 0.5, 0.5] + [1.0] * 6,
        "coefficients": [0.0, 0.0, 0.0, 0.3, 0.6, 0.85, 1.0, 1.0, 1.0],
    },
    "own-table": {"x": X, "s": LAWS["modified-sine"].displacement(X).tolist()},
    "own-polynomial": {"start": [0.0, 0.0, 0.0], "end": [1.0, 0.0, -6.0]},
    "own-scca": {"scca": [0.1, 0.2, 0.3, 0.4]},
    "own-skewed": {"law": "cycloidal", "crossing": 0.35},
}
OWN = {name: make_own_law_from_values(name, table) for name, table in TABLES.items()}
EVERY = {**LAWS, **OWN}
STILL = [name for name, law in EVERY.items() if rests_at_both_ends(law)]


def law_at(law, x):
    """(s, v, a, j) of a law at x (mpmath), between its breaks."""
    if law.NAME in LAWS:
        return naive.law_at(law.NAME, x)
    forms = {SplineLaw: _spline_at, PolynomialLaw: _polynomial_at, SCCALaw: _scca_at, SkewedLaw: _skewed_values}
    return forms[type(law)](law, x)


def _skewed_values(law, x):
    c = mpmath.mpf(law.crossing)
    stretch, end = (2 * c, 0) if x <= c else (2 * (1 - c), 1)
    s, *more = law_at(law.law, end + (x - end) / stretch)
    return end + stretch * (s - end), *(value / stretch**k for k, value in enumerate(more))


def _scca_at(law, x):
    shares = [mpmath.mpf(share) for share in law.shares]
    pieces = naive.scca(*(share / sum(shares) for share in shares), mpmath.mp)
    return next((jet for _, end, jet in pieces if x <= end), pieces[-1][2])(x)


def _polynomial_at(law, x):
    return naive.conditions(law.start, law.end, mpmath.mp)(x)


def _spline_at(law, x):
    knots = tuple(map(mpmath.mpf, law.knots))
    span = max(k for k in range(law.degree, len(law.coefficients)) if knots[k] <= x)

    @cache
    def basis(i, degree, order):
        if not i <= span <= i + degree:
            return mpmath.mpf(0)
        if degree == 0:
            return mpmath.mpf(order == 0)
        rise, fall = knots[i + degree] - knots[i], knots[i + degree + 1] - knots[i + 1]
        left, right = (x - knots[i], knots[i + degree + 1] - x) if order == 0 else (degree, -degree)
        lower = max(order - 1, 0)
        found = left / rise * basis(i, degree - 1, lower) if rise else 0
        return found + (right / fall * basis(i + 1, degree - 1, lower) if fall else 0)

    return tuple(
        sum(
            mpmath.mpf(law.coefficients[i]) * basis(i, law.degree, order)
            for i in range(span - law.degree, span + 1)
        )
        for order in range(4)
    )

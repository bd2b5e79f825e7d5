"""Integrals over the panels of a turn by Gauss's rule, with rising order until two orders agree; and interpolation.

On a panel the integrand is smooth, so the error falls with a power of the order. The difference between two orders
is far above the error of the higher one. Derivatives along a panel are those of the polynomial through its points.

Source: Stoer and Bulirsch, Introduction to Numerical Analysis, ch. 3; for derivatives Berrut and Trefethen,
SIAM Review 46 (2004), ch. 9. Nodes, weights and matrices have the same bits on every processor.
"""

from collections.abc import Callable
from decimal import Decimal, localcontext
from functools import cache
from math import cos, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import matrix_product
from camopt.core.numerics.trigonometry import sine_cosine

GAUSS_ORDERS = (6, 9, 13, 19, 28, 40)
SUM_ERROR = 5e-14  # relative rounding error of laws, of derivatives on panels of 1/100 turn, and of sums

ROOT_DIGITS, NEWTON_STEPS = 40, 6  # digits of roots; each step doubles the correct digits, from two on


class GaussRule(NamedTuple):
    """Gauss's rule on [−1, 1], with the matrix from values to derivatives at its nodes."""

    nodes: FloatArray
    weights: FloatArray
    derivative: FloatArray


@cache
def gauss_rule(order: int) -> GaussRule:
    """Gauss's rule with n points, exact for polynomials of degree 2n − 1."""
    nodes, weights = np.array([_legendre_root_and_weight(order, k) for k in reversed(range(order))]).T.copy()
    share = (-1.0) ** np.arange(order) * np.sqrt((1.0 - nodes**2) * weights)  # barycentric
    derivative = share / share[:, None] / (nodes[:, None] - nodes + np.eye(order))
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return GaussRule(nodes, weights, derivative)


def _legendre_root_and_weight(order: int, root_number: int) -> tuple[float, float]:
    """A root of Legendre's polynomial, the largest first, and its weight, by Newton's method with many digits."""
    with localcontext(prec=ROOT_DIGITS):
        x = Decimal(cos(pi * (root_number + 0.75) / (order + 0.5)))
        for _ in range(NEWTON_STEPS):
            before, here = Decimal(1), x
            for k in range(1, order):
                before, here = here, ((2 * k + 1) * x * here - k * before) / (k + 1)
            slope = order * (x * here - before) / (x * x - 1)
            x -= here / slope
        return float(x), float(2 / ((1 - x * x) * slope * slope))


def chebyshev_nodes_and_matrix(degree: int) -> tuple[FloatArray, FloatArray]:
    """Nodes inside (−1, 1) and the matrix from values there to coefficients of Chebyshev polynomials."""
    count = degree + 1
    _, cosines = sine_cosine(np.pi / (2 * count) * np.arange(4 * count))
    halves = np.arange(2 * count - 1, 0, -2)  # multiples of π/(2·count) at which the nodes are
    series = 2.0 / count * cosines[np.outer(np.arange(count), halves) % (4 * count)]
    series[0] /= 2.0
    return cosines[halves], series


def chebyshev_to_powers_matrix(degree: int) -> FloatArray:
    """Matrix from coefficients of Chebyshev polynomials to those of powers."""
    count = degree + 1
    return np.array([np.pad(chebyshev.cheb2poly(row), (0, count))[:count] for row in np.eye(count)]).T


@cache
def chebyshev_nodes_and_powers_matrix(degree: int) -> tuple[FloatArray, FloatArray]:
    """Nodes inside (−1, 1) and the matrix from values there to power-basis coefficients."""
    u, to_chebyshev = chebyshev_nodes_and_matrix(degree)
    return u, matrix_product(chebyshev_to_powers_matrix(degree), to_chebyshev)


class Integrals(NamedTuple):
    """Integrals (kinds, n) and their errors: the difference of two orders plus rounding."""

    value: FloatArray
    error: FloatArray


def integrate_with_rising_order(
    integrals_by_rule: Callable[[GaussRule, Any], FloatArray],
    error_scale: Callable[[FloatArray], FloatArray],
    integral_count: int,
    relative_error: float,
) -> Integrals:
    """Integrals (kinds, integral_count), each by the lowest order that differs little enough from the order before.

    ``integrals_by_rule`` computes them for a rule and an index; errors are relative to ``error_scale``.
    """
    value = integrals_by_rule(gauss_rule(GAUSS_ORDERS[0]), slice(None))
    error, open_ = np.full_like(value, np.inf), np.arange(integral_count)
    for order in GAUSS_ORDERS[1:]:
        closer = integrals_by_rule(gauss_rule(order), open_)
        difference = np.abs(closer - value[:, open_])
        value[:, open_] = closer
        error[:, open_] = difference + SUM_ERROR * error_scale(closer)
        open_ = open_[np.any(difference > relative_error * error_scale(closer), axis=0)]
        if not open_.size:
            break
    return Integrals(value, error)

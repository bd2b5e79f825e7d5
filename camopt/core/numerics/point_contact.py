"""The pressure of a point contact as a function of the ratio t of its relative radii, for all number types.

Two bodies touch in an ellipse, with half-axis a in the plane of R' and b in that of R'', across it. With μ = b/a
and Carlson's integrals D = R_D(0, μ², 1)/3 and B = μ²·R_D(0, 1, μ²)/3,

    t = R'/R'' = B/(μ²·D),    p₀³ = (E*²/R''²)·N·h(t),    h = 3·μ/(8·π·B²),    a = 2·R''·p₀·B/(μ·E*)

for any t > 0: a circle at t = 1, where h = 6/π³. In elliptic integrals B = (E − (1−k²)·K)/k², D = (K − E)/k².

h falls, h' rises, h'' falls and h''' rises with t, because t·h rises or falls no faster than √t. So the range of h
over a range of t follows from its ends. For numbers h is a table over ln t, with the relative error
``PRESSURE_ERROR``.

Source: Johnson, Contact Mechanics, 4.1 and 4.2; DLMF 19.25 for the integrals.
"""

from functools import lru_cache, singledispatch
from typing import Any

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels
from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray, Number
from camopt.core.numerics.dual import Dual
from camopt.core.numerics.interval import Interval, widen
from camopt.core.numerics.jet import Jet, select
from camopt.core.numerics.quadrature import chebyshev_nodes_and_matrix, chebyshev_to_powers_matrix
from camopt.core.numerics.sloped_interval import Quotient, SlopedInterval, apply_chain_rule
from camopt.core.numerics.stable_functions import matrix_product

PIECE_WIDTH, CENTRES, PIECE_DEGREE = 0.5, 46, 15  # width of a piece in ln t, pieces to either side of 0, degree
FLATTEST = float(np.exp(PIECE_WIDTH * CENTRES))  # largest t of the table, 1e10; the smallest is its inverse
PRESSURE_ERROR = 32.0 * UNIT_ROUNDOFF  # relative error of h for numbers
BOUND_SLACK = 1.0 + 1e-9  # factor on bounds of derivatives: the table's third derivative errs by 2e-10
ITERATIONS = 24  # each reduces the error to less than a seventh


def carlson_integrals(ellipticity: Any) -> tuple[Number, Number]:
    """Carlson's integrals B and D of μ."""
    from scipy.special import elliprd

    square = ellipticity * ellipticity
    return square * elliprd(0.0, 1.0, square) / 3.0, elliprd(0.0, square, 1.0) / 3.0


def contact_half_axis_ratio(radius_ratio: Any) -> FloatArray:
    """Ratio μ = b/a of a contact's half-axes.

    −d ln t/d ln μ lies between 3/2 (a circle) and 2 (a line), so steps with the slope 7/4 converge from anywhere.
    """
    target = np.log(radius_ratio)
    guess = -target / 1.75
    for _ in range(ITERATIONS):
        b, d = carlson_integrals(np.exp(guess))
        guess = guess + (np.log(b / d) - 2.0 * guess - target) / 1.75
    return np.asarray(np.exp(guess))


@lru_cache(maxsize=1)
def pressure_factor_coefficients() -> FloatArray:
    """Coefficients of t·h (pieces, powers), in powers of ln t less the piece's centre, lowest first."""
    nodes, to_chebyshev = chebyshev_nodes_and_matrix(PIECE_DEGREE)
    centres = PIECE_WIDTH * np.arange(-CENTRES, CENTRES + 1)
    mu = contact_half_axis_ratio(np.exp(centres + 0.5 * PIECE_WIDTH * nodes[:, None]))
    b, d = carlson_integrals(mu)
    fitted = matrix_product(to_chebyshev, 3.0 / (8.0 * np.pi * mu * b * d))
    powers = matrix_product(chebyshev_to_powers_matrix(PIECE_DEGREE), fitted).T
    return np.ascontiguousarray(powers / (0.5 * PIECE_WIDTH) ** np.arange(PIECE_DEGREE + 1))


@inline_in_kernels
def pressure_factor_derivatives(t, table):
    """h and three derivatives by t; t is clipped to the table."""
    t = np.minimum(np.maximum(t, 1.0 / FLATTEST), FLATTEST)
    logarithm = np.log(t)
    piece = np.rint(logarithm / PIECE_WIDTH)
    row = np.int64(piece) + CENTRES
    z = logarithm - PIECE_WIDTH * piece
    q, q1, q2, q3 = (
        table[row, PIECE_DEGREE],
        0.0,
        0.0,
        0.0,
    )  # derivatives by ln t; the second divided by 2, the third by 6
    for k in range(PIECE_DEGREE - 1, -1, -1):
        q3 = q3 * z + q2
        q2 = q2 * z + q1
        q1 = q1 * z + q
        q = q * z + table[row, k]
    q2, q3 = 2.0 * q2, 6.0 * q3
    return (
        q / t,
        (q1 - q) / (t * t),
        (q2 - 3.0 * q1 + 2.0 * q) / (t * t * t),
        (q3 - 6.0 * q2 + 11.0 * q1 - 6.0 * q) / (t * t * t * t),
    )


@inline_in_kernels
def pressure_factor_of_jet(t, table):
    """h of a jet, with bounds from the ends of its range; infinite outside the table."""
    within = (t.low >= 1.0 / FLATTEST) & (t.high <= FLATTEST)
    most, h1, h2, h3 = pressure_factor_derivatives(t.low, table)
    least = pressure_factor_derivatives(t.high, table)[0]
    h1, h2, h3 = -h1, h2, -h3
    scale = select(within, BOUND_SLACK, np.inf)
    return Jet(
        select(t.high <= FLATTEST, least, 0.0),
        select(within, most, np.inf),
        scale * (h1 * t.error + PRESSURE_ERROR * most),
        scale * (h1 * t.first),
        scale * (h2 * t.first * t.first + h1 * t.second),
        scale * (h3 * t.first * t.first * t.first + 3.0 * h2 * t.first * t.second + h1 * t.third),
    )


@singledispatch
def pressure_factor_and_derivative(t: Any, table: FloatArray) -> tuple[Number, Number]:
    """h and h' of numbers, jets, intervals or dual numbers.

    A number outside the table has the h of the table's nearest end.
    """
    h, h1, *_ = pressure_factor_derivatives(np.asarray(t, dtype=float), table)
    return h, h1


@pressure_factor_and_derivative.register
def _pressure_factor_pair_of_jet(t: Jet, table: FloatArray) -> tuple[Number, Number]:
    return pressure_factor_of_jet(t, table), Jet(-np.inf, 0.0, np.inf, np.inf, np.inf, np.inf)


@pressure_factor_and_derivative.register
def _pressure_factor_and_derivative_of_interval(t: Interval, table: FloatArray) -> tuple[Interval, Interval]:
    (high, steep, *_), (low, gentle, *_) = (
        pressure_factor_derivatives(t.low, table),
        pressure_factor_derivatives(t.high, table),
    )
    low = np.where(t.high > FLATTEST, 0.0, low)
    below = t.low < 1.0 / FLATTEST
    value, slope = Interval(low, np.where(below, np.inf, high)), Interval(np.where(below, -np.inf, steep), gentle)
    return widen(value, PRESSURE_ERROR), widen(slope, BOUND_SLACK - 1.0)


@pressure_factor_and_derivative.register
def _pressure_factor_pair_of_sloped(t: SlopedInterval, table: FloatArray) -> tuple[SlopedInterval, SlopedInterval]:
    (value, slope), (h, h1) = (
        _pressure_factor_and_derivative_of_interval(t.value, table),
        _pressure_factor_and_derivative_of_interval(t.at, table),
    )
    return apply_chain_rule(value, h, [(t, slope)]), apply_chain_rule(
        slope, h1, [(t, Interval(np.array(0.0), np.array(np.inf)))]
    )


@pressure_factor_and_derivative.register
def _pressure_factor_pair_of_quotient(t: Quotient, table: FloatArray) -> tuple[Number, Number]:
    return pressure_factor_and_derivative(t.divide(), table)


@pressure_factor_and_derivative.register(Dual)
def _pressure_factor_pair_of_dual(t, table):
    h, h1 = pressure_factor_and_derivative(t.value, table)
    return Dual(h, h1 * t.slope), h1


@chosen_by_type(pressure_factor_and_derivative)
def _choose_pressure_factor_for_kernels(t, table):
    if t is Dual:
        return _pressure_factor_pair_of_dual
    if t is Jet:
        return lambda t, table: (
            pressure_factor_of_jet(t, table),
            Jet(-np.inf, 0.0, np.inf, np.inf, np.inf, np.inf),
        )
    return lambda t, table: pressure_factor_derivatives(t, table)[:2]

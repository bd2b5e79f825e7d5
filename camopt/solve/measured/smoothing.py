"""The smoothing spline of measured points, by generalised cross-validation.

Of all closed curves it minimises Σ (y(θᵢ) − yᵢ)² + μ·∫ (y''')² dθ. It is a quintic spline with knots at the points.
Its degrees of freedom f are the trace of the matrix from the lifts to those of the curve. The weight μ minimises
Σ r²/(n − 1.4·f)² of the residuals r: the error of a curve through all other points at each point. A factor of 1
would follow the errors of one file in a hundred.

One basis of eigenvectors, of ∫ (y''')² dθ in the measure of the points, serves all μ (Demmler and Reinsch).

Sources: Wahba, Spline Models for Observational Data, 1990, ch. 4; Kim and Gu, Smoothing spline Gaussian regression,
J. R. Statist. Soc. B 66, 2004 (the factor 1.4).
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.linalg import eigh

from camopt.core.numerics import FloatArray
from camopt.core.numerics.bsplines import derivative_matrix
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints
from camopt.solve.measured.spline_chain import CHAIN_DEGREE

SMOOTHED_ORDER = 3  # order of the smoothed derivative
MOST_KNOTS = 360
TRACE_FACTOR = 1.4
MOST_FREEDOM_SHARE = 0.7  # most degrees of freedom per point: TRACE_FACTOR times it stays below 1
JERK_WEIGHTS = np.exp(np.arange(-40.0, 10.0, 0.1))  # weights μ of the jerk, by x over a turn
BASES_KEPT = 4  # cached bases, of up to some MB each
REGULARISATION_SHARE = 1e-10  # regularisation of the measure, for knots without points beside them


class SmoothingFit(NamedTuple):
    """The smoothing spline at its points: residuals, leverage of each point, and degrees of freedom f."""

    residuals: FloatArray
    leverages: FloatArray
    freedom: float


def smoothing_residuals_and_leverages(points: MeasuredPoints) -> SmoothingFit:
    """The smoothing spline of points by generalised cross-validation.

    Knots are at the angles of the points, or at 360 of these if there are more.
    """
    rough, curves = _roughness_eigenbasis(points.angles.tobytes())
    lifts = points.lifts - points.lifts.mean()
    parts = curves.T @ lifts
    unexplained = max(float(lifts @ lifts - parts @ parts), 0.0)  # squares that no spline with these knots explains
    shrinkage = 1.0 / (1.0 + JERK_WEIGHTS[:, None] * np.maximum(rough, 0.0))
    freedom = shrinkage.sum(axis=1)
    allowed = np.flatnonzero(freedom <= MOST_FREEDOM_SHARE * lifts.size)
    residual_squares = unexplained + (1.0 - shrinkage[allowed]) ** 2 @ parts**2
    best = allowed[np.argmin(residual_squares / (lifts.size - TRACE_FACTOR * freedom[allowed]) ** 2)]
    return SmoothingFit(
        lifts - curves @ (shrinkage[best] * parts), curves**2 @ shrinkage[best], float(freedom[best])
    )


@lru_cache(maxsize=BASES_KEPT)
def _roughness_eigenbasis(angle_bytes: bytes) -> tuple[FloatArray, FloatArray]:
    """Roughness of the curves of a basis, and their values at given angles [deg, as the bytes of doubles].

    It takes a tenth of a second. Lifts measured at the same angles share it.
    """
    basis, roughness = _closed_bspline_basis(np.frombuffer(angle_bytes) / TURN_DEG)
    measure = (basis.T @ basis).toarray()
    measure += np.eye(len(measure)) * REGULARISATION_SHARE * np.trace(measure) / len(measure)
    rough, vectors = eigh(roughness.toarray(), measure)
    return rough, basis @ vectors


def _closed_bspline_basis(x: FloatArray) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Closed B-splines at points of a turn of 1, and the matrix of ∫ (y''')² dx."""
    knots = np.unique(x)
    if knots.size > MOST_KNOTS:
        knots = knots[np.linspace(0, knots.size, MOST_KNOTS, endpoint=False).astype(int)]
    around = np.concatenate([knots[-CHAIN_DEGREE:] - 1.0, knots, knots[: CHAIN_DEGREE + 1] + 1.0])
    closed = sparse.csr_array(np.eye(knots.size)[np.arange(knots.size + CHAIN_DEGREE) % knots.size])
    change = derivative_matrix(around, CHAIN_DEGREE, SMOOTHED_ORDER) @ closed
    nodes, weights = np.polynomial.legendre.leggauss(CHAIN_DEGREE - 2)
    starts, half = (
        around[CHAIN_DEGREE : -CHAIN_DEGREE - 1, None],
        np.diff(around[CHAIN_DEGREE:-CHAIN_DEGREE])[:, None] / 2.0,
    )
    inside = (starts + half * (1.0 + nodes)).ravel()
    trimmed, degree = around[SMOOTHED_ORDER:-SMOOTHED_ORDER], CHAIN_DEGREE - SMOOTHED_ORDER
    jerk = BSpline.design_matrix(inside, trimmed, degree, extrapolate=True) @ change
    weighted = sparse.diags_array(np.sqrt(half * weights).ravel()) @ jerk
    turned = knots[0] + np.mod(x - knots[0], 1.0)
    return BSpline.design_matrix(turned, around, CHAIN_DEGREE, extrapolate=True) @ closed, weighted.T @ weighted

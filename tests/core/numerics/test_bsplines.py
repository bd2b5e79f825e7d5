"""The derivative of a B-spline as a matrix, against scipy's values."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from camopt.core.numerics.bsplines import derivative_matrix


@st.composite
def knot_rows(draw):
    """Clamped knots, inner ones up to as often as the degree."""
    degree = draw(st.integers(0, 6))
    inner = draw(st.lists(st.integers(1, 99), unique=True, max_size=8))
    often = [draw(st.integers(1, max(degree, 1))) for _ in inner]
    ends = degree + 1
    return degree, np.array([0.0] * ends + sorted(np.repeat(inner, often) / 100.0) + [1.0] * ends)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@given(row=knot_rows(), seed=st.integers(0, 10**6))
def test_derivatives_are_those_of_scipy(order, row, seed):
    degree, knots = row
    if order > degree:
        return
    rng = np.random.default_rng(seed)
    coefficients, x = rng.normal(size=knots.size - degree - 1), rng.uniform(size=20)
    inner = knots[order : knots.size - order]
    basis = BSpline.design_matrix(x, inner, degree - order)
    values = basis @ (derivative_matrix(knots, degree, order) @ coefficients)
    expected = BSpline(knots, coefficients, degree)(x, order)
    np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9 * max(np.abs(expected).max(), 1.0))

"""B-splines as matrices, against scipy's and against their identities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from camopt.numerics.bsplines import basis_matrix, derivative_matrix


@st.composite
def knot_rows(draw):
    """Clamped knots, inner ones up to as often as the degree."""
    degree = draw(st.integers(0, 6))
    inner = draw(st.lists(st.integers(1, 99), unique=True, max_size=8))
    often = [draw(st.integers(1, max(degree, 1))) for _ in inner]
    ends = degree + 1
    return degree, np.array([0.0] * ends + sorted(np.repeat(inner, often) / 100.0) + [1.0] * ends)


@given(knot_rows(), st.lists(st.floats(0.0, 1.0), max_size=30))
def test_values_are_those_of_scipy_and_their_sum_is_1(row, x):
    degree, knots = row
    x = np.array([*x, 0.0, 1.0])
    matrix = basis_matrix(knots, degree, x).toarray()
    np.testing.assert_allclose(matrix, BSpline.design_matrix(x, knots, degree).toarray(), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(matrix.sum(axis=1), 1.0, rtol=1e-13)
    assert matrix.min() >= 0.0
    assert basis_matrix(knots, degree, x[:0]).shape == (0, knots.size - degree - 1)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@given(row=knot_rows(), seed=st.integers(0, 10**6))
def test_derivatives_are_those_of_scipy(order, row, seed):
    degree, knots = row
    if order > degree:
        return
    rng = np.random.default_rng(seed)
    coefficients, x = rng.normal(size=knots.size - degree - 1), rng.uniform(size=20)
    inner = knots[order : knots.size - order]
    values = basis_matrix(inner, degree - order, x) @ (derivative_matrix(knots, degree, order) @ coefficients)
    expected = BSpline(knots, coefficients, degree)(x, order)
    np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9 * max(np.abs(expected).max(), 1.0))

"""Polynomials by the conditions at their ends: against equations at 50 digits, and against the books."""

from math import comb

import mpmath
import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st
from support import own
from support.balls.ball import precisely
from support.balls.laws import pieces_of
from support.depth import times

from camopt.model.motion import LAWS
from camopt.model.motion.polynomial import HIGHEST_DEGREE, PolynomialLaw

VERBS = ("displacement", "velocity", "acceleration", "jerk")
X = np.linspace(0.0, 1.0, 101)
VALUES = st.one_of(st.just(0.0), st.floats(-10.0, 10.0))
CONDITIONS = (
    st.lists(VALUES, min_size=1, max_size=HIGHEST_DEGREE + 1)
    .flatmap(lambda values: st.tuples(st.just(values), st.integers(0, len(values))))
    .map(lambda made: PolynomialLaw("p", tuple(made[0][: made[1]]), tuple(made[0][made[1] :])))
)


def at_rest(start, end):
    return PolynomialLaw("p", (0.0,) * start, (1.0, *(0.0,) * (end - 1)))


@pytest.mark.parametrize(("law", "conditions"), [("cubic", 2), ("poly345", 3), ("poly4567", 4), ("poly56789", 5)])
def test_rest_at_both_ends_gives_the_polynomials_of_the_books(law, conditions):
    made = at_rest(conditions, conditions)
    for verb in VERBS:
        expected = getattr(LAWS[law], verb)(X)
        np.testing.assert_allclose(getattr(made, verb)(X), expected, rtol=0, atol=4e-15 * np.abs(expected).max())


@pytest.mark.parametrize("conditions", range(1, 7))
def test_a_stroke_of_full_rest_is_the_smoothstep_of_any_order(conditions):
    """s' = (2n − 1)!/(n − 1)!²·xⁿ⁻¹(1 − x)ⁿ⁻¹ for n conditions at each end: its digits are full near both."""
    n = conditions
    x = np.array([1e-40, 1e-15, 1e-3, 0.25, 0.5, 0.875, 1.0 - 2.0**-20, 1.0 - 2.0**-53])
    expected = (2 * n - 1) * comb(2 * n - 2, n - 1) * (x * (1.0 - x)) ** (n - 1)
    np.testing.assert_allclose(at_rest(n, n).velocity(x), expected, rtol=1e-15 * 4 * n)


@settings(max_examples=times(30, deep=1000))
@given(CONDITIONS, st.floats(0.0, 1.0))
@mpmath.workdps(50)
@precisely()
def test_any_conditions_against_fifty_digits_and_exactly(law, x):
    (piece,) = pieces_of(law)
    for order, exact in enumerate(own.law_at(law, mpmath.mpf(x))):
        ball = piece.derivative(order, arb(x))
        assert abs(mpmath.mpf(ball.mid().str(50, radius=False)) - exact) <= mpmath.mpf("1e-35")
        terms = np.abs(law._bernstein_terms[order]).max(initial=0.0)
        assert abs(mpmath.mpf(float(getattr(law, VERBS[order])(x))) - exact) <= 1e-14 * terms + 1e-40


@settings(max_examples=times(30, deep=1000))
@given(CONDITIONS)
def test_its_ends_are_as_given(law):
    for x, conditions in ((0.0, law.start), (1.0, law.end)):
        for order, value in enumerate(conditions[:4]):
            assert float(getattr(law, VERBS[order])(x)) == value


def test_the_eighth_power_polynomial_is_that_in_print():
    """Kloomok and Muffley: s = 6.09755x³ − 20.7804x⁵ + 26.73155x⁶ − 13.60965x⁷ + 2.56095x⁸."""
    printed = np.polynomial.Polynomial([0, 0, 0, 6.09755, 0, -20.7804, 26.73155, -13.60965, 2.56095])
    for order, verb in enumerate(VERBS):
        expected = (printed.deriv(order) if order else printed)(X)
        np.testing.assert_allclose(getattr(LAWS["poly8"], verb)(X), expected, rtol=0, atol=2e-12)

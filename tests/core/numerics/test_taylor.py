"""Taylor series: against derivatives to 50 digits, and identities."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.balls.ball import Ball, precisely

from camopt.core.numerics.taylor import Taylor, cosine_and_sine_series, vector_angle

TERMS = st.lists(st.floats(-3, 3), min_size=4, max_size=4)


def taylor_series(function, x, count=5):
    """The series of a function (of mpmath) at x."""
    return Taylor([float(term) for term in mpmath.taylor(function, x, count - 1)])


def f(x):
    return 2 + mpmath.sin(x)


def g(x):
    return mpmath.exp(x) / 3


CASES = {
    "sum": (lambda a, b: a + b + 1.5, lambda x: f(x) + g(x) + 1.5),
    "difference": (lambda a, b: a - b - 1.5, lambda x: f(x) - g(x) - 1.5),
    "negative": (lambda a, b: -a, lambda x: -f(x)),
    "product": (lambda a, b: a * b * 2.0, lambda x: f(x) * g(x) * 2),
    "quotient": (lambda a, b: a / b, lambda x: f(x) / g(x)),
    "root": (lambda a, b: a.root(), lambda x: mpmath.sqrt(f(x))),
    "cosine": (lambda a, b: cosine_and_sine_series(b).cosine, lambda x: mpmath.cos(g(x))),
    "sine": (lambda a, b: cosine_and_sine_series(b).sine, lambda x: mpmath.sin(g(x))),
    "angle": (vector_angle, lambda x: mpmath.atan2(g(x), f(x))),
    "slope": (lambda a, b: (a * b).slope.integral(0.25), lambda x: f(x) * g(x) - f(0.3) * g(0.3) + 0.25),
}


@pytest.mark.parametrize("name", CASES)
def test_an_operation_is_that_of_the_functions(name):
    """Each to the fourth derivative, against mpmath's numerical ones."""
    operation, function = CASES[name]
    with mpmath.workdps(50):
        found, exact = (
            operation(taylor_series(f, 0.3), taylor_series(g, 0.3)),
            taylor_series(function, mpmath.mpf(0.3)),
        )
    assert found.terms == pytest.approx(exact.terms, rel=1e-13, abs=1e-15)
    assert [found.derivative(k) for k in range(5)] == pytest.approx(
        [term * mpmath.factorial(k) for k, term in enumerate(exact.terms)], rel=1e-13, abs=1e-14
    )


@given(TERMS, TERMS)
def test_identities(a, b):
    a, b = Taylor(a), Taylor([b[0] + 5.0, *b[1:]])
    turned = cosine_and_sine_series(a)
    assert ((a * b) / b).terms == pytest.approx(a.terms, abs=1e-9)
    assert (b.root() * b.root()).terms == pytest.approx(b.terms, abs=1e-12)
    assert (turned.cosine * turned.cosine + turned.sine * turned.sine).terms == pytest.approx(
        (1, 0, 0, 0), abs=1e-12
    )
    again = vector_angle(turned.cosine, turned.sine)
    assert again.terms[1:] == pytest.approx(a.terms[1:], abs=1e-12)


def test_terms_may_be_arrays_and_balls():
    x = np.array([0.1, 0.2])
    series = cosine_and_sine_series(Taylor([x, 2.0, 0.0])).cosine
    assert series.terms[1] == pytest.approx(-2.0 * np.sin(x))
    with precisely():
        ball = cosine_and_sine_series(Taylor([Ball(0.1), Ball(2.0), Ball(0.0)])).cosine.terms[1]
        assert float(ball.arb.mid()) == pytest.approx(series.terms[1][0], rel=1e-15)

"""Sine and cosine in vector registers: to rounding, compiled and uncompiled alike."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.balls.ball import Ball, precisely

from camopt.core.kernels.compile import compiled
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.jet import UNIT_ROUNDOFF
from camopt.core.numerics.stable_functions import triangle_angle
from camopt.core.numerics.trigonometry import arctangent, cosine_and_sine_of_sum, sine_cosine


@compiled
def in_a_kernel(y, sine, cosine):
    for i in range(y.size):
        sine[i], cosine[i] = sine_cosine(y[i])


@pytest.mark.parametrize("flat", [0.0, 1e-15, 1e-9, 1e-3, 0.5])
def test_the_angle_of_a_triangle_keeps_its_digits_where_it_is_flat(flat):
    """By the law of cosines in 50 digits; a triangle that cannot be has the angle of the nearest one."""
    rng = np.random.default_rng(1)
    a, b = rng.uniform(1.0, 200.0, (2, 400))
    share = np.where(rng.uniform(size=400) < 0.5, flat, 1.0 - flat)
    third = np.abs(a - b) * (1.0 - share) + (a + b) * share
    found = triangle_angle(a, b, third)
    with mpmath.workdps(50):
        for x, y, z, angle in zip(a.tolist(), b.tolist(), third.tolist(), found.tolist(), strict=True):
            cosine = (mpmath.mpf(x) ** 2 + mpmath.mpf(y) ** 2 - mpmath.mpf(z) ** 2) / (2 * mpmath.mpf(x) * y)
            known = mpmath.acos(max(-1, min(1, cosine)))
            assert abs(angle - known) <= 4 * UNIT_ROUNDOFF * known
    assert triangle_angle(3.0, 5.0, 1.9) == 0.0
    assert triangle_angle(3.0, 5.0, 8.1) == np.pi
    ends = triangle_angle(Interval(a, a), b, Interval(third, third * (1.0 + 1e-9)))
    assert np.all(ends.low <= found * (1.0 + 1e-15))
    assert np.all(found <= ends.high * (1.0 + 1e-15))


def test_against_fifty_digits_and_compiled_alike():
    rng = np.random.default_rng(0)
    y = np.concatenate([rng.uniform(-7, 7, 2000), rng.uniform(-1000, 1000, 2000), np.arange(-8, 9) * np.pi / 4])
    sine, cosine = sine_cosine(y)
    with mpmath.workdps(50):
        for angle, s, c in zip(y.tolist(), sine.tolist(), cosine.tolist(), strict=True):
            assert abs(mpmath.sin(angle) - s) <= 1.5 * UNIT_ROUNDOFF
            assert abs(mpmath.cos(angle) - c) <= 1.5 * UNIT_ROUNDOFF
    found = np.empty((2, y.size))
    in_a_kernel(y, found[0], found[1])
    assert found[0].tobytes() == sine.tobytes()
    assert found[1].tobytes() == cosine.tobytes()


def test_arctangents_against_fifty_digits():
    """To a unit in the last place, by any number of them together, of either sign."""
    rng = np.random.default_rng(0)
    y = np.concatenate([10.0 ** rng.uniform(-320, 308, 2000), rng.uniform(-5, 5, 4000), [0.0, 1.0, np.inf]])
    found = arctangent(y)
    with mpmath.workdps(50):
        for tangent, angle in zip(y.tolist(), found.tolist(), strict=True):
            assert abs(mpmath.atan(tangent) - angle) <= np.spacing(abs(angle))
    assert [float(arctangent(each)) for each in y[::40].tolist()] == found[::40].tolist()
    assert (arctangent(-y) == -found).all()
    assert arctangent(Interval(y[:1], y[:1])).high >= found[:1]


@given(st.floats(1e-300, 1e-3))
def test_small_angles_keep_their_digits(y):
    assert sine_cosine(y)[0] == pytest.approx(np.sin(y), rel=4 * UNIT_ROUNDOFF, abs=0)
    assert sine_cosine(-y)[0] == -sine_cosine(y)[0]
    assert sine_cosine(-y)[1] == sine_cosine(y)[1]


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_an_angle_turned_on(start, y):
    cosine, sine = cosine_and_sine_of_sum(np.cos(start), np.sin(start), y)
    assert cosine == pytest.approx(np.cos(start + y), abs=8 * UNIT_ROUNDOFF)
    assert sine == pytest.approx(np.sin(start + y), abs=8 * UNIT_ROUNDOFF)


@precisely()
def test_what_stands_for_a_number():
    sine, cosine = sine_cosine(Interval(np.array([0.1]), np.array([0.2])))
    assert sine.low <= np.sin(0.15) <= sine.high
    assert cosine.low <= np.cos(0.15) <= cosine.high
    assert abs(float(sine_cosine(Ball(0.3))[0].arb) - np.sin(0.3)) < UNIT_ROUNDOFF

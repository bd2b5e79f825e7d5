"""The SCCA family: its members, its closed form, and any shares against 50 digits."""

from math import pi

import mpmath
import numpy as np
import pytest
from flint import arb
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support import own
from support.balls.ball import precisely
from support.balls.laws import pieces_of
from support.depth import times

from camopt.model.motion import LAWS
from camopt.model.motion.programme import law_peaks
from camopt.model.motion.scca import SCCALaw

VERBS = ("displacement", "velocity", "acceleration", "jerk")
SHARE = st.one_of(st.just(0.0), st.floats(0.01, 1.0))
SHARES = st.tuples(SHARE, SHARE, SHARE, SHARE).filter(lambda shares: sum(shares[:3]) > 0.0)


@pytest.mark.parametrize(
    ("law", "shares"),
    [("parabolic", (0.0, 1.0, 0.0, 0.0)), ("harmonic", (0.0, 0.0, 1.0, 0.0)), ("cycloidal", (0.5, 0.0, 0.5, 0.0))],
)
def test_the_family_joins_older_laws(law, shares):
    member, x = SCCALaw("member", shares), np.linspace(0.0, 1.0, 1001)
    for verb in VERBS:
        expected = getattr(LAWS[law], verb)(x)
        np.testing.assert_allclose(getattr(member, verb)(x), expected, rtol=0, atol=1e-15 * np.abs(expected).max())
    assert {key: pytest.approx(value, rel=1e-13) for key, value in law_peaks(member).items() if key != "jumps"} == {
        key: value for key, value in law_peaks(LAWS[law]).items() if key != "jumps"
    }


PIECES = {  # displacements up to the middle in print, of several books: from, a polynomial, size and wave of a sine
    "modified-trapezoid": [
        (0.0, (0.0, 0.38898448), -0.0309544, (4 * pi, 0.0)),
        (0.125, (0.00723407, -0.22203097, 2.44406184), 0.0, (0.0, 0.0)),
        (0.375, (-0.3055077, 1.6110154), -0.0309544, (4 * pi, -pi)),
    ],
    "modified-sine": [
        (0.0, (0.0, 0.43990085), -0.0350062, (4 * pi, 0.0)),
        (0.125, (0.28004957, 0.43990085), -0.31505577, (4 * pi / 3, pi / 3)),
    ],
}


@pytest.mark.parametrize("law", PIECES)
def test_displacements_are_those_in_print(law):
    x = np.linspace(0.0, 0.5, 101)
    expected = np.zeros_like(x)
    for start, powers, size, (speed, phase) in PIECES[law]:
        piece = np.polynomial.Polynomial(powers)(x) + size * np.sin(speed * x + phase)
        expected = np.where(x < start, expected, piece)
    np.testing.assert_allclose(LAWS[law].displacement(x), expected, rtol=0, atol=1e-7)


@given(st.floats(0.0, 0.95))
@example(0.5)
def test_modified_constant_velocity_of_any_share_is_that_of_a_published_library(share):
    """Its largest acceleration from the length t of a ramp: docs.rs/dsmc, trajectory/mcv.rs."""
    t = (1.0 - share) / 8.0
    size = pi**2 / (8.0 * t * ((8.0 - 6.0 * pi) * t + pi))
    law = SCCALaw("own", (2 * t, 0.0, 6 * t, share))
    assert float(law.acceleration(t)) == pytest.approx(size, rel=1e-13)
    if share == 0.5:
        assert law.BREAKS == LAWS["modified-constant-velocity"].BREAKS


@settings(max_examples=times(60, deep=1000))
@given(SHARES)
def test_peaks_are_those_of_the_closed_form(shares):
    b, c, d, e = np.array(shares) / sum(shares)
    p, fast = b + c + d, (b + d) / pi + c / 2
    through = ((pi**2 - 8) * (b * b - d * d) - 2 * pi * (pi - 2) * b * p + (pi * p) ** 2) / (4 * pi**2)
    size = 1 / (through + fast * e)
    found = law_peaks(SCCALaw("own", shares))
    assert found["peak_velocity"] == pytest.approx(fast * size, rel=1e-12)
    assert found["peak_acceleration"] == pytest.approx(size, rel=1e-12)
    smooth = b > 0.0 and (d > 0.0)
    assert found["jumps"] == ("" if smooth else "acceleration")
    if smooth:
        assert found["peak_jerk"] == pytest.approx(pi * size / min(b, d), rel=1e-12)


@settings(max_examples=times(60, deep=1000))
@given(SHARES, st.floats(0.0, 1.0))
@mpmath.workdps(50)
@precisely()
def test_any_shares_against_fifty_digits_and_exactly(shares, share):
    law = SCCALaw("own", shares)
    scale = [np.abs(getattr(law, verb)(np.linspace(0.0, 1.0, 2001))).max() for verb in VERBS]
    for piece in pieces_of(law):
        x = float(piece.start + (piece.end - piece.start) * (0.01 + 0.98 * share))
        for order, exact in enumerate(own.law_at(law, mpmath.mpf(x))):
            ball = piece.derivative(order, arb(x))
            assert abs(mpmath.mpf(ball.mid().str(50, radius=False)) - exact) <= mpmath.mpf("1e-35")
            assert abs(mpmath.mpf(float(getattr(law, VERBS[order])(x))) - exact) <= 1e-13 * scale[order]


@settings(max_examples=times(60, deep=1000))
@given(SHARES, st.sampled_from([1e-3, 1e-8, 1e-60]))
@mpmath.workdps(200)
def test_the_start_of_a_stroke_keeps_its_digits(shares, x):
    law = SCCALaw("own", shares)
    for order, exact in enumerate(own.law_at(law, mpmath.mpf(x))[:3]):
        found = mpmath.mpf(float(getattr(law, VERBS[order])(x)))
        assert abs(found - exact) <= mpmath.mpf(2e-15) * abs(exact) + mpmath.mpf("1e-290"), VERBS[order]

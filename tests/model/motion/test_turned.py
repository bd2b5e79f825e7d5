"""Laws made of others: skewed and mirrored, from every law that can be, against 50 digits and their definitions."""

from itertools import pairwise

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

from camopt.model.motion.derived_laws import MirroredLaw, SkewedLaw
from camopt.model.motion.law import is_symmetric, vdi_motion_task
from camopt.model.motion.programme import Programme, Stroke, law_peaks, weighted_derivative_range
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.stroke import RISE

VERBS = ("displacement", "velocity", "acceleration", "jerk")
SYMMETRIC = [name for name, law in own.EVERY.items() if is_symmetric(law)]
LOPSIDED = [name for name in own.EVERY if name not in SYMMETRIC]
CROSSINGS = st.floats(0.01, 0.99)


def test_some_laws_are_symmetric_and_some_are_not():
    assert {"harmonic", "modified-sine", "own-scca"} <= set(SYMMETRIC)
    assert {"double-harmonic", "half-cycloidal-1", "own-spline", "own-skewed"} <= set(LOPSIDED)


@mpmath.workdps(50)
@precisely()
def is_that_of_fifty_digits(law, expected):
    """Its verbs and its exact pieces, which join, at a few points of each."""
    pieces = pieces_of(law)
    assert (pieces[0].start, pieces[-1].end) == (0, 1)
    assert abs(pieces[-1].derivative(0, pieces[-1].end) - 1) < arb("1e-50")
    for left, right in pairwise(pieces):
        assert left.end.overlaps(right.start)
        for order in (0, 1):
            assert left.derivative(order, left.end).overlaps(right.derivative(order, right.start))
    scale = [np.abs(getattr(law, verb)(np.linspace(0.0, 1.0, 2001))).max() for verb in VERBS]
    for piece in pieces:
        for share in (0.03, 0.5, 0.9):
            x = float(piece.start + (piece.end - piece.start) * share)
            for order, exact in enumerate(expected(mpmath.mpf(x))[:4]):
                ball = piece.derivative(order, arb(x))
                assert abs(mpmath.mpf(ball.mid().str(50, radius=False)) - exact) <= mpmath.mpf("1e-35")
                assert abs(mpmath.mpf(float(getattr(law, VERBS[order])(x))) - exact) <= 1e-13 * scale[order]


@pytest.mark.parametrize("name", SYMMETRIC)
@settings(max_examples=times(4, deep=40))
@given(crossing=CROSSINGS)
def test_a_skewed_law_against_fifty_digits_and_exactly(name, crossing):
    skewed = SkewedLaw("own", own.EVERY[name], crossing)
    is_that_of_fifty_digits(skewed, lambda x: own.law_at(skewed, x))


@pytest.mark.parametrize("name", SYMMETRIC)
@settings(max_examples=times(4, deep=40))
@given(crossing=CROSSINGS)
def test_a_skewed_law_is_as_fast_at_its_crossing_and_has_peaks_in_ratio(name, crossing):
    law = own.EVERY[name]
    skewed = SkewedLaw("own", law, crossing)
    assert float(skewed.displacement(crossing)) == pytest.approx(crossing, rel=1e-14)
    assert float(skewed.velocity(crossing)) == pytest.approx(float(law.velocity(0.5)), rel=1e-13)
    assert vdi_motion_task(skewed) == vdi_motion_task(law)
    rise = Programme((Stroke(RISE, skewed, 0.0, 1.0, 0.0, 1.0),))
    least, largest = weighted_derivative_range(rise, (0.0, 0.0, 1.0), RISE)
    assert rise.lift == 1.0
    assert largest * crossing == pytest.approx(-least * (1.0 - crossing), rel=1e-11)


@pytest.mark.parametrize("name", SYMMETRIC)
def test_a_crossing_in_the_middle_changes_nothing(name):
    law, x = own.EVERY[name], np.linspace(0.0, 1.0, 1001)
    for verb in VERBS:
        expected = getattr(law, verb)(x)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(
            getattr(SkewedLaw("own", law, 0.5), verb)(x), expected, rtol=0, atol=1e-15 * scale
        )


@pytest.mark.parametrize("name", LOPSIDED)
def test_a_mirrored_law_against_fifty_digits_and_exactly(name):
    law = own.EVERY[name]

    def mirrored_values(x):
        s, v, a, j = own.law_at(law, 1 - x)[:4]
        return 1 - s, v, -a, j

    is_that_of_fifty_digits(MirroredLaw("own", law), mirrored_values)
    assert vdi_motion_task(MirroredLaw("own", law)) == "-".join(reversed(vdi_motion_task(law).split("-")))


@pytest.mark.parametrize("name", LOPSIDED)
def test_a_mirrored_law_has_the_same_peaks(name):
    found, expected = law_peaks(MirroredLaw("own", own.EVERY[name])), law_peaks(own.EVERY[name])
    assert found.pop("jumps") == expected.pop("jumps")
    assert found == pytest.approx(expected, rel=1e-12)


SHARES = st.tuples(*[st.one_of(st.just(0.0), st.floats(1e-3, 1.0))] * 4).filter(
    lambda shares: sum(shares[:3]) > 0.0
)


@settings(max_examples=times(20, deep=1000))
@given(SHARES, CROSSINGS)
def test_panels_hold_waves_of_any_length(shares, crossing):
    """As many panels as the jerk needs: they are as near to the law as their table of errors says."""
    law = SkewedLaw("own", SCCALaw("own", shares), crossing)
    programme = Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),))
    table = programme.table
    for u in (-0.95, -0.3, 0.2, 0.9):
        expected = programme.motion_at(table.centre + u * table.half_width)
        for order in range(4):
            series = np.polynomial.polynomial.polyder(table.coefficients.T, order) / table.half_width**order
            found = np.polynomial.polynomial.polyval(u, series)
            assert np.all(np.abs(found - expected[order]) <= 2.0 * table.error[: found.size, order]), order

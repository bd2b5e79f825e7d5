"""Pitch curves by sums of a radius of the roller and one of the cam, beside fractions."""

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from camopt.core.numerics.stable_functions import exact_sum
from camopt.solve.front import curve_numbers

STEPS = np.arange(12.0)


@pytest.mark.parametrize(
    ("sizes", "rollers", "keys"),
    [
        (50.0 + STEPS / 15.0, 5.0 + STEPS / 60.0, 1),
        (50.0 + STEPS / 2.0, 5.0 + STEPS / 4.0, 1),
        (50.0 + STEPS / 15.0, 1e-9 + STEPS / 7e6, 2),
        (0.0 * STEPS, 0.1 * STEPS, 1),
    ],
    ids=["tenths", "halves", "fine", "zero"],
)
def test_curves_are_numbered_as_fractions_are(sizes, rollers, keys):
    sums, rests = (each.ravel() for each in exact_sum(sizes, rollers[:, None]))
    assert len(curve_numbers._exact_sum_sort_keys(sums, rests)) == keys
    first, which = curve_numbers._group_equal_curves(
        SimpleNamespace(size=sums, roller_radius=rests), "roller_radius"
    )
    exact = [Fraction(size) + Fraction(roller) for roller in rollers.tolist() for size in sizes.tolist()]
    distinct = sorted(set(exact))
    assert which.tolist() == [distinct.index(each) for each in exact]
    assert first.tolist() == [exact.index(each) for each in distinct]

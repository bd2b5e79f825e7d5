"""Sums of a radius of the roller and one of the cam in order, beside fractions."""

from fractions import Fraction

import numpy as np
import pytest

from camopt.front import curve_numbers
from camopt.numerics.stable import exact_sum

STEPS = np.arange(12.0)


@pytest.mark.parametrize(
    ("sizes", "rollers", "sorted_by_rests"),
    [
        (50.0 + STEPS / 15.0, 5.0 + STEPS / 60.0, False),
        (50.0 + STEPS / 2.0, 5.0 + STEPS / 4.0, False),
        (50.0 + STEPS / 15.0, 1e-9 + STEPS / 7e6, True),
        (0.0 * STEPS, 0.1 * STEPS, False),
    ],
    ids=["tenths", "halves", "fine", "zero"],
)
def test_sums_are_in_the_order_of_fractions(sizes, rollers, sorted_by_rests, monkeypatch):
    sums, rests = (each.ravel() for each in exact_sum(sizes, rollers[:, None]))
    asked = []
    lexsort = np.lexsort
    monkeypatch.setattr(np, "lexsort", lambda keys: asked.append(keys) or lexsort(keys))
    order = curve_numbers._order(sums, rests)
    exact = [Fraction(size) + Fraction(roller) for roller in rollers.tolist() for size in sizes.tolist()]
    assert order.tolist() == sorted(range(len(exact)), key=exact.__getitem__)
    assert bool(asked) == sorted_by_rests

"""Jets of arrays, as formulas that are not compiled have them."""

from itertools import product
from operator import add, mul, sub, truediv

import numpy as np
import pytest

from camopt.core.numerics.jet import JET_FIELDS, JET_RULES, Jet, larger, smaller

SPECIAL = (0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan)
A, B = (np.tile(each, 5) for each in np.array([*product(SPECIAL, SPECIAL)]).T)  # more than fill vector registers
ONE, OTHER = (Jet(*np.random.default_rng(k).uniform(0.5, 2.0, (6, 9))) for k in range(2))


def bits(values):
    """Those of numbers; any NaN is as good as another."""
    return np.where(np.isnan(values), np.nan, values).view(np.int64).tolist()


def test_the_larger_and_the_smaller_of_arrays_are_those_of_each_pair():
    assert bits(larger(A, B)) == bits(np.array([b if b > a else a for a, b in zip(A, B, strict=True)]))
    assert bits(smaller(A, B)) == bits(np.array([b if b < a else a for a, b in zip(A, B, strict=True)]))


@pytest.mark.parametrize("operation", [add, sub, mul, truediv])
def test_an_operation_is_done_once_and_when_it_is_read(operation, monkeypatch):
    calls = []
    rule = JET_RULES[operation][(True, True)]
    monkeypatch.setitem(JET_RULES[operation], (True, True), lambda a, b: calls.append(1) or rule(a, b))
    found = operation(ONE, OTHER)
    assert not calls
    expected = rule(ONE, OTHER)
    for field in JET_FIELDS:
        assert bits(getattr(found, field)) == bits(getattr(expected, field))
    assert (calls, hasattr(found, "shape")) == ([1], False)

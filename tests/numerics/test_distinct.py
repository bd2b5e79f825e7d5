"""Distinct numbers are those of ``numpy.unique``."""

import numpy as np
import pytest

from camopt.numerics.distinct import distinct

DRAWN = np.random.default_rng(1)


@pytest.mark.parametrize(
    "values",
    [
        [],
        [0.0],
        [2, 1, 2, 2],
        [np.inf, -np.inf, 0.0, -0.0, np.inf],
        DRAWN.integers(0, 50, (7, 30)),
        DRAWN.choice(DRAWN.normal(size=20), 200),
    ],
    ids=str,
)
def test_distinct_numbers_are_those_of_numpy(values):
    found = distinct(np.array(values))
    assert found.dtype == np.unique(values).dtype
    assert np.array_equal(found, np.unique(values))

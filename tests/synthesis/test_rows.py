"""Limits stacked in one matrix: against the same sums term by term, and against a product's own inequality."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from camopt.synthesis.rows import ConvexRows, negated, stacked

NUMBERS = st.floats(-9.0, 9.0)
SIZES = {"x": 3, "y": 2}


def valued():
    """Two vectors and a number as variables, each with values."""
    found = {name: cp.Variable(size) for name, size in SIZES.items()} | {"z": cp.Variable()}
    for k, variable in enumerate(found.values()):
        variable.value = np.cos(np.arange(variable.size) + k) if variable.ndim else 0.7
    return found


@st.composite
def sums(draw):
    """The terms of a few sums, and how many rows each sum has."""
    found = []
    for _ in range(draw(st.integers(1, 4))):
        count, terms = draw(st.integers(1, 3)), []
        for name in draw(st.lists(st.sampled_from([*SIZES, "z", "1"]), min_size=1, max_size=5)):
            size = SIZES.get(name)
            few = st.lists(NUMBERS, min_size=count * (size or 1), max_size=count * (size or 1))
            weights = np.array(draw(few)).reshape((count, size) if size else count)
            terms.append((weights, name))
        found.append(terms)
    return found


@given(sums(), st.booleans())
def test_one_matrix_is_the_same_as_its_sums(found, dense):
    variables = valued()
    values = {**{name: each.value for name, each in variables.items()}, "1": 1.0}
    terms = [
        [(w if w.ndim == 1 or dense else sparse.csr_array(w), {**variables, "1": 1.0}[name]) for w, name in each]
        for each in found
    ]
    expected = [sum(w @ values[name] if w.ndim == 2 else w * values[name] for w, name in each) for each in found]
    assert stacked(terms).value == pytest.approx(np.concatenate(expected), rel=1e-13, abs=1e-12)
    opposite = [negated(each) for each in terms]
    assert stacked(opposite).value == pytest.approx(-np.concatenate(expected), rel=1e-13, abs=1e-12)


@given(st.floats(0.1, 9.0) | st.floats(-9.0, -0.1), st.floats(0.0, 9.0), st.floats(0.0, 9.0))
def test_a_product_is_held_at_a_square(root, one, other):
    x = cp.Variable(3, value=[root, one, other])
    each, rows = np.eye(3), ConvexRows()
    rows.product([(each[1:2], x)], [(each[2:], x)], [(each[:1], x)])
    (limit,) = rows.limits
    missing = root**2 - one * other
    if abs(missing) > 1e-9:
        assert (float(np.max(limit.violation())) > 0.0) == (missing > 0.0)


def test_a_programme_of_all_kinds_has_one_limit_of_each_and_its_optimum():
    """Least x₀ + x₁ with x₀·x₁ ≥ (2·z)², z = 3 and x₀ ≥ 9: 9 + 4."""
    x, z, own, others = cp.Variable(2), cp.Variable(), ConvexRows(), ConvexRows()
    first, last = np.eye(2)[:1], np.eye(2)[1:]
    own.at_least((first, x), (-9.0, 1.0))
    others.zero((1.0, z), (-3.0, 1.0))
    others.product([(first, x)], [(last, x)], [(2.0, z)])
    own.add(others)
    assert len(own.limits) == 3
    problem = cp.Problem(cp.Minimize(cp.sum(x)), own.limits)
    assert problem.solve(solver=cp.CLARABEL) == pytest.approx(13.0, rel=1e-7)
    assert x.value == pytest.approx([9.0, 4.0], rel=1e-6)

"""Conic programmes: rows against the same sums term by term, and optima and multipliers against cvxpy's."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from camopt.synthesis.conic import NO_SOLUTION, SOLVED, ConicProgramme
from camopt.synthesis.functions import LargestNorm, Linear, Magnitudes, Norm
from camopt.synthesis.rows import ConvexRows, Parameter, Unknown, negated, stacked, times, value_of

NUMBERS = st.floats(-9.0, 9.0)
SIZES = {"x": 3, "y": 2}


def valued():
    """Two vectors and a number as unknowns, each with values."""
    found = {name: Unknown(size) for name, size in SIZES.items()} | {"z": Unknown()}
    for k, unknown in enumerate(found.values()):
        unknown.value = np.cos(np.arange(unknown.count) + k) if unknown.is_vector else 0.7
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
    assert value_of(stacked(terms).terms) == pytest.approx(np.concatenate(expected), rel=1e-13, abs=1e-12)
    for each, value in zip(terms, expected, strict=True):
        factors = np.arange(1.0, 1.0 + np.size(value))
        assert value_of(times(factors, each)) == pytest.approx(factors * value, rel=1e-13, abs=1e-12)


@given(st.floats(0.1, 9.0) | st.floats(-9.0, -0.1), st.floats(0.0, 9.0), st.floats(0.0, 9.0))
def test_a_product_is_held_at_a_square(root, one, other):
    x, each, rows = Unknown(3), np.eye(3), ConvexRows()
    x.value = np.array([root, one, other])
    rows.product([(each[1:2], x)], [(each[2:], x)], [(each[:1], x)])
    missing = root**2 - one * other
    if abs(missing) > 1e-9:
        assert (rows.broken_by > 0.0) == (missing > 0.0)


def test_a_programme_of_all_kinds_and_its_optimum():
    """Least x₀ + x₁ with x₀·x₁ ≥ (2·z)², z = 3 and x₀ ≥ 9: 9 + 4."""
    x, z, own, others = Unknown(2), Unknown(), ConvexRows(), ConvexRows()
    first, last = np.eye(2)[:1], np.eye(2)[1:]
    own.at_least((first, x), (-9.0, 1.0))
    others.zero((1.0, z), (-3.0, 1.0))
    others.product([(first, x)], [(last, x)], [(2.0, z)])
    own.add(others)
    assert [kind is not None for kind in own.kinds] == [True] * 3
    programme = ConicProgramme([(np.ones((1, 2)), x)], own)
    assert programme.solve() == SOLVED
    assert programme.value == pytest.approx(13.0, rel=1e-7)
    assert x.value == pytest.approx([9.0, 4.0], rel=1e-6)
    assert own.broken_by < 1e-6


@given(st.integers(0, 10**6), st.booleans())
def test_optimum_and_multipliers_are_those_of_cvxpy(seed, squared):
    """Random programmes with rows of each kind, cones of other sizes, and a parameter among the unknowns."""
    rng = np.random.default_rng(seed)
    x, z, given_ = Unknown(4), Unknown(), Parameter(2)
    given_.value = rng.normal(size=2)
    equal, least, side, root = (rng.normal(size=(count, 4)) for count in (1, 3, 2, 3))
    by, inside = rng.normal(size=(3, 2)), rng.normal(size=4)
    room = least @ inside + by @ given_.value
    rows, more = ConvexRows(), ConvexRows()
    rows.zero((equal, x), (-equal @ inside, 1.0))
    rows.at_least((-least, x), (-by, given_), (room + 1.0, 1.0))
    more.cone([(1.0, z)], [[(side, x)], [(root, x), (np.ones(3), 1.0)]])
    more.at_least((-1.0, z), (50.0, 1.0))
    goal = rng.normal(size=(1, 4))
    squares = [[(np.eye(4), x), (-inside, 1.0)]] if squared else []
    programme = ConicProgramme([(goal, x), (3.0, z), (0.25, 1.0)], rows, more, squares=squares)
    y, t = cp.Variable(4), cp.Variable()
    limits = [
        equal @ y == equal @ inside,
        least @ y <= room + 1.0 - by @ given_.value,
        cp.norm(cp.hstack([side @ y, root @ y + 1.0])) <= t,
        t <= 50.0,
    ]
    cost = goal[0] @ y + 3.0 * t + 0.25 + (cp.sum_squares(y - inside) if squared else 0.0)
    own = cp.Problem(cp.Minimize(cost), limits)
    own.solve(solver=cp.CLARABEL)
    status = programme.solve()
    assert (status == SOLVED) == (own.status == cp.OPTIMAL)
    if status != SOLVED:
        return
    assert programme.value == pytest.approx(own.value, rel=1e-6, abs=1e-6)
    assert x.value == pytest.approx(y.value, rel=1e-3, abs=1e-3)
    # a limit that is wider by δ: the rows gain δ, and the least objective what the multipliers say
    step = 1e-3
    known = rows.multipliers.copy()
    wider = ConvexRows()
    wider.zero((equal, x), (-equal @ inside + step, 1.0))
    wider.at_least((-least, x), (-by, given_), (room + 1.0 + 2.0 * step, 1.0))
    before, after = (
        programme.value,
        ConicProgramme([(goal, x), (3.0, z), (0.25, 1.0)], wider, more, squares=squares),
    )
    if after.solve() == SOLVED:
        assert after.value - before == pytest.approx(step * (known[0] + 2.0 * known[1:].sum()), rel=0.05, abs=2e-5)


def test_what_no_values_hold_is_said():
    x, rows = Unknown(), ConvexRows()
    rows.at_least((1.0, x), (-2.0, 1.0))
    rows.at_least((-1.0, x), (1.0, 1.0))
    programme = ConicProgramme([(1.0, x)], rows)
    assert programme.solve() in NO_SOLUTION
    assert x.value is None


SIDES = [[(np.array([[1.0, 2.0], [0.0, -1.0]]), "x"), (np.array([1.0, -4.0]), 1.0)], [(3.0, "z"), (-1.0, 1.0)]]


@pytest.mark.parametrize("kind", ["linear", "norm", "largest", "magnitudes"])
def test_functions_are_held_below_bounds_and_minimised(kind):
    """Value, multiple and least value under limits, against cvxpy's."""
    x, z = Unknown(2), Unknown()
    sums = [[(w, {"x": x, "z": z}.get(u, u)) for w, u in each] for each in SIDES]
    y, t = cp.Variable(2), cp.Variable()
    rows_ = [np.array([[1.0, 2.0], [0.0, -1.0]]) @ y + np.array([1.0, -4.0]), 3.0 * t - 1.0]
    function, theirs = {
        "linear": (Linear([*sums[1], (-1.0, 1.0)]), rows_[1] - 1.0),
        "norm": (Norm(sums), cp.norm(cp.hstack(rows_))),
        "largest": (LargestNorm([Norm([each]) for each in sums]), cp.maximum(cp.norm(rows_[0]), cp.abs(rows_[1]))),
        "magnitudes": (Magnitudes(sums), cp.norm1(cp.hstack(rows_))),
    }[kind]
    x.value, z.value, y.value, t.value = np.array([0.3, -2.0]), 1.7, np.array([0.3, -2.0]), 1.7
    assert function.value == pytest.approx(float(theirs.value), rel=1e-14)
    assert function.times(2.5).value == pytest.approx(2.5 * float(theirs.value), rel=1e-14)
    top, rows = Unknown(), ConvexRows()
    function.times(2.0).below([(1.0, top)], rows)
    for sign in (1.0, -1.0):
        rows.at_least((sign * np.eye(2), x), (0.5, 1.0))
        rows.at_least((sign, z), (0.5, 1.0))
    programme = ConicProgramme([(1.0, top)], rows)
    assert programme.solve() == SOLVED
    least = cp.Problem(cp.Minimize(2.0 * theirs), [cp.abs(y) <= 0.5, cp.abs(t) <= 0.5]).solve(solver=cp.CLARABEL)
    assert programme.value == pytest.approx(float(least), rel=1e-6, abs=1e-7)
    assert 2.0 * function.value == pytest.approx(programme.value, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("function", [Norm([]), Magnitudes([])])
def test_a_function_of_nothing_is_0(function):
    top, rows = Unknown(), ConvexRows()
    function.below([(1.0, top)], rows)
    programme = ConicProgramme([(1.0, top)], rows)
    assert programme.solve() == SOLVED
    assert (function.value, programme.value) == (0.0, pytest.approx(0.0, abs=1e-7))

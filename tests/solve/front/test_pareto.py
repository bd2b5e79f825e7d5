"""Pareto fronts against their definitions: dominance, hypervolume, knee, thinning."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from camopt.scene.problem.rows import DesignRows
from camopt.scene.search import Search
from camopt.solve.front import pareto
from camopt.solve.front.pareto import (
    REFERENCE_POINT,
    FrontArchive,
    cost_scale,
    hypervolume_and_exactness,
    knee_index,
    non_dominated,
    summarise_front,
    thin_front,
)

NAMES = ("base_radius_mm", "acceleration_max_m_s2", "pressure_angle_max_deg", "profile_radius_min_mm")
TIED = st.sampled_from([0.0, 1.0, 2.0, 2.5, np.inf, -np.inf])
ANY = st.floats(allow_nan=False, min_value=-1e9, max_value=1e9) | st.just(np.inf)


@st.composite
def fronts(draw, values=TIED, most=25):
    """Rows with one to four objectives, some maximised, and the same as costs."""
    many = draw(st.integers(1, 4))
    table = np.array(draw(st.lists(st.lists(values, min_size=many, max_size=many), min_size=1, max_size=most)))
    least = draw(st.integers(0, many))
    objectives = Search(minimise=NAMES[:least], maximise=NAMES[least:many]).objectives
    rows = DesignRows({**dict(zip(NAMES, table.T, strict=False)), "number": np.arange(len(table))}, len(table))
    return rows, objectives, table * np.where(np.arange(many) < least, 1.0, -1.0)


def by_definition(costs):
    """The numbers of the rows that none betters, by a double loop."""
    kept = []
    for i, mine in enumerate(costs):
        for other in costs:
            if all(b <= a for a, b in zip(mine, other, strict=True)) and any(
                b < a for a, b in zip(mine, other, strict=True)
            ):
                break
        else:
            kept.append(i)
    return kept


@given(fronts() | fronts(ANY))
def test_non_dominated_rows_are_those_of_the_definition(front):
    rows, objectives, costs = front
    assert non_dominated(rows, objectives).column("number").tolist() == by_definition(costs)


@given(fronts(), st.integers(1, 7), st.integers(0, 9))
def test_blocks_give_the_same_front(front, size, least):
    rows, objectives, costs = front
    archive = FrontArchive(objectives, least)
    for first in range(0, rows.count, size):
        archive.add(rows.take(np.arange(first, min(first + size, rows.count))))
    assert archive.front().column("number").tolist() == by_definition(costs)


def test_the_worth_of_an_infinite_objective():
    rows = DesignRows({NAMES[0]: np.array([1.0, 1.0, 2.0]), NAMES[1]: np.array([np.inf, 5.0, np.inf])}, 3)
    worst = Search(minimise=NAMES[:2]).objectives
    assert non_dominated(rows, worst).count == 1
    best = Search(minimise=NAMES[:1], maximise=NAMES[1:2]).objectives
    assert non_dominated(rows, best).column(NAMES[1]).tolist() == [np.inf]


def by_inclusion_and_exclusion(points):
    """The share of the box that points dominate, as the signed sum of what each set of them dominates at once."""
    total = 0.0
    for count in range(1, len(points) + 1):
        for chosen in combinations(points, count):
            total -= (-1) ** count * np.prod(np.maximum(REFERENCE_POINT - np.max(chosen, axis=0), 0.0))
    return total / REFERENCE_POINT ** len(points[0])


SHARES = st.floats(0, 1.5) | st.sampled_from([0.0, 0.5, 1.0, np.inf])


@given(
    st.integers(1, 4).flatmap(lambda m: st.lists(st.lists(SHARES, min_size=m, max_size=m), min_size=1, max_size=7))
)
def test_hypervolume_is_that_of_inclusion_and_exclusion(points):
    found, exact = hypervolume_and_exactness(np.array(points))
    assert exact
    assert found == pytest.approx(by_inclusion_and_exclusion(points), abs=1e-12)


def test_hypervolume_of_a_line():
    """Points at i/n on the line x + y = 1 dominate the box less n steps."""
    n = 200
    x = np.arange(n + 1) / n
    steps = REFERENCE_POINT**2 - 0.5 - 0.5 / n  # the triangle under the line, and half a square for each step
    assert hypervolume_and_exactness(np.column_stack([x, 1 - x]))[0] == pytest.approx(
        steps / REFERENCE_POINT**2, rel=1e-12
    )


@pytest.mark.slow
def test_an_approximate_hypervolume_says_so(monkeypatch):
    points = np.abs(np.random.default_rng(0).normal(size=(300, 4)))
    points = 1.0 - points / np.linalg.norm(points, axis=1)[:, None]
    exact, _ = hypervolume_and_exactness(points)
    monkeypatch.setattr(pareto, "EXACT_WORK", 1.0)
    about, known = hypervolume_and_exactness(points)
    assert not known
    assert about == pytest.approx(exact, rel=1e-3)
    assert about != exact


@given(fronts() | fronts(ANY, 60), st.floats(1e-9, 0.999))
def test_every_row_of_a_front_has_one_within_epsilon_among_the_thinned(front, epsilon):
    rows, objectives, _ = front
    whole = non_dominated(rows, objectives)
    costs = pareto.row_costs(whole, objectives)
    normalised = cost_scale(costs).normalise_costs(costs)
    kept = thin_front(whole, objectives, epsilon).column("number").tolist()
    assert kept == sorted(set(kept))
    number = whole.column("number").tolist()
    few = normalised[[number.index(k) for k in kept]]
    for row in normalised:
        assert np.any(np.all(few <= row + epsilon * (1 + 1e-6), axis=1))
    assert few.min(axis=0).tolist() == normalised.min(axis=0).tolist()
    assert number[knee_index(normalised)] in kept


def test_thinning_makes_a_front_of_many_rows_short():
    x = np.linspace(0, 1, 100_001)
    rows = DesignRows({NAMES[0]: 40 + 7 * x, NAMES[1]: 3e3 * (1 - x)}, x.size)
    assert 50 <= thin_front(rows, Search(minimise=NAMES[:2]).objectives, 0.01).count <= 103


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(0, 1e-3)), min_size=2, max_size=30, unique=True))
def test_the_knee_of_two_objectives_is_furthest_below_the_chord(points):
    objectives = Search(minimise=NAMES[:2]).objectives
    table = np.array(points)
    rows = non_dominated(DesignRows(dict(zip(NAMES, table.T, strict=False)), len(table)), objectives)
    costs = pareto.row_costs(rows, objectives)
    scale = cost_scale(costs)
    assume(np.all(scale.nadir - scale.ideal >= 1e-9 * np.array([100, 1e-3])))
    x, y = ((costs - scale.ideal) / (scale.nadir - scale.ideal)).T
    below = (1.0 - x - y) / np.sqrt(2.0)  # distance from the chord from (0, 1) to (1, 0)
    assert below[knee_index(scale.normalise_costs(costs))] == pytest.approx(below.max(), abs=1e-9)


def test_a_front_is_described_in_its_own_units():
    columns = {"base_radius_mm": np.array([30.0, 40.0, 80.0]), "profile_radius_min_mm": np.array([5.0, 40.0, 50.0])}
    objectives = Search(minimise=["base_radius_mm"], maximise=["profile_radius_min_mm"]).objectives
    front = summarise_front(DesignRows(columns, 3), objectives)
    assert front.ideal == {"base_radius_mm": 30.0, "profile_radius_min_mm": 50.0}
    assert front.nadir == {"base_radius_mm": 80.0, "profile_radius_min_mm": 5.0}
    assert front.knee == {"base_radius_mm": 40.0, "profile_radius_min_mm": 40.0}
    assert summarise_front(DesignRows({n: v[:0] for n, v in columns.items()}, 0), objectives) is None


def test_an_objective_that_is_infinite_throughout_says_nothing():
    rows = DesignRows({NAMES[0]: np.array([1.0, 2.0, 3.0]), NAMES[1]: np.array([3.0, 1.5, 1.0])}, 3)
    jerky = DesignRows({**rows.columns, NAMES[2]: np.full(3, np.inf)}, 3)
    plain, other = (
        summarise_front(rows, Search(minimise=NAMES[:2]).objectives),
        summarise_front(jerky, Search(minimise=NAMES[:3]).objectives),
    )
    assert other.hypervolume == plain.hypervolume
    assert other.to_dict()["knee"][NAMES[2]] is None

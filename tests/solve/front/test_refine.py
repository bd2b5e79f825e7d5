"""Refined fronts: the same from any grid, proved feasible, no worse than the grid's, and at local optima."""

import shutil
from itertools import islice

import numpy as np
import pytest
from support.depth import times

from camopt import find_scene, load, optimise, sweep
from camopt.core.storage.manifest import MANIFEST
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.space import grid_space
from camopt.solve.front import pattern_search, refine
from camopt.solve.front.pareto import row_costs
from camopt.solve.front.pattern_search import PatternSearch, move_to_closed_form_optima, search_by_pattern
from camopt.solve.front.table_certificate import certify_table
from camopt.solve.smallest.smallest import solve_smallest_cam

LEVELS = 12
PLAIN = {
    "search.base_radius": {"start": 30, "stop": 120, "step": 3},
    "search.offset": {"start": -10, "stop": 20, "step": 5},
    "search.roller_radius": [5, 20],
    "search.law": ["harmonic", "cycloidal", "parabolic"],
    "search.refine": True,
}
SIZED = ["base_radius_mm", "pressure_angle_max_deg"]
ROLLER = find_scene("roller-1000rpm").replace(**PLAIN)
SCENES = {
    "closed form": ROLLER,
    "curvature": ROLLER.replace(
        **{"search.roller_radius": {"start": 5, "stop": 20, "step": 5}, "limits.curvature_radius": 25}
    ),
    "maximised": ROLLER.replace(
        **{"search.minimise": ["base_radius_mm"], "search.maximise": ["profile_radius_min_mm"]}
    ),
    "size is no objective": ROLLER.replace(
        **{"search.minimise": ["pressure_angle_max_deg"], "search.maximise": ["profile_radius_min_mm"]}
    ),
    "oscillating": find_scene("oscillating-roller").replace(
        **{
            "limits.pressure_angle": 30,
            "search": {
                "base_radius": {"start": 20, "stop": 80, "step": 3},
                "centre_distance": {"start": 120, "stop": 160, "step": 5},
                "minimise": SIZED,
                "refine": True,
            },
        }
    ),
    "flat": find_scene("flat-reciprocating").replace(
        search={
            "base_radius": {"start": 20, "stop": 80, "step": 3},
            "minimise": ["base_radius_mm"],
            "maximise": ["profile_radius_min_mm"],
            "refine": True,
        }
    ),
}


@pytest.fixture(scope="module", autouse=True)
def _few_levels():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(refine, "CURVE_LEVELS", LEVELS)
        patch.setattr(pattern_search, "SHORTEST_STEP", 1e-9)  # the value at an optimum goes with its square
        yield


LONG = {"oscillating": pytest.mark.long}
"""Two sizes are sought where no closed form helps: half the time of all. ``maximised`` asks the same search."""


def marked_names(names):
    return [pytest.param(name, marks=LONG.get(name, ())) for name in names]


@pytest.fixture(scope="module", params=marked_names(SCENES))
def swept(request, tmp_path_factory):
    """The outcome and the refined and the grid's front of a scene, as rows; the outcome names their files."""
    folder = tmp_path_factory.mktemp("refined")
    result = sweep(SCENES[request.param], folder)
    return result, *(rows_of(load(folder / f"{t}.parquet")) for t in ("pareto", "pareto-grid"))


def for_scenes(*names):
    """The scenes that a test takes, if not all."""
    return pytest.mark.parametrize("swept", marked_names(names), indirect=True)


def rows_of(table):
    return DesignRows({name: table[name].to_numpy() for name in table}, len(table))


def costs_of(rows, result):
    return row_costs(rows, result.scene.search.objectives)


def test_the_smallest_cams_share_the_work_of_a_search(monkeypatch):
    """Two laws: the first gets half of it, the second what is left."""
    asked = []

    def record_budget(problem, bounds, budget):
        asked.append(budget.end - budget.meter.read())
        return solve_smallest_cam(problem, bounds, budget)

    monkeypatch.setattr(refine, "solve_smallest_cam", record_budget)
    laws = {"search.law": ["harmonic", "cycloidal"], "search.roller_radius": None}
    sweep(ROLLER.replace(**laws))
    first, second = (left / refine.OPTIMISE_WORK for left in asked)
    assert 0.4 < first <= 0.5
    assert 0.5 < second <= 1.0


@pytest.mark.one_in(5)
def test_a_refined_front_is_no_worse_than_the_grid(swept):
    result, rows, grid = swept
    fine, coarse = costs_of(rows, result), costs_of(grid, result)
    assert grid.count > 1
    assert rows.column("refined").all()
    for row in coarse:
        assert np.any(np.all(fine <= row + 1e-8 * np.abs(row), axis=1))
    assert result.front.hypervolume > result.front.grid_hypervolume
    assert result.front.grid_points == grid.count
    assert result.pareto == rows.count == result.front.points


@pytest.mark.slow
@pytest.mark.one_in(4)
def test_no_allowed_design_nearby_lowers_the_objective(swept):
    """Ten thousand designs about each of a few rows, at distances from 1e-4 to a tenth of each range."""
    result, rows, _ = swept
    problem = with_rounding_relative_error(resolve(result.scene))
    free, random = refine.free_ranges(problem), np.random.default_rng(0)
    objective = "base_radius_mm" if "base_radius_mm" in result.scene.search.minimise else "pressure_angle_max_deg"
    few = rows.take(np.linspace(0, rows.count - 1, 7).astype(int))
    for each, _, designs in grid_space(problem).designs_of_rows(few):
        pattern = PatternSearch(each, free, objective)
        ceilings, held = pattern.worst_costs_and_feasibility(designs)
        assert held.all()
        for i in range(len(designs)):
            many = designs.take(np.full(10_000, i))
            for field, (low, high) in free.items():
                reach = 10.0 ** random.uniform(-4, -1, 10_000) * random.uniform(-1, 1, 10_000)
                getattr(many, field)[:] = np.clip(getattr(many, field) + reach * (high - low), low, high)
            costs, held = pattern.worst_costs_and_feasibility(many)
            allowed = held & np.all(costs <= ceilings[i], axis=1)
            column = pattern.objective_index(objective)
            assert costs[allowed, column].min(initial=np.inf) > ceilings[i, column] * (1 - 1e-6)


@for_scenes("closed form", "curvature", "oscillating")
def test_the_end_of_the_front_is_the_proved_optimum(swept):
    result, rows, _ = swept
    best = optimise(result.scene).best
    assert best["proved"]
    assert rows.column("base_radius_mm").min() == pytest.approx(best["base_radius_mm"], abs=1e-6)


@pytest.mark.slow
@pytest.mark.one_in(2)
@for_scenes("closed form")
@pytest.mark.parametrize(
    "coarser",
    [
        {"search.base_radius": {"start": 30, "stop": 120, "step": 0.5}},
        {"search.base_radius": {"start": 30, "stop": 120, "step": 2}},
        {
            "search.base_radius": {"start": 30, "stop": 120, "step": 7.7},
            "search.offset": {"start": -10, "stop": 20, "step": 3},
        },
    ],
)
def test_a_refined_front_does_not_depend_on_the_step(swept, tmp_path, coarser):
    """The levels of each law are in both fronts, and neither front has a row that the other betters."""
    result, rows, grid = swept
    other = sweep(SCENES["closed form"].replace(**coarser), tmp_path)
    assert other.front.grid_points != grid.count
    assert other.front.ideal == pytest.approx(result.front.ideal, rel=1e-6)
    assert other.front.nadir == pytest.approx(result.front.nadir, rel=1e-6)
    assert other.front.hypervolume == pytest.approx(result.front.hypervolume, abs=0.5 / LEVELS)
    fronts = [costs_of(r, result) for r in (rows, rows_of(load(tmp_path / "pareto.parquet")))]
    for here, there in (fronts, fronts[::-1]):
        apart = [np.abs(there / row - 1.0).max(axis=1).min() for row in here]
        laws = len(set(rows.column("law_rise")))
        assert np.count_nonzero(np.array(apart) < 1e-6) >= laws * (LEVELS - 2)
        below = here * [1 - 1e-6, 1, 1 - 1e-6]  # acceleration is its law's
        assert not any(np.all(there <= row, axis=1).any() for row in below)


@pytest.mark.slow
@for_scenes("closed form", "curvature", "oscillating", "flat")
def test_refined_rows_are_proved_in_balls(swept, tmp_path):
    (file,) = [file for file in swept[0].files if file.name == "pareto.parquet"]
    table = shutil.copy(file, tmp_path)
    assert certify_table(table) == {"held": swept[0].pareto}


def test_few_points_of_a_front_are_asked_for(tmp_path):
    front = sweep(ROLLER.replace(**{"search.thin": 0.2}), tmp_path).front
    assert 4 <= front.points <= 40
    assert load(tmp_path / "pareto.parquet").attrs["front"]["points"] == front.points


@pytest.mark.slow
@for_scenes("closed form")
def test_the_search_finds_what_the_closed_form_proves(swept):
    result, _, grid = swept
    problem = with_rounding_relative_error(resolve(result.scene))
    for each, _, designs in islice(grid_space(problem).designs_of_rows(grid), times(1, deep=3)):
        pattern = PatternSearch(each, refine.free_ranges(problem), "base_radius_mm")
        ceilings, held = pattern.worst_costs_and_feasibility(designs)
        proved, settled = move_to_closed_form_optima(pattern, designs, ceilings)
        found = search_by_pattern(pattern, designs, ceilings)
        assert held.all()
        assert settled.all()
        assert np.all(proved.size <= designs.size)
        assert found.size == pytest.approx(proved.size, abs=1e-6)
        assert found.offset == pytest.approx(proved.offset, abs=1e-6)


@for_scenes("closed form")
def test_the_smallest_cam_of_each_law_is_on_the_front_unless_bettered(swept):
    result, rows, _ = swept
    fine = costs_of(rows, result)
    names = list(result.scene.search.objectives)
    for best in optimise(result.scene).by_law.values():
        row = np.array([best[name] for name in names])
        assert np.any(np.all(fine <= row * (1 + 1e-9), axis=1))


def test_motion_objectives_alone_give_the_optimum_of_each_law(tmp_path):
    scene = ROLLER.replace(**{"search.minimise": ["base_radius_mm", "acceleration_max_m_s2"]})
    sweep(scene, tmp_path)
    found = load(tmp_path / "pareto.parquet").set_index("law_rise").base_radius_mm
    optima = optimise(scene).by_law
    assert set(found.index) == {"harmonic", "parabolic"}
    for law, size in found.items():
        assert size == pytest.approx(optima[law]["base_radius_mm"], rel=1e-12)


def test_without_ranges_there_is_nothing_to_refine(tmp_path):
    lists = {"search.base_radius": None, "search.offset": [0, 5, 10], "cam.base_radius": 60}
    result = sweep(ROLLER.replace(**lists), tmp_path)
    table, grid = load(tmp_path / "pareto.parquet"), load(tmp_path / "pareto-grid.parquet")
    assert not table.refined.any()
    assert table.drop(columns="refined").equals(grid)
    assert result.front.hypervolume == result.front.grid_hypervolume


def test_a_size_that_is_to_grow_goes_to_the_end_of_its_range(tmp_path):
    grown = {"search.minimise": ["pressure_angle_max_deg"], "search.maximise": ["base_radius_mm"]}
    short = {"search.base_radius": {"start": 30, "stop": 120, "step": 70}}
    front = sweep(ROLLER.replace(**grown, **short), tmp_path).front
    assert load(tmp_path / "pareto-grid.parquet").base_radius_mm.max() == 100.0
    assert front.ideal["base_radius_mm"] == pytest.approx(120.0, rel=1e-6)


def test_with_the_size_fixed_another_objective_is_lowered(tmp_path):
    fixed = {"search.base_radius": None, "cam.base_radius": 60, "search.minimise": SIZED}
    sweep(ROLLER.replace(**fixed, **{"search.law": ["harmonic"]}), tmp_path)
    (row,) = load(tmp_path / "pareto.parquet").to_dict("records")
    assert row["base_radius_mm"] == 60.0
    assert row["pressure_angle_max_rise_deg"] == pytest.approx(row["pressure_angle_max_return_deg"], abs=1e-6)


def test_nothing_feasible_leaves_an_empty_front(tmp_path):
    result = sweep(ROLLER.replace(**{"limits.pressure_angle": 3, "limits.pressure_angle_return": 3}), tmp_path)
    assert result.front is None
    assert len(load(tmp_path / "pareto.parquet")) == 0
    assert load(tmp_path / "pareto.parquet").attrs["front"] is None


def test_a_sweep_that_is_not_to_refine_writes_what_it_always_did(tmp_path):
    result = sweep(ROLLER.replace(**{"search.refine": None}), tmp_path)
    assert [file.name for file in result.files] == ["designs.parquet", "pareto.parquet", "scene.toml"]
    names = [".camopt", *(file.name for file in result.files), MANIFEST]
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(names)
    table = load(tmp_path / "pareto.parquet")
    assert "refined" not in table
    assert table.attrs["front"] == result.front.to_dict()


def test_rows_of_three_objectives_stay_spread(tmp_path, monkeypatch):
    """Moved for the size alone they are fewer; and each row of the grid is met in every objective."""
    scene = ROLLER.replace(
        **{
            "search.base_radius": {"start": 60, "stop": 120, "step": 20},
            "search.offset": {"start": -10, "stop": 20, "step": 15},
            "search.roller_radius": [5],
            "search.law": ["cycloidal"],
            "search.minimise": [*SIZED, "pressure_angle_max_return_deg"],
        }
    )
    many = sweep(scene, out=tmp_path / "many", keep="pareto")
    monkeypatch.setattr(refine, "_searches_by_objective", lambda pattern, decided: [pattern])
    assert sweep(scene, out=tmp_path / "few", keep="pareto").pareto < many.pareto
    names = scene.search.minimise
    grid, found = (
        load(tmp_path / "many" / f)[[*names]].to_numpy() for f in ("pareto-grid.parquet", "pareto.parquet")
    )
    for row in grid:
        assert np.any(np.all(found <= row * (1 + 1e-9), axis=1))

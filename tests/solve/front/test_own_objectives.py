"""Own quantities of a scene in searches: sweeps and fronts against pandas, refinement, the smallest cam."""

import numpy as np
import pytest
from support.depth import times
from support.expressions import for_pandas

from camopt import (
    certify,
    evaluate,
    evaluate_designs,
    find_scene,
    load,
    merge,
    optimise,
    scene_of,
    sweep,
    sweep_part,
)
from camopt.core.engines.processes import Processes
from camopt.solve.front import plan

BASE = find_scene("roller-1000rpm").replace(
    **{
        "search": {
            "base_radius": {"start": 41, "stop": 78, "step": 3.7},
            "offset": {"start": -7, "stop": 21, "step": 4},
            "roller_radius": [7, 13.5],
            "law": ["cycloidal", "harmonic"],
        },
        "follower.dynamics": {"mass": 0.7, "spring_rate": 9.3, "preload": 210},
        "limits": {"curvature_radius": 1},
    }
)
READ = (
    *("base_radius_mm", "offset_mm", "roller_radius_mm", "outer_radius_mm", "pressure_angle_max_deg"),
    *("torque_rms_N_m", "profile_radius_min_mm", "acceleration_max_m_s2", "pitch_curvature_min_per_mm"),
)
VALUE = "outer_radius_mm * torque_rms_N_m / cos(radians(pressure_angle_max_deg))"
COMPACT = {"mine": {"value": VALUE, "unit": "mm·N·m"}}
CASES = {
    "one objective": {"search.minimise": ["mine"]},
    "two objectives": {"search.minimise": ["mine", "pressure_angle_max_deg"]},
    "three objectives": {"search.minimise": ["base_radius_mm", "mine", "pressure_angle_max_deg"]},
    "the largest": {"search.minimise": ["base_radius_mm"], "search.maximise": ["mine"]},
    "a limit": {"search.minimise": ["mine", "base_radius_mm"], "limits.mine": 1700},
    "a limit alone": {"search.minimise": ["pressure_angle_max_deg", "base_radius_mm"], "limits.mine": 1700},
    "a sample": {"search.minimise": ["mine", "base_radius_mm"], "search.samples": 77},
}


def random_quantities(first, last):
    """Expressions that have a value somewhere by our name of each, and as pandas has them."""
    found = {}
    for seed in range(first, last):
        ours, theirs = for_pandas(seed, READ, 4)
        try:
            BASE.replace(quantities={"mine": ours})
        except ValueError:  # a part without quantities has no value
            continue
        found[f"q{seed}"] = ours, theirs
    return found


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("first", range(0, times(150, 3000), 100))
def test_random_expressions_are_what_pandas_makes_of_the_same_rows(first, tmp_path):
    both = random_quantities(first, first + 100)
    scene = BASE.replace(quantities={name: ours for name, (ours, _) in both.items()}, outputs=list(READ))
    sweep(scene, out=tmp_path, keep="all", workers=1)
    rows = load(tmp_path / "designs.parquet")
    assert len(both) > 90
    assert len(rows) > 200
    read = rows[list(READ)]
    read.attrs = {}  # pandas copies them for each column of each expression
    own = {name: getattr(np, name) for name in ("minimum", "maximum", "radians", "degrees")}
    for name, (ours, theirs) in both.items():
        with np.errstate(all="ignore"):
            expected = read.eval(theirs, engine="python", local_dict=own) + np.zeros(len(rows))
        expected = np.where(np.isfinite(expected), expected, np.inf)
        assert rows[name].to_numpy() == pytest.approx(expected, rel=1e-12), ours


def brute_force(rows, costs):
    """The rows that no other row is at least as good as in all costs and better in one."""
    values = rows[list(costs)].to_numpy() * np.array(list(costs.values()))
    better = (values[:, None] <= values).all(axis=2) & (values[:, None] < values).any(axis=2)
    return rows[~better.any(axis=0)]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("keep", ["pareto", "all"])
def test_a_front_is_the_one_of_all_rows(case, keep, tmp_path, monkeypatch):
    monkeypatch.setattr(plan, "boxes_are_faster", lambda asked: True)
    scene = BASE.replace(quantities=COMPACT, **CASES[case])
    found = sweep(scene, out=tmp_path / "found", keep=keep)
    sweep(scene, out=tmp_path / "all", keep="all")
    rows, front = load(tmp_path / "all" / "designs.parquet"), load(tmp_path / "found" / "pareto.parquet")
    left = rows[rows["feasible"]]
    if scene.limits.bounds_by_key.get("mine"):
        assert 0 < len(left) < len(rows)
        assert set(rows[rows["mine"] > 1700]["violated"].str.contains("mine")) == {True}
        assert (left["mine"] <= 1700).all()
    expected = brute_force(left, scene.search.objectives)
    sizes = ["law_rise", "base_radius_mm", "offset_mm", "roller_radius_mm"]
    assert 0 < len(front) == found.pareto
    assert {*map(tuple, front[sizes].to_numpy())} == {*map(tuple, expected[sizes].to_numpy())}
    told = "mine" in scene.search.objectives
    assert [("sample" if scene.search.samples else "grid") in each for each in found.warnings] == [True] * told
    assert (found.boxes == 0) == (told or keep == "all")
    assert front.attrs["units"]["mine"] == "mm·N·m"
    assert front.attrs["descriptions"]["mine"] == VALUE


def test_rows_are_those_of_evaluate_in_processes_and_in_parts(tmp_path):
    scene = BASE.replace(quantities=COMPACT, **CASES["a limit"])
    sweep(scene, out=tmp_path / "threads", keep="feasible")
    sweep(scene, out=tmp_path / "processes", keep="feasible", engine=Processes(1))
    for part in (1, 2):
        sweep_part(scene, (part, 2), out=tmp_path / f"part-{part}")
    merge([tmp_path / "part-1", tmp_path / "part-2"], out=tmp_path / "merged")
    texts = [(tmp_path / name / "pareto.parquet").read_bytes() for name in ("threads", "processes", "merged")]
    assert texts[0] == texts[1] == texts[2]
    rows = load(tmp_path / "threads" / "pareto.parquet")
    assert evaluate(scene_of(rows, len(rows) // 2))["mine"] == rows["mine"][len(rows) // 2]


def test_rows_in_memory_have_own_quantities_and_go_back_in():
    scene = BASE.replace(quantities=COMPACT, **CASES["a limit"])
    rows = sweep(scene, keep="all").to_pandas("designs")
    assert rows.attrs["units"]["mine"] == "mm·N·m"
    again = evaluate_designs(scene, rows, strict=False)
    assert again["mine"].to_numpy() == pytest.approx(rows["mine"].to_numpy(), rel=1e-9)
    assert again.attrs["units"]["mine"] == "mm·N·m"
    assert ((again["excess_mine"] <= 0.0) == (again["mine"] <= 1700)).all()
    (apart,) = evaluate_designs(scene, {"base_radius_mm": [41.0], "offset_mm": [90.0]})["mine"]
    assert apart == np.inf


def test_a_value_that_is_no_number_is_never_the_least(tmp_path):
    mine = {"mine": "sqrt(offset_mm) / (base_radius_mm - 48.4)"}
    for goal in ("minimise", "maximise"):
        scene = BASE.replace(quantities=mine, **{f"search.{goal}": ["mine"]})
        sweep(scene, out=tmp_path / goal, keep="all")
        rows, front = (load(tmp_path / goal / f"{name}.parquet") for name in ("designs", "pareto"))
        with np.errstate(all="ignore"):
            values = np.sqrt(rows["offset_mm"]) / (rows["base_radius_mm"] - 48.4)
        finite = np.isfinite(values)
        assert 0 < finite.sum() < len(rows)
        assert not rows["feasible"][~finite].any()
        assert np.isposinf(rows["mine"][~finite]).all()
        assert not rows.isna().any(axis=None)
        best = values[rows["feasible"]]
        assert front["mine"].iloc[0] == pytest.approx(best.min() if goal == "minimise" else best.max(), rel=1e-12)


@pytest.mark.parametrize("power", [1, 2])
def test_a_difference_near_zero_is_as_exact_as_its_terms(power):
    radii = sweep(BASE.replace(outputs=["profile_radius_min_mm"]), keep="all").to_pandas("designs")
    middle = float(radii["profile_radius_min_mm"].iloc[17])
    scene = BASE.replace(
        quantities={"mine": f"2 * ({middle!r} - profile_radius_min_mm) ** {power} / 3"}, **{"limits.mine": 1e-3}
    )
    found = sweep(scene, keep="all")
    rows = found.to_pandas("designs")
    assert np.abs(rows["mine"]).min() < 1e-9
    assert rows["relative_half_width"].max() <= 1e-9
    assert found.exit_code == 0


def test_refinement_lowers_an_own_objective():
    mine = {"mine": "outer_radius_mm * torque_rms_N_m + 3 * (offset_mm - 6.1) ** 2"}
    scene = BASE.replace(quantities=mine, **{"search.minimise": ["mine"], "search.law": ["harmonic"]})
    grid, moved = sweep(scene), sweep(scene.replace(**{"search.refine": True}))
    best = moved.front.knee
    assert best["mine"] < grid.front.knee["mine"] * (1.0 - 1e-4)
    around = [best["offset_mm"] + by for by in (-1e-3, 1e-3)]
    for offset in around:
        assert evaluate(best.scene.replace(**{"follower.offset": offset}))["mine"] >= best["mine"] * (1.0 - 1e-9)


def test_the_smallest_cam_holds_an_own_limit():
    scene = BASE.replace(
        quantities={"mine": "outer_radius_mm * pressure_angle_max_deg"},
        **{"limits.mine": 3000, "search.law": ["harmonic"], "search.offset": None, "follower.offset": 5},
        **{"search.roller_radius": None, "search.base_radius": {"start": 40, "stop": 120}},
    )
    best = optimise(scene).best
    assert (best["binding"], best["proved"]) == (["mine"], False)
    assert 3000 * (1.0 - 1e-9) <= best["mine"] <= 3000
    sizes = np.arange(40.0, best["base_radius_mm"] - 1e-6, 0.11)
    for size in sizes[:: max(len(sizes) // 40, 1)]:
        assert evaluate(best.scene.replace(**{"cam.base_radius": size}))["mine"] > 3000
    assert certify(best.scene)["mine"] == "held"

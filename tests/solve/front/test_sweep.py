"""The sweep: the lazy space, the same rows however it is cut, and an exact Pareto set."""

from itertools import product
from threading import current_thread, main_thread

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from support.depth import covering_cases

from camopt import QUANTITIES, BadInput, Scene, evaluate, find_scene, load, optimise, sweep
from camopt.core.engines import threads as threads_engine
from camopt.core.engines.threads import Threads
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.space import grid_space
from camopt.solve.front.reported_rows import (
    limits_violated_by_smaller_cams,
    row_indices_and_next_smaller_cams,
    with_reevaluated_columns,
)

SMALL = {
    "search.base_radius": {"start": 30, "stop": 90, "step": 4},
    "search.offset": {"start": -10, "stop": 20, "step": 5},
    "search.roller_radius": [5, 20],
    "search.law": ["harmonic", "cycloidal", "parabolic"],
}


@pytest.fixture(scope="session")
def scene():
    return find_scene("roller-1000rpm").replace(**SMALL)


@pytest.fixture(scope="module")
def tables(scene, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    result = sweep(scene, folder, keep="all")
    return result, load(folder / "designs.parquet"), load(folder / "pareto.parquet")


def test_the_space_is_indexed_not_materialised(scene):
    space = grid_space(resolve(scene))
    assert len(space) == 3 * 2 * 7 * 16
    expected = list(product([5, 20], range(-10, 25, 5), range(30, 94, 4)))
    designs = space.designs(np.arange(space.designs_per_problem))
    found = list(zip(designs.roller_radius, designs.offset, designs.size, strict=True))
    assert found == expected
    fine = {"start": 0, "stop": 100, "step": 1e-4}
    huge = scene.replace(**{"search.base_radius": {"start": 1, "stop": 900, "step": 1e-4}, "search.offset": fine})
    assert len(grid_space(resolve(huge))) > 1e13


def test_every_row_is_what_evaluate_says(scene, tables):
    _, designs, _ = tables
    for row in designs.sample(25, random_state=0).to_dict("records"):
        plain = scene.replace(
            **{
                "search": None,
                "cam.base_radius": row["base_radius_mm"],
                "follower.roller_radius": row["roller_radius_mm"],
                "follower.offset": row["offset_mm"] or None,
                "motion": [
                    {
                        **s.model_dump(exclude_none=True, exclude_defaults=True),
                        **({"law": row["law_rise"]} if s.law else {}),
                    }
                    for s in scene.motion
                ],
            }
        )
        one = evaluate(plain)
        for name, value in row.items():
            if name != "relative_half_width":
                assert one[name] == (pytest.approx(value, rel=1e-9) if isinstance(value, float) else value), name


def test_the_pareto_set_is_exact(tables):
    result, designs, pareto = tables
    feasible = designs[designs.feasible]
    costs = feasible[list(result.scene.search.minimise)].to_numpy()
    dominated = [bool(np.any(np.all(costs <= c, axis=1) & np.any(costs < c, axis=1))) for c in costs]
    pd.testing.assert_frame_equal(pareto, feasible[~np.array(dominated)].reset_index(drop=True))
    assert result.pareto == len(pareto)
    assert result.feasible == len(feasible)


@pytest.mark.slow
@pytest.mark.parametrize(("workers", "block"), [(1, 32768), (2, 17), (3, 100), (1, 1)])
def test_rows_do_not_depend_on_workers_or_blocks(scene, tables, tmp_path, workers, block):
    _, _, pareto = tables
    sweep(scene, tmp_path, keep="feasible", workers=workers, block=block)
    designs = load(tmp_path / "designs.parquet")
    pd.testing.assert_frame_equal(load(tmp_path / "pareto.parquet"), pareto, check_exact=True)
    reference = tables[1][tables[1].feasible].reset_index(drop=True)
    pd.testing.assert_frame_equal(designs, reference, check_exact=True)


def own_scene(scene, row):
    """The scene of one row: its sizes and laws, without a space but with its objectives."""
    search = {f"search.{key}": None for key in ("base_radius", "offset", "roller_radius", "law")}
    sizes = {
        "cam.base_radius": row["base_radius_mm"],
        "follower.roller_radius": row["roller_radius_mm"],
        "follower.offset": row["offset_mm"],
    }
    motion = [s.model_dump(exclude_none=True, exclude_defaults=True) for s in scene.motion]
    motion = [s | ({"law": row["law_rise"]} if "law" in s else {}) for s in motion]
    return scene.replace(**search, **sizes, motion=motion)


LOOSE = [(1e-9, False), (1e-4, True), (1e-4, False), (1e-9, True)]


@pytest.mark.slow
@pytest.mark.usefixtures("_few_levels")
@pytest.mark.parametrize(("tolerance", "refine"), covering_cases(LOOSE, lambda pair: pair))
def test_rows_that_people_compare_are_those_of_evaluate_bit_for_bit(scene, tmp_path, tolerance, refine):
    loose = scene.replace(**{"accuracy.relative_error": tolerance, "search.refine": refine, "search.thin": 0.02})
    result = sweep(loose, tmp_path)
    tables = [load(tmp_path / f"{name}.parquet") for name in ("pareto", *(("pareto-grid",) if refine else ()))]
    rows = [row for table in tables for row in table.to_dict("records")]
    rows += [*result.best.values(), result.front.knee]
    assert len(rows) > 20
    for row in rows:
        one = evaluate(own_scene(result.scene, row))
        assert {name: value for name, value in row.items() if name in one and one[name] != value} == {}
        assert set(row) - set(one) <= {"refined", "held_by"}


def test_the_front_is_the_one_that_the_sweep_decided(scene, tmp_path):
    """Digits do not change which rows are on it, nor their order."""
    sweep(scene, tmp_path / "pareto")
    sweep(scene, tmp_path / "all", keep="all")
    designs, front = load(tmp_path / "all" / "designs.parquet"), load(tmp_path / "pareto" / "pareto.parquet")
    feasible = designs[designs.feasible]
    costs = feasible[list(sweep(scene).scene.search.minimise)].to_numpy()
    dominated = [bool(np.any(np.all(costs <= c, axis=1) & np.any(costs < c, axis=1))) for c in costs]
    sizes = ["law_rise", "base_radius_mm", "roller_radius_mm", "offset_mm"]
    pd.testing.assert_frame_equal(front[sizes], feasible[~np.array(dominated)][sizes].reset_index(drop=True))


def test_the_best_of_each_law_and_what_holds_it(tables):
    result, designs, _ = tables
    for law, row in result.best.items():
        of_law = designs[designs.feasible & (designs.law_rise == law)]
        assert row["base_radius_mm"] == of_law.base_radius_mm.min()
        smaller = designs[
            (designs.law_rise == law)
            & (designs.base_radius_mm == row["base_radius_mm"] - 4)
            & (designs.offset_mm == row["offset_mm"])
            & (designs.roller_radius_mm == row["roller_radius_mm"])
        ]
        if len(smaller):
            assert set(row["held_by"].split(", ")) == set(smaller.violated.iloc[0].split(","))


def test_what_holds_rows_is_what_their_next_smaller_cams_exceed(scene, tables):
    """All rows of a table asked together, many of a law and some at the edge of the space, in another order."""
    designs = tables[1].sample(frac=1.0, random_state=5)
    sizes = ["law_rise", "roller_radius_mm", "offset_mm", "base_radius_mm"]
    violated = {tuple(row): of for *row, of in designs[[*sizes, "violated"]].itertuples(index=False)}
    assert len(violated) == len(designs)
    rows = DesignRows({name: designs[name].to_numpy() for name in designs}, len(designs))
    space = grid_space(resolve(scene))
    inside, smaller = row_indices_and_next_smaller_cams(space, rows)
    held = limits_violated_by_smaller_cams(
        rows.count, inside, *with_reevaluated_columns(space, frozenset(smaller.columns), smaller)
    )
    for (*of_law, base), by in zip(designs[sizes].itertuples(index=False), held, strict=True):
        smaller = violated.get((*of_law, base - 4), None if base > 30 else "edge of the space")
        if smaller is not None:  # it can be assembled
            assert by == smaller.replace(",", ", ")


def test_the_grid_never_beats_the_optimum(scene, tables):
    result, _, _ = tables
    optimum = optimise(scene).by_law
    for law, row in result.best.items():
        assert optimum[law]["base_radius_mm"] <= row["base_radius_mm"]


def test_impossible_designs_are_counted_and_in_no_table(scene, tmp_path):
    wide = scene.replace(**{"search.offset": {"start": 0, "stop": 200, "step": 50}})
    result = sweep(wide, tmp_path, keep="all")
    designs = load(tmp_path / "designs.parquet")
    assert result.impossible > 0
    assert len(designs) == result.designs - result.impossible
    assert (designs.offset_mm.abs() < designs.prime_radius_mm).all()
    assert np.isfinite(designs.select_dtypes(float).to_numpy()).all()


def test_keep_pareto(scene, tmp_path):
    sweep(scene, tmp_path, keep="pareto")
    pd.testing.assert_frame_equal(load(tmp_path / "designs.parquet"), load(tmp_path / "pareto.parquet"))


def test_tables_carry_units_symbols_scene_and_version(tables, tmp_path, scene):
    _, designs, _ = tables
    assert designs.attrs["units"]["base_radius_mm"] == "mm"
    assert designs.attrs["symbols"]["base_radius_mm"] == "R_b"
    assert set(designs.columns) <= set(QUANTITIES)
    assert Scene.from_dict(__import__("tomllib").loads(designs.attrs["scene"])) == scene
    sweep(scene, tmp_path)
    plain = pd.read_parquet(tmp_path / "designs.parquet")
    pd.testing.assert_frame_equal(plain, load(tmp_path / "designs.parquet"))
    metadata = pq.read_metadata(tmp_path / "designs.parquet")
    assert metadata.row_group(0).column(0).compression == "ZSTD"
    assert Scene.from_toml(tmp_path / "scene.toml") == scene


def test_values_that_differ_are_split_by_bytes_and_those_that_repeat_are_in_dictionaries(scene, tmp_path):
    sweep(scene, tmp_path)
    group = pq.read_metadata(tmp_path / "designs.parquet").row_group(0)
    encodings = {group.column(k).path_in_schema: set(group.column(k).encodings) for k in range(group.num_columns)}
    assert "RLE_DICTIONARY" in encodings["law_rise"] & encodings["roller_radius_mm"]
    assert encodings["pressure_angle_max_deg"] == {"BYTE_STREAM_SPLIT", "RLE"}


def test_nothing_feasible_names_the_nearest_miss(scene):
    result = sweep(scene.replace(**{"limits.pressure_angle": 5, "limits.pressure_angle_return": 5}))
    assert result.feasible == 0
    assert result.nearest_miss["violated"] == "pressure_angle,pressure_angle_return"


def test_the_nearest_miss_of_many_designs_is_that_of_some_blocks(scene, monkeypatch):
    hopeless = scene.replace(**{"limits.pressure_angle": 5, "limits.pressure_angle_return": 5})
    exact = sweep(hopeless, block=50)
    monkeypatch.setattr("camopt.solve.front.reported_rows.MOST_MISS_DESIGNS", exact.designs // 2)
    some = sweep(hopeless, block=50)
    assert some.nearest_miss["violated"] == exact.nearest_miss["violated"]
    assert some.nearest_miss["pressure_angle_max_deg"] >= exact.nearest_miss["pressure_angle_max_deg"]


def test_other_objectives_and_a_maximised_one(scene, tmp_path):
    chosen = {
        "search.minimise": ["base_radius_mm", "jerk_max_m_s3"],
        "search.maximise": ["profile_radius_min_mm"],
    }
    result = sweep(scene.replace(**chosen), tmp_path)
    pareto = load(tmp_path / "pareto.parquet")
    assert {"jerk_max_m_s3", "profile_radius_min_mm"} <= set(pareto.columns)
    assert np.isinf(pareto.jerk_max_m_s3).any()  # parabolic and harmonic: infinite, and still compared
    assert result.pareto == len(pareto)


def test_an_objective_the_mechanism_has_not_is_a_mistake(scene):
    with pytest.raises(BadInput, match="face_reach_max_mm"):
        sweep(scene.replace(**{"search.minimise": ["face_reach_max_mm"]}))


def test_a_range_without_a_step_is_a_mistake(scene):
    with pytest.raises(BadInput, match="step"):
        sweep(scene.replace(**{"search.offset": {"start": 0, "stop": 5}}))


@pytest.mark.parametrize("name", ["flat-reciprocating", "oscillating-roller", "uniform-knife-radial", "two-pauses"])
def test_a_scene_without_search_sweeps_its_one_design(name, tmp_path):
    result = sweep(find_scene(name), tmp_path)
    assert result.designs == 1
    assert result.feasible == 1
    assert len(load(tmp_path / "pareto.parquet")) == 1


def test_rise_and_return_laws_vary_on_their_own(scene):
    free = scene.replace(
        **{"search.law": None, "search.law_rise": ["harmonic", "cycloidal"], "search.law_return": ["poly345"]}
    )
    assert set(sweep(free).best) <= {"harmonic / poly345", "cycloidal / poly345"}


@pytest.mark.parametrize("ready", [False, True])
def test_the_first_block_of_a_sweep_is_worked_on_where_an_interrupt_ends_it(ready, monkeypatch):
    """While it compiled kernels in a thread of its own, an interrupt was answered after all of them."""
    monkeypatch.setattr(threads_engine, "READY_KERNELS", ["some kernel"] if ready else [])
    space, threads = grid_space(resolve(find_scene("roller-1000rpm"))), []
    work = lambda blocks: threads.append(current_thread()) or blocks[0]  # noqa: E731
    found = Threads(2).results_in_order(work, [*space.blocks(40_000)])
    assert list(found) == list(space.blocks(40_000))
    assert (threads[0] is main_thread()) is not ready
    assert main_thread() not in threads[1:]

"""Rows of plain pandas are designs: units and scene are in attrs, or the scene is asked for."""

import pandas as pd
import pyarrow.parquet as pq
import pytest

from camopt import BadInput, evaluate, evaluate_designs, find_scene, load, scene_of, sweep
from camopt.exporting.cam_points import write_points

SCENE = find_scene("roller-1000rpm").replace(
    search={"base_radius": [57.3, 71.9, 93.7, 121.3], "offset": [0, 11.3], "law": ["cycloidal", "poly345"]}
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("swept")
    sweep(SCENE, folder, keep="all")
    return folder


@pytest.mark.parametrize("name", ["designs", "pareto"])
def test_plain_pandas_has_the_attrs_of_load(folder, name):
    path = folder / f"{name}.parquet"
    plain, loaded = pd.read_parquet(path), load(path)
    assert plain.attrs == loaded.attrs
    assert plain.attrs["units"]["base_radius_mm"] == "mm"
    assert (plain.attrs["sweep"] or {}).get("designs") == (16 if name == "pareto" else None)
    pd.testing.assert_frame_equal(plain, loaded, check_exact=True)


def test_other_tables_have_attrs_too(tmp_path):
    points = tmp_path / "points.parquet"
    write_points(find_scene("two-pauses"), points)
    assert pd.read_parquet(points).attrs == load(points).attrs
    assert "mm" in load(points).attrs["units"].values()


def design_of(scene):
    """All but what was searched: a sweep chooses objectives."""
    return {name: table for name, table in scene.to_dict().items() if name != "search"}


def test_a_row_has_its_scene(folder):
    plain = pd.read_parquet(folder / "designs.parquet")
    for label in (3, 7):
        expected = scene_of(folder / "designs.parquet", label)
        row = plain.loc[label]
        rows = [scene_of(plain, label), scene_of(row), scene_of(plain.loc[[label]]), SCENE.with_row(row)]
        rows += [scene_of(dict(row), scene=SCENE), scene_of(row.to_frame().T, scene=SCENE)]
        rows += [scene_of(pq.read_table(folder / "designs.parquet").slice(label, 1), scene=SCENE)]
        assert all(design_of(each) == design_of(expected) for each in rows)
        assert evaluate(expected)["base_radius_mm"] == row["base_radius_mm"]


def test_a_merge_loses_the_scene_which_is_asked_for(folder):
    plain = pd.read_parquet(folder / "designs.parquet")
    costs = pd.DataFrame({"law_rise": ["cycloidal", "poly345"], "cost": [3.0, 5.0]})
    merged = costs.merge(plain, on="law_rise")
    merged.attrs = {}
    with pytest.raises(BadInput, match=r"^camopt: scene: missing: the table has lost it, as in a merge.*scene=$"):
        scene_of(merged, 3)
    found = scene_of(merged, 3, scene=SCENE)
    assert found.cam.base_radius == merged["base_radius_mm"][3]
    assert {each.law for each in found.motion if each.law} == {merged["law_rise"][3]}


def test_a_row_is_one_row(folder):
    plain = pd.read_parquet(folder / "designs.parquet")
    for wrong in (99, "3", None):
        with pytest.raises(BadInput, match=r"must be a row of table, which has 16, counted from 0"):
            scene_of(plain, wrong)
    with pytest.raises(BadInput, match="a table that camopt wrote, or one row of it"):
        scene_of(7)
    with pytest.raises(BadInput, match="must be a row of table, which has 32"):
        scene_of(pd.concat([plain, plain]), 3)


def test_a_row_of_a_frontier_has_a_scene_of_its_own(folder):
    """As TOML; a word in a column of that name is none."""
    own, rows = find_scene("knife-300rpm-offset"), pd.read_parquet(folder / "pareto.parquet")
    frontier = rows.assign(scene=own.to_toml())
    for found in (scene_of(frontier, 0), scene_of(frontier.loc[0]), scene_of(dict(frontier.loc[0]), scene=SCENE)):
        assert found == own
    assert scene_of(rows.assign(scene="mine"), 0) == scene_of(rows, 0)


@pytest.mark.parametrize("name", ["two-pauses", "slide-by-bell-crank", "press-feed-by-pair", "exhaust-valve"])
def test_a_row_of_evaluate_designs_goes_back_into_its_scene(name):
    scene = find_scene(name)
    own = evaluate(scene)
    row = evaluate_designs(scene, own).iloc[0]
    assert scene.with_row(row).to_dict() == scene_of(row).to_dict()
    again = evaluate(scene_of(row))
    assert [k for k in own if again[k] != own[k]] == []


def test_numbers_of_a_row_are_those_of_the_scene():
    valve = find_scene("exhaust-valve")
    found = valve.with_row(
        {"rpm": 431.0, "preload_N": 333.0, "base_radius_mm": 47.1, "law": "poly345", "cost": None}
    )
    assert (found.cam.rpm, found.follower.dynamics.preload, found.cam.base_radius) == (431.0, 333.0, 47.1)
    assert {each.law for each in found.motion if each.law} == {"poly345"}
    with pytest.raises(BadInput, match=r"cam\.rpm = -3.0"):
        valve.with_row({"rpm": -3})
    with pytest.raises(BadInput, match=r"cam\.base_radius = 'far': must be a number"):
        valve.with_row({"base_radius_mm": "far"})

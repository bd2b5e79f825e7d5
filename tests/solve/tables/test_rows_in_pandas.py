"""Rows of plain pandas are designs: units and scene are in attrs, or the scene is asked for."""

import pandas as pd
import pyarrow.parquet as pq
import pytest

from camopt import BadInput, evaluate, evaluate_designs, find_scene, load, optimise, scene_of, sweep, synthesise
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.problem import resolve_design
from camopt.scene.sources import shipped_scenes
from camopt.show.exporting.cam_points import write_points

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
    with pytest.raises(
        BadInput, match=r"^camopt: scene: missing: the table has lost it, as after a merge.*scene=$"
    ):
        scene_of(merged, 3)
    with pytest.warns(UserWarning, match="^table: camopt ignores cost: this mechanism has no such size") as told:
        found = scene_of(merged, 3, scene=SCENE)
    assert [each.filename for each in told] == [__file__]
    assert found.cam.base_radius == merged["base_radius_mm"][3]
    assert {each.law for each in found.motion if each.law} == {merged["law_rise"][3]}


def test_a_row_is_one_row(folder):
    plain = pd.read_parquet(folder / "designs.parquet")
    for wrong in (99, "3", None):
        with pytest.raises(BadInput, match=r"must be a row of table, which has 16, counted from 0"):
            scene_of(plain, wrong)
    with pytest.raises(BadInput, match="a table that camopt wrote, or one of its rows"):
        scene_of(7)
    with pytest.raises(BadInput, match=r"table: must be .* one of its rows without a label; this is a Series$"):
        scene_of(plain.loc[3], 3)
    with pytest.raises(
        BadInput, match=r"must be a row of table, which has 32.*; 2 rows have this label: .*reset_index"
    ):
        scene_of(pd.concat([plain, plain]), 3)
    with pytest.raises(BadInput, match="row: must be a label of a row; give the scene as scene="):
        scene_of(plain.loc[3], SCENE)
    with pytest.raises(BadInput, match=r"this is a Sweep: give its \.to_pandas\(\)"):
        scene_of(sweep(SCENE), 3)
    with pytest.raises(BadInput, match=r"scene: missing: the scene of this Evaluation is its \.scene"):
        scene_of(evaluate(SCENE))


def test_levels_of_an_index_are_columns_of_a_row(folder):
    plain = pd.read_parquet(folder / "designs.parquet")
    for levels in ("base_radius_mm", ["law_rise", "base_radius_mm", "offset_mm"]):
        indexed = plain.set_index(levels)
        for place in (3, 7):
            expected = scene_of(plain, place)
            assert scene_of(indexed.iloc[[place]]) == expected
            assert SCENE.with_row(indexed.iloc[[place]]) == SCENE.with_row(plain.loc[place])
            if indexed.index.nlevels > 1:
                assert scene_of(indexed, indexed.index[place]) == expected
    best = plain.groupby("law_rise").first()
    assert {each.law for each in scene_of(best, "cycloidal").motion if each.law} == {"cycloidal"}
    assert scene_of(best, "poly345").cam.base_radius == best["base_radius_mm"]["poly345"]


def test_rows_of_an_optimum_have_their_scene():
    found = optimise(SCENE)
    frame = found.to_pandas()
    assert len(frame) == 2
    for law, best in found.by_law.items():
        assert scene_of(frame, law) == best.scene
    assert scene_of(found.best.to_pandas()) == found.best.scene


def test_the_row_of_a_synthesis_has_its_laws():
    found = synthesise(find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12}))
    assert scene_of(found.to_pandas()) == found.scene
    with pytest.raises(BadInput, match="law_rise = 'free-rise': must be a motion law"):
        SCENE.with_row(found.design)


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


FREE = {"law_rise": "free-rise", "law_return": "free-return"}


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ({"base_radius_mm": 67.3, **FREE}, "row: law_rise = 'free-rise': must be a motion law"),
        ({"law": "cycliodal"}, "row: law = 'cycliodal': must be a motion law; did you mean cycloidal?"),
        ({"law_rise": "xx"}, "row: law_rise = 'xx': must be a motion law; known: "),
        ({"law": 3}, "row: law = 3: must be a motion law"),
        ({"law": ["cycloidal"]}, r"row: law = \['cycloidal'\]: must be a motion law"),
        ({"base_radius_mm": float("nan"), "offset_mm": 5.1}, "row: base_radius_mm: missing"),
        ({"base_radius_mm": None}, "row: base_radius_mm: missing"),
        ({"base_radius_mm": pd.NA}, "row: base_radius_mm: missing"),
        ({"base_radius_mm": 67.3, "rpm": float("nan")}, "row: rpm: missing"),
        ({"base_radius_mm": 67.3, "law_rise": float("nan")}, "row: law_rise: missing"),
        (
            {"base_radus_mm": 99.1},
            "row: base_radus_mm: this mechanism has no such size, number.*did you mean base_radius_mm?",
        ),
        ({"outer_radius_mm": 99.1}, "row: outer_radius_mm: this mechanism has no such size, number or law"),
        ({}, "camopt: row: must be a row with a size, a number or a law of this mechanism; known: base_radius_mm"),
        ({"angles_deg": [90.0]}, r"row: angles_deg = \[90.0\]: must be the angles of the 4 segments"),
        ({"base_radius_mm": "60"}, r"cam.base_radius = '60': must be a number"),
        ({"base_radius_mm": True}, r"cam.base_radius = True: must be a number"),
        (None, "camopt: row: must be one row of a table; this is a NoneType"),
        ([1], "camopt: row: must be one row of a table; this is a list"),
        (
            pd.DataFrame({"base_radius_mm": [60.0, 70.0]}),
            "row: must be one row of a table; this is a DataFrame",
        ),
    ],
)
def test_a_row_that_no_scene_may_have_is_refused(row, told):
    scene = find_scene("roller-1000rpm")
    with pytest.raises(BadInput, match=told):
        scene.with_row(row)
    if isinstance(row, dict):
        with pytest.raises(BadInput, match=told):
            scene_of(row, scene=scene)
        with pytest.raises(BadInput, match=told):
            scene.with_row(pd.Series(row, dtype=object))


def test_a_row_with_a_law_of_its_own_scene_keeps_it():
    own = SCENE.replace(**{"laws.free-rise": {"x": [0, 0.4, 1], "s": [0, 0.5, 1]}})
    row = {"base_radius_mm": 67.3, "law": "free-rise"}
    assert {each.law for each in own.with_row(row).motion if each.law} == {"free-rise"}
    with pytest.raises(BadInput, match="law = 'free-rise'"):
        SCENE.with_row(row)
    assert scene_of({**row, "scene": own.to_toml()}, scene=SCENE) == own


@pytest.mark.parametrize("name", shipped_scenes())
def test_laws_of_a_scene_itself_are_known_to_it(name):
    scene = find_scene(name)
    programme = resolve_design(scene).programme
    laws = {"law_rise": programme.law_names(RISE), "law_return": programme.law_names(RETURN)}
    assert scene.with_row(laws) == scene


def test_columns_that_only_another_mechanism_has_may_be_missing():
    flat, roller = find_scene("flat-reciprocating"), find_scene("roller-1000rpm")
    rows = pd.concat([evaluate_designs(flat, {"base_radius_mm": 41.7}), evaluate_designs(roller, {"rpm": 431.0})])
    assert rows["roller_radius_mm"].isna().tolist() == [True, False]
    assert flat.with_row(rows.drop(columns="rpm").iloc[0]).cam.base_radius == 41.7
    assert roller.with_row(rows.iloc[[1]]).cam.rpm == 431.0

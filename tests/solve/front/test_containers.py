"""Rows go back in: designs in any container have the values that a sweep gave them."""

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pandas.testing import assert_frame_equal
from support.depth import times

from camopt import BadInput, evaluate, evaluate_designs, find_scene, load, optimise, sweep

SCENE = find_scene("roller-1000rpm")
NAMES = ["base_radius_mm", "offset_mm", "roller_radius_mm"]
VALVE = find_scene("exhaust-valve")


def designs(count, seed=60):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(37, 121, count), rng.uniform(-17, 23, count), rng.uniform(3, 19, count)])


def rows_of(frame):
    return frame.to_dict("records")


CONTAINERS = {
    "pandas": lambda frame: frame,
    "pandas with nullable numbers": lambda frame: frame.convert_dtypes(),
    "polars": lambda frame: pytest.importorskip("polars").from_pandas(frame),
    "pyarrow": pa.Table.from_pandas,
    "mapping of arrays": lambda frame: {name: frame[name].to_numpy() for name in frame},
    "mapping of lists": lambda frame: frame.to_dict("list"),
    "mapping of Series": lambda frame: {name: frame[name] for name in frame},
    "structured array": lambda frame: frame[NAMES].to_records(index=False).view(np.ndarray),
    "list of mappings": rows_of,
    "list of Series": lambda frame: [row for _, row in frame.iterrows()],
}


@pytest.mark.parametrize("kind", CONTAINERS)
def test_rows_have_the_same_bits_in_any_container(kind):
    frame = pd.DataFrame(designs(7), columns=NAMES)
    if kind != "structured array":  # pandas and numpy agree on no type of texts there
        frame["law"] = ["cycloidal", "harmonic", "poly345", "cycloidal", "modified-sine", "harmonic", "poly8"]
    expected = evaluate_designs(SCENE, frame)
    assert_frame_equal(evaluate_designs(SCENE, CONTAINERS[kind](frame)), expected, check_exact=True)
    for row in range(len(frame)):
        one = evaluate_designs(SCENE, frame.iloc[row])
        assert_frame_equal(one, expected.iloc[row : row + 1], check_exact=True)


def test_an_array_has_names():
    array = designs(5)
    expected = evaluate_designs(SCENE, pd.DataFrame(array, columns=NAMES))
    assert_frame_equal(evaluate_designs(SCENE, array, names=NAMES), expected, check_exact=True)
    assert_frame_equal(evaluate_designs(SCENE, array.tolist(), names=iter(NAMES)), expected, check_exact=True)
    assert_frame_equal(evaluate_designs(SCENE, array[0], names=NAMES), expected.iloc[:1], check_exact=True)
    with pytest.raises(
        BadInput, match=r"an array with a column for each of the 2 names; this has the shape \(5, 3\)"
    ):
        evaluate_designs(SCENE, array, names=NAMES[:2])
    with pytest.raises(BadInput, match="designs: offset_mm: occurs twice"):
        evaluate_designs(SCENE, array, names=["offset_mm", "base_radius_mm", "offset_mm"])


def test_single_values_are_one_design():
    single = {"base_radius_mm": 67.3, "law": "cycloidal"}
    expected = evaluate_designs(SCENE, {name: [value] for name, value in single.items()})
    assert_frame_equal(evaluate_designs(SCENE, single), expected, check_exact=True)


SWEEPS = {
    "sizes and laws": SCENE.replace(
        search={"base_radius": [57.3, 71.9, 93.7, 3], "offset": [0, 11.3, 60], "law": ["cycloidal", "poly345"]}
    ),
    "numbers": VALVE.replace(
        **{"search.follower.dynamics.preload": [211.0, 349.0], "search.cam.rpm": [431.0, 997.0]},
        **{"search.base_radius": [31.7, 47.1]},
    ),
    "several laws in turn": find_scene("two-pauses").replace(search={"base_radius": [41.3, 67.9]}),
    "a profile": find_scene("three-arc-valve").replace(search={"cam.rpm": [431.0, 997.0]}),
    "a train": find_scene("slide-by-bell-crank").replace(
        search={"base_radius": [61.3, 79.9], "train.1.coupler": [220.0, 231.0]}
    ),
}


@pytest.mark.parametrize("what", SWEEPS)
def test_rows_of_a_sweep_go_in_as_they_are(what, tmp_path):
    """The same bits in the columns that both have, also of rows that pandas alone has read."""
    scene = SWEEPS[what]
    sweep(scene, tmp_path, keep="all")
    kept, plain = load(tmp_path / "designs.parquet"), pd.read_parquet(tmp_path / "designs.parquet")
    assert len(kept)
    found = evaluate_designs(scene, kept)
    shared = [name for name in kept if name in found and name != "relative_half_width"]
    assert {*kept} - {*found} <= {"relative_half_width"}
    assert_frame_equal(found[shared], kept[shared], check_exact=True)
    row = len(plain) - 1
    assert_frame_equal(evaluate_designs(scene, plain.iloc[row])[shared], kept[shared].iloc[row:], check_exact=True)
    records = pq.read_table(tmp_path / "designs.parquet").to_pylist()
    assert_frame_equal(evaluate_designs(scene, records)[shared], kept[shared], check_exact=True)


def test_an_evaluation_goes_in_as_it_is():
    single = evaluate(SCENE)
    found = evaluate_designs(SCENE, single)
    assert found["pressure_angle_max_deg"].item() == pytest.approx(single["pressure_angle_max_deg"], rel=1e-9)


def test_columns_of_others_are_ignored_with_one_warning():
    frame = pd.DataFrame(designs(3), columns=NAMES).assign(cost=3.0, machine="mill", face_offset_mm=2.0)
    told_of = (
        r"designs: camopt ignores cost, machine, face_offset_mm: this mechanism has no such size, number or law"
    )
    with pytest.warns(UserWarning, match=told_of) as told:
        found = evaluate_designs(SCENE, frame)
    assert len(told) == 1
    assert told[0].filename == __file__
    assert_frame_equal(found, evaluate_designs(SCENE, frame[NAMES]), check_exact=True)
    with pytest.raises(BadInput, match="designs: cost: this mechanism has no such size, number or law") as refused:
        evaluate_designs(SCENE, frame, strict=True)
    assert [each.key for each in refused.value.mistakes] == ["cost", "machine", "face_offset_mm"]


def test_a_table_that_says_nothing_of_designs_is_refused():
    with pytest.raises(
        BadInput, match=r"designs: base_radius: this mechanism has no such size.*did you mean base_radius_mm"
    ):
        evaluate_designs(SCENE, {"base_radius": [50.0], "cost": [3.0]})


def test_a_warning_names_the_column_that_was_meant():
    with pytest.warns(
        UserWarning, match=r"ignores cost, ofset_mm \(did you mean offset_mm\?\), base_radus_mm: this"
    ):
        evaluate_designs(SCENE, {"base_radius_mm": 67.3, "cost": 3.0, "ofset_mm": 5.1, "base_radus_mm": 3.0})


@pytest.mark.parametrize("table", [{"outer_radius_mm": [201.3]}, {"prime_radius_mm": 67.3}, {"violated": [""]}])
@pytest.mark.parametrize("strict", [False, True])
def test_a_table_of_other_quantities_alone_is_refused(table, strict):
    (name,) = table
    with pytest.raises(BadInput, match=f"^designs: {name}: this mechanism has no such size, number or law"):
        evaluate_designs(SCENE, table, strict=strict)


def test_rows_without_columns_are_refused():
    with pytest.raises(BadInput, match=r"^camopt: designs: must be a table with a size, a number or a law"):
        evaluate_designs(SCENE, pd.DataFrame(index=range(3)))
    assert evaluate_designs(SCENE, []).empty


def test_named_levels_of_an_index_are_columns():
    frame = pd.DataFrame(designs(6), columns=NAMES).assign(law_rise=["cycloidal", "poly345", "harmonic"] * 2)
    expected = evaluate_designs(SCENE, frame)
    for index in ("base_radius_mm", ["law_rise", "offset_mm"], ["law_rise", *NAMES]):
        indexed = frame.set_index(index)
        found = evaluate_designs(SCENE, indexed)
        assert found.index.equals(indexed.index)
        assert_frame_equal(found.reset_index(drop=True), expected, check_exact=True)
        both = evaluate_designs(SCENE, frame.set_index(index, drop=False))
        assert_frame_equal(both.reset_index(drop=True), expected, check_exact=True)
    smallest = frame.groupby("law_rise").first()
    by_law = frame.drop_duplicates("law_rise").sort_values("law_rise").reset_index(drop=True)
    assert_frame_equal(
        evaluate_designs(SCENE, smallest).reset_index(drop=True), evaluate_designs(SCENE, by_law), check_exact=True
    )
    named = {"offset_mm": frame.set_index("base_radius_mm")["offset_mm"]}
    assert evaluate_designs(SCENE, named)["base_radius_mm"].tolist() == frame["base_radius_mm"].tolist()


MASK = [[False, False], [True, False]]
MASKED = {
    "a mapping": {"base_radius_mm": np.ma.array([60.1, 70.3], mask=[0, 1]), "offset_mm": [1.1, 2.3]},
    "an array with names": np.ma.array([[60.1, 1.1], [70.3, 2.3]], mask=MASK),
    "a structured array": np.ma.array(
        [(60.1, 1.1), (70.3, 2.3)], mask=[(0, 0), (1, 0)], dtype=[("base_radius_mm", float), ("offset_mm", float)]
    ),
}


@pytest.mark.parametrize("kind", MASKED)
def test_a_masked_value_is_missing(kind):
    names = NAMES[:2] if kind == "an array with names" else None
    with pytest.raises(BadInput, match=r"^designs: base_radius_mm\[1\]: missing$"):
        evaluate_designs(SCENE, MASKED[kind], names=names)
    with pytest.raises(BadInput, match=r"^designs: law\[1\]: must be a motion law"):
        evaluate_designs(SCENE, {"law": np.ma.array(["cycloidal", "poly345"], mask=[0, 1])})
    unmasked = {"base_radius_mm": np.ma.array([60.1, 70.3])}
    assert evaluate_designs(SCENE, unmasked)["base_radius_mm"].tolist() == [60.1, 70.3]


def test_a_column_of_structures_is_refused():
    polars = pytest.importorskip("polars")
    with pytest.raises(BadInput, match="columns with one value per row; base_radius_mm has more"):
        evaluate_designs(SCENE, polars.DataFrame({"base_radius_mm": [{"a": 1.1}]}))


def test_angles_of_segments_are_refused():
    row = {"base_radius_mm": 67.3, "angles_deg": [100.0, 90.0, 90.0, 80.0]}  # as of ``optimise``
    assert [each.angle for each in SCENE.with_row(row).motion] == row["angles_deg"]
    for rows in (row, [row], pd.DataFrame([row])):
        with pytest.raises(
            BadInput, match=r"^designs: angles_deg: .*pass each row to scene_of, and its scene to evaluate"
        ):
            evaluate_designs(SCENE, rows)


def test_rows_with_scenes_of_their_own_are_refused():
    rows = pd.DataFrame({"base_radius_mm": [67.3, 71.9], "scene": [SCENE.to_toml()] * 2})
    with pytest.raises(BadInput, match=r"^designs: scene: .*pass each row to scene_of, and its scene to evaluate"):
        evaluate_designs(SCENE, rows)
    assert len(evaluate_designs(SCENE, rows.assign(scene="mine"))) == 2


def test_tables_of_camopt_are_strictly_designs(tmp_path):
    scene = SWEEPS["sizes and laws"]
    swept = sweep(scene, tmp_path, keep="all")
    for rows in (swept.to_pandas(), load(tmp_path / "designs.parquet"), optimise(scene).to_pandas()):
        assert len(evaluate_designs(scene, rows, strict=True)) == len(rows)
        assert len(evaluate_designs(scene, evaluate_designs(scene, rows), strict=True)) == len(rows)
    with pytest.raises(BadInput, match=r"give its \.to_pandas\(\)"):
        evaluate_designs(scene, swept)


def test_one_name_may_be_a_text():
    found = evaluate_designs(SCENE, [[60.1], [70.3]], names="base_radius_mm")
    assert found["base_radius_mm"].tolist() == [60.1, 70.3]
    assert evaluate_designs(SCENE, [60.1], names="base_radius_mm")["base_radius_mm"].tolist() == [60.1]


def test_a_row_has_every_column():
    with pytest.raises(BadInput, match=r"designs: offset_mm\[1\]: missing"):
        evaluate_designs(SCENE, [{"base_radius_mm": 60.0, "offset_mm": 3.0}, {"base_radius_mm": 70.0}])
    with pytest.raises(BadInput, match=r"designs: rpm\[1\]: missing"):
        evaluate_designs(SCENE, {"base_radius_mm": 60.0, "rpm": [300.0, None]})


def test_numbers_far_from_those_before_have_the_same_bits():
    """A scene is resolved once for numbers between some ends: values do not depend on these."""
    springs = [{"base_radius_mm": 41.3, "preload_N": force, "rpm": 700.0} for force in (300.0, 100.0, 700.0, 430.0)]
    alone = [evaluate_designs(VALVE.replace(name="other"), spring) for spring in springs]
    one_by_one = [evaluate_designs(VALVE, spring) for spring in springs]
    for found, expected in zip(one_by_one, alone, strict=True):
        assert_frame_equal(found, expected, check_exact=True)
    with pytest.raises(BadInput, match=r"designs: preload_N\[0\] = -1.0"):
        evaluate_designs(VALVE, {"base_radius_mm": 41.3, "preload_N": -1.0})


def test_a_scene_is_resolved_once(monkeypatch):
    from camopt.scene.scene import Scene

    points = {"base_radius_mm": 67.3, "offset_mm": 3.1, "rpm": 700.0}
    evaluate_designs(SCENE, points)
    evaluate_designs(SCENE, points | {"rpm": 900.0})
    made = []
    monkeypatch.setattr(Scene, "_fill_and_check", lambda *args: made.append(args))
    for rpm in (700.0, 811.0, 900.0):
        evaluate_designs(SCENE, points | {"rpm": rpm, "law": "cycloidal"})
    assert not made


NAME = st.sampled_from(["base_radius_mm", "offset_mm", "law", "law_rise", "cost", "rpm", "feasible", 3])
VALUE = st.floats(1.0, 200.0) | st.sampled_from(["cycloidal", None, "", [1.0], {}, True, 10**400, -0.0, b"x"])
ROWS = st.lists(st.dictionaries(NAME, VALUE, max_size=3), max_size=3)


@pytest.mark.filterwarnings("ignore:designs. camopt ignores")
@given(ROWS | st.dictionaries(NAME, VALUE | st.lists(VALUE, max_size=3), max_size=3) | VALUE)
@settings(max_examples=times(30, deep=2000))
def test_whatever_is_given_is_evaluated_or_refused_in_plain_words(designs):
    try:
        found = evaluate_designs(SCENE, designs)
    except BadInput as refused:
        told = str(refused)
        assert told.startswith(("designs: ", "camopt: designs: must be "))
    else:
        assert not found.isna().any(axis=None)

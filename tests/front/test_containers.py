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

from camopt import BadInput, evaluate, evaluate_designs, find_scene, load, sweep

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
    with pytest.raises(BadInput, match="designs: offset_mm: stands there twice"):
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
    with pytest.warns(UserWarning, match="designs: camopt ignores cost, machine, face_offset_mm") as told:
        found = evaluate_designs(SCENE, frame)
    assert len(told) == 1
    assert told[0].filename == __file__
    assert_frame_equal(found, evaluate_designs(SCENE, frame[NAMES]), check_exact=True)
    with pytest.raises(BadInput, match="designs: cost: no size or number of this mechanism and no law") as refused:
        evaluate_designs(SCENE, frame, strict=True)
    assert [each.key for each in refused.value.mistakes] == ["cost", "machine", "face_offset_mm"]


def test_a_table_that_says_nothing_of_designs_is_refused():
    with pytest.raises(BadInput, match=r"designs: base_radius: no size or number.*did you mean base_radius_mm"):
        evaluate_designs(SCENE, {"base_radius": [50.0], "cost": [3.0]})


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
    monkeypatch.setattr(Scene, "_fill", lambda *args: made.append(args))
    for rpm in (700.0, 811.0, 900.0):
        evaluate_designs(SCENE, points | {"rpm": rpm, "law": "cycloidal"})
    assert not made


NAME = st.sampled_from(["base_radius_mm", "offset_mm", "law", "law_rise", "cost", "rpm", "feasible", 3])
VALUE = st.floats(1.0, 200.0) | st.sampled_from(["cycloidal", None, "", [1.0], {}, True, 10**400, -0.0, b"x"])
ROWS = st.lists(st.dictionaries(NAME, VALUE, max_size=3), max_size=3)


@pytest.mark.filterwarnings("ignore:designs. camopt ignores")
@given(ROWS | st.dictionaries(NAME, VALUE | st.lists(VALUE, max_size=3), max_size=3) | VALUE)
@settings(max_examples=times(60, deep=2000))
def test_whatever_is_given_is_evaluated_or_refused_in_plain_words(designs):
    try:
        found = evaluate_designs(SCENE, designs)
    except BadInput as refused:
        told = str(refused)
        assert told.startswith(("designs: ", "camopt: designs: must be "))
    else:
        assert not found.isna().any(axis=None)

"""Designs from elsewhere: each row is what evaluate says."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import BadInput, evaluate, evaluate_designs, find_scene, shipped_scenes
from camopt.model.motion import LAWS
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.variables import variables_of_scene

SCENE = find_scene("roller-1000rpm")


MIRRORED = {"pusher-by-lever": {"pressure_angle_max_at_deg"}}
"""Where rise and return are mirror images, two peaks are equal: either angle is right."""


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [name for name in shipped_scenes() if not find_scene(name).profile])
def test_each_row_is_what_evaluate_says(name):
    """Of designs around the scene's own: every quantity to the relative error of the scene, every verdict."""
    scene = find_scene(name)
    quantities = {each.key: each.quantity for each in variables_of_scene(scene) if each.is_size}
    keys = [*quantities]
    own = {key: getattr(getattr(scene, key.split(".")[0]), key.split(".")[1]) for key in keys}
    scales = np.array([1.0, 1.03, 1.1])
    found = evaluate_designs(scene, {quantities[key]: own[key] * scales for key in keys})
    for i, scale in enumerate(scales):
        single = evaluate(scene.replace(**{key: own[key] * scale for key in keys}))
        for quantity in single.keys() - MIRRORED.get(name, set()):
            value, expected = found[quantity][i], single[quantity]
            if isinstance(expected, float) and quantity != "relative_half_width":
                assert value == pytest.approx(expected, rel=1e-8, abs=1e-9), quantity
            elif quantity != "relative_half_width":
                assert value == expected, quantity


def test_excesses_say_which_limits_are_broken():
    rng = np.random.default_rng(3)
    designs = {"base_radius_mm": rng.uniform(20, 90, 200), "roller_radius_mm": rng.uniform(2, 40, 200)}
    found = evaluate_designs(SCENE, designs)
    limits = [limit.name for limit in resolve(SCENE).limits]
    broken = [",".join(n for n in limits if row[f"excess_{n}"] > 0.0) for _, row in found.iterrows()]
    first = [text if "," not in text else text.replace(",self_crossing", "") for text in broken]
    assert first == found["violated"].tolist()
    assert (found["violated"] == "").equals(found["feasible"])
    angle = np.maximum(found["pressure_angle_max_rise_deg"], found["pressure_angle_max_dwell_deg"])
    assert np.allclose(found["excess_pressure_angle"], angle / SCENE.limits.pressure_angle - 1.0, rtol=1e-12)


def test_rows_keep_their_order_and_index_whatever_their_laws():
    names = [*LAWS, *reversed(LAWS)]
    index = pd.Index([f"design {k}" for k in range(len(names))])
    found = evaluate_designs(SCENE, pd.DataFrame({"law": names, "base_radius_mm": 70.0}, index=index))
    assert found.index.equals(index)
    assert found["law_rise"].tolist() == found["law_return"].tolist() == names
    other = evaluate_designs(SCENE, {"law_return": names[::-1], "base_radius_mm": [70.0] * len(names)})
    assert other["law_return"].tolist() == names[::-1]
    assert set(other["law_rise"]) == set(evaluate_designs(SCENE, {"base_radius_mm": [70.0]})["law_rise"])


def test_what_cannot_be_assembled_keeps_its_row():
    found = evaluate_designs(SCENE, {"offset_mm": [10.0, 200.0, -10.0], "base_radius_mm": 60.0})
    assert (found["violated"] == "assembly").tolist() == [False, True, False]
    assert found["offset_mm"].tolist() == [10.0, 200.0, -10.0]
    assert found.loc[1, "pressure_angle_max_deg"] == found.loc[1, "excess_undercut"] == np.inf
    assert not found.loc[1, ["feasible", "undercut"]].any()
    assert not found.isna().any(axis=None)


def test_no_designs_are_no_rows():
    found = evaluate_designs(SCENE, {"base_radius_mm": [], "law": []})
    assert (len(found), "feasible" in found, "excess_undercut" in found) == (0, True, True)


NAME = st.text(min_size=1, max_size=8) | st.sampled_from(
    ["base_radius_mm", "law", "offset_mm", "base_radius", "rpm", "preload_N", "overhang_mm", "inertia_kg_m2"]
)
VALUE = st.floats() | st.text(max_size=5) | st.none() | st.integers() | st.booleans() | st.sampled_from([*LAWS])


@pytest.mark.filterwarnings("ignore:designs. camopt ignores")
@given(st.dictionaries(NAME, st.lists(VALUE, min_size=2, max_size=2), max_size=3))
@settings(max_examples=times(30, deep=2000))
def test_any_table_is_evaluated_or_refused_in_plain_words(table):
    try:
        found = evaluate_designs(SCENE, table)
    except BadInput as refused:
        told = str(refused).splitlines()
    else:
        told = []
        assert len(found) == (2 if table else 0)
        assert not found.isna().any(axis=None)
    assert all(line.startswith("designs: ") for line in told)


MISTAKES = {
    "base_radius": (
        [50.0],
        "designs: base_radius: this mechanism has no such size, number or law; did you mean base_radius_mm?",
    ),
    "face_offset_mm": ([1.0], "designs: face_offset_mm: this mechanism has no such size, number or law"),
    "base_radius_mm": ([50.0, np.nan], "designs: base_radius_mm[1] = nan: must be a finite number"),
    "roller_radius_mm": ([5.0, -1.0], "designs: roller_radius_mm[1] = -1.0: must be at least 1e-09"),
    "offset_mm": (["far"], "designs: offset_mm[0] = 'far': must be a number"),
    "law": (["cyclodal"], "designs: law[0] = 'cyclodal': must be a motion law; did you mean cycloidal?"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_names_the_column_and_the_row(name):
    values, text = MISTAKES[name]
    with pytest.raises(BadInput) as refused:
        evaluate_designs(SCENE, {name: values})
    assert str(refused.value).startswith(text)


NO_TABLES = {
    "columns of equal length; offset_mm has 1, base_radius_mm has 2": {
        "offset_mm": [1],
        "base_radius_mm": [60, 70],
    },
    "columns with one value per row; offset_mm has more": {"offset_mm": [[1.0, 2.0]], "base_radius_mm": 60.0},
    "columns with one value per row; base_radius_mm has more": {"base_radius_mm": [[1.0, 2.0], [3.0]]},
    "a table of pandas, polars or pyarrow, a mapping of columns, a list of mappings, or an array with names=": 7,
    "a table of pandas, polars or pyarrow, a mapping of columns": [60.0, 70.0],
}


@pytest.mark.parametrize("told", NO_TABLES)
def test_what_is_no_table_is_refused(told):
    with pytest.raises(BadInput, match=f"camopt: designs: must be {told}"):
        evaluate_designs(SCENE, NO_TABLES[told])


def test_a_column_stands_there_once():
    with pytest.raises(BadInput, match="offset_mm: occurs twice"):
        evaluate_designs(SCENE, pd.DataFrame([[1.0, 2.0]], columns=["offset_mm", "offset_mm"]))


def test_a_law_is_given_once():
    with pytest.raises(BadInput, match="must stand alone"):
        evaluate_designs(SCENE, {"law": ["cycloidal"], "law_rise": ["harmonic"]})


def test_a_size_that_nobody_gives_is_missing():
    scene = SCENE.replace(**{"cam.base_radius": None, "search.base_radius": [50, 60]})
    with pytest.raises(BadInput, match=r"cam.base_radius: missing"):
        evaluate_designs(scene, {"offset_mm": [3.0]})
    assert len(evaluate_designs(scene, {"base_radius_mm": [50.0, 60.0]})) == 2


def test_a_searched_number_that_the_table_lacks_is_that_of_the_scene():
    scene = find_scene("roller-1000rpm")
    searched = scene.replace(**{"search.cam.rpm": [300, 2000]})
    sizes = {"base_radius_mm": [60.0, 90.0]}
    found, expected = (evaluate_designs(each, sizes)["acceleration_max_m_s2"] for each in (searched, scene))
    assert found.tolist() == expected.tolist()

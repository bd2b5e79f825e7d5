"""A sweep in memory has the rows that one with a folder writes."""

import pandas as pd
import pytest
from pandas.testing import assert_frame_equal

from camopt import BadInput, UnknownName, find_scene, load, merge, report, scene_of, sweep, sweep_part

SCENE = find_scene("roller-1000rpm").replace(
    search={
        "base_radius": {"start": 57.3, "stop": 121, "step": 5.7},
        "offset": [-7.1, 0, 11.3],
        "law": ["poly345"],
    },
)
REFINED = SCENE.replace(**{"search.refine": True, "search.minimise": ["base_radius_mm", "acceleration_max_m_s2"]})
NONE_FEASIBLE = SCENE.replace(**{"limits.pressure_angle": 3})


@pytest.mark.parametrize("keep", ["feasible", "all", "pareto"])
@pytest.mark.parametrize("scene", [SCENE, REFINED, NONE_FEASIBLE], ids=["grid", "refined", "none feasible"])
def test_rows_in_memory_are_those_of_the_files(scene, keep, tmp_path):
    written, kept = sweep(scene, tmp_path, keep=keep), sweep(scene, keep=keep, block=7)
    names = [path.stem for path in written.files if path.suffix == ".parquet"]
    assert {*names} == {"pareto", "designs", *(["pareto-grid"] if scene.search.refine else [])}
    for name in names:
        frame = load(tmp_path / f"{name}.parquet")
        for found in (
            written.to_pandas(name),
            kept.to_pandas(name),
            sweep(scene, tmp_path, keep=keep).to_pandas(name),
        ):
            assert_frame_equal(found, frame, check_exact=True)
            assert found.attrs == frame.attrs
    assert_frame_equal(kept.to_pandas(), load(tmp_path / "pareto.parquet"), check_exact=True)
    assert (len(kept.to_pandas()), kept.designs) == (kept.pareto, written.designs)


def test_a_sweep_in_memory_keeps_the_front_alone_unless_told():
    swept = sweep(SCENE)
    assert len(swept.to_pandas("pareto")) == swept.pareto > 1
    with pytest.raises(BadInput, match="sweep: pareto; a sweep without out keeps designs if keep names them"):
        swept.to_pandas("designs")
    with pytest.raises(BadInput, match="'designs': must be a table of this sweep: pareto; a sweep"):
        sweep(SCENE, keep="front-only").to_pandas("designs")
    assert sweep(SCENE, keep="all").to_pandas("by_law").index.tolist() == [*swept.best]


def test_a_wrong_name_lists_the_tables_of_a_sweep(tmp_path):
    for swept in (sweep(SCENE, keep="all"), sweep(SCENE, tmp_path)):
        for wrong in ("desings", 3):
            with pytest.raises(UnknownName, match=r"has no rows named .*: designs, pareto,.* by_law"):
                swept.to_pandas(wrong)


def test_merged_parts_have_rows(tmp_path):
    for part in (1, 2):
        sweep_part(SCENE, (part, 2), out=tmp_path / f"part-{part}")
    merged = merge([tmp_path / "part-1", tmp_path / "part-2"], tmp_path / "whole")
    for name in ("pareto", "designs"):
        assert_frame_equal(merged.to_pandas(name), sweep(SCENE, keep="feasible").to_pandas(name), check_exact=True)


@pytest.mark.parametrize("name", ["pareto", "designs", None])
@pytest.mark.parametrize("changes", [{"limits.pressure_angle": 25}, {"search.offset": [0]}, {"cam.rpm": 900}])
def test_a_sweep_refuses_the_rows_of_a_later_one_in_its_folder(changes, name, tmp_path):
    first = sweep(SCENE, tmp_path)
    later = sweep(SCENE.replace(**changes), tmp_path)
    with pytest.raises(BadInput, match="has another result now"):
        first.to_pandas(name)
    with pytest.raises(BadInput, match="has another result now"):
        report(first, tmp_path / "page.html")
    assert_frame_equal(later.to_pandas(name), sweep(SCENE.replace(**changes), keep="feasible").to_pandas(name))
    again = sweep(SCENE, tmp_path)
    assert_frame_equal(first.to_pandas(name), again.to_pandas(name), check_exact=True)
    (tmp_path / "manifest.json").unlink()
    assert_frame_equal(first.to_pandas(name), again.to_pandas(name), check_exact=True)


def test_a_row_is_a_scene():
    front = sweep(SCENE).to_pandas()
    least = front["base_radius_mm"].idxmin()
    assert scene_of(front, least).cam.base_radius == front.loc[least, "base_radius_mm"]
    assert isinstance(front, pd.DataFrame)
    assert front.attrs["units"]["base_radius_mm"] == "mm"

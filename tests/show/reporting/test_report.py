"""The page: what is in it, what is refused, and that names stay text."""

import html
import json
import re
import zlib
from base64 import b64decode

import numpy as np
import pytest

import camopt
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve_design
from camopt.show.reporting.report import MOST_PAGE_CAMS

HOSTILE = "</script><script>alert(1)</script> \"quotes\" 'and' <b>&amp;</b> ünï \u2028"


def data_of(page):
    """The data of the program of a page."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(encoding="utf-8"))
    return json.loads(found[1])


def inflate_text(text):
    return zlib.decompress(b64decode(text))


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """The folder of a small sweep of two laws."""
    folder = tmp_path_factory.mktemp("swept")
    search = {
        "base_radius": {"start": 40, "stop": 80, "step": 5},
        "offset": [0, 10],
        "law": ["cycloidal", "harmonic"],
    }
    scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    scene = scene.replace(**{"search.minimise": ["base_radius_mm", "acceleration_max_m_s2"]})
    return camopt.sweep(scene, out=folder), folder


@pytest.fixture
def without_files(monkeypatch):
    """Pages without files for machines, which take most of the time."""
    monkeypatch.setattr("camopt.show.reporting.cams.cam_downloads_and_missing_reason", lambda scene, stem: ([], ""))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["two-pauses", "feeder-with-stop", "bucket-valve", "knife-900rpm-offset"])
def test_a_page_needs_nothing_from_elsewhere(name, tmp_path):
    page = camopt.report(name, tmp_path / "cam.html")
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:)', text)
    assert "default-src 'none'" in text
    assert page.stat().st_size < 6e6
    (cam,) = data_of(page)["cams"]
    lengths = {len(piece["angle"]) for piece in cam["motion"]["pieces"]}
    assert len(lengths) >= 1
    for panel in cam["panels"]:
        assert [len(v) for v in panel["values"]] == [len(p["angle"]) for p in cam["motion"]["pieces"]], panel[
            "title"
        ]


def test_the_motion_of_a_page_is_that_of_the_scene(tmp_path):
    scene = camopt.find_scene("two-pauses")
    (cam,) = data_of(camopt.report(scene, tmp_path / "cam.html"))["cams"]
    rise = cam["motion"]["pieces"][0]
    angle = np.array(rise["angle"]) / 120.0  # harmonic rise of 40 mm in 120°
    np.testing.assert_allclose(rise["y"], 20.0 * (1.0 - np.cos(np.pi * angle)), atol=1e-5)
    np.testing.assert_allclose(rise["slope"], 30.0 * np.sin(np.pi * angle), atol=1e-5)


def test_names_stay_text(tmp_path):
    scene = camopt.find_scene("two-pauses").replace(name=HOSTILE.replace("\u2028", ""))
    text = camopt.report([scene, scene], tmp_path / "cam.html").read_text(encoding="utf-8")
    assert text.count("<script") == 2
    assert "<b>" not in text
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in text


def test_the_same_result_gives_the_same_page(tmp_path):
    one, other = (camopt.report("two-pauses", tmp_path / f"{k}.html").read_bytes() for k in "ab")
    assert one == other


def test_a_cam_that_cannot_be_made_has_no_files_for_machines(tmp_path):
    scene = camopt.find_scene("roller-1000rpm")
    scene = scene.replace(**{"cam.base_radius": 5, "follower.roller_radius": 60, "follower.offset": 10})
    text = camopt.report(scene, tmp_path / "cam.html").read_text(encoding="utf-8")
    assert 'download="1000-rpm-roller-cam.toml"' in text
    assert "image/vnd.dxf" not in text
    assert "No files for machines" in text


@pytest.mark.slow
def test_a_page_has_what_tolerances_do_of_a_scene_that_has_them(tmp_path, without_files):
    scene = camopt.find_scene("rocker-valve")
    camopt.report(scene, tmp_path / "plain.html")
    assert "errors of the motion" not in (tmp_path / "plain.html").read_text(encoding="utf-8")
    real = scene.replace(**{"tolerances.follower.arm_length": 0.05})
    camopt.report(real, tmp_path / "real.html")
    page = (tmp_path / "real.html").read_text(encoding="utf-8")
    told = ("errors of the motion", "proven upper bound", "arm_length 30.05 mm", "1,024 cams drawn")
    assert all(text in page for text in (*told, '<img src="data:image/png;base64,'))


def test_the_rows_of_a_sweep_are_those_of_its_tables(swept, tmp_path):
    result, folder = swept
    page = data_of(camopt.report(folder, tmp_path / "sweep.html"))
    table = camopt.load(folder / "designs.parquet")
    assert page["count"] == len(table) == result.feasible
    columns = {column["name"]: column for column in page["columns"]}
    planes = np.frombuffer(inflate_text(columns["base_radius_mm"]["packed"]), dtype=np.uint8).reshape(4, -1)
    sizes = np.ascontiguousarray(planes.T).view("<f4")[:, 0]
    np.testing.assert_allclose(sorted(sizes), sorted(table.base_radius_mm), rtol=1e-6)
    front = columns["front"]
    codes = np.frombuffer(inflate_text(front["packed"]), dtype="<u2")
    assert np.sum(codes == front["words"].index("yes")) == result.pareto
    motions = json.loads(inflate_text(page["motions"]))
    assert len([motion for motion in motions if motion]) == 2
    places = np.frombuffer(inflate_text(page["motion_of"]), dtype="<u2")
    assert len(places) == page["count"]


def test_rows_of_other_trains_have_motions_of_their_own(tmp_path):
    scene = camopt.find_scene("press-ram-by-four-bar").replace(**{"search.base_radius": [70, 80]})
    camopt.sweep(scene, tmp_path / "swept", keep="all")
    page = data_of(camopt.report(tmp_path / "swept", tmp_path / "sweep.html"))
    motions = [motion for motion in json.loads(inflate_text(page["motions"])) if motion]
    table = camopt.load(tmp_path / "swept" / "designs.parquet")
    scenes = [camopt.scene_of(table, row) for row in table.index]
    lifts = {resolve_design(each).programme.lift for each in scenes}
    assert len(motions) == len(lifts) == 4
    assert sorted(motion["motion"]["lift"] for motion in motions) == pytest.approx(sorted(lifts), rel=1e-7)
    assert all(len(motion["train"]["members"]) == 6 for motion in motions)


def test_a_sweep_of_too_many_rows_is_thinned_and_says_so(swept, tmp_path, monkeypatch):
    monkeypatch.setattr("camopt.show.reporting.results.PAGE_ROWS", 6)
    page = camopt.report(swept[1], tmp_path / "sweep.html")
    assert data_of(page)["count"] <= 6
    assert "evenly spaced, and all of the Pareto front" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("what", "told"),
    [
        (["two-pauses"] * (MOST_PAGE_CAMS + 1), "at most 4 cams"),
        ([], "either cams or tables"),
        (3.5, "a result of camopt"),
        ("no-such-scene", "no-such-scene"),
    ],
)
def test_what_no_page_shows_is_refused(what, told, tmp_path):
    with pytest.raises(camopt.BadInput, match=told):
        camopt.report(what, tmp_path / "page.html")
    assert not list(tmp_path.iterdir())


def test_cams_and_tables_are_not_mixed(swept, tmp_path):
    with pytest.raises(camopt.BadInput, match="not both"):
        camopt.report(["two-pauses", swept[1]], tmp_path / "page.html")


def test_a_table_without_a_design_is_refused_and_one_design_is_a_cam(tmp_path):
    scene = camopt.find_scene("roller-1000rpm")
    none = scene.replace(search={"base_radius": [20, 30], "law": ["cycloidal"]})
    camopt.sweep(none, out=tmp_path / "none")
    with pytest.raises(camopt.BadInput, match="a table with at least one design"):
        camopt.report(tmp_path / "none", tmp_path / "page.html")
    camopt.sweep(scene.replace(search={"base_radius": [140], "law": ["cycloidal"]}), out=tmp_path / "one")
    (cam,) = data_of(camopt.report(tmp_path / "one", tmp_path / "page.html"))["cams"]
    assert cam["sizes"]["size"] == 140.0


@pytest.mark.parametrize("keep", [None, "feasible", "all"])
def test_a_sweep_in_memory_has_the_page_of_its_folder(swept, keep, tmp_path):
    scene = swept[0].scene.replace(**{"search.minimise": ["base_radius_mm", "pressure_angle_max_deg"]})
    kept = camopt.sweep(scene, keep=keep)
    found = data_of(camopt.report(kept, tmp_path / "page.html"))
    assert found["count"] == len(kept.to_pandas("designs" if keep else None))
    if keep:
        written = camopt.sweep(scene, tmp_path / scene.name, keep=keep)
        assert found == data_of(camopt.report(written, tmp_path / "files.html"))


def test_a_sweep_in_memory_of_one_design_is_a_cam_and_of_none_is_refused(tmp_path):
    scene = camopt.find_scene("roller-1000rpm")
    one = camopt.sweep(scene.replace(search={"base_radius": [140], "law": ["cycloidal"]}))
    pages = [camopt.report(what, tmp_path / "page.html") for what in (one, [one])]
    assert [data_of(page)["cams"][0]["sizes"]["size"] for page in pages] == [140.0, 140.0]
    none = camopt.sweep(scene.replace(search={"base_radius": [20, 30], "law": ["cycloidal"]}))
    with pytest.raises(camopt.BadInput, match=r"table = '1000 rpm roller cam': .* no design was feasible"):
        camopt.report(none, tmp_path / "none.html")


def test_a_table_says_which_designs_are_not_feasible(tmp_path):
    scene = camopt.find_scene("roller-1000rpm").replace(
        search={"base_radius": [30, 120, 140], "law": ["cycloidal"]}
    )
    camopt.sweep(scene, out=tmp_path / "all", keep="all")
    page = camopt.report(tmp_path / "all", tmp_path / "page.html")
    columns = {column["name"]: column for column in data_of(page)["columns"]}
    assert columns["feasible"]["words"] == ["no", "yes"]
    assert "pressure_angle" in columns["violated"]["words"][-1]
    assert "of those here feasible" in page.read_text(encoding="utf-8")


def test_the_headline_names_what_the_table_says_is_broken(tmp_path):
    scene = camopt.find_scene("roller-1000rpm").replace(**{"cam.base_radius": 25})
    text = camopt.report(scene, tmp_path / "page.html").read_text(encoding="utf-8")
    broken = [name for name, verdict in camopt.certify(scene).items() if verdict == "broken"]
    assert f"Not feasible: {', '.join(broken).replace('_', ' ')}." in text


def test_a_folder_without_a_result_is_refused(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(camopt.BadInput, match=r"pareto\.parquet"):
        camopt.report(tmp_path / "empty", tmp_path / "page.html")


def test_cams_of_one_name_are_told_apart_by_their_laws(tmp_path, without_files):
    scene = camopt.find_scene("two-pauses")
    harmonic, cycloidal = (scene.replace(**{"motion.3.law": law}) for law in ("harmonic", "cycloidal"))
    told = ((harmonic, cycloidal), (", harmonic", ", harmonic / cycloidal")), ((harmonic,) * 2, (" (1)", " (2)"))
    for pair, ends in told:
        text = camopt.report([*pair], tmp_path / "page.html").read_text(encoding="utf-8")
        assert all(f"{scene.name}{end}" in text for end in ends)


@pytest.mark.slow
def test_new_laws_stand_beside_the_best_known_law(tmp_path, without_files):
    """From the folder that ``synthesise`` writes: both cams, and how far from the bound the new one is."""
    folder = tmp_path / "new"
    assert main(["synthesise", "two-pauses", "--max-pressure", "30", "--out", str(folder), "--quiet"]) == 0
    page = camopt.report(folder, tmp_path / "page.html")
    text = page.read_text(encoding="utf-8")
    summary = json.loads((folder / "synthesis.json").read_text(encoding="utf-8"))
    assert summary["told"] in text
    assert summary["gap"] == pytest.approx(1.0 - summary["bound"] / summary["objective"])
    before, after = data_of(page)["cams"]
    assert after["sizes"]["size"] < before["sizes"]["size"]
    (folder / "synthesis.json").write_text("{")
    with pytest.raises(camopt.BadInput, match=r"synthesis\.json"):
        camopt.report(folder, tmp_path / "other.html")


def test_the_command_writes_a_page_or_nothing(tmp_path, capsys):
    page = tmp_path / "cam.html"
    assert main(["report", "two-pauses", "--rpm", "60", "--outputs", "section", "--out", str(page)]) == 0
    assert "60 rev/min" in page.read_text(encoding="utf-8")
    assert "area_mm2" in page.read_text(encoding="utf-8")
    assert main(["report", "no-such", "--out", str(tmp_path / "none.html")]) == 2
    assert main(["report", str(tmp_path), "--rpm", "60", "--out", str(tmp_path / "none.html")]) == 2
    assert "needs a scene" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["cam.html"]


@pytest.mark.slow
def test_of_many_laws_the_smallest_cams_are_shown(tmp_path, without_files):
    """As many as fit, from the result and from its folder alike, and how many there are."""
    laws = ["cycloidal", "harmonic", "poly345", "modified-sine", "parabolic", "poly4567"]
    scene = camopt.find_scene("roller-1000rpm").replace(**{"search.law": laws})
    assert main(["optimise", _write_scene(scene, tmp_path), "--out", str(tmp_path / "best"), "--quiet"]) == 0
    pages = [camopt.report(what, tmp_path / "page.html") for what in (tmp_path / "best", camopt.optimise(scene))]
    for page in pages:
        sizes = [cam["sizes"]["size"] for cam in data_of(page)["cams"]]
        assert sizes == sorted(sizes)
        assert len(sizes) == MOST_PAGE_CAMS
        assert f"The 4 smallest of {len(laws)} cams" in page.read_text(encoding="utf-8")


def _write_scene(scene, folder):
    path = folder / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8")
    return str(path)


@pytest.mark.slow
@pytest.mark.parametrize("study", [camopt.timing, camopt.harmonics, camopt.tolerance, camopt.certify])
def test_a_page_shows_any_result_of_a_scene(study, tmp_path):
    scene = camopt.find_scene("two-pauses").replace(tolerances={"profile": 0.01})
    found = study(scene)
    page = camopt.report(found, tmp_path / "page.html").read_text(encoding="utf-8")
    texts = {cell.text for table in found.tables() for row in table.rows for cell in row}
    assert texts
    assert all(html.escape(text) in page for text in texts)

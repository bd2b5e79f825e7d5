"""What results show of themselves: a line of text, a table with units and limits; names that are nearly right."""

import dataclasses
import os
import pickle
import re
import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

import camopt
from camopt import Design, cam_points, evaluate, find_scene, optimise, shipped_scenes, sweep
from camopt.cli.terminal import print_sections
from camopt.show.drawing.notebook import cam_profile_svg
from camopt.solve.tables.html import HTML_ROWS

SVG = "{http://www.w3.org/2000/svg}"

NAME = "a < b & c"
SCENE = find_scene("two-pauses").replace(name=NAME, search={"base_radius": [60, 70]}, limits={"pressure_angle": 30})


class Tags(HTMLParser):
    """The texts of a page, and whether each tag is closed."""

    def __init__(self, page):
        super().__init__()
        self.open, self.texts = [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.open += [tag] if tag != "br" else []

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def results():
    best, swept = optimise(SCENE), sweep(SCENE)
    angles = np.arange(0.0, 360.0, 10.0)
    lifts = np.column_stack([angles, 5 * (1 - np.cos(np.radians(angles)))])
    flat = {"motion": "translating", "contact": "flat"}
    trade = {"size": best.best["base_radius_mm"], "acceleration": 3.0, "bound": None}
    rows = [Design({**best.best, **trade, "base_radius_mm": 60.0 + k}, SCENE) for k in range(45)]
    return {
        "Scene": SCENE,
        "Evaluation": evaluate(SCENE),
        "Optimum": best,
        "Design": best.best,
        "Sweep": swept,
        "Synthesis": camopt.Synthesis(SCENE, best.best.scene, best.best, 60.0, 59.0),
        "Frontier": camopt.Frontier(SCENE, ("size", "acceleration"), rows, [], {}),
        "Fit": camopt.fit(lifts, {"name": NAME, "cam": {"form": "disc", "base_radius": 30.0}, "follower": flat}),
    }


BOUNDED = ("Evaluation", "Optimum", "Design", "Sweep", "Synthesis")


@pytest.mark.parametrize("kind", [*BOUNDED, "Scene", "Frontier", "Fit"])
def test_results_show_themselves_in_a_line_and_as_html(results, kind):
    shown = repr(results[kind])
    assert shown.startswith(f"<{kind} ")
    assert NAME in shown
    assert len(shown) < 160
    page = Tags(results[kind]._repr_html_())
    assert not page.open
    assert any(NAME in text for text in page.texts)
    if kind != "Scene":
        assert "mm" in page.texts
    if kind in BOUNDED:
        assert {"≤ 30", "deg"} <= {*page.texts}


@pytest.mark.parametrize("kind", [*BOUNDED, "Frontier", "Fit"])
def test_a_notebook_shows_the_table_that_a_terminal_prints(results, kind, capsys):
    table = results[kind].table()
    page, rows = Tags(results[kind]._repr_html_()), table.rows[:HTML_ROWS]
    assert {cell.text for row in rows for cell in row} <= {"", *page.texts}
    assert {line for head in table.heads for line in head.text.split("\n")} <= {"", " ", *page.texts}
    print_sections(table)
    printed = capsys.readouterr().out
    assert all(word in printed for row in table.rows for cell in row for word in cell.text.split())


def test_a_result_without_rows_says_so_in_a_line(results, tmp_path):
    part = camopt.sweep_part(SCENE, (1, 2), out=tmp_path)
    none = dataclasses.replace(results["Optimum"], best=None, by_law={})
    for result in (part, none):
        assert result.table() is None
        assert Tags(result._repr_html_()).texts == [repr(result)[1:-1], *result.sections()]


def test_a_long_result_is_cut_with_a_line_that_says_so(results):
    page = Tags(results["Frontier"]._repr_html_())
    assert "… and 5 more rows" in page.texts
    assert {"99", "100"} & {*page.texts} == {"99"}


def test_an_exported_file_shows_its_curves(tmp_path):
    page = Tags(camopt.export(SCENE.replace(name=NAME), tmp_path / "a&b.dxf")._repr_html_())
    assert not page.open
    assert f"Export to {tmp_path / 'a&b.dxf'}" in page.texts
    assert any(" arcs, within " in text and text.endswith(" mm (proved)") for text in page.texts)


@pytest.mark.parametrize("kind", ["Scene", "Evaluation", "Optimum", "Design", "Synthesis", "Fit"])
def test_a_design_has_a_small_picture_of_its_cam(results, kind):
    page = results[kind]._repr_html_()
    (svg,) = re.findall(r"<svg.*</svg>", page)
    assert len(page) < 30_000
    drawn = ElementTree.fromstring(svg)
    found = results[kind]
    scene = found.best.scene if kind == "Optimum" else getattr(found, "scene", found)
    radius = scene.cam.base_radius
    (words,) = [text.text for text in drawn.iter(f"{SVG}text")]
    assert words == f"base radius {radius:.4g} mm"


def pixels(svg):
    """The points of each line of a picture as complex numbers, y downwards."""
    paths = [path.get("d")[1:].split("L") for path in ElementTree.fromstring(svg).iter(f"{SVG}path")]
    return [np.array([complex(*map(float, place.split(","))) for place in path]) for path in paths]


def test_the_small_picture_is_the_profile_to_scale():
    """The base circle and every point of the profile, from the points that a machine gets."""
    scene = find_scene("two-pauses")
    body, circle, *_ = pixels(cam_profile_svg(scene))
    scale = np.ptp(circle.real) / (2 * scene.cam.base_radius)
    assert np.ptp(circle.imag) == pytest.approx(np.ptp(circle.real), abs=0.2)
    centre = complex(circle.real.min() + np.ptp(circle.real) / 2, circle.imag.min() + np.ptp(circle.imag) / 2)
    points = cam_points(scene, step=0.25)
    exact = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    shown = ((body - centre) / scale).conj()
    distances = np.abs(shown[:, None] - exact[None]).min(axis=1)
    assert distances.max() < 0.2 / scale + 0.25  # half a step of the points, and a tenth of a pixel twice


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_cam_has_a_small_picture(name):
    assert all(np.isfinite(line).all() for line in pixels(cam_profile_svg(find_scene(name))))


def test_a_design_that_no_scene_has_is_shown_without_a_picture(results):
    odd = Design({**results["Design"], "base_radius_mm": -1.0}, SCENE)
    page = odd._repr_html_()
    assert "<svg" not in page
    assert "−1" in page or "-1" in page


@pytest.mark.slow
def test_a_picture_of_a_cam_needs_no_matplotlib():
    code = "import camopt, sys; camopt.evaluate(camopt.find_scene('two-pauses'))._repr_html_()"
    code += "; assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "NUMBA_DISABLE_JIT": "1"})


def test_designs_travel_between_processes(results):
    design = pickle.loads(pickle.dumps(results["Design"]))
    assert design == results["Design"]
    assert design.scene == results["Design"].scene


@pytest.mark.parametrize("kind", ["Evaluation", "Design"])
def test_a_name_that_is_nearly_right_is_answered_by_the_nearest(results, kind):
    found = results[kind]
    assert "presure_angle_max_deg" not in found
    assert found.get("presure_angle_max_deg") is None
    with pytest.raises(KeyError, match="did you mean pressure_angle_max_deg"):
        found["presure_angle_max_deg"]


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("presure", "pressure_angle_max_deg or pressure_angle_max_rise_deg or pressure_angle_max_return_deg?"),
        ("radius", "base_radius_mm or roller_radius_mm or prime_radius_mm?"),
        ("base_radius", "base_radius_mm?"),
    ],
)
def test_a_part_of_a_name_is_answered_by_the_names_that_have_it(word, meant, results):
    with pytest.raises(camopt.UnknownName, match=re.escape(f"did you mean {meant}")):
        results["Evaluation"][word]


def test_a_law_that_is_nearly_right_is_answered_by_the_nearest(results):
    found = results["Optimum"].by_law
    (law,) = found
    with pytest.raises(camopt.UnknownName, match=f"did you mean {law}"):
        found[law[:-1]]
    assert pickle.loads(pickle.dumps(found)) == found


@pytest.mark.slow
def test_a_figure_is_shown_once_whether_pyplot_is_at_work_or_not():
    """Of a cell whose last line draws: one image."""
    draw = "import camopt; camopt.plot([camopt.response_spectrum('cycloidal', [1.0, 2.0], 0.1)])"
    cells = [draw, "%matplotlib inline\n" + draw]
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    NotebookClient(book, timeout=120, kernel_name="python3").execute()
    shown = [[output for output in cell.outputs if "image/png" in output.get("data", {})] for cell in book.cells]
    assert [len(images) for images in shown] == [1, 1]

"""What results show of themselves: a line of text, a table with units and limits; names that are nearly right."""

import os
import pickle
import re
import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from camopt import Design, cam_points, evaluate, find_scene, optimise, shipped_scenes, sweep
from camopt.drawing.small import small_cam

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
    return {"Scene": SCENE, "Evaluation": evaluate(SCENE), "Optimum": best, "Design": best.best, "Sweep": swept}


@pytest.mark.parametrize("kind", ["Scene", "Evaluation", "Optimum", "Design", "Sweep"])
def test_results_show_themselves_in_a_line_and_as_html(results, kind):
    shown = repr(results[kind])
    assert shown.startswith(f"<{kind} ")
    assert NAME in shown
    assert len(shown) < 160
    page = Tags(results[kind]._repr_html_())
    assert not page.open
    assert any(NAME in text for text in page.texts)
    if kind != "Scene":
        assert {"≤ 30", "deg", "mm"} <= {*page.texts}


@pytest.mark.parametrize("kind", ["Evaluation", "Optimum", "Design"])
def test_a_design_has_a_small_picture_of_its_cam(results, kind):
    page = results[kind]._repr_html_()
    (svg,) = re.findall(r"<svg.*</svg>", page)
    assert len(page) < 30_000
    drawn = ElementTree.fromstring(svg)
    radius = (results[kind].best if kind == "Optimum" else results[kind])["base_radius_mm"]
    (words,) = [text.text for text in drawn.iter(f"{SVG}text")]
    assert words == f"base radius {radius:.4g} mm"


def pixels(svg):
    """The points of each line of a picture as complex numbers, y downwards."""
    paths = [path.get("d")[1:].split("L") for path in ElementTree.fromstring(svg).iter(f"{SVG}path")]
    return [np.array([complex(*map(float, place.split(","))) for place in path]) for path in paths]


def test_the_small_picture_is_the_profile_to_scale():
    """The base circle and every point of the profile, from the points that a machine gets."""
    scene = find_scene("two-pauses")
    body, circle, *_ = pixels(small_cam(scene))
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
    assert all(np.isfinite(line).all() for line in pixels(small_cam(find_scene(name))))


def test_a_design_that_no_scene_has_is_shown_without_a_picture(results):
    odd = Design({**results["Design"], "base_radius_mm": -1.0}, SCENE)
    page = odd._repr_html_()
    assert "<svg" not in page
    assert "−1" in page or "-1" in page


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

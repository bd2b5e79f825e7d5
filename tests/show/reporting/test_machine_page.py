"""The page of a machine: one cursor, which all stations follow; and the page without scripts."""

import json
import re
from base64 import b64decode
from xml.etree import ElementTree

import numpy as np
import pytest
from support.browser import box_of, drag, open_page, running_browser, watched_page
from support.drawn_machines import random_machine

import camopt
from camopt.scene.problem.problem import resolve_design
from camopt.show.reporting.machine import SHAFT_ANGLES, machine_page
from camopt.show.reporting.report import page_items
from camopt.solve.machine.stations import resolve_stations


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """The page of the shipped machine."""
    return camopt.report("pick-and-place", tmp_path_factory.mktemp("pages") / "unit.html")


def data_of(html):
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.DOTALL)[1]
    return json.loads(text)


@pytest.mark.slow
def test_one_cursor_and_a_group_and_a_section_per_station(unit):
    html, machine = unit.read_text(encoding="utf-8"), camopt.find_machine("pick-and-place")
    names = [station.name for station in machine.station]
    assert html.count('class="cursor"') == html.count('type="range"') == 1
    assert re.findall(r'data-station="(.*?)"', html) == names
    assert re.findall(r'<details class="station" id="station-(\d)"', html) == ["1", "2", "3", "4"]
    for table in camopt.evaluate_machine(machine).tables():
        assert table.title in html
    assert not re.search(r'(src|href)="(?!data:|#)', html)
    (picture,) = re.findall(r'src="data:image/svg\+xml;base64,(.*?)"', html)
    root = ElementTree.fromstring(b64decode(picture))
    assert not [each for each in root.iter() if each.tag.endswith("}text")]  # no font is needed


def test_data_are_the_lifts_and_the_motion_of_the_tools(unit):
    data = data_of(unit.read_text(encoding="utf-8"))
    machine = camopt.find_machine("pick-and-place")
    for station, record in zip(resolve_stations(machine), data["timing"]["stations"], strict=True):
        lift = station.lift.value(SHAFT_ANGLES)
        np.testing.assert_allclose(record["lift"], lift, rtol=1e-7, atol=1e-7)
        assert record["largest"] == pytest.approx(lift.max())
        assert record["high"] < record["low"]
    lift, feed, stop = data["tools"]["tools"]
    np.testing.assert_allclose(lift["y"], data["timing"]["stations"][0]["lift"], atol=1e-6)
    np.testing.assert_allclose(feed["x"], data["timing"]["stations"][3]["lift"], atol=1e-6)
    assert {*stop["x"], *stop["y"]} == {0.0}
    assert [(cam["shift"], cam["ratio"]) for cam in data["cams"]] == [
        (each.phase, each.ratio) for each in machine.station
    ]


def test_inches(unit, monkeypatch):
    for picture in ("still_machine_image_url", "timing_diagram_image_url"):
        monkeypatch.setattr(f"camopt.show.reporting.machine.{picture}", lambda _: "")
    with camopt.shown_in("inch"):
        (result,) = page_items("pick-and-place")
        data = data_of(machine_page(result))
    first = data_of(unit.read_text(encoding="utf-8"))["timing"]["stations"][0]
    assert data["timing"]["stations"][0]["unit"] == "in"
    assert data["timing"]["stations"][0]["largest"] == pytest.approx(first["largest"] / 25.4)


@pytest.mark.slow
def test_a_machine_is_alone_on_its_page(tmp_path):
    for what, options in ((["pick-and-place", "two-pauses"], {}), ("pick-and-place", {"align_noses": True})):
        with pytest.raises(camopt.BadInput, match="one machine by itself"):
            camopt.report(what, tmp_path / "page.html", **options)


@pytest.mark.slow
def test_the_cursor_moves_all_stations_and_the_pointer_moves_the_cursor(tmp_path):
    machine = random_machine(3, 4)
    path = camopt.report(machine, tmp_path / "page.html")
    with running_browser() as browser, watched_page(browser, viewport={"width": 1280, "height": 1000}) as page:
        open_page(page, path)
        for angle in (0.0, 123.4, 360.0):
            page.evaluate(f"camopt.player.go({angle})")
            texts = page.locator("#timing .station text").all_text_contents()
            groups = page.locator("g.body").all()
            turns = [float(re.findall(r"-?[\d.]+", group.get_attribute("transform"))[0]) for group in groups]
            for station, text, turn in zip(machine.station, texts, turns, strict=True):
                scene = machine.scenes[station.name]
                cam = (angle - station.phase) * station.ratio % 360.0
                programme = resolve_design(scene).programme.tool
                lift = float(programme.motion_at(np.radians([cam]), 0)[0, 0]) / programme.unit_in_mm_or_rad
                assert float(text.split()[0].replace("−", "-")) == pytest.approx(lift, rel=1e-3, abs=1e-2)
                if scene.cam.form == "disc":
                    sense = 1.0 if scene.cam.rotation == "ccw" else -1.0
                    assert (turn - sense * cam + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1e-6)
        box = box_of(page, "#timing svg")
        left, right = (data_of(path.read_text(encoding="utf-8"))["timing"][end] for end in ("left", "right"))
        width = page.locator("#timing svg").get_attribute("viewBox").split()[2]
        x = box["x"] + box["width"] * (left + 0.25 * (right - left)) / float(width)
        y = box["y"] + box["height"] / 2
        drag(page, (x - 40, y), (x, y))
        assert page.evaluate("camopt.player.angle") == pytest.approx(90.0, abs=0.5)
        assert page.locator("#timing .angle").text_content() == page.locator("#player output").text_content()


@pytest.mark.slow
def test_without_scripts_the_page_has_still_pictures(unit):
    with running_browser() as browser, watched_page(browser, java_script_enabled=False) as page:
        page.goto(unit.as_uri())
        for picture in page.locator("img").all():
            picture.scroll_into_view_if_needed()
            assert picture.bounding_box()["width"] > 600
        assert page.locator("img").count() == 2

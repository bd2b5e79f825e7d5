"""The pages in a real browser: what turns, filters, sorts and prints, and that nothing is asked of a network."""

import re
from functools import cache

import numpy as np
import pandas as pd
import pymupdf
import pytest
from support.browser import box_of, drag, open_page, running_browser, watched_page

import camopt
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.picture import Picture
from camopt.solve.synthesis.files import write_frontier

SCENES = (
    *("two-pauses", "flat-reciprocating", "knife-900rpm-offset", "rocker-valve", "feeder-with-stop"),
    *("eccentric-rocker", "bucket-valve"),
)
OBJECTIVES = ["base_radius_mm", "acceleration_max_m_s2"]
PHONE = {"viewport": {"width": 390, "height": 800}, "has_touch": True, "is_mobile": True}


@pytest.fixture(scope="module")
def browser():
    with running_browser() as found:
        yield found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def swept(folder):
    """The folder of a sweep of a few hundred designs, and its page."""
    search = {
        "base_radius": {"start": 30, "stop": 100, "step": 2},
        "offset": {"start": -5, "stop": 15, "step": 5},
        "law": ["cycloidal", "harmonic", "parabolic"],
        "minimise": ["base_radius_mm", "acceleration_max_m_s2", "pressure_angle_max_deg"],
    }
    camopt.sweep(camopt.find_scene("roller-1000rpm").replace(search=search), out=folder / "swept", keep="all")
    return folder / "swept", camopt.report(folder / "swept", folder / "swept.html")


@pytest.fixture(scope="module")
def fronted(folder):
    """The page of a frontier of two points."""
    scene = camopt.find_scene("two-pauses").replace(**{"synthesis.pieces": 20})
    write_frontier(camopt.frontier(scene, ["size", "acceleration"], points=2), folder / "frontier")
    return camopt.report(folder / "frontier", folder / "frontier.html")


@cache
def mechanisms():
    """A scene of each mechanism and contact, those of no shipped scene made of others."""
    found = {name: camopt.find_scene(name) for name in SCENES}
    swinging = camopt.find_scene("oscillating-roller").to_dict()
    swinging["follower"] = {**swinging["follower"], "contact": "flat", "centre_distance": 80.0, "face_offset": 5.0}
    for key in ("roller_radius", "arm_length"):
        swinging["follower"].pop(key, None)
    cylinder = camopt.find_scene("oscillating-roller").to_dict()
    cylinder["cam"] = {"form": "cylindrical", "mean_radius": 60.0}
    cylinder["follower"] = {"motion": "oscillating", "contact": "roller", "roller_radius": 6.0, "arm_length": 70.0}
    rib = {**cylinder, "drive": {"kind": "rib"}, "follower": {**cylinder["follower"], "roller_spacing": 22.0}}
    ring = camopt.find_scene("oscillating-roller").to_dict()
    ring |= {"drive": {"kind": "rib"}, "follower": {**ring["follower"], "roller_spacing": 22.0}}
    two = camopt.find_scene("two-pauses").to_dict()
    two["follower"] = {"motion": "translating", "contact": "spherical", "face_radius": 30.0}
    made = {
        "swinging face": swinging,
        "swinging in a groove": cylinder,
        "swinging about a rib": rib,
        "swinging about a rib of a disc": ring,
        "spherical": two,
    }
    for name, data in made.items():
        found[name] = camopt.Scene.from_dict({**data, "limits": {}, "search": {}, "name": name})
    return found


@pytest.fixture(scope="module")
def page_of_all(browser, folder):
    """One browser window for the cams of all mechanisms: (name, scene, page) by name."""
    with watched_page(browser) as page:
        yield page


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", mechanisms())
def test_the_page_draws_the_curves_of_the_cam(name, page_of_all, folder, monkeypatch):
    """The formulas of the page against those of the mechanisms: pitch curve and profile, at every sample."""
    monkeypatch.setattr("camopt.show.reporting.cams.cam_downloads_and_missing_reason", lambda scene, stem: ([], ""))
    scene, page = mechanisms()[name], page_of_all
    open_page(page, camopt.report(scene, folder / "cam.html"))
    drawn = page.evaluate("curvesOf(data.cams[0]).map(({pitch, profile, flank}) => ({pitch, profile, flank}))")
    picture = Picture(scene, resolve_design(scene))
    size = max(np.abs(curves.pitch).max() for curves in picture.curves)
    for found, *contacts in zip(drawn, *(each.curves for each in picture.contacts), strict=True):
        curves, walls = contacts[0], [wall for each in contacts for wall in each.profile]
        pitch = np.array(found["pitch"]) @ [1, 1j]
        profiles = [np.array(found[side]) @ [1, 1j] for side in ("profile", "flank")]
        assert np.abs(pitch - curves.pitch).max() < 1e-5 * size
        for side, expected in zip(profiles, walls, strict=False):
            assert np.abs(side - expected).max() < 1e-5 * size


GAP = """() => {
  const cam = data.cams[0], roller = document.querySelector(".roller"), body = document.querySelector("g.body");
  const to = body.parentNode.getScreenCTM().inverse();
  const at = (node, x, y) => new DOMPoint(x, y).matrixTransform(to.multiply(node.getScreenCTM()));
  const centre = at(roller, Number(roller.getAttribute("cx")), Number(roller.getAttribute("cy")));
  const profile = curvesOf(cam).flatMap((each) => each.profile).map(([x, y]) => at(body, x, y));
  return Math.min(...profile.map((p) => Math.hypot(p.x - centre.x, p.y - centre.y))) - cam.sizes.roller_radius;
}"""
"""The distance of the drawn roller from the drawn cam, both as they are moved, mm."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two-pauses", "rocker-valve"])
def test_the_follower_touches_the_cam_as_it_turns(name, page_of_all, folder):
    """At every cam angle the follower's own shape, moved, is where the turned cam has its trace point."""
    page = page_of_all
    open_page(page, camopt.report(name, folder / "cam.html"))
    for angle in (0.0, 33.5, 200.0, 359.0):
        page.evaluate(f"camopt.player.go({angle})")
        gap = page.evaluate(GAP)
        assert abs(gap) < 1e-3, angle


LINKS = """(angle) => {
  camopt.player.go(angle);
  const groups = [...document.querySelectorAll("g.train > g > g")];
  return groups.map((each) => each.getAttribute("transform").match(/-?[0-9][0-9.e-]*/g).map(Number));
}"""
"""The shift and the turn of each drawn link at a cam angle, mm and deg."""


GROOVED = {"cam": {"form": "cylindrical", "mean_radius": 90}, "search": {}, "limits": {}}
GROOVED["follower"] = {"motion": "oscillating", "contact": "roller", "roller_radius": 12, "arm_length": 120}
TRAINS = [("slide-by-bell-crank", GROOVED, 3), ("valve-with-rocker", {}, 5), ("slide-by-bell-crank", {}, 3)]


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize(("name", "changes", "links"), TRAINS)
def test_the_train_moves_with_the_cam(name, changes, links, page_of_all, folder):
    """What is drawn as the slide is as far as the tool, at positions that the page has and between two of them."""
    page, scene = page_of_all, camopt.find_scene(name).replace(**changes)
    open_page(page, camopt.report(scene, folder / "train.html"))
    first = np.array(page.evaluate(LINKS, 0.0))
    assert len(first) == links
    for angle, tolerance in ((36.0, 1e-5), (72.0, 1e-5), (181.0, 0.05), (252.0, 1e-5)):
        moved = np.array(page.evaluate(LINKS, angle)) - first
        tool = camopt.cam_points(scene, [angle])["tool_displacement_mm"][0]
        assert np.abs(np.hypot(moved[:, 0], moved[:, 1]) - tool).min() < tolerance


@pytest.mark.slow
def test_playing_turns_the_cam_and_moves_every_cursor(browser, folder):
    with watched_page(browser) as page:
        open_page(page, camopt.report("two-pauses", folder / "play.html"))
        before = page.locator("g.body").get_attribute("transform")
        page.click("button.play")
        assert page.locator("button.play").get_attribute("aria-pressed") == "true"
        for _ in range(100):
            page.wait_for_timeout(20)
            if page.evaluate("camopt.player.angle") > 5:
                break
        page.click("button.play")
        angle = page.evaluate("camopt.player.angle")
        assert angle > 5
        assert page.locator("g.body").get_attribute("transform") != before
        places = page.eval_on_selector_all(
            ".diagram .cursor", "all => all.map((each) => Number(each.getAttribute('x1')))"
        )
        assert len(places) == 6
        assert len({round(place, 3) for place in places}) == 1
        page.wait_for_timeout(100)
        assert page.evaluate("camopt.player.angle") == angle


@pytest.mark.slow
def test_slider_keys_and_dragging_set_the_cam_angle(browser, folder):
    with watched_page(browser) as page:
        open_page(page, camopt.report("two-pauses", folder / "drag.html"))
        page.focus("input[type=range]")
        for _ in range(4):
            page.keyboard.press("ArrowRight")
        assert page.evaluate("camopt.player.angle") == 2.0
        box = box_of(page, ".diagram svg")
        page.mouse.click(box["x"] + 52 + (box["width"] - 62) / 3, box["y"] + 60)
        assert page.evaluate("camopt.player.angle") == pytest.approx(120.0, abs=0.5)
        read = page.locator(".diagram output").first.text_content()
        assert float(read) == pytest.approx(40.0, abs=0.01)
        svg = box_of(page, "svg.cam")
        right, middle = svg["x"] + svg["width"] / 2 + 60, svg["y"] + svg["height"] / 2
        drag(page, (right, middle + 40), (right, middle + 90))
        assert page.evaluate("camopt.player.angle") != pytest.approx(120.0, abs=0.5)


def test_two_cams_share_scale_and_diagrams(browser, folder):
    with watched_page(browser) as page:
        names = ["knife-900rpm-radial", "knife-900rpm-offset"]
        open_page(page, camopt.report(names, folder / "two.html"))
        boxes = page.eval_on_selector_all("svg.cam", "all => all.map((each) => each.getAttribute('viewBox'))")
        assert len(boxes) == 2
        assert len(set(boxes)) == 1
        assert page.locator(".diagram").count() == 6
        assert page.locator(".diagram").first.locator(".dot").count() == 2


SHIFTED = """([angle, place]) => {
  camopt.player.go(angle);
  const diagram = document.querySelector(".diagram");
  return Number(diagram.querySelectorAll("output")[place].textContent.replace("−", "-"));
}"""


@pytest.mark.slow
@pytest.mark.parametrize(("align", "turn"), [(True, 0.0), (True, -100.0), (False, 250.0)])
def test_cams_are_aligned_at_their_noses_or_at_an_angle(align, turn, browser, tmp_path):
    names = ["two-pauses", "harmonic-240rpm-offset"]  # with noses at 142.5° and 105°
    path = camopt.report(names, tmp_path / "two.html", align_noses=align, turn=turn)
    later = 37.5 * align + turn
    with watched_page(browser) as page:
        open_page(page, path)
        for angle in (0.0, 10.0, 95.0, 142.5, 200.0, 300.0, 359.0):
            for place, (name, shift) in enumerate(zip(names, (0.0, later), strict=True)):
                points = camopt.cam_points(camopt.find_scene(name), [(angle - shift) % 360])
                displacement = points["displacement_mm"][0]
                assert page.evaluate(SHIFTED, [angle, place]) == pytest.approx(displacement, abs=0.02)
            bodies = page.eval_on_selector_all(
                "svg.cam .body", "all => all.map((e) => e.getAttribute('transform'))"
            )
            turned = [float(re.findall(r"-?[\d.]+", each)[0]) for each in bodies]
            assert (turned[0] - turned[1] - later) % 360 == pytest.approx(0.0, abs=1e-6) or later % 360 == 0
        words = f"drawn {abs((later + 180) % 360 - 180):.4g}° {'later' if (later + 180) % 360 > 180 else 'earlier'}"
        assert words in page.locator("header").text_content()


def test_the_page_of_two_cams_says_which_cannot_be_made(tmp_path):
    scene = camopt.find_scene("exhaust-valve")
    small = scene.replace(**{"name": "Small cam", "cam.base_radius": 5})
    text = camopt.report([scene, small], tmp_path / "two.html").read_text(encoding="utf-8")
    assert "Small cam — cannot be made: it is undercut and its profile crosses itself." in text
    assert text.count(" — cannot be made") == 1
    assert "No files for machines: Small cam cannot be made" in text


@pytest.mark.parametrize("options", [{"align_noses": True}, {"turn": 5.0}])
def test_one_cam_is_not_aligned(options, tmp_path):
    with pytest.raises(camopt.BadInput, match="two cams"):
        camopt.report("two-pauses", tmp_path / "one.html", **options)


@pytest.mark.slow
def test_filters_agree_with_pandas(browser, swept):
    folder, path = swept
    table = camopt.load(folder / "designs.parquet")
    with watched_page(browser) as page:
        open_page(page, path)
        assert page.evaluate("camopt.rows.count") == len(table)
        page.fill("input[aria-label='min base radius, mm']", "50.5")
        page.fill("input[aria-label='max base radius, mm']", "80")
        page.keyboard.press("Enter")
        inside = table.base_radius_mm.between(50.5, 80)
        assert page.evaluate("camopt.rows.passing.length") == inside.sum()
        page.select_option("select[aria-label='filter law']", label="harmonic")
        inside &= table.law_rise == "harmonic"
        assert page.evaluate("camopt.rows.passing.length") == inside.sum()
        assert f"{inside.sum():,} of {len(table):,}" in page.locator("#passing").text_content()
        page.click("#clear")
        assert page.evaluate("camopt.rows.passing.length") == len(table)
        assert page.input_value("input[aria-label='min base radius, mm']") == ""


def test_the_rows_that_pass_are_saved_in_the_order_of_the_page(browser, swept, tmp_path):
    folder, path = swept
    table = camopt.load(folder / "designs.parquet")
    with watched_page(browser) as page:
        open_page(page, path)
        assert page.evaluate("[camopt.scatter.x.name, camopt.scatter.y.name]") == OBJECTIVES
        page.select_option("select[aria-label='filter law']", label="harmonic")
        page.locator("th button", has_text=re.compile(r"^acceleration")).click()
        with page.expect_download() as saved:
            page.focus("#save")
            page.keyboard.press("Enter")
        saved.value.save_as(tmp_path / "rows.csv")
    rows = pd.read_csv(tmp_path / "rows.csv")
    expected = table[table.law_rise == "harmonic"]
    assert len(rows) == len(expected)
    assert rows.acceleration_max_m_s2.is_monotonic_increasing
    for name in ("base_radius_mm", "offset_mm", "pressure_angle_max_deg"):
        np.testing.assert_allclose(np.sort(rows[name]), np.sort(expected[name]), rtol=1e-6)
    assert set(rows.law_rise) == {"harmonic"}


@pytest.mark.slow
def test_brushing_an_axis_and_a_rectangle_filter(browser, swept):
    with watched_page(browser) as page:
        open_page(page, swept[1])
        everything = page.evaluate("camopt.rows.passing.length")
        box = box_of(page, "#parallel canvas")
        drag(page, (box["x"] + 50, box["y"] + 80), (box["x"] + 50, box["y"] + 160))
        brushed = page.evaluate("camopt.rows.passing.length")
        assert 0 < brushed < everything
        page.mouse.click(box["x"] + 50, box["y"] + 100)
        assert page.evaluate("camopt.rows.passing.length") == everything
        box = box_of(page, "#scatter")
        drag(page, (box["x"] + 70, box["y"] + 20), (box["x"] + box["width"] / 2, box["y"] + 250))
        assert 0 < page.evaluate("camopt.rows.passing.length") < everything


@pytest.mark.slow
def test_sorting_and_choosing_by_mouse_and_keyboard(browser, swept):
    with watched_page(browser) as page:
        open_page(page, swept[1])
        head = page.locator("th button", has_text=re.compile(r"^acceleration"))
        head.click()
        head.click()
        assert page.locator("th[aria-sort=descending]").count() == 1
        order = page.evaluate(
            "Array.from(camopt.grid.order).map((row) => camopt.rows.column('acceleration_max_m_s2').values[row])"
        )
        assert order == sorted(order, reverse=True)
        page.locator("#table tbody tr:not(.gap)").nth(2).click()
        first = page.evaluate("camopt.rows.chosen.at(-1)")
        assert first == page.evaluate("camopt.grid.order[2]")
        head.focus()
        for key in ("ArrowDown", "ArrowDown", "Enter"):
            page.keyboard.press(key)
        assert page.evaluate("camopt.rows.chosen") == [first, page.evaluate("camopt.grid.order[3]")]
        assert page.locator("svg.cam").count() == 2
        assert page.locator("#differences thead th").count() == 3


DOT = """() => {
  const { scatter } = camopt;
  return [scatter.toX(scatter.x.values[7]), scatter.toY(scatter.y.values[7])];
}"""
"""Where the dot of a row is."""


def test_a_click_in_the_scatter_draws_the_cam_of_that_row(browser, swept):
    folder, path = swept
    with watched_page(browser) as page:
        open_page(page, path)
        x, y = page.evaluate(DOT)
        box = box_of(page, "#scatter")
        page.mouse.click(box["x"] + x, box["y"] + y)
        sizes = page.evaluate("camopt.rows.cam(camopt.rows.chosen.at(-1)).sizes")
        _, number, _, file = page.locator("#stage figcaption").nth(1).text_content().split()
        known = camopt.load(folder / file).loc[int(number)]
        assert sizes["size"] == pytest.approx(known.base_radius_mm)
        assert sizes["offset"] == pytest.approx(known.offset_mm)


@pytest.mark.slow
def test_a_frontier_shows_before_and_after(browser, fronted):
    """The known law first, the free one after it, at one scale; the gap to the bound is told."""
    with watched_page(browser) as page:
        open_page(page, fronted)
        assert page.locator("svg.cam").count() == 2
        free = page.evaluate("camopt.rows.chosen.map((row) => camopt.rows.text(camopt.rows.column('free'), row))")
        assert free == ["no", "yes"]
        assert "proven lower bound over all motions" in page.locator("header").text_content()


@pytest.mark.slow
@pytest.mark.parametrize("context", [PHONE, {"color_scheme": "dark"}], ids=["phone", "dark"])
def test_no_page_is_wider_than_its_window(context, browser, folder, swept):
    with watched_page(browser, **context) as page:
        for path in (camopt.report("two-pauses", folder / "narrow.html"), swept[1]):
            open_page(page, path)
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 24, 30)"
            assert dark == ("color_scheme" in context)
            page.click("#theme")
            assert (page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 24, 30)") != dark


PAPERS = {"A4": (595.3, 841.9), "Letter": (612.0, 792.0)}
MARGIN = 38.0  # pt: the 14 mm of the style sheet, less what a letter takes beyond its width

ROWS_ON_PAPER = """() => {
  dispatchEvent(new Event("beforeprint"));
  const tables = document.querySelectorAll("table:not(.grid table, .noprint table)");
  const rows = [...tables].flatMap((table) => [...table.rows].map((row) => row.textContent));
  dispatchEvent(new Event("afterprint"));
  return rows;
}"""
"""The text of every row of every table that is printed."""


@pytest.fixture(scope="module")
def printable(folder, swept, fronted):
    """A page of each kind, with the most sheets of paper that it may take."""
    several = ["knife-900rpm-radial", "knife-900rpm-offset", "valve-rod-radial", "roller-1000rpm"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "camopt.show.reporting.cams.cam_downloads_and_missing_reason", lambda scene, stem: ([], "")
        )  # files are not printed
        cam, cams = (camopt.report(what, folder / f"{len(what)}.html") for what in ("exhaust-valve", several))
    return {"a cam": (cam, 4), "cams": (cams, 13), "a sweep": (swept[1], 8), "a frontier": (fronted, 7)}


def drop_blanks(text):
    return re.sub(r"\s", "", text)


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", ["a cam", "cams", "a sweep", "a frontier"])
def test_a_page_prints_whole(kind, browser, printable):
    """Every diagram as far as 360°, every row of every table and every word, inside the margins of the paper."""
    path, most = printable[kind]
    with watched_page(browser, color_scheme="dark") as page:
        open_page(page, path)
        diagrams = page.locator(".diagram").count()
        rows = page.evaluate(ROWS_ON_PAPER)
        for paper, (width, height) in PAPERS.items():
            with pymupdf.open(stream=page.pdf(format=paper), filetype="pdf") as printed:
                words = [word for sheet in printed for word in sheet.get_text("words")]
                assert all(word[0] > MARGIN and word[2] < width - MARGIN for word in words), paper
                assert all(word[1] > 0 and word[3] < height for word in words), paper
                assert sum(len(sheet.search_for("360°")) for sheet in printed) == diagrams, paper
                assert all(len(sheet.get_text("words")) > 10 for sheet in printed), paper
                assert 1 <= len(printed) <= most, paper
                assert all(sheet.rect.width == pytest.approx(width, abs=1) for sheet in printed)
                text = drop_blanks("".join(sheet.get_text(flags=0) for sheet in printed))
                assert [row for row in rows if drop_blanks(row) not in text] == [], paper
                assert drop_blanks(page.title()) in text
                assert diagrams == 0 or "Pressureangle" in text
                assert "Lightordark" not in text
        assert page.evaluate("document.documentElement.dataset.theme") is None
        assert page.locator(".onlyprint *").count() == 0


@pytest.mark.slow
@pytest.mark.parametrize("full", [False, True])
def test_only_a_full_page_prints_effects_and_scene(full, browser, tmp_path):
    page_file = camopt.report("press-feed-by-pair", tmp_path / "cam.html", full=full)
    with watched_page(browser) as page:
        open_page(page, page_file)
        with pymupdf.open(stream=page.pdf(format="A4"), filetype="pdf") as printed:
            text = "".join(sheet.get_text() for sheet in printed)
            assert ("Effects that ran" in text) is ('form = "disc"' in text) is full
            assert full or len(printed) <= 4
        assert page.locator("details:not([open]) > summary").all_text_contents()[-2:] == ["Effects", "Scene (TOML)"]


def test_a_sweep_prints_its_dots(browser, printable):
    """The scatter has its axes, a dot for each design and rings round the chosen ones, all dark on white."""
    with watched_page(browser, color_scheme="dark") as page:
        open_page(page, printable["a sweep"][0])
        with pymupdf.open(stream=page.pdf(format="A4"), filetype="pdf") as printed:
            top = printed[0].search_for("Designs")[0].y1
            picture = printed[0].get_pixmap(dpi=50, clip=(40, top, 555, top + 200), colorspace=pymupdf.csGRAY)
            shades = np.frombuffer(picture.samples, np.uint8)
            assert (shades < 200).sum() > 1000
            assert np.median(shades) == 255


@pytest.mark.slow
def test_hostile_names_stay_text(browser, folder):
    name = "</script><script>alert(1)</script><img src=x onerror=alert(2)> \"'\x7f"
    name = "".join(letter for letter in name if letter.isprintable())
    scene = camopt.find_scene("two-pauses").replace(name=name)
    with watched_page(browser) as page:
        open_page(page, camopt.report([scene, "valve-rod-radial"], folder / "hostile.html"))
        assert name in page.locator("h1").text_content()
        assert page.locator("#stage figcaption").first.text_content() == name
        assert page.locator("img").count() == 0

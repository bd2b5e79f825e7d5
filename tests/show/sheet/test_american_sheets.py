"""The drawing by ASME: its papers, third angle, inches and limits; its table against the points of the cam."""

import re
from functools import cache

import numpy as np
import pymupdf
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sheets import faults_of, words_outside
from test_sheet import SCENES as DISCS_AND_CYLINDERS

from camopt import cam_points, export, find_scene, shown_in
from camopt.core.quantities.unit_systems import INCH_MM
from camopt.scene.iso286 import limit_deviations
from camopt.scene.problem.problem import resolve_design
from camopt.show.sheet.marks import LARGE, MEDIUM, THICK, Line, Words
from camopt.show.sheet.notes import note_texts
from camopt.show.sheet.paper import ANSI_PAPERS, PROJECTION_FIELD, scale_name, title_block
from camopt.show.sheet.section import section_marks
from camopt.show.sheet.sheet import sheet_of, sheets_of
from camopt.show.sheet.standards import STANDARDS, inch_text
from camopt.show.sheet.symbols import projection_symbol
from camopt.show.sheet.true_cam import TrueCam

ASME = STANDARDS["inch"]
NAMES = [
    "valve-rod-radial",
    "exhaust-valve",
    "flat-reciprocating",
    "face-groove-shutter",
    "feeder-with-stop",
    "key aside",
    "key below",
    "hub as wide as the base circle",
    "key without a length",
    "no part",
    "cylinder with fits",
    "cylinder without part",
    "small",
]
SCENES = {name: DISCS_AND_CYLINDERS[name] for name in NAMES}
PLATE = SCENES["valve-rod-radial"]


def american(scene):
    """The scene with a drawing by ASME."""
    return scene.replace(**({"part.standard": "asme"} if scene.part else {"part": {"standard": "asme"}}))


@cache
def sheet(name):
    scene = american(SCENES[name])
    return sheet_of(TrueCam(scene, resolve_design(scene)))


def words_of(found):
    return [mark for mark in found.marks if isinstance(mark, Words)]


def texts(name):
    return [mark.text for mark in words_of(sheet(name))]


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", NAMES)
def test_a_sheet_is_american_and_nothing_is_on_top_of_anything(name):
    found = sheet(name)
    assert faults_of(found) == []
    assert found.paper in ANSI_PAPERS
    first, second = (int(each) for each in scale_name(found.scale).split(":"))
    assert str(max(first, second)).rstrip("0") in ("1", "2", "4")
    block = {"DIMENSIONS ARE IN INCHES", "THIRD ANGLE", "COMPANY", "DWG NO.", "REV", "SIZE", "1 OF 1"}
    assert block - set(texts(name)) == set()
    assert found.paper.name in texts(name)


@pytest.mark.parametrize("name", NAMES)
def test_no_length_has_a_zero_before_its_point_or_a_unit_in_mm(name):
    lengths = [
        mark.text for mark in words_of(sheet(name)) if mark.height == LARGE and not re.search("°|camopt", mark.text)
    ]
    assert [text for text in lengths if re.search(r"(?<![\d.])0\.|\bmm\b", text)] == []
    dimensions = [text for text in lengths if re.fullmatch(r"[ØR]?\d*\.\d+", text)]
    assert {len(text.partition(".")[2]) for text in dimensions} <= {3, 4}


@pytest.mark.long
def test_pairs_and_ribs_have_american_sheets():
    for name, count in (("press-feed-by-pair", 2), ("bottle-filler-by-rib", 1), ("pump-of-constant-breadth", 1)):
        scene = american(find_scene(name))
        found = sheets_of(scene, resolve_design(scene))
        assert [faults_of(each) for each in found] == [[]] * count
        assert f"1 OF {count}" in [mark.text for mark in words_of(found[0])]


def table(found):
    """Rows of numbers of the table, by cam angle."""
    marks = [mark for mark in words_of(found) if mark.place == 1.0 and mark.height == MEDIUM]
    low = min(mark.at.imag for mark in marks)
    marks = [mark for mark in marks if re.fullmatch(r"−?\d*\.?\d+", mark.text) and mark.at.imag >= low]
    edges = sorted({round(mark.at.real, 6) for mark in marks})
    columns = {x: sorted((m for m in marks if round(m.at.real, 6) == x), key=lambda m: -m.at.imag) for x in edges}
    heads = [x for x in edges if all("." not in m.text or m.text.endswith(".5") for m in columns[x])]
    rows = []
    for k, start in enumerate(heads):
        end = heads[k + 1] if k + 1 < len(heads) else np.inf
        block = [columns[x] for x in edges if start <= x < end]
        rows += [[float(m.text.replace("−", "-")) for m in row] for row in zip(*block, strict=True)]
    return np.array(rows)


@pytest.mark.parametrize("name", ["valve-rod-radial", "exhaust-valve"])
def test_values_between_rows_of_the_table_are_interpolated_within_half_a_thou(name):
    """Rows are points of the cam; in the middle between them, φ and r are off by at most .0005 in."""
    rows, scene = table(sheet(name)), SCENES[name]
    angles = rows[:, 0]
    assert angles[0] == 0.0
    assert np.all(np.diff(angles) > 0.0)
    points = cam_points(scene, angles)
    assert np.abs(rows[:, 1] - points["displacement_mm"] / INCH_MM).max() <= 0.5005e-4
    profile = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    assert np.abs(rows[:, 3] - np.abs(profile) / INCH_MM).max() <= 0.5005e-4
    sense = 1.0 if scene.cam.rotation == "ccw" else -1.0
    fine = cam_points(scene, step=0.01)
    true = fine["profile_x_mm"] + 1j * fine["profile_y_mm"]
    turns = np.unwrap(np.radians(rows[:, 2]))
    r, phi = (rows[1:, 3] + rows[:-1, 3]) / 2, (turns[1:] + turns[:-1]) / 2
    made = INCH_MM * r * 1j * np.exp(-1j * sense * phi)
    off = np.array([np.abs(true - point).min() for point in made])
    assert off.max() / INCH_MM <= 0.0005 + 0.0002  # between points 0.01° from each other
    moving = [segment.angle for segment in scene.motion if segment.segment != "dwell"]
    assert len(rows) >= sum(moving)


def test_the_section_is_seen_from_the_right():
    """The hub, in front in the front view, is on the left; edges behind the section are of the left half."""
    part, outline = PLATE.whole_part, np.array([30 + 0j, 20j, -40 + 10j, -40 - 35j, -20j, 30 + 0j])
    with shown_in("inch"):
        right = [m for m in section_marks([outline], part, 1.0) if isinstance(m, Line) and m.pen == THICK]
    left = [m for m in section_marks([outline], part, 1.0) if isinstance(m, Line) and m.pen == THICK]
    ends = {name: np.concatenate([m.points for m in marks]) for name, marks in (("l", left), ("r", right))}
    assert ends["r"].real.min() == -part.hub_length
    assert ends["r"].real.max() == 0.0
    hub = part.hub_diameter / 2
    assert ends["l"].imag.min() == -hub
    assert ends["r"].imag.min() == -35.0


def test_the_arrows_of_the_cutting_plane_point_where_the_section_is_looked_at():
    """With the keyway at 30°, from the right of its plane to the left: to 120°; the letter is beyond the arrow."""
    letters = [mark for mark in words_of(sheet("key aside")) if mark.text == "A" and mark.height == LARGE]
    heads = [m.points for m in sheet("key aside").marks if isinstance(m, Line) and m.filled and len(m.points) == 4]
    assert "SECTION A-A" in texts("key aside")
    way = np.exp(2j * np.pi / 3)
    pointed = 0
    for head in heads:
        axis = head[0] - head[1:3].mean()
        if abs(axis / abs(axis) - way) < 1e-6:
            near = min(letters, key=lambda mark: abs(mark.at + 0.5j * LARGE - head[0]))
            pointed += ((near.at + 0.5j * LARGE - head[0]) * way.conjugate()).real > 0.0
    assert pointed >= 2


def test_the_symbol_of_third_angle_has_its_circles_on_the_left():
    def circles(is_third):
        return [m for m in projection_symbol(0j, is_third) if isinstance(m, Line) and len(m.points) > 100]

    assert {np.sign(mark.points.mean().real) for mark in circles(True)} == {-1.0}
    assert {np.sign(mark.points.mean().real) for mark in circles(False)} == {1.0}


def test_zones_are_numbered_from_the_right_and_lettered_upwards():
    paper = ANSI_PAPERS[1]
    marks = [mark for mark in paper.marks() if isinstance(mark, Words)]
    bottom = sorted((m for m in marks if m.text.isdigit() and m.at.imag < 20), key=lambda m: m.at.real)
    right = sorted((m for m in marks if m.text.isalpha() and m.at.real > 400), key=lambda m: m.at.imag)
    assert [[m.text for m in bottom], [m.text for m in right]] == [["4", "3", "2", "1"], ["A", "B"]]
    sizes = [(round(p.width / INCH_MM, 3), round(p.height / INCH_MM, 3)) for p in ANSI_PAPERS]
    assert sizes == [(8.5, 11), (17, 11), (22, 17), (34, 22)]


def test_units_decide_without_the_key():
    scene = SCENES["flat-reciprocating"]
    problem = resolve_design(scene)
    with shown_in("inch"):
        shown = sheet_of(TrueCam(scene, problem))
        metric = scene.replace(part={"standard": "iso"})
        kept = sheet_of(TrueCam(metric, resolve_design(metric)))
    assert [m.text for m in words_of(shown)] == texts("flat-reciprocating")
    assert [m.text for m in words_of(kept)] == [m.text for m in words_of(sheet_of(TrueCam(scene, problem)))]


@given(st.sampled_from(["H7", "JS9", "F8", "P7", "h6"]), st.floats(3.5, 400))
def test_limits_are_within_the_fit_and_leave_most_of_it(fit, size):
    """They are rounded inwards: no part beyond the fit is allowed."""
    deviations = limit_deviations(fit, size)
    low, high = (float(each) * INCH_MM for each in ASME.toleranced_text(size, fit, deviations).split("-"))
    assert size + deviations.lower - 1e-6 <= low < high <= size + deviations.upper + 1e-6
    assert high - low >= 0.45 * (deviations.upper - deviations.lower)


def test_fits_and_tolerances_are_in_inches():
    assert {"Ø.9843-.9850", ".3143-.3156", "1.1142-1.1220", ".0016", "32", "R.9843"} <= set(
        texts("valve-rod-radial")
    )
    assert {"TOLERANCES: ISO 2768-mK", "SURFACES 125 µin Ra"} <= set(texts("valve-rod-radial"))
    assert {".XXX ±.005", "ANGLES ±0.5°"} <= set(texts("face-groove-shutter"))
    assert "are basic" in " ".join(texts("valve-rod-radial"))
    assert "Projection method" not in " ".join(texts("valve-rod-radial"))
    frames = [m.points for m in sheet("valve-rod-radial").marks if isinstance(m, Line) and len(m.points) == 5]
    basic = next(m for m in words_of(sheet("valve-rod-radial")) if m.text == "R.9843")
    assert any(abs(frame[:4].mean() - basic.corners.mean()) < 1e-9 for frame in frames)


def test_a_german_scene_has_an_english_american_drawing():
    scene = american(PLATE.replace(**{"part.language": "de"}))
    found = sheet_of(TrueCam(scene, resolve_design(scene)))
    assert [mark.text for mark in words_of(found)] == texts("valve-rod-radial")


@pytest.mark.parametrize(
    ("inches", "text"), [(0.25, ".2500"), (1.5, "1.5000"), (-0.00004, ".0000"), (-0.5, "−.5000"), (10, "10.0000")]
)
def test_inches_have_fixed_decimals_and_no_zero_before_the_point(inches, text):
    assert inch_text(inches, 4) == text


@pytest.mark.parametrize(("roughness", "text"), [(0.8, "32"), (1.6, "63"), (3.2, "125"), (2.0, "78.7")])
def test_a_roughness_is_a_number_of_microinches(roughness, text):
    assert ASME.roughness_text(roughness) == text


@given(
    st.fixed_dictionaries(
        {key: st.text(max_size=120) for key in ("name", "number", "material", "hardness", "designer")}
    ),
    st.text(max_size=300),
)
def test_an_american_title_block_holds_any_text(given_texts, tolerances):
    part = PLATE.part.model_copy(update={**given_texts, "general_tolerances": tolerances})
    fields = ASME.title_fields(part, part.name, "1:1", "B", "1/1")
    assert words_outside(fields, title_block(fields)) == []
    assert [field.name for field in fields].count(PROJECTION_FIELD) == 1


@pytest.mark.slow
def test_a_pdf_has_the_size_of_its_paper(tmp_path):
    told = export(american(SCENES["face-groove-shutter"]), tmp_path / "a.pdf")
    paper = next(each for each in ANSI_PAPERS if each.name == told.about["paper"])
    page = pymupdf.open(tmp_path / "a.pdf")[0]
    size = page.rect.width / 72 * INCH_MM, page.rect.height / 72 * INCH_MM
    assert size == pytest.approx((paper.width, paper.height), abs=0.01)


def test_notes_are_in_inches():
    scene = american(SCENES["face-groove-shutter"])
    with shown_in("inch"):
        told = " ".join(note_texts(TrueCam(scene, resolve_design(scene))))
    assert "roller Ø.4724, arm 2.9528" in told
    assert "in its groove .0008, from .0006 to .0017." in told


def test_a_step_that_is_asked_is_that_of_the_table():
    scene = american(SCENES["exhaust-valve"])
    found = sheet_of(TrueCam(scene, resolve_design(scene)), 4.0)
    assert faults_of(found) == []
    assert table(found)[:, 0].tolist() == [4.0 * k for k in range(90)]

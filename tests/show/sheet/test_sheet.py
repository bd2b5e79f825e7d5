"""The workshop drawing, read back from its PDF, against quantities and points; nothing on it hides anything."""

import re
from collections import Counter
from functools import cache
from itertools import pairwise
from math import degrees, hypot, pi

import numpy as np
import pymupdf
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq
from shapely import LineString, MultiPoint, Polygon
from support.cams import CONTACTS, cam_with
from support.depth import covering_cases, is_deep
from support.sheets import faults_of, words_outside

from camopt import BadInput, Scene, cam_points, evaluate, export, find_scene, shipped_scenes
from camopt.scene.problem.problem import resolve_design
from camopt.show.sheet.developed import DevelopedView
from camopt.show.sheet.front_view import FrontView
from camopt.show.sheet.languages import GERMAN, with_decimal_sign
from camopt.show.sheet.marks import (
    LARGE,
    MEDIUM,
    THICK,
    Line,
    Words,
    decimal_text,
    fitted_lines_and_height,
    text_width,
)
from camopt.show.sheet.notes import note_texts
from camopt.show.sheet.paper import A3, A4, paper_scales, scale_name, title_block
from camopt.show.sheet.points_table import points_table, table_columns
from camopt.show.sheet.ring import ring_marks, sort_after_widest_gap, spread_directions
from camopt.show.sheet.section import section_marks
from camopt.show.sheet.sheet import sheet_of
from camopt.show.sheet.standards import STANDARDS
from camopt.show.sheet.true_cam import TrueCam

PLATE = find_scene("valve-rod-radial")
CYLINDER = find_scene("feeder-with-stop")
PART = {"thickness": 12, "bore": 20, "keyway_width": 6, "keyway_depth": 2.8, "roughness": 1.6}
LONG = "x" * 500
SHORT = [("rise", 12), ("dwell", 6), ("return", 10), ("dwell", 332)]
MANY = [("rise", 3), ("return", 3)] * 8 + [("dwell", 312)]


def turning(segments, lift=2.0, law="cycloidal"):
    moving = {"lift": lift, "law": law}
    return [{"segment": s, "angle": a, **(moving if s != "dwell" else {})} for s, a in segments]


SCENES = {  # of the rib: test_sheets_of_pairs
    **{name: find_scene(name) for name in shipped_scenes() if name != "bottle-filler-by-rib"},
    **{f"a {name}": Scene.from_dict(cam_with(name, part={**PART, "thickness": 60})) for name in CONTACTS},
    "key aside": PLATE.replace(**{"part.keyway_angle": 30}),
    "key below": PLATE.replace(**{"part.keyway_angle": -90}),
    "key on the side": PLATE.replace(**{"part.keyway_angle": 180}),
    "no hub": PLATE.replace(**{"part.hub_diameter": None, "part.hub_length": None}),
    "hub as wide as the base circle": PLATE.replace(**{"part.hub_diameter": 50}),
    "large hub": PLATE.replace(**{"cam.base_radius": 60, "part.hub_diameter": 120}),
    "larger hub": PLATE.replace(**{"cam.base_radius": 110, "part.hub_diameter": 220}),
    "key without a length": PLATE.replace(part={"keyway_width": 8, "keyway_depth": 3.3}),
    "law of a long name": find_scene("flat-reciprocating").replace(
        laws={"x" * 500: {"law": "poly345", "crossing": 0.4}},
        motion=turning([("rise", 180), ("return", 180)], law="x" * 500),
    ),
    "no part": PLATE.replace(part=None),
    "roughness alone": PLATE.replace(**{"part.profile_tolerance": None}),
    "cylinder without part": CYLINDER.replace(part=None),
    "cylinder of a length": CYLINDER.replace(part={"thickness": 90}),
    "cylinder, key aside": CYLINDER.replace(**{"part.keyway_angle": 200}),
    "cylinder with fits": CYLINDER.replace(
        **{"part.groove_fit": "H8", "part.groove_chamfer": 0.5, "part.outer_fit": "h9"}
    ),
    "short strokes": find_scene("roller-1000rpm").replace(motion=turning(SHORT)),
    "many strokes": find_scene("roller-1000rpm").replace(motion=turning(MANY, 0.5)),
    "large": PLATE.replace(**{"cam.base_radius": 2e4}),
    "small": find_scene("flat-reciprocating").replace(
        **{"cam.base_radius": 0.5}, motion=turning([("rise", 180), ("return", 180)], 0.01)
    ),
}


def features(name):
    """What the views of a sheet differ by: the mechanism, its strokes, and whatever an odd scene is made for."""
    scene = SCENES[name]
    own = () if name in shipped_scenes() else (name,)
    return (scene.cam.form, scene.follower.motion, scene.follower.contact), bool(scene.part.bore), *own


CHECKED = [name for name in covering_cases(SCENES, features) if name != "many strokes" or is_deep()]


@cache
def sheet(name):
    return sheet_of(TrueCam(SCENES[name], resolve_design(SCENES[name])))


def texts(name):
    return [mark.text for mark in sheet(name).marks if isinstance(mark, Words)]


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", CHECKED)
def test_nothing_is_on_top_of_anything_or_beyond_the_frame(name):
    found = sheet(name)
    assert faults_of(found) == []
    assert found.paper in (A4, A3)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", CHECKED)
def test_a_scale_is_one_of_the_standard(name):
    first, second = (int(each) for each in scale_name(sheet(name).scale).split(":"))
    assert min(first, second) == 1
    assert str(max(first, second)).rstrip("0") in ("1", "2", "5")
    assert scale_name(sheet(name).scale) in texts(name)


def ring_of(name):
    """The names of the ring, each with its angle, in no order."""
    kinds = "rise|dwell|return|move|constant velocity"
    return [each for text in texts(name) for each in re.findall(rf"^({kinds}) ([\d.]+)°$", text)]


STEADY = [name for name, scene in SCENES.items() if "constant-velocity" in {s.segment for s in scene.motion or ()}]


@pytest.mark.parametrize("name", [name for name in dict.fromkeys([*CHECKED, *STEADY]) if SCENES[name].motion])
def test_segments_are_those_of_the_scene(name):
    """Each with its own angle; a stretch at constant velocity is called so, a move by the way that it goes."""
    scene = SCENES[name]
    expected = sorted(decimal_text(segment.angle, 2) for segment in scene.motion)
    assert sorted(angle for _, angle in ring_of(name)) == expected
    found = Counter((kind, angle) for kind, angle in ring_of(name))
    kinds = {"rise", "return", "dwell", "constant-velocity"}
    told = Counter(
        (s.segment.replace("-", " "), decimal_text(s.angle, 2))
        for s in scene.motion
        if s.segment in kinds and s.angle
    )
    assert told - found == Counter()
    steady = sum(s.segment == "constant-velocity" for s in scene.motion)
    noted = " ".join(mark.text for mark in sheet(name).marks if isinstance(mark, Words) and mark.height == MEDIUM)
    assert steady == sum(kind == "constant velocity" for kind, _ in ring_of(name))
    assert not steady or "at constant velocity" in noted


def test_a_move_goes_one_way_or_is_called_a_move():
    names = ["rise 70°", "constant velocity 60°", "move 80°", "constant velocity 48°", "return 62°", "dwell 40°"]
    assert [
        name for name, _, _ in TrueCam(SCENES["belt-matching"], resolve_design(SCENES["belt-matching"])).segments
    ] == names
    there_and_back = [{"segment": "move", "angle": 360, "to": 0, "through": [{"angle": 90, "position": 10}]}]
    scene = find_scene("belt-matching").replace(motion=there_and_back)
    assert [name for name, _, _ in TrueCam(scene, resolve_design(scene)).segments] == ["move 360°"]


VALVE = find_scene("valve-with-rocker").replace(
    motion=[
        {"segment": "move", "angle": 12, "to": 0.08, "velocity": 0.8, "acceleration": 0},
        {"segment": "constant-velocity", "angle": 12, "velocity": 0.8},
        {"segment": "move", "angle": 60, "to": 9},
        {"segment": "move", "angle": 60},
        {"segment": "constant-velocity", "angle": 12, "to": 0.08, "velocity": -0.8},
        {"segment": "move", "angle": 12, "to": 0},
        {"segment": "dwell", "angle": 192},
    ]
)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("language", ["en", "de"])
def test_what_is_asked_of_a_tool_is_not_said_of_the_follower(language):
    """Its moves are rises and returns, nothing at constant velocity; the notes tell both lifts apart, whole."""
    scene = VALVE.replace(**{"part.language": language})
    found = sheet_of(TrueCam(scene, resolve_design(scene)))
    assert faults_of(found) == []
    names = [name for name, _, _ in found.cam.segments]
    assert [name.partition(" ")[0] for name in names] == (
        ["rise"] * 3 + ["return"] * 3 + ["dwell"]
        if language == "en"
        else ["Anstieg"] * 3 + ["Rückgang"] * 3 + ["Rast"]
    )
    (note,) = (text for text in note_texts(found.cam) if " 9;" in text)
    follower = cam_points(scene, step=0.5)["displacement_mm"].max()
    assert [decimal_text(follower) in note, note.count("0.01396 mm/°"), note.count("−0.01396")] == [True, 2, 1]
    whole = " ".join(mark.text for mark in found.marks if isinstance(mark, Words))
    assert " ".join(with_decimal_sign(note, language).split()) in whole
    assert ("0,01396" in whole) == (language == "de")


@pytest.mark.parametrize("name", CHECKED)
def test_no_note_is_cut(name):
    whole = "".join(mark.text for mark in sheet(name).marks if isinstance(mark, Words)).replace(" ", "")
    assert [text for text in note_texts(sheet(name).cam) if text.replace(" ", "") not in whole] == []


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CHECKED)
def test_a_tolerance_refers_to_the_bore_and_to_the_keyway_that_turns_the_cam(name):
    """Each datum twice: in the frame of the tolerance, and where it is."""
    scene = SCENES[name]
    part, cut = (
        scene.whole_part,
        ("thickness", "groove_depth") if scene.cam.form == "cylindrical" else ("thickness",),
    )
    has = bool(part.profile_tolerance and part.bore) and all(getattr(part, key) for key in cut)
    letters = Counter(mark.text for mark in sheet(name).marks if isinstance(mark, Words) and mark.height == LARGE)
    others = has * (bool(part.keyway_width) + bool(part.groove_depth))  # the face that a groove is from
    assert (letters["B"], letters["C"]) == (2 * (others > 0), 2 * (others > 1))
    assert letters["A"] >= (2 if has else 0)  # a cutting plane is called A, too


def test_a_cutter_is_not_told_where_no_flank_is_hollow():
    """Between a base circle with a hollow of R175 and one without, the hollow becomes a straight flank."""
    scene = find_scene("two-pauses")

    def hollow(radius):
        own = scene.replace(**{"cam.base_radius": radius, "outputs": ["cutter_radius_max_mm"]})
        return evaluate(own)["cutter_radius_max_mm"]

    radius = brentq(lambda radius: 1 / hollow(radius) - 1e-5 if np.isfinite(hollow(radius)) else -1e-5, 25.0, 100.0)
    said = {
        each: " ".join(
            note_texts(
                TrueCam(
                    scene.replace(**{"cam.base_radius": each}),
                    resolve_design(scene.replace(**{"cam.base_radius": each})),
                )
            )
        )
        for each in (25.0, radius)
    }
    assert hollow(radius) > 1e4
    assert "cutter or wheel in hollow flanks at most R175.43" in said[25.0]
    assert "cutter or wheel" not in said[radius]


def test_a_section_has_no_line_inside_its_metal():
    """Where plate and hub meet they are one."""
    part = PLATE.whole_part
    outline = TrueCam(PLATE, resolve_design(PLATE)).curve("profile")
    plate, hub = part.thickness, part.hub_diameter / 2
    for mark in section_marks([outline], part, 1.0):
        if isinstance(mark, Line) and mark.pen == THICK and np.all(mark.points.real == plate):
            assert np.abs(mark.points.imag).min() >= hub


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", CHECKED)
def test_what_the_follower_does_adds_up_to_a_turn(name):
    angles = [float(angle) for _, angle in ring_of(name)]
    assert sum(angles) == pytest.approx(360.0, abs=0.005 * len(angles) + 1e-9)


GERMANS = {name: SCENES[name].replace(**{"part.language": "de"}) for name in CHECKED}


@pytest.mark.one_in(18)
@pytest.mark.parametrize("name", GERMANS)
def test_a_german_drawing_has_no_english_and_room_for_its_words(name):
    found = sheet_of(TrueCam(GERMANS[name], resolve_design(GERMANS[name])))
    assert faults_of(found) == []
    own = {*vars(GERMANS[name].whole_part).values(), GERMANS[name].name}
    said = [mark.text for mark in found.marks if isinstance(mark, Words) and mark.text not in own]
    assert "Werkstoff" in said
    english = [text for text in GERMAN if GERMAN[text] != text and len(text) > 3 and "{" not in text]
    words = [re.sub(r" [\d.,]+°?$", "", text) for text in said]
    assert {*words} & {*english} == set()


def test_each_german_text_has_the_places_of_the_english_one():
    assert [text for text, german in GERMAN.items() if text.count("{}") != german.count("{}")] == []


def test_a_mass_has_four_digits():
    (mass,) = re.findall(r"mass ([\d.]+) kg", " ".join(note_texts(TrueCam(CYLINDER, resolve_design(CYLINDER)))))
    exact = evaluate(CYLINDER.replace(outputs=["cam_mass_kg"]))["cam_mass_kg"]
    assert mass == f"{exact:.4g}" != f"{exact:.6g}"


def test_what_holds_elsewhere_is_noted():
    more = {"general_tolerances": "ISO 2768-mK", "edges": [-0.3, 0.2], "other_roughness": 6.3}
    scene = PLATE.replace(**{"cam.shaft_diameter": PART["bore"], "part": {**PART, **more}})
    first = next(iter(note_texts(TrueCam(scene, resolve_design(scene)))))
    for words in ("General tolerances ISO 2768-mK.", "ISO 13715: outer -0.3, inner +0.2.", "surfaces Ra 6.3."):
        assert words in first
    block = STANDARDS["mm"].title_fields(
        scene.replace(**{"part.hardness": "60 HRC", "part.case_depth": "0.8"}).whole_part, "", "1:1", "A4", "1/1"
    )
    assert "60 HRC, CHD 0.8" in [each.value for each in block]


@pytest.mark.parametrize("language", ["en", "de"])
def test_limits_that_are_broken_are_noted_first(language):
    scene = PLATE.replace(**{"limits.pressure_angle": 5, "part.language": language})
    cam, value = TrueCam(scene, resolve_design(scene)), evaluate(scene)["pressure_angle_max_deg"]
    first = next(note_texts(cam))
    assert f"pressure angle return {value:.6g} deg (≤ 5 deg)" in first
    assert first.startswith(cam.translate("Breaks limits of its design: {}.")[:14])
    assert "Breaks" not in next(note_texts(TrueCam(PLATE, resolve_design(PLATE))))


def test_boxes_of_the_title_block_have_keys(tmp_path):
    """A date may be one of TOML."""
    given = {"approved_by": "N. N.", "legal_owner": "Works Ltd", "revision": "B", "designer": "M. M."}
    file = tmp_path / "a.toml"
    file.write_text(PLATE.replace(part=PLATE.part.model_dump(exclude_none=True) | given).to_toml())
    text = re.sub(r"(?m)^designer", "date_of_issue = 2026-11-25\ndesigner", file.read_text())
    file.write_text(text)
    scene = find_scene(str(file))
    named = {
        each.name: each.value
        for each in STANDARDS["mm"].title_fields(scene.whole_part, scene.name, "1:1", "A4", "1/1")
    }
    boxes = ("Approved by", "Legal owner", "Rev.", "Created by", "Date of issue")
    assert [named[box] for box in boxes] == [*given.values(), "2026-11-25"]
    assert faults_of(sheet_of(TrueCam(scene, resolve_design(scene)))) == []
    assert Scene.from_dict(scene.to_dict()) == scene


def test_a_groove_is_located_from_the_lower_face():
    """Its middle at cam angle 0, from the cylinder's end that is lower in the developed view."""
    points = cam_points(CYLINDER, np.arange(0.0, 360.0, 0.05))["pitch_y_mm"]
    middle = (points.min() + points.max()) / 2
    assert decimal_text(points[0] - middle + CYLINDER.part.thickness / 2) in texts("feeder-with-stop")


@pytest.mark.parametrize("turn", [0.0, 40.0, 90.0])
def test_a_section_is_where_its_groove_is(turn):
    """Where the groove climbs, it is wider along the axis than across: from flank to flank of the points.

    Both cam angles are written there, and the edge where a wall of the keyway meets the bore is drawn behind.
    """
    scene = CYLINDER.replace(**{"part.keyway_angle": 90.0 - turn})
    cam = TrueCam(scene, resolve_design(scene))
    depth, outer = scene.part.groove_depth, scene.cam.mean_radius + scene.part.groove_depth / 2
    marks = DevelopedView(cam, 1.0).axial_section_marks()
    thick = [mark.points for mark in marks if isinstance(mark, Line) and mark.pen == THICK]
    points = np.concatenate(thick)
    part = scene.whole_part
    mouth = (part.bore / 2) * np.cos(np.arcsin(part.keyway_width / part.bore))
    assert any(np.allclose(each.imag, mouth, rtol=0, atol=1e-9) and np.ptp(each.real) > 0 for each in thick)
    true = cam_points(scene, step=0.02)
    face = (true["pitch_y_mm"].min() + true["pitch_y_mm"].max() - scene.part.thickness) / 2
    for side, angle in ((1.0, turn), (-1.0, turn + 180.0)):
        x = np.radians(angle) * scene.cam.mean_radius
        flanks = [np.interp(x, true[f"profile_{n}_x_mm"], true[f"profile_{n}_y_mm"]) for n in ("right", "left")]
        drawn = points.real[np.abs(points.imag - side * (outer - depth)) < 1e-9]
        assert [drawn.min(), drawn.max()] == pytest.approx(np.array(flanks) - face, abs=5e-3)
        (told,) = (mark for mark in marks if isinstance(mark, Words) and mark.text == f"{angle:g}°")
        assert told.at.imag * side > outer


def test_the_leader_to_a_flank_leaves_the_length_of_the_circumference_alone():
    scene = find_scene("feeder-with-stop").replace(
        **{"cam.mean_radius": 60, "part.profile_tolerance": 0.02, "part.roughness": 0.8}
    )
    marks = DevelopedView(TrueCam(scene, resolve_design(scene)), 0.2).developed_cylinder_marks()
    (words,) = (mark for mark in marks if isinstance(mark, Words) and "2π" in mark.text)
    box = Polygon([(corner.real, corner.imag) for corner in words.corners])
    crossed = [
        mark for mark in marks
        if isinstance(mark, Line) and LineString([(p.real, p.imag) for p in mark.points]).intersects(box)
    ]  # fmt: skip
    assert crossed == []


def test_a_groove_is_cut_no_wider_than_its_roller():
    """What the drawing allows is what points and files allow."""
    noted = " ".join(texts("feeder-with-stop"))
    widest = float(re.search(r"cutter at most Ø([\d.]+)", noted)[1]) / 2
    assert "hollow flanks" not in noted
    assert "cutter_left_x_mm" in cam_points(CYLINDER, [0.0], cutter_radius=widest)
    with pytest.raises(BadInput, match="at most"):
        cam_points(CYLINDER, [0.0], cutter_radius=1.001 * widest)


def test_names_that_have_no_room_round_the_ring_are_left_out():
    ends = np.linspace(0.0, 2 * pi, 121)
    segments = [("rise 3°", float(a), float(b)) for a, b in pairwise(ends)]
    assert not any(isinstance(mark, Words) for mark in ring_marks(segments, 40.0))
    assert sum(isinstance(mark, Words) for mark in ring_marks(segments[:40], 40.0)) == 40


def expected_dimensions(scene):
    """The dimensions that a drawing has to have, from the scene and from quantities."""
    cam, part = scene.cam, scene.whole_part
    if cam.form == "disc":
        yield f"R{decimal_text(cam.base_radius - (scene.drive.clearance or 0.0) / 2)}"
        largest = evaluate(scene.replace(outputs=["outer_radius_mm"]))["outer_radius_mm"]
        yield from (f"R{decimal_text(largest)}" for _ in range(1) if largest > cam.base_radius)
    else:
        yield f"{decimal_text(2 * pi * cam.mean_radius)} (2π · R{decimal_text(cam.mean_radius)})"
        yield f"{decimal_text(2 * scene.follower.roller_radius)} {part.groove_fit or ''}".strip()
        yield from (
            f"Ø{decimal_text(2 * cam.mean_radius + depth)} {part.outer_fit or ''}".strip()
            for depth in (part.groove_depth,)
            if depth
        )
        chamfers = [part.groove_chamfer] if part.groove_chamfer else []
        yield from (f"Edges of the groove chamfered {decimal_text(chamfer)} × 45°." for chamfer in chamfers)
    shown = ("thickness", "hub_length", "groove_depth")
    yield from (decimal_text(value) for key in shown if (value := getattr(part, key)))
    yield from (
        f"{decimal_text(part.keyway_width)} {part.keyway_fit or ''}".strip() for _ in range(1) if part.keyway_width
    )
    if part.bore:
        yield f"Ø{decimal_text(part.bore)} {part.bore_fit or ''}".strip()
        more = " +0.2" if part.keyway_fit else ""  # of widths from 8 to 32 mm
        over = [f"{decimal_text(part.bore + depth)}{more}" for depth in (part.keyway_depth,) if depth]
        yield from over if cam.form == "cylindrical" or part.thickness else (f"Bore and keyway: {o}." for o in over)
    yield from (f"Ø{decimal_text(across)}" for across in (part.hub_diameter, part.outer_diameter) if across)
    yield from (decimal_text(2 * part.profile_tolerance, 4) for _ in range(1) if part.profile_tolerance)
    yield from (f"Ra {part.roughness:g}" for _ in range(1) if part.roughness)


@pytest.mark.parametrize("name", CHECKED)
def test_dimensions_are_those_of_the_cam(name):
    found = texts(name)
    assert [each for each in expected_dimensions(SCENES[name]) if each not in found] == []


@pytest.mark.parametrize("name", CHECKED)
def test_the_table_has_the_points_of_the_cam(name):
    rows = [mark.text for mark in table_marks(sheet(name))]
    angles = [float(text) for text in texts(name) if re.fullmatch(r"\d+", text)]
    step = 5.0 if 355.0 in angles else 10.0
    points = cam_points(SCENES[name], np.arange(0.0, 360.0, step))
    shown = np.array([float(text.replace("−", "-")) for text in rows])
    lift = points.get("displacement_mm", points.get("displacement_deg"))
    width = shown.size // lift.size
    assert shown.size == width * lift.size
    scene = SCENES[name]
    if scene.cam.form == "cylindrical":
        columns = [*([lift] if width == 3 else []), points["pitch_x_mm"], points["pitch_y_mm"]]
    else:
        curves = ["profile", "pitch"] if width == 5 else ["profile"]
        curves = curves if scene.mechanism.body.bounded else ["pitch"]
        columns = [lift]
        for curve in curves:
            x, y = points[f"{curve}_x_mm"], points[f"{curve}_y_mm"]
            turn = np.degrees(np.arctan2(x, y)) * (1.0 if scene.cam.rotation == "ccw" else -1.0)
            columns += [turn % 360.0, np.hypot(x, y)]
    assert [len(columns), width] == [width, len(columns)]
    found = sorted_columns(sheet(name), lift.size, width)
    for k, column in enumerate(columns):
        off = np.abs(found[:, k] - column)
        assert np.minimum(off, np.abs(off - 360.0)).max() <= 0.5005e-3


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "step"), [(PLATE, 2.0), (CYLINDER, 2.5)])
def test_a_table_has_the_step_that_is_asked(scene, step):
    found = sheet_of(TrueCam(scene, resolve_design(scene)), step)
    assert (found.paper.name, faults_of(found)) == ("A2", [])
    words = {mark.text for mark in found.marks if isinstance(mark, Words)}
    assert {f"{angle:g}" for angle in np.arange(0.0, 360.0, step)} <= words
    developed = scene.cam.form == "cylindrical"
    rows = sorted_columns(found, round(360.0 / step), 2 if developed else 5)
    points = cam_points(scene, np.arange(0.0, 360.0, step))
    lift = rows[:, 1 if developed else 0]
    assert np.abs(lift - points["displacement_mm"]).max() <= 0.5005e-3


@pytest.mark.parametrize(("step", "why"), [(7.0, "divides 360"), (0.0, "at least 0.5"), (0.5, "not fit on A2")])
def test_a_table_of_another_step_is_refused(step, why):
    with pytest.raises(BadInput, match=why):
        sheet_of(TrueCam(PLATE, resolve_design(PLATE)), step)


def test_a_heading_has_room_over_its_columns():
    """The words over x and y, in both languages: within the columns that they are over."""
    for language in ("en", "de"):
        cam = TrueCam(CYLINDER.replace(**{"part.language": language}), resolve_design(CYLINDER))
        marks = points_table(table_columns(cam, 10.0), 1)
        (words,) = (m for m in marks if isinstance(m, Words) and m.text in ("roller centre", "Rollenmitte"))
        lines = sorted({m.points[0].real for m in marks if isinstance(m, Line) and np.ptp(m.points.real) == 0})
        right = max(m.points.real.max() for m in marks if isinstance(m, Line))
        corners = words.corners.real
        assert lines[0] < corners.min() < lines[1] < corners.max() < right


def table_marks(found):
    """The numbers of the table, which are smaller than dimensions."""
    words = (mark for mark in found.marks if isinstance(mark, Words) and mark.height == MEDIUM)
    return [mark for mark in words if re.fullmatch(r"−?\d+\.\d{3}", mark.text)]


def sorted_columns(found, rows, width):
    """The numbers of a table by rows and columns, from where they stand."""
    marks = table_marks(found)
    edges = sorted({round(m.at.real, 6) for m in marks})
    blocks = len(edges) // width
    values = {(round(m.at.real, 6), -m.at.imag): float(m.text.replace("−", "-")) for m in marks}
    out = []
    for b in range(blocks):
        mine = [[v for (x, _), v in sorted(values.items(), key=lambda i: i[0][1]) if x == e]
                for e in edges[b * width : (b + 1) * width]]  # fmt: skip
        out.append(np.array(mine).T)
    return np.concatenate(out).reshape(rows, width)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The one page of a scene's PDF, and what export says of it."""
    folder = tmp_path_factory.mktemp("sheets")

    @cache
    def opened(name):
        file = folder / f"{len(list(folder.iterdir()))}.pdf"
        told = export(SCENES[name], file)
        document = pymupdf.open(file)
        assert document.page_count == 1
        return document[0], told

    return opened


MM = 25.4 / 72


def lines_of(page):
    """Each line of a page: its points in mm, y up, and its width in mm."""
    for drawing in page.get_drawings():
        ends, box = [item[1:3] for item in drawing["items"] if item[0] == "l"], drawing["rect"]
        if drawing["items"][0][0] in ("re", "qu"):  # as which a rectangle is read back
            points = [box.bl, box.br, box.tr, box.tl, box.bl]
        else:
            points = [first for first, _ in ends[:1]] + [last for _, last in ends]
        if points and drawing["width"]:
            yield np.array([complex(p.x, page.rect.height - p.y) for p in points]) * MM, drawing["width"] * MM


def is_circle(points, radius):
    return len(points) > 100 and np.ptp(np.append(np.abs(points - points[:-1].mean()), radius)) < 1e-3


PRINTED = [
    "valve-rod-radial",
    "roller-1000rpm",
    "flat-reciprocating",
    "oscillating-roller",
    "tangent-cam",
    "key aside",
]


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", [*PRINTED, "feeder-with-stop"])
def test_a_pdf_is_a_sheet_of_its_size_with_its_texts(name, page):
    found, told = page(name)
    size = {"A4": (210, 297), "A3": (420, 297)}[told.about["paper"]]
    assert (found.rect.width * MM, found.rect.height * MM) == pytest.approx(size, abs=0.01)
    words = found.get_text().replace("\n", " ")
    assert [text for text in texts(name) if text not in words] == []


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", PRINTED)
def test_the_profile_in_a_pdf_is_that_of_the_cam_at_its_scale(name, page):
    found, told = page(name)
    scale = sheet(name).scale
    base = SCENES[name].cam.base_radius
    lines = list(lines_of(found))
    (centre,) = (points[:-1].mean() for points, _ in lines if is_circle(points, base * scale))
    thick = [points for points, width in lines if abs(width - THICK.width) < 1e-3]
    drawn = (max(thick, key=len) - centre) / scale
    true = cam_points(SCENES[name], step=0.05)
    profile = true["profile_x_mm"] + 1j * true["profile_y_mm"]
    for points, line in ((drawn, profile), (profile, drawn)):
        path = LineString(np.column_stack([line.real, line.imag]))
        off = max(path.distance(point) for point in MultiPoint(np.column_stack([points.real, points.imag])).geoms)
        assert off <= told.curves["profile"].deviation_mm + 1e-3


@pytest.mark.slow
def test_the_groove_in_a_pdf_is_that_of_the_cam_at_its_scale(page):
    found, told = page("feeder-with-stop")
    scale, true = sheet("feeder-with-stop").scale, cam_points(CYLINDER, step=0.1)
    around, middle = (
        2 * pi * CYLINDER.cam.mean_radius,
        1j * (np.ptp(true["pitch_y_mm"]) - CYLINDER.part.thickness) / 2,
    )
    lines = [points for points, width in lines_of(found) if abs(width - THICK.width) < 1e-3]
    (corner,) = (p[0] for p in lines if len(p) == 5 and abs(np.ptp(p.real) - around * scale) < 1e-3)
    drawn = [(p - corner) / scale + middle for p in lines if len(p) > 100]
    for side in ("left", "right"):
        flank = true[f"profile_{side}_x_mm"] + 1j * true[f"profile_{side}_y_mm"]
        inside = MultiPoint([(z.real, z.imag) for z in flank if 0.0 < z.real < around])
        off = [max(LineString(np.column_stack([p.real, p.imag])).distance(z) for z in inside.geoms) for p in drawn]
        assert min(off) <= told.curves[f"profile_{side}"].deviation_mm + 1e-3


def test_text_is_as_wide_as_it_is_taken_for(page):
    found, _ = page("valve-rod-radial")
    spans = [
        (span["text"], span["bbox"])
        for block in found.get_text("dict")["blocks"]
        for line in block.get("lines", ())
        if abs(line["dir"][0] - 1.0) < 1e-9
        for span in line["spans"]
    ]
    marks = [mark for mark in sheet("valve-rod-radial").marks if isinstance(mark, Words)]
    heights = {mark.text: mark.height for mark in marks if len(mark.text) > 6}
    compared = [(text_width(text, heights[text]), (box[2] - box[0]) * MM) for text, box in spans if text in heights]
    assert len(compared) > 20
    for ours, theirs in compared:
        assert ours == pytest.approx(theirs, rel=0.01)


@given(st.lists(st.floats(0, 6.28), min_size=1, max_size=40), st.floats(1e-3, 0.1))
def test_names_are_spread_as_far_as_needed_and_no_further(turns, apart):
    wanted = np.sort(turns)
    found = spread_directions(wanted, apart)
    assert np.all(np.diff(found) >= apart * (1 - 1e-9) - 1e-12)
    assert found.mean() == pytest.approx(wanted.mean(), abs=1e-9)
    if wanted.size > 1 and np.diff(wanted).min() >= apart:
        assert found == pytest.approx(wanted, abs=1e-9)


@given(st.lists(st.floats(-20, 20), min_size=1, max_size=30))
def test_names_begin_past_the_widest_gap(turns):
    names, found = sort_after_widest_gap([(turn, str(k)) for k, turn in enumerate(turns)])
    assert np.all(np.diff(found) >= 0)
    assert 2 * pi - (found[-1] - found[0]) >= np.diff(found).max(initial=0.0) - 1e-9
    for name, turn in zip(names, found, strict=True):
        assert abs(np.angle(np.exp(1j * (turn - turns[int(name)])))) < 1e-9


@given(st.text(max_size=300), st.floats(5, 200), st.integers(1, 3))
def test_a_text_fits_where_it_is_put(text, width, lines):
    found, height = fitted_lines_and_height(text, width, lines, (3.5, 2.5, 1.8))
    assert 1 <= len(found) <= lines
    assert all(text_width(each, height) <= width or len(each) == 1 for each in found)
    if not found[-1].endswith("…"):
        assert "".join("".join(found).split()) == "".join(text.split())


@given(
    st.fixed_dictionaries(
        {key: st.text(max_size=120) for key in ("name", "number", "material", "hardness", "designer")}
    )
)
def test_a_title_block_holds_any_text(given_texts):
    part = PLATE.part.model_copy(update=given_texts)
    places = STANDARDS["mm"].title_fields(part, part.name, "1:1", "A3", "1/1")
    assert words_outside(places, title_block(places, part.language)) == []


@given(st.floats(1e-3, 1e5))
def test_small_cams_are_enlarged_and_no_others(size):
    first = next(paper_scales(size))
    assert first >= 1.0
    assert (first == 1.0) == (size >= 40.0)
    assert size * first >= 40.0 - 1e-9
    assert first == 1.0 or size * first < 40.0 * 2.5 * (1 + 1e-9)


@pytest.mark.parametrize(
    ("value", "text"), [(25.0, "25"), (1.23456, "1.235"), (-2.5, "−2.5"), (-1e-9, "0"), (20000.0, "20000")]
)
def test_numbers_have_no_more_decimals_than_they_need(value, text):
    assert decimal_text(value) == text


def test_the_frame_is_that_of_the_standard():
    """ISO 5457: 20 mm where sheets are bound, 10 mm elsewhere; a title block of 180 mm fills the frame of A4."""
    assert A4.frame.size == complex(180, 277)
    assert A3.frame.size == complex(390, 277)
    assert hypot(A4.width, A4.height) == pytest.approx(210 * 3**0.5, rel=1e-3)
    assert degrees(np.angle(complex(A3.width, A3.height))) == pytest.approx(35.26, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("tip", [{"contact": "knife"}, {"contact": "spherical", "face_radius": 9}])
def test_a_groove_has_a_sheet_for_every_tip(tip, tmp_path):
    """The cylinder is as long as the path of the trace point and its groove ask, drawn or not."""
    groove = find_scene("feeder-with-stop")
    tips = {f"follower.{key}": value for key, value in {"roller_radius": None, **tip}.items()}
    written = export(groove.replace(**tips), tmp_path / "groove.pdf")
    assert {"profile_left", "profile_right"} <= written.curves.keys()
    words = pymupdf.open(tmp_path / "groove.pdf")[0].get_text()
    point = {"knife": "knife edge", "spherical": "face centre"}[tip["contact"]]
    assert f"{point} x round the mean radius" in words


@pytest.mark.parametrize("offset", [0, 12, -12])
def test_lines_of_angles_lead_to_the_ends_of_the_arcs_of_the_profile(offset):
    """Ends of the upper dwell's arc as the profile's own radius says: the largest, to rounding."""
    kept = {"cam.base_radius": 45, "follower.roller_radius": 8, "follower.offset": offset}
    motion = turning([("rise", 100), ("dwell", 80), ("return", 120), ("dwell", 60)], 20)
    scene = find_scene("roller-1000rpm").replace(**kept, motion=motion)
    cam = TrueCam(scene, resolve_design(scene))
    view = FrontView(cam, 1.0)
    points = cam.curve("profile")
    top = np.angle(points[np.abs(points) > np.abs(points).max() - 1e-3])
    middle = np.angle(np.exp(1j * top).sum())
    ends = np.sort(np.angle(np.exp(1j * (top - middle))))[[0, -1]]
    joints = np.sort(np.angle(np.exp(1j * (np.array(view.contact_directions[1:3]) - middle))))
    assert joints == pytest.approx(ends, abs=0.05)
    assert np.ptp(joints) == pytest.approx(np.radians(80), abs=1e-9)
    aside = np.degrees(cam.contact_direction_offsets_from_rays)
    turned = np.degrees(
        np.arctan2(offset, np.sqrt(53**2 - 12**2)) - np.arctan2(offset, np.sqrt(53**2 - 12**2) + 20)
    )
    assert np.abs(aside) == pytest.approx([0, *[abs(turned) if offset else 0] * 2, 0], abs=1e-6)
    feet = sorted(np.angle(mark.points[0]) for mark in view._ray_lines())
    assert feet == pytest.approx(sorted(np.angle(np.exp(1j * np.array(view.contact_directions)))))
    noted = " ".join(
        mark.text for mark in sheet_of(TrueCam(scene, resolve_design(scene))).marks if isinstance(mark, Words)
    )
    assert ("Bent lines" in noted) == bool(offset)

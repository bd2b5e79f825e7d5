"""Drawings of pairs of discs, yokes, ribs and grooves with clearance, against slow re-contact and ISO 286."""

import re
from functools import cache

import ezdxf
import numpy as np
import pymupdf
import pytest
import shapely
from scipy.optimize import brentq
from support.pairs import centres, nearest_points, pair, profiles, yoke
from support.ribs import centres as rib_centres
from support.ribs import flanks as rib_flanks
from support.ribs import rib
from support.sheets import faults_of
from test_sheet import sorted_columns

from camopt import Scene, evaluate, export, find_scene
from camopt.scene.problem.problem import resolve_design
from camopt.show.sheet.callouts import MARK_LENGTH
from camopt.show.sheet.developed import DevelopedView
from camopt.show.sheet.front_view import FrontView
from camopt.show.sheet.marks import CHAIN, HIDDEN, THICK, Line, Words
from camopt.show.sheet.notes import note_texts
from camopt.show.sheet.sheet import sheets_of
from camopt.show.sheet.true_cam import TrueCam
from camopt.show.sheet.two_contacts import contact_distance

PART = {"thickness": 16, "disc_gap": 5, "hub_diameter": 50, "hub_length": 48, "bore": 25, "profile_tolerance": 0.01}
FEED = find_scene("press-feed-by-pair")
PUMP = find_scene("pump-of-constant-breadth")
SHUTTER = find_scene("face-groove-shutter")
SCENES = {"feed": FEED, "slide": Scene.from_dict(pair(np.random.default_rng(3), "translating") | {"part": PART})}
YOKES = {
    "flat": PUMP,
    "rollers": Scene.from_dict(yoke(np.random.default_rng(2), "diameter") | {"part": {"profile_tolerance": 0.01}}),
}


@cache
def sheets(name):
    return sheets_of(SCENES[name], resolve_design(SCENES[name]))


def texts(marks):
    return [mark.text for mark in marks if isinstance(mark, Words)]


def angles_of(count):
    return np.arange(count) * 2.0 * np.pi / count


def shape(points):
    return shapely.Polygon(np.column_stack([points.real, points.imag]))


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_each_disc_of_a_pair_has_a_sheet_at_one_scale_on_which_nothing_overlaps(name):
    found = sheets(name)
    assert [faults_of(sheet) for sheet in found] == [[], []]
    assert len({sheet.scale for sheet in found}) == 1
    assert [[text for text in texts(sheet.marks) if text in ("1/2", "2/2")] for sheet in found] == [
        ["1/2"],
        ["2/2"],
    ]


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("name", SCENES)
def test_both_tables_are_from_one_zero(name, place):
    """φ and r of each disc are where the roller of the rigid follower touches it, in the frame of the cam."""
    problem, found = resolve_design(SCENES[name]), sheets(name)[place]
    rows = 72 if "355" in texts(found.marks) else 36
    turns, table, sense = angles_of(rows), sorted_columns(found, rows, 5), problem.design.sense
    for columns, points in (
        (table[:, 1:3], nearest_points(problem, place, turns)[0]),
        (table[:, 3:5], centres(problem, turns)[place]),
    ):
        own = points * np.exp(-1j * sense * turns)
        drawn = columns[:, 1] * 1j * np.exp(-1j * sense * np.radians(columns[:, 0]))
        assert np.abs(drawn - own).max() < 2e-3  # 0.0005° and 0.0005 mm at about 100 mm


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", SCENES)
def test_the_front_views_show_both_profiles_in_their_true_phase_and_one_timing_mark(name):
    """In full lines that of the sheet, dashed the other one; the mark is where the first disc ends."""
    problem = resolve_design(SCENES[name])
    true = [shape(points).exterior for points in profiles(problem, angles_of(7200))]
    up = shapely.LineString([(0.0, 0.0), (0.0, 500.0)])
    for place in (0, 1):
        view = FrontView(sheets(name)[place].cam, 1.0)
        lines = [mark for mark in view.marks() if isinstance(mark, Line)]
        for pen, profile in ((THICK, true[place]), (HIDDEN, true[1 - place])):
            drawn = max((m.points for m in lines if m.pen == pen), key=lambda points: np.abs(points).max())
            points = shapely.points(np.column_stack([drawn.real, drawn.imag]))
            assert shapely.distance(points, profile).max() < 3e-3
        assert view.timing_mark_radius == pytest.approx(up.intersection(true[0]).bounds[1], abs=0.05)
        marks = [m.points for m in sheets(name)[place].marks if isinstance(m, Line) and m.pen == THICK]
        assert sum(len(m) == 2 and abs(m[1] - m[0] - 1j * MARK_LENGTH) < 1e-9 for m in marks) == 1


def test_the_section_has_both_plates_their_gap_and_the_hub():
    """The first disc in front, and so on the right; each is cut where its profile passes the axis of the keyway."""
    found, scale = sheets("feed")[0].marks, sheets("feed")[0].scale
    assert {"22", "6", "64", "Ø90", "Ø50 H7", "53.8 +0.2"} <= {*texts(found)}
    thick = [m.points for m in found if isinstance(m, Line) and m.pen == THICK]
    lines = shapely.MultiLineString([np.column_stack([points.real, points.imag]) for points in thick])
    numbers = {m.text: m.at for m in found if isinstance(m, Words) and m.text in "12" and m.height > 3.0}
    assert (numbers["1"] - numbers["2"]).real / scale == pytest.approx(28.0)
    (axis,) = {
        m.points[0].imag
        for m in found
        if isinstance(m, Line) and m.pen == CHAIN and np.ptp(m.points.real) / scale == pytest.approx(64 + 8 / scale)
    }
    for number, points in zip("12", profiles(resolve_design(FEED), angles_of(7200)), strict=True):
        x = numbers[number].real
        levels = shapely.get_coordinates(shapely.LineString([(x, 0.0), (x, 300.0)]).intersection(lines))[:, 1]
        cut = shape(points).intersection(shapely.LineString([(0.0, -500.0), (0.0, 500.0)])).bounds
        for end in cut[1::2]:
            assert np.abs((levels - axis) / scale - end).min() < 2e-3


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", SCENES)
def test_the_rollers_move_as_far_as_the_profiles_are_off(name):
    """Each roller on a profile that is larger by the tolerance, as shapely grows it; the angle, or distance."""
    scene, problem = SCENES[name], resolve_design(SCENES[name])
    second = problem.setup.mechanism.further_contacts[0].local_designs(problem.design)
    tolerance, turns = 0.01, angles_of(45)
    found = contact_distance(TrueCam(scene.replace(**{"part.profile_tolerance": tolerance}), problem)).variation
    grown = [shape(points).buffer(tolerance, quad_segs=64) for points in profiles(problem, angles_of(7200))]
    radii = [float(d.roller_radius[0]) for d in (problem.design, second)]
    pivot = float(problem.design.centre_distance[0])
    moved = np.zeros(turns.size)
    for place, (disc, radius, way) in enumerate(zip(grown, radii, (1.0, -1.0), strict=True)):
        for k, (turn, centre) in enumerate(zip(turns, centres(problem, turns)[place], strict=True)):

            def gap(shift, turn=turn, centre=centre, disc=disc, radius=radius, way=way):
                there = pivot + (centre - pivot) * np.exp(-1j * way * shift) if pivot else centre + 1j * way * shift
                there *= np.exp(-1j * problem.design.sense * turn)
                return disc.distance(shapely.Point(there.real, there.imag)) - radius

            moved[k] += brentq(gap, -5e-4 if pivot else -0.05, 1e-3 if pivot else 0.1, xtol=1e-9)
    largest = np.degrees(moved.max()) if pivot else moved.max()
    assert 0.97 * found <= largest <= 1.01 * found


@pytest.mark.slow
def test_the_notes_of_a_pair_have_what_its_follower_is_and_how_it_is_inspected():
    told = " ".join(note_texts(sheets("feed")[1].cam))
    for words in (
        "Disc 1: for an oscillating follower with a roller Ø32, arm 110",
        "Disc 2: for an oscillating follower with a roller Ø32, arm 100",
        "disc 2 in full lines, disc 1 dashed. Both tables are from the same timing mark, on disc 1.",
        "Angle between both arms 90.602°, made 90.592° for an interference of 0.01°.",
        "over a turn: angle between the arms 90.602° ±0.0059°.",
    ):
        assert words in told
    assert f"mass {evaluate(FEED.replace(outputs=['solid']))['cam_mass_kg']:.4g} kg" in told  # of both, on a hub
    assert "may be lost" not in told
    thin = FEED.replace(**{"part.profile_tolerance": 0.01})
    assert "the interference may be lost: clearance up to 0.0018°" in " ".join(
        note_texts(sheets_of(thin, resolve_design(thin))[0].cam)
    )
    hubless = FEED.replace(**{"part.hub_diameter": None, "part.hub_length": None, "part.number": "SF-1"})
    loose = TrueCam(hubless, resolve_design(hubless)).cam_of_each_sheet
    assert [each.part.number for each in loose] == ["SF-1/1", "SF-1/2"]
    assert [each.title for each in loose] == [f"{FEED.part.name}, disc {k}" for k in (1, 2)]
    assert {each.cam.title for each in sheets("feed")} == {FEED.part.name}  # of one part
    assert "from the same timing mark, which each disc has." in " ".join(note_texts(loose[0]))
    both = evaluate(hubless.replace(outputs=["solid"]))["cam_mass_kg"]
    assert sum(each.mass for each in loose) == pytest.approx(both, rel=1e-9)


@pytest.mark.slow
def test_a_pdf_of_a_pair_has_both_sheets(tmp_path):
    told = export(FEED, tmp_path / "pair.pdf")
    assert {"profile", "second_profile"} <= told.curves.keys()
    assert told.about == {"paper": "A3", "scale": "1:2"}
    pages = [page.get_text() for page in pymupdf.open(tmp_path / "pair.pdf")]
    assert ["disc 1 in full" in text for text in pages] == [True, False]
    assert ["disc 2 in full" in text for text in pages] == [False, True]


@pytest.mark.long
def test_a_pdf_of_one_disc_has_its_sheet(tmp_path):
    assert set(export(FEED, tmp_path / "two.pdf", disc=2).curves) == {"second_pitch", "second_profile"}
    (second,) = [page.get_text() for page in pymupdf.open(tmp_path / "two.pdf")]
    assert "disc 2 in full" in second


def ends_of(entity):
    """The points of a line, or of an arc with chords that are off by 10⁻⁵ mm."""
    if entity.dxftype() == "LINE":
        return [entity.dxf.start.vec2, entity.dxf.end.vec2]
    return [point.vec2 for point in entity.flattening(1e-5)]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", SCENES)
def test_both_rollers_stay_on_their_flanks_of_a_dxf_as_the_assembly_turns(name, tmp_path):
    scene, problem = SCENES[name], resolve_design(SCENES[name])
    told = export(scene, tmp_path / "pair.dxf")
    space = ezdxf.readfile(tmp_path / "pair.dxf").modelspace()
    turns = angles_of(48)
    second = problem.setup.mechanism.further_contacts[0].local_designs(problem.design)
    for place, (layer, design) in enumerate((("PROFILE", problem.design), ("SECOND_PROFILE", second))):
        (line,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
        edge = shapely.MultiLineString([ends_of(each) for each in line.virtual_entities()])
        own = centres(problem, turns)[place] * np.exp(-1j * problem.design.sense * turns)
        gaps = [edge.distance(shapely.Point(p.real, p.imag)) - design.roller_radius[0] for p in own]
        assert np.abs(gaps).max() <= told.curves[layer.lower()].deviation_mm + 2e-5
        (circle,) = space.query(f'CIRCLE[layer=="{layer.replace("PROFILE", "BASE-CIRCLE")}"]')
        assert circle.dxf.radius == pytest.approx(design.size[0])
        assert shapely.Point(0, 0).distance(edge) == pytest.approx(design.size[0], abs=2e-3)


@pytest.mark.parametrize("name", YOKES)
def test_the_breadth_of_a_yoke_is_dimensioned_with_its_tolerance(name):
    """Between parallel lines in twelve directions; of rollers between the centres of those that touch there."""
    scene, problem = YOKES[name], resolve_design(YOKES[name])
    (sheet,) = sheets_of(scene, problem)
    cam, turns = sheet.cam, angles_of(7200)
    found, points = contact_distance(cam), cam.curves_at(turns).pitch
    if name == "flat":
        directions = np.exp(1j * angles_of(12))[:, None]
        sizes = np.ptp((points * directions.conj()).real, axis=1)
        assert found.variation == pytest.approx(0.02)
    else:
        sizes = np.abs(points - np.roll(points, 3600))
        assert 0.02 < found.variation < 0.03
    assert np.ptp(sizes) < 1e-4
    assert found.value == pytest.approx(sizes.mean(), abs=1e-4)
    assert faults_of(sheet) == []
    assert texts(sheet.marks).count(found.toleranced_text) == 1
    told = " ".join(note_texts(cam))
    kind = "two flat faces" if name == "flat" else "two rollers Ø16"
    assert f"For a yoke with {kind}." in told
    assert told.count(found.toleranced_text) == 1


RIBS = {
    "nozzles": find_scene("bottle-filler-by-rib"),
    "arm": Scene.from_dict(
        rib(np.random.default_rng(1), "oscillating")
        | {"part": {"thickness": 200, "rib_height": 12, "bore": 30, "profile_tolerance": 0.02, "language": "de"}}
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RIBS)
def test_a_rib_has_one_sheet_with_both_flanks_and_rollers(name):
    """The table where the rigid follower has its rollers; the section where its flanks are there."""
    scene, problem = RIBS[name], resolve_design(RIBS[name])
    (sheet,) = sheets_of(scene, problem)
    assert faults_of(sheet) == []
    assert [text for text in texts(sheet.marks) if re.fullmatch(r"\d/\d", text)] == ["1/1"]
    turns, columns = angles_of(36), ["s", "x1", "y1", "y2"] if name == "nozzles" else ["s", "x1", "y1", "x2", "y2"]
    commas = [m._replace(text=m.text.replace(",", ".")) if isinstance(m, Words) else m for m in sheet.marks]
    table = dict(zip(columns, sorted_columns(sheet._replace(marks=commas), 36, len(columns)).T, strict=True))
    for number, centre in enumerate(rib_centres(problem, turns), start=1):
        assert np.abs(table.get(f"x{number}", table["x1"]) - centre.real).max() < 6e-4
        assert np.abs(table[f"y{number}"] - centre.imag).max() < 6e-4
    view, angles = DevelopedView(sheet.cam, 1.0), np.linspace(-0.5, 7.0, 20001)
    edges = rib_flanks(problem, angles)
    for gap, turn in zip(view._groove_ranges_in_section, view._section_angles, strict=True):
        x = turn % (2 * np.pi) * problem.design.size[0]
        true = [np.interp(x, edge.real, edge.imag) - view.axial_ends[0] for edge in edges[::-1]]
        assert gap == pytest.approx(true, abs=5e-3)
    if name == "nozzles":
        assert {"30", "16", "Ø224", "Ø256"} <= set(texts(sheet.marks))
        told = " ".join(note_texts(sheet.cam))
        for words in (
            "two rollers Ø30, distance of the rollers 60",
            "60, made 59.96 for an interference of 0.04",
            "at the foot of the rib",
        ):
            assert words in told


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["translating", "oscillating"])
def test_a_rib_on_a_disc_has_one_sheet_with_both_flanks_and_rollers(motion):
    """The table where the rigid follower has its rollers; the section between the flanks in the vertical plane."""
    part = {"thickness": 30, "rib_height": 14, "bore": 40, "outer_diameter": 320, "profile_tolerance": 0.02}
    scene = Scene.from_dict({**rib(np.random.default_rng(1), motion, "disc"), "part": part})
    problem = resolve_design(scene)
    (sheet,) = sheets_of(scene, problem)
    assert faults_of(sheet) == []
    assert {"14", "30", "Ø320", "Ø40"} <= set(texts(sheet.marks))
    turns, table = angles_of(36), sorted_columns(sheet, 36, 5).T
    for (turned, radius), centre in zip((table[1:3], table[3:5]), rib_centres(problem, turns), strict=True):
        assert np.abs(radius - np.abs(centre)).max() < 6e-4
        off = np.degrees(np.angle(centre / 1j * np.exp(1j * problem.design.sense * np.radians(turned))))
        assert np.abs(off).max() < 6e-4
    told = " ".join(note_texts(sheet.cam))
    assert "Centres of rollers 1, outside of the rib, and 2, within it." in told
    front = FrontView(sheet.cam, 1.0)
    edges = rib_flanks(problem, np.linspace(0.0, 2.0 * np.pi, 20_001))[::-1]
    for wall, edge in zip(front.walls, edges, strict=True):
        assert [np.abs(wall).min(), np.abs(wall).max()] == pytest.approx(
            [np.abs(edge).min(), np.abs(edge).max()], abs=0.02
        )


@pytest.mark.slow
def test_a_groove_is_dimensioned_by_its_fit_and_its_clearance_is_noted(tmp_path):
    """F8 of 12 mm leaves 16 to 43 µm (ISO 286-2); without a fit the walls have their tolerance."""
    problem = resolve_design(SHUTTER)
    (sheet,) = sheets_of(SHUTTER, problem)
    assert faults_of(sheet) == []
    assert {"12 F8", "9"} <= set(texts(sheet.marks))
    assert texts(sheet.marks).count("C") == 2 + 2  # the frame, the face, and the zones of the paper
    assert "Clearance of the roller Ø12 in its groove 0.02, from 0.016 to 0.043." in " ".join(note_texts(sheet.cam))
    loose = SHUTTER.replace(**{"part.groove_fit": None, "drive.clearance": 0.03})
    other = TrueCam(loose, resolve_design(loose))
    assert "Ø12 in its groove 0.03, from −0.01 to 0.07." in " ".join(note_texts(other))
    (note,) = (note for note in export(loose, tmp_path / "b.pdf").notes if "clearance" in note)
    assert note.startswith("drive.clearance is 0.03 mm, but the tolerance of both walls gives ")
    assert note.endswith(" a clearance from -0.01 mm to 0.07 mm")

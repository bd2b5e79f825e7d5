"""Solids read back: as Open CASCADE measures them, against exact curves and areas, and a roller in its groove."""

import re
import sys
from math import pi

import numpy as np
import pytest
import shapely
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.Geom import Geom_BSplineSurface
from OCP.GeomAbs import GeomAbs_BSplineCurve, GeomAbs_Circle, GeomAbs_Line
from OCP.TopoDS import TopoDS
from support.cams import cam_with
from support.depth import covering_cases
from support.solids import enclosed_area, hole, solids_in

from camopt import BadInput, Scene, evaluate, export, find_scene, shipped_scenes
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve_design
from camopt.show.exporting import shapes, step, stl
from camopt.show.exporting.groove import largest_undercut_radius, workpiece_groove
from camopt.show.exporting.solid import solid_of
from camopt.show.exporting.step import iso_10303_text
from camopt.show.exporting.stl import enclosed_volume, is_watertight, read_triangles
from camopt.show.exporting.workpiece import Workpiece

CHORD = 0.001
KEYWAY = {"keyway_width": 4, "keyway_depth": 1.8, "keyway_angle": 37}
WITHOUT: dict[str, None] = dict.fromkeys(KEYWAY)
PLATE = {"thickness": 16, "bore": 12, **KEYWAY, "hub_diameter": 24, "hub_length": 30}
CYLINDER = {"thickness": 70, "bore": 30, "groove_depth": 10, "density": 7800}
RIBBED = {"thickness": 110, "bore": 30, "rib_height": 10, "density": 7800}
DISCS = [n for n in shipped_scenes() if find_scene(n).mechanism.body.bounded and n != "press-feed-by-pair"]
RIB_ARM = cam_with("groove-arm", law="poly345", drive={"kind": "rib"}, part=RIBBED)
GROOVES = {
    "feeder": find_scene("feeder-with-stop"),
    **{
        f"{contact}-{way}": Scene.from_dict(cam_with(contact, law="poly345", rotation=way, part=CYLINDER))
        for contact in ("groove", "groove-arm")
        for way in ("ccw", "cw")
    },
    "rib": find_scene("bottle-filler-by-rib").replace(**{"part.density": 7850}),
    "rib-arm": Scene.from_dict({**RIB_ARM, "follower": RIB_ARM["follower"] | {"roller_spacing": 40}}),
}


def disc(scene, **part):
    return find_scene(scene).replace(**{"cam.shaft_diameter": None, "part": {**PLATE, **part}})


EDGES = {
    "arcs": {GeomAbs_Circle, GeomAbs_Line},
    "spline": {GeomAbs_BSplineCurve, GeomAbs_Circle, GeomAbs_Line},
}
"""What edges are, with those of the bore and of the hub."""


def kinds(solid):
    return {BRepAdaptor_Curve(TopoDS.Edge(edge)).GetType() for edge in shapes.subshapes(solid, shapes.EDGE)}


def read_back(path):
    """The one solid of a STEP file."""
    (solid,) = solids_in(path)
    return solid


def work_of(scene):
    return Workpiece(scene, resolve_design(scene))


def true_profile(scene, count=40_001):
    """Dense points of the profile, from ``cam_curves``."""
    problem = resolve_design(scene)
    starts = [stroke.start for stroke in problem.programme.strokes]
    angles = np.sort(np.append(np.linspace(0.0, 2 * pi, count), starts))
    found = cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles)
    return found.pitch - problem.design.roller_radius * found.normal


def largest_distance(points, lines):
    """The largest distance of points (n, 2) from lines through others."""
    each = [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
    tree = shapely.STRtree(shapely.linestrings(np.concatenate(each)))
    return tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)[1].max()


def rim(solid, height, beyond, count):
    """Points on the edges of a solid at a height that are further than a radius from the axis, edge by edge."""
    curves = [BRepAdaptor_Curve(TopoDS.Edge(edge)) for edge in shapes.subshapes(solid, shapes.EDGE)]
    ends = [[curve.Value(u) for u in (curve.FirstParameter(), curve.LastParameter())] for curve in curves]
    there = [
        curve
        for curve, (a, b) in zip(curves, ends, strict=True)
        if max(abs(a.Z() - height), abs(b.Z() - height)) < 1e-6 and np.hypot(a.X(), a.Y()) > beyond
    ]
    for curve in there:
        share = np.linspace(curve.FirstParameter(), curve.LastParameter(), count // len(there)).tolist()
        yield np.array([[p.X(), p.Y()] for p in map(curve.Value, share)])


def kind_of(case):
    """What the solids of scenes differ by: the follower that makes the profile, and what edges it has."""
    name, curves = case
    scene = find_scene(name)
    return (name,), (scene.follower.motion, scene.follower.contact, bool(scene.profile), curves)


CASES = [(name, curves) for curves in ("arcs", "spline") for name in DISCS]


@pytest.mark.slow
@pytest.mark.one_in(14)
@pytest.mark.parametrize(("name", "curves"), covering_cases(CASES, kind_of))
def test_a_disc_read_back_is_whole_as_large_as_green_says_and_within_the_chord_both_ways(name, curves, tmp_path):
    scene = disc(name)
    told = step.write(work_of(scene), tmp_path / "cam.step", CHORD, curves)
    off, solid, true = told.curves["profile"].deviation_mm, read_back(tmp_path / "cam.step"), true_profile(scene)
    assert shapes.has_valid_solids(solid)
    assert off <= CHORD
    assert kinds(solid) == EDGES[curves]
    length = np.abs(np.diff(true)).sum()
    expected = 16 * enclosed_area(true) + 14 * pi * 12**2 - 30 * hole(PLATE)
    assert abs(shapes.shape_volume(solid) - expected) <= 16 * length * off + 1e-7 * expected
    measured = shapes.shape_counts_and_volume(solid)
    assert {key: told.about[key] for key in ("faces", "edges")} == {
        key: measured[key] for key in ("faces", "edges")
    }
    bottom, line = list(rim(solid, 0.0, 12.5, 24_000)), np.column_stack([true.real, true.imag])
    points = np.concatenate([*bottom, *rim(solid, 16.0, 12.5, 1000)])
    assert largest_distance(points[::10], [line]) <= off + 1e-5  # of the dense points
    assert largest_distance(line[::20], bottom) <= off + 1e-5


def test_two_ways_of_a_profile_have_different_points():
    """What ``furthest`` finds: 1 mm between circles."""
    inner, outer = (r * np.exp(1j * np.linspace(0.0, 2 * pi, 9001)) for r in (10.0, 11.0))
    pairs = [np.column_stack([points.real, points.imag]) for points in (inner, outer)]
    assert largest_distance(pairs[0], [pairs[1]]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "part",
    [
        {},
        {"hub_diameter": 46, "hub_length": 20},  # wider than all else that is given
        {"hub_length": 16},  # no longer than the plate
        WITHOUT,
        {"bore": None, **WITHOUT},
        {"hub_diameter": 50, "hub_length": 20},  # as wide as the dwell of the profile
    ],
)
def test_volumes_of_plate_hub_bore_and_keyway_add_up(part, tmp_path):
    scene = find_scene("flat-reciprocating").replace(part={**PLATE, **part})
    told = step.write(work_of(scene), tmp_path / "cam.step", CHORD)
    sizes = {key: value for key, value in {**PLATE, **part}.items() if value is not None}
    true, plate, whole = true_profile(scene), sizes["thickness"], sizes["hub_length"]
    inside = hole(sizes) if "bore" in sizes else 0.0
    expected = plate * enclosed_area(true) + (whole - plate) * pi / 4 * sizes["hub_diameter"] ** 2 - whole * inside
    assert told.about["volume_mm3"] == pytest.approx(expected, rel=2e-5)
    assert shapes.shape_volume(read_back(tmp_path / "cam.step")) == pytest.approx(
        told.about["volume_mm3"], rel=1e-9
    )


@pytest.mark.slow
@settings(max_examples=8, phases=[Phase.explicit, Phase.generate])
@given(
    thickness=st.floats(0.5, 200),
    bore=st.floats(0.5, 30),
    share=st.floats(0.1, 0.9),
    depth=st.floats(0.1, 5),
    angle=st.floats(-360, 360),
    wider=st.floats(0.5, 40),
    longer=st.sampled_from([0.0, 1e-14, 1e-6, 0.3, 44.0]),
)
def test_any_part_that_goes_together_is_a_solid(thickness, bore, share, depth, angle, wider, longer):
    keyway = {"keyway_width": share * bore, "keyway_depth": depth, "keyway_angle": angle}
    reach = np.hypot(bore / 2 + depth, share * bore / 2)
    base = find_scene("exhaust-valve").cam.base_radius
    hub = {"hub_diameter": 2 * min(reach + wider, base), "hub_length": thickness + longer}
    part = {"thickness": thickness, "bore": bore, **keyway, **hub}
    scene = find_scene("exhaust-valve").replace(part=part)
    found = solid_of(work_of(scene), 0.01, "arcs")
    area = enclosed_area(true_profile(scene, 5001))
    expected = thickness * area + longer * pi / 4 * hub["hub_diameter"] ** 2 - (thickness + longer) * hole(part)
    assert shapes.shape_volume(found.shape) == pytest.approx(expected, rel=1e-3)


def furthest_from_axis(scene, points):
    """The radius of a roller, and the least distance over the turn of points (n, 3) of a cam from its axis.

    From where the follower puts it as the cam turns. On the wall of a groove both are the same.
    """
    problem, angles = resolve_design(scene), np.linspace(0.0, 2 * pi, 60_001)
    lift, y = problem.programme.lift, problem.programme.motion_at(angles)[0]
    arm, apart = scene.follower.arm_length, scene.follower.roller_spacing or 0.0
    half = np.arcsin(apart / 2 / arm) if arm else apart / 2
    rollers = []
    for psi in (y - lift / 2 + half, y - lift / 2 - half):  # of a groove one and the same
        x, z = np.zeros_like(y), psi  # across the cam's axis, and along it from the middle of the cam
        if arm:  # its pivot is to the right, its line of contact through both ends of the swing
            x, z = arm * (np.cos(lift / 2) - np.cos(psi)), arm * np.sin(psi)
        rollers.append((x, z))
    turn = np.exp(1j * problem.design.sense * angles)
    found = []
    for px, py, pz in points:
        seen = (px + 1j * py) * turn  # as the cam turns, with the follower above
        away = np.min([np.hypot(seen.real - x, pz - scene.part.thickness / 2 - z) for x, z in rollers], axis=0)
        found.append(np.where(seen.imag > 0.0, away, np.inf).min())
    return scene.follower.roller_radius, np.array(found)


def walls(solid):
    """The B-spline surfaces of a solid, each with the ends of both of its parameters."""
    for each in shapes.subshapes(solid, shapes.FACE):
        surface = BRep_Tool.Surface_s(TopoDS.Face(each))
        if isinstance(surface, Geom_BSplineSurface):
            yield surface, surface.Bounds()


@pytest.mark.slow
@pytest.mark.one_in(9)
@pytest.mark.parametrize("name", GROOVES)
def test_a_groove_read_back_is_whole_and_touches_its_roller_at_every_depth(name, tmp_path):
    scene = GROOVES[name]
    told = step.write(work_of(scene), tmp_path / "cam.step", CHORD)
    solid = read_back(tmp_path / "cam.step")
    assert shapes.has_valid_solids(solid)
    assert told.about["wall_deviation_measured_mm"] <= CHORD
    mass = evaluate(scene.replace(outputs=["cam_mass_kg"]))["cam_mass_kg"]
    assert told.about["volume_mm3"] == pytest.approx(mass / scene.part.density * 1e9, rel=1e-4)
    points = []
    for surface, (u0, u1, v0, v1) in walls(solid):
        for u, v in np.random.default_rng(1).uniform((u0, v0), (u1, v1), (12, 2)).tolist():
            place = surface.Value(u, v)
            points.append((place.X(), place.Y(), place.Z()))
    depth = np.hypot(*np.array(points).T[:2]) - scene.cam.mean_radius
    assert np.ptp(depth) > 0.8 * (scene.part.groove_depth or scene.part.rib_height)
    radius, away = furthest_from_axis(scene, points)
    assert np.abs(away - radius).max() <= told.about["wall_deviation_measured_mm"] + 1e-5  # of the angles


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", GROOVES)
def test_the_true_wall_is_on_the_solid(name, tmp_path):
    work = work_of(GROOVES[name])
    solid, groove = solid_of(work, CHORD, "arcs"), workpiece_groove(work)
    middle = work.part.thickness / 2 - (0.0 if work.problem.setup.angular else work.problem.programme.lift / 2)
    for sector in groove.sectors():
        for side in (-1.0, 1.0):
            angles = np.linspace(sector.start, sector.end, 4)[1:-1]
            places = groove.wall_points(
                sector.span, angles, np.array([groove.inner + 0.3, groove.outer - 0.7]), side
            )
            for x, y, z in groove.xyz_points(places).reshape(-1, 3).tolist():
                vertex = shapes.make_vertex((x, y, z + middle))
                assert BRepExtrema_DistShapeShape(vertex, solid.shape).Value() <= CHORD


@pytest.mark.parametrize("depth", [100, 119, 119.99])
def test_a_groove_almost_down_to_the_axis_is_refused(depth, tmp_path):
    scene = GROOVES["groove-arm-ccw"].replace(part={"thickness": 70, "groove_depth": depth})
    with pytest.raises(BadInput, match=f"part.groove_depth = {depth:g}.*: must be smaller"):
        stl.write(work_of(scene), tmp_path / "cam.stl")


def test_the_groove_of_a_small_cam_is_undercut_at_its_bottom_alone(tmp_path):
    """At the mean radius it is not, which is what ``undercut`` says."""
    scene = GROOVES["groove-ccw"].replace(**{"cam.mean_radius": 30, "part.bore": 5})
    deep = scene.replace(**{"part.groove_depth": 40})
    assert not evaluate(deep.replace(outputs=["undercut"]))["undercut"]
    assert largest_undercut_radius(workpiece_groove(work_of(deep))) < 30
    with pytest.raises(BadInput, match=r"part.groove_depth = 40.0: must be smaller: at the radius .* cut away"):
        step.write(work_of(deep), tmp_path / "cam.step")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["bucket-valve", "uniform-knife-offset", "tangent-cam"])
def test_triangles_of_a_disc_are_watertight_and_within_the_chord(name, tmp_path):
    scene = disc(name)
    told = stl.write(work_of(scene), tmp_path / "cam.stl", CHORD)
    triangles, off = read_triangles(tmp_path / "cam.stl"), told.curves["profile"].deviation_mm
    assert told.about["triangles"] == len(triangles)
    assert is_watertight(triangles)
    assert off <= CHORD
    true = true_profile(scene)
    expected = 16 * enclosed_area(true) + 14 * pi * 12**2 - 30 * hole(PLATE)
    surface = 16 * np.abs(np.diff(true)).sum() + 14 * 24 * pi + 30 * 12 * pi
    assert abs(enclosed_volume(triangles) - expected) <= CHORD * surface
    corners = triangles.reshape(-1, 3)
    profile = corners[(corners[:, 2] == 0.0) & (np.hypot(*corners.T[:2]) > 12.5)][:, :2]
    assert largest_distance(profile, [np.column_stack([true.real, true.imag])]) <= 1e-5


@pytest.mark.slow
def test_triangles_of_a_groove_are_watertight_and_touch_the_roller(tmp_path):
    scene, chord = GROOVES["groove-arm-cw"], 0.02
    told = stl.write(work_of(scene), tmp_path / "cam.stl", chord)
    triangles = read_triangles(tmp_path / "cam.stl")
    assert is_watertight(triangles)
    exact = step.write(work_of(scene), tmp_path / "cam.step").about["volume_mm3"]
    assert told.about["volume_mm3"] == pytest.approx(exact, rel=2e-4)
    middles = triangles.mean(axis=1)
    within = np.abs(np.hypot(*middles.T[:2]) - scene.cam.mean_radius) < 0.45 * scene.part.groove_depth
    on_wall = within & (middles[:, 2] > 0.0) & (middles[:, 2] < scene.part.thickness)
    radius, away = furthest_from_axis(scene, middles[on_wall][::10])
    assert np.abs(away - radius).max() <= chord


def test_what_leaks_is_found(tmp_path):
    stl.write(work_of(disc("bucket-valve")), tmp_path / "cam.stl", 0.1)
    triangles = read_triangles(tmp_path / "cam.stl")
    assert is_watertight(triangles)
    assert not is_watertight(triangles[1:])
    assert not is_watertight(np.concatenate([triangles[:1, ::-1], triangles[1:]]))
    assert not is_watertight(np.concatenate([triangles, triangles[:1], triangles[:1, ::-1]]))


def test_a_file_names_the_cam_and_is_the_same_each_time(tmp_path, capfd):
    scene = disc("bucket-valve", name="Nocke 'Ω' 5\\8", number="N-7 𝛼", designer="Ç. Ö.")
    for name in ("a.step", "b.step"):
        export(scene, tmp_path / name)
    assert capfd.readouterr() == ("", "")
    first, second = ((tmp_path / name).read_bytes() for name in ("a.step", "b.step"))
    assert first == second
    words = first.decode("ascii")
    assert "SI_UNIT(.MILLI.,.METRE.)" in words
    assert "1970-01-01T00:00:00" in words
    named = re.search(r"PRODUCT\('(.*?)','(.*?)','',", words.replace("\n", ""))
    assert named
    assert [decode_text(each) for each in named.groups()] == ["N-7 𝛼", "Nocke 'Ω' 5\\8"]


def decode_text(words):
    """A text of ISO 10303-21 as it is read."""
    known = re.sub(r"\\X[24]\\([0-9A-F]+)\\X0\\", lambda found: chr(int(found[1], 16)), words)
    return known.replace("''", "'").replace("\\\\", "\\")


@given(st.text(st.characters(exclude_categories=["Cs", "Cc"], exclude_characters="'\\")))
def test_any_name_can_be_read_in_a_file(words):
    written = iso_10303_text(words).ToCString()
    assert written.isascii()
    assert decode_text(written) == words


def test_each_size_that_lacks_is_told(tmp_path):
    scene = find_scene("feeder-with-stop").replace(part={"bore": 20})
    with pytest.raises(BadInput) as error:
        export(scene, tmp_path / "cam.step")
    assert [(each.key, each.allowed) for each in error.value.mistakes] == [
        ("part.thickness", "missing; a solid needs it"),
        ("part.groove_depth", "missing; a solid needs it"),
    ]


def test_a_shaft_as_wide_as_the_base_circle_leaves_no_solid(tmp_path):
    scene = find_scene("valve-rod-radial").replace(**{"cam.shaft_diameter": 50, "part": {"thickness": 16}})
    with pytest.raises(BadInput, match=r"cam.shaft_diameter = 50.0: must leave a wall to the base circle"):
        export(scene, tmp_path / "cam.stl")


def test_a_chord_wider_than_the_wall_is_refused(tmp_path):
    scene = disc("bucket-valve", bore=33.9, **WITHOUT, hub_diameter=34)
    with pytest.raises(BadInput, match=r"chord = 1: must be smaller: the wall around the bore has 0.05 mm"):
        export(scene, tmp_path / "cam.step", chord=1)
    assert not list(tmp_path.iterdir())


def test_what_is_too_small_for_a_solid_is_told(tmp_path):
    scene = find_scene("bucket-valve").replace(part={"thickness": 1e-9})
    with pytest.raises(BadInput, match=r"^bucket-valve: part: makes no valid solid at a chord of 0.001 mm"):
        step.write(work_of(scene), tmp_path / "cam.step", CHORD)
    assert not list(tmp_path.iterdir())


def test_without_the_library_one_message_says_what_to_install(tmp_path, monkeypatch):
    for name in [each for each in sys.modules if each.startswith(("camopt.show.exporting.", "OCP"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "OCP", None)
    for ending in ("step", "stl"):
        with pytest.raises(BadInput, match=r'pip install "camopt\[cad\]"') as error:
            export(disc("bucket-valve"), tmp_path / f"cam.{ending}")
        assert len(error.value.mistakes) == 1

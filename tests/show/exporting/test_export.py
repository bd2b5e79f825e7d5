"""Files for machines and other programs, read back by libraries that are not camopt's."""

import json
import os
import re
import subprocess
import sys
from xml.etree import ElementTree as Xml

import ezdxf
import numpy as np
import pytest
from ezdxf.math import Vec2, Vec3
from support.cams import CONTACTS, cam_with
from support.curves import largest_distance, true_points

from camopt import BadInput, Scene, cam_points, export, find_scene
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve_design
from camopt.show.exporting.file_types import FILE_TYPES
from camopt.show.exporting.groove import workpiece_groove
from camopt.show.exporting.workpiece import Workpiece
from camopt.solve.contour.curve import disc_curves

PART = {"thickness": 12, "bore": 20, "keyway_width": 6, "keyway_depth": 2.8, "hub_diameter": 34, "hub_length": 20}


def scene_of(name):
    return Scene.from_dict(cam_with(name)) if name in CONTACTS else find_scene(name)


def true_curve(scene, name, cutter_radius=None):
    problem = resolve_design(scene)
    return true_points(problem, disc_curves(problem, cutter_radius)[name].distance)


def layer_points(document, layer):
    """Dense points on the one curve of a layer, as ezdxf flattens it."""
    (entity,) = document.modelspace().query(f'*[layer=="{layer}"]')
    if entity.dxftype() == "LWPOLYLINE":
        found = [Vec3(*entity.get_points()[0][:2])]
        for part in entity.virtual_entities():
            if part.dxftype() == "LINE":
                found += [part.dxf.start, part.dxf.start.lerp(part.dxf.end), part.dxf.end]
            else:  # an ARC runs anticlockwise, whichever way the polyline does
                arc = list(part.flattening(1e-7))
                found += arc if arc[0].isclose(found[-1], abs_tol=1e-6) else arc[::-1]
    else:
        found = list(entity.flattening(1e-7))
    return np.array([complex(*Vec2(point)) for point in found])


@pytest.mark.slow
@pytest.mark.one_in(12)
@pytest.mark.parametrize("curves", ["arcs", "spline", "polyline"])
@pytest.mark.parametrize(
    "name", ["valve-rod-radial", "oscillating-roller", "tangent-cam", "uniform-knife-radial", "groove"]
)
def test_a_dxf_read_back_is_as_near_as_it_is_said_to_be(tmp_path, name, curves):
    scene, file = scene_of(name), tmp_path / "cam.dxf"
    cutter = 4.0 if scene.follower.contact == "roller" else None
    found = export(scene, file, curves=curves, chord=0.002, cutter_radius=cutter)
    document = ezdxf.readfile(file)
    assert document.units == ezdxf.units.MM
    assert not document.audit().has_errors
    for curve, about in found.curves.items():
        line, true = layer_points(document, curve.upper()), true_curve(scene, curve, cutter)
        assert max(largest_distance(line, true), largest_distance(true, line)) <= about.deviation_mm + 2e-5
        assert about.deviation_mm <= 0.002


def test_the_plan_has_the_part(tmp_path):
    scene = find_scene("roller-1000rpm").replace(part=PART)
    export(scene, tmp_path / "cam.dxf")
    space = ezdxf.readfile(tmp_path / "cam.dxf").modelspace()
    (hub,), (base,), (prime,) = (
        space.query(f'CIRCLE[layer=="{name}"]') for name in ("HUB", "BASE-CIRCLE", "PRIME-CIRCLE")
    )
    assert (hub.dxf.radius, base.dxf.radius) == (17.0, scene.cam.base_radius)
    assert prime.dxf.radius == scene.cam.base_radius + scene.follower.roller_radius
    (bore,) = space.query('LWPOLYLINE[layer=="BORE"]')
    corners = np.array([complex(x, y) for x, y, *_ in bore.get_points()])
    assert corners.imag.max() == pytest.approx(12.8)
    assert np.ptp(corners.real) == pytest.approx(6.0)
    assert np.abs(corners[np.argsort(corners.imag)[:2]]) == pytest.approx(10.0)


LINKAGES = {"slide-by-bell-crank": ([160.0, 220.0, 110.0], 1), "valve-with-rocker": ([40.0], 0)}
"""Lengths of links, and which end of the last line is on the slide."""


@pytest.mark.parametrize(("name", "lengths", "end"), [(name, *each) for name, each in LINKAGES.items()])
def test_a_dxf_has_the_layout_of_the_linkage(tmp_path, name, lengths, end):
    """Links are as long as given, the roller is on the pitch curve of the turned cam, the slide goes as asked."""
    scene = find_scene(name)
    export(scene, tmp_path / "cam.dxf")
    space = ezdxf.readfile(tmp_path / "cam.dxf").modelspace()
    layers = {float(each.dxf.layer[8:-3]): each.dxf.layer for each in space if each.dxf.layer.endswith("DEG")}
    angles = sorted(layers)
    points = cam_points(scene, angles)
    assert points["tool_displacement_mm"] == pytest.approx([0.0, scene.motion[0].lift / 2, scene.motion[0].lift])
    ends = []
    for angle, x, y in zip(angles, points["pitch_x_mm"], points["pitch_y_mm"], strict=True):
        lines = [
            (complex(*each.dxf.start.vec2), complex(*each.dxf.end.vec2))
            for each in space.query("LINE")
            if each.dxf.layer == layers[angle]
        ]
        for length in lengths:
            assert min(abs(abs(b - a) - length) for a, b in lines) < 1e-9
        turned = complex(x, y) * np.exp(1j * np.radians(angle) * (1 if scene.cam.rotation == "ccw" else -1))
        centres = [
            complex(*each.dxf.center.vec2) for each in space.query("CIRCLE") if each.dxf.layer == layers[angle]
        ]
        assert min(abs(each - turned) for each in centres) < 1e-9
        ends.append(lines[-1][end])
    assert np.abs(np.diff(ends)) == pytest.approx(np.diff(points["tool_displacement_mm"]), rel=1e-9)


BELL_CRANK = {"stage": "bell-crank", "crank": 100, "coupler": 180, "offset": -90, "angle": -100}
ROCKER = {"stage": "rocker", "input_arm": 70, "output_arm": 60}
ON_CYLINDERS = {
    "cw arm": ({"motion": "oscillating", "arm_length": 90}, BELL_CRANK, "cw", [90.0, 100.0, 180.0]),
    "ccw arm": ({"motion": "oscillating", "arm_length": 90}, BELL_CRANK, "ccw", [90.0, 100.0, 180.0]),
    "stem": ({"motion": "translating"}, ROCKER, "ccw", [70.0, 60.0]),
}


@pytest.mark.parametrize(("follower", "stage", "rotation", "lengths"), ON_CYLINDERS.values(), ids=ON_CYLINDERS)
def test_a_dxf_has_the_layout_beside_a_groove(tmp_path, follower, stage, rotation, lengths):
    """Links are as long as given; the roller is on the pitch curve of the surface that has moved past it."""
    moves = [{"segment": each, "angle": 180, "lift": 30, "law": "cycloidal"} for each in ("rise", "return")]
    cam = {"form": "cylindrical", "rotation": rotation, "mean_radius": 80}
    follower = {"contact": "roller", "roller_radius": 8, **follower}
    scene = Scene.from_dict({"cam": cam, "follower": follower, "motion": moves, "train": [stage]})
    export(scene, tmp_path / "cam.dxf")
    space = ezdxf.readfile(tmp_path / "cam.dxf").modelspace()
    names = {each.dxf.layer for each in space if each.dxf.layer.endswith("DEG")}
    assert len(names) == 3
    for name in names:
        angle = float(name[8:-3])
        points = cam_points(scene, [angle])
        there = [each for each in space if each.dxf.layer == name]
        lines = [(complex(*e.dxf.start.vec2), complex(*e.dxf.end.vec2)) for e in there if e.dxftype() == "LINE"]
        for length in lengths:
            assert min(abs(abs(b - a) - length) for a, b in lines) < 1e-9
        moved = complex(points["pitch_x_mm"][0], points["pitch_y_mm"][0]) - 80.0 * np.radians(angle)
        assert min(abs(complex(*e.dxf.center.vec2) - moved) for e in there if e.dxftype() == "CIRCLE") < 1e-9
        assert any(np.array(line).real == pytest.approx(-80.0 * np.radians(angle)) for line in lines)


def test_a_cam_without_a_train_has_no_layout(tmp_path):
    export(find_scene("valve-rod-radial"), tmp_path / "cam.dxf")
    layers = {each.dxf.name for each in ezdxf.readfile(tmp_path / "cam.dxf").layers}
    assert not any(each.startswith("LINKAGE") for each in layers)


MILLED = {"cutter_radius": 5.0, "feed": 300.0}
NEEDED = {".nc": MILLED, ".mpf": MILLED, ".h": MILLED, ".p": {"cutter_radius": 5.0}, ".stl": {"chord": 0.1}}


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("suffix", FILE_TYPES)
def test_the_same_cam_gives_the_same_file(tmp_path, suffix):
    scene = find_scene("valve-rod-radial")
    files = [tmp_path / f"{k}{suffix}" for k in range(2)]
    for file in files:
        export(scene, file, **NEEDED.get(suffix, {}))
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("curves", ["arcs", "spline"])
@pytest.mark.parametrize("name", ["roller-1000rpm", "flat-reciprocating", "feeder-with-stop"])
def test_an_svg_is_the_cam_in_millimetres(tmp_path, name, curves):
    scene = find_scene(name)
    found = export(scene, tmp_path / "cam.svg", curves=curves)
    root = Xml.parse(tmp_path / "cam.svg").getroot()
    box = [float(each) for each in root.get("viewBox").split()]
    assert root.get("width") == f"{box[2]:.6f}mm"
    assert root.get("height") == f"{box[3]:.6f}mm"
    for curve, about in found.curves.items():
        (path,) = root.iterfind(f".//*[@id='{curve}']/*")
        ends = re.findall(r"(-?[\d.]+) (-?[\d.]+)(?= [ACLZ]|$)", path.get("d"))
        points = np.array([complex(float(x), float(y)) for x, y in ends])
        assert largest_distance(points, true_curve(scene, curve)) <= about.deviation_mm + 2e-5
        assert len(points) == about.elements + 1
        x, y = points.real, -points.imag
        assert box[0] < x.min()
        assert x.max() < box[0] + box[2]
        assert box[1] < y.min()
        assert y.max() < box[1] + box[3]


REFUSED = [
    ("cam.xyz", {}, "file = 'cam.xyz': must be a file that ends in"),
    ("cam.dxf", {"curves": "circles"}, "curves = 'circles': must be one of arcs, spline, polyline"),
    ("cam.dxf", {"chord": 0.0}, "chord = 0.0: must be from 1e-06 to 10 mm"),
    ("cam.svg", {"cutter_radius": -1.0}, "cutter_radius = -1.0: must be above 0"),
    ("cam.svg", {"feed": 100.0}, "feed = 100.0: has no meaning in a .svg file; allowed: chord, curves"),
]


@pytest.mark.parametrize(("file", "settings", "message"), REFUSED)
def test_what_cannot_be_written_is_said_and_nothing_is_written(tmp_path, file, settings, message, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=re.escape(message)):
        export(find_scene("roller-1000rpm"), file, **settings)
    assert list(tmp_path.iterdir()) == []


def turn(law, angle):
    dwell = [{"segment": "dwell", "angle": 360 - 2 * angle}]
    moves = [{"segment": kind, "angle": angle, "lift": 40, "law": law} for kind in ("rise", "return")]
    return {"motion": [*moves, *(dwell if angle < 180 else [])]}


UNMAKABLE = [
    ("roller", {"cam.base_radius": 20.0, **turn("cycloidal", 40)}, "cannot be made: it is undercut"),
    ("roller", turn("uniform", 180), "cannot be made: it is undercut"),
    ("groove", turn("uniform", 180), "cannot be made: .*(torn where the velocity jumps|undercut)"),
]


@pytest.mark.parametrize(("name", "changes", "message"), UNMAKABLE)
def test_a_cam_that_cannot_be_made_is_no_file(tmp_path, name, changes, message):
    scene = Scene.from_dict(cam_with(name)).replace(**changes)
    with pytest.raises(BadInput, match=message):
        export(scene, tmp_path / "cam.dxf")
    assert list(tmp_path.iterdir()) == []


def test_the_command_tells_what_it_proved(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "valve-rod-radial", "cam.dxf", "--cutter-radius", "5"]) == 0
    out, err = capsys.readouterr()
    assert re.search(r"profile: \d+ arcs, within 0\.000\d+ mm \(proved\)", out)
    assert "wrote cam.dxf" in err
    assert main(["export", "valve-rod-radial", "cam.svg", "--json", "--quiet"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["curves"]) == {"pitch", "profile"}
    assert found["curves"]["profile"]["deviation_mm"] <= 0.001


@pytest.mark.parametrize("rotation", ["cw", "ccw"])
def test_a_development_that_is_the_mirror_image_of_the_solid_says_so(rotation, tmp_path):
    """From outside, with the lift upwards, angles about the axis grow to the right, as cam angles in a file."""
    scene = scene_of("groove").replace(**{"cam.rotation": rotation, "part.groove_depth": 5.0})
    solid = workpiece_groove(Workpiece(scene, resolve_design(scene)))
    grow = np.diff(solid.polar_angle(np.array([0.0, 0.1])))[0] > 0.0
    told = [note for note in export(scene, tmp_path / "cam.svg").notes if "seen from inside" in note]
    assert len(told) == (0 if grow else 1)


def test_limits_that_the_cam_breaks_are_told(tmp_path):
    scene = find_scene("roller-1000rpm").replace(limits={"pressure_angle": 10})
    assert "pressure_angle" in export(scene, tmp_path / "cam.svg").notes[0]


def test_an_electronic_cam_and_a_scene_need_no_profile(tmp_path):
    scene = Scene.from_dict(cam_with("roller")).replace(**turn("uniform", 180))
    for name in ("cam.txt", "cam.toml"):
        export(scene, tmp_path / name)


def test_the_scene_itself_is_not_written_over(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text("# mine\n" + find_scene("two-pauses").to_toml())
    assert main(["export", "own.toml", "own.toml"]) == 2
    assert "another file: this one is the scene itself" in capsys.readouterr().err
    assert (tmp_path / "own.toml").read_text().startswith("# mine")


HOMELESS = """
import pwd

def unknown(user):
    raise KeyError(user)

pwd.getpwuid = unknown
from camopt.cli.main import main
raise SystemExit(main(["export", "valve-rod-radial", "cam.dxf", "--quiet"]))
"""
"""As in a container that runs as a number."""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="users have a home there")
def test_a_dxf_has_the_same_bytes_without_a_home_and_for_any_hash_seed(tmp_path):
    found = []
    for seed in "04":
        homeless = {name: os.environ[name] for name in os.environ if name != "HOME" and not name.startswith("XDG_")}
        homeless["PYTHONHASHSEED"] = seed
        run = [sys.executable, "-c", HOMELESS]
        done = subprocess.run(run, cwd=tmp_path, env=homeless, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")
        found.append((tmp_path / "cam.dxf").read_bytes())
    export(find_scene("valve-rod-radial"), tmp_path / "cam.dxf")
    assert {*found} == {(tmp_path / "cam.dxf").read_bytes()}
    assert [path.name for path in tmp_path.iterdir()] == ["cam.dxf"]


def test_a_development_has_its_edges_and_the_line_of_no_lift(tmp_path):
    """The cylinder is as long as it is given, the groove in its middle; at y = 0 is no lift."""
    scene = find_scene("feeder-with-stop")
    export(scene, tmp_path / "groove.dxf")
    lines = ezdxf.readfile(tmp_path / "groove.dxf").modelspace().query("LINE")
    ends = {name: [(*e.dxf.start.vec2, *e.dxf.end.vec2) for e in lines if e.dxf.layer == name] for name in LAYERS}
    turn = 2 * np.pi * scene.cam.mean_radius
    assert ends["ZERO"] == [pytest.approx((0.0, 0.0, turn, 0.0))]
    points = cam_points(scene, step=0.05)["pitch_y_mm"]
    middle, half = (points.min() + points.max()) / 2, scene.part.thickness / 2
    corners = {(round(x, 3), round(y, 3)) for line in ends["EDGES"] for x, y in (line[:2], line[2:])}
    low, high = (pytest.approx(middle + side * half, abs=2e-3) for side in (-1, 1))
    assert sorted(x for x, _ in corners) == pytest.approx([0.0, 0.0, turn, turn], abs=1e-3)
    assert sorted({y for _, y in corners}) == [low, high]


LAYERS = ("EDGES", "ZERO")


def test_curves_that_take_much_of_the_tolerance_of_the_profile_are_told(tmp_path):
    scene = find_scene("two-pauses").replace(**{"part.profile_tolerance": 0.002})
    (note,) = export(scene, tmp_path / "cam.svg").notes
    assert "more than a quarter of part.profile_tolerance (0.002 mm)" in note
    assert export(scene, tmp_path / "cam.svg", chord=0.0005).notes == ()

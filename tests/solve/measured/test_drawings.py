"""Drawings and lobes that people bring: DXF as other programs write it, S96, and files in inch."""

import json

import ezdxf
import numpy as np
import pytest
from ezdxf import units

import camopt
from camopt import BadInput
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve_design
from camopt.solve.measured.columns import TableReadingOptions
from camopt.solve.measured.measured_points import read_points

RADIUS, OFF = 23.0, 6.5 * np.exp(0.7j)
"""An eccentric, whose every point is known: a circle about a centre off the axis [mm]."""


def document(unit=units.MM):
    drawing = ezdxf.new("R2010", units=unit)
    return drawing, drawing.modelspace()


def circle_points(count, size=1.0):
    z = (OFF + RADIUS * np.exp(2j * np.pi * np.arange(count) / count)) * size
    return np.column_stack([z.real, z.imag])


def drawn_by_spline():
    drawing, space = document()
    points = circle_points(240)
    space.add_spline(np.vstack([points, points[:1]]).tolist(), dxfattribs={"layer": "0"})
    return drawing


def drawn_by_bulges():
    drawing, space = document()
    bulge = np.tan(2.0 * np.pi / 5 / 4.0)
    space.add_polyline2d([(*row, bulge) for row in circle_points(5)], format="xyb", close=True)
    return drawing


def drawn_in_inches():
    drawing, space = document(units.IN)
    space.add_lwpolyline(circle_points(400, 1 / 25.4).tolist(), close=True)
    return drawing


def drawn_in_nested_blocks():
    drawing, space = document()
    part, sheet = drawing.blocks.new("PART"), drawing.blocks.new("SHEET")
    centre = (OFF * 1j / 2.0).real, (OFF * 1j / 2.0).imag
    part.add_arc(centre, RADIUS / 2.0, 20, 200)
    part.add_arc(centre, RADIUS / 2.0, 200, 20)
    sheet.add_blockref("PART", (0, 0), dxfattribs={"xscale": 2.0, "yscale": 2.0})
    space.add_blockref("SHEET", (0, 0), dxfattribs={"rotation": -90})
    return drawing


def drawn_with_other_curves():
    """The profile beside its bore, its base circle, a hole off the axis, and a centre line."""
    drawing, space = document()
    space.add_circle((OFF.real, OFF.imag), RADIUS)
    space.add_circle((0, 0), 4.0)
    space.add_circle((0, 0), RADIUS - abs(OFF))
    space.add_circle((OFF.real + 12.0, OFF.imag), 2.0)
    space.add_line((-40, 0), (40, 0))
    return drawing


DRAWN = [drawn_by_spline, drawn_by_bulges, drawn_in_inches, drawn_in_nested_blocks, drawn_with_other_curves]


def profile_read(path, layer=None, **columns):
    """Points x + iy of the profile in a drawing."""
    profile = camopt.MeasuredProfile(path, layer=layer)
    points = read_points(path, profile.with_profile_kind_and_layer(TableReadingOptions(**columns)))
    return points, points.lifts * 1j * np.exp(-1j * np.radians(points.angles))


@pytest.mark.parametrize("draw", DRAWN)
def test_drawings_of_other_programs_give_points_on_the_profile(draw, tmp_path):
    draw().saveas(tmp_path / "old.dxf")
    points, z = profile_read(tmp_path / "old.dxf")
    seam = 1e-3 if draw is drawn_by_spline else 2e-6  # a spline through points ends there without their curvature
    np.testing.assert_allclose(np.abs(z - OFF), RADIUS, rtol=0, atol=seam)
    assert np.diff(points.angles, append=points.angles[0] + 360.0).max() < 3.0


def test_a_drawing_without_a_unit_is_in_the_unit_given_or_shown(tmp_path):
    path = tmp_path / "old.dxf"
    drawing, space = document(0)
    space.add_circle((OFF.real, OFF.imag), RADIUS)
    drawing.saveas(path)
    np.testing.assert_allclose(np.abs(profile_read(path)[1] - OFF), RADIUS)
    inches = np.abs(profile_read(path, lift_unit="inch")[1] / 25.4 - OFF)
    with camopt.shown_in("inch"):
        shown = np.abs(profile_read(path)[1] / 25.4 - OFF)
    np.testing.assert_allclose([inches, shown], RADIUS)


def two_layers():
    drawing, space = document()
    space.add_circle((OFF.real, OFF.imag), RADIUS, dxfattribs={"layer": "OUTER"})
    space.add_circle((OFF.real, OFF.imag), RADIUS / 2.0, dxfattribs={"layer": "INNER"})
    return drawing


def test_the_layer_says_which_of_two_curves_is_meant(tmp_path):
    two_layers().saveas(tmp_path / "old.dxf")
    _, z = profile_read(tmp_path / "old.dxf", layer="inner")
    np.testing.assert_allclose(np.abs(z - OFF), RADIUS / 2.0)


def open_chain():
    drawing, space = document()
    space.add_arc((0, 0), 20, 0, 90)
    return drawing


def beside_axis():
    drawing, space = document()
    space.add_circle((50, 0), 20)
    return drawing


@pytest.mark.parametrize(
    ("draw", "layer", "line"),
    [
        (two_layers, None, "curve on the layer 'OUTER' (largest radius 29.5 mm), a curve on the layer 'INNER'"),
        (two_layers, "BORE", "it has nothing on the layer 'BORE', but on INNER, OUTER"),
        (open_chain, None, "it has no closed outline of lines, arcs, polylines or splines; it has ARC"),
        (beside_axis, None, "has no closed curve round the axis at x = 0, y = 0 other than circles about it"),
    ],
)
def test_a_drawing_that_is_not_clear_gets_one_line(draw, layer, line, tmp_path):
    draw().saveas(tmp_path / "old.dxf")
    with pytest.raises(BadInput) as refused:
        profile_read(tmp_path / "old.dxf", layer)
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_no_drawing_says_what_to_export(tmp_path):
    (tmp_path / "old.dxf").write_bytes(b"AC1027\0\0\0" * 50)
    with pytest.raises(
        BadInput, match="export the profile as DXF with lines, arcs, polylines or splines that close"
    ):
        profile_read(tmp_path / "old.dxf")


CAMS = [
    "bucket-valve",
    "roller-1000rpm",
    "exhaust-valve",
    "knife-300rpm-radial",
    "flat-reciprocating",
    "valve-rod-offset",
    "oscillating-roller",
    "rocker-valve",
    "pusher-by-lever",
    "harmonic-240rpm-offset",
]
CHORD = 0.002  # mm


@pytest.mark.slow
@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", CAMS)
def test_shipped_cams_are_fitted_from_their_drawings(name, tmp_path):
    """Base radius and lift come back to the chord error, whatever the curves of the drawing."""
    scene = camopt.find_scene(name)
    curves = ("arcs", "spline", "polyline")[CAMS.index(name) % 3]
    camopt.export(scene, tmp_path / "cam.dxf", chord=CHORD, curves=curves)
    fitted = camopt.fit(tmp_path / "cam.dxf", scene).scene
    unit = 2.0 * CHORD / scene.follower.arm_length if scene.follower.arm_length else 2.0 * CHORD
    assert fitted.cam.base_radius == pytest.approx(scene.cam.base_radius, abs=2.0 * CHORD)
    lifts = [resolve_design(each).programme.lift for each in (fitted, scene)]
    assert lifts[0] == pytest.approx(lifts[1], abs=unit)


def test_a_cut_cam_is_inspected_from_its_drawing(tmp_path, capsys):
    scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.profile": 0.02})
    camopt.export(scene, tmp_path / "cut.dxf")
    found = camopt.inspect(camopt.MeasuredProfile(tmp_path / "cut.dxf"), scene)
    assert abs(found.error) < 0.002
    assert main(["tolerance", "bucket-valve", "--measured", str(tmp_path / "cut.dxf"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["error"] == found.error


# ----------------------------------------------------------------------------------------------------- S96


@pytest.mark.parametrize("name", ["bucket-valve", "three-arc-valve", "tangent-cam"])
def test_a_lobe_is_the_same_after_s96(name, tmp_path):
    scene = camopt.find_scene(name)
    camopt.export(scene, tmp_path / "lobe.s96")
    rows = (tmp_path / "lobe.s96").read_text().splitlines()
    assert len(rows) == 396
    assert rows[360:] == rows[:36]
    assert all(len(row.partition(".")[2]) == 8 for row in rows)
    points = read_points(tmp_path / "lobe.s96", TableReadingOptions())
    programme = resolve_design(scene).programme
    turned = np.radians(points.angles + programme.nose_angle_deg - 180.0)
    np.testing.assert_allclose(points.lifts, programme.motion_at(turned % (2.0 * np.pi))[0], atol=25.4e-8)
    assert points.lifts.argmax() == 180


def s96(lifts):
    return "".join(f"{lift:.8f}\n" for lift in lifts)


LOBE = np.maximum(0.35 * np.cos(np.radians(np.arange(396) - 180.0)), 0.0)


@pytest.mark.parametrize(
    ("content", "profile", "line"),
    [
        (
            s96(LOBE[:361]),
            False,
            "rows = '361 rows of 1 number': an S96 file has 396 lifts, of which the last 36 repeat",
        ),
        (s96([*LOBE[:360], *LOBE[1:37] + 0.01]), False, "row 361 = 0.01: must repeat row 1: the last 36 rows are"),
        (s96(LOBE), True, "file: an S96 file has lifts, not points of a profile"),
    ],
)
def test_another_form_of_s96_is_refused(content, profile, line, tmp_path):
    path = tmp_path / "lobe.s96"
    path.write_text(content)
    columns = TableReadingOptions()
    with pytest.raises(BadInput) as refused:
        read_points(
            path, camopt.MeasuredProfile(path, "xy").with_profile_kind_and_layer(columns) if profile else columns
        )
    assert line in str(refused.value)


def test_s96_has_no_lift_of_an_arm(tmp_path):
    with pytest.raises(BadInput, match="this one has lifts of a translating follower"):
        camopt.export(camopt.find_scene("oscillating-roller"), tmp_path / "lobe.s96")


# ---------------------------------------------------------------------------------------------------- inch


@pytest.mark.parametrize(
    ("heading", "options", "size"),
    [
        ("x,y", ["--units", "inch"], 25.4),
        ("x (in),y (in)", [], 25.4),
        ("x (mm),y (mm)", ["--units", "inch"], 1.0),
        ("x,y", ["--lift-unit", "inch"], 25.4),
        ("x,y", [], 1.0),
    ],
)
def test_measured_points_are_in_the_unit_that_is_said_or_shown(heading, options, size, tmp_path, capsys):
    scene = camopt.find_scene("bucket-valve")
    points = camopt.cam_points(scene, np.arange(0.0, 360.0, 1.0))
    rows = np.column_stack([points["profile_x_mm"], points["profile_y_mm"]]) / size
    (tmp_path / "cut.csv").write_text("\n".join([heading, *(f"{x:.9g},{y:.9g}" for x, y in rows)]))
    measured = ["--measured", str(tmp_path / "cut.csv"), "--profile", "xy", *options, "--json"]
    assert main(["tolerance", "bucket-valve", *measured]) == 0
    assert abs(json.loads(capsys.readouterr().out)["error"]) < 1e-4


# ------------------------------------------------------------------------------------- what people tried


def drawn_by_a_periodic_spline():
    """Control points that are repeated at the end, on even knots: the spline ends inside its knots."""
    drawing, space = document()
    control = circle_points(90)
    space.add_spline().set_closed([(*row, 0.0) for row in control], degree=3)
    return drawing


def drawn_in_metres():
    drawing, space = document(units.M)
    space.add_lwpolyline(circle_points(720, 1e-3).tolist(), close=True)
    return drawing


@pytest.mark.parametrize(("draw", "off"), [(drawn_by_a_periodic_spline, 0.03), (drawn_in_metres, 1e-6)])
def test_periodic_splines_and_large_units_are_read_too(draw, off, tmp_path):
    """The control points of a spline are outside of it, by less than ``off``."""
    draw().saveas(tmp_path / "old.dxf")
    points, z = profile_read(tmp_path / "old.dxf")
    assert np.ptp(np.abs(z - OFF)) < 1e-5
    np.testing.assert_allclose(np.abs(z - OFF), RADIUS, rtol=0, atol=off)
    assert np.diff(points.angles, append=points.angles[0] + 360.0).max() < 3.0


def test_an_exact_drawing_is_fitted_without_noise(tmp_path, command):
    drawn_with_other_curves().saveas(tmp_path / "old.dxf")
    code, out, err = command("fit", "old.dxf", "--follower", "flat")
    assert code == 0, err
    assert "times the noise" not in out or "noise 0" not in out


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["fit", "cut.csv", "--profile", "xy", "--layer", "A"], "layer = 'A': belongs to a drawing (DXF)"),
        (["fit", "lobe.s96", "--scene", "oscillating-roller"], "an S96 file has lifts of a translating follower"),
        (["report", "bucket-valve", "tangent-cam", "--turn", "nan"], "turn = nan: must be a finite angle, in deg"),
    ],
)
def test_what_cannot_be_meant_is_refused(arguments, line, tmp_path, command):
    (tmp_path / "cut.csv").write_text("\n".join(f"{x},{y}" for x, y in circle_points(90)))
    (tmp_path / "lobe.s96").write_text(s96(LOBE))
    code, _, err = command(*arguments)
    assert (code, err.count("\n")) == (2, 1)
    assert line in err.replace("--turn", "turn").replace("--layer", "layer")

"""What machines get, as a machine would read it: G-code, grinder tables, electronic cams, points."""

import re
from functools import cache
from zipfile import ZipFile

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree
from support.cams import CONTACTS, cam_with
from support.controls import CONTROLS, run_heidenhain, run_iso, run_siemens, run_turning
from support.curves import largest_distance, true_points

import camopt
from camopt import BadInput, Scene, cam_points, evaluate, export, find_scene
from camopt.scene.problem.problem import resolve_design
from camopt.show.exporting.groove import WALL_SIDES, workpiece_groove
from camopt.show.exporting.program import CONTROL_DIALECTS
from camopt.show.exporting.workpiece import Workpiece
from camopt.solve.contour.curve import centred_cylinder_ends, disc_curves

CAMS = [
    ("valve-rod-radial", "climb"),
    ("roller", "conventional"),
    ("flat-reciprocating", "climb"),
    ("tangent-cam", "climb"),
]


def test_each_control_has_an_interpreter():
    assert set(CONTROLS) == set(CONTROL_DIALECTS)


@cache
def cutter_path_of(name):
    """The scene, and points of the path of a cutter of 5 mm and of the profile, which the dialects share."""
    scene = Scene.from_dict(cam_with(name)) if name in CONTACTS else find_scene(name)
    problem = resolve_design(scene)
    curves = disc_curves(problem, 5.0)
    return scene, *(as_cut(scene, true_points(problem, curves[each].distance)) for each in ("cutter", "profile"))


def as_cut(scene, points):
    """Points as a program has them: a cam with a hub in front is cut from behind."""
    return -points.conjugate() if scene.whole_part.has_protruding_hub else points


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize("control", CONTROL_DIALECTS)
@pytest.mark.parametrize(("name", "direction"), CAMS)
def test_a_program_cuts_the_profile(tmp_path, control, name, direction):
    scene, true, profile = cutter_path_of(name)
    settings = {"cutter_radius": 5.0, "feed": 300.0, "depth": 10.0, "direction": direction, "roughing": 0.25}
    machining = {"tool": 7, "spindle": 4000.0, "coolant": True, "roughing_feed": 500.0, "depth_step": 4.0}
    found = export(scene, tmp_path / "cam.nc", control=control, **settings, **machining)
    machine = CONTROLS[control]((tmp_path / "cam.nc").read_text())
    assert (machine.tool, machine.speed, machine.turned, machine.cooled) == (7, 4000.0, True, True)
    *roughing, finishing = machine.cuts
    step = 10.0**-machine.decimals
    assert [cut.depth for cut in roughing] == pytest.approx([-10 / 3, -20 / 3, -10], abs=step)
    assert (finishing.depth, {*finishing.feeds}) == (-10.0, {300.0})
    assert {feed for cut in roughing for feed in cut.feeds} == {500.0}
    closed = np.concatenate(finishing.moves[2:-2])
    closed[-1] = closed[0]  # to what the centres' digits leave
    off = max(largest_distance(closed, true), largest_distance(true, closed))
    assert off <= found.curves["cutter"].deviation_mm + 2e-5
    assert found.curves["cutter"].deviation_mm <= max(0.001, 5.0 * step)
    steel = cKDTree(np.column_stack([profile.real, profile.imag]))
    for cut, stock in (*((each, 0.25) for each in roughing), (finishing, 0.0)):
        path = cut.points  # the way in and out, too
        near = steel.query(np.column_stack([path.real, path.imag]), distance_upper_bound=5.1 + stock)[0]
        assert near.min() == pytest.approx(5.0 + stock, abs=6.0 * step + 0.002)
        for end in (path[0], path[-1]):  # down and up outside of the blank
            assert abs(end) >= np.abs(profile).max() + 5.0 + 1.0
    around = (closed[:-1].conjugate() * closed[1:]).imag.sum()
    assert (around < 0) == (direction == "climb")


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("control", CONTROL_DIALECTS)
def test_arcs_of_a_large_radius_are_lines_within_the_chord(tmp_path, control):
    scene, file = find_scene("valve-rod-radial"), tmp_path / "cam.nc"
    export(scene, file, control=control, **NC)
    most = CONTROLS[control](file.read_text()).arcs
    found = export(scene, file, control=control, largest_radius=20.0, **NC)
    machine = CONTROLS[control](file.read_text())
    assert 0 < machine.arcs < most
    closed = np.concatenate(machine.cuts[0].moves[2:-2])
    problem = resolve_design(scene)
    true = as_cut(scene, true_points(problem, disc_curves(problem, 5.0)["cutter"].distance))
    off = max(largest_distance(closed, true), largest_distance(true, closed))
    assert off <= found.curves["cutter"].deviation_mm + 2e-5
    assert found.curves["cutter"].deviation_mm <= max(0.001, 5.0 * 10.0**-machine.decimals)


def test_the_cutter_goes_down_outside_of_a_blank_that_is_given(tmp_path):
    export(find_scene("valve-rod-radial"), tmp_path / "cam.h", blank_diameter=150.0, **NC)
    (cut,) = run_heidenhain((tmp_path / "cam.h").read_text()).cuts
    assert min(abs(cut.points[0]), abs(cut.points[-1])) >= 75.0 + 5.0


@pytest.mark.parametrize(("ending", "run"), [(".nc", run_iso), (".mpf", run_siemens), (".h", run_heidenhain)])
def test_the_ending_says_the_control(tmp_path, ending, run):
    file = tmp_path / f"cam{ending}"
    export(find_scene("valve-rod-radial").replace(**{"part.name": "nocken (ö)"}), file, decimals=5, **NC)
    assert run(file.read_text(encoding="ascii"), decimals=5).comments[0] == "nocken [?]"


NC = {"cutter_radius": 5.0, "feed": 300.0}


@pytest.mark.parametrize(("settings", "message"), [
    ({}, r"cutter_radius: missing.*\n.*feed: missing"),
    ({**NC, "control": "mazatrol"}, "control = 'mazatrol': must be one of iso, fanuc, siemens, heidenhain"),
    ({**NC, "spindle": 100.0}, "spindle = 100.0: needs tool"),
    ({**NC, "roughing_feed": 100.0}, "roughing_feed = 100.0: needs roughing"),
    ({**NC, "tool": 0}, "tool = 0: must be from 1 to 99999"),
    ({**NC, "decimals": 2}, "decimals = 2: must be one of 3, 4, 5, 6"),
    ({**NC, "depth_step": 1e-5}, "depth_step = 1e-05: must be at least 0.016 mm: at most 1000 steps are allowed"),
    ({**NC, "blank_diameter": 100.0}, r"blank_diameter = 100.0: must be at least 150 mm, the diameter of the cam"),
    ({**NC, "control": "fanuc", "chord": 0.001}, "chord = 0.001: must be at least 0.005 mm: a program has 3 dec"),
    ({**NC, "feed": 0.0}, "feed = 0.0: must be above 0"),
    ({**NC, "direction": "up"}, "direction = 'up': must be one of climb, conventional"),
    ({**NC, "chord": 1e-4}, "chord = 0.0001: must be at least 0.0005 mm"),
    ({**NC, "roughing": -1.0}, "roughing = -1.0: must be from 0 to 1000 mm"),
    ({**NC, "depth": 16.001}, r"depth = 16.001: must be at most 16 mm: a deeper cut reaches the hub"),
    ({**NC, "cutter_radius": 1e3}, "cutter_radius = 1000.0: must be above 0 and at most"),
])  # fmt: skip
def test_a_program_that_cannot_be_is_said(tmp_path, settings, message):
    with pytest.raises(BadInput, match=message):
        export(find_scene("valve-rod-radial"), tmp_path / "cam.nc", **settings)
    assert list(tmp_path.iterdir()) == []


GROOVES = {
    "translating": lambda: find_scene("feeder-with-stop"),
    "oscillating": lambda: Scene.from_dict(
        {
            "cam": {"form": "cylindrical", "mean_radius": 60, "rotation": "cw"},
            "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 8, "arm_length": 90},
            "motion": [
                {"segment": "rise", "angle": 130, "lift": 25, "law": "cycloidal"},
                {"segment": "dwell", "angle": 40},
                {"segment": "return", "angle": 130, "lift": 25, "law": "poly345"},
                {"segment": "dwell", "angle": 60},
            ],
            "part": {"thickness": 80, "groove_depth": 12, "bore": 30},
        }
    ),
}
TURNED = {"A": ("X", "Z", -1.0), "C": ("Z", "X", 1.0)}
"""Along the cam, from it, and the sign of Y where the cutter moves round the cam as the angle grows."""


@pytest.mark.one_in(4)
@pytest.mark.parametrize("control", CONTROL_DIALECTS)
@pytest.mark.parametrize("rotary", TURNED)
@pytest.mark.parametrize("name", GROOVES)
def test_a_program_of_four_axes_cuts_the_walls_of_a_groove(tmp_path, control, rotary, name):
    """The axis of the cutter in the frame of the part, as it turns, beside walls that the roller touches."""
    scene, (along, radial, lateral) = GROOVES[name](), TURNED[rotary]
    roller, depth = scene.follower.roller_radius, scene.part.groove_depth
    settings = {"cutter_radius": roller, "feed": 250.0, "depth_step": 0.6 * depth, "tool": 3, "spindle": 900.0}
    found = export(scene, tmp_path / "cam.nc", control=control, rotary=rotary, **settings)
    outer = scene.cam.mean_radius + depth / 2
    text = (tmp_path / "cam.nc").read_text()
    machine = run_turning(text, control, along, radial, rotary, clear=outer)
    states, levels = np.array(machine.states), [outer - depth / 2, outer - depth]
    assert np.unique(states[:, 2]) == pytest.approx(sorted(levels))
    turns = [states[states[:, 2] == level] for level in levels]
    for turn in turns:
        assert abs(turn[-1, 3] - turn[0, 3]) == pytest.approx(360.0)
    assert turns[0][::-1, [0, 1, 3]] == pytest.approx(turns[1][:, [0, 1, 3]])
    along_cam, across_cam, _, degrees = turns[0][np.argsort(turns[0][:, 3])].T
    even = np.linspace(degrees[0], degrees[-1], 7201)  # all axes of a move are even in each other
    high, beside = (np.interp(even, degrees, each) for each in (along_cam, across_cam))
    ways = np.pi / 2 + np.radians(even)  # of the cutter, round the cam
    groove = workpiece_groove(Workpiece(scene, resolve_design(scene)))
    low = centred_cylinder_ends(resolve_design(scene), scene.part.thickness)[0]
    allowed = found.curves["cutter"].deviation_mm
    assert allowed <= (0.005 if control == "fanuc" else 0.001)
    for radius in groove.section_radii[[0, -1]]:
        for side in WALL_SIDES:
            for span in groove.curve.spans:
                angles = np.linspace(span.start, span.end, 9)[1:-1]
                x, y, z = groove.xyz_points(groove.wall_points(span, angles, np.array([radius]), side))[:, 0].T
                away = np.arctan2(y, x)[:, None] - ways
                gaps = np.hypot(radius * np.sin(away) - lateral * beside, z[:, None] - low - high)
                gaps[np.cos(away) < 0.0] = np.inf  # behind the cam
                assert gaps.min(axis=1) == pytest.approx(roller, abs=allowed + 1e-5)
    if control == "heidenhain":
        assert {*machine.feeds} == {250.0}
    else:
        around = lateral * turns[0][:, 1] + outer * np.radians(turns[0][:, 3])
        length = np.hypot(np.diff(turns[0][:, 0]), np.diff(around)).sum()
        assert machine.minutes == pytest.approx((2 * length + 5.0 + depth) / 250.0, rel=1e-4)


def test_a_program_of_a_rib_goes_round_each_flank_in_the_place_of_its_roller(tmp_path):
    """Both turns together stay at the radius of the roller from every point of both flanks, at its foot and top."""
    scene = find_scene("bottle-filler-by-rib")
    roller, height = scene.follower.roller_radius, scene.part.rib_height
    found = export(
        scene, tmp_path / "cam.nc", cutter_radius=roller, feed=250.0, tool=3, spindle=900.0, depth_step=9.0
    )
    assert {*found.curves} == {"cutter", "second_cutter"}
    outer = scene.cam.mean_radius + height / 2
    states = np.array(run_turning((tmp_path / "cam.nc").read_text(), "iso", "X", "Z", "A", clear=outer).states)
    lowest = states[states[:, 2] == states[:, 2].min()]
    assert lowest[0, 2] == pytest.approx(outer - height)
    rib, low = (
        workpiece_groove(Workpiece(scene, resolve_design(scene))),
        centred_cylinder_ends(resolve_design(scene), scene.part.thickness)[0],
    )
    turns = np.split(lowest, np.flatnonzero(np.abs(np.diff(lowest[:, 0])) > roller) + 1)
    assert len(turns) == 2
    for turn, side in zip(turns, WALL_SIDES[::-1], strict=True):
        turn = turn[np.argsort(turn[:, 3])]
        even = np.linspace(turn[0, 3], turn[-1, 3], 14_401)
        high, ways = np.interp(even, turn[:, 3], turn[:, 0]), np.pi / 2 + np.radians(even)
        for span in rib.curve.spans:
            angles = np.linspace(span.start, span.end, 7)[1:-1]
            for radius in rib.section_radii[[0, -1]]:
                x, y, z = rib.xyz_points(rib.wall_points(span, angles, np.array([radius]), side))[:, 0].T
                away = np.arctan2(y, x)[:, None] - ways
                gaps = np.hypot(radius * np.sin(away), z[:, None] - low - high)
                gaps[np.cos(away) < 0.0] = np.inf
                assert gaps.min(axis=1) == pytest.approx(roller, abs=found.curves["cutter"].deviation_mm + 1e-5)


def test_a_cutter_that_is_smaller_than_the_roller_roughs(tmp_path):
    found = export(GROOVES["oscillating"](), tmp_path / "cam.nc", cutter_radius=7.0, feed=100.0)
    assert "the cutter leaves 1 mm on each wall; a cutter with radius 8 mm cuts them to size" in found.notes


@pytest.mark.parametrize("name", ["feeder-with-stop", "face-groove-shutter"])
def test_walls_are_apart_by_roller_and_clearance(tmp_path, name):
    """In the curves, and as the radius of the cutter that takes the place of the roller."""
    scene = find_scene(name).replace(**{"drive.clearance": 0.06})
    half = scene.follower.roller_radius + 0.03
    walls = [curve.distance for at, curve in disc_curves(resolve_design(scene)).items() if at.startswith("profile")]
    assert sorted(walls) == pytest.approx([-half, half])
    assert export(scene, tmp_path / "cam.nc", cutter_radius=half, feed=200.0).curves
    with pytest.raises(BadInput, match=f"at most {half:g} mm"):
        export(scene, tmp_path / "wide.nc", cutter_radius=half + 0.01, feed=200.0)


@pytest.mark.parametrize(("edits", "settings", "message"), [
    ({}, {"roughing": 0.2}, "roughing = 0.2: has no meaning for a cylinder"),
    ({}, {"direction": "conventional"}, "direction = 'conventional': has no meaning for a cylinder"),
    ({}, {"depth": 17.0}, r"depth = 17.0: must be at most part.groove_depth \(16 mm\)"),
    ({}, {"cutter_radius": 9.5}, "cutter_radius = 9.5: must be above 0 and at most 9 mm"),
    ({}, {"rotary": "B"}, "rotary = 'B': must be one of A, C"),
    ({"part.groove_depth": None}, {}, "part.groove_depth: missing: it gives the depth of the cut"),
    ({"cam.mean_radius": 9000}, {"chord": 0.0055, "decimals": 3}, "chord = 0.0055: must be above 0.079 mm"),
])  # fmt: skip
def test_a_groove_whose_program_cannot_be_is_said(tmp_path, edits, settings, message):
    scene = find_scene("feeder-with-stop").replace(**edits)
    with pytest.raises(BadInput, match=message):
        export(scene, tmp_path / "cam.mpf", **{"cutter_radius": 9.0, "feed": 300.0, **settings})
    assert list(tmp_path.iterdir()) == []


def test_a_disc_is_not_turned_under_its_cutter(tmp_path):
    with pytest.raises(BadInput, match="rotary = 'A': has no meaning for a disc cam"):
        export(find_scene("valve-rod-radial"), tmp_path / "cam.nc", rotary="A", **NC)


@pytest.mark.parametrize(
    ("part", "settings", "deepest"),
    [
        ({}, {}, -16.0),  # a hub is below the plate
        ({}, {"depth": 16.0}, -16.0),
        ({"part.hub_length": 16.0}, {}, -17.0),
        ({"part.hub_length": 16.0}, {"depth": 20.0}, -20.0),
    ],
)
def test_a_program_cuts_through_a_plate_but_not_beside_a_hub(tmp_path, part, settings, deepest):
    export(find_scene("valve-rod-radial").replace(**part), tmp_path / "cam.nc", **NC, **settings)
    program = re.sub(r"\(.*?\)", "", (tmp_path / "cam.nc").read_text())
    assert min(map(float, re.findall(r"Z(-?[\d.]+)", program))) == deepest


def test_a_program_without_a_depth_stays_in_its_plane(tmp_path):
    export(find_scene("roller-1000rpm"), tmp_path / "cam.nc", **NC)
    assert not re.search(r"Z-?\d", re.sub(r"\(.*?\)", "", (tmp_path / "cam.nc").read_text()))


@pytest.mark.parametrize("name", ["valve-rod-radial", "roller", "oscillating-roller", "flat-reciprocating"])
def test_a_wheel_that_follows_the_table_touches_the_profile(tmp_path, name):
    scene = Scene.from_dict(cam_with(name)) if name in CONTACTS else find_scene(name)
    export(scene, tmp_path / "cam.p", cutter_radius=8.0, step=0.5)
    angle, lift, centre = np.loadtxt(tmp_path / "cam.p").T
    assert lift.min() == 0.0
    np.testing.assert_allclose(centre - lift, centre.min(), atol=2e-6)
    problem = resolve_design(scene)
    wheel = centre * 1j * np.exp(-1j * problem.design.sense * np.radians(angle))
    profile = true_points(problem, disc_curves(problem)["profile"].distance, 200_001)
    distance = cKDTree(np.column_stack([profile.real, profile.imag])).query(
        np.column_stack([wheel.real, wheel.imag])
    )[0]
    assert np.abs(distance - 8.0).max() < 2e-5


def test_a_wheel_as_large_as_a_radial_roller_has_its_lift(tmp_path):
    scene = find_scene("valve-rod-radial")
    export(scene, tmp_path / "cam.p", cutter_radius=scene.follower.roller_radius)
    angle, lift, _ = np.loadtxt(tmp_path / "cam.p").T
    np.testing.assert_allclose(lift, cam_points(scene, angle)["displacement_mm"], atol=1e-6)


@pytest.mark.parametrize("name", ["roller-1000rpm", "oscillating-roller", "feeder-with-stop"])
def test_an_electronic_cam_is_the_motion(tmp_path, name):
    scene = find_scene(name)
    assert export(scene, tmp_path / "cam.txt", points=3601).about == {"points": 3601}
    assert "# the slave is the follower" in (tmp_path / "cam.txt").read_text()
    angle, position, velocity, acceleration = np.loadtxt(tmp_path / "cam.txt").T
    unit = "deg" if scene.follower.motion == "oscillating" else "mm"
    np.testing.assert_allclose(position, cam_points(scene, angle)[f"displacement_{unit}"], atol=1e-8)
    work = np.concatenate([[0.0], np.cumsum((velocity[1:] + velocity[:-1]) / 2 * np.diff(angle))])
    np.testing.assert_allclose(position - position[0], work, atol=1e-4 * np.ptp(position))
    gained = np.concatenate([[0.0], np.cumsum((acceleration[1:] + acceleration[:-1]) / 2 * np.diff(angle))])
    np.testing.assert_allclose(velocity - velocity[0], gained, atol=3e-3 * np.ptp(velocity))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", [*CONTACTS, "tangent-cam"])
def test_points_have_the_form_of_the_profile(name):
    """Normals and curvatures against differences of the points, and the least radius that evaluate finds."""
    scene = Scene.from_dict(cam_with(name)) if name in CONTACTS else find_scene(name)
    h = 1e-3
    angles = np.arange(1.5, 359.0, 1.0)
    before, here, after = (cam_points(scene, angles + d) for d in (-h, 0.0, h))
    for curve in [key.removesuffix("_x_mm") for key in here if key.startswith("profile") and key.endswith("_x_mm")]:
        p, q, r = (each[f"{curve}_x_mm"] + 1j * each[f"{curve}_y_mm"] for each in (before, here, after))
        normal = here[f"{curve}_normal_x"] + 1j * here[f"{curve}_normal_y"]
        along = (r - p) / np.abs(r - p)
        np.testing.assert_allclose(np.abs((along.conjugate() * normal).imag), 1.0, atol=1e-6)
        bend = 2 * ((q - p).conjugate() * (r - q)).imag / np.abs((q - p) * (r - q) * (r - p))
        shown = here[f"{curve}_curvature_per_mm"]
        middle = np.median(np.abs(np.abs(bend) - np.abs(shown)))
        assert middle < 1e-5
        side = np.sign((along.conjugate() * normal).imag)
        np.testing.assert_allclose(np.median(np.abs(-side * bend - shown)), middle, atol=1e-12)
        if curve == "profile":
            np.testing.assert_allclose(here["profile_radius_mm"], np.abs(q))
            np.testing.assert_allclose(np.exp(1j * np.radians(here["profile_angle_deg"])), q / np.abs(q))
            assert (normal * q.conjugate()).real.min() > 0.0
    least = evaluate(scene)["profile_radius_min_mm"]
    largest = max(values.max() for key, values in here.items() if key.endswith("curvature_per_mm"))
    assert largest <= 1.0 / least * (1 + 1e-9)


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".xlsx"])
def test_points_are_proved_and_come_back(tmp_path, suffix):
    scene = find_scene("two-pauses")
    close = export(scene, tmp_path / f"a{suffix}", chord=0.01, cutter_radius=4.0)
    assert all(0.002 < curve.deviation_mm <= 0.01 for curve in close.curves.values())
    steps = export(scene, tmp_path / f"b{suffix}", step=2.5)
    assert steps.about == {"points": 145}
    true = true_points(resolve_design(scene), disc_curves(resolve_design(scene))["profile"].distance)
    points = cam_points(scene, step=2.5)
    line = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    measured = largest_distance(true, line)
    assert 0.9 * steps.curves["profile"].deviation_mm <= measured <= steps.curves["profile"].deviation_mm
    read = {".csv": lambda file: pd.read_csv(file, dtype=str).astype(float), ".parquet": camopt.load}.get(suffix)
    table = (
        read(tmp_path / f"b{suffix}")
        if read
        else pd.read_excel(tmp_path / f"b{suffix}", skiprows=[1], engine="calamine")
    )
    assert list(table.columns) == list(points)
    if suffix == ".xlsx":
        assert b'"0.0000"' in ZipFile(tmp_path / "b.xlsx").read("xl/styles.xml")
    digits = 1e-14 if suffix == ".xlsx" else 0.0
    np.testing.assert_allclose(table.to_numpy(dtype=float), np.column_stack(list(points.values())), rtol=digits)


def test_a_chord_and_a_step_are_two_things(tmp_path):
    with pytest.raises(BadInput, match="cannot be used with chord"):
        export(find_scene("two-pauses"), tmp_path / "a.csv", chord=0.01, step=1.0)


def test_the_scene_comes_back(tmp_path):
    scene = find_scene("press-with-drift")
    export(scene, tmp_path / "back.toml")
    assert evaluate(Scene.from_toml(tmp_path / "back.toml")) == evaluate(scene)

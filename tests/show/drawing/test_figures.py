"""The pictures and the points: every shipped scene draws, and the curves are where the follower touches them."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import camopt
from camopt import plot
from camopt.core.mistakes import BadInput
from camopt.model.motion.stroke import RISE
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene, find_scene
from camopt.scene.sources import shipped_scenes
from camopt.show.drawing.loads import load_panels
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture
from camopt.show.exporting.cam_points import cam_points, write_points

SEGMENTS = [("rise", 120, "cycloidal"), ("dwell", 40, None), ("return", 100, "poly345"), ("dwell", 100, None)]
DISC = {"form": "disc", "base_radius": 40.0, "rpm": 200}
CYLINDER = {"form": "cylindrical", "mean_radius": 60.0}
ARM = {"motion": "oscillating", "arm_length": 90.0, "centre_distance": 110.0}
OTHERS: dict[str, tuple[dict[str, Any], dict[str, Any], float]] = {
    "spherical": (DISC, {"motion": "translating", "contact": "spherical", "face_radius": 60.0, "offset": -10}, 15),
    "swinging face": (
        DISC | {"rotation": "cw"},
        {"motion": "oscillating", "contact": "flat", "centre_distance": 120.0, "face_offset": 10.0},
        12,
    ),
    "swinging knife": (DISC, ARM | {"contact": "knife"}, 15),
    "swinging sphere": (DISC, ARM | {"contact": "spherical", "face_radius": 30.0}, 15),
    "groove": (CYLINDER, {"motion": "translating", "contact": "roller", "roller_radius": 10.0}, 40),
    "swinging groove": (
        CYLINDER | {"rotation": "cw"},
        {"motion": "oscillating", "contact": "roller", "roller_radius": 8.0, "arm_length": 100.0},
        24,
    ),
    "undercut": (
        DISC | {"base_radius": 3.0},
        {"motion": "translating", "contact": "roller", "roller_radius": 60.0},
        40,
    ),
    "undercut face": (DISC | {"base_radius": 10.0}, {"motion": "translating", "contact": "flat"}, 30),
    "undercut groove": (
        CYLINDER | {"mean_radius": 15.0},
        {"motion": "translating", "contact": "roller", "roller_radius": 12.0},
        50,
    ),
}
CORNERED = (DISC, {"motion": "translating", "contact": "roller", "roller_radius": 8.0}, 30)


def plain_scene(name: str, law: str | None = None) -> Scene:
    cam, follower, lift = CORNERED if name == "cornered" else OTHERS[name]
    moves = {"rise": {"lift": lift}, "return": {"lift": lift}, "dwell": {}}
    motion = [
        {"segment": kind, "angle": angle, **moves[kind], **({"law": law or own} if own else {})}
        for kind, angle, own in SEGMENTS
    ]
    return Scene.from_dict({"name": "a cam", "cam": cam, "follower": follower, "motion": motion})


def svg_text(scene: Scene, folder: Path) -> str:
    plot(scene, folder / "cam.svg")
    return (folder / "cam.svg").read_text(encoding="utf-8")


@pytest.mark.slow
def test_same_scene_same_file_and_no_settings_left_behind(tmp_path: Path) -> None:
    import matplotlib

    settings = dict(matplotlib.rcParams)
    spectrum = camopt.response_spectrum("cycloidal", np.linspace(0.5, 4.0, 20), damping_ratio=0.02)
    pictures = {
        "cam": partial(plot, find_scene("oscillating-roller")),
        "of": partial(camopt.plot, [spectrum]),
    }
    for name, suffix in (("cam", "svg"), ("of", "svg"), ("of", "pdf"), ("of", "png")):
        files = [tmp_path / f"{name} {turn}.{suffix}" for turn in "ab"]
        for file in files:
            pictures[name](file)
        assert files[0].read_bytes() == files[1].read_bytes()
    assert dict(matplotlib.rcParams) == settings


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["a $ cam <&> $\\frac$", "カム", "x" * 300])
def test_any_name_can_be_drawn(name: str, tmp_path: Path) -> None:
    scene = find_scene("exhaust-valve").replace(name=name)
    plot(scene, tmp_path / "a.png")
    assert (tmp_path / "a.png").exists()


def test_more_than_one_rise_and_no_dwell(tmp_path: Path) -> None:
    moves = [("rise", 90, 10), ("return", 5, 2), ("rise", 85, 12), ("return", 180, 20)]
    motion = [{"segment": s, "angle": a, "lift": h, "law": "modified-trapezoid"} for s, a, h in moves]
    scene = Scene.from_dict({"cam": DISC, "follower": OTHERS["groove"][1], "motion": motion})
    assert "Displacement" in svg_text(scene, tmp_path)


def test_wrong_suffix_and_folder(tmp_path: Path) -> None:
    scene = find_scene("exhaust-valve")
    with pytest.raises(BadInput, match=r"path.*\.png, \.svg or \.pdf"):
        plot(scene, tmp_path / "cam.bmp")
    with pytest.raises(BadInput, match=r"path.*\.csv, \.parquet or \.xlsx"):
        write_points(scene, tmp_path / "cam.ods")
    for write, file in ((plot, "cam.svg"), (write_points, "cam.csv"), (write_points, "cam.parquet")):
        with pytest.raises(FileNotFoundError) as trouble:
            write(scene, tmp_path / "none" / file)
        assert trouble.value.filename == str(tmp_path / "none" / file)
    assert not list(tmp_path.iterdir())


def curve(points: dict[str, Any], name: str) -> Any:
    return points[f"{name}_x_mm"] + 1j * points[f"{name}_y_mm"]


DISCS = [name for name in shipped_scenes() if find_scene(name).cam.form == "disc"]


@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", DISCS)
def test_profile_is_a_roller_radius_from_the_pitch_curve_and_least_at_the_base_circle(name: str) -> None:
    scene = find_scene(name)
    points, half_gap = cam_points(scene, np.linspace(0, 360, 1441)), 0.5 * (scene.drive.clearance or 0.0)
    profile = curve(points, profile_of(scene))
    if scene.follower.contact == "flat":
        assert "pitch_x_mm" not in points
    else:
        radius = (scene.follower.roller_radius or 0.0) + half_gap
        np.testing.assert_allclose(np.abs(profile - curve(points, "pitch")), radius, rtol=0, atol=1e-12)
    assert abs(np.abs(profile).min() - ((scene.cam.base_radius or 0.0) - half_gap)) < 1e-9


@pytest.mark.parametrize("name", [n for n in DISCS if find_scene(n).follower.contact == "roller"])
def test_profile_is_tangent_to_the_roller(name: str) -> None:
    """Between corners the normal, from the profile to the pitch curve, is square to both of them."""
    scene = find_scene(name)
    start = sum(s.angle for s in scene.motion[:1]) * 0.3
    angles = start + np.linspace(0.0, 1e-3, 3)
    points = cam_points(scene, angles)
    pitch, profile = curve(points, "pitch"), curve(points, profile_of(scene))
    normal = (pitch - profile)[1]
    for line in (pitch, profile):
        along = line[2] - line[0]
        assert abs((along * np.conj(normal)).real) < 1e-6 * abs(along) * abs(normal)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", [n for n in DISCS if find_scene(n).follower.motion == "translating"])
def test_turning_the_other_way_mirrors_a_translating_cam(name: str) -> None:
    scene = find_scene(name)
    other = "ccw" if scene.cam.rotation == "cw" else "cw"
    mirrored = scene.replace(**{"cam.rotation": other, "follower.offset": -scene.follower.offset})
    here, there = cam_points(scene), cam_points(mirrored)
    np.testing.assert_allclose(curve(here, "profile"), -np.conj(curve(there, "profile")), rtol=0, atol=1e-12)


def profile_of(scene) -> str:
    """The profile, or the inner wall of a groove, by its name in columns of points."""
    return "profile" if scene.mechanism.body.bounded else "profile_inner"


def test_groove_has_two_flanks_and_two_cutter_paths() -> None:
    points = cam_points(plain_scene("swinging groove"), cutter_radius=5.0)
    pitch = curve(points, "pitch")
    for side in ("left", "right"):
        flank, cutter = curve(points, f"profile_{side}"), curve(points, f"cutter_{side}")
        np.testing.assert_allclose(np.abs(flank - pitch), 8.0, atol=1e-12)
        np.testing.assert_allclose(np.abs(flank - cutter), 5.0, atol=1e-12)
        np.testing.assert_allclose(np.abs(cutter - pitch), 3.0, atol=1e-12)
    assert np.all(points["profile_left_y_mm"] > points["profile_right_y_mm"])
    assert points["displacement_deg"].max() == pytest.approx(24.0, abs=1e-12)


def test_cutter_path_and_bad_requests() -> None:
    scene = find_scene("roller-1000rpm")
    points = cam_points(scene, [0, 10.5, 360], cutter_radius=7.5)
    np.testing.assert_allclose(np.abs(curve(points, "cutter") - curve(points, "profile")), 7.5, atol=1e-12)
    assert points["cam_angle_deg"].tolist() == [0, 10.5, 360]
    for radius in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(BadInput, match="cutter_radius"):
            cam_points(scene, cutter_radius=radius)
    with pytest.raises(BadInput, match="above 0 and at most 10 mm"):
        cam_points(plain_scene("groove"), cutter_radius=10.5)
    for angle in (-1.0, 360.5, float("nan")):
        with pytest.raises(BadInput, match="angles"):
            cam_points(scene, [angle])


@pytest.mark.parametrize("name", ["roller-1000rpm", "flat-reciprocating", "oscillating-roller"])
def test_points_come_back_from_both_files(name: str, tmp_path: Path) -> None:
    import csv

    scene = find_scene(name)
    points = cam_points(scene, cutter_radius=4.0)
    write_points(scene, tmp_path / "cam.csv", 4.0)
    write_points(scene, tmp_path / "cam.parquet", 4.0)
    with open(tmp_path / "cam.csv", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == list(points)
    np.testing.assert_array_equal(np.array(rows, dtype=float).T, np.array(list(points.values())))
    frame = camopt.load(tmp_path / "cam.parquet")
    assert list(frame) == list(points)
    np.testing.assert_array_equal(frame.to_numpy().T, np.array(list(points.values())))
    moved = ("velocity", "acceleration", "jerk")
    units = {unit for name, unit in frame.attrs["units"].items() if not name.startswith(moved)}
    assert units <= {"deg", "mm", "1/mm", ""}
    assert frame.attrs["scene"] == scene.to_toml()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cam.csv", "cam.parquet"]


TRAIN = {
    "mass": 1.5, "spring_rate": 15.0, "preload": 450.0, "damping": 0.03, "guide_length": 90.0, "overhang": 80.0,
    "friction": 0.1, "stem_diameter": 16.0, "natural_frequency": 120.0, "damping_ratio": 0.05,
}  # fmt: skip
SWUNG = {"inertia": 0.02, "spring_rate": 60.0, "preload": 35.0, "natural_frequency": 150.0, "damping_ratio": 0.02}
BODIES = {
    "cam": "steel", "follower": "steel", "face_width": 10.0, "wear_rate": 1e-10, "viscosity": 0.02,
    "pressure_viscosity": 18.0, "roughness": 0.3,
}  # fmt: skip
LOADED = {
    "roller": (CORNERED[0], CORNERED[1], 12),
    "face": (DISC | {"base_radius": 60.0}, {"motion": "translating", "contact": "flat"}, 12),
    **{name: OTHERS[name] for name in ("spherical", "swinging knife", "groove", "swinging groove")},
}
TITLES = {
    "force": {"Force along the motion"},
    "torque": {"Torque of the camshaft"},
    "vibration": {
        "Acceleration of the mass on its elastic train",
        "Deviation of the mass from the motion",
        "Force with the elastic train",
    },
    "thrust": {"Side thrust"},
    "hertz": {"Contact stress"},
    "surface": {"Speed of the roller in its follower", "Film over roughness"},
}


def loaded_scene(name: str, **changes: Any) -> Scene:
    cam, follower, lift = LOADED[name]
    moves = {"rise": {"lift": lift, "law": "cycloidal"}, "return": {"lift": lift, "law": "poly345"}, "dwell": {}}
    motion = [{"segment": kind, "angle": angle, **moves[kind]} for kind, angle, _ in SEGMENTS]
    given = SWUNG if follower["motion"] == "oscillating" else TRAIN
    scene = {"cam": cam | {"rpm": 200.0}, "follower": {**follower, "dynamics": given}, "materials": BODIES}
    return Scene.from_dict({**scene, "motion": motion, "outputs": ["all"], **changes})


def load_diagrams(scene: Scene) -> list[Any]:
    return load_panels(Picture(scene, resolve(scene)))


def test_without_a_call_no_load_is_drawn() -> None:
    assert load_diagrams(loaded_scene("roller", outputs=[])) == []


@pytest.mark.parametrize("name", LOADED)
def test_curves_of_loads_reach_the_exact_values_and_no_further(name: str) -> None:
    shown = load_diagrams(loaded_scene(name))
    assert len(shown) >= 5
    for panel in shown:
        every = np.concatenate(panel.values)
        assert np.isfinite(every).all(), panel.title
        angles = np.degrees(
            np.concatenate(Picture(loaded_scene(name), resolve(loaded_scene(name))).angles_of_pieces)
        )
        size = np.abs(every).max()
        assert panel.peaks, panel.title
        for peak in panel.peaks:
            assert every[np.abs(angles - peak.angle).argmin()] == pytest.approx(peak.value, abs=2e-3 * size)
            beyond = every.min() if peak.least or peak.value < 0.0 else every.max()
            assert abs(beyond - peak.value) <= 2e-3 * size, panel.title


def test_an_elastic_train_that_is_stiff_moves_as_its_cam_does() -> None:
    stiff = loaded_scene("roller", outputs=["vibration"]).replace(**{"follower.dynamics.natural_frequency": 2e5})
    mass, travel, _ = load_diagrams(stiff)
    moved, motion = np.concatenate(mass.values), np.concatenate(mass.reference)
    np.testing.assert_allclose(moved, motion, atol=2e-2 * np.abs(motion).max())
    assert np.abs(np.concatenate(travel.values)).max() < 1e-4


LIMITED = {
    "contact_force_min": 200.0, "torque": 9.0, "residual_vibration": 0.01, "contact_force_elastic": 100.0,
    "side_thrust": 400.0, "normal_force": 900.0, "guide_reaction": 700.0, "stem_bending_stress": 60.0,
    "contact_stress": 900.0, "film_ratio": 0.5,
}  # fmt: skip


@pytest.mark.parametrize("key", LIMITED)
def test_a_limit_on_a_load_is_a_line_in_its_diagram(key: str) -> None:
    lines = [bound for panel in load_diagrams(loaded_scene("roller", outputs=["sizes"], limits={key: LIMITED[key]}))
             for _, bound in panel.limits]  # fmt: skip
    assert lines == [LIMITED[key]]


def test_a_limit_on_power_is_a_line_of_torque() -> None:
    (panel,) = load_diagrams(loaded_scene("roller", outputs=["sizes"], limits={"power": 100.0}))
    ((_, bound),) = panel.limits
    assert bound == pytest.approx(100.0 / (200.0 * np.pi / 30), rel=1e-12)


def test_every_limit_on_the_curve_of_a_diagram_is_a_line_of_it() -> None:
    """By any quantity that is an extreme of the curve, of both signs where that is a magnitude."""
    limits = {"torque_max_N_m": 8.0, "torque_min_N_m": -5.0, "torque_peak_N_m": 9.0, "torque_rms_N_m": 4.0}
    (panel,) = load_diagrams(loaded_scene("roller", outputs=["sizes"], limits=limits))
    assert {(kinds > 0, bound) for kinds, bound in panel.limits} == {(False, 8.0), (False, -5.0), (True, 9.0)}
    limits = {"velocity_max_rise_m_s": 1.0, "velocity_max_m_s": 2.0, "lift_change_max_mm_per_deg": 0.5}
    scene = loaded_scene("roller", limits=limits)
    picture = Picture(scene, resolve(scene))
    _, velocity, *_ = motion_panels(picture)
    per_second = 200.0 * 6.0 * 1e-3
    assert [kinds for kinds, _ in velocity.limits].count(RISE) == 1
    assert sorted(bound for _, bound in velocity.limits) == pytest.approx(sorted([0.5 * per_second, 1.0, 2.0]))

"""A groove in the face of a disc: what it shares with an open cam, and both of its walls, by points and areas."""

import re
from functools import cache

import numpy as np
import pytest
import shapely
from support.cams import cam_with, turn_of
from support.depth import times

from camopt import BadInput, Scene, cam_points, certify, evaluate, evaluate_designs, export, find_scene, optimise
from camopt.model.effects.self_crossing import wall_crossing_verdicts
from camopt.model.effects.self_crossing_boxes import largest_overlap_angles, profile_overlaps, refine_overlap_angles
from camopt.model.mechanisms import DRIVEN, mechanism_for
from camopt.model.mechanisms.elements import FACE_GROOVE, GROOVED
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve_design

GROOVE = {"drive": {"kind": "groove"}}
PART = {"thickness": 22, "outer_diameter": 260, "groove_depth": 10, "bore": 30, "density": 7800}
ROLLERS = ("offset-roller", "arm")
ANGLES = np.linspace(0.0, 2 * np.pi, 20_001)[:-1]


def face(contact, **more):
    return Scene.from_dict(cam_with(contact, **{"law": "poly345", **GROOVE, "part": PART, **more}))


@cache
def values(contact, rotation="ccw"):
    scene = face(contact, rotation=rotation)
    return scene, evaluate(scene), *walls(scene)


def walls(scene):
    """The curves, and each wall as a polygon of shapely."""
    problem = resolve_design(scene)
    curves = cam_curves(problem.setup.mechanism, problem.design, problem.programme, ANGLES)
    return curves, [shapely.Polygon(np.column_stack([wall.real, wall.imag])) for wall in curves.profile]


@pytest.mark.parametrize("contact", ROLLERS)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_a_groove_has_the_pitch_curve_of_an_open_cam_and_walls_on_both_sides_of_it(contact, rotation):
    scene, row, curves, (inner, _) = values(contact, rotation)
    free = evaluate(Scene.from_dict(cam_with(contact, law="poly345", rotation=rotation)))
    same = [name for name in free if name.startswith(("pressure_angle", "pitch_", "velocity", "torque", "jump"))]
    assert {name: row[name] for name in same} == {name: free[name] for name in same}
    radius = scene.follower.roller_radius
    assert inner.length == pytest.approx(free["profile_length_mm"], rel=1e-6)
    np.testing.assert_allclose(np.abs(curves.profile - curves.pitch), radius)
    assert row["outer_radius_mm"] == pytest.approx(np.abs(curves.profile[1]).max(), rel=1e-7)
    assert row["edge_wall_min_mm"] == pytest.approx(130.0 - row["outer_radius_mm"], abs=1e-9)
    assert np.abs(curves.profile[0]).min() == pytest.approx(row["base_radius_mm"], rel=1e-9)
    sharpest = max(row["pitch_curvature_max_per_mm"], -row["pitch_curvature_min_per_mm"])
    assert row["profile_radius_min_mm"] == pytest.approx(1.0 / sharpest - radius, rel=1e-12)


@pytest.mark.parametrize("contact", ROLLERS)
def test_a_clearance_takes_its_half_off_the_wall_to_the_edge_and_its_width_off_the_mass(contact):
    """Steiner: a band of the width w about a curve of the length L has the area w·L."""
    tight = values(contact)[1]
    loose = evaluate(face(contact, drive={"kind": "groove", "clearance": 0.8}))
    off = 10.0 * 0.8 * tight["groove_length_mm"] * 7800e-9
    assert loose["cam_mass_kg"] == pytest.approx(tight["cam_mass_kg"] - off, abs=1e-8 * off)
    assert loose["edge_wall_min_mm"] == pytest.approx(tight["edge_wall_min_mm"] - 0.4, rel=1e-9)
    assert loose["outer_radius_mm"] == pytest.approx(tight["outer_radius_mm"] + 0.4, rel=1e-9)


def test_a_groove_round_a_cylinder_is_as_wide_as_its_roller_and_the_clearance():
    """Its pitch curve does not depend on the roller."""
    feeder = find_scene("feeder-with-stop").replace(outputs=["cam_mass_kg"])
    radius = feeder.follower.roller_radius
    loose = feeder.replace(**{"follower.roller_radius": radius - 0.2, "drive.clearance": 0.4})
    assert evaluate(loose)["cam_mass_kg"] == pytest.approx(evaluate(feeder)["cam_mass_kg"], rel=1e-14)


@pytest.mark.parametrize("contact", ROLLERS)
def test_the_groove_is_taken_off_the_mass_of_its_disc(contact):
    """By areas of shapely: the round plate less bore and groove, about its own centre of gravity."""
    _, row, curves, (inner, outer) = values(contact)
    plate = (
        shapely.Point(0, 0).buffer(130.0, quad_segs=4000).area - shapely.Point(0, 0).buffer(15, quad_segs=4000).area
    )
    band = outer.area - inner.area
    assert row["cam_mass_kg"] == pytest.approx(7800e-9 * (22 * plate - 10 * band), rel=1e-6)
    assert row["groove_length_mm"] == pytest.approx(
        np.abs(np.diff(curves.pitch, append=curves.pitch[0])).sum(), rel=1e-6
    )
    assert band == pytest.approx(2 * 14 * row["groove_length_mm"], rel=1e-6)  # Steiner
    moment = outer.area * complex(*outer.centroid.coords[0]) - inner.area * complex(*inner.centroid.coords[0])
    assert row["unbalance_g_mm"] == pytest.approx(abs(moment) * 10 * 7800e-6, rel=1e-5)
    polar = [np.sum(_wedges(wall)) for wall in curves.profile]
    assert row["cam_inertia_kg_m2"] == pytest.approx(
        7800e-15 * (22 * np.pi / 2 * (130**4 - 15**4) - 10 * (polar[1] - polar[0])), rel=1e-6
    )


def _wedges(points):
    """∫r² dA of the triangles from the axis to the sides of a polygon."""
    ends = np.roll(points, -1)
    area = 0.5 * (points.conj() * ends).imag
    return np.abs(area) * (np.abs(points) ** 2 + (points.conj() * ends).real + np.abs(ends) ** 2) / 6.0


@pytest.mark.parametrize("contact", ROLLERS)
def test_each_wall_bears_the_force_of_its_sign(contact):
    """Hertz's stress at dense cam angles, from points: N by the column of points, 1/R = 1/R_r ± κ of the wall."""
    scene = face(contact)
    if contact != "arm":
        scene = scene.replace(**{"follower.dynamics.friction": None})
    points, found = cam_points(scene, step=0.05), evaluate(scene)
    modulus, width = 206e3 / (1 - 0.3**2) / 2, 15.0
    for name, wall, sign in (("push", "inner", 1.0), ("pull", "outer", -1.0)):
        force = np.maximum(sign * points["normal_force_N"] * np.sign(points["contact_force_N"]), 0.0)
        bend = 1.0 / scene.follower.roller_radius + points[f"profile_{wall}_curvature_per_mm"]
        stress = np.sqrt(force / width * modulus / np.pi * bend).max()
        assert found[f"contact_stress_{name}_MPa"] == pytest.approx(stress, rel=2e-4)
    assert found["contact_stress_max_MPa"] == max(
        found["contact_stress_push_MPa"], found["contact_stress_pull_MPa"]
    )


def random_groove(seed, contact):
    """A random cam, with a lobe or a notch, from slim to stout."""
    random = np.random.default_rng([seed, len(contact)])
    rise, fall, between = *random.uniform(15, 150, 2), random.uniform(0.1, 10)
    angles = [
        (rise, between, fall, 360 - rise - between - fall),
        (rise, 360 - rise - between - fall, fall, between),
    ]
    lift = random.uniform(5, 70) if contact == "arm" else random.uniform(20, 160)
    data = cam_with(contact, law=str(random.choice(["cycloidal", "poly345", "harmonic"])), **GROOVE, outputs=[])
    data["motion"] = turn_of(data["motion"][0]["law"], float(lift), angles[int(random.integers(2))])
    base, roller = 10 ** random.uniform(0.0, 1.8), 10 ** random.uniform(0.0, 1.7)
    data["cam"] |= {"base_radius": float(base), "rotation": str(random.choice(["ccw", "cw"]))}
    own = {"offset": float(random.uniform(-0.95, 0.95) * (base + roller))}
    if contact == "arm":
        own = {key: float(random.uniform(60, 200)) for key in ("arm_length", "centre_distance")}
    data["follower"] |= {"roller_radius": float(roller), "dynamics": {}, **own}
    if seed % 2:
        data["drive"] = {"kind": "groove", "clearance": 0.1 * float(roller)}
    return data


@pytest.mark.parametrize(
    ("contact", "seeds"), [("offset-roller", times(25, deep=200)), ("arm", times(30, deep=250))]
)
def test_a_wall_crosses_itself_if_and_only_if_its_points_do(contact, seeds):
    """Random cams: each wall that runs forwards all along, against the polygon of its points."""
    met = dict.fromkeys([(-1.0, False), (1.0, False)], 0)
    for seed in range(seeds):
        try:
            problem = resolve_design(Scene.from_dict(random_groove(seed, contact)))
        except BadInput:  # it cannot be put together
            continue
        setup, design, programme = problem.setup, problem.design, problem.programme
        curves = cam_curves(setup.mechanism, design, programme, ANGLES)
        pitch = np.diff(curves.pitch, append=curves.pitch[0])
        for flank in setup.mechanism.flanks:
            wall = curves.pitch + flank.side * problem.wall_distance_from_pitch_curve * curves.normal
            if (np.diff(wall, append=wall[0]) / pitch).real.min() > 0.0:
                crossing = wall_crossing_verdicts(setup, design, programme, flank.side)[0].crosses
                assert crossing is not shapely.LinearRing(np.column_stack([wall.real, wall.imag])).is_simple
                met[flank.side, crossing] = met.get((flank.side, crossing), 0) + 1
    assert min(met[side, False] for side in (-1.0, 1.0)) >= times(3, deep=10)


@pytest.mark.parametrize("contact", ROLLERS)
def test_the_roller_cuts_as_deep_into_a_wall_as_the_overlap_says(contact):
    """(w² − |P(a) − C(b)|²)·|C'(a)|, with P and C as they are drawn, and w of R_r and half the clearance."""
    problem = resolve_design(face(contact, drive={"kind": "groove", "clearance": 0.6}))
    setup, design, programme, radius = (
        problem.setup,
        problem.design,
        problem.programme,
        problem.wall_distance_from_pitch_curve,
    )
    pairs = np.random.default_rng(3).uniform(0.0, 6.28, (50, 2))
    one, other = (cam_curves(setup.mechanism, design, programme, angles) for angles in pairs.T)
    step = 1e-6
    ends = [cam_curves(setup.mechanism, design, programme, pairs[:, 0] + side * step).pitch for side in (-1.0, 1.0)]
    speed = np.abs(ends[1] - ends[0]) / (2.0 * step)
    for flank in setup.mechanism.flanks:
        wall = one.pitch + flank.side * radius * one.normal
        expected = (radius**2 - np.abs(wall - other.pitch) ** 2) * speed
        found = profile_overlaps(setup, design, programme, pairs[None], flank.side)[0]
        np.testing.assert_allclose(found, expected, rtol=1e-7)
        near = refine_overlap_angles(setup, design, programme, pairs[:1], flank.side)
        assert profile_overlaps(setup, design, programme, near[None], flank.side)[0, 0] >= found[0]
        best = largest_overlap_angles(setup, design, programme, near[0], flank.side)
        assert profile_overlaps(setup, design, programme, best[None, None], flank.side)[0, 0] >= found[0]


@pytest.mark.slow
def test_the_smallest_groove_is_that_of_a_dense_scan_and_proved_on_both_sides_of_its_bound():
    scene = find_scene("face-groove-shutter").replace(
        **{"search.arm_length": None, "limits.edge_wall_min_mm": 12.0}
    )
    best = optimise(scene).best
    scanned = evaluate_designs(scene, {"base_radius_mm": np.linspace(18.0, 58.0, 201)})
    held = scanned["base_radius_mm"][scanned["feasible"]].min()
    assert best["proved"]
    assert held - 0.2 <= best["base_radius_mm"] <= held
    least = best["base_radius_mm"]
    verdicts = [certify(scene.replace(**{"cam.base_radius": least * (1.0 + side * 1e-9)})) for side in (1.0, -1.0)]
    assert set(verdicts[0].values()) == {"held"}
    assert {name for name, each in verdicts[1].items() if each == "broken"} == set(best["binding"])
    wall = evaluate(scene)["edge_wall_min_mm"]
    for share, said in ((1.0 - 1e-9, "held"), (1.0 + 1e-9, "broken")):
        assert certify(scene.replace(**{"limits.edge_wall_min_mm": wall * share}))["edge_wall_min_mm"] == said


def test_a_groove_that_breaks_out_of_its_disc_is_not_feasible():
    scene = find_scene("face-groove-shutter").replace(
        **{"part.outer_diameter": 120, "limits.edge_wall_min_mm": None}
    )
    row = evaluate(scene.replace(outputs=["outline"]))
    assert (row["feasible"], row["violated"]) == (False, "outer_diameter")
    assert row["edge_wall_min_mm"] < 0.0


def tight():
    """The shutter with a groove as wide as its roller."""
    return find_scene("face-groove-shutter").replace(**{"drive.clearance": None, "limits.crossing_speed": None})


@pytest.mark.slow
@pytest.mark.parametrize("cutter", [6.0, 3.5])
def test_a_program_in_the_plane_cuts_both_walls(tmp_path, cutter):
    """Read back by its lines: cuts as far from the pitch curve as the cutter is narrower, to the groove's depth."""
    scene = tight()
    more = {"roughing": 0.5} if cutter < 6.0 else {}
    told = export(scene, tmp_path / "cam.nc", cutter_radius=cutter, feed=200.0, depth_step=4.0, **more)
    text = re.sub(r"\(.*?\)", "", (tmp_path / "cam.nc").read_text())
    depths = list(map(float, re.findall(r"Z(-[\d.]+)", text)))
    passes = [-3.0, -6.0, -9.0]
    assert depths == passes if cutter == 6.0 else passes + 4 * [-9.0]
    lines = np.array([complex(*map(float, each)) for each in re.findall(r"G[23] X(\S+) Y(\S+)", text)])
    pitch = shapely.LinearRing(np.column_stack([p := walls(scene)[0].pitch, p]).view(float).reshape(-1, 4)[:, :2])
    away = shapely.distance(pitch, shapely.points(lines.real, lines.imag))
    rooms = {0.0} if cutter == 6.0 else {0.0, 2.0, 2.5}
    assert away.max() <= 6.0 - cutter + 0.001
    for room in rooms:
        assert np.sum(np.abs(away - room) < 0.001) > 20
    expected = {"middle"} if cutter == 6.0 else {
        "middle", "roughing_inner", "roughing_outer", "cutter_inner", "cutter_outer"
    }  # fmt: skip
    assert set(told.curves) == expected


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cutter_radius": 1.9}, "cutter_radius = 1.9: must be at least 2 mm, a third of the roller radius"),
        ({"cutter_radius": 6.1}, "cutter_radius = 6.1: must be above 0 and at most 6 mm"),
        ({"cutter_radius": 5.0, "roughing": 1.0}, "roughing = 1.0: must be below 1 mm"),
        ({"cutter_radius": 5.0, "depth": 9.5}, r"depth = 9.5: must be at most part.groove_depth \(9 mm\)"),
        ({"cutter_radius": 5.0, "blank_diameter": 200.0}, "blank_diameter = 200.0: has no meaning for a groove"),
    ],
)
def test_a_program_that_would_spoil_a_groove_is_refused(tmp_path, settings, message):
    with pytest.raises(BadInput, match=message):
        export(tight(), tmp_path / "cam.nc", feed=100.0, **settings)


@pytest.mark.slow
@pytest.mark.parametrize("curves", ["arcs", "spline"])
def test_the_solid_has_the_volume_of_its_mass(tmp_path, curves):
    scene = tight().replace(**{"part.density": 7800.0})
    found = export(scene, tmp_path / "cam.step", curves=curves)
    assert found.about["volume_mm3"] == pytest.approx(
        evaluate(scene.replace(outputs=["solid"]))["cam_mass_kg"] / 7.8e-6, rel=1e-5
    )
    with pytest.raises(
        BadInput, match=r"part.outer_diameter = 124.0: must be above 124.45 mm: the groove breaks through the edge"
    ):
        export(scene.replace(**{"part.outer_diameter": 124.0}), tmp_path / "cam.step")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"follower.contact": "knife", "follower.roller_radius": None}, "drive.kind = 'groove': must be 'spring'"),
        ({"part.groove_depth": 30}, r"part.groove_depth = 30.0: must be below the thickness \(18\)"),
        ({"part.hub_diameter": 30}, r"part.hub_diameter = 30: a grooved disc cam has none"),
        ({"cam.mean_radius": 30}, r"cam.mean_radius = 30: a grooved disc cam with an oscillating"),
        ({"drive.kind": None}, r"part.outer_diameter = 140.0: a disc cam has none"),
        ({"limits.cutter_radius": 4}, "limits.cutter_radius = 4: the cutter of a groove is at most as large"),
    ],
)  # fmt: skip
def test_a_scene_that_cannot_be_is_told(changes, message):
    with pytest.raises(BadInput, match=message):
        find_scene("face-groove-shutter").replace(**changes)


def test_both_motions_have_it_and_only_with_rollers():
    assert {each.motion.name for each in DRIVEN if each.body == FACE_GROOVE} == {"translating", "oscillating"}
    for motion in ("translating", "oscillating"):
        assert mechanism_for("disc", motion, "roller", GROOVED.name).body == FACE_GROOVE
        assert mechanism_for("disc", motion, "flat", GROOVED.name).body != FACE_GROOVE

"""Ribs of cylinders and discs, against both rollers of one rigid follower on the flanks that files have."""

from functools import cache, partial

import ezdxf
import mpmath
import numpy as np
import pytest
import shapely
from matplotlib.figure import Figure
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from support.controls import run_iso
from support.depth import times
from support.pairs import pair
from support.ribs import centres, flanks, rib, rollers
from support.solids import solids_in

import camopt
from camopt.core.mistakes import BadInput
from camopt.core.numerics.curves import value_and_slope
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.contacts import all_follower_contacts, block_at_contact
from camopt.model.effects.rib import EFFECT, RIB_THICKNESS
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.show.drawing.cam import draw_disc
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture
from camopt.show.exporting import shapes
from camopt.solve.verdicts.effect_runs import run_effects

ANGLES = np.radians(np.arange(360.0) + 0.37)
MOTIONS = ("translating", "oscillating")
KINDS = [(form, motion) for form in ("cylindrical", "disc") for motion in MOTIONS]
PLACES = ("first", "second")
PART = {"thickness": 130, "rib_height": 14, "bore": 40, "density": 7800}
PARTS = {"cylindrical": PART, "disc": {**PART, "thickness": 30, "outer_diameter": 400}}


@cache
def problems(form, motion):
    """Random ribs that are not undercut, and where rollers leave a rib."""
    rng, found = np.random.default_rng(39), []
    while len(found) < times(4, 100):
        problem = resolve_design(Scene.from_dict({**rib(rng, motion, form), "part": PARTS[form]}))
        if not quantity(problem, "undercut") and quantity(problem, RIB_THICKNESS) > 0.0:
            found.append(problem)
    return found


def quantity(problem, name):
    return run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), (name,)).column(name)[0]


def nearest_flank_points(problem, which, angles):
    """The point of a flank that is nearest to its roller, and how near: over the turn, then closer and closer."""
    centre = centres(problem, angles)[which][:, None]
    every = np.linspace(-1.0, 2.0 * np.pi + 1.0, 2001)
    at, step = every[np.abs(flanks(problem, every)[which] - centre).argmin(axis=1)], every[1] - every[0]
    for _ in range(5):
        near = at[:, None] + step * np.linspace(-1.0, 1.0, 41)
        points = flanks(problem, near.ravel())[which].reshape(near.shape)
        best = np.abs(points - centre).argmin(axis=1)[:, None]
        at, step = np.take_along_axis(near, best, axis=1)[:, 0], step / 15.0
    found = np.take_along_axis(points, best, axis=1)[:, 0]
    return found, np.abs(found - centre[:, 0])


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(("form", "motion"), KINDS)
def test_both_rollers_of_a_rigid_follower_touch_the_rib_all_the_turn(form, motion):
    """And what is told of each flank is what the flank and its roller have there."""
    for problem in problems(form, motion):
        both, design = rollers(problem, ANGLES), problem.design
        assert np.abs(np.abs(both[0].centre - both[1].centre) - design.roller_spacing[0]).max() < 1e-12
        for which, place in enumerate(PLACES):
            points, distance = nearest_flank_points(problem, which, ANGLES)
            assert np.abs(distance - design.roller_radius[0]).max() < 1e-8
            seen = (both[which].centre - points) / distance * both[which].way.conj()
            assert np.all((seen.real > 0.0) if which == 0 else (seen.real < 0.0))  # from both sides
            slant = np.degrees(np.arctan(np.abs(seen.imag / seen.real))).max()
            told = quantity(problem, f"{place}_pressure_angle_max_deg")
            assert told - 3e-3 * told < slant <= told + 1e-4
            drawn = flanks(problem, np.linspace(0.0, 2.0 * np.pi, 7201)[:-1])[which]
            steps = np.diff(drawn)
            bent = np.angle(steps[1:] / steps[:-1]) / np.abs(steps[1:])
            left = -1.0 if form == "cylindrical" else -design.sense  # where the first roller is right of its way
            bulge = (left * bent if which == 0 else -left * bent).max()
            sharpest = 1.0 / quantity(problem, f"{place}_profile_radius_min_mm")
            assert bulge == pytest.approx(sharpest, rel=2e-2) or max(bulge, sharpest) < 1e-9


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("form", "motion"), KINDS)
def test_the_rib_is_nowhere_thinner_than_its_thickness(form, motion):
    """Over all pairs of points of both flanks; where the motion is steep for long it is as thin."""
    for problem in problems(form, motion):
        one, other = flanks(problem, np.linspace(-1.0, 2.0 * np.pi + 1.0, 1501))
        least = np.abs(one[:, None] - other[None, :]).min()
        told = quantity(problem, RIB_THICKNESS)
        assert told - 1e-9 <= least < told + 0.04 * problem.design.roller_spacing[0]


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_rib_seen_in_a_mirror_across_the_axis_has_its_flanks_exchanged(motion):
    """Its motion is reversed then."""
    problem = problems("cylindrical", motion)[0]
    turned = {"rise": "return", "return": "rise", "dwell": "dwell"}
    rows = [
        {"segment": turned[each.segment], "angle": each.angle}
        | ({} if each.segment == "dwell" else {"lift": problem.programme.lift, "law": each.law})
        for each in problem.segments
    ]
    rows = rows[2:] + rows[:2]  # a turn starts where the follower is lowest
    if problem.setup.angular:
        rows = [row | ({"lift": np.degrees(row["lift"])} if "lift" in row else {}) for row in rows]
    scene = rib(np.random.default_rng(39), motion)
    mirrored = resolve_design(Scene.from_dict({**scene, "motion": rows}))
    for name in ("pressure_angle_max_deg", "profile_radius_min_mm"):
        for one, other in (PLACES, PLACES[::-1]):
            assert quantity(mirrored, f"{one}_{name}") == pytest.approx(
                quantity(problem, f"{other}_{name}"), rel=1e-9
            )
    assert quantity(mirrored, RIB_THICKNESS) == pytest.approx(quantity(problem, RIB_THICKNESS), rel=1e-9)


def exact_roller_centre(problem, angle, which):
    """A roller's centre, and the way in which its follower moves it, as mpmath has them, on a 3-4-5 rise."""
    design, programme, mpf = problem.design, problem.programme, mpmath.mpf
    stroke, sense, disc = programme.strokes[0], int(design.sense), not problem.setup.mechanism.body.developed
    size, d, radius, l, c, e = (  # noqa: E741
        mpf(float(each[0]))
        for each in (
            design.size,
            design.roller_spacing,
            design.roller_radius,
            design.arm_length,
            design.centre_distance,
            design.offset,
        )
    )
    x, lift, i = angle / mpf(float(stroke.angle)), mpf(programme.lift), mpmath.mpc(0, 1)
    y = lift * (10 * x**3 - 15 * x**4 + 6 * x**5)
    share = (mpf(0), mpf(-1))[which] if disc else (mpf(1) / 2, -mpf(1) / 2)[which]
    turned = mpmath.exp(-i * sense * angle) if disc else mpf(1)
    moved = mpf(0) if disc else size * angle
    if not problem.setup.angular:
        place = e + i * (mpmath.sqrt((size + radius) ** 2 - e**2) + y) if disc else i * y
        return turned * (place + i * share * d) + moved, turned * i
    apart = 2 * mpmath.asin(d / (2 * l))
    if disc:
        psi = mpmath.acos((c**2 + l**2 - (size + radius) ** 2) / (2 * c * l)) + y + share * apart
        arm = -l * mpmath.exp(-i * psi)
        return turned * (c + arm), -turned * i * arm / l
    psi = y - lift / 2 + share * apart
    arm = l * mpmath.mpc(-sense * mpmath.cos(psi), mpmath.sin(psi))
    return moved + arm, -i * sense * arm / l


@pytest.mark.parametrize("rotation", ["cw", "ccw"])
@pytest.mark.parametrize(("form", "motion"), KINDS)
def test_curves_of_both_flanks_have_the_digits_of_fifty(form, motion, rotation):
    """From the path of each roller's centre alone, with its derivatives, on the first half of a rise."""
    scene = rib(np.random.default_rng(5), motion, form)
    scene["cam"]["rotation"], scene["motion"][0]["law"] = rotation, "poly345"
    problem = resolve_design(Scene.from_dict(scene))
    case, sense = EvaluationBlock(problem.setup, problem.programme, problem.design), int(problem.design.sense)
    ((thickness, _),) = EFFECT.peaks(problem.setup)[RIB_THICKNESS].curves
    with mpmath.workdps(50):
        for theta in map(mpmath.mpf, (0.11, 0.4, 0.63)):
            state, normals, made = problem.programme.state(np.array([float(theta)])), [], []
            for which, contact in enumerate(all_follower_contacts(problem.setup)):
                centre, way = exact_roller_centre(problem, theta, which)
                at = block_at_contact(case, contact)
                first, second = (
                    mpmath.diff(lambda t, k=which: exact_roller_centre(problem, t, k)[0], theta, n) for n in (1, 2)
                )
                side = (1 if which == 0 else -1) * (sense if form == "disc" else 1)
                normals.append((centre, mpmath.mpc(0, side) * first / abs(first)))
                seen = normals[-1][1] * mpmath.conj(way)
                bend = -side * mpmath.im(mpmath.conj(first) * second) / abs(first) ** 3
                of = at.setup.mechanism
                made += [(of.pressure, at, abs(seen.imag / seen.real)), (of.curvature, at, bend)]
            (one, out), (other, back) = normals
            line = (one - other) / abs(one - other)
            across, leant = (mpmath.re(line * mpmath.conj(each)) for each in (out, -back))
            thick = abs(one - other) * (across + leant) / (1 - mpmath.re(out * mpmath.conj(back)))
            thick -= 2 * mpmath.mpf(float(problem.design.roller_radius[0]))
            for make, at, exact in (*made, (thickness, case, thick)):
                value = float(np.squeeze(value_and_slope(make(at.designs, at.programme), ..., state)[0]))
                slanted = make is at.setup.mechanism.pressure
                assert (abs(value) if slanted else value) == pytest.approx(float(exact), rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("motion", MOTIONS)
def test_each_flank_of_a_disc_has_the_loads_of_a_cam_of_its_own(motion):
    """Those of an open cam outside, and inside those of the outer wall of a groove for the inner roller."""
    scene = rib(np.random.default_rng(4), motion, "disc")
    scene["follower"]["dynamics"] = {"inertia": 0.02, "load": 3.0} if motion == "oscillating" else {"mass": 2.0}
    oil = {"viscosity": 0.05, "pressure_viscosity": 20, "roughness": 0.4}
    scene["materials"] = {"cam": "steel", "follower": "steel", "face_width": 12, **oil}
    problem = resolve_design(Scene.from_dict(scene))
    inner = problem.setup.mechanism.further_contacts[0].local_designs(problem.design).size[0]
    single = {k: v for k, v in scene["follower"].items() if k != "roller_spacing"}
    own = {"cam": {**scene["cam"], "base_radius": inner}, "follower": single, "drive": {"kind": "groove"}}
    spring = Scene.from_dict({**scene, "follower": single, "drive": {"kind": "spring"}})
    groove = resolve_design(Scene.from_dict({**scene, **own}))
    for place, alone, stress in (
        ("first", resolve_design(spring), "contact_stress_max_MPa"),
        ("second", groove, "contact_stress_pull_MPa"),
    ):
        for name, other in (
            ("pressure_angle_max_deg", "pressure_angle_max_deg"),
            ("contact_stress_max_MPa", stress),
        ):
            assert quantity(problem, f"{place}_{name}") == pytest.approx(quantity(alone, other), rel=1e-9)
    spins = [quantity(each, "roller_speed_max_rpm") for each in (problem, resolve_design(spring), groove)]
    assert spins[0] == pytest.approx(max(spins[1:]), rel=1e-9)  # the inner one spins the faster
    undercut = quantity(groove, "pitch_curvature_min_per_mm")
    assert quantity(problem, "second_profile_radius_min_mm") == pytest.approx(
        1.0 / max(-undercut, 0.0) - problem.design.roller_radius[0] if undercut < 0.0 else np.inf, rel=1e-9
    )


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_mass_of_a_ribbed_disc_is_that_of_a_plate_with_a_ring(motion):
    problem, part = problems("disc", motion)[1], PARTS["disc"]
    rings = flanks(problem, np.linspace(0.0, 2.0 * np.pi, 40_001)[:-1])
    outer, inner = (shapely.Polygon(np.column_stack([ring.real, ring.imag])) for ring in rings)
    ring, bore = outer.difference(inner), np.pi * part["bore"] ** 2 / 4
    below = np.pi * part["outer_diameter"] ** 2 / 4 - bore
    volume = below * (part["thickness"] - part["rib_height"]) + ring.area * part["rib_height"]
    assert quantity(problem, "cam_mass_kg") == pytest.approx(volume * part["density"] * 1e-9, rel=1e-7)
    unbalance = ring.area * np.hypot(ring.centroid.x, ring.centroid.y) * part["rib_height"]
    assert quantity(problem, "unbalance_g_mm") == pytest.approx(unbalance * part["density"] * 1e-6, rel=1e-5)
    wall = np.abs(rings[1]).min() - part["bore"] / 2
    assert quantity(problem, "hub_wall_min_mm") == pytest.approx(wall, rel=1e-9)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_picture_of_a_rib_has_its_mass_and_those_of_its_rollers_have_none(motion):
    scene = {**rib(np.random.default_rng(4), motion, "disc"), "part": PARTS["disc"], "outputs": ["solid"]}
    scene = Scene.from_dict(scene)
    picture = Picture(scene, resolve_design(scene))
    assert picture.quantity_values["cam_mass_kg"] == pytest.approx(camopt.evaluate(scene)["cam_mass_kg"], rel=1e-12)
    assert not [each for each in picture.contacts if "cam_mass_kg" in each.quantity_values]


@pytest.mark.parametrize("make", [partial(rib, form="disc"), pair])
def test_the_pitch_point_of_a_picture_is_that_of_the_steepest_contact(make):
    """On the path of its roller, a roller's radius from the profile as it is drawn."""
    scene = Scene.from_dict(make(np.random.default_rng(4), "translating"))
    picture, axes = Picture(scene, resolve_design(scene)), Figure().add_subplot()
    draw_disc(axes, picture)
    ((x, y),) = next(line for line in axes.lines if line.get_label() == "pitch point").get_xydata()
    steepest = max(picture.contacts, key=lambda each: each.quantity_values["pressure_angle_max_deg"])
    which = picture.contacts.index(steepest)
    assert which == 1  # or there is nothing to see
    both = flanks(picture.problem, np.linspace(0.0, 2.0 * np.pi, 7201))
    radius = steepest.problem.design.roller_radius[0]
    assert np.abs(both[which] - (x + 1j * y)).min() == pytest.approx(radius, rel=1e-6)
    (marked,) = [peak for peak in motion_panels(picture)[4].peaks if peak.text.startswith("pitch point")]
    assert abs(marked.value) == steepest.quantity_values["pressure_angle_max_deg"]


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_mass_of_a_ribbed_cam_is_that_of_its_core_and_of_slices_of_its_rib(motion):
    """Slices at radii through the rib, each the area between both flanks, cut at the slope that it has there."""
    problem = problems("cylindrical", motion)[1]
    design, angles = problem.design, np.linspace(0.0, 2.0 * np.pi, 20_001)
    mean, radius = design.size[0], design.roller_radius[0]
    core, top = mean - PART["rib_height"] / 2, mean + PART["rib_height"] / 2
    pitch = centres(problem, angles)
    shares, weights = np.polynomial.legendre.leggauss(8)
    volume = polar = 0.0
    for share, weight in zip(shares, weights, strict=True):
        here = mean + share * (top - mean)
        area = 0.0
        for side, points in zip((1.0, -1.0), pitch, strict=True):
            slice_ = points.real * here / mean + 1j * points.imag
            normal = 1j * np.gradient(slice_, angles)
            flank = slice_ - side * radius * normal / np.abs(normal)
            area += side * np.sum((flank.imag[1:] + flank.imag[:-1]) / 2 * np.diff(flank.real))
        volume += weight * (top - mean) * area
        polar += weight * (top - mean) * area * here**2
    bore = PART["bore"] / 2
    solid = np.pi * (core**2 - bore**2) * PART["thickness"], np.pi / 2 * (core**4 - bore**4) * PART["thickness"]
    density = PART["density"] * 1e-9
    assert quantity(problem, "cam_mass_kg") == pytest.approx(density * (solid[0] + volume), rel=1e-7)
    assert quantity(problem, "cam_inertia_kg_m2") == pytest.approx(density * 1e-6 * (solid[1] + polar), rel=1e-7)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("drive", "preload", "load"),
    [
        ({}, 0.0, 40.0),
        ({}, 0.0, 2000.0),  # the second roller never touches
        ({"interference": 0.01, "stiffness": 10e3}, 100.0, 40.0),
        ({"interference": 0.01, "stiffness": 40e3}, 400.0, 40.0),
    ],
)
def test_each_flank_bears_the_force_of_its_sign_and_a_preload_is_on_both(drive, preload, load):
    """Hertz's stress and the film of Dowson and Higginson at dense cam angles: N from the force and the slope, the
    curvature from the flanks."""
    scene = rib(np.random.default_rng(2), "translating")
    oil = {"viscosity": 0.08, "pressure_viscosity": 20, "roughness": 0.4}
    scene["materials"] = {"cam": "steel", "follower": "steel", "face_width": 12, **oil}
    angles, modulus = np.linspace(0.0, 2.0 * np.pi, 7201), 207e3 / (1 - 0.292**2) / 2
    scene["follower"]["dynamics"] = {"mass": 5.0, "load": load}
    asked = {"drive": {"kind": "rib", **drive}, "outputs": ["hertz", "surface"]}
    problem, films = resolve_design(Scene.from_dict({**scene, **asked})), []
    y1, y2 = problem.programme.motion_at(angles)[1:3]
    force = 5e-3 * (300 * np.pi / 30) ** 2 * y2 + load
    slope = y1 / problem.design.size[0]
    bend = -y2 / problem.design.size[0] ** 2 / (1 + slope**2) ** 1.5
    radius = problem.design.roller_radius[0]
    for place, sign in zip(PLACES, (1.0, -1.0), strict=True):
        shared = sign * force / 2 + np.maximum(np.abs(force) / 2, preload)
        normal = shared * np.sqrt(1 + slope**2)
        hollow = radius * (1 - radius * sign * bend)
        stress = np.sqrt(normal / 12 * modulus / np.pi / hollow).max()
        assert quantity(problem, f"{place}_contact_stress_max_MPa") == pytest.approx(stress, rel=1e-6)
        speed = 0.08e-6 * 10 * np.pi * problem.design.size[0] * np.sqrt(1 + slope**2) * hollow / radius
        with np.errstate(divide="ignore"):
            film = 2.65e3 * hollow * (20e-3 * 2 * modulus) ** 0.54 * (speed / (2 * modulus * hollow)) ** 0.7
            film *= (normal / (2 * modulus * hollow * 12)) ** -0.13
        lost = normal.min() <= 0.0 < normal.max()
        films.append(0.0 if lost else film.min())
    assert quantity(problem, "film_thickness_min_um") == pytest.approx(min(films), rel=1e-6)


def test_rollers_of_a_rib_roll_on_their_flanks_without_turning_round():
    scene = camopt.Scene.from_dict(
        {**rib(np.random.default_rng(3), "oscillating"), "outputs": ["surface", "frame"]}
    )
    problem, row = resolve_design(scene), camopt.evaluate(scene)
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
    y1 = problem.programme.motion_at(angles)[1]
    omega, radius = 300 * np.pi / 30, problem.design.roller_radius[0]
    fastest = 0.0
    for points, sign in zip(centres(problem, angles), (1.0, -1.0), strict=True):
        speed = np.abs(np.gradient(points, angles))
        spin = speed / radius - sign * problem.design.sense * y1  # against the arm, which turns over the mantle
        fastest = max(fastest, np.abs(spin[1:-1]).max())
    assert row["roller_speed_max_rpm"] == pytest.approx(fastest * omega * 30 / np.pi, rel=1e-5)
    assert row["subtending_angle_deg"] == pytest.approx(
        np.degrees(2 * np.arcsin(problem.design.roller_spacing[0] / 2 / problem.design.arm_length[0])), rel=1e-12
    )
    assert not [name for name in row if name.startswith(("slip", "skidding", "groove_length", "self_crossing"))]


def test_a_clearance_is_crossed_as_in_a_groove_and_taken_off_the_rib():
    """The flanks of both have one slope at each cam angle; a rib with none is thicker by it."""
    scene = rib(np.random.default_rng(6), "translating")
    scene["follower"]["dynamics"] = {"mass": 3.0}
    scene["outputs"] = ["rib_thickness_min_mm"] + [
        f"crossing_{n}" for n in ("count", "speed_max_m_s", "time_max_ms")
    ]
    loose, tight = ({**scene, "drive": {"kind": "rib", **more}} for more in ({"clearance": 0.04}, {}))
    found = camopt.evaluate(Scene.from_dict(loose))
    tight = Scene.from_dict({**tight, "outputs": [RIB_THICKNESS]})
    assert found[RIB_THICKNESS] == pytest.approx(camopt.evaluate(tight)[RIB_THICKNESS] - 0.04, abs=1e-12)
    groove = {**scene, "drive": {"kind": "groove", "clearance": 0.04}, "outputs": scene["outputs"][1:]}
    groove["follower"] = {k: v for k, v in scene["follower"].items() if k != "roller_spacing"}
    alike = camopt.evaluate(Scene.from_dict(groove))
    assert {name: found[name] for name in alike if name.startswith("crossing")} == {
        name: alike[name] for name in alike if name.startswith("crossing")
    }


@pytest.mark.long
def test_the_smallest_rib_is_that_of_a_scan():
    scene = rib(np.random.default_rng(7), "oscillating")
    del scene["cam"]["mean_radius"]
    scene["limits"] = {"pressure_angle": 40, "rib_thickness_min_mm": 6, "curvature_radius": 4}
    search = {"mean_radius": {"start": 30, "stop": 200}}
    scene = Scene.from_dict({**scene, "search": search})
    least = camopt.optimise(scene).best["mean_radius_mm"]
    scanned = camopt.evaluate_designs(scene, {"mean_radius_mm": np.linspace(0.97, 1.03, 25) * least})
    assert least <= scanned["mean_radius_mm"][scanned["feasible"]].min() <= least * 1.003


@pytest.mark.slow
def test_a_cam_whose_rollers_leave_no_rib_is_none(tmp_path):
    """cos β_max = 2·R_r/d at the smallest mean radius with a rib, tan β_max = max |y'|/R there."""
    scene = {**rib(np.random.default_rng(7), "translating"), "limits": {"pressure_angle": 80}}
    del scene["cam"]["mean_radius"]
    scene["follower"]["roller_spacing"] = 2.2 * scene["follower"]["roller_radius"]
    found = camopt.optimise(Scene.from_dict({**scene, "search": {"mean_radius": {"start": 1, "stop": 200}}}))
    best, wanted = found.best, "curvature_radius and rib_thickness_min_mm"
    assert found.warnings == (
        "only built-in limits hold the size of this cam: no_rib; "
        f"if you want to make it, also set [limits] such as {wanted}",
    )
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
    thin, none = (
        Scene.from_dict({**scene, "cam": {**scene["cam"], "mean_radius": best["mean_radius_mm"] * by}})
        for by in (1.0 + 1e-6, 1.0 - 1e-6)
    )
    steepest = np.abs(resolve_design(thin).programme.motion_at(angles)[1]).max()
    assert best["mean_radius_mm"] == pytest.approx(steepest / np.tan(np.arccos(1.0 / 1.1)), rel=1e-6)
    assert (best["binding"], best["proved"]) == (["no_rib"], True)
    assert (camopt.evaluate(none)["violated"], camopt.evaluate(thin)["feasible"]) == ("no_rib", True)
    assert (camopt.certify(none)["no_rib"], camopt.certify(thin)["no_rib"]) == ("broken", "held")
    with pytest.raises(BadInput, match="cannot be made: its rollers leave no rib between them"):
        camopt.export(none, tmp_path / "none.dxf")


BAD = {
    "rollers that overlap": ({"follower.roller_spacing": 10.0}, "above the diameter of the rollers .* rib between"),
    "no spacing": (
        {"follower.roller_spacing": None},
        r"follower\.roller_spacing: missing; a ribbed cylindrical cam",
    ),
    "a spacing without a rib": (
        {"drive.kind": "groove"},
        r"follower\.roller_spacing = .*: a cylindrical cam .* none",
    ),
    "a depth of a groove": (
        {"part.groove_depth": 6.0},
        r"part\.groove_depth = 6.*: a ribbed cylindrical cam has none",
    ),
    "a rib beyond the cylinder": (
        {"part": {"thickness": 30, "rib_height": 9}},
        "must be above .*the length of the rib",
    ),
    "a rib down to the axis": (
        {"part.rib_height": 190.0},
        r"part\.rib_height = 190.*: must be below twice the mean",
    ),
    "both clearance and interference": (
        {"drive.clearance": 0.02, "drive.interference": 0.01, "drive.stiffness": 1e4},
        r"drive\.clearance = 0\.02: contacts with an interference have no clearance",
    ),
    "crossings under preload": (
        {"drive.interference": 0.01, "drive.stiffness": 1e4, "limits": {"crossing_speed": 0.1}},
        "crossing_speed_max_m_s: its contacts stay closed by a preload",
    ),
    "a knife": ({"follower.contact": "knife", "follower.roller_radius": None}, "must be .*groove"),
}


BAD_DISCS = {
    "an inner roller on the axis": (
        "translating",
        {"follower.roller_spacing": 92.0},
        r"roller_spacing = 92.*: must be below .*: the inner roller would reach the axis of the cam",
    ),
    "an inner roller that swings over the axis": (
        "oscillating",
        {"follower.roller_spacing": 110.0},
        r"roller_spacing = 110.*: must be below .*: the inner roller would reach the axis of the cam",
    ),
    "a rib that leaves no plate": (
        "translating",
        {"part": {"thickness": 12, "rib_height": 12}},
        r"part\.rib_height = 12.*: must be below the thickness \(12\): the rib needs a plate below it",
    ),
    "a depth of a groove on a disc": (
        "translating",
        {"part.groove_depth": 6.0},
        r"part\.groove_depth = 6.*: a ribbed disc cam has none",
    ),
}


@pytest.mark.parametrize("name", BAD_DISCS)
def test_a_rib_that_cannot_be_on_a_disc_gets_one_clear_message(name):
    motion, changes, message = BAD_DISCS[name]
    scene = Scene.from_dict(rib(np.random.default_rng(3), motion, "disc"))
    with pytest.raises(BadInput, match=message):
        resolve_design(scene.replace(**changes))


def test_a_follower_that_no_rib_has_is_one_mistake():
    scene = {**rib(np.random.default_rng(3), "translating", "disc"), "part": PARTS["disc"]}
    with pytest.raises(BadInput) as refused:
        Scene.from_dict({**scene, "follower": {**scene["follower"], "contact": "knife"}})
    (mistake,) = refused.value.mistakes
    assert mistake.key == "drive.kind"


FAST = [
    {"segment": "rise", "angle": 70, "lift": 24, "law": "cycloidal"},
    {"segment": "return", "angle": 70, "lift": 24, "law": "cycloidal"},
    {"segment": "dwell", "angle": 220},
]


@pytest.mark.parametrize(
    ("broken", "changes"),
    {
        "undercut": {"cam.base_radius": 50.0, "follower.roller_radius": 16.0, "follower.roller_spacing": 40.0},
        "no_rib": {"follower.roller_spacing": 17.0},
        "shaft_diameter": {"cam.shaft_diameter": 2.0 * (60.0 - 24.0) + 1e-6},
    }.items(),
)
def test_a_disc_whose_rollers_make_no_rib_or_meet_the_shaft_breaks_a_limit(broken, changes):
    """The inner flank is undercut where the outer one is not; the inner roller leaves R_b − d about the axis."""
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 60.0, "rotation": "ccw"},
            "follower": {
                "motion": "translating",
                "contact": "roller",
                "roller_radius": 8.0,
                "roller_spacing": 24.0,
            },
            "drive": {"kind": "rib"},
            "motion": FAST,
        }
    )
    found = camopt.evaluate(scene.replace(**changes, outputs=["pair", "rib"]))
    assert found["violated"].split(", ") == [broken], found["violated"]
    if broken == "undercut":
        assert found["second_profile_radius_min_mm"] < 0.0 < found["first_profile_radius_min_mm"]


@pytest.mark.slow
def test_the_smallest_rib_of_a_disc_is_that_of_a_scan():
    scene = rib(np.random.default_rng(8), "translating", "disc")
    del scene["cam"]["base_radius"]
    scene["limits"] = {"pressure_angle": 30, "rib_thickness_min_mm": 6, "curvature_radius": 4}
    best = camopt.optimise(Scene.from_dict({**scene, "search": {"base_radius": {"start": 20, "stop": 200}}})).best
    sizes = best["base_radius_mm"] * np.array([1.0 - 1e-7, 1.0 + 1e-7, 1.01, 1.05])
    held = [camopt.evaluate(Scene.from_dict({**scene, "cam": {**scene["cam"], "base_radius": s}})) for s in sizes]
    assert [row["feasible"] for row in held] == [False, True, True, True]
    assert best["proved"]


@pytest.mark.parametrize("name", BAD)
def test_a_rib_that_cannot_be_gets_one_clear_message(name):
    changes, message = BAD[name]
    scene = Scene.from_dict(rib(np.random.default_rng(3), "translating"))
    with pytest.raises(BadInput, match=message):
        resolve_design(scene.replace(**changes))


@pytest.mark.parametrize("motion", MOTIONS)
def test_files_have_both_flanks_and_each_has_its_steel_on_the_side_of_the_rib(motion, tmp_path):
    """Read back, rollers of the rigid follower are at their distance from the drawn flanks at 360 angles."""
    scene = Scene.from_dict(rib(np.random.default_rng(11), motion)).replace(**{"part": PART, "cam.rpm": None})
    problem = resolve_design(scene)
    camopt.export(scene, tmp_path / "rib.dxf", chord=0.002, curves="polyline")
    space = ezdxf.readfile(tmp_path / "rib.dxf").modelspace()
    for layer, centre in zip(("PROFILE", "SECOND_PROFILE"), centres(problem, ANGLES), strict=True):
        (line,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
        drawn = shapely.LineString(line.get_points("xy"))
        inside = (centre.real > drawn.bounds[0] + 25.0) & (centre.real < drawn.bounds[2] - 25.0)
        distance = shapely.distance(shapely.points(centre.real, centre.imag), drawn)
        assert np.abs(distance - problem.design.roller_radius[0])[inside].max() < 0.003
    points = camopt.cam_points(scene, np.arange(0.0, 360.0, 5.0))
    xy = [points[f"{name}_x_mm"] + 1j * points[f"{name}_y_mm"] for name in ("profile", "second_profile")]
    normals = [points[f"{n}_normal_x"] + 1j * points[f"{n}_normal_y"] for n in ("profile", "second_profile")]
    assert np.all(((xy[0] - xy[1]) * normals[0].conj()).real > 0.0)
    assert np.all(((xy[1] - xy[0]) * normals[1].conj()).real > 0.0)
    for name, place in zip(("profile", "second_profile"), PLACES, strict=True):
        sharpest = 1.0 / points[f"{name}_curvature_per_mm"].max()
        assert sharpest == pytest.approx(quantity(problem, f"{place}_profile_radius_min_mm"), rel=0.05)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_wheel_that_follows_the_table_is_where_the_rollers_of_a_rigid_follower_are(motion, tmp_path):
    """Of a rigid follower over the mantle; and the wheel touches the flanks as the files have them."""
    scene = Scene.from_dict(rib(np.random.default_rng(11), motion)).replace(part=PART)
    problem, radius = resolve_design(scene), scene.follower.roller_radius
    told = camopt.export(scene, tmp_path / "rib.p", cutter_radius=radius, step=5.0)
    angle, *places = np.loadtxt(tmp_path / "rib.p").T
    assert told.about["lines"] == angle.size == 73
    assert not [note for note in told.notes if "the cutter leaves" in note]
    turn = np.radians(angle)
    wheels = (
        places if motion == "translating" else [y + 1j * x for y, x in zip(places[::2], places[1::2], strict=True)]
    )
    rigid, dense = centres(problem, turn), centres(problem, np.linspace(0.0, 2.0 * np.pi, 40_001))
    ends = [each.imag for each in dense]
    low = (min(map(np.min, ends)) + max(map(np.max, ends)) - PART["thickness"]) / 2.0
    for wheel, centre, flank in zip(wheels, rigid, flanks(problem, np.linspace(-0.3, 6.6, 40_001)), strict=True):
        found = turn * problem.design.size[0] + np.imag(wheel) + 1j * (np.real(wheel) + low)
        assert np.abs(found - centre).max() < 2e-6
        near = [np.abs(flank - one).min() for one in found]
        assert np.abs(np.array(near) - radius).max() < 1e-5
    assert (
        camopt.export(scene, tmp_path / "rib.p", cutter_radius=radius - 1.0)
        .notes[1]
        .startswith("the cutter leaves 1 mm")
    )
    with pytest.raises(BadInput, match=r"cutter_radius = 20\.0: must be above 0 and at most"):
        camopt.export(scene, tmp_path / "rib.p", cutter_radius=20.0)


def on_disc(motion):
    """A rib on a disc with its part, between a dwell and a dwell."""
    scene = Scene.from_dict(rib(np.random.default_rng(11), motion, "disc"))
    return scene.replace(**{"part": PARTS["disc"], "cam.rpm": None})


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("motion", MOTIONS)
def test_files_of_a_disc_have_its_rib(motion, tmp_path):
    """Read back, rollers are at their distance from the flanks, drawn and of the solid."""
    scene = on_disc(motion)
    problem, part = resolve_design(scene), PARTS["disc"]
    camopt.export(scene, tmp_path / "rib.dxf", chord=0.002, curves="polyline")
    space, radius = ezdxf.readfile(tmp_path / "rib.dxf").modelspace(), problem.design.roller_radius[0]
    both, rings = centres(problem, ANGLES), []
    for layer, centre in zip(("PROFILE", "SECOND_PROFILE"), both, strict=True):
        (line,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
        rings.append(shapely.Polygon(line.get_points("xy")))
        distance = shapely.distance(shapely.points(centre.real, centre.imag), rings[-1].exterior)
        assert np.abs(distance - radius).max() < 0.003
    least = [circle.dxf.radius for circle in space.query('CIRCLE[layer=="SECOND_BASE-CIRCLE"]')]
    assert least == pytest.approx([np.abs(both[1]).min() + radius], abs=2e-3)
    told = camopt.export(scene, tmp_path / "rib.step", chord=0.002)
    (solid,) = solids_in(tmp_path / "rib.step")
    mass = quantity(problem, "cam_mass_kg")
    assert told.about["volume_mm3"] * part["density"] * 1e-9 == pytest.approx(mass, rel=2e-5)
    for centre in np.concatenate([each[::60] for each in both]):
        axis = shapes.make_vertex((centre.real, centre.imag, part["thickness"] - 0.5))
        assert BRepExtrema_DistShapeShape(axis, solid).Value() == pytest.approx(radius, abs=0.003)
    points = camopt.cam_points(scene, np.arange(0.0, 360.0, 5.0))
    xy = [points[f"{name}_x_mm"] + 1j * points[f"{name}_y_mm"] for name in ("profile", "second_profile")]
    normals = [points[f"{n}_normal_x"] + 1j * points[f"{n}_normal_y"] for n in ("profile", "second_profile")]
    assert np.all(((xy[0] - xy[1]) * normals[0].conj()).real > 0.0)
    assert np.all(((xy[1] - xy[0]) * normals[1].conj()).real > 0.0)


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("direction", ["climb", "conventional"])
def test_a_program_goes_round_the_rib_of_a_disc_and_then_within_it(direction, tmp_path):
    """Run by an interpreter, its cutter touches each flank all the turn, and never cuts into the rib."""
    scene = on_disc("oscillating")
    asked = {"cutter_radius": 6.0, "feed": 300.0, "roughing": 0.4, "depth_step": 8.0, "direction": direction}
    found = camopt.export(scene, tmp_path / "rib.nc", **asked)
    assert any("only metal near the rib" in note for note in found.notes)
    cuts = run_iso((tmp_path / "rib.nc").read_text()).cuts
    assert [cut.depth for cut in cuts] == [-7.0, -14.0, -7.0, -14.0, -14.0, -14.0]
    turn = np.linspace(0.0, 2.0 * np.pi, 2001)[:-1]
    outer, inner = (np.column_stack([f.real, f.imag]) for f in flanks(resolve_design(scene), turn))
    ring, whole = shapely.Polygon(outer, [inner]), shapely.Polygon(outer)
    for place, cut in enumerate(cuts):
        path = shapely.LineString([(p.real, p.imag) for p in cut.points[::2]])
        stock = 0.4 if place < 4 else 0.0
        assert shapely.distance(path, ring) == pytest.approx(6.0 + stock, abs=2e-3)
        assert shapely.contains(whole, path) == (place in (2, 3, 5))
        if not stock:  # the whole flank
            touched = shapely.points((inner if place == 5 else outer)[::20])
            assert shapely.distance(touched, path).max() < 6.0 + 5e-3
    for settings, message in (
        ({"depth": 15.0}, r"depth = 15.*: must be at most part\.rib_height \(14 mm\)"),
        ({"cutter_radius": 60.0}, r"cutter_radius = 60.*mm"),
    ):
        with pytest.raises(BadInput, match=message):
            camopt.export(scene, tmp_path / "bad.nc", **{**asked, **settings})

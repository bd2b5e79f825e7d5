"""Files of pairs of discs read back: both discs in one frame, and what has one disc refuses."""

import ezdxf
import numpy as np
import pytest
import shapely
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from support.controls import run_iso
from support.pairs import centres, nearest_points, pair, profiles, yoke
from support.solids import enclosed_area, extents, hole, section, solids_in

from camopt import BadInput, MeasuredProfile, Scene, cam_points, evaluate, export, find_scene, inspect_pair
from camopt.model.effects import EvaluationBlock
from camopt.scene.problem.problem import resolve_design
from camopt.show.exporting import shapes
from camopt.show.exporting.stl import is_watertight, read_triangles
from camopt.solve.contour.curve import cam_discs
from camopt.solve.verdicts.effect_runs import run_effects

RNG_SEED = 12
DENSE = np.linspace(0.0, 2.0 * np.pi, 20001)[:-1]


@pytest.fixture(params=["translating", "oscillating"])
def scene(request):
    return Scene.from_dict(pair(np.random.default_rng(RNG_SEED), request.param))


def test_both_discs_of_a_drawing_are_in_one_frame(scene, tmp_path):
    found = export(scene, tmp_path / "pair.dxf")
    assert {"profile", "second_profile"} <= found.curves.keys()
    problem, space = resolve_design(scene), ezdxf.readfile(tmp_path / "pair.dxf").modelspace()
    every = np.linspace(0.0, 2.0 * np.pi, 20001)
    for layer, drawn in zip(("PROFILE", "SECOND_PROFILE"), profiles(problem, every), strict=True):
        (line,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
        corners = np.array([complex(x, y) for x, y in line.get_points("xy")])
        assert np.abs(corners[:, None] - drawn).min(axis=1).max() < 0.02  # of points 0.02 mm from each other


def test_points_of_the_second_disc_are_a_roller_radius_from_its_pitch_curve(scene):
    """Along the normal out of the steel; and they are where the roller of the rigid follower is."""
    problem, points = resolve_design(scene), cam_points(scene, np.arange(0.0, 360.0, 7.0))
    radius = float(problem.setup.mechanism.further_contacts[0].local_designs(problem.design).roller_radius[0])

    def curve(name):
        return points[f"second_{name}_x"] + 1j * points[f"second_{name}_y"]

    pitch, profile = (points[f"second_{n}_x_mm"] + 1j * points[f"second_{n}_y_mm"] for n in ("pitch", "profile"))
    assert np.abs(profile + radius * curve("profile_normal") - pitch).max() < 1e-9
    touched, _ = nearest_points(problem, 1, np.radians(points["cam_angle_deg"]))
    turned = touched * np.exp(-1j * problem.design.sense * np.radians(points["cam_angle_deg"]))
    assert np.abs(turned - profile).max() < 1e-6
    assert (points["second_profile_curvature_per_mm"] > -1.0).all()


def test_each_disc_is_an_ordinary_cam_with_the_quantities_of_its_contact(scene):
    problem, names = resolve_design(scene), ("pressure_angle_max_deg", "profile_radius_min_mm", "outer_radius_mm")
    found = evaluate(scene.replace(outputs=["all"]))
    for place, disc in zip(("first", "second"), cam_discs(problem), strict=True):
        alone = run_effects(EvaluationBlock(disc.problem.setup, disc.problem.programme, disc.problem.design), names)
        for name in names:
            assert alone.column(name)[0] == pytest.approx(found[f"{place}_{name}"], rel=1e-8)


NC = {"cutter_radius": 5.0, "feed": 300.0}
PLATES = {"thickness": 12, "bore": 20, "keyway_width": 4, "keyway_depth": 1.8, "keyway_angle": 37}
HUB = {"hub_diameter": 44, "hub_length": 40}
SLIDES = {"motion": "translating", "contact": "roller", "roller_radius": 16}


def ring(path):
    return shapely.linearrings(np.column_stack([path.real, path.imag]))


def closed_way(machine, count):
    """The closed part of a way: so many moves that end where the one before them ends."""
    moves = machine.cuts[0].moves
    ends = np.array([move[-1] for move in moves])  # to what the centres' digits leave
    (first,) = 1 + np.flatnonzero(np.abs(ends[count:] - ends[:-count]) < 1e-3)
    return np.concatenate(moves[first : first + count])


def paths_of(scene, file):
    """The paths of the cutter in programs of both discs, in the frame of the drawing, and the largest deviation."""
    found, off = [], 0.0
    for disc in (1, 2) if scene.mechanism.second_contact_size_keys else (None,):
        told = export(scene, file, disc=disc, **NC)
        path = closed_way(run_iso(file.read_text()), told.curves["cutter"].elements)
        found.append(-path.conjugate() if disc == 2 else path)
        off = max(off, told.curves["cutter"].deviation_mm)
    return found, off


@pytest.mark.slow
@pytest.mark.parametrize("seed", [RNG_SEED, *(pytest.param(k, marks=pytest.mark.long) for k in range(100, 150))])
@pytest.mark.parametrize("kind", ["translating", "oscillating", "breadth", "diameter"])
def test_both_contacts_touch_what_programs_cut_at_every_step_of_the_turn(kind, seed, tmp_path):
    """The rigid follower at its position, 360 times in the turn, and the contour that a control reads."""
    rng = np.random.default_rng(seed)
    scene = Scene.from_dict((yoke if kind in ("breadth", "diameter") else pair)(rng, kind))
    problem, angles = resolve_design(scene), np.radians(np.arange(0.0, 360.0))
    paths, off = paths_of(scene, tmp_path / "disc.nc")
    turned = np.exp(-1j * problem.design.sense * angles)
    places = enumerate(paths if len(paths) == 2 else paths * 2)
    assert off <= 0.001
    for which, path in places:
        if kind == "breadth":
            sign, lift = (1.0, -1.0)[which], problem.programme.lift
            y = problem.programme.motion_at(angles)[0]
            face = problem.design.size[0] + (y if sign > 0.0 else lift - y)
            reached = [(path * turn.conjugate() / 1j).real.max() for turn in sign * turned]
            gaps = face + NC["cutter_radius"] - reached
        else:
            seen = centres(problem, angles)[which] * turned
            radius = [problem.design, problem.setup.mechanism.further_contacts[0].local_designs(problem.design)][
                which
            ].roller_radius
            away = shapely.distance(shapely.points(seen.real, seen.imag), ring(path))
            gaps = np.abs(away) - np.abs(radius - NC["cutter_radius"])
        assert np.abs(gaps).max() < off + 1e-5  # of the dense points


def test_points_of_both_discs_touch_their_rollers_at_every_step_of_the_turn(scene, tmp_path):
    told = export(scene, tmp_path / "pair.csv")
    table, problem = np.genfromtxt(tmp_path / "pair.csv", delimiter=",", names=True), resolve_design(scene)
    angles = np.radians(np.arange(0.0, 360.0))
    turned = np.exp(-1j * problem.design.sense * angles)
    second = problem.setup.mechanism.further_contacts[0].local_designs(problem.design)
    for which, design in enumerate((problem.design, second)):
        name = ("profile", "second_profile")[which]
        seen, line = centres(problem, angles)[which] * turned, table[f"{name}_x_mm"] + 1j * table[f"{name}_y_mm"]
        gaps = shapely.distance(shapely.points(seen.real, seen.imag), ring(line)) - design.roller_radius
        assert np.abs(gaps).max() <= told.curves[name].deviation_mm + 1e-9


def on_crank(slide, crank, coupler, offset, start):
    """The angle of the crank at which a slide is where it is asked, by bisection of its closed loop."""
    first = np.radians(start)

    def place(angle):
        return crank * np.cos(angle) + np.sqrt(coupler**2 - (crank * np.sin(angle) - offset) ** 2)

    low, high = np.full(slide.shape, first), np.full(slide.shape, first + 1.0)
    for _ in range(60):
        middle = (low + high) / 2
        beyond = place(middle) - place(first) > slide
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return low - first


@pytest.mark.slow
def test_discs_of_a_pair_that_drives_a_slide_hold_its_arms_where_the_slide_is_asked(tmp_path):
    """The rigid follower where the closed loop of its crank has it: on points and measured discs."""
    stage = {"stage": "bell-crank", "crank": 160, "coupler": 220, "offset": -150, "angle": -110}
    feed = find_scene("press-feed-by-pair").to_dict()
    moves = [{**each, **({"lift": 70.0} if "lift" in each else {})} for each in feed["motion"]]
    scene = Scene.from_dict({**feed, "motion": moves, "train": [stage]})
    problem, degrees = resolve_design(scene), np.arange(0.0, 360.0)
    alone = resolve_design(Scene.from_dict({"cam": feed["cam"], "motion": moves, "follower": SLIDES}))
    swung = on_crank(alone.programme.motion_at(np.radians(degrees))[0], 160.0, 220.0, -150.0, -110.0)
    assert np.abs(problem.programme.motion_at(np.radians(degrees))[0] - swung).max() < 1e-12
    told, names = export(scene, tmp_path / "pair.csv"), ("profile", "second_profile")
    table = np.genfromtxt(tmp_path / "pair.csv", delimiter=",", names=True)
    turned = np.exp(-1j * problem.design.sense * np.radians(degrees))
    for name, centre in zip(names, centres(problem, np.radians(degrees)), strict=True):
        seen = shapely.points((centre * turned).real, (centre * turned).imag)
        away = shapely.distance(seen, ring(table[f"{name}_x_mm"] + 1j * table[f"{name}_y_mm"]))
        assert np.abs(away - 16.0).max() <= told.curves[name].deviation_mm + 1e-9
    points = cam_points(scene, degrees[::2])
    lines = [np.column_stack([points[f"{n}_{x}_mm"] for x in "xy"]) for n in names]
    lines[1] += [0.0, 0.003]  # the bore of the second disc is off
    found = inspect_pair([MeasuredProfile(line, "xy") for line in lines], scene)
    far = np.degrees(0.003 / 100.0)  # of an arm, where its pressure angle is 0
    told = found.discs[1]
    assert told.mover == "follower"
    assert far < abs(told.error) < far / np.cos(np.radians(evaluate(scene)["second_pressure_angle_max_deg"]))
    assert np.ptp(found.off) == pytest.approx(2.0 * far, rel=0.06)


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("part", [{**PLATES, **HUB}, PLATES])
def test_an_assembly_has_both_profiles_a_gap_apart_on_one_bore(scene, part, tmp_path):
    """One solid on a hub, or two without: the volume by Green's formula, ends, and sections at both middles."""
    scene = scene.replace(part=part)
    told = export(scene, tmp_path / "pair.step", chord=0.01)
    solids = solids_in(tmp_path / "pair.step")
    assert told.about["solids"] == len(solids) == (1 if "hub_diameter" in part else 2)
    assert all(shapes.has_valid_solids(each) for each in solids)
    profiles_ = [np.append(each, each[0]) for each in profiles(resolve_design(scene), DENSE)]
    hub = np.pi * (part.get("hub_diameter", 0.0) / 2) ** 2 * (40 - 24) if "hub_diameter" in part else 0.0
    through = 40 if "hub_diameter" in part else 24
    volume = sum(shapes.shape_volume(each) for each in solids)
    assert volume == pytest.approx(12 * sum(map(enclosed_area, profiles_)) + hub - through * hole(part), rel=2e-5)
    heights = [height for each in solids for height in extents(each)[2]]
    assert (min(heights), max(heights)) == pytest.approx((0.0, 40.0 if "hub_diameter" in part else 27.0), abs=1e-5)
    for profile, middle in zip(profiles_, (21.0, 6.0), strict=True):
        cut = np.concatenate([points for each in solids for points in section(each, middle)])
        outside = np.abs(cut) > 25.0
        rim = shapely.points(cut[outside].real, cut[outside].imag)
        assert shapely.distance(rim, ring(profile)).max() <= 0.01 + 1e-5
        assert np.diff(np.sort(np.angle(cut[outside]))).max() < 0.3  # all round


@pytest.mark.slow
def test_the_first_disc_alone_has_the_hub_and_both_files_together_are_the_assembly(scene, tmp_path):
    """Each lies where it is in the assembly, closed, and their volumes add up to its."""
    scene, volumes = scene.replace(part={**PLATES, **HUB}), []
    for disc, ends in ((1, (12.0, 40.0)), (2, (0.0, 12.0)), (None, (0.0, 40.0))):
        told = export(scene, tmp_path / "disc.step", disc=disc, chord=0.01)
        (solid,) = solids_in(tmp_path / "disc.step")
        assert shapes.has_valid_solids(solid)
        assert extents(solid)[2] == pytest.approx(ends, abs=1e-5)
        volumes.append(told.about["volume_mm3"])
    assert volumes[0] + volumes[1] == pytest.approx(volumes[2], rel=1e-7)


@pytest.mark.slow
@pytest.mark.one_in(2)
def test_triangles_of_a_pair_are_two_bodies_or_one(scene, tmp_path):
    for part in (PLATES, {**PLATES, **HUB}):
        told = export(scene.replace(part=part), tmp_path / "pair.stl", chord=0.05)
        assert is_watertight(read_triangles(tmp_path / "pair.stl"))
        exact = export(scene.replace(part=part), tmp_path / "pair.step", chord=0.05)
        assert told.about["solids"] == exact.about["solids"] == (1 if part != PLATES else 2)
        assert told.about["volume_mm3"] == pytest.approx(exact.about["volume_mm3"], rel=3e-3)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("disc", [1, 2, None])
def test_a_program_cuts_the_solid_that_lies_as_it_says(disc, tmp_path):
    """The cutter stays its radius away from the solid, which is turned over about Y where it is cut from behind."""
    scene = find_scene("press-feed-by-pair") if disc else find_scene("exhaust-valve")
    hub = {"hub_length": 40, "hub_diameter": 1.9 * scene.cam.base_radius}
    scene = scene.replace(part={"thickness": 12, **hub})
    export(scene, tmp_path / "cam.step")
    told = export(scene, tmp_path / "cam.nc", disc=disc, **NC)
    (solid,), machine = solids_in(tmp_path / "cam.step"), run_iso((tmp_path / "cam.nc").read_text())
    assert ("from behind" in machine.comments[4]) == (disc != 1)
    assert machine.cuts[0].depth == {1: -13.0, 2: -13.0, None: -12.0}[disc]
    assert machine.z == (5.0 + 40.0 - 27.0 if disc == 1 else 5.0)  # over a hub that stands in front
    top = 27.0 if disc == 1 else 0.0
    for point in closed_way(machine, told.curves["cutter"].elements)[::1999]:
        x, z = (point.real, top - 6.0) if disc == 1 else (-point.real, 6.0)
        away = BRepExtrema_DistShapeShape(shapes.make_vertex((x, point.imag, z)), solid).Value()
        assert away == pytest.approx(5.0, abs=0.0025)


def test_a_wheel_that_follows_the_table_of_the_second_disc_touches_its_profile(scene, tmp_path):
    export(scene, tmp_path / "disc.p", disc=2, cutter_radius=8.0, step=0.5)
    angle, _, centre = np.loadtxt(tmp_path / "disc.p").T
    problem = resolve_design(scene)
    wheel = centre * 1j * np.exp(-1j * problem.design.sense * np.radians(angle))
    away = shapely.distance(shapely.points(wheel.real, wheel.imag), ring(profiles(problem, DENSE)[1]))
    assert away == pytest.approx(8.0, abs=2e-5)


@pytest.mark.slow
def test_a_file_of_one_disc_has_the_curves_of_that_disc(tmp_path):
    scene = find_scene("press-feed-by-pair")
    for disc, first in ((1, ""), (2, "second_")):
        for ending in (".csv", ".dxf", ".svg"):
            assert set(export(scene, tmp_path / f"a{ending}", disc=disc).curves) == {
                f"{first}pitch",
                f"{first}profile",
            }
        assert set(cam_points(scene, [0.0], disc=disc)) < set(cam_points(scene, [0.0]))
    with pytest.raises(BadInput, match="disc = 3: must be the number of a disc of the cam"):
        cam_points(scene, [0.0], disc=3)


@pytest.mark.parametrize(
    ("name", "file", "settings", "message"),
    [
        (
            "press-feed-by-pair",
            "a.nc",
            {},
            r"disc: missing: a \.nc file has one disc of a conjugate pair; give 1 or 2",
        ),
        ("press-feed-by-pair", "a.p", {"disc": 3}, "disc = 3: must be 1 or 2"),
        ("press-feed-by-pair", "a.txt", {"disc": 1}, r"disc = 1: has no meaning in a \.txt file"),
        ("pump-of-constant-breadth", "a.nc", {"disc": 1}, "disc = 1: has no meaning for a cam of one disc"),
    ],
)
def test_a_disc_that_cannot_be_is_said(name, file, settings, message, tmp_path):
    with pytest.raises(BadInput, match=message):
        export(find_scene(name), tmp_path / file, **settings)


def test_what_is_below_a_disc_ends_its_program(tmp_path):
    scene = find_scene("press-feed-by-pair").replace(part={"thickness": 12, "hub_diameter": 90, "hub_length": 40})
    with pytest.raises(BadInput, match=r"depth = 15.1: must be at most 15 mm: a deeper cut reaches the other disc"):
        export(scene, tmp_path / "a.nc", disc=1, depth=15.1, **NC)
    export(scene.replace(part={"thickness": 12}), tmp_path / "a.nc", disc=1, depth=15.1, **NC)

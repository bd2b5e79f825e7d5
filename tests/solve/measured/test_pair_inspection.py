"""Measured pairs and yokes: exact points, discs of known errors, and a rigid follower put on them by trial."""

import json
from functools import cache

import numpy as np
import pytest
import shapely
from support.pairs import centres, pair, yoke

import camopt
from camopt import BadInput, MeasuredProfile, Scene, cam_points, find_scene, inspect_pair
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve_design
from camopt.show.sheet.true_cam import TrueCam
from camopt.show.sheet.two_contacts import contact_distance

DEGREES = np.arange(0.0, 360.0, 1.0)
NAMES = ("profile", "second_profile")
YOKES = dict.fromkeys(("breadth", "diameter"), (0.03, 9000.0))
MOUNTED = {"translating": (0.02, 9000.0), "oscillating": (0.02, 5e5), **YOKES}
"""Interference and stiffness."""


@cache
def drawn_pair(kind):
    """A scene with a preload, and the points and normals of its discs in one frame."""
    scene = (yoke if kind in YOKES else pair)(np.random.default_rng(5), kind)
    interference, stiffness = MOUNTED[kind]
    scene["drive"] |= {"interference": interference, "stiffness": stiffness}
    scene["follower"]["dynamics"] = {"inertia": 0.05} if kind == "oscillating" else {"mass": 2.0}
    found = Scene.from_dict(scene)
    points = cam_points(found, DEGREES)
    names = NAMES if found.mechanism.second_contact_size_keys else NAMES[:1]

    def curve(name, unit=""):
        return points[f"{name}_x{unit}"] + 1j * points[f"{name}_y{unit}"]

    return found, [(curve(name, "_mm"), curve(f"{name}_normal")) for name in names]


def read_as(points, form="xy", sense=1.0):
    if form == "xy":
        return MeasuredProfile(np.column_stack([points.real, points.imag]), form)
    angles = np.mod(sense * (90.0 - np.degrees(np.angle(points))), 360.0)
    return MeasuredProfile(np.column_stack([angles, np.abs(points)]), form)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("kind", "form"), [*((kind, "xy") for kind in MOUNTED), ("oscillating", "polar"), ("breadth", "polar")]
)
def test_exact_points_hold_the_contacts_as_far_apart_as_drawn(kind, form):
    """However the pair is turned on its shaft; polar angles as the cam turns."""
    scene, discs = drawn_pair(kind)
    sense, turned = resolve_design(scene).design.sense, np.exp(1j * np.radians(67.0))
    found = inspect_pair([read_as(points * turned, form, sense) for points, _ in discs], scene)
    known = camopt.evaluate(scene.replace(outputs=["all"]))
    assert max(abs(found.least.value), abs(found.most.value)) < 2e-5
    assert found.discs[0].phase_deg == pytest.approx(67.0 * sense, abs=1e-4)
    if kind != "translating":  # the offsets of this pair are not the same
        names = {"oscillating": "subtending_angle_deg", "breadth": "breadth_mm", "diameter": "roller_distance_mm"}
        assert found.drawn == pytest.approx(known[names[kind]])
    assert (found.allowed, found.within) == (None, None)
    name = "N_m" if kind == "oscillating" else "N"
    assert found.preload.min() == pytest.approx(known[f"pair_preload_{name}"], rel=2e-3)
    assert found.needed.max() == pytest.approx(known[f"pair_preload_required_{name}"], rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["press-feed-by-pair", "pump-of-constant-breadth"])
def test_what_is_allowed_is_what_the_sheet_says(name):
    scene, names = find_scene(name), NAMES
    points = cam_points(scene, DEGREES)
    given = [points[f"{each}_x_mm"] + 1j * points[f"{each}_y_mm"] for each in names if f"{each}_x_mm" in points]
    found = inspect_pair(list(map(read_as, given)), scene)
    sheet = contact_distance(TrueCam(scene, resolve_design(scene)))
    assert found.allowed == pytest.approx(sheet.variation, rel=1e-3)
    assert found.within
    assert f"± {found.allowed:.6g} {found.unit}" in found.table().rows[0][1].text
    assert [each.used[0].allowed for each in found.discs] == [scene.part.profile_tolerance] * len(given)


def lift_off_profile(scene, cut, which, theta):
    """How far a roller of the follower goes from where it is drawn until it rests on a dense profile, mm (rad)."""
    problem = resolve_design(scene)
    at = centres(problem, np.array([theta]))[which][0] * np.exp(-1j * problem.design.sense * theta)
    second = problem.setup.mechanism.further_contacts[0].local_designs(problem.design)
    radius = float((problem.design, second)[which].roller_radius[0])
    turn, c = np.exp(-1j * problem.design.sense * theta), float(problem.design.centre_distance[0])
    ring, way = shapely.linearrings(np.column_stack([cut.real, cut.imag])), (1.0, -1.0)[which]

    def gap_to_profile(moved):
        if problem.setup.angular:
            place = (c + (at / turn - c) * np.exp(-1j * way * moved)) * turn
        else:
            place = at + way * 1j * moved * turn
        return shapely.distance(ring, shapely.points(place.real, place.imag)) - radius

    low, high = -0.02, 0.02
    low, high = (each / (c or 1.0) * 2 if problem.setup.angular else each * 5 for each in (low, high))
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if gap_to_profile(middle) > 0.0 else (middle, high)
    return low


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["translating", "oscillating"])
def test_discs_of_known_errors_hold_a_rigid_follower_as_far_apart_as_trial_finds(kind):
    """One disc too large, the other off its axis and turned against it."""
    scene, ((first, normal), (second, _)) = drawn_pair(kind)
    cut = [first + 0.008 * normal, (second + 0.006 - 0.009j) * np.exp(1j * np.radians(0.01))]
    found = inspect_pair([read_as(each) for each in cut], scene, aligned=True)
    unit = np.degrees(1.0) if kind == "oscillating" else 1.0
    for degrees in np.arange(7.0, 360.0, 40.0):
        exact = unit * sum(
            lift_off_profile(scene, each, k, np.radians(degrees)) for k, each in enumerate(dense(kind, cut))
        )
        assert np.interp(degrees, found.angles, found.off, period=360.0) == pytest.approx(exact, abs=unit * 2e-5)
    ends = found.interference + found.off
    assert (found.left.value, found.variation) == (ends.min(), np.ptp(found.off))
    assert found.discs[1].eccentricity == pytest.approx((0.006, -0.009), abs=2e-4)


def dense(kind, cut):
    """Closed lines through points, as fine as splines make them."""
    from scipy.interpolate import CubicSpline

    for points in cut:
        closed = np.append(points, points[0])
        at = np.arange(closed.size)
        yield CubicSpline(at, closed, bc_type="periodic")(np.linspace(0.0, at[-1], 40_001))


@pytest.mark.slow
@pytest.mark.parametrize("kind", YOKES)
def test_the_breadth_of_a_yoke_varies_by_both_sides(kind):
    """Of flat faces a wave of an odd number leaves it as it is; one of an even number counts twice, as size."""
    scene, ((profile, normal),) = drawn_pair(kind)
    angles = np.radians(DEGREES)
    larger = inspect_pair([read_as(profile + 0.01 * normal)], scene)
    if kind == "breadth":
        assert larger.least.value == pytest.approx(0.02, abs=1e-5)
        assert larger.most.value == pytest.approx(0.02, abs=1e-5)
        for number, height in ((5, 0.0), (6, 0.008)):
            waved = inspect_pair([read_as(profile + 0.004 * np.cos(number * angles) * normal)], scene)
            assert (waved.least.value, waved.most.value) == pytest.approx((-height, height), abs=3e-4)
    else:
        assert larger.least.value >= 0.02 - 1e-5  # by 1/cos β


def test_what_is_lost_is_told():
    """A pair whose discs are too small has play; a fast one with little left lets go."""
    scene, discs = drawn_pair("translating")
    small = [read_as(points - 0.015 * normal) for points, normal in discs]
    found = inspect_pair(small, scene)
    assert found.left.value == pytest.approx(0.02 - 0.03, abs=2e-3)
    assert "deg: the preload is lost there" in found.table().note
    nearly = [read_as(points - 0.009 * normal) for points, normal in discs]
    fast = scene.replace(**{"cam.rpm": 1200})
    found = inspect_pair(nearly, fast)
    assert found.left.value > 0.0 > found.spare.value
    assert "At its speed a contact lets go" in found.table().note
    assert [row[0].text for row in found.table().rows] == [
        "distance of the rollers, off by",
        "interference",
        "preload",
    ]


@pytest.mark.slow
def test_one_disc_of_another_drawing_leaves_the_other_as_it_is():
    scene, discs = drawn_pair("oscillating")
    first, second = (points[::4] for points, _ in discs)
    for given, far, said in (
        ((first, -second.conj()), [False, True], "its mirrored points (x to -x) fit"),
        ((second, first), [True, True], "the points of the other disc fit"),
    ):
        found = inspect_pair([read_as(each) for each in given], scene)
        assert [each.far for each in found.discs] == far
        assert [said in each.table().note for each in found.discs] == far
        assert [each.used[0].found < 1e-3 for each in found.discs] != far
        table, known = found.table(), found.records()
        assert table.rows == []
        assert "They are not compared: disc" in table.note
        assert [known[name] for name in ("variation", "left", "preload_least", "within")] == [None] * 4
    apart = inspect_pair([read_as(first), read_as(second * np.exp(0.5j))], scene)
    assert "their points have not one angle 0" in apart.table().note


@pytest.mark.parametrize("aligned", [False, True])
def test_a_disc_that_is_turned_against_the_other_has_no_error_of_its_profile(aligned):
    """It moves its roller by y'·Δ, and so much is the subtending angle off if the pair is aligned."""
    scene, discs = drawn_pair("oscillating")
    first, second = (points[::2] for points, _ in discs)
    problem, turned = resolve_design(scene), 0.01
    cut = second * np.exp(1j * problem.design.sense * np.radians(turned))
    found = inspect_pair([read_as(first), read_as(cut)], scene, aligned=aligned)
    slopes = problem.programme.motion_at(np.radians(DEGREES))[1]
    assert found.turned == pytest.approx(turned, abs=1e-5)
    assert max(each.used[0].found for each in found.discs) < 1e-4
    assert [each.waves for each in found.discs] == [(), ()]
    assert found.variation == pytest.approx(turned * np.ptp(slopes), rel=2e-3)
    assert "Disc 2 is turned by 0.01 deg against disc 1, ahead of it: what the keyway" in found.table().note


@pytest.mark.slow
def test_files_of_both_discs_are_read_by_the_command(capsys, tmp_path):
    scene = find_scene("press-feed-by-pair")
    points = cam_points(scene, np.arange(0.0, 360.0, 2.0))
    for name in NAMES:
        rows = np.column_stack([points[f"{name}_x_mm"], points[f"{name}_y_mm"]])
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",", header="x,y", comments="")
    given = [word for name in NAMES for word in ("--measured", str(tmp_path / f"{name}.csv"))]
    assert main(["tolerance", "press-feed-by-pair", *given, "--profile", "xy", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["pair"]["variation"] < 1e-3
    assert [each["noise"] < 1e-4 for each in found["discs"]] == [True, True]
    assert main(["tolerance", "press-feed-by-pair", *given, "--profile", "xy"]) == 0
    assert "none lets go" in capsys.readouterr().out
    assert main(["tolerance", "bucket-valve", *given, "--profile", "xy"]) == 2
    assert "has one contact with the cam" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "count", "message"),
    [
        (
            "press-feed-by-pair",
            1,
            "measured = 1: must be 2: a file, or an array, of points for each disc of the cam",
        ),
        ("pump-of-constant-breadth", 2, "measured = 2: must be 1: a file"),
        ("exhaust-valve", 1, "follower: has one contact with the cam"),
        ("bottle-filler-by-rib", 2, "follower: has a rib between its rollers: measured ribs are not compared yet"),
    ],
)
def test_points_of_other_discs_than_the_cam_has_are_refused(name, count, message):
    circle = read_as(30.0 * np.exp(1j * np.radians(DEGREES)))
    with pytest.raises(BadInput, match=message):
        inspect_pair([circle] * count, find_scene(name))

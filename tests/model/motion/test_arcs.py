"""Cams given by arcs and lines: the motion of each follower, the profile that it has, and bad ones."""

import re
from math import cos, hypot, inf, pi, radians, sin, sqrt, tan

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support import lowered
from support.balls.ball import Ball, precisely
from support.balls.laws import stretches_of
from support.depth import times

from camopt import (
    BadInput,
    Scene,
    certify,
    evaluate,
    evaluate_designs,
    find_scene,
    fit,
    optimise,
    sweep,
    synthesise,
)
from camopt.model.mechanisms.geometry import cam_curves
from camopt.model.motion.profile import ElementSpec, least_distance_from_axis, place_profile_elements
from camopt.model.motion.profile_law import ProfileLaw
from camopt.scene.problem.problem import resolve_design

FOLLOWERS = {
    "knife": {"motion": "translating", "contact": "knife"},
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": 10},
    "offset-roller": {"motion": "translating", "contact": "roller", "roller_radius": 10, "offset": 6},
    "spherical": {"motion": "translating", "contact": "spherical", "face_radius": 20, "offset": -3},
    "arm": {
        "motion": "oscillating",
        "contact": "roller",
        "roller_radius": 10,
        "arm_length": 70,
        "centre_distance": 80,
    },
    "flat": {"motion": "translating", "contact": "flat"},
    "swinging-face": {"motion": "oscillating", "contact": "flat", "centre_distance": 80, "face_offset": 5},
}
FLAT = ("flat", "swinging-face")
BASE = {"element": "arc", "radius": 25, "x": 0, "y": 0}
NOSE = {"element": "arc", "radius": 8, "x": 4, "y": 30}
LINE = {"element": "line"}


def flank(radius):
    return {"element": "arc", "radius": radius}


PROFILES = {
    "tangent": [BASE, LINE, NOSE, LINE],
    "three-arc": [BASE, flank(90), NOSE, flank(70)],
    "eccentric": [{"element": "arc", "radius": 28, "x": -5, "y": 3}],
    "hollow": [BASE, flank(-60), NOSE, LINE],
    "four-arc": [BASE, flank(120), {"element": "arc", "radius": 12, "x": 0, "y": 28}, LINE, NOSE, LINE],
}
PAIRS = [
    (profile, follower)
    for profile in PROFILES
    for follower in FOLLOWERS
    if follower not in FLAT or profile in ("three-arc", "eccentric")
]


def scene_of(profile, follower, rotation="ccw", **more):
    """A scene; the elements of a profile are met the other way round where the cam turns cw."""
    elements = PROFILES[profile] if isinstance(profile, str) else profile
    first, *rest = elements
    return Scene.from_dict(
        {
            "cam": {"form": "disc", "rotation": rotation, "rpm": 300},
            "follower": FOLLOWERS[follower] if isinstance(follower, str) else follower,
            "profile": [first, *(rest if rotation == "ccw" else rest[::-1])],
            **more,
        }
    )


def parts_of_profile(scene):
    """The programme of a scene, the parts of its profile, and the angle by which its coordinates stand turned."""
    sense = 1.0 if scene.cam.rotation == "ccw" else -1.0
    elements = [ElementSpec(e.radius, None if e.x is None else complex(e.x, -sense * e.y)) for e in scene.profile]
    return resolve_design(scene), place_profile_elements(elements), sense


def profile_of(scene, angles):
    """Points of the profile as the package draws them, and the first one's angle in the elements' coordinates."""
    problem, parts, sense = parts_of_profile(scene)
    points = cam_curves(problem.setup.mechanism, problem.design, problem.programme, angles).profile[0]
    seen = np.conj(points) if sense > 0.0 else points
    start = parts[0].start.point
    first = cam_curves(problem.setup.mechanism, problem.design, problem.programme, np.zeros(1)).profile[0][0]
    first = np.conj(first) if sense > 0.0 else first
    return problem, parts, seen * (start / first) / abs(start / first)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize(("profile", "follower"), PAIRS)
def test_the_motion_has_the_profile_that_it_comes_from(profile, follower, rotation):
    scene = scene_of(profile, follower, rotation)
    angles = np.concatenate(
        [s.start + s.angle * np.linspace(0.01, 0.99, 40) for s in parts_of_profile(scene)[0].programme.strokes]
    )
    _, parts, points = profile_of(scene, angles)
    for part, here in zip(parts, points.reshape(len(parts), -1), strict=True):
        if part.radius is None:
            off = ((here - part.start.point) / part.start.normal).real
        else:
            off = np.abs(here - part.centre) - abs(part.radius)
        assert np.abs(off).max() < 1e-12


def profile_angle(scene, curves, programme, theta):
    """The angle of the cam's own coordinates at a cam angle: at 0 the follower comes on the first element."""
    return turned_to_start(scene, curves) + (1 if scene.cam.rotation == "ccw" else -1) * theta


def turned_to_start(scene, curves):
    follower, point, normal = scene.follower, curves[0].point(0), curves[0].normal(0)
    if follower.contact == "flat":
        height = (point * mpmath.conj(normal)).real
        if follower.motion == "translating":
            return mpmath.pi / 2 - mpmath.arg(normal)
        psi = mpmath.asin((height - follower.face_offset) / follower.centre_distance)
        return mpmath.pi / 2 - psi - mpmath.arg(normal)
    trace = point + (follower.roller_radius or follower.face_radius or 0) * normal
    if follower.motion == "translating":
        there = mpmath.mpc(follower.offset, mpmath.sqrt(abs(trace) ** 2 - mpmath.mpf(follower.offset) ** 2))
    else:
        c, l = follower.centre_distance, follower.arm_length  # noqa: E741
        psi = mpmath.acos((c * c + l * l - abs(trace) ** 2) / (2 * c * l))
        there = c - l * mpmath.expj(-psi)
    return mpmath.arg(there / trace)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize(("profile", "follower"), PAIRS)
def test_the_motion_is_that_of_a_follower_lowered_on_the_cam(profile, follower, rotation):
    scene = scene_of(profile, follower, rotation)
    problem, parts, _ = parts_of_profile(scene)
    programme = problem.programme
    with mpmath.workdps(30):
        curves = lowered.curves_of(scene, parts)
        lowest = lowered.position(scene, curves, turned_to_start(scene, curves)) - programme.strokes[0].low
        for stroke in programme.strokes:
            theta = mpmath.mpf(stroke.start + 0.37 * stroke.angle)
            y = lowered.position(scene, curves, profile_angle(scene, curves, programme, theta)) - lowest
            here = programme.motion_at(np.array([float(theta)]))[0, 0]
            assert abs(y - here) < 2e-13 * (100 if scene.follower.motion == "translating" else 1)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize(
    ("profile", "follower"),
    [("tangent", "offset-roller"), ("hollow", "arm"), ("three-arc", "swinging-face"), ("eccentric", "arm")],
)
def test_velocity_acceleration_and_jerk_are_its_derivatives(profile, follower, rotation):
    scene = scene_of(profile, follower, rotation)
    problem, parts, _ = parts_of_profile(scene)
    with mpmath.workdps(40):
        curves = lowered.curves_of(scene, parts)
        for stroke in problem.programme.strokes:
            theta = mpmath.mpf(stroke.start + 0.43 * stroke.angle)
            found = problem.programme.motion_at(np.array([float(theta)]))[:, 0]
            for order in (1, 2, 3):
                exact = mpmath.diff(
                    lambda t: lowered.position(scene, curves, profile_angle(scene, curves, None, t)),
                    theta,
                    order,
                    h=1e-6,
                )
                assert float(exact) == pytest.approx(found[order], rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(("profile", "follower"), PAIRS)
def test_proofs_have_the_same_motion(profile, follower):
    with precisely():
        for stroke in parts_of_profile(scene_of(profile, follower))[0].programme.strokes:
            if isinstance(stroke.law, ProfileLaw):
                (piece,) = stretches_of(stroke.law)
                verbs = (stroke.law.displacement, stroke.law.velocity, stroke.law.acceleration, stroke.law.jerk)
                for x in (0.0, 0.31, 1.0):
                    for order, verb in enumerate(verbs):
                        exact, size = (
                            float(piece.derivative(order, Ball(x).arb)),
                            np.abs(verb(np.linspace(0, 1, 9))).max(),
                        )
                        assert float(verb(x)) == pytest.approx(exact, rel=1e-11, abs=1e-12 * (100 + size))


# ------------------------------------------------------------------------------------------------- textbooks


def test_a_tangent_cam_is_that_of_the_book():
    """Khurmi & Gupta, Theory of Machines, art. 20.17: straight flank, then nose, of a radial roller follower."""
    scene = find_scene("tangent-cam")
    programme = resolve_design(scene).programme
    _, flank, nose, _ = programme.strokes
    r1, r2, r3, far = 45.0, 20.0, 10.0, 35.0 / cos(radians(45.0))
    for share in (0.01, 0.4, 0.99):
        t = share * flank.angle
        y = programme.motion_at(np.array([flank.start + t]))[:3, 0]
        book = (
            (r1 + r2) * (1 / cos(t) - 1),
            (r1 + r2) * sin(t) / cos(t) ** 2,
            (r1 + r2) * (2 - cos(t) ** 2) / cos(t) ** 3,
        )
        assert y == pytest.approx(book, rel=1e-12, abs=1e-12)
    assert tan(flank.angle) == pytest.approx(far * sin(radians(45.0)) / (r1 + r2), rel=1e-13)
    long = r2 + r3
    top = nose.start + nose.angle / 2
    for t in (0.01, 0.1, nose.angle / 2 - 0.01):
        root = sqrt(long**2 - (far * sin(t)) ** 2)
        fallen = long + far - far * cos(t) - root
        speed = far * (sin(t) + far * sin(2 * t) / (2 * root))
        slowing = far * (cos(t) + (long**2 * far * cos(2 * t) + far**3 * sin(t) ** 4) / root**3)
        y = programme.motion_at(np.array([top + t]))[:3, 0]
        assert y == pytest.approx((far + r3 - r1 - fallen, -speed, -slowing), rel=1e-11)
    assert programme.lift == pytest.approx(far + r3 - r1, rel=1e-14)


def test_a_three_arc_cam_under_a_flat_face_is_that_of_the_book():
    """Khurmi & Gupta, Theory of Machines, art. 20.19: circular flank and nose, simple harmonic both."""
    programme = resolve_design(find_scene("three-arc-valve")).programme
    _, flank, nose, _ = programme.strokes
    r1, r2, big, far = 16.0, 6.0, 80.0, 19.0
    for t in (0.01, flank.angle / 2):
        y = programme.motion_at(np.array([flank.start + t]))[:3, 0]
        assert y == pytest.approx(((big - r1) * (1 - cos(t)), (big - r1) * sin(t), (big - r1) * cos(t)), rel=1e-11)
    top = nose.start + nose.angle / 2
    for t in (0.0, 0.3, nose.angle / 2 - 0.01):
        y = programme.motion_at(np.array([top + t]))[:3, 0]
        assert y == pytest.approx((far * cos(t) + r2 - r1, -far * sin(t), -far * cos(t)), rel=1e-12, abs=1e-12)
    alpha = flank.angle + nose.angle / 2  # the triangle of the three centres
    assert (big - r2) ** 2 == pytest.approx((big - r1) ** 2 + far**2 + 2 * (big - r1) * far * cos(alpha), rel=1e-13)


def test_an_eccentric_is_a_crank():
    """Radial roller: a slider-crank of the throw and r + R_r; flat face: a Scotch yoke."""
    m = hypot(5, 3)
    theta = np.linspace(0.0, 6.2, 40)
    slider = resolve_design(scene_of("eccentric", "roller")).programme.motion_at(theta)[0]
    assert slider == pytest.approx(
        -m * np.cos(theta) + np.sqrt(38**2 - (m * np.sin(theta)) ** 2) - 38 + m, abs=1e-12
    )
    yoke = resolve_design(scene_of("eccentric", "flat")).programme.motion_at(theta)[0]
    assert yoke == pytest.approx(m * (1 - np.cos(theta)), abs=1e-12)


# ------------------------------------------------------------------------------------------------ everything


@pytest.mark.one_in(11)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize(("profile", "follower"), PAIRS)
def test_it_is_evaluated_and_proved_like_any_scene(profile, follower, rotation):
    scene = scene_of(profile, follower, rotation, limits={"velocity": 1e3})
    found = evaluate(scene)
    radii = [e.radius for e in scene.profile if e.radius is not None and e.radius > 0]
    assert found["profile_radius_min_mm"] == pytest.approx(min(radii), rel=1e-14)
    assert found["base_radius_mm"] == scene.cam.base_radius
    assert found["status"] == "certified"
    assert set(certify(scene).values()) <= {"held", "broken"}
    jumps = {jump.order for jump in resolve_design(scene).programme.jumps}
    assert jumps == (set() if profile == "eccentric" else {2})


def test_a_hollow_flank_is_seen_by_the_cutter():
    found = evaluate(scene_of("hollow", "roller"))
    assert found["cutter_radius_max_mm"] == pytest.approx(60, rel=1e-14)
    assert found["pitch_curvature_min_per_mm"] == pytest.approx(-1 / 50, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "radius"), [("three-arc-valve", 6), ("tangent-cam", 10), ("eccentric-rocker", 30)]
)
def test_a_limit_that_the_sharpest_arc_just_meets_is_met(name, radius):
    for limit, verdict in ((radius, "held"), (radius * (1 + 1e-15), "broken"), (radius * (1 - 1e-15), "held")):
        scene = find_scene(name).replace(**{"limits.curvature_radius": limit})
        assert certify(scene)["curvature_radius"] == verdict
    assert evaluate(find_scene(name).replace(**{"limits.curvature_radius": radius}))["feasible"]


@pytest.mark.parametrize(("hollow", "verdict"), [(-60, "held"), (-10.5, "held")])
def test_a_hollow_flank_is_not_sharp(hollow, verdict):
    profile = [BASE, flank(hollow), NOSE, LINE]
    scene = scene_of(profile, "roller", limits={"curvature_radius": 5})
    assert certify(scene)["curvature_radius"] == verdict


def test_lines_have_no_curvature():
    found = evaluate(scene_of("tangent", "roller"))
    assert (found["pitch_curvature_min_per_mm"], found["cutter_radius_max_mm"]) == (0.0, inf)


def test_a_scene_with_a_profile_is_written_and_read_again():
    scene = scene_of("three-arc", "roller")
    assert Scene.from_dict(scene.to_dict()) == scene
    assert scene.cam.base_radius == 25.0
    smaller = scene.replace(profile=[{**BASE, "radius": 24}, *PROFILES["three-arc"][1:]])
    assert smaller.cam.base_radius == 24.0
    assert smaller.replace(**{"cam.base_radius": 24 + 1e-9}) == smaller
    assert "a profile of 4" in repr(scene)


def test_a_cw_cam_is_the_mirror_image():
    ccw, cw = (resolve_design(scene_of("three-arc", "roller", rotation)).programme for rotation in ("ccw", "cw"))
    mirrored = [{**e, **({"x": -e["x"]} if "x" in e else {})} for e in PROFILES["three-arc"]]
    first, *rest = mirrored
    same = resolve_design(scene_of([first, *rest[::-1]], "roller", "cw")).programme
    theta = np.linspace(0, 6.28, 50)
    assert not np.allclose(ccw.motion_at(theta)[0], cw.motion_at(theta)[0])
    assert same.motion_at(theta)[0] == pytest.approx(ccw.motion_at(theta)[0], abs=1e-13)


# ------------------------------------------------------------------------------------------------- bad input


def arc(radius, *centre):
    return {"element": "arc", "radius": radius, **dict(zip("xy", centre, strict=False))}


BAD = [
    ([BASE, LINE, arc(8, 0, 10), LINE], "roller", "profile.2: no line touches both neighbours"),
    ([BASE, flank(10), NOSE, LINE], "roller", "profile.2: no arc of this radius touches both neighbours"),
    ([BASE, LINE, LINE, NOSE], "roller", "profile.2: its neighbours, which it touches, must be arcs"),
    ([BASE, arc(60, 10, 10), NOSE, LINE], "roller", "profile.2: does not touch the arc before it, by 20.9 mm"),
    ([BASE, arc(20, 0, 0), NOSE, LINE], "roller", "profile.2: has the centre of the arc before it"),
    ([BASE], "roller", "profile.1: a circle about the cam's axis does not move the follower"),
    ([LINE], "roller", "profile.1: a profile of one element is an arc with its centre"),
    ([arc(20, 30, 0)], "roller", "profile: the axis of the cam (0, 0) is outside the profile"),
    ([BASE, flank(-9), NOSE, LINE], "roller", "profile.2: the follower bridges this hollow flank"),
    ([BASE, LINE, NOSE, LINE], "flat", "profile.2: a flat face jumps over a line"),
    ([BASE, flank(-60), NOSE, flank(90)], "flat", "profile.2: a flat face jumps over a hollow flank"),
    ([arc(20, 15, 0)], {**FOLLOWERS["offset-roller"], "offset": 20}, "profile.1: too steep"),
    ([BASE, LINE, arc(8, 0, 90), LINE], "arm", "too steep: the pressure angle would exceed 89 deg"),
    ([BASE, {"element": "line", "radius": 5}, NOSE, LINE], "roller", "profile.2.radius = 5: a line has none"),
    ([BASE, {"element": "arc"}, NOSE, LINE], "roller", "profile.2.radius: missing; an arc has a radius"),
    ([BASE, arc(90, 3), NOSE, LINE], "roller", "profile.2.y: missing; a centre has x and y"),
    ([BASE, arc(0.0), NOSE, LINE], "roller", "profile.2.radius = 0.0: must be at least 1e-09 from 0"),
    (
        [BASE, {"element": "spline"}, NOSE, LINE],
        "roller",
        "profile.2.element = 'spline': must be one of 'arc' or 'line'",
    ),
    ([BASE, arc("a", 0, 0), NOSE, LINE], "roller", "profile.2.radius = 'a': must be a number"),
    ([], "roller", "profile = []: must be a list of at least one value"),
]


def mistakes_of(scene, **changes):
    """The mistakes of a scene, one by one."""
    with pytest.raises(BadInput) as error:
        scene_of(*scene, **changes)
    return str(error.value).splitlines()


@pytest.mark.parametrize(("profile", "follower", "message"), BAD)
def test_a_bad_profile_is_told_once(profile, follower, message):
    if profile:
        (line,) = mistakes_of((profile, follower))
    else:
        with pytest.raises(BadInput) as error:
            Scene.from_dict({**scene_of("tangent", "roller").to_dict(), "profile": []})
        (line,) = str(error.value).splitlines()
    assert message in line


def test_elements_in_the_wrong_order_are_told():
    nose, other = arc(8, 0, 30), arc(12, 10, 20)
    wrong = [BASE, LINE, other, LINE, nose, LINE]
    (line,) = mistakes_of((wrong, "roller"))
    assert "the elements do not go round the cam exactly once" in line
    right = scene_of([BASE, *wrong[:0:-1]], "roller", "cw")  # a cw cam is met the other way round
    assert [element.x for element in right.profile] == [element.get("x") for element in wrong]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motion": [{"segment": "dwell", "angle": 360}]}, "profile: a scene has either [[motion]] or [[profile]]"),
        (
            {"cam": {"form": "disc", "base_radius": 26}},
            "cam.base_radius = 26.0: the least radius of the profile is 25",
        ),
        ({"cam": {"form": "cylindrical", "mean_radius": 40}}, "cam.form = 'cylindrical': must be 'disc'"),
        ({"search": {"roller_radius": [5, 10]}}, "search.roller_radius: would change the motion"),
        ({"search": {"base_radius": {"start": 20, "stop": 30}}}, "search.base_radius: would change the motion"),
        ({"search": {"law": ["cycloidal"]}}, "search.law: would change the motion"),
        ({"search": {"angle_rise": {"start": 20, "stop": 30}}}, "search.angle_rise: would change the motion"),
    ],
)
def test_what_contradicts_a_profile_is_told_once(changes, message):
    (line,) = mistakes_of(("three-arc", "roller"), **changes)
    assert message in line


def test_a_scene_without_motion_and_profile_is_told():
    data = scene_of("tangent", "roller").to_dict()
    with pytest.raises(BadInput, match=r"motion: missing; a scene has \[\[motion\]\], or the \[\[profile\]\]"):
        Scene.from_dict({key: value for key, value in data.items() if key != "profile"})


@pytest.mark.parametrize("command", [optimise, synthesise])
def test_what_changes_size_or_motion_refuses_a_profile(command):
    with pytest.raises(BadInput, match=r"profile: the .* cannot change, since the scene gives the profile"):
        command(scene_of("tangent", "roller"))


def test_other_sizes_are_refused_and_other_speeds_are_not(tmp_path):
    scene = scene_of("tangent", "roller")
    with pytest.raises(BadInput, match="profile: sizes cannot change, since the scene gives the profile"):
        evaluate_designs(scene, {"roller_radius_mm": [10.0, 12.0]})
    found = evaluate_designs(scene, {"rpm": [300.0, 600.0]})
    fast = evaluate(scene.replace(**{"cam.rpm": 600}))
    assert found["acceleration_max_m_s2"][1] == pytest.approx(fast["acceleration_max_m_s2"], rel=1e-8)
    swept = sweep(scene.replace(**{"search.cam.rpm": [300, 600]}), tmp_path)
    assert swept.feasible == 2
    slowest = swept.best[""]
    assert evaluate(slowest.scene)["acceleration_max_m_s2"] == slowest["acceleration_max_m_s2"]
    assert slowest.scene.profile == scene.profile


def test_measured_points_replace_a_profile():
    lifts = [(angle, 5 * (1 - cos(radians(angle)))) for angle in range(360)]
    fitted = fit(lifts, find_scene("tangent-cam"), band=0.01)
    assert fitted.deviation.held
    assert (fitted.scene.profile, fitted.scene.cam.base_radius) == ((), 45.0)


def test_a_fixed_centre_is_as_good_as_a_found_one():
    _, parts, _ = parts_of_profile(scene_of("three-arc", "roller"))
    centres = [part.centre.conjugate() for part in parts]
    whole = [arc(e["radius"], c.real, c.imag) for e, c in zip(PROFILES["three-arc"], centres, strict=True)]
    theta = np.linspace(0, 6.28, 50)
    found, same = (
        resolve_design(scene_of(p, "roller")).programme.motion_at(theta)[0] for p in ("three-arc", whole)
    )
    assert found == pytest.approx(same, abs=1e-10)


TOLD = [
    r"profile\.[24]: no arc of this radius touches both neighbours",
    r"profile\.[1-4]: a flat face jumps over a hollow flank: only arcs with a radius above 0 move it smoothly",
    r"profile\.[1-4]: too steep: the pressure angle would exceed 89 deg, or the follower does not reach so far",
    r"profile\.[1-4]: the follower bridges this hollow flank: its radius \(.+\) is too large for it",
    "profile: the elements do not go round the cam exactly once",
    r"profile: the axis of the cam \(0, 0\) is outside the profile",
    "profile: the arcs are one circle about the cam's axis to within a millionth: the follower does not move",
    r"motion\.lift: the arm starts at .+ deg and rises by .+: it must stay below 180 deg",
]
"""Why arcs and a follower make no motion, whatever their numbers are."""


@settings(max_examples=times(15, deep=1500))
@given(
    base=st.floats(5, 60),
    nose=st.floats(0.5, 60),
    distance=st.floats(0, 80),
    flanks=st.one_of(
        st.tuples(radius, radius)  # the second kind mostly makes a cam
        for radius in (st.floats(-200, 200).filter(lambda radius: abs(radius) > 1e-3), st.floats(60, 200))
    ),
    follower=st.sampled_from(sorted(FOLLOWERS)),
)
def test_any_numbers_make_a_motion_or_a_message(base, nose, distance, flanks, follower):
    elements = [arc(base, 0, 0), flank(flanks[0]), arc(nose, 0, distance), flank(flanks[1])]
    scene, told = None, ""
    try:
        scene = scene_of(elements, follower)
    except BadInput as error:
        told = str(error)
    assert not told or any(re.fullmatch(f"scene: {line}", told) for line in TOLD)
    assume(scene)
    programme = resolve_design(scene).programme
    motion = programme.motion_at(np.linspace(0, 2 * pi, 100))
    assert np.isfinite(motion).all()
    assert motion[0].min() > -1e-9 * base
    assert {jump.order for jump in programme.jumps} <= {2}
    assert least_distance_from_axis(parts_of_profile(scene)[1]) == scene.cam.base_radius


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", range(12))
def test_a_cam_at_random_has_one_verdict_from_doubles_and_from_balls(seed):
    """With the least radius of its nose as limit, which it just meets."""
    rng = np.random.default_rng(seed)
    base, follower = rng.uniform(15, 40), rng.choice(["roller", "offset-roller", "arm", "spherical", "knife"])
    nose, distance = rng.uniform(2, 10), rng.uniform(1.0, 1.4) * base
    flanks = [flank(float(rng.choice([1, -1]) * rng.uniform(100, 300))) for _ in range(2)]
    scene = scene_of(
        [arc(base, 0, 0), flanks[0], arc(nose, rng.uniform(-3, 3), distance), flanks[1]],
        str(follower),
        str(rng.choice(["ccw", "cw"])),
        limits={"curvature_radius": nose, "pressure_angle": 60},
    )
    found, verdicts = evaluate(scene), certify(scene)
    assert found["relative_half_width"] < 1e-9
    assert found["feasible"] == (set(verdicts.values()) == {"held"})
    assert verdicts["curvature_radius"] == "held"

"""Tolerances of ribs, against rollers of a rigid follower set on flanks with errors, and closed forms."""

from functools import cache

import numpy as np
import pytest
import shapely
from support.real_cams import PairCams
from support.ribs import centres, flanks, rib

import camopt
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX, errors_at_contacts_by_key
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.plays_and_interference import list_plays
from camopt.solve.tolerances.response import PairResponse
from camopt.solve.tolerances.turn_errors import TurnErrors

MOTIONS = ("translating", "oscillating")
TURN = np.linspace(-0.6, 2.0 * np.pi + 0.6, 40_001)
ANGLES = np.radians([31.0, 77.0, 204.0])
WAY = "bore_eccentricity_way"
CASES = {
    "spacing": {"follower.roller_spacing": 0.05},
    "arm": {"follower.arm_length": -0.04},
    "rollers": {"follower.roller_radius": 0.02, f"follower.roller_radius{SECOND_CONTACT_SUFFIX}": -0.01},
    "flank": {f"profile{SECOND_CONTACT_SUFFIX}": 0.03},
    "bore": {"bore_eccentricity": 0.05, WAY: 0.8},
    "phase": {"phase": 1e-3},
    "all": {
        "follower.roller_spacing": 0.02,
        "follower.roller_radius": -0.02,
        "profile": 0.02,
        f"profile{SECOND_CONTACT_SUFFIX}": -0.01,
        "bore_eccentricity": 0.03,
        WAY: 2.5,
        "phase": -5e-4,
    },
}


@cache
def problem_of(motion):
    return resolve_design(Scene.from_dict(rib(np.random.default_rng(7), motion)))


@cache
def cut(motion):
    """Points of both flanks of the nominal cam over the developed mantle, and normals to the rollers."""
    problem = problem_of(motion)
    design, within = problem.design, np.mod(TURN, 2.0 * np.pi)
    found = []
    for points, centre in zip(flanks(problem, TURN), centres(problem, within), strict=True):
        centre = centre + (TURN - within) * design.size[0]
        found.append((points, (centre - points) / design.roller_radius[0]))
    return found


def stands(motion, errors, place, theta):
    """The displacement of a follower whose roller touches its flank, by trial."""
    problem = problem_of(motion)
    design, lift, key = problem.design, problem.programme.lift, SECOND_CONTACT_SUFFIX if place else ""
    points, normal = cut(motion)[place]
    ahead, side = errors.get("phase", 0.0), -1.0 if place else 1.0
    bore = errors.get("bore_eccentricity", 0.0) * np.cos(errors.get(WAY, 0.0) + design.sense * (theta + ahead))
    near = np.abs(TURN - theta) < 0.5
    line = shapely.LineString(
        [(p.real, p.imag) for p in (points + errors.get(f"profile{key}", 0.0) * normal + bore)[near]]
    )
    radius = design.roller_radius[0] + errors.get(f"follower.roller_radius{key}", 0.0)
    d = design.roller_spacing[0] + errors.get("follower.roller_spacing", 0.0)

    def room(y):
        centre = (theta + ahead) * design.size[0] + 1j * (y + side * d / 2.0)
        if problem.setup.angular:
            l = design.arm_length[0] + errors.get("follower.arm_length", 0.0)  # noqa: E741
            pivot = (theta + ahead) * design.size[0]
            pivot = pivot + design.sense * design.arm_length[0] * np.cos(lift / 2)
            a = y - lift / 2 + side * np.arcsin(d / (2 * l))
            centre = pivot - design.sense * l * np.cos(a) + 1j * l * np.sin(a)
        return line.distance(shapely.Point(centre.real, centre.imag)) - radius

    y = float(problem.programme.motion_at(np.array([theta]))[0][0])
    size = 0.2 / (design.arm_length[0] if problem.setup.angular else 1.0)
    low, high = y - size, y + size
    short = room(low)
    assert short * room(high) < 0.0
    for _ in range(28):
        at = 0.5 * (low + high)
        low, high = (at, high) if room(at) * short > 0.0 else (low, at)
    return 0.5 * (low + high)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_both_contacts_are_where_rollers_rest_on_flanks_with_errors(motion, case):
    errors, problem = CASES[case], problem_of(motion)
    if case == "arm" and motion == "translating":
        errors = {"profile": -0.03}
    off, apart = PairCams(problem).at(errors, ANGLES)
    size = problem.design.arm_length[0] if problem.setup.angular else 1.0
    for place, theta in enumerate(ANGLES):
        y = float(problem.programme.motion_at(ANGLES)[0][place])
        first, second = stands(motion, errors, 0, theta) - y, y - stands(motion, errors, 1, theta)
        assert off[place] * size == pytest.approx((first - second) / 2 * size, abs=2e-6)
        assert apart[place] * size == pytest.approx((first + second) * size, abs=2e-6)


@pytest.mark.parametrize("motion", MOTIONS)
def test_first_order_is_the_slope_of_what_both_rollers_do_exactly(motion):
    problem, step = problem_of(motion), 1e-5
    answers = PairResponse(problem, ANGLES)
    arm = ("follower.arm_length",) if problem.setup.angular else ()
    for tolerance in ("follower.roller_spacing", "follower.roller_radius", "profile", "phase", *arm):
        for key in errors_at_contacts_by_key(problem.setup.mechanism, tolerance):
            off, apart = (np.array(each) / step for each in PairCams(problem).at({key: step}, ANGLES))
            np.testing.assert_allclose(answers.response_rows(key, 0)[0][0], off, rtol=1e-4, atol=1e-6)
            np.testing.assert_allclose(answers.separation_rows(key, 0)[0], apart, rtol=1e-4, atol=1e-5)
    for way, (one, other) in zip((0.0, np.pi / 2), answers.bore_responses_in_two_directions, strict=True):
        off, apart = PairCams(problem).at({"bore_eccentricity": step, WAY: way}, ANGLES)
        np.testing.assert_allclose((one - other)[0] / 2, off / step, atol=1e-5)
        np.testing.assert_allclose((one + other)[0], apart / step, atol=1e-5)


def filler(**given):
    return camopt.find_scene("bottle-filler-by-rib").replace(part={}, limits={}, tolerances=given)


def test_a_rib_of_a_follower_that_translates_has_its_closed_forms():
    """tan β = y'/R: half of what both flanks are off by, over cos β; their sum holds the rollers apart."""
    problem = resolve_design(filler(profile=0.01))
    slope = np.abs(problem.programme.motion_at(np.linspace(0.0, 6.283, 20_001))[1]).max() / 120.0
    secant = np.hypot(1.0, slope)
    found = camopt.tolerance(filler(profile=0.01, bore_eccentricity=0.02, **{"follower.roller_spacing": 0.003}))
    shares = found.errors[0].shares
    assert found.errors[0].worst == pytest.approx(0.01 * secant + 0.02 * slope, rel=1e-6)
    assert (shares["profile"], shares[f"profile{SECOND_CONTACT_SUFFIX}"]) == pytest.approx((0.005 * secant,) * 2)
    assert shares["follower.roller_spacing"] == pytest.approx(0.0, abs=1e-12)
    spacing, interference, preload, _ = found.plays
    assert spacing[2:] == pytest.approx((60.0, 60.0 - 0.02 * secant - 0.003, 60.0 + 0.02 * secant + 0.003))
    assert interference.most == pytest.approx(0.04 + 0.02 * secant + 0.003)
    assert preload.most == pytest.approx(15_000 * interference.most)
    worst = found.worst_case
    assert worst.bound >= abs(worst.error) == pytest.approx(found.errors[0].worst, rel=1e-3)
    # with a clearance in place of the interference, which no preload takes up
    drive = {"kind": "rib", "clearance": 0.04, "interference": None, "stiffness": None}
    off = {"drive.clearance": 0.01, "follower.roller_spacing": 0.003}
    loose = filler().replace(drive=drive, tolerances=off)  # whose tool hardly moves: its worst case takes long
    _, backlash = list_plays(TurnErrors(loose, resolve_design(loose)))
    assert (backlash.what, backlash.unit) == ("backlash of the tool", "mm")
    assert backlash[2:] == pytest.approx((0.04 * secant, 0.03 - 0.003, 0.05 * secant + 0.003), rel=1e-6)


@pytest.mark.long
def test_a_batch_of_ribs_has_the_variances_of_first_order_and_none_is_beyond_the_bound():
    given = {"follower.roller_radius": "h6", "profile": 0.01, "bore_eccentricity": 0.02, "phase": 0.005}
    found = camopt.tolerance(scene := filler(**given))
    batch, error = camopt.sample_cams(scene, cams=2**10), found.errors[0]
    for key, share in error.variances.items():
        assert batch.errors[0].variances[key] == pytest.approx(share, abs=0.06)
    assert batch.errors[0].worst < found.worst_case.bound
    assert batch.errors[0].of_99_73 == pytest.approx(error.three_sigma, rel=0.15)


EVERY = {
    "follower.roller_spacing": 0.02,
    "follower.roller_radius": -0.02,
    f"follower.roller_radius{SECOND_CONTACT_SUFFIX}": 0.01,
    "profile": 0.02,
    f"profile{SECOND_CONTACT_SUFFIX}": -0.01,
    "bore_eccentricity": 0.03,
    WAY: 2.5,
    "phase": -5e-4,
}


@pytest.mark.parametrize(
    ("motion", "more"),
    [
        ("translating", {"follower.offset": 0.03}),
        ("oscillating", {"follower.arm_length": -0.04, "follower.centre_distance": 0.02}),
    ],
)
def test_both_contacts_of_a_rib_on_a_disc_are_where_rollers_rest(motion, more):
    """In the frame of the cam, whose flanks are off; the arm turns, or the stem slides, until a roller touches."""
    problem = resolve_design(Scene.from_dict(rib(np.random.default_rng(7), motion, "disc")))
    errors = EVERY | more
    design, turn = problem.design, np.linspace(0.0, 2.0 * np.pi, 20_001)[:-1]
    sizes = {name: float(each[0]) for name, each in design.sizes.items()}
    off = {name: each + errors.get(f"follower.{name}", 0.0) for name, each in sizes.items()}
    prime, c, l = sizes["size"] + sizes["roller_radius"], sizes["centre_distance"], sizes["arm_length"]  # noqa: E741
    bore = errors["bore_eccentricity"] * np.exp(1j * errors[WAY])

    def centre(place, y, theta):
        if motion == "translating":
            apart = off["roller_spacing"] if place else 0.0
            at = off["offset"] + 1j * (np.sqrt(prime**2 - sizes["offset"] ** 2) + y - apart)
        else:
            apart = 2.0 * np.arcsin(off["roller_spacing"] / 2.0 / off["arm_length"]) if place else 0.0
            psi = np.arccos((c**2 + l**2 - prime**2) / (2.0 * c * l)) + y - apart
            at = off["centre_distance"] - off["arm_length"] * np.exp(-1j * psi)
        return at * np.exp(-1j * design.sense * (theta + errors["phase"])) - bore

    found = []
    for place, (points, nominal) in enumerate(zip(flanks(problem, turn), centres(problem, turn), strict=True)):
        key = SECOND_CONTACT_SUFFIX if place else ""
        cut = points + errors[f"profile{key}"] * (nominal - points) / sizes["roller_radius"]
        ring = shapely.LinearRing(np.column_stack([cut.real, cut.imag]))
        radius = sizes["roller_radius"] + errors[f"follower.roller_radius{key}"]
        moved = []
        for theta in ANGLES:
            y = float(problem.programme.motion_at(np.array([theta]))[0][0])
            low, high = (y + side * 0.3 / (l or 1.0) for side in (-1.0, 1.0))
            for _ in range(26):
                middle = 0.5 * (low + high)
                at = centre(place, middle, theta)
                beyond = ring.distance(shapely.Point(at.real, at.imag)) > radius
                low, high = (low, middle) if beyond == (place == 0) else (middle, high)
            moved.append(low - y)
        found.append(np.array(moved))
    stood, apart = PairCams(problem).at(errors, ANGLES)
    size = l or 1.0
    np.testing.assert_allclose(stood * size, (found[0] + found[1]) / 2.0 * size, atol=3e-6)
    np.testing.assert_allclose(apart * size, (found[0] - found[1]) * size, atol=3e-6)

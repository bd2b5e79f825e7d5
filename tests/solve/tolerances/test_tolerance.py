"""Errors of the motion by tolerances: worst cases, root sum squares, impulses, dwells and errors through trains."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from support.cams import cam_with
from support.real_cams import RealCams

import camopt
from camopt.core.mistakes import BadInput
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion.tool_drive import tool_position
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.response import ToolResponse
from camopt.solve.tolerances.turn_errors import TurnErrors, root_sum_square_range, worst_case_range
from camopt.solve.tolerances.worst_case import make_worst_cam_search

GIVEN = {
    "follower.roller_radius": "h6",
    "follower.offset": {"plus": 0.03, "minus": 0.01},
    "profile": 0.02,
    "waves": 20,
    "bore_eccentricity": 0.015,
    "phase": 0.04,
}


def scene_of(contact="offset-roller", law="poly345", given=GIVEN, **more):
    found = cam_with(contact, law, dynamics={}, **more)
    found = {key: found[key] for key in ("cam", "follower", "motion", *more) if key in found}
    return Scene.from_dict({**found, "tolerances": given})


def turn_errors(scene):
    return TurnErrors(scene, resolve_design(scene))


@pytest.mark.slow
@pytest.mark.one_in(12)
@pytest.mark.parametrize("order", range(3))
@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "groove-arm"])
def test_the_largest_is_that_of_a_dense_scan(contact, order):
    own = {"offset-roller": GIVEN, "arm": {"follower.arm_length": 0.03, "follower.centre_distance": "js9"}}
    given = own.get(contact, {"profile": 0.02, "waves": 9, "phase": 0.03})
    turn = turn_errors(scene_of(contact, given=given))
    angles = np.linspace(0.0, 2 * np.pi, 200_001)[:-1]
    for total in (worst_case_range, root_sum_square_range):
        found, scanned = (
            total(turn.contributions_at(np.array([turn.angle_of_largest_total(total, order)])), order).magnitude[0],
            total(turn.contributions_at(angles), order).magnitude,
        )
        assert found >= scanned.max() * (1.0 - 1e-12)
        assert found == pytest.approx(scanned.max(), rel=1e-4)  # which has no side of a jump


def test_no_errors_within_their_zones_are_worse_than_the_worst_case_and_a_corner_is_as_bad():
    """Sums of answers to 500 random sets of errors, and to the set that is worst at each angle."""
    scene, rng = scene_of(given={**GIVEN, "profile": None, "waves": None}), np.random.default_rng(5)
    turn = turn_errors(scene)
    angles = np.linspace(0.01, 6.2, 40)
    answers, found = ToolResponse(turn.problem, angles), turn.contributions_at(angles)
    lengths = [
        answers.number_response("follower.roller_radius"),
        answers.number_response("follower.offset"),
        answers.number_response("phase"),
        *answers.bore_responses_in_two_directions,
    ]
    low = np.array([-0.013 / 2, -0.01, -np.radians(0.04)])  # h6 of a diameter of 28 mm
    high = np.array([0.0, 0.03, np.radians(0.04)])
    for order in range(3):
        terms = np.array([each[order] for each in lengths])
        for _ in range(500):
            way, distance = rng.uniform(0, 2 * np.pi), 0.015 * rng.uniform() ** 0.1
            errors = [*rng.uniform(low, high), distance * np.cos(way), distance * np.sin(way)]
            assert (np.abs(errors @ terms) <= worst_case_range(found, order).magnitude * (1 + 1e-12)).all()
        ends = np.maximum(low[:, None] * terms[:3], high[:, None] * terms[:3])
        below = np.maximum(-low[:, None] * terms[:3], -high[:, None] * terms[:3])
        corner = np.maximum(ends.sum(axis=0), below.sum(axis=0)) + 0.015 * np.hypot(*terms[3:])
        np.testing.assert_allclose(worst_case_range(found, order).magnitude, corner, rtol=1e-12)


def test_no_profile_within_its_zone_and_waves_is_worse_and_a_cosine_is_as_bad():
    """Random trigonometric polynomials within the zone, and cosines of as many waves as are allowed."""
    zone, n, rng = 0.02, 12, np.random.default_rng(8)
    turn = turn_errors(scene_of(given={"profile": zone, "waves": n}))
    angles = np.linspace(0.0, 6.28, 90)
    answer, found = ToolResponse(turn.problem, angles).profile_response, turn.contributions_at(angles)
    orders, dense = np.arange(n + 1), np.linspace(0, 2 * np.pi, 4001)

    def motion(waves):
        """The displacement and its slopes for complex amplitudes of waves."""
        d0, d1, d2 = ((waves * (1j * orders) ** k @ np.exp(1j * np.outer(orders, angles))).real for k in range(3))
        g0, g1, g2 = answer
        return g0 * d0, g1 * d0 + g0 * d1, g2 * d0 + 2 * g1 * d1 + g0 * d2

    for _ in range(300):
        waves = (rng.normal(size=n + 1) + 1j * rng.normal(size=n + 1)) * rng.choice([0.0, 1.0], n + 1)
        most = np.abs((waves @ np.exp(1j * np.outer(orders, dense))).real).max() * 1.0001 + 1e-9
        for order, value in enumerate(motion(zone / most * waves)):
            assert (np.abs(value) <= worst_case_range(found, order).magnitude).all()
    turned = [motion(zone * np.eye(n + 1)[n] * np.exp(1j * phase)) for phase in np.linspace(0, 2 * np.pi, 721)]
    reached = [np.max([np.abs(each[order]) for each in turned], axis=0) for order in range(3)]
    for order in range(2):
        np.testing.assert_allclose(worst_case_range(found, order).magnitude, reached[order], rtol=1e-4)
    assert (worst_case_range(found, 2).magnitude <= 1.1 * reached[2]).all()


def test_a_band_is_that_of_random_cams():
    """Its half is three standard deviations of 40,000 cams with errors spread as their tolerances say.

    No cam is beyond the worst case, and the band is not either.
    """
    spread = {"plus": 0.02, "minus": 0.02}
    given = {
        "follower.roller_radius": {**spread, "cpk": 1.2},
        "follower.arm_length": {**spread, "distribution": "uniform"},
        "follower.centre_distance": {**spread, "distribution": "triangular"},
    }
    turn, rng, count = turn_errors(scene_of("arm", given=given)), np.random.default_rng(2), 40_000
    angles = np.linspace(0.1, 6.0, 12)
    answers = ToolResponse(turn.problem, angles)
    drawn = {
        "follower.roller_radius": rng.normal(0, 0.02 / 3.6, count),
        "follower.arm_length": rng.uniform(-0.02, 0.02, count),
        "follower.centre_distance": rng.triangular(-0.02, 0, 0.02, count),
    }
    for order in range(3):
        errors = sum(np.outer(values, answers.number_response(key)[order]) for key, values in drawn.items())
        found = turn.contributions_at(angles)
        deviation = np.sqrt(sum(each.deviation[order] ** 2 for each in found))
        np.testing.assert_allclose(errors.std(axis=0), deviation, rtol=0.02)
        np.testing.assert_allclose(
            root_sum_square_range(found, order).magnitude,
            np.minimum(3 * deviation, worst_case_range(found, order).magnitude),
            rtol=1e-12,
        )


TRAINS = {
    "roller": {"stage": "rocker", "input_arm": 40, "input_angle": -10, "output_arm": 55, "output_angle": -25},
    "arm": {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70},
}


@pytest.mark.parametrize("contact", TRAINS)
def test_at_the_tool_an_error_is_what_comes_through_the_train(contact):
    """By differences of the tool's motion for a follower that is a little off, and of these by the cam angle."""
    turn = turn_errors(scene_of(contact, given={"phase": 0.01}, train=[TRAINS[contact]]))
    problem, train = turn.problem, turn.problem.setup.train
    step = off = 1e-5
    angles = 0.7 + step * np.arange(-2, 3)
    tool, own = (
        ToolResponse(each, angles) for each in (problem, replace(problem, setup=replace(problem.setup, train=None)))
    )
    at = train.follower_displacement_at(tool_position(problem.programme, angles))
    moved = [
        train.tool_displacement(Taylor([at + side * off * own.profile_response[0]])).terms[0] for side in (1, -1)
    ]
    answer = (moved[0] - moved[1]) / (2 * off)
    np.testing.assert_allclose(tool.profile_response[0], answer, rtol=1e-8)
    assert tool.profile_response[1, 2] == pytest.approx((answer[3] - answer[1]) / (2 * step), rel=1e-4, abs=1e-5)
    z1 = problem.programme.tool.motion_at(angles)[1]
    np.testing.assert_allclose(tool.number_response("phase")[0], z1, rtol=1e-9)


def test_a_jump_of_the_motion_makes_its_error_infinite_with_a_reason():
    """Where the acceleration jumps an error of the offset has an impulse; a profile under a flat face has none."""
    found = camopt.tolerance(scene_of(law="harmonic", given={"follower.offset": 0.02}))
    assert [np.isinf(each.worst) for each in found.errors] == [False, False, True]
    assert found.errors[2].at_deg == pytest.approx(0.0, abs=1e-9)
    jumps = sorted({round(np.degrees(jump.at), 6) for jump in turn_errors(found.scene).problem.programme.jumps})
    assert f"The acceleration of the motion jumps at {', '.join(f'{at:g}' for at in jumps)} deg" in found.reason
    flat = camopt.tolerance(scene_of("flat", "harmonic", {"profile": 0.02, "waves": 8}))
    assert flat.reason == ""
    assert flat.errors[2].worst == pytest.approx(0.02 * 64 * (420 * 2 * np.pi / 60) ** 2 / 1e3)
    corner = camopt.tolerance(scene_of(law="uniform", given={"follower.offset": 0.02}))
    assert [np.isinf(each.worst) for each in corner.errors] == [False, True, True]


@pytest.mark.parametrize("side", ["plus", "minus"])
def test_an_impulse_is_found_on_whichever_side_a_size_is_off(side):
    found = camopt.tolerance(scene_of(law="harmonic", given={"follower.offset": {side: 0.02}}))
    assert [np.isinf(each.worst) for each in found.errors] == [False, False, True]
    assert found.errors[2].at_deg == pytest.approx(0.0, abs=1e-9)


def test_without_waves_the_slope_of_a_profile_has_no_bound():
    found = camopt.tolerance(scene_of(given={"profile": 0.02, "phase": 0.1}))
    assert [each.at_deg is None for each in found.errors] == [False, True, True]
    alone = camopt.tolerance(scene_of(given={"phase": 0.1}))
    assert found.errors[1].shares == {"profile": np.inf, "phase": pytest.approx(alone.errors[1].worst, rel=1e-4)}
    assert "tolerances.waves" in found.reason


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["offset-roller", "swinging-face", "groove-arm"])
def test_a_dwell_wobbles_as_much_as_the_displacement_changes_in_it(contact):
    """By all pairs of angles of the dwell and all directions of the bore; sizes that are off move it as a whole."""
    turn = turn_errors(scene_of(contact, given={"bore_eccentricity": 0.02, "phase": 0.1}))
    for stroke, dwell in zip(
        turn.problem.programme.strokes[1::2], camopt.tolerance(turn.scene).dwells, strict=True
    ):
        angles = np.linspace(stroke.start + 1e-9, stroke.start + stroke.angle - 1e-9, 200)
        first, second = ToolResponse(turn.problem, angles).bore_responses_in_two_directions
        swings = [0.02 * np.ptp(first[0] * np.cos(w) + second[0] * np.sin(w)) for w in np.linspace(0, np.pi, 361)]
        assert dwell.change == pytest.approx(motion_unit_factor(turn.problem.setup, 0) * max(swings), rel=1e-3)


def test_waves_wobble_in_a_dwell_no_more_than_a_cosine():
    (first, second) = camopt.tolerance(scene_of("flat", given={"profile": 0.02, "waves": 3})).dwells
    assert first.change == pytest.approx(0.04 * np.sin(np.radians(60)))
    assert second.change == pytest.approx(0.04)


def test_shares_add_up_and_scale_with_the_speed():
    slow, fast = (camopt.tolerance(scene_of(rpm=rpm)) for rpm in (420, 840))
    for order, (one, other) in enumerate(zip(slow.errors, fast.errors, strict=True)):
        assert sum(one.shares.values()) == pytest.approx(one.worst)
        assert sum(one.variances.values()) == pytest.approx(1.0)
        assert other.worst == pytest.approx(2**order * one.worst)


def test_a_mirrored_cam_has_the_same_errors():
    one = camopt.tolerance(scene_of(given={**GIVEN, "follower.offset": 0.02}))
    follower = scene_of().follower.model_dump(exclude_none=True)
    mirrored = scene_of(given={**GIVEN, "follower.offset": 0.02}, rotation="cw").replace(
        **{"follower.offset": -follower["offset"]}
    )
    for here, there in zip(one.errors, camopt.tolerance(mirrored).errors, strict=True):
        assert here.worst == pytest.approx(there.worst, rel=1e-9)
        assert here.three_sigma == pytest.approx(there.three_sigma, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"follower.arm_length": 0.1},
            "tolerances.follower.arm_length: a disc cam with a translating roller follower has no",
        ),
        (
            {"follower.roller_radius": "h66"},
            "tolerances.follower.roller_radius = 'h66': must be a tolerance class of ISO 286",
        ),
        ({"follower.roller_radius": -0.1}, "roller_radius = -0.1: must be a number of at least 0"),
        (
            {"follower.offset": {"iso": "h6", "plus": 0.1}},
            "tolerances.follower.offset = 'h6': give a class, or plus and minus",
        ),
        ({"follower.offset": [1]}, "tolerances.follower.offset = [1]: must be a number, a class of ISO 286"),
        ({"phase": "h6"}, "tolerances.phase = 'h6': must be an angle in deg"),
        ({"face_tilt": 0.1}, "tolerances.face_tilt: is for a translating follower with a flat face"),
        ({"waves": 3}, "tolerances.waves = 3: needs tolerances.profile, which is missing"),
        ({"profile": -0.1}, "tolerances.profile = -0.1: must be at least 0"),
        (
            {"roller_radius": 0.1},
            "tolerances.roller_radius = 0.1: not a known key; did you mean tolerances.follower.roller_radius?",
        ),
        ({"follower.roller_radius": 14}, "tolerances.follower.roller_radius = 14.0: must be below follower.roller"),
        ({"follower.roller_radius": {"minus": 99.0}}, "must be below follower.roller_radius (14)"),
        ({"bore_eccentricity": 900.0}, "tolerances.bore_eccentricity = 900.0: must be below cam.base_radius ("),
        ({"phase": {"minus": 181}}, "must be at most 180 deg"),
        (
            {"phase": {"plus": 1, "distribution": "uniform", "cpk": 1.3}},
            "tolerances.phase.cpk = 1.3: only a normal",
        ),
        (
            {"phase": {"plus": 0.1, "values": [-0.2, 0.3]}},
            "values = '-0.2 to 0.3': all 2 are outside plus (0.1)",
        ),
    ],
)
def test_invalid_tolerances_are_refused(given, said):
    with pytest.raises(BadInput) as refused:
        scene_of(given=given)
    assert said in str(refused.value)


def test_a_tolerance_of_0_is_none():
    given = {"follower.offset": 0.02, "phase": 0.01}
    none = {"profile": 0, "waves": 9, "bore_eccentricity": 0, "follower.roller_radius": 0}
    plain, more = (camopt.tolerance(scene_of(given=each)) for each in (given, given | none))
    assert [each.worst for each in more.errors] == [each.worst for each in plain.errors]
    assert more.worst_case.bound == plain.worst_case.bound


def test_a_profile_tolerance_of_the_drawing_that_leaves_no_cam_is_refused():
    pair = camopt.find_scene("press-feed-by-pair")
    for given, said in ((65, "cam.base_radius (62)"), (61, "drive.base_radius (60)")):
        with pytest.raises(BadInput) as refused:
            pair.replace(**{"part.profile_tolerance": given, "drive.base_radius": 60})
        assert f"part.profile_tolerance = {float(given)}: must be below {said}" in str(refused.value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "given", "key", "most"),
    [
        ("roller-1000rpm", {"bore_eccentricity": 40}, "bore_eccentricity", 35.0),
        ("roller-1000rpm", {"follower.offset": 60, "phase": 0.1}, "follower.offset", 35.0),
        ("rocker-valve", {"follower.arm_length": 20}, "follower.arm_length", None),
        ("roller-1000rpm", {"follower.offset": 30, "bore_eccentricity": 30}, "", None),
    ],
)
def test_tolerances_too_large_for_contact_are_refused_with_the_largest_possible(scene, given, key, most):
    """An axis 20 mm off a pitch circle of 55 mm finds it until one is off by the other 35 mm, whichever it is."""
    scene = camopt.find_scene(scene)
    with pytest.raises(BadInput, match=f"tolerances{'.' if key else ''}{key}.*does not touch its cam") as told:
        camopt.tolerance(scene.replace(tolerances=given))
    allowed = str(told.value).rpartition("at most ")[2].removeprefix("about ")
    if key:
        size = float(allowed)
        assert most is None or size == pytest.approx(most, rel=0.01)
        smaller = make_worst_cam_search(turn_errors(scene.replace(tolerances={key: 0.99 * size})))
        assert np.isfinite(smaller.place_and_largest_error(smaller.errors_of_nearly_worst_cam())).all()
    else:
        assert allowed.endswith("% of each")
        assert 0.0 < float(allowed.split()[0]) < 100.0


def test_one_uniform_error_has_no_root_sum_square_beyond_its_worst_case():
    for kind, share in (("uniform", 1.0), ("triangular", 1.0), ("normal", 0.5)):
        given = {"phase": {"plus": 0.1, "minus": 0.1, "distribution": kind, **({"cpk": 2.0} if share < 1 else {})}}
        for each in camopt.tolerance(scene_of(given=given)).errors:
            assert each.three_sigma == pytest.approx(share * each.worst, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spread", "sigma", "furthest"),
    [({"cpk": 0.4}, 0.1 / 1.2, 0.25), ({"values": [-0.05, 0.15, 0.2]}, np.std([-0.05, 0.15, 0.2]), 0.2)],
)
def test_parts_beyond_their_zone_count_in_the_root_sum_square_and_are_reported(spread, sigma, furthest):
    """A flat face is lifted by what its phase is off times the slope: 3σ to either side, as far as parts go."""
    given = {"phase": {"plus": 0.1, "minus": 0.1, **spread, "batch": "lot"}, "follower.offset": {"batch": "lot"}}
    found = camopt.tolerance(scene_of("flat", given=given))
    asked = found.errors[0]
    mean = np.mean(spread.get("values", 0.0))
    assert asked.three_sigma / asked.worst == pytest.approx(min(mean + 3 * sigma, furthest) / 0.1, rel=1e-9)
    said = " ".join(str(found.table()).split())
    assert "beyond the tolerance of phase" in said
    assert "independent errors (except within a batch) with" in said


def test_a_class_needs_the_size_that_it_is_of():
    scene = camopt.find_scene("roller-1000rpm")
    with pytest.raises(BadInput, match=r"needs follower\.roller_radius: the zone of an ISO 286 class depends on"):
        Scene.from_dict(
            scene.to_dict()
            | {
                "follower": {"motion": "translating", "contact": "roller", "offset": 5.0},
                "search": {"roller_radius": [5, 6], "base_radius": [50]},
                "tolerances": {"follower.roller_radius": "h6"},
            }
        )


def test_a_roller_in_a_groove_has_no_tolerance_of_its_radius():
    with pytest.raises(BadInput, match=r"roller_radius: cannot have a tolerance: both walls of the groove"):
        scene_of("groove", given={"follower.roller_radius": "h6"})


def test_the_drawing_takes_the_tolerance_of_the_profile_from_here():
    scene = scene_of(given={"profile": 0.025})
    assert scene.whole_part.profile_tolerance == 0.025
    with pytest.raises(BadInput, match=r"part\.profile_tolerance = 0\.02: tolerances\.profile is given too"):
        scene.replace(**{"part.profile_tolerance": 0.02})


@pytest.mark.slow
def test_the_command_shows_and_draws_motion_errors(command, tmp_path):
    file, picture = tmp_path / "cut.toml", tmp_path / "errors.png"
    file.write_text(scene_of().to_toml())
    code, out, err = command("tolerance", file, "--plot", picture)
    assert (code, "worst case" in out, picture.exists()) == (0, True, True)
    found = json.loads(command("tolerance", file, "--json")[1])
    assert [each["name"] for each in found["errors"]] == ["displacement", "velocity", "acceleration"]
    endless = json.loads(command("tolerance", file, "--json", "--set", "tolerances.waves=")[1])
    assert endless["errors"][1]["worst"] is None
    assert endless["errors"][1]["shares"]["unbounded"] == ["profile"]
    code, out, err = command("tolerance", file, "--set", "tolerances=")
    assert (code, out) == (2, "")
    assert "tolerances: has no tolerance: add one, such as profile = 0.02" in err


def test_the_command_says_why_an_error_is_infinite_and_shows_no_rounding_of_an_angle(command, tmp_path):
    """Under a flat face the profile's error is that of the follower at every angle: the first is told."""
    file = tmp_path / "flat.toml"
    file.write_text(scene_of("flat", given={"profile": 0.01}).to_toml())
    out = command("tolerance", file)[1]
    assert "without tolerances.waves: set it, such as waves = 20." in " ".join(out.split())
    places = [line.split()[-1] for line in out.splitlines() if "at cam angle" in line]
    assert places == ["0", "0"]


def test_real_cams_pass_a_lift_between_the_earliest_and_the_latest_angle():
    """300 cams by exact contact; those at the ends of all errors nearly reach both."""
    scene = scene_of("offset-roller", given={"follower.offset": 0.3, "profile": 0.1, "phase": 0.2})
    (told,) = camopt.timing(scene, [3.0]).passages
    problem, rng = resolve_design(scene), np.random.default_rng(3)
    ends = np.array([[0.3], [0.1], [np.radians(0.2)]])
    cams = np.hstack([rng.uniform(-ends, ends, (3, 292)), ends * np.array([*product((-1, 1), repeat=3)]).T])
    found = []
    places = np.linspace(0.0, 2 * np.pi, 2001)[:-1]
    for cam in cams.T:
        off = {
            key: np.full(places.size, each)
            for key, each in zip(("follower.offset", "profile", "phase"), cam, strict=True)
        }
        moved = RealCams(problem).motion(off, places, 0)
        theta, above = moved.angle.terms[0], moved.tool.terms[0] - 3.0
        out, back = (np.flatnonzero((above[:-1] * side < 0) & (above[1:] * side >= 0))[0] for side in (1, -1))
        found.append(
            [theta[k] - above[k] * (theta[k + 1] - theta[k]) / (above[k + 1] - above[k]) for k in (out, back)]
        )
    low, high = np.degrees(np.min(found, axis=0)), np.degrees(np.max(found, axis=0))
    width = np.array(
        [told.rises_latest_deg - told.rises_earliest_deg, told.falls_latest_deg - told.falls_earliest_deg]
    )
    early, late = (
        np.array([getattr(told, f"{way}_{end}_deg") for way in ("rises", "falls")])
        for end in ("earliest", "latest")
    )
    assert np.all((early - 0.01 * width < low) & (low < early + 0.01 * width))  # the second order is left out
    assert np.all((late - 0.01 * width < high) & (high < late + 0.01 * width))

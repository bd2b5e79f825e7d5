"""Tolerances of followers held from both sides, against rigid bodies set on dense discs, and closed forms."""

import json
from functools import cache

import numpy as np
import pytest
from support.real_cams import PairCams, RealPairs

import camopt
from camopt.core.mistakes import BadInput
from camopt.model.effects.error_response import SECOND_CONTACT_SUFFIX, errors_at_contacts_by_key
from camopt.model.effects.motion import motion_unit_factor
from camopt.scene.problem.problem import resolve_design
from camopt.show.sheet.true_cam import TrueCam
from camopt.show.sheet.two_contacts import contact_distance
from camopt.solve.tolerances.error_samples import sample_errors
from camopt.solve.tolerances.errors import errors_at_contact, flat_from_polar_errors
from camopt.solve.tolerances.margins import LimitsByNumber, ToleranceBox, evaluate_limits
from camopt.solve.tolerances.plays_and_interference import INTERFERENCE_KEY, Interference, list_plays
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.response import PairResponse, separation_range
from camopt.solve.tolerances.turn_errors import TurnErrors, worst_case_range
from camopt.solve.tolerances.worst_case import make_worst_cam_search, tool_motion_error_at_contact_maker
from camopt.solve.verdicts.constraint_boxes import BoxParts
from tests.solve.measured.test_pair_inspection import drawn_pair as pair_drawn
from tests.solve.measured.test_pair_inspection import lift_off_profile

ANGLES = np.radians([25.0, 81.0, 150.0, 222.0, 301.0])
DENSE = np.arange(0.0, 360.0, 0.05)
OFF = {"profile": 0.02, "bore_eccentricity": 0.03, "phase": 0.05, "disc_phase": 0.04}
"""mm, deg"""


@cache
def discs(kind):
    """The discs of a scene, dense: points and normals in the frame of the cam."""
    scene, _ = pair_drawn(kind)
    points = camopt.cam_points(scene, DENSE)
    names = ("profile", "second_profile") if scene.mechanism.second_contact_size_keys else ("profile", "profile")

    def curve(name, unit=""):
        return points[f"{name}_x{unit}"] + 1j * points[f"{name}_y{unit}"]

    return [(curve(name, "_mm"), curve(f"{name}_normal")) for name in names]


def cut(scene, kind, errors):
    """The discs that have errors."""
    sense, found = resolve_design(scene).design.sense, []
    for place, (points, normal) in enumerate(discs(kind)):
        own = points + errors.get(("profile", f"profile{SECOND_CONTACT_SUFFIX}")[place], 0.0) * normal
        own = own + errors.get("bore_eccentricity", 0.0) * np.exp(1j * errors.get("bore_eccentricity_way", 0.0))
        ahead = errors.get("phase", 0.0) + (errors.get("disc_phase", 0.0) if place else 0.0)
        found.append(own * np.exp(1j * sense * ahead))
    return found


WIDE = "--set", "tolerances.profile=0.01", "--set", "part.profile_tolerance=", "--set", "limits="
CASES = {
    "profile": {"profile": 0.02},
    "second profile": {f"profile{SECOND_CONTACT_SUFFIX}": -0.02},
    "bore": {"bore_eccentricity": 0.03, "bore_eccentricity_way": 0.8},
    "phase": {"phase": np.radians(0.05)},
    "disc_phase": {"disc_phase": np.radians(0.04)},
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("kind", ["translating", "oscillating"])
def test_both_contacts_are_where_rigid_followers_rest_on_each_disc(kind, case):
    """By trial against a polygon of 7,200 points, less what that gives of the discs without errors."""
    scene, errors = pair_drawn(kind)[0], CASES[case]
    if case == "second profile":
        errors = {f"profile{SECOND_CONTACT_SUFFIX}": -0.02}
    problem, made, exact = resolve_design(scene), cut(scene, kind, errors), cut(scene, kind, {})
    off, apart = PairCams(problem).at(errors, ANGLES)
    for place, theta in enumerate(ANGLES):
        first, second = (
            lift_off_profile(scene, made[k], k, theta) - lift_off_profile(scene, exact[k], k, theta) for k in (0, 1)
        )
        size = 0.05 if kind == "translating" else 0.05 / 80
        assert off[place] == pytest.approx((first - second) / 2, abs=2e-3 * size)
        assert apart[place] == pytest.approx(first + second, abs=2e-3 * size)


def pair_of(**given):
    return camopt.find_scene("press-feed-by-pair").replace(part={}, tolerances=given)


EVERY = {
    "drive.roller_radius": 0.02,
    "follower.arm_length": 0.02,
    "profile": 0.004,
    "bore_eccentricity": 0.01,
    "disc_phase": 0.02,
    "drive.base_radius": 0.005,
}


@pytest.fixture(scope="module")
def every():
    scene = pair_of(**EVERY).replace(limits={"contact_stress": 1200})
    return scene, camopt.tolerance(scene)


MORE = ("follower.roller_radius", "drive.arm_length", "follower.centre_distance", "phase")


def test_first_order_is_the_slope_of_what_both_contacts_do_exactly():
    problem, step = resolve_design(pair_of(**EVERY)), 1e-5
    answers = PairResponse(problem, ANGLES)
    for tolerance in (key for key in (*EVERY, *MORE) if key not in ("drive.base_radius", "bore_eccentricity")):
        for key in errors_at_contacts_by_key(problem.setup.mechanism, tolerance):
            off, apart = (np.array(each) / step for each in PairCams(problem).at({key: step}, ANGLES))
            np.testing.assert_allclose(answers.response_rows(key, 0)[0][0], off, rtol=1e-4, atol=1e-7)
            np.testing.assert_allclose(answers.separation_rows(key, 0)[0], apart, rtol=1e-4, atol=1e-5)
    for way in (0.0, np.pi / 2):
        errors = {"bore_eccentricity": step, "bore_eccentricity_way": way}
        off, apart = (np.array(each) / step for each in PairCams(problem).at(errors, ANGLES))
        one, other = answers.bore_responses_in_two_directions[0 if way == 0.0 else 1]
        np.testing.assert_allclose((one - other)[0] / 2, off, atol=1e-6)
        np.testing.assert_allclose((one + other)[0], apart, atol=1e-6)


@pytest.mark.slow
def test_the_worst_cam_of_a_pair_is_within_what_is_proved_and_random_ones_too(every):
    scene, found = every
    worst, problem = found.worst_case, resolve_design(scene)
    assert abs(worst.error) <= worst.bound <= (1.0 + 2e-5) * abs(worst.error)
    assert abs(worst.error) == pytest.approx(found.errors[0].worst, rel=2e-3)
    rng, cams, unit = np.random.default_rng(4), 2000, np.degrees(1.0)
    angles = rng.uniform(0.0, 2 * np.pi, cams)
    errors = {"bore_eccentricity_way": rng.uniform(-np.pi, np.pi, cams)}
    for tolerance, size in EVERY.items():
        keys = (
            errors_at_contacts_by_key(problem.setup.mechanism, tolerance)
            if tolerance != "drive.base_radius"
            else ()
        )
        for key in keys:
            zone = np.radians(size) if "phase" in key else size
            errors[key] = rng.choice([0.0 if "bore" in key else -1.0, 1.0], cams) * zone
    off, apart = PairCams(problem).at(errors, angles)
    assert unit * np.abs(off).max() <= worst.bound
    between = separation_range(scene, problem, np.linspace(0.0, 6.28, 2000))
    room = np.radians(0.005 / np.hypot(1, 1))  # of the base radius, which is in it, and of second order
    assert between.low.min() - room <= apart.min()
    assert apart.max() <= between.high.max() + room


JUMPING = [{"segment": each, "angle": 180, "lift": 20, "law": "parabolic"} for each in ("rise", "return")]
PROVED = {
    "pair": ("press-feed-by-pair", EVERY),
    "yoke": ("pump-of-constant-breadth", {"profile": 0.02, "bore_eccentricity": 0.02, "phase": 0.05}),
    "rib": (
        "bottle-filler-by-rib",
        {
            "follower.roller_radius": 0.02,
            "follower.roller_spacing": 0.02,
            "bore_eccentricity": 0.03,
            "profile": 0.01,
        },
    ),
}


@pytest.mark.parametrize("kind", PROVED)
def test_what_is_proved_of_both_contacts_is_their_exact_contact_at_each_place(kind):
    """The formula of the proof on parts without a width, beside contact by iteration at the cam angle."""
    name, given = PROVED[kind]
    scene = camopt.find_scene(name).replace(part={}, limits={}, tolerances=given)
    if kind == "rib":
        scene = scene.replace(motion=JUMPING)
    search = make_worst_cam_search(TurnErrors(scene, resolve_design(scene)))
    problem, rng = search.problem, np.random.default_rng(8)
    panels = np.arange(problem.programme.table.half_width.size)
    errors = {key: rng.uniform(*search.error_ranges[key], panels.size) for key in search.error_ranges}
    u, known = rng.uniform(-0.9, 0.9, panels.size), flat_from_polar_errors(errors)
    rows = np.array([u, *known.values()])

    parts = BoxParts(panels, np.ones(panels.size), rows, rows, np.ones((len(rows), 1)))
    half, middle = (getattr(problem.programme.table, each) for each in ("half_width", "centre"))
    with np.errstate(all="ignore"):
        value = (
            search.bound_search(tool_motion_error_at_contact_maker(search.cam, 0))
            .enclose_quantity_times_side(parts)
            .value
        )
    places = middle + u * half
    own = dict(errors)
    if "bore_eccentricity_way" in own:  # in the ground where the first contact touches, to the frame of the cam
        own["bore_eccentricity_way"] = own["bore_eccentricity_way"] - problem.design.sense * places
    theta = places + rest_of_first(problem, own, places)
    off, _ = PairCams(problem).at(errors if kind == "rib" else own, theta)
    size = np.abs(off).max()
    assert np.all((value.low - 1e-10 * size <= off) & (off <= value.high + 1e-10 * size))
    assert (value.high - value.low).max() < 2e-5 * size


def rest_of_first(problem, errors, places):
    """How much further a cam is turned where the first contact touches a place."""
    own = errors_at_contact(problem, 0, errors)
    if "bore_eccentricity_way" in own:
        own["bore_eccentricity_way"] = own["bore_eccentricity_way"] + problem.design.sense * places
    return (
        RealCam(PairCams(problem).contacts[0]).tool_error_at_contact(flat_from_polar_errors(own), places).angle
        - places
    )


@pytest.mark.parametrize("kind", ["yoke", "rib"])
def test_no_cam_exceeds_what_is_proved_of_both_contacts_and_one_nearly_has_it(kind):
    """Random corners, and the best of them pushed on by trial."""
    name, given = PROVED[kind]
    scene = camopt.find_scene(name).replace(part={}, limits={}, tolerances=given)
    turn = TurnErrors(scene, resolve_design(scene))
    search, rng, cams = make_worst_cam_search(turn), np.random.default_rng(9), 20_000
    bound = search.find_worst_cam().bound / motion_unit_factor(turn.problem.setup, 0)
    way = "bore_eccentricity_way"
    errors = {key: rng.choice(ends, cams) for key, ends in search.error_ranges.items()}
    if way in errors:
        errors[way] = rng.uniform(-np.pi, np.pi, cams)
    places = rng.uniform(0.0, 2.0 * np.pi, cams)
    for step in (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3):
        found = np.abs(search.motion_errors(errors, places))
        assert found.max() <= bound
        best = np.argsort(found)[-50:]
        places = rng.normal(np.repeat(places[best], 40), step)
        errors = {key: np.repeat(each[best], 40) for key, each in errors.items()}
        if way in errors:
            errors[way] = rng.normal(errors[way], step)
    assert found.max() > 0.9999 * bound


@pytest.mark.slow
def test_a_second_roller_has_the_class_of_the_first_where_it_is_as_large():
    scene = pair_of(**{"drive.roller_radius": "h6"}).replace(limits={})
    angle, interference, *_ = camopt.tolerance(scene).plays
    assert interference.most == pytest.approx(0.01)  # h6 goes down alone
    assert angle.least < angle.nominal
    loose = scene.replace(**{"drive.interference": 0.001, "limits.pair_preload_ratio": 1.0})
    with pytest.raises(BadInput, match=r"preload: .* has a clearance of 0\.0.*; .*roller_radius.* get grades"):
        camopt.allocate(loose, 0.1)
    lost = camopt.tolerance(loose)
    assert next(each for each in lost.plays if each.what == "preload").least == 0.0
    assert next(each for each in lost.margins if each.limit == "pair_preload_ratio").worst == 0.0


def test_what_is_left_of_the_preload_is_the_interference_and_its_tolerances(every):
    scene, found = every
    angle, interference, preload, torque = found.plays
    assert (angle.what, interference.what, preload.what) == ("subtending angle", "interference", "preload")
    assert torque[:] == ("torque of the preload", "N·m", 0.0, -np.inf, np.inf)  # of waves without a number
    assert angle.nominal == pytest.approx(camopt.evaluate(scene.replace(outputs=["all"]))["subtending_angle_deg"])
    assert interference.least == pytest.approx(0.01 + angle.least - angle.nominal)
    assert preload.most == pytest.approx(700000 * np.radians(interference.most))
    margin = next(each for each in found.margins if each.limit == "contact_stress")
    assert margin.sizes["drive.interference"] == pytest.approx(interference.most)
    made = found.worst_cam("contact_stress")
    assert camopt.evaluate(made)["contact_stress_max_MPa"] == pytest.approx(margin.worst, rel=1e-9)
    assert margin.worst > margin.nominal * 1.2


@pytest.mark.slow
def test_the_worst_cam_has_an_interference_that_its_own_sizes_give_and_the_gap_is_to_that_of_any(every):
    """Other errors at the ends that hold both contacts furthest apart, by exact contact at each cam angle."""
    scene, found = every
    margin, problem = next(each for each in found.margins if each.limit == "contact_stress"), resolve_design(scene)
    angles, design, arm = TurnErrors(scene, problem).nodes, problem.design, scene.to_dict()["drive"]["arm_length"]
    c = design.centre_distance[0]
    interference = Interference.from_scene(scene, problem, 0.01, None)

    def most_interference(sizes):
        errors = {key: by + np.zeros(angles.size) for key, by in sizes.items() if key != "drive.base_radius"}
        for key, end in (
            ("profile", 0.004),
            (f"profile{SECOND_CONTACT_SUFFIX}", 0.004),
            ("disc_phase", np.radians(0.02)),
        ):
            errors[key] = end * np.sign(PairCams(problem).at({key: end}, angles)[1])
        ways = ({"bore_eccentricity_way": np.full(angles.size, way)} for way in np.linspace(-np.pi, np.pi, 73))
        bores = ({**way, "bore_eccentricity": EVERY["bore_eccentricity"]} for way in ways)
        apart = max(PairCams(problem).at(errors | each, angles)[1].max() for each in bores)
        starts = (
            np.arccos((c**2 + arm**2 - (78.0 + by) ** 2) / (2 * c * arm))
            for by in (0.0, sizes["drive.base_radius"])
        )
        return 0.01 + np.degrees(apart - next(starts) + next(starts))

    sizes = {
        key: margin.sizes[key] - problem.nominal_numbers[key] for key in margin.sizes if key != "drive.interference"
    }
    assert margin.sizes["drive.interference"] == pytest.approx(most_interference(sizes), rel=1e-3)
    others = {key: -by for key, by in sizes.items()}
    least = interference.interference_range({key: np.array([by]) for key, by in others.items()}).high.max()
    assert least == pytest.approx(most_interference(others), rel=1e-3)
    assert least < 0.6 * margin.sizes["drive.interference"]
    assert 1e-4 < margin.gap / margin.worst < 3e-3  # the interference of any cam, with the sizes of any other


SMOOTH = {key: each for key, each in EVERY.items() if key not in ("profile", "drive.base_radius")}


def test_no_preload_turns_the_shaft_more_than_its_energy_changes_and_one_nearly_does():
    """dU/dθ of ½·k·(δ₀ + s)² by differences, with s of exact contact, of cams at the ends of their tolerances."""
    scene = pair_of(**SMOOTH).replace(limits={})
    problem, rng, cams, step = resolve_design(scene), np.random.default_rng(7), 20_000, 1e-4
    *_, told = list_plays(TurnErrors(scene, problem))
    angles = rng.uniform(0.0, 2 * np.pi, cams)
    errors = {"bore_eccentricity_way": rng.uniform(-np.pi, np.pi, cams)}
    for tolerance, size in SMOOTH.items():
        for key in errors_at_contacts_by_key(problem.setup.mechanism, tolerance):
            zone = np.radians(size) if "phase" in key else size
            errors[key] = rng.choice([1.0, 1.0] if "bore" in key else [-1.0, 1.0], cams) * zone
    stored = [
        0.5 * 700000 * np.square(np.radians(0.01) + PairCams(problem).at(errors, angles + side * step)[1])
        for side in (-1.0, 1.0)
    ]
    most = np.abs((stored[1] - stored[0]) / (2.0 * step)).max()
    assert 0.75 * told.most < most <= 1.001 * told.most


def test_waves_of_a_disc_of_constant_breadth_turn_the_shaft_as_bernstein_has_it():
    """Both faces are off by t at most, and as steep as t·n: T = k·(δ₀ + 2t)·2·t·n."""
    yoke = camopt.find_scene("pump-of-constant-breadth").replace(limits={}, part={})
    yoke = yoke.replace(**{"drive.interference": 0.05, "drive.stiffness": 1e5})
    yoke = yoke.replace(tolerances={"profile": 0.01, "waves": 10})
    *_, torque = list_plays(TurnErrors(yoke, resolve_design(yoke)))
    assert torque.most == pytest.approx(1e5 * 0.07 * 0.2 * 1e-3)


@pytest.mark.slow
def test_a_batch_of_pairs_has_the_variances_of_first_order(every):
    scene, found = every
    batch = camopt.sample_cams(scene.replace(limits={}), cams=2**10)
    spread, error = batch.errors[0], found.errors[0]
    for key, share in error.variances.items():
        assert spread.variances[key] == pytest.approx(share, abs=0.06)
    assert spread.worst < error.worst
    assert spread.of_99_73 == pytest.approx(error.three_sigma, rel=0.15)


@pytest.mark.long
def test_cams_of_a_batch_have_the_interference_of_their_own_errors():
    """Of the worst of some: by exact contact at each cam angle; its stress is that of a scene which has it."""
    given = {**SMOOTH, "profile": 0.002, "drive.interference": 0.001}
    scene = pair_of(**given).replace(limits={"contact_stress": 1200})
    problem, cams = resolve_design(scene), 16
    batch, off = (
        camopt.sample_cams(scene, cams),
        sample_errors(scene, problem, cams, 0),
    )
    spread, stresses = batch.spreads[-1], batch.samples["contact_stress_max_MPa"].values
    own = {key: each[stresses.argmax()] for key, each in off.items()}
    bore = own.pop("bore_eccentricity")
    own |= {"bore_eccentricity": abs(bore), "bore_eccentricity_way": np.angle(bore)}
    mounted, angles = 0.01 + own.pop("drive.interference"), TurnErrors(scene, problem).nodes
    errors = {key: np.full(angles.size, each) for key, each in own.items()}
    exact = mounted + np.degrees(PairCams(problem).at(errors, angles)[1].max())
    assert spread.sizes["drive.interference"] == pytest.approx(exact, rel=2e-3)
    made = scene.replace(tolerances={}, **spread.sizes)
    assert camopt.evaluate(made)["contact_stress_max_MPa"] == pytest.approx(spread.worst, rel=1e-9)
    assert spread.worst == stresses.max()
    assert {"profile", "bore_eccentricity", "disc_phase"} < spread.variances.keys()


@pytest.mark.slow
@pytest.mark.parametrize("key", ["profile", "drive.arm_length"])
def test_limits_with_several_interferences_are_those_of_each_alone(key):
    """What reads no interference is found once: of one cam, if all are of the same sizes."""
    scene = pair_of(**{key: 0.01})
    box = ToleranceBox.from_scene(scene, resolve_design(scene))
    limits, cams = [each for each in box.problem.limits if each.shown_quantities], 5
    off = {each.field: np.linspace(-0.01, 0.01, cams) for each in box.variables.values() if each.key == key}
    designs = box.problem.design.take(np.zeros(cams, dtype=int))
    designs = designs.with_values({field: designs.values[field] + by for field, by in off.items()})
    interferences = np.linspace([0.005, 0.02], [0.03, 0.01], cams, axis=1)
    by_number = LimitsByNumber(box.problem, limits, INTERFERENCE_KEY)
    for found, own in zip(by_number.evaluate_limits_by_number(designs, interferences), interferences, strict=True):
        alone = evaluate_limits(box.problem, limits, designs.with_values({INTERFERENCE_KEY: own}))
        np.testing.assert_array_equal(found.values, alone.values)
        np.testing.assert_array_equal(found.excess, alone.excess)
        assert np.unique(found.values[[each.name for each in limits].index("contact_stress")]).size == cams


FOUR_BAR = {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70}


@pytest.mark.slow
def test_a_batch_of_pairs_behind_a_train_has_the_motion_of_the_exact_contact_of_both():
    """Velocity and acceleration by differences of it; links are off too."""
    given = {**SMOOTH, "profile": 0.004, "train.1.coupler": 0.05}
    scene = pair_of().replace(train=[FOUR_BAR], limits={}, tolerances=given)
    problem, places, step = resolve_design(scene), np.array([0.7, 1.9, 3.2, 4.4, 5.8]), 1e-4
    off = sample_errors(scene, problem, places.size, 3)
    cams, search = RealPairs(problem, 0), make_worst_cam_search(TurnErrors(scene, problem))
    angles, bore = cams.motion(off, places, 0).angle.terms[0], off["bore_eccentricity"]

    def exact(theta):
        given = {**off, "bore_eccentricity": np.abs(bore), "bore_eccentricity_way": np.angle(bore)}
        given.pop("train.1.coupler")
        moved, _ = PairCams(problem).at(given, theta)
        return RealCam(problem).tool_error_of_highest_order(off, theta, [moved]).error

    before, at, after = (exact(angles + side * step) for side in (-1, 0, 1))
    np.testing.assert_allclose(cams.motion_errors(off, places, 0), at, rtol=1e-9)
    np.testing.assert_allclose(cams.motion_errors(off, places, 1), (after - before) / (2 * step), rtol=1e-6)
    np.testing.assert_allclose(cams.motion_errors(off, places, 2), (after - 2 * at + before) / step**2, rtol=6e-3)
    (found, *_), most = (
        camopt.sample_cams(scene, cams=4).errors,
        worst_case_range(search.turn.node_contributions, 0).magnitude.max(),
    )
    assert 0.1 * most < np.radians(found.worst) < most


@pytest.mark.slow
def test_a_disc_of_constant_breadth_has_its_closed_forms(command):
    """An axis that is off moves both faces alike; a profile that stands out holds them further apart."""
    yoke = camopt.find_scene("pump-of-constant-breadth").replace(limits={}, part={})
    off = camopt.tolerance(yoke.replace(tolerances={"bore_eccentricity": 0.02}))
    assert off.errors[0].worst == pytest.approx(0.02)
    assert off.plays[0][2:] == pytest.approx((64.0, 64.0, 64.0))
    larger = camopt.tolerance(yoke.replace(tolerances={"cam.base_radius": 0.01}))
    assert (larger.errors[0].worst, *larger.plays[0][3:]) == pytest.approx((0.0, 63.98, 64.02))
    assert larger.plays_table().title.endswith("held from both sides")
    told = json.loads(command("tolerance", "pump-of-constant-breadth", *WIDE, "--json")[1])
    assert (told["errors"][0]["worst"], told["plays"][0]["most"]) == pytest.approx((0.01, 64.02))


@pytest.mark.slow
def test_a_profile_tolerance_that_uses_up_the_preload_is_reported(command, tmp_path):
    """Whichever table it is in; the clearance is what the sheet says that the contacts vary by, less the rest."""
    thin = {"drive.interference": 0.004, "limits": {}}
    scene = camopt.find_scene("press-feed-by-pair").replace(**thin)
    found = camopt.tolerance(scene)
    assert found.plays == camopt.tolerance(scene.with_profile_tolerance_moved).plays
    assert scene.with_profile_tolerance_moved.tolerances.profile == scene.part.profile_tolerance
    sheet = contact_distance(TrueCam(scene, resolve_design(scene)))
    clearance = sheet.variation - 0.004
    assert -found.plays[1].least == pytest.approx(clearance, rel=1e-4)
    assert sheet.largest_clearance == pytest.approx(clearance)
    said = f"the worst has a clearance of {-found.plays[1].least:.6g} deg"
    assert said in found.plays_table().note
    (tmp_path / "thin.toml").write_text(scene.to_toml())
    assert said in command("evaluate", tmp_path / "thin.toml")[2]
    assert "no preload" not in command("evaluate", "press-feed-by-pair")[2]


def test_the_backlash_of_a_groove_is_its_clearance_over_the_pressure_angle():
    scene = camopt.find_scene("face-groove-shutter")
    (play,) = camopt.tolerance(scene.replace(tolerances={"drive.clearance": 0.005}, part={}, limits={})).plays
    steepest = max(camopt.evaluate(scene)[f"pressure_angle_max_{each}_deg"] for each in ("rise", "return"))
    known = np.degrees(0.02 / 75 / np.cos(np.radians(steepest)))
    assert play.nominal == pytest.approx(known, rel=1e-6)
    assert play.most == pytest.approx(1.25 * known, rel=1e-6)
    assert play.what == "backlash of the tool"


@pytest.mark.parametrize(
    ("scene", "given", "said"),
    [
        ("roller-1000rpm", {"disc_phase": 0.1}, "tolerances.disc_phase: is for the two discs of a conjugate pair"),
        ("pump-of-constant-breadth", {"drive.roller_radius": 0.1}, "tolerances.drive.roller_radius: a yoke"),
        ("bottle-filler-by-rib", {"drive.roller_radius": 0.1}, "tolerances.drive.roller_radius: a rib has none"),
        ("press-feed-by-pair", {"drive.offset": 0.1}, "tolerances.drive.offset: a conjugate pair has none"),
        ("roller-1000rpm", {"drive.offset": 0.1}, "tolerances.drive.offset: belongs to a second contact"),
    ],
)
def test_tolerances_that_a_follower_lacks_are_refused(scene, given, said):
    with pytest.raises(BadInput) as refused:
        camopt.find_scene(scene).replace(tolerances=given)
    assert said in str(refused.value)

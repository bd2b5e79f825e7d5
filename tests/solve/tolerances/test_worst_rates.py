"""Proven bounds of the errors of velocity and acceleration, and the cams that nearly reach them."""

import json

import numpy as np
import pytest
from mpmath import mp
from scipy import optimize
from support.cams import CONTACTS
from support.real_cams import RealCams, cams_of
from support.recontact import displacement

import camopt
from camopt.core.numerics.budget import UNLIMITED
from camopt.core.numerics.stretches import motion_ranges_over_stretches
from camopt.model.effects.motion import motion_unit_factor
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, direction_key, is_direction, repeat_cam_errors
from camopt.solve.tolerances.turn_errors import TurnErrors
from camopt.solve.tolerances.worst_case import make_worst_cam_search
from tests.solve.tolerances.test_recontact import slope
from tests.solve.tolerances.test_worst_case import DIGITS, KINDS, scene_with_tolerances

WAVES = 9


def with_waves(contact, law="poly345", **more):
    return scene_with_tolerances(contact, law, **more).replace(**{"tolerances.waves": WAVES})


def search_of(scene, order):
    return make_worst_cam_search(TurnErrors(scene, resolve_design(scene)), order)


def real_off(search, errors, places, turned):
    """Errors (m,) with their ways where a place is touched, in the frame of the cam, for exact re-contact."""
    found, sense = {}, search.problem.design.sense
    turns = places + turned + errors.get("phase", 0.0)
    for key, each in errors.items():
        if key == BORE:
            there = turns if search.problem.setup.mechanism.body.developed else places
            found[key] = each * np.exp(1j * (errors[BORE_DIRECTION] - sense * there))
        elif key.startswith("profile") and not is_direction(key):
            at = [
                search.profile_place(direction_key(key), {k: e[j] for k, e in errors.items()}, p)
                for j, p in enumerate(places)
            ]
            found[key] = each * np.exp(1j * (search.cam.waves * np.array(at) - errors[direction_key(key)]))
        elif not is_direction(key):
            found[key] = each
    return found


def exact(search, errors, places):
    """The errors of a motion by exact re-contact."""
    turned = search.tool_error_at_contact(errors, places).angle - places
    cams = cams_of(search.problem, search.cam.waves)
    return cams.motion_errors(real_off(search, errors, places, turned), places, search.order)


def random_errors(search, rng, count):
    """Half of them at corners."""
    inside = {key: rng.uniform(*ends, count) for key, ends in search.error_ranges.items()}
    outside = {
        key: each if is_direction(key) else rng.choice(search.error_ranges[key], count)
        for key, each in inside.items()
    }
    return {key: np.concatenate([inside[key], outside[key]]) for key in inside}


@pytest.mark.parametrize("contact", [*KINDS, "flat-cw", "arm-cw", "groove-cw"])
def test_errors_of_rates_are_those_of_exact_re_contact(contact):
    """All errors at once; at the tool of a train too."""
    rotation = "cw" if contact.endswith("-cw") else "ccw"
    scene = with_waves(contact.removesuffix("-cw"), rotation=rotation, size=0.03)
    for order in (1, 2):
        search, rng = search_of(scene, order), np.random.default_rng(4)
        errors, places = random_errors(search, rng, 20), rng.uniform(0.1, 6.1, 40)
        found, known = search.tool_error_at_contact(errors, places).error, exact(search, errors, places)
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-10 * np.abs(known).max())


@pytest.mark.slow
@pytest.mark.one_in(24)
@pytest.mark.parametrize("law", ["poly345", "harmonic"])
@pytest.mark.parametrize("contact", KINDS)
@pytest.mark.parametrize("order", [1, 2])
def test_no_cam_exceeds_the_bounds_of_rates_and_the_worst_cam_nearly_has_them(contact, law, order):
    """By 20,000 cams, half of them at corners, and a local search from the worst of them."""
    search, rng = search_of(with_waves(contact, law), order), np.random.default_rng(order)
    found, unit = search.find_worst_cam(), motion_unit_factor(search.problem.setup, order)
    errors, places = random_errors(search, rng, 10_000), rng.uniform(0.0, 2 * np.pi, 20_000)
    sampled = np.abs(exact(search, errors, places)) * unit
    assert sampled.max() <= found.bound
    best, keys = int(sampled.argmax()), [*search.error_ranges]

    def worse(values):
        at = np.array([values[-1]])
        return (
            -abs(search.motion_errors({key: np.array([v]) for key, v in zip(keys, values, strict=False)}, at)[0])
            * unit
        )

    ends = [(-np.inf, np.inf) if is_direction(key) else search.error_ranges[key] for key in keys]
    start = [*(errors[key][best] for key in keys), places[best]]
    climbed = optimize.minimize(
        worse, start, bounds=[*ends, (start[-1] - 0.2, start[-1] + 0.2)], method="Nelder-Mead"
    )
    assert -climbed.fun <= found.bound
    assert abs(found.error) >= -climbed.fun * (1.0 - 1e-6)
    assert found.gap <= 0.12 * found.bound  # 0.001 where the machine is idle


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize("contact", CONTACTS)
def test_the_worst_cams_have_their_rates_by_exact_contact_in_40_digits(contact):
    scene = with_waves(contact)
    tables, setup = scene.to_dict(), resolve_design(scene).setup
    for order in (1, 2):
        found = search_of(scene, order).find_worst_cam()
        known = {key.removeprefix("follower."): each for key, each in found.errors.items() if not is_direction(key)}
        known |= {key: np.radians(known[key]) for key in ("phase", "face_tilt") if key in known}
        with mp.workdps(DIGITS):
            for key, name in ((BORE, "bore"), ("profile", "profile")):
                known[name] = known.pop(key) * mp.expj(np.radians(found.errors[direction_key(key)]))
            known["waves"] = WAVES
            theta = mp.mpf(np.radians(found.at_deg))
            exactly = [slope(lambda at, e=e: displacement(tables, e, at), theta, order) for e in (known, {})]
        assert found.error == pytest.approx(
            float(exactly[0] - exactly[1]) * motion_unit_factor(setup, order), rel=1e-6
        )


def test_a_phase_alone_moves_a_motion_along():
    """y'(θ + δ) − y'(θ); and of an acceleration that jumps the whole jump."""
    scene = scene_with_tolerances("flat", "poly345").replace(tolerances={"phase": 0.1})
    bounds, programme = camopt.tolerance(scene).worst_cases, resolve_design(scene).programme
    theta = np.linspace(0.0, 2 * np.pi, 100_001)
    before, after = (programme.motion_at(np.mod(theta + way, 2 * np.pi)) for way in (0.0, np.radians(0.1)))
    for order in range(3):
        most = np.abs(after[order] - before[order]).max() * motion_unit_factor(resolve_design(scene).setup, order)
        assert abs(bounds[order].error) == pytest.approx(most, rel=1e-3)
        assert most <= bounds[order].bound <= most * 1.012
    jumping = scene_with_tolerances("flat", "parabolic").replace(tolerances={"phase": 0.1})
    found, problem = camopt.tolerance(jumping), resolve_design(jumping)
    largest = max(abs(each.size) for each in problem.programme.jumps) * motion_unit_factor(problem.setup, 2)
    assert abs(found.worst_cases[2].error) == pytest.approx(largest, rel=1e-9)
    assert largest <= found.worst_cases[2].bound <= 1.0012 * largest
    assert "a late or early cam has the whole jump as its error" in found.table().note
    still = camopt.tolerance(jumping.replace(tolerances={"profile": 0.01, "waves": 3}))  # none is late
    assert still.worst_cases[2].bound < 0.01 * largest


@pytest.mark.one_in(6)
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", ["bottle-filler-by-rib", "pump-of-constant-breadth"])
def test_two_contacts_have_bounds_of_rates(name, order):
    """By exact re-contact of random cams at corners."""
    given = {"bore_eccentricity": 0.02, "profile": 0.01, "waves": 7}
    search = search_of(camopt.find_scene(name).replace(part={}, limits={}, tolerances=given), order)
    rng, found, unit = (
        np.random.default_rng(1),
        search.find_worst_cam(),
        motion_unit_factor(search.problem.setup, order),
    )
    errors, places = random_errors(search, rng, 100), rng.uniform(0.1, 6.1, 200)
    known = exact(search, errors, places)
    np.testing.assert_allclose(search.motion_errors(errors, places), known, rtol=0, atol=1e-9 * np.abs(known).max())
    assert np.abs(known).max() * unit <= found.bound
    assert found.gap <= 0.12 * found.bound


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("law", "order", "gap"), [("modified-sine", 2, 0.08), ("harmonic", 1, 0.02), ("harmonic", 2, 0.002)]
)
def test_a_bound_of_a_pair_counts_jumps_with_cams_whose_contacts_have_passed_them(law, order, gap):
    """Of y'', or of y''' alone; random cams next to each jump are within, with errors at their ends or not."""
    feed = camopt.find_scene("press-feed-by-pair")
    motion = [each | {"law": law} if "law" in each else each for each in feed.to_dict()["motion"]]
    tolerances = {
        "drive.roller_radius": 0.02,
        "profile": 0.004,
        "waves": 10,
        "bore_eccentricity": 0.01,
        "disc_phase": 0.02,
    }
    search = search_of(feed.replace(part={}, tolerances=tolerances, motion=motion), order)
    most = abs(search.place_and_largest_error(search.errors_of_nearly_worst_cam())[1])
    assert search.prove_error_bound(most, gap, UNLIMITED).high <= most * (1.0 + gap)
    rng, cams = np.random.default_rng(order), 20_000
    ends = {
        key: rng.uniform(-0.2, 1.2, cams).clip(0.0, 1.0) * (high - low) + low
        for key, (low, high) in search.error_ranges.items()
    }
    jumps = rng.choice([each.at for each in search.jumps], cams)
    places = search.cam.angles_in_turn(jumps + rng.normal(0.0, 2e-4, cams))
    tried = np.abs(search.motion_errors(ends, places)).max()
    assert 0.7 * most < tried < most * (1.0 + gap)


def test_stretches_hold_the_motion_at_their_angles():
    """Stretches of random lengths from random panels, past their ends either way, and on to other pieces."""
    programme, rng = resolve_design(scene_with_tolerances("flat", "parabolic")).programme, np.random.default_rng(7)
    table, size = programme.table, 400
    panel = rng.integers(0, table.half_width.size, size)
    low = rng.uniform(-1.5, 1.5, size) * table.half_width[panel]
    high = low + rng.uniform(size=size) ** 3 * 6.0 * table.half_width[panel]
    found = motion_ranges_over_stretches(table, panel, low, high)
    for share in np.linspace(0.0, 1.0, 11):
        at = np.mod(table.centre[panel] + low + share * (high - low), 2 * np.pi)
        for order, value in enumerate(programme.motion_at(at)):
            room = 1e-12 * np.abs(value).max()
            assert np.all((found.ranges[order].low - room <= value) & (value <= found.ranges[order].high + room))
    jumps = np.array([each.at for each in programme.jumps])
    ends = (table.centre[panel] + each for each in (low, high))
    passed = [np.floor((end[:, None] - jumps) / (2 * np.pi)) for end in ends]
    assert np.all(found.pieces[(passed[0] != passed[1]).any(axis=1)])


def test_why_no_bound_of_a_rate_is_proved_is_said():
    plain = scene_with_tolerances("flat", "poly345").replace(tolerances={"profile": 0.01})
    found = camopt.tolerance(plain)
    assert [np.isinf(each.bound) for each in found.worst_cases] == [False, True, True]
    assert "No bound of the velocity is proved: the slope of the profile's error has no bound" in found.table().note
    corners = camopt.find_scene("uniform-knife-offset").replace(tolerances={"follower.offset": 0.01})
    assert all(np.isinf(each.bound) for each in camopt.tolerance(corners).worst_cases)


@pytest.mark.slow
def test_no_bound_is_proved_of_waves_that_a_flat_face_does_not_follow():
    """Its least radius is 6.815 mm: with 50 waves it is hollow from 6.815/2499 = 0.00273 mm on."""
    for profile, bounded in ((0.0027, True), (0.0028, False)):
        found = camopt.tolerance(
            camopt.find_scene("bucket-valve").replace(tolerances={"profile": profile, "waves": 50})
        )
        assert np.isfinite(found.worst_cases[2].bound) == bounded
        assert ("touches only their crests" in found.table().note) != bounded


def test_the_worst_cams_with_their_reported_errors_have_their_reported_rates():
    """In mm and deg, with the crest of the waves and the bore in the frame of the cam."""
    scene = with_waves("groove-arm", "cycloidal")
    problem, places = resolve_design(scene), np.linspace(0.0, 2 * np.pi, 5_001)[:-1]
    for order, worst in enumerate(camopt.tolerance(scene).worst_cases[1:], start=1):
        off = repeat_cam_errors(worst.errors, places.size)
        known = np.abs(RealCams(problem, WAVES).motion_errors(off, places, order)).max() * motion_unit_factor(
            problem.setup, order
        )
        assert known == pytest.approx(abs(worst.error), rel=1e-4)


@pytest.mark.slow
def test_the_command_shows_the_bounds_of_rates(command, tmp_path):
    file = tmp_path / "cut.toml"
    file.write_text(with_waves("knife").to_toml())
    said = command("tolerance", file, "--json", "--out", tmp_path / "worst")[1]
    cases = json.loads(said)["worst_cases"]
    for each, name in zip(cases, ("motion", "motion-velocity", "motion-acceleration"), strict=True):
        cam = camopt.find_scene(tmp_path / "worst" / f"worst-{name}.toml")  # its phase is that of one part
        assert cam.tolerances.number_and_angle_tolerances["phase"].values == (each["errors"]["phase"],)
    assert [each["name"] for each in cases] == ["displacement", "velocity", "acceleration"]
    assert all(abs(each["error"]) <= each["bound"] for each in cases)
    assert Scene.from_dict(with_waves("knife").to_dict()).tolerances.waves == WAVES

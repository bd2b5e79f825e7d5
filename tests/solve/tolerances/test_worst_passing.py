"""Proven earliest and latest passages of a lift over all cams, and the cams that nearly reach them."""

import json
from math import radians

import numpy as np
import pytest
from mpmath import mp
from support.depth import is_deep
from support.real_cams import cams_of
from support.recontact import displacement

import camopt
from camopt.core.numerics.budget import UNLIMITED
from camopt.model.effects.motion import motion_unit_factor
from camopt.scene.problem.problem import resolve_design
from camopt.show.studies.timing import _passage_ends
from camopt.solve.tolerances import dwells_and_passages
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, error_ranges_by_key_at_all_contacts
from camopt.solve.tolerances.turn_errors import TurnErrors
from camopt.solve.tolerances.worst_case import make_worst_cam_search
from tests.solve.tolerances.test_response import DIGITS
from tests.solve.tolerances.test_worst_case import scene_with_tolerances
from tests.solve.tolerances.test_worst_wobble import cam_of

KINDS = ["offset-roller", "arm", "flat", "swinging-face", "groove-arm", "train", "pair", "links"]


def passages(scene):
    """The events of half of the lift, however long they take."""
    (passage,) = camopt.timing(scene.replace(tolerances={})).passages
    turn = TurnErrors(scene.with_profile_tolerance_moved, resolve_design(scene))
    of, unit = make_worst_cam_search(turn), turn.problem.programme.tool.unit_in_mm_or_rad
    return [
        dwells_and_passages._worst_passage(of, each, end, UNLIMITED)
        for each in _passage_ends(passage, unit)
        for end in dwells_and_passages.PASSAGE_DIRECTIONS
    ]


@pytest.mark.one_in(9)
@pytest.mark.parametrize("kind", KINDS)
def test_no_cam_passes_beyond_the_bound(kind):
    """By 10,000 cams, half of them at corners, by exact contact at each bound."""
    scene, rng, count = cam_of(kind), np.random.default_rng(5), 10_000
    problem = resolve_design(scene)
    zones, cams, programme = (
        error_ranges_by_key_at_all_contacts(scene.with_profile_tolerance_moved, problem),
        cams_of(problem, 0),
        problem.programme.tool,
    )
    share = rng.uniform(size=(count, len(zones)))
    share[count // 2 :] = rng.integers(0, 2, (count - count // 2, len(zones)))
    off = {key: low + x * (high - low) for (key, (low, high)), x in zip(zones.items(), share.T, strict=True)}
    off[BORE] = off[BORE] * np.exp(2j * np.pi * rng.uniform(size=count))
    off.pop(BORE_DIRECTION, None)
    for found in passages(scene)[:: 1 if is_deep() else 3]:
        angles = np.full(count, radians(found.bound_deg))
        error = cams.motion_errors(off, cams.contact_places(off, angles), 0)
        side = dwells_and_passages.PASSAGE_SIDES[found.passage, found.end]
        above = side * (programme.motion_at(angles[:1])[0] + error - found.lift * programme.unit_in_mm_or_rad)
        assert above.max() <= 1e-13
        assert above.max() > -0.5 * np.ptp(error)  # not far from it
        assert 0.0 < found.gap_deg < 2e-5 * abs(found.found_deg - angle_of(scene, found))


def angle_of(scene, found):
    """Where the nominal cam passes."""
    return getattr(camopt.timing(scene.replace(tolerances={})).passages[0], f"{found.passage}_at_deg")


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "groove-arm"])
def test_the_first_and_the_last_cam_are_at_the_lift_by_exact_contact_in_40_digits(contact):
    scene = scene_with_tolerances(contact)
    tables, unit = scene.to_dict(), motion_unit_factor(resolve_design(scene).setup, 0)
    for found in passages(scene)[:: 1 if contact == "offset-roller" or is_deep() else 3]:
        known = {key.removeprefix("follower."): each for key, each in found.errors.items()}
        known |= {key: np.radians(known[key]) for key in ("phase", "face_tilt") if key in known}
        with mp.workdps(DIGITS):
            known["bore"] = known.pop(BORE) * mp.expj(np.radians(known.pop(BORE_DIRECTION)))
            exact = unit * displacement(tables, known, mp.mpf(np.radians(found.found_deg)))
        assert float(exact) == pytest.approx(found.lift, abs=1e-10)


def test_the_bounds_are_closed_forms_where_there_are_some():
    """Under a flat face a profile moves the lift, and a phase the cam angle."""
    scene = camopt.find_scene("bucket-valve")
    by_profile = camopt.timing(scene.replace(tolerances={"profile": 0.01}), [1.0]).worst
    for found, lift in zip(by_profile, (0.99, 1.01, 1.01, 0.99), strict=True):
        (passage,) = camopt.timing(scene, [lift]).passages
        assert found.bound_deg == pytest.approx(getattr(passage, f"{found.passage}_at_deg"), abs=1e-6)
    by_phase = camopt.timing(scene.replace(tolerances={"phase": {"plus": 0.02, "minus": 0.01}}), [1.0])
    rises, falls = by_phase.passages[0].rises_at_deg, by_phase.passages[0].falls_at_deg
    expected = [rises - 0.02, rises + 0.01, falls - 0.02, falls + 0.01]
    assert [each.bound_deg for each in by_phase.worst] == pytest.approx(expected, abs=3e-6)


def test_a_passage_that_some_cam_does_not_make_and_one_without_a_proof_are_reported(command, monkeypatch):
    wide = camopt.find_scene("bucket-valve").replace(tolerances={"profile": 0.5})
    low = camopt.timing(wide, [0.4]).worst  # as low as a profile that stands out by 0.5 mm does not go
    assert [(each.bound_deg, each.unproved) for each in low if np.isinf(each.bound_deg)] == [
        (-np.inf, "some cam never passes it"),
        (np.inf, "some cam never passes it"),
    ]
    assert {each.gap_deg for each in low if np.isinf(each.bound_deg)} == {0.0}
    out = command("timing", "uniform-knife-offset", "--set", "tolerances.profile=0.01")[1]
    assert "An infinite bound is not proved: the velocity of the motion jumps." in out
    monkeypatch.setattr(dwells_and_passages, "MOTION_PROOF_WORK", 0.0)
    found = json.loads(command("timing", "bucket-valve", "--set", "tolerances.profile=0.01", "--json")[1])["worst"]
    assert {(each["bound_deg"], each["unproved"]) for each in found} == {(None, "the proof takes too much work")}


def test_a_tolerance_so_large_that_a_follower_loses_its_cam_is_refused(command):
    code, _, err = command("timing", "roller-1000rpm", "--set", "tolerances.follower.offset=40")
    assert code == 2
    assert "the follower does not touch its cam all over the turn" in err

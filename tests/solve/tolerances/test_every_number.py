"""Tolerances of links and of numbers other than sizes, against closed loops in 40 digits and other cams."""

import json
from functools import cache

import numpy as np
import pytest
from mpmath import mp
from scipy import stats
from support.cams import STEEL, cam_with
from support.depth import is_deep, times
from support.trains import exact

import camopt
from camopt.core.mistakes import BadInput
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion.tool_drive import tool_position
from camopt.model.trains import TRAIN_STAGES
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.scene.train import CARRIED_KEYS
from camopt.solve.tolerances import dwells_and_passages, worst_case
from camopt.solve.tolerances.error_samples import sample_errors
from camopt.solve.tolerances.errors import (
    contact_errors_from_flat_errors,
    error_ranges_at_one_contact,
    flat_from_polar_errors,
)
from camopt.solve.tolerances.margins import ToleranceBox
from camopt.solve.tolerances.real_cam import RealCam, follower_offset_in_train
from camopt.solve.tolerances.response import ToolResponse
from camopt.solve.tolerances.turn_errors import TurnErrors, variance_by_tolerance
from tests.solve.tolerances.test_tolerance import TRAINS, scene_of

STAGES = {
    "rocker": ("roller", TRAINS["roller"]),
    "bell-crank": (
        "offset-roller",
        {"stage": "bell-crank", "crank": 80, "coupler": 150, "angle": -80, "input_arm": 60, "input_angle": -15},
    ),
    "four-bar": ("arm", {"crossed": False, **TRAINS["arm"]}),
    "slider-crank": ("arm", {"stage": "slider-crank", "crank": 60, "coupler": 150, "offset": 5, "angle": -100}),
    "ratio": ("roller", {"stage": "ratio", "ratio": -1.5}),
    "incline": ("roller", {"stage": "incline", "angle": 30, "guide": 80}),
}
SIZE = {"ratio": 0.002}
QUICK = ("rocker", "ratio")
"""Those of which a bound is proved every day."""
MP_STEP = 1e-12
"""Of a link, for its slope in 40 digits."""


@cache
def scene_with_stage(stage, size=0.02):
    """A scene with a train whose numbers all have tolerances, and what its bound is."""
    contact, row = STAGES[stage]
    keys = [key for key in row if key not in ("stage", "crossed")]
    given = {f"train.1.{key}": SIZE.get(key, size) for key in keys} | {"follower.roller_radius": size}
    found = cam_with(contact, "poly345", dynamics={})
    tables = {key: found[key] for key in ("cam", "follower", "motion")}
    scene = Scene.from_dict({**tables, "name": stage, "train": [row], "tolerances": given})
    return scene, resolve_design(scene)


@cache
def bound_of(stage):
    return camopt.tolerance(scene_with_stage(stage)[0]).worst_case


def tool_by_closed_loops(scene, problem, follower, errors=()):
    """Where the tool is by its closed loops in 40 digits, of a follower at a place from the start of the train."""
    row = {key: each for key, each in scene.train[0] if each is not None and key != "stage"}
    for key, by in dict(errors).items():
        if key.startswith("train.1."):
            row[key[8:]] = mp.mpf(row[key[8:]]) + mp.mpf(by)
    return exact([(scene.train[0].stage, row)], problem.setup.angular, mp.mpf(follower))


@pytest.mark.long
def test_tools_of_links_with_errors_are_where_their_closed_loops_are():
    """Random cams and corners of all tolerances, in 40 digits; none is beyond the bound, and one nearly has it."""
    rng, most = np.random.default_rng(3), 0.0
    for number in range(times(4, 300)):
        stage = [*STAGES][number % len(STAGES)]
        scene, problem = scene_with_stage(stage)
        ends = error_ranges_at_one_contact(scene, problem)
        shares = rng.choice([0.0, 1.0], len(ends)) if number % 2 else rng.uniform(size=len(ends))
        errors = {k: low + x * (high - low) for (k, (low, high)), x in zip(ends.items(), shares, strict=True)}
        place = np.array([rng.uniform(0.1, 6.1)])
        found, still = (
            RealCam(problem).tool_error_at_contact(flat_from_polar_errors(errors), place),
            RealCam(problem).tool_error_at_contact({}, place),
        )
        own = {key: each for key, each in errors.items() if not key.startswith("train")}
        train = problem.setup.train
        at = [
            float(train.follower_displacement_at(tool_position(problem.programme, each))[0])
            for each in (place, found.angle)
        ]
        y, y1, *_ = problem.programme.motion_at(place)
        rest = problem.setup.mechanism.shifted_contact(
            problem.design,
            problem.programme.lift,
            y,
            y1,
            contact_errors_from_flat_errors(flat_from_polar_errors(own)),
        )
        with mp.workdps(40):
            stands = tool_by_closed_loops(scene, problem, at[0] + float(rest.moved[0]), errors)
            known = float(stands - tool_by_closed_loops(scene, problem, at[1]))
        assert found.error[0] == pytest.approx(known, abs=1e-9)
        assert abs(still.error[0]) < 1e-12
        if is_deep() or stage in QUICK:
            bound = bound_of(stage).bound
            assert abs(known) * motion_unit_factor(problem.setup, 0) <= bound
            most = max(most, abs(known) * motion_unit_factor(problem.setup, 0) / bound)
    assert most > (0.3 if is_deep() else 0.0)
    for stage in QUICK:
        found = bound_of(stage)
        assert 0.0 <= found.gap <= 2e-4 * found.bound
        assert set(found.errors) == set(scene_with_stage(stage)[0].tolerances.numbers)
        assert found.bound == pytest.approx(camopt.tolerance(scene_with_stage(stage)[0]).errors[0].worst, rel=0.01)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("stage", STAGES)
def test_responses_to_links_are_the_slopes_of_their_closed_loops(stage):
    """The displacement in 40 digits; velocity and acceleration by differences over cam angles."""
    scene, problem = scene_with_stage(stage)
    step, angles = 1e-4, np.array([0.9, 0.9 - 1e-4, 0.9 + 1e-4, 2.0])
    answers, start = ToolResponse(problem, angles), follower_offset_in_train(problem)
    for key in (key for key in scene.tolerances.numbers if key.startswith("train")):
        found = answers.number_response(key)
        for place in (0, 3):
            y = float(problem.programme.motion_at(angles)[0][place]) + start
            with mp.workdps(40):
                ends = [tool_by_closed_loops(scene, problem, y, {key: side * mp.mpf(MP_STEP)}) for side in (1, -1)]
                known = float((ends[0] - ends[1]) / (2 * mp.mpf(MP_STEP)))
            assert found[0, place] == pytest.approx(known, rel=1e-8, abs=1e-10)
        size = np.abs(found).max()
        assert found[1, 0] == pytest.approx((found[0, 2] - found[0, 1]) / (2 * step), abs=1e-5 * size)
        assert found[2, 0] == pytest.approx((found[1, 2] - found[1, 1]) / (2 * step), abs=1e-5 * size)


CARRIED_BY = {
    "slide": {
        "mass": 1.3,
        "spring_rate": 7.1,
        "preload": 90.7,
        "load": 4.3,
        "gravity": 9.81,
        "friction_force": 3.1,
    },
    "shaft": {"inertia": 0.0031, "spring_rate": 11.3, "preload": 5.3},
}
ALL_KEYS = [
    (*STAGES["rocker"], "slide", {"arm_inertia": 0.0013}),
    (*STAGES["bell-crank"], "slide", {"offset": 4.7, "arm_inertia": 0.0013}),
    (*STAGES["four-bar"], "shaft", {}),
    (
        "arm",
        {"stage": "four-bar", "crank": 150, "coupler": 130, "rocker": 140, "ground": 75, "angle": 70},
        "shaft",
        {},
    ),
    (*STAGES["slider-crank"], "slide", {}),
    ("roller", {"stage": "slider-crank", "crank": 101, "coupler": 203, "offset": 5, "angle": -99}, "shaft", {}),
    (*STAGES["ratio"], "slide", {}),
    ("roller", {"stage": "ratio", "radius": 47}, "shaft", {}),
    (*STAGES["incline"], "slide", {}),
]
"""Stages with all of their keys: a contact of a follower, the stage, what it moves and carries, and more keys."""


def test_every_key_of_every_stage_is_among_them():
    for name, stage in TRAIN_STAGES.items():
        rows = [{**row, **CARRIED_BY[moves], **more} for _, row, moves, more in ALL_KEYS if row["stage"] == name]
        assert set().union(*rows) >= {*stage.needs, *stage.others} - {"crossed"}
    assert set().union(*({**CARRIED_BY[moves], **more} for *_, moves, more in ALL_KEYS)) >= {*CARRIED_KEYS}


@pytest.mark.slow
@pytest.mark.one_in(9)
@pytest.mark.parametrize(("contact", "row", "moves", "more"), ALL_KEYS)
def test_every_key_of_every_stage_may_have_a_tolerance(contact, row, moves, more, command, tmp_path, monkeypatch):
    """Of sizes that are not round, by each command that reads tolerances."""
    for room, name in (
        (worst_case, "DISPLACEMENT_GAP"),
        (worst_case, "RATE_GAP"),
        (dwells_and_passages, "WOBBLE_GAP"),
    ):
        monkeypatch.setattr(room, name, 0.1)
    monkeypatch.setattr(dwells_and_passages, "PASSAGE_GAPS", (0.1, 10.0))
    rng, file = np.random.default_rng(57), tmp_path / "cam.toml"
    numbers = {
        key: each for key, each in {**row, **more, **CARRIED_BY[moves]}.items() if key not in ("stage", "crossed")
    }
    numbers = {key: each * rng.uniform(0.98, 1.02) for key, each in numbers.items()}
    found = cam_with(contact, "poly345", dynamics={})
    follower = {**found["follower"], "dynamics": {"inertia": 0.0011} if contact == "arm" else {"mass": 0.7}}
    given = {f"train.1.{key}": 1e-4 * abs(each) for key, each in numbers.items()}
    tables = {"cam": found["cam"], "follower": follower, "motion": found["motion"], "train": [{**row, **numbers}]}
    scene = Scene.from_dict({**tables, "limits": {"contact_force_min": -1e9}, "tolerances": given})
    file.write_text(scene.to_toml())
    status, out, _ = command("tolerance", file, "--cams", 64, "--json")
    told = json.loads(out)
    assert status == 0
    rounding = np.spacing(100.0)  # the error of a cam is a difference of positions [mm or deg]
    assert told["worst_case"]["bound"] > abs(told["worst_case"]["error"]) - rounding > 0.0
    assert set(told["worst_case"]["errors"]) == {key for key in given if key[8:] not in CARRIED_KEYS}
    assert command("timing", file)[0] == 0


NUMBERS = {
    "follower.roller_radius": 0.05,
    "cam.base_radius": 0.1,
    "cam.rpm": 5,
    "follower.dynamics.spring_rate": 0.5,
    "follower.dynamics.mass": {"plus": 0.03, "minus": 0.01},
    "materials.face_width": 0.2,
}
BOUNDS = {
    "pressure_angle": 40,
    "contact_force_min": 1,
    "contact_stress": 400,
    "torque": 12,
    "acceleration": 120,
    "hub_wall": 5,
}


def loaded_scene(**more):
    found = cam_with("roller", "cycloidal", outputs=[])
    own = {"name": "loaded", **found, "materials": STEEL, "limits": BOUNDS, "part": {"bore": 20}}
    return Scene.from_dict({**own, "tolerances": NUMBERS, **more})


@pytest.fixture(scope="module")
def of_numbers():
    scene = loaded_scene()
    return scene, camopt.tolerance(scene)


def test_of_all_numbers_within_their_tolerances_none_makes_a_worse_cam(of_numbers):
    """By cams of their own: the worst one of each limit, and some at corners and inside."""
    scene, found = of_numbers
    assert found.errors[0].shares.keys() == {"follower.roller_radius"}  # the others move no tool
    rng, limits = np.random.default_rng(5), [each for each in found.margins if each.quantity]
    assert {each.verdict for each in limits} == {"held"}
    for each in limits:
        worst = found.worst_cam(each.limit)
        assert worst.tolerances.numbers == {}
        assert camopt.evaluate(worst)[each.quantity] == pytest.approx(each.worst, rel=1e-12)
    for number in range(times(4, 60)):
        cam = {}
        for key, given in NUMBERS.items():
            plus, minus = (given["plus"], given["minus"]) if isinstance(given, dict) else (given, given)
            share = rng.choice([0.0, 1.0]) if number % 2 else rng.uniform()
            cam[key] = scene.numbers([key])[key] - minus + share * (plus + minus)
        values = camopt.evaluate(scene.replace(**cam, outputs=[each.quantity for each in limits]))
        for each in limits:
            side = -1.0 if each.relation in ("≥", ">") else 1.0
            assert side * (values[each.quantity] - each.worst) <= (each.gap or 0.0) + 1e-12


@pytest.mark.slow
def test_a_robust_cam_holds_its_limits_at_every_number_within_the_tolerances(of_numbers):
    limits = {"pressure_angle": 30, "contact_force_min": 1, "torque": 60}
    given = {key: NUMBERS[key] for key in ("follower.roller_radius", "cam.rpm", "follower.dynamics.mass")}
    changes = {"search": {"robust": True}, "limits": limits, "tolerances": given, "part": {}}
    scene = of_numbers[0].replace(**changes)
    best = camopt.optimise(scene).best
    assert (best["proved"], best["every_cam"]) == (True, "held")
    assert set(camopt.certify(best.scene).values()) == {"held"}
    smaller = best.scene.replace(**{"cam.base_radius": best["base_radius_mm"] * (1.0 - 1e-6)})
    margins = {each.limit: each.verdict for each in camopt.tolerance(smaller).margins}
    assert "broken" in margins.values()
    assert best["nominal_mm"] < best["base_radius_mm"]


def test_a_batch_has_the_spread_of_each_number(of_numbers):
    """The contact force at its least is linear in the rate of the spring: its share and quantiles are known."""
    given = {"follower.dynamics.spring_rate": {"plus": 0.5, "minus": 0.5}, "follower.dynamics.preload": 10}
    scene = of_numbers[0].replace(tolerances=given, limits={"contact_force_min": 1})
    spread = next(each for each in camopt.sample_cams(scene, cams=2**12).spreads if each.limit != "undercut")
    force = camopt.evaluate(scene)["contact_force_min_N"]
    slopes = {
        key: camopt.evaluate(scene.replace(**{key: scene.numbers([key])[key] + 1e-3}))["contact_force_min_N"]
        - force
        for key in given
    }
    parts = [slopes[key] / 1e-3 * zone / 3 for key, zone in zip(given, (0.5, 10), strict=True)]
    deviation = np.hypot(*parts)
    assert spread.median == pytest.approx(force, abs=0.02 * deviation)
    assert spread.high == pytest.approx(force + 3 * deviation, rel=3e-3)
    for key, part in zip(given, parts, strict=True):
        assert spread.variances[key] == pytest.approx((part / deviation) ** 2, abs=0.03)


LEVER = camopt.find_scene("pusher-by-lever")


def test_limits_of_trains_with_errors_are_those_of_cams_designed_for_them():
    """A cam of which a link is off is made for it: at the ends of its zone as another scene has it."""
    scene = LEVER.replace(tolerances={"train.1.ratio": 0.01})
    for each in camopt.tolerance(scene).margins:
        if not each.quantity:
            continue
        ends = [
            camopt.evaluate(LEVER.replace(**{"train.1.ratio": 2.0 + by}, outputs=[each.quantity]))[each.quantity]
            for by in (-0.01, 0.01)
        ]
        side = -1.0 if each.relation in ("≥", ">") else 1.0
        assert each.worst == pytest.approx(side * max(side * end for end in (*ends, each.nominal)), rel=1e-12)


@pytest.mark.long
def test_limits_of_all_trains_within_their_tolerances_are_proved():
    """No cam of random trains is worse than the worst one; its value is where the verdict changes."""
    given, rng = {"train.1.crank": 0.3, "train.1.coupler": 0.2}, np.random.default_rng(7)
    scene = camopt.find_scene("slide-by-bell-crank").replace(limits={"pressure_angle": 26}, tolerances=given)
    margins = {each.limit: each for each in ToleranceBox.from_scene(scene, resolve_design(scene)).margins}
    (margin, undercut) = (margins[name] for name in ("pressure_angle", "undercut"))
    assert (margin.verdict, undercut.verdict) == ("held", "held")
    assert 0.0 < margin.gap < 1e-6
    for _ in range(times(4, 100)):
        cam = {key: scene.numbers([key])[key] + by * rng.uniform(-1, 1) for key, by in given.items()}
        names = [margin.quantity, undercut.quantity]
        values = camopt.evaluate(scene.replace(**cam, tolerances={}, outputs=names))
        assert values[margin.quantity] <= margin.worst + margin.gap
        assert values[undercut.quantity] >= undercut.worst - undercut.gap
    for share, verdict in ((1.0 + 1e-8, "held"), (1.0 - 1e-8, "broken")):
        other = scene.replace(**{"limits.pressure_angle": margin.worst * share})
        found = ToleranceBox.from_scene(other, resolve_design(other)).margins
        assert {each.limit: each.verdict for each in found}["pressure_angle"] == verdict


def test_a_lever_with_an_error_moves_its_tool_in_proportion():
    """The closed form: the tool is off by its displacement times the relative error of the ratio."""
    found = camopt.tolerance(LEVER.replace(tolerances={"train.1.ratio": 0.002}))
    lift = LEVER.motion[0].lift
    assert found.errors[0].worst == pytest.approx(lift * 0.001, rel=1e-9)
    assert found.worst_case.bound == pytest.approx(lift * 0.001, rel=2e-5)


def test_measured_errors_are_drawn_as_they_are(tmp_path):
    """Of a linear limit: so many cams hold it as measured parts do; the file is read beside the scene."""
    parts = [-0.4, -0.1, 0.0, 0.1, 0.1, 0.3, 0.45, 0.6]
    (tmp_path / "parts.csv").write_text("part,error\n" + "".join(f"{n},{e}\n" for n, e in enumerate(parts)))
    face = scene_of("flat", given={})
    middle, names = face.follower.offset, ("face_reach_max_mm", "face_reach_min_mm")
    cams = [camopt.evaluate(face.replace(**{"follower.offset": middle + each})) for each in parts]
    reach = [max(abs(cam[name]) for name in names) for cam in cams]
    scene = face.replace(**{"limits.face_reach": sorted(reach)[4] + 1e-6})
    file = tmp_path / "cam.toml"
    file.write_text(scene.to_toml() + '\n[tolerances]\n"follower.offset" = { values = "parts.csv:error" }\n')
    scene = Scene.from_toml(file)
    assert scene.tolerances.numbers["follower.offset"].values == tuple(parts)
    assert Scene.from_dict(scene.to_dict()) == scene
    batch = camopt.sample_cams(scene, cams=2**12)
    held = next(each.held for each in batch.spreads if each.limit == "face_reach")
    assert held.share == pytest.approx(5 / 8, abs=1e-3)
    assert set(batch.samples["follower_offset_off_mm"].values) == set(parts)
    margin = next(each for each in camopt.tolerance(scene).margins if each.limit == "face_reach")
    assert margin.worst == pytest.approx(max(reach))  # the ends of the zone are those of the parts


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({}, {}),
        ({"distribution": "uniform"}, {"distribution": "triangular"}),
        ({"values": [0.01, 0.02, -0.01, 0.0, 0.03]}, {}),
    ],
)
def test_errors_of_one_batch_go_together(one, other):
    """The variance at a cam angle is that of 32,768 cams, and of normal errors that of the closed form."""
    given = {
        "train.1.input_arm": {"plus": 0.02, "minus": 0.02, "batch": "lot", "shared": 0.8, **one},
        "train.1.output_arm": {"plus": 0.03, "minus": 0.02, "batch": "lot", "shared": 0.5, **other},
    }
    if "values" in one:
        given["train.1.input_arm"] |= {"plus": 0.0, "minus": 0.0}
    scene = camopt.find_scene("valve-with-rocker").replace(tolerances=given)
    problem = resolve_design(scene)
    found = TurnErrors(scene, problem).contributions_at(np.array([0.8, 1.2]))
    off = sample_errors(scene, problem, 2**15, 4)
    errors = sum(np.outer(off[each.key], each.response[0]) for each in found)
    np.testing.assert_allclose(errors.var(axis=0), variance_by_tolerance(found, 0).sum(axis=0), rtol=0.01)
    np.testing.assert_allclose(errors.mean(axis=0), sum(each.mean[0] for each in found), atol=1e-5)
    if not (one or other):
        first, second = (each.response[0] * sigma for each, sigma in zip(found, (0.02 / 3, 0.025 / 3), strict=True))
        known = first**2 + second**2 + 2 * np.sqrt(0.8 * 0.5) * first * second
        np.testing.assert_allclose(variance_by_tolerance(found, 0).sum(axis=0), known, rtol=1e-9)
        assert np.corrcoef(*off.values())[0, 1] == pytest.approx(np.sqrt(0.4), abs=0.01)


def test_the_share_of_cams_within_a_distance_is_that_of_the_normal_distribution(command, tmp_path):
    """A profile that is too large everywhere lifts a flat face by as much."""
    scene, file = scene_of("flat", given={"profile": 0.03}), tmp_path / "cam.toml"
    file.write_text(scene.to_toml())
    batch = camopt.sample_cams(scene, cams=2**12, within=0.015)
    known = 1.0 - 2.0 * stats.norm.sf(1.5)
    assert batch.held.share == pytest.approx(known, abs=1e-3)
    assert batch.errors[0].held == batch.held
    with camopt.shown_in("inch"):
        found = batch.table()
    rows = {row[0].text: row[1].text for row in found.rows}
    assert rows["variance by profile, %"] == f"{100 * batch.errors[0].variances['profile']:.6g}"
    assert float(rows["worst cam"]) == pytest.approx(batch.errors[0].worst / 25.4, rel=1e-5)
    assert "±0.000590551 in" in found.note
    told = json.loads(command("tolerance", file, "--cams", 4096, "--within", 0.015, "--json")[1])
    assert told["batch"]["held"]["share"] == batch.held.share
    assert command("tolerance", file, "--within", 0.015)[0] == 2
    with pytest.raises(BadInput, match="a distance above 0"):
        camopt.sample_cams(scene, within=-1.0)


def test_a_cam_of_its_own_has_no_tolerance_of_what_was_made(of_numbers):
    scene, _ = of_numbers
    scene = scene.replace(**{"tolerances.profile": 0.01, "limits.position_error": 0.2})
    worst = camopt.tolerance(scene).worst_cam("pressure_angle")
    assert (worst.tolerances.numbers, worst.tolerances.profile) == ({}, 0.01)
    assert camopt.evaluate(worst)["position_error_max_mm"] == pytest.approx(0.0105, abs=2e-4)


def test_a_robust_scene_of_given_sizes_is_certified_with_classes_of_them():
    scene = loaded_scene(
        tolerances={"follower.roller_radius": "h6"}, search={"robust": True, "roller_radius": [12, 14]}
    )
    assert set(camopt.certify(scene).values()) == {"held"}
    with pytest.raises(BadInput, match=r"tolerances\.follower\.roller_radius = 'h6': must be ± mm"):
        camopt.optimise(scene)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"train.2.ratio": 1}, "tolerances.train.2.ratio: the train of the scene has 1 stage"),
        ({"train.1.crank": 1}, "tolerances.train.1.crank: this stage, ratio, has no crank"),
        (
            {"train.1.ratio": 0.1, "train": {"1": {"ratio": 0.2}}},
            "train.1.ratio = 0.1: is given twice: leave one",
        ),
        ({"train.1.ratio": "h6"}, "is for sizes of cam, follower and train, not for train.1.ratio"),
        ({"follower.dynamics.damping": 1}, "the scene does not give follower.dynamics.damping"),
        ({"cam.shaft_diameter": 1}, "tolerances.cam.shaft_diameter: cannot have a tolerance: give"),
        ({"cam.rpm": 200}, "would change cam.rpm from 100 to -100, which must be"),
        ({"cam.form": 1}, "tolerances.cam.form = 1: not a number of this table"),
        ({"phase": {"values": "x.csv"}}, "must be a list of numbers, or a file and its column"),
        ({"phase": {"values": "x.csv:a"}}, "must be a CSV file with columns a: No such file"),
        ({"phase": {"values": [1, 2], "cpk": 2}}, "phase.cpk = 2: the measured values are the distribution"),
        ({"phase": {"plus": 1, "shared": 0.5}}, "needs the name of a batch, which is missing"),
    ],
)
def test_invalid_tolerances_of_numbers_are_refused(given, said):
    with pytest.raises(BadInput) as refused:
        LEVER.replace(tolerances=given)
    assert said in str(refused.value)

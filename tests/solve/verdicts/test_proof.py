"""Proofs, against 50 digits, ball arithmetic, the laws, and the verdicts of the kernels."""

import json
import operator as operators
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import mpmath
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st
from support import naive, own
from support.balls.ball import Ball, ball_between, precisely
from support.balls.curves import in_balls
from support.balls.deciding import Largest
from support.balls.laws import EXACT_BY_NAME, pieces_of
from support.balls.motion import TurnPart, exact_motion
from support.balls.proof import constraint_verdict, sides_of
from support.cams import CONTACTS, GUIDED, WORN, cam_with
from support.depth import covering_cases, times
from support.smallest_cams import BASE, CASES

import camopt
from camopt import Scene, certify, evaluate, find_scene, optimise, shipped_scenes, sweep
from camopt.cli.main import main
from camopt.core.mistakes import BadInput
from camopt.core.quantities import QUANTITIES
from camopt.model.motion import LAWS
from camopt.scene.problem.limits import LOAD_LIMITS
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.space import grid_space
from camopt.solve.front.table_certificate import certify_table
from camopt.solve.verdicts.certify import certify_limits
from camopt.solve.verdicts.limit_boxes import limit_verdict_over_box
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts, evaluate_with_verdicts_and_effort
from camopt.solve.verdicts.verdict_words import worst_verdict

DATA = json.loads((Path(__file__).parents[2] / "data" / "reference.json").read_text())
REFERENCE = {cam["id"]: cam for cam in DATA}


def features(name):
    """What a cam has that others have not: a mechanism, turning one way or the other, and laws."""
    scene = REFERENCE[name]["scene"]
    mechanism = scene["cam"]["form"], scene["follower"]["motion"], scene["follower"]["contact"]
    yield mechanism, scene["cam"].get("rotation")
    yield from (segment.get("law") for segment in scene["motion"])


VERBS = ("displacement", "velocity", "acceleration", "jerk")


def test_every_law_has_an_exact_form_and_one_of_fifty_digits():
    """In tests/support/balls/laws.py and tests/support/naive.py, with tables by tests/data/make_reference.py."""
    assert set(EXACT_BY_NAME) == {name for name, law in LAWS.items() if isinstance(law, ModuleType)}
    assert set(naive.LAWS) >= set(LAWS)


@pytest.mark.parametrize("law", own.EVERY)
@precisely()
def test_exact_laws_join_and_are_the_laws(law):
    pieces = pieces_of(own.EVERY[law])
    assert pieces[0].start == 0
    assert pieces[0].derivative(0, arb(0)).contains(0)
    assert abs(pieces[-1].derivative(0, pieces[-1].end) - 1) < arb("1e-50")
    for left, right in pairwise(pieces):
        for order in (0, 1):
            assert left.derivative(order, left.end).overlaps(right.derivative(order, right.start))
    for piece in pieces:
        for share in (0.1, 0.5, 0.9):
            x = piece.start + (piece.end - piece.start) * share
            for order, verb in enumerate(VERBS):
                exact, found = float(piece.derivative(order, x)), float(getattr(own.EVERY[law], verb)(float(x)))
                assert found == pytest.approx(exact, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("law", own.EVERY)
@mpmath.workdps(50)
@precisely()
def test_exact_laws_against_fifty_digits(law):
    for piece in pieces_of(own.EVERY[law]):
        x = mpmath.mpf(float(piece.start + (piece.end - piece.start) * 0.3))
        unit = own.law_at(own.EVERY[law], x)
        for order, expected in enumerate(unit[:4]):
            found = piece.derivative(order, arb(str(x)))
            assert abs(mpmath.mpf(found.mid().str(45, radius=False)) - expected) <= mpmath.mpf("1e-40")


SIDES = {"pressure_angle": ("pressure_angle_max_deg", 1.0), "curvature_radius": ("profile_radius_min_mm", -1.0)}


def extremes_of(quantity):
    """The fifty digits of a quantity, of the cams for which they make a limit."""
    every = {name: cam["expected"].get(quantity, "inf") for name, cam in REFERENCE.items()}
    return {name: value for name, value in every.items() if 1e-6 < float(value) < 89}


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("limit", "name"),
    [(limit, name) for limit, (key, _) in SIDES.items() for name in covering_cases(extremes_of(key), features)],
)
def test_limits_on_either_side_of_a_fifty_digit_extreme(limit, name):
    quantity, side = SIDES[limit]
    scene, value = Scene.from_dict(REFERENCE[name]["scene"]), float(extremes_of(quantity)[name])
    for share, verdict in ((1e-12 * side, "held"), (-1e-12 * side, "broken")):
        found = certify(scene.replace(limits={limit: value * (1.0 + share)}))
        either = [found[key] for key in (limit, f"{limit}_return") if key in found]
        assert ("broken" if "broken" in either else "held") == verdict, share
        assert "undecided" not in either


ROUNDINGS = 1e-13  # relative: what is decided on either side of a bound
ANGLES = extremes_of("pressure_angle_max_deg")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", covering_cases(ANGLES, features))
@mpmath.workdps(50)
def test_what_rounding_hides_is_undecided_and_no_more_than_that(name):
    """A limit at the double next to the exact extreme is not decided wrongly; one some roundings off is decided."""
    scene, exact = Scene.from_dict(REFERENCE[name]["scene"]), mpmath.mpf(ANGLES[name])
    sound = not evaluate(scene.replace(limits=None))["violated"]
    for share in (0.0, ROUNDINGS, -ROUNDINGS):
        bound = float(exact * (1 + mpmath.mpf(share)))
        found, held = evaluate(scene.replace(limits={"pressure_angle": bound})), sound and share > 0.0
        if share and sound:
            assert (found["feasible"], found["status"]) == (held, "certified")
        if found["status"] == "certified":
            assert found["feasible"] <= (sound and bool(exact <= mpmath.mpf(bound)))


@pytest.mark.parametrize("name", ["roller-1000rpm", "two-pauses", "pusher-by-lever"])
def test_a_limit_that_both_sides_of_an_enclosure_touch_is_undecided_and_not_feasible(name):
    scene = find_scene(name).replace(limits=None)
    limited = scene.replace(limits={"pressure_angle": evaluate(scene)["pressure_angle_max_deg"]})
    found = certify(limited)
    assert "undecided" in found.values()
    assert found.exit_code == 4
    assert (evaluate(limited)["feasible"], evaluate(limited)["status"]) == (False, "undecided")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", shipped_scenes())
@pytest.mark.parametrize("limits", [{"pressure_angle": 35}, {"curvature_radius": 12}])
def test_proofs_agree_with_the_kernels(name, limits):
    scene = find_scene(name).replace(limits=limits)
    found, proofs = evaluate(scene), certify(scene)
    crossing = proofs.pop("self_crossing", None)
    assert crossing == {True: "broken", False: "held"}.get(found.get("self_crossing"))
    assert {limit for limit, verdict in proofs.items() if verdict == "broken"} == set(
        filter(None, found["violated"].split(","))
    )
    assert (worst_verdict(proofs.values()) == "held") == found["feasible"]


@pytest.mark.parametrize("name", ["roller-1000rpm", "two-pauses", "flat-reciprocating", "oscillating-roller"])
def test_an_optimum_is_proved_and_a_hair_smaller_is_refused(name):
    limits = {"pressure_angle": 35, "curvature_radius": 3}
    scene = find_scene(name).replace(limits=limits, search=None)
    best = optimise(scene).best["base_radius_mm"]
    assert worst_verdict(certify(scene.replace(**{"cam.base_radius": best})).values()) == "held"
    hair = 2e-7 if name == "oscillating-roller" else 1e-12 * (best + 30)  # where a search decides: its gap
    assert worst_verdict(certify(scene.replace(**{"cam.base_radius": best - hair})).values()) == "broken"


@pytest.mark.slow
def test_proofs_ask_for_no_ball_arithmetic():
    """python-flint is the oracle of these tests; the package does without."""
    code = "import sys, camopt; camopt.certify(camopt.find_scene('two-pauses')); print('flint' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
    )


def test_proofs_in_threads_are_those_of_one():
    scene = find_scene("two-pauses")
    with ThreadPoolExecutor(4) as threads:
        assert all(each == certify(scene) for each in threads.map(certify, [scene] * 8))


@pytest.mark.parametrize("law", ["cycloidal", "poly345", "modified-sine"])
@pytest.mark.parametrize("heavy", [False, True])
def test_a_preload_is_the_least_contact_force_of_a_cam_that_nothing_unloads(law, heavy):
    """At rest F is the preload, exactly; doubles give less, by the rounding of terms a million times as large.

    So are intervals wider, and decide at no less than that.
    """
    near = 1e-7 if heavy else 1e-12
    dynamics = (
        {"mass": 80.0, "spring_rate": 1e6, "preload": 1.0} if heavy else {"spring_rate": 20.0, "preload": 40.0}
    )
    moves = [{"segment": kind, "angle": 100, "lift": 25, "law": law} for kind in ("rise", "return")]
    follower = {
        "motion": "translating",
        "contact": "roller",
        "roller_radius": 10,
        "dynamics": {"mass": 0.8} | dynamics,
    }
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rpm": 3000 if heavy else 600, "base_radius": 40},
            "follower": follower,
            "motion": [*moves, {"segment": "dwell", "angle": 160}],
        }
    )
    for share, verdicts in ((1.0 - near, {"held"}), (1.0, {"held", "undecided"}), (1.0 + 1e-12, {"broken"})):
        cam = scene.replace(limits={"contact_force_min": dynamics["preload"] * share})
        found = certify(cam)["contact_force_min"]
        assert found in verdicts
        assert evaluate(cam)["feasible"] == (found == "held")


def test_a_design_with_numbers_of_its_own_is_asked_for_no_limit_that_was_left_out():
    """Those that are asked last came back when it was looked at alone, which ended the search for a cam."""
    rates = {"follower.dynamics.spring_rate": {"start": 5.0, "stop": 8.0, "step": 1.0}}
    scene = find_scene("roller-1000rpm").replace(
        search={"base_radius": [60.0], "roller_radius": [10.0], "offset": [5.0], **rates},
        **{"follower.dynamics": {"mass": 0.8, "preload": 40.0}, "limits.contact_force_min": 40.0},
    )
    space = grid_space(resolve(scene))
    problem, design = space.problem.without_deferred_limits, space.designs(np.zeros(1, int))
    alone, _ = problem.absorb_design_numbers(design)
    assert [limit.name for limit in alone.limits] == [limit.name for limit in problem.limits]
    assert len(alone.limits) < len(resolve(scene).limits)


def test_speed_limits_are_proved():
    scene = find_scene("roller-1000rpm")
    fast = evaluate(scene)["velocity_max_m_s"]
    for share, verdict in ((1 + 1e-12, "held"), (1 - 1e-12, "broken")):
        assert certify(scene.replace(limits={"velocity": fast * share}))["velocity"] == verdict
    assert certify(scene.replace(limits={"jerk": 1e15}))["jerk"] == "broken"  # the acceleration jumps


def test_corners_break_curvature_limits():
    scene = find_scene("uniform-knife-radial")
    assert certify(scene.replace(limits={"curvature_radius": 1}))["curvature_radius"] == "broken"


def test_a_design_that_cannot_be_assembled_is_broken():
    problem = resolve(find_scene("roller-1000rpm"))
    design = replace(problem.design, offset=np.array([80.0]))
    assert certify_limits(problem, design) == {"assembly": "broken"}


def test_a_face_that_swings_faster_than_the_cam_turns_is_broken_everywhere():
    """Its radius of curvature is infinite where both turn alike, which decides no limit."""
    follower = {"motion": "oscillating", "contact": "flat", "face_offset": 8, "centre_distance": 120}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "rotation": "cw", "base_radius": 60},
            "follower": follower,
            "motion": [
                {"segment": "rise", "angle": 10.15184381778742, "lift": 20, "law": "cycloidal"},
                {"segment": "return", "angle": 199.91323210412148, "lift": 20, "law": "cubic"},
                {"segment": "dwell", "angle": 149.93492407809111},
            ],
            "limits": {"curvature_radius": 3},
        }
    )
    found = evaluate(scene)
    assert (found["feasible"], found["violated"], found["status"]) == (False, "assembly", "certified")
    assert certify(scene) == {"assembly": "broken"}


TURNS = st.fixed_dictionaries(
    {
        "laws": st.tuples(*[st.sampled_from(sorted(LAWS))] * 2),
        "shares": st.tuples(*[st.floats(0.05, 1.0)] * 4),
        "lift": st.floats(0.3, 1.0),
        "rests": st.tuples(st.booleans(), st.booleans()),
    }
)


def turn_of(scene, laws, shares, lift, rests):
    """Rise, dwell, return and dwell of a turn, as a scene has them; a dwell may have 0 deg."""
    shares = np.array(shares) * [1.0, rests[0], 1.0, rests[1]]
    angles = (360.0 * shares / shares.sum()).tolist()
    most = max(segment.lift or 0.0 for segment in scene.motion) * lift
    return [
        {"segment": "rise", "angle": angles[0], "lift": most, "law": laws[0]},
        {"segment": "dwell", "angle": angles[1]},
        {"segment": "return", "angle": angles[2], "lift": most, "law": laws[1]},
        {"segment": "dwell", "angle": angles[3]},
    ]


LOADED = {"mass": 0.5, "spring_rate": 5.0, "preload": 100.0, "load": [[0, 0], [95, 400], [210, -50]]}
EACH = ("knife", "roller free", "spherical", "flat", "oscillating", "oscillating flat", "cylindrical")
AT_ANOTHER = {
    **{name: CASES[name] for name in (*EACH, "cylindrical oscillating")},
    "load over the turn": CASES["roller free"].replace(
        **{"follower.dynamics": LOADED, "limits.contact_force_min": 20.0}
    ),
}


@pytest.mark.parametrize("name", AT_ANOTHER)
@given(turn=TURNS, near=st.sampled_from([-1e-16, 0.0, 1e-16, 0.2]), size=st.floats(0.7, 2.0))
@settings(max_examples=times(2, deep=30))
def test_a_question_at_another_programme_is_the_scene_rewritten_with_it(name, turn, near, size):
    """Verdict for verdict, limits beside the cam's own pressure angle among them, where rounding decides."""
    scene = AT_ANOTHER[name].replace(search=None)
    written = scene.replace(motion=turn_of(scene, **turn))
    key = "mean_radius" if scene.cam.form == "cylindrical" else "base_radius"
    wider = {f"cam.{key}": size * getattr(scene.cam, key)}
    own = evaluate(written.replace(**wider)).quantities.get("pressure_angle_max_deg", np.inf)
    if 1e-3 < own * (1.0 + near) < 89:
        wider |= {"limits.pressure_angle": own * (1.0 + near), "limits.pressure_angle_return": own * (1.0 + near)}
    here, there = resolve(scene.replace(**wider)), resolve(written.replace(**wider))
    assert certify_limits(here.with_programme(there.programme), here.design) == certify_limits(there, there.design)


@pytest.mark.parametrize("rest", [0.0, 20.0])
def test_a_verdict_at_freed_angles_is_that_of_the_scene_with_them(rest):
    """At the pressure angle of the cam itself, where rounding decides; a dwell may shrink to nothing."""
    scene = Scene.from_dict(BASE).replace(
        **{"search.angle_dwell": {"start": 0, "stop": 90}, "search.angle_rise": {"start": 90, "stop": 300}}
    )
    data = scene.replace(search=None).to_dict()
    for segment, angle in zip(data["motion"], (270.0 - rest, 0.0, 90.0, rest), strict=True):
        segment["angle"] = angle
    written = Scene.from_dict(data)
    own = evaluate(written)["pressure_angle_max_return_deg"]
    for bound in (own * (1.0 - 3e-14), own, own * (1.0 + 3e-14)):
        limits = {"limits.pressure_angle_return": float(bound)}
        here, there = resolve(scene.replace(**limits)), resolve(written.replace(**limits))
        names = frozenset({"feasible", "violated", "status"})
        rows, effort = evaluate_with_verdicts_and_effort(here.with_programme(there.programme), here.design, names)
        assert effort.again == 1
        assert (
            rows.select_columns(names).records()
            == evaluate_with_verdicts(there, there.design, names).select_columns(names).records()
        )


@precisely()
def test_balls_enclose():
    x = Ball(ball_between(arb(1), arb(2)))
    for function in (np.sqrt, np.square, np.sin, np.cos, np.negative):
        found = function(x).arb
        for point in np.linspace(1, 2, 17):
            assert found.contains(arb(float(function(point)), 1e-15))


@precisely()
@given(low=st.floats(-3.0, 3.0), wide=st.floats(0.0, 2.0), number=st.floats(0.25, 4.0))
@pytest.mark.parametrize("operator", ["add", "sub", "mul", "truediv"])
def test_operators_of_balls_are_those_that_numpy_asks_for(operator, low, wide, number):
    """From either side, and with balls and numbers of every kind beside them."""
    ball = Ball(ball_between(arb(low), arb(low + wide)))
    rule = {"add": np.add, "sub": np.subtract, "mul": np.multiply, "truediv": np.true_divide}[operator]
    of_python = getattr(operators, operator)
    for other in (Ball(number), arb(number), number, np.float64(number), 2):
        for pair in ((ball, other), (other, ball)):
            if not isinstance(pair[0], arb):
                assert str(of_python(*pair).arb) == str(rule(*pair).arb)
    assert str((-ball).arb) == str(np.negative(ball).arb)


@precisely()
def test_a_part_that_its_ball_decides_is_looked_at_once(monkeypatch):
    """A large cam under a wide limit: no ball reaches it, so that none is looked at in its middle as well."""
    scene = find_scene("roller-1000rpm").replace(**{"cam.base_radius": 1000, "limits": {"pressure_angle": 80}})
    problem, looked, over = resolve(scene), [], Largest._over
    monkeypatch.setattr(Largest, "_over", lambda *where: looked.append(where) or over(*where))
    monkeypatch.delattr(TurnPart, "in_middle")
    limit = next(limit for limit in problem.limits if limit.name == "pressure_angle")
    motion, design = exact_motion(problem.programme), in_balls(problem.design)
    for constraint in limit.constraints:
        looked.clear()
        assert constraint_verdict(problem, constraint, design, motion) == "held"
        parts = [part for side in sides_of(constraint, design, motion) for _, part in side.parts(motion)]
        assert 0 < len(looked) == sum(len(part.first) for part in parts)


@precisely()
@given(low=st.floats(-1.0, 0.0), high=st.floats(0.0, 1.0), share=st.floats(0.0, 1.0))
def test_the_root_of_a_ball_that_reaches_below_zero_encloses_that_of_the_rest(low, high, share):
    ball = ball_between(arb(low), arb(high))
    root = np.sqrt(Ball(ball)).arb
    assert root.contains((share * arb(high)).sqrt().mid())
    assert root.upper() <= ball.upper().sqrt() * 1.000001


@precisely()
def test_a_number_below_zero_has_no_root():
    assert np.sqrt(Ball(ball_between(arb(-2), arb(-1)))).arb.is_nan()


def test_a_pitch_point_almost_at_rest_takes_no_longer_to_prove(monkeypatch):
    """A knife edge on an arm that starts almost at the cam's centre: √(w² + s²) of balls that reach below 0."""
    monkeypatch.setattr("support.balls.deciding.DECIDING_PARTS", 100)
    arm = {"motion": "oscillating", "contact": "knife", "arm_length": 90, "centre_distance": 90}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 1e-5, "rpm": 500},
            "follower": arm,
            "motion": [
                {"segment": "rise", "angle": 180, "lift": 17, "law": "cycloidal"},
                {"segment": "return", "angle": 180, "lift": 17, "law": "harmonic"},
            ],
            "limits": {"sliding_speed": 4},
        }
    )
    assert certify(scene)["sliding_speed"] == "held"


@pytest.fixture
def table(tmp_path):
    scene = find_scene("roller-1000rpm").replace(
        **{"search.base_radius": [60, 80, 100], "search.offset": [0, 10], "search.law": ["harmonic", "cycloidal"]}
    )
    sweep(scene, tmp_path, keep="all")
    return tmp_path / "designs.parquet"


@pytest.mark.slow
def test_each_row_of_a_table_is_certified(table, capsys):
    counts = certify_table(table)
    rows = camopt.load(table)
    assert counts["undecided"] == 0
    assert ((rows["proof"] == "held") == rows["feasible"]).all()
    assert counts["held"] == rows["feasible"].sum() > 0
    assert rows.attrs["units"]["base_radius_mm"] == "mm"
    assert main(["certify", str(table), "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == {
        "held": counts["held"],
        "broken": counts["broken"],
        "undecided": 0,
    }
    assert list(camopt.load(table).columns).count("proof") == 1


def test_what_is_no_table_of_a_sweep_is_told(tmp_path):
    plain = tmp_path / "plain.parquet"
    pq.write_table(pa.table({"a": [1]}), plain)
    (tmp_path / "text.parquet").write_text("no table", encoding="utf-8")
    for name in ("plain.parquet", "text.parquet"):
        with pytest.raises(BadInput, match="a Parquet table that camopt wrote"):
            certify_table(tmp_path / name)
    with pytest.raises(FileNotFoundError, match="No such file"):
        certify_table(tmp_path / "missing.parquet")


def test_the_command_proves_a_scene(capsys):
    assert main(["certify", "two-pauses", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out).values()) == {"held"}
    assert main(["certify", "roller-1000rpm"]) == 1
    assert "broken" in capsys.readouterr().out


def test_limits_on_the_command_line_are_proved(tmp_path, capsys):
    assert main(["certify", "two-pauses", "--json", "--max-pressure", "30"]) == 1
    assert json.loads(capsys.readouterr().out)["pressure_angle_return"] == "broken"
    assert main(["certify", "two-pauses", "--max-pressure", "45"]) == 0
    assert main(["certify", str(tmp_path / "pareto.parquet"), "--max-pressure", "30"]) == 2
    assert "--max-pressure = 30.0: cannot be used with a table" in capsys.readouterr().err


def test_a_sweep_counts_what_its_verdicts_took():
    scene = find_scene("roller-1000rpm").replace(**{"limits.pressure_angle": 30.0, "search": {"law": ["poly345"]}})
    best = optimise(scene).best["base_radius_mm"]
    near = [best * (1.0 + k * 5e-15) for k in range(-20, 21)]
    effort = sweep(scene.replace(**{"search.base_radius": near})).effort
    assert 0 < effort.intervals <= effort.again <= len(near)
    assert 0 < effort.undecided <= effort.intervals  # those at the limit itself


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CONTACTS)
def test_a_limit_that_a_corner_makes_infinite_is_broken_there(contact):
    """At a jump of y' a force is infinite, and a speed is not: what is refused without a look at any design."""
    dynamics = None if CONTACTS[contact]["motion"] == "oscillating" else GUIDED
    scene = Scene.from_dict(cam_with(contact, "uniform", dynamics, materials=WORN))
    cam, refused = evaluate(scene), []
    for name, quantity in LOAD_LIMITS.items():
        if quantity in cam:
            lax = scene.replace(limits={name: 1e9 if QUANTITIES[quantity].limit_sign > 0.0 else 1e-9})
            (limit,) = (each for each in resolve(lax).limits if each.name == name)
            if limit.is_infinite_on_motion(resolve(lax).programme):
                refused.append(name)
                assert name in evaluate(lax)["violated"], name
    assert refused


@pytest.mark.parametrize("share", [1.0 + 1e-9, 1.0 - 1e-9])
def test_a_mean_is_decided_over_a_box_of_nothing(share):
    """The length of a groove, of a cam within tolerances that are none of its own: that ended in an IndexError."""
    scene = find_scene("barrel-traverse").replace(limits=None)
    length = evaluate(scene.replace(outputs=["groove_length_mm"]))["groove_length_mm"]
    problem = with_rounding_relative_error(resolve(scene.replace(limits={"groove_length_mm": length * share})))
    (limit,) = (each for each in problem.limits if each.name == "groove_length_mm")
    assert limit_verdict_over_box(problem, limit, problem.design, {}).verdict == (
        "held" if share > 1.0 else "broken"
    )

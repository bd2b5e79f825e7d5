"""Motions through trains: by the forward formulas, in balls, beside other scenes, and next to their limits."""

import re

import numpy as np
import pytest
from flint import arb
from support.balls.motion import exact_motion, motion_at
from support.cams import CONTACTS, cam_with, turn_of
from support.trains import random_train

import camopt
from camopt import Scene, evaluate
from camopt.core.mistakes import BadInput
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.panels import value_and_three_derivatives
from camopt.core.numerics.taylor import Taylor
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion import LAWS
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment
from camopt.model.motion.tool_drive import follower_programme
from camopt.scene.problem.problem import resolve, resolve_design
from camopt.solve.verdicts.certify import certify_limits

NEAR = 1e-9
RIGHT = 1e-12  # of the largest value in the turn
SHIPPED = ("valve-with-rocker", "slide-by-bell-crank")
BELL_CRANK = {"stage": "bell-crank", "crank": 90, "coupler": 180, "offset": -70, "angle": -110}
ROCKER = {"stage": "rocker", "input_arm": 40, "input_angle": -10, "output_arm": 55, "output_angle": -25}
FOUR_BAR = {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70}
TRAINS = {"translating": [ROCKER], "oscillating": [FOUR_BAR]}


def random_turn(seed, law):
    """A tool through a random train, and its follower."""
    rng = np.random.default_rng(seed)
    _, train, _ = random_train(rng)
    low, high = (float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends)
    start, end = low + (high - low) * np.sort(rng.uniform(0.15, 0.85, 2))
    lift = (end - start) * (180 / np.pi if train.angular else 1.0)
    turn = [MotionSegment("rise", 110.0, lift, law), MotionSegment("dwell", 40.0)]
    turn += [MotionSegment("return", 90.0, lift, law), MotionSegment("dwell", 120.0)]
    tool = Programme.from_segments(turn, angular=train.angular, laws=LAWS)
    return follower_programme(tool, train, start), train, start


@pytest.mark.parametrize("law", ["cycloidal", "poly4567", "modified-sine"])
@pytest.mark.parametrize("seed", range(12))
def test_the_tool_goes_where_it_is_asked(seed, law):
    """The state of the follower, through the train, is that of the tool: from the laws, and from the table."""
    turn, train, zero = random_turn(seed, law)
    base = float(train.follower_displacement(Taylor([zero])).terms[0]) - turn.strokes[0].low
    rng = np.random.default_rng(seed)
    panels, u = rng.integers(turn.table.centre.size, size=60), rng.uniform(-1.0, 1.0, 60)
    angles = turn.table.centre[panels] + u * turn.table.half_width[panels]
    tabulated = np.stack(value_and_three_derivatives(turn.table, panels, u))
    asked = turn.tool.motion_at(angles) + np.array([zero, 0.0, 0.0, 0.0])[:, None]
    scale = np.abs(asked).max(axis=1)
    for y, y1, y2, y3 in (turn.motion_at(angles), tabulated):
        tool = train.tool_displacement(Taylor([base + y, y1, y2 / 2, y3 / 6]))
        for order in range(4):
            assert tool.derivative(order) == pytest.approx(asked[order], abs=1e-10 * scale[order])


@pytest.mark.parametrize("seed", range(6))
def test_the_table_is_that_of_balls(seed):
    turn, _, _ = random_turn(100 + seed, "poly4567")
    turn = turn.reversed_programme if seed % 2 else turn  # as that of a second disc of a pair
    exact, rng = exact_motion(turn), np.random.default_rng(seed)
    largest = np.abs(turn.table.nodes).max(axis=0)
    for panel in rng.integers(turn.table.centre.size, size=40):
        u = float(rng.uniform(-1.0, 1.0))
        angle = float(turn.table.centre[panel] + u * turn.table.half_width[panel])
        number = next(k for k, stroke in enumerate(turn.strokes) if stroke.start <= angle <= stroke.end)
        stroke = exact.strokes[number]
        centre, half = (arb(float(x[panel])) for x in (turn.table.centre, turn.table.half_width))
        x = (centre + u * half - arb(turn.strokes[number].start)) / stroke.angle
        piece = next((each for each in stroke.pieces if each.start <= x <= each.end), None)
        found, known = value_and_three_derivatives(turn.table, panel, u), motion_at(stroke, piece, x)
        for order in range(4):
            assert found[order] == pytest.approx(float(known[order].arb), abs=RIGHT * largest[order])


@pytest.mark.parametrize("contact", CONTACTS)
def test_a_train_of_ratio_two_is_a_follower_with_half_the_lift(contact):
    """The cam, its pressure angle and its loads are those of the follower; the motion is the tool's."""
    lift = 14 if CONTACTS[contact]["motion"] == "oscillating" else 24
    turn = turn_of("poly4567", lift)
    plain = evaluate(Scene.from_dict({**cam_with(contact), "motion": turn_of("poly4567", lift / 2)}))
    train = [{"stage": "ratio", "ratio": 2.0}]
    through = evaluate(Scene.from_dict({**cam_with(contact), "motion": turn, "train": train}))
    own = {name: value for name, value in plain.items() if isinstance(value, float) and name in {*through}}
    asked = ("velocity", "acceleration", "jerk", "lift_", "overshoot", "residual")
    assert len(own) > 40
    for name, value in own.items():
        twice = 2.0 if name.startswith(asked) and "follower" not in name else 1.0
        if name != "relative_half_width":
            assert through[name] == pytest.approx(twice * value, rel=1e-9, abs=1e-9), name
    for name in ("velocity_max", "acceleration_max", "jerk_max"):
        key = next(each for each in through if each.startswith(f"{name}_follower"))
        assert 2.0 * through[key] == pytest.approx(through[key.replace("_follower", "")], rel=1e-12)


def test_a_train_that_turns_the_motion_round_makes_returns_of_rises():
    scene = Scene.from_dict({**cam_with("roller"), "train": [{"stage": "ratio", "ratio": -1.0}]})
    programme = resolve(scene).programme
    assert [stroke.kind for stroke in programme.strokes] == [2, 4, 1, 4]
    assert programme.strokes[1].low == 0.0
    assert programme.lift == pytest.approx(24.0, rel=1e-15)


def scene_of(contact, **limits):
    train = TRAINS[CONTACTS[contact]["motion"]]
    return Scene.from_dict(
        {**cam_with(contact, "poly4567"), "train": train, "outputs": ["motion"], "limits": limits}
    )


LIMITS = ("acceleration", "jerk", "pressure_angle", "curvature_radius", "velocity_max_follower")


def reached_value(contact, key):
    cam = evaluate(scene_of(contact))
    names = {"acceleration": "acceleration_max_m", "jerk": "jerk_max_m", "pressure_angle": "pressure_angle_max_deg"}
    names |= {"curvature_radius": "profile_radius_min_mm"}
    if CONTACTS[contact]["motion"] == "oscillating":
        names |= {"acceleration": "acceleration_max_rad", "jerk": "jerk_max_rad"}
    name = next((each for each in cam if each.startswith(names.get(key, key))), None)
    return name, None if name is None else cam[name]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("key", LIMITS)
def test_limits_through_a_train_are_decided_next_to_their_bounds(contact, key):
    name, value = reached_value(contact, key)
    if name is None or not np.isfinite(value) or value <= 0.0:
        pytest.skip("this mechanism has none, or no finite one")
    for share in (1.0 + NEAR, 1.0 - NEAR):
        asked = key if key in LIMIT_KEYS else name
        scene = scene_of(contact, **{asked: value * share})
        holds = (share > 1.0) != (key == "curvature_radius")
        problem = resolve_design(scene)
        verdicts = certify_limits(problem, problem.design)
        assert {verdict for limit, verdict in verdicts.items() if limit.startswith(asked)} <= {"held", "broken"}
        assert (verdicts[asked] == "held") == holds or asked == "pressure_angle"
        assert any(each.startswith(asked) for each in evaluate(scene)["violated"].split(",")) != holds


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scene_is_swept_as_it_is_evaluated_and_proved(name, tmp_path):
    scene = camopt.find_scene(name).replace(**{"search.base_radius.step": 8})
    camopt.sweep(scene, out=tmp_path, keep="all", workers=1)
    designs = camopt.load(tmp_path / "designs.parquet")
    assert len(designs) > 12
    assert {*designs["feasible"]} == {True, False}
    for row in range(0, len(designs), len(designs) // 6):
        one = camopt.scene_of(designs, row)
        cam, proved = evaluate(one), camopt.certify(one)
        assert cam["pressure_angle_max_rise_deg"] == pytest.approx(
            designs["pressure_angle_max_rise_deg"][row], rel=1e-9
        )
        assert designs["feasible"][row] == cam["feasible"] == ({*proved.values()} == {"held"})


DEAD = {
    "beyond a dead point": ([BELL_CRANK], {"motion.1.lift": 200, "motion.3.lift": 200}, "train.1", "dead point"),
    "no assembly": ([{**FOUR_BAR, "coupler": 10}], {}, "train.1", "do not meet"),
    "a length for a four-bar": ([{"stage": "ratio", "radius": 20}, FOUR_BAR], {}, "train.2", "length"),
    "an unknown stage": ([{"stage": "gears"}], {}, "train.1.stage", "one of"),
    "no such key": ([{**FOUR_BAR, "pivot": 3}], {}, "train.1.pivot", "not a known key"),
    "a key of another stage": ([{**FOUR_BAR, "radius": 3}], {}, "train.1", "has no radius"),
    "a negative length": ([{**FOUR_BAR, "crank": -3}], {}, "train.1.crank", "at least"),
    "a text": ([{**FOUR_BAR, "crank": "long"}], {}, "train.1.crank", "a number"),
}


@pytest.mark.parametrize(("train", "changes", "key", "words"), DEAD.values(), ids=DEAD)
def test_a_bad_train_is_told_in_one_line(train, changes, key, words):
    with pytest.raises(BadInput) as told:
        Scene.from_dict({**cam_with("arm"), "train": train}).replace(**changes)
    (mistake,) = told.value.mistakes
    assert mistake.key == key
    assert words in str(mistake)
    assert "\n" not in str(mistake)


def test_a_dead_point_is_told_with_the_cam_angle_where_the_tool_comes_to_it():
    scene = {**cam_with("arm"), "train": [BELL_CRANK], "motion": turn_of("uniform", 200.0, (100, 40, 100, 120))}
    with pytest.raises(BadInput) as told:
        Scene.from_dict(scene)
    (mistake,) = told.value.mistakes
    limit, at = map(
        float, re.search(r"dead point is at ([\d.]+) mm \(cam angle ([\d.]+) deg\)", str(mistake)).groups()
    )
    assert at == pytest.approx(limit / 200.0 * 100.0, abs=0.11)


def test_positions_count_from_the_start_position_of_the_train():
    """A turn between 10 and 40 mm of the slide, whose train is given at 0."""
    turn = [
        {"segment": "rise", "angle": 120, "to": 40, "law": "cycloidal"},
        {"segment": "return", "angle": 240, "to": 10, "law": "cycloidal"},
    ]
    problem = resolve(Scene.from_dict({**cam_with("arm"), "motion": turn, "train": [BELL_CRANK]}))
    train = problem.setup.train
    low, high = (float(train.follower_displacement(Taylor([each])).terms[0]) for each in (10.0, 40.0))
    assert problem.programme.lift == pytest.approx(high - low, rel=1e-13)


def test_points_and_text_units_are_those_of_the_tool():
    scene = Scene.from_dict({**cam_with("arm"), "motion": turn_of("cycloidal", 14), "train": [BELL_CRANK]})
    points = camopt.cam_points(scene, [0.0, 110.0])
    assert points["tool_displacement_mm"] == pytest.approx([0.0, 14.0])
    assert "displacement_deg" in points
    turn = [{**each, "lift": "1.4 cm"} if "lift" in each else each for each in turn_of("cycloidal", 14)]
    assert Scene.from_dict({**cam_with("arm"), "motion": turn, "train": [BELL_CRANK]}).motion[0].lift == 14.0


def test_rises_of_the_pressure_angle_are_those_of_the_follower_and_tables_say_so():
    """With a ratio below 0 the follower rises where the tool returns; by points of the turn."""
    scene = camopt.find_scene("pusher-by-lever").replace(
        **{"train.1.ratio": -1.73, "limits": {}, "motion.1.angle": 87, "motion.2.angle": 53}
    )
    found, problem, angles = evaluate(scene), resolve_design(scene), np.linspace(0.0, 2.0 * np.pi, 7201)
    motion, setup = problem.programme, problem.setup
    slant = np.arctan(value_and_slope(setup.mechanism.pressure(problem.design, motion), 0, motion.state(angles))[0])
    follower, tool = motion.motion_at(angles)[1], motion.tool.motion_at(angles)[1]
    for kind, side in (("rise", 1.0), ("return", -1.0)):
        steepest, fastest = np.abs(slant[side * follower > 1e-6]).max(), np.abs(tool[side * tool > 1e-6]).max()
        assert found[f"pressure_angle_max_{kind}_deg"] == pytest.approx(np.degrees(steepest), rel=1e-5)
        assert found[f"velocity_max_{kind}_m_s"] == pytest.approx(fastest * motion_unit_factor(setup, 1), rel=1e-5)
    rows = {row[0].text: row[-1].text for row in found.table().rows}
    for kind in ("rise", "return"):
        angle, velocity = rows[f"pressure_angle_max_{kind}_deg"], rows[f"velocity_max_{kind}_m_s"]
        assert angle == f"Largest pressure angle |β| over the {kind}s of the follower."
        assert velocity == f"Largest |velocity| over the {kind}s; with a train, of the tool."


@pytest.mark.parametrize("name", SHIPPED)
def test_the_smallest_cam_is_that_of_a_dense_scan(name):
    scene = camopt.find_scene(name)
    radius = float(scene.follower.roller_radius)
    law = scene.motion[0].law
    scene = scene.replace(search={"base_radius": {"start": 5.0, "stop": 120.0, "step": 1.0}, "law": [law]})
    best = camopt.optimise(scene).best["base_radius_mm"]
    assert radius > 0.0
    for size, holds in ((best * (1 + 1e-6), True), (best * (1 - 1e-6), False)):
        assert evaluate(scene.replace(**{"cam.base_radius": size, "search": None}))["feasible"] == holds

"""Loads through trains: against Lagrange's equation from closed loops, energies, and scenes without a train."""

import mpmath
import numpy as np
import pytest
from flint import arb
from mpmath import mpf
from support.balls.motion import exact_motion, motion_at
from support.cams import CONTACTS, SWUNG, UNGUIDED, cam_with, turn_of
from support.trains import LOOPS, arm_angle, drawn_loads, exact, random_train

import camopt
from camopt import Scene, certify, evaluate
from camopt.core.mistakes import BadInput
from camopt.core.numerics.panels import value_and_three_derivatives
from camopt.core.numerics.taylor import Taylor
from camopt.model.motion.load import TrainLoad
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.carried_load import sum_follower_load
from camopt.scene.problem.problem import resolve

LAGRANGE = 1e-9  # of the sum of magnitudes
TOOL = {"mass": 0.4, "spring_rate": 12.0, "preload": 60.0, "gravity": 9.81}


def places(stages, angular, y):
    """Positions of the joints from closed loops, with the numbers of the joints."""
    found, turns, joint, x = [], angular, 0, y
    for name, keys in stages:
        if name in ("rocker", "bell-crank") and not turns:
            joint += 1
            found.append((joint, arm_angle(keys, turns, x)))
        x = LOOPS[name](keys, turns, x)
        joint += 1
        found.append((joint, x))
        turns = TRAIN_STAGES[name].turns(keys, turns)
    return found


@pytest.mark.one_in(5)
@pytest.mark.parametrize("seed", range(100))
def test_the_force_at_the_follower_is_that_of_lagrange(seed):
    """F = m(y)·ÿ + m'(y)·ẏ²/2 + Σ Q·ds/dy, m(y) = Σ m·(ds/dy)², of joints found by root finding at 50 digits."""
    rng = np.random.default_rng(seed)
    stages, train, angular = random_train(rng)
    low, high = (float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends)
    y = float(train.follower_displacement(Taylor([low + (high - low) * rng.uniform(0.2, 0.8)])).terms[0])
    y1, y2 = rng.uniform(-3, 3, 2)
    way = float(np.sign(y1))
    carried, load = drawn_loads(rng, len(train.links))
    joints = train.joint_motions(Taylor([y, y1, y2 / 2, 0.0]))
    ours = sum_follower_load(joints, carried, [way * sense for sense in train.joint_motion_signs], load)
    with mpmath.workdps(50):
        step = mpf(10) ** -14
        beside = [places(stages, angular, mpf(y) + k * step) for k in (-1, 0, 1)]
        still = inertia = size = mpf(0)
        for (joint, before), (_, here), (_, after) in zip(*beside, strict=True):
            ratio, bend = (after - before) / (2 * step), (after - 2 * here + before) / step**2
            each = carried[joint - 1]
            force = each.force + each.stiffness * here + each.friction * way * mpmath.sign(ratio)
            force += load[joint].terms[0] if joint in load else 0
            still += force * ratio
            inertia += each.mass * (ratio**2 * y2 + ratio * bend * y1**2)
            size += abs(force * ratio) + each.mass * (abs(ratio**2 * y2) + abs(ratio * bend) * y1**2)
    assert float(abs(ours.still.terms[0] - still)) <= LAGRANGE * float(size)
    assert float(abs(ours.carried.terms[0] - inertia)) <= LAGRANGE * float(size)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", range(40))
def test_ratios_are_slopes_of_closed_loops(seed):
    """With all derivatives: the series of each ratio is that of the slope of its joint's motion."""
    rng = np.random.default_rng(500 + seed)
    stages, train, angular = random_train(rng)
    low, high = (float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends)
    y = float(train.follower_displacement(Taylor([low + (high - low) * rng.uniform(0.2, 0.8)])).terms[0])
    ratio = train.joint_motions(Taylor([y, 1.0, 0.0, 0.0]))[-1].ratio
    with mpmath.workdps(50):
        terms = mpmath.taylor(lambda x: exact(stages, angular, x), mpf(y), 4)
    slopes = [(k + 1) * float(terms[k + 1]) for k in range(4)]
    assert ratio.terms == pytest.approx(slopes, abs=1e-10 * max(map(abs, slopes)))


# ---------------------------------------------------------------------------------------------- whole scenes


OF_LOADS = ["force", "torque", "thrust", "hertz"]


def own_dynamics(contact):
    return SWUNG if CONTACTS[contact]["motion"] == "oscillating" else UNGUIDED


def scene_through_stage(contact, stage, *, law="poly4567", lift=None, **more):
    turns = CONTACTS[contact]["motion"] == "oscillating"
    lift = lift or (14 if turns else 20)
    made = {**cam_with(contact, dynamics=own_dynamics(contact)), "motion": turn_of(law, lift), "train": stage}
    return Scene.from_dict({**made, "outputs": OF_LOADS, **more})


ROCKER = {"stage": "rocker", "input_arm": 40, "input_angle": -10, "output_arm": 55, "output_angle": -25}
FOUR_BAR = {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70}
SLIDE = {"stage": "bell-crank", "crank": 90, "coupler": 180, "offset": -70, "angle": -110}


@pytest.mark.slow
@pytest.mark.one_in(5)
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("ratio", [2.0, 0.5])
def test_a_constant_ratio_is_a_scene_with_what_it_reflects(contact, ratio):
    """Mass, spring and forces on the other side of a ratio i are i²·m, i²·k and i·F at the follower."""
    turns = CONTACTS[contact]["motion"] == "oscillating"
    mass = {"inertia": 4e-3} if turns else {"mass": 0.5}
    tool = {**mass, "spring_rate": 9.0, "preload": 30.0, "load": 12.0}
    own = own_dynamics(contact)
    heavy = "inertia" if turns else "mass"
    reflected = {
        **own,
        heavy: own[heavy] + ratio**2 * mass[heavy],
        "spring_rate": own["spring_rate"] + ratio**2 * tool["spring_rate"],
        "preload": own["preload"] + ratio * (tool["preload"] + tool["load"]),
        **({} if turns else {"gravity": 0.0}),
    }
    lift = 14 if turns else 20
    scene = scene_through_stage(contact, [{"stage": "ratio", "ratio": ratio, **tool}], lift=lift)
    ours = evaluate(scene if turns else scene.replace(**{"follower.dynamics.gravity": 0.0}))
    plain = {**cam_with(contact, dynamics=reflected), "motion": turn_of("poly4567", lift / ratio)}
    theirs = evaluate(Scene.from_dict({**plain, "outputs": OF_LOADS}))
    names = [name for name, value in theirs.items() if isinstance(value, float) and "required" not in name]
    assert len(names) > 12
    for name in names:
        if name != "relative_half_width":
            scale = abs(theirs["torque_peak_N_m"]) if "torque" in name else 1.0
            assert ours[name] == pytest.approx(theirs[name], rel=1e-10, abs=1e-10 * scale), name


SCENES = {
    "a rocker": ("roller", [{**ROCKER, "arm_inertia": 4e-4, **TOOL}]),
    "a slide": ("arm", [{**SLIDE, **TOOL}]),
    "a four-bar": ("arm", [{**FOUR_BAR, "inertia": 3e-3, "preload": 4.0, "spring_rate": 6.0}]),
    "two stages": ("flat", [{**ROCKER, "mass": 0.2}, {"stage": "incline", "angle": 30, **TOOL}]),
    "a slide with a load": ("roller", [{**ROCKER, **TOOL, "load": [[20, 0], [90, 150], [200, 20]]}]),
    "a rubbing slide": ("roller", [{**ROCKER, **TOOL, "friction_force": 25.0}]),
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("contact", "train"), SCENES.values(), ids=SCENES)
def test_the_force_is_that_of_energies_at_the_tool(contact, train):
    """F·y' is the rate of the energies of follower and tools by the cam angle, found by differences."""
    scene = scene_through_stage(contact, train)
    problem = resolve(scene)
    programme, dynamics, omega = problem.programme, problem.setup.dynamics, problem.setup.omega
    theta = np.linspace(0.0, 2 * np.pi, 3601)[:-1] + 1e-3
    step = 1e-3
    offsets = np.array([-2, -1, 0, 1, 2])[:, None] * step
    y, y1, _, _ = programme.motion_at(theta + offsets)
    train_, load = problem.setup.train, programme.load
    assert isinstance(load, TrainLoad)
    zero = load.zero
    energy = 0.5 * dynamics.mass * (omega * y1) ** 2 + 0.5 * dynamics.stiffness * y**2
    energy += (dynamics.preload + dynamics.load) * y
    spent = dynamics.damping * omega * y1[2] ** 2
    places_ = [joint.displacement for joint in train_.joint_motions(Taylor([y + zero, y1]))]
    for each in train_.carried:
        moved = places_[each.joint]
        energy += 0.5 * each.mass * (omega * moved.terms[1]) ** 2
        energy += 0.5 * each.stiffness * moved.terms[0] ** 2 + each.force * moved.terms[0]
        spent = spent + each.friction * np.abs(moved.terms[1][2])
    for joint, changing in load.loads:
        spent = spent + changing.load_and_slope(theta)[0] * places_[joint].terms[1][2]
    rate = (energy[0] - 8 * energy[1] + 8 * energy[3] - energy[4]) / (12 * step)
    state = programme.state(theta)
    force = dynamics.mass * omega**2 * state.y2 + dynamics.damping * omega * state.y1 + dynamics.stiffness * state.y
    force += dynamics.preload + dynamics.load + state.load.value + omega**2 * state.load.carried
    moving = np.abs(y1[2]) > 1e-3 * np.abs(y1).max()
    torque, ours = (rate + spent)[moving], (force * y1[2])[moving]
    assert ours == pytest.approx(torque, abs=2e-8 * np.abs(torque).max())
    found = evaluate(scene)
    lever = float(problem.design.arm_length[0]) if problem.setup.angular else 1.0
    sampled = force / lever
    assert found["contact_force_max_N"] >= sampled.max() * (1 - 1e-12)
    assert found["contact_force_max_N"] == pytest.approx(sampled.max(), rel=1e-4)
    assert found["contact_force_min_N"] <= sampled.min() + 1e-12 * sampled.max()
    assert found["contact_force_min_N"] == pytest.approx(sampled.min(), abs=1e-4 * sampled.max())
    assert found["torque_max_N_m"] * 1e3 == pytest.approx(ours.max(), rel=1e-4)


@pytest.mark.parametrize(("contact", "train"), SCENES.values(), ids=SCENES)
def test_over_a_turn_the_torque_does_the_work_of_what_is_not_returned(contact, train):
    scene = scene_through_stage(contact, train)
    problem = resolve(scene)
    programme, load = problem.programme, problem.programme.load
    theta, weight = np.polynomial.legendre.leggauss(40)
    edges = np.linspace(0, 2 * np.pi, 1441)
    middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1] - edges[0]) / 2
    angles = (middle[:, None] + half * theta).ravel()
    weights = np.tile(half * weight, middle.size)
    y, y1, _, _ = programme.motion_at(angles)
    spent = np.sum(weights * problem.setup.dynamics.damping * problem.setup.omega * y1**2)
    joints = [joint.displacement for joint in problem.setup.train.joint_motions(Taylor([y + load.zero, y1]))]
    for each in problem.setup.train.carried:
        spent += each.friction * np.sum(weights * np.abs(joints[each.joint].terms[1]))
    for joint, changing in load.loads:
        spent += np.sum(weights * changing.load_and_slope(angles)[0] * joints[joint].terms[1])
    found = evaluate(scene)
    assert found["torque_mean_N_m"] * 2e3 * np.pi == pytest.approx(
        spent, rel=1e-9, abs=1e-10 * found["torque_peak_N_m"] * 2e3 * np.pi
    )
    if "rubbing" in str(train) or "friction_force" in train[0]:
        friction = 2 * 25.0 * 20.0  # out and back by the tool
        damped = np.sum(weights * problem.setup.dynamics.damping * problem.setup.omega * y1**2)
        assert spent == pytest.approx(friction + damped, rel=1e-9)


@pytest.mark.parametrize(("contact", "train"), SCENES.values(), ids=SCENES)
def test_the_table_of_a_load_is_that_of_balls(contact, train):
    """Within its own errors, for a law that keeps its digits at both ends."""
    programme = resolve(scene_through_stage(contact, train, law="cycloidal")).programme
    turn, rng = exact_motion(programme), np.random.default_rng(1)
    table = programme.table
    scales = [np.abs(force.nodes[:, :2]).max(axis=0) for force in table.load]
    for panel in rng.integers(table.centre.size, size=60):
        u = float(rng.uniform(-0.98, 0.98))
        angle = float(table.centre[panel] + u * table.half_width[panel])
        number = next(k for k, stroke in enumerate(programme.strokes) if stroke.start <= angle <= stroke.end)
        stroke = turn.strokes[number]
        centre, half = (arb(float(each[panel])) for each in (table.centre, table.half_width))
        x = (centre + u * half - arb(programme.strokes[number].start)) / stroke.angle
        piece, line, _, _ = next(part for part in stroke.smooth() if part[2] <= x <= part[3])
        known = [float(ball.arb) for ball in motion_at(stroke, piece, x, line)[5:]]
        for k, force in enumerate(table.load):
            found = value_and_three_derivatives(force, panel, u)
            for order in (0, 1):
                off = abs(found[order] - known[2 * k + order])
                assert off <= force.error[panel, order] + 1e-30
                assert off <= 1e-12 * max(scales[k][order], 1e-30)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("key", ["contact_force_min", "normal_force", "torque", "power", "contact_stress"])
@pytest.mark.parametrize("name", ["a rocker", "a slide", "a slide with a load"])
def test_limits_on_loads_through_a_train_are_decided_next_to_their_bounds(name, key):
    contact, train = SCENES[name]
    quantity = {
        "contact_force_min": "contact_force_min_N",
        "normal_force": "normal_force_max_N",
        "torque": "torque_peak_N_m",
        "power": "power_peak_W",
        "contact_stress": "contact_stress_max_MPa",
    }[key]
    value = evaluate(scene_through_stage(contact, train))[quantity]
    assert value > 0.0
    for share in (1.0 + 1e-9, 1.0 - 1e-9):
        scene = scene_through_stage(contact, train, limits={key: value * share})
        holds = (share > 1.0) != (key == "contact_force_min")
        assert certify(scene)[key] == ("held" if holds else "broken")
        assert (key in evaluate(scene)["violated"].split(",")) != holds


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["a rocker", "a rubbing slide", "a slide with a load"])
@pytest.mark.parametrize("quantity", ["torque_rms_N_m", "torque_mean_N_m"])
def test_means_through_a_train_are_decided_next_to_their_bounds(name, quantity):
    contact, train = SCENES[name]
    value = evaluate(scene_through_stage(contact, train))[quantity]
    for share in (1.0 + 1e-8, 1.0 - 1e-8):
        scene = scene_through_stage(contact, train, limits={quantity: value * share})
        assert certify(scene)[quantity] == ("held" if share > 1.0 else "broken")


def test_at_its_jump_speed_a_train_loses_contact():
    contact, train = SCENES["a rocker"]
    speed = evaluate(scene_through_stage(contact, train))["jump_speed_rpm"]
    at_jump = evaluate(scene_through_stage(contact, train).replace(**{"cam.rpm": speed}))
    assert at_jump["contact_force_min_N"] == pytest.approx(0.0, abs=1e-9 * at_jump["contact_force_max_N"])


def test_the_spring_that_keeps_contact_is_just_enough():
    contact, train = SCENES["a rocker"]
    fast = scene_through_stage(contact, train).replace(
        **{"cam.rpm": 3 * evaluate(scene_through_stage(contact, train))["jump_speed_rpm"]}
    )
    rate = evaluate(fast)["spring_rate_required_N_per_mm"]
    found = evaluate(fast.replace(**{"follower.dynamics.spring_rate": rate}))
    assert found["contact_force_min_N"] == pytest.approx(0.0, abs=1e-9 * found["contact_force_max_N"])


def test_searched_speeds_are_those_of_scenes_of_their_own(tmp_path):
    contact, train = SCENES["a rocker"]
    search = {"cam": {"rpm": [200.0, 420.0, 700.0]}, "base_radius": [40.0, 50.0]}
    scene = scene_through_stage(contact, train, search=search, limits={"normal_force": 900.0})
    camopt.sweep(scene, out=tmp_path, keep="all", workers=1)
    designs = camopt.load(tmp_path / "designs.parquet")
    assert len(designs) == 6
    for row in range(len(designs)):
        alone = evaluate(camopt.scene_of(designs, row))
        for name in ("normal_force_max_N", "contact_force_min_N", "torque_peak_N_m", "jump_speed_rpm"):
            assert designs[name][row] == pytest.approx(alone[name], rel=1e-9)
    best = camopt.optimise(scene).best
    assert best["feasible"]


def test_velocities_that_jump_leave_what_depends_on_energy_unknown():
    contact, train = SCENES["a rocker"]
    found = evaluate(scene_through_stage(contact, train, law="uniform"))
    assert [found[n] for n in ("torque_mean_N_m", "energy_fluctuation_J", "torque_max_N_m")] == [np.inf] * 3


BAD = {
    "a mass that turns": ([{**FOUR_BAR, "mass": 1.0}], "turns"),
    "an inertia that slides": ([{**SLIDE, "inertia": 1.0}], "slides"),
    "no arm": ([{**SLIDE, "arm_inertia": 1.0}], "input_arm"),
    "weight of nothing": ([{**SLIDE, "gravity": 9.81}], "mass"),
    "a load out of order": ([{**SLIDE, "load": [[20, 1.0], [10, 2.0]]}], "at least"),
    "a load from nowhere": ([{**SLIDE, "load": "nowhere.csv"}], "nowhere.csv"),
}


@pytest.mark.parametrize(("train", "words"), BAD.values(), ids=BAD)
def test_bad_loads_are_told_in_one_line(train, words):
    with pytest.raises(BadInput) as told:
        Scene.from_dict({**cam_with("arm"), "train": train})
    (mistake,) = told.value.mistakes
    assert mistake.key.startswith("train.1")
    assert words in str(mistake)


def test_texts_with_units_of_a_stage_are_those_of_what_it_moves():
    train = [{**FOUR_BAR, "preload": "4 N*m"}, {**SLIDE, "preload": "0.06 kN"}]
    scene = Scene.from_dict({**cam_with("arm"), "train": train})
    assert [stage.preload for stage in scene.train] == [4.0, 60.0]

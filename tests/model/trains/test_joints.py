"""Forces in joints: against free bodies solved at 50 digits, sampled turns, balls, and next to limits."""

import mpmath
import numpy as np
import pytest
from flint import arb
from mpmath import mpf
from support.balls.motion import exact_motion, motion_at
from support.cams import CONTACTS, SWUNG, UNGUIDED, cam_with, turn_of
from support.trains import LOOPS, arm_angle, drawn_loads, random_train, slide_at

import camopt
from camopt import Scene, certify, evaluate
from camopt.core.numerics.panels import value_and_three_derivatives
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.joints import largest_joint_force, programme_loaded_by_joint_force, setup_joint_forces
from camopt.model.motion.load import TrainLoad
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.four_bar import assemble_four_bar
from camopt.model.trains.train import Train
from camopt.scene.problem.problem import resolve

FREE_BODIES = 1e-9  # of the largest force
TOOL = {"mass": 0.4, "spring_rate": 12.0, "preload": 60.0, "gravity": 9.81}
ROCKER = {"stage": "rocker", "input_arm": 40, "input_angle": -10, "output_arm": 55, "output_angle": -25}
FOUR_BAR = {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70}
SLIDE = {"stage": "bell-crank", "crank": 90, "coupler": 180, "offset": -70, "angle": -110}


def moment(at, force):
    return at.real * force.imag - at.imag * force.real


def solve_equations(rows):
    """Solution of linear equations, each a list of factors and the right side."""
    return list(mpmath.lu_solve(mpmath.matrix([row[:-1] for row in rows]), [row[-1] for row in rows]))


def coupler_between(one, other, first, last):
    """Forces at both ends of a bar without mass, from its balance and one more equation, given as a row."""
    arm = other - one
    rows = [[1, 0, 1, 0, 0], [0, 1, 0, 1, 0], [0, 0, -arm.imag, arm.real, 0], [*first, last]]
    fx, fy, gx, gy = solve_equations(rows)
    at_one, at_other = mpmath.mpc(fx, fy), mpmath.mpc(gx, gy)
    pushed = (at_one.real * arm.real + at_one.imag * arm.imag) / abs(arm)
    return at_one, at_other, pushed


# What a stage has in its joints, and asks of what drives it, if it gives a force (moment) against what is beyond:
# names with forces (pins, guides), the forces on the pivots of its input and of its output, and what it asks.


def arm_lifts(length, angle, asked):
    """An arm that lifts a slide by a force on its face, square to the motion."""
    (force,) = solve_equations([[1, asked]])
    return {"roller": force}, force * length * mpmath.cos(angle)


def arm_is_lifted(length, angle, asked):
    """An arm whose moment comes from a force on its face."""
    (force,) = solve_equations([[length * mpmath.cos(angle), asked]])
    return {"roller": force}, force


def crank_and_slide(keys, phi, x, *, crank_asks=None, slide_asks=None):
    a, e = mpf(keys["crank"]), mpf(keys.get("offset", 0.0))
    pin, slide = a * mpmath.expj(phi), mpmath.mpc(x, e)
    if slide_asks is not None:  # the slide has −G from the coupler: −G_x is what it asks, and its guide gives G_y
        f, g, pushed = coupler_between(pin, slide, [0, 0, -1, 0], slide_asks)
        return pushed, g.imag, moment(pin, f)
    f, g, pushed = coupler_between(pin, slide, [pin.imag, -pin.real, 0, 0], crank_asks)  # pin × (−F) = moment
    return pushed, g.imag, g.real


def rocker_at(keys, phi):
    """The angle of the rocker with the crank at the start."""
    near = assemble_four_bar(
        *(keys[n] for n in ("crank", "coupler", "rocker", "ground", "angle")), crossed=keys["crossed"]
    )

    def gap(psi):
        return abs(keys["ground"] + keys["rocker"] * mpmath.expj(psi) - keys["crank"] * mpmath.expj(phi)) ** 2

    return mpmath.findroot(lambda psi: gap(psi) - mpf(keys["coupler"]) ** 2, near.rocker_start)


def four_bar_bodies(keys, phi, psi, asked):
    a, c, d = (mpf(keys[name]) for name in ("crank", "rocker", "ground"))
    pin, end = a * mpmath.expj(phi), c * mpmath.expj(psi)
    f, g, pushed = coupler_between(pin, d + end, [0, 0, end.imag, -end.real], asked)  # end × (−G) = moment
    assert abs(abs(f) - abs(g)) < 1e-40
    return pushed, moment(pin, f)


def lever_bodies(i, asked):
    """A bar from 0 to 1, lifted at 0, pressed down at 1, on a pivot at p: 1 − p is i·(0 − p)."""
    p = 1 / (1 - i)
    given, pivot = solve_equations([[1, 1, asked], [0, p, asked]])
    return given, pivot


def incline_bodies(keys, asked):
    slope, guide = (mpf(keys.get(k, 90.0)) * mpmath.pi / 180 for k in ("angle", "guide"))
    n, g = mpmath.mpc(mpmath.sin(slope), mpmath.cos(slope)), mpmath.expj(guide)
    side = -1j * g  # either side will do
    # on the slide: N·n + G·side = asked·g; on the wedge: P·1 + W·i = N·n
    rows = [[n.real, side.real, 0, 0, asked * g.real], [n.imag, side.imag, 0, 0, asked * g.imag]]
    rows += [[-n.real, 0, 1, 0, 0], [-n.imag, 0, 0, 1, 0]]
    face, on_slide, given, on_wedge = solve_equations(rows)
    return {"face": face, "guide of the wedge": on_wedge, "guide of the slide": on_slide}, given


def places_of(stages, angular, y):
    """Where each joint is, from closed loops."""
    found, turns, x = [y], angular, y
    for name, keys in stages:
        if name in ("rocker", "bell-crank") and not turns:
            found.append(arm_angle(keys, turns, x))
        x = LOOPS[name](keys, turns, x)
        found.append(x)
        turns = TRAIN_STAGES[name].turns(keys, turns)
    return found


def bodies(stages, angular, places, own):  # noqa: C901, PLR0915
    """Every force by (stage, kind of name), from the tool back; own[joint] is the load of the joint itself."""
    turns = [angular]
    for name, keys in stages:
        turns.append(TRAIN_STAGES[name].turns(keys, turns[-1]))
    joint, asked, found = len(places) - 1, own[-1], []
    pressed = {}  # forces on the pivot of a joint
    for number in range(len(stages), 0, -1):
        name, keys = stages[number - 1]
        given_turns = turns[number - 1]
        before = places[joint - 1]
        start = mpf(keys.get("angle", 0.0)) * mpmath.pi / 180
        if name in ("rocker", "bell-crank"):
            if name == "rocker":
                at = mpf(keys.get("output_angle", 0.0)) * mpmath.pi / 180 + before
                forces, given = arm_lifts(mpf(keys["output_arm"]), at, asked)
            else:
                x = slide_at(keys, start + before)
                pushed, guide, given = crank_and_slide(keys, start + before, x, slide_asks=asked)
                forces = {"coupler": pushed, "guide": guide}
            found += [(number, *each) for each in forces.items()]
            pressed.setdefault(joint - 1, []).append(next(iter(forces.values())))
            if not given_turns:
                joint -= 1
                asked = given + own[joint]
                at = mpf(keys.get("input_angle", 0.0)) * mpmath.pi / 180 + places[joint]
                forces, given = arm_is_lifted(mpf(keys["input_arm"]), at, asked)
                found.append((number, "roller", forces["roller"]))
                pressed.setdefault(joint, []).append(forces["roller"])
        elif name == "slider-crank":
            phi, x = (before, places[joint]) if given_turns else (places[joint], before)
            first = slide_at(keys, start)
            asks = {"slide_asks": asked} if given_turns else {"crank_asks": asked}
            pushed, guide, given = crank_and_slide(keys, start + phi, first + x, **asks)
            found += [(number, "coupler", pushed), (number, "guide", guide)]
            pressed.setdefault(joint - 1 if given_turns else joint, []).append(pushed)
        elif name == "four-bar":
            rocker = rocker_at(keys, start) + places[joint]
            pushed, given = four_bar_bodies(keys, start + before, rocker, asked)
            found.append((number, "coupler", pushed))
            for k in (joint - 1, joint):
                pressed.setdefault(k, []).append(pushed)
        elif name == "incline":
            forces, given = incline_bodies(keys, asked)
            found += [(number, *each) for each in forces.items()]
        elif "radius" in keys:
            r = mpf(keys["radius"])
            (force,) = solve_equations([[1, asked]]) if given_turns else solve_equations([[r, asked]])
            given = force * r if given_turns else force
            found.append((number, "teeth", force))
            pressed.setdefault(joint - 1 if given_turns else joint, []).append(force)
        elif given_turns:
            given = asked * mpf(keys["ratio"])
            for k in (joint - 1, joint):
                pressed.setdefault(k, []).append(mpmath.nan)
        else:
            given, pivot = lever_bodies(mpf(keys["ratio"]), asked)
            found += [(number, "input end", given), (number, "output end", asked), (number, "pivot", pivot)]
        joint -= 1
        asked = given + own[joint]
    return found, pressed


@pytest.mark.one_in(5)
@pytest.mark.parametrize("seed", range(200))
def test_forces_in_joints_are_those_of_free_bodies(seed):
    """Positions by root finding at 50 digits, accelerations by differences, each body in balance (d'Alembert)."""
    rng = np.random.default_rng(seed)
    stages, train, angular = random_train(rng)
    low, high = (float(np.clip(end.at, -20.0, 20.0)) for end in train.tool_travel_ends)
    y = float(train.follower_displacement(Taylor([low + (high - low) * rng.uniform(0.2, 0.8)])).terms[0])
    y1, y2 = rng.uniform(-3, 3, 2)
    carried, loads = drawn_loads(rng, len(train.links))
    train = Train(train.links, train.stages, carried)
    with mpmath.workdps(50):
        step = mpf(10) ** -14
        before, here, after = (places_of(stages, angular, mpf(y) + k * step) for k in (-1, 0, 1))
        own = []
        for joint, at in enumerate(here):
            ratio = (after[joint] - before[joint]) / (2 * step)
            bend = (after[joint] - 2 * at + before[joint]) / step**2
            force = mpf(loads[joint].terms[0]) if joint in loads else mpf(0)
            for each in (each for each in carried if each.joint == joint):
                force += each.force + each.stiffness * at + each.friction * np.sign(y1) * mpmath.sign(ratio)
                force += each.mass * (ratio * y2 + bend * y1**2)
            own.append(force)
        found, pressed = bodies(stages, angular, here, own)
    ours = [
        (force, [_force(train, parts, (y, y1, y2), loads) for parts in force.signed_sums])
        for force in train.joint_forces
    ]
    scale = max([abs(value) for _, values in ours for value in values], default=0.0)
    left = [(number, name, float(value)) for number, name, value in found]
    for force, values in ours:
        if not _on_shaft(train, force):
            alike = [
                each for each in left if each[0] == force.stage and force.name.rstrip(" 0123456789") == each[1]
            ]
            nearest = min(alike, key=lambda each: abs(each[2] - values[0]))
            assert abs(nearest[2] - values[0]) <= FREE_BODIES * scale, force.name
            left.remove(nearest)
    assert not left
    pivots = [force for force in ours if _on_shaft(train, force[0])]
    known = {k: float(sum(map(abs, each))) for k, each in pressed.items() if k and not any(map(mpmath.isnan, each))}
    assert len(pivots) == len(known)
    for force, values in pivots:
        assert abs(max(map(abs, values)) - known[force.parts[0].link + 1]) <= FREE_BODIES * scale


def _on_shaft(train, force):
    """Whether a force is on the pivot of the member that a link turns, and not in the link itself."""
    return force.kind == "pivot" and train.links[force.parts[0].link].driver_and_driven_angular[1]


def _force(train, parts, motion, loads):
    y, y1, y2 = motion
    load = TrainLoad(train, parts=parts)
    found = load.follower_load(train, Taylor([y, y1, y2 / 2, 0.0]), float(np.sign(y1)), loads)
    return float(found.still.terms[0] + found.carried.terms[0])


# ---------------------------------------------------------------------------------------------- whole scenes

SCENES = {
    "a rocker": ("roller", [{**ROCKER, "arm_inertia": 4e-4, **TOOL}]),
    "a slide": ("arm", [{**SLIDE, **TOOL}]),
    "a four-bar": ("arm", [{**FOUR_BAR, "inertia": 3e-3, "preload": 4.0, "spring_rate": 6.0}]),
    "two stages": ("flat", [{**ROCKER, "mass": 0.2}, {"stage": "incline", "angle": 30, **TOOL}]),
    "a load that changes": ("roller", [{**ROCKER, "load": [[20, 0], [90, 150], [200, 20]]}]),
    "a rubbing slide": ("roller", [{**ROCKER, **TOOL, "friction_force": 25.0}]),
}
LIMITED = ["joint_force_max_N", "pivot_force_max_N", "slide_thrust_max_N"]


def scene_through_train(contact, train, *, law="poly4567", **more):
    turns = CONTACTS[contact]["motion"] == "oscillating"
    made = {**cam_with(contact, dynamics=SWUNG if turns else UNGUIDED), "motion": turn_of(law, 14 if turns else 20)}
    return Scene.from_dict({**made, "train": train, "outputs": ["joints"], **more})


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("contact", "train"), SCENES.values(), ids=SCENES)
def test_the_largest_forces_are_those_of_a_dense_scan(contact, train):
    scene = scene_through_train(contact, train)
    problem, found = resolve(scene), evaluate(scene)
    theta = np.linspace(0.0, 2 * np.pi, 20001)[:-1] + 1e-9
    dense = {}
    for force in setup_joint_forces(problem.setup):
        most = 0.0
        for parts in force.signed_sums:
            load = programme_loaded_by_joint_force(problem.programme, parts).state(theta).load
            most = max(most, np.abs(load.value + problem.setup.omega**2 * load.carried).max())
        worst = largest_joint_force(problem.programme, force, problem.setup.omega)
        assert most <= worst.value * (1 + 1e-12)
        assert most == pytest.approx(float(worst.value), rel=1e-5)
        dense[force.kind] = max(dense.get(force.kind, (0.0, 0.0)), (float(worst.value), float(worst.at)))
    rows = {(row.stage, row.joint): row for row in found.joint_forces}
    assert len(rows) == len(setup_joint_forces(problem.setup))
    for force in setup_joint_forces(problem.setup):
        row, worst = (
            rows[force.stage, force.name],
            largest_joint_force(problem.programme, force, problem.setup.omega),
        )
        assert max(row.force_max_N, -(row.force_min_N or 0.0)) == pytest.approx(float(worst.value), rel=1e-12)
    for kind, name in zip(("joint", "pivot", "guide"), LIMITED, strict=True):
        assert (name in found) == (kind in dense)
        if kind in dense:
            assert found[name] == pytest.approx(dense[kind][0], rel=1e-12)
    assert found["joint_force_max_at_deg"] == pytest.approx(np.degrees(dense["joint"][1]), abs=1e-4)


@pytest.mark.parametrize(("contact", "train"), SCENES.values(), ids=SCENES)
def test_tables_agree_with_balls_within_their_errors(contact, train):
    problem, rng = resolve(scene_through_train(contact, train, law="cycloidal")), np.random.default_rng(1)
    for force in setup_joint_forces(problem.setup):
        programme = programme_loaded_by_joint_force(problem.programme, force.signed_sums[0])
        turn, table = exact_motion(programme), programme.table
        for panel in rng.integers(table.centre.size, size=8):
            u = float(rng.uniform(-0.98, 0.98))
            angle = float(table.centre[panel] + u * table.half_width[panel])
            number = next(k for k, stroke in enumerate(programme.strokes) if stroke.start <= angle <= stroke.end)
            stroke = turn.strokes[number]
            centre, half = (arb(float(each[panel])) for each in (table.centre, table.half_width))
            x = (centre + u * half - arb(programme.strokes[number].start)) / stroke.angle
            piece, line, _, _ = next(part for part in stroke.smooth() if part[2] <= x <= part[3])
            known = [float(ball.arb) for ball in motion_at(stroke, piece, x, line)[5:]]
            for k, each in enumerate(table.load):
                assert (
                    abs(value_and_three_derivatives(each, panel, u)[0] - known[2 * k])
                    <= each.error[panel, 0] + 1e-30
                )


@pytest.mark.parametrize(("contact", "train"), SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("quantity", LIMITED)
def test_limits_are_decided_next_to_their_bounds(contact, train, quantity):
    scene = scene_through_train(contact, train)
    if quantity not in (found := evaluate(scene)):
        pytest.skip("no such joint")
    for share in (1.0 + FREE_BODIES, 1.0 - FREE_BODIES):
        limited = scene.replace(**{f"limits.{quantity}": found[quantity] * share})
        assert certify(limited)[quantity] == ("held" if share > 1.0 else "broken")
        assert (evaluate(limited)["violated"] == quantity) == (share < 1.0)


LOADED = {"mass": 0.5, "spring_rate": 3.0, "preload": 40.0}
TURNED = {"inertia": 3e-3, "spring_rate": 6.0, "preload": 4.0}
DIRECTED = {
    "a slide": ("arm", {**SLIDE, **LOADED}),
    "a four-bar": ("arm", {**FOUR_BAR, **TURNED}),
    "from a slide": ("roller", {"stage": "slider-crank", "crank": 60, "coupler": 150, "angle": 80, **TURNED}),
}


@pytest.mark.parametrize(("contact", "stage"), DIRECTED.values(), ids=DIRECTED)
def test_a_coupler_pushes_along_itself(contact, stage):
    """From the pin of the crank to that of slide or rocker, where the motions of follower and tool have these."""
    found = evaluate(scene_through_train(contact, [stage]))
    row = next(each for each in found.joint_forces if each.joint == "coupler")
    assert row.direction_deg == found["joint_force_max_direction_deg"]
    points = camopt.cam_points(found.scene, [0.0, row.largest_at_deg])
    names = [each for each in points if "displacement" in each]
    moved = {each: np.diff(points[each])[0] * (np.radians(1.0) if each.endswith("_deg") else 1.0) for each in names}
    follower = next(moved[each] for each in names if not each.startswith("tool"))
    tool = next(moved[each] for each in names if each.startswith("tool"))
    start, a, b = np.radians(stage["angle"]), stage["crank"], stage["coupler"]
    if stage["stage"] == "four-bar":
        pin, psi = a * np.exp(1j * (start + follower)), float(rocker_at({"crossed": False, **stage}, start))
        end = stage["ground"] + stage["rocker"] * np.exp(1j * (psi + tool))
    else:
        turned, slid = (tool, follower) if contact == "roller" else (follower, tool)
        first, e = a * np.exp(1j * start), stage.get("offset", 0.0)
        pin = a * np.exp(1j * (start + turned))
        end = first.real + np.sqrt(b**2 - (first.imag - e) ** 2) + slid + 1j * e
    assert abs(end - pin) == pytest.approx(b, rel=1e-9)
    assert row.direction_deg == pytest.approx(np.degrees(np.angle(end - pin)), abs=1e-6)


def test_the_face_of_a_wedge_is_pressed_square_to_it():
    stage = {"stage": "incline", "angle": 25.0, "guide": 80.0, **LOADED}
    (row,) = (
        each for each in evaluate(scene_through_train("roller", [stage])).joint_forces if each.joint == "face"
    )
    assert row.direction_deg == pytest.approx(90.0 - 25.0 - 80.0)


def test_searched_speeds_have_forces_of_their_own(tmp_path):
    contact, train = SCENES["a slide"]
    scene = scene_through_train(
        contact, train, search={"cam": {"rpm": [200.0, 1400.0]}, "base_radius": [40.0, 50.0]}
    )
    camopt.sweep(scene, out=tmp_path, keep="all", workers=1)
    designs = camopt.load(tmp_path / "designs.parquet")
    for row in range(len(designs)):
        assert designs["joint_force_max_N"][row] == evaluate(camopt.scene_of(designs, row))["joint_force_max_N"]
    assert len(set(designs["joint_force_max_N"])) == 2


def test_forces_are_infinite_where_a_mass_gets_a_blow_and_no_further():
    train = [{**SLIDE, "spring_rate": 4.0}, {"stage": "incline", "angle": 30, "mass": 1.0}]
    assert evaluate(scene_through_train("arm", train, law="uniform"))["joint_force_max_N"] == np.inf
    without = [SLIDE, {"stage": "incline", "angle": 30, "spring_rate": 4.0}]
    assert np.isfinite(evaluate(scene_through_train("arm", without, law="uniform"))["joint_force_max_N"])


def test_a_train_that_carries_nothing_has_no_forces():
    assert "joint_force_max_N" not in evaluate(scene_through_train("arm", [SLIDE], outputs=["all"]))
    with pytest.raises(camopt.BadInput, match=r"max_N = 9\.0: needs a mass, spring or load in train\.1"):
        evaluate(scene_through_train("arm", [SLIDE], limits={"joint_force_max_N": 9}))


def test_forces_of_springs_alone_need_no_speed():
    scene = scene_through_train("arm", [{**SLIDE, "spring_rate": 4.0, "preload": 10.0}])
    scene = scene.replace(**{"cam.rpm": None, "follower.dynamics": None})
    assert evaluate(scene)["joint_force_max_N"] > 10.0

"""Free laws of moves: exact optima, conditions that hold, bounds that motions keep, and laws that are scenes."""

import tomllib
from functools import cache
from math import isclose, pi, radians, sqrt

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.depth import times

from camopt import BadInput, Scene, Unmet, certify, evaluate, find_scene, frontier, synthesise
from camopt.model.effects.vibration import vibration_extremes
from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import MotionSegment
from camopt.scene.problem.problem import resolve
from camopt.solve.synthesis.cams import programme_with_laws
from camopt.solve.synthesis.iterate import free_stroke_motions, without_solver_error
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.solver import SOLVED, solve
from camopt.solve.synthesis.stroke_motion import DerivativeRange, Sizes
from camopt.solve.synthesis.symmetry import find_mirror_strokes
from camopt.solve.synthesis.synthesise import solve_free_laws

MOVES = (
    "belt-matching",
    "bucket-valve",
    "feeder-with-stop",
    "indexing-overlap",
    "press-with-drift",
    "rocker-valve",
)
CAM = {"form": "disc", "rpm": 60, "base_radius": 400}
KNIFE = {"motion": "translating", "contact": "knife"}


@cache
def free(name, minimise, pieces=24):
    scene = find_scene(name).replace(**{"synthesis.minimise": minimise, "synthesis.pieces": pieces})
    return scene, synthesise(scene)


def turn(*segments, **changes):
    """A scene of segments on a cam so large that its size limits nothing."""
    return Scene.from_dict({"cam": CAM, "follower": KNIFE, "motion": list(segments)}).replace(**changes)


def states(scene):
    """y, y', y'' … at the start and at the end of each stroke, in positions of the scene."""
    programme = resolve(scene).programme
    ends = [s.motion(np.array([s.start, s.start + s.angle])) for s in programme.strokes]
    return programme, np.array(ends)


# ------------------------------------------------------------------------------------------- what they hold


@pytest.mark.slow
@pytest.mark.one_in(15)
@pytest.mark.parametrize("name", MOVES)
@pytest.mark.parametrize("minimise", ["acceleration", "jerk_rms"])
def test_free_moves_hold_every_limit_join_smoothly_and_are_no_worse_than_the_scenes_own(name, minimise):
    scene, result = free(name, minimise)
    assert evaluate(result.scene)["feasible"]
    assert set(certify(result.scene).values()) == {"held"}
    assert not resolve(result.scene).programme.jumps
    angular = "rad_s" if scene.follower.motion == "oscillating" else "m_s"
    own = evaluate(scene)[f"acceleration_max_{angular}2"]
    if minimise == "acceleration":
        assert isclose(evaluate(result.scene)[f"acceleration_max_{angular}2"], result.objective, rel_tol=1e-9)
        assert result.objective <= own * (1 + 1e-6)
    assert result.bound is None or result.bound <= result.objective
    assert result.bound is not None


@pytest.mark.slow
@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", MOVES)
def test_the_states_that_a_scene_asks_for_are_met_and_stretches_keep_their_velocity(name):
    scene, result = free(name, "acceleration")
    (before, at_first), (after, at_last) = states(scene), states(result.scene)
    for number, (one, other) in enumerate(zip(before.strokes, after.strokes, strict=True)):
        if not one.is_law_replaceable:
            assert np.allclose(at_first[number], at_last[number], rtol=1e-12, atol=1e-12)
            continue
        for asked in one.conditions_in_mm_or_rad(before.strokes[0].low):
            values = other.motion(np.linspace(asked.start, asked.end, 101))[asked.order]
            room = 1e-9 * max(np.abs(at_first[:, asked.order]).max(), np.abs(values).max())
            assert asked.low - room <= values.min()
            assert values.max() <= asked.high + room
        assert other.law.NAME.startswith("free")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", MOVES)
def test_a_scene_with_free_moves_is_read_again_and_asks_the_same(name):
    scene, result = free(name, "acceleration")
    again = Scene.from_dict(tomllib.loads(result.scene.to_toml()))
    assert evaluate(again) == evaluate(result.scene)
    first, second = (build_synthesis_problem(each) for each in (scene, again))
    assert [c.key for c in first.conditions] == [c.key for c in second.conditions]
    assert first.zero == pytest.approx(second.zero, abs=1e-9)


# --------------------------------------------------------------------------------------------- exact optima


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["belt-matching", "feeder-with-stop", "press-with-drift"])
def test_the_least_mean_square_jerk_is_that_of_the_scenes_own_polynomials(name):
    """Between fixed states the polynomial of degree 5 is the optimum: the programme and its bound find it too."""
    moves = find_scene(name).to_dict()["motion"]
    wide = {"limits": {}, "cam.base_radius": 1e4, "cam.mean_radius": None}
    if find_scene(name).cam.form == "cylindrical":
        wide = {"limits": {}, "cam.mean_radius": 1e4, "cam.base_radius": None}
    scene = find_scene(name).replace(**wide, **{"synthesis.minimise": "jerk_rms", "synthesis.pieces": 24})
    if any(s["segment"] in ("rise", "return") for s in moves):
        laws = [s | ({"law": "poly345"} if s["segment"] in ("rise", "return") else {}) for s in moves]
        scene = scene.replace(motion=laws)
    programme, seconds = resolve(scene).programme, 60 / scene.cam.rpm
    angles = (np.arange(720_000) + 0.5) * 2 * pi / 720_000
    own = sqrt(np.mean(programme.motion_at(angles)[3] ** 2)) * (2 * pi / seconds) ** 3 / 1e3
    result = synthesise(scene)
    assert result.objective == pytest.approx(own, rel=1e-4)  # what is given up for the gentlest jerk
    assert own * (1 - 1e-5) <= result.bound * (1 + 1e-5) <= own * (1 + 2e-5)


@pytest.mark.slow
@settings(max_examples=times(4, deep=60), deadline=None)
@given(
    angle=st.floats(40, 200), lift=st.floats(5, 60), before=st.floats(0.0, 0.9), after=st.floats(0.0, 0.9),
)  # fmt: skip
def test_the_least_peak_acceleration_is_that_of_two_parabolas(angle, lift, before, after):
    """Between two velocities in a given angle: full acceleration one way, then the other (Pontryagin).

    From velocity u to w over θ the least A solves |h − θ·(u + w)/2| = θ²·A/4 − (w − u)²/(4·A). The worse of the two
    moves of the turn decides.
    """
    theta, stretch = radians(angle), radians(20)
    u, w = before * lift / theta, after * lift / theta
    back = {"angle": 320 - angle, "lift": -(u * stretch + lift + w * stretch)}
    least = max(
        _least_acceleration(theta, lift, u, w), _least_acceleration(radians(back["angle"]), back["lift"], w, u)
    )
    scene = turn(
        {"segment": "constant-velocity", "angle": 20, "to": u * stretch},
        {"segment": "move", "angle": angle, "to": u * stretch + lift},
        {"segment": "constant-velocity", "angle": 20, "to": (u + w) * stretch + lift},
        {"segment": "move", "angle": back["angle"], "to": 0},
        **{"synthesis.minimise": "acceleration", "synthesis.rest": 1, "synthesis.pieces": 40},
    )
    result = synthesise(scene)
    per = (scene.cam.rpm * 2 * pi / 60) ** 2 / 1e3
    assert least * per * (1 - 1e-3) <= result.bound * (1 + 1e-6) <= least * per * (1 + 1e-5)
    assert least * per * (1 - 1e-5) <= result.objective <= least * per * 1.03


def _least_acceleration(theta, lift, u, w):
    off = abs(lift - theta * (u + w) / 2)
    return 2 * off / theta**2 + sqrt((2 * off / theta**2) ** 2 + ((w - u) / theta) ** 2)


# -------------------------------------------------------------------------------------- symmetric and smooth

EVEN = [
    {"segment": "rise", "angle": 100, "lift": 30, "law": "poly345"},
    {"segment": "dwell", "angle": 20},
    {"segment": "return", "angle": 100, "lift": 30, "law": "poly345"},
    {"segment": "dwell", "angle": 140},
]
UP_AND_DOWN = ((100, 5), (160, 5), (100, 0))
SYMMETRIC = {
    "valve": (find_scene("bucket-valve"), 92.0),
    "rise and return": (turn(*EVEN, **{"search.base_radius": {"start": 20, "stop": 400}}), 110.0),
    "moves": (turn(*({"segment": "move", "angle": angle, "to": to} for angle, to in UP_AND_DOWN)), 180.0),
}


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SYMMETRIC)
def test_a_symmetric_motion_is_its_own_mirror_image(name):
    scene, middle = SYMMETRIC[name]
    scene = scene.replace(**{"synthesis.symmetric": True, "synthesis.pieces": 16, "synthesis.minimise": "jerk"})
    programme = resolve(synthesise(scene).scene).programme
    away = np.radians(np.linspace(0.3, 179.7, 777))
    there, back = (programme.motion_at(np.mod(radians(middle) + side * away, 2 * pi)) for side in (1, -1))
    for order in range(3):
        room = 1e-8 * np.abs(there[order]).max()
        assert np.allclose(there[order], (-1) ** order * back[order], rtol=0, atol=room)


def test_what_is_no_mirror_image_cannot_be_symmetric():
    with pytest.raises(BadInput, match="the segments are not symmetric"):
        synthesise(find_scene("roller-1000rpm").replace(**{"synthesis.symmetric": True}))


@given(st.lists(st.tuples(st.integers(10, 90), st.integers(0, 4)), min_size=1, max_size=4), st.integers(0, 20))
def test_a_turn_and_its_reverse_have_mirror_images_wherever_it_starts(half, start):
    """A row of moves there and back is symmetric, from whichever segment it is read."""
    levels = [level for _, level in half]
    ends = [*levels, *reversed([0, *levels[:-1]])]
    rows = [
        MotionSegment("move", angle, to=end) for (angle, _), end in zip([*half, *reversed(half)], ends, strict=True)
    ]
    start %= len(rows)
    turned = Programme.from_segments([*rows[start:], *rows[:start]], angular=False).strokes
    places = find_mirror_strokes(turned)
    assert places is not None
    for stroke, place in zip(turned, places, strict=True):
        assert stroke.angle == pytest.approx(turned[place].angle)
        assert stroke.low == pytest.approx(turned[place].high)


@pytest.mark.long
@pytest.mark.parametrize("minimise", ["acceleration", "size"])
def test_a_smooth_motion_gives_up_a_share_of_its_objective_for_less_variation_of_the_jerk(minimise):
    scene = find_scene("bucket-valve").replace(**{"synthesis.minimise": minimise, "synthesis.pieces": 16})
    if minimise == "size":
        scene = find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 16})
    angles = np.linspace(0.0, 2 * pi, 36_001)
    found = []
    for smooth in (0.0, 0.01, 0.1):
        result = synthesise(scene.replace(**{"synthesis.smooth": smooth}))
        jerk = resolve(result.scene).programme.motion_at(angles)[3]
        found.append((result.objective, np.abs(np.diff(jerk)).sum()))
        assert evaluate(result.scene)["feasible"]
        assert result.objective <= found[0][0] * (1 + smooth + 1e-3)
    assert found[0][1] > 1.05 * found[1][1] > 1.05 * found[2][1]


@pytest.mark.slow
def test_the_frontier_of_moves_has_bounds_and_cams():
    scene = find_scene("press-with-drift").replace(**{"synthesis.pieces": 12})
    found = frontier(scene, ("acceleration", "jerk"), points=2, workers=1)
    assert found.rows
    for row in found.rows:
        assert row["bound"] <= row["acceleration"] * (1 + 1e-9)
        cam = Scene.from_dict(tomllib.loads(row["scene"]))
        assert evaluate(cam)["feasible"]
        assert evaluate(cam)["jerk_max_m_s3"] <= row["jerk"] * (1 + 1e-9)
    own = found.known[0]
    assert own["law_rise"] == ""
    assert all(found.least[axis][0] <= own[axis] for axis in ("acceleration", "jerk"))


TRAIN = {"follower.dynamics.natural_frequency": 14.3, "follower.dynamics.damping_ratio": 0.04}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["press-with-drift", "bucket-valve", "two moves"])
def test_the_residual_vibration_of_moves_is_linear_in_their_coefficients(name):
    """Random coefficients, as smooth at the joints as they have to be: the rows say what the train does."""
    if name == "two moves":
        rows = ({"angle": 80, "to": [5, 9]}, {"angle": 100, "to": 20}, {"angle": 60, "to": 0})
        moves = ({"segment": "move", **row} for row in rows)
        scene = turn(*moves, {"segment": "dwell", "angle": 120})
    else:
        scene = find_scene(name)
    train = TRAIN | {"follower.dynamics.natural_frequency": 6.1 * scene.cam.rpm / 60}
    scene = scene.replace(**train, **{"synthesis.minimise": "residual_vibration", "synthesis.pieces": 8})
    problem = build_synthesis_problem(scene)
    model, start, _ = solve_free_laws(problem)
    random = np.random.default_rng(5)
    noisy = [c + 0.05 * random.normal(size=c.size) for c in start.coefficients]
    found = start._replace(coefficients=without_solver_error(problem, noisy))
    for motion, coefficients in zip(free_stroke_motions(model), found.coefficients, strict=True):
        motion.coefficients.value = coefficients
    programme = programme_with_laws(problem, found)
    wanted = vibration_extremes(programme, *problem.train_frequency_and_damping).residual
    assert model.unit * float(model.objective.value) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.slow
def test_moves_of_the_least_residual_vibration_leave_next_to_none():
    scene = find_scene("press-with-drift").replace(
        **TRAIN, **{"synthesis.minimise": "residual_vibration", "synthesis.pieces": 16, "outputs": ["vibration"]}
    )
    result = synthesise(scene)
    assert result.objective <= 1e-2 * evaluate(scene)["residual_vibration_max_mm"]
    assert evaluate(result.scene)["residual_vibration_max_mm"] == pytest.approx(
        result.objective, rel=1e-6, abs=1e-12
    )


# ------------------------------------------------------------------------------------------------ mistakes

LAW = {"degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1], "positions": [0, 0, 10, 10]}
MOTION = [
    {"segment": "move", "angle": 100, "to": 10, "law": "own"},
    {"segment": "dwell", "angle": 60},
    {"segment": "return", "angle": 100, "to": 0, "law": "poly345"},
    {"segment": "dwell", "angle": 100},
]


def scene_with_moves(place=0, table=None, **keys):
    motion = [segment | (keys if number == place else {}) for number, segment in enumerate(MOTION)]
    data = {"cam": CAM, "follower": KNIFE, "motion": motion, "laws": {"own": table or LAW}}
    return Scene.from_dict(data)


def test_a_move_with_a_law_of_its_own_is_that_spline():
    x = np.linspace(0, 1, 50)
    motion = resolve(scene_with_moves()).programme.motion_at(x * radians(100))
    assert np.allclose(motion[0], 10 * (3 * x**2 - 2 * x**3), rtol=1e-14, atol=1e-14)


MISTAKES = [
    (0, {"to": 11}, "motion.1.law = 'own': ends at 10; the move ends at 11"),
    (0, {"to": None}, "motion.1.to: missing; a move goes to a position"),
    (0, {"velocity": 2}, "motion.1.law = 'own': has velocity 0 by rad; motion.1.velocity requires 2"),
    (
        0,
        {"acceleration": [-1, 1]},
        "has acceleration -19.6968 by rad²; motion.1.acceleration requires -1 to 1",
    ),
    (0, {"law": "poly345"}, "motion.1.law = 'poly345': is for a rise or return; a move takes a law of positions"),
    (0, {"law": "others"}, "motion.1.law = 'others': must be a motion law"),
    (2, {"law": "own"}, "motion.3.law = 'own': is a law of positions, for a move"),
]


@pytest.mark.parametrize(("place", "keys", "message"), MISTAKES)
def test_a_law_that_is_not_for_its_move_is_said(place, keys, message):
    with pytest.raises(BadInput) as caught:
        scene_with_moves(place, **keys)
    assert message in str(caught.value)


LAWS = [
    ({"positions": [1, 1, 10, 10]}, "motion.1.law = 'own': starts at 1; the move starts at 0"),
    ({"positions": [0, 10]}, "laws.own.positions"),
    ({"knots": [0, 0, 0, 0, 1, 1, 1]}, "laws.own.knots: has 7 values; 4 positions of degree 3 need 8"),
    ({"mirror": True}, "laws.own.mirror = True: is for a law from 0 to 1; this law has positions"),
    ({"peaks": [1, 2]}, "laws.own.peaks = [1, 2]: is for a law from 0 to 1"),
    ({"coefficients": [0, 0, 1, 1]}, "laws.own.positions = [0, 0, 10, 10]: a B-spline has none"),
]


@pytest.mark.parametrize(("keys", "message"), LAWS)
def test_a_law_of_positions_that_is_none_is_said(keys, message):
    with pytest.raises(BadInput) as caught:
        scene_with_moves(table=LAW | keys)
    assert message in str(caught.value)


def test_free_laws_of_free_laws_hold_the_same_limits():
    """What moves hold by default is told by the moves of least jerk, not by the laws that a scene has by now."""
    scene, result = free("belt-matching", "acceleration")
    again = synthesise(result.scene)
    assert again.objective == pytest.approx(result.objective, rel=1e-4)
    assert (
        build_synthesis_problem(result.scene).derivative_ranges == build_synthesis_problem(scene).derivative_ranges
    )


def test_what_free_moves_cannot_do_is_said():
    peaked = find_scene("belt-matching").replace(**{"synthesis.peak_acceleration": 5})
    with pytest.raises(BadInput, match="is for the unit stroke of rises and returns, and this motion has none"):
        synthesise(peaked)
    still = turn(
        {"segment": "constant-velocity", "angle": 180, "to": 10},
        {"segment": "constant-velocity", "angle": 180, "to": 0},
    )
    with pytest.raises(BadInput, match="has nothing to choose: it needs a rise, a return or a move"):
        synthesise(still)


VALVE = {
    "cam": {"form": "disc", "rpm": 3500, "base_radius": 22},
    "follower": {
        "motion": "translating",
        "contact": "flat",
        "dynamics": {"mass": 0.11, "spring_rate": 28, "preload": 250},
    },
    "motion": [
        {"segment": "move", "angle": 12, "to": 0.08, "velocity": 0.8, "acceleration": 0},
        {"segment": "move", "angle": 83.3, "to": 9.2, "through": [{"angle": 35.3, "position": 1.2}]},
        {"segment": "move", "angle": 83.3, "to": 0.08, "velocity": -0.8, "acceleration": 0},
        {"segment": "move", "angle": 12, "to": 0},
        {"segment": "dwell", "angle": 169.4},
    ],
    "limits": {"curvature_radius": 3, "face_diameter_min_mm": 24, "contact_stress": 700, "jump_speed": 3500},
    "materials": {"cam": "steel", "follower": "steel", "face_width": 11},
    "synthesis": {"pieces": 24, "minimise": "acceleration"},
}


@pytest.mark.long
@pytest.mark.parametrize("minimise", ["acceleration", "size"])
def test_lift_area_and_face_diameter_are_limits_of_the_programme(minimise):
    """The area by a fine sum over the motion; the scene's own motion holds all limits, so free laws do."""
    own = Scene.from_dict(VALVE)
    area = evaluate(own.replace(outputs=["lift_area_mm_deg"]))["lift_area_mm_deg"]
    asked = own.replace(**{"limits.lift_area_mm_deg": 0.998 * area, "synthesis.minimise": minimise})
    assert evaluate(asked)["feasible"]
    found = synthesise(asked)
    angles = np.deg2rad((np.arange(36000) + 0.5) / 100)
    y = resolve(found.scene).programme.motion_at(angles)[0]
    assert found.design["feasible"]
    assert (y - y.min()).sum() / 100 >= 0.998 * area * (1 - 1e-6)
    loose = synthesise(own.replace(**{"synthesis.minimise": minimise}))
    assert loose.objective <= found.objective * (1 + 1e-3)
    assert found.bound is not None
    assert found.bound <= found.objective


@pytest.mark.slow
def test_moves_of_the_largest_lift_area_are_no_worse_than_the_scenes_own_within_their_limits():
    """The area by a fine sum over the motion, from its lowest; a table of areas has the highest lift all round."""
    own = Scene.from_dict(VALVE)
    limited = {
        "limits.acceleration": evaluate(own)["acceleration_max_m_s2"],
        "synthesis.minimise": "lost_lift_area",
    }
    found = synthesise(own.replace(**limited))
    lost = []
    for scene in (found.scene, own):
        y = resolve(scene).programme.motion_at(np.deg2rad((np.arange(36000) + 0.5) / 100))[0]
        lost.append(360 * resolve(own).programme.lift - (y - y.min()).sum() / 100)
    assert found.design["feasible"]
    assert found.objective == pytest.approx(lost[0], rel=1e-6)
    assert found.bound <= lost[0] < lost[1]


@pytest.mark.slow
def test_more_lift_area_than_any_motion_has_is_said():
    too_much = Scene.from_dict(VALVE).replace(**{"limits.lift_area_mm_deg": 1300, "synthesis.pieces": 12})
    with pytest.raises(Unmet, match=r"limits\.lift_area_mm_deg"):
        synthesise(too_much)


@pytest.mark.parametrize(("order", "law"), [(1, "harmonic"), (2, "parabolic"), (3, "poly345")])
def test_the_area_of_a_motion_lies_where_its_values_at_nodes_say(order, law):
    """By the least and the largest area that nodes on a known motion leave, against its own, half of its box.

    Of two parabolas the largest second derivative is reached everywhere: trapezoids miss all that the bound allows.
    """
    rise = {"segment": "rise", "angle": 120, "lift": 40, "law": law}
    rest = [{"segment": "dwell", "angle": 60}, {"segment": "return", "angle": 120, "lift": 40, "law": law}]
    scene = turn(rise, *rest, {"segment": "dwell", "angle": 60}).replace(
        **{"synthesis.rest": 1 if order < 3 else 2}
    )
    problem = build_synthesis_problem(scene)
    stroke, sizes = problem.strokes[0], Sizes(cp.Variable(), cp.Variable(), cp.Variable())
    largest = np.abs(stroke.motion(stroke.start + stroke.angle * np.linspace(0, 1, 100001))[order]).max()
    bound = largest / problem.motion_unit
    motion = RelaxedMotion(9, problem, stroke, {order: [DerivativeRange(-bound, bound)]}, sizes)
    x = np.linspace(0, 1, 10)
    y, v, a, _ = stroke.motion(stroke.start + x * stroke.angle) / problem.motion_unit
    known = [(motion.y, y), (motion.v, v * stroke.angle), (motion.a, a * stroke.angle**2)]
    fixed = [cp.abs(unknown - value) <= 1e-9 for unknown, value in known[: 3 if order == 3 else 2]]
    constraints = motion.constraints + fixed
    ends = [cp.Problem(goal(motion.lift_area()), constraints) for goal in (cp.Minimize, cp.Maximize)]
    assert [solve(end) for end in ends] == [SOLVED] * 2
    least, most = (end.value for end in ends)
    half = stroke.angle / 2
    assert least - 1e-6 <= half <= most + 1e-6
    assert most - least <= {1: 0.2, 2: 0.1, 3: 2e-3}[order] * half

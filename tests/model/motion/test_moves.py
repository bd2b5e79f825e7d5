"""Segments that join: moves between any states, and stretches at constant velocity."""

from itertools import pairwise
from math import inf, isclose, pi, radians

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp
from scipy.interpolate import make_interp_spline
from support import naive, naive_moves
from support.balls.proof import exact_turn
from support.cams import CONTACTS, cam_with

from camopt import BadInput, Scene, certify, evaluate, find_scene
from camopt.model.motion.programme import Programme, derivative_root_mean_square, weighted_derivative_range
from camopt.model.motion.segments import MotionSegment
from camopt.model.motion.stroke import ALL_STROKES, DWELL, INWARD, OUTWARD, RESTING, RETURN, RISE
from camopt.scene.problem.problem import resolve
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture

ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}
BESIDE = 1e-9  # rad, to either side of a joint


def turn(*segments, angular=False):
    return Programme.from_segments([MotionSegment(*each) for each in segments], angular=angular)


def move(angle, to, *wanted):
    return ("move", angle, 0.0, None, to, wanted)


def sides(programme, at):
    """The motion just before and just after a cam angle, rad."""
    return programme.motion_at(np.array([at - BESIDE, at + BESIDE])).T


PRACTICE = ("belt-matching", "bucket-valve", "feeder-with-stop", "press-with-drift", "rocker-valve")
DWELLING, BELT = ("dwell", 80), ("constant-velocity", 120, 0.0, None, 40.0)


# ------------------------------------------------------------------------------------------------------ joints


positions, speeds = st.floats(-50.0, 50.0), st.none() | st.floats(-40.0, 40.0)
BESIDE_MOVES = ("poly345", "cycloidal", "harmonic", "uniform")
KINDS = ("move", "constant-velocity", "dwell", "rise")


@st.composite
def turns(draw, wanted=2, kinds=KINDS):
    """Segments of a turn that closes, moves among them, and at least one of these beside the start."""
    count = draw(st.integers(2, 7))
    shares = np.array([draw(st.floats(0.2, 1.0)) for _ in range(count)])
    angles, position, found = 360.0 * shares / shares.sum(), 0.0, []
    for angle in angles[:-1]:
        kind = draw(st.sampled_from(kinds))
        if kind in ("move", "constant-velocity"):
            position = draw(positions)
            conditions = tuple(draw(speeds) for _ in range(wanted)) if kind == "move" else ()
            found.append((kind, angle, 0.0, None, position, conditions))
        elif kind == "rise":
            lift = draw(st.floats(1.0, 30.0))
            position += lift
            found.append((kind, angle, lift, draw(st.sampled_from(BESIDE_MOVES))))
        else:
            found.append((kind, angle))
    found.append(move(angles[-1], draw(positions)))
    ends = [each[4] for each in found if len(each) > 4]
    assume(max(ends) - min(ends) > 1e-3)
    return found


@given(turns())
def test_a_move_joins_what_is_beside_it(segments):
    """y is continuous everywhere, and y' and y'' where a move meets something, unless they are given otherwise."""
    programme = turn(*segments)
    strokes = programme.strokes
    scale = np.abs(programme.table.nodes).max(axis=0)[:3]
    for before, after in zip(strokes, (*strokes[1:], strokes[0]), strict=True):
        (left,), (right,) = (s.motion(np.array([at])).T for s, at in ((before, before.end), (after, after.start)))
        assert abs(left[0] - right[0]) <= 1e-9 * scale[0]
        for order in (1, 2):
            given_here = (
                before.law_follows_from_neighbours
                and len(before.wanted) > order
                and before.wanted[order] is not None
            )
            if after.law_follows_from_neighbours or (before.law_follows_from_neighbours and not given_here):
                assert abs(left[order] - right[order]) <= 1e-9 * scale[order]
            if given_here:
                assert isclose(left[order], before.wanted[order], rel_tol=1e-9, abs_tol=1e-9 * scale[order])


@given(turns(wanted=3))
def test_a_jerk_that_is_given_is_reached(segments):
    programme = turn(*segments)
    scale = np.abs(programme.table.nodes).max(axis=0)[3]
    for stroke in programme.strokes:
        if stroke.law_follows_from_neighbours and len(stroke.wanted) > 3 and stroke.wanted[3] is not None:
            reached = stroke.motion(np.array([stroke.end]))[3, 0]
            assert isclose(reached, stroke.wanted[3], rel_tol=1e-9, abs_tol=1e-9 * scale)


@given(turns())
def test_displacements_are_counted_from_the_lowest_of_the_turn(segments):
    programme = turn(*segments)
    angles = [*np.linspace(0.0, 2 * pi, 20_001)[:-1], *(stroke.start for stroke in programme.strokes)]
    samples = programme.motion_at(np.array(angles))[0]
    assert -1e-9 * programme.lift <= samples.min() <= 1e-4 * programme.lift
    assert samples.max() <= programme.lift * (1 + 1e-12)
    assert samples.max() >= programme.lift * (1 - 1e-4)
    assert weighted_derivative_range(programme, (1.0,), ALL_STROKES) == pytest.approx(
        programme.lowest_and_highest_displacement, abs=1e-12 * programme.lift
    )


@given(turns(kinds=("move", "move", "dwell")))
def test_a_turn_run_backwards_is_the_mirror_image(segments):
    """Rises become returns, velocities change sign: the least jerk knows no sense of rotation."""
    after = [*segments[1:], segments[0]]
    conditions = [s[5] if s[0] == "move" and a[0] == "move" else () for s, a in zip(segments, after, strict=True)]
    segments = [(*s[:5], c) if s[0] == "move" else s for s, c in zip(segments, conditions, strict=True)]
    levels = [segments[-1][4]]
    for each in segments:
        levels.append(each[4] if each[0] == "move" else levels[-1])
    backwards = []
    for k in reversed(range(len(segments))):
        kind, angle = segments[k][:2]
        before = conditions[k - 1]
        if kind == "dwell":
            backwards.append(("dwell", angle))
        else:
            wanted = tuple(v if v is None else v * (-1.0) ** n for n, v in enumerate(before, start=1))
            backwards.append(move(angle, levels[k], *wanted))
    one, other = turn(*segments), turn(*backwards)
    angles = np.linspace(0.01, 2 * pi - 0.01, 97)
    signs = np.array([1.0, -1.0, 1.0, -1.0])[:, None]
    here, there = one.motion_at(angles), other.motion_at(2 * pi - angles) * signs
    assert np.allclose(here[:3], there[:3], atol=1e-7 * np.abs(here[:3]).max(axis=1, keepdims=True) + 1e-12)


# -------------------------------------------------------------------------------------------------- least jerk


@pytest.mark.one_in(2)
@pytest.mark.parametrize("order", [3, 4])
@given(st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=8), st.integers(0, 10**6))
def test_free_joints_are_those_of_the_natural_spline(order, levels, seed):
    """A second answer: scipy's interpolating spline of degree 2k − 1 that rests at both ends."""
    shares = np.random.default_rng(seed).uniform(0.3, 1.0, len(levels) + 1)
    angles = 300.0 * shares / shares.sum()
    last = (None, None, 0.0) if order == 4 else ()
    segments = [move(a, y) for a, y in zip(angles, levels, strict=False)]
    programme = turn(*segments, move(angles[-1], 0.0, *last), ("dwell", 60))
    knots = np.concatenate([[0.0], np.cumsum(np.radians(angles))])
    rest = [(k, 0.0) for k in range(1, order)]
    spline = make_interp_spline(knots, [0.0, *levels, 0.0], k=2 * order - 1, bc_type=(rest, rest))
    within = np.linspace(0.0, knots[-1], 203)[1:-1]
    expected = np.array([spline.derivative(n)(within) if n else spline(within) for n in range(4)])
    found = programme.motion_at(within)
    found[0] -= programme.motion_at(np.zeros(1))[0]
    assert np.allclose(found, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max(axis=1, keepdims=True) + 1e-10)


@given(st.lists(st.floats(-30.0, 30.0), min_size=4, max_size=9), st.integers(0, 10**6))
def test_a_turn_of_moves_alone_is_the_periodic_spline(levels, seed):
    shares = np.random.default_rng(seed).uniform(0.3, 1.0, len(levels))
    angles = 360.0 * shares / shares.sum()
    assume(max(levels) - min(levels) > 1e-3)
    programme = turn(*(move(a, y) for a, y in zip(angles, levels, strict=True)))
    knots = np.concatenate([[0.0], np.cumsum(np.radians(angles))])
    values = np.array([levels[-1], *levels])
    values[-1] = values[0]
    spline = make_interp_spline(knots, values, k=5, bc_type="periodic")
    within = np.linspace(0.0, 2 * pi, 203)[1:-1]
    found, expected = programme.motion_at(within), np.array([spline.derivative(n)(within) for n in range(1, 4)])
    assert np.allclose(found[1:], expected, rtol=0.0, atol=1e-7 * np.abs(expected).max(axis=1, keepdims=True))


def test_no_other_state_at_a_joint_has_less_jerk():
    """An identity of a minimum: whatever is given at a free joint instead, the mean square of the jerk is more."""
    free = turn(move(70, 12.0), move(90, 30.0), move(120, 0.0), DWELLING)
    least = derivative_root_mean_square(free, 3)
    state = free.motion_at(np.radians([70.0]))[:, 0]
    for change in (-0.1, -1e-3, 1e-3, 0.1):
        for order in (1, 2):
            wanted = [None, None]
            wanted[order - 1] = state[order] * (1 + change)
            other = turn(move(70, 12.0, *wanted), move(90, 30.0), move(120, 0.0), DWELLING)
            assert derivative_root_mean_square(other, 3) > least


FREE = (-inf, inf)


def loose(angle, between, *wanted):
    """A move whose position at its end is a range."""
    return ("move", angle, 0.0, None, None, wanted, between)


def test_a_joint_at_which_nothing_is_asked_changes_nothing():
    one = turn(loose(30, FREE), loose(50, FREE), move(60, 25.0), move(100, 0.0), ("dwell", 120))
    other = turn(move(140, 25.0), move(100, 0.0), ("dwell", 120))
    angles = np.linspace(0.0, 2 * pi, 301)[:-1]
    assert np.allclose(one.motion_at(angles), other.motion_at(angles), rtol=1e-9, atol=1e-9)
    assert one.lift == pytest.approx(other.lift, rel=1e-12)


ends = st.tuples(st.floats(-20.0, 20.0), st.floats(0.0, 10.0)).map(lambda pair: (pair[0], pair[0] + pair[1]))


@given(st.lists(st.tuples(ends, st.none() | ends, st.none() | ends), min_size=1, max_size=4), st.randoms())
def test_ranges_are_kept_and_nothing_within_them_has_less_jerk(joints, random):
    """The least of a convex form over a box: ranges hold, and no other values within them do better."""
    angles = [240.0 / (len(joints) + 1)] * len(joints)
    assume(max(abs(end) for between, *_ in joints for end in between) > 1e-3)
    last = move(240.0 / (len(joints) + 1), 0.0)

    def turn_with(chosen):
        return turn(*chosen, last, ("dwell", 120))

    best = turn_with(
        [loose(angle, between, *wanted) for angle, (between, *wanted) in zip(angles, joints, strict=True)]
    )
    start, least = best.strokes[0].low, derivative_root_mean_square(best, 3)
    for stroke, asked in zip(best.strokes, joints, strict=False):
        state = stroke.motion(np.array([stroke.end]))[:, 0] - np.array([start, 0.0, 0.0, 0.0])
        for value, within in zip(state, asked, strict=False):
            if within is not None:
                assert within[0] - 1e-7 <= value <= within[1] + 1e-7
    for _ in range(5):
        some = [
            move(angle, random.uniform(*between), *(w if w is None else random.uniform(*w) for w in wanted))
            for angle, (between, *wanted) in zip(angles, joints, strict=True)
        ]
        if any(value for each in some for value in (each[4], *each[5]) if value):
            assert derivative_root_mean_square(turn_with(some), 3) >= least * (1 - 1e-9) - 1e-9


def test_a_range_that_is_reached_is_as_if_its_end_were_given():
    free = turn(loose(120, FREE), move(120, 30.0), move(60, 0.0), ("dwell", 60))
    height = free.strokes[0].high - free.strokes[0].low
    for between, expected in (((-50.0, height - 4.0), height - 4.0), ((height + 2.0, 90.0), height + 2.0)):
        one = turn(loose(120, between), move(120, 30.0), move(60, 0.0), ("dwell", 60))
        other = turn(move(120, expected), move(120, 30.0), move(60, 0.0), ("dwell", 60))
        angles = np.linspace(0.0, 2 * pi, 200)[:-1]
        assert np.allclose(one.motion_at(angles), other.motion_at(angles), rtol=1e-8, atol=1e-8)


# ---------------------------------------------------------------------------------------------------- 50 digits


@mpmath.workdps(50)
def fifty_digits(start, end, angle, x):
    """The polynomial with given states (y, y', … by rad) at both ends, from its conditions as a linear system."""
    count = len(start)
    system, right = mp.matrix(2 * count), mp.matrix(2 * count, 1)
    for side, state in enumerate((start, end)):
        for k in range(count):
            for n in range(k, 2 * count):
                system[side * count + k, n] = mp.ff(n, k) * (mp.mpf(angle) if side else mp.mpf(0)) ** (n - k)
            right[side * count + k] = mp.mpf(float(state[k]))
    powers = list(mp.lu_solve(system, right))
    here = mp.mpf(angle) * x
    return [sum(mp.ff(n, k) * c * here ** (n - k) for n, c in enumerate(powers) if n >= k) for k in range(4)]


@pytest.mark.parametrize("wanted", [(), (3.0,), (-2.0, 15.0), (1.0, -4.0, 100.0)])
def test_a_move_against_fifty_digits(wanted):
    """Belt matching: from a dwell to constant velocity, and back under conditions of its own."""
    programme = turn(move(60, 10.0), BELT, move(50, 25.0, *wanted), move(50, 0.0), DWELLING)
    for stroke in (programme.strokes[0], programme.strokes[2], programme.strokes[3]):
        ends = [stroke.motion(np.array([at]))[:, 0] for at in (stroke.start, stroke.end)]
        states = [end[: len(stroke.law.start)] for end in ends]
        for x in (0.01, 0.3, 0.5, 0.97):
            found = stroke.motion(np.array([stroke.start + x * stroke.angle]))[:, 0]
            exact = fifty_digits(*states, stroke.angle, (found, mp.mpf(x))[1])
            for one, other in zip(found, exact, strict=True):
                assert abs(one - other) <= 1e-12 * (abs(other) + float(np.abs(states).max()))


def test_a_stretch_at_constant_velocity_is_straight():
    """The velocity of a belt: 30 mm in 120°, with neither acceleration nor jerk, and its neighbours reach it."""
    programme = turn(move(60, 10.0), BELT, move(100, 0.0), DWELLING)
    y, y1, y2, y3 = programme.motion_at(np.radians(np.linspace(60.001, 179.999, 50)))
    assert np.allclose(y1, 30 / radians(120), rtol=1e-14)
    assert not y2.any()
    assert not y3.any()
    assert np.allclose(y, 10 + np.linspace(0.001, 119.999, 50) / 4, rtol=1e-13)
    assert not programme.jumps


@pytest.mark.slow
@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", [*PRACTICE, "rocker-valve with ranges"])
def test_scenes_with_moves_against_fifty_digits(name, monkeypatch):
    """Natural conditions of the least jerk as one linear system, and every quantity from the drawn cam."""
    scene = find_scene(name.removesuffix(" with ranges"))
    if name.endswith("ranges"):
        rows = scene.to_dict()["motion"]
        for k, way in ((2, 1), (4, -1)):
            rows[k] |= {"to": [4, 8], "velocity": sorted([way * 20, way * 28])}
        scene = scene.replace(motion=rows)
    with mpmath.workdps(naive.DPS):
        swings = scene.follower.motion == "oscillating"
        pieces = naive_moves.programme(scene.to_dict()["motion"], scene.cam.rpm, swings)
    agrees(scene, pieces, monkeypatch)


def agrees(scene, pieces, monkeypatch):
    """Whether every quantity of a scene is that of smooth pieces at 50 digits."""
    with mpmath.workdps(naive.DPS):
        rough = naive_moves.rough(pieces)
        monkeypatch.setattr(naive, "programme", lambda _, ctx, __: pieces if ctx is mp else rough)
        expected = naive.evaluate(scene.to_dict())
    found = evaluate(scene.replace(outputs=["all"]))
    for key, value in expected.items():
        if isinstance(value, bool):
            assert found[key] is value, key
        else:
            assert found[key] == pytest.approx(float(value), rel=1e-11, abs=1e-12), key


@pytest.mark.slow
def test_windows_that_overlap_against_fifty_digits(monkeypatch):
    """The bolt's windows bind at their edges: the motion is the spline through these, and no other has less jerk.

    ½∫ (y‴)² changes by −[y⁽⁵⁾]·δy + [y⁽⁴⁾]·δy′ at each, with [ ] the jumps there. All that binds is a lower bound,
    and no change is below 0 where δy, δy′ ≥ 0: enough, as the form is convex and the windows are linear.
    """
    scene = find_scene("indexing-overlap")
    shut, moved, rest = scene.to_dict()["motion"]
    asked = [*({"to": y} for y in (8, 12, 12, 8)), {"velocity": -12}, {"to": 0}]
    angles = np.diff([shut["angle"], 100, 110, 230, 240, 255, 290]).tolist()
    through = [{"segment": "move", "angle": angle, **each} for angle, each in zip(angles, asked, strict=True)]
    motion, run = [{**shut, "to": 0}, *through, rest], list(range(1, len(through) + 1))
    with mpmath.workdps(naive.DPS):
        spans, levels = naive_moves.angles_of(motion), naive_moves.positions(motion, None)
        powers, _ = naive_moves.solve_moves(motion, run, spans, levels, None)
        for k, (before, after) in enumerate(pairwise(powers)):
            start, end = spans[k + 1]
            fifth = 120 * (after[5] - before[5])
            fourth = 24 * (after[4] - before[4]) - 120 * before[5] * (end - start)
            pushed, none = (-fifth, fourth) if "to" in asked[k] else (fourth, fifth)
            assert pushed > 1
            assert abs(none) < 1e-40
        pieces = naive_moves.programme(motion)
        for condition in moved["through"]:
            order = "velocity" in condition
            low, high = condition["velocity" if order else "position"]
            for degrees in mp.linspace(*condition["angle"], 421):
                theta = degrees * mp.pi / 180
                value = next(p for p in pieces if theta <= p.end).jet(theta)[order]
                assert low - mp.mpf(10) ** -40 <= value <= high + mp.mpf(10) ** -40
    agrees(scene, pieces, monkeypatch)


# ------------------------------------------------------------------------------------------------------- kinds


def test_pieces_of_a_move_are_what_they_do():
    """A move that goes out and back is a rise, then a return; one that stays is a dwell."""
    programme = turn(("rise", 90, 20.0, "cycloidal"), move(60, 20.0), move(120, 0.0, 30.0), move(90, 0.0))
    kinds_found = [int(kind) for kind in programme.table.kind]
    assert kinds_found[0] == RISE | OUTWARD
    assert set(kinds_found) <= {RISE | OUTWARD, RETURN | INWARD, DWELL | RESTING}
    still = turn(("rise", 90, 20.0, "cycloidal"), ("dwell", 30), move(60, 20.0), ("dwell", 30), move(150, 0.0))
    assert int(still.table.kind[2]) == DWELL | RESTING


def test_other_laws_beside_a_move_change_the_move():
    """A move joins the law that is beside it, whichever it is: here one that starts with an acceleration."""
    programme = turn(move(60, 10.0), ("rise", 100, 30.0, "cycloidal"), move(120, 0.0), DWELLING)
    other = programme.with_laws(programme.strokes[1].law and parabola(), None)
    for each, jump in ((programme, 0.0), (other, 4 * 30 / radians(100) ** 2)):
        before, after = sides(each, radians(60))
        assert isclose(before[2], jump, rel_tol=1e-6, abs_tol=1e-6)
        assert isclose(after[2], jump, rel_tol=1e-6, abs_tol=1e-6)


def parabola():
    from camopt.model.motion import LAWS

    return LAWS["parabolic"]


# ------------------------------------------------------------------------------------------------------ proofs


MOVED = [
    {"segment": "move", "angle": 70, "to": 6},
    {"segment": "constant-velocity", "angle": 60, "to": 14},
    {"segment": "move", "angle": 90, "to": 3, "velocity": -4},
    {"segment": "move", "angle": 70, "to": 0},
    {"segment": "dwell", "angle": 70},
]
HELD_OR_BROKEN = ("pressure_angle", "pressure_angle_return", "acceleration", "velocity", "jerk", "curvature_radius")


@pytest.mark.one_in(4)
@pytest.mark.parametrize("contact", CONTACTS)
def test_limits_near_the_values_of_a_motion_with_moves_are_proved(contact):
    """Ball arithmetic on exact polynomials against the kernels: held above each value, broken below it."""
    scene = Scene.from_dict({**cam_with(contact), "motion": MOVED, "outputs": ["motion", "pressure"], "limits": {}})
    found = evaluate(scene)
    angular = scene.follower.motion == "oscillating"
    names = {
        "pressure_angle": "pressure_angle_max_rise_deg",
        "pressure_angle_return": "pressure_angle_max_return_deg",
        "velocity": "velocity_max_rad_s" if angular else "velocity_max_m_s",
        "acceleration": "acceleration_max_rad_s2" if angular else "acceleration_max_m_s2",
        "jerk": "jerk_max_rad_s3" if angular else "jerk_max_m_s3",
    }
    for limit, name in names.items():
        value = float(found[name])
        if value < 1e-9:
            continue  # a flat face has no pressure angle
        for share, verdict in ((1e-9, "held"), (-1e-9, "broken")):
            limits = {"pressure_angle_return": 89, "pressure_angle": 89, limit: value * (1 + share)}
            proof = certify(scene.replace(limits=limits))
            assert proof[limit] == verdict, (limit, share)


@given(turns())
def test_the_highest_of_a_turn_is_proved(segments):
    programme = turn(*segments)
    highest = exact_turn(programme).lift.arb
    assert abs(float(highest.mid()) - programme.lift) <= 1e-9 * programme.lift


# ------------------------------------------------------------------------------------------------------- scenes


def scene_of(*motion, **cam):
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 8}
    return {"cam": {"form": "disc", "base_radius": 60, **cam}, "follower": follower, "motion": list(motion)}


REST = {"segment": "dwell", "angle": 120}


@pytest.mark.parametrize(("per", "factor"), [("rad", 1.0), ("deg", 180 / pi), ("s", 60 / (2 * pi * 90))])
@pytest.mark.parametrize("name", ORDERS)
def test_derivatives_are_given_by_angle_or_by_time(name, per, factor):
    """mm by rad, by deg or by second to the same power: 90 rev/min are 3π rad/s."""
    condition = {name: 5.0 / factor ** ORDERS[name], "per": per}
    scene = Scene.from_dict(
        scene_of(
            {"segment": "move", "angle": 100, "to": 12, **condition},
            {"segment": "move", "angle": 140, "to": 0},
            REST,
            rpm=90,
        )
    )
    programme = resolve(scene).programme
    before = programme.strokes[0]
    assert isclose(before.motion(np.array([before.end]))[ORDERS[name], 0], 5.0, rel_tol=1e-12)


def test_a_velocity_is_another_way_to_give_a_stretch():
    by_position = Scene.from_dict(
        scene_of(
            {"segment": "move", "angle": 60, "to": 10},
            {"segment": "constant-velocity", "angle": 120, "to": 40},
            {"segment": "move", "angle": 60, "to": 0},
            REST,
        )
    )
    by_speed = by_position.replace(
        motion=[{**s.model_dump(exclude_none=True, exclude_defaults=True)} for s in by_position.motion]
    )
    motion = [dict(s) for s in by_speed.to_dict()["motion"]]
    del motion[1]["to"]
    motion[1] |= {"velocity": 0.25, "per": "deg"}
    other = by_position.replace(motion=motion)
    angles = np.linspace(0.0, 6.0, 50)
    one, two = (resolve(each).programme.motion_at(angles) for each in (by_position, other))
    assert np.allclose(one, two, rtol=1e-12, atol=1e-9)


def test_a_turn_of_positions_may_start_anywhere():
    """A cam that starts half way up: its base circle is where the follower is lowest."""
    scene = Scene.from_dict(
        scene_of(
            {"segment": "rise", "angle": 90, "to": 30, "law": "cycloidal"},
            {"segment": "return", "angle": 120, "to": -5, "law": "cycloidal"},
            {"segment": "rise", "angle": 150, "to": 12, "law": "poly345"},
        )
    )
    programme = resolve(scene).programme
    assert programme.lift == pytest.approx(35.0, rel=1e-15)
    assert programme.motion_at(np.zeros(1))[0, 0] == pytest.approx(17.0, rel=1e-15)
    plain = Scene.from_dict(
        scene_of(
            {"segment": "rise", "angle": 150, "lift": 17, "law": "poly345"},
            {"segment": "rise", "angle": 90, "lift": 18, "law": "cycloidal"},
            {"segment": "return", "angle": 120, "lift": 35, "law": "cycloidal"},
        )
    )
    one, two = evaluate(scene), evaluate(plain)
    for name in ("pressure_angle_max_deg", "profile_radius_min_mm", "pitch_curvature_max_per_mm"):
        assert one[name] == pytest.approx(two[name], rel=1e-12)


RISE_ROW = {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"}
BACK = {"segment": "move", "angle": 120, "to": 0}
MISTAKES = [
    ([RISE_ROW, {**BACK, "to": None}, REST], "motion.2.to: missing; a move goes to a position"),
    ([RISE_ROW, {**BACK, "to": [1, 2]}, REST], "motion.2.to = [1, 2]: must be a number: a move goes to a position"),
    ([RISE_ROW, {**BACK, "velocity": [2, 1]}, REST], "motion.2.velocity = [2, 1]: must be a number, or a range"),
    ([RISE_ROW, {**BACK, "velocity": [1, 2, 3]}, REST], "motion.2.velocity = [1, 2, 3]: must be a number, or"),
    (
        [RISE_ROW, {**BACK, "jerk": "none"}, REST],
        "motion.2.jerk = 'none': must be a number, or a range",
    ),
    (
        [{**RISE_ROW, "lift": None, "to": [3, 4]}, BACK, REST],
        "motion.1.to = [3, 4]: must be a number; only a move may have a range",
    ),
    (
        [RISE_ROW, {**BACK, "lift": 3}, REST],
        "motion.2.lift = 3: a move has none: give the position",
    ),
    (
        [RISE_ROW, {**BACK, "law": "poly345"}, REST],
        "motion.2.law = 'poly345': is for a rise or return; a move takes a law of positions",
    ),
    ([RISE_ROW, BACK, {**REST, "velocity": 2}], "motion.3.velocity = 2: a dwell has none: conditions are for a m"),
    (
        [RISE_ROW, {**BACK, "velocity": 2, "per": "s"}, REST],
        "motion.2.per = 's': derivatives by time need",
    ),
    ([RISE_ROW, {**BACK, "per": "turn"}, REST], "motion.2.per = 'turn': must be one of 'rad', 'deg' or 's'"),
    ([{**RISE_ROW, "to": 20}, BACK, REST], "motion.1.lift = 20: give either the lift or the position at its"),
    (
        [RISE_ROW, {"segment": "constant-velocity", "angle": 120}, REST],
        "motion.2.to: missing; give the position at its end (to) or the velocity",
    ),
    (
        [RISE_ROW, {"segment": "constant-velocity", "angle": 120, "to": 3, "velocity": 1}, {**BACK, "angle": 120}],
        "motion.2.velocity = 1: give either the velocity or the position at its end (to): the segment",
    ),
    ([{**RISE_ROW, "lift": None}, BACK, REST], "motion.1.lift: missing; give the lift or the position at its end"),
    ([RISE_ROW, BACK, {**REST, "to": 0}], "motion.3.to = 0: a dwell has none"),
    ([RISE_ROW, {**BACK, "angle": -10}, {**REST, "angle": 250}], "motion.2.angle = -10: must be at least 0"),
    ([RISE_ROW, {**BACK, "jerk": 1e308}, REST], "motion.2.jerk = 1e+308: must be a number, or a range"),
    (
        [{"segment": "rise", "angle": 120, "to": -4, "law": "cycloidal"}, BACK, REST],
        "motion.1.to = -4: must be above 0, where this rise starts",
    ),
    ([{"segment": "move", "angle": 240, "to": 5}, REST], "motion: never moves"),
    (
        [RISE_ROW, {**BACK, "angle": 0}, {**REST, "angle": 240}],
        "motion.2.angle = 0: must be at least 1e-06",
    ),
]


@pytest.mark.parametrize(("motion", "line"), MISTAKES)
def test_mistakes_in_segments_that_join(motion, line):
    rows = [{key: value for key, value in row.items() if value is not None} for row in motion]
    with pytest.raises(BadInput) as caught:
        Scene.from_dict(scene_of(*rows), "cam.toml")
    (found,) = str(caught.value).splitlines()
    assert found.startswith(f"cam.toml: {line}")


def test_an_arm_swings_no_further_than_it_may_inside_a_move():
    """The highest of a move may be between its ends: what cannot be put together is told all the same."""
    scene = cam_with("arm")
    scene["motion"] = [{**BACK, "to": 60, "velocity": 300}, {**BACK, "to": 0}, REST]
    with pytest.raises(BadInput, match="must stay below 180 deg"):
        Scene.from_dict(scene)


@pytest.mark.parametrize("kind", ["rise", "return", "dwell"])
def test_angles_beside_moves_are_not_freed(kind):
    scene = scene_of(RISE_ROW, BACK, REST)
    scene["search"] = {f"angle_{kind}": {"start": 50, "stop": 150}}
    with pytest.raises(BadInput, match=r"cannot vary|has no return"):
        Scene.from_dict(scene)


def test_kinds_of_segments_are_known_everywhere():
    """A quantity of rises is that of the pieces of a move that go up."""
    scene = Scene.from_dict({**scene_of(*MOVED), "outputs": ["pressure"]})
    found = evaluate(scene)
    programme = resolve(scene).programme
    assert all(programme.has_kinds(kind) for kind in (RISE, RETURN, DWELL))
    both = [float(found[f"pressure_angle_max_{kind}_deg"]) for kind in ("rise", "return")]
    assert max(both) == found["pressure_angle_max_deg"]
    assert min(both) > 0.0


def test_what_a_move_is_given_is_marked_in_its_diagrams():
    """A square at the end of each move, and at each derivative that is given there; a band where the lash is."""
    scene = find_scene("bucket-valve")
    displacement, velocity, acceleration, *_ = motion_panels(Picture(scene, resolve(scene)))
    assert [round(mark.end) for mark in displacement.marks] == [12, 24, 46, 92, 138, 160, 172, 184]
    assert displacement.marks[3][2:] == pytest.approx((9.0, 9.0))
    omega = 3000 * 2 * pi / 60
    assert [mark.low for mark in velocity.marks] == pytest.approx([v * omega / 1e3 for v in (0.8, 12.5, -12.5)])
    assert acceleration.marks == [(pytest.approx(12.0), pytest.approx(12.0), 0.0, 0.0)]
    assert displacement.bands == [pytest.approx((0.1, 0.2))]


def test_ranges_of_a_scene_are_kept_by_text_and_drawn_as_bars():
    rows = ({**BACK, "to": [18, 22], "velocity": [2, 9], "per": "rad"}, BACK, REST)
    scene = Scene.from_dict(scene_of(*rows))
    assert Scene.from_dict(scene.to_dict()) == scene
    assert scene.to_dict()["motion"][0]["to"] == [18, 22]
    displacement, velocity, *_ = motion_panels(Picture(scene, resolve(scene)))
    assert displacement.marks[0] == pytest.approx((120.0, 120.0, 18.0, 22.0))
    assert velocity.marks[0] == pytest.approx((120.0, 120.0, 2.0, 9.0))
    assert 18 - 1e-9 <= resolve(scene).programme.strokes[0].high <= 22 + 1e-9
    assert certify(scene.replace(**{"limits.pressure_angle": 80}))["pressure_angle"] == "held"


def test_a_position_next_to_nothing_is_none():
    """Numbers that only underflow: the motion is that of position 0."""
    rows = [{**BACK, "to": 5}, {**BACK, "to": 1e-320}, REST]
    one, other = (resolve(Scene.from_dict(scene_of(*each))) for each in (rows, [rows[0], BACK, REST]))
    assert one.programme == other.programme

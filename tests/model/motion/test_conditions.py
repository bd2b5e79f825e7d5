"""Conditions on the way of moves: least-jerk motions and free laws that meet them, bounds, and contradictions."""

import sys
from dataclasses import replace
from math import inf, pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq, linprog, minimize
from scipy.special import beta
from support.depth import times
from support.pictures import faults_of

sys.path.insert(0, str(Path(__file__).parents[3] / "benchmarks"))
import conditions as study

from camopt import BadInput, Scene, certify, evaluate, find_scene, plot, synthesise
from camopt.core.mistakes import Unmet
from camopt.core.numerics.irreducible import irreducible_set
from camopt.core.numerics.quadratic import constrained_least_squares
from camopt.model.motion.move_run import (
    MoveRun,
    bernstein_derivative_matrix,
    derivative_mean_weights,
    states_to_bernstein_matrix,
)
from camopt.model.motion.programme import Programme, derivative_root_mean_square, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES, SOLVER_TOLERANCE, PassingCondition
from camopt.scene.problem.problem import resolve
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.relaxed_optimum import relaxation_bound
from camopt.solve.verdicts.certify import verdict_on_all_move_conditions

MOVES = [{"segment": "move", "angle": 200, "to": 40}, {"segment": "dwell", "angle": 20}]
BACK = [{"segment": "move", "angle": 120, "to": 0}, {"segment": "dwell", "angle": 20}]
BELT = {"angle": [90, 120], "velocity": 14}


def scene_of(*motion):
    return Scene.from_dict({"cam": study.CAM, "follower": study.FOLLOWER, "motion": list(motion)})


def meets(programme, conditions, room):
    """Whether a motion meets conditions of a scene, on samples."""
    up = -programme.strokes[0].low
    for each in conditions:
        low, high = each["angle"] if isinstance(each["angle"], list) else (each["angle"], each["angle"])
        motion = programme.motion_at(np.radians(np.linspace(low, high, 501 if high > low else 1)))
        for order, name in enumerate(("position", "velocity", "acceleration", "jerk")):
            asked = each.get(name)
            if asked is not None:
                ends = asked if isinstance(asked, list) else (asked, asked)
                values = motion[order] + up * (order == 0)
                by = room * max(1.0, np.abs(ends).max())
                if values.min() < ends[0] - by or values.max() > ends[1] + by:
                    return False
    return True


# ---------------------------------------------------------------------------------------------- the least jerk


def test_a_move_through_points_is_as_if_it_were_several_moves():
    through = [
        {"angle": 70, "position": 9, "velocity": 12},
        {"angle": 130, "position": [20, 22], "acceleration": 4},
    ]
    one = resolve(study.scene_with(through)).programme
    parts = [
        {"segment": "move", "angle": 70, "to": 9, "velocity": 12},
        {"segment": "move", "angle": 60, "to": [20, 22], "acceleration": 4},
        {"segment": "move", "angle": 70, "to": 40},
    ]
    other = resolve(scene_of(*parts, *MOVES[1:], *BACK))
    angles = np.radians(np.arange(0.25, 360, 0.5))
    assert np.allclose(one.motion_at(angles), other.programme.motion_at(angles), rtol=1e-8, atol=1e-8)
    assert [stroke.key for stroke in one.strokes] == ["motion.1", "motion.2", "motion.3", "motion.4"]


@settings(max_examples=times(5, deep=100), deadline=None)
@given(st.integers(0, 10**6))
def test_the_least_jerk_meets_random_conditions_and_no_motion_has_less(seed):
    """The bound of the relaxation, which knows nothing of polynomials, is just below it."""
    conditions = study.feasible(np.random.default_rng(seed))
    scene = study.scene_with(conditions, **{"synthesis.minimise": "jerk_rms", "cam.rpm": None})
    programme = resolve(scene).programme
    assert meets(programme, conditions, 1e-8)
    assert not programme.jumps
    problem = build_synthesis_problem(scene)
    wide = problem.keep_limits(
        [name for name in problem.limit_names if name not in ("jerk", "acceleration", "the size")]
    )
    freed = wide.keep_limits([name for name in wide.limit_names if name != "the lowest position"])
    bound, own = relaxation_bound(freed), derivative_root_mean_square(programme, 3)
    assert bound is not None
    assert own * 0.985 <= bound <= own * (1 + 1e-5)


def test_a_motion_that_is_given_all_along_is_that_line():
    """Nothing is left to choose, and what is asked besides is just met."""
    asked = [{"angle": [80, 280], "acceleration": 0}, {"angle": [80, 160], "position": [40, 80]}]
    rows = [
        {"segment": "constant-velocity", "angle": 80, "to": 40},
        {"segment": "move", "angle": 200, "to": 140, "through": asked},
        {"segment": "constant-velocity", "angle": 40, "to": 160},
        {"segment": "move", "angle": 40, "to": 0},
    ]
    programme = resolve(scene_of(*rows)).programme
    angles = np.radians(np.linspace(81, 279, 100))
    assert np.allclose(programme.motion_at(angles)[1], 40 / radians(80), rtol=1e-9)


def test_a_belt_on_the_way_of_a_move_is_a_stretch_at_constant_velocity():
    programme = resolve(study.scene_with([BELT])).programme
    motion = programme.motion_at(np.radians(np.linspace(90.01, 119.99, 300)))
    assert np.allclose(motion[1], 14, rtol=1e-9)
    assert np.abs(motion[2]).max() < 1e-6
    assert evaluate(study.scene_with([BELT], **{"limits.pressure_angle": 30}))["feasible"]


@pytest.mark.parametrize("name", ["position", "velocity", "acceleration", "jerk"])
def test_a_range_of_angles_holds_eachderivative_of_and_costs_jerk(name):
    order = ("position", "velocity", "acceleration", "jerk").index(name)
    free = resolve(study.scene_with([])).programme
    angles = np.radians(np.linspace(60, 90, 500))
    values = free.motion_at(angles)[order]
    largest = float(values.max() - 0.4 * np.ptp(values))
    conditions = [{"angle": [60, 90], name: [float(values.min() - 5 * np.ptp(values)), largest]}]
    bent = resolve(study.scene_with(conditions)).programme
    assert -3e-3 <= bent.motion_at(angles[1:-1])[order].max() / abs(largest) - np.sign(largest) <= 1e-8
    assert derivative_root_mean_square(bent, 3) > derivative_root_mean_square(free, 3)


@pytest.mark.slow
def test_conditions_are_kept_by_text_proved_beside_and_drawn(tmp_path):
    scene = study.scene_with([BELT, {"angle": 40, "position": [2, 5]}], **{"limits.pressure_angle": 35})
    assert Scene.from_dict(scene.to_dict()) == scene
    assert certify(scene)["pressure_angle"] == "held"
    displacement, velocity, *_ = motion_panels(Picture(scene, resolve(scene)))
    assert displacement.note.startswith("squares and bands: conditions of moves")
    assert (90, 120) in [(round(mark.start), round(mark.end)) for mark in velocity.marks]
    (tmp_path / "cam.toml").write_text(scene.to_toml(), encoding="utf-8")
    assert Scene.from_toml(tmp_path / "cam.toml") == scene
    assert not faults_of(plot(scene, tmp_path / "cam.png"))


def test_what_is_asked_twice_is_no_contradiction():
    more = [{"angle": 100, "velocity": 14}, {"angle": [100, 110], "velocity": [14, 14], "acceleration": 0}]
    angles = np.radians(np.arange(0.25, 360, 0.5))
    once = resolve(study.scene_with([BELT])).programme.motion_at(angles)
    for some in (more, more[:1], [{"angle": [95, 118], "jerk": 0}], [BELT, BELT]):
        again = resolve(study.scene_with([BELT, *some])).programme.motion_at(angles)
        assert np.allclose(once, again, rtol=1e-6, atol=1e-5)


def test_conditions_per_degree_and_per_second_are_the_same():
    scenes = []
    for per, velocity in (("rad", 14.0), ("deg", 14.0 * np.pi / 180), ("s", 14.0 * 2 * np.pi)):
        row = MOVES[0] | {"per": per, "through": [{"angle": [90, 120], "velocity": velocity}]}
        scenes.append(scene_of(row, *MOVES[1:], *BACK))
    angles = np.radians(np.arange(0.25, 360, 0.5))
    first, *others = (resolve(scene).programme.motion_at(angles) for scene in scenes)
    assert all(np.allclose(first, other, rtol=1e-9, atol=1e-9) for other in others)


# ------------------------------------------------------------------------------------------------- free laws


@pytest.mark.slow
@settings(max_examples=times(4, deep=60), deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["jerk_rms", "acceleration", "jerk"]))
def test_free_laws_meet_random_conditions_near_their_bound(seed, minimise):
    conditions = study.feasible(np.random.default_rng(seed))
    scene = study.scene_with(conditions, **{"synthesis.minimise": minimise, "synthesis.pieces": 32})
    result = synthesise(scene)
    programme = resolve(result.scene).programme
    assert meets(programme, conditions, 1e-5)
    assert not programme.jumps
    assert result.bound is not None
    assert result.bound <= result.objective * (1 + 1e-6)
    assert result.gap < (0.01 if minimise == "jerk_rms" else 0.15)


def test_the_least_peak_acceleration_through_a_belt_is_that_of_parabolas():
    """The belt's height is free: the two sides share what is left so that the worse of them is least."""
    scene = study.scene_with(
        [{"angle": [80, 120], "velocity": 14.0}],
        **{"synthesis.minimise": "acceleration", "synthesis.pieces": 60, "limits.jerk": 1e7},
    )
    before, along, after = np.radians([80.0, 40.0, 80.0])

    def least_acceleration(theta, lift, u, w):
        off = abs(lift - theta * (u + w) / 2)
        return 2 * off / theta**2 + sqrt((2 * off / theta**2) ** 2 + ((w - u) / theta) ** 2)

    def larger(height):
        rest = 40.0 - height - 14.0 * along
        return max(least_acceleration(before, height, 0.0, 14.0), least_acceleration(after, rest, 14.0, 0.0))

    up = min(larger(height) for height in np.linspace(0, 30, 30001))
    back = 4 * 40.0 / radians(120) ** 2
    result, best = synthesise(scene), max(up, back) * (2 * np.pi) ** 2 / 1e3
    assert best * (1 - 2e-3) <= result.bound <= best * (1 + 1e-5)
    assert result.objective <= best * 1.03


@pytest.mark.slow
def test_conditions_and_limits_that_contradict_each_other_are_named_together():
    scene = study.scene_with(
        [{"angle": 60, "position": 5}, {"angle": 120, "position": 35}, {"angle": 150, "velocity": [0, 50]}],
        **{"limits.velocity": 0.15, "cam.rpm": 60, "synthesis.minimise": "jerk_rms"},
    )
    with pytest.raises(Unmet) as caught:
        synthesise(scene)
    words = str(caught.value)
    assert "these 3 contradict each other" in words
    assert all(key in words for key in ("velocity", "motion.1.through.1.position", "motion.1.through.2.position"))
    assert "through.3" not in words


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@pytest.mark.parametrize("where", [(80.0, 80.0), (60.0, 95.0)], ids=["angle", "range"])
def test_conditions_are_proved_just_up_to_what_the_motion_has(order, where):
    """A range that ends a little beyond the largest value is held, one that ends a little before it is broken."""
    programme = resolve(study.scene_with([{"angle": 120, "position": 30}])).programme
    first, *others = programme.strokes
    start, end = map(radians, where)
    values = first.motion(np.linspace(start, end, 20_001 if end > start else 1))[order] / first.size
    values = values - programme.strokes[0].low * (order == 0)
    largest = np.abs(first.motion(np.linspace(0.0, first.angle, 20_001))[order]).max()
    verdicts = []
    for side in (3.0, -3.0):
        asked: list = [None] * 4
        asked[order] = (
            float(values.min()) - largest,
            float(values.max()) + side * SOLVER_TOLERANCE[order] * float(largest),
        )
        turn = replace(
            programme, strokes=(replace(first, through=(PassingCondition(start, end, tuple(asked)),)), *others)
        )
        verdicts.append(verdict_on_all_move_conditions(turn))
    assert verdicts == ["held", "broken"]


def test_what_is_asked_of_nothing_has_no_verdict():
    assert "conditions" not in certify(find_scene("roller-1000rpm"))
    assert certify(study.scene_with([BELT]))["conditions"] == "held"


# ------------------------------------------------------------------------------------------- contradictions


@pytest.mark.slow
@settings(max_examples=times(4, deep=100), deadline=None)
@given(st.integers(0, 10**6))
def test_contradictory_conditions_are_named_and_without_any_of_them_there_is_a_motion(seed):
    conditions = study.contradictory(np.random.default_rng(seed))
    named = study.irreducible_of(conditions)
    assert len(named) >= 2
    assert study.irreducible_of([conditions[k] for k in named]) == list(range(len(named)))
    for left_out in named:
        others = [conditions[k] for k in named if k != left_out]
        assert meets(resolve(study.scene_with(others)).programme, others, 1e-8)


def test_the_message_names_what_contradicts_and_what_helps():
    with pytest.raises(BadInput) as caught:
        study.scene_with([{"angle": [50, 60], "velocity": [1, 2]}, {"angle": 55, "velocity": 3}])
    assert str(caught.value) == (
        "scene: motion.1.through.1.velocity: contradicts motion.1.through.2.velocity: "
        "no motion meets all of these; leave one out, or give a wider range"
    )


def nose(low, high):
    """A valve's lift of 9 mm from a ramp, its acceleration within bounds, mm/rad²; rising, then the same back."""
    bounds = {"acceleration": [low, high]}
    return scene_of(
        {"segment": "move", "angle": 12, "to": 0.08, "velocity": 0.8, "acceleration": 0},
        {"segment": "constant-velocity", "angle": 12, "velocity": 0.8},
        {"segment": "move", "angle": 60, "to": 9, "through": [{"angle": [24, 84], **bounds}]},
        {"segment": "move", "angle": 60, "through": [{"angle": [84, 144], **bounds}]},
        {"segment": "constant-velocity", "angle": 12, "to": 0.08, "velocity": -0.8},
        {"segment": "move", "angle": 12, "to": 0},
        {"segment": "dwell", "angle": 192},
    )


def least_depth(high):
    """How far below 0 the acceleration must go where it jumps from ``high`` once, as no smooth motion does."""
    start, end, angle, velocity = 0.08 + 0.8 * radians(12), 9.0, radians(60), 0.8
    share = brentq(  # of the angle at the upper bound, after which velocity goes to 0 as lift gets to 9
        lambda x: (
            start + velocity * angle + high * x * angle**2 * (1.0 - x / 2.0)
            - (velocity + high * x * angle) * angle * (1.0 - x) / 2.0 - end
        ),
        0.0,
        1.0,
    )  # fmt: skip
    return (velocity + high * share * angle) / ((1.0 - share) * angle)


def test_bounds_on_acceleration_are_met_where_a_motion_between_their_ends_exists():
    """Nearly as far as a motion that jumps between them; nearer than that it is not said that there is none."""
    least = least_depth(60.0)
    assert 20.9 < least < 21.2  # moves with short joins have 21.13, of 59.9
    programme = resolve(nose(-21.9, 60.0)).programme
    angles = np.radians(np.linspace(24.0, 144.0, 5001))[1:-1]
    acceleration = programme.motion_at(angles)[2]
    assert [acceleration.min() > -21.9001, acceleration.max() < 60.0001] == [True, True]
    assert programme.motion_at(np.radians([84.0]))[0, 0] == pytest.approx(9.0, abs=1e-9)
    with pytest.raises(BadInput, match=r"no motion was found that meets all of these, with each range in 48 parts"):
        nose(-least - 0.05, 60.0)
    with pytest.raises(BadInput, match=r"motion\.4\.through\.1\.acceleration: no motion meets all of these"):
        nose(0.99 * -least, 60.0)


@pytest.mark.parametrize("count", [3, 4])
@pytest.mark.parametrize("order", range(4))
def testmeans_between_of_aderivative_of_are_divided_differences_of_any_motion(count, order):
    """Of y = cos(3x) on 0 to 1, from its states there, against integrals with the weights."""
    verbs = [lambda x, k=k: 3.0**k * np.cos(3.0 * x + k * pi / 2) for k in range(4)]
    ends = np.array([verbs[k](x) for x in (0.0, 1.0) for k in range(count)])
    found = (
        derivative_mean_weights(count, order)
        @ bernstein_derivative_matrix(count, order)
        @ states_to_bernstein_matrix(count, 1.0)
        @ ends
    )
    orders = [(i, order + 1 - i) for i in range(order + 2) if max(i, order + 1 - i) <= count]

    def mean(i, j):
        if not i * j:
            return verbs[order](float(i == 0))
        return quad(lambda x: (1 - x) ** (i - 1) * x ** (j - 1) * verbs[order](x), 0, 1)[0] / beta(i, j)

    integrals = [mean(i, j) for i, j in orders]
    assert found == pytest.approx(integrals, rel=1e-9)


@settings(max_examples=times(5, deep=100), deadline=None)
@given(st.integers(0, 10**6))
def test_what_a_motion_meets_is_not_said_to_be_impossible(seed):
    """The bounds of a motion itself, on a range, with no room, however wide splines between the same cuts are."""
    random = np.random.default_rng(seed)
    motion = np.polynomial.Polynomial(random.normal(size=9)) * np.polynomial.Polynomial([0, 0, 0, 1.0])
    x = np.linspace(0.0, radians(200.0), 4001)
    (start, end), order = np.sort(random.choice(np.arange(10, 190), 2, replace=False)), int(random.integers(0, 4))
    values = motion.deriv(order)(x[(x >= radians(start)) & (x <= radians(end))])
    asked: list = [None] * 4
    asked[order] = (float(values.min()) - 1e-9, float(values.max()) + 1e-9)
    turn = resolve(scene_of(*MOVES, *BACK)).programme
    last = turn.strokes[0].angle
    run = MoveRun(
        [
            replace(
                turn.strokes[0],
                high=float(motion(last)),
                wanted=(None, float(motion.deriv(1)(last)), float(motion.deriv(2)(last))),
                given=turn.strokes[0].given._replace(change=float(motion(last))),
                through=(PassingCondition(radians(start), radians(end), tuple(asked)),),
            )
        ],
        turn.strokes[-1],
        turn.strokes[1],
        0.0,
        48,
    )
    assert not run.is_proved_impossible()


@given(st.lists(st.tuples(st.integers(-5, 5), st.integers(-5, 5)), min_size=1, max_size=6))
def test_an_irreducible_set_of_intervals_is_one_or_two(intervals):
    """Intervals of a line meet if each two of them do (Helly)."""
    numbered = list(enumerate(intervals))

    def feasible(some):
        return max((low for _, (low, _) in some), default=-9) <= min((high for _, (_, high) in some), default=9)

    assume(not feasible(numbered))
    found = irreducible_set(numbered, feasible)
    assert not feasible(found)
    assert all(feasible([other for other in found if other != each]) for each in found)
    assert len(found) <= 2


@settings(max_examples=times(20, deep=400), deadline=None)
@given(st.integers(0, 10**6))
def test_least_squares_under_limits_are_those_of_a_general_solver(seed):
    random = np.random.default_rng(seed)
    n, m = random.integers(1, 6), random.integers(1, 10)
    factor, offset = random.normal(size=(n + 3, n)), random.normal(size=n + 3)
    rows, least = random.normal(size=(m, n)), random.normal(size=m)
    found = constrained_least_squares(factor, offset, rows, least)
    known = linprog(np.zeros(n), A_ub=-rows, b_ub=-least, bounds=[(None, None)] * n)
    assert (found is not None) == (known.status == 0)
    assume(found is not None)
    assert np.all(rows @ found >= least - 1e-8)

    def cost(x):
        return float(np.sum((factor @ x + offset) ** 2))

    limits = {"type": "ineq", "fun": lambda x: rows @ x - least}
    other = minimize(cost, known.x, constraints=limits, method="SLSQP", options={"ftol": 1e-14, "maxiter": 500})
    assert cost(found) <= cost(other.x) * (1 + 1e-6) + 1e-9


# ------------------------------------------------------------------------------------------------- mistakes

MISTAKES = [
    (
        {"angle": 250, "position": 5},
        "motion.1.through.1.angle = 250: must be inside the move, between 0 and 200 deg",
    ),
    ({"angle": 200, "position": 40}, "for its end use to, velocity, …"),
    ({"angle": [190, 210], "position": 5}, "must be a range within the move, from 0 to 200 deg of the turn"),
    ({"angle": [20, 10], "position": 5}, "must be a cam angle, or a range [from, to], deg, from 0 to 360"),
    ({"angle": 50}, "motion.1.through.1: has no condition: give position, velocity, acceleration or jerk"),
    ({"position": 5}, "motion.1.through.1.angle: missing"),
    ({"angle": 50, "position": [8, 5]}, "motion.1.through.1.position"),
    ({"angle": 50, "position": "high"}, "motion.1.through.1.position"),
    ({"angle": "50", "position": 5}, "motion.1.through.1.angle"),
    ({"angle": 50, "height": 5}, "motion.1.through.1.height"),
    ({"angle": inf, "position": 5}, "motion.1.through.1.angle"),
    ({"angle": 50, "velocity": 5, "per": "s"}, "per = 's': belongs to the segment, for all its derivatives"),
    ({"angle": [0, 200], "velocity": [0, 5]}, "contradicts the segments next to the moves, or the positions at"),
]


@pytest.mark.parametrize(("condition", "message"), MISTAKES)
def test_mistakes_in_conditions(condition, message):
    with pytest.raises(BadInput) as caught:
        study.scene_with([condition])
    assert message in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    "segment",
    [
        {"segment": "dwell", "angle": 200},
        {"segment": "rise", "angle": 200, "lift": 40, "law": "poly345"},
        {"segment": "constant-velocity", "angle": 200, "to": 40},
    ],
)
def test_only_moves_have_conditions(segment):
    motion = [segment | {"through": [{"angle": 50, "position": 5}]}, MOVES[0] | {"angle": 20}, *BACK]
    with pytest.raises(BadInput, match=r"motion\.1\.through"):
        scene_of(*motion)


def test_a_law_of_a_move_that_misses_a_condition_is_said():
    result = synthesise(study.scene_with([BELT], **{"synthesis.minimise": "jerk_rms", "synthesis.pieces": 12}))
    data = result.scene.to_dict()
    data["motion"][0]["through"][0]["velocity"] = 15
    with pytest.raises(BadInput, match=r"has velocity 1\d\.?\d* by rad; motion.1.through.1.velocity requires 15"):
        Scene.from_dict(data)


def test_a_free_move_over_a_part_of_the_turn_has_the_extremes_that_its_samples_have():
    result = synthesise(study.scene_with([BELT], **{"synthesis.minimise": "acceleration", "synthesis.pieces": 24}))
    programme = resolve(result.scene).programme
    angles = np.radians(np.arange(0.005, 360, 0.01))
    for order in (1, 2, 3):
        low, high = weighted_derivative_range(Programme(programme.strokes), (0.0,) * order + (1.0,), ALL_STROKES)
        values = programme.motion_at(angles)[order]
        assert low - 1e-9 <= values.min()
        assert values.max() <= high + 1e-9


def test_a_move_may_be_given_by_its_conditions_alone():
    rest = {"segment": "dwell", "angle": 160}
    one = scene_of({"segment": "move", "angle": 200, "to": 0, "through": [{"angle": 95, "position": 35}]}, rest)
    assert resolve(one).programme.lift >= 35 - 1e-9
    parts = ({"segment": "move", "angle": 100, "to": [60, 75]}, {"segment": "move", "angle": 100, "to": 0})
    assert 60 - 1e-9 <= resolve(scene_of(*parts, rest)).programme.lift <= 75 + 1e-9
    with pytest.raises(BadInput, match="never moves: no position or condition differs from its start"):
        scene_of({"segment": "move", "angle": 100}, parts[1], rest)


def test_free_moves_may_go_as_low_as_a_range_allows():
    """A band about the dwell: the motion may use both sides of it, and the size has no bound then."""
    banded = study.scene_with(
        [{"angle": [5, 60], "position": [-0.5, 0.5]}], **{"synthesis.minimise": "jerk_rms", "synthesis.pieces": 24}
    )
    result = synthesise(banded)
    programme = resolve(result.scene).programme
    assert programme.strokes[0].low > 0.2  # where the turn starts, above the lowest
    assert result.gap < 0.01
    sized = {
        "synthesis.minimise": "size",
        "limits.pressure_angle": 30,
        "search.base_radius": {"start": 5, "stop": 900},
    }
    assert synthesise(banded.replace(**sized)).bound is None


def test_a_jerk_of_zero_over_a_range_is_held_by_free_laws():
    asked = [{"angle": [40, 80], "jerk": 0, "velocity": [5, 10]}]
    scene = study.scene_with(asked, **{"synthesis.minimise": "acceleration", "synthesis.pieces": 24})
    programme = resolve(synthesise(scene).scene).programme
    jerk = programme.motion_at(np.radians(np.linspace(40.001, 79.999, 400)))[3]
    assert np.abs(jerk).max() <= 1e-6 * np.abs(programme.motion_at(np.radians(np.arange(0.5, 360)))[3]).max()

"""Verdicts of constraints from extremes of their curves, against the quantities that limits compare with bounds."""

from dataclasses import replace

import numpy as np
import pytest

from camopt import find_scene
from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.known_extremes import NOTHING_KNOWN
from camopt.model.motion.stroke import DWELL, RETURN, RISE
from camopt.scene.problem.constraints import merge_constraints_over_stroke_kinds
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.sample import sweep_space
from camopt.solve.verdicts.feasible_filter import known_extremes_with_limited_curve, may_hold_and_holds_by_extremes
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts

SEARCH = {"search.base_radius": {"start": 40, "stop": 160, "step": 8}, "search.offset": [-20, 0, 20]}
KINDS = ("rise", "dwell", "return")


def problem_of(**limits: float):
    """Of the first law of a scene with bounds on the pressure angle; and some designs."""
    scene = find_scene("roller-1000rpm").replace(
        **SEARCH, **{f"limits.{key}": value for key, value in limits.items()}
    )
    space = sweep_space(resolve(scene.replace(**{"search.law": ["cycloidal"]})))
    return space.problem, space.problem.setup.mechanism.pitch(space.designs(np.arange(len(space))))


@pytest.mark.parametrize(
    "limits", [{"pressure_angle": 30.0}, {"pressure_angle": 25.0, "pressure_angle_return": 40.0}]
)
@pytest.mark.parametrize("apart", [(), (RISE, RETURN, DWELL)])
def test_constraints_are_held_where_their_quantities_hold_the_bounds(limits, apart):
    problem, designs = problem_of(**limits)
    case = EvaluationBlock(problem.setup, problem.programme, designs)
    constraints = merge_constraints_over_stroke_kinds(
        constraint for limit in problem.pitch_curve_limits for constraint in limit.constraints
    )
    assert len(constraints) == len(limits)
    known = known_extremes_with_limited_curve(case, constraints, [(constraints[0].curve, kinds) for kinds in apart])
    assert len(known.by_curve[constraints[0].curve]) == (3 if apart else len(limits))
    possible, held = may_hold_and_holds_by_extremes(known, constraints, case)
    names = [f"pressure_angle_max_{kind}_deg" for kind in KINDS]
    rows = evaluate_with_verdicts(problem, designs, frozenset(names))
    bounds = {"rise": 30.0, "dwell": 30.0, "return": 30.0} if len(limits) == 1 else {"rise": 25.0, "return": 40.0}
    expected = np.all([rows.column(f"pressure_angle_max_{kind}_deg") <= bounds[kind] for kind in bounds], axis=0)
    np.testing.assert_array_equal(possible, expected)
    np.testing.assert_array_equal(held, expected)
    assert 0 < np.count_nonzero(held) < len(designs)


def test_a_design_at_its_bound_is_neither_held_nor_broken():
    problem, designs = problem_of(pressure_angle=30.0)
    one = designs.take(np.array([20]))
    angle = float(
        evaluate_with_verdicts(problem, one, frozenset({"pressure_angle_max_deg"})).column(
            "pressure_angle_max_deg"
        )[0]
    )
    problem, _ = problem_of(pressure_angle=angle, pressure_angle_return=angle)
    constraints = merge_constraints_over_stroke_kinds(
        constraint for limit in problem.pitch_curve_limits for constraint in limit.constraints
    )
    case = EvaluationBlock(problem.setup, problem.programme, one)
    possible, held = may_hold_and_holds_by_extremes(
        known_extremes_with_limited_curve(case, constraints, ()), constraints, case
    )
    assert possible[0]
    assert not held[0]


@pytest.mark.parametrize("goal", [LARGEST, LEAST, LARGEST_MAGNITUDE])
def test_what_is_known_of_parts_of_a_turn_is_known_of_all_of_it(goal):
    problem, designs = problem_of(pressure_angle=30.0)
    case, curve = EvaluationBlock(problem.setup, problem.programme, designs), problem.setup.mechanism.pressure
    questions, whole = [(RISE | DWELL, goal), (RETURN, goal)], (RISE | DWELL | RETURN, goal)
    known = NOTHING_KNOWN.with_extremes(curve, questions, case.extremes(curve, questions))
    found, expected = known.find_known_extremes(curve, [whole]), case.extremes(curve, [whole])
    np.testing.assert_array_equal(found.value, expected.value)
    assert np.all(np.abs(found.width) <= 1e-9 * np.abs(found.value))
    assert known.find_known_extreme(curve, (RISE, goal)) is None
    assert known.find_known_extremes(curve, [whole, (RISE, goal)]) is None
    some = known.take(np.array([3, 1])).find_known_extreme(curve, (RETURN, goal))
    np.testing.assert_array_equal(some.value, case.extremes(curve, questions).value[1, [3, 1]])
    again = replace(case, known_extremes=known).extremes(curve, [whole])
    np.testing.assert_array_equal(again.value, expected.value)

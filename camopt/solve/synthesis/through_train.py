"""Constraints on the follower, written for the free motion of the tool that it drives.

At a constant train ratio i, the follower moves by y = (z − z₀)/i. A constraint that is linear in y is then linear
in the tool's motion z too. At a ratio that changes, the constraint is not convex (``nonconvex_constraints``): its
tangent planes are taken through the train.
"""

from dataclasses import replace

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.peak import MotionDerivative
from camopt.model.motion.stroke import reversed_kinds
from camopt.model.motion.tool_drive import tool_travel_range
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem
from camopt.solve.synthesis.synthesis_problem import LinearConstraint


def constant_tool_to_follower_ratio(scene_problem: Problem) -> float | None:
    """Ratio of the tool's velocity to the follower's; None if it changes over the turn."""
    return 1.0 if scene_problem.setup.train is None else scene_problem.setup.train.constant_ratio


def reverses_motion(scene_problem: Problem) -> bool:
    """Whether the follower moves inward while the tool moves outward."""
    train = scene_problem.setup.train
    return train is not None and bool(
        np.diff(train.follower_displacement_at(np.array(tool_travel_range(scene_problem.programme))))[0] < 0.0
    )


def linear_constraint_on_tool_motion(
    scene_problem: Problem, linear_constraint: LinearConstraint
) -> LinearConstraint:
    """A linear constraint on the follower's motion, as one on the tool's motion, at a constant ratio.

    The result is |i| times the constraint, because its sizes are in a unit that is |i| times smaller
    (``SynthesisProblem.size_unit``).
    """
    ratio = constant_tool_to_follower_ratio(scene_problem)
    assert ratio is not None
    constant = abs(ratio) * linear_constraint.constant
    if ratio > 0.0:
        return replace(linear_constraint, constant=constant)
    reversed_terms = {
        name: -getattr(linear_constraint, name) for name in ("displacement", "velocity", "acceleration")
    }
    constant += linear_constraint.displacement * scene_problem.programme.tool.lift
    return replace(
        linear_constraint, **reversed_terms, constant=constant, kinds=reversed_kinds(linear_constraint.kinds)
    )


def constraint_with_tool_stroke_kinds(scene_problem: Problem, constraint: Constraint) -> Constraint:
    """The same constraint, with the stroke kinds of the tool in place of those of the follower."""
    is_about_tool = isinstance(constraint.curve, MotionDerivative) and not constraint.curve.at_follower
    return (
        constraint
        if is_about_tool or not reverses_motion(scene_problem)
        else constraint._replace(kinds=reversed_kinds(constraint.kinds))
    )


def follower_states(scene_problem: Problem, zero: float, state: FloatArray) -> FloatArray:
    """Follower motion y to y''' (4, n) from the tool motion [mm or rad, per radᵏ]; NaN beyond dead points.

    ``zero`` is the tool position where the tool's displacement is 0, as the scene gives it [mm or deg].
    """
    train, programme = scene_problem.setup.train, scene_problem.programme
    if train is None:
        return state
    z, z1, z2, z3 = state
    with np.errstate(all="ignore"):
        follower = train.follower_displacement(
            Taylor([zero * programme.tool.unit_in_mm_or_rad + z, z1, z2 / 2.0, z3 / 6.0])
        )
    states = np.array([np.broadcast_to(follower.derivative(order), z.shape) for order in range(len(state))])
    states[0] -= train.follower_displacement_at(np.array(tool_travel_range(programme))).min()
    return states

"""The motion of the follower from free laws of the tool that it drives.

Where the ratio of the train is the same everywhere, y = (z − z₀)/i, what is linear in the motion of the follower is
linear in that of the tool. Where it changes, it is a ceiling (``ceilings``), whose planes are taken through the
train.
"""

from dataclasses import replace

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.peak import Derivative
from camopt.model.motion.stroke import reversed_kinds
from camopt.model.motion.tool_drive import tool_travel
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem
from camopt.solve.synthesis.synthesis_problem import LinearConstraint


def constant_train_ratio(problem: Problem) -> float | None:
    """The velocity of the tool over that of the follower; None where it changes."""
    return 1.0 if problem.setup.train is None else problem.setup.train.constant_ratio


def reverses_motion(problem: Problem) -> bool:
    """Whether the follower goes in as the tool goes out."""
    train = problem.setup.train
    return train is not None and bool(np.diff(train.follower_at(np.array(tool_travel(problem.programme))))[0] < 0.0)


def constraint_at_tool(problem: Problem, floor: LinearConstraint) -> LinearConstraint:
    """A linear limit on the motion of the follower as one on that of the tool, at a constant ratio.

    It is |i| times the limit, with sizes in units that are |i| times as small (``SynthesisProblem.size_unit``).
    """
    ratio = constant_train_ratio(problem)
    assert ratio is not None
    constant = abs(ratio) * floor.constant
    if ratio > 0.0:
        return replace(floor, constant=constant)
    by = {name: -getattr(floor, name) for name in ("displacement", "velocity", "acceleration")}
    constant += floor.displacement * problem.programme.tool.lift
    return replace(floor, **by, constant=constant, kinds=reversed_kinds(floor.kinds))


def constraint_about_tool(problem: Problem, constraint: Constraint) -> Constraint:
    """A constraint with the kinds of pieces in which the tool moves so."""
    of_tool = isinstance(constraint.curve, Derivative) and not constraint.curve.at_follower
    return (
        constraint
        if of_tool or not reverses_motion(problem)
        else constraint._replace(kinds=reversed_kinds(constraint.kinds))
    )


def follower_states(problem: Problem, zero: float, state: FloatArray) -> FloatArray:
    """The motion of the follower, mm or rad by rad, from that of the tool (4, n); NaN beyond dead points.

    The tool is at ``zero``, as given, where its displacement is 0.
    """
    train, turn = problem.setup.train, problem.programme
    if train is None:
        return state
    z, z1, z2, z3 = state
    with np.errstate(all="ignore"):
        moved = train.follower(Taylor([zero * turn.tool.unit + z, z1, z2 / 2.0, z3 / 6.0]))
    found = np.array([np.broadcast_to(moved.derivative(order), z.shape) for order in range(len(state))])
    found[0] -= train.follower_at(np.array(tool_travel(turn))).min()
    return found

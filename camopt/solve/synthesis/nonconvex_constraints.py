"""Constraints that are not convex in the motion: on curvature and on the loads that a scene limits.

They are constraints (``constraints.Constraint``) on curves over the turn that are not linear in the motion and the
sizes. Their curves are the formulas of the effects, evaluated at samples of the turn. Tangent planes in the motion
(y to y''') and in the sizes (e, s₀) are central differences. So any curve can be used, and no formula is written
twice.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, LEAST, Curve, FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.state import State
from camopt.core.quantities import AT_MOST, QUANTITIES
from camopt.model.effects.peak import MotionDerivative
from camopt.model.motion.stroke import DWELL, INWARD, OUTWARD, RESTING, RETURN, RISE, WAY_OF, Stroke
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limits import LOAD_LIMITS, limited_quantity_name
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.scene.problem.tolerance_zones import NumberErrors, with_added_errors
from camopt.solve.synthesis.linear_constraints import is_linear, repeats_first_contact
from camopt.solve.synthesis.residual import RESIDUAL_TERM
from camopt.solve.synthesis.synthesis_problem import SynthesisProblem
from camopt.solve.synthesis.through_train import constraint_with_tool_stroke_kinds, follower_states

PIECE_SAMPLES, STROKE_SAMPLES = 6, 288  # least samples of a piece, and of a stroke
DWELL_SAMPLES = 24  # samples of a dwell, over which a load may change
DIFFERENCE_STEP = 6e-6  # step of central differences: the cube root of the rounding
STEP_AND_BACK = (DIFFERENCE_STEP, -DIFFERENCE_STEP)
LAW_ORDERS = 4  # y, y', y'' and y'''

LeadAndHeight = tuple[float, float] | FloatArray
"""e and s₀ [mm]: a number each, or one for each state."""


def load_limit_keys_by_quantity(scene_problem: Problem) -> dict[str, str]:
    """Key in [limits] of each quantity that is the largest value of a curve."""
    keys = {limited_quantity_name(key, scene_problem.setup): key for key in LOAD_LIMITS if key != RESIDUAL_TERM}
    return {name: key for name, key in keys.items() if QUANTITIES[name].relation_to_limit == AT_MOST}


def nonconvex_constraints_of(problem: SynthesisProblem) -> tuple[Constraint, ...]:
    """The nonconvex constraints of a problem, except upper bounds that no motion can meet."""
    scene_problem = problem.scene_problem
    return tuple(
        constraint_with_tool_stroke_kinds(scene_problem, constraint)
        for constraint in strictest_constraints(scene_problem.constraints)
        if not repeats_first_contact(scene_problem, constraint) and not is_linear(scene_problem, constraint)
        if constraint.upper_bound_of_each_side() > 0.0 or constraint.goal == LEAST
    )


def load_constraints_at(scene_problem: Problem, key: str, bound: float) -> tuple[Constraint, ...]:
    """The constraints of one load limit at a bound; none if the bound cannot be met."""
    limits = scene_problem.with_numbers({f"limits.{key}": bound}).limits
    return tuple(
        constraint_with_tool_stroke_kinds(scene_problem, constraint)
        for constraint in next(limit.constraints for limit in limits if limit.name == key)
        if constraint.upper_bound_of_each_side() > 0.0
    )


@dataclass(frozen=True)
class TangentPlanes:
    """Curves over their bounds at samples of one stroke (n,), with slopes by y to y''' (4, n), by e and by s₀."""

    values: FloatArray
    motion: FloatArray
    lead: FloatArray
    height: FloatArray


def stroke_sample_positions(problem: SynthesisProblem, stroke: Stroke) -> FloatArray:
    """The samples of a stroke: x of the unit stroke, inside its pieces."""
    count = DWELL_SAMPLES if stroke.kind == DWELL else max(problem.splines.pieces * PIECE_SAMPLES, STROKE_SAMPLES)
    return (np.arange(count) + 0.5) / count


class SampledConstraints:
    """The curves of nonconvex constraints over one stroke, at its samples.

    They are those of the nominal cam, or of an error variant that must meet the limits too, with its scene problem.
    """

    def __init__(
        self,
        problem: SynthesisProblem,
        stroke: Stroke,
        scene_problem: Problem | None = None,
        errors: NumberErrors | None = None,
    ) -> None:
        self.problem, self.stroke = problem, stroke
        self.scene_problem, self.errors = scene_problem or problem.scene_problem, errors or {}
        self.angles = stroke.start + stroke.angle * stroke_sample_positions(problem, stroke)

    def is_limited_by(self, constraint: Constraint) -> bool:
        """Whether a constraint applies to the stroke, or to a direction in which the follower may move there."""
        kind = self.stroke.kind
        one_way = kind in WAY_OF and (self.problem.monotone or kind == DWELL)
        return bool(constraint.kinds & (kind | (WAY_OF[kind] if one_way else OUTWARD | INWARD)))

    def ratios_to_bounds(
        self,
        constraints: Sequence[Constraint],
        state: FloatArray,
        sizes: LeadAndHeight,
        state_giving_direction: FloatArray | None = None,
    ) -> FloatArray:
        """Ratio of each curve to its bound (rows, n).

        A curve whose magnitude is limited has a second row, with the opposite sign.

        ``state`` is y to y''' at the samples (4, n) [mm or rad, per radᵏ], or several such states one after
        another. A curve that applies to one direction is 0 where the follower moves the other way. The direction is
        that of ``state_giving_direction`` if it is given. Undefined values are infinite.
        """
        designs, programme, follower_state = (
            with_added_errors(self.problem.design_of_sizes(*sizes), self.errors),
            self.scene_problem.programme,
            self._follower_state(state),
        )
        outward = (state if state_giving_direction is None else state_giving_direction)[1] >= 0.0
        kind = self.stroke.kind if self.stroke.kind in WAY_OF else 0
        resting = RESTING if kind == DWELL else 0
        ways = [way | resting | (kind or moving) for way, moving in ((OUTWARD, RISE), (INWARD, RETURN))]
        rows = []
        with np.errstate(all="ignore"):
            for constraint in [constraint for constraint in constraints if self.is_limited_by(constraint)]:
                curve: Curve = constraint.curve
                if isinstance(curve, MotionDerivative):
                    value = follower_state[curve.order]
                else:
                    value = curve_value(curve(designs, programme), ..., follower_state)
                value = value * constraint.factor(designs)
                if constraint.upper_bound_of_each_side() <= 0.0:  # a lower bound, which may be 0
                    value = 1.0 - (constraint.upper_bound_of_each_side() + value) / self.problem.size_unit
                else:
                    value = constraint.side_signs[0] * value / constraint.upper_bound_of_each_side()
                value = np.nan_to_num(np.broadcast_to(value, outward.shape), nan=np.inf)
                applies = np.where(outward, *(bool(constraint.kinds & way) for way in ways))
                value = np.where(applies, value, 0.0)
                rows += [value, -value] if constraint.goal == LARGEST_MAGNITUDE else [value]
        return np.array(rows).reshape(-1, outward.size)

    def _follower_state(self, state: FloatArray) -> State:
        """The state of the follower for a state of the tool."""
        motion, load = (
            follower_states(self.scene_problem, self.problem.zero, state),
            self.scene_problem.programme.load,
        )
        y, y1, y2, y3 = motion
        if load is None:
            return State(y, y1, y2, y3)
        angles = np.tile(self.angles, y.size // self.angles.size)
        return State(y, y1, y2, y3, load.load_state(angles, motion, np.sign(y1)))

    def tangent_planes(
        self, constraints: Sequence[Constraint], state: FloatArray, sizes: LeadAndHeight
    ) -> TangentPlanes:
        """Tangent planes of the curves, for motions and sizes in units of the programme."""
        fast = 1.0 / self.stroke.angle ** np.arange(LAW_ORDERS)
        units = np.append(self.problem.motion_unit * fast, [self.problem.size_unit] * 2)
        steps = np.concatenate([np.zeros((1, units.size)), *(k * np.diag(units) for k in STEP_AND_BACK)])
        states = state[:, None] + steps.T[:LAW_ORDERS, :, None]
        stepped_sizes = np.repeat(np.array(sizes)[:, None] + steps.T[LAW_ORDERS:], state.shape[1], axis=1)
        values = self.ratios_to_bounds(
            constraints, states.reshape(LAW_ORDERS, -1), stepped_sizes, np.tile(state, len(steps))
        ).reshape(-1, len(steps), state.shape[1])
        up, down = np.split(values[:, 1:].transpose(1, 0, 2), 2)
        with np.errstate(all="ignore"):
            slopes = np.nan_to_num((up - down) / (2.0 * DIFFERENCE_STEP), posinf=0.0, neginf=0.0)
        return TangentPlanes(
            values[:, 0], slopes[:LAW_ORDERS] / fast[:, None, None], slopes[LAW_ORDERS], slopes[LAW_ORDERS + 1]
        )

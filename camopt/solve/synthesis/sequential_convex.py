"""Free laws under nonconvex constraints, by a sequence of convex steps.

Each step replaces the nonconvex curves by their tangent planes (``nonconvex_constraints``), within a trust region
around the last iterate. A penalty prices what exceeds a bound. A step is accepted if it lowers the true penalised
objective. Most planes are far below their bounds: a step takes those that are near, and is solved again with those
that it passes. Minimised curves are held below a level that is part of the objective. The steps end at a local
optimum. The optimum of the convex constraints alone is a lower bound of it.

Source: Fletcher, Practical Methods of Optimization, ch. 14 (exact penalty, trust region).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import cvxpy as cp
import numpy as np
from scipy import sparse

from camopt.core.numerics import LARGEST_MAGNITUDE, BoolArray, FloatArray
from camopt.scene.problem.constraints import ConstantBound, Constraint
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import NumberErrors
from camopt.solve.synthesis.convex_model import ConvexModel
from camopt.solve.synthesis.iterate import Iterate, free_stroke_motions, iterate_of, spline_and_fixed_motions
from camopt.solve.synthesis.nonconvex_constraints import SampledConstraints, stroke_sample_positions
from camopt.solve.synthesis.solver import SOLVED_STATUSES, CompiledProgramme, solve
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, TERM_ORDERS

PENALTIES = (
    1.0,
    100.0,
    1e4,
)  # penalties of exceeding a bound by 100 %, in units of the objective: the next if one is too low; high ones make
# steps short, because a step along a curved bound exceeds it slightly
MOST_CONVEX_STEPS, FIRST_TRUST_RADIUS, LEAST_TRUST_RADIUS = 60, 0.1, 2e-4
GOOD_RATIO, POOR_RATIO = (
    0.75,
    0.25,
)  # shares of the predicted fall: above the first the trust region grows, below the second it shrinks
LEAST_FALL = 2e-6  # least relative fall of the penalised objective that is worth a step
LEAST_MULTIPLIER = 1e-3  # multipliers of the trust region below this are solver error
NEAR_PLANES = 0.2  # a step takes the planes that come nearer to their bounds than this share of the bound
PLANE_ERROR = 1e-7  # what the solver may exceed a plane by
HELD_BACK = 0.999  # share of the trust radius beyond which the trust region holds a step back
BOUND_MARGIN = 2e-4  # relative margin of bounds, because a curve rises slightly between samples


@dataclass
class StrokePlanes:
    """The tangent planes of all curves over one stroke, curve by curve."""

    constraints: SampledConstraints
    state_matrices: list[tuple[Any, FloatArray]]
    """y to y''' at the samples of one curve, in units of the lift: a matrix of the variables and a constant each.
    """
    are_minimised: BoolArray
    constraint_count: int
    """Number of the constraints it takes, from the first."""

    @property
    def row_count(self) -> int:
        """Number of rows: one for each sample of each curve."""
        return self.are_minimised.size * self.state_matrices[0][1].size

    def motion_state(self, unit: float, solution_vector: FloatArray) -> FloatArray:
        """y to y''' at the samples of one curve [mm]."""
        return unit * np.array([matrix @ solution_vector + constant for matrix, constant in self.state_matrices])


class SequentialConvex:
    """The convex steps of a programme under nonconvex constraints.

    ``held`` constraints stay below their bounds, for this cam and for all error variants that must meet the limits.
    ``minimised`` constraints are minimised, beside the objective of the model. Methods take the same constraints,
    with other bounds.
    """

    def __init__(
        self, model: ConvexModel, held: Sequence[Constraint], minimised: Sequence[Constraint] = ()
    ) -> None:
        self.model, self.count = model, len(held)
        self.excess, self.level = cp.Variable(), cp.Variable()
        self.penalty = cp.Parameter(nonneg=True, value=PENALTIES[0])
        self.variables = [
            model.sizes.lead,
            model.sizes.height,
            *(m.coefficients for m in free_stroke_motions(model)),
        ]
        self.blocks = list(self._stroke_planes(model.problem.scene_problem, {}, [*held, *minimised]))
        for scene_problem, errors in model.problem.scene_problem.error_variants:
            self.blocks += self._stroke_planes(scene_problem, errors, held)
        objective, above_0 = model.objective + self.penalty * self.excess, [self.excess >= 0.0]
        if minimised:
            objective, above_0 = objective + self.level, [*above_0, self.level >= 0.0]
        priced = cp.Problem(cp.Minimize(objective), [*model.constraints, *above_0])
        self.step = CompiledProgramme(priced, [*self.variables, self.excess, *([self.level] if minimised else [])])
        self.centre = cp.Parameter(sum(variable.size for variable in self.variables))
        distance = cp.sum_squares(cp.hstack(self.variables) - self.centre)
        self.nearest = cp.Problem(cp.Minimize(distance), model.constraints)

    def _stroke_planes(
        self, scene_problem: Problem, errors: NumberErrors, constraints: Sequence[Constraint]
    ) -> Iterator[StrokePlanes]:
        """Planes for each stroke that a constraint limits."""
        width, first_column = sum(variable.size for variable in self.variables), 2
        for stroke, motion in zip(self.model.problem.strokes, spline_and_fixed_motions(self.model), strict=True):
            state_matrices = motion.derivative_matrices_at(stroke_sample_positions(self.model.problem, stroke))
            count = state_matrices[0][0].shape[1]
            sampled = SampledConstraints(self.model.problem, stroke, scene_problem, errors)
            sides = [
                1 + (constraint.goal == LARGEST_MAGNITUDE)
                for constraint in constraints
                if sampled.is_limited_by(constraint)
            ]
            minimised = [
                n >= self.count for n, constraint in enumerate(constraints) if sampled.is_limited_by(constraint)
            ]
            if sides:
                columns = sparse.eye_array(count, width, k=first_column, format="csr")
                placed = [(sparse.csr_array(matrix @ columns), constant) for matrix, constant in state_matrices]
                yield StrokePlanes(sampled, placed, np.repeat(minimised, sides), len(constraints))
            first_column += count

    def find_local_optimum(
        self,
        start: Iterate,
        held_constraints: Sequence[Constraint],
        minimised_constraints: Sequence[Constraint] = (),
    ) -> Iterate:
        """The local optimum that convex steps reach from the motion nearest to a start within the convex limits."""
        self._set_variables_to_iterate(start)
        iterate = iterate_of(self.model) if solve(self.nearest) in SOLVED_STATUSES else start
        minimised_constraints = _scale_bounds(
            minimised_constraints,
            self.largest_ratios_to_bounds(iterate, held_constraints, minimised_constraints)[1],
        )
        radius = FIRST_TRUST_RADIUS
        for self.penalty.value in PENALTIES:
            iterate, radius, is_done = self._descend_and_check_penalty(
                iterate, radius, held_constraints, minimised_constraints
            )
            if is_done:
                break
        self.penalty.value = PENALTIES[0]
        return iterate

    def _descend_and_check_penalty(
        self,
        iterate: Iterate,
        radius: float,
        held_constraints: Sequence[Constraint],
        minimised_constraints: Sequence[Constraint],
    ) -> tuple[Iterate, float, bool]:
        """Steps at one penalty: the last iterate, the trust radius, and whether the penalty is high enough.

        It is too low if the steps end above a bound. It is too low as well if a step exceeds a bound although the
        last iterate holds all bounds, or although the trust region does not hold it back.
        """
        cost, top = self._penalised_objective_and_held_ratio(iterate, held_constraints, minimised_constraints)
        if cost == inf:
            return iterate, radius, False
        planes = self._tangent_plane_rows_and_bounds(iterate, held_constraints, minimised_constraints)
        self.step.compile_to_matrices()
        for _ in range(MOST_CONVEX_STEPS):
            # below the least radius, the planes do not fit at any distance
            if radius < LEAST_TRUST_RADIUS or self._solve_step(iterate, radius, planes) not in SOLVED_STATUSES:
                break
            predicted_fall = cost - self.step.value
            if predicted_fall < LEAST_FALL * abs(cost):  # the planes predict no further fall
                break
            exceeds = self.excess.value > BOUND_MARGIN and self.penalty.value < PENALTIES[-1]
            vector = _solution_vector(iterate)
            step_length = float(np.abs(self.step.point[: vector.size] - vector).max())
            if exceeds and (top <= 1.0 or step_length < HELD_BACK * radius):
                return iterate, radius, False
            trial = iterate_of(self.model)
            trial_cost, trial_top = self._penalised_objective_and_held_ratio(
                trial, held_constraints, minimised_constraints
            )
            ratio = (cost - trial_cost) / predicted_fall
            radius *= 2.0 if ratio > GOOD_RATIO else 1.0 if ratio > POOR_RATIO else 0.25
            if ratio > 0.0:
                iterate, cost, top = trial, trial_cost, trial_top
                planes = self._tangent_plane_rows_and_bounds(iterate, held_constraints, minimised_constraints)
        return iterate, max(radius, FIRST_TRUST_RADIUS), top <= 1.0

    def curve_multipliers(
        self, iterate: Iterate, held_constraints: Sequence[Constraint]
    ) -> list[FloatArray] | None:
        """Multipliers of all curves at a local optimum, block by block.

        The model keeps the multipliers of its own constraints. None if another step would use the whole trust
        region or exceed a bound.
        """
        planes = self._tangent_plane_rows_and_bounds(iterate, held_constraints, ())
        self.penalty.value = PENALTIES[-1]
        self.step.compile_to_matrices()
        status, self.penalty.value = self._solve_step(iterate, FIRST_TRUST_RADIUS, planes, inf), PENALTIES[0]
        if status not in SOLVED_STATUSES or self.excess.value > BOUND_MARGIN:
            return None
        self.step.set_variables_and_multipliers()
        ends = np.cumsum([block.row_count for block in self.blocks])
        *curves, radius_multipliers = np.split(self.step.row_multipliers, ends)
        return curves if radius_multipliers.max() < LEAST_MULTIPLIER else None

    def curve_ratios_to_bounds(self, iterate: Iterate, held_constraints: Sequence[Constraint]) -> list[FloatArray]:
        """Ratios of all curves to their bounds at a solution, block by block."""
        self._set_variables_to_iterate(iterate)
        scale, vector = self.model.problem.motion_unit, _solution_vector(iterate)
        return [
            block.constraints.ratios_to_bounds(
                held_constraints, block.motion_state(scale, vector), self._lead_and_height(iterate)
            ).ravel()
            for block in self.blocks
        ]

    def rank_starts(
        self,
        starts: Sequence[Iterate],
        held_constraints: Sequence[Constraint],
        minimised_constraints: Sequence[Constraint] = (),
    ) -> list[Iterate]:
        """Starts in the order of their penalised objective, with a penalty for convex limits that they break."""
        minimised_constraints = _scale_bounds(
            minimised_constraints,
            self.largest_ratios_to_bounds(starts[0], held_constraints, minimised_constraints)[1],
        )

        def penalised_objective_of_start(start: Iterate) -> float:
            cost, _ = self._penalised_objective_and_held_ratio(start, held_constraints, minimised_constraints)
            return cost + PENALTIES[0] * max(
                float(np.max(constraint.violation())) for constraint in self.model.constraints
            )

        return sorted(starts, key=penalised_objective_of_start)

    def _set_variables_to_iterate(self, iterate: Iterate) -> None:
        """Set the variables, and the centre of the search for the nearest motion, to a solution."""
        self.model.sizes.lead.value, self.model.sizes.height.value = iterate.lead, iterate.height
        for motion, values in zip(free_stroke_motions(self.model), iterate.coefficients, strict=True):
            motion.coefficients.value = values
        self.centre.value = _solution_vector(iterate)

    def _tangent_plane_rows_and_bounds(
        self, iterate: Iterate, held_constraints: Sequence[Constraint], minimised_constraints: Sequence[Constraint]
    ) -> tuple[sparse.csr_array, FloatArray]:
        """Rows of the tangent planes at a solution, for the variables of a step, and their upper bounds."""
        constraints, vector, scale = (
            [*held_constraints, *minimised_constraints],
            _solution_vector(iterate),
            self.model.problem.motion_unit,
        )
        rows, upper_bounds = [], []
        for block in self.blocks:
            planes = block.constraints.tangent_planes(
                constraints[: block.constraint_count],
                block.motion_state(scale, vector),
                self._lead_and_height(iterate),
            )
            slopes = sum(
                sparse.diags_array(slope.ravel()) @ sparse.vstack([matrix] * len(slope))
                for slope, (matrix, _) in zip(planes.motion, block.state_matrices, strict=True)
            )
            by_sizes = np.stack([planes.lead.ravel(), planes.height.ravel()], axis=1)
            slopes = slopes + sparse.hstack([by_sizes, sparse.csr_array((block.row_count, vector.size - 2))])
            minimised_rows = np.repeat(block.are_minimised, block.state_matrices[0][1].size).astype(float)
            slacks = [1.0 - minimised_rows, minimised_rows][: len(self.step.variables) - len(self.variables)]
            rows.append(sparse.hstack([slopes, *(sparse.csr_array(-column[:, None]) for column in slacks)]))
            upper_bounds.append(
                slopes @ vector - planes.values.ravel() + (1.0 - minimised_rows) * (1.0 - BOUND_MARGIN)
            )
        return sparse.vstack(rows, format="csr"), np.concatenate(upper_bounds)

    def _solve_step(
        self,
        iterate: Iterate,
        radius: float,
        planes: tuple[sparse.csr_array, FloatArray],
        plane_distance: float = NEAR_PLANES,
    ) -> str:
        """Solve a step from a solution, within the trust radius and below the planes: the solver's status.

        Planes further than ``plane_distance`` below their bounds are left out, unless the step passes them.
        """
        (rows, upper_bounds), vector = planes, _solution_vector(iterate)
        identity = sparse.eye_array(vector.size, rows.shape[1], format="csr")
        is_taken = rows[:, : vector.size] @ vector > upper_bounds - plane_distance
        while True:
            taken_rows = sparse.vstack([rows[is_taken], identity, -identity], format="csr")
            taken_bounds = np.concatenate([upper_bounds[is_taken], radius + vector, radius - vector])
            status = self.step.solve(taken_rows, taken_bounds)
            if status not in SOLVED_STATUSES:
                return status
            excesses = rows @ self.step.point - upper_bounds
            if not np.any(excesses[~is_taken] > PLANE_ERROR):
                return status
            is_taken |= excesses > -plane_distance

    def _lead_and_height(self, iterate: Iterate) -> tuple[float, float]:
        """e and s₀ [mm]."""
        length = self.model.problem.size_unit
        return length * iterate.lead, length * iterate.height

    def largest_ratios_to_bounds(
        self, iterate: Iterate, held_constraints: Sequence[Constraint], minimised_constraints: Sequence[Constraint]
    ) -> tuple[float, float]:
        """Largest ratio of the held curves to their bounds, and of the minimised curves."""
        scale, vector, largest = self.model.problem.motion_unit, _solution_vector(iterate), ([0.0], [0.0])
        for block in self.blocks:
            values = block.constraints.ratios_to_bounds(
                [*held_constraints, *minimised_constraints][: block.constraint_count],
                block.motion_state(scale, vector),
                self._lead_and_height(iterate),
            )
            for row, is_minimised in zip(values, block.are_minimised, strict=True):
                largest[int(is_minimised)].append(float(row.max()))
        return max(largest[0]), max(largest[1])

    def _penalised_objective_and_held_ratio(
        self, iterate: Iterate, held_constraints: Sequence[Constraint], minimised_constraints: Sequence[Constraint]
    ) -> tuple[float, float]:
        """The penalised objective at a solution, and the largest ratio of a held curve to its bound."""
        self._set_variables_to_iterate(iterate)
        top, level = self.largest_ratios_to_bounds(iterate, held_constraints, minimised_constraints)
        model, problem = self.model, self.model.problem
        trace_radius = (
            np.hypot(iterate.lead, iterate.height) if problem.has_lead_in_prime_radius else iterate.height
        )
        model.sizes.prime.value = max(trace_radius, problem.prime_range[0] / problem.size_unit)
        for name, variable in model.peak_variables.items():
            # the largest derivative over the turn, or jerk at crossings
            if name == CROSSING_JERK:
                largest = [
                    motion.solved_jerk_bound_after_crossing(crossing)
                    for crossing in problem.crossings
                    if isinstance(motion := model.motions[crossing.stroke], SplineMotion)
                ]
            else:
                largest = [
                    float(np.abs(motion.solved_bernstein_coefficients(TERM_ORDERS[name])).max())
                    for motion in spline_and_fixed_motions(model)
                ]
            variable.value = max(largest)
        cost = float(model.objective.value) + (level if minimised_constraints else 0.0)
        penalised = cost + self.penalty.value * max(0.0, top - 1.0 + BOUND_MARGIN)
        return penalised if np.isfinite(penalised) else inf, top


def _solution_vector(iterate: Iterate) -> FloatArray:
    """A solution as one vector."""
    return np.concatenate([iterate[:2], *iterate.coefficients])


def _scale_bounds(constraints: Sequence[Constraint], curve_level: float) -> tuple[Constraint, ...]:
    """Constraints with bounds scaled so that curves at ``curve_level`` are at 1."""
    scale = curve_level if 0.0 < curve_level < inf else 1.0
    return tuple(
        constraint._replace(bound=ConstantBound(constraint.upper_bound_of_each_side() * scale))
        for constraint in constraints
    )

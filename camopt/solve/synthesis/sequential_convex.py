"""Free laws under nonconvex constraints, by a sequence of convex steps.

Each step replaces the nonconvex curves by their tangent planes (``nonconvex_constraints``), within a trust region
around the last iterate. A penalty prices what exceeds a bound. A step is accepted if it lowers the true penalised
objective. Minimised curves are held below a level that is part of the objective. The steps end at a local optimum.
The optimum of the convex constraints alone is a lower bound of it.

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
from camopt.solve.synthesis.iterate import Iterate, free_motions, iterate_of, sampled_motions
from camopt.solve.synthesis.nonconvex_constraints import SampledConstraints, stroke_samples
from camopt.solve.synthesis.solver import SOLVED_STATUSES, CompiledProgramme, solve
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, TERM_ORDERS

PENALTY_PRICES = (
    100.0,
    1e4,
)  # of a curve that is above its bound by all of it, in units of the objective: if one is too low
MOST_CONVEX_STEPS, FIRST_TRUST_RADIUS = 60, 0.1
GOOD_RATIO, POOR_RATIO = (
    0.75,
    0.25,
)  # of what planes promise: if more comes true, steps go further; if less, less far
LEAST_FALL = 5e-5  # a fall of the priced objective, relative, that is worth a step
LEAST_MULTIPLIER = 1e-3  # of a multiplier of the reach: what a solver's error makes of none
BOUND_MARGIN = 2e-4  # by which bounds are held closer than asked: between samples a curve rises a little more


@dataclass
class StrokePlanes:
    """The tangent planes of all curves over one stroke, curve by curve."""

    constraints: SampledConstraints
    state_matrices: list[tuple[Any, FloatArray]]
    """y to y''' at the samples of one curve, in units of the lift: a matrix of ``places`` and a constant each."""
    are_minimised: BoolArray
    """Which curves are minimised."""
    constraint_count: int
    """How many ceilings it has, the first ones."""

    @property
    def row_count(self) -> int:
        """How many rows it has: one for each sample of each curve."""
        return self.are_minimised.size * self.state_matrices[0][1].size

    def motion_state(self, unit: float, place: FloatArray) -> FloatArray:
        """y to y''' at the samples of one curve, mm."""
        return unit * np.array([matrix @ place + constant for matrix, constant in self.state_matrices])


class SequentialConvex:
    """The convex steps of a programme under ceilings.

    ``held`` ceilings stay below their bounds, and so do those of all cams that have to hold limits with this one;
    ``lowered`` ones are minimised, beside the objective of the model. What is given to its methods are the same
    ceilings with other bounds.
    """

    def __init__(self, model: ConvexModel, held: Sequence[Constraint], lowered: Sequence[Constraint] = ()) -> None:
        self.model, self.count = model, len(held)
        self.missing, self.level = cp.Variable(), cp.Variable()
        self.price = cp.Parameter(nonneg=True, value=PENALTY_PRICES[0])
        self.places = [model.sizes.lead, model.sizes.height, *(m.coefficients for m in free_motions(model))]
        self.blocks = list(self._stroke_planes(model.problem.scene_problem, {}, [*held, *lowered]))
        for scene_problem, off in model.problem.scene_problem.error_variants:
            self.blocks += self._stroke_planes(scene_problem, off, held)
        objective, above_0 = model.objective + self.price * self.missing, [self.missing >= 0.0]
        if lowered:
            objective, above_0 = objective + self.level, [*above_0, self.level >= 0.0]
        priced = cp.Problem(cp.Minimize(objective), [*model.constraints, *above_0])
        self.step = CompiledProgramme(priced, [*self.places, self.missing, *([self.level] if lowered else [])])
        self.last = cp.Parameter(sum(each.size for each in self.places))
        away = cp.sum_squares(cp.hstack(self.places) - self.last)
        self.nearest = cp.Problem(cp.Minimize(away), model.constraints)

    def _stroke_planes(
        self, scene_problem: Problem, off: NumberErrors, constraints: Sequence[Constraint]
    ) -> Iterator[StrokePlanes]:
        """A block for each stroke on which a curve of a cam counts."""
        width, start = sum(each.size for each in self.places), 2
        for stroke, motion in zip(self.model.problem.strokes, sampled_motions(self.model), strict=True):
            at = motion.derivatives_at(stroke_samples(self.model.problem, stroke))
            count = at[0][0].shape[1]
            sampled = SampledConstraints(self.model.problem, stroke, scene_problem, off)
            sides = [1 + (c.goal == LARGEST_MAGNITUDE) for c in constraints if sampled.is_limited_by(c)]
            lowered = [n >= self.count for n, c in enumerate(constraints) if sampled.is_limited_by(c)]
            if sides:
                columns = sparse.eye_array(count, width, k=start, format="csr")
                placed = [(sparse.csr_array(matrix @ columns), constant) for matrix, constant in at]
                yield StrokePlanes(sampled, placed, np.repeat(lowered, sides), len(constraints))
            start += count

    def find_local_optimum(
        self, start: Iterate, held: Sequence[Constraint], lowered: Sequence[Constraint] = ()
    ) -> Iterate:
        """The local optimum that convex steps reach from the motion nearest to a start within the convex limits."""
        self._load_solution(start)
        last = iterate_of(self.model) if solve(self.nearest) in SOLVED_STATUSES else start
        lowered = _scale_bounds(lowered, self._highest_levels(last, held, lowered)[1])
        reach = FIRST_TRUST_RADIUS
        for self.price.value in PENALTY_PRICES:
            last, reach, enough = self._descend_at_price(last, reach, held, lowered)
            if enough:
                break
        self.price.value = PENALTY_PRICES[0]
        return last

    def _descend_at_price(
        self, last: Iterate, reach: float, held: Sequence[Constraint], lowered: Sequence[Constraint]
    ) -> tuple[Iterate, float, bool]:
        """Where steps end at one price, their reach there, and whether the price is high enough.

        It is too low where the steps end above a bound, or would leave bounds that the last motion holds.
        """
        cost, top = self._priced_objective(last, held, lowered)
        if cost == inf:
            return last, reach, False
        planes = self._tangent_rows(last, held, lowered)
        self.step.compile_parameters()
        for _ in range(MOST_CONVEX_STEPS):
            if self._solve_step(last, reach, planes) not in SOLVED_STATUSES:
                break
            promise = cost - self.step.value
            if promise < LEAST_FALL * abs(cost):  # even the planes promise no more
                break
            if top <= 1.0 and self.missing.value > BOUND_MARGIN and self.price.value < PENALTY_PRICES[-1]:
                return last, reach, False
            tried = iterate_of(self.model)
            found, above = self._priced_objective(tried, held, lowered)
            gained = (cost - found) / promise
            reach *= 2.0 if gained > GOOD_RATIO else 1.0 if gained > POOR_RATIO else 0.25
            if gained > 0.0:
                last, cost, top = tried, found, above
                planes = self._tangent_rows(last, held, lowered)
        return last, max(reach, FIRST_TRUST_RADIUS), top <= 1.0

    def curve_multipliers(self, at: Iterate, held: Sequence[Constraint]) -> list[FloatArray] | None:
        """The multipliers of all curves at a local optimum, block by block; the model has those of its constraints.

        None if a step would go on as far as it may, or above a bound.
        """
        planes = self._tangent_rows(at, held, ())
        self.price.value = PENALTY_PRICES[-1]
        self.step.compile_parameters()
        status, self.price.value = self._solve_step(at, FIRST_TRUST_RADIUS, planes), PENALTY_PRICES[0]
        if status not in SOLVED_STATUSES or self.missing.value > BOUND_MARGIN:
            return None
        self.step.unpack_values()
        rows = sum(block.row_count for block in self.blocks)
        curves, pull = np.split(self.step.row_multipliers, [rows])
        ends = np.cumsum([block.row_count for block in self.blocks])
        return np.split(curves, ends[:-1]) if pull.max() < LEAST_MULTIPLIER else None

    def curve_ratios(self, at: Iterate, held: Sequence[Constraint]) -> list[FloatArray]:
        """All curves over their bounds at a solution, block by block."""
        self._load_solution(at)
        scale, place = self.model.problem.motion_unit, _solution_vector(at)
        return [
            block.constraints.ratios_to_bounds(
                held, block.motion_state(scale, place), self._lead_and_height(at)
            ).ravel()
            for block in self.blocks
        ]

    def rank_starts(
        self, starts: Sequence[Iterate], held: Sequence[Constraint], lowered: Sequence[Constraint] = ()
    ) -> list[Iterate]:
        """Starts by their priced objective, with the price of convex limits that they break."""
        lowered = _scale_bounds(lowered, self._highest_levels(starts[0], held, lowered)[1])

        def price(start: Iterate) -> float:
            cost, _ = self._priced_objective(start, held, lowered)
            return cost + PENALTY_PRICES[0] * max(float(np.max(c.violation())) for c in self.model.constraints)

        return sorted(starts, key=price)

    def _load_solution(self, at: Iterate) -> None:
        """A solution in the variables, and in the parameter that the nearest motion is near to."""
        self.model.sizes.lead.value, self.model.sizes.height.value = at.lead, at.height
        for motion, values in zip(free_motions(self.model), at.coefficients, strict=True):
            motion.coefficients.value = values
        self.last.value = _solution_vector(at)

    def _tangent_rows(
        self, at: Iterate, held: Sequence[Constraint], lowered: Sequence[Constraint]
    ) -> tuple[sparse.csr_array, FloatArray]:
        """The planes at a solution: rows of the variables of a step, and the most that they may have."""
        constraints, place, scale = [*held, *lowered], _solution_vector(at), self.model.problem.motion_unit
        rows, most = [], []
        for block in self.blocks:
            planes = block.constraints.tangent_planes(
                constraints[: block.constraint_count], block.motion_state(scale, place), self._lead_and_height(at)
            )
            rise = sum(
                sparse.diags_array(slope.ravel()) @ sparse.vstack([matrix] * len(slope))
                for slope, (matrix, _) in zip(planes.motion, block.state_matrices, strict=True)
            )
            by_sizes = np.stack([planes.lead.ravel(), planes.height.ravel()], axis=1)
            rise = rise + sparse.hstack([by_sizes, sparse.csr_array((block.row_count, place.size - 2))])
            minimised = np.repeat(block.are_minimised, block.state_matrices[0][1].size).astype(float)
            above = [1.0 - minimised, minimised][: len(self.step.variables) - len(self.places)]
            rows.append(sparse.hstack([rise, *(sparse.csr_array(-each[:, None]) for each in above)]))
            most.append(rise @ place - planes.values.ravel() + (1.0 - minimised) * (1.0 - BOUND_MARGIN))
        return sparse.vstack(rows, format="csr"), np.concatenate(most)

    def _solve_step(self, last: Iterate, reach: float, planes: tuple[sparse.csr_array, FloatArray]) -> str:
        """Solve a step from a solution, within reach of it and below planes: the status."""
        (rows, most), place = planes, _solution_vector(last)
        away = sparse.eye_array(place.size, rows.shape[1], format="csr")
        every = sparse.vstack([rows, away, -away], format="csr")
        return self.step.solve(every, np.concatenate([most, reach + place, reach - place]))

    def _lead_and_height(self, at: Iterate) -> tuple[float, float]:
        """e and s₀, mm."""
        length = self.model.problem.size_unit
        return length * at.lead, length * at.height

    def _highest_levels(
        self, at: Iterate, held: Sequence[Constraint], lowered: Sequence[Constraint]
    ) -> tuple[float, float]:
        """The largest of the curves over their bounds: of those held, and of those minimised."""
        scale, place, tops = self.model.problem.motion_unit, _solution_vector(at), ([0.0], [0.0])
        for block in self.blocks:
            state = block.motion_state(scale, place)
            values = block.constraints.ratios_to_bounds(
                [*held, *lowered][: block.constraint_count], state, self._lead_and_height(at)
            )
            for row, which in zip(values, block.are_minimised, strict=True):
                tops[int(which)].append(float(row.max()))
        return max(tops[0]), max(tops[1])

    def _largest_derivative(self, term: str) -> float:
        """The largest of a derivative over the turn, or of the jerk where the force turns round."""
        motions = self.model.motions
        if term == CROSSING_JERK:
            turning = [(motions[each.stroke], each) for each in self.model.problem.crossings]
            return max(
                motion.jerk_at_crossing(each) for motion, each in turning if isinstance(motion, SplineMotion)
            )
        return float(
            max(np.abs(each.derivative_samples(TERM_ORDERS[term])).max() for each in sampled_motions(self.model))
        )

    def _priced_objective(
        self, at: Iterate, held: Sequence[Constraint], lowered: Sequence[Constraint]
    ) -> tuple[float, float]:
        """The objective at a solution, with the price of what is above its bound, and the highest of the curves."""
        self._load_solution(at)
        top, level = self._highest_levels(at, held, lowered)
        model, problem = self.model, self.model.problem
        reach = np.hypot(at.lead, at.height) if problem.has_trace_point else at.height
        model.sizes.prime.value = max(reach, problem.prime_range[0] / problem.size_unit)
        for name, variable in model.peak_variables.items():
            variable.value = self._largest_derivative(name)
        cost = float(model.objective.value) + (level if lowered else 0.0)
        price = cost + self.price.value * max(0.0, top - 1.0 + BOUND_MARGIN)
        return price if np.isfinite(price) else inf, top


def _solution_vector(at: Iterate) -> FloatArray:
    """A solution as one vector."""
    return np.concatenate([at[:2], *at.coefficients])


def _scale_bounds(constraints: Sequence[Constraint], level: float) -> tuple[Constraint, ...]:
    """Ceilings whose curves are at most 1 of their bounds where they were at a level."""
    scale = level if 0.0 < level < inf else 1.0
    return tuple(
        constraint._replace(bound=ConstantBound(constraint.upper_bound() * scale)) for constraint in constraints
    )

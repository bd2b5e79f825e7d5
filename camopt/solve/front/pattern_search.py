"""Polishing: designs move within a box until one objective is at a minimum while no other objective rises.

Every step meets all limits and ceilings by the worse ends of its enclosures. All designs of a block move together,
by a pattern search over the free sizes. If the size of the cam is the objective, bisection finds the least size
that each choice of the other sizes allows. The search uses no derivatives, because there are none where two limits
meet.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from camopt.core.numerics import BoolArray, FloatArray
from camopt.model.mechanisms.design import Designs, SizeBounds, concatenate_designs
from camopt.scene.problem.limits import pressure_angle_limits
from camopt.scene.problem.problem import Problem
from camopt.solve.front.pareto import objective_costs
from camopt.solve.smallest.closed_form import NUDGES, closed_form_design, size_lower_bound
from camopt.solve.verdicts.limit_verdicts import quantities_with_excess_bounds

OPENING_STEP, LONGEST_STEP, SHORTEST_STEP = 1 / 16, 1 / 4, 1e-10  # steps, as shares of a range
SEARCH_STEPS = 300
STEP_HALVINGS = 48
LEAST_STEP_GAIN = 1e-12  # relative: a smaller gain is rounding


@dataclass(frozen=True)
class PatternSearch:
    """A pattern search over designs of one programme: the free variables, and the objective to lower."""

    problem: Problem
    free: SizeBounds
    """The sizes and numbers that may vary, with their ranges."""
    objective: str

    def objective_index(self, objective: str) -> int:
        """The column of an objective in the costs."""
        return list(self.problem.objectives).index(objective)

    @property
    def minimises_size(self) -> bool:
        """Whether the objective is the size of the cam, to be lowered."""
        name = self.problem.size_quantity_name
        return self.objective == name and self.problem.objectives.get(name, 0.0) > 0.0

    def worst_costs_and_feasibility(self, designs: Designs) -> tuple[FloatArray, BoolArray]:
        """The worse end of each objective as a cost, (designs, objectives), and which designs are feasible."""
        problem = self.problem
        held = problem.setup.mechanism.can_assemble(designs, self.problem.programme) & (designs.size > 0.0)
        costs = np.full((len(designs), len(problem.objectives)), np.inf)
        existing = designs.take(held)
        rows, excess, _ = quantities_with_excess_bounds(problem, existing, frozenset())
        costs[held] = objective_costs(rows.columns_shifted_by_width_share(1.0), len(existing), problem.objectives)
        held[held] = np.all(excess <= 0.0, axis=0)
        return costs, held

    def are_feasible_under_ceilings(self, designs: Designs, cost_ceilings: FloatArray) -> Any:
        """Which designs are feasible and cost no more than their ceilings."""
        costs, held = self.worst_costs_and_feasibility(designs)
        return held & np.all(costs <= cost_ceilings, axis=1)

    def shrink_and_evaluate_objective(
        self, designs: Designs, cost_ceilings: FloatArray
    ) -> tuple[Designs, FloatArray]:
        """Designs with their objectives, at the least size if that is the objective; inf for those not allowed."""
        if self.minimises_size:
            index = np.flatnonzero(self.are_feasible_under_ceilings(designs, cost_ceilings))
            size, reached = designs.size.copy(), np.full(len(designs), np.inf)
            size[index] = reached[index] = self._smallest_feasible_sizes(designs.take(index), cost_ceilings[index])
            return replace(designs, size=size), reached
        costs, held = self.worst_costs_and_feasibility(designs)
        held &= np.all(costs <= cost_ceilings, axis=1)
        return designs, np.where(held, costs[:, self.objective_index(self.objective)], np.inf)

    def _smallest_feasible_sizes(self, designs: Designs, cost_ceilings: FloatArray) -> FloatArray:
        """The least allowed size of each allowed design, by bisection [mm]."""
        low, high = np.full(len(designs), self.free["size"][0]), designs.size
        high = np.where(self.are_feasible_under_ceilings(replace(designs, size=low), cost_ceilings), low, high)
        for _ in range(STEP_HALVINGS):
            middle = (low + high) / 2
            held = self.are_feasible_under_ceilings(replace(designs, size=middle), cost_ceilings)
            low, high = np.where(held, low, middle), np.where(held, middle, high)
        return high


def polish_designs(pattern: PatternSearch, designs: Designs, cost_ceilings: FloatArray) -> Designs:
    """The designs at their optima under ceilings (designs, objectives), which the designs meet at the start."""
    proved = np.zeros(len(designs), dtype=bool)
    if pattern.minimises_size:
        designs, proved = move_to_closed_form_optima(pattern, designs, cost_ceilings)
    rest = np.flatnonzero(~proved)
    return (
        designs.replace_at(rest, search_by_pattern(pattern, designs.take(rest), cost_ceilings[rest]))
        if rest.size
        else designs
    )


def search_by_pattern(pattern: PatternSearch, designs: Designs, cost_ceilings: FloatArray) -> Designs:
    """The designs at local optima, by a pattern search; designs that are not allowed stay."""
    names = [name for name in pattern.free if not (pattern.minimises_size and name == "size")]
    designs, value = pattern.shrink_and_evaluate_objective(designs, cost_ceilings)
    step = np.where(np.isfinite(value), OPENING_STEP, 0.0)
    random = np.random.default_rng(0)
    for _ in range(SEARCH_STEPS if names else 0):
        active = np.flatnonzero(step > SHORTEST_STEP)
        if not active.size:
            break
        # both ways along each axis, and with several axes also along those of a frame turned at random
        many = len(names)
        frames = [np.eye(many)] if many == 1 else [np.eye(many), np.linalg.qr(random.normal(size=(many, many)))[0]]
        directions = np.concatenate([sign * frame for frame in frames for sign in (1.0, -1.0)])
        index = np.repeat(active, len(directions))
        shares = step[index, None] * np.tile(directions, (active.size, 1))
        moved = designs.take(index)
        values = moved.values
        for name, share in zip(names, shares.T, strict=True):  # but not beyond the range
            low, high = pattern.free[name]
            values[name] = np.clip(values[name] + share * (high - low), low, high)
        moved, reached = pattern.shrink_and_evaluate_objective(moved.with_values(values), cost_ceilings[index])
        best = np.argmin(reached.reshape(active.size, -1), axis=1) + np.arange(active.size) * len(directions)
        better = reached[best] < value[active] - LEAST_STEP_GAIN * np.abs(value[active])
        step[active] = np.where(better, np.minimum(2 * step[active], LONGEST_STEP), step[active] / 2)
        value[active[better]] = reached[best[better]]
        designs = designs.replace_at(active[better], moved.take(best[better]))
    return designs


def move_to_closed_form_optima(
    pattern: PatternSearch, designs: Designs, cost_ceilings: FloatArray
) -> tuple[Designs, BoolArray]:
    """The designs, those with a closed form at their proved optimum, and a mask of these.

    The linear limits, with the ceilings of the pressure angle, give a design that no allowed one undercuts in size.
    If it is allowed, it is the smallest.
    """
    bounds = [
        _closed_form_smallest_design(pattern, designs.take([i]), cost_ceilings[i]) for i in range(len(designs))
    ]
    index = np.flatnonzero([design is not None for design in bounds])
    proved = np.zeros(len(designs), dtype=bool)
    if not index.size:
        return designs, proved
    least = concatenate_designs([design for design in bounds if design is not None])
    open_ = np.arange(index.size)
    for step in NUDGES:
        larger = replace(least, size=least.size + step * least.prime_radius).take(open_)
        held = larger.size <= designs.size[index[open_]]
        held[held] = pattern.are_feasible_under_ceilings(larger.take(held), cost_ceilings[index[open_[held]]])
        designs = designs.replace_at(index[open_[held]], larger.take(held))
        proved[index[open_[held]]] = True
        open_ = open_[~held]
    nudge = least.size[open_] + NUDGES[-1] * least.prime_radius[open_]
    proved[index[open_]] = designs.size[index[open_]] <= nudge  # as small as rounding allows
    return designs, proved


def _closed_form_smallest_design(
    pattern: PatternSearch, design: Designs, cost_ceilings: FloatArray
) -> Designs | None:
    """The smallest design under the linear limits and ceilings; None without a closed form."""
    problem = pattern.problem
    most = dict(zip(problem.objectives, cost_ceilings, strict=True))
    angle = most.get("pressure_angle_max_deg", np.inf)
    on_return = min(angle, most.get("pressure_angle_max_return_deg", np.inf))
    if on_return <= 0.0:
        return None
    bounds = (float(b) if b < np.inf else None for b in (angle, on_return))
    pressure = pressure_angle_limits(problem.setup, *bounds)
    tighter = replace(problem, limits=(*problem.limits, *pressure))
    box = {name: (float(value[0]), float(value[0])) for name, value in design.values.items()}
    box |= {name: ends for name, ends in pattern.free.items() if name in design.sizes}
    box["size"] = (size_lower_bound(tighter, box), box["size"][1])
    return closed_form_design(tighter, box)

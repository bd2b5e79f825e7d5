"""A small cam over sizes and the angles of a turn, by the simplex method of Nelder and Mead, without proof.

Source: J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7 (1965).
"""

from collections.abc import Callable
from functools import partial
from itertools import permutations
from math import inf
from typing import Any

import numpy as np
import scipy

from camopt.core.numerics import FloatArray, IndexArray
from camopt.core.numerics.budget import Budget
from camopt.model.mechanisms.design import SizeBounds
from camopt.solve.smallest.closed_form import closed_form_design
from camopt.solve.smallest.result import SmallestCam, allowed_proof_gap
from camopt.solve.smallest.smallest import solve_small_cam_unproved
from camopt.solve.smallest.turns import SegmentAngles, TurnOptimum, better_turn

INFEASIBLE_COST = 1e9  # mm: cost of a point without a feasible design
NARROW_RANGE = 1e-9  # deg: angles with narrower ranges are fixed
DESCENT_MOVES = 80  # most evaluations of a descent, for each angle
LEAST_TRADE, TRADE_GAIN = (
    1e-3,
    1e-7,
)  # smallest trade between segments, deg, and smallest gain, relative to the size
ROUGH_END, FINE_END = 1e-6, 1e-10  # tolerances at which a descent ends, mm and shares of a range


def descend_simplex(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    steps: FloatArray,
    end_tolerances: tuple[float, float],
    moves_per_variable: int,
    budget: Budget,
    variable_range: tuple[float, float] | None = None,
) -> FloatArray:
    """The point of least cost that the simplex method reaches from a start, with ``steps`` along each variable.

    It ends at ``moves_per_variable`` evaluations for each variable, when the budget is spent, or when the steps and
    costs of the simplex differ by no more than ``end_tolerances``. ``variable_range`` is that of every variable.
    """

    def stop_when_budget_is_spent(intermediate_result: Any) -> None:
        if budget.is_spent:
            raise StopIteration

    corners = start + np.vstack([np.zeros(start.size), np.diag(steps)])
    step, change = end_tolerances
    options = {
        "initial_simplex": corners,
        "xatol": step,
        "fatol": change,
        "maxfev": moves_per_variable * start.size,
    }
    return np.asarray(
        scipy.optimize.minimize(
            cost,
            start,
            bounds=None if variable_range is None else [variable_range] * start.size,
            method="Nelder-Mead",
            callback=stop_when_budget_is_spent,
            options=options,
        ).x
    )


class NelderMead:
    """Descents over the angles from the best turn so far; without proof, but most often they reach the optimum."""

    def __init__(self, turns: SegmentAngles, bounds: SizeBounds, best: TurnOptimum | None = None) -> None:
        self.turns, self.bounds, self.box = turns, bounds, turns.angle_box
        self.free = np.flatnonzero(self.box.high - self.box.low > NARROW_RANGE)
        middle = self.box.low + 0.5 * (self.box.high - self.box.low)
        self.best = best or TurnOptimum(SmallestCam(None, 0.0), turns.turn_near_angles(middle, self.box))

    def best_of_few_turns(self) -> TurnOptimum:
        """The best turn by the closed form, if it decides; else the first with a cam of a few.

        These are the middle turn, the scene's and the corner turns.
        """
        self.solve_small_cam_of_turn(self.best.freed_angles)
        if self.free.size > 1 and self.descend_by_closed_form():
            return self.best
        scene = self.turns.scene_angles
        inside = np.all((scene >= self.box.low) & (scene <= self.box.high))
        for freed in [*([scene] if inside else []), *self.turns.corner_turn_angles]:
            if self.best.answer.design is None and not self.turns.budget.is_spent:
                self.solve_small_cam_of_turn(freed)
        return self.best

    def find_best_turn(self) -> TurnOptimum:
        """The best turn that descents reach from the best one so far."""
        if self.free.size > 1 and self.best.answer.design is not None:
            self.descend_from_best_turn(self.small_cam_size_of_turn, 0.05, ROUGH_END)
            self.trade_angles_between_segments(self.small_cam_size_of_turn, self.best.freed_angles)
            self.descend_from_best_turn(partial(self.small_cam_size_of_turn, with_fine_grids=True), 1e-3, FINE_END)
        return self.best

    def solve_small_cam_of_turn(self, freed_angles: FloatArray, *, with_fine_grids: bool = False) -> SmallestCam:
        """A small cam for a turn, kept if it is the best so far."""
        best, problem = self.best.answer.design, self.turns.problem_with_angles(freed_angles)
        answer = solve_small_cam_unproved(
            problem, self.bounds, best, self.turns.budget, with_fine_grids=with_fine_grids
        )
        if answer.design is None and best is None:
            self.best = TurnOptimum(answer, freed_angles)
        self.best = better_turn(self.best, TurnOptimum(answer, freed_angles))
        return answer

    def small_cam_size_of_turn(self, freed_angles: FloatArray, *, with_fine_grids: bool = False) -> float:
        """Size of a small cam for a turn [mm]; ``INFEASIBLE_COST`` if there is none or the budget is spent."""
        if self.turns.budget.is_spent:
            return INFEASIBLE_COST
        return min(
            self.solve_small_cam_of_turn(freed_angles, with_fine_grids=with_fine_grids).size, INFEASIBLE_COST
        )

    def closed_form_size(self, freed_angles: FloatArray) -> float:
        """Size by the closed form alone [mm]; most often no other limit needs a larger one."""
        design = closed_form_design(self.turns.problem_with_angles(freed_angles), self.bounds)
        return INFEASIBLE_COST if design is None else float(design.size[0])

    def descend_by_closed_form(self) -> bool:
        """Descend by the closed form; True if the cam at the end meets all other limits too."""
        for reach in (0.05, 1e-3):
            turn = self.trade_angles_between_segments(
                self.closed_form_size, self.descend_from_best_turn(self.closed_form_size, reach, FINE_END)
            )
            least, answer = self.closed_form_size(turn), self.solve_small_cam_of_turn(turn)
            decided = (
                least < INFEASIBLE_COST
                and answer.design is not None
                and answer.size <= least + allowed_proof_gap(answer.design)
            )
        return decided

    def turn_with_shifted_angles(
        self, start: FloatArray, segment_order: IndexArray, steps: FloatArray
    ) -> FloatArray:
        """A turn with free segments longer by shares of their ranges; the last in order makes up the total."""
        shifted, lengths = start.copy(), steps * (self.box.high - self.box.low)[segment_order[:-1]]
        shifted[segment_order[:-1]] += lengths
        shifted[segment_order[-1]] -= lengths.sum()
        return shifted

    def trade_angles_between_segments(self, cost: Callable[[FloatArray], float], turn: FloatArray) -> FloatArray:
        """The turn after moving degrees from one segment to another for as long as that reduces the cost.

        Pairs of segments follow the edges of the box of turns, and stay exactly on an end of a range.
        """
        least, step = cost(turn), float(np.max(self.box.high - self.box.low)) / 4.0
        while step > LEAST_TRADE and not self.turns.budget.is_spent:
            before = least
            for longer, shorter in permutations(self.free, 2):
                most_gain, most_loss = self.box.high[longer] - turn[longer], turn[shorter] - self.box.low[shorter]
                room = min(most_gain, most_loss)
                trade = min(step, room)
                other = turn.copy()
                other[longer] = self.box.high[longer] if trade == most_gain else turn[longer] + trade
                other[shorter] = self.box.low[shorter] if trade == most_loss else turn[shorter] - trade
                size = cost(other) if room > 0.0 else inf
                if size < least:
                    turn, least = other, size
            step = step if least < before * (1.0 - TRADE_GAIN) else step / 4.0
        return turn

    def descend_from_best_turn(
        self, cost: Callable[[FloatArray], float], first_step: float, end_tolerance: float
    ) -> FloatArray:
        """The turn of least cost that a simplex reaches from the best one; ``first_step`` is its first step."""
        start = self.best.freed_angles
        room = np.minimum(start - self.box.low, self.box.high - start)[self.free]
        order = self.free[np.argsort(room, kind="stable")]
        inwards = np.where(self.box.high - start >= start - self.box.low, first_step, -first_step)[order[:-1]]

        def cost_at_steps(steps: FloatArray) -> float:
            turn = self.turn_with_shifted_angles(start, order, steps)
            outside = float(np.maximum(self.box.low - turn, turn - self.box.high).max(initial=0.0))
            return cost(turn) if outside <= 0.0 else INFEASIBLE_COST * (1.0 + outside)

        steps = descend_simplex(
            cost_at_steps,
            np.zeros(inwards.size),
            inwards,
            (end_tolerance, end_tolerance),
            DESCENT_MOVES,
            self.turns.budget,
        )
        return self.turn_with_shifted_angles(start, order, steps)

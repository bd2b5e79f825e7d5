"""The smallest cam over sizes and numbers of the train: a sample of trains, descents from the best, then a proof.

Each train gives the follower another motion, and each motion has its smallest cam. A small cam, without proof, is
enough for the sample and the first descents (simplex method of Nelder and Mead). Boxes of sizes and trains
(``motion_boxes``) then prove that no other train has a smaller cam, or find that train. If the boxes do not finish,
a finer descent solves for the smallest cam itself, and the answer is the best train tried.

A box is dropped if a limit at some cam angle (``train_limits``) proves that it holds no feasible cam, or if none of
its trains or cams can be assembled. Limits on the train alone (transmission angle, forces in joints) and on means
over the turn drop boxes too. Means under loads that change over the turn, or with friction in guides, drop no box;
the answer meets them all the same.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.sloped_interval import SlopedInterval
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.scene.problem.sample import SAMPLERS
from camopt.solve.smallest.closed_form import least_allowed_size
from camopt.solve.smallest.free_variables import free_train_numbers
from camopt.solve.smallest.grid_search import largest_possible_size
from camopt.solve.smallest.motion_boxes import BoxExcesses, MotionSearch
from camopt.solve.smallest.nelder_mead import INFEASIBLE_COST, descend_simplex
from camopt.solve.smallest.result import SmallestCam
from camopt.solve.smallest.smallest import solve_small_cam_unproved, solve_smallest_cam
from camopt.solve.smallest.train_limits import TrainLimits
from camopt.solve.verdicts.driven_boxes import searched_train_keys
from camopt.solve.verdicts.train_boxes import is_tool_derivative

SPREAD_TRAINS, CORNERED_NUMBERS = (
    16,
    3,
)  # sampled trains; up to this many numbers the corners of their ranges are tried too
TRAIN_WORK = 1e4
PHASE_SHARES = 1 / 6, 1 / 4, 5 / 6  # shares of the budget after which the sample, the first descents and boxes end


class TrainOptimum(NamedTuple):
    """The smallest cam of the trains tried, with the problem of its train."""

    problem: Problem
    answer: SmallestCam
    out_of_time: bool = False
    """Whether the search stopped early."""


class TrainBoxSearch(MotionSearch):
    """Branch and bound over the trains of a problem, below the best cam so far."""

    def __init__(self, problem: Problem, bounds: SizeBounds, best: TrainOptimum, budget: Budget) -> None:
        self.problem, self.bounds, self.budget = with_rounding_relative_error(problem), bounds, budget
        self.best, self.best_motion = best.answer, best.problem
        self.limits = TrainLimits.from_problem(self.problem.with_keys_per_design(self.motion_fields))

    @cached_property
    def motion_fields(self) -> Collection[str]:
        return searched_train_keys(self.problem)

    def search_ranges(self) -> SizeBounds:
        least = least_allowed_size(self.problem, self.bounds)
        most = min(largest_possible_size(self.problem, self.bounds), self.best.size)
        trains = {each.key: each.range_ends for each in free_train_numbers(self.problem)}
        return {**self.bounds, **trains, "size": (least, most)}

    def problem_and_motion_of_design(self, design: Designs) -> tuple[Problem, Problem]:
        problem = self.problem.with_numbers({key: float(design.numbers[key][0]) for key in self.motion_fields})
        return problem, problem

    def add_worst_excess_places(self, design: Designs, problem: Problem) -> None:
        mechanism = problem.setup.mechanism
        if not mechanism.has_no_assembly and mechanism.can_assemble(design, problem.programme)[0]:
            self.limits.add_worst_excess_places(design, problem)

    def box_excesses(self, boxes: Designs, inside: Designs, template_interval: SlopedInterval) -> BoxExcesses:
        with np.errstate(all="ignore"):
            return self.limits.box_excesses(boxes, inside, template_interval)


@dataclass
class TrainOptimiser:
    """A search among trains; each train is given by its shares, the positions of its numbers in their ranges."""

    problem: Problem
    bounds: SizeBounds
    budget: Budget
    optima: dict[tuple[float, ...], TrainOptimum] = field(default_factory=dict)
    """The smallest cam of each train tried, by its shares."""

    def find_smallest_cam(self) -> TrainOptimum:
        """The smallest cam of all trains tried, with the lower bound over all trains."""
        spread, rough, boxes = (self.budget.share(1.0 / part) for part in PHASE_SHARES)
        for shares in self._trial_train_shares():
            self.cam_size_of_train(shares, solve_small_cam_unproved, spread)
        stopped_early = spread.is_spent
        self.descend_from_best_train(
            solve_small_cam_unproved, rough, first_step=0.1, end_tolerances=(1e-3, 1e-3), moves_per_number=15
        )
        stopped_early |= rough.is_spent
        bounded = self._bound_all_trains(boxes)
        if bounded.answer.is_proved:
            return bounded
        stopped_early |= boxes.is_spent
        self.descend_from_best_train(
            solve_smallest_cam, self.budget, first_step=0.02, end_tolerances=(1e-7, 1e-9), moves_per_number=50
        )
        best = min(bounded, self._best_train_optimum, key=lambda train: train.answer.size)
        return best._replace(answer=replace(best.answer, floor=bounded.answer.floor), out_of_time=stopped_early)

    def _bound_all_trains(self, budget: Budget) -> TrainOptimum:
        """The best train, with a lower bound of the size over all trains.

        If the scene gives the motion at the follower, limits that do not involve the tool are the same for all
        trains, and give the bound.
        """
        if not self.problem.programme.given_at_follower:
            search = TrainBoxSearch(self.problem, self.bounds, self._best_train_optimum, budget)
            answer = search.find_smallest_cam()
            return TrainOptimum(search.best_motion, answer)
        best, floor, train = self._best_train_optimum, 0.0, self.problem.setup.train
        if train is None or not train.carried:
            limits = tuple(
                limit
                for limit in self.problem.limits
                if limit.constraints and not any(is_tool_derivative(each.curve) for each in limit.constraints)
            )
            floor = solve_smallest_cam(replace(self.problem, limits=limits), self.bounds, budget=budget).floor
        return best._replace(answer=replace(best.answer, floor=floor))

    @property
    def _best_train_optimum(self) -> TrainOptimum:
        return min(
            self.optima.values(), key=lambda each: (each.answer.size, each.problem.setup.mechanism.has_no_assembly)
        )

    def cam_size_of_train(self, shares: FloatArray, solve: Callable[..., SmallestCam], budget: Budget) -> float:
        """Size of the cam of a train [mm]; ``INFEASIBLE_COST`` if there is none or the budget is spent."""
        if self.optima and budget.is_spent:
            return INFEASIBLE_COST
        values = {
            each.key: float(each.values_at_shares(np.array(s)))
            for each, s in zip(free_train_numbers(self.problem), shares, strict=True)
        }
        self.budget.spend(TRAIN_WORK)
        problem = self.problem.with_numbers(values)
        has_no_assembly = problem.setup.mechanism.has_no_assembly
        answer = SmallestCam(None, inf) if has_no_assembly else solve(problem, self.bounds, budget=budget)
        key = tuple(map(float, shares))
        if key not in self.optima or answer.size < self.optima[key].answer.size:
            self.optima[key] = TrainOptimum(problem, answer)
        return min(answer.size, INFEASIBLE_COST)

    def descend_from_best_train(
        self,
        solve: Callable[..., SmallestCam],
        budget: Budget,
        first_step: float,
        end_tolerances: tuple[float, float],
        moves_per_number: int,
    ) -> None:
        """Descend from the best train tried, if it has a cam, by the simplex method; its trains go into ``optima``.

        ``first_step`` and the first tolerance are shares of each range; the second is a difference of sizes, mm.
        """
        feasible = [shares for shares, train in self.optima.items() if train.answer.design is not None]
        if feasible:
            start = np.array(min(feasible, key=lambda shares: self.optima[shares].answer.size))
            cost = partial(self.cam_size_of_train, solve=solve, budget=budget)
            steps = np.where(start > 0.5, -first_step, first_step)
            descend_simplex(cost, start, steps, end_tolerances, moves_per_number, budget, variable_range=(0.0, 1.0))

    def _trial_train_shares(self) -> Iterator[FloatArray]:
        """The shares of the scene's train, of the corners of few ranges, and of a sample of all ranges."""
        numbers = free_train_numbers(self.problem)
        count = len(numbers)
        # the scene's own train, or the nearest one within the ranges
        shares = []
        for number in numbers:
            low, high = number.range_ends
            value = self.problem.setup.given[number.key]
            shares.append(0.5 if value is None or high == low else (value - low) / (high - low))
        yield np.clip(shares, 0.0, 1.0)
        for corner in product((0.0, 1.0), repeat=count) if count <= CORNERED_NUMBERS else ():
            yield np.array(corner)
        yield from SAMPLERS["sobol"](count, SPREAD_TRAINS, 0)

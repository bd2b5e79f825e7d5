"""The smallest cam over numbers of the train as well: the best of many in their ranges, descents from it, a proof.

Each train gives the follower another motion, of which the smallest cam is sought as that of any other: a small one
where many trains are tried, the smallest itself near the best of them (simplex method of Nelder and Mead). Boxes of
sizes and trains (``motion_boxes``) then prove that no other train has a smaller cam, or find it; where they run
out, the answer is the best of the trains that were tried.

A box is dropped if a limit at some cam angle (``train_limits``) shows that it holds no feasible cam, or if none of
its trains, or of its cams, can be put together. Limits on what trains alone do, the transmission angle and the
forces in joints, and on means over the turn do the same. Means under loads that change over the turn, and those of
guides with friction, drop no box; a cam has to hold them like all others to be the answer.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds
from camopt.core.numerics.sloped_interval import SlopedInterval
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, at_rounding_error
from camopt.scene.problem.sample import SAMPLERS
from camopt.scene.problem.settings import NumberSetting
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.boxes import DesignBoxes
from camopt.solve.smallest.closed_form import negligible_size
from camopt.solve.smallest.grid_search import largest_possible_size
from camopt.solve.smallest.motion_boxes import BoxExcesses, MotionSearch
from camopt.solve.smallest.nelder_mead import INFEASIBLE_COST, descend_simplex
from camopt.solve.smallest.result import SmallestCam
from camopt.solve.smallest.smallest import solve_small_cam, solve_smallest_cam
from camopt.solve.smallest.train_limits import TrainLimits
from camopt.solve.verdicts.driven_boxes import train_keys

SPREAD_TRAINS, CORNERED_NUMBERS = (
    16,
    3,
)  # trains all over the ranges; of how many numbers at most the ends of all as well
TRAIN_DESCENTS = 1  # from the best of them, before boxes
PHASE_SHARES = 1 / 6, 1 / 4, 5 / 6  # of the time: when trains all over, on the way down, and boxes are left


class TrainOptimum(NamedTuple):
    """The smallest cam of the trains that were tried, with the problem of its train."""

    problem: Problem
    answer: SmallestCam
    out_of_time: bool = False
    """Whether the time was over before the search was."""


class TrainBoxSearch(MotionSearch):
    """A search among the trains of a problem, below the best cam so far."""

    def __init__(self, problem: Problem, bounds: SizeBounds, found: TrainOptimum, until: float) -> None:
        self.problem, self.bounds, self.until = at_rounding_error(problem), bounds, until
        self.best, self.best_motion = found.answer, found.problem
        self.limits = TrainLimits.from_problem(self.problem.with_free_keys(self.motion_fields))

    @cached_property
    def motion_fields(self) -> Collection[str]:
        return train_keys(self.problem)

    def search_ends(self) -> SizeBounds:
        of_limits = max((limit.least_size for limit in self.problem.limits), default=0.0)
        least = max(self.bounds["size"][0], of_limits, negligible_size(self.problem, self.bounds))
        most = min(largest_possible_size(self.problem, self.bounds), self.best.size)
        trains = {each.key: each.range_ends for each in self.problem.search_space.trains if each.has_range}
        return {**self.bounds, **trains, "size": (least, most)}

    def motion_at_middle(self, boxes: DesignBoxes) -> tuple[Problem, Problem]:
        numbers = {key: float(boxes.low[key][0] + boxes.high[key][0]) / 2.0 for key in self.motion_fields}
        problem = self.problem.with_numbers(numbers)
        return problem, problem

    def learn_worst_places(self, design: Designs, problem: Problem) -> None:
        mechanism = problem.setup.mechanism
        if not mechanism.has_no_assembly and mechanism.can_assemble(design, problem.programme)[0]:
            self.limits.learn_worst_places(design, problem)

    def box_excesses(self, boxes: Designs, inside: Designs, like: SlopedInterval) -> BoxExcesses:
        with np.errstate(all="ignore"):
            return self.limits.box_excesses(boxes, inside, like)


def listed_trains(problem: Problem) -> list[NumberSetting]:
    """The combinations of numbers of the train of which ``[search]`` lists values; one without any."""
    listed = [each for each in problem.search_space.trains if not each.has_range]
    values = product(*(each.grid_values.tolist() for each in listed))
    return [dict(zip((each.key for each in listed), each, strict=True)) for each in values]


def free_train_numbers(problem: Problem) -> list[Variable]:
    """The numbers of the train of which ``[search]`` gives a range."""
    return [each for each in problem.search_space.trains if each.has_range]


class Descent(NamedTuple):
    """How to go down from a train."""

    reach: float
    """The first step, a share of each range."""
    moves: int
    """Trains that are tried at most, for each number."""
    share: float
    """Of each range: it ends where steps are no longer, and sizes differ by no more than ``size``."""
    size: float
    """mm"""
    solve: Callable[..., SmallestCam]
    """What finds the cam of one train."""


ROUGH_DESCENT, FINE_DESCENT = (
    Descent(0.1, 15, 1e-3, 1e-3, solve_small_cam),
    Descent(0.02, 50, 1e-7, 1e-9, solve_smallest_cam),
)


def _is_of_tool(limit: Limit) -> bool:
    """Whether a limit is about the motion of the tool."""
    curves = [constraint.curve for constraint in limit.constraints]
    return any(isinstance(each, Derivative) and not each.at_follower for each in curves)


@dataclass
class TrainOptimiser:
    """A search among trains, by the shares that their numbers take of their ranges."""

    problem: Problem
    bounds: SizeBounds
    until: float
    """When it is to stop (``clock.now``)."""
    optima: dict[tuple[float, ...], TrainOptimum] = field(default_factory=dict)
    """The best of each train by those shares."""
    out_of_time: bool = False
    """Whether a train was left out because the time was over."""

    def run(self) -> TrainOptimum:
        """The smallest cam of all trains that were tried."""
        spread, rough, boxes = (clock_seconds() + part * (self.until - clock_seconds()) for part in PHASE_SHARES)
        for shares in self._sample_shares():
            self.size_of_train(shares, solve_small_cam, spread)
        for start in self._best_shares(TRAIN_DESCENTS):
            self.descend_from_train(start, ROUGH_DESCENT, rough)
        found = self._bound_all_trains(boxes)
        if found.answer.is_proved:
            return found
        self.out_of_time |= clock_seconds() > boxes
        for start in self._best_shares(1):
            self.descend_from_train(start, FINE_DESCENT, self.until)
        best = min(found, self._best_train, key=lambda each: each.answer.size)
        return best._replace(answer=replace(best.answer, floor=found.answer.floor), out_of_time=self.out_of_time)

    def _bound_all_trains(self, until: float) -> TrainOptimum:
        """The best train, with a size that no cam of any train undercuts.

        Where the follower's motion is given, the limits that the tool does not enter hold for all trains.
        """
        if not self.problem.programme.given_at_follower:
            search = TrainBoxSearch(self.problem, self.bounds, self._best_train, until)
            answer = search.run()
            return TrainOptimum(search.best_motion, answer)
        best, floor, train = self._best_train, 0.0, self.problem.setup.train
        if train is None or not train.carried:
            alone = tuple(each for each in self.problem.limits if each.constraints and not _is_of_tool(each))
            floor = solve_smallest_cam(replace(self.problem, limits=alone), self.bounds, until=until).floor
        return best._replace(answer=replace(best.answer, floor=floor))

    @property
    def _best_train(self) -> TrainOptimum:
        """The best of all trains that were tried."""
        return min(
            self.optima.values(), key=lambda each: (each.answer.size, each.problem.setup.mechanism.has_no_assembly)
        )

    def size_of_train(self, shares: FloatArray, solve: Callable[..., SmallestCam], until: float) -> float:
        """The size of the cam of a train; none is looked for when the time is over."""
        if self.optima and clock_seconds() > until:
            self.out_of_time = True
            return INFEASIBLE_COST
        variables = free_train_numbers(self.problem)
        values = {
            each.key: float(each.values_at_shares(np.array(s))) for each, s in zip(variables, shares, strict=True)
        }
        problem = self.problem.with_numbers(values)
        apart = problem.setup.mechanism.has_no_assembly
        found = TrainOptimum(problem, SmallestCam(None, inf) if apart else solve(problem, self.bounds, until=until))
        key = tuple(map(float, shares))
        if key not in self.optima or found.answer.size < self.optima[key].answer.size:
            self.optima[key] = found
        return min(found.answer.size, INFEASIBLE_COST)

    def descend_from_train(self, start: FloatArray, how: Descent, until: float) -> None:
        """Go down from a train by a simplex."""
        cost, steps = (
            partial(self.size_of_train, solve=how.solve, until=until),
            np.where(start > 0.5, -how.reach, how.reach),
        )
        descend_simplex(cost, start, steps, (how.share, how.size), how.moves, until, ends=(0.0, 1.0))

    def _best_shares(self, count: int) -> list[FloatArray]:
        """The best trains with a feasible cam."""
        feasible = (shares for shares, each in self.optima.items() if each.answer.design is not None)
        return [np.array(shares) for shares in sorted(feasible, key=lambda s: self.optima[s].answer.size)[:count]]

    def _sample_shares(self) -> Iterator[FloatArray]:
        """The train of the scene, those at the ends of few ranges, and others all over them."""
        count = len(free_train_numbers(self.problem))
        # the scene's own train, or the nearest to it in the ranges
        shares = []
        for each in free_train_numbers(self.problem):
            low, high = each.range_ends
            own = self.problem.setup.given[each.key]
            shares.append(0.5 if own is None or high == low else (own - low) / (high - low))
        yield np.clip(shares, 0.0, 1.0)
        for corner in product((0.0, 1.0), repeat=count) if count <= CORNERED_NUMBERS else ():
            yield np.array(corner)
        yield from SAMPLERS["sobol"](count, SPREAD_TRAINS, 0)

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
from camopt.core.numerics.clock import now
from camopt.core.numerics.sloped import Sloped
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, exactly
from camopt.scene.problem.sample import SAMPLERS
from camopt.scene.problem.settings import Setting
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.boxes import Boxes
from camopt.solve.smallest.closed_form import negligible
from camopt.solve.smallest.first_look import largest_size
from camopt.solve.smallest.motion_boxes import MotionSearch, Said
from camopt.solve.smallest.nelder_mead import DEAR, descend
from camopt.solve.smallest.result import Smallest
from camopt.solve.smallest.smallest import small, smallest
from camopt.solve.smallest.train_limits import TrainLimits
from camopt.solve.verdicts.driven_boxes import train_keys

SPREAD, CORNERED = 16, 3  # trains all over the ranges; of how many numbers at most the ends of all as well
DESCENTS = 1  # from the best of them, before boxes
TIMES = 1 / 6, 1 / 4, 5 / 6  # of the time: when trains all over, on the way down, and boxes are left


class BestTrain(NamedTuple):
    """The smallest cam of the trains that were tried, with the problem of its train."""

    problem: Problem
    answer: Smallest
    cut: bool = False
    """Whether the time was over before the search was."""


class TrainBoxes(MotionSearch):
    """A search among the trains of a problem, below the best cam so far."""

    def __init__(self, problem: Problem, bounds: SizeBounds, found: BestTrain, until: float) -> None:
        self.problem, self.bounds, self.until = exactly(problem), bounds, until
        self.best, self.told = found.answer, found.problem
        self.limits = TrainLimits.of(self.problem.bringing(self.deciding))

    @cached_property
    def deciding(self) -> Collection[str]:
        return train_keys(self.problem)

    def ends(self) -> SizeBounds:
        of_limits = max((limit.least_size for limit in self.problem.limits), default=0.0)
        least = max(self.bounds["size"][0], of_limits, negligible(self.problem, self.bounds))
        most = min(largest_size(self.problem, self.bounds), self.best.size)
        trains = {each.key: each.ends for each in self.problem.choices.trains if each.in_range}
        return {**self.bounds, **trains, "size": (least, most)}

    def motion(self, boxes: Boxes) -> tuple[Problem, Problem]:
        numbers = {key: float(boxes.low[key][0] + boxes.high[key][0]) / 2.0 for key in self.deciding}
        problem = self.problem.with_numbers(numbers)
        return problem, problem

    def learn(self, design: Designs, problem: Problem) -> None:
        mechanism = problem.setup.mechanism
        if not mechanism.is_apart and mechanism.exists(design, problem.programme)[0]:
            self.limits.learn(design, problem)

    def said(self, boxes: Designs, inside: Designs, like: Sloped) -> Said:
        with np.errstate(all="ignore"):
            return self.limits.said(boxes, inside, like)


def listed_trains(problem: Problem) -> list[Setting]:
    """The combinations of numbers of the train of which ``[search]`` lists values; one without any."""
    listed = [each for each in problem.choices.trains if not each.in_range]
    values = product(*(each.values.tolist() for each in listed))
    return [dict(zip((each.key for each in listed), each, strict=True)) for each in values]


def free_of_train(problem: Problem) -> list[Variable]:
    """The numbers of the train of which ``[search]`` gives a range."""
    return [each for each in problem.choices.trains if each.in_range]


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
    solve: Callable[..., Smallest]
    """What finds the cam of one train."""


ROUGH, FINE = Descent(0.1, 15, 1e-3, 1e-3, small), Descent(0.02, 50, 1e-7, 1e-9, smallest)


def _enters_tool(limit: Limit) -> bool:
    """Whether a limit is about the motion of the tool."""
    curves = [claim.curve for claim in limit.claims]
    return any(isinstance(each, Derivative) and not each.at_follower for each in curves)


@dataclass
class TrainSearch:
    """A search among trains, by the shares that their numbers take of their ranges."""

    problem: Problem
    bounds: SizeBounds
    until: float
    """When it is to stop (``clock.now``)."""
    tried: dict[tuple[float, ...], BestTrain] = field(default_factory=dict)
    """The best of each train by those shares."""
    cut: bool = False
    """Whether a train was left out because the time was over."""

    def run(self) -> BestTrain:
        """The smallest cam of all trains that were tried."""
        spread, rough, boxes = (now() + part * (self.until - now()) for part in TIMES)
        for shares in self._spread():
            self.size(shares, small, spread)
        for start in self._best(DESCENTS):
            self.descend(start, ROUGH, rough)
        found = self._of_any_train(boxes)
        if found.answer.proved:
            return found
        self.cut |= now() > boxes
        for start in self._best(1):
            self.descend(start, FINE, self.until)
        best = min(found, self._least, key=lambda each: each.answer.size)
        return best._replace(answer=replace(best.answer, floor=found.answer.floor), cut=self.cut)

    def _of_any_train(self, until: float) -> BestTrain:
        """The best train, with a size that no cam of any train undercuts.

        Where the follower's motion is given, the limits that the tool does not enter hold for all trains.
        """
        if not self.problem.programme.given_at_follower:
            search = TrainBoxes(self.problem, self.bounds, self._least, until)
            answer = search.run()
            return BestTrain(search.told, answer)
        best, floor, train = self._least, 0.0, self.problem.setup.train
        if train is None or not train.carried:
            alone = tuple(each for each in self.problem.limits if each.claims and not _enters_tool(each))
            floor = smallest(replace(self.problem, limits=alone), self.bounds, until=until).floor
        return best._replace(answer=replace(best.answer, floor=floor))

    @property
    def _least(self) -> BestTrain:
        """The best of all trains that were tried."""
        return min(self.tried.values(), key=lambda each: (each.answer.size, each.problem.setup.mechanism.is_apart))

    def size(self, shares: FloatArray, solve: Callable[..., Smallest], until: float) -> float:
        """The size of the cam of a train; none is looked for when the time is over."""
        if self.tried and now() > until:
            self.cut = True
            return DEAR
        variables = free_of_train(self.problem)
        values = {each.key: float(each.values_at(np.array(s))) for each, s in zip(variables, shares, strict=True)}
        problem = self.problem.with_numbers(values)
        apart = problem.setup.mechanism.is_apart
        found = BestTrain(problem, Smallest(None, inf) if apart else solve(problem, self.bounds, until=until))
        key = tuple(map(float, shares))
        if key not in self.tried or found.answer.size < self.tried[key].answer.size:
            self.tried[key] = found
        return min(found.answer.size, DEAR)

    def descend(self, start: FloatArray, how: Descent, until: float) -> None:
        """Go down from a train by a simplex."""
        cost, steps = partial(self.size, solve=how.solve, until=until), np.where(start > 0.5, -how.reach, how.reach)
        descend(cost, start, steps, (how.share, how.size), how.moves, until, ends=(0.0, 1.0))

    def _best(self, count: int) -> list[FloatArray]:
        """The best trains with a feasible cam."""
        feasible = (shares for shares, each in self.tried.items() if each.answer.design is not None)
        return [np.array(shares) for shares in sorted(feasible, key=lambda s: self.tried[s].answer.size)[:count]]

    def _spread(self) -> Iterator[FloatArray]:
        """The train of the scene, those at the ends of few ranges, and others all over them."""
        count = len(free_of_train(self.problem))
        # the scene's own train, or the nearest to it in the ranges
        shares = []
        for each in free_of_train(self.problem):
            low, high = each.ends
            own = self.problem.setup.given[each.key]
            shares.append(0.5 if own is None or high == low else (own - low) / (high - low))
        yield np.clip(shares, 0.0, 1.0)
        for corner in product((0.0, 1.0), repeat=count) if count <= CORNERED else ():
            yield np.array(corner)
        yield from SAMPLERS["sobol"](count, SPREAD, 0)

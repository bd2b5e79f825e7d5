"""The smallest cam over numbers of the train as well: the best of many in their ranges, descents from it, a proof.

Each train gives the follower another motion, of which the smallest cam is sought as that of any other: a small one
where many trains are tried, the smallest itself near the best of them (simplex method of Nelder and Mead). Boxes of
sizes and trains (``train_boxes``) then prove that no other train has a smaller cam, or find it; where they run out,
the answer is the best of the trains that were tried.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.effects.peak import Derivative
from camopt.mechanisms.design import SizeBounds
from camopt.numerics import FloatArray
from camopt.numerics.clock import now
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem
from camopt.problem.sample import SAMPLERS
from camopt.problem.settings import Setting
from camopt.problem.variables import Variable
from camopt.smallest.nelder_mead import DEAR, descend
from camopt.smallest.result import Smallest
from camopt.smallest.smallest import small, smallest
from camopt.smallest.train_boxes import BestTrain, TrainBoxes

SPREAD, CORNERED = 16, 3  # trains all over the ranges; of how many numbers at most the ends of all as well
DESCENTS = 1  # from the best of them, before boxes
TIMES = 1 / 6, 1 / 4, 5 / 6  # of the time: when trains all over, on the way down, and boxes are left


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

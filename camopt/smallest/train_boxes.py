"""The smallest cam over sizes and numbers of the train together, by bisection of boxes of both (``motion_boxes``).

A box is dropped if a limit at some cam angle (``train_limits``) shows that it holds no feasible cam, or if none of
its trains, or of its cams, can be put together. Limits on what trains alone do, the transmission angle and the
forces in joints, and on means over the turn do the same. Means under loads that change over the
turn, and those of guides with friction, drop no box; a cam has to hold them like all others to be the answer.
"""

from collections.abc import Collection
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.mechanisms import Designs
from camopt.mechanisms.design import SizeBounds
from camopt.numerics.sloped import Sloped
from camopt.problem.problem import Problem, exactly
from camopt.smallest.boxes import Boxes
from camopt.smallest.closed_form import negligible
from camopt.smallest.first_look import largest_size
from camopt.smallest.motion_boxes import MotionSearch, Said
from camopt.smallest.result import Smallest
from camopt.smallest.train_limits import TrainLimits
from camopt.verdicts.driven_boxes import train_keys


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

"""The smallest cam over sizes and motions together, by bisection of boxes of both, many at once.

A box is dropped only if a limit at some cam angle shows that it holds no feasible cam, or if a feasible cam is
known that is as small. What is left when the search is stopped bounds how much smaller a cam may be.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from abc import abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics.sloped_interval import SlopedInterval
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.boxes import Bisection, DesignBoxes
from camopt.solve.smallest.excesses import Excesses, chained_excesses, cut_boxes, widest_side, with_weighted_sum
from camopt.solve.smallest.grid_search import size_scale
from camopt.solve.smallest.result import SmallestCam, allowed_gap, crossing_memory, first_feasible_design
from camopt.solve.smallest.smallest import solve_small_cam
from camopt.solve.verdicts.sloped_designs import sloped_boxes

MOTION_BATCH = 256  # boxes examined together, at most, to stop in time
SEARCHED_MIDDLES = 12  # boxes whose middle is searched: the best motion so far may be in another valley
LADDER_ROUNDS, LADDER_SIZES = 3, 16  # how often so many sizes of a box are looked at, closer and closer


class BoxExcesses(NamedTuple):
    """What is above 0 only where no cam of a box is feasible."""

    limits: Sequence[Excesses]
    others: Sequence[Excesses] = ()
    """What is asked besides."""
    guides: Sequence[Excesses] = ()
    """What tells which side to cut, and nothing else."""


class MotionSearch(Bisection):
    """A search among motions, and sizes of their cams, below the best cam so far."""

    most_boxes = 50_000
    problem: Problem
    bounds: SizeBounds
    until: float
    """When it is to stop (``clock.now``)."""
    best: SmallestCam
    """The smallest cam so far."""
    best_motion: Any
    """What its motion is told by."""
    lift: float | None = None
    """Of motions, where it is not that of the problem's."""
    batch_count: int = 0

    @property
    @abstractmethod
    def motion_fields(self) -> Collection[str]:
        """What decides the motion, by field of boxes."""

    @abstractmethod
    def search_ends(self) -> SizeBounds:
        """Between which sizes, and numbers that decide the motion, are worth a look."""

    @abstractmethod
    def motion_at_middle(self, boxes: DesignBoxes) -> tuple[Problem, Any]:
        """The problem of a motion in the middle of the first box, and what it is told by."""

    @abstractmethod
    def learn_worst_places(self, design: Designs, problem: Problem) -> None:
        """Look for the places where a design in the middle of a box exceeds limits the most."""

    @abstractmethod
    def box_excesses(self, boxes: Designs, inside: Designs, like: SlopedInterval) -> BoxExcesses:
        """What limits say of boxes as designs of ranges with slopes, as ``like`` is."""

    def run(self) -> SmallestCam:
        """The smallest cam, with a size that no cam undercuts."""
        ends = self.search_ends()
        floor, most = ends["size"]  # most often no cam may be as small
        if most > floor:
            scale = size_scale(self.problem, self.bounds, self.lift)
            floor = self.bisect(
                DesignBoxes.single_box(ends, scale, self.problem.search_space.variables), self.until
            )
        return replace(self.best, floor=floor)

    def possible_boxes(self, boxes: DesignBoxes) -> DesignBoxes:
        """What of some boxes can be a motion at all."""
        return boxes

    def select_batch(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """Those with the smallest cams, and the rest."""
        order = np.argsort(boxes.low["size"], kind="stable")
        return boxes.take(order[:MOTION_BATCH]), boxes.take(order[MOTION_BATCH:])

    def contract_boxes(self, boxes: DesignBoxes) -> DesignBoxes:
        """What of some boxes may be part of a motion and hold a smaller cam, which is looked for there."""
        boxes = self.possible_boxes(boxes)
        if not len(boxes):
            return boxes
        self.batch_count += 1
        self.search_middle(boxes, closely=self.batch_count <= SEARCHED_MIDDLES)
        return self.contract_by_limits(boxes)

    def contract_by_limits(self, boxes: DesignBoxes) -> DesignBoxes:
        """Those of some boxes that may hold a smaller cam, without what limits cut off, and the side to cut."""
        if self.best.design is not None:
            boxes = self.drop_finished(boxes, boxes.low["size"] >= self.best.size - allowed_gap(self.best.design))
            boxes = boxes.cap_sizes(self.best.size)
        if not len(boxes):
            return boxes
        inside = boxes.middle_designs(self.problem.design)
        looked, like = sloped_boxes(boxes.as_designs(self.problem.design), inside, list(boxes.free), 1)
        middle = np.array([inside.values[name] for name in boxes.free])
        low, high = (np.array([ends[name] for name in boxes.free]) for ends in (boxes.low, boxes.high))
        with np.errstate(all="ignore"):
            reach = like.span
            limits, others, guides = self.box_excesses(looked, inside, like)
            if not limits:
                return boxes.with_ends({}, {}, np.argmax(reach.high, axis=0))
            over = chained_excesses([*limits, *others])
            low, high, empty = cut_boxes(
                with_weighted_sum(over, reach, boxes.free.index("size")), low, high, middle
            )
            side = widest_side(chained_excesses([*limits, *guides]), reach)
        named = (dict(zip(boxes.free, each, strict=True)) for each in (low, high))
        boxes = boxes.with_ends(next(named), next(named), side).take(~empty)
        return self.drop_finished(boxes, boxes.is_narrow)

    def search_middle(self, boxes: DesignBoxes, *, closely: bool) -> None:
        """Look at cams in the middle of the least box, and for where they exceed limits the most."""
        design = boxes.take(slice(1)).middle_designs(self.problem.design)
        problem, told = self.motion_at_middle(boxes)
        self.learn_worst_places(design, problem)
        if problem.setup.mechanism.has_no_assembly:
            return
        design = design.without_numbers(self.motion_fields)
        if closely:
            self.update_best(solve_small_cam(problem, self.bounds, self.best.design, self.until), told)
        rounding = allowed_gap(design) / 4.0
        low, high = (float(ends["size"][0]) for ends in (boxes.low, boxes.high))
        high = min(high + rounding, self.best.size)
        for _ in range(LADDER_ROUNDS):
            sizes = np.linspace(low, high, LADDER_SIZES)
            ladder = replace(design.take(np.zeros(LADDER_SIZES, dtype=int)), size=sizes)
            cam = first_feasible_design(problem, ladder, crossing_memory(problem), self.until)
            if cam is None:
                return
            self.update_best(SmallestCam(cam, 0.0), told)
            low, high = float(cam.size[0]) - (sizes[1] - sizes[0]), float(cam.size[0])

    def update_best(self, answer: SmallestCam, told: Any) -> None:
        """Make a cam the best if it is smaller."""
        if answer.size < self.best.size:
            self.best, self.best_motion = answer, told

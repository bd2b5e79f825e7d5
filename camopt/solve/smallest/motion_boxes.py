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

from camopt.core.numerics.sloped import Sloped
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.boxes import Bisection, Boxes
from camopt.solve.smallest.excesses import Excesses, chained_excesses, combined, cut_by, widest
from camopt.solve.smallest.first_look import scale_of
from camopt.solve.smallest.result import Smallest, first_feasible, gap_of, known_crossings
from camopt.solve.smallest.smallest import small
from camopt.solve.verdicts.sloped_designs import sloped_boxes

MOTION_BATCH = 256  # boxes examined together, at most, to stop in time
LOOKED_INTO = 12  # boxes whose middle is searched: the best motion so far may be in another valley
LADDERS, LADDER = 3, 16  # how often so many sizes of a box are looked at, closer and closer


class Said(NamedTuple):
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
    best: Smallest
    """The smallest cam so far."""
    told: Any
    """What its motion is told by."""
    lift: float | None = None
    """Of motions, where it is not that of the problem's."""
    looked: int = 0

    @property
    @abstractmethod
    def deciding(self) -> Collection[str]:
        """What decides the motion, by field of boxes."""

    @abstractmethod
    def ends(self) -> SizeBounds:
        """Between which sizes, and numbers that decide the motion, are worth a look."""

    @abstractmethod
    def motion(self, boxes: Boxes) -> tuple[Problem, Any]:
        """The problem of a motion in the middle of the first box, and what it is told by."""

    @abstractmethod
    def learn(self, design: Designs, problem: Problem) -> None:
        """Look for the places where a design in the middle of a box exceeds limits the most."""

    @abstractmethod
    def said(self, boxes: Designs, inside: Designs, like: Sloped) -> Said:
        """What limits say of boxes as designs of ranges with slopes, as ``like`` is."""

    def run(self) -> Smallest:
        """The smallest cam, with a size that no cam undercuts."""
        ends = self.ends()
        floor, most = ends["size"]  # most often no cam may be as small
        if most > floor:
            scale = scale_of(self.problem, self.bounds, self.lift)
            floor = self.bisect(Boxes.one(ends, scale, self.problem.choices.variables), self.until)
        return replace(self.best, floor=floor)

    def possible(self, boxes: Boxes) -> Boxes:
        """What of some boxes can be a motion at all."""
        return boxes

    def split(self, boxes: Boxes) -> tuple[Boxes, Boxes]:
        """Those with the smallest cams, and the rest."""
        order = np.argsort(boxes.low["size"], kind="stable")
        return boxes.take(order[:MOTION_BATCH]), boxes.take(order[MOTION_BATCH:])

    def narrowed(self, boxes: Boxes) -> Boxes:
        """What of some boxes may be part of a motion and hold a smaller cam, which is looked for there."""
        boxes = self.possible(boxes)
        if not len(boxes):
            return boxes
        self.looked += 1
        self.look_into(boxes, closely=self.looked <= LOOKED_INTO)
        return self.cut(boxes)

    def cut(self, boxes: Boxes) -> Boxes:
        """Those of some boxes that may hold a smaller cam, without what limits cut off, and the side to cut."""
        if self.best.design is not None:
            boxes = self.left(boxes, boxes.low["size"] >= self.best.size - gap_of(self.best.design))
            boxes = boxes.below(self.best.size)
        if not len(boxes):
            return boxes
        inside = boxes.middles(self.problem.design)
        looked, like = sloped_boxes(boxes.designs(self.problem.design), inside, list(boxes.free), 1)
        middle = np.array([inside.values[name] for name in boxes.free])
        low, high = (np.array([ends[name] for name in boxes.free]) for ends in (boxes.low, boxes.high))
        with np.errstate(all="ignore"):
            reach = like.span
            limits, others, guides = self.said(looked, inside, like)
            if not limits:
                return boxes.narrowed({}, {}, np.argmax(reach.high, axis=0))
            over = chained_excesses([*limits, *others])
            low, high, empty = cut_by(combined(over, reach, boxes.free.index("size")), low, high, middle)
            side = widest(chained_excesses([*limits, *guides]), reach)
        named = (dict(zip(boxes.free, each, strict=True)) for each in (low, high))
        boxes = boxes.narrowed(next(named), next(named), side).take(~empty)
        return self.left(boxes, boxes.narrow)

    def look_into(self, boxes: Boxes, *, closely: bool) -> None:
        """Look at cams in the middle of the least box, and for where they exceed limits the most."""
        design = boxes.take(slice(1)).middles(self.problem.design)
        problem, told = self.motion(boxes)
        self.learn(design, problem)
        if problem.setup.mechanism.is_apart:
            return
        design = design.without(self.deciding)
        if closely:
            self.offer(small(problem, self.bounds, self.best.design, self.until), told)
        rounding = gap_of(design) / 4.0
        low, high = (float(ends["size"][0]) for ends in (boxes.low, boxes.high))
        high = min(high + rounding, self.best.size)
        for _ in range(LADDERS):
            sizes = np.linspace(low, high, LADDER)
            ladder = replace(design.take(np.zeros(LADDER, dtype=int)), size=sizes)
            cam = first_feasible(problem, ladder, known_crossings(problem), self.until)
            if cam is None:
                return
            self.offer(Smallest(cam, 0.0), told)
            low, high = float(cam.size[0]) - (sizes[1] - sizes[0]), float(cam.size[0])

    def offer(self, answer: Smallest, told: Any) -> None:
        """Make a cam the best if it is smaller."""
        if answer.size < self.best.size:
            self.best, self.told = answer, told

"""The Pareto front of a grid, decided by boxes of designs: the rows of the full sweep without its evaluations.

A box of designs is dropped if all of them break a limit, or if a design known to be feasible dominates the least
that any of them costs. What is left is halved, and small boxes are evaluated. One design of each box is evaluated
before it is halved, so that what dominates is known early.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11; for several objectives
J. Fernández, B. Tóth, Obtaining an outer approximation of the efficient set of nonlinear biobjective problems,
J. Global Optim. 38 (2007).
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from camopt.core.engines.progress import Progress, report_progress
from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.dominance import Both, Dominators, Known
from camopt.core.quantities import in_order
from camopt.model.effects import Case
from camopt.scene.problem.rows import Rows, scattered
from camopt.scene.problem.space import Space
from camopt.solve.front.blocks import Seen
from camopt.solve.front.box_bounds import BoxBounds, is_hopeless
from camopt.solve.front.grid_boxes import Grid, GridBoxes, chained_boxes
from camopt.solve.front.pareto import Archive, non_dominated, row_costs
from camopt.solve.verdicts.judging import Effort
from camopt.solve.verdicts.running import run_effects
from camopt.solve.verdicts.screening import screened

FEW_DESIGNS = 64  # designs of a box that are evaluated: to bound it costs as much
HALVED_FIRST = 1 << 13  # halved before those that they leave, which bounds the memory
TOGETHER = 2048  # boxes bounded together, and few enough for the cache
FIRST_BOXES, LARGE_RATIO = 2048, 8  # boxes to begin with, if they are large: so many times as large as small ones
EVALUATED_AT_ONCE = 8192  # designs evaluated together
PENDING = 1 << 18  # designs of small boxes evaluated before their dominance is asked again
DESIGN_NUMBER = "number"  # of a design in the space, as a column of rows

SearchItem = TypeVar("SearchItem")
SearchResult = TypeVar("SearchResult")


@dataclass
class FrontSearch:
    """A search in progress."""

    space: Space
    names: tuple[str, ...]
    """The columns of rows."""
    workers: int
    progress: Progress | None
    """Called with boxes done, and about how many there will be."""
    waiting: list[GridBoxes] = field(default_factory=list)
    """Boxes to bound, those that were made last at the end."""
    small: list[GridBoxes] = field(default_factory=list)
    """Boxes to evaluate."""
    boxes: int = 0
    """Bounded."""
    finished: int = 0
    """Small boxes."""
    evaluated: int = 0
    """Designs, some of them in boxes that were dropped later."""
    decided: int = 0
    """Designs in boxes that were dropped."""
    effort: Effort = field(default_factory=Effort)
    reached: float = 0.0

    def __post_init__(self) -> None:
        self.grid, self.objectives = Grid(self.space), self.space.problem.objectives
        self.archive, self.known = Archive(self.objectives, EVALUATED_AT_ONCE), Known(len(self.objectives))

    def run(self) -> Seen:
        """The front, its rows in the order of the space."""
        self.pool = ThreadPoolExecutor(self.workers)
        try:
            self.start()
            while self.waiting:
                self.step()
        finally:
            self.pool.shutdown(cancel_futures=True)
        rows = self.archive.given_up()
        rows = self.with_sizes(rows.drawn(np.unique(rows.column(DESIGN_NUMBER), return_index=True)[1]))
        return Seen(rows, rows, self.effort, self.reached, self.evaluated, boxes=self.boxes, decided=self.decided)

    def with_sizes(self, rows: Rows) -> Rows:
        """Rows in the order of the space with the sizes of their designs, in place of their numbers."""
        motion, number = np.divmod(rows.column(DESIGN_NUMBER), self.space.designs_each)
        motions, firsts = np.unique(motion if rows.count else [0], return_index=True)
        sizes = scattered(self._sizes(motions, number, [*firsts, rows.count]), rows.count)
        columns = rows.columns | sizes.columns
        return Rows({name: columns[name] for name in in_order(columns.keys() & set(self.names))}, rows.count)

    def _sizes(self, motions: IntArray, number: IntArray, ends: list[int]) -> Iterator[tuple[slice, Rows]]:
        """The sizes of designs of some motions, with the places of those of each."""
        names = self.space.problem.sizes.intersection(self.names)
        for (first, last), problem in zip(pairwise(ends), (self.space.problems[i] for i in motions), strict=True):
            case = Case(problem.setup, problem.programme, self.space.designs(number[first:last]))
            yield slice(first, last), run_effects(case, names)

    def start(self) -> None:
        """The motions that may meet the limits, halved until there are some boxes: to bound few takes as long."""
        hopeless = np.array([is_hopeless(problem) for problem in self.space.problems])
        boxes = self.kept(self.grid.whole(len(self.objectives)), ~hopeless)
        while 0 < len(boxes) < FIRST_BOXES and np.all(boxes.counts > LARGE_RATIO * FEW_DESIGNS):
            boxes = boxes.halved(np.argmax(boxes.high - boxes.low, axis=1))
        self.evaluate(boxes.motion[:0], boxes.motion[:0])  # a front without rows has columns
        self.waiting.append(boxes)

    def step(self) -> None:
        """Halve the boxes that were made last, some at a time, and evaluate small ones."""
        boxes = self.waiting.pop()
        if len(boxes) > HALVED_FIRST:
            self.waiting.append(boxes.take(slice(HALVED_FIRST, None)))
            boxes = boxes.take(slice(HALVED_FIRST))
        few = boxes.counts <= FEW_DESIGNS
        self.small.append(boxes.take(few))
        if not few.all():
            self.waiting.append(self.halved(boxes.take(~few)))
        if not self.waiting or sum(int(part.counts.sum()) for part in self.small) > PENDING:
            self.finish(chained_boxes(self.small))
        done = self.boxes + self.finished
        halvings = (np.log2(np.maximum(part.counts / FEW_DESIGNS, 2.0)).sum() for part in self.waiting)
        report_progress(self.progress, done, done + int(sum(halvings)) + sum(map(len, self.small)))

    def kept(self, boxes: GridBoxes, left: Any) -> GridBoxes:
        """The boxes that are not dropped."""
        self.decided += int(boxes.counts[~left].sum())
        return boxes.take(left)

    def halved(self, boxes: GridBoxes) -> GridBoxes:
        """The halves of those of some boxes that may hold a part of the front."""
        self.evaluate(boxes.motion, self.grid.number(boxes.middle))
        dominators = self.dominators()
        boxes = self.kept(boxes, ~dominators.dominate(boxes.costs))
        self.boxes += len(boxes)
        order = np.argsort(boxes.motion, kind="stable")
        parts = [boxes.take(index) for index in _cut(order, boxes.motion[order], TOGETHER)]
        bounded = list(self.each(partial(self.bounded, dominators), parts))
        if not bounded:
            return boxes
        seen, left, axis = (list(each) for each in zip(*bounded, strict=True))
        open_ = np.concatenate(left)
        return self.kept(chained_boxes(seen), open_).halved(np.concatenate(axis)[open_])

    def bounded(self, dominators: Dominators | Both, boxes: GridBoxes) -> tuple[GridBoxes, Any, IntArray]:
        """Boxes of one motion with what they cost at least, which are open, and the axis to cut."""
        bounds = BoxBounds(self.space.problems[boxes.motion[0]], self.grid.free)
        designs = self.grid.designs(boxes)
        open_, change = ~bounds.impossible(designs), np.zeros((len(self.grid.free), len(boxes)))
        costs = np.full((len(boxes), len(self.objectives)), -np.inf)
        looked = bounds.look(designs.take(open_))
        costs[open_], change[:, open_] = looked.costs, looked.change
        costs = np.nan_to_num(costs)
        index = np.flatnonzero(open_)
        left = ~dominators.dominate(costs[index])
        open_[index[~left]] = False
        index = index[left]
        broken, moved = bounds.broken(designs.take(index), looked.take(left))
        open_[index[broken]] = False
        change[:, index] = np.maximum(change[:, index], moved)
        return replace(boxes, costs=costs), open_, self.widest(boxes, change)

    def widest(self, boxes: GridBoxes, change: Any) -> IntArray:
        """The axis of each box to cut: of those with several values the one across which bounds change the most."""
        places = boxes.high - boxes.low
        free = [k for k, name in enumerate(self.grid.axes) if name in self.grid.free]
        share = np.zeros(places.shape)
        share[:, free] = np.where(places[:, free] > 0, change.T + 1e-9 * places[:, free], -1.0)
        share[:, [k for k in range(places.shape[1]) if k not in free]] = -1.0
        return np.asarray(np.argmax(share, axis=1))

    def finish(self, boxes: GridBoxes) -> None:
        """Evaluate all designs of small boxes that may hold a part of the front."""
        boxes = boxes.take(np.argsort(boxes.motion, kind="stable"))
        done = np.cumsum(boxes.counts)
        for first in range(0, int(done[-1]) if done.size else 0, PENDING):
            some = boxes.take((done > first) & (done <= first + PENDING))
            some = self.kept(some, ~self.dominators().dominate(some.costs))
            self.evaluate(np.repeat(some.motion, some.counts), self.grid.numbers(some))
        self.small, self.finished = [], self.finished + len(boxes)

    def evaluate(self, motion: IntArray, number: IntArray) -> None:
        """Evaluate designs by motion and number, and keep those that may be on the front."""
        order = np.argsort(motion, kind="stable")
        blocks = [(motion[part], number[part]) for part in _cut(order, motion[order], EVALUATED_AT_ONCE)]
        for found in self.each(self.block, blocks or [(np.zeros(1, dtype=np.int64), number)]):
            self.learn(found.front)
            self.effort, self.reached = self.effort.plus(found.effort), max(self.reached, found.reached)
            self.evaluated += found.evaluated

    def block(self, item: tuple[IntArray, IntArray]) -> Seen:
        """Evaluate some designs of one motion."""
        (motion, *_), number = item
        problem, designs = self.space.problems[motion], self.space.designs(number)
        exists = problem.setup.mechanism.exists(designs, problem.programme)
        found = screened(problem, designs.take(exists), frozenset(self.names))
        told = set(found.rows.columns) - (
            problem.sizes - self.objectives.keys()
        )  # the number tells the other sizes
        columns = {name: found.rows.columns[name] for name in told}
        columns[DESIGN_NUMBER] = number[exists][found.which] + motion * self.space.designs_each
        rows = non_dominated(Rows(columns, found.rows.count), self.objectives)
        reached = float(np.max(found.rows.columns["relative_half_width"], initial=0.0))
        return Seen(rows, rows, found.effort, reached, number.size)

    def learn(self, rows: Rows) -> None:
        """Take rows that may be on the front."""
        self.archive.add(rows.take(~self.known.add(self.costs_of(rows))))

    def dominators(self) -> Dominators | Both:
        """What dominates boxes: the front of what has been evaluated, and perhaps some rows more."""
        return self.known.dominators(lambda: self.costs_of(self.archive.front()))

    def costs_of(self, rows: Rows) -> FloatArray:
        """The costs of rows, infinite ones as the largest number."""
        return np.nan_to_num(row_costs(rows, self.objectives))

    def each(self, work: Callable[[SearchItem], SearchResult], items: list[SearchItem]) -> Iterable[SearchResult]:
        """Results in order; of a single item in this thread, so that an interrupt ends it while it compiles."""
        return self.pool.map(work, items) if len(items) > 1 else map(work, items)


def _cut(order: IntArray, motion: IntArray, size: int) -> Iterator[IntArray]:
    """An order cut where the motion changes, and into parts of a size at most."""
    for part in np.split(order, np.flatnonzero(np.diff(motion)) + 1):
        yield from (part[first : first + size] for first in range(0, part.size, size))

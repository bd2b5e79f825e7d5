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
from camopt.core.numerics.dominance import Dominators, PointTree, TreePair
from camopt.core.quantities import in_column_order
from camopt.model.effects import EvaluationBlock
from camopt.scene.problem.rows import DesignRows, scatter_rows
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.blocks import SpaceResult
from camopt.solve.front.box_bounds import BoxBounds, is_motion_infeasible
from camopt.solve.front.grid_boxes import Grid, GridBoxes, chained_boxes
from camopt.solve.front.pareto import FrontArchive, non_dominated, row_costs
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.feasible_filter import filter_designs
from camopt.solve.verdicts.limit_verdicts import Effort

FEW_DESIGNS = 64  # designs of a box that are evaluated: to bound it costs as much
HALVED_AT_ONCE = 1 << 13  # halved before those that they leave, which bounds the memory
BOUNDED_AT_ONCE = 2048  # boxes bounded together, and few enough for the cache
FIRST_BOXES, LARGE_RATIO = 2048, 8  # boxes to begin with, if they are large: so many times as large as small ones
EVALUATED_AT_ONCE = 8192  # designs evaluated together
PENDING_DESIGNS = 1 << 18  # designs of small boxes evaluated before their dominance is asked again
DESIGN_NUMBER = "number"  # of a design in the space, as a column of rows

SearchItem = TypeVar("SearchItem")
SearchResult = TypeVar("SearchResult")


@dataclass
class FrontSearch:
    """A search in progress."""

    space: DesignSpace
    names: tuple[str, ...]
    """The columns of rows."""
    workers: int
    progress: Progress | None
    """Called with boxes done, and about how many there will be."""
    open_boxes: list[GridBoxes] = field(default_factory=list)
    """Boxes to bound, those that were made last at the end."""
    small_boxes: list[GridBoxes] = field(default_factory=list)
    """Boxes to evaluate."""
    bounded_count: int = 0
    """Bounded."""
    finished_count: int = 0
    """Small boxes."""
    evaluated: int = 0
    """Designs, some of them in boxes that were dropped later."""
    decided: int = 0
    """Designs in boxes that were dropped."""
    effort: Effort = field(default_factory=Effort)
    reached: float = 0.0

    def __post_init__(self) -> None:
        self.grid, self.objectives = Grid(self.space), self.space.problem.objectives
        self.archive, self.known = FrontArchive(self.objectives, EVALUATED_AT_ONCE), PointTree(len(self.objectives))

    def run(self) -> SpaceResult:
        """The front, its rows in the order of the space."""
        self.pool = ThreadPoolExecutor(self.workers)
        try:
            self.start()
            while self.open_boxes:
                self.step()
        finally:
            self.pool.shutdown(cancel_futures=True)
        rows = self.archive.take_front()
        rows = self.with_sizes(rows.take_and_release(np.unique(rows.column(DESIGN_NUMBER), return_index=True)[1]))
        return SpaceResult(
            rows, rows, self.effort, self.reached, self.evaluated, boxes=self.bounded_count, decided=self.decided
        )

    def with_sizes(self, rows: DesignRows) -> DesignRows:
        """Rows in the order of the space with the sizes of their designs, in place of their numbers."""
        motion, number = np.divmod(rows.column(DESIGN_NUMBER), self.space.designs_per_problem)
        motions, firsts = np.unique(motion if rows.count else [0], return_index=True)
        sizes = scatter_rows(self._sizes_by_motion(motions, number, [*firsts, rows.count]), rows.count)
        columns = rows.columns | sizes.columns
        return DesignRows(
            {name: columns[name] for name in in_column_order(columns.keys() & set(self.names))}, rows.count
        )

    def _sizes_by_motion(
        self, motions: IntArray, number: IntArray, ends: list[int]
    ) -> Iterator[tuple[slice, DesignRows]]:
        """The sizes of designs of some motions, with the places of those of each."""
        names = self.space.problem.size_names.intersection(self.names)
        for (first, last), problem in zip(pairwise(ends), (self.space.problems[i] for i in motions), strict=True):
            case = EvaluationBlock(problem.setup, problem.programme, self.space.designs(number[first:last]))
            yield slice(first, last), run_effects(case, names)

    def start(self) -> None:
        """The motions that may meet the limits, halved until there are some boxes: to bound few takes as long."""
        hopeless = np.array([is_motion_infeasible(problem) for problem in self.space.problems])
        boxes = self.keep_boxes(self.grid.whole_boxes(len(self.objectives)), ~hopeless)
        while 0 < len(boxes) < FIRST_BOXES and np.all(boxes.design_counts > LARGE_RATIO * FEW_DESIGNS):
            boxes = boxes.halve_boxes(np.argmax(boxes.high - boxes.low, axis=1))
        self.evaluate_numbers(boxes.motion[:0], boxes.motion[:0])  # a front without rows has columns
        self.open_boxes.append(boxes)

    def step(self) -> None:
        """Halve the boxes that were made last, some at a time, and evaluate small ones."""
        boxes = self.open_boxes.pop()
        if len(boxes) > HALVED_AT_ONCE:
            self.open_boxes.append(boxes.take(slice(HALVED_AT_ONCE, None)))
            boxes = boxes.take(slice(HALVED_AT_ONCE))
        few = boxes.design_counts <= FEW_DESIGNS
        self.small_boxes.append(boxes.take(few))
        if not few.all():
            self.open_boxes.append(self.halve_boxes(boxes.take(~few)))
        if not self.open_boxes or sum(int(part.design_counts.sum()) for part in self.small_boxes) > PENDING_DESIGNS:
            self.evaluate_small_boxes(chained_boxes(self.small_boxes))
        done = self.bounded_count + self.finished_count
        halvings = (np.log2(np.maximum(part.design_counts / FEW_DESIGNS, 2.0)).sum() for part in self.open_boxes)
        report_progress(self.progress, done, done + int(sum(halvings)) + sum(map(len, self.small_boxes)))

    def keep_boxes(self, boxes: GridBoxes, left: Any) -> GridBoxes:
        """The boxes that are not dropped."""
        self.decided += int(boxes.design_counts[~left].sum())
        return boxes.take(left)

    def halve_boxes(self, boxes: GridBoxes) -> GridBoxes:
        """The halves of those of some boxes that may hold a part of the front."""
        self.evaluate_numbers(boxes.motion, self.grid.design_numbers(boxes.middle_places))
        dominators = self.dominators()
        boxes = self.keep_boxes(boxes, ~dominators.dominate(boxes.costs))
        self.bounded_count += len(boxes)
        order = np.argsort(boxes.motion, kind="stable")
        parts = [
            boxes.take(index) for index in _split_by_motion_and_size(order, boxes.motion[order], BOUNDED_AT_ONCE)
        ]
        bounded = list(self.map_in_order(partial(self.bound_boxes, dominators), parts))
        if not bounded:
            return boxes
        seen, left, axis = (list(each) for each in zip(*bounded, strict=True))
        open_ = np.concatenate(left)
        return self.keep_boxes(chained_boxes(seen), open_).halve_boxes(np.concatenate(axis)[open_])

    def bound_boxes(self, dominators: Dominators | TreePair, boxes: GridBoxes) -> tuple[GridBoxes, Any, IntArray]:
        """Boxes of one motion with what they cost at least, which are open, and the axis to cut."""
        bounds = BoxBounds(self.space.problems[boxes.motion[0]], self.grid.free)
        designs = self.grid.box_designs(boxes)
        open_, change = ~bounds.impossible_boxes(designs), np.zeros((len(self.grid.free), len(boxes)))
        costs = np.full((len(boxes), len(self.objectives)), -np.inf)
        looked = bounds.bound_costs(designs.take(open_))
        costs[open_], change[:, open_] = looked.costs, looked.change
        costs = np.nan_to_num(costs)
        index = np.flatnonzero(open_)
        left = ~dominators.dominate(costs[index])
        open_[index[~left]] = False
        index = index[left]
        broken, moved = bounds.broken_boxes(designs.take(index), looked.take(left))
        open_[index[broken]] = False
        change[:, index] = np.maximum(change[:, index], moved)
        return replace(boxes, costs=costs), open_, self.widest_axis(boxes, change)

    def widest_axis(self, boxes: GridBoxes, change: Any) -> IntArray:
        """The axis of each box to cut: of those with several values the one across which bounds change the most."""
        places = boxes.high - boxes.low
        free = [k for k, name in enumerate(self.grid.axes) if name in self.grid.free]
        share = np.zeros(places.shape)
        share[:, free] = np.where(places[:, free] > 0, change.T + 1e-9 * places[:, free], -1.0)
        share[:, [k for k in range(places.shape[1]) if k not in free]] = -1.0
        return np.asarray(np.argmax(share, axis=1))

    def evaluate_small_boxes(self, boxes: GridBoxes) -> None:
        """Evaluate all designs of small boxes that may hold a part of the front."""
        boxes = boxes.take(np.argsort(boxes.motion, kind="stable"))
        done = np.cumsum(boxes.design_counts)
        for first in range(0, int(done[-1]) if done.size else 0, PENDING_DESIGNS):
            some = boxes.take((done > first) & (done <= first + PENDING_DESIGNS))
            some = self.keep_boxes(some, ~self.dominators().dominate(some.costs))
            self.evaluate_numbers(np.repeat(some.motion, some.design_counts), self.grid.numbers_in_boxes(some))
        self.small_boxes, self.finished_count = [], self.finished_count + len(boxes)

    def evaluate_numbers(self, motion: IntArray, number: IntArray) -> None:
        """Evaluate designs by motion and number, and keep those that may be on the front."""
        order = np.argsort(motion, kind="stable")
        blocks = [
            (motion[part], number[part])
            for part in _split_by_motion_and_size(order, motion[order], EVALUATED_AT_ONCE)
        ]
        for found in self.map_in_order(self.evaluate_block, blocks or [(np.zeros(1, dtype=np.int64), number)]):
            self.add_front_rows(found.front)
            self.effort, self.reached = self.effort.plus(found.effort), max(self.reached, found.reached)
            self.evaluated += found.evaluated

    def evaluate_block(self, item: tuple[IntArray, IntArray]) -> SpaceResult:
        """Evaluate some designs of one motion."""
        (motion, *_), number = item
        problem, designs = self.space.problems[motion], self.space.designs(number)
        exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
        found = filter_designs(problem, designs.take(exists), frozenset(self.names))
        told = set(found.rows.columns) - (
            problem.size_names - self.objectives.keys()
        )  # the number tells the other sizes
        columns = {name: found.rows.columns[name] for name in told}
        columns[DESIGN_NUMBER] = number[exists][found.which] + motion * self.space.designs_per_problem
        rows = non_dominated(DesignRows(columns, found.rows.count), self.objectives)
        reached = float(np.max(found.rows.columns["relative_half_width"], initial=0.0))
        return SpaceResult(rows, rows, found.effort, reached, number.size)

    def add_front_rows(self, rows: DesignRows) -> None:
        """Take rows that may be on the front."""
        self.archive.add(rows.take(~self.known.add(self.costs_of(rows))))

    def dominators(self) -> Dominators | TreePair:
        """What dominates boxes: the front of what has been evaluated, and perhaps some rows more."""
        return self.known.dominators(lambda: self.costs_of(self.archive.front()))

    def costs_of(self, rows: DesignRows) -> FloatArray:
        """The costs of rows, infinite ones as the largest number."""
        return np.nan_to_num(row_costs(rows, self.objectives))

    def map_in_order(
        self, work: Callable[[SearchItem], SearchResult], items: list[SearchItem]
    ) -> Iterable[SearchResult]:
        """Results in order; of a single item in this thread, so that an interrupt ends it while it compiles."""
        return self.pool.map(work, items) if len(items) > 1 else map(work, items)


def _split_by_motion_and_size(order: IntArray, motion: IntArray, size: int) -> Iterator[IntArray]:
    """An order cut where the motion changes, and into parts of a size at most."""
    for part in np.split(order, np.flatnonzero(np.diff(motion)) + 1):
        yield from (part[first : first + size] for first in range(0, part.size, size))

"""The Pareto front of a grid by branch and bound: the rows of the full sweep without most of its evaluations.

A box of designs is dropped if all of them break a limit, or if a feasible design dominates the lower bounds of
their costs. Other boxes are halved, and small boxes are evaluated. One design of each box is evaluated before the
box is halved, so that dominating designs are known early.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11; for several objectives
J. Fernández, B. Tóth, Obtaining an outer approximation of the efficient set of nonlinear biobjective problems,
J. Global Optim. 38 (2007).
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from camopt.core.engines.progress import Progress, report_progress
from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.dominance import Dominators, PointTree, TreePair
from camopt.core.quantities import in_column_order
from camopt.model.effects import EvaluationBlock
from camopt.scene.problem.rows import DesignRows, scatter_rows
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.blocks import SpaceResult
from camopt.solve.front.box_bounds import BoxBounds, is_motion_infeasible
from camopt.solve.front.grid_boxes import Grid, GridBoxes, concatenate_grid_boxes
from camopt.solve.front.pareto import FrontArchive, non_dominated, row_costs
from camopt.solve.verdicts.effect_runs import run_effects
from camopt.solve.verdicts.feasible_filter import filter_designs
from camopt.solve.verdicts.limit_verdicts import Effort

FEW_DESIGNS = 64  # a box with at most so many designs is evaluated: bounding it costs as much
HALVED_AT_ONCE = 1 << 13  # boxes halved together; their halves come next, which bounds the memory
BOUNDED_AT_ONCE = 2048  # boxes bounded together: few enough for the cache
FIRST_BOXES, LARGE_RATIO = 2048, 8  # boxes to begin with, if they hold this many times the designs of small boxes
EVALUATED_AT_ONCE = 8192  # designs evaluated together
PENDING_DESIGNS = 1 << 18  # designs of small boxes evaluated before dominance is tested again
DESIGN_NUMBER = "number"  # the column with the number of a design in the space

SearchItem = TypeVar("SearchItem")
SearchResult = TypeVar("SearchResult")


@dataclass
class FrontSearch:
    """A branch-and-bound search for the front of a space."""

    space: DesignSpace
    names: tuple[str, ...]
    """The columns of rows."""
    workers: int
    progress: Progress | None
    """Called with (boxes done, expected number of boxes)."""
    open_boxes: list[GridBoxes] = field(default_factory=list)
    """Boxes to bound, the latest at the end."""
    small_boxes: list[GridBoxes] = field(default_factory=list)
    """Boxes to evaluate."""
    bounded_count: int = 0
    """Number of boxes bounded."""
    finished_count: int = 0
    """Number of small boxes finished."""
    evaluated: int = 0
    """Number of designs evaluated, some of them in boxes that were dropped later."""
    decided: int = 0
    """Number of designs in boxes that were dropped."""
    effort: Effort = field(default_factory=Effort)
    reached: float = 0.0

    def __post_init__(self) -> None:
        self.grid, self.objectives = Grid(self.space), self.space.problem.objectives
        self.archive, self.points = (
            FrontArchive(self.objectives, EVALUATED_AT_ONCE),
            PointTree(len(self.objectives)),
        )

    def find_front(self) -> SpaceResult:
        """The front, with its rows in the order of the space."""
        self.pool = ThreadPoolExecutor(self.workers)
        try:
            self.open_first_boxes()
            while self.open_boxes:
                self.halve_or_evaluate_boxes()
        finally:
            self.pool.shutdown(cancel_futures=True)
        rows = self.archive.take_front()
        rows = rows.take_and_release(np.unique(rows.column(DESIGN_NUMBER), return_index=True)[1])
        # the sizes of designs replace their numbers
        motion, number = np.divmod(rows.column(DESIGN_NUMBER), self.space.designs_per_problem)
        motions, firsts = np.unique(motion if rows.count else [0], return_index=True)
        sizes = scatter_rows(self._sizes_by_motion(motions, number, [*firsts, rows.count]), rows.count)
        columns = rows.columns | sizes.columns
        names = in_column_order(columns.keys() & set(self.names))
        rows = DesignRows({name: columns[name] for name in names}, rows.count)
        return SpaceResult(
            rows, rows, self.effort, self.reached, self.evaluated, boxes=self.bounded_count, decided=self.decided
        )

    def _sizes_by_motion(
        self, motions: IntArray, design_numbers: IntArray, row_ends: list[int]
    ) -> Iterator[tuple[slice, DesignRows]]:
        """The sizes of the designs of some motions, with the places of each motion's rows."""
        names = self.space.problem.size_quantity_names.intersection(self.names)
        for (first, last), problem in zip(
            pairwise(row_ends), (self.space.problems[i] for i in motions), strict=True
        ):
            block = EvaluationBlock(
                problem.setup, problem.programme, self.space.designs(design_numbers[first:last])
            )
            yield slice(first, last), run_effects(block, names)

    def open_first_boxes(self) -> None:
        """Open a box for each motion that may meet the limits, cut into many: bounding few takes as long."""
        infeasible = np.array([is_motion_infeasible(problem) for problem in self.space.problems])
        boxes = self.keep_undecided_and_count_decided(
            self.grid.whole_box_of_each_motion(len(self.objectives)), ~infeasible
        )
        while 0 < len(boxes) < FIRST_BOXES and np.all(boxes.design_counts > LARGE_RATIO * FEW_DESIGNS):
            boxes = boxes.halve_boxes(np.argmax(boxes.high - boxes.low, axis=1))
        self.evaluate_and_archive_designs(boxes.motion[:0], boxes.motion[:0])  # a front without rows has columns
        self.open_boxes.append(boxes)

    def halve_or_evaluate_boxes(self) -> None:
        """Halve the latest boxes, up to ``HALVED_AT_ONCE``, and evaluate small ones."""
        boxes = self.open_boxes.pop()
        if len(boxes) > HALVED_AT_ONCE:
            self.open_boxes.append(boxes.take(slice(HALVED_AT_ONCE, None)))
            boxes = boxes.take(slice(HALVED_AT_ONCE))
        small = boxes.design_counts <= FEW_DESIGNS
        self.small_boxes.append(boxes.take(small))
        if not small.all():
            self.open_boxes.append(self.bound_and_halve_boxes(boxes.take(~small)))
        if not self.open_boxes or sum(int(part.design_counts.sum()) for part in self.small_boxes) > PENDING_DESIGNS:
            self.evaluate_designs_of_small_boxes(concatenate_grid_boxes(self.small_boxes))
        done = self.bounded_count + self.finished_count
        halvings = (np.log2(np.maximum(part.design_counts / FEW_DESIGNS, 2.0)).sum() for part in self.open_boxes)
        report_progress(self.progress, done, done + int(sum(halvings)) + sum(map(len, self.small_boxes)))

    def keep_undecided_and_count_decided(self, boxes: GridBoxes, is_undecided: BoolArray) -> GridBoxes:
        """The kept boxes; the designs of the others count as decided."""
        self.decided += int(boxes.design_counts[~is_undecided].sum())
        return boxes.take(is_undecided)

    def bound_and_halve_boxes(self, boxes: GridBoxes) -> GridBoxes:
        """The halves of the boxes that may hold a part of the front."""
        self.evaluate_and_archive_designs(boxes.motion, self.grid.design_numbers_at_places(boxes.middle_places))
        dominators = self.dominators()
        boxes = self.keep_undecided_and_count_decided(boxes, ~dominators.mask_dominated_points(boxes.costs))
        self.bounded_count += len(boxes)
        order = np.argsort(boxes.motion, kind="stable")
        parts = [boxes.take(index) for index in _split_order_by_motion(order, boxes.motion[order], BOUNDED_AT_ONCE)]
        bounded = list(self.map_in_order(partial(self.bound_boxes_and_choose_axes, dominators), parts))
        if not bounded:
            return boxes
        bounded_boxes, are_open, axes = (list(column) for column in zip(*bounded, strict=True))
        open_ = np.concatenate(are_open)
        return self.keep_undecided_and_count_decided(concatenate_grid_boxes(bounded_boxes), open_).halve_boxes(
            np.concatenate(axes)[open_]
        )

    def bound_boxes_and_choose_axes(
        self, dominators: Dominators | TreePair, boxes: GridBoxes
    ) -> tuple[GridBoxes, BoolArray, IntArray]:
        """Boxes of one motion with lower bounds of their costs, which boxes stay open, and the axis to cut."""
        bounds = BoxBounds(self.space.problems[boxes.motion[0]], self.grid.varied_fields)
        designs = self.grid.boxes_as_interval_designs(boxes)
        open_, change = (
            ~bounds.boxes_impossible_by_sizes(designs),
            np.zeros((len(self.grid.varied_fields), len(boxes))),
        )
        costs = np.full((len(boxes), len(self.objectives)), -np.inf)
        box_costs = bounds.bound_costs(designs.take(open_))
        costs[open_], change[:, open_] = box_costs.costs, box_costs.change
        costs = np.nan_to_num(costs)
        index = np.flatnonzero(open_)
        non_dominated = ~dominators.mask_dominated_points(costs[index])
        open_[index[~non_dominated]] = False
        index = index[non_dominated]
        broken, excess_change = bounds.infeasible_boxes_and_excess_changes(
            designs.take(index), box_costs.take(non_dominated)
        )
        open_[index[broken]] = False
        change[:, index] = np.maximum(change[:, index], excess_change)
        return replace(boxes, costs=costs), open_, self.choose_cut_axes(boxes, change)

    def choose_cut_axes(self, boxes: GridBoxes, bound_changes: FloatArray) -> IntArray:
        """The axis of each box to cut: the one with several values across which the bounds change the most."""
        places = boxes.high - boxes.low
        free = [k for k, name in enumerate(self.grid.axes) if name in self.grid.varied_fields]
        share = np.zeros(places.shape)
        share[:, free] = np.where(places[:, free] > 0, bound_changes.T + 1e-9 * places[:, free], -1.0)
        share[:, [k for k in range(places.shape[1]) if k not in free]] = -1.0
        return np.asarray(np.argmax(share, axis=1))

    def evaluate_designs_of_small_boxes(self, boxes: GridBoxes) -> None:
        """Evaluate all designs of small boxes that may hold a part of the front."""
        boxes = boxes.take(np.argsort(boxes.motion, kind="stable"))
        done = np.cumsum(boxes.design_counts)
        for first in range(0, int(done[-1]) if done.size else 0, PENDING_DESIGNS):
            block = boxes.take((done > first) & (done <= first + PENDING_DESIGNS))
            block = self.keep_undecided_and_count_decided(
                block, ~self.dominators().mask_dominated_points(block.costs)
            )
            self.evaluate_and_archive_designs(
                np.repeat(block.motion, block.design_counts), self.grid.design_numbers_in_boxes(block)
            )
        self.small_boxes, self.finished_count = [], self.finished_count + len(boxes)

    def evaluate_and_archive_designs(self, motions: IntArray, design_numbers: IntArray) -> None:
        """Evaluate designs, given by motion and number, and keep those that may be on the front."""
        order = np.argsort(motions, kind="stable")
        blocks = [
            (motions[part], design_numbers[part])
            for part in _split_order_by_motion(order, motions[order], EVALUATED_AT_ONCE)
        ]
        for result in self.map_in_order(
            self.evaluate_designs_of_motion, blocks or [(np.zeros(1, dtype=np.int64), design_numbers)]
        ):
            dominated = self.points.add_and_find_dominated(self.finite_row_costs(result.front))
            self.archive.add(result.front.take(~dominated))
            self.effort, self.reached = self.effort.plus(result.effort), max(self.reached, result.reached)
            self.evaluated += result.evaluated

    def evaluate_designs_of_motion(self, motions_and_numbers: tuple[IntArray, IntArray]) -> SpaceResult:
        """Evaluate some designs of one motion."""
        (motion, *_), number = motions_and_numbers
        problem, designs = self.space.problems[motion], self.space.designs(number)
        exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
        filtered = filter_designs(problem, designs.take(exists), frozenset(self.names))
        # sizes that are no objectives follow from the number
        names = set(filtered.rows.columns) - (problem.size_quantity_names - self.objectives.keys())
        columns = {name: filtered.rows.columns[name] for name in names}
        columns[DESIGN_NUMBER] = number[exists][filtered.which] + motion * self.space.designs_per_problem
        rows = non_dominated(DesignRows(columns, filtered.rows.count), self.objectives)
        reached = float(np.max(filtered.rows.columns["relative_half_width"], initial=0.0))
        return SpaceResult(rows, rows, filtered.effort, reached, number.size)

    def dominators(self) -> Dominators | TreePair:
        """The points that dominate boxes: the front of the designs evaluated so far, and perhaps others."""
        return self.points.dominators(lambda: self.finite_row_costs(self.archive.front()))

    def finite_row_costs(self, rows: DesignRows) -> FloatArray:
        """The costs of rows, with the largest number for infinite ones."""
        return np.nan_to_num(row_costs(rows, self.objectives))

    def map_in_order(
        self, work: Callable[[SearchItem], SearchResult], items: list[SearchItem]
    ) -> Iterable[SearchResult]:
        """The results in order; a single item runs in this thread, so that an interrupt ends its compilation."""
        return self.pool.map(work, items) if len(items) > 1 else map(work, items)


def _split_order_by_motion(order: IntArray, motions: IntArray, part_size: int) -> Iterator[IntArray]:
    """An order cut where the motion changes, and into parts of at most ``part_size``."""
    for part in np.split(order, np.flatnonzero(np.diff(motions)) + 1):
        yield from (part[first : first + part_size] for first in range(0, part.size, part_size))

"""A space of designs cut into blocks; any thread, process or machine can evaluate a block by itself.

The results are gathered in order.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from threading import Lock
from typing import NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from camopt.core.engines.progress import Progress, report_progress
from camopt.core.numerics import BoolArray
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.rows import DesignRows, Objectives, concatenate_rows
from camopt.scene.problem.space import DesignSpace
from camopt.solve.front.curve_numbers import CurveNumbers, OwnCurves
from camopt.solve.front.curve_verdicts import CurveVerdicts
from camopt.solve.front.pareto import FrontArchive, best_row_of_each_law, non_dominated
from camopt.solve.verdicts.feasible_filter import feasible_designs, filter_designs
from camopt.solve.verdicts.limit_verdicts import Effort, evaluate_with_verdicts_and_effort

BLOCK_SIZE = 65536  # designs in a block: Python's share of the time is small, and memory stays bounded
SHARING_BLOCK_SIZE = 2**18  # the same for designs that share pitch curves: most of them take nanoseconds
BEST_BATCHES = 64  # batches whose best designs are compared together
NO_ROWS = DesignRows({}, 0)  # the rows of no blocks


@dataclass(frozen=True)
class BlockBatch:
    """The results of consecutive blocks."""

    first: int
    """The number of the first block."""
    last: int
    """The number after the last block."""
    designs: int
    existing: int
    """Number of designs that can be assembled."""
    feasible: int
    effort: Effort
    reached: float
    """The largest relative half-width of an enclosure of any row that is kept."""
    kept: DesignRows
    """Rows for the table of designs; none if there is no such table."""
    front: DesignRows
    """Rows that may be on the Pareto front."""
    best: DesignRows
    """The best feasible row of each law."""


def merge_batches(batches: Sequence[BlockBatch], objectives: Objectives) -> BlockBatch:
    """One batch from consecutive batches."""
    if len(batches) == 1:
        return batches[0]
    return BlockBatch(
        first=batches[0].first,
        last=batches[-1].last,
        designs=sum(batch.designs for batch in batches),
        existing=sum(batch.existing for batch in batches),
        feasible=sum(batch.feasible for batch in batches),
        effort=reduce(Effort.plus, (batch.effort for batch in batches)),
        reached=max(batch.reached for batch in batches),
        kept=concatenate_rows(batch.kept for batch in batches),
        front=non_dominated(concatenate_rows(batch.front for batch in batches), objectives),
        best=best_row_of_each_law(concatenate_rows(batch.best for batch in batches), objectives),
    )


class BlockResult(NamedTuple):
    """The results of the designs of one block."""

    existing: int
    feasible: int
    rows: DesignRows
    """The rows to keep; without a table of designs, some dominated rows may be missing."""
    effort: Effort
    compared: BoolArray
    """Which rows may be on the front: all non-dominated ones, and perhaps others."""


class SpaceBlocks:
    """The blocks of a space, numbered in the order of the space; each has designs of one problem."""

    def __init__(
        self,
        space: DesignSpace,
        column_names: tuple[str, ...],
        curve_numbers: CurveNumbers | None,
        include_infeasible: bool = False,
        keep_rows: bool = True,
        block_size: int = BLOCK_SIZE,
        decide_by_own_curves: bool = False,
    ) -> None:
        """Cut a space into blocks.

        Parameters
        ----------
        space : Space
            The designs.
        column_names : tuple of str
            The columns of rows.
        curve_numbers : CurveNumbers or None
            The pitch curves that designs share; None evaluates each design by itself.
        include_infeasible : bool, default False
            Whether rows have all designs that can be assembled, not only feasible ones.
        keep_rows : bool, default True
            Whether batches keep rows for the table of designs.
        block_size : int, default 65536
            The most designs of a block.
        decide_by_own_curves : bool, default False
            Whether each design's own pitch curve decides all its limits, if designs share none.
        """
        self.space, self.size = space, block_size
        self._names, self._every, self._kept = frozenset(column_names), include_infeasible, keep_rows
        self._parts = list(space.design_ranges_by_problem())
        counts = [-(-(stop - start) // block_size) for _, start, stop in self._parts]
        if curve_numbers and len(counts) % 2 and self._parts[0][2] - self._parts[0][1] > BLOCK_SIZE:
            counts[0] = max(counts[0], 2)  # two threads begin with the first motion, and share the rest evenly
        self._ends = np.cumsum(counts).tolist()
        self._numbers, self._own = curve_numbers, decide_by_own_curves
        self._curves: WeakValueDictionary[int, CurveVerdicts] = WeakValueDictionary()
        self._latest: CurveVerdicts | None = None  # keeps those of the current motion alive
        self._one_at_a_time = Lock()

    def __len__(self) -> int:
        return int(self._ends[-1]) if self._ends else 0

    @property
    def searched_curve_count(self) -> int:
        """Number of pitch curves that are searched: one for each design, unless designs share them."""
        return len(self._numbers) * len(self.space.problems) if self._numbers else len(self.space)

    def _part_and_design_range(self, block_number: int) -> tuple[int, int, int]:
        """The part of the space that a block belongs to, its first design, and the one after its last."""
        part = bisect_right(self._ends, block_number)
        _, start, stop = self._parts[part]
        before = self._ends[part - 1] if part else 0
        size = -(-(stop - start) // (self._ends[part] - before))  # all about the same
        first = start + size * (block_number - before)
        return part, first, min(first + size, stop)

    def design_count_before_block(self, block_number: int) -> int:
        """The number of designs in all blocks before one."""
        if block_number >= len(self):
            return len(self.space)
        part, first, _ = self._part_and_design_range(block_number)
        return sum(stop - start for _, start, stop in self._parts[:part]) + first - self._parts[part][1]

    def evaluate_block(self, block_number: int) -> BlockBatch:
        part, first, last = self._part_and_design_range(block_number)
        problem, *_ = self._parts[part]
        if self._numbers:
            block = self._evaluate_by_pitch_curves(self._cached_curve_verdicts(part, problem), first, last)
        elif self._own:
            own = CurveVerdicts(self.space, problem, OwnCurves(self.space, first, last), self._names)
            block = self._evaluate_by_pitch_curves(own, first, last)
        else:
            block = self._evaluate_without_curve_verdicts(problem, first, last)
        objectives, rows = problem.objectives, block.rows.select_columns(self._names)
        front = non_dominated(rows.take(block.compared), objectives)
        kept = rows if self._kept else rows.take(np.arange(0))
        return BlockBatch(
            first=block_number,
            last=block_number + 1,
            designs=last - first,
            existing=block.existing,
            feasible=block.feasible,
            effort=block.effort,
            reached=float(np.max(kept.columns["relative_half_width"], initial=0.0)),
            kept=kept,
            front=front,
            best=best_row_of_each_law(front, objectives),
        )

    def _evaluate_without_curve_verdicts(self, problem: Problem, first: int, last: int) -> BlockResult:
        designs = self.space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme))
        if self._every:
            rows, effort = evaluate_with_verdicts_and_effort(problem, designs, self._names)
            held = rows.column("feasible").astype(bool)
            return BlockResult(len(designs), int(np.count_nonzero(held)), rows, effort, held)
        rows, which, effort = filter_designs(problem, designs, self._names)
        if problem.robust_errors:
            block_problem = replace(problem)  # its cache of trains with errors lasts as long as this block
            rows = rows.take(feasible_designs(block_problem, designs.take(which)))
        return BlockResult(len(designs), rows.count, rows, effort, np.ones(rows.count, dtype=bool))

    def _evaluate_by_pitch_curves(self, curve_verdicts: CurveVerdicts, first: int, last: int) -> BlockResult:
        """The results of designs first … last − 1 from the verdicts of their pitch curves."""
        verdicts = curve_verdicts.block_verdicts(first, last, keep_dominated=self._kept)
        held, open_ = verdicts.held_designs, verdicts.open_designs
        rows, count = curve_verdicts.evaluate_held_designs(held, self._names), verdicts.held_count
        compared, effort = verdicts.compared, Effort()
        if len(open_):
            open_rows, which, effort = curve_verdicts.filter_undecided_designs(open_, self._names)
            order = np.argsort(np.concatenate([held.designs, open_.designs[which]]))
            rows, count = concatenate_rows([rows, open_rows]).take(order), count + open_rows.count
            compared = np.concatenate([compared, np.ones(open_rows.count, dtype=bool)])[order]
        return BlockResult(verdicts.existing, count, rows, effort, compared)

    def _cached_curve_verdicts(self, part: int, problem: Problem) -> CurveVerdicts:
        """The pitch curves of a motion, kept while a thread uses them, or until those of another motion exist."""
        assert self._numbers is not None
        with self._one_at_a_time:
            curves = self._curves.get(part)
            if curves is None:
                curves = CurveVerdicts(self.space, problem, self._numbers, self._names)
                self._curves[part] = self._latest = curves
            return curves


class SpaceResult(NamedTuple):
    """The results of a space: counts, the front, and the best row of each law, perhaps among others."""

    front: DesignRows
    best: DesignRows
    effort: Effort
    reached: float
    """The largest relative half-width of an enclosure of any row that is kept or on the front."""
    evaluated: int
    """Number of designs evaluated, including those that cannot be assembled."""
    existing: int | None = None
    """Number of designs that can be assembled; None if not counted."""
    feasible: int | None = None
    """Number of feasible designs; None if not counted."""
    boxes: int = 0
    """Number of boxes of designs that were bounded."""
    decided: int = 0
    """Number of designs in boxes that were dropped."""

    def without_rows(self) -> "SpaceResult":
        """The counts alone: the rows of large fronts take much memory."""
        return self._replace(front=NO_ROWS, best=NO_ROWS)


def gather_batches(
    space: DesignSpace,
    batches: Iterable[BlockBatch],
    block_size: int,
    write: Callable[[DesignRows], None],
    progress: Progress | None = None,
) -> SpaceResult:
    """The results of batches that cover a space in order; ``write`` is called with the rows that they keep.

    ``progress`` is called with (designs done, designs in all). Rows do not depend on how the space was cut.
    """
    designs, existing, feasible, effort, reached = 0, 0, 0, Effort(), 0.0
    objectives, total, best = space.problem.objectives, len(space), list[DesignRows]()
    archive = FrontArchive(objectives, block_size)
    for batch in batches:
        designs += batch.designs
        existing += batch.existing
        feasible += batch.feasible
        effort = effort.plus(batch.effort)
        reached = max(reached, batch.reached)
        archive.add(batch.front)
        best.append(batch.best)
        if len(best) > BEST_BATCHES:
            best = [best_row_of_each_law(concatenate_rows(best), objectives)]
        write(batch.kept)
        report_progress(progress, designs, total)
    if not best:
        return SpaceResult(NO_ROWS, NO_ROWS, effort, reached, designs, existing, feasible)
    front = archive.front()
    reached = float(np.max(front.columns.get("relative_half_width", 0.0), initial=reached))
    first = best_row_of_each_law(concatenate_rows(best), objectives)
    return SpaceResult(front, first, effort, reached, designs, existing, feasible)

"""A space of designs cut into blocks, each of which any thread, process or machine can evaluate on its own.

Their results are gathered in order.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
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
from camopt.solve.front.pareto import FrontArchive, best_of_laws, non_dominated
from camopt.solve.verdicts.feasible_filter import feasible_designs, filter_designs
from camopt.solve.verdicts.limit_verdicts import Effort, evaluate_with_effort

BLOCK_SIZE = 65536  # designs: Python's share is small, and memory stays bounded
SHARING_BLOCK_SIZE = 2**18  # of those that share pitch curves: most take nanoseconds
BEST_BATCHES = 64  # batches whose best designs are compared together
NO_ROWS = DesignRows({}, 0)  # where there are no blocks


@dataclass(frozen=True)
class BlockBatch:
    """The results of consecutive blocks."""

    first: int
    """The number of the first of the blocks."""
    last: int
    """The number after that of the last one."""
    designs: int
    existing: int
    """Designs that can be assembled."""
    feasible: int
    effort: Effort
    reached: float
    """The largest relative half-width of an enclosure of any row that is kept."""
    kept: DesignRows
    """Rows for the table of designs; none where there is no such table."""
    front: DesignRows
    """Rows that may be on the Pareto front."""
    best: DesignRows
    """Rows with the best feasible one of each law."""


def merge_batches(batches: Sequence[BlockBatch], objectives: Objectives) -> BlockBatch:
    """One batch from consecutive ones."""
    if len(batches) == 1:
        return batches[0]
    effort = Effort()
    for batch in batches:
        effort = effort.plus(batch.effort)
    return BlockBatch(
        first=batches[0].first,
        last=batches[-1].last,
        designs=sum(batch.designs for batch in batches),
        existing=sum(batch.existing for batch in batches),
        feasible=sum(batch.feasible for batch in batches),
        effort=effort,
        reached=max(batch.reached for batch in batches),
        kept=concatenate_rows(batch.kept for batch in batches),
        front=non_dominated(concatenate_rows(batch.front for batch in batches), objectives),
        best=best_of_laws(concatenate_rows(batch.best for batch in batches), objectives),
    )


class BlockResult(NamedTuple):
    """The results of the designs of one block."""

    existing: int
    feasible: int
    rows: DesignRows
    """Those that are wanted, or more; without a table of designs, but for some that others dominate."""
    effort: Effort
    compared: BoolArray
    """Of these rows some, with all that no other dominates."""


class SpaceBlocks:
    """The blocks of a space, by number in the order of the space; each has designs of one problem."""

    def __init__(
        self,
        space: DesignSpace,
        names: tuple[str, ...],
        numbers: CurveNumbers | None,
        every: bool = False,
        kept: bool = True,
        size: int = BLOCK_SIZE,
        own: bool = False,
    ) -> None:
        """Cut a space.

        Parameters
        ----------
        space : Space
            The designs.
        names : tuple of str
            The columns of rows.
        numbers : CurveNumbers or None
            Which pitch curves designs share; None looks at each design alone.
        every : bool, default False
            Whether rows are wanted of all designs that can be assembled, and not of feasible ones alone.
        kept : bool, default True
            Whether batches keep rows for the table of designs.
        size : int, default 65536
            The most designs of a block.
        own : bool, default False
            Whether the pitch curve of each design tells all of it, where they share none.
        """
        self.space, self.size = space, size
        self._names, self._every, self._kept = frozenset(names), every, kept
        self._parts = list(space.problem_ranges())
        counts = [-(-(stop - start) // size) for _, start, stop in self._parts]
        if numbers and len(counts) % 2 and self._parts[0][2] - self._parts[0][1] > BLOCK_SIZE:
            counts[0] = max(counts[0], 2)  # two threads, which begin together, share the first, and then as many
        self._ends = np.cumsum(counts).tolist()
        self._numbers, self._own = numbers, own
        self._curves: WeakValueDictionary[int, CurveVerdicts] = WeakValueDictionary()
        self._latest: CurveVerdicts | None = None  # keeps those of the motion that is worked on
        self._one_at_a_time = Lock()

    def __len__(self) -> int:
        return int(self._ends[-1]) if self._ends else 0

    @property
    def curve_count(self) -> int:
        """How many pitch curves are searched: one of each design, unless designs share them."""
        return len(self._numbers) * len(self.space.problems) if self._numbers else len(self.space)

    def _design_range(self, number: int) -> tuple[int, int, int]:
        """The part of the space that a block is of, and which designs of that problem it has: from, to."""
        part = bisect_right(self._ends, number)
        _, start, stop = self._parts[part]
        before = self._ends[part - 1] if part else 0
        size = -(-(stop - start) // (self._ends[part] - before))  # all about the same
        first = start + size * (number - before)
        return part, first, min(first + size, stop)

    def designs_before(self, number: int) -> int:
        """The number of designs in all blocks before one."""
        if number >= len(self):
            return len(self.space)
        part, first, _ = self._design_range(number)
        return sum(stop - start for _, start, stop in self._parts[:part]) + first - self._parts[part][1]

    def evaluate_block(self, number: int) -> BlockBatch:
        """Evaluate one block."""
        part, first, last = self._design_range(number)
        problem, *_ = self._parts[part]
        block = self._evaluate_designs(part, problem, first, last)
        objectives, rows = problem.objectives, block.rows.select_columns(self._names)
        front = non_dominated(rows.take(block.compared), objectives)
        kept = rows if self._kept else rows.take(np.arange(0))
        return BlockBatch(
            first=number,
            last=number + 1,
            designs=last - first,
            existing=block.existing,
            feasible=block.feasible,
            effort=block.effort,
            reached=float(np.max(kept.columns["relative_half_width"], initial=0.0)),
            kept=kept,
            front=front,
            best=best_of_laws(front, objectives),
        )

    def _evaluate_designs(self, part: int, problem: Problem, first: int, last: int) -> BlockResult:
        """Designs first … last − 1 by their pitch curves, if these tell all or are shared, or each by itself."""
        if self._numbers:
            return self._evaluate_by_curves(self._curve_verdicts(part, problem), first, last)
        if self._own:
            own = OwnCurves(self.space, first, last)
            return self._evaluate_by_curves(CurveVerdicts(self.space, problem, own, self._names), first, last)
        return self._evaluate_separately(problem, first, last)

    def _evaluate_separately(self, problem: Problem, first: int, last: int) -> BlockResult:
        """Designs first … last − 1, of which each is looked at alone."""
        designs = self.space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme))
        if self._every:
            rows, effort = evaluate_with_effort(problem, designs, self._names)
            held = rows.column("feasible").astype(bool)
            return BlockResult(len(designs), int(np.count_nonzero(held)), rows, effort, held)
        rows, which, effort = filter_designs(problem, designs, self._names)
        if problem.robust_errors:
            others = replace(problem)  # trains that are off are kept as long as this block
            rows = rows.take(feasible_designs(others, designs.take(which)))
        return BlockResult(len(designs), rows.count, rows, effort, np.ones(rows.count, dtype=bool))

    def _evaluate_by_curves(self, curves: CurveVerdicts, first: int, last: int) -> BlockResult:
        """The same by what their pitch curves say of them."""
        told = curves.verdicts(first, last, every=self._kept)
        rows, count, compared, effort = (
            curves.feasible_rows(told.held_designs, self._names),
            told.held_count,
            told.compared,
            Effort(),
        )
        if len(told.open_designs):
            left, which, effort = curves.filter_open(told.open_designs, self._names)
            order = np.argsort(np.concatenate([told.held_designs.designs, told.open_designs.designs[which]]))
            rows, count = concatenate_rows([rows, left]).take(order), count + left.count
            compared = np.concatenate([compared, np.ones(left.count, dtype=bool)])[order]
        return BlockResult(told.existing, count, rows, effort, compared)

    def _curve_verdicts(self, part: int, problem: Problem) -> CurveVerdicts:
        """The pitch curves of a motion, kept while a thread uses them or until those of another are made."""
        assert self._numbers is not None
        with self._one_at_a_time:
            curves = self._curves.get(part)
            if curves is None:
                curves = CurveVerdicts(self.space, problem, self._numbers, self._names)
                self._curves[part] = self._latest = curves
            return curves


class SpaceResult(NamedTuple):
    """The results of a space: counts, the front, and rows that include the best one of each law."""

    front: DesignRows
    best: DesignRows
    effort: Effort
    reached: float
    """The largest relative half-width of an enclosure of any row that is kept, or of the front."""
    evaluated: int
    """Designs, those that cannot be assembled among them."""
    existing: int | None = None
    """Designs that can be assembled; None if they were not counted."""
    feasible: int | None = None
    """Designs; None if they were not counted."""
    boxes: int = 0
    """Boxes of designs that were bounded."""
    decided: int = 0
    """Designs in boxes that were dropped."""

    def without_rows(self) -> "SpaceResult":
        """The counts alone: rows of large fronts take much memory."""
        return self._replace(front=DesignRows({}, 0), best=DesignRows({}, 0))


def gather_batches(
    space: DesignSpace,
    batches: Iterable[BlockBatch],
    block: int,
    write: Callable[[DesignRows], None],
    progress: Progress | None = None,
) -> SpaceResult:
    """The results of batches that cover a space in order. ``write`` takes the rows that they keep.

    ``progress`` is called with (designs done, designs in all). Rows are the same however the space was cut.
    """
    designs, existing, feasible, effort, reached = 0, 0, 0, Effort(), 0.0
    objectives, total, best = space.problem.objectives, len(space), list[DesignRows]()
    archive = FrontArchive(objectives, block)
    for batch in batches:
        designs += batch.designs
        existing += batch.existing
        feasible += batch.feasible
        effort = effort.plus(batch.effort)
        reached = max(reached, batch.reached)
        archive.add(batch.front)
        best.append(batch.best)
        if len(best) > BEST_BATCHES:
            best = [best_of_laws(concatenate_rows(best), objectives)]
        write(batch.kept)
        report_progress(progress, designs, total)
    if not best:
        return SpaceResult(NO_ROWS, NO_ROWS, effort, reached, designs, existing, feasible)
    front = archive.front()
    reached = float(np.max(front.columns.get("relative_half_width", 0.0), initial=reached))
    first = best_of_laws(concatenate_rows(best), objectives)
    return SpaceResult(front, first, effort, reached, designs, existing, feasible)

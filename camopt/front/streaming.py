"""All designs of a space through the kernels, block by block; results are gathered in order."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from camopt.engines.progress import Progress, report_progress
from camopt.front.blocks import Batch
from camopt.front.pareto import Archive, best_of_laws
from camopt.problem.rows import Rows, concatenate_rows
from camopt.problem.space import Space
from camopt.verdicts.judging import Effort

BEST_TOGETHER = 64  # batches whose best designs are compared together
NO_ROWS = Rows({}, 0)  # where there are no blocks


class Seen(NamedTuple):
    """The results of a space: counts, the front, and rows that include the best one of each law."""

    front: Rows
    best: Rows
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

    def without_rows(self) -> "Seen":
        """The counts alone: rows of large fronts take much memory."""
        return self._replace(front=Rows({}, 0), best=Rows({}, 0))


def gathered(
    space: Space,
    batches: Iterable[Batch],
    block: int,
    write: Callable[[Rows], None],
    progress: Progress | None = None,
) -> Seen:
    """The results of batches that cover a space in order. ``write`` takes the rows that they keep.

    ``progress`` is called with (designs done, designs in all). Rows are the same however the space was cut.
    """
    designs, existing, feasible, effort, reached = 0, 0, 0, Effort(), 0.0
    objectives, total, best = space.problem.objectives, len(space), list[Rows]()
    archive = Archive(objectives, block)
    for batch in batches:
        designs += batch.designs
        existing += batch.existing
        feasible += batch.feasible
        effort = effort.plus(batch.effort)
        reached = max(reached, batch.reached)
        archive.add(batch.front)
        best.append(batch.best)
        if len(best) > BEST_TOGETHER:
            best = [best_of_laws(concatenate_rows(best), objectives)]
        write(batch.kept)
        report_progress(progress, designs, total)
    if not best:
        return Seen(NO_ROWS, NO_ROWS, effort, reached, designs, existing, feasible)
    front = archive.front()
    reached = float(np.max(front.columns.get("relative_half_width", 0.0), initial=reached))
    first = best_of_laws(concatenate_rows(best), objectives)
    return Seen(front, first, effort, reached, designs, existing, feasible)

"""Robust fronts: the proof that every cam within the tolerances of each design on a front meets the limits.

A sweep with ``search.robust`` evaluates the corners of the tolerances. The proof covers the whole box of tolerances
of each design on the front, and of the best design of each law. If it finds a cam between the corners that breaks a
limit, this cam joins the corners, and the sweep runs again: designs that the broken one dominated may now be on the
front (exchange method, as in ``smallest.exchange``). Designs that are broken after the last run are dropped.
"""

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from camopt.core.engines.progress import Progress
from camopt.core.engines.threads import Threads
from camopt.core.numerics.budget import Budget
from camopt.scene.problem.problem import with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.sample import sweep_space
from camopt.scene.problem.settings import with_toleranced_numbers_per_design
from camopt.scene.problem.space import DesignSpace
from camopt.scene.problem.tolerance_zones import NumberErrors
from camopt.solve.front.blocks import SpaceResult, gather_batches
from camopt.solve.front.plan import SweepPlan
from camopt.solve.front.reported_rows import ReportedRows, report_rows
from camopt.solve.smallest.exchange import certify_over_tolerances
from camopt.solve.verdicts.verdict_words import BROKEN

CERTIFY_WORK = 60e6
"""Work of the proofs of a front; designs without a proof by then are undecided."""
SWEEP_EXCHANGES, MOST_ADDED_CAMS = 4, 8
"""Most repetitions of a sweep, and most cams with errors that join each repetition."""
PROOF_COLUMN = "proof"


def certify_front_with_resweeps(
    plan: SweepPlan, space_result: SpaceResult, threads: Threads, progress: Progress | None
) -> tuple[SpaceResult, ReportedRows, DesignRows, dict[str, int] | None]:
    """The counts of a sweep, its reported rows, its front, and the number of designs for each verdict.

    With ``search.robust``, designs that have a cam within the tolerances that breaks a limit are dropped, and the
    front has the column ``proof`` with the verdict on all cams of each design. The numbers by verdict include the
    dropped designs; without ``search.robust`` they are None. The threads run repeated sweeps.
    """
    reported = report_rows(plan, space_result, progress)
    if not plan.problem.robust_errors:
        return space_result.without_rows(), reported, reported.front, None
    proofs = ToleranceVerdicts(plan.space)
    for done in range(SWEEP_EXCHANGES + 1):
        budget = Budget(CERTIFY_WORK)
        front, best = (proofs.with_proof_column(rows, budget) for rows in (reported.front, reported.best))
        if not proofs.violating_errors or done == SWEEP_EXCHANGES:
            break
        # each design of the next sweep must meet the limits with some of these errors too
        added = proofs.violating_errors[:: -(-len(proofs.violating_errors) // MOST_ADDED_CAMS)]
        problem = replace(plan.problem, robust_errors=(*plan.problem.robust_errors, *added))
        plan = replace(plan, problem=problem, space=sweep_space(problem))
        proofs.violating_errors.clear()
        batches = plan.evaluate_in_batches(plan.part_blocks(), threads)
        space_result = gather_batches(plan.space, batches, plan.block_size, lambda rows: None, progress)
        reported = report_rows(plan, space_result, progress)
    kept, kept_best = (rows.column(PROOF_COLUMN) != BROKEN for rows in (front, best))
    grid = reported.front.take(kept) if reported.grid is reported.front else reported.grid
    active = [limits for limits, is_kept in zip(reported.active_limits, kept_best, strict=True) if is_kept]
    reported = ReportedRows(reported.front.take(kept), grid, reported.best.take(kept_best), active)
    counts = dict(Counter(front.column(PROOF_COLUMN).tolist()))
    return space_result.without_rows(), reported, front.take(kept), counts


@dataclass
class ToleranceVerdicts:
    """The verdicts on designs of a space over the boxes of their tolerances."""

    space: DesignSpace
    verdicts: dict[tuple[Any, ...], str] = field(default_factory=dict)
    """The verdicts so far, by the sizes and laws of a row."""
    violating_errors: list[NumberErrors] = field(default_factory=list)
    """The errors of cams that break limits."""

    def with_proof_column(self, rows: DesignRows, budget: Budget) -> DesignRows:
        """The rows with the verdict on each, in the column ``proof``; ``budget`` is the work of all proofs."""
        names = {*self.space.problem.size_quantity_names, "law_rise", "law_return"}
        keys = [tuple(row.values()) for row in rows.select_columns(names).records()]
        unknown = np.array([place for place, key in enumerate(keys) if key not in self.verdicts], dtype=int)
        for problem, index, designs in self.space.designs_by_setting(rows.take(unknown)):
            for place, number in enumerate(unknown[index].tolist()):
                cam = with_toleranced_numbers_per_design(
                    with_rounding_relative_error(replace(problem, design=designs.take([place])))
                )
                self.verdicts[keys[number]], errors = certify_over_tolerances(cam, cam.design, budget)
                self.violating_errors += errors
        return DesignRows(
            {**rows.columns, PROOF_COLUMN: np.array([self.verdicts[key] for key in keys], dtype=object)}, rows.count
        )

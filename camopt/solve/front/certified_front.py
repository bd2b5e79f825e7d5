"""Whether every cam within the tolerances of each design of a front holds the limits: a proof over its whole box.

A sweep with ``search.robust`` looks at the corners of the tolerances. Where the proof of a design on the front, or
of the best of a law, finds a cam between them that breaks a limit, that joins those that have to hold them, and the
sweep is done again, so that designs come in which were left out for this one (exchange method, as in
``smallest.exchange``). What is broken in the end is left out.
"""

from collections import Counter
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.engines.progress import Progress
from camopt.core.engines.threads import Threads
from camopt.core.numerics.clock import clock_seconds
from camopt.scene.problem.problem import at_rounding_error
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import with_toleranced_numbers
from camopt.scene.problem.space import DesignSpace
from camopt.scene.problem.tolerance_zones import NumberErrors
from camopt.solve.front.blocks import SpaceResult, gather_batches
from camopt.solve.front.plan import SweepPlan
from camopt.solve.front.reported_rows import ReportedRows, report_rows
from camopt.solve.smallest.exchange import certify_over_tolerances
from camopt.solve.verdicts.verdict_words import BROKEN

CERTIFY_SECONDS = 60.0
"""For the proofs of a front; what is not proved by then is undecided."""
SWEEP_EXCHANGES, MOST_ADDED_CAMS = 4, 8
"""How often a sweep is done again, and how many cams are added then that have to hold the limits."""
PROOF_COLUMN = "proof"


class CertifiedFront(NamedTuple):
    """What people compare of a sweep, without designs of which a cam within the tolerances breaks a limit."""

    space_result: SpaceResult
    """Without rows."""
    reported_rows: ReportedRows
    front: DesignRows
    """With the verdict on each over the box of its tolerances, in the column ``proof``, if these count."""
    every_cam: dict[str, int] | None
    """How many designs have each verdict; the broken ones are left out."""


def certify_front(plan: SweepPlan, seen: SpaceResult, own: Threads, progress: Progress | None) -> CertifiedFront:
    """The results of a sweep with the proofs that its scene asks for; its own threads sweep again."""
    compared = report_rows(plan, seen, progress)
    if not plan.problem.robust_errors:
        return CertifiedFront(seen.without_rows(), compared, compared.front, None)
    proofs = ToleranceVerdicts(plan.space)
    for done in range(SWEEP_EXCHANGES + 1):
        proofs.until = clock_seconds() + CERTIFY_SECONDS
        front, best = (proofs.with_verdicts(each) for each in (compared.front, compared.best))
        if not proofs.violating_errors or done == SWEEP_EXCHANGES:
            break
        plan = plan.with_extra_cams(proofs.violating_errors[:: -(-len(proofs.violating_errors) // MOST_ADDED_CAMS)])
        proofs.violating_errors.clear()
        seen = gather_batches(
            plan.space, plan.batches(plan.part_blocks(), own), plan.block, lambda rows: None, progress
        )
        compared = report_rows(plan, seen, progress)
    kept, good = (each.column(PROOF_COLUMN) != BROKEN for each in (front, best))
    grid = compared.front.take(kept) if compared.grid is compared.front else compared.grid
    held = [by for by, right in zip(compared.active_limits, good, strict=True) if right]
    compared = ReportedRows(compared.front.take(kept), grid, compared.best.take(good), held)
    return CertifiedFront(
        seen.without_rows(), compared, front.take(kept), dict(Counter(front.column(PROOF_COLUMN).tolist()))
    )


@dataclass
class ToleranceVerdicts:
    """The verdicts on designs of a space over the boxes of their tolerances."""

    space: DesignSpace
    until: float = inf
    """When they end (``clock_seconds``)."""
    verdicts: dict[tuple[Any, ...], str] = field(default_factory=dict)
    """Of rows of which a verdict is known, by what they have of sizes and laws."""
    violating_errors: list[NumberErrors] = field(default_factory=list)
    """By how much cams are off that break limits."""

    def with_verdicts(self, rows: DesignRows) -> DesignRows:
        """Rows with the verdict on each, in the column ``proof``."""
        names = {*self.space.problem.size_names, "law_rise", "law_return"}
        keys = [tuple(each.values()) for each in rows.select_columns(names).records()]
        unknown = np.array([place for place, key in enumerate(keys) if key not in self.verdicts], dtype=int)
        for problem, index, designs in self.space.designs_by_setting(rows.take(unknown)):
            for place, number in enumerate(unknown[index].tolist()):
                every = with_toleranced_numbers(at_rounding_error(replace(problem, design=designs.take([place]))))
                verdict, offs = certify_over_tolerances(every, every.design, self.until)
                self.violating_errors += offs
                self.verdicts[keys[number]] = verdict
        return DesignRows(
            {**rows.columns, PROOF_COLUMN: np.array([self.verdicts[key] for key in keys], dtype=object)}, rows.count
        )

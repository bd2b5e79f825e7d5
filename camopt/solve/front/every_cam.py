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
from camopt.core.numerics.clock import now
from camopt.scene.problem.problem import exactly
from camopt.scene.problem.rows import Rows
from camopt.scene.problem.settings import toleranced
from camopt.scene.problem.space import Space
from camopt.scene.problem.zones import Off
from camopt.solve.front.blocks import Seen, gathered
from camopt.solve.front.compared import Compared, compared_rows
from camopt.solve.front.plan import SweepPlan
from camopt.solve.smallest.exchange import over_tolerances
from camopt.solve.verdicts.words import BROKEN

SECONDS = 60.0
"""For the proofs of a front; what is not proved by then is undecided."""
EXCHANGES, MOST_OFFS = 4, 8
"""How often a sweep is done again, and how many cams are added then that have to hold the limits."""
COLUMN = "proof"


class Proved(NamedTuple):
    """What people compare of a sweep, without designs of which a cam within the tolerances breaks a limit."""

    seen: Seen
    """Without rows."""
    compared: Compared
    front: Rows
    """With the verdict on each over the box of its tolerances, in the column ``proof``, if these count."""
    every_cam: dict[str, int] | None
    """How many designs have each verdict; the broken ones are left out."""


def proved(plan: SweepPlan, seen: Seen, own: Threads, progress: Progress | None) -> Proved:
    """The results of a sweep with the proofs that its scene asks for; its own threads sweep again."""
    compared = compared_rows(plan, seen, progress)
    if not plan.problem.offs:
        return Proved(seen.without_rows(), compared, compared.front, None)
    proofs = Proofs(plan.space)
    for done in range(EXCHANGES + 1):
        proofs.until = now() + SECONDS
        front, best = (proofs.of(each) for each in (compared.front, compared.best))
        if not proofs.offs or done == EXCHANGES:
            break
        plan = plan.with_offs(proofs.offs[:: -(-len(proofs.offs) // MOST_OFFS)])
        proofs.offs.clear()
        seen = gathered(plan.space, plan.batches(plan.numbers(), own), plan.block, lambda rows: None, progress)
        compared = compared_rows(plan, seen, progress)
    kept, good = (each.column(COLUMN) != BROKEN for each in (front, best))
    grid = compared.front.take(kept) if compared.grid is compared.front else compared.grid
    held = [by for by, right in zip(compared.held, good, strict=True) if right]
    compared = Compared(compared.front.take(kept), grid, compared.best.take(good), held)
    return Proved(seen.without_rows(), compared, front.take(kept), dict(Counter(front.column(COLUMN).tolist())))


@dataclass
class Proofs:
    """The verdicts on designs of a space over the boxes of their tolerances."""

    space: Space
    until: float = inf
    """When they end (``clock.now``)."""
    known: dict[tuple[Any, ...], str] = field(default_factory=dict)
    """Of rows of which a verdict is known, by what they have of sizes and laws."""
    offs: list[Off] = field(default_factory=list)
    """By how much cams are off that break limits."""

    def of(self, rows: Rows) -> Rows:
        """Rows with the verdict on each, in the column ``proof``."""
        names = {*self.space.problem.sizes, "law_rise", "law_return"}
        keys = [tuple(each.values()) for each in rows.only(names).records()]
        unknown = np.array([place for place, key in enumerate(keys) if key not in self.known], dtype=int)
        for problem, index, designs in self.space.designs_apart(rows.take(unknown)):
            for place, number in enumerate(unknown[index].tolist()):
                every = toleranced(exactly(replace(problem, design=designs.take([place]))))
                verdict, offs = over_tolerances(every, every.design, self.until)
                self.offs += offs
                self.known[keys[number]] = verdict
        return Rows({**rows.columns, COLUMN: np.array([self.known[key] for key in keys], dtype=object)}, rows.count)

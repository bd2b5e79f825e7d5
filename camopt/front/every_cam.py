"""Whether every cam within the tolerances of each design of a front holds the limits: a proof over its whole box.

A sweep with ``search.robust`` looks at the corners of the tolerances alone.
"""

from collections import Counter
from dataclasses import replace

import numpy as np

from camopt.numerics.clock import now
from camopt.problem.rows import Rows
from camopt.problem.space import Space
from camopt.verdicts.words import worst

SECONDS = 60.0
"""For the proofs of a front; what is not proved by then is undecided."""
COLUMN = "proof"


def with_proofs(space: Space, rows: Rows) -> Rows:
    """Rows with a verdict on each over the box of its tolerances, in the column ``proof``."""
    from camopt.verdicts.certify import over_box

    found, until = np.full(rows.count, "", dtype=object), now() + SECONDS
    for problem, index, designs in space.designs_apart(rows):
        for place, number in enumerate(index.tolist()):
            found[number] = worst(over_box(replace(problem, design=designs.take([place])), until).values())
    return Rows({**rows.columns, COLUMN: found}, rows.count)


def counted(rows: Rows) -> dict[str, int]:
    """How many rows have each verdict."""
    return dict(Counter(rows.column(COLUMN).tolist()))

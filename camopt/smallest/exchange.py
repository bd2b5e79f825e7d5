"""The proof that every cam within tolerances holds the limits with a smallest one, and the cam that breaks one.

Those at the corners of the zones are looked at with each design that is tried. If the proof over the whole box then
finds another cam that breaks a limit, that is added to those that have to hold it, and so on: no robust cam is
smaller than the smallest of those that hold the limits for some cams of the box.

Source: J. W. Blankenship, J. E. Falk, Infinitely constrained optimization problems, J. Optim. Theory Appl. 19
(1976).
"""

from dataclasses import replace

import numpy as np

from camopt.mechanisms import Designs
from camopt.mechanisms.design import SizeBounds
from camopt.problem.problem import Problem
from camopt.problem.zones import Off
from camopt.smallest.result import Smallest, gap_of
from camopt.verdicts.limit_boxes import ends_within, limit_over_box, nominal_at
from camopt.verdicts.screening import feasible
from camopt.verdicts.words import BROKEN, HELD, UNDECIDED, worst

EXCHANGES = 16
"""How often a cam within the tolerances that breaks a limit is added to those that have to hold it."""


def with_proof(problem: Problem, answer: Smallest, bounds: SizeBounds, until: float) -> tuple[Smallest, Off | None]:
    """An answer with the verdict on every cam within the tolerances; by how much one is off that breaks a limit.

    Where rounding leaves the proof open, a cam is tried that is larger by less than what sizes are proved to.
    """
    assert answer.design is not None
    verdict, off = over_tolerances(problem, answer.design, until)
    if verdict == UNDECIDED:
        room = (gap_of(answer.design) - (answer.gap if answer.proved else 0.0)) / 2.0
        larger = answer.moved(np.array([room]))
        within = all(larger.sizes[disc][0] <= bounds[disc][1] for disc in answer.discs)
        if within and feasible(problem, larger)[0] and over_tolerances(problem, larger, until)[0] == HELD:
            return replace(answer, design=larger, every_cam=HELD), None
    return replace(answer, every_cam=verdict), off


def over_tolerances(problem: Problem, design: Designs, until: float) -> tuple[str, Off | None]:
    """The verdict on all cams within the tolerances of a design; by how much one is off that breaks a limit."""
    ends, verdicts = ends_within(problem, design), []
    for limit in problem.limits:
        found = limit_over_box(problem, limit, design, ends, until)
        if found.verdict == BROKEN and found.witness is not None:
            nominal, values = nominal_at(problem, design), found.witness.values
            return BROKEN, {f: float(values[f][0]) - at for f, at in nominal.items() if f in values}
        verdicts.append(found.verdict)
    return worst(verdicts), None

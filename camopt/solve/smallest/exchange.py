"""The proof that every cam within tolerances holds the limits with a smallest one, and cams that break them.

Those at the corners of the zones are looked at with each design that is tried; none at first, where links have
tolerances. If the proof over the whole box then finds other cams that break limits, the worst near them are added
to those that have to hold them, and so on: no robust cam is smaller than the smallest of those that hold the limits
for some cams of the box.

Source: J. W. Blankenship, J. E. Falk, Infinitely constrained optimization problems, J. Optim. Theory Appl. 19
(1976).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.zones import Off, moved
from camopt.solve.smallest.result import Smallest, gap_of
from camopt.solve.verdicts.judging import excesses
from camopt.solve.verdicts.limit_boxes import ends_within, limit_over_box, nominal_at
from camopt.solve.verdicts.running import columns_for
from camopt.solve.verdicts.screening import feasible
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED, worst

EXCHANGES = 16
"""How often a cam within the tolerances that breaks a limit is added to those that have to hold it."""


def with_proof(problem: Problem, answer: Smallest, bounds: SizeBounds, until: float) -> tuple[Smallest, list[Off]]:
    """An answer with the verdict on every cam within the tolerances; by how much those are off that break limits.

    Where rounding leaves the proof open, a cam is tried that is larger by less than what sizes are proved to.
    """
    assert answer.design is not None
    verdict, offs = over_tolerances(problem, answer.design, until)
    if verdict == UNDECIDED:
        room = (gap_of(answer.design) - (answer.gap if answer.proved else 0.0)) / 2.0
        larger = answer.moved(np.array([room]))
        within = all(larger.sizes[disc][0] <= bounds[disc][1] for disc in answer.discs)
        if within and feasible(problem, larger)[0] and over_tolerances(problem, larger, until)[0] == HELD:
            return replace(answer, design=larger, every_cam=HELD), []
    return replace(answer, every_cam=verdict), offs


def broken_at(problem: Problem, design: Designs, offs: Sequence[Off]) -> list[Off]:
    """Those of some cams that are off which break a limit: of limits that no proof decides."""
    return [off for off in offs if not feasible(replace(problem, offs=(off,)), design, perhaps=True)[0]]


def over_tolerances(problem: Problem, design: Designs, until: float) -> tuple[str, list[Off]]:
    """The verdict on all cams within the tolerances of a design; how far off one is for each broken limit."""
    ends, nominal, verdicts, offs = ends_within(problem, design), nominal_at(problem, design), [], list[Off]()
    for limit in problem.limits:
        found = limit_over_box(problem, limit, design, ends, until)
        if found.verdict == BROKEN and found.witness is not None:
            values = found.witness.values
            off = {field: float(values[field][0]) - at for field, at in nominal.items() if field in values}
            offs.append(_worse(problem, limit, design, off))
        verdicts.append(found.verdict)
    return worst(verdicts), offs


def _worse(problem: Problem, limit: Limit, design: Designs, off: Off) -> Off:
    """By how much a cam is off that breaks a limit more: each number in turn at an end, if that is worse."""
    most = _excess(problem, limit, design, off)
    for field, zone in problem.zones.items():
        for end in (zone.lower, zone.upper):
            other = {**off, field: end}
            if (excess := _excess(problem, limit, design, other)) > most:
                off, most = other, excess
    return off


def _excess(problem: Problem, limit: Limit, design: Designs, off: Off) -> float:
    """By how much a cam that is off exceeds a limit."""
    shared, brought = problem.parted(off)
    own, cam = problem.with_numbers_off(shared), moved(design, brought)
    limits = [each for each in own.limits if (each.name, each.bound) == (limit.name, limit.bound)]
    return float(excesses(limits, columns_for(own, limits, cam), cam).max())

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
from camopt.scene.problem.tolerance_zones import NumberErrors, add_errors
from camopt.solve.smallest.result import SmallestCam, allowed_gap
from camopt.solve.verdicts.effect_runs import columns_for
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_boxes import limit_over_box, nominal_numbers, tolerance_ranges
from camopt.solve.verdicts.limit_verdicts import excesses
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict

CAM_EXCHANGES = 16
"""How often a cam within the tolerances that breaks a limit is added to those that have to hold it."""


def certify_answer(
    problem: Problem, answer: SmallestCam, bounds: SizeBounds, until: float
) -> tuple[SmallestCam, list[NumberErrors]]:
    """An answer with the verdict on every cam within the tolerances; by how much those are off that break limits.

    Where rounding leaves the proof open, a cam is tried that is larger by less than what sizes are proved to.
    """
    assert answer.design is not None
    verdict, offs = certify_over_tolerances(problem, answer.design, until)
    if verdict == UNDECIDED:
        room = (allowed_gap(answer.design) - (answer.gap if answer.is_proved else 0.0)) / 2.0
        larger = answer.with_larger_sizes(np.array([room]))
        within = all(larger.sizes[disc][0] <= bounds[disc][1] for disc in answer.discs)
        if (
            within
            and feasible_designs(problem, larger)[0]
            and certify_over_tolerances(problem, larger, until)[0] == HELD
        ):
            return replace(answer, design=larger, every_cam=HELD), []
    return replace(answer, every_cam=verdict), offs


def violating_cams(problem: Problem, design: Designs, offs: Sequence[NumberErrors]) -> list[NumberErrors]:
    """Those of some cams that are off which break a limit: of limits that no proof decides."""
    return [
        off for off in offs if not feasible_designs(replace(problem, robust_errors=(off,)), design, perhaps=True)[0]
    ]


def certify_over_tolerances(problem: Problem, design: Designs, until: float) -> tuple[str, list[NumberErrors]]:
    """The verdict on all cams within the tolerances of a design; how far off one is for each broken limit."""
    ends, nominal, verdicts, offs = (
        tolerance_ranges(problem, design),
        nominal_numbers(problem, design),
        [],
        list[NumberErrors](),
    )
    for limit in problem.limits:
        found = limit_over_box(problem, limit, design, ends, until)
        if found.verdict == BROKEN and found.witness is not None:
            values = found.witness.values
            off = {field: float(values[field][0]) - at for field, at in nominal.items() if field in values}
            offs.append(_worsen_violation(problem, limit, design, off))
        verdicts.append(found.verdict)
    return worst_verdict(verdicts), offs


def _worsen_violation(problem: Problem, limit: Limit, design: Designs, off: NumberErrors) -> NumberErrors:
    """By how much a cam is off that breaks a limit more: each number in turn at an end, if that is worse."""
    most = _cam_excess(problem, limit, design, off)
    for field, zone in problem.zones.items():
        for end in (zone.lower, zone.upper):
            other = {**off, field: end}
            if (excess := _cam_excess(problem, limit, design, other)) > most:
                off, most = other, excess
    return off


def _cam_excess(problem: Problem, limit: Limit, design: Designs, off: NumberErrors) -> float:
    """By how much a cam that is off exceeds a limit."""
    shared, brought = problem.split_errors(off)
    own, cam = problem.with_number_errors(shared), add_errors(design, brought)
    limits = [each for each in own.limits if (each.name, each.bound) == (limit.name, limit.bound)]
    return float(excesses(limits, columns_for(own, limits, cam), cam).max())

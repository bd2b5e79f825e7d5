"""Robust smallest cams by exchange: the proof over all tolerances, and the cams with errors that break a limit.

The search evaluates each design with the cams at the corners of the tolerance zones, or with none of them at first
if links have tolerances. The proof then covers the whole box of tolerances. If it finds other cams that break
limits, the worst near them join the search, which runs again. A few cams of the box give a lower bound: no robust
cam is smaller than the smallest design that is feasible with these cams.

Source: J. W. Blankenship, J. E. Falk, Infinitely constrained optimization problems, J. Optim. Theory Appl. 19
(1976).
"""

from dataclasses import replace

import numpy as np

from camopt.core.numerics.budget import Budget
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import NumberErrors, with_added_errors
from camopt.solve.smallest.result import SmallestCam, allowed_proof_gap
from camopt.solve.verdicts.effect_runs import columns_for_limits
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_boxes import limit_verdict_over_box, nominal_toleranced_numbers, tolerance_ranges
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED, worst_verdict

CAM_EXCHANGES = 16
"""Most rounds in which cams with errors that break a limit join the search."""


def certify_robust_answer(
    problem: Problem, answer: SmallestCam, bounds: SizeBounds, budget: Budget
) -> tuple[SmallestCam, list[NumberErrors]]:
    """The answer with the verdict on every cam within the tolerances, and the errors of cams that break limits.

    If rounding leaves the proof open, a design is tried that is larger by less than the gap of a proved size.
    """
    assert answer.design is not None
    verdict, violating = certify_over_tolerances(problem, answer.design, budget)
    if verdict == UNDECIDED:
        room = (allowed_proof_gap(answer.design) - (answer.gap if answer.is_proved else 0.0)) / 2.0
        larger = answer.with_larger_sizes(np.array([room]))
        if (
            all(larger.sizes[disc][0] <= bounds[disc][1] for disc in answer.discs)
            and feasible_designs(problem, larger)[0]
            and certify_over_tolerances(problem, larger, budget)[0] == HELD
        ):
            return replace(answer, design=larger, every_cam=HELD), []
    return replace(answer, every_cam=verdict), violating


def certify_over_tolerances(problem: Problem, design: Designs, budget: Budget) -> tuple[str, list[NumberErrors]]:
    """The verdict on all cams within a design's tolerances, and the errors of one cam for each broken limit."""
    ends, nominal = tolerance_ranges(problem, design), nominal_toleranced_numbers(problem, design)
    verdicts, violating = [], list[NumberErrors]()
    for limit in problem.limits:
        limit_verdict = limit_verdict_over_box(problem, limit, design, ends, budget)
        if limit_verdict.verdict == BROKEN and limit_verdict.witness is not None:
            values = limit_verdict.witness.values
            errors = {field: float(values[field][0]) - at for field, at in nominal.items() if field in values}
            violating.append(_worsen_violating_errors(problem, limit, design, errors))
        verdicts.append(limit_verdict.verdict)
    return worst_verdict(verdicts), violating


def _worsen_violating_errors(problem: Problem, limit: Limit, design: Designs, errors: NumberErrors) -> NumberErrors:
    """Errors that break a limit more: each number in turn goes to an end of its zone if that is worse."""
    most = _cam_excess(problem, limit, design, errors)
    for field, zone in problem.zones.items():
        for end in (zone.lower, zone.upper):
            other = {**errors, field: end}
            if (excess := _cam_excess(problem, limit, design, other)) > most:
                errors, most = other, excess
    return errors


def _cam_excess(problem: Problem, limit: Limit, design: Designs, errors: NumberErrors) -> float:
    """Relative excess of a cam with these errors over a limit."""
    shared_errors, cam_errors = problem.split_train_and_design_errors(errors)
    variant, cam = problem.with_number_errors(shared_errors), with_added_errors(design, cam_errors)
    limits = [other for other in variant.limits if (other.name, other.bound) == (limit.name, limit.bound)]
    return float(relative_excesses_by_limit(limits, columns_for_limits(variant, limits, cam), cam).max())

"""Verdicts on limits: the enclosures of quantities are compared with their limits.

A limit is held if the far side of the quantity's enclosure holds it, and broken if the near side breaks it. In
between, the design is evaluated again with an error near rounding, and then in interval arithmetic. A design that
is undecided even then is not feasible.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.model.effects import EvaluationBlock, quantities_with_expression_inputs
from camopt.model.effects.contacts import select_designs
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limit import ASSEMBLY, Limit, quantities_of_limits
from camopt.scene.problem.problem import SINGLE_DESIGN_ERROR, Problem, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows, QuantityColumns
from camopt.solve.verdicts.effect_runs import columns_for_limits, effect_plan, with_quantities_of_effect
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

CERTIFIED, SAMPLED = "certified", "sampled"
ENCLOSURE_SIDES = np.array([[1.0], [-1.0]])  # far and near side of an enclosure, as shares of its half-width
DEFERRED_WORK = 100.0  # work of the last limits for one design
LAST_DESIGNS_AT_ONCE = 16  # designs checked together for the last limits, if there is a budget


def sampled_or_certified_status(problem: Problem) -> str:
    """Status of a proved verdict: sampled if it depends on a table of points or a Python function, else certified.

    Between the points of a table the motion is only assumed, and the numbers of a Python function have no
    enclosure.
    """
    return SAMPLED if problem.programme.has_sampled_law or problem.has_unenclosed_limit else CERTIFIED


class Effort(NamedTuple):
    """Numbers of designs that were evaluated again, then in intervals, and that stayed undecided."""

    again: int = 0
    intervals: int = 0
    undecided: int = 0

    def plus(self, other: "Effort") -> "Effort":
        return Effort(*(a + b for a, b in zip(self, other, strict=True)))


def evaluate_with_verdicts(
    problem: Problem, designs: Designs, wanted_quantities: frozenset[str], budget: Budget = UNLIMITED
) -> DesignRows:
    """Wanted quantities of all designs, with their verdicts; undecided ones stay so once the budget is spent."""
    return evaluate_with_verdicts_and_effort(problem, designs, wanted_quantities, budget)[0]


def evaluate_with_verdicts_and_effort(
    problem: Problem, designs: Designs, wanted_quantities: frozenset[str], budget: Budget = UNLIMITED
) -> tuple[DesignRows, Effort]:
    """Wanted quantities of all designs, with their verdicts and the effort."""
    budget.spend(problem.evaluation_work(len(designs)))
    rows, outer, inner = quantities_with_excess_bounds(problem, designs, wanted_quantities)
    rows = with_inaccurate_numbers_certified(problem, designs, rows)
    exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
    feasible = exists & np.all(outer <= 0.0, axis=0)
    undecided = exists & ~feasible & ~np.any(inner > 0.0, axis=0)
    proved, over = sampled_or_certified_status(problem), np.where(feasible | undecided, outer, inner)
    verdict = {
        "feasible": feasible,
        "violated": np.where(exists, violated_limit_names(problem.limits, over), ASSEMBLY),
        "status": np.where(undecided, UNDECIDED, proved) if undecided.any() else proved,
        "relative_half_width": rows.half_width,
    }
    rows = DesignRows(rows.columns | verdict, rows.count)
    index = np.flatnonzero(undecided)
    if not index.size:
        return rows, Effort()
    if problem.setup.relative_error > SINGLE_DESIGN_ERROR:
        closer, effort = evaluate_with_verdicts_and_effort(
            with_rounding_relative_error(problem), designs.take(index), wanted_quantities, budget
        )
        return rows.replace_rows(index, closer), effort._replace(again=index.size)
    closer = _rows_with_certified_verdicts(problem, designs.take(index), rows.take(index), budget)
    remaining = int(np.count_nonzero(closer.column("status") == UNDECIDED))
    return rows.replace_rows(index, closer), Effort(intervals=index.size, undecided=remaining)


class ExcessBounds(NamedTuple):
    """Quantities of designs, and their relative excess over each limit (limits, designs).

    ``outer`` is the excess of the far sides of enclosures, ``inner`` that of the near sides. Both are −∞ for limits
    that are checked last, if the design may exceed another limit.
    """

    rows: DesignRows
    outer: FloatArray
    inner: FloatArray


def quantities_with_excess_bounds(
    problem: Problem, designs: Designs, wanted_quantities: frozenset[str], budget: Budget = UNLIMITED
) -> ExcessBounds:
    """Wanted quantities of all designs, the quantities of limits, and the excesses over all limits.

    Limits that are checked last are checked only for designs that may hold all others, within the budget.
    """
    budget.spend(problem.evaluation_work(len(designs)))
    case, rows, later = EvaluationBlock(problem.setup, problem.programme, designs), DesignRows({}, len(designs)), []
    wanted_quantities = quantities_with_expression_inputs(wanted_quantities, problem.setup)
    for effect, names in effect_plan(wanted_quantities | problem.required_quantities, problem.setup):
        if effect.last and not names & wanted_quantities:
            later.append((effect, names))
        else:
            rows = with_quantities_of_effect(rows, case, effect, names)
    first = [limit for limit in problem.limits if not limit.is_deferred]
    both = np.full((2, len(problem.limits), len(designs)), -np.inf)
    both[:, : len(first)] = relative_excesses_by_enclosure_side(first, rows, designs)
    outer, inner = both
    index = np.flatnonzero(np.all(outer <= 0.0, axis=0))
    last = problem.limits[len(first) :]
    outer[len(first) :, index] = inf
    pieces = np.array_split(index, 1 + index.size // LAST_DESIGNS_AT_ONCE) if budget.end < inf else [index]
    for numbers in pieces if last and index.size else ():
        if budget.is_spent:
            break
        budget.spend(DEFERRED_WORK * numbers.size)
        last_rows, part = rows.take(numbers), select_designs(case, numbers)
        for effect, names in later:
            last_rows = with_quantities_of_effect(last_rows, part, effect, names)
        both[:, len(first) :, numbers] = relative_excesses_by_enclosure_side(last, last_rows, part.designs)
    return ExcessBounds(rows, outer, inner)


def with_inaccurate_numbers_certified(problem: Problem, designs: Designs, rows: DesignRows) -> DesignRows:
    """Rows with numbers proved in intervals where double precision misses the scene's accuracy."""
    if np.all(np.asarray(rows.half_width) <= problem.accuracy):
        return rows
    from camopt.solve.verdicts.certified_ranges import certify_inaccurate_quantities  # noqa: PLC0415, seldom needed

    return certify_inaccurate_quantities(problem, designs, rows)


def _rows_with_certified_verdicts(
    problem: Problem, designs: Designs, rows: DesignRows, budget: Budget
) -> DesignRows:
    """Rows with the verdicts of interval arithmetic."""
    from camopt.solve.verdicts.certify import certify_limits  # noqa: PLC0415, seldom needed

    by_design = [
        list(certify_limits(*problem.absorb_design_numbers(designs.take([i])), budget).values())
        for i in range(len(designs))
    ]
    verdicts = np.array(by_design).T
    feasible = np.all(verdicts == HELD, axis=0)
    settled = feasible | np.any(verdicts == BROKEN, axis=0)
    verdict = {
        "feasible": feasible,
        "violated": violated_limit_names(problem.limits, np.where(verdicts == HELD, -1.0, 1.0)),
        "status": np.where(settled, sampled_or_certified_status(problem), UNDECIDED),
    }
    return DesignRows(rows.columns | verdict, rows.count)


def relative_excesses_by_limit(limits: Sequence[Limit], columns: QuantityColumns, designs: Designs) -> FloatArray:
    """Relative excess over each limit (limits, designs)."""
    excess = np.empty((len(limits), len(designs)))
    for limit, row in zip(limits, excess, strict=True):
        row[:] = limit.excess(columns, designs)
    return excess


def relative_excesses_by_enclosure_side(limits: Sequence[Limit], rows: DesignRows, designs: Designs) -> FloatArray:
    """Relative excess over each limit of the far and near sides of enclosures (2, limits, designs)."""
    columns = rows.select_columns(quantities_of_limits(limits)).columns_shifted_by_width_share(ENCLOSURE_SIDES)
    excess = np.empty((2, len(limits), len(designs)))
    for number, limit in enumerate(limits):
        excess[:, number] = limit.excess(columns, designs)
    return excess


def worst_excesses_over_variants(problem: Problem, limits: Sequence[Limit], designs: Designs) -> FloatArray:
    """Largest relative excess over each limit among all variants of each design (limits, designs)."""
    return np.asarray(np.max([excess for _, _, excess in excesses_of_variants(problem, limits, designs)], axis=0))


def excesses_of_variants(
    problem: Problem, limits: Sequence[Limit], designs: Designs
) -> Iterator[tuple[Designs, QuantityColumns, FloatArray]]:
    """Variants of the designs that must all hold the limits, with their quantities and excesses (limits, designs).

    The excess over a limit that only the nominal designs must hold is −∞ for the other variants.
    """
    of_errors = [limit.is_on_motion_error for limit in limits]
    for number, (variant_problem, variant) in enumerate(problem.nominal_and_error_variants(designs)):
        columns = columns_for_limits(variant_problem, limits, variant)
        excess = relative_excesses_by_limit(limits, columns, variant)
        if number:
            excess[of_errors] = -np.inf
        yield variant, columns, excess


INFINITE_EXCESS = 1e6  # in place of an infinite excess, so that other limits still rank designs


def excess_rank(excess: FloatArray) -> tuple[float, float]:
    """Rank of a design by its excesses (limits,): the largest relative excess, then their sum."""
    over = np.clip(excess, 0.0, INFINITE_EXCESS)
    return float(over.max(initial=0.0)), float(over.sum())


def index_of_least_excess(excess: FloatArray) -> int:
    """Number of the design in (limits, designs) that misses its limits the least."""
    over = np.clip(excess, 0.0, INFINITE_EXCESS)
    return int(np.lexsort((over.sum(axis=0), over.max(axis=0)))[0])


def violated_limit_names(limits: Iterable[Limit], excess: FloatArray) -> NDArray[np.str_]:
    """Names of the limits that each design exceeds, joined by commas.

    A limit that is checked last is named only if the design holds all others.
    """
    names, last = [limit.name for limit in limits], np.array([limit.is_deferred for limit in limits], dtype=bool)
    over = excess > 0.0
    over[last] &= ~np.any(over[~last], axis=0)
    kinds = [column.tobytes() for column in over.T]
    texts = {kind: ",".join(n for n, bad in zip(names, kind, strict=True) if bad) for kind in set(kinds)}
    return np.array([texts[kind] for kind in kinds], dtype=str)

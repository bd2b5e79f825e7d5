"""Verdicts: the quantities of designs beside their limits; a verdict is proved or undecided.

A limit is held if the far side of the quantity's enclosure holds it, and broken if the near side breaks it.
Between the two a design is looked at again at an error near rounding, and then in intervals; what is undecided
even then, to rounding, is no feasible design.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds
from camopt.model.effects import EvaluationBlock, with_read_quantities
from camopt.model.effects.contacts import select_designs
from camopt.model.mechanisms import Designs
from camopt.scene.problem.limit import ASSEMBLY, Limit, quantities_of_limits
from camopt.scene.problem.problem import SINGLE_DESIGN_ERROR, Problem, at_rounding_error
from camopt.scene.problem.rows import DesignRows, QuantityColumns
from camopt.solve.verdicts.effect_runs import columns_for, effect_plan, with_effect
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

CERTIFIED, SAMPLED = "certified", "sampled"
ENCLOSURE_SIDES = np.array([[1.0], [-1.0]])  # shares of the widths of enclosures, a row each
LAST_DESIGNS_AT_ONCE = 16  # designs of which limits that are asked last are asked, where there is a time to stop


def proved_status(problem: Problem) -> str:
    """The status of a proved verdict; what is proved of a table is not known of the motion between its points.

    Nor does a number without an enclosure prove anything, such as that of a Python function.
    """
    return SAMPLED if problem.programme.has_sampled_law or problem.has_unenclosed_limit else CERTIFIED


class Effort(NamedTuple):
    """Numbers of designs evaluated more than once: at an error near rounding, then in intervals."""

    again: int = 0
    intervals: int = 0
    undecided: int = 0

    def plus(self, other: "Effort") -> "Effort":
        return Effort(*(a + b for a, b in zip(self, other, strict=True)))


def evaluate_rows(problem: Problem, designs: Designs, wanted: frozenset[str], until: float = inf) -> DesignRows:
    """The wanted quantities of all designs, with their verdict; undecided if that takes longer than ``until``."""
    return evaluate_with_effort(problem, designs, wanted, until)[0]


def evaluate_with_effort(
    problem: Problem, designs: Designs, wanted: frozenset[str], until: float = inf
) -> tuple[DesignRows, Effort]:
    """As ``evaluate_rows``, and the effort that it took."""
    rows, outer, inner = bound_excesses(problem, designs, wanted)
    rows = with_certified_numbers(problem, designs, rows)
    exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
    feasible = exists & np.all(outer <= 0.0, axis=0)
    undecided = exists & ~feasible & ~np.any(inner > 0.0, axis=0)
    proved, over = proved_status(problem), np.where(feasible | undecided, outer, inner)
    verdict = {
        "feasible": feasible,
        "violated": np.where(exists, violations(problem.limits, over), ASSEMBLY),
        "status": np.where(undecided, UNDECIDED, proved) if undecided.any() else proved,
        "relative_half_width": rows.half_width,
    }
    rows = DesignRows(rows.columns | verdict, rows.count)
    index = np.flatnonzero(undecided)
    if not index.size:
        return rows, Effort()
    if problem.setup.relative_error > SINGLE_DESIGN_ERROR:
        closer, effort = evaluate_with_effort(at_rounding_error(problem), designs.take(index), wanted, until)
        return rows.replace_rows(index, closer), effort._replace(again=index.size)
    closer = _certify_rows(problem, designs.take(index), rows.take(index), until)
    left = int(np.count_nonzero(closer.column("status") == UNDECIDED))
    return rows.replace_rows(index, closer), Effort(intervals=index.size, undecided=left)


class ExcessBounds(NamedTuple):
    """Designs with their quantities, and the relative excess over each limit, (limits, designs).

    ``outer`` is that of the far sides of enclosures, ``inner`` that of the near sides. Both are −∞ for a limit that
    is checked last, of designs that may exceed another one.
    """

    rows: DesignRows
    outer: FloatArray
    inner: FloatArray


def bound_excesses(problem: Problem, designs: Designs, wanted: frozenset[str], until: float = inf) -> ExcessBounds:
    """The wanted quantities of all designs, and what all limits need, except those checked last, with all excesses.

    After ``until`` (``clock.now``) nothing more is found of limits that are checked last.
    """
    case, rows, later = EvaluationBlock(problem.setup, problem.programme, designs), DesignRows({}, len(designs)), []
    wanted = with_read_quantities(wanted, problem.setup)
    for effect, names in effect_plan(wanted | problem.required_quantities, problem.setup):
        if effect.last and not names & wanted:
            later.append((effect, names))
        else:
            rows = with_effect(rows, case, effect, names)
    first = [limit for limit in problem.limits if not limit.is_deferred]
    both = np.full((2, len(problem.limits), len(designs)), -np.inf)
    both[:, : len(first)] = excess_of_sides(first, rows, designs)
    outer, inner = both
    index = np.flatnonzero(np.all(outer <= 0.0, axis=0))
    last = problem.limits[len(first) :]
    outer[len(first) :, index] = inf
    pieces = np.array_split(index, 1 + index.size // LAST_DESIGNS_AT_ONCE) if until < inf else [index]
    for some in pieces if last and index.size else ():
        if clock_seconds() > until:
            break
        found, part = rows.take(some), select_designs(case, some)
        for effect, names in later:
            found = with_effect(found, part, effect, names)
        both[:, len(first) :, some] = excess_of_sides(last, found, part.designs)
    return ExcessBounds(rows, outer, inner)


def with_certified_numbers(problem: Problem, designs: Designs, rows: DesignRows) -> DesignRows:
    """The rows, with numbers proved in intervals where doubles are less exact than the scene asks."""
    if np.all(np.asarray(rows.half_width) <= problem.accuracy):
        return rows
    from camopt.solve.verdicts.certified_ranges import certify_numbers  # noqa: PLC0415, seldom needed

    return certify_numbers(problem, designs, rows)


def _certify_rows(problem: Problem, designs: Designs, rows: DesignRows, until: float) -> DesignRows:
    """The rows with the verdicts of intervals, whose errors are those of the formulas alone."""
    from camopt.solve.verdicts.certify import certify_limits  # noqa: PLC0415, seldom needed

    found = [
        list(certify_limits(*problem.absorb_design_numbers(designs.take([i])), until).values())
        for i in range(len(designs))
    ]
    verdicts = np.array(found).T
    feasible = np.all(verdicts == HELD, axis=0)
    settled = feasible | np.any(verdicts == BROKEN, axis=0)
    verdict = {
        "feasible": feasible,
        "violated": violations(problem.limits, np.where(verdicts == HELD, -1.0, 1.0)),
        "status": np.where(settled, proved_status(problem), UNDECIDED),
    }
    return DesignRows(rows.columns | verdict, rows.count)


def excesses(limits: Sequence[Limit], columns: QuantityColumns, designs: Designs) -> FloatArray:
    """Relative excess over each limit, (limits, designs)."""
    found = np.empty((len(limits), len(designs)))
    for limit, over in zip(limits, found, strict=True):
        over[:] = limit.excess(columns, designs)
    return found


def excess_of_sides(limits: Sequence[Limit], rows: DesignRows, designs: Designs) -> FloatArray:
    """The same of the far sides of enclosures, and of the near ones: (2, limits, designs)."""
    found, columns = (
        np.empty((2, len(limits), len(designs))),
        rows.select_columns(quantities_of_limits(limits)).shifted_columns(ENCLOSURE_SIDES),
    )
    for number, limit in enumerate(limits):
        found[:, number] = limit.excess(columns, designs)
    return found


def worst_excesses(problem: Problem, limits: Sequence[Limit], designs: Designs) -> FloatArray:
    """Relative excess over each limit, (limits, designs), of the worst of all designs that have to hold it."""
    return np.asarray(np.max([each for _, _, each in excesses_of_variants(problem, limits, designs)], axis=0))


def excesses_of_variants(
    problem: Problem, limits: Sequence[Limit], designs: Designs
) -> Iterator[tuple[Designs, QuantityColumns, FloatArray]]:
    """Designs and those that have to hold limits with each, with their quantities and excesses (limits, designs).

    −∞ of a limit that the first alone have to hold.
    """
    of_errors = [limit.is_on_motion_error for limit in limits]
    for place, (own, each) in enumerate(problem.all_variants(designs)):
        columns = columns_for(own, limits, each)
        excess = excesses(limits, columns, each)
        if place:
            excess[of_errors] = -np.inf
        yield each, columns, excess


INFINITE_EXCESS = (
    1e6  # what counts as an infinite excess, so that designs can still be told apart by their other limits
)


def excess_rank(excess: FloatArray) -> tuple[float, float]:
    """The excess of a design (limits,) for comparison: its worst relative excess, then the sum of all."""
    over = np.clip(excess, 0.0, INFINITE_EXCESS)
    return float(over.max(initial=0.0)), float(over.sum())


def least_excess(excess: FloatArray) -> int:
    """The design, of those in (limits, designs), that misses the least."""
    over = np.clip(excess, 0.0, INFINITE_EXCESS)
    return int(np.lexsort((over.sum(axis=0), over.max(axis=0)))[0])


def violations(limits: Iterable[Limit], excess: FloatArray) -> NDArray[np.str_]:
    """The names of the limits that each design exceeds, joined by commas.

    A limit that is asked last is named only where a design holds all others.
    """
    names, last = [limit.name for limit in limits], np.array([limit.is_deferred for limit in limits], dtype=bool)
    over = excess > 0.0
    over[last] &= ~np.any(over[~last], axis=0)
    kinds = [each.tobytes() for each in over.T]
    texts = {kind: ",".join(n for n, bad in zip(names, kind, strict=True) if bad) for kind in set(kinds)}
    return np.array([texts[kind] for kind in kinds], dtype=str)

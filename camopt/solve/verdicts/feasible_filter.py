"""Screening: the quantities of those designs of many that hold every limit, with a verdict that is proved.

Effects run cheapest first, and a design that breaks a limit is dropped before the next effect runs. Constraints on
curves come first: a constraint holds at every cam angle, so any one angle refutes it. Designs that are alike are at
their worst near the same angles. Where nodes of the motion show that most of a few designs break a constraint, all
designs are looked at there. The extremes of the curves decide about the rest.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import and_, or_
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, BoolArray, FloatArray, IndexArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.piecewise import columns_of_all_rows, motion_at_node
from camopt.model.effects import Effect, EvaluationBlock
from camopt.model.effects.known_extremes import NOTHING_KNOWN, KnownExtremes, Question
from camopt.model.effects.peak import CLEAR_SHARE, Derivative, Variant
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import Constraint, merge_stroke_kinds
from camopt.scene.problem.limit import Limit, quantities_of_limits
from camopt.scene.problem.limits import peaks_of_quantity
from camopt.scene.problem.problem import Problem, at_rounding_error, strictest_constraints
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts.effect_runs import (
    effect_plan,
    with_curve_values,
    with_effect,
    with_pitch_values,
    with_values_beyond_pitch,
)
from camopt.solve.verdicts.limit_verdicts import Effort, evaluate_with_effort, proved_status, with_certified_numbers

MANY_DESIGNS, PROBE_DESIGNS, PROBE_NODES = (
    500,
    16,
    4,
)  # designs that are worth it, those asked first, and nodes for each side of a constraint
BROKEN_BEYOND = 1e-6  # relative, of what is further beyond a bound than rounding


@np.errstate(all="ignore")
def designs_breaking_constraints(case: EvaluationBlock, constraints: Iterable[Constraint]) -> BoolArray:
    """Which designs of a case break one of some constraints for certain; of few designs none are asked."""
    found, table = np.zeros(len(case.designs), dtype=bool), case.programme.table
    asked = (
        [each for each in constraints if not isinstance(each.curve, Derivative)]
        if found.size > MANY_DESIGNS
        else []
    )
    pieces = np.repeat(table.kind, np.diff(table.first_panel) + 1)
    for made in {each.curve: None for each in asked}:
        record = made(case.designs, case.programme)
        few = case.designs.take(np.linspace(0, found.size - 1, PROBE_DESIGNS).astype(int))
        values = value_of(made(few, case.programme), ..., motion_at_node(columns_of_all_rows(table), ...))
        for constraint in (each for each in asked if each.curve is made):
            for side in constraint.sides:
                shown = (
                    _exceeds_constraint(constraint, side, values, few) & (pieces & constraint.kinds != 0)[:, None]
                )
                for node in _decisive_nodes(shown):
                    found |= _exceeds_constraint(
                        constraint, side, value_of(record, ..., motion_at_node(table, node)), case.designs
                    )
    return found


def _decisive_nodes(shown: BoolArray) -> Iterator[int]:
    """The nodes that show the most, one by one, of what (nodes, designs) show."""
    for _ in range(PROBE_NODES):
        if not shown.any():
            break
        node = int(np.argmax(shown.sum(axis=1)))
        yield node
        shown = shown & ~shown[node]


def _exceeds_constraint(constraint: Constraint, side: float, values: FloatArray, designs: Designs) -> Any:
    """Which values of the curve of a constraint are clearly beyond its bound."""
    allowed = constraint.upper_bound()
    room = BROKEN_BEYOND * (abs(allowed) or constraint.unit(designs))
    return side * constraint.factor(designs) * values > allowed + room


def with_extremes(
    case: EvaluationBlock, constraints: Sequence[Constraint], apart: Iterable[Variant]
) -> KnownExtremes:
    """What is known of designs, with the extremes of the curve of some constraints that these are about.

    Kinds of piece that curves ``apart`` tell apart are asked apart.
    """
    curve = constraints[0].curve
    questions = _extreme_questions(case, constraints, [kinds for make, kinds in apart if make is curve])
    return case.known_extremes.with_extremes(curve, questions, case.extremes(curve, questions))


def _extreme_questions(
    case: EvaluationBlock, constraints: Sequence[Constraint], apart: Sequence[int]
) -> list[Question]:
    """As few questions as tell of each constraint: one about all kinds of piece that none of them tells apart."""
    found: dict[tuple[int, ...], int] = {}
    for goal in dict.fromkeys(constraint.goal for constraint in constraints):
        about = [constraint.kinds for constraint in constraints if constraint.goal == goal]
        for bit in _powers_of_two(reduce(or_, about) & case.programme.kinds):
            same = (goal, *(bool(bit & kinds) for kinds in (*about, *apart)))
            found[same] = found.get(same, 0) | bit
    return [(kinds, goal) for (goal, *_), kinds in found.items()]


def _powers_of_two(number: int) -> Iterator[int]:
    """The powers of two of which a number is the sum."""
    while number:
        yield number & -number
        number &= number - 1


def holds_by_extremes(
    known: KnownExtremes, constraints: Iterable[Constraint], case: EvaluationBlock
) -> tuple[BoolArray, BoolArray]:
    """Which designs may hold some constraints by what is known of their curves, and which do for certain."""
    possible, held = np.ones((2, len(case.designs)), dtype=bool)
    for constraint in constraints:
        kinds, allowed = constraint.kinds & case.programme.kinds, constraint.upper_bound()
        room = CLEAR_SHARE * abs(allowed) or CLEAR_SHARE * constraint.unit(case.designs)
        parts = known.known_parts(constraint.curve, (kinds, constraint.goal)) if kinds else []
        assert bool(parts) == bool(kinds)
        for found in parts:
            near = -found.value if constraint.goal == LEAST else found.value
            possible &= near <= allowed + room
            held &= near + found.width <= allowed - room
    return possible, held


@dataclass(frozen=True)
class Candidates:
    """Designs that hold every limit that was asked so far, or may."""

    problem: Problem
    designs: Designs
    which: IndexArray
    """Their numbers among those that there were."""
    rows: DesignRows
    held: BoolArray
    """Which of them hold those limits for certain."""
    pending: tuple[Limit, ...]
    """The limits that were not asked yet."""
    known: KnownExtremes = NOTHING_KNOWN
    """Extremes of their curves that were searched for limits."""

    @property
    def case(self) -> EvaluationBlock:
        """The block that they are."""
        return EvaluationBlock(self.problem.setup, self.problem.programme, self.designs, known_extremes=self.known)

    def plan(self, wanted: frozenset[str]) -> list[tuple[Effect, frozenset[str]]]:
        """The effects that find what is wanted, and what the limits need that were not asked yet."""
        return effect_plan(wanted | quantities_of_limits(self.pending), self.problem.setup)

    def take(self, index: IndexArray) -> "Candidates":
        """Some of them."""
        return replace(
            self,
            designs=self.designs.take(index),
            which=self.which[index],
            rows=self.rows.take(index),
            held=self.held[index],
            known=self.known.take(index),
        )

    @property
    def pending_constraints(self) -> list[Constraint]:
        """What the limits that were not asked yet say of curves."""
        return [constraint for limit in self.pending for constraint in limit.constraints]

    def drop_refuted(self, constraints: Sequence[Constraint]) -> "Candidates":
        """Those of which no single cam angle shows that they break a constraint."""
        return self.keep_possible(~designs_breaking_constraints(self.case, constraints)) if constraints else self

    def filter_with_rows(self, rows: DesignRows) -> "Candidates":
        """Adds quantities, and drops designs that now surely break a limit."""
        if rows is self.rows:
            return self
        ready = tuple(limit for limit in self.pending if rows.columns.keys() >= set(limit.required_quantities))
        pending = tuple(limit for limit in self.pending if limit not in ready)
        left = replace(self, rows=rows, pending=pending)
        if not ready:
            return left
        left = left.keep_possible(left._holds_limits(ready, -1.0))
        return replace(left, held=left.held & left._holds_limits(ready, 1.0))

    def keep_possible(self, possible: BoolArray) -> "Candidates":
        """Those that are possible still."""
        return self if possible.all() else self.take(np.flatnonzero(possible))

    def filter_by_constraints(self, constraints: list[Constraint], wanted: frozenset[str]) -> "Candidates":
        """Drops designs that surely break a constraint, of some on one curve; the extremes of that are known then.

        They are asked so that those of quantities which are ``wanted`` are known, too.
        """
        asked = (name for _, names in self.plan(wanted) for name in names)
        peaks = (peak for name in asked for peak in peaks_of_quantity(name, self.problem.setup))
        known = with_extremes(self.case, constraints, [variant for peak in peaks for variant in peak.curves])
        possible, held = holds_by_extremes(known, constraints, self.case)
        return replace(self, known=known, held=self.held & held).keep_possible(possible)

    def _holds_limits(self, limits: tuple[Limit, ...], side: float) -> BoolArray:
        """Which of them hold some limits on a side of their enclosures: 1 for the far one."""
        columns = self.rows.select_columns(quantities_of_limits(limits)).shifted_columns(side)
        held = (np.asarray(limit.excess(columns, self.designs) <= 0.0) for limit in limits)
        return np.broadcast_to(reduce(and_, held), len(self.designs))


def unfiltered_candidates(problem: Problem, designs: Designs) -> Candidates:
    """Designs of which nothing is known yet."""
    count = len(designs)
    held = np.ones(count, dtype=bool)
    return Candidates(problem, designs, np.arange(count), DesignRows({}, count), held, problem.limits)


def feasible_designs(problem: Problem, designs: Designs, *, perhaps: bool = False) -> BoolArray:
    """Which designs can be assembled and are proved to hold every limit, or ``perhaps`` are not shown to break one.

    So do those that have to hold the limits with them (``Problem.all_variants``).
    """
    which, held = np.arange(len(designs)), np.zeros(len(designs), dtype=bool)
    for own, each in problem.all_variants(designs):
        some = each.take(which)
        exists = np.flatnonzero(own.setup.mechanism.can_assemble(some, own.programme) & (some.size > 0.0))
        found = unfiltered_candidates(own, some.take(exists))
        for effect, names in found.plan(own.required_quantities):
            found = found.filter_with_rows(with_effect(found.rows, found.case, effect, names))
        which = which[exists[found.which if perhaps else found.which[found.held]]]
    held[which] = True
    return held


class FilteredRows(NamedTuple):
    """The feasible ones of some designs: rows, their numbers among those, and what it took."""

    rows: DesignRows
    which: IndexArray
    effort: Effort


def filter_designs(problem: Problem, designs: Designs, wanted: frozenset[str]) -> FilteredRows:
    """The wanted quantities of those designs that hold every limit, with their verdict."""
    candidates = unfiltered_candidates(problem, designs)
    candidates = candidates.drop_refuted(candidates.pending_constraints)
    for effect, names in candidates.plan(wanted):
        candidates = candidates.filter_with_rows(with_pitch_values(candidates.rows, candidates.case, effect, names))
        candidates = candidates.filter_with_rows(
            with_values_beyond_pitch(candidates.rows, candidates.case, effect, names)
        )
    return _with_verdict(candidates, wanted)


def filter_by_pitch(candidates: Candidates, wanted: frozenset[str], later: tuple[Limit, ...] = ()) -> Candidates:
    """Those of some pitch curves, as designs of their own, that hold every limit which they decide, or may.

    Limits that are asked ``later`` call for no quantities here. Those that constraints on their curves decide call
    for none at all.
    """
    later = tuple(limit for limit in candidates.pending if limit in later or not limit.required_quantities)
    decided = candidates.problem.pitch_curve_limits
    rest = (limit for limit in candidates.pending if limit not in later and limit not in decided)
    constraints = merge_stroke_kinds(
        strictest_constraints(constraint for limit in decided for constraint in limit.constraints)
    )
    found = replace(candidates.drop_refuted(constraints), pending=tuple(rest))
    for curve in dict.fromkeys(constraint.curve for constraint in constraints):
        found = found.filter_by_constraints(
            [constraint for constraint in constraints if constraint.curve is curve], wanted
        )
    for effect, names in found.plan(wanted):
        found = found.filter_with_rows(with_curve_values(found.rows, found.case, effect, names))
    return replace(found, pending=(*later, *found.pending))


def filter_beyond_pitch(candidates: Candidates, wanted: frozenset[str]) -> FilteredRows:
    """As ``filter_designs``, of designs of which everything is known that their pitch curves decide."""
    candidates = candidates.drop_refuted(candidates.pending_constraints)
    run = with_effect if candidates.problem.setup.mechanism.profile else with_values_beyond_pitch
    for effect, names in candidates.plan(wanted):
        candidates = candidates.filter_with_rows(run(candidates.rows, candidates.case, effect, names))
    return _with_verdict(candidates, wanted)


def _with_verdict(candidates: Candidates, wanted: frozenset[str]) -> FilteredRows:
    """The rows of candidates that hold all limits; those that may are looked at again."""
    problem, held = candidates.problem, candidates.held
    rows = with_certified_numbers(problem, candidates.designs, candidates.rows).select_columns(wanted)
    verdict = {"feasible": True, "violated": "", "status": proved_status(problem)}
    rows = DesignRows({**rows.columns, "relative_half_width": rows.half_width}, rows.count)
    if held.all():
        return FilteredRows(DesignRows(rows.columns | verdict, rows.count), candidates.which, Effort())
    near, effort = evaluate_with_effort(at_rounding_error(problem), candidates.designs.take(~held), wanted)
    rows, kept = rows.replace_rows(np.flatnonzero(~held), near), held.copy()
    kept[~held] = near.column("feasible")
    rows = rows.take(kept)
    return FilteredRows(
        DesignRows(rows.columns | verdict, rows.count), candidates.which[kept], effort._replace(again=near.count)
    )

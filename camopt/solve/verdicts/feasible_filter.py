"""Filter many designs: keep those that are proved to hold every limit, with their quantities.

Effects run cheapest first, and a design that breaks a limit is dropped before the next effect runs. Constraints on
curves come first. A constraint must hold at every cam angle, so a single angle can refute it, and similar designs
are at their worst near the same angles. So a few designs are evaluated at all nodes of the motion, and then all
designs at the nodes where most of the few break a constraint. The extremes of the curves decide the rest.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import and_, or_
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, BoolArray, FloatArray, IndexArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.piecewise import state_at_node, table_as_columns
from camopt.model.effects import Effect, EvaluationBlock
from camopt.model.effects.known_extremes import NOTHING_KNOWN, KnownExtremes
from camopt.model.effects.peak import CLEAR_SHARE, MotionDerivative, Variant
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import Constraint, merge_constraints_over_stroke_kinds
from camopt.scene.problem.limit import Limit, quantities_of_limits
from camopt.scene.problem.limits import peaks_of_quantity
from camopt.scene.problem.problem import Problem, strictest_constraints, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts.effect_runs import (
    effect_plan,
    with_pitch_curve_values_of_designs,
    with_quantities_of_effect,
    with_values_beyond_pitch_curves,
    with_values_of_distinct_pitch_curves,
)
from camopt.solve.verdicts.limit_verdicts import (
    Effort,
    evaluate_with_verdicts_and_effort,
    sampled_or_certified_status,
    with_inaccurate_numbers_certified,
)

# fewest designs for which probing pays; designs that are probed at all nodes; nodes for each side of a constraint
MANY_DESIGNS, PROBE_DESIGNS, PROBE_NODES = 500, 16, 4
BROKEN_BEYOND = 1e-6  # relative excess that rounding cannot explain


@np.errstate(all="ignore")
def designs_breaking_constraints(case: EvaluationBlock, constraints: Iterable[Constraint]) -> BoolArray:
    """Which designs certainly break one of the constraints. Few designs are not probed."""
    broken, table = np.zeros(len(case.designs), dtype=bool), case.programme.table
    checked = constraints if broken.size > MANY_DESIGNS else ()
    probed = [constraint for constraint in checked if not isinstance(constraint.curve, MotionDerivative)]
    pieces = np.repeat(table.kind, np.diff(table.first_panel) + 1)
    for make_curve in {constraint.curve: None for constraint in probed}:
        curve = make_curve(case.designs, case.programme)
        few = case.designs.take(np.linspace(0, broken.size - 1, PROBE_DESIGNS).astype(int))
        values = curve_value(make_curve(few, case.programme), ..., state_at_node(table_as_columns(table), ...))
        for constraint in (constraint for constraint in probed if constraint.curve is make_curve):
            for side in constraint.side_signs:
                exceeds = _exceeds_constraint(constraint, side, values, few)
                for node in _first_nodes_that_most_designs_exceed(
                    exceeds & (pieces & constraint.kinds != 0)[:, None]
                ):
                    at_node = curve_value(curve, ..., state_at_node(table, node))
                    broken |= _exceeds_constraint(constraint, side, at_node, case.designs)
    return broken


def _first_nodes_that_most_designs_exceed(exceeds: BoolArray) -> Iterator[int]:
    """Nodes at which most designs exceed a constraint, one by one, from flags (nodes, designs)."""
    for _ in range(PROBE_NODES):
        if not exceeds.any():
            break
        node = int(np.argmax(exceeds.sum(axis=1)))
        yield node
        exceeds = exceeds & ~exceeds[node]


def _exceeds_constraint(constraint: Constraint, side: float, values: FloatArray, designs: Designs) -> Any:
    """Which values of a constraint's curve are clearly beyond its bound."""
    allowed = constraint.upper_bound_of_each_side()
    room = BROKEN_BEYOND * (abs(allowed) or constraint.unit(designs))
    return side * constraint.factor(designs) * values > allowed + room


def known_extremes_with_limited_curve(
    case: EvaluationBlock, constraints: Sequence[Constraint], quantity_curve_variants: Iterable[Variant]
) -> KnownExtremes:
    """Known extremes of the designs, with those of the curve of some constraints added by the fewest questions.

    ``quantity_curve_variants`` are curves of quantities with their kinds of piece. Kinds that they
    treat separately have separate questions.
    """
    curve, kinds_by_members = constraints[0].curve, dict[tuple[int, ...], int]()
    separate_kinds = [kinds for make, kinds in quantity_curve_variants if make is curve]
    for goal in dict.fromkeys(constraint.goal for constraint in constraints):
        constrained = [constraint.kinds for constraint in constraints if constraint.goal == goal]
        remaining = reduce(or_, constrained) & case.programme.kinds
        while remaining:
            bit = remaining & -remaining  # the lowest kind; kinds under the same constraints share one question
            members = (goal, *(bool(bit & kinds) for kinds in (*constrained, *separate_kinds)))
            kinds_by_members[members] = kinds_by_members.get(members, 0) | bit
            remaining -= bit
    questions = [(kinds, goal) for (goal, *_), kinds in kinds_by_members.items()]
    return case.known_extremes.with_extremes(curve, questions, case.extremes(curve, questions))


def may_hold_and_holds_by_extremes(
    known_extremes: KnownExtremes, constraints: Iterable[Constraint], case: EvaluationBlock
) -> tuple[BoolArray, BoolArray]:
    """Which designs may hold some constraints by known extremes, and which are proved to hold them."""
    possible, held = np.ones((2, len(case.designs)), dtype=bool)
    for constraint in constraints:
        kinds, allowed = constraint.kinds & case.programme.kinds, constraint.upper_bound_of_each_side()
        room = CLEAR_SHARE * abs(allowed) or CLEAR_SHARE * constraint.unit(case.designs)
        parts = (
            known_extremes.extremes_covering_question(constraint.curve, (kinds, constraint.goal)) if kinds else []
        )
        assert bool(parts) == bool(kinds)
        for extreme in parts:
            near = -extreme.value if constraint.goal == LEAST else extreme.value
            possible &= near <= allowed + room
            held &= near + extreme.width <= allowed - room
    return possible, held


@dataclass(frozen=True)
class Candidates:
    """Designs that hold, or may hold, every limit checked so far."""

    problem: Problem
    designs: Designs
    which: IndexArray
    """Their numbers among the original designs."""
    rows: DesignRows
    held: BoolArray
    """Whether each design is proved to hold the limits checked so far."""
    pending: tuple[Limit, ...]
    """Limits that are not checked yet."""
    known: KnownExtremes = NOTHING_KNOWN
    """Extremes of their curves that limits needed."""

    @property
    def case(self) -> EvaluationBlock:
        """The designs as a block for effects."""
        return EvaluationBlock(self.problem.setup, self.problem.programme, self.designs, known_extremes=self.known)

    def plan_of_pending_effects(self, wanted_quantities: frozenset[str]) -> list[tuple[Effect, frozenset[str]]]:
        """Effects that compute the wanted quantities and those of the pending limits."""
        return effect_plan(wanted_quantities | quantities_of_limits(self.pending), self.problem.setup)

    def take(self, index: IndexArray) -> "Candidates":
        """The candidates at some positions."""
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
        """Constraints on curves of the pending limits."""
        return [constraint for limit in self.pending for constraint in limit.constraints]

    def drop_designs_broken_at_probed_angles(self, constraints: Sequence[Constraint]) -> "Candidates":
        """Drop designs that break a constraint at a probed cam angle."""
        return self.keep_possible(~designs_breaking_constraints(self.case, constraints)) if constraints else self

    def add_rows_and_drop_broken(self, rows: DesignRows) -> "Candidates":
        """Add quantities, and drop designs that now are known to break a limit."""
        if rows is self.rows:
            return self
        ready = tuple(limit for limit in self.pending if rows.columns.keys() >= set(limit.required_quantities))
        candidates = replace(self, rows=rows, pending=tuple(limit for limit in self.pending if limit not in ready))
        if not ready:
            return candidates
        candidates = candidates.keep_possible(candidates._holds_limits(ready, -1.0))
        return replace(candidates, held=candidates.held & candidates._holds_limits(ready, 1.0))

    def keep_possible(self, possible: BoolArray) -> "Candidates":
        """Keep the designs that are still possible."""
        return self if possible.all() else self.take(np.flatnonzero(possible))

    def filter_by_curve_constraints(
        self, constraints: list[Constraint], wanted_quantities: frozenset[str]
    ) -> "Candidates":
        """Drop designs that break one of the constraints on a curve, and keep the extremes of the curve.

        The questions also give the extremes that ``wanted_quantities`` quantities need.
        """
        needed = (name for _, names in self.plan_of_pending_effects(wanted_quantities) for name in names)
        peaks = (peak for name in needed for peak in peaks_of_quantity(name, self.problem.setup))
        known = known_extremes_with_limited_curve(
            self.case, constraints, [variant for peak in peaks for variant in peak.curves]
        )
        possible, held = may_hold_and_holds_by_extremes(known, constraints, self.case)
        return replace(self, known=known, held=self.held & held).keep_possible(possible)

    def _holds_limits(self, limits: tuple[Limit, ...], enclosure_side: float) -> BoolArray:
        """Which designs hold all the limits with the far (1) or near (−1) ends of their enclosures."""
        columns = self.rows.select_columns(quantities_of_limits(limits)).columns_shifted_by_width_share(
            enclosure_side
        )
        held = (np.asarray(limit.excess(columns, self.designs) <= 0.0) for limit in limits)
        return np.broadcast_to(reduce(and_, held), len(self.designs))


def unfiltered_candidates(problem: Problem, designs: Designs) -> Candidates:
    """All designs as candidates, with nothing checked yet."""
    count = len(designs)
    held = np.ones(count, dtype=bool)
    return Candidates(problem, designs, np.arange(count), DesignRows({}, count), held, problem.limits)


def feasible_designs(problem: Problem, designs: Designs, *, include_undecided: bool = False) -> BoolArray:
    """Which designs can be assembled and are proved to hold every limit.

    ``include_undecided``: are not proved to break one.

    All variants of a design must hold the limits (``Problem.nominal_and_error_variants``).
    """
    which, held = np.arange(len(designs)), np.zeros(len(designs), dtype=bool)
    for variant_problem, variants in problem.nominal_and_error_variants(designs):
        remaining = variants.take(which)
        assembles = variant_problem.setup.mechanism.can_assemble(remaining, variant_problem.programme)
        exists = np.flatnonzero(assembles & (remaining.size > 0.0))
        candidates = unfiltered_candidates(variant_problem, remaining.take(exists))
        for effect, names in candidates.plan_of_pending_effects(variant_problem.required_quantities):
            candidates = candidates.add_rows_and_drop_broken(
                with_quantities_of_effect(candidates.rows, candidates.case, effect, names)
            )
        which = which[exists[candidates.which if include_undecided else candidates.which[candidates.held]]]
    held[which] = True
    return held


class FilteredRows(NamedTuple):
    """Feasible designs: their rows, their numbers among all designs, and the effort."""

    rows: DesignRows
    which: IndexArray
    effort: Effort


def filter_designs(problem: Problem, designs: Designs, wanted_quantities: frozenset[str]) -> FilteredRows:
    """Wanted quantities of the designs that hold every limit, with their verdict."""
    candidates = unfiltered_candidates(problem, designs)
    candidates = candidates.drop_designs_broken_at_probed_angles(candidates.pending_constraints)
    for effect, names in candidates.plan_of_pending_effects(wanted_quantities):
        candidates = candidates.add_rows_and_drop_broken(
            with_pitch_curve_values_of_designs(candidates.rows, candidates.case, effect, names)
        )
        candidates = candidates.add_rows_and_drop_broken(
            with_values_beyond_pitch_curves(candidates.rows, candidates.case, effect, names)
        )
    return _feasible_rows_rechecking_undecided(candidates, wanted_quantities)


def filter_by_pitch_curve_limits(
    candidates: Candidates, wanted_quantities: frozenset[str], deferred_limits: tuple[Limit, ...]
) -> Candidates:
    """Filter candidates of one design for each pitch curve by the limits that pitch curves decide.

    Limits in ``deferred_limits`` are checked elsewhere. Limits that constraints on curves decide need no
    quantities.
    """
    deferred_limits = tuple(
        limit for limit in candidates.pending if limit in deferred_limits or not limit.required_quantities
    )
    decided = candidates.problem.pitch_curve_limits
    rest = (limit for limit in candidates.pending if limit not in deferred_limits and limit not in decided)
    constraints = merge_constraints_over_stroke_kinds(
        strictest_constraints(constraint for limit in decided for constraint in limit.constraints)
    )
    filtered = replace(candidates.drop_designs_broken_at_probed_angles(constraints), pending=tuple(rest))
    for curve in dict.fromkeys(constraint.curve for constraint in constraints):
        filtered = filtered.filter_by_curve_constraints(
            [each for each in constraints if each.curve is curve], wanted_quantities
        )
    for effect, names in filtered.plan_of_pending_effects(wanted_quantities):
        filtered = filtered.add_rows_and_drop_broken(
            with_values_of_distinct_pitch_curves(filtered.rows, filtered.case, effect, names)
        )
    return replace(filtered, pending=(*deferred_limits, *filtered.pending))


def filter_by_remaining_limits(candidates: Candidates, wanted_quantities: frozenset[str]) -> FilteredRows:
    """Filter candidates whose pitch curves are already filtered, by all other limits."""
    candidates = candidates.drop_designs_broken_at_probed_angles(candidates.pending_constraints)
    run = (
        with_quantities_of_effect if candidates.problem.setup.mechanism.profile else with_values_beyond_pitch_curves
    )
    for effect, names in candidates.plan_of_pending_effects(wanted_quantities):
        candidates = candidates.add_rows_and_drop_broken(run(candidates.rows, candidates.case, effect, names))
    return _feasible_rows_rechecking_undecided(candidates, wanted_quantities)


def _feasible_rows_rechecking_undecided(candidates: Candidates, wanted_quantities: frozenset[str]) -> FilteredRows:
    """Rows of the candidates that hold all limits; candidates that only may hold them are evaluated again."""
    problem, held = candidates.problem, candidates.held
    rows = with_inaccurate_numbers_certified(problem, candidates.designs, candidates.rows).select_columns(
        wanted_quantities
    )
    verdict = {"feasible": True, "violated": "", "status": sampled_or_certified_status(problem)}
    rows = DesignRows({**rows.columns, "relative_half_width": rows.half_width}, rows.count)
    if held.all():
        return FilteredRows(DesignRows(rows.columns | verdict, rows.count), candidates.which, Effort())
    near, effort = evaluate_with_verdicts_and_effort(
        with_rounding_relative_error(problem), candidates.designs.take(~held), wanted_quantities
    )
    rows, feasible = rows.replace_rows(np.flatnonzero(~held), near), held.copy()
    feasible[~held] = near.column("feasible")
    rows = rows.take(feasible)
    return FilteredRows(
        DesignRows(rows.columns | verdict, rows.count),
        candidates.which[feasible],
        effort._replace(again=near.count),
    )

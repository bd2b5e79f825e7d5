"""Screening: the quantities of those designs of many that hold every limit, with a verdict that is proved.

Effects run cheapest first, and a design that breaks a limit is dropped before the next effect runs. Claims on
curves come first: a claim holds at every cam angle, so any one angle refutes it. Designs that are alike are at
their worst near the same angles. Where nodes of the motion show that most of a few designs break a claim, all
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
from camopt.core.numerics.piecewise import node_motion, of_all_rows
from camopt.model.effects import Case, Effect
from camopt.model.effects.known import NOTHING_KNOWN, KnownExtremes, Question
from camopt.model.effects.peak import CLEAR, Derivative, Variant
from camopt.model.mechanisms import Designs
from camopt.scene.problem.claims import Claim, together
from camopt.scene.problem.limit import Limit, needs_of
from camopt.scene.problem.limits import peaks_of
from camopt.scene.problem.problem import Problem, exactly, strictest
from camopt.scene.problem.rows import Rows
from camopt.solve.verdicts.judging import Effort, evaluate_with_effort, proved_status, with_narrow_numbers
from camopt.solve.verdicts.running import beyond_pitch, extended, of_curves, planned, with_pitch_values

MANY, FEW, NODES = 500, 16, 4  # designs that are worth it, those asked first, and nodes for each side of a claim
BROKEN_BEYOND = 1e-6  # relative, of what is further beyond a bound than rounding


@np.errstate(all="ignore")
def refuted(case: Case, claims: Iterable[Claim]) -> BoolArray:
    """Which designs of a case break one of some claims for certain; of few designs none are asked."""
    found, table = np.zeros(len(case.designs), dtype=bool), case.programme.table
    asked = [each for each in claims if not isinstance(each.curve, Derivative)] if found.size > MANY else []
    pieces = np.repeat(table.kind, np.diff(table.first_panel) + 1)
    for made in {each.curve: None for each in asked}:
        record = made(case.designs, case.programme)
        few = case.designs.take(np.linspace(0, found.size - 1, FEW).astype(int))
        values = value_of(made(few, case.programme), ..., node_motion(of_all_rows(table), ...))
        for claim in (each for each in asked if each.curve is made):
            for side in claim.sides:
                shown = _beyond(claim, side, values, few) & (pieces & claim.kinds != 0)[:, None]
                for node in _telling(shown):
                    found |= _beyond(claim, side, value_of(record, ..., node_motion(table, node)), case.designs)
    return found


def _telling(shown: BoolArray) -> Iterator[int]:
    """The nodes that show the most, one by one, of what (nodes, designs) show."""
    for _ in range(NODES):
        if not shown.any():
            break
        node = int(np.argmax(shown.sum(axis=1)))
        yield node
        shown = shown & ~shown[node]


def _beyond(claim: Claim, side: float, values: FloatArray, designs: Designs) -> Any:
    """Which values of the curve of a claim are clearly beyond its bound."""
    allowed = claim.allowed()
    room = BROKEN_BEYOND * (abs(allowed) or claim.unit(designs))
    return side * claim.factor(designs) * values > allowed + room


def with_extremes(case: Case, claims: Sequence[Claim], apart: Iterable[Variant]) -> KnownExtremes:
    """What is known of designs, with the extremes of the curve of some claims that these are about.

    Kinds of piece that curves ``apart`` tell apart are asked apart.
    """
    curve = claims[0].curve
    questions = _questions(case, claims, [kinds for make, kinds in apart if make is curve])
    return case.known.with_answers(curve, questions, case.extremes(curve, questions))


def _questions(case: Case, claims: Sequence[Claim], apart: Sequence[int]) -> list[Question]:
    """As few questions as tell of each claim: one about all kinds of piece that none of them tells apart."""
    found: dict[tuple[int, ...], int] = {}
    for goal in dict.fromkeys(claim.goal for claim in claims):
        about = [claim.kinds for claim in claims if claim.goal == goal]
        for bit in _bits(reduce(or_, about) & case.programme.kinds):
            same = (goal, *(bool(bit & kinds) for kinds in (*about, *apart)))
            found[same] = found.get(same, 0) | bit
    return [(kinds, goal) for (goal, *_), kinds in found.items()]


def _bits(number: int) -> Iterator[int]:
    """The powers of two of which a number is the sum."""
    while number:
        yield number & -number
        number &= number - 1


def held_by_extremes(known: KnownExtremes, claims: Iterable[Claim], case: Case) -> tuple[BoolArray, BoolArray]:
    """Which designs may hold some claims by what is known of their curves, and which do for certain."""
    possible, held = np.ones((2, len(case.designs)), dtype=bool)
    for claim in claims:
        kinds, allowed = claim.kinds & case.programme.kinds, claim.allowed()
        room = CLEAR * abs(allowed) or CLEAR * claim.unit(case.designs)
        parts = known.parts(claim.curve, (kinds, claim.goal)) if kinds else []
        assert bool(parts) == bool(kinds)
        for found in parts:
            near = -found.value if claim.goal == LEAST else found.value
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
    rows: Rows
    held: BoolArray
    """Which of them hold those limits for certain."""
    pending: tuple[Limit, ...]
    """The limits that were not asked yet."""
    known: KnownExtremes = NOTHING_KNOWN
    """Extremes of their curves that were searched for limits."""

    @property
    def case(self) -> Case:
        """The block that they are."""
        return Case(self.problem.setup, self.problem.programme, self.designs, known=self.known)

    def plan(self, wanted: frozenset[str]) -> list[tuple[Effect, frozenset[str]]]:
        """The effects that find what is wanted, and what the limits need that were not asked yet."""
        return planned(wanted | needs_of(self.pending), self.problem.setup)

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
    def claims(self) -> list[Claim]:
        """What the limits that were not asked yet say of curves."""
        return [claim for limit in self.pending for claim in limit.claims]

    def unrefuted(self, claims: Sequence[Claim]) -> "Candidates":
        """Those of which no single cam angle shows that they break a claim."""
        return self.only(~refuted(self.case, claims)) if claims else self

    def asked(self, rows: Rows) -> "Candidates":
        """Adds quantities, and drops designs that now surely break a limit."""
        if rows is self.rows:
            return self
        ready = tuple(limit for limit in self.pending if rows.columns.keys() >= set(limit.needs))
        pending = tuple(limit for limit in self.pending if limit not in ready)
        left = replace(self, rows=rows, pending=pending)
        if not ready:
            return left
        left = left.only(left._holding(ready, -1.0))
        return replace(left, held=left.held & left._holding(ready, 1.0))

    def only(self, possible: BoolArray) -> "Candidates":
        """Those that are possible still."""
        return self if possible.all() else self.take(np.flatnonzero(possible))

    def within(self, claims: list[Claim], wanted: frozenset[str]) -> "Candidates":
        """Drops designs that surely break a claim, of some on one curve; the extremes of that are known then.

        They are asked so that those of quantities which are ``wanted`` are known, too.
        """
        asked = (name for _, names in self.plan(wanted) for name in names)
        peaks = (peak for name in asked for peak in peaks_of(name, self.problem.setup))
        known = with_extremes(self.case, claims, [variant for peak in peaks for variant in peak.curves])
        possible, held = held_by_extremes(known, claims, self.case)
        return replace(self, known=known, held=self.held & held).only(possible)

    def _holding(self, limits: tuple[Limit, ...], side: float) -> BoolArray:
        """Which of them hold some limits on a side of their enclosures: 1 for the far one."""
        columns = self.rows.only(needs_of(limits)).shifted(side)
        held = (np.asarray(limit.excess(columns, self.designs) <= 0.0) for limit in limits)
        return np.broadcast_to(reduce(and_, held), len(self.designs))


def begun(problem: Problem, designs: Designs) -> Candidates:
    """Designs of which nothing is known yet."""
    count = len(designs)
    held = np.ones(count, dtype=bool)
    return Candidates(problem, designs, np.arange(count), Rows({}, count), held, problem.limits)


def feasible(problem: Problem, designs: Designs, *, perhaps: bool = False) -> BoolArray:
    """Which designs can be assembled and are proved to hold every limit, or ``perhaps`` are not shown to break one.

    So do those that have to hold the limits with them (``Problem.every``).
    """
    which, held = np.arange(len(designs)), np.zeros(len(designs), dtype=bool)
    for own, each in problem.every(designs):
        some = each.take(which)
        exists = np.flatnonzero(own.setup.mechanism.exists(some, own.programme) & (some.size > 0.0))
        found = begun(own, some.take(exists))
        for effect, names in found.plan(own.needed):
            found = found.asked(extended(found.rows, found.case, effect, names))
        which = which[exists[found.which if perhaps else found.which[found.held]]]
    held[which] = True
    return held


class Screened(NamedTuple):
    """The feasible ones of some designs: rows, their numbers among those, and what it took."""

    rows: Rows
    which: IndexArray
    effort: Effort


def screened(problem: Problem, designs: Designs, wanted: frozenset[str]) -> Screened:
    """The wanted quantities of those designs that hold every limit, with their verdict."""
    candidates = begun(problem, designs)
    candidates = candidates.unrefuted(candidates.claims)
    for effect, names in candidates.plan(wanted):
        candidates = candidates.asked(with_pitch_values(candidates.rows, candidates.case, effect, names))
        candidates = candidates.asked(beyond_pitch(candidates.rows, candidates.case, effect, names))
    return _with_verdict(candidates, wanted)


def screened_by_pitch(candidates: Candidates, wanted: frozenset[str], later: tuple[Limit, ...] = ()) -> Candidates:
    """Those of some pitch curves, as designs of their own, that hold every limit which they decide, or may.

    Limits that are asked ``later`` call for no quantities here. Those that claims on their curves decide call for
    none at all.
    """
    later = tuple(limit for limit in candidates.pending if limit in later or not limit.needs)
    decided = candidates.problem.limits_of_pitch
    rest = (limit for limit in candidates.pending if limit not in later and limit not in decided)
    claims = together(strictest(claim for limit in decided for claim in limit.claims))
    found = replace(candidates.unrefuted(claims), pending=tuple(rest))
    for curve in dict.fromkeys(claim.curve for claim in claims):
        found = found.within([claim for claim in claims if claim.curve is curve], wanted)
    for effect, names in found.plan(wanted):
        found = found.asked(of_curves(found.rows, found.case, effect, names))
    return replace(found, pending=(*later, *found.pending))


def screened_beyond_pitch(candidates: Candidates, wanted: frozenset[str]) -> Screened:
    """As ``screened``, of designs of which everything is known that their pitch curves decide."""
    candidates = candidates.unrefuted(candidates.claims)
    run = extended if candidates.problem.setup.mechanism.profile else beyond_pitch
    for effect, names in candidates.plan(wanted):
        candidates = candidates.asked(run(candidates.rows, candidates.case, effect, names))
    return _with_verdict(candidates, wanted)


def _with_verdict(candidates: Candidates, wanted: frozenset[str]) -> Screened:
    """The rows of candidates that hold all limits; those that may are looked at again."""
    problem, held = candidates.problem, candidates.held
    rows = with_narrow_numbers(problem, candidates.designs, candidates.rows).only(wanted)
    verdict = {"feasible": True, "violated": "", "status": proved_status(problem)}
    rows = Rows({**rows.columns, "relative_half_width": rows.half_width}, rows.count)
    if held.all():
        return Screened(Rows(rows.columns | verdict, rows.count), candidates.which, Effort())
    near, effort = evaluate_with_effort(exactly(problem), candidates.designs.take(~held), wanted)
    rows, kept = rows.with_rows(np.flatnonzero(~held), near), held.copy()
    kept[~held] = near.column("feasible")
    rows = rows.take(kept)
    return Screened(
        Rows(rows.columns | verdict, rows.count), candidates.which[kept], effort._replace(again=near.count)
    )

"""Whether every cam whose train is within tolerances holds a limit: each has a follower's motion of its own.

The tool moves as it is asked, whatever the train, so that over a part of its turn it is a range whose slopes by the
cam angle are its derivatives. The formulas of the links take it back to the followers of all trains of a box
(``smallest.driven_boxes``): the motions of all cams, with slopes by the cam angle and by each link. From there on
it is the bisection of ``verdicts.claim_boxes``.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from camopt.effects.peak import Derivative
from camopt.mechanisms import Designs
from camopt.motion.driven import travel
from camopt.motion.programme import Programme
from camopt.motion.table import turned_kinds, way_of
from camopt.motion.train_load import TrainLoad
from camopt.numerics import FloatArray, IntArray
from camopt.numerics.curves import curve
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Placed, Quotient, Sloped, as_quotient, as_sloped, range_of, variables
from camopt.problem.claims import Claim
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.smallest.driven_boxes import Driven, driven_at
from camopt.verdicts.claim_boxes import Answer, Ends, Parts, Search, excess_of, state_over
from camopt.verdicts.words import BROKEN, HELD, UNDECIDED

MOST_ORDER = 2
"""Of a derivative of the follower's motion that is known over boxes."""


def limit_over_trains(problem: Problem, limit: Limit, ends: Ends, until: float = inf) -> Answer:
    """Whether all designs between ends, with the numbers of trains among them, hold a limit."""
    claims = [*((each, False) for each in limit.claims), *((each, True) for each in limit.of_train)]
    if not claims or limit.mean is not None or problem.programme.given_at_follower:
        return Answer(UNDECIDED)
    found = [_over(problem, claim, ends, until, of_train) for claim, of_train in claims]
    broken = [each for each in found if each.verdict == BROKEN]
    return broken[0] if broken else Answer(HELD if all(each.verdict == HELD for each in found) else UNDECIDED)


def _with_load(problem: Problem, claim: Claim) -> Problem | None:
    """The problem with the load that a claim is about; None of one that changes over the turn, as few are known."""
    load, mechanism = problem.programme.load, problem.setup.mechanism
    if claim.curve in (*mechanism.of_pitch, mechanism.profile_radius, mechanism.outline):
        return replace(problem, programme=replace(problem.programme, load=None))
    changes = load.loads if isinstance(load, TrainLoad) else load
    return None if changes else problem


def _over(problem: Problem, claim: Claim, ends: Ends, until: float, of_train: bool) -> Answer:
    made: Any = claim.curve
    if not problem.programme.has(claim.kinds):
        return Answer(HELD)
    if isinstance(made, Derivative) and not (made.at_follower and made.order <= MOST_ORDER):
        return Answer(UNDECIDED)
    if (known := _with_load(problem, claim)) is None:
        return Answer(UNDECIDED)
    search = TrainSearch(known, claim, problem.design, tuple(ends), until, of_train)
    return search.run(search.first(ends))


@dataclass(frozen=True)
class TrainSearch(Search):
    """The search for a cam with a train of a box that breaks a claim."""

    of_train: bool = False
    """Whether the claim is on a curve of the train."""

    @cached_property
    def sense(self) -> float:
        """Which way the follower goes if the tool goes up."""
        assert self.problem.setup.train is not None
        return float(self.problem.setup.train.senses[-1])

    @cached_property
    def tool(self) -> Programme:
        """The motion that is asked."""
        return self.problem.programme.tool

    @cached_property
    def kinds(self) -> IntArray:
        """The kind of each panel of the tool's motion."""
        return np.repeat(self.tool.table.kind, np.diff(self.tool.table.first_panel))

    def first(self, ends: Ends) -> Parts:
        """Whole panels of the tool's motion where the follower's is of the kinds of the claim, with the box."""
        own = self.kinds if self.sense > 0.0 else turned_kinds(self.kinds)
        return Parts.of(np.flatnonzero(own & self.claim.kinds), self.claim, ends)

    def excess(self, parts: Parts) -> Sloped:
        middle = (parts.low + parts.high) / 2.0
        half = self.tool.table.half_width[parts.panel]
        place = Interval(parts.low[0] * half, parts.high[0] * half)
        sides = [place, *(Interval(low, high) for low, high in zip(parts.low[1:], parts.high[1:], strict=True))]
        angle, *numbers = variables(sides, [middle[0] * half, *middle[1:]])
        designs = self.design.take(np.zeros(parts.size, dtype=int))
        designs = designs.with_values(dict(zip(self.names, numbers, strict=True)))
        driven, radicands = self._driven(parts, middle[0], angle, designs)
        claim: Any = self.claim
        if self.of_train:
            value = claim.curve(designs, driven.links)
        elif isinstance(claim.curve, Derivative):
            value = driven.state[claim.curve.order]
        else:
            value, _ = curve(claim.curve(designs, driven), ..., driven.state)
        whole = value.divided() if isinstance(value, Quotient) else value
        found = as_sloped(excess_of(claim, parts.side, as_quotient(whole), designs), angle)
        return self._where_assembled(found, driven, designs, radicands)

    def _driven(self, parts: Parts, u: FloatArray, angle: Sloped, designs: Designs) -> tuple[Driven, list[Sloped]]:
        """The motion of the followers of parts, and what has to be above 0 for that."""
        radicands, zero = list[Sloped](), travel(self.problem.programme)[0] - self.tool.levels[0]
        tool: Any = state_over(self.tool.table, parts.panel, u, angle)
        moving: Any = tool.y + zero, tool.y1, tool.y2
        motion = [Placed.of(each, radicands) for each in moving]
        own: dict[str, Any] = {key: each for key, each in designs.numbers.items() if is_of_train(key)}
        trains = {key: Placed.of(each, radicands) for key, each in own.items()}
        ways = way_of(self.kinds[parts.panel])
        return driven_at(self.problem, designs.with_values(trains), np.empty(0), motion, ways), radicands

    def _where_assembled(self, excess: Sloped, driven: Driven, designs: Designs, radicands: list[Sloped]) -> Sloped:
        """An excess that is not known where some train or cam cannot be put together, or goes the other way."""
        known = driven.sense == self.sense
        margins = self.problem.setup.mechanism.assembly_margins(designs, driven)  # type: ignore[arg-type]
        for each in (*margins, *radicands):
            known = known & (as_interval(range_of(each)).low > 0.0)
        high, low = np.where(known, excess.value.high, inf), np.where(known, excess.at.low, -inf)
        slopes = Interval(np.where(known, excess.slopes.low, -inf), np.where(known, excess.slopes.high, inf))
        value, at = Interval(excess.value.low, high), Interval(low, np.maximum(excess.at.high, low))
        return Sloped(value, at, slopes, excess.span)

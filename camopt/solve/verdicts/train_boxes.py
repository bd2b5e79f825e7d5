"""Whether every cam whose train is within tolerances holds a limit: each has a follower's motion of its own.

The tool moves as it is asked, whatever the train, so that over a part of its turn it is a range whose slopes by the
cam angle are its derivatives. The formulas of the links take it back to the followers of all trains of a box
(``verdicts.driven_boxes``): the motions of all cams, with slopes by the cam angle and by each link. From there on
it is the bisection of ``verdicts.claim_boxes``.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import UNIT, FloatArray, IntArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.loading import ANGLE_ERRORS, LOAD_ERRORS
from camopt.core.numerics.sloped import Placed, Quotient, Sloped, as_quotient, as_sloped, range_of, variables
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.driven import travel
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import turned_kinds, way_of
from camopt.scene.problem.claims import Claim
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_of_train
from camopt.solve.verdicts.claim_boxes import Answer, Ends, Parts, Search, excess_of, state_over
from camopt.solve.verdicts.driven_boxes import Driven, LoadAt, driven_at
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED

MOST_ORDER = 2
"""Of a derivative of the follower's motion that is known over boxes."""


def enters_train(problem: Problem, limit: Limit) -> bool:
    """Whether trains that are off change a limit: not one on the motion that is asked of the tool, or the bore."""
    curves = [each.curve for each in limit.claims]
    if limit.mean is not None:
        curves += [make for make, _ in limit.mean.mean.curves]
    asked = bool(curves) and not problem.programme.given_at_follower
    return not (limit.of_base or (asked and all(map(_of_tool, curves))))


def _of_tool(made: Any) -> bool:
    """Whether a curve is a derivative of the motion of the tool."""
    return isinstance(made, Derivative) and not made.at_follower


def limit_over_trains(problem: Problem, limit: Limit, design: Designs, ends: Ends, until: float = inf) -> Answer:
    """Whether all designs between ends, with the numbers of trains among them, hold a limit."""
    claims = [*((each, False) for each in limit.claims), *((each, True) for each in limit.of_train)]
    if not claims or limit.mean is not None or problem.programme.given_at_follower:
        return Answer(UNDECIDED)
    found = [claim_over_trains(problem, claim, design, ends, until, of_train) for claim, of_train in claims]
    broken = [each for each in found if each.verdict == BROKEN]
    return broken[0] if broken else Answer(HELD if all(each.verdict == HELD for each in found) else UNDECIDED)


def _with_load(problem: Problem, claim: Claim) -> Problem:
    """The problem with the load that a claim is about."""
    mechanism = problem.setup.mechanism
    if claim.curve in (*mechanism.of_pitch, mechanism.profile_radius, mechanism.outline):
        return replace(problem, programme=replace(problem.programme, load=None))
    return problem


def claim_over_trains(
    problem: Problem, claim: Claim, design: Designs, ends: Ends, until: float, of_train: bool = False
) -> Answer:
    """Whether all of these designs hold a claim, on a curve of the cam or of its train."""
    made: Any = claim.curve
    if not problem.programme.has(claim.kinds):
        return Answer(HELD)
    if isinstance(made, Derivative) and not (made.at_follower and made.order <= MOST_ORDER):
        return Answer(UNDECIDED)
    search = TrainSearch(_with_load(problem, claim), claim, design, tuple(ends), until, of_train)
    return search.run(search.first(ends))


def motion_over_trains(problem: Problem, claim: Claim, design: Designs, ends: Ends) -> Driven | None:
    """The motion of all followers of a box, with the range of their lifts; None if some are not assembled."""
    search = TrainSearch(problem, claim, design, tuple(ends), inf)
    return search.over(search.first(ends).take([0])).whole


class Known(NamedTuple):
    """The motion of the followers of parts of a box."""

    driven: Driven
    designs: Designs
    angle: Sloped
    assembled: Any
    """Of which parts every train and cam can be put together, and moves the same way."""

    @property
    def whole(self) -> Driven | None:
        """With lifts as ranges; None if some are not assembled."""
        lift = range_of(self.driven.lift)
        return replace(self.driven, lift=lift) if np.all(self.assembled) else None


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
        parts, table = Parts.of(np.flatnonzero(own & self.claim.kinds), self.claim, ends), self.tool.table
        centre, half = table.centre[parts.panel], table.half_width[parts.panel]
        for corner in self.corners:
            parts = parts.parted((np.mod(corner - centre + np.pi, 2.0 * np.pi) - np.pi) / half)
            centre, half = table.centre[parts.panel], table.half_width[parts.panel]
        return parts

    @property
    def corners(self) -> tuple[float, ...]:
        """The cam angles between which loads go straight."""
        load = self.problem.programme.load
        return () if load is None else load.angles

    def loaded(self, parts: Parts, u: FloatArray, angle: Sloped) -> LoadAt:
        """What loads are over parts, which have no corner of them inside."""
        table = self.tool.table
        place = u * table.half_width[parts.panel]

        def at(load: ExternalLoad) -> tuple[Any, Any]:
            value, slope = load.at(table.centre[parts.panel] + place)
            error = UNIT * (LOAD_ERRORS * load.largest + ANGLE_ERRORS * np.abs(slope))
            straight = Interval(value - slope * place - error, value - slope * place + error)
            return Placed.of(angle * slope + straight, []), slope

        return at

    def excess(self, parts: Parts) -> Sloped:
        found, claim = self.over(parts), self.claim
        made: Any = claim.curve
        if self.of_train:
            value = made(found.designs, found.driven.links)
        elif isinstance(made, Derivative):
            value = found.driven.state[made.order]
        else:
            value = value_of(made(found.designs, found.driven), ..., found.driven.state)
        whole = value.divided() if isinstance(value, Quotient) else value
        excess = as_sloped(excess_of(claim, parts.side, as_quotient(whole), found.designs), found.angle)
        return where_known(found.assembled, excess)

    def over(self, parts: Parts) -> Known:
        """The motion over parts."""
        middle = (parts.low + parts.high) / 2.0
        half = self.tool.table.half_width[parts.panel]
        place = Interval(parts.low[0] * half, parts.high[0] * half)
        sides = [place, *(Interval(low, high) for low, high in zip(parts.low[1:], parts.high[1:], strict=True))]
        angle, *numbers = variables(sides, [middle[0] * half, *middle[1:]])
        designs = self.design.take(np.zeros(parts.size, dtype=int))
        designs = designs.with_values(dict(zip(self.names, numbers, strict=True)))
        radicands, zero = list[Sloped](), travel(self.problem.programme)[0] - self.tool.levels[0]
        tool: Any = state_over(self.tool.table, parts.panel, middle[0], angle)
        moving: Any = tool.y + zero, tool.y1, tool.y2
        motion = [Placed.of(each, radicands) for each in moving]
        own: dict[str, Any] = {key: each for key, each in designs.numbers.items() if is_of_train(key)}
        trains = {key: Placed.of(each, radicands) for key, each in own.items()}
        ways = way_of(self.kinds[parts.panel])
        loads = self.loaded(parts, middle[0], angle)
        driven = driven_at(self.problem, designs.with_values(trains), loads, motion, ways)
        margins = self.problem.setup.mechanism.assembly_margins(designs, driven)  # type: ignore[arg-type]
        assembled = driven.sense == self.sense
        for each in (*margins, *radicands):
            assembled = assembled & (as_interval(range_of(each)).low > 0.0)
        return Known(driven, designs, angle, assembled)


def where_known(known: Any, excess: Sloped) -> Sloped:
    """An excess that is not known elsewhere: where some train or cam is not assembled, or goes the other way."""
    high, low = np.where(known, excess.value.high, inf), np.where(known, excess.at.low, -inf)
    slopes = Interval(np.where(known, excess.slopes.low, -inf), np.where(known, excess.slopes.high, inf))
    value, at = Interval(excess.value.low, high), Interval(low, np.maximum(excess.at.high, low))
    return Sloped(value, at, slopes, excess.span)

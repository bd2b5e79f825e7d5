"""Whether every cam whose train is within tolerances holds a limit: each has a follower's motion of its own.

The tool moves as it is asked, whatever the train, so that over a part of its turn it is a range whose slopes by the
cam angle are its derivatives. The formulas of the links take it back to the followers of all trains of a box
(``verdicts.driven_boxes``): the motions of all cams, with slopes by the cam angle and by each link. From there on
it is the bisection of ``verdicts.constraint_boxes``.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray, IntArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.load_tables import ANGLE_ERRORS, LOAD_ERRORS
from camopt.core.numerics.sloped_interval import (
    LinkageInterval,
    Quotient,
    SlopedInterval,
    as_quotient,
    as_sloped_interval,
    box_variables,
    range_of,
)
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import motion_ways, reversed_kinds
from camopt.model.motion.tool_drive import tool_travel
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key
from camopt.solve.verdicts.constraint_boxes import (
    BoxParts,
    BoxVerdict,
    ConstraintSearch,
    NumberRanges,
    excess_of,
    state_over,
)
from camopt.solve.verdicts.driven_boxes import DrivenMotion, LoadAt, driven_motion
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

MOST_ORDER = 2
"""Of a derivative of the follower's motion that is known over boxes."""


def depends_on_train(problem: Problem, limit: Limit) -> bool:
    """Whether trains that are off change a limit: not one on the motion that is asked of the tool, or the bore."""
    curves = [each.curve for each in limit.constraints]
    if limit.mean_constraint is not None:
        curves += [make for make, _ in limit.mean_constraint.mean.curves]
    asked = bool(curves) and not problem.programme.given_at_follower
    return not (limit.is_on_base_circle or (asked and all(map(_is_tool_derivative, curves))))


def _is_tool_derivative(made: Any) -> bool:
    """Whether a curve is a derivative of the motion of the tool."""
    return isinstance(made, Derivative) and not made.at_follower


def limit_over_trains(
    problem: Problem, limit: Limit, design: Designs, ends: NumberRanges, until: float = inf
) -> BoxVerdict:
    """Whether all designs between ends, with the numbers of trains among them, hold a limit."""
    constraints = [
        *((each, False) for each in limit.constraints),
        *((each, True) for each in limit.train_constraints),
    ]
    if not constraints or limit.mean_constraint is not None or problem.programme.given_at_follower:
        return BoxVerdict(UNDECIDED)
    found = [
        constraint_over_trains(problem, constraint, design, ends, until, of_train)
        for constraint, of_train in constraints
    ]
    broken = [each for each in found if each.verdict == BROKEN]
    return broken[0] if broken else BoxVerdict(HELD if all(each.verdict == HELD for each in found) else UNDECIDED)


def _with_load(problem: Problem, constraint: Constraint) -> Problem:
    """The problem with the load that a constraint is about."""
    mechanism = problem.setup.mechanism
    if constraint.curve in (*mechanism.pitch_curves, mechanism.profile_radius, mechanism.outline):
        return replace(problem, programme=replace(problem.programme, load=None))
    return problem


def constraint_over_trains(
    problem: Problem,
    constraint: Constraint,
    design: Designs,
    ends: NumberRanges,
    until: float,
    of_train: bool = False,
) -> BoxVerdict:
    """Whether all of these designs hold a constraint, on a curve of the cam or of its train."""
    made: Any = constraint.curve
    if not problem.programme.has_kinds(constraint.kinds):
        return BoxVerdict(HELD)
    if isinstance(made, Derivative) and not (made.at_follower and made.order <= MOST_ORDER):
        return BoxVerdict(UNDECIDED)
    search = TrainConstraintSearch(
        _with_load(problem, constraint), constraint, design, tuple(ends), until, of_train
    )
    return search.run(search.whole_panels(ends))


def motion_over_trains(
    problem: Problem, constraint: Constraint, design: Designs, ends: NumberRanges
) -> DrivenMotion | None:
    """The motion of all followers of a box, with the range of their lifts; None if some are not assembled."""
    search = TrainConstraintSearch(problem, constraint, design, tuple(ends), inf)
    return search.motion_over(search.whole_panels(ends).take([0])).driven_with_lift_range


class BoxMotion(NamedTuple):
    """The motion of the followers of parts of a box."""

    driven: DrivenMotion
    designs: Designs
    angle: SlopedInterval
    assembled: Any
    """Of which parts every train and cam can be put together, and moves the same way."""

    @property
    def driven_with_lift_range(self) -> DrivenMotion | None:
        """With lifts as ranges; None if some are not assembled."""
        lift = range_of(self.driven.lift)
        return replace(self.driven, lift=lift) if np.all(self.assembled) else None


@dataclass(frozen=True)
class TrainConstraintSearch(ConstraintSearch):
    """The search for a cam with a train of a box that breaks a constraint."""

    of_train: bool = False
    """Whether the constraint is on a curve of the train."""

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

    def whole_panels(self, ends: NumberRanges) -> BoxParts:
        """Whole panels of the tool's motion on the strokes that the constraint is about, with the box."""
        own = self.kinds if self.sense > 0.0 else reversed_kinds(self.kinds)
        parts, table = (
            BoxParts.from_panels(np.flatnonzero(own & self.constraint.kinds), self.constraint, ends),
            self.tool.table,
        )
        centre, half = table.centre[parts.panel], table.half_width[parts.panel]
        for corner in self.corners:
            parts = parts.split_at_place((np.mod(corner - centre + np.pi, 2.0 * np.pi) - np.pi) / half)
            centre, half = table.centre[parts.panel], table.half_width[parts.panel]
        return parts

    @property
    def corners(self) -> tuple[float, ...]:
        """The cam angles between which loads go straight."""
        load = self.problem.programme.load
        return () if load is None else load.angles

    def loads_over(self, parts: BoxParts, u: FloatArray, angle: SlopedInterval) -> LoadAt:
        """What loads are over parts, which have no corner of them inside."""
        table = self.tool.table
        place = u * table.half_width[parts.panel]

        def load_over_parts(load: ExternalLoad) -> tuple[Any, Any]:
            value, slope = load.load_and_slope(table.centre[parts.panel] + place)
            error = UNIT_ROUNDOFF * (LOAD_ERRORS * load.largest + ANGLE_ERRORS * np.abs(slope))
            straight = Interval(value - slope * place - error, value - slope * place + error)
            return LinkageInterval.from_interval(angle * slope + straight, []), slope

        return load_over_parts

    def excess(self, parts: BoxParts) -> SlopedInterval:
        found, constraint = self.motion_over(parts), self.constraint
        made: Any = constraint.curve
        if self.of_train:
            value = made(found.designs, found.driven.links)
        elif isinstance(made, Derivative):
            value = found.driven.state[made.order]
        else:
            value = value_of(made(found.designs, found.driven), ..., found.driven.state)
        whole = value.divide() if isinstance(value, Quotient) else value
        excess = as_sloped_interval(
            excess_of(constraint, parts.side, as_quotient(whole), found.designs), found.angle
        )
        return restrict_to_assembled(found.assembled, excess)

    def motion_over(self, parts: BoxParts) -> BoxMotion:
        """The motion over parts."""
        middle = (parts.low + parts.high) / 2.0
        half = self.tool.table.half_width[parts.panel]
        place = Interval(parts.low[0] * half, parts.high[0] * half)
        sides = [place, *(Interval(low, high) for low, high in zip(parts.low[1:], parts.high[1:], strict=True))]
        angle, *numbers = box_variables(sides, [middle[0] * half, *middle[1:]])
        designs = self.design.take(np.zeros(parts.size, dtype=int))
        designs = designs.with_values(dict(zip(self.names, numbers, strict=True)))
        radicands, zero = list[SlopedInterval](), tool_travel(self.problem.programme)[0] - self.tool.levels[0]
        tool: Any = state_over(self.tool.table, parts.panel, middle[0], angle)
        moving: Any = tool.y + zero, tool.y1, tool.y2
        motion = [LinkageInterval.from_interval(each, radicands) for each in moving]
        own: dict[str, Any] = {key: each for key, each in designs.numbers.items() if is_train_key(key)}
        trains = {key: LinkageInterval.from_interval(each, radicands) for key, each in own.items()}
        ways = motion_ways(self.kinds[parts.panel])
        loads = self.loads_over(parts, middle[0], angle)
        driven = driven_motion(self.problem, designs.with_values(trains), loads, motion, ways)
        margins = self.problem.setup.mechanism.assembly_margins(designs, driven)  # type: ignore[arg-type]
        assembled = driven.sense == self.sense
        for each in (*margins, *radicands):
            assembled = assembled & (as_interval(range_of(each)).low > 0.0)
        return BoxMotion(driven, designs, angle, assembled)


def restrict_to_assembled(known: Any, excess: SlopedInterval) -> SlopedInterval:
    """An excess that is not known elsewhere: where some train or cam is not assembled, or goes the other way."""
    high, low = np.where(known, excess.value.high, inf), np.where(known, excess.at.low, -inf)
    slopes = Interval(np.where(known, excess.slopes.low, -inf), np.where(known, excess.slopes.high, inf))
    value, at = Interval(excess.value.low, high), Interval(low, np.maximum(excess.at.high, low))
    return SlopedInterval(value, at, slopes, excess.span)

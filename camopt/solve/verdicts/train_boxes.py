"""Verdict on a limit for all cams whose trains are within a box; each train gives its follower another motion.

The tool moves as the scene asks, whatever the train. Over a part of the turn its motion is a range, and the slopes
by the cam angle are its derivatives. The formulas of the links convert it to the motions of the followers of all
trains of a box (``verdicts.driven_boxes``), with slopes by the cam angle and by each number. The rest is the
bisection of ``verdicts.constraint_boxes``.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import UNIT_ROUNDOFF, Curve, FloatArray, IntArray, Number
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.load_tables import ANGLE_ERRORS, LOAD_ERRORS
from camopt.core.numerics.sloped_interval import (
    LinkageInterval,
    Quotient,
    SlopedInterval,
    as_quotient,
    as_sloped_interval,
    range_of,
)
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import motion_directions, reversed_kinds
from camopt.model.motion.tool_drive import tool_travel_range
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key
from camopt.solve.verdicts.constraint_boxes import (
    BoxParts,
    BoxVerdict,
    ConstraintSearch,
    NumberRanges,
    enclose_state,
    relative_excess,
    verdict_on_alternatives,
)
from camopt.solve.verdicts.driven_boxes import DrivenMotion, LoadAt, motion_of_driven_followers
from camopt.solve.verdicts.verdict_words import HELD, UNDECIDED, WORST_FIRST

MOST_ORDER = 2
"""Highest derivative of the follower's motion that is known over boxes."""


def depends_on_train_errors(problem: Problem, limit: Limit) -> bool:
    """Whether a limit depends on the train's errors; limits on the tool's motion and on the bore do not."""
    curves = [constraint.curve for constraint in limit.constraints]
    if limit.mean_constraint is not None:
        curves += [make for make, _ in limit.mean_constraint.mean.curves]
    at_tool = bool(curves) and not problem.programme.given_at_follower
    return not (limit.is_on_base_circle or (at_tool and all(map(is_tool_derivative, curves))))


def is_tool_derivative(curve: Curve) -> bool:
    """Whether a curve is a derivative of the tool's motion."""
    return isinstance(curve, MotionDerivative) and not curve.at_follower


def limit_verdict_over_trains(
    problem: Problem, limit: Limit, design: Designs, number_ranges: NumberRanges, budget: Budget
) -> BoxVerdict:
    """Verdict on a limit for all designs and trains whose numbers lie between ``number_ranges``."""
    if (
        not (limit.constraints or limit.train_constraints)
        or limit.mean_constraint is not None
        or problem.programme.given_at_follower
    ):
        return BoxVerdict(UNDECIDED)

    def decide(constraint: Constraint, ranges: NumberRanges, is_on_train_curve: bool = False) -> BoxVerdict:
        return constraint_verdict_over_trains(problem, constraint, design, ranges, budget, is_on_train_curve)

    verdicts = [
        *(decide(constraint, number_ranges) for constraint in limit.constraints),
        *(decide(constraint, number_ranges, is_on_train_curve=True) for constraint in limit.train_constraints),
        *(verdict_on_alternatives(decide, condition, number_ranges) for condition in limit.contact_conditions),
    ]
    return min(verdicts, key=lambda each: WORST_FIRST.index(each.verdict))


def constraint_verdict_over_trains(
    problem: Problem,
    constraint: Constraint,
    design: Designs,
    number_ranges: NumberRanges,
    budget: Budget,
    is_on_train_curve: bool = False,
) -> BoxVerdict:
    """Verdict on a constraint on a curve of the cam or of its train, for all designs between ``number_ranges``."""
    curve: Curve = constraint.curve
    if not problem.programme.has_kinds(constraint.kinds):
        return BoxVerdict(HELD)
    if isinstance(curve, MotionDerivative) and not (curve.at_follower and curve.order <= MOST_ORDER):
        return BoxVerdict(UNDECIDED)
    mechanism = problem.setup.mechanism
    if curve in (*mechanism.curves_shared_by_pitch_curve, mechanism.profile_radius, mechanism.outline):
        problem = replace(problem, programme=replace(problem.programme, load=None))  # the shape has no load
    search = TrainConstraintSearch(
        problem, constraint, design, tuple(number_ranges), budget, of_train=is_on_train_curve
    )
    return search.search_for_violation(search.tool_panels_split_at_load_corners(number_ranges))


def driven_motion_over_trains(
    problem: Problem, constraint: Constraint, design: Designs, number_ranges: NumberRanges
) -> DrivenMotion | None:
    """Motion of all followers of a box, with the range of their lifts; None if one may fail to assemble."""
    search = TrainConstraintSearch(problem, constraint, design, tuple(number_ranges), UNLIMITED)
    motion = search.enclose_motion(search.tool_panels_split_at_load_corners(number_ranges).take([0]))
    return replace(motion.driven, lift=range_of(motion.driven.lift)) if np.all(motion.assembled) else None


class BoxMotion(NamedTuple):
    """Motion of the followers of parts of a box."""

    driven: DrivenMotion
    designs: Designs
    angle: SlopedInterval
    assembled: Any
    """In which parts every train and cam can be assembled, and moves in the same direction."""


@dataclass(frozen=True)
class TrainConstraintSearch(ConstraintSearch):
    """The search for a cam, with a train of the box, that breaks a constraint."""

    of_train: bool = False
    """Whether the constraint is on a curve of the train."""

    @cached_property
    def follower_sense(self) -> float:
        """Direction of the follower as the tool moves up: 1 or −1."""
        assert self.problem.setup.train is not None
        return float(self.problem.setup.train.joint_motion_signs[-1])

    @cached_property
    def tool_programme(self) -> Programme:
        """The tool's motion."""
        return self.problem.programme.tool

    @cached_property
    def panel_stroke_kinds(self) -> IntArray:
        """Kind of each panel of the tool's motion."""
        return np.repeat(self.tool_programme.table.kind, np.diff(self.tool_programme.table.first_panel))

    def tool_panels_split_at_load_corners(self, number_ranges: NumberRanges) -> BoxParts:
        """Whole panels of the tool's motion on the constraint's strokes, with the box."""
        kinds, table = (
            self.panel_stroke_kinds if self.follower_sense > 0.0 else reversed_kinds(self.panel_stroke_kinds),
            self.tool_programme.table,
        )
        parts = BoxParts.from_panels(np.flatnonzero(kinds & self.constraint.kinds), self.constraint, number_ranges)
        centre, half = table.centre[parts.panel], table.half_width[parts.panel]
        load = self.problem.programme.load
        for corner in () if load is None else load.angles:
            parts = parts.split_at_panel_place((np.mod(corner - centre + np.pi, 2.0 * np.pi) - np.pi) / half)
            centre, half = table.centre[parts.panel], table.half_width[parts.panel]
        return parts

    def load_function_over_parts(self, parts: BoxParts, middle_place: FloatArray, angle: SlopedInterval) -> LoadAt:
        """Loads over parts; no part may have a corner of a load inside."""
        table = self.tool_programme.table
        place = middle_place * table.half_width[parts.panel]

        def load_over_parts(load: ExternalLoad) -> tuple[Number, Number]:
            value, slope = load.load_and_slope(table.centre[parts.panel] + place)
            error = UNIT_ROUNDOFF * (LOAD_ERRORS * load.largest_load_magnitude + ANGLE_ERRORS * np.abs(slope))
            straight = Interval(value - slope * place - error, value - slope * place + error)
            return LinkageInterval.from_sloped_interval(angle * slope + straight, []), slope

        return load_over_parts

    def enclose_excess(self, parts: BoxParts) -> SlopedInterval:
        motion, constraint = self.enclose_motion(parts), self.constraint
        curve: Curve = constraint.curve
        if self.of_train:
            value = curve(motion.designs, motion.driven.links)
        elif isinstance(curve, MotionDerivative):
            value = motion.driven.state[curve.order]
        else:
            value = curve_value(curve(motion.designs, motion.driven), ..., motion.driven.state)
        quotient = as_quotient(value.divide() if isinstance(value, Quotient) else value)
        excess = as_sloped_interval(relative_excess(constraint, parts.side, quotient, motion.designs), motion.angle)
        return excess_unbounded_if_unassembled(motion.assembled, excess)

    def enclose_motion(self, parts: BoxParts) -> BoxMotion:
        """Motion of the followers over parts."""
        middle_place, angle, designs = self.angles_and_designs(parts, self.tool_programme.table)
        radicands, zero = (
            list[SlopedInterval](),
            tool_travel_range(self.problem.programme)[0] - self.tool_programme.lowest_and_highest_displacement[0],
        )
        tool: Any = enclose_state(self.tool_programme.table, parts.panel, middle_place, angle)
        moving: Any = tool.y + zero, tool.y1, tool.y2
        motion = [LinkageInterval.from_sloped_interval(term, radicands) for term in moving]
        ranges: dict[str, Any] = {key: number for key, number in designs.numbers.items() if is_train_key(key)}
        trains = {key: LinkageInterval.from_sloped_interval(number, radicands) for key, number in ranges.items()}
        ways = motion_directions(self.panel_stroke_kinds[parts.panel])
        loads = self.load_function_over_parts(parts, middle_place, angle)
        driven = motion_of_driven_followers(self.problem, designs.with_values(trains), loads, motion, ways)
        margins = self.problem.setup.mechanism.assembly_margins(designs, driven)  # type: ignore[arg-type]
        assembled = driven.sense == self.follower_sense
        for margin in (*margins, *radicands):
            assembled = assembled & (as_interval(range_of(margin)).low > 0.0)
        return BoxMotion(driven, designs, angle, assembled)


def excess_unbounded_if_unassembled(assembled: Any, excess: SlopedInterval) -> SlopedInterval:
    """The excess where all trains and cams are assembled; elsewhere without bounds."""
    high, low = np.where(assembled, excess.value.high, inf), np.where(assembled, excess.at.low, -inf)
    slopes = Interval(np.where(assembled, excess.slopes.low, -inf), np.where(assembled, excess.slopes.high, inf))
    value, at = Interval(excess.value.low, high), Interval(low, np.maximum(excess.at.high, low))
    return SlopedInterval(value, at, slopes, excess.span)

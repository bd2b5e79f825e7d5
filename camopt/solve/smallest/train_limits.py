"""Excesses over limits in boxes of sizes and trains, from each limit at a few cam angles.

Limits on means over the turn follow ``verdicts.mean_boxes``, which has only sizes. On each panel of its turn the
tool's motion has a range. The links map it to a range of the follower's motion for all trains of a box
(``driven_boxes``), and the curve's formula maps that to a range of the curve and its slopes. At one design of each
box Gauss's rule gives the mean far more closely; with the slopes this narrows the range.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import Curve, FloatArray, IntArray, Number
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import (
    Quotient,
    SlopedInterval,
    as_quotient,
    as_sloped_interval,
    narrow_by_mean_value,
    value_at_box_point,
)
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.model.motion.tool_drive import tool_travel_range
from camopt.scene.problem.constraints import Constraint, TurnMeanConstraint
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.scene.problem.tolerance_zones import NumberErrors, with_added_errors
from camopt.solve.smallest.enclosure import constraints_on_present_strokes, with_motion_peak_as_curve
from camopt.solve.smallest.excesses import UNBOUNDED_SLOPE, Excesses
from camopt.solve.smallest.motion_boxes import IDLE_EXCESS, STROKE_PLACES, BoxExcesses
from camopt.solve.verdicts.constraint_boxes import relative_excess
from camopt.solve.verdicts.driven_boxes import (
    MOTION_TERMS,
    DrivenMotion,
    ToolPlaces,
    driven_motion_at_places,
    driven_motion_over_boxes,
    driven_motion_over_ranges,
)
from camopt.solve.verdicts.mean_boxes import enclose_weighted_sums, excess_from_mean_of_curve_power
from camopt.solve.verdicts.train_means import estimate_mean_curve_power_of_designs, is_of_chosen_stroke_kind

SCAN_ANGLES, SCAN_ZOOMS = (
    256,
    4,
)  # cam angles in a scan for the largest value of a function, and number of ever finer scans
ADDED_ANGLES = 96  # most further places, where designs tried so far exceed a limit the most


def _cam_angle_of_largest_value(function: Callable[[FloatArray], FloatArray]) -> float:
    """The cam angle at which a function of cam angles is largest over the turn."""
    middle, half = pi, pi
    for _ in range(SCAN_ZOOMS):
        angles = (middle + half * np.linspace(-1.0, 1.0, SCAN_ANGLES)) % (2 * pi)
        middle, half = angles[np.argmax(function(angles))], half * 2.0 / SCAN_ANGLES
    return float(middle)


def _derivative_order(constraint: Constraint) -> int:
    """The order of the derivative of the follower's motion that a constraint limits; 0 for another curve."""
    curve: Curve = constraint.curve
    return curve.order if isinstance(curve, MotionDerivative) and curve.at_follower else 0


def _cam_angle_of_largest_derivative(turn: Programme, order: int, side: float, stroke_kinds: int) -> float:
    """The cam angle at which a derivative of a follower's motion, times a side, is largest over some strokes."""
    return _cam_angle_of_largest_value(
        lambda at: np.where(turn.kinds_at(at) & stroke_kinds, side * turn.motion_at(at)[order], -np.inf)
    )


@dataclass
class TrainLimits:
    """The constraints of limits, and the cam angles at which boxes are evaluated."""

    problem: Problem
    """The problem, with the train's free numbers as numbers of designs."""
    constraints: list[Constraint]
    train_constraints: list[Constraint]
    """The constraints on curves of trains."""
    mean_constraints: list[TurnMeanConstraint]
    even_angles: FloatArray
    added_angles: list[float] = field(default_factory=list)

    @classmethod
    def from_problem(cls, problem: Problem) -> "TrainLimits":
        even = [
            each.start + each.angle * np.linspace(0.0, 1.0, STROKE_PLACES if each.law else 1)
            for each in problem.programme.tool.strokes
        ]
        train_constraints = [constraint for limit in problem.limits for constraint in limit.train_constraints]
        constraints = [
            each if _derivative_order(each) else with_motion_peak_as_curve(each)
            for each in strictest_constraints(
                constraint for limit in problem.limits for constraint in limit.constraints
            )
        ]
        # boxes enclose means of cams and trains, under loads constant over the turn
        load = problem.programme.load
        is_load_varying = isinstance(load, ExternalLoad) or (isinstance(load, TrainLoad) and bool(load.loads))
        mean_constraints = [
            constraint
            for limit in problem.limits
            if (constraint := limit.mean_constraint) is not None and not is_load_varying
            if constraint.mean.smooth is None and not isinstance(constraint.mean.curves[0][0], MotionDerivative)
        ]
        return cls(problem, constraints, train_constraints, mean_constraints, np.concatenate(even))

    @property
    def evaluation_places(self) -> ToolPlaces:
        """Both sides of the cam angles at which boxes are evaluated."""
        angles = np.array([*self.even_angles, *self.added_angles[-ADDED_ANGLES:]])
        both = self.problem.programme.one_sided_angles(angles, ALL_STROKES)
        terms = max([MOTION_TERMS, *(_derivative_order(constraint) + 1 for constraint in self.constraints)])
        return ToolPlaces.at_angles(self.problem.programme, both.ravel(), terms)

    def add_worst_excess_places(self, design: Designs, problem: Problem) -> None:
        """Add the cam angles at which a cam, and its robust variants, exceed limits the most."""
        for variant, cam in problem.nominal_and_error_variants(design):
            programme = variant.programme
            if variant.setup.mechanism.can_assemble(cam, programme)[0]:
                for constraint in constraints_on_present_strokes(variant, self.constraints):
                    if order := _derivative_order(constraint):
                        angles = [
                            _cam_angle_of_largest_derivative(programme, order, side, constraint.kinds)
                            for side in constraint.side_signs
                        ]
                    else:
                        block = EvaluationBlock(variant.setup, programme, cam)
                        extremes = block.extremes(constraint.curve, constraint.kinds_and_goals)
                        angles = extremes.where.ravel().tolist()
                    self.added_angles += [angle for angle in angles if angle not in self.added_angles]
                for constraint, side in self._train_constraint_sides:
                    self.added_angles.append(
                        _cam_angle_of_largest_value(partial(self._train_excess_at_angles, constraint, side, cam))
                    )

    @property
    def _train_constraint_sides(self) -> list[tuple[Constraint, float]]:
        return [(constraint, side) for constraint in self.train_constraints for side in constraint.side_signs]

    def _train_excess_at_angles(
        self, constraint: Constraint, side: float, design: Designs, angles: FloatArray
    ) -> FloatArray:
        """Relative excess of one design over a constraint on its train, at cam angles."""
        places = ToolPlaces.at_angles(self.problem.programme, angles, MOTION_TERMS)
        with np.errstate(all="ignore"):
            motion = driven_motion_at_places(self.problem, design, places)
            over = _train_excess(constraint, side, motion, design) + np.zeros((angles.size, 1))
        return np.asarray(np.nan_to_num(over[:, 0], nan=-np.inf))

    def box_excesses(self, boxes: Designs, inside: Designs, template_interval: SlopedInterval) -> BoxExcesses:
        """The excesses over limits and over conditions of assembly, for the cam and its robust variants.

        Each limit is evaluated where one design of each box exceeds it the most; limits that are far from active
        are skipped. If the direction in which the followers of a box move is unknown, its limits are unknown too.
        """
        parts = [
            self._excesses_of_cam(
                self._designs_with_errors(boxes, errors),
                self._designs_with_errors(inside, errors),
                template_interval,
            )
            for errors in ({}, *self.problem.robust_errors)
        ]
        return BoxExcesses(*(list(chain.from_iterable(part)) for part in zip(*parts, strict=True)))

    def _designs_with_errors(self, designs: Designs, errors: NumberErrors) -> Designs:
        """Designs with errors; numbers that only the problem has start from their nominal values."""
        nominal = {
            key: np.full(len(designs), self.problem.nominal_numbers[key])
            for key in errors.keys() - designs.values.keys()
        }
        return with_added_errors(designs.with_values(nominal), errors)

    def _excesses_of_cam(self, boxes: Designs, inside: Designs, template_interval: SlopedInterval) -> BoxExcesses:
        places, count = self.evaluation_places, template_interval.size
        near = list(self._worst_excess_places(inside, places, self.constraints, _motion_excess))
        where = np.array([place for _, _, place in near] or [np.zeros(count, dtype=int)])
        radicands, copies = list[SlopedInterval](), boxes.take(np.tile(np.arange(count), len(where)))
        driven = driven_motion_over_boxes(self.problem, copies, places, where.ravel(), radicands)
        limits = []
        for number, (constraint, side, place) in enumerate(near):
            part = driven.take_trains(slice(number * count, (number + 1) * count))
            excess = Excesses.from_sloped_value(
                as_sloped_interval(_motion_excess(constraint, side, part, boxes), template_interval)
            )
            kinds = np.where(part.sense > 0.0, places.kinds[place], places.against[place])
            kinds = np.where(part.sense == 0.0, 0, kinds)  # the followers' direction is unknown
            limits.append(_unbounded_where_unknown(excess, kinds & constraint.kinds != 0))
        motion: Any = driven.take_trains(slice(0, count))
        margins = self.problem.setup.mechanism.assembly_margins(boxes, motion)
        assembly = [_assembly_excess(margin, 1) for margin in margins if isinstance(margin, SlopedInterval)]
        assembly += [_assembly_excess(radicand, len(where)) for radicand in radicands]
        for constraint, side, place in self._worst_excess_places(
            inside, places, self.train_constraints, _train_excess
        ):
            radicands = list[SlopedInterval]()
            part = driven_motion_over_boxes(self.problem, boxes, places, place, radicands)
            excess = Excesses.from_sloped_value(
                as_sloped_interval(_train_excess(constraint, side, part, boxes), template_interval)
            )
            limits.append(_unbounded_where_unknown(excess, part.sense != 0.0))
            assembly += [_assembly_excess(radicand, 1) for radicand in radicands]
        for mean in self.mean_constraints:
            limits.append(
                _unbounded_where_unknown(
                    *mean_excess_and_known_boxes(self.problem, mean, boxes, inside, template_interval)
                )
            )
        # boxes are first cut until the direction of their followers is known
        unknown = np.where(motion.sense == 0.0, UNBOUNDED_SLOPE, -np.inf)[None]
        return BoxExcesses(
            limits,
            assembly,
            [Excesses.from_sloped_value(as_sloped_interval(motion.moved, template_interval))._replace(at=unknown)],
        )

    def _worst_excess_places(
        self,
        inside: Designs,
        places: ToolPlaces,
        constraints: list[Constraint],
        excess_of: Callable[[Constraint, float, DrivenMotion, Designs], Number],
    ) -> Iterator[tuple[Constraint, float, IntArray]]:
        """Each side of each near constraint, with the index of the place where one design of each box is worst."""
        if not constraints:
            return
        motion = driven_motion_at_places(self.problem, inside, places)
        kinds = np.where(motion.sense > 0.0, places.kinds[:, None], places.against[:, None])
        for constraint in constraints:
            for side in constraint.side_signs:
                over = excess_of(constraint, side, motion, inside) + np.zeros(kinds.shape)
                over = np.where(kinds & constraint.kinds, np.nan_to_num(over, nan=-np.inf), -np.inf)
                if np.max(over) > IDLE_EXCESS:
                    yield constraint, side, np.argmax(over, axis=0)


def _train_excess(constraint: Constraint, side: Any, motion: DrivenMotion, designs: Designs) -> Number:
    return relative_excess(constraint, side, as_quotient(constraint.curve(designs, motion.links)), designs)


def _motion_excess(constraint: Constraint, side: Any, motion: DrivenMotion, designs: Designs) -> Number:
    curve: Curve = constraint.curve
    order = _derivative_order(constraint)
    value = motion.state[order] if order else curve_value(curve(designs, motion), ..., motion.state)
    return relative_excess(constraint, side, as_quotient(value), designs)


def _unbounded_where_unknown(excesses: Excesses, is_known: Any) -> Excesses:
    """Excesses that are unbounded for boxes where they are not known."""
    unbounded = np.full(is_known.shape, np.inf)
    least, at = (np.where(is_known, excess, -unbounded) for excess in (excesses.least, excesses.at))
    return excesses._replace(least=least, at=at, most=np.where(is_known, excesses.most, unbounded))


def _assembly_excess(margin: SlopedInterval, place_count: int) -> Excesses:
    """The excess of a margin of assembly, which must be above 0, at ``place_count`` places one after the other."""
    scale = value_at_box_point(margin).largest_magnitude
    return Excesses.from_sloped_value(-margin / np.where(scale > 0.0, scale, 1.0), place_count)


def mean_excess_and_known_boxes(
    problem: Problem,
    constraint: TurnMeanConstraint,
    boxes: Designs,
    inside: Designs,
    template_interval: SlopedInterval,
) -> tuple[Excesses, FloatArray]:
    """The excess over a limit on a mean, and for which boxes it is known: those whose followers move one way."""
    turn, count = problem.programme, template_interval.size
    table = turn.tool.table
    copies = np.tile(np.arange(count), len(table.centre))
    designs, panels = boxes.take(copies), np.repeat(np.arange(len(table.centre)), count)
    zero = (
        tool_travel_range(turn)[0] - turn.tool.lowest_and_highest_displacement[0]
    )  # panels hold the tool's motion; trains count it from here
    low, high, error = (rows[panels, :MOTION_TERMS].T.copy() for rows in (table.low, table.high, table.error))
    low[0], high[0] = low[0] + zero, high[0] + zero
    ranges = [Interval(a - e, b + e) for a, b, e in zip(low, high, error, strict=True)]
    stroke_kinds = np.repeat(table.kind, np.diff(table.first_panel))
    driven = driven_motion_over_ranges(problem, designs, ranges, stroke_kinds[panels])
    known = np.all(driven.sense.reshape(-1, count) != 0.0, axis=0)
    mean, like = constraint.mean, template_interval[copies]
    weights, panel_kinds = np.repeat(table.half_width / np.pi, count), np.repeat(stroke_kinds, count)
    parts = []  # what each curve contributes to the mean: its range (n,) and its slopes (d, n)
    curve: Curve
    for curve, kinds in mean.curves:
        value = curve_value(curve(designs, driven), ..., driven.state)
        sloped = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, like)
        power = np.square(sloped) if mean.power == 2 else sloped
        applies = is_of_chosen_stroke_kind(panel_kinds, kinds, driven.sense)
        shares = np.where(applies, weights, 0.0).reshape(-1, count)
        parts.append([enclose_weighted_sums(shares, each) for each in (power.value, power.slopes)])
    whole, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    at = estimate_mean_curve_power_of_designs(problem, mean, inside, table.centre, table.half_width, stroke_kinds)
    narrow = narrow_by_mean_value(whole, at, slopes, template_interval)
    return Excesses.from_sloped_value(excess_from_mean_of_curve_power(constraint, narrow, boxes)), known

"""The smallest cam over sizes and angles together, by branch and bound on boxes of both (``motion_boxes``).

A box is dropped if a limit at some share of a stroke proves that it holds no feasible cam, or if its angles fit no
turn. At a share of a stroke the displacement does not depend on the angle; y', y'' and y''' fall with the angle,
its square and its cube. A limit's formula there is evaluated over a box of sizes and angles, with its slopes
(``enclosure``). This bounds the excess of all cams of the box, in all turns that have the stroke.

Limits that depend on where in the turn a stroke lies, as under a load over the turn, drop no box; the answer meets
them all the same.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby, product
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.curves import LOADED_CURVES, curve_value
from camopt.core.numerics.sloped_interval import SlopedInterval, as_quotient, as_sloped_interval
from camopt.core.numerics.state import State
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.programme import Programme, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES, DWELL, Stroke
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.solve.smallest.boxes import DesignBoxes
from camopt.solve.smallest.closed_form import size_lower_bound
from camopt.solve.smallest.enclosure import size_constraints_with_error_variants, state_enclosing_rounding
from camopt.solve.smallest.excesses import SIDE_ROUNDING, Excesses
from camopt.solve.smallest.grid_search import largest_possible_size
from camopt.solve.smallest.motion_boxes import IDLE_EXCESS, STROKE_PLACES, BoxExcesses, MotionSearch
from camopt.solve.smallest.turns import SAME_POSITION, AngleRanges, SegmentAngles, TurnOptimum
from camopt.solve.verdicts.constraint_boxes import relative_excess

ADDED_PLACES = 64  # most further places, where designs tried so far exceed a limit the most


@dataclass
class StrokeLimit:
    """One constraint of a limit on one stroke, and the places at which boxes are evaluated."""

    constraint: Constraint
    stroke: Stroke
    """The stroke, starting at a cam angle of 0."""
    turn: Programme
    """A turn that has the stroke."""
    angle_name: str | None
    """The number of designs that holds its angle (deg); None if the stroke's own angle is fixed."""
    even_motion: FloatArray
    """y, y', y'' and y''' by the share of the stroke, at evenly spaced places (4, places)."""
    added_motion: FloatArray
    """The same at places where a design exceeds the limit the most."""

    def add_worst_excess_place(self, problem: Problem, design: Designs) -> None:
        """Add the place at which one design exceeds the limit the most."""
        angle = (
            self.stroke.angle if self.angle_name is None else float(np.radians(design.numbers[self.angle_name][0]))
        )
        stroke = replace(self.stroke, angle=angle)
        where = (
            EvaluationBlock(problem.setup, Programme((stroke,)), design)
            .extremes(lambda designs, _: self.constraint.curve(designs, self.turn), self.constraint.kinds_and_goals)
            .where[:, 0]
        )
        new = _motion_on_both_sides_of_shares(stroke, where / angle, self.constraint.kinds)
        self.added_motion = np.concatenate([self.added_motion, new], axis=1)[:, -ADDED_PLACES:]

    def box_excesses(self, box: Designs, inside: Designs, template_interval: SlopedInterval) -> Iterator[Excesses]:
        """The excess at the place where one design of each box exceeds the limit the most, if it is near the limit.

        The boxes are designs of sloped intervals like ``template_interval``.
        """
        places, count = np.concatenate([self.even_motion, self.added_motion], axis=1), template_interval.size
        points = inside.take(np.tile(np.arange(count), places.shape[1]))
        for side in self.constraint.side_signs:
            excess = self._constraint_excess(side, np.repeat(places, count, axis=1), points)
            excess = np.nan_to_num(excess + np.zeros(len(points)), nan=-np.inf).reshape(-1, count)
            if np.max(excess) >= IDLE_EXCESS:
                worst = state_enclosing_rounding(
                    State(*places[:, np.argmax(excess, axis=0)]), _unit_angle_programme(self.stroke)
                )
                over_box = self._constraint_excess(side, worst, box)
                yield Excesses.from_sloped_value(as_sloped_interval(over_box, template_interval))

    def _constraint_excess(self, side: float, state: Any, designs: Designs) -> Number:
        y, y1, y2, y3 = state[:4]
        angle: Any = (
            self.stroke.angle if self.angle_name is None else designs.numbers[self.angle_name] * (np.pi / 180.0)
        )
        rate = 1.0 / angle
        square = np.square(rate)
        curve = self.constraint.curve(designs, self.turn)
        value = curve_value(curve, ..., State(y, y1 * rate, y2 * square, y3 * (rate * square)))
        return relative_excess(self.constraint, np.full(y.size, side), as_quotient(value), designs)


def _motion_on_both_sides_of_shares(stroke: Stroke, shares: FloatArray, stroke_kinds: int) -> FloatArray:
    """The motion and its derivatives by the share of a stroke, on both sides of some shares with these kinds."""
    unit_stroke = _unit_angle_programme(stroke)
    return np.asarray(unit_stroke.motion_at(unit_stroke.one_sided_angles(shares, stroke_kinds).ravel()))


def _unit_angle_programme(stroke: Stroke) -> Programme:
    return Programme((replace(stroke, angle=1.0, given=None),))


class TurnBoxSearch(MotionSearch):
    """Branch and bound over the turns with the same segments, below the best cam so far."""

    def __init__(self, turns: SegmentAngles, bounds: SizeBounds, best: TurnOptimum) -> None:
        self.turns, self.bounds, self.budget = turns, bounds, turns.budget
        self.best, self.best_motion = best
        self.problem, self.box = with_rounding_relative_error(turns.problem), turns.angle_box
        self.longest = turns.programme_with_angles(self.box.high)
        """The strokes at their longest angles; together they exceed a turn, but each occurs in some turn."""
        self.lift = self.longest.lift
        self.limits = [*self._stroke_limits()]

    def _stroke_limits(self) -> Iterator[tuple[Problem, StrokeLimit]]:
        """The limits on strokes, each with the problem (of the nominal cam or a robust variant) that moves them.

        Limits that depend on where in the turn a stroke lies, by a load that changes over the turn, are left out.
        """
        problem = self.problem
        if self.longest.load is not None:
            limits = tuple(
                limit
                for limit in problem.limits
                if not any(
                    type(constraint.curve(problem.design, self.longest)) in LOADED_CURVES
                    for constraint in limit.constraints
                )
            )
            problem = replace(problem, limits=limits)
        for variant, group in groupby(size_constraints_with_error_variants(problem), lambda item: item.problem):
            longest = self.longest
            if variant.programme is not self.problem.programme:
                longest = replace(self.turns, problem=variant).programme_with_angles(self.box.high)
            for (_, constraint), (stroke, name) in product(group, self.angle_field_of_each_stroke(longest).items()):
                first = replace(stroke, start=0.0)
                shares = np.linspace(0.0, 1.0, STROKE_PLACES if stroke.law else 1)
                even_motion = _motion_on_both_sides_of_shares(first, shares, constraint.kinds)
                if even_motion.size:  # the constraint applies to the stroke
                    yield variant, StrokeLimit(constraint, first, longest, name, even_motion, np.empty((4, 0)))

    @cached_property
    def motion_fields(self) -> dict[str, int]:
        """The index among the freed segments of each stroke, by the field of its angle in boxes."""
        return {
            each.field: k
            for k, each in enumerate(self.turns.variables)
            if self.turns.segments[each.segment].segment != "dwell"
        }

    def angle_field_of_each_stroke(self, turn: Programme) -> dict[Stroke, str | None]:
        """The strokes and dwells of the longest turn.

        Each stroke with the field of its angle, each dwell with None.
        """
        least, longest = self.turns.all_segment_angles(self.box.low), self.turns.all_segment_angles(self.box.high)
        fields = {angle.segment: angle.field for angle in self.turns.variables}
        strokes: dict[Stroke, str | None] = {}
        present = [i for i in range(len(longest)) if longest[i] > 0.0]
        for i, stroke in zip(present, turn.strokes, strict=True):
            if stroke.kind != DWELL:
                strokes[stroke] = fields.get(i)
            elif least[i] > 0.0 or abs(stroke.low) <= SAME_POSITION:  # all these turns have a dwell at the lowest
                strokes[stroke] = None
        return strokes

    @cached_property
    def angle_sum_range_deg(self) -> tuple[float, float]:
        """The least and the largest sum of the freed strokes' angles [deg]."""
        dwells = [k for k in range(len(self.turns.freed_segments)) if k not in self.motion_fields.values()]
        total = float(self.turns.scene_angles.sum())
        slack = SIDE_ROUNDING * total
        return total - self.box.high[dwells].sum() - slack, total - self.box.low[dwells].sum() + slack

    def problem_and_motion_of_design(self, design: Designs) -> tuple[Problem, FloatArray]:
        # the dwells, then the strokes give way to keep the total
        low, high = self.box.low.copy(), self.box.high.copy()
        for name, k in self.motion_fields.items():
            low[k] = high[k] = design.numbers[name][0]
        angles = self.turns.turn_near_angles((low + high) / 2.0, AngleRanges(low, high))
        freed = self.turns.turn_near_angles(angles, self.box)
        return self.problem.with_programme(self.turns.programme_with_angles(freed)), freed

    def add_worst_excess_places(self, design: Designs, problem: Problem) -> None:
        if self.problem.setup.mechanism.can_assemble(design, self.longest)[0]:
            for variant, limit in self.limits:
                limit.add_worst_excess_place(variant, design)

    def box_excesses(self, boxes: Designs, inside: Designs, template_interval: SlopedInterval) -> BoxExcesses:
        excesses = [
            excess for _, limit in self.limits for excess in limit.box_excesses(boxes, inside, template_interval)
        ]
        (low, high), total = self.angle_sum_range_deg, sum(boxes.numbers[name] for name in self.motion_fields)
        if not isinstance(total, SlopedInterval):
            return BoxExcesses(excesses)
        return BoxExcesses(excesses, [Excesses.from_sloped_value(x / 360.0) for x in (total - high, low - total)])

    def search_ranges(self) -> SizeBounds:
        least = size_lower_bound(self.problem.with_programme(self.longest), self.bounds)
        most = min(largest_possible_size(self.problem, self.bounds), self.best.size)
        strokes = self.angle_field_of_each_stroke(self.longest)
        low = {name: self.least_stroke_angle_deg(stroke) for stroke, name in strokes.items() if name}
        angles = {
            name: (min(max(low[name], self.box.low[k]), self.box.high[k]), self.box.high[k])
            for name, k in self.motion_fields.items()
        }
        return {**self.bounds, **angles, "size": (least, most)}

    def least_stroke_angle_deg(self, stroke: Stroke) -> float:
        """Least angle of a stroke that meets the limits on velocity, acceleration and jerk [deg]."""
        least = 0.0
        for constraint in self.problem.constraints:
            if isinstance(constraint.curve, MotionDerivative):
                turn = constraint.curve.motion_of_tool_or_follower(self.longest)
                source, order = turn.strokes[self.longest.strokes.index(stroke)], constraint.curve.order
                if constraint.kinds & source.kind:
                    ends = weighted_derivative_range(Programme((source,)), (0.0,) * order + (1.0,), ALL_STROKES)
                    share = max(-ends[0], ends[1]) / constraint.upper_bound_of_each_side()
                    least_angle = np.degrees(stroke.angle) * share ** (1.0 / order)
                    least = max(least, least_angle * (1.0 - 16.0 * SIDE_ROUNDING))
        return float(least)

    def boxes_with_possible_motion(self, boxes: DesignBoxes) -> DesignBoxes:
        """The parts of boxes whose angles fit a turn."""
        names = list(self.motion_fields)
        low, high = (np.array([ends[name] for name in names]) for ends in (boxes.low, boxes.high))
        low = np.maximum(low, self.angle_sum_range_deg[0] - (high.sum(axis=0) - high))
        high = np.minimum(high, self.angle_sum_range_deg[1] - (low.sum(axis=0) - low))
        ends = ({n: end for n, end in zip(names, side, strict=True) if n in boxes.free} for side in (low, high))
        return boxes.with_ends_and_cut_side(next(ends), next(ends), boxes.side).take(
            np.all(low <= high + SAME_POSITION, axis=0)
        )

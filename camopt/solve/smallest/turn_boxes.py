"""The smallest cam over sizes and angles together, by bisection of boxes of both, many at once (``motion_boxes``).

A box is dropped if a limit at some share of a stroke shows that it holds no feasible cam, or if its angles are no
part of a turn. At a share of a stroke the displacement is known, whatever the angle; y', y'' and y''' fall with the
angle, its square and its cube. So the formula of a limit there, run on a box of sizes and angles with its slopes
(``enclosure``), bounds the excess of all cams of the box, in all turns that have the stroke. Limits that depend on
where in the turn a stroke is, as under a load over the turn, drop no box; a cam has to hold them like all others to
be the answer.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, FloatArray
from camopt.core.numerics.curves import LOADED_CURVES, value_of
from camopt.core.numerics.sloped_interval import SlopedInterval, as_quotient, as_sloped_interval
from camopt.core.numerics.state import State
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.programme import Programme, weighted_range
from camopt.model.motion.stroke import ALL_STROKES, DWELL, Stroke
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, at_rounding_error
from camopt.solve.smallest.boxes import DesignBoxes
from camopt.solve.smallest.closed_form import least_size
from camopt.solve.smallest.enclosure import constraints_on_size, state_with_rounding
from camopt.solve.smallest.excesses import SIDE_ROUNDING, Excesses
from camopt.solve.smallest.grid_search import largest_possible_size
from camopt.solve.smallest.motion_boxes import BoxExcesses, MotionSearch
from camopt.solve.smallest.turns import SAME_POSITION, AngleRanges, SegmentAngles, TurnOptimum
from camopt.solve.verdicts.constraint_boxes import excess_of

STROKE_IDLE_EXCESS = -0.5  # a limit that no point of a box exceeds by more, relative, is not looked at more closely
STROKE_SHARES = 17  # of a stroke at which every box is looked at, even
ADDED_PLACES = 64  # and so many more at most, where cams that were looked at exceed a limit the most


@dataclass
class StrokeLimit:
    """One constraint of a limit on one stroke, and the places at which boxes are looked at."""

    constraint: Constraint
    stroke: Stroke
    """From a cam angle of 0."""
    turn: Programme
    """A turn that has the stroke."""
    angle_name: str | None
    """Under which designs bring its angle (deg); None where it is the stroke's own."""
    even_motion: FloatArray
    """y, y', y'' and y''' by the share of the stroke, at places (4, places)."""
    added_motion: FloatArray
    """As ``even``, where a cam exceeds the limit the most."""

    @classmethod
    def from_constraint(
        cls, constraint: Constraint, stroke: Stroke, turn: Programme, name: str | None
    ) -> "StrokeLimit":
        stroke = replace(stroke, start=0.0)
        shares = np.linspace(0.0, 1.0, STROKE_SHARES if stroke.law else 1)
        return cls(
            constraint, stroke, turn, name, _one_sided_motion(stroke, shares, constraint.kinds), np.empty((4, 0))
        )

    def add_worst_place(self, problem: Problem, design: Designs) -> None:
        """Add the place at which one design exceeds the limit the most."""
        angle = (
            self.stroke.angle if self.angle_name is None else float(np.radians(design.numbers[self.angle_name][0]))
        )
        stroke, kinds = replace(self.stroke, angle=angle), self.constraint.kinds
        goals = [(kinds, LARGEST if side > 0.0 else LEAST) for side in self.constraint.sides]
        where = (
            EvaluationBlock(problem.setup, Programme((stroke,)), design)
            .extremes(self._turn_curve, goals)
            .where[:, 0]
        )
        new = _one_sided_motion(stroke, where / angle, kinds)
        self.added_motion = np.concatenate([self.added_motion, new], axis=1)[:, -ADDED_PLACES:]

    def _turn_curve(self, designs: Designs, alone: Programme) -> Any:
        return self.constraint.curve(designs, self.turn)

    def box_excesses(self, box: Designs, inside: Designs, like: SlopedInterval) -> Iterator[Excesses]:
        """The excess at the place where one design of each box exceeds the limit the most, if a limit is near.

        Boxes are designs of ranges with slopes, as ``like`` is.
        """
        places, count = np.concatenate([self.even_motion, self.added_motion], axis=1), like.size
        points = inside.take(np.tile(np.arange(count), places.shape[1]))
        for side in self.constraint.sides:
            state = np.repeat(places, count, axis=1)
            excess = self._constraint_excess(side, state, points)
            excess = np.nan_to_num(excess + np.zeros(len(points)), nan=-np.inf).reshape(-1, count)
            if np.max(excess) < STROKE_IDLE_EXCESS:
                continue
            worst = state_with_rounding(State(*places[:, np.argmax(excess, axis=0)]), _unit_stroke(self.stroke))
            yield Excesses.from_sloped_value(as_sloped_interval(self._constraint_excess(side, worst, box), like))

    def _constraint_excess(self, side: float, state: Any, designs: Designs) -> Any:
        """What is above 0 where designs exceed the limit."""
        y, y1, y2, y3 = state[:4]
        angle: Any = (
            self.stroke.angle if self.angle_name is None else designs.numbers[self.angle_name] * (np.pi / 180.0)
        )
        fast = 1.0 / angle
        square = np.square(fast)
        made = self.constraint.curve(designs, self.turn)
        value = value_of(made, ..., State(y, y1 * fast, y2 * square, y3 * (fast * square)))
        return excess_of(self.constraint, np.full(y.size, side), as_quotient(value), designs)


def _one_sided_motion(stroke: Stroke, shares: FloatArray, kinds: int) -> FloatArray:
    """The motion by the share of a stroke on both sides of some shares, where it moves in ways of some kinds."""
    alone = _unit_stroke(stroke)
    return np.asarray(alone.motion_at(alone.one_sided_angles(shares, kinds).ravel()))


def _unit_stroke(stroke: Stroke) -> Programme:
    """The stroke alone, over an angle of 1."""
    return Programme((replace(stroke, angle=1.0, given=None),))


class TurnBoxSearch(MotionSearch):
    """A search among the turns that have the same segments, below the best cam so far."""

    def __init__(self, turns: SegmentAngles, bounds: SizeBounds, found: TurnOptimum) -> None:
        self.turns, self.bounds, self.until = turns, bounds, turns.until
        self.best, self.best_motion = found
        self.problem, self.box = at_rounding_error(turns.problem), turns.box
        self.longest = turns.programme_of(self.box.high)
        """The strokes at their longest angles: no turn, but each of its strokes is one of turns."""
        self.lift = self.longest.lift
        self.limits = [*self._stroke_limits()]

    def _stroke_limits(self) -> Iterator[tuple[Problem, StrokeLimit]]:
        """The limits on strokes, each with the problem of the train that moves them."""
        for own, asked in groupby(constraints_on_size(self.problem_without_load), lambda each: each.problem):
            longest = self.longest
            if own.programme is not self.problem.programme:
                longest = replace(self.turns, problem=own).programme_of(self.box.high)
            for each in asked:
                for stroke, name in self.strokes_of(longest).items():
                    limit = StrokeLimit.from_constraint(each.constraint, stroke, longest, name)
                    if limit.even_motion.size:  # the constraint is about the stroke
                        yield own, limit

    @cached_property
    def problem_without_load(self) -> Problem:
        """With the limits that are the same wherever in the turn a stroke is."""
        if self.longest.load is None:
            return self.problem
        limits = tuple(limit for limit in self.problem.limits if not self.reads_load(limit))
        return replace(self.problem, limits=limits)

    def reads_load(self, limit: Limit) -> bool:
        """Whether a limit is about a load that changes over the turn."""
        made = (constraint.curve(self.problem.design, self.longest) for constraint in limit.constraints)
        return any(type(curve) in LOADED_CURVES for curve in made)

    @cached_property
    def motion_fields(self) -> dict[str, int]:
        """The place among the freed segments of each that moves, by the name that its angle has in boxes."""
        angles = enumerate(self.turns.variables)
        return {each.field: k for k, each in angles if self.turns.segments[each.segment].segment != "dwell"}

    @cached_property
    def shared_strokes(self) -> dict[Stroke, str | None]:
        """What all of these turns have."""
        return self.strokes_of(self.longest)

    def strokes_of(self, turn: Programme) -> dict[Stroke, str | None]:
        """Those of a turn with the longest angles: strokes with the names of their angles, and rests, without."""
        least, longest = self.turns.all_angles(self.box.low), self.turns.all_angles(self.box.high)
        fields = {each.segment: each.field for each in self.turns.variables}
        found: dict[Stroke, str | None] = {}
        present = [i for i in range(len(longest)) if longest[i] > 0.0]
        for i, stroke in zip(present, turn.strokes, strict=True):
            if stroke.kind != DWELL:
                found[stroke] = fields.get(i)
            elif least[i] > 0.0 or abs(stroke.low) <= SAME_POSITION:  # one is at the lowest in all these turns
                found[stroke] = None
        return found

    @cached_property
    def total_range(self) -> tuple[float, float]:
        """The least and the most that the freed strokes have together, deg."""
        dwells = [k for k in range(len(self.turns.freed_segments)) if k not in self.motion_fields.values()]
        total = float(self.turns.scene_angles.sum())
        slack = SIDE_ROUNDING * total
        return total - self.box.high[dwells].sum() - slack, total - self.box.low[dwells].sum() + slack

    def motion_at_middle(self, boxes: DesignBoxes) -> tuple[Problem, FloatArray]:
        freed = self.turn_at_middle(boxes)
        return self.problem.with_programme(self.turns.programme_of(freed)), freed

    def learn_worst_places(self, design: Designs, problem: Problem) -> None:
        if self.problem.setup.mechanism.can_assemble(design, self.longest)[0]:
            for own, limit in self.limits:
                limit.add_worst_place(own, design)

    def box_excesses(self, boxes: Designs, inside: Designs, like: SlopedInterval) -> BoxExcesses:
        alone = [each for _, limit in self.limits for each in limit.box_excesses(boxes, inside, like)]
        return BoxExcesses(alone, [*self.sum_excesses(boxes)])

    def search_ends(self) -> SizeBounds:
        least = least_size(self.problem.with_programme(self.longest), self.bounds)
        most = min(largest_possible_size(self.problem, self.bounds), self.best.size)
        low = {name: self.least_stroke_angle(stroke) for stroke, name in self.shared_strokes.items() if name}
        angles = {
            name: (min(max(low[name], self.box.low[k]), self.box.high[k]), self.box.high[k])
            for name, k in self.motion_fields.items()
        }
        return {**self.bounds, **angles, "size": (least, most)}

    def least_stroke_angle(self, stroke: Stroke) -> float:
        """The least angle of a stroke, deg, at which it holds the limits on velocity, acceleration and jerk."""
        least = 0.0
        for constraint in self.problem.constraints:
            if not isinstance(constraint.curve, Derivative):
                continue
            asked = constraint.curve.source_motion(self.longest).strokes[self.longest.strokes.index(stroke)]
            if constraint.kinds & asked.kind:
                order = constraint.curve.order
                ends = weighted_range(Programme((asked,)), (0.0,) * order + (1.0,), ALL_STROKES)
                share = max(-ends[0], ends[1]) / constraint.upper_bound()
                least = max(least, np.degrees(stroke.angle) * share ** (1.0 / order) * (1.0 - 16.0 * SIDE_ROUNDING))
        return float(least)

    def sum_excesses(self, boxes: Designs) -> Iterator[Excesses]:
        """That strokes leave the dwells what these can take."""
        together = sum(boxes.numbers[name] for name in self.motion_fields)
        if isinstance(together, SlopedInterval):
            for excess in (together - self.total_range[1], self.total_range[0] - together):
                yield Excesses.from_sloped_value(excess / 360.0)

    def possible_boxes(self, boxes: DesignBoxes) -> DesignBoxes:
        """What of some boxes can be part of a turn."""
        names = list(self.motion_fields)
        low, high = (np.array([ends[name] for name in names]) for ends in (boxes.low, boxes.high))
        low = np.maximum(low, self.total_range[0] - (high.sum(axis=0) - high))
        high = np.minimum(high, self.total_range[1] - (low.sum(axis=0) - low))
        ends = ({n: end for n, end in zip(names, each, strict=True) if n in boxes.free} for each in (low, high))
        return boxes.with_ends(next(ends), next(ends), boxes.side).take(np.all(low <= high + SAME_POSITION, axis=0))

    def turn_at_middle(self, boxes: DesignBoxes) -> FloatArray:
        """A turn in the middle of the first box; dwells share what strokes leave, if they can."""
        low, high = self.box.low.copy(), self.box.high.copy()
        for name, k in self.motion_fields.items():
            low[k] = high[k] = (boxes.low[name][0] + boxes.high[name][0]) / 2.0
        if not low.sum() <= self.turns.scene_angles.sum() <= high.sum():
            for name, k in self.motion_fields.items():
                low[k], high[k] = boxes.low[name][0], boxes.high[name][0]
        return self.turns.turn_at_shares(np.full(low.size, 0.5), AngleRanges(low, high))

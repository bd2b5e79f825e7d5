"""The smallest cam over sizes and angles together, by bisection of boxes of both, many at once (``motion_boxes``).

A box is dropped if a limit at some share of a stroke (``stroke_limits``) shows that it holds no feasible cam, or
if its angles are no part of a turn. Limits that depend on where in the turn a stroke is, as under a load over the
turn, drop no box; a cam has to hold them like all others to be the answer.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from camopt.effects.peak import Derivative
from camopt.mechanisms import Designs
from camopt.mechanisms.design import SizeBounds
from camopt.motion.programme import Programme, span
from camopt.motion.stroke import Stroke
from camopt.motion.table import ALL_STROKES, DWELL
from camopt.numerics import FloatArray
from camopt.numerics.curves import WITH_LOAD
from camopt.numerics.sloped import Sloped
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem, exactly
from camopt.smallest.boxes import Boxes
from camopt.smallest.closed_form import least_size
from camopt.smallest.enclosure import claims_on_size
from camopt.smallest.excesses import SIDE_ROUNDING, Excesses
from camopt.smallest.first_look import largest_size, scale_of
from camopt.smallest.motion_boxes import MotionSearch, Said
from camopt.smallest.result import Smallest
from camopt.smallest.stroke_limits import StrokeLimit, stroke_limits
from camopt.smallest.turns import SAME_POSITION, AngleRanges, BestTurn, SegmentAngles, better


class TurnSearch(MotionSearch):
    """A search among the turns that have the same segments, below the best cam so far."""

    def __init__(self, turns: SegmentAngles, bounds: SizeBounds, found: BestTurn) -> None:
        self.turns, self.bounds, self.found, self.until = turns, bounds, found, turns.until
        self.problem, self.box = exactly(turns.problem), turns.box
        self.longest = turns.programme(self.box.high)
        """The strokes at their longest angles: no turn, but each of its strokes is one of turns."""
        self.limits = [*self._limits()]

    def _limits(self) -> Iterator[tuple[Problem, StrokeLimit]]:
        """The limits on strokes, each with the problem of the train that moves them."""
        for own, asked in groupby(claims_on_size(self.asked), lambda each: each.problem):
            longest = self.longest
            if own.programme is not self.problem.programme:
                longest = replace(self.turns, problem=own).programme(self.box.high)
            for limit in stroke_limits([each.claim for each in asked], self.strokes_of(longest), longest):
                yield own, limit

    @cached_property
    def asked(self) -> Problem:
        """With the limits that are the same wherever in the turn a stroke is."""
        if self.longest.load is None:
            return self.problem
        limits = tuple(limit for limit in self.problem.limits if not self.reads_load(limit))
        return replace(self.problem, limits=limits)

    def reads_load(self, limit: Limit) -> bool:
        """Whether a limit is about a load that changes over the turn."""
        made = (claim.curve(self.problem.design, self.longest) for claim in limit.claims)
        return any(type(curve) in WITH_LOAD for curve in made)

    @cached_property
    def names(self) -> dict[str, int]:
        """The place among the freed segments of each that moves, by the name that its angle has in boxes."""
        angles = enumerate(self.turns.variables)
        return {each.field: k for k, each in angles if self.turns.segments[each.segment].segment != "dwell"}

    @cached_property
    def strokes(self) -> dict[Stroke, str | None]:
        """What all of these turns have."""
        return self.strokes_of(self.longest)

    def strokes_of(self, turn: Programme) -> dict[Stroke, str | None]:
        """Those of a turn with the longest angles: strokes with the names of their angles, and rests, without."""
        least, longest = self.turns.angles(self.box.low), self.turns.angles(self.box.high)
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
    def room(self) -> tuple[float, float]:
        """The least and the most that the freed strokes have together, deg."""
        dwells = [k for k in range(len(self.turns.freed)) if k not in self.names.values()]
        total = float(self.turns.scene_angles.sum())
        slack = SIDE_ROUNDING * total
        return total - self.box.high[dwells].sum() - slack, total - self.box.low[dwells].sum() + slack

    def run(self) -> BestTurn:
        """The smallest cam, with a size that no cam of these turns undercuts."""
        ends = self.ends()
        least, most = ends["size"]
        if most <= least:  # as small as any cam may be
            return self.found._replace(answer=replace(self.found.answer, floor=least))
        scale = scale_of(self.problem, self.bounds, self.longest.lift)
        boxes = Boxes.one(ends, scale, self.problem.choices.variables)
        floor = self.bisect(boxes, self.turns.until)
        return self.found._replace(answer=replace(self.found.answer, floor=floor))

    @property
    def deciding(self) -> dict[str, int]:
        return self.names

    @property
    def best(self) -> Smallest:
        return self.found.answer

    def motion(self, boxes: Boxes) -> tuple[Problem, FloatArray]:
        freed = self.turn(boxes)
        return self.problem.with_programme(self.turns.programme(freed)), freed

    def offer(self, answer: Smallest, problem: Problem, told: Any) -> None:
        self.found = better(self.found, BestTurn(answer, told))

    def learn(self, design: Designs, problem: Problem) -> None:
        if self.problem.setup.mechanism.exists(design, self.longest)[0]:
            for own, limit in self.limits:
                limit.look_at(own, design)

    def said(self, boxes: Designs, inside: Designs, like: Sloped) -> Said:
        alone = [each for _, limit in self.limits for each in limit.excesses(boxes, inside, like)]
        return Said(alone, [*self.sums(boxes)])

    def ends(self) -> SizeBounds:
        """Between which sizes and angles are worth a look."""
        least = least_size(self.problem.with_programme(self.longest), self.bounds)
        most = min(largest_size(self.problem, self.bounds), self.found.answer.size)
        low = {name: self.gentlest(stroke) for stroke, name in self.strokes.items() if name}
        angles = {
            name: (min(max(low[name], self.box.low[k]), self.box.high[k]), self.box.high[k])
            for name, k in self.names.items()
        }
        return {**self.bounds, **angles, "size": (least, most)}

    def gentlest(self, stroke: Stroke) -> float:
        """The least angle of a stroke, deg, at which it holds the limits on velocity, acceleration and jerk."""
        least = 0.0
        for claim in self.problem.claims:
            if not isinstance(claim.curve, Derivative):
                continue
            asked = claim.curve.of(self.longest).strokes[self.longest.strokes.index(stroke)]
            if claim.kinds & asked.kind:
                order = claim.curve.order
                ends = span(Programme((asked,)), (0.0,) * order + (1.0,), ALL_STROKES)
                share = max(-ends[0], ends[1]) / claim.allowed()
                least = max(least, np.degrees(stroke.angle) * share ** (1.0 / order) * (1.0 - 16.0 * SIDE_ROUNDING))
        return float(least)

    def sums(self, boxes: Designs) -> Iterator[Excesses]:
        """That strokes leave the dwells what these can take."""
        together = sum(boxes.numbers[name] for name in self.names)
        if isinstance(together, Sloped):
            for excess in (together - self.room[1], self.room[0] - together):
                yield Excesses.of(excess / 360.0)

    def possible(self, boxes: Boxes) -> Boxes:
        """What of some boxes can be part of a turn."""
        names = list(self.names)
        low, high = (np.array([ends[name] for name in names]) for ends in (boxes.low, boxes.high))
        low = np.maximum(low, self.room[0] - (high.sum(axis=0) - high))
        high = np.minimum(high, self.room[1] - (low.sum(axis=0) - low))
        ends = ({n: end for n, end in zip(names, each, strict=True) if n in boxes.free} for each in (low, high))
        return boxes.narrowed(next(ends), next(ends), boxes.side).take(np.all(low <= high + SAME_POSITION, axis=0))

    def turn(self, boxes: Boxes) -> FloatArray:
        """A turn in the middle of the first box; dwells share what strokes leave, if they can."""
        low, high = self.box.low.copy(), self.box.high.copy()
        for name, k in self.names.items():
            low[k] = high[k] = (boxes.low[name][0] + boxes.high[name][0]) / 2.0
        if not low.sum() <= self.turns.scene_angles.sum() <= high.sum():
            for name, k in self.names.items():
                low[k], high[k] = boxes.low[name][0], boxes.high[name][0]
        return self.turns.at(np.full(low.size, 0.5), AngleRanges(low, high))

"""The smallest cam over sizes and angles together, by bisection of boxes of both, many at once.

A box is dropped only if a limit, at some share of a stroke (``stroke_limits``), shows that it holds no feasible
cam, if its angles are no part of a turn, or if a feasible cam is known that is as small. What is left when the
search is stopped bounds how much smaller a cam may be. Limits that depend on where in the turn a stroke is, as
under a load over the turn, drop no box; a cam has to hold them like all others to be the answer.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

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
from camopt.smallest.bisection import Bisection
from camopt.smallest.boxes import Boxes
from camopt.smallest.closed_form import least_size
from camopt.smallest.combined import combined
from camopt.smallest.enclosure import claims_on_size
from camopt.smallest.excesses import SIDE_ROUNDING, Excesses, chained_excesses, cut_off, kept, widest
from camopt.smallest.first_look import largest_size, scale_of
from camopt.smallest.result import Smallest, first_feasible, gap_of, known_crossings
from camopt.smallest.sloped_designs import sloped_boxes
from camopt.smallest.smallest import small
from camopt.smallest.stroke_limits import stroke_limits
from camopt.smallest.turns import SAME_POSITION, AngleRanges, BestTurn, SegmentAngles, better

TURN_BATCH = 256  # boxes examined together, at most, to stop in time
LOOKED_INTO = 12  # boxes whose middle is searched: the best turn so far may be in another valley
LADDERS, LADDER = 3, 16  # how often so many sizes of a box are looked at, closer and closer


class TurnSearch(Bisection):
    """A search among the turns that have the same segments, below the best cam so far."""

    most_boxes = 50_000

    def __init__(self, turns: SegmentAngles, bounds: SizeBounds, found: BestTurn) -> None:
        self.turns, self.bounds, self.found, self.looked = turns, bounds, found, 0
        self.problem, self.box = exactly(turns.problem), turns.box
        self.longest = turns.programme(self.box.high)
        """The strokes at their longest angles: no turn, but each of its strokes is one of turns."""
        self.limits = stroke_limits(claims_on_size(self.asked), self.strokes, self.longest)

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
        """What all of these turns have: strokes with the names of their angles, and rests, which have none."""
        least, longest = self.turns.angles(self.box.low), self.turns.angles(self.box.high)
        fields = {each.segment: each.field for each in self.turns.variables}
        found: dict[Stroke, str | None] = {}
        present = [i for i in range(len(longest)) if longest[i] > 0.0]
        for i, stroke in zip(present, self.longest.strokes, strict=True):
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

    def split(self, boxes: Boxes) -> tuple[Boxes, Boxes]:
        """Those with the smallest cams, and the rest."""
        order = np.argsort(boxes.low["size"], kind="stable")
        return boxes.take(order[:TURN_BATCH]), boxes.take(order[TURN_BATCH:])

    def narrowed(self, boxes: Boxes) -> Boxes:
        """What of some boxes may be part of a turn and hold a smaller cam, which is looked for there."""
        boxes = self.summed(boxes)
        if not len(boxes):
            return boxes
        self.looked += 1
        self.look_into(boxes, closely=self.looked <= LOOKED_INTO)
        return self.cut(boxes)

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

    def cut(self, boxes: Boxes) -> Boxes:
        """Those of some boxes that may hold a smaller cam, without what limits cut off, and the side to cut."""
        best = self.found.answer
        if best.design is not None:
            boxes = self.left(boxes, boxes.low["size"] >= best.size - gap_of(best.design)).below(best.size)
        if not len(boxes):
            return boxes
        inside = boxes.middles(self.problem.design)
        looked, like = sloped_boxes(boxes.designs(self.problem.design), inside, list(boxes.free), 1)
        with np.errstate(all="ignore"):
            reach = like.span
            alone = [each for limit in self.limits for each in limit.excesses(looked, inside, like)]
            if not alone:
                return boxes.narrowed({}, {}, np.argmax(reach.high, axis=0))
            over = chained_excesses([*alone, *self.sums(looked)])
            left = cut_off(combined(over, reach, boxes.free.index("size")), reach)
            side = widest(chained_excesses(alone), reach)
        middle = np.array([inside.values[name] for name in boxes.free])
        low, high = (np.array([ends[name] for name in boxes.free]) for ends in (boxes.low, boxes.high))
        low, high = kept(low, high, middle, reach, left)
        held = np.all(low <= high, axis=0) & ~over.surely
        named = (dict(zip(boxes.free, each, strict=True)) for each in (low, high))
        boxes = boxes.narrowed(next(named), next(named), side).take(held)
        return self.left(boxes, boxes.narrow)

    def sums(self, boxes: Designs) -> Iterator[Excesses]:
        """That strokes leave the dwells what these can take."""
        together = sum(boxes.numbers[name] for name in self.names)
        if isinstance(together, Sloped):
            for excess in (together - self.room[1], self.room[0] - together):
                yield Excesses.of(excess / 360.0)

    def summed(self, boxes: Boxes) -> Boxes:
        """What of some boxes can be part of a turn."""
        names = list(self.names)
        low, high = (np.array([ends[name] for name in names]) for ends in (boxes.low, boxes.high))
        low = np.maximum(low, self.room[0] - (high.sum(axis=0) - high))
        high = np.minimum(high, self.room[1] - (low.sum(axis=0) - low))
        ends = ({n: end for n, end in zip(names, each, strict=True) if n in boxes.free} for each in (low, high))
        return boxes.narrowed(next(ends), next(ends), boxes.side).take(np.all(low <= high + SAME_POSITION, axis=0))

    def look_into(self, boxes: Boxes, *, closely: bool) -> None:
        """Look at cams in the middle of the least box, and for where they exceed limits the most."""
        design = boxes.take(slice(1)).middles(self.problem.design)
        if self.problem.setup.mechanism.exists(design, self.longest)[0]:
            for limit in self.limits:
                limit.look_at(self.problem, design)
        design = design.without(self.names)
        freed = self.turn(boxes)
        problem = self.problem.with_programme(self.turns.programme(freed))
        if closely:
            near = small(problem, self.bounds, self.found.answer.design, self.turns.until)
            self.found = better(self.found, BestTurn(near, freed))
        rounding = gap_of(design) / 4.0
        low, high = (float(ends["size"][0]) for ends in (boxes.low, boxes.high))
        high = min(high + rounding, self.found.answer.size)
        for _ in range(LADDERS):
            sizes = np.linspace(low, high, LADDER)
            ladder = replace(design.take(np.zeros(LADDER, dtype=int)), size=sizes)
            cam = first_feasible(problem, ladder, known_crossings(problem), self.turns.until)
            if cam is None:
                return
            self.found = better(self.found, BestTurn(Smallest(cam, 0.0), freed))
            low, high = float(cam.size[0]) - (sizes[1] - sizes[0]), float(cam.size[0])

    def turn(self, boxes: Boxes) -> FloatArray:
        """A turn in the middle of the first box; dwells share what strokes leave, if they can."""
        low, high = self.box.low.copy(), self.box.high.copy()
        for name, k in self.names.items():
            low[k] = high[k] = (boxes.low[name][0] + boxes.high[name][0]) / 2.0
        if not low.sum() <= self.turns.scene_angles.sum() <= high.sum():
            for name, k in self.names.items():
                low[k], high[k] = boxes.low[name][0], boxes.high[name][0]
        return self.turns.at(np.full(low.size, 0.5), AngleRanges(low, high))

"""What limits say of boxes of sizes and trains: each holds at every cam angle, whatever the train.

Limits on means over the turn are as ``verdicts.mean_boxes`` has those of sizes alone. On each panel of its turn the
tool's motion has a range, which links take to one of the followers of all trains of a box (``driven_boxes``), and
the formula of the curve to its range and slopes. At one design of each box the mean is far better known, by Gauss's
rule; with the slopes, that narrows the range.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, FloatArray, IntArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped import Quotient, Sloped, as_quotient, as_sloped, at_point, by_mean_value
from camopt.model.effects import Case
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.driven import travel
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.claims import Claim, MeanClaim
from camopt.scene.problem.problem import Problem, strictest
from camopt.scene.problem.zones import Off, moved
from camopt.solve.smallest.enclosure import curve_of_designs, present_claims
from camopt.solve.smallest.excesses import HUGE_SLOPE, Excesses
from camopt.solve.smallest.motion_boxes import Said
from camopt.solve.verdicts.claim_boxes import excess_of
from camopt.solve.verdicts.driven_boxes import TERMS, Driven, ToolPlaces, at_places, over_boxes, over_ranges
from camopt.solve.verdicts.mean_boxes import excess_of_mean, weighted
from camopt.solve.verdicts.train_means import counts, mean_at

IDLE = -0.5  # a limit that no point of a box exceeds by more, relative, is not looked at more closely
STROKE_PLACES = 17  # in a stroke at which every box is looked at, even
LOOKS, CLOSER = 256, 4  # cam angles at which a derivative is looked for where it is largest, and how often closer
ADDED = 96  # and so many more at most, where cams that were looked at exceed a limit the most


def _largest_of(look: Callable[[FloatArray], FloatArray]) -> float:
    """The cam angle at which a function of cam angles is largest over the turn."""
    middle, half = pi, pi
    for _ in range(CLOSER):
        angles = (middle + half * np.linspace(-1.0, 1.0, LOOKS)) % (2 * pi)
        middle, half = angles[np.argmax(look(angles))], half * 2.0 / LOOKS
    return float(middle)


def _order(claim: Claim) -> int:
    """Of the derivative of the follower's motion that a claim is about; 0 if it is about another curve."""
    made: Any = claim.curve
    return made.order if isinstance(made, Derivative) and made.at_follower else 0


def _largest_at(turn: Programme, order: int, side: float, kinds: int) -> float:
    """The cam angle at which a derivative of a follower's motion, times a side, is largest over some strokes."""
    return _largest_of(lambda at: np.where(turn.kinds_at(at) & kinds, side * turn.at(at)[order], -np.inf))


class Worst(NamedTuple):
    """Where boxes are looked at for one side of a claim."""

    claim: Claim
    side: float
    place: IntArray
    """Of each box."""


@dataclass
class TrainLimits:
    """The claims of limits, and the cam angles at which boxes are looked at."""

    problem: Problem
    """With designs that bring the numbers of the train which have ranges."""
    claims: list[Claim]
    of_train: list[Claim]
    """Those on curves of trains."""
    means: list[MeanClaim]
    even: FloatArray
    added: list[float] = field(default_factory=list)

    @classmethod
    def of(cls, problem: Problem) -> "TrainLimits":
        """The limits of a problem."""
        strokes = problem.programme.tool.strokes
        even = [
            each.start + each.angle * np.linspace(0.0, 1.0, STROKE_PLACES if each.law else 1) for each in strokes
        ]
        of_train = [claim for limit in problem.limits for claim in limit.of_train]
        claims = [
            each if _order(each) else each._replace(curve=curve_of_designs(each.curve, each.kinds))
            for each in strictest(claim for limit in problem.limits for claim in limit.claims)
        ]
        return cls(problem, claims, of_train, means_of_trains(problem), np.concatenate(even))

    @property
    def places(self) -> ToolPlaces:
        """Both sides of those cam angles."""
        angles = np.array([*self.even, *self.added[-ADDED:]])
        both = self.problem.programme.one_sided(angles, ALL_STROKES)
        terms = max([TERMS, *(_order(each) + 1 for each in self.claims)])
        return ToolPlaces.of(self.problem.programme, both.ravel(), terms)

    def learn(self, design: Designs, problem: Problem) -> None:
        """Add the places at which one cam of a train exceeds limits the most, and those that hold them with it."""
        for own, cam in problem.every(design):
            if own.setup.mechanism.exists(cam, own.programme)[0]:
                for claim in present_claims(own, self.claims):
                    if order := _order(claim):
                        found = [_largest_at(own.programme, order, side, claim.kinds) for side in claim.sides]
                    else:
                        goals = [(claim.kinds, LARGEST if side > 0.0 else LEAST) for side in claim.sides]
                        extremes = Case(own.setup, own.programme, cam).extremes(claim.curve, goals)
                        found = extremes.where.ravel().tolist()
                    self.added += [each for each in found if each not in self.added]
                for claim, side in self._sides_of_train:
                    self.added.append(_largest_of(partial(self._over_train, claim, side, cam)))

    @property
    def _sides_of_train(self) -> list[tuple[Claim, float]]:
        return [(claim, side) for claim in self.of_train for side in claim.sides]

    def _over_train(self, claim: Claim, side: float, design: Designs, angles: FloatArray) -> FloatArray:
        """The excess of one design over a claim on its train at cam angles."""
        places = ToolPlaces.of(self.problem.programme, angles, TERMS)
        with np.errstate(all="ignore"):
            motion = at_places(self.problem, design, places)
            over = _excess_of_train(claim, side, motion, design) + np.zeros((angles.size, 1))
        return np.asarray(np.nan_to_num(over[:, 0], nan=-np.inf))

    def said(self, boxes: Designs, inside: Designs, like: Sloped) -> Said:
        """The excess where one design of each box exceeds a limit the most, for each limit that is near.

        And what is above 0 where no train, or no cam, can be put together. Where it is not known which way
        followers of a box go, nothing is known of limits. So of all cams that have to hold limits with these.
        """
        every = [self._said(self._off(boxes, off), self._off(inside, off), like) for off in self.offs]
        return Said(*(list(chain.from_iterable(part)) for part in zip(*every, strict=True)))

    @property
    def offs(self) -> tuple[Off, ...]:
        """By how much cams are off that have to hold the limits."""
        return {}, *self.problem.offs

    def _off(self, designs: Designs, off: Off) -> Designs:
        """Designs that are off, with their trains."""
        lacking = {
            key: np.full(len(designs), self.problem.nominal[key]) for key in off.keys() - designs.values.keys()
        }
        return moved(designs.with_values(lacking), off)

    def _said(self, boxes: Designs, inside: Designs, like: Sloped) -> Said:
        places, count = self.places, like.size
        near = list(self._worst(inside, places))
        where = np.array([each.place for each in near] or [np.zeros(count, dtype=int)])
        radicands, every = list[Sloped](), boxes.take(np.tile(np.arange(count), len(where)))
        driven = over_boxes(self.problem, every, places, where.ravel(), radicands)
        found = []
        for number, (claim, side, place) in enumerate(near):
            here = driven.part(slice(number * count, (number + 1) * count))
            excess = Excesses.of(as_sloped(_excess(claim, side, here, boxes), like))
            kinds = np.where(here.sense > 0.0, places.kinds[place], places.against[place])
            kinds = np.where(here.sense == 0.0, 0, kinds)  # it is not known which way followers go
            found.append(_where_known(excess, kinds & claim.kinds != 0))
        motion: Any = driven.part(slice(0, count))
        margins = self.problem.setup.mechanism.assembly_margins(boxes, motion)
        lacking = [_lack(each, 1) for each in margins if isinstance(each, Sloped)]
        lacking += [_lack(each, len(where)) for each in radicands]
        for claim, side, place in self._worst_of_train(inside, places):
            asked = list[Sloped]()
            here = over_boxes(self.problem, boxes, places, place, asked)
            excess = Excesses.of(as_sloped(_excess_of_train(claim, side, here, boxes), like))
            found.append(_where_known(excess, here.sense != 0.0))
            lacking += [_lack(each, 1) for each in asked]
        for mean in self.means:
            over, known = mean_excesses(self.problem, mean, boxes, inside, like)
            found.append(_where_known(over, known))
        # boxes are first cut until it is known which way their followers go
        unknown = np.where(motion.sense == 0.0, HUGE_SLOPE, -np.inf)[None]
        return Said(found, lacking, [Excesses.of(as_sloped(motion.moved, like))._replace(at=unknown)])

    def _worst(self, inside: Designs, places: ToolPlaces) -> Iterator[Worst]:
        """Of claims that are near, the place where one design of each box exceeds them most; either side."""
        motion = at_places(self.problem, inside, places)
        kinds = np.where(motion.sense > 0.0, places.kinds[:, None], places.against[:, None])
        for claim in self.claims:
            for side in claim.sides:
                over = _excess(claim, side, motion, inside) + np.zeros(kinds.shape)
                over = np.where(kinds & claim.kinds, np.nan_to_num(over, nan=-np.inf), -np.inf)
                if np.max(over) > IDLE:
                    yield Worst(claim, side, np.argmax(over, axis=0))

    def _worst_of_train(self, inside: Designs, places: ToolPlaces) -> Iterator[Worst]:
        """The same of claims on trains."""
        if not self.of_train:
            return
        motion = at_places(self.problem, inside, places)
        for claim, side in self._sides_of_train:
            over = _excess_of_train(claim, side, motion, inside) + np.zeros((places.angles.size, len(inside)))
            over = np.nan_to_num(over, nan=-np.inf)
            if np.max(over) > IDLE:
                yield Worst(claim, side, np.argmax(over, axis=0))


def _excess_of_train(claim: Claim, side: Any, motion: Driven, designs: Designs) -> Any:
    """What is above 0 where the trains of designs exceed a claim on one side."""
    return excess_of(claim, side, as_quotient(claim.curve(designs, motion.links)), designs)


def _excess(claim: Claim, side: Any, motion: Driven, designs: Designs) -> Any:
    """What is above 0 where designs exceed a claim on one side."""
    made: Any = claim.curve
    order = _order(claim)
    value = motion.state[order] if order else value_of(made(designs, motion), ..., motion.state)
    return excess_of(claim, side, as_quotient(value), designs)


def _where_known(over: Excesses, known: Any) -> Excesses:
    """Excesses that tell nothing of other boxes."""
    none = np.full(known.shape, np.inf)
    ends = (np.where(known, each, -none) for each in (over.least, over.at))
    return over._replace(least=next(ends), at=next(ends), most=np.where(known, over.most, none))


def _lack(margin: Sloped, rows: int) -> Excesses:
    """The excess of what has to be above 0, so many times one after the other."""
    scale = at_point(margin).largest_magnitude
    return Excesses.of(-margin / np.where(scale > 0.0, scale, 1.0), rows)


def means_of_trains(problem: Problem) -> list[MeanClaim]:
    """The claims on means that differ between cams and trains; of loads that are the same all over the turn."""
    load = problem.programme.load
    if isinstance(load, ExternalLoad) or (isinstance(load, TrainLoad) and load.loads):
        return []
    means = [limit.mean for limit in problem.limits if limit.mean is not None]
    return [
        each for each in means if each.mean.smooth is None and not isinstance(each.mean.curves[0][0], Derivative)
    ]


def mean_excesses(
    problem: Problem, claim: MeanClaim, boxes: Designs, inside: Designs, like: Sloped
) -> tuple[Excesses, FloatArray]:
    """The excess over a limit on a mean, and of which boxes it is known: where the followers go one way."""
    turn, count = problem.programme, like.size
    table = turn.tool.table
    every = np.tile(np.arange(count), len(table.centre))
    designs, panels = boxes.take(every), np.repeat(np.arange(len(table.centre)), count)
    zero = travel(turn)[0] - turn.tool.levels[0]  # panels are those of the tool's motion, from the start of trains
    low, high, error = (rows[panels, :TERMS].T.copy() for rows in (table.low, table.high, table.error))
    low[0], high[0] = low[0] + zero, high[0] + zero
    ranges = [Interval(a - off, b + off) for a, b, off in zip(low, high, error, strict=True)]
    driven = over_ranges(problem, designs, ranges, _kinds(problem)[panels])
    known = np.all(driven.sense.reshape(-1, count) != 0.0, axis=0)
    parts = [
        _share(problem, claim.mean, number, designs, driven, like[every], count)
        for number in range(len(claim.mean.curves))
    ]
    value, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    at = mean_at(problem, claim.mean, inside, table.centre, table.half_width, _kinds(problem))
    found = by_mean_value(value, at, slopes, like)
    return Excesses.of(excess_of_mean(claim, found, boxes)), known


def _kinds(problem: Problem) -> Any:
    """Of each panel of the tool's turn."""
    table = problem.programme.tool.table
    return np.repeat(table.kind, np.diff(table.first_panel))


def _share(
    problem: Problem, mean: Mean, number: int, designs: Designs, driven: Driven, like: Sloped, count: int
) -> tuple[Interval, Interval]:
    """The share of the pieces of one curve of a mean: its range (n,) and its slopes (d, n)."""
    make: Any
    make, kinds = mean.curves[number]
    value = value_of(make(designs, driven), ..., driven.state)
    made = value.divided() if isinstance(value, Quotient) else as_sloped(value, like)
    power = np.square(made) if mean.power == 2 else made
    weights = np.repeat(problem.programme.tool.table.half_width / np.pi, count)
    of = np.repeat(_kinds(problem), count)
    shares = np.where(counts(of, kinds, driven.sense), weights, 0.0).reshape(-1, count)
    return weighted(shares, power.value), weighted(shares, power.slopes)

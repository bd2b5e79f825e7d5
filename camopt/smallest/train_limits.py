"""What limits say of boxes of sizes and trains: each holds at every cam angle, whatever the train."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects import Case
from camopt.effects.peak import Derivative
from camopt.effects.transmission import LEAST_ANGLE, ROUNDED
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST, LEAST, FloatArray, IntArray
from camopt.numerics.curves import curve
from camopt.numerics.sloped import Sloped, as_quotient, as_sloped, at_point
from camopt.problem.claims import Claim
from camopt.problem.problem import Problem, strictest
from camopt.smallest.driven_boxes import TERMS, Driven, ToolPlaces, at_places, least_transmission, over_boxes
from camopt.smallest.enclosure import curve_of_designs, present_claims
from camopt.smallest.excesses import HUGE_SLOPE, Excesses
from camopt.smallest.motion_boxes import Said
from camopt.verdicts.claim_boxes import excess_of

IDLE = -0.5  # a limit that no point of a box exceeds by more, relative, is not looked at more closely
STROKE_PLACES = 17  # in a stroke at which every box is looked at, even
LOOKS, CLOSER = 256, 4  # cam angles at which a derivative is looked for where it is largest, and how often closer
ADDED = 96  # and so many more at most, where cams that were looked at exceed a limit the most


def claims_of_trains(problem: Problem) -> list[Claim]:
    """The claims of limits as those of designs that bring their trains.

    What the tool has of a derivative at most is the same for all trains.
    """
    claims = strictest(claim for limit in problem.limits for claim in limit.claims)
    return [each._replace(curve=_of_trains(each)) for each in claims]


def _of_trains(claim: Claim) -> Any:
    """The curve of a claim."""
    return claim.curve if _order(claim) else curve_of_designs(claim.curve, claim.kinds)


def _order(claim: Claim) -> int:
    """Of the derivative of the follower's motion that a claim is about; 0 if it is about another curve."""
    made: Any = claim.curve
    return made.order if isinstance(made, Derivative) and made.at_follower else 0


def _largest_at(turn: Programme, order: int, side: float, kinds: int) -> float:
    """The cam angle at which a derivative of a follower's motion, times a side, is largest over some strokes."""
    middle, half = pi, pi
    for _ in range(CLOSER):
        angles = middle + half * np.linspace(-1.0, 1.0, LOOKS)
        inside = angles % (2 * pi)
        over = np.where(turn.kinds_at(inside) & kinds, side * turn.at(inside)[order], -np.inf)
        middle, half = angles[np.argmax(over)], half * 2.0 / LOOKS
    return float(middle % (2 * pi))


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
    even: FloatArray
    added: list[float] = field(default_factory=list)

    @classmethod
    def of(cls, problem: Problem) -> "TrainLimits":
        """The limits of a problem."""
        strokes = problem.programme.tool.strokes
        even = [
            each.start + each.angle * np.linspace(0.0, 1.0, STROKE_PLACES if each.law else 1) for each in strokes
        ]
        return cls(problem, claims_of_trains(problem), np.concatenate(even))

    @property
    def places(self) -> ToolPlaces:
        """Both sides of those cam angles."""
        angles = np.array([*self.even, *self.added[-ADDED:]])
        both = self.problem.programme.one_sided(angles, ALL_STROKES)
        terms = max([TERMS, *(_order(each) + 1 for each in self.claims)])
        return ToolPlaces.of(self.problem.programme, both.ravel(), terms)

    @cached_property
    def least_angle(self) -> float:
        """The transmission angle that is asked for at least, rad; 0 if none is."""
        asked = [each.bound for each in self.problem.limits if LEAST_ANGLE in each.needs]
        return float(np.radians(max(asked, default=0.0)))

    def learn(self, design: Designs, problem: Problem) -> None:
        """Add the places at which one cam of a train exceeds limits the most."""
        for claim in present_claims(problem, self.claims):
            if order := _order(claim):
                found = [_largest_at(problem.programme, order, side, claim.kinds) for side in claim.sides]
            else:
                goals = [(claim.kinds, LARGEST if side > 0.0 else LEAST) for side in claim.sides]
                extremes = Case(problem.setup, problem.programme, design).extremes(claim.curve, goals)
                found = extremes.where.ravel().tolist()
            self.added += [each for each in found if each not in self.added]

    def said(self, boxes: Designs, inside: Designs, like: Sloped) -> Said:
        """The excess where one design of each box exceeds a limit the most, for each limit that is near.

        And what is above 0 where no train, or no cam, can be put together. Where it is not known which way
        followers of a box go, nothing is known of limits.
        """
        places, count = self.places, like.size
        near = list(self._worst(inside, places))
        where = np.array([each.place for each in near] or [np.zeros(count, dtype=int)])
        radicands, every = list[Sloped](), boxes.take(np.tile(np.arange(count), len(where)))
        driven = over_boxes(self.problem, every, places, where.ravel(), radicands)
        found = []
        for number, (claim, side, place) in enumerate(near):
            here = driven.part(slice(number * count, (number + 1) * count))
            excess = Excesses.of(as_sloped(_excess(claim, side, here, boxes), like))
            found.append(_where_known(excess, _is_about(claim, places, place, here.sense)))
        motion: Any = driven.part(slice(0, count))
        margins = self.problem.setup.mechanism.assembly_margins(boxes, motion)
        lacking = [_lack(each, 1) for each in margins if isinstance(each, Sloped)]
        lacking += [_lack(each, len(where)) for each in radicands]
        if self.least_angle:
            at_ends = list[Sloped]()
            angle = as_sloped(least_transmission(self.problem, boxes, at_ends), like)
            found.append(Excesses.of(1.0 - ROUNDED - angle / self.least_angle))
            lacking += [_lack(each, 1) for each in at_ends]
        return Said(found, lacking, _to_know(motion, like))

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


def _excess(claim: Claim, side: Any, motion: Driven, designs: Designs) -> Any:
    """What is above 0 where designs exceed a claim on one side."""
    made: Any = claim.curve
    order = _order(claim)
    value = motion.state[order] if order else curve(made(designs, motion), ..., motion.state)[0]
    return excess_of(claim, side, as_quotient(value), designs)


def _is_about(claim: Claim, places: ToolPlaces, where: IntArray, sense: FloatArray) -> Any:
    """Whether a claim is about the pieces of followers at places; not where their sense is not known."""
    kinds = np.where(sense > 0.0, places.kinds[where], np.where(sense < 0.0, places.against[where], 0))
    return kinds & claim.kinds != 0


def _where_known(over: Excesses, known: Any) -> Excesses:
    """Excesses that tell nothing of other boxes."""
    none = np.full(known.shape, np.inf)
    ends = (np.where(known, each, -none) for each in (over.least, over.at))
    return over._replace(least=next(ends), at=next(ends), most=np.where(known, over.most, none))


def _to_know(driven: Driven, like: Sloped) -> list[Excesses]:
    """Boxes are first cut until it is known which way their followers go."""
    moved = Excesses.of(as_sloped(driven.moved, like))
    return [moved._replace(at=np.where(driven.sense == 0.0, HUGE_SLOPE, -np.inf)[None])]


def _lack(margin: Sloped, rows: int) -> Excesses:
    """The excess of what has to be above 0, so many times one after the other."""
    scale = at_point(margin).largest_magnitude
    return Excesses.of(-margin / np.where(scale > 0.0, scale, 1.0), rows)

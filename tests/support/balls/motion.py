"""The motion of a turn in balls: from the numbers that it was made from, taken as exact."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, starmap
from math import factorial
from typing import NamedTuple, Self

from flint import arb, arb_series

from camopt.model.motion.law_panels import turning_points
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import TURN_PANELS, Programme
from camopt.model.motion.stroke import Stroke, reversed_kinds
from camopt.model.motion.tool_drive import DrivenLaw
from support.balls.ball import Ball, ball_between, precisely
from support.balls.driven import DrivenPiece, follower_at, narrow_derivatives, train_in_balls
from support.balls.laws import Stretch, stretches_of
from support.balls.load import LoadPart, LoadsInBalls

FIRST_PARTS = 8  # of each piece of a law, and line of a load
DERIVATIVES = 5  # of the motion, as curves take them, the displacement included
NARROWEST_PART = arb(2) ** -90


class ExactStroke(NamedTuple):
    """A segment of the turn in balls: cam angle in rad, displacement in mm or rad."""

    kind: int
    pieces: tuple[Stretch, ...]
    """Where its motion is smooth; none in a dwell."""
    angle: arb
    low: arb
    size: arb
    """What its law is multiplied by."""
    change: arb
    lines: tuple[LoadPart, ...] = ()
    """Of an external load that changes."""

    def smooth(self) -> Iterator[tuple[Stretch | None, LoadPart | None, arb, arb]]:
        """Where motion and load are smooth: the piece of the law (None in a dwell), the line, and the ends in x."""
        for piece in self.pieces or (None,):
            low, high = (piece.start, piece.end) if piece else (arb(0), arb(1))
            for line in self.lines or (None,):
                start, end = (low, high) if line is None else (low.max(line.start), high.min(line.end))
                if end > start:
                    yield piece, line, start, end


@dataclass(frozen=True)
class ExactMotion:
    """The exact turn; stands in for a Programme where formulas ask for the lift, and whether the load changes."""

    strokes: tuple[ExactStroke, ...]
    load: ExternalLoad | TrainLoad | None
    highest: arb | None = None
    """Of the turn, where that may be inside a stroke."""
    tool_programme: "ExactMotion | None" = None
    """The motion of the tool that the follower drives through a train, if there is one."""
    given_at_follower: bool = False

    @cached_property
    def parts(self) -> "tuple[TurnPart, ...]":
        """Where it is smooth."""
        return tuple(TurnPart(stroke, *smooth) for stroke in self.strokes for smooth in stroke.smooth())

    @property
    def tool(self) -> "ExactMotion":
        """The motion that is asked, as of a Programme."""
        return self.tool_programme or self

    @property
    def given_programme(self) -> "ExactMotion":
        """The motion that is given, as of a Programme."""
        return self if self.given_at_follower else self.tool

    @property
    def lift(self) -> Ball:
        levels = [stroke.low + stroke.change for stroke in self.strokes]
        highest = max(levels, key=lambda level: float(level.mid())) if self.highest is None else self.highest
        return Ball(highest)


@precisely()
def exact_motion(programme: Programme) -> ExactMotion:
    """The turn of a programme, the numbers that it was made from taken as exact."""
    if programme.reverse_of is not None:
        return _reversed_motion(exact_motion(programme.reverse_of), arb(programme.reverse_of.lift))
    if programme.tool_programme is None:
        return _given_motion(programme, None if programme.load is None else LoadsInBalls(programme.load))
    if programme.given_at_follower:
        follower = _given_motion(programme, _loads_of_train(programme))
        tool = replace(_follower_motion(programme.tool_programme, follower), tool_programme=None)
        return replace(follower, tool_programme=tool, given_at_follower=True)
    return _follower_motion(programme, exact_motion(programme.tool_programme))


def _reversed_motion(motion: ExactMotion, lift: arb) -> ExactMotion:
    """The turn with the displacement lift − y, without loads and train."""
    turned = (
        each._replace(
            kind=int(reversed_kinds(each.kind)), low=lift - each.low, size=-each.size, change=-each.change, lines=()
        )
        for each in motion.strokes
    )
    return ExactMotion(tuple(turned), None)


def has_monotone_strokes(programme: Programme) -> bool:
    """Whether the follower turns back only between strokes."""
    return not any(s.law and (s.is_move or turning_points(s.law, TURN_PANELS)) for s in programme.strokes)


def _loads_of_train(programme: Programme) -> LoadsInBalls | None:
    """What comes through a train to a follower whose own motion is given."""
    load = programme.load
    if not isinstance(load, TrainLoad):
        return None if load is None else LoadsInBalls(load)
    return LoadsInBalls(load, train_in_balls(load.train), arb(load.zero), has_monotone_strokes(programme))


def _given_motion(programme: Programme, loads: LoadsInBalls | None) -> ExactMotion:
    """The turn of a programme that nothing drives."""
    degree, strokes, start = arb.pi() / 180, [], arb(0)
    level = arb(programme.start) * _unit(programme.strokes[0])
    for stroke in programme.strokes:
        angle, change, size = _stroke_in_degrees(stroke)
        lines = loads.parts(stroke.kind, start, angle) if loads else ()
        pieces = stretches_of(stroke.law) if stroke.law else ()
        strokes.append(ExactStroke(stroke.kind, pieces, angle * degree, level, size, change, lines))
        level, start = level + change, start + angle
    return ExactMotion(tuple(strokes), programme.load)


def _follower_motion(programme: Programme, tool: ExactMotion) -> ExactMotion:
    """The turn of a follower that drives a tool, from that of the tool in balls."""
    law = next(stroke.law for stroke in programme.strokes if isinstance(stroke.law, DrivenLaw))
    train, zero = train_in_balls(law.train), arb(law.zero)
    level, strokes, start = arb(programme.start), [], arb(0)
    loads = None
    if programme.load is not None:
        counted = follower_at(train, zero + tool.strokes[0].low) - level
        loads = LoadsInBalls(programme.load, train, counted, has_monotone_strokes(programme))
    for stroke, asked in zip(programme.strokes, tool.strokes, strict=True):
        low = zero + asked.low
        begins, ends = (follower_at(train, each) for each in (low, low + asked.change))
        pieces = tuple(DrivenPiece(piece, low, asked.size, train, begins) for piece in asked.pieces)
        angle = asked.angle * 180 / arb.pi()
        lines = loads.parts(stroke.kind, start, angle) if loads else ()
        strokes.append(ExactStroke(stroke.kind, pieces, asked.angle, level, arb(1), ends - begins, lines))
        level, start = level + ends - begins, start + angle
    return ExactMotion(tuple(strokes), programme.load, tool_programme=tool)


def _unit(stroke: Stroke) -> arb:
    """Of displacements as given, in mm (rad)."""
    return arb.pi() / 180 if stroke.given and stroke.given.angular else arb(1)


def _stroke_in_degrees(stroke: Stroke) -> tuple[arb, arb, arb]:
    """The cam angle of a stroke in deg, its change of displacement, and its size, in mm (rad)."""
    if stroke.given is None:
        change = arb(stroke.high) - arb(stroke.low)
        return stroke.angle * 180 / arb.pi(), change, change
    change = arb(stroke.given.change) * _unit(stroke)
    return arb(stroke.given.angle), change, _unit(stroke) * stroke.way if stroke.is_move else change


def motion_at(stroke: ExactStroke, piece: Stretch | None, x: arb, line: LoadPart | None = None) -> list[Ball]:
    """Balls of y and its first four derivatives by the cam angle over a ball of x; loads and their slopes too."""
    return _stroke_values(stroke, None if piece is None else narrow_derivatives(piece, DERIVATIVES, x), x, line)


def _stroke_values(stroke: ExactStroke, law: list[arb] | None, x: arb, line: LoadPart | None) -> list[Ball]:
    """The same from a law and its derivatives by x; of a dwell None."""
    rows = [stroke.size * row / stroke.angle**k for k, row in enumerate(law)] if law else [arb(0)] * DERIVATIVES
    rows[0] = stroke.low + rows[0]
    load = [] if line is None else line.series(x, stroke.angle, series_of(rows, DERIVATIVES))
    return [*map(Ball, rows), *(Ball(each[k]) for each in load for k in (0, 1))]


def series_of(rows: list[arb], terms: int) -> arb_series:
    """The series with some derivatives."""
    return arb_series([row / factorial(k) for k, row in enumerate(rows)], terms)


@dataclass(eq=False)
class TurnPart:
    """A part of a stroke where motion and load are smooth, from one x to another.

    What is found of it is kept, for all that is asked of the same motion.
    """

    stroke: ExactStroke
    piece: Stretch | None
    line: LoadPart | None
    low: arb
    high: arb

    @cached_property
    def whole(self) -> arb:
        return ball_between(self.low, self.high)

    @cached_property
    def middle(self) -> arb:
        return self.whole.mid()

    @property
    def narrow(self) -> bool:
        """Whether it is not to be cut."""
        return bool(self.high - self.low < NARROWEST_PART)

    @property
    def angle(self) -> arb:
        """Its cam angle, rad."""
        return (self.high - self.low) * self.stroke.angle

    @property
    def away(self) -> arb:
        """Cam angles from the middle, rad."""
        return (self.whole - self.middle) * self.stroke.angle

    @cached_property
    def first(self) -> tuple[Self, ...]:
        """It in some, equally long; nothing changes over a dwell without a load that does, which is one point."""
        if self.piece is None and self.line is None:
            return (self._between(self.low, self.low),)
        ends = (self.low + (self.high - self.low) * k / FIRST_PARTS for k in range(FIRST_PARTS + 1))
        return tuple(starmap(self._between, pairwise(ends)))

    @cached_property
    def halves(self) -> tuple[Self, Self]:
        return self._between(self.low, self.middle), self._between(self.middle, self.high)

    def _between(self, low: arb, high: arb) -> Self:
        return type(self)(self.stroke, self.piece, self.line, low, high)

    @cached_property
    def over(self) -> list[Ball]:
        """The motion over it all, as of ``motion_at``."""
        law = None if self.piece is None else narrow_derivatives(self.piece, DERIVATIVES, self.whole, self._law)
        return _stroke_values(self.stroke, law, self.whole, self.line)

    @cached_property
    def in_middle(self) -> list[Ball]:
        """The motion in its middle."""
        return _stroke_values(self.stroke, self._law, self.middle, self.line)

    @cached_property
    def _law(self) -> list[arb] | None:
        """The law and its derivatives in the middle."""
        return None if self.piece is None else self.piece.derivatives(DERIVATIVES, self.middle)

    def at(self, x: arb) -> list[Ball]:
        """The motion at an x of it."""
        return motion_at(self.stroke, self.piece, x, self.line)

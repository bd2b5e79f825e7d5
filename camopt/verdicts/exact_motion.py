"""The motion of a turn in balls: from the numbers that it was made from, taken as exact."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from flint import arb

from camopt.motion.law import Law
from camopt.motion.load import ExternalLoad
from camopt.motion.programme import Programme
from camopt.motion.stroke import Stroke
from camopt.verdicts.ball import Ball, precisely
from camopt.verdicts.exact_laws import Stretch, stretches_of
from camopt.verdicts.exact_load import LoadLine, lines_of


class ExactStroke(NamedTuple):
    """A segment of the turn in balls: cam angle in rad, displacement in mm or rad."""

    kind: int
    law: Law | None
    angle: arb
    low: arb
    size: arb
    """What its law is multiplied by."""
    change: arb
    lines: tuple[LoadLine, ...] = ()
    """Of an external load that changes."""

    def smooth(self) -> Iterator[tuple[Stretch | None, LoadLine | None, arb, arb]]:
        """Where motion and load are smooth: the piece of the law (None in a dwell), the line, and the ends in x."""
        for piece in stretches_of(self.law) if self.law else (None,):
            low, high = (piece.start, piece.end) if piece else (arb(0), arb(1))
            for line in self.lines or (None,):
                start, end = (low, high) if line is None else (low.max(line.start), high.min(line.end))
                if end > start:
                    yield piece, line, start, end


@dataclass(frozen=True)
class ExactMotion:
    """The exact turn; stands in for a Programme where formulas ask for the lift, and whether the load changes."""

    strokes: tuple[ExactStroke, ...]
    load: ExternalLoad | None
    highest: arb | None = None
    """Of the turn, where that may be inside a stroke."""

    @property
    def lift(self) -> Ball:
        levels = [stroke.low + stroke.change for stroke in self.strokes]
        highest = max(levels, key=lambda level: float(level.mid())) if self.highest is None else self.highest
        return Ball(highest)


@precisely()
def exact_motion(programme: Programme) -> ExactMotion:
    """The turn of a programme, the numbers that it was made from taken as exact."""
    degree, strokes, start = arb.pi() / 180, [], arb(0)
    level = arb(programme.start) * _unit(programme.strokes[0])
    for stroke in programme.strokes:
        angle, change, size = _given(stroke)
        lines = () if programme.load is None else tuple(lines_of(programme.load, start, angle))
        strokes.append(ExactStroke(stroke.kind, stroke.law, angle * degree, level, size, change, lines))
        level, start = level + change, start + angle
    return ExactMotion(tuple(strokes), programme.load)


def _unit(stroke: Stroke) -> arb:
    """Of displacements as given, in mm (rad)."""
    return arb.pi() / 180 if stroke.given and stroke.given.angular else arb(1)


def _given(stroke: Stroke) -> tuple[arb, arb, arb]:
    """The cam angle of a stroke in deg, its change of displacement, and its size, in mm (rad)."""
    if stroke.given is None:
        change = arb(stroke.high) - arb(stroke.low)
        return stroke.angle * 180 / arb.pi(), change, change
    change = arb(stroke.given.change) * _unit(stroke)
    return arb(stroke.given.angle), change, _unit(stroke) if stroke.is_move else change


def motion_at(stroke: ExactStroke, piece: Stretch | None, x: arb, line: LoadLine | None = None) -> list[Ball]:
    """Balls of y and its first four derivatives by the cam angle over a ball of x; load and slope of a line too."""
    rows = [arb(0)] * 5
    if piece is not None:
        rows = [stroke.size * row / stroke.angle**k for k, row in enumerate(_derivatives(piece, x))]
    load = [] if line is None else [line.at(x), line.slope / stroke.angle]
    return [Ball(stroke.low + rows[0]), *map(Ball, rows[1:] + load)]


def _derivatives(piece: Stretch, x: arb) -> list[arb]:
    """s and its first four derivatives over a ball: each where both the ball and its next derivative have it.

    Beside a dwell s′ falls with the square of the distance, its ball only with the width of the ball of x.
    """
    rows = piece.derivatives(5, x)
    if x.is_exact():
        return rows
    middle = x.mid()
    there = piece.derivatives(4, middle)
    for k in reversed(range(4)):
        rows[k] = rows[k].intersection(there[k] + rows[k + 1] * (x - middle))
    return rows

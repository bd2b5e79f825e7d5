"""The motion of a follower that drives a tool through a train in balls: the formulas of ``trains``, run on balls.

What links are made from, numbers of their start position found and rounded among it, is taken as exact.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from math import factorial
from typing import Any

from flint import arb, arb_series

from camopt.model.trains.train import Train
from support.balls.ball import precisely

POINT = 1e-40
"""The radius of a ball that is a point but for rounding."""


@dataclass(frozen=True)
class DrivenPiece:
    """The motion of the follower while that of the tool is smooth, over x from ``start`` to ``end``."""

    tool: Any
    """A smooth part of the tool's law."""
    low: arb
    """Where the tool's stroke starts, from the start position of the train, mm (rad)."""
    size: arb
    """What the tool's law is multiplied by."""
    train: Train
    """With balls in place of its numbers."""
    begins: arb
    """Where the follower's stroke starts."""

    @property
    def start(self) -> arb:
        start: arb = self.tool.start
        return start

    @property
    def end(self) -> arb:
        end: arb = self.tool.end
        return end

    def derivative(self, order: int, x: arb) -> arb:
        """A derivative by x over a ball of x; of the displacement, from where the stroke starts."""
        return self.derivatives(order + 1, x)[order]

    def derivatives(self, count: int, x: arb) -> list[arb]:
        """The displacement from where the stroke starts, and its derivatives by x, over a ball of x."""
        rows = narrow_derivatives(self.tool, count, x)
        terms = [self.size * row / factorial(k) for k, row in enumerate(rows)]
        series = self.train.follower_displacement(arb_series([self.low + terms[0], *terms[1:]], count))
        first, *rest = (series[k] * factorial(k) for k in range(count))
        return [first - self.begins, *rest]


def narrow_derivatives(piece: Any, count: int, x: arb, there: list[arb] | None = None) -> list[arb]:
    """s and its derivatives over a ball: each where both the ball and its next derivative have it.

    ``there`` are those in the middle, if they are known.

    Beside a dwell s′ falls with the square of the distance, its ball only with the width of the ball of x.
    """
    rows: list[arb] = piece.derivatives(count, x)
    if x.rad() <= POINT:
        return rows
    middle = x.mid()
    there = there or piece.derivatives(count - 1, middle)
    for k in reversed(range(count - 1)):
        rows[k] = rows[k].intersection(there[k] + rows[k + 1] * (x - middle))
    return rows


@cache
@precisely()
def train_in_balls(train: Train) -> Train:
    """A train with balls in place of its numbers."""
    links, carried = (tuple(map(_in_balls, each)) for each in (train.links, train.carried))
    return replace(train, links=links, carried=carried)


def _in_balls(value: Any) -> Any:
    if isinstance(value, float):
        return arb(value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{each.name: _in_balls(getattr(value, each.name)) for each in fields(value)})
    return value


def follower_at(train: Train, tool: arb) -> arb:
    """Where the follower is, of a train in balls."""
    found: arb = train.follower_displacement(arb_series([tool], 1))[0]
    return found

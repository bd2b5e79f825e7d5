"""External loads that change over the turn, in balls: lines between rows, and what comes through a train."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from flint import arb, arb_series

from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.stroke import RETURN, RISE
from camopt.model.trains.train import Train

WAY = {RISE: arb(1), RETURN: arb(-1)}
"""Which way a follower moves in a stroke whose motion does not turn back."""


class LoadLine(NamedTuple):
    """A load over a part of a stroke: from ``start`` to ``end`` of x, its value at the start, its slope by x."""

    start: arb
    end: arb
    load: arb
    slope: arb

    def at(self, x: arb) -> arb:
        return self.load + self.slope * (x - self.start)

    def series(self, x: arb, angle: arb, follower: arb_series) -> list[arb_series]:
        """The load about x as a series by the cam angle, of a stroke of an angle in rad."""
        return [arb_series([self.at(x), self.slope / angle], follower.prec)]


@dataclass(frozen=True)
class ThroughTrain:
    """What comes through a train over a part of a stroke, from ``start`` to ``end`` of x."""

    start: arb
    end: arb
    load: TrainLoad
    train: Train
    """Its train, with balls in place of its numbers."""
    zero: arb
    """Where the follower's displacement counts from."""
    loads: tuple[tuple[int, LoadLine], ...]
    """Loads that change, by joint."""
    way: arb | None
    """Which way the follower moves there, where that is known."""

    def series(self, x: arb, angle: arb, follower: arb_series) -> list[arb_series]:
        """S and I (``trains.carried_load``) about x as series by the cam angle, from that of the displacement."""
        loads = {joint: line.series(x, angle, follower)[0] for joint, line in self.loads}
        way = follower[1].sgn() if self.way is None else self.way
        return list(self.load.follower_load(self.train, follower + self.zero, way, loads))


LoadPart = LoadLine | ThroughTrain


class LoadsInBalls(NamedTuple):
    """The load of a programme in balls."""

    load: ExternalLoad | TrainLoad
    train: Train | None = None
    """Of a load through a train: it, with balls in place of its numbers."""
    zero: arb | None = None
    """And where the follower's displacement counts from."""
    monotone: bool = False
    """Whether the follower turns back only between strokes."""

    def parts(self, kind: int, start: arb, angle: arb) -> tuple[LoadPart, ...]:
        """Where it is smooth, in a stroke of a kind, start and angle, deg."""
        if not isinstance(self.load, TrainLoad):
            return tuple(lines_of(self.load, start, angle))
        assert self.train is not None
        assert self.zero is not None
        way = WAY.get(kind) if self.monotone else None
        lines: list[tuple[tuple[int, LoadLine], ...]] = [()]
        for joint, load in self.load.loads:
            lines = [(*known, (joint, line)) for known in lines for line in lines_of(load, start, angle)]
        found = []
        for known in lines:
            low, high = arb(0), arb(1)
            for _, line in known:
                low, high = low.max(line.start), high.min(line.end)
            if high > low:
                found.append(ThroughTrain(low, high, self.load, self.train, self.zero, known, way))
        return tuple(found)


def lines_of(external: ExternalLoad, start: arb, angle: arb) -> Iterator[LoadLine]:
    """The lines of a load that reach into a stroke of a given start and angle, deg; its rows are taken as exact."""
    turn = [(arb(x), arb(load) * external.unit) for x, load in external.rows]
    (first, one), (last, other) = turn[0], turn[-1]
    for (left, before), (right, after) in pairwise([(last - 360, other), *turn, (first + 360, one)]):
        low, high = (left - start) / angle, (right - start) / angle
        if high > low and high > 0 and low < 1:
            yield LoadLine(low, high, before, (after - before) / (high - low))

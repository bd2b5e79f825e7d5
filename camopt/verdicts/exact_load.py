"""An external load that changes over the turn, in balls: the straight lines between the rows of its table."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from flint import arb

from camopt.motion.load import ExternalLoad


class LoadLine(NamedTuple):
    """A load over a part of a stroke: from ``start`` to ``end`` of x, its value at the start, its slope by x."""

    start: arb
    end: arb
    load: arb
    slope: arb

    def at(self, x: arb) -> arb:
        return self.load + self.slope * (x - self.start)


def lines_of(external: ExternalLoad, start: arb, angle: arb) -> Iterator[LoadLine]:
    """The lines of a load that reach into a stroke of a given start and angle, deg; its rows are taken as exact."""
    turn = [(arb(x), arb(load) * external.unit) for x, load in external.rows]
    (first, one), (last, other) = turn[0], turn[-1]
    for (left, before), (right, after) in pairwise([(last - 360, other), *turn, (first + 360, one)]):
        low, high = (left - start) / angle, (right - start) / angle
        if high > low and high > 0 and low < 1:
            yield LoadLine(low, high, before, (after - before) / (high - low))

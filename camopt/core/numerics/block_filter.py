"""The designs of a block sorted out by what their pitch curves tell: kernels, for they pass over every design.

First they are counted, and the least cost of those of each size of the cam is found. From that follows what a
design of each size may cost without another one that is better; those that cost no more are gathered, or all.
"""

from typing import NamedTuple

import numpy as np

from camopt.core.kernels.compile import compiled_for_many
from camopt.core.numerics import BoolArray, FloatArray, IntArray

FILTER_WORK = 0.1  # of the value of a curve: numpy compares a few numbers for each design


class RadiusRanges(NamedTuple):
    """From and to, of each curve (curves,)."""

    least: FloatArray
    most: FloatArray


class PitchVerdicts(NamedTuple):
    """What pitch curves tell of the designs that share them."""

    exists: BoolArray
    """Whether the designs can be assembled, (curves,)."""
    places: IntArray
    """Where in the following arrays each curve is, (curves,); all that break a limit have one place."""
    sure_bodies: RadiusRanges
    """The bodies with which they hold all limits for certain, from and to, mm."""
    possible_bodies: RadiusRanges
    """And those with which they may."""
    cost: FloatArray
    """What their designs cost by the one objective in which those of equal size may differ."""


class DesignBlock(NamedTuple):
    """The designs of a block, with the sizes of the cam fastest."""

    curves: IntArray
    """The number of the pitch curve of each."""
    bodies: FloatArray
    """The radius of the body that follows it, mm."""
    place: int
    """The place of the first among the sizes."""


class BlockCounts(NamedTuple):
    """How many designs of a block can be assembled, hold all limits for certain, and may hold them."""

    existing: int
    held: int
    open: int


def count_designs(known: PitchVerdicts, block: DesignBlock, sizes: int) -> tuple[BlockCounts, FloatArray]:
    """The counts of a block, and the least cost of what surely holds all limits, of each of so many sizes."""
    counts, least = np.zeros(3, np.int64), np.full(sizes, np.inf)
    count_block(known, block.curves, block.bodies, block.place, least, counts)
    return BlockCounts(*counts.tolist()), least


class FeasibleDesigns(NamedTuple):
    """Designs of a block, by number in it."""

    held: IntArray
    """Those that surely hold all limits, or such of them as cost at most what those of their size may."""
    cheap: BoolArray
    """Which of these cost no more than that."""
    open: IntArray
    """Those that may hold all limits."""


def gather_designs(
    known: PitchVerdicts, block: DesignBlock, counts: BlockCounts, most: FloatArray, every: bool
) -> FeasibleDesigns:
    """Designs of a block that hold all limits: ``every`` one, or those of each size that cost at most so much."""
    held, open_ = np.empty(counts.held, np.int64), np.empty(counts.open, np.int64)
    found = FeasibleDesigns(held, np.empty(counts.held, np.bool_), open_)
    count = np.zeros(1, np.int64)
    gather_block(known, block.curves, block.bodies, block.place, most, every, found, count)
    return FeasibleDesigns(found.held[: count[0]], found.cheap[: count[0]], found.open)


@compiled_for_many(work=FILTER_WORK)
def count_block(known, curves, bodies, place, least, counts):
    """Fill the counts of a block and the least costs of each size."""
    existing, held, some = 0, 0, 0
    for i in range(curves.size):
        at, body = known.places[curves[i]], bodies[i]
        existing += known.exists[curves[i]]
        surely = (known.sure_bodies.least[at] <= body) & (body <= known.sure_bodies.most[at])
        held += surely
        some += (known.possible_bodies.least[at] <= body) & (body <= known.possible_bodies.most[at])
        if surely and known.cost[at] < least[place]:
            least[place] = known.cost[at]
        place = place + 1 if place + 1 < least.size else 0
    counts[0], counts[1], counts[2] = existing, held, some - held


@count_block.array_version
def _count_block_in_python(known, curves, bodies, place, least, counts):
    at = known.places[curves]
    held, some = (
        np.flatnonzero(_is_in_radius_range(known.sure_bodies, at, bodies)),
        _is_in_radius_range(known.possible_bodies, at, bodies),
    )
    np.minimum.at(least, (place + held) % least.size, known.cost[at[held]])
    counts[:] = np.count_nonzero(known.exists[curves]), held.size, np.count_nonzero(some) - held.size


def _is_in_radius_range(those, at, bodies):
    """Which bodies are in the range of their curve."""
    return (those.least[at] <= bodies) & (bodies <= those.most[at])


@compiled_for_many(work=FILTER_WORK)
def gather_block(known, curves, bodies, place, most, every, found, count):
    """Fill the designs of a block that are wanted, and how many of those hold all limits for certain."""
    told, some = 0, 0
    for i in range(curves.size):
        at, body = known.places[curves[i]], bodies[i]
        if (known.sure_bodies.least[at] <= body) & (body <= known.sure_bodies.most[at]):
            cheap = known.cost[at] <= most[place]
            if every or cheap:
                found.held[told], found.cheap[told] = i, cheap
                told += 1
        elif (known.possible_bodies.least[at] <= body) & (body <= known.possible_bodies.most[at]):
            found.open[some] = i
            some += 1
        place = place + 1 if place + 1 < most.size else 0
    count[0] = told


@gather_block.array_version
def _gather_block_in_python(known, curves, bodies, place, most, every, found, count):
    at = known.places[curves]
    surely, perhaps = (
        _is_in_radius_range(those, at, bodies) for those in (known.sure_bodies, known.possible_bodies)
    )
    found.open[:], told = np.flatnonzero(perhaps & ~surely), np.flatnonzero(surely)
    cheap = known.cost[at[told]] <= most[(place + told) % most.size]
    told, cheap = (told, cheap) if every else (told[cheap], cheap[cheap])
    found.held[: told.size], found.cheap[: told.size], count[0] = told, cheap, told.size

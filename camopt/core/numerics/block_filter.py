"""Filter the designs of a block by the verdicts on their pitch curves, with kernels that pass over every design.

A first pass counts the designs and finds the lowest cost for each size of the cam. From it follows the highest cost
at which no other design of that size is better. A second pass gathers the designs up to this cost, or all of them.
"""

from typing import NamedTuple

import numpy as np

from camopt.core.kernels.compile import compiled_once_it_pays
from camopt.core.numerics import BoolArray, FloatArray, IntArray

FILTER_WORK = 0.1  # work per design, in values of a curve: numpy compares a few numbers


class RadiusRanges(NamedTuple):
    """Range of the radius for each curve (curves,)."""

    least: FloatArray
    most: FloatArray


class PitchVerdicts(NamedTuple):
    """Verdicts on the designs that share each pitch curve."""

    exists: BoolArray
    """Whether the designs can be assembled, (curves,)."""
    places: IntArray
    """Place of each curve in the following arrays (curves,); all curves that break a limit share one place."""
    sure_bodies: RadiusRanges
    """Radii of bodies with which the designs are proved to hold all limits [mm]."""
    possible_bodies: RadiusRanges
    """Radii of bodies with which the designs may hold all limits [mm]."""
    cost: FloatArray
    """Cost of the designs by the one objective in which designs of equal size may differ."""


class DesignBlock(NamedTuple):
    """The designs of a block; the size of the cam varies fastest."""

    curves: IntArray
    """Pitch curve of each design, by number."""
    bodies: FloatArray
    """Radius of each design's body [mm]."""
    place: int
    """Place of the first design among the sizes."""


class BlockCounts(NamedTuple):
    """Numbers of designs that can be assembled, are proved to hold all limits, and may hold them."""

    existing: int
    held: int
    open: int


def block_counts_and_least_costs(
    verdicts: PitchVerdicts, block: DesignBlock, size_count: int
) -> tuple[BlockCounts, FloatArray]:
    """Counts of a block, and for each size the lowest cost of designs that are proved to hold all limits."""
    counts, least = np.zeros(3, np.int64), np.full(size_count, np.inf)
    write_block_counts_and_least_costs(verdicts, block.curves, block.bodies, block.place, least, counts)
    return BlockCounts(*counts.tolist()), least


class FeasibleDesigns(NamedTuple):
    """Designs of a block, by their numbers in it."""

    held: IntArray
    """Designs that are proved to hold all limits; all of them, or those whose cost is allowed for their size."""
    cheap: BoolArray
    """Whether the cost of each is allowed for its size."""
    open: IntArray
    """Designs that may hold all limits."""


def gather_feasible_designs(
    verdicts: PitchVerdicts, block: DesignBlock, counts: BlockCounts, cost_limits: FloatArray, include_costly: bool
) -> FeasibleDesigns:
    """Gather the feasible designs of a block: all (``include_costly``), or those up to the cost of their size."""
    held, open_ = np.empty(counts.held, np.int64), np.empty(counts.open, np.int64)
    found = FeasibleDesigns(held, np.empty(counts.held, np.bool_), open_)
    count = np.zeros(1, np.int64)
    write_feasible_designs(
        verdicts, block.curves, block.bodies, block.place, cost_limits, include_costly, found, count
    )
    return FeasibleDesigns(found.held[: count[0]], found.cheap[: count[0]], found.open)


@compiled_once_it_pays(work=FILTER_WORK)
def write_block_counts_and_least_costs(verdicts, curve_numbers, body_radii, size_index, least_costs, counts):
    """Write the counts of a block and the lowest cost for each size."""
    existing, held, possible = 0, 0, 0
    for i in range(curve_numbers.size):
        at, body = verdicts.places[curve_numbers[i]], body_radii[i]
        existing += verdicts.exists[curve_numbers[i]]
        surely = (verdicts.sure_bodies.least[at] <= body) & (body <= verdicts.sure_bodies.most[at])
        held += surely
        possible += (verdicts.possible_bodies.least[at] <= body) & (body <= verdicts.possible_bodies.most[at])
        if surely and verdicts.cost[at] < least_costs[size_index]:
            least_costs[size_index] = verdicts.cost[at]
        size_index = size_index + 1 if size_index + 1 < least_costs.size else 0
    counts[0], counts[1], counts[2] = existing, held, possible - held


@write_block_counts_and_least_costs.array_version
def _write_block_counts_in_python(verdicts, curve_numbers, body_radii, size_index, least_costs, counts):
    at = verdicts.places[curve_numbers]
    held, possible = (
        np.flatnonzero(_bodies_in_radius_range(verdicts.sure_bodies, at, body_radii)),
        _bodies_in_radius_range(verdicts.possible_bodies, at, body_radii),
    )
    np.minimum.at(least_costs, (size_index + held) % least_costs.size, verdicts.cost[at[held]])
    counts[:] = np.count_nonzero(verdicts.exists[curve_numbers]), held.size, np.count_nonzero(possible) - held.size


def _bodies_in_radius_range(ranges, curve_places, body_radii):
    """Which bodies are within the range of their curve."""
    return (ranges.least[curve_places] <= body_radii) & (body_radii <= ranges.most[curve_places])


@compiled_once_it_pays(work=FILTER_WORK)
def write_feasible_designs(
    verdicts, curve_numbers, body_radii, size_index, cost_limits, include_costly, feasible, count
):
    """Write the gathered designs of a block, and the number of those that are proved to hold all limits."""
    held_count, open_count = 0, 0
    for i in range(curve_numbers.size):
        at, body = verdicts.places[curve_numbers[i]], body_radii[i]
        if (verdicts.sure_bodies.least[at] <= body) & (body <= verdicts.sure_bodies.most[at]):
            cheap = verdicts.cost[at] <= cost_limits[size_index]
            if include_costly or cheap:
                feasible.held[held_count], feasible.cheap[held_count] = i, cheap
                held_count += 1
        elif (verdicts.possible_bodies.least[at] <= body) & (body <= verdicts.possible_bodies.most[at]):
            feasible.open[open_count] = i
            open_count += 1
        size_index = size_index + 1 if size_index + 1 < cost_limits.size else 0
    count[0] = held_count


@write_feasible_designs.array_version
def _write_feasible_designs_in_python(
    verdicts, curve_numbers, body_radii, size_index, cost_limits, include_costly, feasible, count
):
    at = verdicts.places[curve_numbers]
    surely, perhaps = (
        _bodies_in_radius_range(ranges, at, body_radii)
        for ranges in (verdicts.sure_bodies, verdicts.possible_bodies)
    )
    feasible.open[:], held = np.flatnonzero(perhaps & ~surely), np.flatnonzero(surely)
    cheap = verdicts.cost[at[held]] <= cost_limits[(size_index + held) % cost_limits.size]
    held, cheap = (held, cheap) if include_costly else (held[cheap], cheap[cheap])
    feasible.held[: held.size], feasible.cheap[: held.size], count[0] = held, cheap, held.size

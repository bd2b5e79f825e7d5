"""Designs of a block sorted out by their pitch curves, compiled and not, against one design after another."""

import numpy as np
import pytest

from camopt.core.kernels.arguments import kernel_argument_type
from camopt.core.kernels.compile import NEVER_COMPILE
from camopt.core.numerics import block_filter
from camopt.core.numerics.block_filter import (
    DesignBlock,
    PitchVerdicts,
    RadiusRanges,
    block_counts_and_least_costs,
    gather_feasible_designs,
)

CURVES, PLACES, DESIGNS = 40, 30, 700


def of_chance(rng):
    """Curves and designs with many ties, some infinite costs and some empty ranges."""
    least, most = rng.integers(0, 4, (2, PLACES)), rng.integers(0, 9, (2, PLACES))
    surely = RadiusRanges(*np.array([least.max(axis=0), most.min(axis=0)], dtype=float))
    perhaps = RadiusRanges(*np.array([least.min(axis=0), most.max(axis=0)], dtype=float))
    cost = rng.choice([1.0, 2.0, 3.0, np.inf], PLACES)
    known = PitchVerdicts(rng.random(CURVES) < 0.8, rng.integers(0, PLACES, CURVES), surely, perhaps, cost)
    return known, DesignBlock(
        rng.integers(0, CURVES, DESIGNS), rng.integers(0, 9, DESIGNS) / 1.0, int(rng.integers(0, 5))
    )


def dominance_by_loop(known, block, sizes, most):
    """The counts, the least costs, and the designs that are told."""
    existing, held, open_, least, told = 0, 0, [], np.full(sizes, np.inf), []
    for i, (curve, body) in enumerate(zip(block.curves, block.bodies, strict=True)):
        place, at = (block.place + i) % sizes, known.places[curve]
        existing += known.exists[curve]
        if known.sure_bodies.least[at] <= body <= known.sure_bodies.most[at]:
            held += 1
            least[place] = min(least[place], known.cost[at])
            told += [i] if known.cost[at] <= most[place] else []
        elif known.possible_bodies.least[at] <= body <= known.possible_bodies.most[at]:
            open_.append(i)
    return (existing, held, len(open_)), least, told, open_


@pytest.fixture(
    params=["plain", pytest.param("compiled", marks=pytest.mark.skipif(NEVER_COMPILE, reason="not compiled"))]
)
def way(request, monkeypatch):
    if request.param == "compiled":
        for name in ("write_block_counts_and_least_costs", "write_feasible_designs"):
            kernel = getattr(block_filter, name)

            def compiled(*given, kernel=kernel):
                kernel.machine_code(tuple(map(kernel_argument_type, given)))(given)

            monkeypatch.setattr(block_filter, name, compiled)


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("sizes", [1, 5, 1000])
def test_a_block_is_sorted_out_as_one_design_after_another(sizes):
    rng = np.random.default_rng(5)
    for _ in range(5):
        known, block = of_chance(rng)
        counts, least = block_counts_and_least_costs(known, block, sizes)
        most = rng.choice([-np.inf, 1.0, 2.0, np.inf], sizes)
        expected, cheapest, told, open_ = dominance_by_loop(known, block, sizes, most)
        assert tuple(counts) == expected
        assert np.array_equal(least, cheapest)
        found = gather_feasible_designs(known, block, counts, most, include_costly=False)
        assert (found.held.tolist(), found.open.tolist()) == (told, open_)
        assert found.cheap.all()
        whole = gather_feasible_designs(known, block, counts, most, include_costly=True)
        assert (whole.held.size, whole.open.tolist()) == (counts.held, open_)
        assert whole.held[whole.cheap].tolist() == told

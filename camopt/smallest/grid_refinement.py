"""Better designs near another one, by finer and finer grids around the best so far. A search without proof."""

from collections.abc import Callable
from math import inf

import numpy as np

from camopt.mechanisms import Designs
from camopt.mechanisms.design import SizeBounds
from camopt.numerics import FloatArray
from camopt.numerics.clock import now
from camopt.problem.problem import Problem
from camopt.smallest.result import discs_of, size_of
from camopt.verdicts.judging import bound_excesses, least_excess
from camopt.verdicts.screening import feasible

STEPS = 7  # of a grid along each free size
SHRINKS = 2.5  # the factor from grid to grid
NEAR, CLOSE = 12, 22  # grids: 1e-5 and 1e-9 of the first

Preference = Callable[[Designs, FloatArray], int]
"""The best of some designs, by their excesses over the limits of all that have to hold them, (limits, designs)."""


def nearest_miss(problem: Problem, bounds: SizeBounds, design: Designs, until: float = inf) -> Designs:
    """A design that exceeds its limits less than the given one; the best so far after ``until`` (``clock.now``)."""
    return _zoomed(problem, bounds, design, lambda designs, excess: least_excess(excess), NEAR, until)


def shrink_on_grids(
    problem: Problem, bounds: SizeBounds, design: Designs, zooms: int = NEAR, until: float = inf
) -> Designs | None:
    """A feasible design near the given one, which need not be feasible, as small as grids show; None if none is."""

    discs = discs_of(bounds)

    def smallest(designs: Designs, excess: FloatArray) -> int:
        worst = np.max(excess, axis=0, initial=-inf)
        size = np.where(worst <= 0.0, size_of(designs, discs), inf)
        return int(np.lexsort((worst, size))[0])  # of one size the one with the most room

    found = _zoomed(problem, bounds, design, smallest, zooms, until)
    return found if feasible(problem, found)[0] else None


def _zoomed(
    problem: Problem, bounds: SizeBounds, design: Designs, choice: Preference, zooms: int, until: float = inf
) -> Designs:
    free = {name: ends for name, ends in bounds.items() if ends[1] > ends[0]}
    spans = {name: (b - a) / 8 if np.isfinite(b - a) else inf for name, (a, b) in free.items()}
    spans["size"] = min(spans.get("size", inf), float(design.prime_radius[0]) / 4)
    for _ in range(zooms):
        if now() > until:
            break
        steps = [np.linspace(-1, 1, STEPS) * spans[name] for name in free]
        mesh = [m.ravel() for m in np.meshgrid(*steps, indexing="ij")]
        moved = {n: np.clip(design.values[n] + m, *free[n]) for n, m in zip(free, mesh, strict=True)}
        ones = np.ones(mesh[0].size if mesh else 1)
        points = design.with_values({n: moved.get(n, v * ones) for n, v in design.values.items()})
        points = points.take(problem.setup.mechanism.exists(points, problem.programme) & (points.size > 0.0))
        if len(points):
            every = [bound_excesses(own, each, frozenset(), until).outer for own, each in problem.every(points)]
            excess = np.concatenate(every)
            if now() > until:  # not all is known
                break
            design = points.take([choice(points, excess)])
        spans = {name: span / SHRINKS for name, span in spans.items()}
    return design

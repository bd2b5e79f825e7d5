"""A first look at a box of designs: a coarse grid, and finer and finer ones around its best design.

They look for the least excess, or the smallest feasible design. A search without proof.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import now
from camopt.model.mechanisms.design import SIZE_FIELDS as SIZE_FIELDS
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.scene.tables import LARGEST_VALUE
from camopt.solve.smallest.result import discs_of, first_feasible, known_crossings, proved_feasible, size_of
from camopt.solve.verdicts.judging import bound_excesses, least_excess
from camopt.solve.verdicts.screening import feasible

VALUES, FEW_VALUES = 9, 4  # of a free size in the coarse grid; few where there is no feasible design to find
SIZES = 800  # of the cam in the coarse grid
LOOK_BATCH = 512  # designs looked at together
UNCOMPILED, SMALL_BLOCK = 2048, 64  # designs of a grid for which no kernel is compiled, and how many of them then
STEPS = 7  # of a grid along each free size
SHRINKS = 2.5  # the factor from grid to grid
NEAR, CLOSE = 12, 22  # grids: 1e-5 and 1e-9 of the first
Preference = Callable[[Designs, FloatArray], int]
"""The best of some designs, by their excesses over the limits of all that have to hold them, (limits, designs)."""


@dataclass(frozen=True)
class Look:
    """The smallest feasible design seen; without one the nearest to it, if any can be assembled."""

    design: Designs | None
    nearest: Designs | None = None
    hopeless: bool = False
    """Whether some limit is exceeded whatever the sizes: the motion decides it, or its corners make it infinite."""


def first_look(problem: Problem, bounds: SizeBounds, values: int = VALUES, until: float = inf) -> Look:
    """The best designs of a coarse grid, with ``values`` of each free size but the cam's; ends after ``until``."""
    points = coarse_grid(problem, bounds, problem.programme.lift, values)
    points = points.take(problem.setup.mechanism.exists(points, problem.programme))
    points = points.take(np.argsort(size_of(points, discs_of(bounds)), kind="stable"))
    crossings = known_crossings(problem)
    for block in _blocks(points, until):
        found = first_feasible(problem, block, crossings, until)
        if found is not None:
            return Look(found)
    if not len(points):
        return Look(None)
    seen = [bound_excesses(problem, block, frozenset(), until) for block in _blocks(points, until)]
    excess, surely = (np.concatenate([getattr(each, side) for each in seen], axis=1) for side in ("outer", "inner"))
    if _whatever_the_size(problem, surely) or any(_never(*other) for other in problem.every(points.take([0]))):
        return Look(None, points.take([least_excess(excess)]), hopeless=True)
    near = nearest_miss(problem, bounds, points.take([least_excess(excess)]), until)
    return Look(near) if proved_feasible(problem, near, until) else Look(None, near)


def spread(low: Any, high: Any, scale: float, count: int) -> FloatArray:
    """Sizes from low to high, (count, …), even up to a scale and geometric beyond."""
    sizes = scale * np.sinh(np.linspace(np.arcsinh(low / scale), np.arcsinh(high / scale), count))
    return np.asarray(np.clip(sizes, low, high))


def scale_of(problem: Problem, bounds: SizeBounds, lift: float | None = None) -> float:
    """A length of the order of the largest sizes of interest, mm.

    Of a motion with another lift than that of the problem if one is given.
    """
    sizes = (ends for name, ends in bounds.items() if name in SIZE_FIELDS and name != "size")
    lengths = [*(end for ends in sizes for end in ends), bounds["size"][0]]
    return max([abs(length) for length in lengths] + [problem.programme.lift if lift is None else lift])


def coarse_grid(problem: Problem, bounds: SizeBounds, lift: float, values: int) -> Designs:
    """Sizes even near the least and geometric beyond, at a few values of each other free size."""
    low, high = bounds["size"][0], largest_size(problem, bounds)
    scale = scale_of(problem, bounds, lift)
    near = np.linspace(low, min(high, low + 20 * scale), SIZES // 2)
    sizes = np.unique(np.concatenate([near, spread(low, high, scale, SIZES // 2)])) if high >= low else near[:0]
    others = {n: np.linspace(a, b, values if b > a else 1) for n, (a, b) in bounds.items() if n != "size"}
    mesh = np.meshgrid(*others.values(), sizes[sizes > 0.0], indexing="ij")
    fields = dict(zip([*others, "size"], (m.ravel() for m in mesh), strict=True))
    return problem.design.with_values(fields)


def largest_size(problem: Problem, bounds: SizeBounds) -> float:
    """The largest size worth a look: the given one, or what limits on it or the triangle of an arm allow."""
    reach = bounds["centre_distance"][1] + bounds["arm_length"][1] + max(bounds["face_offset"][1], 0.0)
    triangle = "centre_distance" in problem.setup.mechanism.sizes
    of_limits = max(min((limit.most_size for limit in problem.limits), default=inf), bounds["size"][0])
    return min(bounds["size"][1], of_limits, reach if triangle else inf, LARGEST_VALUE)


def _blocks(points: Designs, until: float) -> Iterator[Designs]:
    """The designs a block at a time; after ``until`` none but the first ``LOOK_BATCH``."""
    size = SMALL_BLOCK if len(points) <= UNCOMPILED else LOOK_BATCH
    for first in range(0, len(points), size):
        if first >= LOOK_BATCH and now() > until:
            return
        yield points.take(slice(first, first + size))


def _never(problem: Problem, design: Designs) -> bool:
    """Whether a cam exceeds a limit by its motion alone."""
    of_motion = replace(problem, limits=tuple(limit for limit in problem.limits if limit.is_of_motion))
    return _whatever_the_size(of_motion, bound_excesses(of_motion, design, frozenset()).inner)


def _whatever_the_size(problem: Problem, excess: FloatArray) -> bool:
    for limit, over in zip(problem.limits, excess, strict=True):
        if limit.is_of_motion and np.all(over > 0.0):
            return True
        if limit.needs and problem.programme.corners and np.all(over == inf):
            return True
        if limit.infinite_at(problem.programme):
            return True
    return False


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

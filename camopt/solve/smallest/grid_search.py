"""Grid searches without proof: a coarse grid over a box of designs, then finer grids around the best design.

They search for the least excess over limits, or for the smallest feasible design.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.model.mechanisms.design import SIZE_FIELDS, Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.scene.tables import LARGEST_VALUE
from camopt.solve.smallest.result import (
    empty_known_crossings,
    first_feasible_design,
    is_provably_feasible,
    largest_base_radii,
    minimised_disc_fields,
)
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_verdicts import index_of_least_excess, quantities_with_excess_bounds

GRID_VALUES, FEW_GRID_VALUES = (
    9,
    4,
)  # values of a free size in the coarse grid; few if no feasible design is expected
GRID_SIZES = 800  # sizes of the cam in the coarse grid
GRID_BATCH = 512  # designs evaluated together
UNCOMPILED_DESIGNS, SMALL_BLOCK = (
    2048,
    64,
)  # grids up to this many designs do not compile a kernel, and are evaluated in blocks of this size
ZOOM_STEPS = 7  # points of a grid along each free size
ZOOM_FACTOR = 2.5  # the factor from grid to grid
NEAR_ZOOMS, CLOSE_ZOOMS = 12, 22  # numbers of grids; the last is 1e-5 and 1e-9 as wide as the first
DesignChoice = Callable[[Designs, FloatArray], int]
"""The index of the best design, from designs and their excesses (limits, designs)."""


@dataclass(frozen=True)
class GridOptimum:
    """The smallest feasible design of a grid; without one the nearest miss, if any design can be assembled."""

    design: Designs | None
    nearest: Designs | None = None
    motion_infeasible: bool = False
    """Whether the motion alone breaks some limit at any size, or its corners make the limited quantity infinite."""


def search_coarse_grid(
    problem: Problem, bounds: SizeBounds, values_per_variable: int, budget: Budget
) -> GridOptimum:
    """The best design of a coarse grid, with ``values_per_variable`` of each free variable except the size."""
    points = coarse_grid(problem, bounds, values_per_variable)
    points = points.take(problem.setup.mechanism.can_assemble(points, problem.programme))
    points = points.take(np.argsort(largest_base_radii(points, minimised_disc_fields(bounds)), kind="stable"))
    crossings = empty_known_crossings(problem)
    for block in _split_blocks(points, budget):
        design = first_feasible_design(problem, block, crossings, budget)
        if design is not None:
            return GridOptimum(design)
    if not len(points):
        return GridOptimum(None)
    bounded = [
        quantities_with_excess_bounds(problem, block, frozenset(), budget)
        for block in _split_blocks(points, budget)
    ]
    excess, inner = (np.concatenate([getattr(b, side) for b in bounded], axis=1) for side in ("outer", "inner"))
    if _is_infeasible_at_every_size(problem, inner) or any(
        _motion_breaks_limit(*variant) for variant in problem.nominal_and_error_variants(points.take([0]))
    ):
        return GridOptimum(None, points.take([index_of_least_excess(excess)]), motion_infeasible=True)
    near = find_nearest_miss(problem, bounds, points.take([index_of_least_excess(excess)]), budget)
    return GridOptimum(near) if is_provably_feasible(problem, near, budget) else GridOptimum(None, near)


def linear_then_geometric_sizes(low: Any, high: Any, scale: float, count: int) -> FloatArray:
    """Sizes from low to high, (count, …), evenly spaced up to a scale and geometrically beyond."""
    sizes = scale * np.sinh(np.linspace(np.arcsinh(low / scale), np.arcsinh(high / scale), count))
    return np.asarray(np.clip(sizes, low, high))


def size_scale(problem: Problem, bounds: SizeBounds, lift: float | None = None) -> float:
    """A length of the order of the largest sizes of interest [mm]; ``lift`` replaces that of the problem."""
    sizes = [ends for name, ends in bounds.items() if name in SIZE_FIELDS and name != "size"]
    lengths = [*(end for ends in sizes for end in ends), bounds["size"][0]]
    return max([abs(length) for length in lengths] + [problem.programme.lift if lift is None else lift])


def coarse_grid(problem: Problem, bounds: SizeBounds, values_per_variable: int) -> Designs:
    """A grid: sizes even near the least, then geometric, and ``values_per_variable`` of each other variable."""
    low, high = bounds["size"][0], largest_possible_size(problem, bounds)
    scale = size_scale(problem, bounds)
    near = np.linspace(low, min(high, low + 20 * scale), GRID_SIZES // 2)
    sizes = (
        np.unique(np.concatenate([near, linear_then_geometric_sizes(low, high, scale, GRID_SIZES // 2)]))
        if high >= low
        else near[:0]
    )
    others = {
        n: np.linspace(a, b, values_per_variable if b > a else 1) for n, (a, b) in bounds.items() if n != "size"
    }
    mesh = np.meshgrid(*others.values(), sizes[sizes > 0.0], indexing="ij")
    return problem.design.with_values(dict(zip([*others, "size"], (m.ravel() for m in mesh), strict=True)))


def largest_possible_size(problem: Problem, bounds: SizeBounds) -> float:
    """Upper bound of the size [mm]: from its range, limits on it, and the triangle of a pivoted follower."""
    reach = bounds["centre_distance"][1] + bounds["arm_length"][1] + max(bounds["face_offset"][1], 0.0)
    has_triangle = "centre_distance" in problem.setup.mechanism.sizes
    limit_sizes = max(min((limit.most_size for limit in problem.limits), default=inf), bounds["size"][0])
    return min(bounds["size"][1], limit_sizes, reach if has_triangle else inf, LARGEST_VALUE)


def _split_blocks(points: Designs, budget: Budget) -> Iterator[Designs]:
    """The designs block by block; once the budget is spent only the first ``GRID_BATCH``."""
    size = SMALL_BLOCK if len(points) <= UNCOMPILED_DESIGNS else GRID_BATCH
    for first in range(0, len(points), size):
        if first >= GRID_BATCH and budget.is_spent:
            return
        yield points.take(slice(first, first + size))


def _motion_breaks_limit(problem: Problem, design: Designs) -> bool:
    motion_problem = replace(
        problem, limits=tuple(limit for limit in problem.limits if limit.is_decided_by_motion_alone)
    )
    return _is_infeasible_at_every_size(
        motion_problem, quantities_with_excess_bounds(motion_problem, design, frozenset()).inner
    )


def _is_infeasible_at_every_size(problem: Problem, excess: FloatArray) -> bool:
    return any(
        (limit.is_decided_by_motion_alone and np.all(over > 0.0))
        or (limit.required_quantities and problem.programme.corners and np.all(over == inf))
        or limit.is_infinite_on_motion(problem.programme)
        for limit, over in zip(problem.limits, excess, strict=True)
    )


def find_nearest_miss(problem: Problem, bounds: SizeBounds, design: Designs, budget: Budget = UNLIMITED) -> Designs:
    """A design near a given one that exceeds its limits the least; the best so far once the budget is spent."""
    return _best_design_on_zoomed_grids(
        problem, bounds, design, lambda designs, excess: index_of_least_excess(excess), NEAR_ZOOMS, budget
    )


def shrink_on_grids(
    problem: Problem, bounds: SizeBounds, design: Designs, zooms: int = NEAR_ZOOMS, budget: Budget = UNLIMITED
) -> Designs | None:
    """The smallest feasible design that grids find near a given one; None if they find none."""
    discs = minimised_disc_fields(bounds)

    def smallest_feasible_index(designs: Designs, excess: FloatArray) -> int:
        worst = np.max(excess, axis=0, initial=-inf)
        size = np.where(worst <= 0.0, largest_base_radii(designs, discs), inf)
        return int(np.lexsort((worst, size))[0])  # at equal sizes the least excess

    best = _best_design_on_zoomed_grids(problem, bounds, design, smallest_feasible_index, zooms, budget)
    return best if feasible_designs(problem, best)[0] else None


def _best_design_on_zoomed_grids(
    problem: Problem,
    bounds: SizeBounds,
    design: Designs,
    choose_design: DesignChoice,
    zooms: int,
    budget: Budget,
) -> Designs:
    free = {name: ends for name, ends in bounds.items() if ends[1] > ends[0]}
    spans = {name: (b - a) / 8 if np.isfinite(b - a) else inf for name, (a, b) in free.items()}
    spans["size"] = min(spans.get("size", inf), float(design.prime_radius[0]) / 4)
    for _ in range(zooms):
        if budget.is_spent:
            break
        steps = [np.linspace(-1, 1, ZOOM_STEPS) * spans[name] for name in free]
        mesh = [m.ravel() for m in np.meshgrid(*steps, indexing="ij")]
        columns = {n: np.clip(design.values[n] + m, *free[n]) for n, m in zip(free, mesh, strict=True)}
        ones = np.ones(mesh[0].size if mesh else 1)
        points = design.with_values({n: columns.get(n, v * ones) for n, v in design.values.items()})
        points = points.take(problem.setup.mechanism.can_assemble(points, problem.programme) & (points.size > 0.0))
        if len(points):
            excess = np.concatenate(
                [
                    quantities_with_excess_bounds(*pair, frozenset(), budget).outer
                    for pair in problem.nominal_and_error_variants(points)
                ]
            )
            if budget.is_spent:  # some excesses may be missing
                break
            design = points.take([choose_design(points, excess)])
        spans = {name: span / ZOOM_FACTOR for name, span in spans.items()}
    return design

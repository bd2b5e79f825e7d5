"""Pitch curves that designs of a space share: the numbers of all curves, and the curves of each block."""

from functools import cached_property, reduce
from math import frexp, ldexp, prod
from operator import or_
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.model.effects.peak import RadiusRange
from camopt.model.mechanisms import Designs, Mechanism
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.space import DesignSpace

MOST_CURVES = 2**20  # curves kept for one motion: some 250 bytes each
MOST_SUMS = 2**20  # sums of a roller radius and a cam radius that are sorted: some 130 bytes each
LEAST_SHARING = 1.5  # designs per pitch curve from which keeping the curves pays
CURVES_AT_ONCE = 2**16  # most pitch curves searched together
BLOCKS_KEPT = 16  # blocks whose curves are kept from one motion to the next


BlockCurves = tuple[IntArray, FloatArray, IntArray]
"""The pitch curves of a block: the number of each design's curve, the radius of its body on that curve or another
distance between curve and profile [mm], and the parts of all curves in which these curves are."""


class CurveParts:
    """Pitch curves by number, cut into parts; the curves of a part are searched together."""

    pitch_curve_designs: Designs
    """Designs with a point follower on the pitch curves, by number."""
    part: int
    """Number of curves in a part; one thread searches one part or several."""

    def __init__(self) -> None:
        self._designs: dict[tuple[int, int], Designs] = {}
        self._existing: dict[tuple[int, int], tuple[BoolArray, Designs]] = {}

    def assemblable_mask_and_designs(
        self, part_range: tuple[int, int], problem: Problem
    ) -> tuple[BoolArray, Designs]:
        """Which curves of consecutive parts (first, end) can be assembled, and the designs of these.

        Motions with the same assembled curves share the designs and their caches.
        """
        designs = self._designs.get(part_range)
        if designs is None:
            first, end = part_range
            designs = self._designs[part_range] = self.pitch_curve_designs.take(
                slice(first * self.part, end * self.part)
            )
        exists = problem.setup.mechanism.can_assemble(designs, problem.programme)
        existing = self._existing.get(part_range)
        if existing is None or not np.array_equal(existing[0], exists):
            existing = self._existing[part_range] = exists, designs.take(exists)
        return existing


class CurveNumbers(CurveParts):
    """The pitch curve of each design of a motion, as a number from 0, in the order of the space."""

    def __init__(self, space: DesignSpace) -> None:
        super().__init__()
        self.shape = (1, *(values.size for values in space.axes.values()))
        strides = np.cumprod((1, *self.shape[:0:-1]))[::-1]
        axes, mechanism = {field: i for i, field in enumerate(space.axes, start=1)}, space.problem.setup.mechanism
        merged = [axes[field] for field in axes if field in _sizes_summed_in_pitch_curve(mechanism)]
        body = axes.get(mechanism.parallel)
        self._merged, self._others, self._space = (
            merged,
            [i for i in range(len(self.shape)) if i not in merged],
            space,
        )
        ignored = {body} if mechanism.pitch_ignores_parallel_size else set()
        summed = [i for i in merged if i not in ignored]
        numbers = self._design_number_contributions(strides, summed)
        grid = {field: space.axes[field] for field in space.axes if axes[field] in summed}
        sizes = {
            field: np.full(numbers.shape, values[0]) for field, values in space.axes.items() if field not in grid
        }
        sizes |= {f: np.broadcast_to(v, numbers.shape) for f, v in zip(grid, np.ix_(*grid.values()), strict=True)}
        designs = space.designs_with_varied_values(
            {field: values.ravel() for field, values in sizes.items()}, numbers.size
        )
        first, which = _group_equal_curves(mechanism.standard_profile_reduction(designs), mechanism.parallel)
        whole = [self.shape[i] for i in merged]
        self._which = np.broadcast_to(which.reshape([1 if i in ignored else self.shape[i] for i in merged]), whole)
        radii = space.axes.get(mechanism.parallel, space.problem.design.sizes[mechanism.parallel])
        bodies = radii.reshape([self.shape[i] if i == body else 1 for i in merged])
        self._bodies = np.broadcast_to(bodies, whole)
        self.bodies = RadiusRange(bodies.min(), bodies.max())
        self._sum_numbers = numbers.ravel()[first]
        self._other_numbers = self._design_number_contributions(strides, self._others).ravel()
        pairs = -(-len(self) // (2 * CURVES_AT_ONCE))
        self.part = -(-len(self) // (2 * pairs))  # an even number of parts, for two threads
        self._blocks: dict[tuple[int, int], BlockCurves] = {}

    def __len__(self) -> int:
        return self._sum_numbers.size * self._other_numbers.size

    @cached_property
    def pitch_curve_designs(self) -> Designs:  # type: ignore[override]
        numbers = (self._other_numbers[:, None] + self._sum_numbers).ravel()
        return self._space.problem.setup.mechanism.standard_profile_reduction(self._space.designs(numbers))

    def pitch_curves_of_block(self, first: int, last: int) -> BlockCurves:
        """The pitch curves of designs first … last − 1; they are the same for the next motion."""
        block_curves = self._blocks.get((first, last)) or self._find_block_curves(first, last)
        if len(self._blocks) < BLOCKS_KEPT:
            self._blocks[first, last] = block_curves
        return block_curves

    def _find_block_curves(self, first: int, last: int) -> BlockCurves:
        fastest = self.shape[-1]
        begin, end = first // fastest, -(-last // fastest)
        skipped = begin * fastest
        low, high = (first - skipped, last - skipped) if end - begin == 1 else (0, fastest)
        slow = np.unravel_index(np.arange(begin, end), self.shape[:-1])

        def gather_values_by_axis(values: Any, axes: list[int]) -> Any:
            """The designs' values in an array with some axes of the space; the fastest axis is in columns."""
            chosen = values[tuple(slow[i] if i < len(slow) else slice(low, high) for i in axes)]
            return chosen if len(slow) in axes else chosen[:, None]

        others = np.arange(self._other_numbers.size).reshape([self.shape[i] for i in self._others])
        curves = (
            gather_values_by_axis(self._which, self._merged)
            + gather_values_by_axis(others, self._others) * self._sum_numbers.size
        )
        bodies = gather_values_by_axis(self._bodies, self._merged)
        arrays = (np.broadcast_to(array, (end - begin, high - low)).ravel() for array in (curves, bodies))
        curves, bodies = (array[first - skipped - low : last - skipped - low] for array in arrays)
        low, high = int(curves.min()) // self.part, int(curves.max()) // self.part
        parts = np.arange(low, high + 1) if high - low < 2 else np.flatnonzero(np.bincount(curves // self.part))
        return curves, bodies, parts

    def _design_number_contributions(self, strides: IntArray, axes: list[int]) -> IntArray:
        """The contributions of some axes to the number of a design, for all combinations of their places."""
        steps = [np.arange(self.shape[i]) * strides[i] for i in axes]
        return np.asarray(sum(np.ix_(*steps), np.zeros((1,) * len(steps), dtype=np.intp)))


class OwnCurves(CurveParts):
    """The pitch curves of designs first … last − 1 of a motion: one for each design, in the same order."""

    def __init__(self, space: DesignSpace, first: int, last: int) -> None:
        super().__init__()
        mechanism, designs = space.problem.setup.mechanism, space.designs(np.arange(first, last))
        self.shape = tuple(values.size for values in space.axes.values()) or (1,)
        self.pitch_curve_designs, self._radii = (
            mechanism.standard_profile_reduction(designs),
            designs.sizes[mechanism.parallel],
        )
        self.bodies = RadiusRange(self._radii.min(), self._radii.max())
        self.part = min(CURVES_AT_ONCE, last - first)

    def __len__(self) -> int:
        return len(self.pitch_curve_designs)

    def pitch_curves_of_block(self, first: int, last: int) -> BlockCurves:
        """The pitch curves of all designs, whatever the block."""
        count = len(self)
        return np.arange(count), self._radii, np.arange(-(-count // self.part))


def _sizes_summed_in_pitch_curve(mechanism: Mechanism) -> tuple[str, ...]:
    """The sizes that a pitch curve depends on by their sum alone, or not at all."""
    return tuple(dict.fromkeys(("size", mechanism.parallel)))


def _group_equal_curves(curves: Designs, remainder_field: str) -> tuple[IntArray, IntArray]:
    """The index of the first of each group of equal pitch curves, and the group of each curve, sorted by size."""
    keys = _exact_sum_sort_keys(curves.size, getattr(curves, remainder_field))
    order = np.lexsort(keys[::-1])
    new = np.ones(order.size, dtype=bool)
    new[1:] = reduce(or_, (np.diff(key[order]) != 0 for key in keys))
    which = np.empty(order.size, np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which


def _exact_sum_sort_keys(sizes: FloatArray, rounding_remainders: FloatArray) -> tuple[NDArray[Any], ...]:
    """Keys that sort sizes, equal ones by their rests: the parts of sums that rounding has removed.

    If all are whole numbers of one small unit, the exact sums are integers, which take half the time to sort.
    """
    if not rounding_remainders.any():
        return (sizes,)
    unit = ldexp(1.0, min(62 - frexp(float(np.abs(sizes).max()))[1], 1000))
    parts = [part * unit for part in (sizes, rounding_remainders)]
    whole = [part.astype(np.int64) for part in parts]
    exact = all(np.array_equal(part, number) for part, number in zip(parts, whole, strict=True))
    return (
        (whole[0] + whole[1],)
        if exact and np.array_equal(sizes + rounding_remainders, sizes)
        else (sizes, rounding_remainders)
    )


def shared_pitch_curve_numbers(space: DesignSpace) -> CurveNumbers | None:
    """The numbers of the pitch curves of a space; None if keeping the curves does not pay, or they are too many."""
    mechanism, limits = space.problem.setup.mechanism, space.problem.limits
    if mechanism.profile and not all(
        limit.deciding_pitch_curve_quantities == () or limit.is_decided_by_motion_alone for limit in limits
    ):
        return None
    merged = {
        field: values.size
        for field, values in space.axes.items()
        if field in _sizes_summed_in_pitch_curve(mechanism)
    }
    ignored = merged.pop(mechanism.parallel, 1) if mechanism.pitch_ignores_parallel_size else 1
    if not space.axes or (
        sum(count > 1 for count in merged.values()) < 2 and not mechanism.pitch_ignores_parallel_size
    ):
        return None
    sums, least = prod(merged.values()), merged.get("size", 1)
    if sums > MOST_SUMS or least * (space.designs_per_problem // (sums * ignored)) > MOST_CURVES:
        return None
    numbers = CurveNumbers(space)
    return numbers if len(numbers) <= min(MOST_CURVES, space.designs_per_problem / LEAST_SHARING) else None

"""Which designs of a space share a pitch curve: numbers of the curves, and those of each block of designs."""

from functools import cached_property
from math import prod
from typing import NamedTuple

import numpy as np

from camopt.effects.peak import Bodies
from camopt.mechanisms import Designs
from camopt.mechanisms.design import without_roller
from camopt.numerics import FloatArray, IntArray
from camopt.problem.space import Space

MERGED = ("size", "roller_radius")  # sizes that a pitch curve has in one
MOST_CURVES = 2**19  # kept of one motion: some 100 bytes each
WORTH = 1.5  # designs a pitch curve, from which on they are worth keeping
AT_ONCE = 2**14  # pitch curves searched together, or somewhat fewer
BLOCKS_KEPT = 16  # of which the curves of the designs are kept from one motion to the next


class BlockCurves(NamedTuple):
    """The pitch curves of a block of designs."""

    curves: IntArray
    """The number of that of each design."""
    bodies: FloatArray
    """The radius of the body that follows it."""
    parts: IntArray
    """The parts of all curves that they are in."""


class CurveNumbers:
    """Which pitch curve each design of a motion has: numbers from 0, by the order of the space."""

    def __init__(self, space: Space) -> None:
        self.shape = (1, *(values.size for values in space.axes.values()))
        strides = np.cumprod((1, *self.shape[:0:-1]))[::-1]
        merged = [i for i, field in enumerate(space.axes, start=1) if field in MERGED]
        self._merged, self._others = merged, [i for i in range(len(self.shape)) if i not in merged]
        numbers = self._numbers(strides, merged)
        designs, self._space = space.designs(numbers.ravel()), space
        curves = space.problem.setup.mechanism.pitch(designs)
        pairs = curves.size + 1j * curves.roller_radius
        _, first, which = np.unique(pairs, return_index=True, return_inverse=True)
        self._which, self._bodies = (each.reshape(numbers.shape) for each in (which, designs.roller_radius))
        self.bodies = Bodies(designs.roller_radius.min(), designs.roller_radius.max())
        self._of_sums = numbers.ravel()[first]
        self._of_others = self._numbers(strides, self._others).ravel()
        self.part = -(-len(self) // -(-len(self) // AT_ONCE))
        """How many curves are searched together."""
        self._blocks: dict[tuple[int, int], BlockCurves] = {}

    def __len__(self) -> int:
        return self._of_sums.size * self._of_others.size

    @cached_property
    def designs(self) -> Designs:
        """Designs that a point follows on the pitch curves, by number."""
        of_each = (self._of_others[:, None] + self._of_sums).ravel()
        return self._space.problem.setup.mechanism.pitch(self._space.designs(of_each))

    def of_block(self, first: int, last: int) -> BlockCurves:
        """The pitch curves of designs first … last − 1, which those of the next motion have too."""
        found = self._blocks.get((first, last)) or self._of_block(first, last)
        if len(self._blocks) < BLOCKS_KEPT:
            self._blocks[first, last] = found
        return found

    def _of_block(self, first: int, last: int) -> BlockCurves:
        fastest = self.shape[-1]
        begin, end = first // fastest, -(-last // fastest)
        slow = [digits[:, None] for digits in np.unravel_index(np.arange(begin, end), self.shape[:-1])]
        where = [*slow, np.arange(fastest)[None]]
        others = np.ravel_multi_index(
            np.broadcast_arrays(*(where[i] for i in self._others)), [self.shape[i] for i in self._others]
        )
        merged = tuple(where[i] for i in self._merged)
        curves, bodies = self._which[merged] + others * self._of_sums.size, self._bodies[merged]
        found = (np.broadcast_to(each, (end - begin, fastest)).ravel() for each in (curves, bodies))
        curves, bodies = (each[first - begin * fastest : last - begin * fastest] for each in found)
        return BlockCurves(curves, bodies, np.flatnonzero(np.bincount(curves // self.part)))

    def _numbers(self, strides: IntArray, axes: list[int]) -> IntArray:
        """The contributions of given axes to the number of a design, for all combinations."""
        steps = [np.arange(self.shape[i]) * strides[i] for i in axes]
        return np.asarray(sum(np.ix_(*steps), np.zeros((1,) * len(steps), dtype=np.intp)))


def curve_numbers(space: Space) -> CurveNumbers | None:
    """The numbers of the pitch curves of a space; None where they are not worth keeping, or too many to keep."""
    merged = [values.size for field, values in space.axes.items() if field in MERGED]
    if not space.axes or (
        sum(count > 1 for count in merged) < 2 and space.problem.setup.mechanism.pitch is not without_roller
    ):
        return None
    if max(prod(merged), space.designs_each // prod(merged)) > MOST_CURVES:
        return None
    numbers = CurveNumbers(space)
    return numbers if len(numbers) <= min(MOST_CURVES, space.designs_each / WORTH) else None

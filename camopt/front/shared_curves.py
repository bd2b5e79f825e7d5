"""Pitch curves that designs of a space share: each is searched once, whatever roller then rolls along it.

The pitch curve of a disc cam depends on base radius and roller radius by their sum alone, that of a cylindrical cam
not on the roller at all. So a space that varies both has fewer pitch curves than designs. Those of one motion are
searched when a block of designs first needs them, some at a time, and kept while that motion lasts.
"""

from math import prod
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms import Designs
from camopt.mechanisms.design import without_roller
from camopt.problem.problem import Problem
from camopt.problem.rows import Columns, Rows
from camopt.problem.space import Space, field_of
from camopt.verdicts.screening import Candidates, begun, screened_by_pitch

IntArray = NDArray[np.intp]

MERGED = ("size", "roller_radius")  # sizes that a pitch curve has in one
MOST_CURVES = 2**19  # kept of one motion: some 100 bytes each
WORTH = 1.5  # designs a pitch curve, from which on they are worth keeping
AT_ONCE = 2**12  # pitch curves searched together


class CurveNumbers:
    """Which pitch curve each design of a motion has: numbers from 0, by the order of the space."""

    def __init__(self, space: Space) -> None:
        self.shape = (1, *(values.size for values in space.axes.values()))
        strides = np.cumprod((1, *self.shape[:0:-1]))[::-1]
        merged = [i for i, key in enumerate(space.axes, start=1) if field_of(key) in MERGED]
        self._merged, self._others = merged, [i for i in range(len(self.shape)) if i not in merged]
        numbers = self._numbers(strides, merged)
        curves = space.problem.setup.mechanism.pitch(space.designs(numbers.ravel()))
        pairs = curves.size + 1j * curves.roller_radius
        _, first, which = np.unique(pairs, return_index=True, return_inverse=True)
        self._which = which.reshape(numbers.shape)
        self._of_sums, self._of_others = numbers.ravel()[first], self._numbers(strides, self._others).ravel()

    def __len__(self) -> int:
        return self._of_sums.size * self._of_others.size

    def of_block(self, first: int, last: int) -> IntArray:
        """The pitch curves of designs first … last − 1."""
        fastest = self.shape[-1]
        begin, end = first // fastest, -(-last // fastest)
        slow = [digits[:, None] for digits in np.unravel_index(np.arange(begin, end), self.shape[:-1])]
        where = [*slow, np.arange(fastest)[None]]
        others = np.ravel_multi_index(
            np.broadcast_arrays(*(where[i] for i in self._others)), [self.shape[i] for i in self._others]
        )
        curves = self._which[tuple(where[i] for i in self._merged)] + others * self._of_sums.size
        curves = np.broadcast_to(curves, (end - begin, fastest)).ravel()
        return curves[first - begin * fastest : last - begin * fastest]

    def a_design(self, curve: IntArray) -> IntArray:
        """The number of one of the designs that have a pitch curve."""
        other, place = np.divmod(curve, self._of_sums.size)
        return self._of_others[other] + self._of_sums[place]

    def _numbers(self, strides: IntArray, axes: list[int]) -> IntArray:
        """What some axes give to the number of a design, all combinations."""
        steps = [np.arange(self.shape[i]) * strides[i] for i in axes]
        return np.asarray(sum(np.ix_(*steps), np.zeros((1,) * len(steps), dtype=np.intp)))


class SharedCurves:
    """What the pitch curves of one motion say of its designs."""

    def __init__(self, space: Space, problem: Problem, numbers: CurveNumbers, wanted: frozenset[str]) -> None:
        self._space, self._problem, self._numbers, self._wanted = space, problem, numbers, wanted
        count = len(numbers)
        self._locks = [Lock() for _ in range(0, count, AT_ONCE)]
        self._known = np.zeros(len(self._locks), dtype=bool)
        self._exists, self._possible, self._held = np.zeros((3, count), dtype=bool)
        self._columns: Columns = {}
        self._outward: Columns = {}
        self._half_width = np.zeros(count)
        self._pending = problem.limits

    def candidates(self, first: int, last: int) -> tuple[int, Candidates]:
        """Of designs first … last − 1: how many can be assembled, and those that hold what their curves decide."""
        curves = self._numbers.of_block(first, last)
        self._search(np.flatnonzero(np.bincount(curves // AT_ONCE)))
        which = np.flatnonzero(self._possible[curves])
        existing, curves = int(np.count_nonzero(self._exists[curves])), curves[which]
        columns = {name: values[curves] for name, values in self._columns.items()}
        outward = {name: values[curves] for name, values in self._outward.items()}
        rows = Rows(columns, which.size, outward, self._half_width[curves])
        designs = self._space.designs(first + which)
        return existing, Candidates(self._problem, designs, which, rows, self._held[curves], self._pending)

    def _search(self, parts: IntArray) -> None:
        """Search what is not known yet: first what no other thread is at, then what one was."""
        for blocking in (False, True):
            for part in parts[~self._known[parts]]:
                if self._locks[part].acquire(blocking=blocking):
                    try:
                        if not self._known[part]:
                            self._search_part(part)
                    finally:
                        self._locks[part].release()

    def _search_part(self, part: int) -> None:
        curves = np.arange(part * AT_ONCE, min((part + 1) * AT_ONCE, len(self._numbers)))
        designs = self._curves(curves)
        exists = self._problem.setup.mechanism.exists(designs, self._problem.programme)
        found = screened_by_pitch(begun(self._problem, designs.take(exists)), self._wanted)
        where = curves[exists][found.which]
        self._exists[curves], self._possible[where], self._held[where] = exists, True, found.held
        for kept, columns in ((self._columns, found.rows.columns), (self._outward, found.rows.outward)):
            for name, values in columns.items():
                kept.setdefault(name, np.zeros(len(self._numbers)))[where] = values  # one, whoever comes first
        self._half_width[where], self._pending = found.rows.half_width, found.pending
        self._known[part] = True

    def _curves(self, numbers: IntArray) -> Designs:
        """Designs that a point follows on these pitch curves."""
        return self._problem.setup.mechanism.pitch(self._space.designs(self._numbers.a_design(numbers)))


def curve_numbers(space: Space) -> CurveNumbers | None:
    """The numbers of the pitch curves of a space; None where they are not worth keeping, or too many to keep."""
    varied = [values.size > 1 for key, values in space.axes.items() if field_of(key) in MERGED]
    if not space.axes or (sum(varied) < 2 and space.problem.setup.mechanism.pitch is not without_roller):
        return None
    merged = prod(values.size for key, values in space.axes.items() if field_of(key) in MERGED)
    if max(merged, space.designs_each // merged) > MOST_CURVES:
        return None
    numbers = CurveNumbers(space)
    return numbers if len(numbers) <= min(MOST_CURVES, space.designs_each / WORTH) else None

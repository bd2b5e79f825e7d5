"""Halving without a compiler: parts of a panel are evaluated together, before they are needed.

The halving (``halving``) takes designs one by one. Machine code does that quickly, but uncompiled, one part takes
as long as some hundred parts in an array. So a part is evaluated together with the parts that may be needed next:
those of all designs in the panel, and their halves of some levels. Further levels are evaluated for the parts that
the search will halve, by the best value so far. The bits are the same.
"""

from typing import Any

import numpy as np

from camopt.core.kernels.compile import PLAIN_RUN
from camopt.core.numerics import FloatArray
from camopt.core.numerics.climbing import PanelPartEnds, PeakQuery, allowed_gain
from camopt.core.numerics.curve_kernels import (
    JET_WORK,
    Evaluator,
    PartBounds,
    bound_curves_over_parts,
    evaluate_points,
)
from camopt.core.numerics.halving import (
    CLIMBS,
    POINT_WIDTH,
    UNSETTLED,
    classify_and_bound_part,
    closer_upper_bound_by_jet,
    has_excess_rounding_error,
)

HALF_LEVELS = 7  # levels of halves that are evaluated together for a single part, that part included
WAITING_PARTS = 32  # most parts that are evaluated together, so that the halves of two levels are too
MOST_KEPT_PARTS = 100_000  # about 700 bytes each

WHOLE_PANEL = (0.0, 1.0)


class CachingEvaluator(Evaluator):
    """An evaluator that keeps bounds of parts, and values and slopes at their middles.

    Parts that are not evaluated yet are columns of 7 numbers: a design and its ``PanelPartEnds``. ``waiting`` has
    those that the search will need; the next one is the last.
    """

    def __init__(self, *functions: Any) -> None:
        self.bounds: dict[tuple[int, int, float, float], PartBounds] = {}
        self.points: dict[tuple[int, int, float], tuple[float, float]] = {}

    def begin_halving(
        self, panel: int, parts: FloatArray, query: PeakQuery, first_best_and_errors: tuple[int, Any, Any]
    ) -> None:
        """Wait for some parts of a panel, and evaluate the whole panel, which often settles them.

        ``first_best_and_errors`` has the first design, and the panel's best values and rounding errors from it on.
        """
        if len(self.bounds) > MOST_KEPT_PARTS:
            self.bounds, self.points = {}, {}
        self.waiting, self.query, self.found = parts[:, ::-1], query, first_best_and_errors
        designs = [i for i in np.unique(parts[0].astype(int)) if (panel, i, *WHOLE_PANEL) not in self.bounds]
        if designs:
            PLAIN_RUN.add_formula_work_within_limit(JET_WORK * len(designs))
            together = np.array(designs) if len(designs) > 1 else designs[0]  # an array of one takes longer
            whole = super().part(self.source, panel, *WHOLE_PANEL, together)
            self._store_bounds(panel, together, *WHOLE_PANEL, whole)

    def part(self, curve_address: Any, panel: int, middle: float, half_length: float, design: int) -> PartBounds:
        """Bounds over a part of the panel, as ``curve_kernels.bound_curve_over_part``."""
        place = (panel, design, middle, half_length)
        while place not in self.bounds:
            i, low, high = self.waiting[:3]
            here = np.flatnonzero((i == design) & (low < middle) & (middle < high))
            if (
                half_length == POINT_WIDTH or not here.size
            ):  # such a part is not halved, or nothing told that it would be
                PLAIN_RUN.add_formula_work_within_limit(JET_WORK)
                return super().part(curve_address, panel, middle, half_length, design)  # type: ignore[no-any-return]
            # the search has passed those after it
            self.waiting, parts = np.split(self.waiting[:, : here[-1] + 1], [-WAITING_PARTS], axis=1)
            self._evaluate_parts_and_halves(panel, parts)
        return self.bounds[place]

    def point(self, curve_address: Any, panel: int, u: float, sign: float, design: int) -> tuple[float, float]:
        """Oriented value and slope, as ``curve_kernels.evaluate_point``."""
        if (panel, design, u) not in self.points:
            PLAIN_RUN.add_formula_work_within_limit(1)
            return super().point(curve_address, panel, u, sign, design)  # type: ignore[no-any-return]
        value, slope = self.points[panel, design, u]
        return sign * value, sign * slope

    def _evaluate_parts_and_halves(self, panel: int, parts: FloatArray) -> None:
        """Evaluate some parts with their halves of several levels. Halves that will be halved again wait."""
        levels = [parts]
        for _ in range(HALF_LEVELS - parts.shape[1].bit_length()):
            levels.append(halves_of_parts(levels[-1], np.full((2, levels[-1].shape[1]), np.nan)))
        values, bounds = self._evaluate_parts(panel, np.hstack(levels))
        start, chosen = 0, np.arange(parts.shape[1])
        for level in levels:
            at = start + chosen
            halved = self._will_be_halved(panel, parts, bounds[:, at])
            parts = halves_of_parts(parts[:, halved], values[:, at[halved]])
            chosen = (2 * chosen[halved, None] + (0, 1)).ravel()
            start += level.shape[1]
        self.waiting = np.hstack((self.waiting, parts))

    def _evaluate_parts(self, panel: int, parts: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Oriented values and slopes at the middles of parts; bounds of the parts, and a point's rounding error."""
        designs, middles, reaches = parts[0].astype(int), 0.5 * (parts[1] + parts[2]), 0.5 * (parts[2] - parts[1])
        PLAIN_RUN.add_formula_work_within_limit((1 + JET_WORK) * designs.size)
        values = np.array(evaluate_points(self.source, panel, middles, 1.0, designs))
        self.points |= {
            (panel, design, middle): (value, slope)
            for design, middle, value, slope in zip(designs, middles, *values, strict=True)
        }
        if self.query.blur < np.inf:  # the rounding error of a part is compared with that of a point
            PLAIN_RUN.add_formula_work_within_limit(JET_WORK * designs.size)
            reaches = np.concatenate((reaches, np.full(designs.size, POINT_WIDTH)))
            designs, middles = np.tile(designs, 2), np.tile(middles, 2)
        jets = bound_curves_over_parts(self.source, panel, middles, reaches, designs)
        bounds, count = self._store_bounds(panel, designs, middles, reaches, jets), parts.shape[1]
        point_errors = PartBounds(*bounds).error[-count:]  # type: ignore[index]
        return self.query.sign * values, np.vstack((bounds[:, :count], point_errors))

    def _will_be_halved(self, panel: int, parts: FloatArray, bounds: FloatArray) -> Any:
        """Which parts the search would halve if it came to them now, as ``search_part_by_halving``."""
        (first, values, errors), (_, table) = self.found, self.source[0]
        designs, ends, jets = parts[0].astype(int) - first, PanelPartEnds(*parts[1:]), PartBounds(*bounds[:-1])
        best, error = values[designs], np.fmin(errors[designs], jets.error)
        enough = best + allowed_gain(best, self.query.relative_error, error)
        verdict, bound, _ = classify_and_bound_part(ends, jets.third, table.half_width[panel], enough)
        bound = np.where(
            verdict == UNSETTLED,
            closer_upper_bound_by_jet(bound, jets, ends, self.query.sign, table.half_width[panel]),
            np.where(verdict == CLIMBS, np.inf, bound),
        )
        blurred = has_excess_rounding_error(error, bound, best, self.query) & (error > 2.0 * bounds[-1])
        return blurred | ((verdict == UNSETTLED) & (bound > enough))

    def _store_bounds(
        self, panel: int, designs: Any, middles: Any, half_lengths: Any, bounds: PartBounds
    ) -> FloatArray:
        """Keep bounds of parts, and return them. Those of a whole panel, which other formulas give, stay."""
        columns = np.atleast_1d(*np.broadcast_arrays(designs, middles, half_lengths, *bounds))
        for design, middle, reach, *numbers in zip(*columns, strict=True):
            self.bounds.setdefault((panel, design, middle, reach), PartBounds(*numbers))
        return np.array(columns[3:])


def halves_of_parts(parts: FloatArray, middle_values: FloatArray) -> FloatArray:
    """Both halves of each part, by values and slopes at their middles."""
    design, low, high, left, right = parts[0], parts[1], parts[2], parts[3:5], parts[5:]
    middle = 0.5 * (low + high)
    halves = ((design, low, middle, *left, *middle_values), (design, middle, high, *middle_values, *right))
    return np.array(halves).transpose(1, 2, 0).reshape(7, -1)

"""Halving without a compiler: parts of a panel are evaluated together, before they are needed.

The halving (``halving``) takes designs one by one. Machine code does that quickly, but uncompiled, one part takes
as long as some hundred parts in an array. So a part is evaluated together with the parts that may be needed next:
those of all designs in the panel, and their halves. The bits are the same.
"""

from typing import Any

import numpy as np

from camopt.core.kernels.compile import PLAIN_RUN
from camopt.core.numerics.curve_kernels import JET_WORK, Evaluator, PartBounds, bound_parts, evaluate_points
from camopt.core.numerics.halving import POINT_WIDTH

HALF_LEVELS = 7  # levels of halves that are evaluated together for a single part, that part included
LEAST_LEVELS = 5  # levels of halves for many parts
MOST_KEPT_PARTS = 100_000  # about 700 bytes each

WHOLE_PANEL = (0.0, 1.0)
PanelPart = tuple[int, float, float]
"""A design and a part of the panel: its middle and half-width, in u."""


class PanelCache:
    """Bounds of the parts of one panel, and values and slopes at their middles."""

    def __init__(self, curve: Any, panel: int) -> None:
        self.curve, self.panel = curve, panel
        self.bounds: dict[PanelPart, PartBounds] = {}
        self.points: dict[tuple[int, float], tuple[float, float]] = {}

    def store_whole_panel_bounds(self, parts: list[PanelPart]) -> None:
        """Evaluate the whole panel for the parts' designs that have no bounds of it yet."""
        designs = sorted({i for i, _, _ in parts if (i, *WHOLE_PANEL) not in self.bounds})
        if designs:
            together = np.array(designs) if len(designs) > 1 else designs[0]  # an array of one takes longer
            PLAIN_RUN.add_formula_work_within_limit(JET_WORK * len(designs))
            whole = self.curve.part(self.curve.source, self.panel, *WHOLE_PANEL, together)
            self._store_bounds([(design, *WHOLE_PANEL) for design in designs], whole)
        self.first = parts  # evaluated when one of them is needed: often the whole panel settles them

    def part(self, source: Any, panel: int, middle: float, reach: float, design: int) -> PartBounds:
        """Bounds over a part of the panel, as ``curve_kernels.bound_part``."""
        place = (design, middle, reach)
        if reach == POINT_WIDTH:  # such a part is not halved
            PLAIN_RUN.add_formula_work_within_limit(JET_WORK)
            return self.curve.part(source, panel, middle, reach, design)  # type: ignore[no-any-return]
        if place not in self.bounds:
            self._evaluate_parts_and_halves(self.first if place in self.first else [place])
        return self.bounds[place]

    def point(self, source: Any, panel: int, u: float, sign: float, design: int) -> tuple[float, float]:
        """Oriented value and slope, as ``curve_kernels.evaluate_point``."""
        if (design, u) not in self.points:
            PLAIN_RUN.add_formula_work_within_limit(1)
            return self.curve.point(source, panel, u, sign, design)  # type: ignore[no-any-return]
        value, slope = self.points[design, u]
        return sign * value, sign * slope

    def _evaluate_parts_and_halves(self, parts: list[PanelPart]) -> None:
        """Evaluate some parts, their halves of several levels, and the points at their middles."""
        level = every = parts
        for _ in range(max(HALF_LEVELS + 1 - len(parts).bit_length(), LEAST_LEVELS) - 1):
            level = [(i, m + side * r / 2, r / 2) for i, m, r in level for side in (-1.0, 1.0)]
            every = every + level
        PLAIN_RUN.add_formula_work_within_limit((1 + JET_WORK) * len(every))
        designs, middles, reaches = map(np.array, zip(*every, strict=True))
        values, slopes = evaluate_points(self.curve.source, self.panel, middles, 1.0, designs)
        for (design, middle, _), value, slope in zip(every, values, slopes, strict=True):
            self.points[design, middle] = (value, slope)
        self._store_bounds(every, bound_parts(self.curve.source, self.panel, middles, reaches, designs))

    def _store_bounds(self, parts: list[PanelPart], bounds: PartBounds) -> None:
        columns = (np.broadcast_to(column, len(parts)) for column in bounds)
        self.bounds.update(zip(parts, map(PartBounds, *columns), strict=True))


class CachingEvaluator(Evaluator):
    """An evaluator that keeps the evaluated parts of its panels for the next question."""

    panels: dict[int, PanelCache]

    def prefetch_panel(self, panel: int, parts: list[PanelPart]) -> PanelCache:
        """The cache of a panel, for some parts that will be halved."""
        if sum(len(cache.bounds) for cache in self.panels.values()) > MOST_KEPT_PARTS:
            self.panels.clear()
        if panel not in self.panels:
            self.panels[panel] = PanelCache(self, panel)
        self.panels[panel].store_whole_panel_bounds(parts)
        return self.panels[panel]


def caching_evaluator(curve: Evaluator) -> CachingEvaluator:
    """A caching evaluator of the same curve, still empty."""
    caching = CachingEvaluator(*curve)
    caching.panels = {}
    return caching

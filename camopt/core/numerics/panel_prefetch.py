"""Halving without a compiler: parts of a panel are evaluated many at a time, before they are needed.

The last resort of the search (``halving``) takes designs one by one. As machine code that is quick; uncompiled, one
part takes as long as some hundred in an array. So whatever may be asked for next is evaluated with what is asked
for: the parts of all designs in the panel, and the halves of each. What is then asked for gets the same bits.
"""

from typing import Any

import numpy as np

from camopt.core.kernels.compile import PLAIN_RUN
from camopt.core.numerics.curve_kernels import JET_WORK, Evaluator, PartBounds, bound_parts, evaluate_points
from camopt.core.numerics.halving import POINT_WIDTH

HALF_LEVELS = 7  # of halves of a single part, that part included, which are evaluated together
LEAST_LEVELS = 5  # of halves of many parts
MOST_KEPT_PARTS = 100_000  # parts, of some 700 bytes each

WHOLE_PANEL = (0.0, 1.0)
PanelPart = tuple[int, float, float]
"""A design and a part of the panel: its middle and half its width, as u."""


class PanelCache:
    """Bounds of the parts of one panel, and values and slopes in their middles."""

    def __init__(self, curve: Any, panel: int) -> None:
        self.curve, self.panel = curve, panel
        self.bounds: dict[PanelPart, PartBounds] = {}
        self.points: dict[tuple[int, float], tuple[float, float]] = {}

    def evaluate_whole_panel(self, places: list[PanelPart]) -> None:
        """Evaluate the whole panel for those designs of some parts for which it is unknown."""
        designs = sorted({i for i, _, _ in places if (i, *WHOLE_PANEL) not in self.bounds})
        if designs:
            together = np.array(designs) if len(designs) > 1 else designs[0]  # an array of one takes longer
            PLAIN_RUN.count(JET_WORK * len(designs))
            whole = self.curve.part(self.curve.made, self.panel, *WHOLE_PANEL, together)
            self._store_bounds([(design, *WHOLE_PANEL) for design in designs], whole)
        self.first = places  # looked at when one of them is asked for: often the whole panel settles them

    def part(self, made: Any, panel: int, middle: float, reach: float, design: int) -> PartBounds:
        """As ``curve_kernels.part``."""
        place = (design, middle, reach)
        if reach == POINT_WIDTH:  # which is not halved
            PLAIN_RUN.count(JET_WORK)
            return self.curve.part(made, panel, middle, reach, design)  # type: ignore[no-any-return]
        if place not in self.bounds:
            self._evaluate_halves(self.first if place in self.first else [place])
        return self.bounds[place]

    def point(self, made: Any, panel: int, u: float, sign: float, design: int) -> tuple[float, float]:
        """As ``curve_kernels.point``."""
        if (design, u) not in self.points:
            PLAIN_RUN.count(1)
            return self.curve.point(made, panel, u, sign, design)  # type: ignore[no-any-return]
        value, slope = self.points[design, u]
        return sign * value, sign * slope

    def _evaluate_halves(self, places: list[PanelPart]) -> None:
        """Evaluate some parts, the halves that they may be cut into, and the points in their middles."""
        level = every = places
        for _ in range(max(HALF_LEVELS + 1 - len(places).bit_length(), LEAST_LEVELS) - 1):
            level = [(i, m + side * r / 2, r / 2) for i, m, r in level for side in (-1.0, 1.0)]
            every = every + level
        PLAIN_RUN.count((1 + JET_WORK) * len(every))
        designs, middles, reaches = map(np.array, zip(*every, strict=True))
        values, slopes = evaluate_points(self.curve.made, self.panel, middles, 1.0, designs)
        for (design, middle, _), *found in zip(every, values, slopes, strict=True):
            self.points[design, middle] = (found[0], found[1])
        self._store_bounds(every, bound_parts(self.curve.made, self.panel, middles, reaches, designs))

    def _store_bounds(self, places: list[PanelPart], found: PartBounds) -> None:
        columns = (np.broadcast_to(column, len(places)) for column in found)
        self.bounds.update(zip(places, map(PartBounds, *columns), strict=True))


class CachingEvaluator(Evaluator):
    """An evaluator that keeps what it knows of the panels of its curve, for the next question."""

    panels: dict[int, PanelCache]

    def prefetch_panel(self, panel: int, places: list[PanelPart]) -> PanelCache:
        """A panel that is to be cut into some parts."""
        if sum(len(each.bounds) for each in self.panels.values()) > MOST_KEPT_PARTS:
            self.panels.clear()
        if panel not in self.panels:
            self.panels[panel] = PanelCache(self, panel)
        self.panels[panel].evaluate_whole_panel(places)
        return self.panels[panel]


def caching_evaluator(curve: Evaluator) -> CachingEvaluator:
    """An evaluator of the same curve that keeps panels, and has none yet."""
    made = CachingEvaluator(*curve)
    made.panels = {}
    return made

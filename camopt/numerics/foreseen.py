"""Halving without a compiler: parts of a panel are evaluated many at a time, before they are needed.

The last resort of the search (``halving``) takes designs one by one. As machine code that is quick; uncompiled, one
part takes as long as some hundred in an array. So whatever may be asked for next is evaluated with what is asked
for: the parts of all designs in the panel, and the halves of each. What is then asked for gets the same bits.
"""

from typing import Any

import numpy as np

from camopt.kernels.compile import PLAIN_RUN
from camopt.numerics.evaluating import PartBounds, many_parts, many_points

HALF_LEVELS = 5  # of halves, that asked for included, which are evaluated together

WHOLE_PANEL = (0.0, 1.0)
PanelPart = tuple[int, float, float]
"""A design and a part of the panel: its middle and half its width, as u."""


class Prefetched:
    """Bounds of the parts of one panel, and oriented values and slopes in their middles."""

    def __init__(self, curve: Any, panel: int, sign: float, places: list[PanelPart]) -> None:
        self.curve, self.panel, self.sign = curve, panel, sign
        self.bounds: dict[PanelPart, PartBounds] = {}
        self.points: dict[tuple[int, float], tuple[float, float]] = {}
        designs = sorted({design for design, _, _ in places})
        together = np.array(designs) if len(designs) > 1 else designs[0]  # an array of one takes longer
        whole = curve.part(curve.made, panel, *WHOLE_PANEL, together)
        self._keep([(design, *WHOLE_PANEL) for design in designs], whole)
        self.first = places  # looked at when one of them is asked for: often the whole panel settles them

    def part(self, made: Any, panel: int, middle: float, reach: float, design: int) -> PartBounds:
        """As ``evaluating.part``."""
        place = (design, middle, reach)
        if place not in self.bounds:
            self._look(self.first if place in self.first else [place])
        return self.bounds[place]

    def point(self, made: Any, panel: int, u: float, sign: float, design: int) -> tuple[float, float]:
        """As ``evaluating.point``."""
        return self.points.get((design, u)) or self.curve.point(made, panel, u, sign, design)

    def _look(self, places: list[PanelPart]) -> None:
        """Evaluate some parts, and the halves that they may be cut into."""
        PLAIN_RUN.go_on()
        level = every = places
        for _ in range(HALF_LEVELS - 1):
            level = [(i, m + side * r / 2, r / 2) for i, m, r in level for side in (-1.0, 1.0)]
            every = every + level
        designs, middles, reaches = map(np.array, zip(*every, strict=True))
        self._keep(every, many_parts(self.curve.made, self.panel, middles, reaches, designs))
        values, slopes = many_points(self.curve.made, self.panel, middles, self.sign, designs)
        for (design, middle, _), *found in zip(every, values, slopes, strict=True):
            self.points[design, middle] = (found[0], found[1])

    def _keep(self, places: list[PanelPart], found: PartBounds) -> None:
        columns = (np.broadcast_to(column, len(places)) for column in found)
        self.bounds.update(zip(places, map(PartBounds, *columns), strict=True))

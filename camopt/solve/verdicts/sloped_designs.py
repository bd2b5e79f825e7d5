"""Boxes of designs as designs whose sizes are sloped intervals."""

from typing import Any

import numpy as np

from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import SlopedInterval, box_variables
from camopt.model.mechanisms import Designs


def sloped_boxes(box: Designs, inside: Designs, free: list[str], rows: int) -> tuple[Designs, SlopedInterval]:
    """Boxes as designs of sloped intervals, repeated ``rows`` times, and one of these intervals."""
    intervals: dict[str, Any] = box.values
    ends = [Interval(*(np.tile(getattr(intervals[n], end), rows) for end in ("low", "high"))) for n in free]
    sloped = dict(zip(free, box_variables(ends, [np.tile(inside.values[n], rows) for n in free]), strict=True))
    fixed = {n: np.tile(v, rows) for n, v in inside.values.items() if n not in free}
    return inside.with_values({**fixed, **sloped}), sloped[free[0]]

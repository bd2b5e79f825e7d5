"""Boxes of designs as designs whose sizes are sloped intervals."""

from typing import Any

import numpy as np

from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import SlopedInterval, box_variables
from camopt.model.mechanisms import Designs


def designs_of_sloped_intervals(
    box: Designs, inner_designs: Designs, free_names: list[str], repetitions: int
) -> tuple[Designs, SlopedInterval]:
    """Boxes as designs of sloped intervals, repeated ``repetitions`` times, and one of these intervals."""
    intervals: dict[str, Any] = box.values
    ends = [
        Interval(*(np.tile(getattr(intervals[n], end), repetitions) for end in ("low", "high"))) for n in free_names
    ]
    sloped = dict(
        zip(
            free_names,
            box_variables(ends, [np.tile(inner_designs.values[n], repetitions) for n in free_names]),
            strict=True,
        )
    )
    fixed = {n: np.tile(v, repetitions) for n, v in inner_designs.values.items() if n not in free_names}
    return inner_designs.with_values({**fixed, **sloped}), sloped[free_names[0]]

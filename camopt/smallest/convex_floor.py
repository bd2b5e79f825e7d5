"""A lower bound of the size where two angles are free and the size is convex in them.

Where the size has a closed form it is the largest of functions a + b/angleⁿ, b ≥ 0, or the least prime radius under
such: convex in the angles, as long as no stroke has a velocity at its ends. Between two angles it then lies above
the lines through its neighbours.
"""

from math import inf

import numpy as np

from camopt.mechanisms.design import SizeBounds
from camopt.motion.programme import law_peaks
from camopt.smallest.closed_form import closed_form
from camopt.smallest.turns import BestTurn, SegmentAngles

NEIGHBOUR_STEP = 1e-4  # deg between the neighbours of the optimum that prove it


def floor_if_convex(turns: SegmentAngles, bounds: SizeBounds, found: BestTurn) -> float:
    """A size that no cam undercuts, from sizes near the best turn; 0 where the size is not known to be convex."""
    box, total = turns.box, turns.scene_angles.sum()
    laws = [stroke.law for stroke in turns.programme(box.high).strokes if stroke.law is not None]
    if len(turns.freed) != 2 or any(law_peaks(law)["jumps"] == "velocity" for law in laws):
        return 0.0

    def size(angle: float) -> float | None:
        design = closed_form(turns.problem_of(np.array([angle, total - angle])), bounds)
        return None if design is None else float(design.size[0])

    near = [found.freed[0] + k * NEIGHBOUR_STEP for k in (-2, -1, 0, 1, 2)]
    angles = sorted({float(np.clip(angle, box.low[0], box.high[0])) for angle in near})
    sizes = [size(angle) for angle in angles]
    if len(angles) < 3 or any(value is None for value in sizes):
        return 0.0
    return convex_floor([float(box.low[0]), *angles, float(box.high[0])], [v for v in sizes if v is not None])


def convex_floor(angles: list[float], values: list[float]) -> float:
    """A lower bound of a convex function from its values at all of these places but the first and the last.

    Between two places it lies above the lines through the two to the left and through the two to the right.
    """
    ends, at = (angles[0], angles[-1]), angles[1:-1]
    lines = [
        _line(*pair)
        for pair in zip(zip(at, values, strict=True), list(zip(at, values, strict=True))[1:], strict=False)
    ]
    floor = inf
    for k, (left, right) in enumerate(zip([ends[0], *at], [*at, ends[1]], strict=True)):
        around = [lines[i] for i in (k - 2, k) if 0 <= i < len(lines)]
        floor = min(floor, _least_of_largest(around, left, right))
    return floor


TangentLine = tuple[float, float, float]
"""A place, the value there, and the slope."""


def _line(first: tuple[float, float], second: tuple[float, float]) -> TangentLine:
    return *first, (second[1] - first[1]) / (second[0] - first[0])


def _least_of_largest(lines: list[TangentLine], left: float, right: float) -> float:
    """The least value of the largest of one or two lines between two places."""

    def value(x: float) -> float:
        return max(v + slope * (x - at) for at, v, slope in lines)

    places = [left, right]
    if len(lines) == 2 and lines[0][2] != lines[1][2]:
        (a, v, s), (b, w, t) = lines
        places.append(min(max((w - t * b - v + s * a) / (s - t), left), right))
    return min(map(value, places))

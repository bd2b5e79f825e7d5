"""The smallest cam over the angles of a turn as well: freed segments share out the degrees that they have together.

A few turns, and a descent by the closed form if it decides, give a small cam. Where the size is convex in the
angles, lines prove it at once; elsewhere boxes of sizes and angles prove it, or find a smaller cam
(``turn_boxes``). Where they run out, a descent over the angles looks for one more.

Where the size has a closed form it is the largest of functions a + b/angleⁿ, b ≥ 0, or the least prime radius under
such: convex in the angles, as long as no stroke has a velocity at its ends. Between two angles it then lies above
the lines through its neighbours.
"""

from dataclasses import replace
from functools import reduce
from itertools import pairwise
from math import inf

import numpy as np

from camopt.core.numerics.clock import clock_seconds
from camopt.model.mechanisms.design import SizeBounds
from camopt.model.motion.programme import law_peaks
from camopt.solve.smallest.closed_form import closed_form_design
from camopt.solve.smallest.nelder_mead import NelderMead
from camopt.solve.smallest.result import SmallestCam
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.smallest.turn_boxes import TurnBoxSearch
from camopt.solve.smallest.turns import SegmentAngles, TurnOptimum, better_turn

NEIGHBOUR_STEP = 1e-4  # deg between the neighbours of the optimum that prove it


def smallest_over_turns(turns: SegmentAngles, bounds: SizeBounds) -> TurnOptimum:
    """The design of least size over the angles as well, with its proven gap."""
    none = TurnOptimum(SmallestCam(None, 0.0), turns.scene_angles)
    found = reduce(better_turn, (NelderMead(each, bounds).try_few_turns() for each in turns.turn_kinds), none)
    floors = []
    for each in turns.turn_kinds:
        found = _with_floor(found, floor_if_convex(each, bounds, found))
        if not found.answer.is_proved:
            search = TurnBoxSearch(each, bounds, found)
            found = TurnOptimum(search.run(), search.best_motion)
        floors.append(found.answer.floor)
    found = _with_floor(found, min(floors))
    if found.answer.is_proved:
        return found
    descended = (NelderMead(each, bounds, found).run() for each in turns.turn_kinds)
    return _with_floor(_solve_best_turn(turns, bounds, reduce(better_turn, descended, found)), min(floors))


def _solve_best_turn(turns: SegmentAngles, bounds: SizeBounds, found: TurnOptimum) -> TurnOptimum:
    """The smallest cam of a turn, which a descent only nears, if there is time."""
    if found.answer.design is None or clock_seconds() > turns.until:
        return found
    return better_turn(
        found,
        TurnOptimum(
            solve_smallest_cam(turns.problem_of(found.freed_angles), bounds, turns.until), found.freed_angles
        ),
    )


def _with_floor(found: TurnOptimum, floor: float) -> TurnOptimum:
    return TurnOptimum(replace(found.answer, floor=floor), found.freed_angles)


def floor_if_convex(turns: SegmentAngles, bounds: SizeBounds, found: TurnOptimum) -> float:
    """A size that no cam undercuts, from sizes near the best turn; 0 where the size is not known to be convex."""
    box, total = turns.box, turns.scene_angles.sum()
    laws = [stroke.law for stroke in turns.programme_of(box.high).strokes if stroke.law is not None]
    if len(turns.freed_segments) != 2 or any(law_peaks(law)["jumps"] == "velocity" for law in laws):
        return 0.0

    def size(angle: float) -> float | None:
        design = closed_form_design(turns.problem_of(np.array([angle, total - angle])), bounds)
        return None if design is None else float(design.size[0])

    near = [found.freed_angles[0] + k * NEIGHBOUR_STEP for k in (-2, -1, 0, 1, 2)]
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
    points = zip(at, values, strict=True)
    lines = [(*first, (second[1] - first[1]) / (second[0] - first[0])) for first, second in pairwise(points)]
    floor = inf
    for k, (left, right) in enumerate(zip([ends[0], *at], [*at, ends[1]], strict=True)):
        around = [lines[i] for i in (k - 2, k) if 0 <= i < len(lines)]
        floor = min(floor, _envelope_minimum(around, left, right))
    return floor


def _envelope_minimum(lines: list[tuple[float, float, float]], left: float, right: float) -> float:
    """The least value of the largest of one or two lines between two places.

    A line is a place, the value there, and the slope.
    """

    def value(x: float) -> float:
        return max(v + slope * (x - at) for at, v, slope in lines)

    places = [left, right]
    if len(lines) == 2 and lines[0][2] != lines[1][2]:
        (a, v, s), (b, w, t) = lines
        places.append(min(max((w - t * b - v + s * a) / (s - t), left), right))
    return min(map(value, places))

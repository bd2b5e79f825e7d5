"""The smallest cam over sizes and the angles of a turn; the freed segments share a fixed total of degrees.

A few turns, with a descent by the closed form if it decides, give a small cam. If the size is convex in the angles,
lines prove this cam at once. Otherwise boxes of sizes and angles prove it or find a smaller one (``turn_boxes``).
If the boxes do not finish, a descent over the angles tries to improve it.

A size with a closed form is the largest of functions a + b/angleⁿ, b ≥ 0, or the least prime radius under such
functions. It is convex in the angles if no stroke has a velocity at its ends. Between two angles it then lies above
the lines through neighbouring points.
"""

from dataclasses import replace
from functools import reduce
from itertools import pairwise
from math import inf

import numpy as np

from camopt.model.mechanisms.design import SizeBounds
from camopt.model.motion.programme import law_peaks
from camopt.solve.smallest.nelder_mead import INFEASIBLE_COST, NelderMead
from camopt.solve.smallest.result import SmallestCam
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.smallest.turn_boxes import TurnBoxSearch
from camopt.solve.smallest.turns import SegmentAngles, TurnOptimum, better_turn

NEIGHBOUR_STEP = 1e-4  # deg between the points near the optimum that prove it


def smallest_cam_over_turns(turns: SegmentAngles, bounds: SizeBounds) -> TurnOptimum:
    """The smallest design over sizes and angles, with its proved lower bound."""
    best = TurnOptimum(SmallestCam(None, 0.0), turns.scene_angles)
    best = reduce(
        better_turn,
        (NelderMead(kind, bounds).best_of_few_turns() for kind in turns.with_and_without_lowest_dwell),
        best,
    )
    floors = []
    for kind in turns.with_and_without_lowest_dwell:
        best = _with_size_lower_bound(best, size_lower_bound_if_convex(kind, bounds, best))
        if not best.answer.is_proved:
            search = TurnBoxSearch(kind, bounds, best)
            best = TurnOptimum(search.find_smallest_cam(), search.best_motion)
        floors.append(best.answer.floor)
    best = _with_size_lower_bound(best, min(floors))
    if best.answer.is_proved:
        return best
    descended = (NelderMead(kind, bounds, best).find_best_turn() for kind in turns.with_and_without_lowest_dwell)
    best = reduce(better_turn, descended, best)
    if best.answer.design is not None and not turns.budget.is_spent:  # a descent has only come near this cam
        answer = solve_smallest_cam(turns.problem_with_angles(best.freed_angles), bounds, turns.budget)
        best = better_turn(best, TurnOptimum(answer, best.freed_angles))
    return _with_size_lower_bound(best, min(floors))


def _with_size_lower_bound(turn: TurnOptimum, floor: float) -> TurnOptimum:
    return TurnOptimum(replace(turn.answer, floor=floor), turn.freed_angles)


def size_lower_bound_if_convex(turns: SegmentAngles, bounds: SizeBounds, best: TurnOptimum) -> float:
    """Lower bound of the size from sizes near the best turn [mm]; 0 if the size may not be convex."""
    box, total = turns.angle_box, turns.scene_angles.sum()
    laws = [stroke.law for stroke in turns.programme_with_angles(box.high).strokes if stroke.law is not None]
    if len(turns.freed_segments) != 2 or any(law_peaks(law)["jumps"] == "velocity" for law in laws):
        return 0.0

    near = [best.freed_angles[0] + k * NEIGHBOUR_STEP for k in (-2, -1, 0, 1, 2)]
    angles = sorted({float(np.clip(angle, box.low[0], box.high[0])) for angle in near})
    search = NelderMead(turns, bounds, best)
    sizes = [search.closed_form_size(np.array([angle, total - angle])) for angle in angles]
    if len(angles) < 3 or INFEASIBLE_COST in sizes:
        return 0.0
    return convex_lower_bound([float(box.low[0]), *angles, float(box.high[0])], sizes)


def convex_lower_bound(angles: list[float], values: list[float]) -> float:
    """Lower bound of a convex function, from its values at all of the angles except the first and the last.

    Between two angles the function lies above the line through the two points to the left, and above the line
    through the two points to the right.
    """
    ends, at = (angles[0], angles[-1]), angles[1:-1]
    points = zip(at, values, strict=True)
    lines = [(*first, (second[1] - first[1]) / (second[0] - first[0])) for first, second in pairwise(points)]
    floor = inf
    for k, (left, right) in enumerate(zip([ends[0], *at], [*at, ends[1]], strict=True)):
        floor = min(floor, _envelope_minimum([lines[i] for i in (k - 2, k) if 0 <= i < len(lines)], left, right))
    return floor


def _envelope_minimum(lines: list[tuple[float, float, float]], left: float, right: float) -> float:
    """Least value between two places of the maximum of one or two lines.

    Each line is a place, the value there, and the slope.
    """
    places = [left, right]
    if len(lines) == 2 and lines[0][2] != lines[1][2]:
        (a, v, s), (b, w, t) = lines
        places.append(min(max((w - t * b - v + s * a) / (s - t), left), right))
    return min(max(v + slope * (x - at) for at, v, slope in lines) for x in places)

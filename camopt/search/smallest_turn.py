"""The smallest cam over the angles of a turn as well: freed segments share out the degrees that they have together.

A stroke of a longer angle has a lower |y'| at the same displacement. Of every mechanism tan β = A(y) + B(y)·y', and
over a stroke |A| is largest at one of its ends, where a law at rest has y' = 0; tan β lies between A and its value
at a shorter angle, so no stroke's pressure angle grows with its angle. Nor do velocity, acceleration and jerk. So a
box of angles holds no cam smaller than that of the turn which gives each segment its longest angle of the box (a
turn of more than 360°), under these limits alone.

Where the size has a closed form it is the largest of functions a + b/angleⁿ, b ≥ 0, or the least prime radius under
such: convex in the angles. Between two angles it then lies above the lines through its neighbours.
"""

from dataclasses import replace
from functools import reduce
from heapq import heappop, heappush
from math import inf

import numpy as np

from camopt.mechanisms import translating_flat
from camopt.motion.programme import Programme, law_peaks
from camopt.motion.table import DWELL
from camopt.question import Question
from camopt.search.answer import Bounds, gap_of
from camopt.search.clock import now
from camopt.search.closed_form import closed_form, least_size
from camopt.search.descent import NARROW, descended
from camopt.search.smallest import small, smallest
from camopt.search.turns import Box, Found, Turns, better

MOST_TURNS = 200  # boxes of angles whose bound is computed
LOOKED_INTO = 40  # of them, whose middle is looked at too: the descent may have ended in the wrong valley
STEP = 1e-4  # deg between the neighbours of the optimum that prove it
EASED = ("velocity", "acceleration", "pressure_angle", "pressure_angle_return", "shaft_diameter")
FLAT = ("curvature_radius", "undercut")  # of a flat face that translates


def smallest_of_turns(turns: Turns, bounds: Bounds) -> Found:
    """The design of least size over the angles as well, with its proven gap."""
    answers = [_smallest_of_kind(each, bounds) for each in turns.kinds]
    found = reduce(better, answers)
    return Found(replace(found.answer, floor=min(answer.floor for answer, _ in answers)), found.freed)


def _smallest_of_kind(turns: Turns, bounds: Bounds) -> Found:
    """As ``smallest_of_turns``, where the follower rests at its lowest in all turns, or in none."""
    least = least_size(turns.question, turns.programme(turns.box.high), bounds)
    bounds = {**bounds, "size": (least, bounds["size"][1])}
    found = descended(turns, bounds)
    floor = _floor_if_convex(turns, bounds, found)
    if floor is None or found.answer.design is None:
        found, floor = _branched(turns, bounds, found)
    if found.answer.design is not None and not found.answer.proved:
        exact = smallest(turns.question, turns.programme(found.freed), bounds, turns.until)
        found = better(Found(exact, found.freed), found)
    return Found(replace(found.answer, floor=floor), found.freed)


def _eased(turns: Turns) -> tuple[str, ...]:
    """The limits that a longer angle of any segment never makes harder to hold."""
    question, box = turns.question, turns.box
    middle = turns.programme(turns.at(np.full(len(turns.freed), 0.5), box))
    jumps = {law_peaks(stroke.law)["jumps"] for stroke in middle.strokes if stroke.law is not None}
    if "velocity" in jumps:  # at the end of a stroke y' is not 0
        return ("shaft_diameter",)
    most = turns.programme(box.high)
    rests = any(stroke.kind == DWELL and stroke.low == 0.0 for stroke in most.strokes)
    flat = question.subject.mechanism is translating_flat.MECHANISM and (rests or "acceleration" not in jumps)
    jerk = () if "acceleration" in jumps else ("jerk",)  # jumps where strokes meet may cancel at some angles alone
    return (*EASED, *jerk, *(FLAT if flat else ()))


def _floor_if_convex(turns: Turns, bounds: Bounds, found: Found) -> float | None:
    """A lower bound of the size from its values near the optimum, where two angles are free and it is convex."""
    if len(turns.freed) != 2 or "pressure_angle" not in _eased(turns):
        return None
    box = turns.box
    total, least, most = turns.scene_angles.sum(), box.low[0], box.high[0]

    def size(angle: float) -> float | None:
        programme = turns.programme(np.array([angle, total - angle]))
        design = closed_form(turns.question, programme, bounds)
        return None if design is None else float(design.size[0])

    near = [found.freed[0] + k * STEP for k in (-2, -1, 0, 1, 2)]
    angles = sorted({float(np.clip(angle, least, most)) for angle in near})
    sizes = [size(angle) for angle in angles]
    if len(angles) < 3 or any(value is None for value in sizes):
        return None
    return max(convex_floor([least, *angles, most], [v for v in sizes if v is not None]), bounds["size"][0])


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


Line = tuple[float, float, float]
"""A place, the value there, and the slope."""


def _line(first: tuple[float, float], second: tuple[float, float]) -> Line:
    return *first, (second[1] - first[1]) / (second[0] - first[0])


def _least_of_largest(lines: list[Line], left: float, right: float) -> float:
    """The least value of the largest of one or two lines between two places."""

    def value(x: float) -> float:
        return max(v + slope * (x - at) for at, v, slope in lines)

    places = [left, right]
    if len(lines) == 2 and lines[0][2] != lines[1][2]:
        (a, v, s), (b, w, t) = lines
        places.append(min(max((w - t * b - v + s * a) / (s - t), left), right))
    return min(map(value, places))


def _branched(turns: Turns, bounds: Bounds, found: Found) -> tuple[Found, float]:
    """The best turn and a lower bound of the size, by bisection of boxes of angles, the least bound first."""
    eased = _eased(turns)
    limits = tuple(limit for limit in turns.question.limits if limit.name in eased)
    relaxed = replace(turns.question, limits=limits)
    heap: list[tuple[float, int, Box]] = []
    counted = 0

    def push(box: Box, least: float) -> None:
        nonlocal counted
        counted += 1
        floor = max(least, _floor(relaxed, turns.programme(box.high), bounds, turns.until))
        heappush(heap, (floor, counted, box))

    push(turns.box, bounds["size"][0])
    while heap and counted < MOST_TURNS and now() < turns.until:
        floor, _, box = heap[0]
        best = found.answer
        close = best.design is not None and floor >= best.size - gap_of(best.design)
        if close or np.all(box.high - box.low <= NARROW):
            break
        heappop(heap)
        for half in _halves(turns, box):
            if counted < LOOKED_INTO or len(turns.freed) > 2:
                freed = turns.at(np.full(len(turns.freed), 0.5), half)
                near = found.answer.design
                found = better(found, Found(small(turns.question, turns.programme(freed), bounds, near), freed))
            push(half, floor)
    return found, heap[0][0] if heap else inf


def _floor(relaxed: Question, programme: Programme, bounds: Bounds, until: float) -> float:
    """A lower bound of the size under the limits that are eased."""
    least = bounds["size"][0]
    if not any(limit.needs for limit in relaxed.limits):
        return least
    return smallest(relaxed, programme, bounds, until).floor


def _halves(turns: Turns, box: Box) -> list[Box]:
    """A box cut in two across its longest side."""
    side = int(np.argmax(box.high - box.low))
    middle = (box.low[side] + box.high[side]) / 2
    high, low = box.high.copy(), box.low.copy()
    high[side] = low[side] = middle
    return [turns.tightened(Box(box.low, high)), turns.tightened(Box(low, box.high))]

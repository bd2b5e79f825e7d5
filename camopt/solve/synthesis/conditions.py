"""The scene's conditions at cam angles as conditions on new laws, and the zero of displacements.

Moves may go anywhere between what they join. The lowest of them makes the size of the cam, so it has to be known:
where the lowest position that the scene gives may be a rest, no move goes below it. Else some move has to (one that
turns back between two stretches at constant velocity), and the lowest of the scene's own motion says where.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import start_position
from camopt.model.motion.stroke import Condition, Stroke
from camopt.scene.problem.problem import Problem

SAME_LEVEL = 1e-9  # of the lift: levels nearer than that are one
LOWEST_SAMPLES = 3601  # angles of a turn at which its lowest is looked for


class Ground(NamedTuple):
    """Where displacements are counted from."""

    strokes: tuple[Stroke, ...]
    zero: float
    """The position there, as given: mm, or deg."""
    unit: float
    """Of positions, in mm or rad."""
    dip: float | None
    """The cam angle where the motion is lowest, if no position that the scene gives need be."""


def ground_of(problem: Problem) -> Ground:
    """The lowest position that is given, or else that of the scene's own motion."""
    programme, unit = problem.programme.tool, problem.programme.tool.unit
    zero = start_position(problem.segments) - programme.start
    levels = _levels(programme)
    lowest = min(levels.kept)
    beyond = [low for low in (*levels.left, *levels.allowed) if low < lowest + SAME_LEVEL * programme.lift]
    rests = not any(low in levels.left or low < lowest - SAME_LEVEL * programme.lift for low in beyond)
    if not rests:
        angles = np.linspace(0.0, programme.strokes[-1].end, LOWEST_SAMPLES)
        return Ground(programme.strokes, zero, unit, float(angles[programme.at(angles)[0].argmin()]))
    if lowest == 0.0:
        return Ground(programme.strokes, zero, unit, None)
    moved = tuple(replace(s, low=s.low - lowest, high=s.high - lowest) for s in programme.strokes)
    return Ground(moved, zero + lowest / unit, unit, None)


class Levels(NamedTuple):
    """The displacements that a scene gives."""

    kept: list[float]
    """Those of a joint, or an angle."""
    left: list[float]
    """Those among them that the motion leaves with a velocity."""
    allowed: list[float]
    """The lowest of ranges, where the motion may be."""


def _levels(programme: Programme) -> Levels:
    """The displacements that a scene gives, and whether the motion may rest there."""
    found = Levels([], [], [])
    for stroke in programme.strokes:
        if not (stroke.is_move and stroke.is_free):
            found.kept.extend((stroke.low, stroke.high))
            found.left.extend((stroke.low, stroke.high) if stroke.is_move else ())
            continue
        asked = list(stroke.asked(programme.strokes[0].low))
        for each in asked:
            if each.order == 0 and each.low == each.high:
                found.kept.append(each.low)
                found.left.extend([] if _may_rest(asked, each.start) else [each.low])
            elif each.order == 0 and isfinite(each.low):
                found.allowed.append(each.low)
    return found


def _may_rest(asked: Sequence[Condition], angle: float) -> bool:
    """Whether nothing that is asked at a cam angle gives a velocity there."""
    here = [each for each in asked if each.order == 1 and each.start <= angle <= each.end]
    return all(each.low <= 0.0 <= each.high for each in here)


def conditions_of(ground: Ground) -> Iterator[Condition]:
    """The conditions at the ends of moves and on their way; none goes below the lowest position."""
    for stroke in ground.strokes:
        if not (stroke.is_move and stroke.is_free):
            continue
        yield from stroke.asked(ground.strokes[0].low)
        if ground.dip is None:
            yield Condition("the lowest position", 0, stroke.start, stroke.end, 0.0, inf)

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


class DisplacementOrigin(NamedTuple):
    """Where displacements are counted from."""

    strokes: tuple[Stroke, ...]
    zero: float
    """The position there, as given: mm, or deg."""
    unit: float
    """Of positions, in mm or rad."""
    lowest_angle: float | None
    """The cam angle where the motion is lowest, if no position that the scene gives need be."""


def displacement_origin(scene_problem: Problem) -> DisplacementOrigin:
    """The lowest position that is given, or else that of the scene's own motion."""
    programme, unit = scene_problem.programme.tool, scene_problem.programme.tool.unit
    zero = start_position(scene_problem.segments) - programme.start
    levels = _given_levels(programme)
    lowest = min(levels.given_levels)
    beyond = [
        low for low in (*levels.moving_levels, *levels.range_minima) if low < lowest + SAME_LEVEL * programme.lift
    ]
    rests = not any(low in levels.moving_levels or low < lowest - SAME_LEVEL * programme.lift for low in beyond)
    if not rests:
        angles = np.linspace(0.0, programme.strokes[-1].end, LOWEST_SAMPLES)
        return DisplacementOrigin(
            programme.strokes, zero, unit, float(angles[programme.motion_at(angles)[0].argmin()])
        )
    if lowest == 0.0:
        return DisplacementOrigin(programme.strokes, zero, unit, None)
    moved = tuple(replace(s, low=s.low - lowest, high=s.high - lowest) for s in programme.strokes)
    return DisplacementOrigin(moved, zero + lowest / unit, unit, None)


class GivenLevels(NamedTuple):
    """The displacements that a scene gives."""

    given_levels: list[float]
    """Those of a joint, or an angle."""
    moving_levels: list[float]
    """Those among them that the motion leaves with a velocity."""
    range_minima: list[float]
    """The lowest of ranges, where the motion may be."""


def _given_levels(programme: Programme) -> GivenLevels:
    """The displacements that a scene gives, and whether the motion may rest there."""
    found = GivenLevels([], [], [])
    for stroke in programme.strokes:
        if not (stroke.is_move and stroke.is_free):
            found.given_levels.extend((stroke.low, stroke.high))
            found.moving_levels.extend((stroke.low, stroke.high) if stroke.is_move else ())
            continue
        asked = list(stroke.required_conditions(programme.strokes[0].low))
        for each in asked:
            if each.order == 0 and each.low == each.high:
                found.given_levels.append(each.low)
                found.moving_levels.extend([] if _may_rest(asked, each.start) else [each.low])
            elif each.order == 0 and isfinite(each.low):
                found.range_minima.append(each.low)
    return found


def _may_rest(asked: Sequence[Condition], angle: float) -> bool:
    """Whether nothing that is asked at a cam angle gives a velocity there."""
    here = [each for each in asked if each.order == 1 and each.start <= angle <= each.end]
    return all(each.low <= 0.0 <= each.high for each in here)


def motion_conditions(ground: DisplacementOrigin) -> Iterator[Condition]:
    """The conditions at the ends of moves and on their way; none goes below the lowest position."""
    for stroke in ground.strokes:
        if not (stroke.is_move and stroke.is_free):
            continue
        yield from stroke.required_conditions(ground.strokes[0].low)
        if ground.lowest_angle is None:
            yield Condition("the lowest position", 0, stroke.start, stroke.end, 0.0, inf)

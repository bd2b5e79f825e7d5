"""Conditions of a scene at cam angles, as conditions on new laws, and the origin of displacements.

Free moves may go anywhere between their ends. The lowest of them decides the size of the cam, so it must be known.
If the motion may rest at the lowest position that the scene gives, no move goes below it. Otherwise a move must go
below it, such as one that turns back between two stretches of constant velocity. The scene's own motion then shows
where it is lowest.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from camopt.model.motion.programme import Programme
from camopt.model.motion.segments import start_position
from camopt.model.motion.stroke import Condition, Stroke
from camopt.scene.problem.problem import Problem

SAME_LEVEL = 1e-9  # positions closer than this share of the lift are equal
LOWEST_SAMPLES = 3601  # cam angles of a turn at which the lowest position is searched


class DisplacementOrigin(NamedTuple):
    """The strokes with displacements from a lowest position, and where that is."""

    strokes: tuple[Stroke, ...]
    zero: float
    """The lowest position, as the scene gives it [mm or deg]."""
    unit: float
    """Size of one mm or deg of a position [mm or rad]."""
    lowest_angle: float | None
    """Cam angle where the motion is lowest [rad], if no given position is the lowest; None otherwise."""


def origin_at_lowest_position(scene_problem: Problem) -> DisplacementOrigin:
    """The lowest position that the scene gives, or else that of the scene's own motion."""
    programme, unit = scene_problem.programme.tool, scene_problem.programme.tool.unit_in_mm_or_rad
    zero = start_position(scene_problem.segments) - programme.start
    given_levels, moving_levels, range_minima = _displacements_given_by_scene(programme)
    lowest, rounding = min(given_levels), SAME_LEVEL * programme.lift
    if any(level < lowest + rounding for level in moving_levels) or any(
        level < lowest - rounding for level in range_minima
    ):  # the motion may not rest at the lowest
        angles = np.linspace(0.0, programme.strokes[-1].end, LOWEST_SAMPLES)
        return DisplacementOrigin(
            programme.strokes, zero, unit, float(angles[programme.motion_at(angles)[0].argmin()])
        )
    if lowest == 0.0:
        return DisplacementOrigin(programme.strokes, zero, unit, None)
    strokes = tuple(
        replace(stroke, low=stroke.low - lowest, high=stroke.high - lowest) for stroke in programme.strokes
    )
    return DisplacementOrigin(strokes, zero + lowest / unit, unit, None)


def _displacements_given_by_scene(programme: Programme) -> tuple[list[float], list[float], list[float]]:
    """Displacements that a scene gives: all, those passed with a velocity, and the lower ends of ranges."""
    given_levels, moving_levels, range_minima = list[float](), list[float](), list[float]()
    for stroke in programme.strokes:
        if not (stroke.is_move and stroke.is_law_replaceable):
            given_levels += (stroke.low, stroke.high)
            moving_levels += (stroke.low, stroke.high) if stroke.is_move else ()
            continue
        conditions = list(stroke.conditions_in_mm_or_rad(programme.strokes[0].low))
        for condition in conditions:
            if condition.order == 0 and condition.low == condition.high:
                given_levels.append(condition.low)
                if any(
                    velocity.order == 1
                    and velocity.start <= condition.start <= velocity.end
                    and not velocity.low <= 0.0 <= velocity.high
                    for velocity in conditions
                ):
                    moving_levels.append(condition.low)
            elif condition.order == 0 and isfinite(condition.low):
                range_minima.append(condition.low)
    return given_levels, moving_levels, range_minima


def conditions_on_free_moves(origin: DisplacementOrigin) -> Iterator[Condition]:
    """Conditions on free moves, at their ends and between; none goes below a known lowest position."""
    for stroke in origin.strokes:
        if stroke.is_move and stroke.is_law_replaceable:
            yield from stroke.conditions_in_mm_or_rad(origin.strokes[0].low)
            if origin.lowest_angle is None:
                yield Condition("the lowest position", 0, stroke.start, stroke.end, 0.0, inf)

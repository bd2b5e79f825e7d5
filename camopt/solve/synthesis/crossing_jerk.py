"""The jerk of a motion where the force turns round, and which scenes may ask for it; ``crossings`` says why.

No programme is written here, so that pages and comparisons do without cvxpy.
"""

from collections.abc import Sequence
from math import inf

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import RETURN, RISE, Stroke
from camopt.scene.problem.problem import Problem
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, StrokeCrossing

JERK_SAMPLES = 2001  # places of a stroke
ZERO_ACCELERATION = 1e-6  # of the largest acceleration: less is none


def check_crossings(scene_problem: Problem) -> None:
    """BadInput if the force on the follower is not that of its mass alone, or it has no clearance to cross."""
    own, key = scene_problem.setup.dynamics, "synthesis.minimise"
    loaded = scene_problem.programme.load is not None or any((own.stiffness, own.damping, own.load, own.preload))
    what = None
    if not scene_problem.setup.given.drive.clearance:
        what = "needs drive.clearance, which the roller crosses"
    elif loaded:
        what = "is of a follower without spring, damping and load, whose force turns round with its acceleration"
    elif scene_problem.setup.train is not None or any(
        each.is_move for each in scene_problem.programme.tool.strokes
    ):
        what = "is of rises and returns of the follower itself, without moves and without a train"
    if what:
        raise BadInput([Mistake(scene_problem.file, key, CROSSING_JERK, what, bare=True)])


def crossing_jerk(programme: Programme, window: float, placed: Sequence[StrokeCrossing] = ()) -> float:
    """The largest |y'''|, by rad, over an angle from where the force of a mass turns round in each stroke.

    The places are those given, or else those of the motion itself; infinite where y'' jumps there.
    """
    known = {each.stroke: each.low for each in placed}
    found = [0.0]
    for number, stroke in enumerate(programme.strokes):
        if stroke.kind in (RISE, RETURN):
            starts = [known[number]] if number in known else _force_reversals(stroke)
            found += [_largest_jerk_in_window(programme, stroke, x, window) for x in starts]
    return max(found)


def _force_reversals(stroke: Stroke) -> list[float]:
    """Where in a stroke the acceleration begins to have the other sign than that with which the stroke began."""
    x = np.linspace(0.0, 1.0, JERK_SAMPLES)
    y2 = stroke.motion(stroke.start + x * stroke.angle)[2]
    sign = np.sign(np.where(np.abs(y2) > ZERO_ACCELERATION * np.abs(y2).max(), y2, 0.0))
    moving = np.flatnonzero(sign)
    changes = moving[1:][sign[moving[1:]] != sign[moving[:-1]]]
    return [float(x[each - 1]) for each in changes]


def _largest_jerk_in_window(programme: Programme, stroke: Stroke, x: float, window: float) -> float:
    start = stroke.start + x * stroke.angle
    end = min(start + window, stroke.end)
    if any(jump.order <= 2 and start - 1e-9 < jump.at < end + 1e-9 for jump in programme.jumps):
        return inf
    inside = start + (np.arange(JERK_SAMPLES) + 0.5) / JERK_SAMPLES * (end - start)  # the jerk may jump at the ends
    return float(np.abs(stroke.motion(inside)[3]).max())

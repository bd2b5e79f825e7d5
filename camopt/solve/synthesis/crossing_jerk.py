"""The jerk of a motion where its force changes its sign, and the scenes that can minimise it (see ``crossings``).

This module states no convex programme, so that pages and comparisons need no cvxpy.
"""

from collections.abc import Sequence
from math import inf

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import RETURN, RISE, Stroke
from camopt.scene.problem.problem import Problem
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, StrokeCrossing

JERK_SAMPLES = 2001  # samples of a stroke
ZERO_ACCELERATION = 1e-6  # share of the largest acceleration that counts as zero


def check_crossing_jerk_applies(scene_problem: Problem) -> None:
    """BadInput if the force on the follower is not its inertia alone, or if it has no clearance to cross."""
    dynamics, key = scene_problem.setup.dynamics, "synthesis.minimise"
    has_load = scene_problem.programme.load is not None or any(
        (dynamics.stiffness, dynamics.damping, dynamics.load, dynamics.preload)
    )
    what = None
    if not scene_problem.setup.given.drive.clearance:
        what = "needs drive.clearance, which the roller crosses"
    elif has_load:
        what = "needs a follower without spring, damping and load: its force then has the sign of its acceleration"
    elif scene_problem.setup.train is not None or any(
        stroke.is_move for stroke in scene_problem.programme.tool.strokes
    ):
        what = "needs rises and returns of the follower itself, without moves and without a train"
    if what:
        raise BadInput([Mistake(scene_problem.file, key, CROSSING_JERK, what, bare=True)])


def largest_jerk_after_crossings(
    programme: Programme, window_angle: float, known_crossings: Sequence[StrokeCrossing] = ()
) -> float:
    """Largest |y'''|, per rad³, within an angle after the force of a mass changes its sign in each stroke.

    ``known_crossings`` gives the crossings of some strokes; other strokes cross where their own acceleration
    changes its sign. The jerk is infinite if y'' jumps there.
    """
    known_starts = {crossing.stroke: crossing.low for crossing in known_crossings}
    jerks = [0.0]
    for number, stroke in enumerate(programme.strokes):
        if stroke.kind in (RISE, RETURN):
            starts = [known_starts[number]] if number in known_starts else _x_of_acceleration_sign_changes(stroke)
            jerks += [_largest_jerk_in_window_after_x(programme, stroke, x, window_angle) for x in starts]
    return max(jerks)


def _x_of_acceleration_sign_changes(stroke: Stroke) -> list[float]:
    """The x at which the acceleration of a stroke changes its sign."""
    x = np.linspace(0.0, 1.0, JERK_SAMPLES)
    y2 = stroke.motion(stroke.start + x * stroke.angle)[2]
    sign = np.sign(np.where(np.abs(y2) > ZERO_ACCELERATION * np.abs(y2).max(), y2, 0.0))
    nonzero = np.flatnonzero(sign)
    changes = nonzero[1:][sign[nonzero[1:]] != sign[nonzero[:-1]]]
    return [float(x[index - 1]) for index in changes]


def _largest_jerk_in_window_after_x(programme: Programme, stroke: Stroke, x: float, window_angle: float) -> float:
    """Largest |y'''| from x of a stroke over a cam angle ``window_angle``; infinite if y'' jumps there."""
    start = stroke.start + x * stroke.angle
    end = min(start + window_angle, stroke.end)
    if any(jump.order <= 2 and start - 1e-9 < jump.at < end + 1e-9 for jump in programme.jumps):
        return inf
    angles = start + (np.arange(JERK_SAMPLES) + 0.5) / JERK_SAMPLES * (end - start)  # the jerk may jump at the ends
    return float(np.abs(stroke.motion(angles)[3]).max())

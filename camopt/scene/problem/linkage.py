"""Where the links of a train are, and where its follower drives them.

Scenes do not say where a linkage is mounted: links are put one after the other, each on the far side of what drives
it.
"""

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.tool_drive import tool_position
from camopt.model.trains.sketch import LinkSketch, Port
from camopt.scene.problem.problem import Problem


def follower_pivot(problem: Problem) -> complex:
    """The pivot of an oscillating follower, mm: from the axis of a disc cam, on a surface that is developed."""
    design = problem.design
    if not problem.setup.mechanism.body.developed:
        return complex(design.centre_distance[0])
    return complex(design.sense * float(design.arm_length[0]) * np.cos(problem.programme.lift / 2))


def outward_turn_sense(problem: Problem) -> float:
    """Which way an oscillating follower turns as it goes outward: 1 anticlockwise, −1 clockwise."""
    return -problem.design.sense if problem.setup.mechanism.body.developed else -1.0


def linkage_sketch(problem: Problem, angles: FloatArray, at: complex, size: float) -> LinkSketch | None:
    """The train of a problem at cam angles, rad, driven ``at`` a place of the first of them; None without a train.

    Where its follower swings that is its pivot, and where it slides the end of its stem. What has no length of its
    own goes by ``size``, mm.
    """
    train = problem.setup.train
    if train is None:
        return None
    moved = train.follower_at(tool_position(problem.programme, angles))
    if not problem.setup.angular:
        return train.sketch(moved, Port(at - 1j * float(moved[0]), 1j), size)
    return train.sketch(moved, Port(at, -outward_turn_sense(problem), outward_turn_sense(problem)), size)

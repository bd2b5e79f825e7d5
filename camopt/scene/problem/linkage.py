"""Places of the links of a train, for pictures.

A scene does not say where its linkage is mounted. Links are placed in order, each on the far side of its driver.
"""

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.tool_drive import tool_position
from camopt.model.trains.sketch import LinkSketch, Port
from camopt.scene.problem.problem import Problem


def follower_pivot(problem: Problem) -> complex:
    """The pivot of an oscillating follower [mm]: from the axis of a disc cam, or on the developed cylinder."""
    design = problem.design
    if not problem.setup.mechanism.body.developed:
        return complex(design.centre_distance[0])
    return complex(design.sense * float(design.arm_length[0]) * np.cos(problem.programme.lift / 2))


def outward_turn_sense_of_follower(problem: Problem) -> float:
    """Sense in which an oscillating follower turns outward: 1 anticlockwise, −1 clockwise."""
    return -problem.design.sense if problem.setup.mechanism.body.developed else -1.0


def linkage_sketch(
    problem: Problem, angles: FloatArray, pivot_or_stem_end: complex, default_length: float
) -> LinkSketch | None:
    """Sketch of the links of a problem's train at cam angles [rad]; None without a train.

    ``pivot_or_stem_end`` is the pivot of an oscillating follower, or the end of the stem of a translating one at
    the first angle. ``default_length`` [mm] replaces lengths that the scene does not have.
    """
    train = problem.setup.train
    if train is None:
        return None
    positions = train.follower_displacement_at(tool_position(problem.programme, angles))
    if not problem.setup.angular:
        return train.sketch(positions, Port(pivot_or_stem_end - 1j * float(positions[0]), 1j), default_length)
    return train.sketch(
        positions,
        Port(pivot_or_stem_end, -outward_turn_sense_of_follower(problem), outward_turn_sense_of_follower(problem)),
        default_length,
    )

"""Where the follower of a disc cam is when it touches a point of the profile: ``geometry.cam_curves`` inverted.

A round follower of the radius R_r that touches the profile at p, where its outward normal is n, has its centre at

    T = p + R_r·n,

and is as high as that of a cam with the prime radius |T| on its base circle. A flat face there is at the distance
p·n from the axis, as on a cam with this base radius. The cam has turned until T, or n, is where it is on that cam.

The position of a translating follower is the height of its trace point or face above the axis, that of an
oscillating one the angle ψ of its arm or face. If a point is off by δ along the normal, a flat translating face is
off by δ, and a round translating follower by δ/cos β. An error ε of the normal's direction has an effect of ε²
only: the follower then touches the same curve beside the point.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7, the other way round.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from camopt.mechanisms.design import Designs
from camopt.mechanisms.oscillating_flat import first_sine
from camopt.numerics import BoolArray, ComplexArray, FloatArray
from camopt.problem.problem import Problem


class Contacts(NamedTuple):
    """A follower on a profile: cam angles (rad), positions (mm; rad when oscillating), whether it can be there."""

    angles: FloatArray
    positions: FloatArray
    possible: BoolArray


def touching(problem: Problem, profile: ComplexArray, normals: ComplexArray) -> Contacts:
    """The follower of a problem, whose motion does not count, where it touches points with outward normals."""
    mechanism, design = problem.setup.mechanism, problem.design
    trace = profile + design.roller_radius[0] * normals
    flat = mechanism.flat_faced
    reach = (profile * normals.conjugate()).real if flat else np.abs(trace) - design.roller_radius[0]
    same = design.take(np.zeros(profile.size, dtype=int))
    on_base = replace(same, size=reach)
    possible = mechanism.exists(on_base, problem.programme)
    with np.errstate(invalid="ignore"):
        ground = mechanism.travel(on_base, problem.programme, np.zeros(profile.size))
        seen = (ground.normal, normals) if flat else (ground.trace, trace)
        angles = design.sense * np.angle(seen[0] * seen[1].conjugate())
        return Contacts(angles, position_of(problem, on_base), possible)


def position_of(problem: Problem, designs: Designs) -> FloatArray:
    """The position of the follower on the base circles of designs."""
    if problem.setup.mechanism.start is not None:
        return np.asarray(problem.setup.mechanism.start(designs))
    return np.arcsin(first_sine(designs)) if problem.setup.angular else designs.size


def base_radius(problem: Problem, position: float) -> float:
    """The base radius of a cam on whose base circle the follower has a position: the inverse of ``position_of``."""
    mechanism, design = problem.setup.mechanism, problem.design
    if mechanism.trace_point is not None:
        return float(np.hypot(*mechanism.trace_point(design, position))[0] - design.roller_radius[0])
    if problem.setup.angular:
        return float(design.face_offset[0] + design.centre_distance[0] * np.sin(position))
    return position

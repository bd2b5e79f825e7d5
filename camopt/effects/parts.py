"""The profile of a disc cam in parts: each inside a disc and close to a straight line, its tangents inside a cone.

For a follower with a trace point, on a cam that is not undercut. Over the part [m − h, m + h] of the turn the pitch
curve p has |p'(θ) − p'(m)| ≤ h·sup|p''|. So its direction, which is the profile's too, stays within
δ = arcsin(h·sup|p''|/|p'(m)|) of that in the middle, and the profile within h·(|p'(m)| + h·sup|p''|) + R_r·δ of its
middle point. The trace point moves along a line, or on a circle about the pivot, so that sup|p''| follows from
the bounds of y' and y'' in the motion's panels. In double precision, with a margin for rounding.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.effects.case import Subject
from camopt.mechanisms.design import ComplexArray, Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray

IntArray = NDArray[np.int64]
WIDEST = np.pi / 100  # half of the cam angle of a first part
ROUNDING = 1e-12  # relative to the size of the cam, thousands of times what the formulas lose


class Parts(NamedTuple):
    """Parts of the turn (n,), in order: cam angles in rad, bounds of |y'| and |y''| in each."""

    middle: FloatArray
    half: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def split(self, into: IntArray) -> "Parts":
        """Each part in so many equal ones."""
        start, half, *bounds = (np.repeat(x, into) for x in (self.middle - self.half, self.half / into, *self[2:]))
        place = np.arange(half.size) - np.repeat(np.cumsum(into) - into, into)
        return Parts(start + (2 * place + 1) * half, half, *bounds)


def first_parts(programme: Programme) -> Parts:
    """The panels of the motion, or parts of them: a jump of y' or y'' lies between two parts."""
    table = programme.table
    most = table.most[: table.centre.size]  # the rest is of groups of panels
    panels = Parts(table.centre, table.half_width, most[:, 1], most[:, 2])
    return panels.split(np.ceil(table.half_width / WIDEST).astype(int))


class Cover(NamedTuple):
    """What encloses the profile over parts: arrays (..., n), lengths in mm, angles in rad."""

    point: ComplexArray
    """The profile in the middle of the part."""
    tangent: ComplexArray
    """Its direction there, of length 1."""
    normal: ComplexArray
    spread: FloatArray
    """How far its direction is from that in the middle, at most; π if nothing is known."""
    radius: FloatArray
    """How far it is from the middle point, at most."""
    bulge: FloatArray
    """How far it is from the tangent in the middle point, at most."""
    rounding: FloatArray
    """How exact its points are."""

    def take(self, index: IntArray) -> "Cover":
        """Some of the parts."""
        return self._replace(**{name: values[index] for name, values in self._asdict().items()})


def cover(subject: Subject, design: Designs, programme: Programme, parts: Parts) -> Cover:
    """Enclose the profile of one design, or of several, (n, 1) each, over parts of the turn."""
    trace = subject.mechanism.travel(design, programme, parts.middle).trace
    lever = 1j * (design.centre_distance - trace) if subject.angular else 1j  # of the trace point by y
    reach, distance = np.abs(lever), np.abs(trace)
    velocity = lever * programme.at(parts.middle)[1] - 1j * design.sense * trace
    speed = np.abs(velocity)
    swing = np.square(parts.velocity) if subject.angular else 0.0
    bend = reach * (parts.acceleration + swing + (2.0 + parts.half) * parts.velocity) + distance
    rounding = ROUNDING * (distance + reach * parts.velocity + design.roller_radius)
    ratio = (parts.half * bend + rounding) / speed
    spread = np.where(ratio < 1.0, np.arcsin(np.minimum(ratio, 1.0)), np.pi)
    turn = np.exp(-1j * design.sense * parts.middle)
    tangent = turn * velocity / speed
    normal = 1j * design.sense * tangent
    point = turn * trace - design.roller_radius * normal
    shift = design.roller_radius * np.minimum(spread, 2.0)
    radius = parts.half * (speed + parts.half * bend) + shift + rounding
    bulge = radius * np.sin(np.minimum(spread, np.pi / 2)) + rounding
    return Cover(point, tangent, normal, spread, radius, bulge, rounding)

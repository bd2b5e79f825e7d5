"""The profile of a disc cam in parts: each inside a disc and close to a straight line, its tangents inside a cone.

For a follower with a trace point, on a cam that is not undercut. Over the part [m − h, m + h] of the turn the pitch
curve p has |p'(θ) − p'(m)| ≤ h·sup|p''|. So its direction, which is the profile's too, stays within
δ = arcsin(h·sup|p''|/|p'(m)|) of that in the middle, and the profile within h·(|p'(m)| + h·sup|p''|) + R_r·δ of its
middle point. The trace point moves along a line, or on a circle about the pivot, so that sup|p''| follows from
the bounds of y' and y'' in the motion's panels. In double precision, with a margin for rounding.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.effects.case import Subject
from camopt.mechanisms.design import ComplexArray, Designs
from camopt.mechanisms.oscillating import first_angle
from camopt.mechanisms.translating import height
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.interval import as_interval

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
    slowest: FloatArray
    """The least speed of the trace point over the cam, mm/rad; 0 or less if nothing is known."""

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
    slowest = speed - parts.half * bend - rounding
    return Cover(point, tangent, normal, spread, radius, bulge, rounding, slowest)


Ends = Sequence[ComplexArray]
"""Where parts of a profile start, and where they end."""


def ends_of(subject: Subject, design: Designs, programme: Programme, parts: Parts) -> Ends:
    """The ends of parts of the profile of one design, or of several, (n, 1) each."""
    angles = np.concatenate([parts.middle - parts.half, parts.middle + parts.half], axis=-1)
    return np.split(points_at(subject, design, programme, angles), 2, axis=-1)


def points_at(subject: Subject, design: Designs, programme: Programme, angles: FloatArray) -> ComplexArray:
    """The profile of one design, or of several, (n, 1) each, at cam angles in rad."""
    travel = subject.mechanism.travel(design, programme, np.mod(angles, 2 * np.pi))
    turn = np.exp(-1j * design.sense * angles)
    return np.asarray(turn * (travel.trace - design.roller_radius * travel.normal))


def drift(subject: Subject, design: Designs, box: Designs, parts: Parts, found: Cover) -> FloatArray:
    """How far the profiles of a box of designs (Intervals) are from that of one of them at each cam angle, at most.

    Over each part, (n,), in mm. If the trace point moves by ΔT, and its lever changes by ΔK, its velocity v over
    the cam changes by Δv = |y'|·ΔK + ΔT at most, and the normal turns by no more than arcsin(Δv/|v|).
    """

    def change(name: str) -> Any:
        side = as_interval(getattr(box, name))
        return np.maximum(side.high - design.sizes[name], design.sizes[name] - side.low)

    if subject.angular:
        start = as_interval(first_angle(box))
        pivot = change("centre_distance")
        trace = pivot + change("arm_length") + as_interval(box.arm_length).high * (start.high - start.low)
        lever = pivot + trace
    else:
        heights = as_interval(height(box))
        trace, lever = np.hypot(change("offset"), heights.high - heights.low), 0.0
    ratio = (lever * parts.velocity + trace) / np.maximum(found.slowest, 1e-300)
    turned = np.where(ratio < 1.0, np.arcsin(np.minimum(ratio, 1.0)), 2.0)
    moved = trace + change("roller_radius") + design.roller_radius * turned + found.rounding
    return np.asarray(moved)

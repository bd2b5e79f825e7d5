"""Enclosures of a disc cam's profile in parts: each part is within a disc and a strip, its tangents within a cone.

They are for a follower with a trace point, and a cam that is not undercut. Over the part [m − h, m + h] of the turn
the pitch curve p has |p'(θ) − p'(m)| ≤ h·sup|p''|. So its direction, which is that of the profile too, stays within
δ = arcsin(h·sup|p''|/|p'(m)|) of the direction in the middle. The profile stays within
h·(|p'(m)| + h·sup|p''|) + R_r·δ of its middle point, and within ½h²·sup|p''| + R_r·(1 − cos δ) of the tangent at
that point. The trace point moves along a line or on a circle about the pivot, so sup|p''| follows from bounds of y'
and y''. All is computed in double precision, with a margin for rounding.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import ComplexArray, FloatArray, IntArray, Number
from camopt.core.numerics.piecewise import MotionTable
from camopt.model.effects.effect import Setup
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import Programme

HALF_PART = np.pi / 100  # half the cam angle of an initial part
PART_ERROR = 2e-14  # of the size of the cam, besides the motion's error: tens of times the rounding of the formulas


class TurnParts(NamedTuple):
    """Parts of the turn (n,) in order: cam angles [rad], and bounds of |y'|, |y''| and of errors in each part."""

    middle: FloatArray
    half: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    error: FloatArray
    """Error of y and y'."""

    def split(self, part_counts: IntArray) -> "TurnParts":
        """The parts, each cut into a number of equal parts; 0 leaves a part out."""
        halves = self.half / np.maximum(part_counts, 1)
        start, half, *bounds = (np.repeat(x, part_counts) for x in (self.middle - self.half, halves, *self[2:]))
        place = np.arange(half.size) - np.repeat(np.cumsum(part_counts) - part_counts, part_counts)
        return TurnParts(start + (2 * place + 1) * half, half, *bounds)


def initial_turn_parts(programme: Programme) -> TurnParts:
    """The panels of the motion, or parts of them; jumps of y' or y'' are between two parts."""
    table = programme.table
    most, error = (rows[: table.centre.size] for rows in (table.most, table.error))  # other rows belong to groups
    panels = TurnParts(table.centre, table.half_width, most[:, 1], most[:, 2], np.max(error[:, :2], axis=1))
    return panels.split(np.ceil(table.half_width / HALF_PART).astype(int))


class ProfileEnclosure(NamedTuple):
    """Enclosures of the profile over parts: arrays (..., n), lengths in mm, angles in rad."""

    point: ComplexArray
    """The point of the profile in the middle of the part."""
    tangent: ComplexArray
    """The unit tangent at the middle point."""
    normal: ComplexArray
    spread: FloatArray
    """Largest angle between the direction of the profile and that in the middle; π if nothing is known."""
    radius: FloatArray
    """Largest distance from the middle point."""
    bulge: FloatArray
    """Largest distance from the tangent at the middle point."""
    rounding: FloatArray
    """Rounding error of the points."""

    def take(self, index: Any) -> "ProfileEnclosure":
        return self._replace(**{name: values[index] for name, values in self._asdict().items()})


def enclose_profile(
    setup: Setup, design: Designs, programme: Programme, parts: TurnParts, side: float = INNER_SIDE
) -> ProfileEnclosure:
    """Enclose a wall of one design, or of several designs (n, 1), over parts of the turn."""
    y, y1 = displacement_and_velocity_at(programme.table, parts.middle)
    trace, velocity = (
        x + 1j * z
        for x, z in trace_point_and_velocity(setup, design, start_height_or_arm_angle(setup, design) + y, y1)
    )
    reach = np.abs(design.centre_distance - trace) if setup.angular else 1.0  # motion of the trace point per y
    distance, speed, radius = np.abs(trace), np.abs(velocity), setup.pitch_to_flank_distance(design)
    inwards = -side * radius
    fastest = np.minimum(parts.velocity, np.abs(y1) + parts.half * parts.acceleration + parts.error)
    swing = np.square(fastest) if setup.angular else 0.0
    bend = reach * (parts.acceleration + swing + (2.0 + parts.half) * fastest) + distance
    rounding = PART_ERROR * (distance + reach * fastest + radius) + reach * parts.error
    rounding = rounding * (1.0 + radius / speed)
    ratio = (parts.half * bend + rounding) / speed
    spread = np.where(ratio < 1.0, np.arcsin(np.minimum(ratio, 1.0)), np.pi)
    turn = np.exp(-1j * design.sense * parts.middle)
    tangent = turn * velocity / speed
    normal = 1j * design.sense * tangent
    away = parts.half * (speed + parts.half * bend) + radius * np.minimum(spread, 2.0) + rounding
    bulge = 0.5 * np.square(parts.half) * bend + radius * 2.0 * np.square(np.sin(0.5 * spread)) + rounding
    return ProfileEnclosure(turn * trace - inwards * normal, tangent, normal, spread, away, bulge, rounding)


def wall_points(
    setup: Setup, design: Designs, programme: Programme, angles: FloatArray, side: float = INNER_SIDE
) -> ComplexArray:
    """Points of a wall of one design, or of several designs (n, 1), at cam angles in rad."""
    y, y1 = displacement_and_velocity_at(programme.table, angles)
    wall = designs_with_wall_as_profile(setup, design, side)
    (x, z), (along, up) = trace_point_and_velocity(setup, wall, start_height_or_arm_angle(setup, design) + y, y1)
    share = wall.sense * wall.roller_radius / np.sqrt(np.square(along) + np.square(up))
    point = x + share * up + 1j * (z - share * along)  # T − R_r·n in the ground frame
    return np.asarray(np.exp(-1j * design.sense * angles) * point)


def displacement_and_velocity_at(table: MotionTable, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """y and y' at cam angles in rad, from the panels' polynomials; neither jumps on a cam without undercut."""
    angles = np.mod(angles, 2 * np.pi)
    panel = np.searchsorted((table.centre - table.half_width)[1:], angles, side="right")
    h, series = table.half_width[panel], table.coefficients.T
    u = (angles - table.centre[panel]) / h
    y, y1 = (polynomial.polyval(u, each[:, panel], tensor=False) for each in (series, polynomial.polyder(series)))
    return np.asarray(y), np.asarray(y1 / h)


def designs_with_wall_as_profile(setup: Setup, designs: Designs, side: Any) -> Designs:
    """Designs whose profile is the wall on one side of the trace point; a wall beyond it has a negative roller.

    The wall is R_r and half the clearance away. For the height or angle at displacement 0 the designs themselves
    must be used.
    """
    return replace(designs, roller_radius=-side * setup.pitch_to_flank_distance(designs))


def start_height_or_arm_angle(setup: Setup, designs: Designs) -> Number:
    """Height of the trace point [mm], or angle of the arm [rad], at displacement 0; numbers or ranges."""
    assert setup.mechanism.start is not None
    return setup.mechanism.start(designs)


def trace_point_and_velocity(
    setup: Setup, designs: Designs, follower_position: Any, y1: Any
) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    """(x, y) of the trace point T in the ground frame [mm], and of its velocity over the cam [mm/rad].

    The velocity is K·y' − iσT. T moves by K = i per displacement, or about a pivot at c by K = i(c − T). The height
    or angle s and y' are numbers or ranges.
    """
    assert setup.mechanism.trace_point is not None
    x, z = setup.mechanism.trace_point(designs, follower_position)
    along, up = (z * y1, (designs.centre_distance - x) * y1) if setup.angular else (0.0, y1)
    return (x, z), (along + designs.sense * z, up - designs.sense * x)

"""Loads on the contact as curves over the turn: normal force, side thrust, and what decides the contact stress.

With F the force along the motion (``effects.force``), t = tan β and a guide of length b and overhang a = a₀ − y,

    N = F·√(1 + t²)/D,    S = F·t/D,    D = 1 − side·μ·q·t,    q = (2a + b)/b

side·t = |t| on the side that the follower is thrust to; without friction D = 1. F/l takes the place of F where the
follower oscillates; a flat face that does touches at the distance r from the pivot, N = F/r. Line contact needs

    q = N/R,    roller: 1/R = κ/(1 − κ·R_r) + 1/R_r = 1/(R_r·(1 − κ·R_r)),    flat face: R = ρ

and a spherical face N·h(1 − κ·R_s)/R_s² (``numerics.point_contact``).

Each is built from the mechanism's own curves of pressure angle, curvature, radius and reach.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.case import Bounded, Case, Dynamics, Subject
from camopt.effects.force import weights
from camopt.mechanisms.design import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, FloatArray
from camopt.numerics.curves import Linear, curve, formula
from camopt.numerics.point_contact import pressure_factor, pressure_table


class ChangingForce(NamedTuple):
    """F where the external load changes over the turn: ``steady``, that of all else, and share·load."""

    steady: Linear
    share: FloatArray


class NormalForce(NamedTuple):
    """N of a follower with a trace point, N; D = 1 − (drag + slide·y)·t."""

    force: Any
    pressure: Any
    drag: FloatArray
    slide: FloatArray


class SideThrust(NamedTuple):
    """S·(arm + reach·y), fields as in NormalForce: N, or N·mm where the arm is a length."""

    force: Any
    pressure: Any
    drag: FloatArray
    slide: FloatArray
    arm: FloatArray
    reach: FloatArray


class GuideDrag(NamedTuple):
    """μ·q·t: what jams the follower in its guide at 1."""

    pressure: Any
    drag: FloatArray
    slide: FloatArray


class FaceForce(NamedTuple):
    """N on a flat face that oscillates, N: the moment over the distance of the contact from the pivot."""

    moment: Any
    distance: Any


class RollerLoad(NamedTuple):
    """N/R at a roller, N/mm; ``flank`` is −1 for the other flank of a groove."""

    normal: Any
    curvature: Any
    roller_radius: FloatArray
    flank: FloatArray


class PointLoad(NamedTuple):
    """N·h/R_s² at a spherical face, N/mm²; ``flank`` as in RollerLoad, ``table`` of h."""

    normal: Any
    curvature: Any
    face_radius: FloatArray
    flank: FloatArray
    table: FloatArray


class FaceLoad(NamedTuple):
    """N/ρ at a flat face, N/mm."""

    normal: Any
    radius: Any


class ShaftTorque(NamedTuple):
    """T = F·y', N·mm."""

    force: Any


@formula(ChangingForce, loaded=True)
def changing_force(f, i, y, y1, y2, y3):
    force, force1 = curve(f.steady, i, y, y1, y2, y3)
    _, load, load1 = y3
    return force + f.share[i] * load, force1 + f.share[i] * load1


@formula(NormalForce, loaded=True)
def normal_force(f, i, y, y1, y2, y3):
    force, force1 = curve(f.force, i, y, y1, y2, y3)
    t, t1 = curve(f.pressure, i, y, y1, y2, y3)
    drag, drag1 = f.drag[i] + f.slide[i] * y, f.slide[i] * y1
    root = np.sqrt(np.square(t) + 1.0)
    left = 1.0 - drag * t
    value = force * root / left
    return value, (force1 * root + force * (t * t1) / root + value * (drag1 * t + drag * t1)) / left


@formula(SideThrust, loaded=True)
def side_thrust(f, i, y, y1, y2, y3):
    force, force1 = curve(f.force, i, y, y1, y2, y3)
    t, t1 = curve(f.pressure, i, y, y1, y2, y3)
    drag, drag1 = f.drag[i] + f.slide[i] * y, f.slide[i] * y1
    arm, arm1 = f.arm[i] + f.reach[i] * y, f.reach[i] * y1
    left = 1.0 - drag * t
    thrust = force * t / left
    thrust1 = (force1 * t + force * t1 + thrust * (drag1 * t + drag * t1)) / left
    return thrust * arm, thrust1 * arm + thrust * arm1


@formula(GuideDrag)
def guide_drag(f, i, y, y1, y2, y3):
    t, t1 = curve(f.pressure, i, y, y1, y2, y3)
    drag = f.drag[i] + f.slide[i] * y
    return drag * t, f.slide[i] * y1 * t + drag * t1


@formula(FaceForce, loaded=True)
def face_force(f, i, y, y1, y2, y3):
    moment, moment1 = curve(f.moment, i, y, y1, y2, y3)
    r, r1 = curve(f.distance, i, y, y1, y2, y3)
    value = moment / r
    return value, (moment1 - value * r1) / r


@formula(RollerLoad, loaded=True)
def roller_load(f, i, y, y1, y2, y3):
    normal, normal1 = curve(f.normal, i, y, y1, y2, y3)
    k, k1 = curve(f.curvature, i, y, y1, y2, y3)
    r, side = f.roller_radius[i], f.flank[i]
    left = r - side * r * r * k
    value = normal / left
    return value, (normal1 + value * (side * r * r * k1)) / left


@formula(PointLoad, loaded=True)
def point_load(f, i, y, y1, y2, y3):
    normal, normal1 = curve(f.normal, i, y, y1, y2, y3)
    k, k1 = curve(f.curvature, i, y, y1, y2, y3)
    r, side = f.face_radius[i], f.flank[i]
    h, h1 = pressure_factor(1.0 - side * r * k, f.table)
    return normal * h / (r * r), (normal1 * h - normal * h1 * (side * r * k1)) / (r * r)


@formula(FaceLoad, loaded=True)
def face_load(f, i, y, y1, y2, y3):
    normal, normal1 = curve(f.normal, i, y, y1, y2, y3)
    rho, rho1 = curve(f.radius, i, y, y1, y2, y3)
    value = normal / rho
    return value, (normal1 - value * rho1) / rho


@formula(ShaftTorque, loaded=True)
def shaft_torque(f, i, y, y1, y2, y3):
    force, force1 = curve(f.force, i, y, y1, y2, y3)
    return force * y1, force1 * y1 + force * y2


def force_curve(subject: Subject, designs: Designs, programme: Programme) -> Any:
    """F, N; F/l of an oscillating follower with a trace point, the moment (N·mm) of an oscillating flat face."""
    lever = designs.arm_length if subject.angular and subject.mechanism.curvature else np.ones(len(designs))
    return _force_at(lever, subject, programme)


def _force_at(lever: Any, subject: Subject, programme: Programme) -> Any:
    """F over a length, N (N·mm)."""
    assert subject.omega is not None
    steady = Linear(*(weight / lever for weight in weights(subject.dynamics, subject.omega)))
    return steady if programme.load is None else ChangingForce(steady, 1.0 / lever)


def friction(dynamics: Dynamics, count: int, side: float) -> tuple[FloatArray, FloatArray]:
    """drag and slide: side·μ·q as a line in y."""
    zeros = np.zeros(count)
    if not dynamics.friction or dynamics.guide_length is None or dynamics.overhang is None:
        return zeros, zeros
    q = 1.0 + 2.0 * dynamics.overhang / dynamics.guide_length
    return zeros + side * dynamics.friction * q, zeros - side * dynamics.friction * 2.0 / dynamics.guide_length


def normal_curve(subject: Subject, designs: Designs, programme: Programme, side: float = 0.0) -> Any:
    """The normal force of a mechanism, N; with the guide's friction on one side, or none (0)."""
    force = force_curve(subject, designs, programme)
    if subject.mechanism.curvature:
        drag = friction(subject.dynamics, len(designs), side)
        return NormalForce(force, subject.mechanism.pressure(designs, programme), *drag)
    if not subject.angular:
        return force
    assert subject.mechanism.reach is not None
    return FaceForce(force, subject.mechanism.reach(designs, programme))


def torque_curve(subject: Subject, designs: Designs, programme: Programme) -> ShaftTorque:
    """The torque of the camshaft, the same for all designs."""
    return ShaftTorque(_force_at(np.ones(len(designs)), subject, programme))


def contact_load(
    subject: Subject, designs: Designs, programme: Programme, flank: float = 1.0, side: float = 0.0
) -> Any:
    """What decides the contact stress of a mechanism: N/R, N/mm; at a spherical face N·h/R_s², N/mm²."""
    normal = normal_curve(subject, designs, programme, side)
    if subject.mechanism.curvature:
        turned = np.full(len(designs), flank)
        curvature = subject.mechanism.curvature(designs, programme)
        if subject.spherical:
            return PointLoad(normal, curvature, designs.roller_radius, turned, pressure_table())
        return RollerLoad(normal, curvature, designs.roller_radius, turned)
    assert subject.mechanism.profile_radius is not None
    return FaceLoad(normal, subject.mechanism.profile_radius(designs, programme))


def sides(subject: Subject) -> tuple[tuple[float, int], ...]:
    """On which side the guide's friction acts, and over which strokes; together they hold the largest load.

    A rise may thrust to either side, and the larger load counts. A return thrusts to the negative side, where
    friction carries a part of the load; where it does not, the load given is a little above the true one. In a
    groove the follower may be pulled against its friction on either stroke.
    """
    if subject.mechanism.curvature is None or not np.any(friction(subject.dynamics, 1, 1.0)):
        return ((0.0, TURN),)
    return (1.0, RISE | RETURN), (-1.0, driven(subject)), (0.0, DWELL)


def driven(subject: Subject) -> int:
    """The strokes on which the cam works against the guide's friction, so that the follower may jam."""
    return RISE | RETURN if subject.mechanism.grooved else RISE


Variant = tuple[Callable[[Designs, Programme], Any], int]
"""A curve and the kinds of stroke over which it is the load."""


class Largest(NamedTuple):
    """The largest load of each design (designs,), how far it may be above, its cam angle and its variant."""

    value: FloatArray
    width: FloatArray
    where: FloatArray
    variant: FloatArray

    def bounded(self, factor: float = 1.0) -> Bounded:
        """As a quantity, in another unit."""
        return Bounded(self.value * factor, self.width * factor, self.value * factor)


def goal_of(subject: Subject) -> int:
    """A groove pulls as well as it pushes."""
    return LARGEST_MAGNITUDE if subject.mechanism.grooved else LARGEST


def largest(case: Case, variants: Sequence[Variant], goal: int, sound: Any, *, located: bool = False) -> Largest:
    """The largest load over the turn; infinite for designs that are not sound, and where y' jumps.

    Its cam angle is as exact as the load only if ``located``.
    """
    count = len(case.designs)
    found = Largest(np.full(count, np.inf), *np.zeros((3, count)))
    index = np.flatnonzero(sound & (not case.programme.corners))
    if not index.size:
        return found
    some = replace(case, designs=case.designs.take(index))
    asked = [v for v in variants if any(stroke.kind & v[1] for stroke in case.programme.strokes)]
    each = [some.extremes(make, [(kinds, goal)], located=located) for make, kinds in asked]
    values = np.array([f.value[0] for f in each])
    tops = np.array([f.value[0] + f.width[0] for f in each])
    best = values.argmax(axis=0)
    chosen = np.arange(index.size)
    found.value[index] = values[best, chosen]
    finite = np.isfinite(found.value[index])
    found.width[index] = np.where(finite, tops.max(axis=0) - np.where(finite, found.value[index], 0.0), 0.0)
    found.where[index] = np.array([f.where[0] for f in each])[best, chosen]
    found.variant[index] = [variants.index(asked[k]) for k in best]
    return found

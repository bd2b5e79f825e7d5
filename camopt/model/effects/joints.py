"""Largest forces in the joints of a train over the turn: in its pins, on its pivots, and across its slides.

They follow from the masses, springs, loads and friction of the train (``trains.joint_forces``). Each is S + ω²·I
with polynomials on panels, like the load on the follower (``motion.load``), so extremes are those of the continuous
turn. The forces depend only on the motion, the speed and the train; the follower's own mass and spring load the cam
and not the train.

The force on a pivot is the sum of the magnitudes of both forces on it: the largest that it can be, since a scene
does not say how links are mounted. If the velocity jumps, the force is infinite in every joint that moves a mass.

Source: Norton, Design of Machinery, ch. 11 (dynamic force analysis).
"""

from dataclasses import replace
from functools import partial
from math import degrees, inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray, Number
from camopt.core.numerics.curves import Linear
from camopt.core.numerics.extremes import Precision, extremes_of_curve
from camopt.core.numerics.state import TrainForces
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.force import force_with_train_load
from camopt.model.effects.peak import TrainMotion, TrainPeak
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.load import TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.model.trains.joint_forces import JointForce, WeightedForce

LARGEST_BY_KIND = {"joint": "joint_force_max_N", "pivot": "pivot_force_max_N", "guide": "slide_thrust_max_N"}
JOINT_FORCE_ANGLE, JOINT_FORCE_DIRECTION = "joint_force_max_at_deg", "joint_force_max_direction_deg"
JOINT_PRECISION = Precision(1e-14, 1e-9)


class ForceRange(NamedTuple):
    """Least and largest value of a force over the turn [N], with cam angles [rad] and widths of enclosures."""

    least: Any
    largest: Any
    least_at: Any
    largest_at: Any
    least_width: Any
    largest_width: Any


def setup_joint_forces(setup: Setup) -> tuple[JointForce, ...]:
    return () if setup.train is None else setup.train.joint_forces


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    kinds = {force.kind for force in setup_joint_forces(setup)}
    names = tuple(name for kind, name in LARGEST_BY_KIND.items() if kind in kinds)
    return (*names, JOINT_FORCE_ANGLE, JOINT_FORCE_DIRECTION) if "joint" in kinds else names


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    if setup.train is None:
        return {}
    if not setup.train.carried:
        return dict.fromkeys(
            applicable_quantities(setup), (f"a mass, spring or load in train.{setup.train.stages[-1]}",)
        )
    return (
        dict.fromkeys(applicable_quantities(setup), ("cam.rpm",))
        if setup.train.has_mass and setup.omega is None
        else {}
    )


def programme_loaded_by_joint_force(programme: Programme, parts: tuple[WeightedForce, ...]) -> Programme:
    """The turn with a force in joints of the train in place of the load on the follower."""
    assert isinstance(programme.load, TrainLoad)
    return replace(programme, load=replace(programme.load, parts=parts))


@once_per_setting
def joint_force_range(programme: Programme, speed: FloatArray) -> ForceRange:
    """Range of a force in joints over its turn (``programme_loaded_by_joint_force``), by speed [rad/s]."""
    none, load = np.zeros_like(speed), programme.load
    assert isinstance(load, TrainLoad)
    first = min(part.link for part in load.parts)
    if programme.corners and any(each.mass and each.joint > first for each in load.train.carried):
        return ForceRange(none - inf, none + inf, none, none, none, none)
    force = force_with_train_load(Linear(none, none, none, none), none + 1.0, speed**2)
    questions = [(ALL_STROKES, LEAST), (ALL_STROKES, LARGEST)]
    return ForceRange(
        *np.concatenate(extremes_of_curve(force, speed.size, programme.table, questions, JOINT_PRECISION))
    )


def joint_force_at(programme: Programme, angles: FloatArray, speed: float) -> FloatArray:
    """Force in a joint [N] at cam angles [rad], from its turn (``programme_loaded_by_joint_force``)."""
    load = programme.state(angles).load
    assert isinstance(load, TrainForces)
    return np.asarray(load.value + speed**2 * load.carried)


class JointRow(NamedTuple):
    """A force in a joint over the turn, or on a pivot the largest sum of two magnitudes."""

    stage: int
    joint: str
    force_min_N: float | None  # noqa: N815
    """Negative if a coupler is pulled or a roller lifts off; None for a sum."""
    force_max_N: float  # noqa: N815
    largest_at_deg: float
    """Cam angle of the largest magnitude [deg]."""
    direction_deg: float | None
    """Direction at the largest magnitude [deg], from the slide's motion, in a four-bar from the line of its pivots;
    None for a sum."""


def joint_force_rows(setup: Setup, programme: Programme) -> list[JointRow]:
    """The forces in all joints of a train, from the follower to the tool; none without a load or a speed."""
    if missing_keys_by_quantity(setup):
        return []
    speed = 0.0 if setup.omega is None else float(setup.omega)
    return [_joint_force_row(programme, force, speed) for force in setup_joint_forces(setup)]


def _joint_force_row(programme: Programme, force: JointForce, speed: float) -> JointRow:
    value, at, _ = (float(each) for each in largest_joint_force(programme, force, speed))
    if len(force.parts) > 1:
        return JointRow(force.stage, force.name, None, value, degrees(at), None)
    limits = joint_force_range(programme_loaded_by_joint_force(programme, force.parts), speed)
    way = float(joint_force_direction_deg(programme, force, np.array([at]))[0])
    return JointRow(force.stage, force.name, float(limits.least), float(limits.largest), degrees(at), way)


def joint_force_direction_deg(programme: Programme, force: JointForce, angles: FloatArray) -> FloatArray:
    """Direction of a positive force of one link [deg] at cam angles [rad]."""
    load, ((link, number, _),) = programme.load, force.parts
    assert isinstance(load, TrainLoad)
    joint = load.train.joint_motions(Taylor([programme.motion_at(angles)[0] + load.zero]))[link]
    return np.degrees(load.train.links[link].joint_forces[number].way(np.asarray(joint.displacement.terms[0])))


class LargestForce(NamedTuple):
    """Largest magnitude of some forces [N], its cam angle [rad], and by how much the true value may exceed it."""

    value: Any
    at: Any
    room: Any


def largest_joint_force(programme: Programme, force: JointForce, speed: Any) -> LargestForce:
    """Largest magnitude of a force over the turn."""
    ends = list[LargestForce]()
    for parts in force.signed_sums:
        limits = joint_force_range(programme_loaded_by_joint_force(programme, parts), speed)
        ends.append(LargestForce(-limits.least, limits.least_at, limits.least_width))
        ends.append(LargestForce(limits.largest, limits.largest_at, limits.largest_width))
    return _largest_of_forces(ends)


def _largest_of_forces(forces: Any) -> LargestForce:
    value, at, room = (np.array(each) for each in zip(*forces, strict=True))
    best = value.argmax(axis=0)[None]
    top = np.take_along_axis(value, best, 0)[0]
    with np.errstate(invalid="ignore"):
        excess = np.where(np.isfinite(top), (value + room).max(axis=0) - top, 0.0)
    return LargestForce(top, np.take_along_axis(at, best, 0)[0], excess)


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    speed, columns = 0.0 if case.setup_per_design.omega is None else case.setup_per_design.omega, dict[str, Any]()
    for kind, name in LARGEST_BY_KIND.items():
        if not wanted_quantities & (
            {name, JOINT_FORCE_ANGLE, JOINT_FORCE_DIRECTION} if kind == "joint" else {name}
        ):
            continue
        forces = [force for force in setup_joint_forces(case.setup) if force.kind == kind]
        worst = _largest_of_forces(largest_joint_force(case.programme, force, speed) for force in forces)
        columns[name] = EnclosedValue(worst.value, worst.room, worst.value)
        if kind == "joint":
            columns[JOINT_FORCE_ANGLE] = np.degrees(worst.at)
        if kind == "joint" and JOINT_FORCE_DIRECTION in wanted_quantities:
            columns[JOINT_FORCE_DIRECTION] = _largest_force_direction_deg(case.programme, forces, speed)
    return columns


def train_peaks(setup: Setup) -> dict[str, TrainPeak]:
    forces = dict[str, TrainPeak]()
    for kind, name in LARGEST_BY_KIND.items():
        sums = [parts for force in setup_joint_forces(setup) if force.kind == kind for parts in force.signed_sums]
        curves = tuple(partial(_link_force_curve, setup=setup, parts=parts) for parts in sums)
        forces[name] = TrainPeak(curves, LARGEST_MAGNITUDE)
    return forces


def _link_force_curve(
    designs: Designs, motion: TrainMotion, setup: Setup, parts: tuple[WeightedForce, ...]
) -> Number:
    omega = setup.with_design_numbers(designs).omega
    return motion.link_force_sum(parts, 0.0 if omega is None else omega)


def _largest_force_direction_deg(programme: Programme, forces: list[JointForce], speed: Any) -> FloatArray:
    """Direction of the largest of some forces [deg], at the cam angle of its largest magnitude."""
    largest = [largest_joint_force(programme, force, speed) for force in forces]
    ways = [
        joint_force_direction_deg(programme, force, np.atleast_1d(worst.at))
        for force, worst in zip(forces, largest, strict=True)
    ]
    number = np.argmax([np.atleast_1d(worst.value) for worst in largest], axis=0)
    return np.asarray(np.choose(number, ways).reshape(np.shape(largest[0].value)))


EFFECT = Effect(
    "joints",
    applicable_quantities,
    evaluate_columns,
    missing_keys_by_quantity=missing_keys_by_quantity,
    is_of_motion=lambda setup: True,
    train_peaks=train_peaks,
    holds_between_speeds=True,
)

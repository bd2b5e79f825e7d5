"""Limits: what a scene forbids, the quantities each limit calls for, and by how much a design exceeds it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camopt.effects import Subject
from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.quantities import motion_quantity
from camopt.rows import Columns
from camopt.scene import Scene


@dataclass(frozen=True)
class Limit:
    """One limit of a scene, under its key in ``[limits]``.

    ``excess`` is relative: held where ≤ 0, exceeded by 10 % at 0.1. Its sign is exact.
    """

    name: str
    bound: float
    needs: tuple[str, ...]
    excess: Callable[[Columns, Designs], FloatArray]


def _at_most(name: str, bound: float, *needs: str) -> Limit:
    """The largest magnitude of some quantities is bounded."""

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        largest = np.max([np.abs(columns[need]) + np.zeros(len(designs)) for need in needs], axis=0)
        result: FloatArray = (largest - bound) / bound
        return result

    return Limit(name, bound, needs, excess)


def _curvature(name: str, subject: Subject, bound: float) -> Limit:
    """Least convex radius of the profile: κ_pitch·(R_r + ρ_min) ≤ 1, no difference of radii.

    Undercut is the same with ρ_min = 0, but at the bound itself it is not held.
    """
    at_bound = np.finfo(float).tiny if bound == 0.0 else 0.0

    def flat(columns: Columns, designs: Designs) -> FloatArray:
        result: FloatArray = (bound - columns["profile_radius_min_mm"]) / (bound or designs.size)
        return np.where(result == 0.0, at_bound, result)

    def trace(columns: Columns, designs: Designs) -> FloatArray:
        sharpest = columns["pitch_curvature_max_per_mm"]
        if subject.mechanism.grooved:
            sharpest = np.maximum(sharpest, -columns["pitch_curvature_min_per_mm"])
        result: FloatArray = sharpest * (designs.roller_radius + bound) - 1.0
        return np.where(result == 0.0, at_bound, result)

    if subject.mechanism.curvature is None:
        return Limit(name, bound, ("profile_radius_min_mm",), flat)
    needs = ("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", "profile_radius_min_mm")
    return Limit(name, bound, needs, trace)


def _implied(subject: Subject) -> list[Limit]:
    """What every cam has to hold, asked or not: no undercut, and clear of its shaft."""
    limits = []
    if not subject.pointed:
        limits.append(_curvature("undercut", subject, 0.0))
    if subject.shaft_radius is not None:
        radius = subject.shaft_radius
        limits.append(
            Limit("shaft_diameter", 2 * radius, (), lambda columns, designs: (radius - designs.size) / radius)
        )
    return limits


def limits_of(scene: Scene, subject: Subject) -> tuple[Limit, ...]:
    """The limits of a scene, cheapest first, with those that every cam has to hold."""
    asked = scene.limits
    limits = []
    for derivative in ("velocity", "acceleration", "jerk"):
        bound = getattr(asked, derivative)
        if bound is not None:
            quantity = motion_quantity(derivative, "", angular=subject.angular, timed=True)
            limits.append(_at_most(derivative, bound, quantity))
    if asked.pressure_angle is not None:
        rises = ("pressure_angle_max_rise_deg", "pressure_angle_max_dwell_deg")
        limits.append(_at_most("pressure_angle", asked.pressure_angle, *rises))
    on_return = asked.pressure_angle if asked.pressure_angle_return is None else asked.pressure_angle_return
    if on_return is not None:
        limits.append(_at_most("pressure_angle_return", on_return, "pressure_angle_max_return_deg"))
    if asked.face_reach is not None:
        limits.append(_at_most("face_reach", asked.face_reach, "face_reach_max_mm", "face_reach_min_mm"))
    if asked.curvature_radius is not None:
        limits.append(_curvature("curvature_radius", subject, asked.curvature_radius))
    return (*limits, *_implied(subject))

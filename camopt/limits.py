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


def _curvature(subject: Subject, bound: float) -> Limit:
    """Least convex radius of the profile: κ_pitch·(R_r + ρ_min) ≤ 1, no difference of radii."""
    if subject.mechanism.curvature is None:
        return Limit(
            "curvature_radius",
            bound,
            ("profile_radius_min_mm",),
            lambda columns, designs: (bound - columns["profile_radius_min_mm"]) / bound,
        )

    def excess(columns: Columns, designs: Designs) -> FloatArray:
        sharpest = columns["pitch_curvature_max_per_mm"]
        if subject.mechanism.grooved:
            sharpest = np.maximum(sharpest, -columns["pitch_curvature_min_per_mm"])
        result: FloatArray = sharpest * (designs.roller_radius + bound) - 1.0
        return result

    needs = ("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm")
    return Limit("curvature_radius", bound, needs, excess)


def _implied(subject: Subject) -> list[Limit]:
    """What every cam has to hold, asked or not: no undercut, and clear of its shaft."""
    limits = []
    if not subject.pointed:
        needs = ("undercut", "profile_radius_min_mm")
        limits.append(Limit("undercut", 0.0, needs, _undercut_excess))
    if subject.shaft_radius is not None:
        radius = subject.shaft_radius
        limits.append(
            Limit("shaft_diameter", 2 * radius, (), lambda columns, designs: (radius - designs.size) / radius)
        )
    return limits


def _undercut_excess(columns: Columns, designs: Designs) -> FloatArray:
    """Relative to the roller: how far the profile is cut away; positive exactly where it is undercut."""
    size = np.where(designs.roller_radius > 0.0, designs.roller_radius, designs.size)
    depth = -columns["profile_radius_min_mm"] / size
    tiny = np.finfo(float).tiny  # the verdict keeps its sign where the depth has rounded to zero
    result: FloatArray = np.where(columns["undercut"], np.maximum(depth, tiny), np.minimum(depth, -tiny))
    return result


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
    if asked.pressure_angle_return is not None:
        returns = "pressure_angle_max_return_deg"
        limits.append(_at_most("pressure_angle_return", asked.pressure_angle_return, returns))
    if asked.face_reach is not None:
        limits.append(_at_most("face_reach", asked.face_reach, "face_reach_max_mm", "face_reach_min_mm"))
    if asked.curvature_radius is not None:
        limits.append(_curvature(subject, asked.curvature_radius))
    return (*limits, *_implied(subject))

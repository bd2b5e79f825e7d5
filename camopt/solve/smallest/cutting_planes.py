"""The smallest cam of an oscillating follower, by cutting planes.

The linear limits (``linear_forms``) at a few cam angles give a lower bound of the size, and the cam at this bound.
The limits at the angles where this cam breaks them the most are added, until it breaks none.

Boxes alone (``branch_and_bound``) prove the same sizes, but take 4 times the CPU time (60 scenes; 1.5 times in 18
scenes with free angles, up to 8.7 times in one). Hence the planes come first.

Source: E. W. Cheney, A. A. Goldstein, Newton's method for convex programming and Tchebycheff approximation,
Numerische Mathematik 1 (1959).
"""

from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.model.effects import EvaluationBlock
from camopt.model.mechanisms import Designs, cylindrical_oscillating, oscillating, oscillating_flat
from camopt.model.mechanisms.design import SizeBounds
from camopt.model.motion.programme import Programme
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.linear_forms import (
    ARM_FORM,
    FACE_FORM,
    GROOVE_FORM,
    PLANE_TOLERANCE,
    LinearForm,
    LinearLimit,
    Planes,
)
from camopt.solve.smallest.result import RELATIVE_GAP, allowed_proof_gap
from camopt.solve.verdicts.feasible_filter import feasible_designs

LINEAR_FORMS: dict[Any, LinearForm] = {
    oscillating.MECHANISM.pressure: ARM_FORM,
    oscillating_flat.MECHANISM.pressure: FACE_FORM,
    cylindrical_oscillating.MECHANISM.pressure: GROOVE_FORM,
}
"""The linear form of each oscillating follower, by its formula of the pressure angle."""
PLANE_SAMPLES = 96  # samples of each stroke, for a first set of planes
FIRST_PLANES_TOLERANCE = 1e-6  # relative: by how much samples may exceed the first planes
PLANE_ROUNDS = 30
LINEAR_WORK = 8.0  # work of a round, or of a closed form, over that of an evaluation
PLANE_ROUNDING = 1e-15  # relative
EASING_FACTORS = tuple(
    4.0**k for k in range(10)
)  # how far the cam is moved inside the planes, in multiples of the last excess


class LinearOptimum(NamedTuple):
    """The smallest cam, if the linear limits alone decide, and a lower bound of the size, mm."""

    design: Designs | None
    floor: float


def cutting_plane_optimum(problem: Problem, bounds: SizeBounds, budget: Budget = UNLIMITED) -> LinearOptimum | None:
    """The smallest cam under the linear limits; None for other mechanisms, or without such limits.

    Once the budget is spent, it is the lower bound so far.
    """
    form = LINEAR_FORMS.get(problem.setup.mechanism.pressure)
    limits = form.limits(problem) if form else []
    if form is None or not limits:
        return None
    ranges = form.range_planes(problem.programme, bounds)
    planes = _planes_active_at_samples(form, limits, problem.programme, bounds)
    (least, most), floor = bounds["size"], 0.0
    for done in range(PLANE_ROUNDS):
        if done and budget.is_spent:
            break
        budget.spend(LINEAR_WORK * problem.evaluation_work(1))
        point = form.least_point(np.concatenate([ranges, planes]), bounds)
        if point is None:
            return LinearOptimum(None, inf)
        design = _design_at_point(problem, form, point, bounds)
        floor = float(design.size[0]) * (1.0 - PLANE_TOLERANCE)
        if floor > most:
            return LinearOptimum(None, inf)
        if floor < least * (1.0 - PLANE_TOLERANCE):
            return LinearOptimum(None, least)
        worst = _planes_at_worst_cam_angles(problem, limits, design)
        excess = float(-np.min(_plane_margins(worst, point)) / np.linalg.norm(point))
        inside = _feasible_smallest_cam_in_planes(problem, form, bounds, (ranges, planes), excess, floor)
        if inside is not None or excess < PLANE_TOLERANCE:
            return LinearOptimum(inside, floor)
        planes = np.concatenate([planes, worst[_plane_margins(worst, point) < 0.0]])
    return LinearOptimum(None, floor)


def _feasible_smallest_cam_in_planes(
    problem: Problem,
    form: LinearForm,
    bounds: SizeBounds,
    range_and_limit_planes: tuple[Planes, Planes],
    excess: float,
    floor: float,
) -> Designs | None:
    """The smallest cam a little inside the planes, if it is feasible and no larger than the gap allows."""
    ranges, limits = range_and_limit_planes
    for times in EASING_FACTORS if excess < RELATIVE_GAP else ():
        inner = limits.copy()
        inner[:, 3] += times * max(excess, PLANE_ROUNDING) * floor
        point = form.least_point(np.concatenate([ranges, inner]), bounds)
        design = None if point is None else _design_at_point(problem, form, point, bounds)
        if design is None or design.size[0] - floor > allowed_proof_gap(design) / 2:
            return None
        design = replace(design, size=np.clip(design.size, *bounds["size"]))  # rounding may leave the range
        if feasible_designs(problem, design)[0]:
            return design
    return None


def _plane_margins(planes: Planes, point: FloatArray) -> FloatArray:
    """Distance of a point from each plane, positive inside."""
    return np.asarray(planes[:, :3] @ point - planes[:, 3])


def _design_at_point(problem: Problem, form: LinearForm, point: FloatArray, bounds: SizeBounds) -> Designs:
    """The design at a point, with the largest roller."""
    sizes = {name: low for name, (low, _) in bounds.items()} | {"roller_radius": bounds["roller_radius"][1]}
    sizes |= form.sizes(point, sizes["roller_radius"])
    arrays = {name: np.clip([value], *bounds[name]) for name, value in sizes.items() if name != "size"}
    return problem.design.with_values({**arrays, "size": np.array([sizes["size"]])})


def _planes_active_at_samples(
    form: LinearForm, limits: list[LinearLimit], programme: Programme, bounds: SizeBounds
) -> Planes:
    """The planes that are active at a sample of cam angles, by exchange among them; it takes some milliseconds."""
    ranges, planes = form.range_planes(programme, bounds), np.empty((0, 4))
    shares, samples = (np.arange(PLANE_SAMPLES) + 0.5) / PLANE_SAMPLES, list[Planes]()
    for limit in limits:
        angles = np.concatenate([s.start + s.angle * shares for s in programme.strokes if s.kind & limit.kinds])
        samples += limit.planes(programme.motion_at(angles[(programme.kinds_at(angles) & limit.kinds) != 0])[:3])
    for _ in range(PLANE_ROUNDS):
        point = form.least_point(np.concatenate([ranges, planes]), bounds)
        if point is None:
            break
        worst = np.array([group[np.argmin(_plane_margins(group, point))] for group in samples])
        worst = worst[_plane_margins(worst, point) < -FIRST_PLANES_TOLERANCE * np.linalg.norm(point)]
        if not worst.size:
            break
        planes = np.concatenate([planes, worst])
    return planes


def _planes_at_worst_cam_angles(problem: Problem, limits: list[LinearLimit], design: Designs) -> Planes:
    """The planes of each limit at the cam angles where a design breaks it the most, on both sides of them."""
    block, worst = EvaluationBlock(problem.setup, problem.programme, design), []
    for limit in limits:
        where = block.extremes(limit.curve, [(limit.kinds, goal) for goal in limit.goals]).where[:, 0]
        angles = problem.programme.one_sided_angles(where, limit.kinds)
        planes = limit.planes(problem.programme.motion_at(angles.ravel())[:3])
        worst += [group[k :: len(where)] for k, group in enumerate(planes)]
    return np.concatenate(worst)

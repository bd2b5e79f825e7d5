"""Constraints that are linear in the motion and in the sizes e and s₀.

The mechanism decides which constraints are linear. For a translating trace point and a groove it is tan β; for a
translating flat face, the radius of curvature and the reach. There is no train, or one of constant ratio. All
other constraints are nonconvex (``nonconvex_constraints``) and are met by convex steps.

For a robust cam, tolerances of sizes tighten the constraints. A cam with the errors δe and δR has the lead e + δe
and the height s₀ + δs, where

    s₀ + δs = √((R_p + δR)² − (e + δe)²),    R_p² = s₀² + e²

So a·y + b·y' + c·y'' + l·e + h·s₀ + k ≥ 0 holds for that cam if the nominal cam meets it with k + l·δe + h·δs in
place of k. The least such k over all errors is computed at the sizes of the nominal optimum, and again at the sizes
of the optimum that follows. The smallest cam for the laws is then certified as any robust cam. A train with errors
in its links gives linear constraints of its own, at its own ratio. A nonconvex constraint is evaluated for each of
these cams.

Source: A. Ben-Tal, L. El Ghaoui, A. Nemirovski, Robust Optimization, 2009, ch. 1.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from math import inf, sqrt
from typing import Any, NamedTuple

from camopt.model.effects import force
from camopt.model.effects.contacts import FunctionAtContact
from camopt.model.effects.effect import LeastForce
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import cylindrical, translating, translating_flat
from camopt.model.mechanisms.pairs import CONTACT_CURVES
from camopt.model.motion.load import ReflectedLoad, TrainLoad
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.solve.synthesis.synthesis_problem import LinearConstraint, MeanConstraint, SynthesisProblem
from camopt.solve.synthesis.through_train import constant_tool_to_follower_ratio, linear_constraint_on_tool_motion


def linear_constraints_of(scene_problem: Problem) -> list[LinearConstraint]:
    """The linear constraints of a scene, without repetitions. The smallest cam for the laws meets the others."""
    merged: dict[LinearConstraint, LinearConstraint] = {}
    for constraint in map(
        partial(linear_constraint_on_tool_motion, scene_problem),
        _linear_constraints_by_limit(scene_problem) if constant_tool_to_follower_ratio(scene_problem) else (),
    ):
        unnamed = replace(constraint, name="", kinds=0)
        same = merged.get(unnamed, constraint)
        merged[unnamed] = replace(same, kinds=same.kinds | constraint.kinds)
    return list(merged.values())


def _linear_constraints_by_limit(scene_problem: Problem) -> Iterator[LinearConstraint]:
    strictest = strictest_constraints(scene_problem.constraints)
    for limit in scene_problem.limits:
        for constraint in limit.constraints:
            if constraint in strictest and constraint.curve in LINEAR_CURVES:
                yield from LINEAR_CURVES[constraint.curve](limit.name, constraint)
            elif (
                constraint in strictest
                and (second := _linear_second_contact(scene_problem))
                and second.first_contact_curve(constraint) in LINEAR_CURVES
            ):
                yield from map(
                    second.constraint_on_first,
                    LINEAR_CURVES[second.first_contact_curve(constraint)](limit.name, constraint),
                )
        if limit.necessary_conditions.reach < inf:
            yield from _flat_face_reach_constraints(limit.name, limit.necessary_conditions.reach)
        if limit.least_contact_force is not None:
            yield _contact_force_constraint(scene_problem, limit.name, limit.least_contact_force)


def convex_mean_constraints(scene_problem: Problem) -> Iterator[MeanConstraint]:
    """The limits on means of the motion that are convex. The smallest cam for the laws meets the other ones.

    The lift area is linear in the motion, 1/2π·∮y dθ ≥ m. Root mean squares are cones, √(1/2π·∮(y⁽ᵏ⁾)² dθ) ≤ r. So
    a lower bound of a mean is convex if the mean is linear, and an upper bound always is.
    """
    for limit in scene_problem.limits:
        constraint = limit.mean_constraint
        if constraint is not None and isinstance(curve := constraint.mean.curves[0][0], MotionDerivative):
            power, side = constraint.mean.power, constraint.side
            if power == 1 or side > 0.0:
                bound = constraint.mean.mean_from_power_mean(constraint.upper_bound_of_each_side())
                yield MeanConstraint(limit.name, curve.order, power, float(bound), side)


def is_linear(scene_problem: Problem, constraint: Constraint) -> bool:
    """Whether a constraint is linear in the motion and the sizes; one on a derivative is a range of the laws.

    Behind a train of changing ratio, only constraints on the tool itself are linear.
    """
    curve, second = constraint.curve, _linear_second_contact(scene_problem)
    if isinstance(curve, MotionDerivative):
        return not curve.at_follower or constant_tool_to_follower_ratio(scene_problem) is not None
    if second and second.first_contact_curve(constraint) in LINEAR_CURVES:
        return True
    return curve in LINEAR_CURVES and constant_tool_to_follower_ratio(scene_problem) is not None


def repeats_first_contact(scene_problem: Problem, constraint: Constraint) -> bool:
    """Whether a constraint on the second contact repeats that on the first contact, half a turn later."""
    mechanism = scene_problem.setup.mechanism
    if not mechanism.drive.one_disc or constraint.kinds != ALL_STROKES:
        return False
    (contact,) = mechanism.further_contacts
    curve = constraint.curve
    return isinstance(curve, FunctionAtContact) and curve.function in [
        getattr(contact.mechanism, name) for name in CONTACT_CURVES
    ]


class _SecondContact(NamedTuple):
    """The second contact of a follower whose motion there is level + way·y, with a linear lead and height."""

    curves: dict[Any, Any]
    """Curves of the first contact, by the same curves of the second."""
    way: float
    """−1 if the motion is reversed, and the cam turns the other way as seen there."""
    level: float
    share: float
    """Share of the first contact's lead (apart from ``way``) and height: 1 or 0."""
    lead: float
    height: float
    """Lead and height that are added [mm]."""

    def first_contact_curve(self, constraint: Constraint) -> Any:
        """The curve of the first contact for a constraint on the second; None for any other constraint."""
        curve = constraint.curve
        return self.curves.get(curve.function) if isinstance(curve, FunctionAtContact) else None

    def constraint_on_first(self, constraint: LinearConstraint) -> LinearConstraint:
        """A linear constraint on the second contact, as one on the motion and sizes of the first."""
        return replace(
            constraint,
            displacement=self.way * constraint.displacement,
            velocity=self.way * constraint.velocity,
            acceleration=self.way * constraint.acceleration,
            lead=self.way * self.share * constraint.lead,
            height=self.share * constraint.height,
            constant=constraint.constant
            + constraint.displacement * self.level
            + constraint.lead * self.lead
            + constraint.height * self.height,
        )


def _linear_second_contact(scene_problem: Problem) -> _SecondContact | None:
    """The second contact, if the lift is fixed and its sizes are either fixed or those of the first contact."""
    mechanism, design = scene_problem.setup.mechanism, scene_problem.design
    strokes = scene_problem.programme.tool.strokes
    if (
        not mechanism.further_contacts
        or mechanism.start is None
        or scene_problem.setup.angular
        or any(stroke.is_move and stroke.is_law_replaceable for stroke in strokes)
    ):
        return None
    (contact,), lift = mechanism.further_contacts, scene_problem.programme.lift
    curves = {contact.mechanism.pressure: mechanism.pressure}
    if mechanism.has_rib:
        rib_height = -float(design.roller_spacing[0])
        is_fixed = "roller_spacing" not in scene_problem.search_space.variables
        return _SecondContact(curves, 1.0, 0.0, 1.0, 0.0, rib_height) if is_fixed else None
    if not design.second:
        return _SecondContact(curves, -1.0, lift, 1.0, 0.0, 0.0)
    searched = [name for name in design.second if name in scene_problem.search_space.variables]
    if searched or {f"second_{name}" for name in ("size", "roller_radius", "offset")} - design.second.keys():
        return None
    second = contact.local_designs(design)
    return _SecondContact(
        curves, -1.0, lift, 0.0, float(second.signed_offset[0]), float(mechanism.start(second)[0])
    )


def _trace_point_pressure_constraints(name: str, constraint: Constraint) -> Iterator[LinearConstraint]:
    """|y' − e| ≤ T·(s₀ + y), with T the tangent of the pressure angle."""
    tangent = constraint.upper_bound_of_each_side()
    yield LinearConstraint(name, tangent, -1.0, lead=1.0, height=tangent, kinds=constraint.kinds)
    yield LinearConstraint(name, tangent, 1.0, lead=-1.0, height=tangent, kinds=constraint.kinds)


def _groove_pressure_constraints(name: str, constraint: Constraint) -> Iterator[LinearConstraint]:
    """|y'| ≤ T·R_m, with T the tangent of the pressure angle."""
    for side in constraint.side_signs:
        yield LinearConstraint(
            name, 0.0, -side, height=constraint.upper_bound_of_each_side(), kinds=constraint.kinds
        )


def _flat_face_radius_constraint(name: str, constraint: Constraint) -> Iterator[LinearConstraint]:
    """R_b + y + y'' ≥ ρ."""
    yield LinearConstraint(name, 1.0, 0.0, 1.0, height=1.0, constant=constraint.upper_bound_of_each_side())


def _flat_face_reach_constraints(
    name: str, reach: float, sides: tuple[float, ...] = (1.0, -1.0)
) -> Iterator[LinearConstraint]:
    """|y' − e| ≤ t: the reach along a flat face, both ways or one way."""
    for side in sides:
        yield LinearConstraint(name, velocity=-side, lead=side, constant=reach)


LINEAR_CURVES: dict[Any, Callable[[str, Constraint], Iterator[LinearConstraint]]] = {
    translating.MECHANISM.pressure: _trace_point_pressure_constraints,
    cylindrical.MECHANISM.pressure: _groove_pressure_constraints,
    translating_flat.MECHANISM.pressure: lambda name, constraint: iter(
        ()
    ),  # the face is square to its motion: β is 0
    translating_flat.MECHANISM.profile_radius: _flat_face_radius_constraint,
    translating_flat.MECHANISM.reach: lambda name, constraint: _flat_face_reach_constraints(
        name, constraint.upper_bound_of_each_side(), constraint.side_signs
    ),
}


def _contact_force_constraint(scene_problem: Problem, name: str, least: LeastForce) -> LinearConstraint:
    """A least contact force at a speed, as a linear constraint; for an arm, its moment about the pivot."""
    load = scene_problem.programme.load  # what reaches the follower, apart from its own dynamics
    if isinstance(load, TrainLoad):
        reflected = load.reflected_load
    else:
        reflected = ReflectedLoad(0.0, 0.0, max(load.loads) if load else 0.0)
    arm = float(scene_problem.design.arm_length[0]) if scene_problem.setup.angular else 1.0
    stiffness, damping, mass, constant = force.force_weights_and_constant(scene_problem.setup.dynamics, least.omega)
    stiffness, mass = stiffness + reflected.stiffness, mass + reflected.mass * least.omega**2
    constant += reflected.highest  # the highest load of any motion, so that the bound remains valid
    unit = abs(constant) + mass or 1.0  # makes terms of order 1, as in other constraints
    # a longer arm needs a larger moment; sizes are in units of an arc, and the motion is in radians
    radius = max(arm, float(scene_problem.design.centre_distance[0])) if scene_problem.setup.angular else 0.0
    constant -= least.force * arm
    return LinearConstraint(
        name,
        stiffness / unit,
        damping / unit,
        mass / unit,
        lead=-least.force * radius / unit,
        constant=constant / unit,
    )


def with_robust_limits(problem: SynthesisProblem, lead: float, height: float) -> SynthesisProblem:
    """The problem with linear constraints that all error variants meet, near an optimum of these sizes [mm]."""
    nominal = problem.scene_problem.without_motion_error_limits
    shifts = {id(nominal): (nominal, [(0.0, 0.0)])}
    for scene_problem, errors in problem.scene_problem.error_variants:
        _, size_shifts = shifts.setdefault(id(scene_problem), (scene_problem, []))
        lead_shift = problem.scene_problem.design.sense * errors.get("offset", 0.0)
        height_shift = size_error = errors.get("size", 0.0)
        if problem.has_lead_in_prime_radius:
            prime = sqrt(height**2 + lead**2) + size_error + errors.get("roller_radius", 0.0)
            height_shift = sqrt(max(prime**2 - (lead + lead_shift) ** 2, 0.0)) - height
        size_shifts.append((lead_shift, height_shift))
    unit, linear_constraints = abs(constant_tool_to_follower_ratio(nominal) or 1.0), list[LinearConstraint]()
    for scene_problem, size_shifts in shifts.values():
        ratio = abs(constant_tool_to_follower_ratio(scene_problem) or 1.0)
        share = ratio / unit  # of units (``through_train.linear_constraint_on_tool_motion``)
        for constraint in linear_constraints_of(scene_problem):
            worst = min(
                constraint.lead * by_lead + constraint.height * by_height for by_lead, by_height in size_shifts
            )
            lead_term, height_term = constraint.lead * share, constraint.height * share
            constant = constraint.constant + ratio * worst
            linear_constraints.append(replace(constraint, lead=lead_term, height=height_term, constant=constant))
    return replace(problem, linear_constraints=tuple(linear_constraints))

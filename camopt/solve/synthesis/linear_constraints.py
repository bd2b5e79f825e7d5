"""Limits that are linear in the motion and in the sizes e and s₀: the planes of the convex programme.

Which they are depends on the mechanism: tan β of a trace point that translates and of a groove, and the radius of
curvature and the reach of a flat face that translates, all without a train, or with one of constant ratio. Every
other constraint is a ceiling (``nonconvex_constraints``), for convex steps.

For every cam within tolerances they hold less what tolerances of sizes take of them. A cam that is off by δe and δR
has the lead e + δe and the height s₀ + δs of its own,

    s₀ + δs = √((R_p + δR)² − (e + δe)²),    R_p² = s₀² + e²

so that a·y + b·y' + c·y'' + l·e + h·s₀ + k ≥ 0 holds for it if the same less a constant, l·δe + h·δs at its worst,
holds for the nominal one. That constant is taken at the sizes of the nominal optimum, and again at those that come
of it; in the end the smallest cam of the laws is the robust one, which is proved as any other. A train whose links
are off gives planes of its own, at its ratio. What is no plane is a curve of each of these cams.

Source: A. Ben-Tal, L. El Ghaoui, A. Nemirovski, Robust Optimization, 2009, ch. 1.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf, sqrt
from typing import Any, NamedTuple

from camopt.model.effects import force
from camopt.model.effects.necessary_conditions import LeastForce
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import cylindrical, translating, translating_flat
from camopt.model.mechanisms.pairs import CONTACT_CURVES
from camopt.model.motion.load import ExternalLoad, ReflectedLoad, TrainLoad
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem, strictest_constraints
from camopt.scene.problem.tolerance_zones import NumberErrors
from camopt.solve.synthesis.synthesis_problem import LinearConstraint, MeanConstraint, SynthesisProblem
from camopt.solve.synthesis.through_train import constant_train_ratio, constraint_at_tool


def linear_constraints_of(scene_problem: Problem) -> list[LinearConstraint]:
    """The limits of a scene that are linear, each once. What is not, the size holds in the end."""
    found: dict[LinearConstraint, LinearConstraint] = {}
    for floor in map(
        partial(constraint_at_tool, scene_problem),
        _list_linear_constraints(scene_problem) if constant_train_ratio(scene_problem) else (),
    ):
        plain = replace(floor, name="", kinds=0)
        first = found.get(plain, floor)
        found[plain] = replace(first, kinds=first.kinds | floor.kinds)
    return list(found.values())


def _list_linear_constraints(scene_problem: Problem) -> Iterator[LinearConstraint]:
    asked = strictest_constraints(scene_problem.constraints)
    for limit in scene_problem.limits:
        for constraint in limit.constraints:
            if constraint in asked and constraint.curve in LINEAR_CURVES:
                yield from LINEAR_CURVES[constraint.curve](limit.name, constraint)
            elif (
                constraint in asked
                and (second := _linear_second_contact(scene_problem))
                and second.first_contact_curve(constraint) in LINEAR_CURVES
            ):
                yield from map(
                    second.constraint_on_first,
                    LINEAR_CURVES[second.first_contact_curve(constraint)](limit.name, constraint),
                )
        if limit.necessary_conditions.reach < inf:
            yield from _reach_constraints(limit.name, limit.necessary_conditions.reach)
        if limit.least_contact_force is not None:
            yield _contact_force_constraint(scene_problem, limit.name, limit.least_contact_force)


def mean_constraints_of(scene_problem: Problem) -> Iterator[MeanConstraint]:
    """The limits of a scene on means of the motion that are convex in it. What is not, the cam holds in the end.

    The area below the lift is linear in it, 1/2π·∮y dθ ≥ m, and root mean squares √(1/2π·∮(y⁽ᵏ⁾)² dθ) ≤ r
    are cones: a mean that has to be large is convex where it is linear, one that has to be small in any case.
    """
    for limit in scene_problem.limits:
        constraint = limit.mean_constraint
        if constraint is None or not isinstance(curve := constraint.mean.curves[0][0], Derivative):
            continue
        power, side = constraint.mean.power, constraint.side
        if power == 1 or side > 0.0:
            bound = constraint.mean.value_of_mean(constraint.upper_bound())
            yield MeanConstraint(limit.name, curve.order, power, float(bound), side)


def is_linear(scene_problem: Problem, constraint: Constraint) -> bool:
    """Whether a constraint is a plane in the motion and the sizes; one on a derivative is a range of the laws.

    Behind a train whose ratio changes only what is asked of the tool itself is.
    """
    made, second = constraint.curve, _linear_second_contact(scene_problem)
    if isinstance(made, Derivative):
        return not made.at_follower or constant_train_ratio(scene_problem) is not None
    if second and second.first_contact_curve(constraint) in LINEAR_CURVES:
        return True
    return made in LINEAR_CURVES and constant_train_ratio(scene_problem) is not None


def repeats_first_contact(scene_problem: Problem, constraint: Constraint) -> bool:
    """Whether a constraint on the second contact says what the same does of the first one, half a turn later."""
    mechanism = scene_problem.setup.mechanism
    if not mechanism.drive.one_disc or constraint.kinds != ALL_STROKES:
        return False
    (contact,) = mechanism.further_contacts
    made = getattr(constraint.curve, "make", None)
    return made is not None and made in [getattr(contact.mechanism, name) for name in CONTACT_CURVES]


class _SecondContact(NamedTuple):
    """The second contact of a follower, where its motion is level + way·y, and its lead and height are linear."""

    curves: dict[Any, Any]
    """By the curves of constraints on it, those of the first contact."""
    way: float
    """−1 where the motion is reversed, and the cam that is seen turns the other way."""
    level: float
    share: float
    """What its lead (but for ``way``) and height have of those of the first: 1 or 0."""
    lead: float
    height: float
    """What they have besides, mm."""

    def first_contact_curve(self, constraint: Constraint) -> Any:
        """The curve of the first contact that a constraint on the second is about, if it is one."""
        return self.curves.get(getattr(constraint.curve, "make", None))

    def constraint_on_first(self, floor: LinearConstraint) -> LinearConstraint:
        """A linear limit on the motion and sizes of the second contact as one on those of the first."""
        return replace(
            floor,
            displacement=self.way * floor.displacement,
            velocity=self.way * floor.velocity,
            acceleration=self.way * floor.acceleration,
            lead=self.way * self.share * floor.lead,
            height=self.share * floor.height,
            constant=floor.constant
            + floor.displacement * self.level
            + floor.lead * self.lead
            + floor.height * self.height,
        )


def _linear_second_contact(scene_problem: Problem) -> _SecondContact | None:
    """The second contact, if the lift is given and its sizes are all those of the first, or all known."""
    mechanism, design = scene_problem.setup.mechanism, scene_problem.design
    if not mechanism.further_contacts or mechanism.start is None or scene_problem.setup.angular:
        return None
    if any(stroke.is_move and stroke.is_free for stroke in scene_problem.programme.tool.strokes):
        return None
    (contact,), lift = mechanism.further_contacts, scene_problem.programme.lift
    curves = {contact.mechanism.pressure: mechanism.pressure}
    if mechanism.has_rib:
        closer = -float(design.roller_spacing[0])
        known = "roller_spacing" not in scene_problem.search_space.variables
        return _SecondContact(curves, 1.0, 0.0, 1.0, 0.0, closer) if known else None
    if not design.second:
        return _SecondContact(curves, -1.0, lift, 1.0, 0.0, 0.0)
    searched = [name for name in design.second if name in scene_problem.search_space.variables]
    own = {f"second_{name}" for name in ("size", "roller_radius", "offset")}
    if searched or own - design.second.keys():
        return None
    second = contact.local_designs(design)
    return _SecondContact(curves, -1.0, lift, 0.0, float(second.lead[0]), float(mechanism.start(second)[0]))


def _trace_pressure(name: str, constraint: Constraint) -> Iterator[LinearConstraint]:
    """|y' − e| ≤ T·(s₀ + y)."""
    tangent = constraint.upper_bound()
    yield LinearConstraint(name, tangent, -1.0, lead=1.0, height=tangent, kinds=constraint.kinds)
    yield LinearConstraint(name, tangent, 1.0, lead=-1.0, height=tangent, kinds=constraint.kinds)


def _groove_pressure(name: str, constraint: Constraint) -> Iterator[LinearConstraint]:
    """|y'| ≤ T·R_m."""
    for side in constraint.sides:
        yield LinearConstraint(name, 0.0, -side, height=constraint.upper_bound(), kinds=constraint.kinds)


def _face_radius(name: str, constraint: Constraint) -> Iterator[LinearConstraint]:
    """R_b + y + y'' ≥ ρ."""
    yield LinearConstraint(name, 1.0, 0.0, 1.0, height=1.0, constant=constraint.upper_bound())


def _reach_constraints(
    name: str, most: float, sides: tuple[float, ...] = (1.0, -1.0)
) -> Iterator[LinearConstraint]:
    """No further than so much along a flat face, |y' − e| ≤ t, either way or one way."""
    for side in sides:
        yield LinearConstraint(name, velocity=-side, lead=side, constant=most)


LINEAR_CURVES: dict[Any, Callable[[str, Constraint], Iterator[LinearConstraint]]] = {
    translating.MECHANISM.pressure: _trace_pressure,
    cylindrical.MECHANISM.pressure: _groove_pressure,
    translating_flat.MECHANISM.pressure: lambda name, constraint: iter(
        ()
    ),  # the face is square to its motion: β is 0
    translating_flat.MECHANISM.profile_radius: _face_radius,
    translating_flat.MECHANISM.reach: lambda name, constraint: _reach_constraints(
        name, constraint.upper_bound(), constraint.sides
    ),
}


def _reflected_load(load: ExternalLoad | TrainLoad | None) -> ReflectedLoad:
    """What comes to the follower besides its own dynamics."""
    if isinstance(load, TrainLoad):
        return load.reflected_load
    return ReflectedLoad(0.0, 0.0, load.highest if load else 0.0)


def _contact_force_constraint(scene_problem: Problem, name: str, least: LeastForce) -> LinearConstraint:
    """A contact force that there has to be at a speed, as a plane; of an arm, its moment about the pivot."""
    brought = _reflected_load(scene_problem.programme.load)
    arm = float(scene_problem.design.arm_length[0]) if scene_problem.setup.angular else 1.0
    stiffness, damping, mass, constant = force.force_weights(scene_problem.setup.dynamics, least.omega)
    stiffness, mass = stiffness + brought.stiffness, mass + brought.mass * least.omega**2
    constant += brought.highest  # no motion has more of it: the bound stays one
    unit = abs(constant) + mass or 1.0  # of the order of 1, as the others are
    terms = (stiffness / unit, damping / unit, mass / unit)
    return LinearConstraint(name, *terms, constant=(constant - least.force * arm) / unit)


def with_robust_limits(problem: SynthesisProblem, lead: float, height: float) -> SynthesisProblem:
    """The demand with limits that cams which are off hold too, near an optimum of these sizes, mm."""
    nominal = problem.scene_problem.without_error_limits
    shifts = {id(nominal): (nominal, [(0.0, 0.0)])}
    for scene_problem, off in problem.scene_problem.error_variants:
        _, own = shifts.setdefault(id(scene_problem), (scene_problem, []))
        by_lead = problem.scene_problem.design.sense * off.get("offset", 0.0)
        own.append((by_lead, _height_shift(problem, off, lead, by_lead, height)))
    unit, linear_constraints = abs(constant_train_ratio(nominal) or 1.0), list[LinearConstraint]()
    for scene_problem, own in shifts.values():
        ratio = abs(constant_train_ratio(scene_problem) or 1.0)
        linear_constraints += (
            _reduce_by_shifts(floor, own, ratio, unit) for floor in linear_constraints_of(scene_problem)
        )
    return replace(problem, linear_constraints=tuple(linear_constraints))


def _reduce_by_shifts(
    floor: LinearConstraint, shifts: Sequence[tuple[float, float]], ratio: float, unit: float
) -> LinearConstraint:
    """A linear limit of which so much is taken, δe and δs, as the worst of some cams does.

    It is that of a train of a ratio, and of sizes in units of that of another one
    (``through_train.constraint_at_tool``).
    """
    worst = min(floor.lead * by_lead + floor.height * by_height for by_lead, by_height in shifts)
    share = ratio / unit
    lead, height = floor.lead * share, floor.height * share
    return replace(floor, lead=lead, height=height, constant=floor.constant + ratio * worst)


def _height_shift(
    problem: SynthesisProblem, off: NumberErrors, lead: float, by_lead: float, height: float
) -> float:
    larger = off.get("size", 0.0)
    if not problem.has_trace_point:
        return larger
    prime = sqrt(height**2 + lead**2) + larger + off.get("roller_radius", 0.0)
    return sqrt(max(prime**2 - (lead + by_lead) ** 2, 0.0)) - height

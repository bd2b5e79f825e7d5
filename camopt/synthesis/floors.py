"""Limits that are linear in the motion and in the sizes e and s₀: the planes of the convex programme.

Which they are depends on the mechanism: tan β of a trace point that translates and of a groove, and the radius of
curvature and the reach of a flat face that translates. Every other claim is a ceiling (``ceilings``), for convex
steps.
"""

from collections.abc import Callable, Iterator
from math import pi
from typing import Any

from camopt.claims import Claim, Derivative
from camopt.effects import force
from camopt.mechanisms import cylindrical, translating, translating_flat
from camopt.question import Question, strictest
from camopt.synthesis.demand import Floor


def floors_of(question: Question) -> Iterator[Floor]:
    """The limits of a scene that are linear. What is not, the size holds in the end."""
    asked = strictest(question)
    for limit in question.limits:
        for claim in limit.claims:
            if claim in asked and claim.curve in LINEAR:
                yield from LINEAR[claim.curve](limit.name, claim)
    yield from _on_contact(question)


def is_linear(claim: Claim) -> bool:
    """Whether a claim is a plane in the motion and the sizes; one on a derivative is a range of the laws."""
    return claim.curve in LINEAR or isinstance(claim.curve, Derivative)


def _trace_pressure(name: str, claim: Claim) -> Iterator[Floor]:
    """|y' − e| ≤ T·(s₀ + y)."""
    tangent = claim.allowed()
    yield Floor(name, tangent, -1.0, lead=1.0, height=tangent, kinds=claim.strokes)
    yield Floor(name, tangent, 1.0, lead=-1.0, height=tangent, kinds=claim.strokes)


def _groove_pressure(name: str, claim: Claim) -> Iterator[Floor]:
    """|y'| ≤ T·R_m."""
    for side in claim.sides:
        yield Floor(name, 0.0, -side, height=claim.allowed(), kinds=claim.strokes)


def _square(name: str, claim: Claim) -> Iterator[Floor]:
    """Nothing: the pressure angle of a face square to its motion is 0."""
    return iter(())


def _face_radius(name: str, claim: Claim) -> Iterator[Floor]:
    """R_b + y + y'' ≥ ρ."""
    yield Floor(name, 1.0, 0.0, 1.0, height=1.0, constant=claim.allowed())


def _face_reach(name: str, claim: Claim) -> Iterator[Floor]:
    """|y' − e| ≤ t."""
    for side in claim.sides:
        yield Floor(name, velocity=-side, lead=side, constant=claim.allowed())


LINEAR: dict[Any, Callable[[str, Claim], Iterator[Floor]]] = {
    translating.MECHANISM.pressure: _trace_pressure,
    cylindrical.MECHANISM.pressure: _groove_pressure,
    translating_flat.MECHANISM.pressure: _square,
    translating_flat.MECHANISM.profile_radius: _face_radius,
    translating_flat.MECHANISM.reach: _face_reach,
}


def _on_contact(question: Question) -> Iterator[Floor]:
    """The contact force at the scene's speed, and that at a speed that the cam has to reach, as planes."""
    subject, limits, load = question.subject, question.scene.limits, question.programme.load
    speeds = {
        "contact_force_min": (subject.omega, limits.contact_force_min),
        "jump_speed": (None if limits.jump_speed is None else limits.jump_speed * pi / 30, 0.0),
    }
    for name, (omega, least) in speeds.items():
        if getattr(limits, name) is not None and omega is not None and least is not None:
            stiffness, damping, mass, constant = force.weights(subject.dynamics, omega)
            constant += load.highest if load else 0.0  # no motion has more of it: the bound stays one
            unit = abs(constant) + mass or 1.0  # of the order of 1, as the others are
            yield Floor(name, stiffness / unit, damping / unit, mass / unit, constant=(constant - least) / unit)

"""Contact stress by Hertz: rollers and flat faces in line contact.

    p₀ = √(E*/(π·L)·max N/R),    b = 2·√(N·R/(π·L·E*)),    largest shear 0.30028·p₀ at the depth 0.78615·b

with the relative radius R of ``effects.loads``, half-width b, face width L. On a concave flank that nearly conforms
to the roller R grows without end and the stress falls to zero: the formulas hold while b is small against R_r.
A knife edge has no width, and its stress no bound. In a groove the roller touches one flank or the other, and the
sharper counts. Source: Johnson, Contact Mechanics, ch. 4.
"""

from functools import partial
from typing import Any

import numpy as np

from camopt.effects import force
from camopt.effects.case import Bounded, Case, Effect, Subject
from camopt.effects.loads import Largest, Variant, goal_of, largest, line_load, normal_curve, sides
from camopt.numerics import FloatArray
from camopt.numerics.curves import curve

SHEAR, DEPTH = 0.3002831060007776, 0.7861513777574233  # of the largest shear: over p₀, over b
NAMES = ("contact_stress_max_MPa", "contact_half_width_mm", "contact_shear_max_MPa", "contact_shear_depth_mm")


def offers(subject: Subject) -> tuple[str, ...]:
    return NAMES[:1] if subject.pointed else () if subject.spherical else NAMES


def lacks(subject: Subject) -> dict[str, tuple[str, ...]]:
    keys = force.missing(subject)
    if not subject.bodies.modulus:
        keys += ("materials.cam", "materials.follower")
    if not subject.bodies.face_width:
        keys += ("materials.face_width",)
    return {name: keys for name in offers(subject) if keys and not subject.pointed}


def reads(subject: Subject) -> tuple[str, ...]:
    if subject.pointed:
        return ()
    return ("undercut", *(("jamming_margin",) if subject.dynamics.friction and subject.mechanism.curvature else ()))


def variants(subject: Subject) -> list[tuple[float, Variant]]:
    """The line load on each flank, with the guide's friction on each side: (side, variant)."""
    flanks = (1.0, -1.0) if subject.mechanism.grooved else (1.0,)
    return [
        (side, (partial(line_load, subject, flank=flank, side=side), kinds))
        for flank in flanks
        for side, kinds in sides(subject)
    ]


def load_of(subject: Subject, stress: float) -> float:
    """N/R, N/mm², at which the contact stress is reached."""
    assert subject.bodies.modulus is not None
    assert subject.bodies.face_width is not None
    return stress**2 * np.pi * subject.bodies.face_width / subject.bodies.modulus


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    subject = case.subject
    if subject.pointed:
        return {"contact_stress_max_MPa": np.inf}
    sound = ~np.broadcast_to(case.found["undercut"], len(case.designs))
    sound = sound & (np.asarray(case.found.get("jamming_margin", 1.0)) > 0.0)
    both = variants(subject)
    goal, curves = goal_of(subject), [variant for _, variant in both]
    top = largest(case, curves, goal, sound)
    load, unit = np.maximum(top.value, 0.0), load_of(subject, 1.0)
    stress = np.sqrt(load / unit)
    finite = np.where(np.isfinite(load), stress, 0.0)
    outward = np.where(np.isfinite(load), np.sqrt((load + top.width) / unit) - finite, 0.0)
    columns: dict[str, Any] = {"contact_stress_max_MPa": Bounded(stress, outward, stress)}
    if wanted & set(NAMES[1:]):
        top = largest(case, curves, goal, sound, located=True)
        half_width = np.where(np.isfinite(load), 0.0, np.inf)
        for number, (side, (make, _)) in enumerate(both):
            here = np.flatnonzero(np.isfinite(load) & (load > 0.0) & (top.variant == number))
            half_width[here] = _half_width(case, make, side, here, top)
        columns["contact_half_width_mm"] = half_width
        columns["contact_shear_max_MPa"] = Bounded(SHEAR * stress, SHEAR * outward, stress)
        columns["contact_shear_depth_mm"] = DEPTH * half_width
    return columns


def _half_width(case: Case, make: Any, side: float, index: Any, top: Largest) -> FloatArray:
    """Half-width of the contact where the stress is largest, b = 2·N/(π·L·p₀)."""
    designs, programme = case.designs.take(index), case.programme
    load, normal = make(designs, programme), normal_curve(case.subject, designs, programme, side)
    values = []
    for turn in (-1e-12, 1e-12):  # to both sides of a jump
        motion = programme.at(np.mod(top.where[index] + turn, 2 * np.pi))
        values.append((curve(load, ..., *motion)[0], curve(normal, ..., *motion)[0]))
    (before, one), (after, two) = values
    nearer = np.abs(np.abs(before) - top.value[index]) < np.abs(np.abs(after) - top.value[index])
    force = np.abs(np.where(nearer, one, two))
    stress, width = np.sqrt(top.value[index] / load_of(case.subject, 1.0)), case.subject.bodies.face_width
    assert width is not None
    return np.asarray(2.0 * force / (np.pi * width * stress))


EFFECT = Effect("hertz", offers, run, lacks, reads)

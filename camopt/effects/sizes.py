"""Sizes: what a design is made of, numbers of the scene that vary among them, and its clearance of the shaft.

No point of a profile is nearer to the cam centre than the base circle (the trace point is never nearer than
the prime circle), so the clearance is base radius minus shaft radius, exactly.
"""

from typing import Any

from camopt.effects.case import Case, Effect, Setup
from camopt.motion.table import RETURN, RISE


def offers(setup: Setup) -> tuple[str, ...]:
    mechanism = setup.mechanism
    names = ["law_rise", "law_return", mechanism.body.size_quantity]
    if mechanism.curvature is not None:
        names += ["roller_radius_mm"]
        names += ["prime_radius_mm"] if mechanism.body.closed else []
        names += ["arm_length_mm"] if setup.angular else []
    elif setup.angular:
        names += ["face_offset_mm"]
    if mechanism.body.closed:
        names += ["centre_distance_mm"] if setup.angular else ["offset_mm"]
    if setup.shaft_radius is not None:
        names += ["shaft_clearance_mm"]
    return (*names, *setup.varied.values())


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    designs = case.designs
    return {
        "law_rise": case.programme.law_names(RISE),
        "law_return": case.programme.law_names(RETURN),
        case.setup.mechanism.body.size_quantity: designs.size,
        "roller_radius_mm": designs.roller_radius,
        "prime_radius_mm": designs.prime_radius,
        "offset_mm": designs.offset,
        "arm_length_mm": designs.arm_length,
        "centre_distance_mm": designs.centre_distance,
        "face_offset_mm": designs.face_offset,
        "shaft_clearance_mm": designs.size - (case.setup.shaft_radius or 0.0),
        **{name: case.each.given[key] for key, name in case.setup.varied.items()},
    }


EFFECT = Effect("sizes", offers, run, of_sizes=True)

"""Sizes of a design, the scene's numbers that vary from design to design, and the clearance of the shaft.

No point of a profile is nearer to the cam centre than the base circle, since the trace point is never nearer than
the prime circle. So the clearance is exactly the base radius minus the shaft radius.
"""

from typing import Any

from camopt.model.effects.contacts import smallest_disc_size
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.motion.stroke import RETURN, RISE


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    mechanism = setup.mechanism
    names = ["law_rise", "law_return", *mechanism.size_quantity_by_field.values()]
    if mechanism.body.closed and not mechanism.flat_faced:
        names += ["prime_radius_mm"]
    if setup.shaft_radius is not None:
        names += ["shaft_clearance_mm"]
    return (*names, *setup.varied.values())


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    designs, mechanism = case.designs, case.setup.mechanism
    seconds = (each.local_designs(designs).sizes.items() for each in mechanism.further_contacts)
    sizes = designs.sizes | {f"second_{name}": size for each in seconds for name, size in each}
    return {
        "law_rise": case.programme.law_names(RISE),
        "law_return": case.programme.law_names(RETURN),
        **{name: sizes[field] for field, name in mechanism.size_quantity_by_field.items()},
        "prime_radius_mm": designs.prime_radius,
        "shaft_clearance_mm": smallest_disc_size(case.setup, designs) - (case.setup.shaft_radius or 0.0),
        **{name: case.setup_per_design.given[key] for key, name in case.setup.varied.items()},
    }


EFFECT = Effect("sizes", applicable_quantities, evaluate_columns, is_of_sizes=True)

"""Face: the least diameter of a flat face that turns in its guide, such as that of a bucket tappet.

The contact is a line of the cam's width b, square to the reach r along the face. It stays within a circle about the
follower's axis with the diameter 2·√(r² + (b/2)²), with the largest |r| over the turn. Without a face width in the
scene, b = 0.

Source: the reach is that of Norton, Cam Design and Manufacturing Handbook, ch. 7 (width of a flat face).
"""

from typing import Any

import numpy as np

from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, NecessaryConditions, Setup

FACE_DIAMETER = "face_diameter_min_mm"
FACE_REACHES = ("face_reach_max_mm", "face_reach_min_mm")


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    return () if setup.mechanism.reach is None or setup.angular else (FACE_DIAMETER,)


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    width = case.setup_per_design.bodies.face_width
    width = 0.0 if width is None else width
    diameter, far = (
        2.0 * np.hypot(np.maximum(*map(np.abs, ends)), width / 2.0)
        for ends in (
            [case.columns[name] for name in FACE_REACHES],
            [case.outer_end_of_column_enclosure(name) for name in FACE_REACHES],
        )
    )
    return {FACE_DIAMETER: EnclosedValue(diameter, far - diameter, diameter)}


def necessary_conditions(setup: Setup, quantity_name: str, bound: float) -> NecessaryConditions:
    """The reach at which the circle about the follower's axis has the bound as its diameter."""
    width = setup.bodies.face_width or 0.0
    if quantity_name != FACE_DIAMETER or "materials.face_width" in setup.free or bound < width:
        return NecessaryConditions()
    return NecessaryConditions(reach=difference_of_squares_root(bound, width) / 2.0)


EFFECT = Effect(
    "face",
    applicable_quantities,
    evaluate_columns,
    input_quantities=lambda setup: FACE_REACHES if applicable_quantities(setup) else (),
    necessary_conditions=necessary_conditions,
    is_per_contact=True,
)

"""Wall: the least thickness of metal round the bore and its keyway.

The wall ends

- on a disc cam at the base circle, where a groove in its face is nearest to the axis too, and at its hub;
- on a disc cam with a rib at the inner flank, beyond the centre of the inner roller by its radius;
- on a cylindrical cam at the bottom of its groove, or the foot of its rib.

The corners of a keyway of width w and depth t in a bore of radius r are at the distance √((r + t)² + w²/4) from the
axis.
"""

from math import inf
from typing import Any

import numpy as np

from camopt.model.effects.effect import Effect, EvaluationBlock, NecessaryConditions, Setup
from camopt.model.mechanisms.elements import INNER_SIDE

WALL = "hub_wall_min_mm"


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    return (WALL,)


def cam_radius_for_wall(setup: Setup, wall_thickness: float) -> float:
    """Base or mean radius for a thickness of the wall [mm]; infinite if the hub's wall is thinner."""
    solid = setup.solid
    if solid.hub_radius and solid.hub_radius - solid.bore_reach < wall_thickness:
        return inf
    inwards = (solid.groove_depth_or_rib_height or 0.0) / 2.0 if setup.mechanism.body.developed else 0.0
    return wall_thickness + solid.bore_reach + inwards


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    solid, designs, mechanism = case.setup.solid, case.designs, case.setup.mechanism
    inside = not mechanism.body.developed and all(flank.side > INNER_SIDE for flank in mechanism.flanks)
    # the flank of a rib is beyond its inner roller
    beyond = designs.roller_radius + case.setup.pitch_to_flank_distance(designs) if inside else 0.0
    wall = designs.size + beyond - cam_radius_for_wall(case.setup, 0.0)
    return {WALL: np.minimum(wall, solid.hub_radius - solid.bore_reach) if solid.hub_radius else wall}


EFFECT = Effect(
    "wall",
    applicable_quantities,
    evaluate_columns,
    lambda setup: {} if setup.solid.bore_radius else {WALL: ("part.bore",)},
    necessary_conditions=lambda setup, name, bound: NecessaryConditions(
        least_size=cam_radius_for_wall(setup, bound)
    ),
    is_of_sizes=True,
    is_per_contact=True,
)

"""Outline: the radius of the circle that the turning cam fills, and its clearance to pivot and edge.

At the farthest point of a profile the normal is along the radius. With a trace point C, the farthest point is where
C is farthest, at |C| − R_r. With a flat face it is where the face is farthest: at R_b + y if the face translates,
at f + c·sin ψ if it swings. For an undercut profile this is an upper bound.

These distances rise with the displacement y and depend on nothing else of the motion: up to the highest position ψ
stays below π for an arm, and below π/2 for a face. So the farthest point belongs to the highest position; on the
second disc of a pair, whose motion is reversed, to the lowest.

The pivot of an oscillating follower is at the distance c from the cam's axis. Its clearance to the turning cam is

    c − R_out

and has to be more than the radius of its boss. Below 0 the cam runs through the pivot and breaks the limit
``pivot_in_cam``, which every cam has.

A groove in the face of a disc has R_out = max |C| + R_r plus half the clearance of the roller: the farthest point
of its outer wall. A disc of the diameter D then has the edge wall D/2 − R_out. The follower is beside such a disc,
so there is no clearance to its pivot.

Source: regrouped from Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from collections.abc import Callable
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, Curve, Number
from camopt.core.numerics.curves import curve_type_from_formula
from camopt.core.numerics.state import State
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.peak import Peak
from camopt.model.effects.peak_columns import peak_column
from camopt.model.mechanisms.design import Designs, unreduced_designs
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES

OUTER_RADIUS, PIVOT_CLEARANCE = "outer_radius_mm", "pivot_clearance_min_mm"
EDGE_WALL = "edge_wall_min_mm"


@curve_type_from_formula
def clearance_beyond_outline(state: State, outline: Number, distance_from_axis: Number) -> Number:
    """A distance from the cam's axis, such as that of the pivot, minus that of the outline [mm]."""
    return distance_from_axis - outline


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    mechanism = setup.mechanism
    if mechanism.outline is None:
        return ()
    edge = (EDGE_WALL,) if "outer_diameter" in mechanism.body.part else ()
    pivot = (PIVOT_CLEARANCE,) if mechanism.body.bounded and "centre_distance" in mechanism.sizes else ()
    return (OUTER_RADIUS, *pivot, *edge)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    lacking = EDGE_WALL in applicable_quantities(setup) and setup.solid.outer_diameter is None
    return {EDGE_WALL: ("part.outer_diameter",)} if lacking else {}


def _outermost_outline_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    """Curve of the outline's distance from the axis, for the flank that is farthest from it [mm]."""
    assert setup.mechanism.outline is not None
    side = max(flank.side for flank in setup.mechanism.flanks)
    return setup.mechanism.outline(designs, programme, side * setup.pitch_to_flank_distance(designs))


def _clearance_curve(
    setup: Setup, distance_from_axis: Callable[[Designs], Any], designs: Designs, programme: Programme
) -> Curve:
    return clearance_beyond_outline(
        _outermost_outline_curve(setup, designs, programme), distance_from_axis(designs)
    )


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.mechanism.outline is None:
        return {}
    centre_distance, edge = attrgetter("centre_distance"), (setup.solid.outer_diameter or 0.0) / 2.0
    per_body = (
        0.0
        if setup.mechanism.standard_profile_reduction is unreduced_designs
        else -1.0
        if setup.mechanism.flat_faced
        else 1.0
    )
    clearances = {
        OUTER_RADIUS: Peak(((partial(_outermost_outline_curve, setup), ALL_STROKES),), LARGEST),
        PIVOT_CLEARANCE: Peak(
            ((partial(_clearance_curve, setup, centre_distance), ALL_STROKES),),
            LEAST,
            unit=centre_distance,
            per_body=per_body,
        ),
        EDGE_WALL: Peak(
            ((partial(_clearance_curve, setup, lambda designs: np.full(len(designs), edge)), ALL_STROKES),),
            LEAST,
            unit=attrgetter("size"),
        ),
    }
    return {
        name: clearances[name]._replace(at_ends=True)
        for name in applicable_quantities(setup)
        if name not in missing_keys_by_quantity(setup)
    }


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    return {name: peak_column(case, peak) for name, peak in peaks(case.setup).items() if name in wanted_quantities}


EFFECT = Effect(
    "outline", applicable_quantities, evaluate_columns, missing_keys_by_quantity, peaks=peaks, is_per_contact=True
)

"""Outline: the radius of the circle about the cam's axis that the turning cam needs, and what it leaves of room.

The farthest point of a profile has its normal along the radius. So it is where the trace point C is farthest, at
|C| − R_r; under a flat face, where the face is farthest: at R_b + y if it translates, at f + c·sin ψ if it swings.
That is so for a profile that is not undercut; of one that is, this is an upper bound.

The pivot of a follower that oscillates is at the distance c from the cam's axis. The turning cam stays from it by

    c − R_out

which has to be more than the radius of its boss; below 0 the cam passes over the pivot.

Source: regrouped from Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from camopt.effects.case import Case, Effect, Setup
from camopt.effects.peak import Peak
from camopt.effects.peak_columns import peak_column
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST, LEAST, FloatArray
from camopt.numerics.curves import curve, formula

RADIUS, CLEARANCE = "outer_radius_mm", "pivot_clearance_min_mm"


class PivotClearance(NamedTuple):
    """Distance of the pivot from the cam's axis less how far the outline is from it, mm."""

    outline: Any
    centre_distance: FloatArray


@formula(PivotClearance)
def pivot_clearance(f, i, at):
    far, far1 = curve(f.outline, i, at)
    return f.centre_distance[i] - far, -far1


def offers(setup: Setup) -> tuple[str, ...]:
    if setup.mechanism.outline is None:
        return ()
    return (RADIUS, CLEARANCE) if "centre_distance" in setup.mechanism.sizes else (RADIUS,)


def _clearance(
    outline: Callable[[Designs, Programme], Any], designs: Designs, programme: Programme
) -> PivotClearance:
    return PivotClearance(outline(designs, programme), designs.centre_distance)


def _centre_distance(designs: Designs) -> Any:
    """c, mm: clearances are right to so much of it."""
    return designs.centre_distance


def peaks(setup: Setup) -> dict[str, Peak]:
    outline = setup.mechanism.outline
    if outline is None:
        return {}
    room = Peak(((partial(_clearance, outline), ALL_STROKES),), LEAST, unit=_centre_distance)
    found = {RADIUS: Peak(((outline, ALL_STROKES),), LARGEST), CLEARANCE: room}
    return {name: found[name] for name in offers(setup)}


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    return {name: peak_column(case, peak) for name, peak in peaks(case.setup).items() if name in wanted}


EFFECT = Effect("outline", offers, run, peaks=peaks, of_contact=True)

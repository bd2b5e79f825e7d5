"""Outline: the radius of the circle about the cam's axis that the turning cam just clears.

The farthest point of a profile has its normal along the radius. So it is where the trace point C is farthest, at
|C| − R_r; under a flat face, where the face is farthest: at R_b + y if it translates, at f + c·sin ψ if it swings.
That is so for a profile that is not undercut; of one that is, this is an upper bound.

Source: regrouped from Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from typing import Any

from camopt.effects.case import Bounded, ByExtreme, Case, Effect, Setup, as_it_is
from camopt.motion.table import TURN
from camopt.numerics import LARGEST

RADIUS = "outer_radius_mm"


def offers(setup: Setup) -> tuple[str, ...]:
    return () if setup.mechanism.outline is None else (RADIUS,)


def by_extremes(setup: Setup) -> dict[str, ByExtreme]:
    if setup.mechanism.outline is None:
        return {}
    return {RADIUS: ByExtreme(((setup.mechanism.outline, TURN),), LARGEST, as_it_is)}


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    assert case.setup.mechanism.outline is not None
    found = case.extremes(case.setup.mechanism.outline, [(TURN, LARGEST)])
    return {RADIUS: Bounded(found.value[0], found.width[0], found.value[0])}


EFFECT = Effect("outline", offers, run, by_extremes=by_extremes)

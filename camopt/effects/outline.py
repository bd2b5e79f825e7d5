"""Outline: the radius of the circle about the cam's axis that the turning cam needs.

The farthest point of a profile has its normal along the radius. So it is where the trace point C is farthest, at
|C| − R_r; under a flat face, where the face is farthest: at R_b + y if it translates, at f + c·sin ψ if it swings.
That is so for a profile that is not undercut; of one that is, this is an upper bound.

Source: regrouped from Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from typing import Any

from camopt.effects.case import Case, Effect, Setup
from camopt.effects.peak import Peak
from camopt.effects.peak_columns import peak_column
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST

RADIUS = "outer_radius_mm"


def offers(setup: Setup) -> tuple[str, ...]:
    return () if setup.mechanism.outline is None else (RADIUS,)


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.mechanism.outline is None:
        return {}
    return {RADIUS: Peak(((setup.mechanism.outline, ALL_STROKES),), LARGEST)}


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    return {name: peak_column(case, peak) for name, peak in peaks(case.setup).items()}


EFFECT = Effect("outline", offers, run, peaks=peaks)

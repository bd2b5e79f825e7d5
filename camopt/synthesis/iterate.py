"""Solutions of a convex programme of free laws, without a solver's error."""

from typing import NamedTuple

import numpy as np

from camopt.motion.table import DWELL
from camopt.numerics import FloatArray
from camopt.synthesis.convex import Convex
from camopt.synthesis.demand import Demand
from camopt.synthesis.spline_motion import SplineMotion


class Iterate(NamedTuple):
    """A solution: e and s₀ in units of the sizes, and the coefficients of each moving stroke."""

    lead: float
    height: float
    coefficients: tuple[FloatArray, ...]


def moving(model: Convex) -> list[SplineMotion]:
    """The free motions of a programme."""
    return [motion for motion in model.motions if isinstance(motion, SplineMotion)]


def iterate_of(model: Convex) -> Iterate:
    """The values of a solved programme."""
    sizes = float(model.sizes.lead.value), float(model.sizes.height.value)
    return Iterate(*sizes, cleaned(model.demand, [motion.coefficients.value for motion in moving(model)]))


def cleaned(demand: Demand, coefficients: list[FloatArray]) -> tuple[FloatArray, ...]:
    """Coefficients without a solver's error: at rest beside a dwell, smooth where two strokes meet, monotone.

    However small, an error there would be a jump of the acceleration, or a motion that turns back.
    """
    strokes = [stroke for stroke in demand.strokes if stroke.kind != DWELL]
    found: list[FloatArray] = [np.asarray(np.clip(each, 0.0, 1.0)) for each in coefficients]
    if demand.monotone:
        found = [np.maximum.accumulate(each) for each in found]
    turns = [stroke.kind != strokes[number - 1].kind for number, stroke in enumerate(strokes)]
    for number, (stroke, own) in enumerate(zip(strokes, found, strict=True)):
        first, last = (1 + demand.rest * beside for beside in demand.beside_dwells(stroke))
        own[:first], own[-last:] = 0.0, 1.0
        if turns[number]:  # no velocity: the motion does not leave the stroke
            own[1], found[number - 1][-2] = 0.0, 1.0
    for number, (stroke, own) in enumerate(zip(strokes, found, strict=True)):
        if demand.beside_dwells(stroke)[0]:
            continue
        before = strokes[number - 1]
        for order in range(2 if turns[number] else 1, demand.rest + 1):
            start, end = (demand.splines.at(np.array([x]), order).toarray()[0] for x in (0.0, 1.0))
            per, per_before = ((s.high - s.low) / s.angle**order for s in (stroke, before))
            wanted = per_before / per * (end @ found[number - 1])
            own[order] = (wanted - start[:order] @ own[:order]) / start[order]
    return tuple(found)

"""The limit lines of a diagram: one for each limit on its curve, at the bound in the diagram's unit."""

from collections.abc import Hashable
from functools import partial
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.model.effects.peak import DOUBLES, Peak
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE, WAYS
from camopt.scene.problem.claims import At, Claim
from camopt.scene.problem.limits import peak_of
from camopt.show.drawing.picture import Picture

LimitLines = list[tuple[int, float]]
"""Kinds of stroke over which a magnitude is bounded, or 0 for one side of the turn; the level."""


def limit_lines(picture: Picture, name: str, kinds: int = 0) -> LimitLines:
    """The lines of all limits on the curve whose extreme is a quantity, in the unit of that quantity.

    One of a quantity that is no extreme of a curve is at its own bound, over some kinds of stroke.
    """
    asked = [limit for limit in picture.problem.limits if limit.asked]
    peak = peak_of(name, picture.problem.setup)
    if peak is None:
        return [(kinds, limit.bound) for limit in asked if name in limit.shown]
    shown = {_identity(make) for make, _ in peak.curves}
    found = [claim for limit in asked for claim in limit.claims if _identity(claim.curve) in shown]
    return list(dict.fromkeys((_kinds(claim), _level(claim, peak, picture)) for claim in found))


def _identity(make: Any) -> Hashable:
    """A key that tells the curves of one setup apart."""
    return (make.func, frozenset(make.keywords.items())) if isinstance(make, partial) else make


def _kinds(claim: Claim) -> int:
    """The kinds of stroke over which a magnitude is bounded; 0 for one side of the turn."""
    if claim.goal != LARGEST_MAGNITUDE:
        return 0
    everywhere = claim.kinds & WAYS or claim.kinds & (RISE | RETURN) == RISE | RETURN
    return ALL_STROKES if everywhere else claim.kinds


def _level(claim: Claim, peak: Peak, picture: Picture) -> float:
    """The bound of a claim as a value of the quantity that a peak is."""
    if isinstance(claim.bound, At) and claim.bound.scale == peak.scale:
        return claim.bound.quantity
    design = picture.problem.design
    extreme = claim.bound.value(DOUBLES) / np.asarray(claim.factor(design))
    return float(np.squeeze(peak.scale.quantity(extreme, design)))

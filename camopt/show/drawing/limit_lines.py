"""Limit lines of a diagram: one for each limit on its curve, at the bound in the unit of the diagram."""

from collections.abc import Hashable
from functools import partial
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.model.effects.peak import DOUBLES, Peak
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE, WAYS
from camopt.scene.problem.constraints import Constraint, QuantityBound
from camopt.scene.problem.limits import peak_at_first_contact
from camopt.show.drawing.picture import Picture


def stroke_kinds_and_limit_levels(
    picture: Picture, quantity_name: str, stroke_kinds: int = 0
) -> list[tuple[int, float]]:
    """The lines of all limits on the curve whose extreme is the quantity ``quantity_name``, in its unit.

    They are pairs of kinds of stroke and level. Kinds 0 are one line over the turn; else ± the level is drawn over
    these strokes. If the quantity is not an extreme of a curve, its limit is one line at its bound.
    """
    limits = [limit for limit in picture.problem.limits if limit.set_by_scene]
    peak = peak_at_first_contact(quantity_name, picture.problem.setup)
    if peak is None:
        return [(stroke_kinds, limit.bound) for limit in limits if quantity_name in limit.shown_quantities]
    shown = {_curve_identity(make) for make, _ in peak.curves}
    constraints = [
        constraint
        for limit in limits
        for constraint in limit.constraints
        if _curve_identity(constraint.curve) in shown
    ]
    return list(
        dict.fromkeys(
            (_stroke_kinds_of_magnitude_bound(constraint), _bound_in_quantity_unit(constraint, peak, picture))
            for constraint in constraints
        )
    )


def _curve_identity(curve_maker: Any) -> Hashable:
    """A key that is equal for equal curves of one setup."""
    return (
        (curve_maker.func, frozenset(curve_maker.keywords.items()))
        if isinstance(curve_maker, partial)
        else curve_maker
    )


def _stroke_kinds_of_magnitude_bound(constraint: Constraint) -> int:
    """Kinds of stroke over which a magnitude is bounded; 0 if only one sign is bounded."""
    if constraint.goal != LARGEST_MAGNITUDE:
        return 0
    everywhere = constraint.kinds & WAYS or constraint.kinds & (RISE | RETURN) == RISE | RETURN
    return ALL_STROKES if everywhere else constraint.kinds


def _bound_in_quantity_unit(constraint: Constraint, peak: Peak, picture: Picture) -> float:
    """The bound of a constraint, in the unit of the quantity of a peak."""
    if isinstance(constraint.bound, QuantityBound) and constraint.bound.scale == peak.scale:
        return constraint.bound.quantity
    design = picture.problem.design
    with np.errstate(divide="ignore"):  # the bound may be infinite
        extreme = constraint.bound.curve_extreme_at_bound(DOUBLES) / np.asarray(constraint.factor(design))
        return float(np.squeeze(peak.scale.quantity_from_extreme(extreme, design)))

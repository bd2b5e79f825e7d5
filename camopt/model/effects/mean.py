"""Means: quantities that are the mean of a curve over the turn, or its root mean square.

    M = (1/2π·∮fᵖ dθ)^(1/p),    p = 1 or 2

An effect declares the curve, and the scale from the mean to the quantity, as with a ``Peak``.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import Number
from camopt.model.effects.panel_parts import PanelParts
from camopt.model.effects.peak import IDENTITY_SCALE, NumberKind, Scale, Variant, never_infinite_by_jumps
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme


class Mean(NamedTuple):
    """A quantity that is the mean of a curve over the turn, or its root mean square."""

    curves: tuple[Variant, ...]
    """The curve, or its parts by kinds of pieces, which together make up the turn."""
    power: int = 1
    scale: Scale = IDENTITY_SCALE
    jumps: Callable[[Programme], bool] = never_infinite_by_jumps
    """Whether jumps of a motion make it infinite for every design."""
    smooth: Callable[[Designs, Programme], PanelParts] | None = None
    """The parts on which its curves are smooth; None if these are whole panels."""

    @property
    def is_least(self) -> bool:
        """Whether a bound on the quantity bounds the mean from below."""
        return self.scale.is_decreasing

    def mean_from_power_mean(self, power_mean: Number) -> Number:
        """M, from the mean of the curve to the power p; numbers or ranges."""
        return power_mean if self.power == 1 else np.sqrt(power_mean)

    def power_mean_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        """Mean of the curve to the power p at a value of the quantity; negative if there is none."""
        mean = self.scale.weighted_extreme_for_quantity(quantity, number_kind)
        return mean if self.power == 1 or mean < 0 else mean * mean

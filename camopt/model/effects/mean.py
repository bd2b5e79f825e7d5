"""Means: quantities that are the mean of a curve over the turn, or its root mean square.

    M = (1/2π·∮fᵖ dθ)^(1/p),    p = 1 or 2

An effect says once of which curve a quantity is the mean, and by which monotone map people read it, as of a
``Peak``.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from camopt.model.effects.panel_parts import PanelParts
from camopt.model.effects.peak import IDENTITY_SCALE, NumberKind, Scale, Variant, never_jumps
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme

SmoothPanels = Callable[[Designs, Programme], PanelParts]
"""The parts of panels on which the curves of one design are smooth."""


class Mean(NamedTuple):
    """A quantity that is the mean of a curve over the turn, or its root mean square."""

    curves: tuple[Variant, ...]
    """The curve, or what it is on the pieces of some kinds, which together are the turn."""
    power: int = 1
    scale: Scale = IDENTITY_SCALE
    jumps: Callable[[Programme], bool] = never_jumps
    """Whether jumps of a motion make it infinite, whatever the design."""
    smooth: SmoothPanels | None = None
    """Where its curves are smooth, if that is not on whole panels."""

    @property
    def is_least(self) -> bool:
        """Whether a bound on the quantity bounds the mean from below."""
        return self.scale.falls

    def value_of_mean(self, mean: Any) -> Any:
        """M from the mean of the curve to the power p: numbers or ranges."""
        return mean if self.power == 1 else np.sqrt(mean)

    def power_mean_at(self, quantity: float, numbers: NumberKind) -> Any:
        """The mean of the curve to the power p at a value of the quantity; below 0 if there is none."""
        mean = self.scale.extreme_at(quantity, numbers)
        return mean if self.power == 1 or mean < 0 else mean * mean

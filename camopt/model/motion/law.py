"""A motion law: a module, or a member of a family of laws (a class), with four functions on the unit stroke.

``displacement(x)`` runs from s(0) = 0 to s(1) = 1. ``velocity``, ``acceleration`` and ``jerk`` are its first three
derivatives by x. ``BREAKS`` are the points between which all four are smooth, 0 and 1 included. At a break a
function may return either one-sided value, so motion tables evaluate laws only between breaks.

A law need not rest at its ends. ``vdi_motion_task`` names its motion at both ends by the letters of VDI 2143.

The steps to add a law are on the page ``docs/architecture.md``.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray


class Law(Protocol):
    """The functions and constants that every law has."""

    @property
    def NAME(self) -> str: ...  # noqa: N802
    @property
    def TITLE(self) -> str: ...  # noqa: N802
    @property
    def SOURCE(self) -> str: ...  # noqa: N802
    @property
    def BREAKS(self) -> tuple[float, ...]: ...  # noqa: N802

    def __hash__(self) -> int: ...
    def displacement(self, x: ArrayLike, /) -> FloatArray: ...
    def velocity(self, x: ArrayLike, /) -> FloatArray: ...
    def acceleration(self, x: ArrayLike, /) -> FloatArray: ...
    def jerk(self, x: ArrayLike, /) -> FloatArray: ...


class LawByOrder:
    """The four functions of a law that has one formula for the derivative of any order."""

    def _derivative(self, x: ArrayLike, order: int) -> FloatArray:
        raise NotImplementedError

    def displacement(self, x: ArrayLike, /) -> FloatArray:
        return self._derivative(x, 0)

    def velocity(self, x: ArrayLike, /) -> FloatArray:
        return self._derivative(x, 1)

    def acceleration(self, x: ArrayLike, /) -> FloatArray:
        return self._derivative(x, 2)

    def jerk(self, x: ArrayLike, /) -> FloatArray:
        return self._derivative(x, 3)


class LawBySeries(LawByOrder):
    """The four functions of a law that computes all derivatives up to some order together."""

    def _derivatives_to_order(self, x: ArrayLike, order: int) -> Sequence[FloatArray]:
        """Displacement and its derivatives up to an order."""
        raise NotImplementedError

    def _derivative(self, x: ArrayLike, order: int) -> FloatArray:
        return self._derivatives_to_order(x, order)[order]


def law_derivatives(law: Law, x: ArrayLike, order: int) -> Sequence[FloatArray]:
    """Displacement of a law and its derivatives up to an order."""
    if isinstance(law, LawBySeries):
        return law._derivatives_to_order(x, order)
    return [verb(x) for verb in (law.displacement, law.velocity, law.acceleration, law.jerk)[: order + 1]]


def fold_to_half(x: ArrayLike) -> tuple[FloatArray, Any]:
    """x mirrored into the first half of the stroke, and a mask of the mirrored values.

    A symmetric law, s(1−x) = 1 − s(x), is evaluated from the nearer end, where its formulas keep their digits.
    """
    x = np.asarray(x, dtype=float)
    mirrored = x > 0.5
    return np.where(mirrored, 1.0 - x, x), mirrored


VDI_STATES = {(False, False): "R", (True, False): "G", (False, True): "U", (True, True): "B"}
"""Letters of VDI 2143, by whether velocity and acceleration differ from 0.

Rest (Rast), constant velocity (Geschwindigkeit), reversal (Umkehr), and motion in general (Bewegung).
"""
UNIT_SAMPLES = np.linspace(0.0, 1.0, 257)
LAW_ROUNDING = 1e-9  # of the largest value: less is rounding


def vdi_motion_task(law: Law) -> str:
    """The motion task of a law by VDI 2143, such as R-G, from its velocity and acceleration at both ends."""
    ends = [
        np.abs(verb([0.0, 1.0])) > LAW_ROUNDING * np.abs(verb(UNIT_SAMPLES)).max()
        for verb in (law.velocity, law.acceleration)
    ]
    return "-".join(
        VDI_STATES[bool(velocity), bool(acceleration)] for velocity, acceleration in zip(*ends, strict=True)
    )


def rests_at_both_ends(law: Law) -> bool:
    """Whether the velocity of a law is zero at both ends, so that it makes no corner beside a dwell."""
    return not {"G", "B"} & set(vdi_motion_task(law))


def is_symmetric(law: Law) -> bool:
    """Whether a law is symmetric: s(1 − x) = 1 − s(x)."""
    return bool(
        np.abs(law.displacement(UNIT_SAMPLES) + law.displacement(1.0 - UNIT_SAMPLES) - 1.0).max() <= LAW_ROUNDING
    )

"""The SCCA family of laws: sine–constant–cosine acceleration.

In the first half of the stroke the acceleration rises as a quarter sine over b/2, is constant (A) over c/2, and
falls as a cosine over d/2. A share e of the stroke at constant velocity may follow. The second half mirrors the
first: s(1 − x) = 1 − s(x). With p = b + c + d and p + e = 1:

    A = 1/{[(π² − 8)(b² − d²) − 2π(π − 2)·b·p + π²p²]/(4π²) + V·e},   V = (b + d)/π + c/2

The peaks are V·A of velocity, A of acceleration, and the larger of πA/b and πA/d of jerk. With b = 0 the
acceleration jumps at the ends; with d = 0 it jumps after the constant part. The family includes parabolic
(b, c, d = 0, 1, 0), harmonic (0, 0, 1) and cycloidal motion (½, 0, ½).

Source: Norton, Cam Design and Manufacturing Handbook, ch. 3.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import angle_minus_sine
from camopt.model.motion.law import fold_to_half

Verb = Callable[[FloatArray, float], FloatArray]
"""A derivative in a piece, from the distance t to its start and its length, for a largest acceleration of 1."""


def _quarter_frequency(length: float) -> float:
    """Angular frequency of a quarter sine."""
    return np.pi / 2 / length


RAMP: tuple[Verb, ...] = (
    lambda t, length: angle_minus_sine(_quarter_frequency(length) * t) / _quarter_frequency(length) ** 2,
    lambda t, length: 2.0 * np.sin(_quarter_frequency(length) / 2 * t) ** 2 / _quarter_frequency(length),
    lambda t, length: np.sin(_quarter_frequency(length) * t),
    lambda t, length: _quarter_frequency(length) * np.cos(_quarter_frequency(length) * t),
)
CONSTANT: tuple[Verb, ...] = (
    lambda t, _: t * t / 2,
    lambda t, _: t,
    lambda t, _: np.ones_like(t),
    lambda t, _: np.zeros_like(t),
)
FALL: tuple[Verb, ...] = (
    lambda t, length: 2.0 * np.sin(_quarter_frequency(length) / 2 * t) ** 2 / _quarter_frequency(length) ** 2,
    lambda t, length: np.sin(_quarter_frequency(length) * t) / _quarter_frequency(length),
    # the cosine as a sine from the end, with full digits where it passes through zero
    lambda t, length: np.sin(_quarter_frequency(length) * (length - t)),
    lambda t, length: -_quarter_frequency(length) * np.sin(_quarter_frequency(length) * t),
)
ZERO: tuple[Verb, ...] = (lambda t, _: np.zeros_like(t),) * 4


class Quarter(NamedTuple):
    """A piece of the first half of a stroke, with s and v at its start."""

    verbs: tuple[Verb, ...]
    start: float
    length: float
    s: float
    v: float


@dataclass(frozen=True)
class SCCALaw:
    """A law from the shares (b, c, d, e) of its stroke: sine, constant acceleration, cosine, constant velocity.

    Shares are 0 or more, and b, c and d not all 0. If their sum is not 1, they are divided by it.
    """

    NAME: str
    shares: tuple[float, float, float, float]
    TITLE: str = "sine-constant-cosine acceleration"
    SOURCE: str = "the scene"

    @cached_property
    def _first_half_pieces(self) -> list[Quarter]:
        """The pieces of the first half that are not empty, for a largest acceleration of 1."""
        pieces, start, s, v = [], 0.0, 0.0, 0.0
        for verbs, share in zip((RAMP, CONSTANT, FALL, ZERO), self.shares, strict=True):
            if share > 0.0:
                length = share / sum(self.shares) / 2
                pieces.append(Quarter(verbs, start, length, s, v))
                gain_s, gain_v = (float(verb(np.array(length), length)) for verb in verbs[:2])
                start, s, v = start + length, s + v * length + gain_s, v + gain_v
        return pieces

    @cached_property
    def _largest_acceleration(self) -> float:
        """Largest acceleration, so that s is ½ at mid-stroke."""
        verbs, _, length, s, v = self._first_half_pieces[-1]
        return 0.5 / (s + v * length + float(verbs[0](np.array(length), length)))

    @cached_property
    def BREAKS(self) -> tuple[float, ...]:  # noqa: N802
        verbs, _, length, _, _ = self._first_half_pieces[-1]
        inner = [piece.start for piece in self._first_half_pieces[1:]]
        middle = [0.5] if verbs[2](np.array(length), length) != 0.0 else []
        return (0.0, *inner, *middle, *(1.0 - x for x in reversed(inner)), 1.0)

    def _first_half_derivative(self, folded_x: FloatArray, order: int) -> FloatArray:
        """A derivative in the first half of the stroke."""
        values = np.zeros_like(folded_x)
        for verbs, start, length, s, v in self._first_half_pieces:
            t = folded_x - start
            before = (s + v * t, v, 0.0, 0.0)[order]
            values = np.where(folded_x < start, values, before + verbs[order](t, length))
        return self._largest_acceleration * values

    def displacement(self, x: ArrayLike, /) -> FloatArray:
        near, mirrored = fold_to_half(x)
        s = self._first_half_derivative(near, 0)
        return np.where(mirrored, 1.0 - s, s)

    def velocity(self, x: ArrayLike, /) -> FloatArray:
        return self._first_half_derivative(fold_to_half(x)[0], 1)

    def acceleration(self, x: ArrayLike, /) -> FloatArray:
        near, mirrored = fold_to_half(x)
        a = self._first_half_derivative(near, 2)
        return np.where(mirrored, -a, a)

    def jerk(self, x: ArrayLike, /) -> FloatArray:
        return self._first_half_derivative(fold_to_half(x)[0], 3)


_NORTON = "Norton, Cam Design and Manufacturing Handbook, ch. 3"
modified_trapezoid = SCCALaw("modified-trapezoid", (0.25, 0.5, 0.25, 0.0), "modified trapezoid", _NORTON)
"""Peaks: velocity 2, acceleration 8π/(2 + π) = 4.8881, jerk 61.426."""
modified_sine = SCCALaw("modified-sine", (0.25, 0.0, 0.75, 0.0), "modified sine", _NORTON)
"""Peaks: velocity 4π/(4 + π) = 1.7596, acceleration 4π²/(4 + π) = 5.5280, jerk 69.466 (at the ends)."""
modified_constant_velocity = SCCALaw(
    "modified-constant-velocity",
    (0.125, 0.0, 0.375, 0.5),
    "modified constant velocity (50 %)",
    "Sankyo Seisakusho, Cam Terminology (MCV curve); its shares: docs.rs/dsmc, trajectory/mcv.rs",
)
"""A modified sine with half of the stroke at constant velocity. Peaks of velocity, acceleration and jerk: 1.2753,
8.0127, 201.38."""
cycloidal_constant_velocity = SCCALaw(
    "cycloidal-constant-velocity",
    (0.25, 0.0, 0.25, 0.5),
    "cycloidal, constant velocity (50 %)",
    "MechDesigner, MotionDesigner Reference: Cycloidal-CV50",
)
"""Half a cycloidal motion over a quarter of the stroke at each end. Peaks of velocity, acceleration and jerk: 4/3,
8π/3, 32π²/3."""

"""Waves of a measured profile: the harmonics of its deviation that noise does not explain.

They are taken off one after the other, the one that leaves the least first, until what is left is no more than
noise: of even points round the turn these are the harmonics of Fourier. Where points are missing no series of all
harmonics is known, and this one stays as small as the deviation is.

A wave of amplitude 2σ·√(ln(20·K)/n) is met by the noise σ of n points among K waves in one file of twenty.

A profile within ±t with at most n waves in a turn has slopes of at most n·t and n²·t, of first and second order
(``tolerances.turn``). So waves δ that are found are as steep and as curved as a profile within ±t may be
with n = max(√(max|δ''|/t), max|δ'|/t) waves: k waves of amplitude a count as k·√(a/t) if they are lower than t.

Sources: S. Mallat, Z. Zhang, Matching pursuits with time-frequency dictionaries, 1993; Rayleigh's distribution of
amplitudes of noise.
"""

from math import inf, log, sqrt
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray

MOST_HARMONICS = 120
POINTS_PER_WAVE = 4
"""Points of a wave, at least."""
FILES_PER_FALSE_WAVE = 20.0
"""Files in which noise looks like a wave."""
LEAST_WAVE = 1e-5
"""mm: a lower one is that of the digits of a file."""
STEPS_PER_HARMONIC = 8
"""For each harmonic, at most."""


class ProfileWave(NamedTuple):
    """A harmonic of the deviation of a profile along its normal.

    Examples
    --------
    >>> turn = np.radians(np.arange(0, 360, 2))
    >>> rough = (20 + 0.01 * np.cos(7 * turn)) * np.exp(1j * turn)
    >>> points = camopt.MeasuredProfile(np.column_stack([rough.real, rough.imag]), "xy")
    >>> camopt.inspect(points, camopt.find_scene("bucket-valve")).waves[0].number > 0
    True
    """

    number: int
    """In a turn."""
    amplitude: float
    """mm."""


class ProfileHarmonics(NamedTuple):
    """Harmonics of a deviation at cam angles, rad: amplitudes with their phases, by number from 0."""

    angles: FloatArray
    coefficients: ComplexArray

    @property
    def waves(self) -> tuple[ProfileWave, ...]:
        """From the second harmonic on, the largest first."""
        sizes = np.abs(self.coefficients)
        numbers = [int(k) for k in np.argsort(-sizes, kind="stable") if k > 1 and sizes[k]]
        return tuple(ProfileWave(k, float(sizes[k])) for k in numbers)

    def wave_count_within(self, zone: float) -> float:
        """With how many waves in a turn a profile within ±zone, mm, has slopes as these have at the points."""
        numbers = np.arange(self.coefficients.size)
        turned = np.exp(1j * np.outer(self.angles, numbers))
        slope, bend = (
            float(np.abs((turned @ (numbers**k * (1j) ** k * self.coefficients)).real).max()) for k in (1, 2)
        )
        return max(sqrt(bend / zone), slope / zone) if zone else inf if bend else 0.0


def find_waves(angles: FloatArray, off: FloatArray, noise: float) -> ProfileHarmonics:
    """The harmonics of deviations, mm, at cam angles, rad, that their noise does not explain."""
    most = min(MOST_HARMONICS, off.size // POINTS_PER_WAVE)
    turned = np.outer(np.arange(most + 1), angles)
    cosine, sine = np.cos(turned), np.sin(turned)
    cc, cs, ss = (np.sum(a * b, axis=1) for a, b in ((cosine, cosine), (cosine, sine), (sine, sine)))
    ss[0] = 1.0  # a mean has no sine
    least = max(noise * sqrt(2.0 * log(FILES_PER_FALSE_WAVE * most)), LEAST_WAVE * sqrt(off.size / 2.0))
    rest, parts = off.copy(), np.zeros(most + 1, dtype=complex)
    for _ in range(STEPS_PER_HARMONIC * most):
        c, s = cosine @ rest, sine @ rest
        a, b = ((ss * c - cs * s) / (cc * ss - cs**2), (cc * s - cs * c) / (cc * ss - cs**2))
        k = int(np.argmax(a * c + b * s))
        if (a * c + b * s)[k] <= least**2:
            break
        parts[k] += a[k] - 1j * b[k]
        rest -= a[k] * cosine[k] + b[k] * sine[k]
    parts[np.abs(parts) <= least * sqrt(2.0 / off.size)] = 0.0
    return ProfileHarmonics(angles, parts)

"""Waves of a measured profile: harmonics of its deviation that noise does not explain.

They are subtracted one after the other, always the harmonic that leaves the least, until the rest is noise. For
equally spaced points these are the Fourier harmonics. With missing points, a series of all harmonics is unknown,
and this series stays as small as the deviation is.

Noise σ of n points has a wave of the amplitude 2σ·√(ln(20·K)/n) among K waves in one of twenty files.

A profile within ±t with at most n waves in a turn has slopes of at most n·t and n²·t, of first and second order
(``tolerances.turn``). So waves δ are as steep and as curved as a profile within ±t with
n = max(√(max|δ''|/t), max|δ'|/t) waves. k waves of amplitude a count as k·√(a/t) if a is less than t.

Sources: S. Mallat, Z. Zhang, Matching pursuits with time-frequency dictionaries, 1993; Rayleigh's distribution of
amplitudes of noise.
"""

from math import inf, log, sqrt
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray

MOST_HARMONICS = 120
POINTS_PER_WAVE = 4
"""Least number of points of a wave."""
FILES_PER_FALSE_WAVE = 20.0
"""Number of files with one false wave of noise."""
LEAST_WAVE = 1e-5
"""Smaller waves come from the digits of a file [mm]."""
STEPS_PER_HARMONIC = 8
"""Most subtractions per harmonic."""


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
    """Number of waves in a turn."""
    amplitude: float
    """Amplitude [mm]."""


class ProfileHarmonics(NamedTuple):
    """Harmonics of a deviation at cam angles [rad]: complex amplitudes, by number from 0."""

    angles: FloatArray
    coefficients: ComplexArray

    @property
    def waves(self) -> tuple[ProfileWave, ...]:
        """Waves from the second harmonic on, the largest first."""
        sizes = np.abs(self.coefficients)
        numbers = [int(k) for k in np.argsort(-sizes, kind="stable") if k > 1 and sizes[k]]
        return tuple(ProfileWave(k, float(sizes[k])) for k in numbers)

    def equivalent_wave_count(self, zone_mm: float) -> float:
        """Number of waves in a turn with which a profile within ±zone [mm] is as steep and curved at the points."""
        numbers = np.arange(self.coefficients.size)
        exponentials = np.exp(1j * np.outer(self.angles, numbers))
        slope, curvature = (
            float(np.abs((exponentials @ (numbers**k * (1j) ** k * self.coefficients)).real).max()) for k in (1, 2)
        )
        return max(sqrt(curvature / zone_mm), slope / zone_mm) if zone_mm else inf if curvature else 0.0


def significant_harmonics(angles: FloatArray, deviations: FloatArray, noise: float) -> ProfileHarmonics:
    """Harmonics of deviations [mm] at cam angles [rad] that noise does not explain."""
    most_harmonics = min(MOST_HARMONICS, deviations.size // POINTS_PER_WAVE)
    multiples = np.outer(np.arange(most_harmonics + 1), angles)
    cosine, sine = np.cos(multiples), np.sin(multiples)
    cc, cs, ss = (np.sum(a * b, axis=1) for a, b in ((cosine, cosine), (cosine, sine), (sine, sine)))
    ss[0] = 1.0  # a mean has no sine
    least_norm = max(
        noise * sqrt(2.0 * log(FILES_PER_FALSE_WAVE * most_harmonics)), LEAST_WAVE * sqrt(deviations.size / 2.0)
    )
    rest, parts = deviations.copy(), np.zeros(most_harmonics + 1, dtype=complex)
    for _ in range(STEPS_PER_HARMONIC * most_harmonics):
        c, s = cosine @ rest, sine @ rest
        a, b = ((ss * c - cs * s) / (cc * ss - cs**2), (cc * s - cs * c) / (cc * ss - cs**2))
        k = int(np.argmax(a * c + b * s))
        if (a * c + b * s)[k] <= least_norm**2:
            break
        parts[k] += a[k] - 1j * b[k]
        rest -= a[k] * cosine[k] + b[k] * sine[k]
    parts[np.abs(parts) <= least_norm * sqrt(2.0 / deviations.size)] = 0.0
    return ProfileHarmonics(angles, parts)

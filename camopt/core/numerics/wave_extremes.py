"""Extremes of waves (``numerics.oscillator``) over their panels, enclosed by branch and bound.

On an interval [c − ρ, c + ρ] of a panel's u, no value is above either of

    f(c) + |f′(c)|·ρ + M·ρ²/2,   M ≥ |f″| on it,
    P(c) + |P′(c)|·ρ + M_P·ρ²/2 + the amplitude of the vibration at its start,

with the polynomial P. The second bound serves intervals of many periods. Intervals that cannot exceed the best
value are dropped, the others are halved. Where the polynomial is constant (a dwell, a parabolic stroke), all
periods are alike, and the first two stationary points give the extreme at once.
"""

from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.oscillator import Wave

RELATIVE_ERROR = 1e-14  # relative to a bound of the wave's largest magnitude
MOST_INTERVALS = (
    1 << 20
)  # most intervals at once; above, rows are searched separately, and a single row keeps its bound
WAVE_HALVINGS = 64


class WaveExtreme(NamedTuple):
    """Largest value found in each row (rows,), and an upper bound, but for rounding."""

    value: FloatArray
    bound: FloatArray


def wave_maximum(wave: Wave) -> WaveExtreme:
    """Largest value of each row of a wave, with one-sided limits at the ends of panels."""
    value = np.max(wave.values_on_all_panels(np.array([-1.0, 1.0])), axis=(0, 2))
    value = np.maximum(value, np.max(_peak_where_polynomial_constant(wave), axis=1))
    scale = np.max(np.abs(wave.polynomial).sum(axis=0) + wave.amplitude, axis=1)
    bound = value.copy()
    row, panel = np.nonzero((wave.polynomial[1:] != 0.0).any(axis=0))
    flat = row * wave.phase.shape[1] + panel
    centre, radius = np.zeros(len(flat)), 1.0
    pieces = _WavePieces.from_wave(wave)
    for _ in range(WAVE_HALVINGS):
        at_centre, upper = pieces.values_and_upper_bounds(flat, centre, radius)
        owner = flat // wave.phase.shape[1]
        np.maximum.at(value, owner, at_centre)
        open_ = upper > value[owner] + RELATIVE_ERROR * scale[owner]
        np.maximum.at(bound, owner[~open_], upper[~open_])
        flat, centre = flat[open_], centre[open_]
        if not flat.size or 2 * flat.size > MOST_INTERVALS:
            break
        radius /= 2.0
        flat, centre = np.concatenate([flat, flat]), np.concatenate([centre - radius, centre + radius])
    rows = len(value)
    if flat.size and rows > 1:
        halves = [wave_maximum(wave.select_rows(part)) for part in (slice(rows // 2), slice(rows // 2, None))]
        return WaveExtreme(*(np.concatenate(ends) for ends in zip(*halves, strict=True)))
    if flat.size:
        np.maximum.at(bound, flat // wave.phase.shape[1], upper[open_])
    return WaveExtreme(value, np.maximum(bound, value))


def wave_minimum(wave: Wave) -> WaveExtreme:
    """Smallest value of each row of a wave, and its lower bound."""
    negative = wave_maximum(wave.times(-1.0))
    return WaveExtreme(-negative.value, -negative.bound)


def wave_peak_magnitude(wave: Wave) -> WaveExtreme:
    """Largest magnitude of each row of a wave, and its upper bound."""
    high, low = wave_maximum(wave), wave_maximum(wave.times(-1.0))
    return WaveExtreme(np.maximum(high.value, low.value), np.maximum(high.bound, low.bound))


def _peak_where_polynomial_constant(wave: Wave) -> FloatArray:
    """Peak vibration on panels with a constant polynomial, from two stationary points; −∞ elsewhere."""
    z, w = wave.damping, wave.damped_frequency_ratio
    across, along = w * wave.sine - z * wave.cosine, w * wave.cosine + z * wave.sine
    first = np.mod(np.arctan2(across, along), np.pi)
    values = []
    for phase in (first, first + np.pi):
        angle = phase / w
        free = np.exp(-z * angle) * (wave.cosine * np.cos(phase) + wave.sine * np.sin(phase))
        inside = (angle <= 2.0 * wave.phase) & ~(wave.polynomial[1:] != 0.0).any(axis=0)
        values.append(np.where(inside, wave.polynomial[0] + free, -np.inf))
    result: FloatArray = np.maximum(*values)
    return result


class _WavePieces(NamedTuple):
    """A wave with rows and panels in one axis, and bounds of second derivatives by u."""

    series: FloatArray
    cosine: FloatArray
    sine: FloatArray
    phase: FloatArray
    curved: FloatArray  # bound of the polynomial's second derivative
    damping: FloatArray
    frequency: FloatArray

    @classmethod
    def from_wave(cls, wave: Wave) -> "_WavePieces":
        series = wave.polynomial.reshape(len(wave.polynomial), -1)
        k = np.arange(len(series))[:, None]
        curved = np.sum(k * (k - 1) * np.abs(series), axis=0)
        flat = (wave.cosine.ravel(), wave.sine.ravel(), wave.phase.ravel())
        rates = (
            np.broadcast_to(rate, wave.phase.shape).ravel() for rate in (wave.damping, wave.damped_frequency_ratio)
        )
        return cls(series, *flat, curved, *rates)

    def values_and_upper_bounds(
        self, piece: FloatArray, centre: FloatArray, radius: float
    ) -> tuple[FloatArray, FloatArray]:
        """Values at the centres of intervals, and upper bounds over the intervals."""
        value, slope = self.series[-1, piece], np.zeros(len(piece))
        for row in self.series[-2::-1]:
            slope = slope * centre + value
            value = value * centre + row[piece]
        a, z, w = self.phase[piece], self.damping[piece], self.frequency[piece]
        cosine, sine = self.cosine[piece], self.sine[piece]
        angle = a * (centre + 1.0)
        decay, c, s = np.exp(-z * angle), np.cos(w * angle), np.sin(w * angle)
        free = decay * (cosine * c + sine * s)
        falling = a * decay * ((w * sine - z * cosine) * c - (w * cosine + z * sine) * s)
        amplitude = np.hypot(cosine, sine) * np.exp(-z * a * (centre - radius + 1.0))
        bend = 0.5 * radius**2
        curved = self.curved[piece]
        near = value + free + np.abs(slope + falling) * radius + (curved + a * a * amplitude) * bend
        far = value + np.abs(slope) * radius + curved * bend + amplitude
        return value + free, np.minimum(near, far)

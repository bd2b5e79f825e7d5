"""The response of a mass on a spring to a piecewise polynomial motion of its foot, in closed form.

With the motion z = x − y of the mass relative to its foot, r = ω_n/ω and derivatives by the cam angle:

    z″ + 2ζr·z′ + r²·z = −y″,   0 ≤ ζ < 1.

On each panel of half-width h, with u ∈ [−1, 1] and a = r·h, the response is a polynomial plus a free vibration,

    z(u) = Σ c_k·uᵏ + e^{−ζφ}(A·cos wφ + B·sin wφ),   φ = a(u + 1),   w = √(1 − ζ²)

(a ``Wave``), without time steps. Two forms of the first-order system keep the digits:

- stiff (r ≥ 1): the pair (z, p) with p = z′/r + 2ζz, driven by −y″/r; at a corner of y′, p jumps by −Δy′/r;
- soft (r < 1): the pair (x, p) with p = x′/r + 2ζz, driven by y itself, so that r → 0 leaves the mean of y.

Both are s′ = a(p − 2ζs + shift), p′ = drive − a·s in u. For a ≥ 2 the polynomial solution is computed downwards
from the highest power (a finite sum in 1/a). For a < 2 this would cancel, so it is computed upwards as a power
series. Against 50 digits, z has an error of 1e-13 of its largest value. If the motion has jumps, rounding of the
phase may raise it to 5e-16·r. Near resonance the error grows with the response.

Arrays are (rows, panels), polynomials (powers, rows, panels): a row is one value of r and of ζ, each (rows, 1).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import FloatArray, IntArray, Number

SERIES_PHASE = (
    2.0  # radians of free vibration to each side of a panel's centre, below which the power series is used
)
SERIES_TERMS = 40  # the next term is below 1e-18 of the largest, for every ζ < 1
LEFT_END = np.array([-1.0])
WHOLE_NUMBER = 4e-15  # relative distance below which r is a whole number but for rounding


def damped_frequency_ratio(damping: Any) -> Number:
    """w = √(1 − ζ²), the damped frequency divided by the undamped one."""
    return np.sqrt((1.0 - damping) * (1.0 + damping))


class Wave(NamedTuple):
    """Polynomials (powers, rows, panels) plus damped vibrations on panels."""

    polynomial: FloatArray
    cosine: FloatArray
    sine: FloatArray
    half_width: FloatArray
    phase: FloatArray  # a = r·h
    damping: FloatArray

    @property
    def damped_frequency_ratio(self) -> FloatArray:
        """w (rows, 1)."""
        return np.asarray(damped_frequency_ratio(self.damping))

    @property
    def amplitude(self) -> FloatArray:
        """Amplitude of the free vibration at the start of each panel."""
        return np.hypot(self.cosine, self.sine)

    def slope(self) -> "Wave":
        """The derivative by the cam angle."""
        ratio, w = self.phase / self.half_width, self.damped_frequency_ratio
        return self._replace(
            polynomial=polynomial.polyder(self.polynomial) / self.half_width,
            cosine=ratio * (w * self.sine - self.damping * self.cosine),
            sine=-ratio * (w * self.cosine + self.damping * self.sine),
        )

    def times(self, factor: FloatArray | float) -> "Wave":
        """The wave multiplied by a factor (rows, 1)."""
        return Wave(self.polynomial * factor, self.cosine * factor, self.sine * factor, *self[3:])

    def plus(self, other: "Wave") -> "Wave":
        """The sum with another wave on the same panels."""
        series = _add_polynomials(self.polynomial, other.polynomial)
        return Wave(series, self.cosine + other.cosine, self.sine + other.sine, *self[3:])

    def plus_polynomial(self, series: FloatArray) -> "Wave":
        """The sum with a polynomial, (powers, panels) or (powers, rows, panels)."""
        series = np.broadcast_to(series if series.ndim == 3 else series[:, None], (len(series), *self.phase.shape))
        return self._replace(polynomial=_add_polynomials(self.polynomial, series))

    def select_rows(self, index: Any) -> "Wave":
        """Some of the rows."""
        return Wave(self.polynomial[:, index], *(part[index] for part in self[1:]))

    def values_on_all_panels(self, u: FloatArray) -> FloatArray:
        """Values (points, rows, panels) at u ∈ [−1, 1] (points,) of all panels."""
        return self._values_at_places(np.asarray(u, dtype=float)[:, None, None])

    def values_on_panels(self, panel: IntArray, u: FloatArray) -> FloatArray:
        """Values (rows, points) at points u (points,) of panels (points,)."""
        series, cosine, sine, half_width, phase = (part[..., panel] for part in self[:5])
        return Wave(series, cosine, sine, half_width, phase, self.damping)._values_at_places(u)

    def _values_at_places(self, u: FloatArray) -> FloatArray:
        angle = self.phase * (u + 1.0)
        phase = self.damped_frequency_ratio * angle
        free = np.exp(-self.damping * angle) * (self.cosine * np.cos(phase) + self.sine * np.sin(phase))
        result: FloatArray = _polynomial_values(self.polynomial, u) + free
        return result


def _add_polynomials(one: FloatArray, other: FloatArray) -> FloatArray:
    """Sum of two polynomials of any degrees."""
    longer, shorter = (one, other) if len(one) >= len(other) else (other, one)
    total = longer.copy()
    total[: len(shorter)] += shorter
    return total


def _polynomial_values(series: FloatArray, u: FloatArray) -> FloatArray:
    value: FloatArray = series[-1] + np.zeros_like(u)
    for row in series[-2::-1]:
        value = value * u + row
    return value


def is_resonant(frequency_ratio: Any, damping: Any) -> Any:
    """Whether a harmonic of the turn meets the natural frequency of an undamped train: no bounded response."""
    whole = np.maximum(np.rint(frequency_ratio), 1.0)
    return (np.asarray(damping) == 0.0) & (np.abs(frequency_ratio - whole) <= WHOLE_NUMBER * frequency_ratio)


def periodic_response(
    motion: FloatArray, half_width: FloatArray, slope_jumps: FloatArray, frequency_ratio: Any, damping: Any
) -> Wave:
    """Periodic z over one turn for each r and ζ, which are arrays (rows, 1) or numbers.

    ``motion`` (powers, panels) is y in u. ``half_width`` (panels,) adds up to half a turn. ``slope_jumps``
    (panels,) is the jump of y′ at the start of each panel. r > 0 must not be resonant (``is_resonant``).
    """
    frequency_ratio, damping = (
        np.reshape(number, (-1, 1)) for number in np.broadcast_arrays(frequency_ratio, damping)
    )
    h = np.broadcast_to(half_width, (len(frequency_ratio), half_width.size))
    phase, soft, moved = frequency_ratio * h, frequency_ratio < 1.0, motion[:, None]
    with np.errstate(over="ignore"):  # in soft rows, which are replaced below
        shift, drive, kicks = _stiff_train_shift_drive_and_kicks(motion, phase, slope_jumps / frequency_ratio)
    shift = np.where(soft, 2.0 * damping * moved, shift)
    drive, kicks = np.where(soft, phase * moved, drive), np.where(soft, 0.0, kicks)
    solution = _polynomial_solution_by_panel(shift, drive, phase, damping)
    # start on the polynomial: from rest there would be a vibration, whose removal costs digits of the phase
    smooth = _polynomial_values(solution[0][:, :, 0], LEFT_END), _polynomial_values(solution[1][:, :, 0], LEFT_END)
    *_, end = _free_vibration_at_panel_starts(solution, phase, kicks, damping, smooth)
    short = _start_correction_to_close_turn(
        (end[0] - smooth[0], end[1] - smooth[1]), 2.0 * phase.sum(axis=1), damping[:, 0]
    )
    wave = _assemble_wave(solution, h, phase, kicks, damping, (smooth[0] + short[0], smooth[1] + short[1]))
    return wave.plus_polynomial(np.where(soft, -moved, 0.0)) if soft.any() else wave


def response_from_rest(
    motion: FloatArray, half_width: FloatArray, slope_jumps: FloatArray, frequency_ratio: FloatArray, damping: Any
) -> Wave:
    """z from rest, for each r in ``frequency_ratio`` (rows, 1), with ``half_width`` (rows, panels)."""
    phase, damping = frequency_ratio * half_width, np.full_like(frequency_ratio, damping)
    shift, drive, kicks = _stiff_train_shift_drive_and_kicks(motion, phase, slope_jumps / frequency_ratio)
    solution = _polynomial_solution_by_panel(shift, drive, phase, damping)
    start = (np.zeros(len(frequency_ratio)), np.zeros(len(frequency_ratio)))
    return _assemble_wave(solution, half_width, phase, kicks, damping, start)


StatePair = tuple[FloatArray, FloatArray]


def _stiff_train_shift_drive_and_kicks(
    motion: FloatArray, phase: FloatArray, jumps: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    drive = np.zeros((len(motion), *phase.shape))
    drive[:-2] = -polynomial.polyder(motion, 2)[:, None] / phase
    return np.zeros_like(drive), drive, -jumps


def _polynomial_solution_by_panel(
    shift_coefficients: FloatArray, drive_coefficients: FloatArray, phase: FloatArray, damping: FloatArray
) -> StatePair:
    """Polynomial solution of s′ = a(p − 2ζs + shift), p′ = drive − a·s on each panel."""
    degree, shape = len(drive_coefficients) - 1, (SERIES_TERMS + 1, *phase.shape)
    s, p = np.zeros(shape), np.zeros(shape)
    a = np.maximum(phase, SERIES_PHASE)
    for k in range(degree, -1, -1):
        s[k] = (drive_coefficients[k] - (k + 1) * p[k + 1]) / a
        p[k] = (k + 1) * s[k + 1] / a + 2.0 * damping * s[k] - shift_coefficients[k]
    up, along = np.zeros(shape), np.zeros(shape)
    a = np.minimum(phase, SERIES_PHASE)
    for k in range(SERIES_TERMS):
        driven = k <= degree
        up[k + 1] = a * (along[k] - 2.0 * damping * up[k] + (shift_coefficients[k] if driven else 0.0)) / (k + 1)
        along[k + 1] = ((drive_coefficients[k] if driven else 0.0) - a * up[k]) / (k + 1)
    short = phase < SERIES_PHASE
    return np.where(short, up, s), np.where(short, along, p)


def _free_vibration_at_panel_starts(
    forced_solution: StatePair, phase: FloatArray, kicks: FloatArray, damping: FloatArray, start: StatePair
) -> tuple[FloatArray, FloatArray, StatePair]:
    """Free vibration (s, p) at the start of each panel, and the state after the last panel."""
    (s, p), w = start, damped_frequency_ratio(damping)
    ends = np.array([-1.0, 1.0])[:, None, None]
    (s_left, s_right), (p_left, p_right) = (_polynomial_values(series[:, None], ends) for series in forced_solution)
    decay, cosine, sine = np.exp(-2.0 * damping * phase), np.cos(2.0 * w * phase), np.sin(2.0 * w * phase) / w
    leaning = damping * sine
    free_s, free_p = np.empty_like(phase), np.empty_like(phase)
    for k in range(phase.shape[1]):
        fs, fp = s - s_left[:, k], p + kicks[:, k] - p_left[:, k]
        free_s[:, k], free_p[:, k] = fs, fp
        c, d, e = cosine[:, k], leaning[:, k], decay[:, k]
        s = e * ((c - d) * fs + sine[:, k] * fp) + s_right[:, k]
        p = e * ((c + d) * fp - sine[:, k] * fs) + p_right[:, k]
    return free_s, free_p, (s, p)


def _start_correction_to_close_turn(gap_at_end: StatePair, angle: FloatArray, damping: FloatArray) -> StatePair:
    """Correction of the start with which the turn returns to it: (1 − E)·correction = gap, E the free vibration.

    The determinant is |1 − e^{λφ}|², a sum of squares; 1 − e^{−ζφ}·cos wφ is formed without cancellation.
    """
    w = damped_frequency_ratio(damping)
    decay = np.exp(-damping * angle)
    sine = decay * np.sin(w * angle) / w
    gap = 2.0 * decay * np.sin(w * angle / 2.0) ** 2 - np.expm1(-damping * angle)
    determinant = gap**2 + (w * sine) ** 2
    s, p = gap_at_end
    return (
        ((gap - damping * sine) * s + sine * p) / determinant,
        ((gap + damping * sine) * p - sine * s) / determinant,
    )


def _assemble_wave(
    solution: StatePair,
    half_width: FloatArray,
    phase: FloatArray,
    kicks: FloatArray,
    damping: FloatArray,
    start: StatePair,
) -> Wave:
    s, p, _ = _free_vibration_at_panel_starts(solution, phase, kicks, damping, start)
    sine = (p - damping * s) / damped_frequency_ratio(damping)
    series = solution[0]
    used = np.flatnonzero(series.any(axis=(1, 2)))
    return Wave(series[: used[-1] + 1 if used.size else 1], s, sine, half_width, phase, damping)

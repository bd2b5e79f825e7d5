"""Cam angles for points of a cam: in even steps, or as close as a chord needs."""

from collections.abc import Callable
from math import floor, isfinite
from numbers import Real

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import ComplexArray, FloatArray

MOST_POINTS = 1_000_000
WIDEST_STEP = 10.0  # deg: the coarsest spacing
NARROWEST_STEP = 1e-7  # deg: at a jump of the velocity the curves have a gap, however close the points are
CHORD_SHARES = np.linspace(0.0, 1.0, 9)[1:-1]  # checked places of an arc between its ends

CurvePoints = Callable[[FloatArray], list[ComplexArray]]
"""A function from cam angles [deg] to points of curves [mm]."""


def angles_in_steps(step: float) -> FloatArray:
    """Cam angles from 0 to 360 in even steps [deg]; the last step is shorter if they do not divide the turn."""
    if not (isinstance(step, Real) and isfinite(step) and 360.0 / MOST_POINTS <= step <= 360.0):
        raise BadInput([Mistake("camopt", "step", step, f"from {360.0 / MOST_POINTS:g} to 360 deg")])
    count = floor(360.0 / step * (1.0 + 1e-12))
    return np.append(step * np.arange(count), [step * count, 360.0] if 360.0 - step * count > 1e-9 else [360.0])


def angles_within_chord(chord: float, stroke_starts_deg: FloatArray, curves: CurvePoints) -> FloatArray:
    """Cam angles from 0 to 360 [deg], so close that chords deviate from the curves by at most ``chord`` [mm].

    Arcs are halved until the curve is close enough at seven places between the ends. The angles include
    ``stroke_starts_deg``, at which the motion changes.
    """
    if not (isinstance(chord, Real) and isfinite(chord) and chord > 0.0):
        raise BadInput([Mistake("camopt", "chord", chord, "above 0 mm")])
    even = np.linspace(0.0, 360.0, round(360.0 / WIDEST_STEP) + 1)
    even = even[np.abs(even[:, None] - stroke_starts_deg).min(axis=1, initial=np.inf) > NARROWEST_STEP]
    angles = np.unique(np.concatenate([even, stroke_starts_deg]))
    pending = np.ones(angles.size - 1, dtype=bool)
    while pending.any():
        ends = np.array([angles[:-1][pending], angles[1:][pending]])
        sagitta = _largest_sagitta(ends, curves)
        wide = (sagitta > chord) & (ends[1] - ends[0] > NARROWEST_STEP)
        more = np.sqrt(sagitta[wide] / (4.0 * chord)).sum()  # each half has a quarter of the sagitta
        if angles.size + more > MOST_POINTS:
            raise BadInput(
                [Mistake("camopt", "chord", chord, f"larger: this chord needs more than {MOST_POINTS:,} points")]
            )
        halved = (ends.sum(axis=0) / 2)[wide]
        every = np.concatenate([angles, halved])
        pending = np.isin(np.sort(every)[:-1], np.concatenate([ends[0][wide], halved]))
        angles = np.sort(every)
    return angles


def _largest_sagitta(ends: FloatArray, curves: CurvePoints) -> FloatArray:
    """Largest distance of the curves from the chords of arcs [mm]; (2, arcs) to (arcs,)."""
    low, high = ends
    angles = low + (high - low) * np.concatenate([[0.0], CHORD_SHARES, [1.0]])[:, None]
    furthest = np.zeros(low.size)
    for points in curves(angles.reshape(-1)):
        first, *between, last = points.reshape(angles.shape)
        along = last - first
        length = np.abs(along)
        unit = np.where(length > 0.0, along / np.where(length > 0.0, length, 1.0), 0.0)
        offsets = [p - first - unit * np.clip(((p - first) * unit.conjugate()).real, 0.0, length) for p in between]
        furthest = np.maximum(furthest, np.abs(offsets).max(axis=0))
    return furthest

"""Residual vibration of free laws: a second-order cone, since the response is linear in the motion.

The steady response of a linear train is linear in the motion, and so in the coefficients of free splines. At the
start of a dwell its free vibration has the amplitude A = √(a² + b²), with a and b linear in the coefficients
(``effects.vibration_extremes``). The largest A over the dwells is convex.

The rows of a and b come from the response itself, by raising one coefficient at a time. So there is no second model
of the train, and the rows are exact at any speed. The lower bound for any motion is 0.
"""

from functools import lru_cache
from math import pi
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.oscillator import is_resonant
from camopt.model.effects.effect import Setup
from camopt.model.effects.vibration import steady_vibration_wave
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import DWELL, Stroke
from camopt.solve.synthesis.splines import Splines

RESIDUAL_TERM = "residual_vibration"


def train_frequency_and_damping(setup: Setup) -> tuple[float, float] | None:
    """Frequency ratio ω_n/ω and damping ratio of the train; None if one is missing, or at resonance."""
    frequency, damping = setup.dynamics.natural_frequency, setup.dynamics.damping_ratio
    if frequency is None or setup.omega is None:
        return None
    ratio = 2.0 * pi * frequency / setup.omega
    return None if is_resonant(ratio, damping) else (ratio, damping)


class ResidualResponse(NamedTuple):
    """a and b at the start of each dwell (dwells, 2) [mm or rad], linear in the free strokes' coefficients."""

    rows: tuple[FloatArray, ...]
    """One matrix for each free stroke (dwells, 2, coefficients)."""
    constant: FloatArray


@lru_cache(maxsize=8)
def residual_response(
    strokes: tuple[Stroke, ...], splines: tuple[Splines, ...], scale: float, ratio: float, damping: float
) -> ResidualResponse:
    """Vibration left by free strokes with their splines; ``scale`` is the displacement unit of moves."""
    free = [number for number, stroke in enumerate(strokes) if stroke.is_law_replaceable]
    basis = dict(zip(free, splines, strict=True))
    start = {number: np.zeros(basis[number].count) for number in free}
    for number, coefficients in start.items():  # zero except at the ends of the stroke
        stroke = strokes[number]
        coefficients[[0, -1]] = (stroke.low / scale, stroke.high / scale) if stroke.is_move else (0.0, 1.0)

    def vibration_states_at_dwells(coefficients: dict[int, FloatArray]) -> FloatArray:
        turn = Programme(
            tuple(
                basis[n].stroke_with_law(stroke, "", coefficients[n], scale)
                if stroke.is_law_replaceable
                else stroke
                for n, stroke in enumerate(strokes)
            )
        )
        wave, starts = steady_vibration_wave(turn, ratio, damping), turn.piece_starts
        pieces = [int(np.abs(starts - stroke.start).argmin()) for stroke in strokes if stroke.kind == DWELL]
        dwells = turn.table.first_panel[pieces]
        return np.stack([wave.cosine[0, dwells], wave.sine[0, dwells]], axis=1)

    whole = constant = vibration_states_at_dwells(start)
    rows = []
    for number in free:
        count, following = basis[number].count, (number + 1) % len(strokes)
        response = np.zeros((*whole.shape, count))
        for column in range(1, count - 1):
            response[..., column] = (
                vibration_states_at_dwells(start | {number: start[number] + np.eye(count)[column]}) - whole
            )
        if strokes[number].is_move and strokes[following].is_move and following in basis and following != 0:
            raised = {number: start[number] + np.eye(count)[-1]}
            raised[following] = start[following] + np.eye(basis[following].count)[0]
            response[..., -1] = vibration_states_at_dwells(start | raised) - whole
            constant = constant - response[..., -1] * start[number][-1]
        rows.append(response)
    return ResidualResponse(tuple(rows), constant)

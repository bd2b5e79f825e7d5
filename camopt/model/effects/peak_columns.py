"""Columns of quantities that are peaks: enclosed extremes over the continuous turn."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.extremes import Extremes
from camopt.core.numerics.state import State
from camopt.model.effects.effect import EnclosedValue, EvaluationBlock
from camopt.model.effects.known_extremes import overall_extreme
from camopt.model.effects.peak import Peak


class DesignExtremes(NamedTuple):
    """The extremes of designs (designs,), with the widths of their enclosures, cam angles and curves."""

    value: FloatArray
    width: FloatArray
    where: FloatArray
    number: FloatArray
    """The number of the curve, in the order of the peak."""


def infinite_extremes(case: EvaluationBlock, peak: Peak) -> DesignExtremes:
    """Infinite extremes for all designs."""
    count, outwards = len(case.designs), -1.0 if peak.goal == LEAST else 1.0
    return DesignExtremes(np.full(count, outwards * np.inf), *np.zeros((3, count)))


def peak_extremes(
    case: EvaluationBlock,
    peak: Peak,
    sound_designs: Any = True,
    *,
    exact_angles: bool = False,
    floor: float = -np.inf,
) -> DesignExtremes:
    """Extremes of all curves of a peak.

    Infinite for designs that are not ``sound_designs``, and if jumps make them so.

    Cam angles are as exact as values only if ``exact_angles``. ``floor`` is that of ``Precision``.
    """
    count = len(case.designs)
    if sound_designs is True and count and not peak.jumps(case.programme):
        return _extremes_of_sound_designs(case, peak, exact_angles=exact_angles, floor=floor)
    columns = infinite_extremes(case, peak)
    index = np.flatnonzero(np.broadcast_to(sound_designs, count) & (not peak.jumps(case.programme)))
    if index.size:
        part = replace(case, designs=case.designs.take(index), known_extremes=case.known_extremes.take(index))
        for column, values in zip(
            columns, _extremes_of_sound_designs(part, peak, exact_angles=exact_angles, floor=floor), strict=True
        ):
            column[index] = values
    return columns


def _extremes_of_sound_designs(
    case: EvaluationBlock, peak: Peak, *, exact_angles: bool, floor: float
) -> DesignExtremes:
    """Extremes of a peak's curves, for designs that all can bear their load."""
    if peak.at_ends and not exact_angles:
        ((make, _),) = peak.curves
        curve = make(case.designs, case.programme)
        ends = [
            curve_value(curve, ..., State(level, 0.0, 0.0, 0.0))
            for level in case.programme.lowest_and_highest_displacement
        ]
        value = (np.minimum if peak.goal == LEAST else np.maximum)(*ends)
        return DesignExtremes(value, *np.zeros((3, len(case.designs))))
    numbers = [k for k, (_, kinds) in enumerate(peak.curves) if case.programme.has_kinds(kinds)]
    extremes = []
    for k in numbers:
        make, kinds = peak.curves[k]
        answers = case.extremes(make, [(kinds, peak.goal)], exact_angles=exact_angles, floor=floor)
        extremes.append(Extremes(*(values[0] for values in answers)))
    (value, where, width), number = overall_extreme(extremes, peak.goal)
    return DesignExtremes(value, width, where, np.array(numbers, float)[number])


def column_from_extremes(case: EvaluationBlock, peak: Peak, extreme: DesignExtremes) -> EnclosedValue:
    """The column of a peak, from its extremes."""
    by = -extreme.width if peak.goal == LEAST else extreme.width
    with np.errstate(divide="ignore"):
        value = np.asarray(peak.scale.quantity_from_extreme(extreme.value, case.designs))
    scale = np.abs(value) if peak.unit is None else np.maximum(np.abs(value), peak.unit(case.designs))
    return EnclosedValue(value, peak.scale.quantity_change(extreme.value, by, case.designs), scale)


def peak_column(case: EvaluationBlock, peak: Peak, sound_designs: Any = True) -> EnclosedValue:
    """The column of a peak; infinite for designs that are not ``sound_designs``."""
    return column_from_extremes(case, peak, peak_extremes(case, peak, sound_designs))


def largest_and_least_columns(
    case: EvaluationBlock, largest: Peak, least: Peak
) -> tuple[EnclosedValue, EnclosedValue]:
    """Columns of the largest and the least value of one curve, with errors relative to the larger magnitude."""
    ((make, kinds),) = largest.curves
    ends = case.extremes(make, [(kinds, largest.goal), (kinds, least.goal)])
    columns = []
    for k, peak in enumerate((largest, least)):
        extreme = DesignExtremes(ends.value[k], ends.width[k], ends.where[k], np.zeros(len(case.designs)))
        columns.append(
            column_from_extremes(
                case, peak, infinite_extremes(case, peak) if peak.jumps(case.programme) else extreme
            )
        )
    scale = np.maximum(*(np.abs(column.value) for column in columns))
    above, below = (column._replace(scale=scale) for column in columns)
    return above, below

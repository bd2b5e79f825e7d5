"""The columns of quantities that are peaks: their extremes over the continuous turn, enclosed."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.extremes import Extremes
from camopt.core.numerics.state import State
from camopt.model.effects.effect import EnclosedValue, EvaluationBlock
from camopt.model.effects.known_extremes import overall_extreme
from camopt.model.effects.peak import Peak


class DesignExtremes(NamedTuple):
    """The extreme of each design (designs,), its enclosure, its cam angle and its curve."""

    value: FloatArray
    width: FloatArray
    where: FloatArray
    number: FloatArray
    """Of the curve, in the order of the peak's."""


def infinite_extremes(case: EvaluationBlock, peak: Peak) -> DesignExtremes:
    """An extreme that is infinite for all designs."""
    count, outwards = len(case.designs), -1.0 if peak.goal == LEAST else 1.0
    return DesignExtremes(np.full(count, outwards * np.inf), *np.zeros((3, count)))


def peak_extremes(
    case: EvaluationBlock, peak: Peak, sound: Any = True, *, located: bool = False, floor: float = -np.inf
) -> DesignExtremes:
    """The extreme of all curves of a peak; infinite for designs that are not sound, and where jumps make it so.

    Its cam angle is as exact as its value only if ``located``. ``floor`` is that of ``Precision``.
    """
    count = len(case.designs)
    if sound is True and count and not peak.jumps(case.programme):
        return _sound_extremes(case, peak, located=located, floor=floor)
    whole = infinite_extremes(case, peak)
    index = np.flatnonzero(np.broadcast_to(sound, count) & (not peak.jumps(case.programme)))
    if index.size:
        some = replace(case, designs=case.designs.take(index), known_extremes=case.known_extremes.take(index))
        for column, values in zip(whole, _sound_extremes(some, peak, located=located, floor=floor), strict=True):
            column[index] = values
    return whole


def _sound_extremes(case: EvaluationBlock, peak: Peak, *, located: bool, floor: float) -> DesignExtremes:
    """The same of designs that all are sound."""
    if peak.at_ends and not located:
        ((make, _),) = peak.curves
        made = make(case.designs, case.programme)
        ends = [value_of(made, ..., State(level, 0.0, 0.0, 0.0)) for level in case.programme.levels]
        value = (np.minimum if peak.goal == LEAST else np.maximum)(*ends)
        return DesignExtremes(value, *np.zeros((3, len(case.designs))))
    numbers = [k for k, (_, kinds) in enumerate(peak.curves) if case.programme.has_kinds(kinds)]
    each = []
    for k in numbers:
        make, kinds = peak.curves[k]
        found = case.extremes(make, [(kinds, peak.goal)], located=located, floor=floor)
        each.append(Extremes(*(values[0] for values in found)))
    (value, where, width), number = overall_extreme(each, peak.goal)
    return DesignExtremes(value, width, where, np.array(numbers, float)[number])


def as_column(case: EvaluationBlock, peak: Peak, extreme: DesignExtremes) -> EnclosedValue:
    """The quantity from its extreme."""
    by = -extreme.width if peak.goal == LEAST else extreme.width
    with np.errstate(divide="ignore"):
        value = np.asarray(peak.scale.quantity(extreme.value, case.designs))
    scale = np.abs(value) if peak.unit is None else np.maximum(np.abs(value), peak.unit(case.designs))
    return EnclosedValue(value, peak.scale.change(extreme.value, by, case.designs), scale)


def peak_column(case: EvaluationBlock, peak: Peak, sound: Any = True) -> EnclosedValue:
    """A quantity that is a peak, of all designs of a case."""
    return as_column(case, peak, peak_extremes(case, peak, sound))


def range_columns(case: EvaluationBlock, largest: Peak, least: Peak) -> tuple[EnclosedValue, EnclosedValue]:
    """The largest and the least value of one curve, with errors relative to the larger magnitude of both."""
    ((make, kinds),) = largest.curves
    found = case.extremes(make, [(kinds, largest.goal), (kinds, least.goal)])
    columns = []
    for k, peak in enumerate((largest, least)):
        extreme = DesignExtremes(found.value[k], found.width[k], found.where[k], np.zeros(len(case.designs)))
        columns.append(
            as_column(case, peak, infinite_extremes(case, peak) if peak.jumps(case.programme) else extreme)
        )
    scale = np.maximum(*(np.abs(column.value) for column in columns))
    above, below = (column._replace(scale=scale) for column in columns)
    return above, below

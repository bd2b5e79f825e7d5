"""The columns of quantities that are peaks: their extremes over the continuous turn, enclosed."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.extremes import Extremes
from camopt.core.numerics.state import State
from camopt.model.effects.case import Bounded, Case
from camopt.model.effects.known import furthest
from camopt.model.effects.peak import Peak


class ExtremeOfEach(NamedTuple):
    """The extreme of each design (designs,), its enclosure, its cam angle and its curve."""

    value: FloatArray
    width: FloatArray
    where: FloatArray
    number: FloatArray
    """Of the curve, in the order of the peak's."""


def infinite(case: Case, peak: Peak) -> ExtremeOfEach:
    """An extreme that is infinite for all designs."""
    count, outwards = len(case.designs), -1.0 if peak.goal == LEAST else 1.0
    return ExtremeOfEach(np.full(count, outwards * np.inf), *np.zeros((3, count)))


def extreme_of(
    case: Case, peak: Peak, sound: Any = True, *, located: bool = False, floor: float = -np.inf
) -> ExtremeOfEach:
    """The extreme of all curves of a peak; infinite for designs that are not sound, and where jumps make it so.

    Its cam angle is as exact as its value only if ``located``. ``floor`` is that of ``Precision``.
    """
    count = len(case.designs)
    if sound is True and count and not peak.jumps(case.programme):
        return _of_sound(case, peak, located=located, floor=floor)
    whole = infinite(case, peak)
    index = np.flatnonzero(np.broadcast_to(sound, count) & (not peak.jumps(case.programme)))
    if index.size:
        some = replace(case, designs=case.designs.take(index), known=case.known.take(index))
        for column, values in zip(whole, _of_sound(some, peak, located=located, floor=floor), strict=True):
            column[index] = values
    return whole


def _of_sound(case: Case, peak: Peak, *, located: bool, floor: float) -> ExtremeOfEach:
    """The same of designs that all are sound."""
    if peak.at_ends and not located:
        ((make, _),) = peak.curves
        made = make(case.designs, case.programme)
        ends = [value_of(made, ..., State(level, 0.0, 0.0, 0.0)) for level in case.programme.levels]
        value = (np.minimum if peak.goal == LEAST else np.maximum)(*ends)
        return ExtremeOfEach(value, *np.zeros((3, len(case.designs))))
    numbers = [k for k, (_, kinds) in enumerate(peak.curves) if case.programme.has(kinds)]
    each = []
    for k in numbers:
        make, kinds = peak.curves[k]
        found = case.extremes(make, [(kinds, peak.goal)], located=located, floor=floor)
        each.append(Extremes(*(values[0] for values in found)))
    (value, where, width), number = furthest(each, peak.goal)
    return ExtremeOfEach(value, width, where, np.array(numbers, float)[number])


def as_column(case: Case, peak: Peak, extreme: ExtremeOfEach) -> Bounded:
    """The quantity from its extreme."""
    by = -extreme.width if peak.goal == LEAST else extreme.width
    with np.errstate(divide="ignore"):
        value = np.asarray(peak.scale.quantity(extreme.value, case.designs))
    scale = np.abs(value) if peak.unit is None else np.maximum(np.abs(value), peak.unit(case.designs))
    return Bounded(value, peak.scale.change(extreme.value, by, case.designs), scale)


def peak_column(case: Case, peak: Peak, sound: Any = True) -> Bounded:
    """A quantity that is a peak, of all designs of a case."""
    return as_column(case, peak, extreme_of(case, peak, sound))


def columns_of_ends(case: Case, largest: Peak, least: Peak) -> tuple[Bounded, Bounded]:
    """The largest and the least value of one curve, with errors relative to the larger magnitude of both."""
    ((make, kinds),) = largest.curves
    found = case.extremes(make, [(kinds, largest.goal), (kinds, least.goal)])
    columns = []
    for k, peak in enumerate((largest, least)):
        extreme = ExtremeOfEach(found.value[k], found.width[k], found.where[k], np.zeros(len(case.designs)))
        columns.append(as_column(case, peak, infinite(case, peak) if peak.jumps(case.programme) else extreme))
    scale = np.maximum(*(np.abs(column.value) for column in columns))
    above, below = (column._replace(scale=scale) for column in columns)
    return above, below

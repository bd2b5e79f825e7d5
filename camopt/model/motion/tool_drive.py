"""The motion of a follower that drives a tool through a train, or of a tool that a known follower drives.

The motion is asked at the tool, where z is; the follower is where the train has it, y = f⁻¹(z), and its derivatives
are those of the series of both (``numerics.taylor``). So y has as many of them as z, and jumps where z does. Where
the cam is given, y is known, and the tool is driven by the follower through the same train from its other end.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.motion.law import BySeries, Law, law_derivatives
from camopt.model.motion.law_panels import turning_points
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ExactNumbers, Stroke, reversed_kinds
from camopt.model.trains.link import value_at_end
from camopt.model.trains.train import StageFault, Train


@dataclass(frozen=True)
class DrivenLaw(BySeries):
    """The motion of a follower in a stroke of the tool, from its start and in units of ``size``, mm (rad).

    Of a tool that a known follower drives, follower and tool change places.
    """

    law: Law
    """The tool's."""
    zero: float
    """Where the tool is lowest in the turn, from the start position of the train, mm (rad)."""
    low: float
    """Where the tool starts, from its lowest position, mm (rad)."""
    factor: float
    """What the tool's law is multiplied by."""
    train: Train
    start: float
    """Where the follower starts, mm (rad)."""
    size: float

    @property
    def NAME(self) -> str:  # noqa: N802
        return self.law.NAME

    @property
    def TITLE(self) -> str:  # noqa: N802
        return f"{self.law.TITLE}, through the train"

    @property
    def SOURCE(self) -> str:  # noqa: N802
        return self.law.SOURCE

    @property
    def BREAKS(self) -> tuple[float, ...]:  # noqa: N802
        return self.law.BREAKS

    def _derivatives_to_order(self, x: ArrayLike, order: int) -> list[FloatArray]:
        first, *rates = (self.factor * each for each in law_derivatives(self.law, x, order))
        terms = [self.zero + self.low + first, *(rate / k for rate, k in zip(rates, (1.0, 2.0, 6.0), strict=False))]
        found = self.train.follower(Taylor(terms)) - self.start
        return [np.asarray(found.derivative(k) / self.size) for k in range(order + 1)]


@turning_points.register
def _turnings_of_tool(law: DrivenLaw, panels: int) -> tuple[float, ...]:
    """Between its dead points a train turns back where the tool does."""
    return turning_points(law.law, panels)


@lru_cache(maxsize=512)
def follower_programme(
    tool: Programme, train: Train, zero: float, load: ExternalLoad | TrainLoad | None = None
) -> Programme:
    """The turn of the follower that drives a tool as asked.

    Displacements of the tool count from where they are ``zero`` above the start position of the train, mm (rad).
    ``load`` is an external load at the follower, or what comes to it through the train.

    Raises
    ------
    StageFault
        If the tool goes beyond a dead point.
    """
    low, high = (zero + level for level in tool.levels)
    for side, end, at in zip((-1.0, 1.0), train.tool_reach, (low, high), strict=True):
        if not side * at < side * end.at:
            raise StageFault(end.stage, f"the tool goes beyond a dead point: {end.why} there")
    ends = {end for each in tool.strokes for end in (each.low, each.high)}
    levels = {end: value_at_end(train.follower, zero + end) for end in ends}
    base = levels[tool.strokes[0].low]
    strokes = tuple(_follower_stroke(each, train, zero, levels, base) for each in tool.strokes)
    turn = Programme(strokes, load, tool_programme=tool).on_base_circle()
    if not isinstance(load, TrainLoad):
        return turn
    return replace(turn, load=replace(load, zero=base - turn.strokes[0].low))


def programme_with_tool(
    follower: Programme, train: Train, zero: float, load: ExternalLoad | TrainLoad | None = None
) -> Programme:
    """The turn of a follower whose motion is known, with the tool that it drives.

    ``zero`` is where the follower is lowest, from the start position of the train, mm (rad).

    Raises
    ------
    StageFault
        If the follower goes beyond a dead point.
    """
    moved = follower_programme(replace(follower, load=None), train.reversed_train, zero)
    if isinstance(load, TrainLoad):
        load = replace(load, zero=zero)
    return replace(follower, load=load, tool_programme=replace(moved, tool_programme=None), given_at_follower=True)


def tool_travel(turn: Programme) -> tuple[float, float]:
    """From where to where the tool of a follower goes, from the start position of their train, mm (rad)."""
    low, high = (_tool_zero(turn) + level for level in turn.tool.levels)
    return low, high


def tool_position(turn: Programme, angles: FloatArray) -> FloatArray:
    """Where the tool of a follower is at cam angles, from the start position of their train, mm (rad)."""
    return np.asarray(_tool_zero(turn) + turn.tool.motion_at(angles)[0])


def follower_series(train: Train, turn: Programme, angles: FloatArray) -> Series:
    """Where the follower is at cam angles from the start position of its train, as a series, mm or rad."""
    _, z1, z2, _ = turn.tool.motion_at(angles)
    return train.follower(Taylor([tool_position(turn, angles), z1, z2 / 2]))


def train_ratio_series(train: Train, turn: Programme, angles: FloatArray) -> Series:
    """The ratio of a train at cam angles, as a series."""
    return train.joints(follower_series(train, turn, angles))[-1].ratio


def _tool_zero(turn: Programme) -> float:
    """Where the tool of a follower is lowest."""
    if turn.given_at_follower:
        return next(s.law.start - s.low for s in turn.tool.strokes if isinstance(s.law, DrivenLaw))
    return next(stroke.law.zero for stroke in turn.strokes if isinstance(stroke.law, DrivenLaw))


def _follower_stroke(stroke: Stroke, train: Train, zero: float, levels: dict[float, float], base: float) -> Stroke:
    """A stroke of the follower; where a rise of the tool lowers it, it is a return."""
    low, high = levels[stroke.low], levels[stroke.high]
    size = 1.0 if stroke.is_move or high == low else high - low
    law = stroke.law and DrivenLaw(stroke.law, zero, stroke.low, stroke.size, train, low, size)
    turned = (high - low) * (stroke.high - stroke.low) < 0.0
    kind = reversed_kinds(stroke.kind) if turned else stroke.kind
    given = stroke.given and ExactNumbers(stroke.given.angle, high - low, angular=False)
    return Stroke(kind, law, stroke.start, stroke.angle, low - base, high - base, given, key=stroke.key)

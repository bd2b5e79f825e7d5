"""The motion of a follower that drives a tool through a train, or of a tool that a known follower drives.

Usually the scene gives the motion z of the tool. The train then gives the follower's, y = f⁻¹(z), with derivatives
from Taylor series (``numerics.taylor``). So y has as many derivatives as z, and jumps where z does. If the cam is
given, y is known; the tool's motion then follows from the train that is driven at its other end.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.motion.law import Law, LawBySeries, law_derivatives
from camopt.model.motion.law_panels import turning_points
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ExactNumbers, Stroke, reversed_kinds
from camopt.model.trains.link import formula_value_at_end
from camopt.model.trains.train import StageFault, Train


@dataclass(frozen=True)
class DrivenLaw(LawBySeries):
    """The motion of a follower in a stroke of the tool, from the start of the stroke, in units of ``size``.

    For a tool that a known follower drives, follower and tool change places. Positions in mm or rad.
    """

    law: Law
    """The law of the tool."""
    zero: float
    """Lowest position of the tool in the turn, from the start position of the train."""
    low: float
    """Position of the tool at the start of the stroke, from its lowest position."""
    factor: float
    """The factor of the tool's law."""
    train: Train
    start: float
    """Position of the follower at the start of the stroke."""
    size: float
    """The unit of this law."""

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
        first, *rates = (self.factor * values for values in law_derivatives(self.law, x, order))
        terms = [self.zero + self.low + first, *(rate / k for rate, k in zip(rates, (1.0, 2.0, 6.0), strict=False))]
        motion = self.train.follower_displacement(Taylor(terms)) - self.start
        return [np.asarray(motion.derivative(k) / self.size) for k in range(order + 1)]


@turning_points.register
def _tool_turning_points(law: DrivenLaw, panel_count: int) -> tuple[float, ...]:
    """The turning points of the tool's law: between dead points, a train turns back where the tool does."""
    return turning_points(law.law, panel_count)


@lru_cache(maxsize=512)
def follower_programme(
    tool: Programme, train: Train, lowest_tool_position: float, load: ExternalLoad | TrainLoad | None = None
) -> Programme:
    """The turn of the follower that drives a tool.

    ``lowest_tool_position`` is the lowest position of the tool, from the start position of the train [mm or rad].
    ``load`` is an external load at the follower, or the load of the train.

    Raises
    ------
    StageFault
        If the tool goes beyond a dead point.
    """
    low, high = (lowest_tool_position + level for level in tool.lowest_and_highest_displacement)
    for side, end, at in zip((-1.0, 1.0), train.tool_travel_ends, (low, high), strict=True):
        if not side * at < side * end.at:
            raise StageFault(end.stage, f"the tool goes beyond a dead point: {end.why} there")
    ends = {end for stroke in tool.strokes for end in (stroke.low, stroke.high)}
    levels = {end: formula_value_at_end(train.follower_displacement, lowest_tool_position + end) for end in ends}
    base = levels[tool.strokes[0].low]
    strokes = tuple(_follower_stroke(stroke, train, lowest_tool_position, levels, base) for stroke in tool.strokes)
    turn = Programme(strokes, load, tool_programme=tool).on_base_circle()
    if not isinstance(load, TrainLoad):
        return turn
    return replace(turn, load=replace(load, zero=base - turn.strokes[0].low))


def programme_with_tool(
    follower: Programme, train: Train, lowest_follower_position: float, load: ExternalLoad | TrainLoad | None = None
) -> Programme:
    """The turn of a follower whose motion is known, with the tool that it drives.

    ``lowest_follower_position`` is the lowest position of the follower, from the start position of the train [mm or
    rad].

    Raises
    ------
    StageFault
        If the follower goes beyond a dead point.
    """
    tool = follower_programme(replace(follower, load=None), train.reversed_train, lowest_follower_position)
    if isinstance(load, TrainLoad):
        load = replace(load, zero=lowest_follower_position)
    return replace(follower, load=load, tool_programme=replace(tool, tool_programme=None), given_at_follower=True)


def tool_travel_range(turn: Programme) -> tuple[float, float]:
    """Lowest and highest position of the tool, from the start position of the train [mm or rad]."""
    low, high = (_lowest_tool_position(turn) + level for level in turn.tool.lowest_and_highest_displacement)
    return low, high


def tool_position(turn: Programme, angles: FloatArray) -> FloatArray:
    """Position of the tool at cam angles, from the start position of the train [mm or rad]."""
    return np.asarray(_lowest_tool_position(turn) + turn.tool.motion_at(angles)[0])


def follower_series(train: Train, turn: Programme, angles: FloatArray) -> Series:
    """Position of the follower at cam angles, from the start position of the train, as a series [mm or rad]."""
    _, z1, z2, _ = turn.tool.motion_at(angles)
    return train.follower_displacement(Taylor([tool_position(turn, angles), z1, z2 / 2]))


def train_ratio_series(train: Train, turn: Programme, angles: FloatArray) -> Series:
    """Velocity ratio of the train at cam angles, as a series."""
    return train.joint_motions(follower_series(train, turn, angles))[-1].ratio


def _lowest_tool_position(turn: Programme) -> float:
    """Lowest position of the tool, from the start position of the train [mm or rad]."""
    if turn.given_at_follower:
        return next(s.law.start - s.low for s in turn.tool.strokes if isinstance(s.law, DrivenLaw))
    return next(stroke.law.zero for stroke in turn.strokes if isinstance(stroke.law, DrivenLaw))


def _follower_stroke(
    stroke: Stroke,
    train: Train,
    lowest_tool_position: float,
    follower_position_by_tool: dict[float, float],
    start_position: float,
) -> Stroke:
    """A stroke of the follower; if a rise of the tool lowers the follower, it is a return."""
    low, high = follower_position_by_tool[stroke.low], follower_position_by_tool[stroke.high]
    size = 1.0 if stroke.is_move or high == low else high - low
    law = stroke.law and DrivenLaw(stroke.law, lowest_tool_position, stroke.low, stroke.size, train, low, size)
    lowered = (high - low) * (stroke.high - stroke.low) < 0.0
    kind = reversed_kinds(stroke.kind) if lowered else stroke.kind
    given = stroke.given and ExactNumbers(stroke.given.angle, high - low, angular=False)
    return Stroke(
        kind, law, stroke.start, stroke.angle, low - start_position, high - start_position, given, key=stroke.key
    )

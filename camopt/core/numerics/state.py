"""The state of the follower at a cam angle, or over a range of them: the argument of the formulas of curves."""

from typing import Any, NamedTuple


class Load(NamedTuple):
    """An external load that changes over the turn, and its slope by the cam angle."""

    value: Any
    slope: Any


class TrainForces(NamedTuple):
    """What a train brings to the follower: its load, the inertia of what it carries by ω², and slopes of both."""

    value: Any
    slope: Any
    carried: Any
    carried_slope: Any


class State(NamedTuple):
    """Displacement y, its derivatives by the cam angle (rad), and the external load if it changes over the turn.

    mm or rad, N or N·mm. Numbers, arrays, or numbers of any other kind that formulas run on: intervals, series,
    jets.
    """

    y: Any
    y1: Any
    y2: Any
    y3: Any
    load: Load | TrainForces | None = None
    y4: Any = 0.0
    """What slopes of curves take that have y''' in their values; 0 where no slope is asked."""

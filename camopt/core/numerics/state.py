"""The state of the follower at a cam angle or over a range of cam angles. Curve formulas take it as argument."""

from typing import Any, NamedTuple


class Load(NamedTuple):
    """An external load that changes over the turn, with its slope by the cam angle."""

    value: Any
    slope: Any


class TrainForces(NamedTuple):
    """Forces of a train on the follower: its load, and its inertia force divided by ω², with their slopes."""

    value: Any
    slope: Any
    carried: Any
    carried_slope: Any


class State(NamedTuple):
    """Displacement y [mm or rad], its derivatives by the cam angle, and the load if it changes [N or N·mm].

    Numbers, arrays, or any other number type on which formulas run: intervals, series, jets.
    """

    y: Any
    y1: Any
    y2: Any
    y3: Any
    load: Load | TrainForces | None = None
    y4: Any = 0.0
    """y'''', for slopes of curves that contain y'''; 0 if no slope is needed."""

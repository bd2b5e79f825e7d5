"""What a train carries, and the force that it takes at the follower, by virtual work.

Each joint j, moved by s_j, has the velocity ratio i_j = ds_j/dy to the follower, so that a force Q_j on it asks the
follower for Q_j·i_j, and a mass for the force of its acceleration:

    F = S + ω²·I,    S = Σ (F_j + k_j·s_j + R_j·sgn ṡ_j)·i_j,    I = Σ m_j·s_j''·i_j,    s'' = i²·y'' + i'·y'

Source: Norton, Design of Machinery, ch. 10 (virtual work; effective mass of linkages).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from camopt.core.numerics.taylor import Series, series_slope


@dataclass(frozen=True)
class CarriedLoad:
    """What moves at a joint, and what acts on it: t, mm, N; where it turns t·mm², rad, N·mm."""

    joint: int
    """1 is what the first link moves; 0 the follower."""
    mass: Any = 0.0
    stiffness: Any = 0.0
    force: Any = 0.0
    """A constant force against the motion, where the train starts."""
    friction: Any = 0.0
    """The force of friction, against the velocity; none at rest."""


class TrainJoint(NamedTuple):
    """A joint of a train: how far it is from its start position, and its velocity ratio to the follower."""

    moved: Series
    ratio: Series


class FollowerLoad(NamedTuple):
    """What a train brings to the follower, N (N·mm): S and I."""

    still: Series
    carried: Series


def sum_follower_load(
    joints: list[TrainJoint], carried: tuple[CarriedLoad, ...], ways: Sequence[Any], loads: Mapping[int, Series]
) -> FollowerLoad:
    """S and I, from the joints as series by the cam angle.

    ``ways`` has for each joint which way it moves: 1, −1, or 0 at rest. ``loads`` are forces that change over the
    turn, by joint.
    """
    still = joints[0].moved * 0.0
    inertia = series_slope(series_slope(still))
    for each in carried:
        moved, ratio = joints[each.joint]
        force = moved * each.stiffness + (ways[each.joint] * each.friction + each.force)
        still = still + force * ratio
        inertia = inertia + series_slope(series_slope(moved)) * ratio * each.mass
    for joint, load in loads.items():
        still = still + load * joints[joint].ratio
    return FollowerLoad(still, inertia)

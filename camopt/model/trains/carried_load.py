"""The load of a train on the follower: masses, springs, forces and friction at its joints, by virtual work.

Joint j has moved by s_j, and its velocity ratio to the follower is i_j = ds_j/dy. A force Q_j at the joint loads
the follower with Q_j·i_j; a mass loads it with the force that its acceleration takes:

    F = S + ω²·I,    S = Σ (F_j + k_j·s_j + R_j·sgn ṡ_j)·i_j,    I = Σ m_j·s_j''·i_j,    s'' = i²·y'' + i'·y'

Source: Norton, Design of Machinery, ch. 10 (virtual work; effective mass of linkages).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from camopt.core.numerics.taylor import Series, series_derivative


@dataclass(frozen=True)
class CarriedLoad:
    """The mass at a joint and the forces on it, in t, mm and N; at a joint that turns in t·mm², rad and N·mm."""

    joint: int
    """0 is the follower, 1 the output of the first link."""
    mass: Any = 0.0
    stiffness: Any = 0.0
    """Rate of a spring that is unloaded in the start position of the train."""
    force: Any = 0.0
    """Constant force against the motion."""
    friction: Any = 0.0
    """Force against the velocity; 0 at rest."""


class TrainJoint(NamedTuple):
    """Displacement of a joint from its start position, and its velocity ratio to the follower."""

    displacement: Series
    ratio: Series


class FollowerLoad(NamedTuple):
    """The load of a train on the follower, S and I of the module's formula [N or N·mm]."""

    still: Series
    """S, which does not depend on the speed."""
    carried: Series
    """I, to be multiplied by ω²."""


def sum_follower_load(
    joints: list[TrainJoint],
    carried_loads: tuple[CarriedLoad, ...],
    velocity_signs: Sequence[Any],
    loads: Mapping[int, Series],
) -> FollowerLoad:
    """S and I, from the joints as series by the cam angle.

    ``velocity_signs`` has the sign of each joint's velocity: 1, −1, or 0 at rest. ``loads`` are forces that change
    over the turn, by joint.
    """
    static = joints[0].displacement * 0.0
    inertia = series_derivative(series_derivative(static))
    for part in carried_loads:
        displacement, ratio = joints[part.joint]
        force = displacement * part.stiffness + (velocity_signs[part.joint] * part.friction + part.force)
        static = static + force * ratio
        inertia = inertia + series_derivative(series_derivative(displacement)) * ratio * part.mass
    for joint, load in loads.items():
        static = static + load * joints[joint].ratio
    return FollowerLoad(static, inertia)

"""Peaks of a train: quantities that are extremes of curves of its links over the turn, for any cam.

An effect declares the curves and which extreme of them counts, as with a ``Peak``. Effects compute the quantity of
a single train by other formulas (``effects.transmission_angle``, ``effects.joint_motions``); boxes of trains use
these curves.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from camopt.model.effects.peak import IDENTITY_SCALE, Scale
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme
from camopt.model.trains.joint_forces import WeightedForce


class TrainMotion(Protocol):
    """The motion and the forces of trains at cam angles, in any kind of number."""

    def transmission_angle(self, link: int) -> Any:
        """Transmission angle of a link's coupler [rad]."""

    def link_force_sum(self, parts: Sequence[WeightedForce], speed: Any) -> Any:
        """Sum of forces of links [N] at a speed [rad/s]."""


class TrainPeak(NamedTuple):
    """A quantity that is the extreme of some curves of a train over the turn."""

    curves: tuple[Callable[[Designs, TrainMotion], Any], ...]
    goal: int
    """LEAST or LARGEST_MAGNITUDE, over all curves together."""
    scale: Scale = IDENTITY_SCALE

    def jumps(self, programme: Programme) -> bool:
        """Always False; its effect considers jumps of the motion."""
        return False

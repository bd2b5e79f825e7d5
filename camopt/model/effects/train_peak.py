"""Peaks of a train: quantities that are the extreme over the turn of what its links do, whatever cam drives them.

An effect says once which extreme of which curves of a train a quantity is, as of a ``Peak``. Single trains have it
by ways of their own (``effects.transmission``, ``effects.joints``); boxes of trains by these curves, at cam angles.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from camopt.model.effects.peak import IDENTITY_SCALE, Scale
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme
from camopt.model.trains.joint_forces import WeightedForce


class TrainMotion(Protocol):
    """What trains do at cam angles, in any kind of number."""

    def transmission(self, link: int) -> Any:
        """The acute angle of a link's coupler, rad."""
        ...

    def force(self, parts: Sequence[WeightedForce], speed: Any) -> Any:
        """A sum of forces of links at a speed, rad/s, N."""
        ...


TrainCurve = Callable[[Designs, TrainMotion], Any]
"""What trains of designs have at cam angles."""


class TrainPeak(NamedTuple):
    """A quantity that is the extreme of some curves of a train over the turn."""

    curves: tuple[TrainCurve, ...]
    goal: int
    """LEAST or LARGEST_MAGNITUDE, of all curves together."""
    scale: Scale = IDENTITY_SCALE

    def jumps(self, programme: Programme) -> bool:
        """Whether jumps of a motion make it infinite: its effect tells."""
        return False

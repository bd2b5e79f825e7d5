"""The dynamics of a follower as plain numbers, in place of those of a scene (``effects.effect_numbers``)."""

from typing import Any, NamedTuple


class Dynamics(NamedTuple):
    """mm, s, N, t; oscillating: t·mm², N·mm/rad, N·mm, N·mm·s/rad."""

    mass: Any = None
    damping: Any = 0.0
    stiffness: Any = 0.0
    preload: Any = 0.0
    load: Any = 0.0
    damping_ratio: Any = 0.0

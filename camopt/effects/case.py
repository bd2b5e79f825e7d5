"""What an effect is, and the case it works on."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.peak import Peak
from camopt.mechanisms.design import Designs, Mechanism
from camopt.motion.programme import Programme
from camopt.numerics.extremes import Extremes, Precision, extremes


@dataclass(frozen=True)
class Dynamics:
    """What moves with the follower: mm, s, N, t; oscillating: t·mm², N·mm/rad, N·mm, N·mm·s/rad.

    None where a scene does not say; what presses the follower on the cam is 0 then.
    """

    mass: float | None = None
    damping: float = 0.0
    stiffness: float = 0.0
    preload: float = 0.0
    load: float = 0.0
    """Constant external force on the follower, its weight included, positive towards the cam."""
    friction: float = 0.0
    guide_length: float | None = None
    overhang: float | None = None
    stem_diameter: float | None = None
    natural_frequency: float | None = None
    damping_ratio: float = 0.0
    fluctuation: float | None = None
    lash: float | None = None
    """The clearance that the follower takes up before what it drives moves, mm (rad)."""
    lash_variation: float = 0.0


@dataclass(frozen=True)
class Bodies:
    """The bodies in contact and their lubricant: MPa, mm, N, s. None where a scene does not say."""

    modulus: float | None = None
    """E*, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂."""
    face_width: float | None = None
    wear_rate: float | None = None
    """Volume worn off the cam by load and sliding distance, mm²/N."""
    viscosity: float | None = None
    pressure_viscosity: float | None = None
    roughness: float | None = None
    """Root mean square of both surfaces."""


@dataclass(frozen=True)
class Solid:
    """The cam as a solid: mm, t/mm³, rad. None where a scene does not say; 0 where there is no such thing."""

    thickness: float | None = None
    density: float | None = None
    bore_radius: float = 0.0
    bore_reach: float = 0.0
    """The largest distance of the bore, its keyway included, from the axis."""
    keyway_width: float = 0.0
    keyway_depth: float = 0.0
    keyway_angle: float = 0.0
    hub_radius: float = 0.0
    hub_length: float = 0.0
    groove_depth: float | None = None


@dataclass(frozen=True)
class Setup:
    """What all designs of a problem share: the mechanism and the speed. Lengths in mm."""

    mechanism: Mechanism
    angular: bool
    """Whether the follower oscillates, so that its displacement is an angle."""
    pointed: bool
    """Whether the follower is a knife edge."""
    rpm: float | None
    shaft_radius: float | None
    tolerance: float = 1e-9
    dynamics: Dynamics = Dynamics()
    bodies: Bodies = Bodies()
    solid: Solid = Solid()
    spherical: bool = False
    """Whether the follower touches the cam in a point."""
    numbers: tuple[tuple[str, float], ...] = ()
    """The numbers of the scene that a search varies, by quantity, in the units of the scene."""

    @property
    def omega(self) -> float | None:
        """The speed, rad/s."""
        return None if self.rpm is None else self.rpm * 2 * pi / 60


class Bounded(NamedTuple):
    """A quantity with its enclosure: the true value lies between ``value`` and ``value + outward``.

    Apart from rounding, it lies only on the side of ``outward``. Relative errors refer to ``scale``.
    """

    value: Any
    outward: Any
    scale: Any


@dataclass(frozen=True)
class Case:
    """A block of designs that share a programme, and what earlier effects found of them."""

    setup: Setup
    programme: Programme
    designs: Designs
    found: Mapping[str, Any] = field(default_factory=dict)
    outward: Mapping[str, Any] = field(default_factory=dict)
    """How far the true value of each may lie from what was found, with its sign."""

    def far(self, name: str) -> Any:
        """The far side of the enclosure of a quantity that an earlier effect found."""
        return self.found[name] + self.outward.get(name, 0.0)

    def extremes(
        self,
        curve: Callable[[Designs, Programme], Any],
        questions: list[tuple[int, int]],
        *,
        located: bool = False,
    ) -> Extremes:
        """Extremes of one of the mechanism's curves, for questions (kinds of stroke, goal).

        Cam angles are as exact as values only if ``located``.
        """
        precision = Precision(self.setup.tolerance, self.setup.tolerance if located else np.inf)
        made = curve(self.designs, self.programme)
        return extremes(made, len(self.designs), self.programme.table, questions, precision)


def nothing(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    """No quantity at all."""
    return {}


@dataclass(frozen=True)
class Effect:
    """A discipline that computes quantities: what it offers for a setup, and how."""

    name: str
    offers: Callable[[Setup], tuple[str, ...]]
    """The quantities of the setup's mechanism."""
    run: Callable[[Case, frozenset[str]], dict[str, Any]] = nothing
    """From a case and the wanted names to columns: arrays (designs,) or one value for all, Bounded if inexact."""
    lacks: Callable[[Setup], Mapping[str, tuple[str, ...]]] = lambda setup: {}
    """For each offered quantity that cannot be computed from what the scene gives: the keys that it lacks."""
    reads: Callable[[Setup], tuple[str, ...]] = lambda setup: ()
    """Quantities that ``run`` reads from ``Case.found``: of other effects, or found of the pitch curve."""
    of_pitch: Callable[[Case, frozenset[str]], dict[str, Any]] = nothing
    """As ``run``, and before it: what the pitch curve decides, which designs with rollers of many sizes share."""
    of_motion: Callable[[Setup], bool] = lambda setup: False
    """Whether its quantities depend on the motion and the speed alone, whatever the design."""
    peaks: Callable[[Setup], Mapping[str, Peak]] = lambda setup: {}
    """Its quantities that extremes of curves decide; of those that it offers, or more."""
    of_sizes: bool = False
    """Whether it is arithmetic on sizes, which runs on ranges of them (Intervals) too."""
    last: bool = False
    """Whether it costs so much that a limit on its quantities is checked only for designs that meet all others."""

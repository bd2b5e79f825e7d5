"""The scene's numbers for speed, loads and materials, converted to inside units.

Each may be one number, an array with a number for each of many designs, or a range of numbers, with slopes or
without: what is made of them is arithmetic. None where a scene does not say; what presses the follower on the cam
is 0 then.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any, NamedTuple

from camopt.trains.train import Train


class Band(NamedTuple):
    """Between which values an error is."""

    low: float
    high: float

    @property
    def half(self) -> float:
        return (self.high - self.low) / 2.0

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2.0

    def end(self, side: float) -> float:
        """How far it goes to a side, +1 or −1."""
        return self.high if side > 0.0 else -self.low


NO_BAND = Band(0.0, 0.0)


@dataclass(frozen=True)
class GivenErrors:
    """By how much cams and followers may be off: mm, rad."""

    sizes: Mapping[str, Band]
    """Of the follower, by field of ``Designs``."""
    profile: float = 0.0
    waves: int | None = None
    bore: float = 0.0
    phase: Band = NO_BAND
    tilt: Band = NO_BAND
    is_square: bool = False
    """Whether a follower that rests stands square to its cam, whatever the design: it translates, not offset."""
    second: Mapping[str, Band] = field(default_factory=dict)
    """Of sizes of a second contact, by key of the scene."""
    disc_phase: Band = NO_BAND
    links: Mapping[str, tuple[Band, Train]] = field(default_factory=dict)
    """Of numbers of the train, by key, each with the train as a series of it."""

    @property
    def by_key(self) -> dict[str, Band]:
        """The bands of numbers that are not of the train, by key of ``[tolerances]``."""
        angles = {"phase": self.phase, "face_tilt": self.tilt, "disc_phase": self.disc_phase}
        sizes = {f"follower.{field}": band for field, band in self.sizes.items()}
        return {**sizes, **self.second, **{key: band for key, band in angles.items() if band != NO_BAND}}

    @property
    def is_lopsided(self) -> bool:
        """Whether an error goes further to one side than to the other."""
        return any(each.middle for each in (*self.sizes.values(), self.phase, self.tilt))


Number = Any
"""A number, an array (designs,), an Interval or a Sloped; None where a scene does not say."""


class GivenDynamics(NamedTuple):
    """The dynamics of the follower: mm, s, N, t; oscillating: t·mm², N·mm/rad, N·mm, N·mm·s/rad."""

    mass: Number = None
    damping: Number = 0.0
    stiffness: Number = 0.0
    preload: Number = 0.0
    load: Number = 0.0
    """Constant external force on the follower, its weight included, positive towards the cam."""
    friction: Number = 0.0
    guide_length: Number = None
    overhang: Number = None
    stem_diameter: Number = None
    natural_frequency: Number = None
    damping_ratio: Number = 0.0
    fluctuation: Number = None
    lash: Number = None
    """The clearance that the tool takes up before what it drives moves, mm (rad)."""
    lash_variation: Number = 0.0
    pair_preload: Number = None
    """With which two contacts press at rest."""
    pair_stiffness: Number = None
    """The increase of that by the interference."""


class Bodies(NamedTuple):
    """The bodies in contact and their lubricant: MPa, mm, N, s."""

    modulus: Number = None
    """E*, 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂."""
    face_width: Number = None
    wear_rate: Number = None
    """Volume worn off the cam by load and sliding distance, mm²/N."""
    viscosity: Number = None
    pressure_viscosity: Number = None
    roughness: Number = None
    """Root mean square of both surfaces."""


class GivenDrive(NamedTuple):
    """A positive drive: mm, t·mm²."""

    clearance: Number = None
    """Between the follower and both flanks together, along their normal."""
    roller_inertia: Number = None
    """Of the roller about its pin."""
    friction: Number = None
    """Between roller and flank."""


@dataclass(frozen=True)
class GivenNumbers:
    """Numbers by key of the scene, such as ``cam.rpm``, in its units; None, or absent, if not given."""

    values: Mapping[str, Number] = field(default_factory=dict)
    angular: bool = False
    """Whether the follower oscillates: what is a force and a mass elsewhere is a moment and an inertia."""
    tool_turns: bool = False
    """Whether the motion of the tool, or without a train of the follower, is an angle."""

    def with_numbers(self, numbers: Mapping[str, Number]) -> "GivenNumbers":
        """The same with other numbers."""
        return replace(self, values={**self.values, **numbers})

    def __getitem__(self, key: str) -> Number:
        return self.values.get(key)

    def times(self, key: str, factor: Number, absent: float | None = None) -> Number:
        """A number in inside units; None stays None."""
        value = self[key]
        return absent if value is None else value * factor

    @property
    def rpm(self) -> Number:
        return self["cam.rpm"]

    @property
    def shaft_radius(self) -> Number:
        return self.times("cam.shaft_diameter", 0.5)

    @property
    def dynamics(self) -> GivenDynamics:
        """The follower's dynamics."""
        torque, length = 1e3 if self.angular else 1.0, pi / 180 if self.tool_turns else 1.0
        mass = self.times(f"{OF_FOLLOWER}inertia", 1e3) if self.angular else self.times(f"{OF_FOLLOWER}mass", 1e-3)
        lever = self._of_follower("spring_at")  # a force on it in N is a moment in N·mm
        turned = pi / 180 if self.angular else 1.0
        stiffness, interference = self.times("drive.stiffness", torque), self.times("drive.interference", turned)
        weight = (0.0 if mass is None else mass) * self._of_follower("gravity", 1.0, 0.0) * 1e3
        return GivenDynamics(
            mass=mass,  # t from kg, t·mm² from kg·m²
            damping=self._of_follower("damping", torque, 0.0),
            stiffness=self._of_follower("spring_rate", torque if lever is None else lever**2, 0.0),
            preload=self._of_follower("preload", torque if lever is None else lever, 0.0),
            load=self._of_follower("load", torque, 0.0) + weight,
            friction=self._of_follower("friction", 1.0, 0.0),
            guide_length=self._of_follower("guide_length"),
            overhang=self._of_follower("overhang"),
            stem_diameter=self._of_follower("stem_diameter"),
            natural_frequency=self._of_follower("natural_frequency"),
            damping_ratio=self._of_follower("damping_ratio", 1.0, 0.0),
            fluctuation=self._of_follower("fluctuation"),
            lash=self._of_follower("lash", length),
            lash_variation=self._of_follower("lash_variation", length, 0.0),
            pair_preload=None if stiffness is None or interference is None else stiffness * interference,
            pair_stiffness=stiffness,
        )

    def _of_follower(self, name: str, factor: Number = 1.0, absent: float | None = None) -> Any:
        return self.times(f"{OF_FOLLOWER}{name}", factor, absent)

    @property
    def bodies(self) -> Bodies:
        """The bodies in contact."""
        return Bodies(
            modulus=self._modulus,
            face_width=self["materials.face_width"],
            wear_rate=self["materials.wear_rate"],
            viscosity=self.times("materials.viscosity", 1e-6),
            pressure_viscosity=self.times("materials.pressure_viscosity", 1e-3),
            roughness=self.times("materials.roughness", 1e-3),
        )

    @property
    def drive(self) -> GivenDrive:
        """The positive drive."""
        return GivenDrive(self["drive.clearance"], self.times("drive.roller_inertia", 1e3), self["drive.friction"])

    @property
    def _modulus(self) -> Number:
        """E* in MPa; None unless modulus and Poisson's ratio of both bodies are known."""
        compliance: Any = 0.0
        for body in ("cam", "follower"):
            modulus, poisson = (self[f"materials.{body}_{name}"] for name in ("modulus", "poisson"))
            if modulus is None or poisson is None:
                return None
            compliance = compliance + (1.0 - poisson**2) / (1e3 * modulus)
        return 1.0 / compliance


OF_FOLLOWER = "follower.dynamics."

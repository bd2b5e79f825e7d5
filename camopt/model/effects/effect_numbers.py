"""The scene's numbers for speed, loads and materials, converted to inside units.

Each may be one number, an array with a number for each design, or a range with or without slopes; all formulas take
these. A number that the scene does not give is None, but 0 for forces on the follower.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from camopt.core.numerics import Number
from camopt.core.quantities import NUMBER_KEYS, has_number_angular_unit
from camopt.model.trains.train import Train


class ErrorBand(NamedTuple):
    """The range of an error."""

    low: float
    high: float

    @property
    def half_range(self) -> float:
        return (self.high - self.low) / 2.0

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2.0

    def largest_error_to_side(self, side: float) -> float:
        """How far it reaches to a side, +1 or −1."""
        return self.high if side > 0.0 else -self.low


NO_BAND = ErrorBand(0.0, 0.0)


@dataclass(frozen=True)
class ToleranceBands:
    """The tolerances of cams and followers [mm, rad]."""

    sizes: Mapping[str, ErrorBand]
    """Bands of the follower's sizes, by field of ``Designs``."""
    profile: float = 0.0
    waves: int | None = None
    bore: float = 0.0
    phase: ErrorBand = NO_BAND
    tilt: ErrorBand = NO_BAND
    is_square: bool = False
    """Whether the pressure angle is 0 in every dwell of any design: the follower translates without offset."""
    second: Mapping[str, ErrorBand] = field(default_factory=dict)
    """Bands of the sizes of a second contact, by key of the scene."""
    disc_phase: ErrorBand = NO_BAND
    links: Mapping[str, tuple[ErrorBand, Train]] = field(default_factory=dict)
    """Bands of the train's numbers by key, each with the train as a series in that number."""

    @property
    def bands_by_key(self) -> dict[str, ErrorBand]:
        """All bands but those of the train, by key of ``[tolerances]``."""
        angles = {"phase": self.phase, "face_tilt": self.tilt, "disc_phase": self.disc_phase}
        sizes = {f"follower.{field}": band for field, band in self.sizes.items()}
        return {**sizes, **self.second, **{key: band for key, band in angles.items() if band != NO_BAND}}


class ConvertedTable:
    """The numbers of a table of the scene by key, in mm, s, N, t, rad; each is converted once."""

    def __init__(self, numbers: "SceneNumbers", table: str) -> None:
        self.numbers, self.table = numbers, table

    def __getattr__(self, name: str) -> Number:
        if name.startswith("__"):
            raise AttributeError(name)
        number = self.__dict__[name] = self.numbers.number_in_inside_units(f"{self.table}.{name}")
        return number


class FollowerDynamics(ConvertedTable):
    """The dynamics of the follower in mm, s, N and t; oscillating, in t·mm², N·mm/rad, N·mm and N·mm·s/rad."""

    @cached_property
    def mass(self) -> Number:
        """Mass [t], or moment of inertia [t·mm²]."""
        return self.inertia if self.numbers.angular else self.numbers.number_in_inside_units(f"{self.table}.mass")

    @cached_property
    def stiffness(self) -> Number:
        """Spring rate [N/mm or N·mm/rad]; a straight spring acts on an oscillating follower by a lever."""
        lever = self.spring_at
        return (
            self.spring_rate
            if lever is None
            else self.numbers.number_times_factor(f"{self.table}.spring_rate", lever**2, 0.0)
        )

    @cached_property
    def preload(self) -> Number:
        """Preload of the spring [N or N·mm]; a straight spring acts on an oscillating follower by a lever."""
        lever, inside = self.spring_at, self.numbers.number_in_inside_units(f"{self.table}.preload")
        return inside if lever is None else self.numbers.number_times_factor(f"{self.table}.preload", lever, 0.0)

    @cached_property
    def load(self) -> Number:
        """Constant external force on the follower with its weight, positive towards the cam [N or N·mm]."""
        weight = (0.0 if self.mass is None else self.mass) * self.gravity * 1e3
        return self.numbers.number_in_inside_units(f"{self.table}.load") + weight

    @cached_property
    def pair_stiffness(self) -> Number:
        """Preload of two contacts per interference [N/mm or N·mm/rad]."""
        return self.numbers.number_in_inside_units("drive.stiffness")

    @cached_property
    def pair_preload(self) -> Number:
        """Preload of two contacts at rest [N or N·mm]."""
        interference = self.numbers.number_in_inside_units("drive.interference")
        return None if self.pair_stiffness is None or interference is None else self.pair_stiffness * interference


class ContactBodies(ConvertedTable):
    """The bodies in contact and their lubricant, in MPa, mm, N and s."""

    @cached_property
    def modulus(self) -> Number:
        """Contact modulus E* [MPa]: 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂; None if one of these is not given."""
        compliance: Number = 0.0
        for body in ("cam", "follower"):
            modulus, poisson = (getattr(self, f"{body}_{name}") for name in ("modulus", "poisson"))
            if modulus is None or poisson is None:
                return None
            compliance = compliance + (1.0 - poisson**2) / modulus
        return 1.0 / compliance


@dataclass(frozen=True)
class SceneNumbers:
    """Numbers by key of the scene, such as ``cam.rpm``, in the scene's units; None or absent if not given."""

    values: Mapping[str, Number] = field(default_factory=dict)
    angular: bool = False
    """Whether the follower oscillates; forces and masses are then moments and inertias."""
    tool_turns: bool = False
    """Whether the motion of the tool is an angle; without a train, the follower is the tool."""

    def with_numbers(self, numbers: Mapping[str, Number]) -> "SceneNumbers":
        """The numbers with some replaced."""
        return replace(self, values={**self.values, **numbers})

    def __getitem__(self, key: str) -> Number:
        return self.values.get(key)

    def number_times_factor(self, key: str, factor: Number, value_if_absent: float | None = None) -> Number:
        """A number times a factor; ``absent`` if the scene does not give it."""
        value = self[key]
        return value_if_absent if value is None else value * factor

    def number_in_inside_units(self, key: str) -> Number:
        """A number in mm, s, N, t, rad; its default if the scene does not give it."""
        record, value = NUMBER_KEYS[key], self[key]
        turns = has_number_angular_unit(key, angular=self.angular, tool_turns=self.tool_turns)
        return record.default if value is None else record.to_inside_units(value, angular=turns)

    @property
    def drive(self) -> ConvertedTable:
        return ConvertedTable(self, "drive")

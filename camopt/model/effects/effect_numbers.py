"""The scene's numbers for speed, loads and materials, converted to inside units.

Each may be one number, an array with a number for each of many designs, or a range of numbers, with slopes or
without: what is made of them is arithmetic. None where a scene does not say; what presses the follower on the cam
is 0 then.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

from camopt.core.quantities import NUMBER_KEYS, number_turns
from camopt.model.trains.train import Train


class ErrorBand(NamedTuple):
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


NO_BAND = ErrorBand(0.0, 0.0)


@dataclass(frozen=True)
class ToleranceBands:
    """By how much cams and followers may be off: mm, rad."""

    sizes: Mapping[str, ErrorBand]
    """Of the follower, by field of ``Designs``."""
    profile: float = 0.0
    waves: int | None = None
    bore: float = 0.0
    phase: ErrorBand = NO_BAND
    tilt: ErrorBand = NO_BAND
    is_square: bool = False
    """Whether a follower that rests stands square to its cam, whatever the design: it translates, not offset."""
    second: Mapping[str, ErrorBand] = field(default_factory=dict)
    """Of sizes of a second contact, by key of the scene."""
    disc_phase: ErrorBand = NO_BAND
    links: Mapping[str, tuple[ErrorBand, Train]] = field(default_factory=dict)
    """Of numbers of the train, by key, each with the train as a series of it."""

    @property
    def by_key(self) -> dict[str, ErrorBand]:
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


class ConvertedTable:
    """The numbers of a table of the scene by key, in mm, s, N, t, rad; each is converted once."""

    def __init__(self, numbers: "SceneNumbers", table: str) -> None:
        self.numbers, self.table = numbers, table

    def __getattr__(self, name: str) -> Number:
        if name.startswith("__"):
            raise AttributeError(name)
        found = self.__dict__[name] = self.numbers.convert_number(f"{self.table}.{name}")
        return found


class FollowerDynamics(ConvertedTable):
    """The dynamics of the follower: mm, s, N, t; oscillating: t·mm², N·mm/rad, N·mm, N·mm·s/rad."""

    @cached_property
    def mass(self) -> Number:
        """Mass, or moment of inertia."""
        return self.inertia if self.numbers.angular else self.numbers.convert_number(f"{self.table}.mass")

    @cached_property
    def stiffness(self) -> Number:
        """Rate of the spring; a straight one with a rate in N/mm has one in N·mm/rad on its lever."""
        lever = self.spring_at
        return (
            self.spring_rate
            if lever is None
            else self.numbers.multiply_number(f"{self.table}.spring_rate", lever**2, 0.0)
        )

    @cached_property
    def preload(self) -> Number:
        """Preload of the spring; of a straight one that of its force on its lever."""
        lever, inside = self.spring_at, self.numbers.convert_number(f"{self.table}.preload")
        return inside if lever is None else self.numbers.multiply_number(f"{self.table}.preload", lever, 0.0)

    @cached_property
    def load(self) -> Number:
        """Constant external force on the follower, its weight included, positive towards the cam."""
        weight = (0.0 if self.mass is None else self.mass) * self.gravity * 1e3
        return self.numbers.convert_number(f"{self.table}.load") + weight

    @cached_property
    def pair_stiffness(self) -> Number:
        """Increase of the preload of two contacts by their interference."""
        return self.numbers.convert_number("drive.stiffness")

    @cached_property
    def pair_preload(self) -> Number:
        """Preload with which two contacts press at rest."""
        interference = self.numbers.convert_number("drive.interference")
        return None if self.pair_stiffness is None or interference is None else self.pair_stiffness * interference


class ContactBodies(ConvertedTable):
    """The bodies in contact and their lubricant: MPa, mm, N, s."""

    @cached_property
    def modulus(self) -> Number:
        """E* of 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂; None unless modulus and Poisson's ratio of both are known."""
        compliance: Any = 0.0
        for body in ("cam", "follower"):
            modulus, poisson = (getattr(self, f"{body}_{name}") for name in ("modulus", "poisson"))
            if modulus is None or poisson is None:
                return None
            compliance = compliance + (1.0 - poisson**2) / modulus
        return 1.0 / compliance


@dataclass(frozen=True)
class SceneNumbers:
    """Numbers by key of the scene, such as ``cam.rpm``, in its units; None, or absent, if not given."""

    values: Mapping[str, Number] = field(default_factory=dict)
    angular: bool = False
    """Whether the follower oscillates: what is a force and a mass elsewhere is a moment and an inertia."""
    tool_turns: bool = False
    """Whether the motion of the tool, or without a train of the follower, is an angle."""

    def with_numbers(self, numbers: Mapping[str, Number]) -> "SceneNumbers":
        """The same with other numbers."""
        return replace(self, values={**self.values, **numbers})

    def __getitem__(self, key: str) -> Number:
        return self.values.get(key)

    def multiply_number(self, key: str, factor: Number, absent: float | None = None) -> Number:
        """A number in inside units; None stays None."""
        value = self[key]
        return absent if value is None else value * factor

    @property
    def rpm(self) -> Number:
        return self["cam.rpm"]

    @property
    def shaft_radius(self) -> Number:
        return self.multiply_number("cam.shaft_diameter", 0.5)

    def convert_number(self, key: str) -> Number:
        """A number in mm, s, N, t, rad; what it is where the scene does not give it."""
        record, value = NUMBER_KEYS[key], self[key]
        turns = number_turns(key, angular=self.angular, tool_turns=self.tool_turns)
        return record.default if value is None else record.to_inside_units(value, turns=turns)

    @property
    def dynamics(self) -> FollowerDynamics:
        """The follower's dynamics."""
        return FollowerDynamics(self, "follower.dynamics")

    @property
    def bodies(self) -> ContactBodies:
        """The bodies in contact."""
        return ContactBodies(self, "materials")

    @property
    def drive(self) -> ConvertedTable:
        """The positive drive."""
        return ConvertedTable(self, "drive")

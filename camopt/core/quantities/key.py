"""The record of a scene's key: a sentence about it, its unit, and the values that it takes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any, Literal

from camopt.core.quantities.quantity import Quantity, column_suffix

NO_UNIT = "no unit"
"""The unit of a number that has none."""
Bounds = Mapping[str, float]
"""Allowed values of a number, by pydantic's words: ge, le, gt, lt."""
LENGTH: Bounds = {"ge": 1e-9, "le": 1e9}
ANYWHERE: Bounds = {"ge": -1e9, "le": 1e9}
POSITIVE: Bounds = {"ge": 1e-15, "le": 1e15}
NOT_NEGATIVE: Bounds = {"ge": 0, "le": 1e15}
LENGTHS = (0.1, 1e4)
"""Usual lengths [mm]."""
INSIDE_UNITS = {
    "kg": 1e-3,
    "kg·m²": 1e3,
    "N·m": 1e3,
    "N·m/rad": 1e3,
    "N·m·s/rad": 1e3,
    "deg": pi / 180,
    "GPa": 1e3,
    "Pa·s": 1e-6,
    "1/GPa": 1e-3,
    "µm": 1e-3,
}
"""Factors to the inside units mm, s, N, t, rad; a unit that is not listed has the factor 1."""


@dataclass(frozen=True)
class Key:
    """A scene's key: a sentence about it, without the full stop, and the unit of its number."""

    sentence: str
    unit: str = ""
    """Empty if the key is no number."""
    turning: str = ""
    """Unit for a motion that turns, if it is another one."""
    usual: tuple[float, float] | None = field(default=None, kw_only=True)
    """Range of values that need no warning."""
    example: Any = field(default=None, kw_only=True)
    """Value in a new scene."""
    turning_example: float | None = field(default=None, kw_only=True)

    @property
    def both_units_text(self) -> str:
        """Both units as text for readers."""
        return f"{self.unit}, oscillating {self.turning}" if self.turning else self.unit

    def example_of(self, *, angular: bool) -> Any:
        """Example for a motion that turns, or slides."""
        return self.turning_example if angular and self.turning_example is not None else self.example

    def unit_of(self, *, angular: bool) -> str:
        """Unit for a motion that turns, or slides."""
        return self.turning if angular and self.turning else self.unit

    def column_unit(self, *, angular: bool) -> str:
        """Unit in tables of designs; empty for a number without a unit."""
        return self.unit_of(angular=angular).replace(NO_UNIT, "")


@dataclass(frozen=True, kw_only=True)
class NumberKey(Key):
    """A key of a number that effects read and that tables of designs have as a column."""

    key: str
    columns: tuple[tuple[str, str, str], ...] = ()
    """Name, symbol and sentence of the quantity in tables; the second for a motion that turns. A stage has none."""
    allowed: Bounds = field(default_factory=lambda: POSITIVE)
    default: float | None = None
    """Value if the scene does not give one."""
    motion_of: Literal["follower", "spring", "tool"] = "follower"
    """The body whose motion decides whether the number is about a rotation."""
    read_by: tuple[str, ...] = ()
    """Effects that read the number."""
    slides: bool = False
    """Whether only translating followers have it."""
    turns: bool = False
    """Whether only oscillating followers have it."""
    guide: bool = False
    """Whether it belongs to the guide."""

    @property
    def name(self) -> str:
        """Name of the key in its table."""
        return self.key.rpartition(".")[2]

    @property
    def table(self) -> str:
        """Table of the scene that has the key."""
        return self.key.rpartition(".")[0]

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities in tables; the second is for a motion that turns."""
        return tuple(
            Quantity(name, symbol, self.column_unit(angular=turns), "sizes", text)
            for (name, symbol, text), turns in zip(self.columns, (False, True), strict=False)
        )

    def to_inside_units(self, value: Any, *, angular: bool) -> Any:
        """The value in the inside units mm, s, N, t, rad."""
        return value * INSIDE_UNITS.get(self.unit_of(angular=angular), 1.0)


@dataclass(frozen=True, kw_only=True)
class LimitKey(Key):
    """A short key of ``[limits]``."""

    key: str
    quantity: str = ""
    """The quantity that it bounds; "" if it bounds several, or if the scene decides."""
    allowed: Bounds = field(default_factory=lambda: POSITIVE)

    def bounded_quantity_name(self, *, angular: bool) -> str:
        """The quantity that it bounds, for a motion that turns, or slides."""
        if not (angular and self.turning):
            return self.quantity
        return self.quantity.removesuffix(column_suffix(self.unit)) + column_suffix(self.turning)

"""The record of a key of a scene: what the key is, its unit, and all else that camopt knows of it by itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any, Literal

from camopt.core.quantities.quantity import Quantity, column_suffix

NO_UNIT = "no unit"
"""The unit of a number that has none."""
Bounds = Mapping[str, float]
"""What a number may be, by the words of pydantic: ge, le, gt, lt."""
LENGTH: Bounds = {"ge": 1e-9, "le": 1e9}
ANYWHERE: Bounds = {"ge": -1e9, "le": 1e9}
POSITIVE: Bounds = {"ge": 1e-15, "le": 1e15}
NOT_NEGATIVE: Bounds = {"ge": 0, "le": 1e15}
LENGTHS = (0.1, 1e4)
"""Usual lengths, mm."""
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
"""What one of a unit is in mm, s, N, t, rad; 1 of a unit that is not named."""


@dataclass(frozen=True)
class Key:
    """What a key of a scene is, in a sentence without its full stop, and the unit of its number."""

    sentence: str
    unit: str = ""
    """Empty for what is no number."""
    turning: str = ""
    """The unit where what the key is about turns, if that is another one."""
    usual: tuple[float, float] | None = field(default=None, kw_only=True)
    """From where to where a value raises no question."""
    example: Any = field(default=None, kw_only=True)
    """What a scene to start from has of it."""
    turning_example: float | None = field(default=None, kw_only=True)

    @property
    def units(self) -> str:
        """Both units, as people read them."""
        return f"{self.unit}, oscillating {self.turning}" if self.turning else self.unit

    def example_of(self, *, turns: bool) -> Any:
        """The example where what the key is about turns, or slides."""
        return self.turning_example if turns and self.turning_example is not None else self.example

    def unit_of(self, *, turns: bool) -> str:
        """The unit where what the key is about turns, or slides."""
        return self.turning if turns and self.turning else self.unit

    def column_unit(self, *, turns: bool) -> str:
        """That unit as tables of designs have it: empty where there is none."""
        return self.unit_of(turns=turns).replace(NO_UNIT, "")


@dataclass(frozen=True, kw_only=True)
class NumberKey(Key):
    """A key of a number that effects read, and that tables of designs have in a column."""

    key: str
    columns: tuple[tuple[str, str, str], ...] = ()
    """Name, symbol and sentence of its quantity in tables, of two the second where it turns; none of a stage's."""
    allowed: Bounds = field(default_factory=lambda: POSITIVE)
    default: float | None = None
    """What it is where a scene does not give it."""
    motion_of: Literal["follower", "spring", "tool"] = "follower"
    """What decides whether it turns."""
    read_by: tuple[str, ...] = ()
    """The effects that read it."""
    slides: bool = False
    """Whether followers that translate alone have it."""
    turns: bool = False
    """Whether followers that oscillate alone have it."""
    guide: bool = False
    """Whether it is of the guide."""

    @property
    def name(self) -> str:
        """Its name in its table."""
        return self.key.rpartition(".")[2]

    @property
    def table(self) -> str:
        """The table that it is in."""
        return self.key.rpartition(".")[0]

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities that it is in tables, the second where it turns."""
        rows = zip(self.columns, (False, True), strict=False)
        return tuple(Quantity(*each[:2], self.column_unit(turns=turns), "sizes", each[2]) for each, turns in rows)

    def to_inside_units(self, value: Any, *, turns: bool) -> Any:
        """A value in mm, s, N, t, rad."""
        return value * INSIDE_UNITS.get(self.unit_of(turns=turns), 1.0)


@dataclass(frozen=True, kw_only=True)
class LimitKey(Key):
    """A short key of ``[limits]``."""

    key: str
    quantity: str = ""
    """The quantity that it bounds; "" of one that bounds several, or depends on the scene."""
    allowed: Bounds = field(default_factory=lambda: POSITIVE)

    def quantity_of(self, *, turns: bool) -> str:
        """The quantity that it bounds where what is asked to move turns, or slides."""
        if not (turns and self.turning):
            return self.quantity
        return self.quantity.removesuffix(column_suffix(self.unit)) + column_suffix(self.turning)

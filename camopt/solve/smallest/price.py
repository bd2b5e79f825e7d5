"""Prices of active limits (shadow prices), and their table."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar
from warnings import warn

from camopt.core.quantities.unit_systems import from_shown_unit, to_shown_unit, unit_in_shown_system
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of, to_json_values

UNKNOWN_PRICE = "—"
PRICE_COLUMNS = ("limit", "value", "price", "if tightened", "size without it", "useful up to", "next limit")


@dataclass(frozen=True)
class Price:
    """The price of an active limit of a smallest cam (shadow price).

    ``price`` and ``tightened`` are derivatives: the change of the size per unit of the bound, for small changes.
    The size is the base radius (of two free discs, the larger one's), or the mean radius of a cylindrical cam.
    Prices of free laws are changes of their objective, in its unit instead of mm; the fields from ``size_without``
    on are then None.

    Attributes
    ----------
    key : str
        The bound's key in the scene, as ``limits.pressure_angle``; ``search.offset.stop`` for an end of a range,
        ``tolerances.profile`` for a tolerance.
    bound : float
        Its value. For a tolerance: the larger of its two ends, µm (deg); the price is for moving both ends.
    unit : str
        Unit of the bound.
    relation : str
        How the limited quantity must compare with the bound: ≤, ≥, or ± if its magnitude must be ≤.
    price : float or None
        Change of the size as the bound is eased, or a tolerance narrowed [mm per unit]. None if a condition
        without a value, such as no undercut, also holds the cam.
    tightened : float or None
        Change of the size as the bound is tightened [mm per unit]. It differs from ``price`` if another limit would
        hold the cam by itself.
    size_without : float or None
        Size of the smallest cam without this limit, or with a tolerance of 0 [mm]; easing the bound saves no more.
        0 if nothing else limits the size; None for an end of a range, or if it was not proved.
    holds_to : float or None
        Value of the limited quantity for the cam of ``size_without``; easing beyond it saves nothing.
    next : tuple of str or None
        The keys of the active limits of the cam of ``size_without``.

    Examples
    --------
    >>> (price,) = camopt.prices(camopt.optimise(camopt.find_scene("belt-matching")))[""]
    >>> price.bound, price.unit, price.price < 0 < price.size_without
    (30.0, 'deg', True)
    """

    key: str
    bound: float
    unit: str
    relation: str
    price: float | None
    tightened: float | None
    size_without: float | None = None
    holds_to: float | None = None
    next: tuple[str, ...] | None = None

    def to_dict(self) -> dict[str, Any]:
        """The values by name."""
        return dict(to_json_values(self))

    def to_json(self) -> dict[str, Any]:
        """The old name of ``to_dict``."""
        warn("to_json is now to_dict", DeprecationWarning, stacklevel=2)
        return self.to_dict()

    def in_words(self, unit_of_size: str = "mm") -> dict[str, str]:
        """The price as a row of texts; ``unit_of_size`` is that of the objective."""
        unit = f"{unit_in_shown_system(unit_of_size)} per {unit_in_shown_system(self.unit) or 'unit'}".lstrip()

        def price_text(value: float | None) -> str:
            if value is None:
                return UNKNOWN_PRICE
            return f"{from_shown_unit(to_shown_unit(value, unit_of_size), self.unit):.4g} {unit}".replace("-", "−")

        def bound_text(value: float | None, unit: str) -> str:
            return UNKNOWN_PRICE if value is None else with_unit(value, unit).replace("-", "−")

        return {
            "limit": self.key,
            "value": f"{self.relation} {bound_text(self.bound, self.unit)}",
            "price": price_text(self.price),
            "if tightened": "" if self.tightened == self.price else price_text(self.tightened),
            "size without it": bound_text(self.size_without, "mm"),
            "useful up to": bound_text(self.holds_to, self.unit),
            "next limit": UNKNOWN_PRICE if self.next is None else ", ".join(self.next) or "nothing",
        }


class Prices(Result, dict[str, list[Price]]):
    """The prices of the active limits, by law: a mapping, whose rows ``to_pandas`` returns."""

    main_rows: ClassVar[str] = "prices"

    def __init__(self, prices: Mapping[str, list[Price]], unit_of_size: str = "mm") -> None:
        super().__init__(prices)
        self.unit_of_size = unit_of_size

    def values_for_json(self) -> dict[str, Any]:
        """A record for each bound of each law."""
        return {"prices": [{"law": law, **vars(price)} for law, each in self.items() for price in each]}

    def table(self) -> Table:
        """A row for each bound of each law, without empty columns."""
        rows = [price.in_words(self.unit_of_size) for each in self.values() for price in each]
        filled = [name for name in PRICE_COLUMNS if any(row[name] not in ("", UNKNOWN_PRICE) for row in rows)]
        return price_table(self, ["law", *filled] if len(self) > 1 else filled, self.unit_of_size)


def price_table(prices: Mapping[str, Iterable[Price]], names: Iterable[str], unit_of_size: str = "mm") -> Table:
    """The prices of each law, in some columns."""
    rows = [{"law": law, **price.in_words(unit_of_size)} for law, each in prices.items() for price in each]
    return table_of("What each limit costs", rows, [name for name in names if any(row[name] for row in rows)])

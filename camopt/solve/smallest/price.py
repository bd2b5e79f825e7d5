"""The price of a bound, and a table of several."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar
from warnings import warn

from camopt.core.quantities.unit_systems import from_shown_unit, shown_unit, to_shown_unit
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.result import Result, Table, table_of, to_json_values

UNKNOWN_PRICE = "—"
PRICE_COLUMNS = ("bound", "as set", "price", "tightened", "size without it", "holds to", "then held by")


@dataclass(frozen=True)
class Price:
    """The price of a bound that a smallest cam just meets.

    ``price`` and ``tightened`` are derivatives: how the size (base radius, of two free discs that of the larger
    one, or mean radius of a cylindrical cam) changes per unit of the bound, for small changes. Those of free laws
    are of what these minimise, in its unit in place of mm, and have no cam without the bound.

    Attributes
    ----------
    key : str
        The bound's key in the scene, as ``limits.pressure_angle``; ``search.offset.stop`` for an end of a range,
        ``tolerances.profile`` for a tolerance.
    bound : float
        Its value; of a tolerance the larger of its ends, µm (deg): with the price both ends go out or in.
    unit : str
        Of the bound.
    relation : str
        How what is bounded must compare with the bound: ≤, ≥ or ±, where its magnitude must be ≤.
    price : float or None
        mm per unit, as the bound is eased, a tolerance narrowed; None where something that has no bound holds the
        cam as well.
    tightened : float or None
        mm per unit, as the bound is tightened: not ``price`` where another bound would be enough to hold the cam.
    size_without : float or None
        The size of the smallest cam without this limit, or with a tolerance of 0, mm: easing it saves no more. 0
        where nothing else limits the size; None where it was not sought (an end of a range), or not proved in time.
    holds_to : float or None
        What the cam of ``size_without`` has of what is bounded: beyond it, easing saves nothing more.
    next : tuple of str or None
        The keys of what the cam of ``size_without`` just meets, bounds or what every cam must hold.

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
        """The price as a row of texts, with the unit of what is minimised."""
        unit = f"{shown_unit(unit_of_size)} per {shown_unit(self.unit) or 'unit'}".lstrip()

        def cost(value: float | None) -> str:
            if value is None:
                return UNKNOWN_PRICE
            return f"{from_shown_unit(to_shown_unit(value, unit_of_size), self.unit):.4g} {unit}".replace("-", "−")

        def amount(value: float | None, unit: str) -> str:
            return UNKNOWN_PRICE if value is None else with_unit(value, unit).replace("-", "−")

        return {
            "bound": self.key,
            "as set": f"{self.relation} {amount(self.bound, self.unit)}",
            "price": cost(self.price),
            "tightened": "" if self.tightened == self.price else cost(self.tightened),
            "size without it": amount(self.size_without, "mm"),
            "holds to": amount(self.holds_to, self.unit),
            "then held by": UNKNOWN_PRICE if self.next is None else ", ".join(self.next) or "nothing",
        }


class Prices(Result, dict[str, list[Price]]):
    """The prices of the bounds of each law: a mapping, whose rows ``to_pandas`` gives."""

    main_rows: ClassVar[str] = "prices"

    def __init__(self, prices: Mapping[str, list[Price]], unit_of_size: str = "mm") -> None:
        super().__init__(prices)
        self.unit_of_size = unit_of_size

    def document(self) -> dict[str, Any]:
        """A record for each bound of each law."""
        return {"prices": [{"law": law, **vars(price)} for law, each in self.items() for price in each]}

    def table(self) -> Table:
        """A row for each bound of each law, without columns in which nothing is known."""
        rows = [price.in_words(self.unit_of_size) for each in self.values() for price in each]
        known = [name for name in PRICE_COLUMNS if any(row[name] not in ("", UNKNOWN_PRICE) for row in rows)]
        return price_table(self, ["law", *known] if len(self) > 1 else known, self.unit_of_size)


def price_table(prices: Mapping[str, Iterable[Price]], names: Iterable[str], unit_of_size: str = "mm") -> Table:
    """The prices of each law, in some columns."""
    rows = [{"law": law, **price.in_words(unit_of_size)} for law, each in prices.items() for price in each]
    return table_of("What each bound costs", rows, [name for name in names if any(row[name] for row in rows)])

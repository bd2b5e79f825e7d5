"""The result of ``optimise``: the smallest cam of each law, its active limits, and what these cost."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any, ClassVar

from camopt.core.mistakes import NOTHING_FEASIBLE
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.scene.unusual_values import missing_wall_notes
from camopt.solve.smallest.price import PRICE_COLUMNS, UNKNOWN_PRICE, Price, price_table
from camopt.solve.tables.cells import with_unit
from camopt.solve.tables.designs import (
    Design,
    designs_table,
    nearest_miss_sections,
    shown_law_columns,
    with_rise_law_as_law_column,
)
from camopt.solve.tables.result import Result, Table, to_json_values

LARGEST_FAILS = "the largest cam tried does, or cannot be assembled"


@dataclass(frozen=True)
class Optimum(Result):
    """The smallest cam of each law (``by_law``), and the smallest of all (``best``).

    Each ``Design`` is a mapping from quantity to value, and has a ``scene``. Besides the quantities that the scene
    calls for, it has:

    - ``binding``: the active limits, which keep the cam from being smaller;
    - ``proved``: whether camopt proved that no feasible design of that law is smaller by more than 1e-9 of the
      prime radius. If both discs of a pair have a range, this is proved of the larger disc, and of the smaller one
      beside it;
    - ``gap_mm``: by how much a feasible design might be smaller;
    - ``angles_deg``: the angles of all segments, if ``[search]`` varies some;
    - ``every_cam``, with ``search.robust``: whether every cam within the tolerances meets every limit: held (proved
      over the whole box), undecided, or broken (the search met no design whose cams all meet them);
    - ``nominal_mm``, with ``search.robust``: the size of the smallest cam without tolerances. ``nominal_proved``
      says whether this size is proved. ``safety_mm`` is by how much the robust cam is larger: what safety costs;
    - ``clear_above_mm``: all larger designs that were tried above this size are feasible. It exceeds the optimum if
      larger cams break a limit again, and is infinite if large cams fail, as with oscillating followers.

    Attributes
    ----------
    scene : Scene
        The scene that was solved.
    best : Design or None
        The smallest cam of all; None if no law has a feasible design.
    by_law : dict
        The smallest cam of each law, the smallest first.
    obstacles : dict
        For each law without a feasible design, the limits that prevent one.
    nearest_miss : Design or None
        If no law has a feasible design: the design that breaks its limits the least; ``violated`` names them.
        If ``out_of_time``: the best of the designs tried so far.
    out_of_time : bool
        Whether a search stopped early, so that its answer is not proved.
    warnings : tuple of str
        Warnings on the best cam, like those of an ``Evaluation``.
    prices : dict or None
        The prices of each law (``camopt.prices``) if they were computed, as the command does.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(**{"search.law": ["cycloidal"]})
    >>> optimum = camopt.optimise(scene)
    >>> optimum.best["binding"], optimum.best["gap_mm"] < 1e-6
    (['pressure_angle', 'pressure_angle_return'], True)
    """

    scene: Scene
    best: Design | None
    by_law: dict[str, Design]
    obstacles: dict[str, str]
    nearest_miss: Design | None
    out_of_time: bool = False
    warnings: tuple[str, ...] = ()
    prices: dict[str, list[Price]] | None = None
    main_rows: ClassVar[str] = "by_law"

    def __repr__(self) -> str:
        what = repr(self.best).removeprefix("<").removesuffix(">") if self.best else "no feasible design"
        return f"<Optimum of {self.scene.name}: {len(self.by_law)} laws; {what}>"

    def table(self) -> Table | None:
        """The smallest cam of each law with its active limits; with its gap, if some cam is not proved."""
        rows = with_rise_law_as_law_column(self.by_law.values())
        if not rows:
            return None
        for row in rows:
            if "angles_deg" in row:
                row["angles_deg"] = " ".join(f"{angle:.6g}" for angle in row["angles_deg"])
        last = ["every_cam", "nominal_mm", "safety_mm"] if any("nominal_mm" in row for row in rows) else []
        last += ["binding", *(["angles_deg"] if any("angles_deg" in row for row in rows) else [])]
        last += [] if all(row["proved"] for row in rows) else ["proved", "gap_mm"]
        title = f"{self.scene.name}: the smallest cam{' of each law' if shown_law_columns(rows) else ''}"
        return designs_table(title, resolve(self.scene), rows, last)

    def sections(self) -> Iterator[Table | str]:
        """The smallest cam of each law, the proofs that are missing, and prices; or the nearest miss."""
        name = self.scene.name
        if best := self.table():
            yield best
        for law, obstacle in self.obstacles.items():
            yield f"{law or name}: no feasible design; stopped by {obstacle}"
        for law, row in self.by_law.items():
            if not row["proved"]:
                less = with_unit(row["gap_mm"], "mm")
                yield f"{law or name}: not proved; a feasible cam may be smaller by up to {less}"
            if not row.get("nominal_proved", True):
                yield f"{law or name}: the smallest nominal cam is not proved; a smaller one may exist"
        yield from self._larger_cam_sentences()
        if self.out_of_time:
            yield "The search stopped before a proof; more `seconds` may prove this cam or find a smaller one."
        if any((self.prices or {}).values()):
            yield from self._price_sections(self.prices or {})
        if self.nearest_miss and self.out_of_time:
            yield from nearest_miss_sections(
                self.nearest_miss, "No feasible design before the search stopped. Nearest miss so far:"
            )
        elif self.nearest_miss:
            yield from nearest_miss_sections(self.nearest_miss)

    def _larger_cam_sentences(self) -> Iterator[str]:
        size_name = resolve(self.scene).size_quantity_name
        for law, row in self.by_law.items():
            clear = row["clear_above_mm"]
            if clear > row[size_name]:
                tried = f"all cams tried above {with_unit(clear, 'mm')} meet the limits"
                tried = tried if isfinite(clear) else LARGEST_FAILS
                late = " (the search stopped before all were tried)" if self.out_of_time else ""
                yield f"{law or self.scene.name}: larger cams may break a limit again{late}; {tried}."

    def _price_sections(self, prices: dict[str, list[Price]]) -> Iterator[Table | str]:
        """The price of each active limit, the size of the cam without it, and the next limits."""
        yield ""
        yield price_table(prices, ["law", *PRICE_COLUMNS] if len(prices) > 1 else PRICE_COLUMNS)
        all_prices = [price for each in prices.values() for price in each]
        ranges = [price for price in all_prices if price.key.startswith("search.")]
        if any(price.price is None or price.tightened is None for price in all_prices):
            why = "a condition without a value, such as no undercut, also holds the cam"
            yield f"{UNKNOWN_PRICE} in a price: not known, because {why}."
        if any(price.next is None and price not in ranges for price in all_prices):
            late = "not proved before the search stopped; more `seconds` may do"
            yield f"{UNKNOWN_PRICE} in the size without a limit or tolerance: {late}."
        if any(price.next is None for price in ranges):
            yield f"{UNKNOWN_PRICE} in the size without the end of a range: not computed."

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings, and thin walls."""
        thin = missing_wall_notes(self.scene, self.best.get("base_radius_mm")) if self.best else ()
        return (*self.warnings, *thin)

    def values_for_json(self) -> dict[str, Any]:
        """The best design, the designs of each law, the obstacles and the prices."""
        return {
            **to_json_values(next(iter(self.by_law.values()), {})),
            "by_law": self.by_law,
            "obstacles": self.obstacles,
            "nearest_miss": self.nearest_miss,
            "out_of_time": self.out_of_time,
            **({} if self.prices is None else {"prices": self.prices}),
            **({"warnings": self.warnings} if self.warnings else {}),
        }

    @property
    def relative_half_width(self) -> float:
        """The relative half-width of the best design's enclosures."""
        return float(self.best["relative_half_width"]) if self.best else 0.0

    @property
    def exit_code(self) -> int:
        """0; 1 without a feasible design; 4 where the accuracy is not reached."""
        return super().exit_code if self.best else NOTHING_FEASIBLE

    @property
    def shown_cam(self) -> Scene | None:
        """The smallest cam of all."""
        return self.best.scene if self.best else None

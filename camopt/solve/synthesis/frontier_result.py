"""The result of ``frontier``; it needs no solver."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Any

from camopt.core.mistakes import NOTHING_FEASIBLE
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.scene.scene import Scene
from camopt.solve.synthesis.problem_from_scene import default_peak_factors
from camopt.solve.synthesis.result_sentences import (
    OWN_MOVES,
    default_limits_in_words,
    defaults_unlike_synthesise_in_words,
)
from camopt.solve.synthesis.term_units import term_unit
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.designs import Design, joined_laws, shown_size_columns
from camopt.solve.tables.result import Result, Table, table_of


@dataclass(frozen=True)
class Frontier(Result, Drawable):
    """The trade-off between two or three axes; less of each is better.

    Attributes
    ----------
    scene : Scene
        The scene as given.
    axes : tuple of str
        Terms of the objective, or loads.
    rows : list of Design
        The nondominated cams with new ("free") motion laws, in the order of the first axis. Each row has the values
        of the axes, the quantities of the cam and its scene. ``bound`` is a lower bound of the first axis for any
        motion with the same values of the other axes; loads are not considered, and it is None if it was not
        computed. ``local`` says whether the cam is only a local optimum.
    known : list of Design
        The known laws, each on its smallest cam; ``within`` says whether it meets all limits that the rows meet.
    least : dict
        For each axis the least value found, and a lower bound for any motion (None for a load).
    local : tuple of str
        The axes along which the front consists of local optima, because active constraints are not convex.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> found = camopt.frontier(coarse, points=2, workers=1)
    >>> found.axes, found.local, found.rows[0]["bound"] <= found.rows[0]["size"]
    (('size', 'acceleration'), (), True)
    """

    picture = "pictures.frontier"
    main_rows = "rows"
    scene: Scene
    axes: tuple[str, ...]
    rows: list[Design]
    known: list[Design]
    least: dict[str, tuple[float, float | None]]
    local: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<Frontier of {self.scene.name}: {' and '.join(self.axes)}, {len(self.rows)} cams of free laws>"

    @property
    def units(self) -> dict[str, str]:
        """The unit of each axis, and of ``bound``."""
        units = {axis: term_unit(axis, self.scene) for axis in self.axes}
        return {**units, "bound": units[self.axes[0]]}

    def table(self) -> Table | None:
        """A table of the cams of free laws, then of known laws; * marks a law that breaks a limit on the motion."""
        rows: list[dict[str, Any]] = [{**row, "law": "free"} for row in self.rows]
        for row in self.known:
            laws = joined_laws(row["law_rise"], row["law_return"]) or OWN_MOVES
            rows.append({**row, "law": laws if row["within"] else f"{laws} *"})
        if not rows:
            return None
        sizes = [name for name in shown_size_columns(self.scene.search.sizes, rows) if not name.startswith("law")]
        shown = [{**row, "bound": "" if row.get("bound") is None else row["bound"]} for row in rows]
        return table_of(
            f"{self.scene.name}: the frontier", shown, ["law", *self.axes, "bound", *sizes], units=self.units
        )

    @property
    def shown_cam(self) -> None:
        """None: the scene is a range of cams."""
        return None

    def sections(self) -> Iterator[Table | str]:
        """The free laws along the frontier, the known laws, and the least value of each axis."""
        defaults = default_peak_factors(self.scene, self.axes)
        yield self.table() or f"{self.scene.name}: the frontier"
        yield "Each known law is on its smallest cam within the limits."
        if not all(row["within"] for row in self.known):
            yield "* breaks a limit of the free laws"
        yield from default_limits_in_words(self.scene, defaults)
        yield from defaults_unlike_synthesise_in_words(self.scene, defaults)
        for term, (least, bound) in self.least.items():
            unit = self.units[term]
            below = "lower bound for any motion within the other limits:"
            most = f"; {below} {number_text(to_shown_unit(bound, unit))}" if bound else ""
            local = " (a local optimum)" if term in self.local else ""
            yield f"Least {term}: {with_unit(least, unit)}{local}{most}"

    def values_for_json(self) -> dict[str, Any]:
        """The axes, the least value of each, and the rows of free and of known laws."""
        return {
            "scene": self.scene.name,
            "axes": self.axes,
            "local": self.local,
            "default_peaks": default_peak_factors(self.scene, self.axes),
            "least": {
                term: {"free_laws": least, "any_motion": bound, "local": term in self.local}
                for term, (least, bound) in self.least.items()
            },
            "rows": self.rows,
            "known_laws": self.known,
        }

    @property
    def exit_code(self) -> int:
        """0, or 1 if no cam is feasible."""
        return super().exit_code if self.rows else NOTHING_FEASIBLE

    @property
    def excluded(self) -> list[tuple[float, float]]:
        """The region of two axes that no motion can reach, as corners (a, b) of a staircase.

        No motion with at most a of the second axis has less than b of the first. Between two rows, the bound of the
        row with more of the second axis applies.
        """
        if len(self.axes) > 2:
            return []
        first, second = self.axes
        pairs = [(float(row[second]), row["bound"]) for row in self.rows if row["bound"] is not None]
        lowest, leftmost = self.least[first][1], self.least[second][1]
        pairs += [(inf, lowest)] if lowest else []
        pairs += [(leftmost, inf)] if leftmost else []
        corners: list[tuple[float, float]] = []
        for at, bound in sorted(pairs, reverse=True):
            if not corners or bound > corners[-1][1]:
                corners.append((at, float(bound)))
        return corners[::-1]

"""Texts and tables of a comparison: settings, designs and fronts of two results."""

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.show.comparing.scenes import differing_settings_in_shown_units
from camopt.solve.tables.cells import number_text, shown_column_name, unit_of_column
from camopt.solve.tables.designs import LAW_COLUMNS, shown_law_columns, with_rise_law_as_law_column
from camopt.solve.tables.result import Table, table_of

if TYPE_CHECKING:
    from camopt.show.comparing.compare import Comparison, TableComparison
    from camopt.show.comparing.fronts import FrontSide
    from camopt.show.comparing.scenes import ValuePair

VALUE_CHARACTERS = 60  # shown characters of a value
NOT_SET = "—"


def comparison_sections(result: "Comparison") -> Iterator[Table | str]:
    """Texts and tables of the differences, or a line that there are none."""
    yield f"A: {result.a}"
    yield f"B: {result.b}"
    if result.same:
        yield (
            "A and B are the same: designs, quantities and settings."
            if result.by_table
            else "A and B are the same."
        )
    if result.by_table and result.versions[0] != result.versions[1]:
        yield f"Written by camopt {result.versions[0]} (A) and {result.versions[1]} (B)."
    for name, only in (("A", result.only_in_a), ("B", result.only_in_b)):
        if only:
            yield f"Only in {name}: {', '.join(only)}"
    for names, pair in result.scenes.items():
        settings = differing_settings_in_shown_units(*pair).items()
        rows = [
            {"key": key, "A": _short_value_text(a), "B": _short_value_text(b), "unit": unit}
            for key, (a, b, unit) in settings
        ]
        yield ""
        yield table_of(f"Settings that differ ({names})", rows, ["key", "A", "B", "unit"])
    for names, cam in result.cams.items():
        yield ""
        yield from _quantity_sections(names, cam)
    for name, table in result.by_table.items():
        yield ""
        yield from _design_sections(name, table)
        yield from _front_sections(table)


def _short_value_text(value: Any) -> str:
    """A value of a scene as text of a cell."""
    if value is None:
        return NOT_SET
    text = ", ".join(map(number_text, value)) if isinstance(value, list) else number_text(value)
    return text if len(text) <= VALUE_CHARACTERS else f"{text[:VALUE_CHARACTERS]}…"


def _value_in_shown_unit(name: str, value: Any) -> Any:
    """A value of a column in the shown unit."""
    return to_shown_unit(value, unit_of_column(name)) if isinstance(value, float) else value


def _quantity_sections(scene_names: str, value_pairs: "Mapping[str, ValuePair]") -> Iterator[Table | str]:
    """Quantities of two cams that differ, side by side."""
    if not value_pairs:
        yield f"The quantities of both cams are the same ({scene_names})."
        return
    rows = [
        {
            "quantity": shown_column_name(name),
            "A": _short_value_text(_value_in_shown_unit(name, each.a)),
            "B": _short_value_text(_value_in_shown_unit(name, each.b)),
            "B − A": "" if each.difference is None else f"{_value_in_shown_unit(name, each.difference):+.6g}",
            "relative": f"{each.difference / abs(each.a):+.1%}" if each.difference and each.a else "",
        }
        for name, each in value_pairs.items()
    ]
    yield table_of(f"Quantities that differ ({scene_names})", rows, [*rows[0]])


def _design_sections(name: str, table: "TableComparison") -> Iterator[Table | str]:
    """Numbers of designs only in A, only in B and changed; changed quantities; the best designs only in A or B."""
    in_a, in_b = table.designs
    yield f"{name}: {in_a:,} designs in A, {in_b:,} in B"
    if table.has_same_designs:
        yield "The same designs, with the same quantities."
        return
    only = f"{table.went.size:,} only in A, {table.came.size:,} only in B"
    beyond = f" ({table.beyond:,} of them beyond the accuracy)" if len(table.changed) else ""
    yield f"{only}, {len(table.changed):,} changed{beyond}"
    for side, columns in (("A", table.columns_in_a), ("B", table.columns_in_b)):
        if columns:
            yield f"Columns only in {side}: {', '.join(columns)}"
    if table.quantities:
        rows = [
            {
                "quantity": shown_column_name(name),
                "designs": change.designs,
                "beyond accuracy": change.beyond,
                "largest change": "" if change.largest is None else float(f"{change.largest:.2g}"),
                "A": _short_value_text(_value_in_shown_unit(name, change.a)),
                "B": _short_value_text(_value_in_shown_unit(name, change.b)),
            }
            for name, change in table.quantities.items()
        ]
        yield ""
        yield table_of(
            "Quantities that changed, with the values of the design with the largest relative change",
            rows,
            [*rows[0]],
        )
    for side, kind, count in (("A", "went", table.went.size), ("B", "came", table.came.size)):
        if rows := table.first[kind]:
            title = f"Designs only in {side}" + (f": {len(rows)} of {count:,}" if count > len(rows) else "")
            yield ""
            numbers = [name for name in rows[0] if name not in ("row", *LAW_COLUMNS)]
            yield table_of(title, with_rise_law_as_law_column(rows), ["row", *shown_law_columns(rows), *numbers])


def _front_sections(table: "TableComparison") -> Iterator[Table | str]:
    """Differences of the fronts, or the reason why they cannot be compared."""
    a, b = table.objectives
    if table.fronts and table.fronts.has_same_points:
        yield table.fronts.verdict_sentence
    elif table.fronts:
        yield ""
        words: dict[str, Callable[[FrontSide], str]] = {
            "points": lambda side: f"{side.points:,}",
            "hypervolume (0 to 1, higher is better)": lambda side: (
                f"{'' if side.exact else 'about '}{side.hypervolume:.6g}"
            ),
            "points dominated by the other": lambda side: _count_with_share(side.dominated, side.points),
            "points on both fronts": lambda side: _count_with_share(side.shared, side.points),
            "mean distance behind the other (IGD⁺)": lambda side: _distance_text(side.behind_mean),
            "largest distance behind the other (ε)": lambda side: _distance_text(side.behind_most),
        }
        rows = [{"": word, "A": text(table.fronts.a), "B": text(table.fronts.b)} for word, text in words.items()]
        yield table_of("The fronts, normalised by the ideal and the nadir of both", rows, ["", "A", "B"])
        yield table.fronts.verdict_sentence
    elif a != b:
        yield f"The fronts cannot be compared: A has the objectives {_objectives_text(a)}; B {_objectives_text(b)}."


def _objectives_text(objectives: dict[str, str]) -> str:
    return ", ".join(f"{aim} {name}" for name, aim in objectives.items()) or "none"


def _count_with_share(count: int, total: int) -> str:
    return f"{count:,} ({count / total:.1%})" if total else "0"


def _distance_text(value: float | None) -> str:
    return NOT_SET if value is None else f"{value:.3g}".replace("-", "−")

"""Tables of designs: a row for each, or one design down the page."""

from collections.abc import Iterable, Mapping
from typing import Any

from camopt.problem.problem import Problem
from camopt.quantities.unit_systems import shown_unit
from camopt.tables.cells import name_in_shown_unit, quantity, unit_of_column
from camopt.tables.columns import TableRow, bounds_shown, columns_of, own_units
from camopt.tables.layout import ABOUT, VALUE, Cell, Table, table_of


def designs_table(
    title: str, problem: Problem, rows: Iterable[TableRow], last: Iterable[str] = (), asked: Iterable[str] = ()
) -> Table:
    """A row for each design: sizes, wanted quantities, and further columns; lists become texts."""
    shown = [{name: _words(value) for name, value in row.items()} for row in rows]
    names = [*columns_of(problem, shown, asked), *last]
    return table_of(title, shown, names, bounds_shown(problem), own_units(problem))


def _words(value: Any) -> Any:
    return ", ".join(value) if isinstance(value, list) and all(isinstance(each, str) for each in value) else value


def design_table(title: str, problem: Problem, design: TableRow, about: Mapping[str, str | Cell]) -> Table:
    """One design down the page: name, value, unit and meaning of each quantity, and limits if there are any.

    A narrow terminal leaves meanings out, but not those that are cells of words.
    """
    bounds, units = bounds_shown(problem), own_units(problem)
    rows: list[list[str | Cell]] = []
    for name, text in about.items():
        unit = unit_of_column(name, units.get(name))
        limit = [bounds.get(name, "")] if bounds else []
        value = quantity(name, design[name], unit).replace(",", ", ")
        rows.append([name_in_shown_unit(name, unit), value, shown_unit(unit), *limit, text])
    heads = [Cell(""), Cell("", VALUE), Cell(""), *([Cell("")] if bounds else []), Cell("", ABOUT)]
    return Table.of(title, heads, rows)

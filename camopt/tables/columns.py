"""Tables of designs, a row for each or one down the page: the quantities that they show, and limits beside them."""

from collections.abc import Container, Iterable, Mapping, Sequence
from typing import Any

from camopt.effects import quantity_of
from camopt.problem.problem import Problem
from camopt.quantities import QUANTITIES, in_order
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.scene.design_rows import DERIVED
from camopt.tables.cells import name_in_shown_unit, quantity, unit_of_column
from camopt.tables.layout import ABOUT, VALUE, Cell, Table, table_of

TableRow = Mapping[str, Any]
WHOLE_TURN, STROKE_ANGLES = (
    "pressure_angle_max_deg",
    ("pressure_angle_max_rise_deg", "pressure_angle_max_return_deg"),
)
LAW_COLUMNS = ("law_rise", "law_return")


def bounds_shown(problem: Problem) -> dict[str, str]:
    """The limit on each quantity, as "≤ 30"; of several on one quantity, the first."""
    found: dict[str, str] = {}
    for limit in problem.limits:
        for name in limit.shown:
            bound = shown(limit.bound, quantity_of(name, limit.setup).unit)
            found.setdefault(name, f"{limit.relation} {bound:g}".replace("-", "−"))
    on_parts = {found.get(name) for name in STROKE_ANGLES}
    if len(on_parts) == 1 and None not in on_parts:
        found[WHOLE_TURN] = found[STROKE_ANGLES[0]]
    return found


def own_units(problem: Problem) -> dict[str, str]:
    """The units of the scene's own quantities, by name."""
    return {name: each.unit for name, each in problem.setup.own.items()}


def columns_of(problem: Problem, rows: Iterable[TableRow], asked: Iterable[str] = ()) -> list[str]:
    """Sizes, then wanted quantities: objectives, limited quantities and outputs; none that is 0 throughout.

    A law on rises and returns alike is one column, ``law``; so is a pressure angle that is asked over the turn.
    """
    rows, bounds = list(rows), bounds_shown(problem)
    outputs = problem.wanted - problem.needed if problem.outputs else problem.setup.own.keys()
    asked = [*asked, *in_order(outputs)]
    twice = {WHOLE_TURN} - {*asked} or {*STROKE_ANGLES} - {*asked}
    named = dict.fromkeys([*asked, *(name for name in bounds if WHOLE_TURN not in bounds or name not in twice)])
    searched = [each.name for each in problem.choices.sizes]
    shown = [name for name in named if name in rows[0] and not is_nothing(searched, name, rows)]
    sizes = sizes_shown(searched, rows)
    return [*sizes, *(name for name in shown if name not in sizes)]


def sizes_shown(searched: Container[str], rows: Iterable[TableRow]) -> list[str]:
    """The sizes worth a column: no law twice, no sum or difference of others, none that is 0 and not searched.

    ``searched`` are the keys of the sizes in ``[search]``.
    """
    rows = list(rows)
    sizes = [name for name in rows[0] if name in QUANTITIES and QUANTITIES[name].effect == "sizes"]
    kept = [name for name in sizes if name not in DERIVED and not is_nothing(searched, name, rows)]
    return [*laws_shown(rows), *(name for name in kept if name not in LAW_COLUMNS)]


def laws_shown(rows: Iterable[TableRow]) -> list[str]:
    """The columns of laws: one if rises and returns have the same, none if the motion is made of moves only."""
    rows = list(rows)
    if any(row["law_rise"] != row["law_return"] for row in rows):
        return list(LAW_COLUMNS)
    return ["law"] if any(row["law_rise"] for row in rows) else []


def joined_laws(rise: str, fall: str) -> str:
    """The laws of rises and returns as one name: once if they are the same, empty if there are only moves."""
    return " / ".join(filter(None, dict.fromkeys((rise, fall))))


def with_law(rows: Iterable[TableRow]) -> list[dict[str, Any]]:
    """Rows with the column ``law``."""
    return [{"law": row["law_rise"], **row} for row in rows]


def axes_of(names: Sequence[str]) -> list[str]:
    """The columns of a frontier that are its axes; none of another table."""
    if not {"free", "bound"} <= {*names}:
        return []
    return list(names[names.index("free") + 1 : names.index("bound")])


def is_nothing(searched: Container[str], name: str, rows: Iterable[TableRow]) -> bool:
    """Whether a quantity is 0, or an empty name, in all designs: a roller radius of a knife, a law of moves.

    ``searched`` are the keys of the sizes in ``[search]``.
    """
    if any(row[name] not in (0.0, "") for row in rows):
        return False
    effect = QUANTITIES[name].effect if name in QUANTITIES else ""
    return effect == "pressure" or (effect == "sizes" and name.removesuffix("_mm") not in searched)


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

"""What ``camopt evaluate`` prints."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rich.table import Table

from camopt.cli.terminal import print_json, room_across, show, table_of
from camopt.problem.problem import Problem, resolve
from camopt.quantities import QUANTITIES
from camopt.scene.read import numbers_read
from camopt.tables.cells import number, quantity
from camopt.tables.columns import bounds_of, is_nothing

if TYPE_CHECKING:
    from camopt.verdicts.evaluation import Evaluation


def show_evaluation(result: "Evaluation", as_json: bool) -> None:
    """Every quantity of a design, one a line."""
    if as_json:
        return print_json(result.to_json())
    names = [name for name in result if not is_nothing(result.scene.search.sizes, name, [result])]
    explained = room_across() >= ROOM_TO_EXPLAIN
    about = {n: result.unbounded.get(n) or (QUANTITIES[n].sentence if explained else "") for n in names}
    show(design_table(result.scene.name, resolve(result.scene), result, about))
    if read := numbers_read(result.scene):
        rows = [{"key": each.key, "value": as_read(each.value), "unit": each.unit} for each in read]
        show("", table_of("Numbers of the scene, as they are read", rows, ["key", "value", "unit"]))
    return None


def as_read(value: Any) -> str:
    """A number of the scene; of a load that changes, how many rows it has."""
    return number(value) if isinstance(value, float) else f"{len(value):,} rows"


ROOM_TO_EXPLAIN = 110  # columns of a screen: on a narrower one each sentence would be a column of single words


def design_table(title: str, problem: Problem, design: Mapping[str, Any], about: Mapping[str, str]) -> Table:
    """One design as a table down the page: name, value, unit, limit, and a word about each quantity."""
    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    bounds = bounds_of(problem)
    table.add_column(no_wrap=True)
    table.add_column(style="bold", justify="right")
    table.add_column(no_wrap=True)
    if bounds:
        table.add_column(no_wrap=True)
    table.add_column(style="dim")
    for name, text in about.items():
        limit = [bounds.get(name, "")] if bounds else []
        unit = QUANTITIES[name].unit if name in QUANTITIES else ""
        table.add_row(name, quantity(name, design[name]).replace(",", ", "), unit, *limit, text)
    return table

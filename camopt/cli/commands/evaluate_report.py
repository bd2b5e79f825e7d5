"""The output of ``camopt evaluate``."""

from typing import TYPE_CHECKING, Any

from camopt.cli.terminal import print_json, room_across, show
from camopt.scene.read import numbers_read
from camopt.tables.cells import number
from camopt.tables.layout import table_of

if TYPE_CHECKING:
    from camopt.verdicts.evaluation import Evaluation


def show_evaluation(result: "Evaluation", as_json: bool) -> None:
    """Every quantity of a design, one a line."""
    if as_json:
        return print_json(result.to_json())
    show(result.table(explained=room_across() >= ROOM_TO_EXPLAIN))
    if read := numbers_read(result.scene):
        rows = [{"key": each.key, "value": as_read(each.value), "unit": each.unit} for each in read]
        show("", table_of("Numbers of the scene, as they are read", rows, ["key", "value", "unit"]))
    return None


def as_read(value: Any) -> str:
    """A number of the scene; of a load that changes, how many rows it has."""
    return number(value) if isinstance(value, float) else f"{len(value):,} rows"


ROOM_TO_EXPLAIN = 110  # columns of a screen: on a narrower one each sentence would be a column of single words

"""The output of ``camopt keys`` and of ``camopt schema``."""

from itertools import groupby

from camopt.cli.terminal import print_json, show
from camopt.scene.keys import Key, found_keys
from camopt.scene.places import table_heading
from camopt.scene.schema import TABLES, scene_schema
from camopt.tables.layout import ABOUT, Cell, Table


def show_schema() -> None:
    """The JSON Schema of scenes."""
    print_json(scene_schema())


def show_keys(name: str | None, as_json: bool) -> None:
    """The keys of a table or of all, table by table."""
    found = found_keys(name)
    if as_json:
        return print_json([key._asdict() for key in found])
    for table, keys in groupby(found, lambda key: key.table):
        what = (TABLES[table].__doc__ or "").split("\n")[0]
        show(Table.of(f"{table_heading(table)}  {what}" if table else "At the top", HEADS, map(_row, keys)))
    return None


HEADS: list[Cell | str] = ["key", "unit", "allowed", "if not given", Cell("what it is", ABOUT)]


def _row(key: Key) -> list[Cell | str]:
    default = "needed" if key.needed else str(key.default).lower() if isinstance(key.default, bool) else key.default
    return [key.key, key.unit, key.allowed, "" if default is None else str(default), Cell(key.sentence, ABOUT)]

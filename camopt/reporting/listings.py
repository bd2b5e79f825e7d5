"""Lists of the keys of a scene and of the shipped scenes."""

import tomllib
from itertools import groupby

from camopt.scene.keys import KeyInWords, found_keys
from camopt.scene.places import table_heading
from camopt.scene.schema import TABLES
from camopt.scene.sources import shipped_scenes, shipped_toml
from camopt.tables.layout import ABOUT, Cell, Table, table_of
from camopt.tables.result import Listing

KEY_HEADS: list[Cell | str] = ["key", "unit", "allowed", "if not given", Cell("what it is", ABOUT)]


def list_keys(name: str | None) -> Listing:
    """The keys of a table or of all, table by table."""
    keys = found_keys(name)
    return Listing(keys, tuple(_key_table(table, [*each]) for table, each in groupby(keys, lambda key: key.table)))


def _key_table(table: str, keys: list[KeyInWords]) -> Table:
    """The keys of one table."""
    what = (TABLES[table].__doc__ or "").split("\n")[0]
    return Table.of(f"{table_heading(table)}  {what}" if table else "At the top", KEY_HEADS, map(_key_row, keys))


def _key_row(key: KeyInWords) -> list[Cell | str]:
    """A key as a row."""
    default = "needed" if key.needed else str(key.default).lower() if isinstance(key.default, bool) else key.default
    return [key.key, key.unit, key.allowed, "" if default is None else str(default), Cell(key.sentence, ABOUT)]


def list_scenes() -> Listing:
    """The shipped scenes with their titles."""
    records = [{"name": each, "title": tomllib.loads(shipped_toml(each))["name"]} for each in shipped_scenes()]
    return Listing(records, (table_of("Shipped scenes", records, ["name", "title"]),))

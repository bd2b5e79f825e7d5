"""Read columns of numbers from CSV files, with plain messages for any other file."""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from camopt.core.mistakes import BadInput
from camopt.core.storage.files import decode_user_text, read_bytes

MOST_SPANS = 2000  # points of a law or rows of a load; every span between two is a panel in every kernel
NO_PREFIXES: Mapping[str, str] = {}
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}


def read_csv_columns(
    folder: Path | None,
    name: str,
    column_names: tuple[str, ...],
    allowed_prefixes: Mapping[str, str] = NO_PREFIXES,
    text_column: str = "",
) -> dict[str, list[Any]]:
    """Columns of numbers of a CSV file, by name; a ValueError says what is wrong with the file.

    ``name`` is relative to ``folder``; None if the scene may not name files. ``allowed_prefixes`` are texts allowed
    before the numbers of a column, such as IT before a grade. ``text_column`` has texts in place of numbers.
    """
    if folder is None:
        raise ValueError("must be the data: a scene inside a table cannot name files")
    try:
        return _parse_columns(
            decode_user_text(read_bytes(folder / name)), column_names, allowed_prefixes, text_column
        )
    except (OSError, BadInput, ValueError, csv.Error) as trouble:
        reason = trouble.strerror if isinstance(trouble, OSError) else trouble
        if isinstance(trouble, BadInput):
            reason = f"must be {trouble.mistakes[0].allowed}"
        raise ValueError(f"must be a CSV file with columns {' and '.join(column_names)}: {reason}") from None


def csv_column_names(folder: Path, name: str) -> tuple[str, ...]:
    """The names of the columns of a CSV file; a ValueError says why it cannot be read."""
    try:
        return tuple(
            each.strip() for each in next(csv.reader(decode_user_text(read_bytes(folder / name)).splitlines()), [])
        )
    except OSError as trouble:
        raise ValueError(f"must be a CSV file: {trouble.strerror}") from None
    except BadInput as trouble:
        raise ValueError(f"must be {trouble.mistakes[0].allowed}") from None


def _parse_columns(
    text: str, column_names: tuple[str, ...], allowed_prefixes: Mapping[str, str], text_column: str
) -> dict[str, list[Any]]:
    rows = csv.reader(text.splitlines())
    names = [name.strip() for name in next(rows, [])]
    absent = [name for name in column_names if name not in names]
    if absent:
        separator = next((word for sign, word in SEPARATORS.items() if sign in text.partition("\n")[0]), None)
        why = f"its columns are separated by {separator}, not by commas" if separator else ""
        raise ValueError(why or f"its first line has no {' and no '.join(absent)}")
    columns: dict[str, list[Any]] = {name: [] for name in column_names}
    for row in filter(None, rows):
        if len(row) > len(names):
            count = f"{len(row)} values for {len(names)} columns"
            raise ValueError(f"line {rows.line_num} has {count}; write decimals with a point, not a comma")
        for name in column_names:
            text = row[names.index(name)].strip() if names.index(name) < len(row) else ""
            text = text.removeprefix(allowed_prefixes.get(name, ""))
            columns[name].append(text if name == text_column else _cell_number(text, name, rows.line_num))
        if len(columns[column_names[0]]) > MOST_SPANS:
            raise ValueError(f"has more than {MOST_SPANS} rows")
    return columns


def _cell_number(text: str, name: str, line: int) -> float:
    """The number of a cell."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"line {line} has no number for {name}: {text!r}") from None

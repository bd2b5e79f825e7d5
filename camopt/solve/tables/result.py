"""Results of commands, which a terminal, a notebook, a page and ``--json`` show, and their tables.

A table has a title, headings, rows and a note, all of them texts, so that every output shows the same.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple
from warnings import warn

import numpy as np

from camopt.core.mistakes import NOT_REACHED, UnknownName, suggest_names
from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.display import HasHtml
from camopt.solve.tables.cells import column_heading, quantity_text

if TYPE_CHECKING:
    import pandas as pd


WORDS, NUMERIC, VALUE, ABOUT = "", "number", "value", "about"
"""Kinds of column: words, numbers, values of any length (bold), and sentences about the other columns."""


class Cell(NamedTuple):
    """A text in a table and its kind: that of its column, or a verdict."""

    text: str
    kind: str = WORDS


class FileLine(str):
    """A line that begins with a file name; it is never wrapped."""

    __slots__ = ()


@dataclass(frozen=True)
class Branch:
    """A line of a tree, with the branches below it."""

    text: str
    branches: tuple["Branch", ...] = ()

    @classmethod
    def from_texts(cls, text: str, *branches: "Branch | str") -> "Branch":
        """Make a branch from its text, and texts or branches below it."""
        return cls(text, tuple(below if isinstance(below, Branch) else cls(below) for below in branches))


@dataclass(frozen=True)
class Table:
    """A table. A heading has one line for each word, one for the unit and one for the limit."""

    title: str
    heads: list[Cell]
    rows: list[list[Cell]]
    note: str = ""

    @classmethod
    def from_texts(
        cls, title: str, heads: Iterable[Cell | str], rows: Iterable[Iterable[Cell | str]], note: str = ""
    ) -> "Table":
        """Make a table of texts; each has the kind of its column, unless it is a ``Cell``."""
        tops = [head if isinstance(head, Cell) else Cell(head) for head in heads]
        cells = [
            [text if isinstance(text, Cell) else Cell(text, top.kind) for text, top in zip(row, tops, strict=True)]
            for row in rows
        ]
        return cls(title, tops, cells, note)

    def __str__(self) -> str:
        lines = [[head.text.replace("\n", " ").strip() for head in self.heads]] if self.is_headed else []
        lines += [[cell.text for cell in row] for row in self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        right = [head.kind == NUMERIC for head in self.heads]
        texts = (
            "  ".join(
                text.rjust(width) if numeric else text.ljust(width)
                for text, width, numeric in zip(line, widths, right, strict=True)
            ).rstrip()
            for line in lines
        )
        return "\n".join(filter(None, (self.title, *texts, self.note)))

    def without_meaning_sentences(self) -> "Table":
        """The table without the sentences about the other columns."""
        return replace(self, rows=[[Cell("") if cell.kind == ABOUT else cell for cell in row] for row in self.rows])

    @property
    def is_headed(self) -> bool:
        """Whether any column has a heading; a table without headings describes one thing line by line."""
        return any(head.text for head in self.heads)


def table_of(
    title: str,
    records: Sequence[Mapping[str, Any]],
    names: Iterable[str],
    bounds: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Table:
    """Make a table with a row for each record. Headings have the name, the unit and, with ``bounds``, the limit.

    ``units`` are the units of columns that are no quantities.
    """
    names, bounds, units = [*names], bounds or {}, units or {}
    limited = any(name in bounds for name in names)
    heads = []
    for name in names:
        words = column_heading(name, units.get(name)) + (f"\n{bounds.get(name, ' ')}" if limited else "")
        texts = all(isinstance(record.get(name, ""), str) for record in records)
        heads.append(Cell(words, WORDS if texts else NUMERIC))
    rows = ([quantity_text(name, record.get(name, ""), units.get(name)) for name in names] for record in records)
    return Table.from_texts(title, heads, rows)


BODY_SIZES = frozenset({"base_radius_mm", "mean_radius_mm"})  # sizes of a disc and of a cylinder


NAMES_SHOWN = 4  # columns that a repr names


class Result(HasHtml):
    """The result of a function of camopt, which its command prints.

    Examples
    --------
    >>> found = camopt.timing(camopt.find_scene("bucket-valve"), [1.0])
    >>> found.to_pandas()["lift"].tolist(), [table.title for table in found.tables()], found.exit_code
    ([1.0], ['Inlet valve, bucket tappet, with ramps: above a lift'], 0)
    """

    __slots__ = ()
    main_rows: ClassVar[str] = ""
    """Key of the rows that ``to_pandas`` gives by default; if empty, the values of the result are one row."""

    def sections(self) -> Iterable[Any]:
        """Tables and sentences of the result, in reading order."""
        return filter(None, (self.table(),))

    @property
    def notes(self) -> Iterable[str]:
        """Remarks on the result; commands print them to standard error."""
        return ()

    def values_for_json(self) -> Any:
        """Values of the result by key, which ``to_dict`` converts for JSON."""
        raise NotImplementedError

    def document(self) -> Any:
        """Deprecated name of ``values_for_json``."""
        warn("document is now values_for_json", DeprecationWarning, stacklevel=2)
        return self.values_for_json()

    @property
    def relative_half_width(self) -> float:
        """Largest relative error of a value."""
        return 0.0

    @property
    def half_width(self) -> float:
        """Deprecated name of ``relative_half_width``."""
        warn("half_width is now relative_half_width", DeprecationWarning, stacklevel=2)
        return self.relative_half_width

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 0 done, 1 nothing feasible, 4 less accurate than the scene asks."""
        return NOT_REACHED if self.relative_half_width > self.asked_accuracy else 0

    @property
    def asked_accuracy(self) -> float:
        """Largest relative error that the scene allows; infinite for a result without a scene."""
        scene = getattr(self, "scene", None)
        return float("inf") if scene is None else float(scene.accuracy.relative_error)

    @property
    def shown_cam(self) -> Any:
        """Scene of the cam that a notebook shows beside the tables, or None."""
        return getattr(self, "scene", None)

    @property
    def kept_tables(self) -> Iterable[str]:
        """Names of tables that ``to_pandas`` gives in addition to the rows of ``to_dict``."""
        return ()

    def table(self) -> Table | None:
        """The main table, or None."""
        return None

    def tables(self) -> tuple[Table, ...]:
        """Tables of the result, with texts in the units that are shown."""
        return tuple(part for part in self.sections() if isinstance(part, Table))

    def to_dict(self) -> Any:
        """Values that ``--json`` prints, by key; None for infinite ones, whose names are under ``unbounded``."""
        return to_json_values(self.values_for_json())

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """Rows of the result as a DataFrame. Its ``attrs`` have the units of columns and, for designs, the scene.

        Parameters
        ----------
        name : str, optional
            Key of the rows in ``to_dict``, if the result has several kinds of rows.

        Returns
        -------
        pandas.DataFrame
            One row for each record. A mapping in a record has a column for each value, such as ``shares.profile``.

        Raises
        ------
        UnknownName
            If the result has no such rows.
        """
        import pandas as pd

        document, name = self.values_for_json(), self.main_rows if name is None else name
        index: list[str] | None = None
        if isinstance(document, list):
            records = document
        elif name:
            index, records = records_under_key(document, name, self.kept_tables)
        else:
            records = [{key: value for key, value in document.items() if isinstance(value, (int, float, str))}]
        frame = pd.json_normalize([record_values(record) for record in records])
        if index is not None:
            frame.index = pd.Index(index)
        scene = getattr(self, "scene", None)
        own = getattr(scene, "quantities", {})
        units = {column: QUANTITIES[column].unit for column in frame if column in QUANTITIES}
        frame.attrs = {"units": units | {column: own[column].unit for column in frame if column in own}}
        if scene is not None and not BODY_SIZES.isdisjoint(frame.columns):  # rows of designs
            frame.attrs["scene"] = scene.to_toml()
        return frame


class Columns(Result, dict[str, Any]):
    """Columns of equal length by name: a mapping to arrays. ``to_pandas`` gives their rows.

    Parameters
    ----------
    columns : Mapping
        Arrays, or one value for all rows.
    units : Mapping, optional
        Units by column.

    Examples
    --------
    >>> points = camopt.cam_points(camopt.find_scene("roller-1000rpm"), [0, 90, 180])
    >>> points.to_pandas().shape[0], points.units["displacement_mm"]
    (3, 'mm')
    """

    def __init__(self, columns: Mapping[str, Any], units: Mapping[str, str] | None = None) -> None:
        super().__init__(columns)
        self.units = dict(units or {})

    def __repr__(self) -> str:
        rows = max((len(column) for column in self.values() if np.ndim(column)), default=0)
        names, more = [*self][:NAMES_SHOWN], len(self) - NAMES_SHOWN
        words = ", ".join(names) + (f" and {more} more columns" if more > 0 else "")
        return f"<{type(self).__name__}: {rows:,} row{'s' * (rows != 1)} of {words}>"

    def table(self) -> Table:
        """A table with a row for each point."""
        rows: list[Any] = self.to_pandas().to_dict("records")
        return table_of(f"{len(rows):,} rows", rows, [*self], units=self.units)

    def values_for_json(self) -> dict[str, Any]:
        """The columns by name."""
        return dict(self)

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """The columns as a DataFrame, with their units in ``attrs``.

        Raises
        ------
        UnknownName
            If ``name`` is given: there is only one kind of rows.
        """
        import pandas as pd

        if name is not None:
            records_under_key({}, name)
        frame = pd.DataFrame(dict(self))
        frame.attrs = {"units": self.units}
        return frame


@dataclass(frozen=True)
class Listing(Result):
    """A list of records, with the tables and sentences that show it."""

    records: list[Any]
    parts: tuple[Table | str, ...]

    def sections(self) -> tuple[Table | str, ...]:
        """Tables and sentences of the list."""
        return self.parts

    def values_for_json(self) -> list[Any]:
        """The records."""
        return self.records


def records_under_key(
    document: Mapping[str, Any], name: str, other_table_names: Iterable[str] = ()
) -> tuple[list[str] | None, list[Any]]:
    """Rows under a key of a document, and their names if they have any.

    Raises
    ------
    UnknownName
        If there are no such rows. The message names the others, with ``other_table_names``.
    """
    kinds = {key: value for key, value in document.items() if is_list_or_mapping_of_records(value)}
    if name not in [*kinds]:
        raise UnknownName(
            f"this result has no rows named {name!r}; {suggest_names(str(name), [*other_table_names, *kinds])}"
        )
    rows = kinds[name]
    return ([*rows], [*rows.values()]) if isinstance(rows, Mapping) else (None, [*rows])


def is_list_or_mapping_of_records(value: Any) -> bool:
    """Whether a value is a list of records, or a mapping of records."""
    rows = [*value.values()] if isinstance(value, Mapping) else value
    return isinstance(rows, (list, tuple)) and not is_record(rows) and all(map(is_record, rows))


def is_record(value: Any) -> bool:
    """Whether a value is a record: a mapping, a named tuple or a dataclass."""
    return isinstance(value, Mapping) or is_dataclass(value) or hasattr(value, "_asdict")


def record_values(value: Any) -> dict[str, Any]:
    """Values of a record by name."""
    if isinstance(value, Mapping):
        return dict(value)
    names = value._fields if hasattr(value, "_asdict") else [field.name for field in fields(value)]
    return {name: getattr(value, name) for name in names}


def to_json_values(value: Any) -> Any:
    """Convert a value for JSON; infinite numbers become None, with their names under ``unbounded``."""
    if is_record(value):
        record = record_values(value)
        infinite = [name for name, item in record.items() if isinstance(item, float) and isinf(item)]
        named = {"unbounded": infinite} if infinite and "unbounded" not in record else {}
        return {name: to_json_values(item) for name, item in record.items()} | named
    if isinstance(value, (list, tuple)):
        return [to_json_values(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return to_json_values(value.tolist())
    if isinstance(value, float):
        return None if isinf(value) else value
    return str(value) if isinstance(value, Path) else value

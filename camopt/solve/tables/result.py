"""Results: what a command returns, which terminal, notebook, page and ``--json`` print; and their tables.

A table is the same for every printer: title, headings, rows and note, all of them texts.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import NOT_REACHED, UnknownName, suggest_names
from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.display import HasHtml
from camopt.solve.tables.cells import heading, quantity_text

if TYPE_CHECKING:
    import pandas as pd


WORDS, NUMERIC, VALUE, ABOUT = "", "number", "value", "about"
"""Kinds of column: words, numbers, what a name has (bold, of any length), sentences about the others."""


class Cell(NamedTuple):
    """A text of a table and its kind: that of its column, or a verdict."""

    text: str
    kind: str = WORDS


class FileLine(str):
    """A line that begins with a file: however long, it stays one line, for people and programs."""

    __slots__ = ()


@dataclass(frozen=True)
class Branch:
    """A line of a tree, and the branches below it."""

    text: str
    branches: tuple["Branch", ...] = ()

    @classmethod
    def from_texts(cls, text: str, *branches: "Branch | str") -> "Branch":
        """A line above lines and other branches."""
        return cls(text, tuple(each if isinstance(each, Branch) else cls(each) for each in branches))


@dataclass(frozen=True)
class Table:
    """A table: a heading for each column, with a line for each word, for the unit and for the limit."""

    title: str
    heads: list[Cell]
    rows: list[list[Cell]]
    note: str = ""

    @classmethod
    def from_texts(
        cls, title: str, heads: Iterable[Cell | str], rows: Iterable[Iterable[Cell | str]], note: str = ""
    ) -> "Table":
        """A table of texts, each of the kind of its column unless it says otherwise."""
        tops = [head if isinstance(head, Cell) else Cell(head) for head in heads]
        cells = [
            [each if isinstance(each, Cell) else Cell(each, top.kind) for each, top in zip(row, tops, strict=True)]
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

    def without_meanings(self) -> "Table":
        """The table without its sentences about the other columns."""
        return replace(self, rows=[[Cell("") if each.kind == ABOUT else each for each in row] for row in self.rows])

    @property
    def is_headed(self) -> bool:
        """Whether any column has a heading: a table without them says of one thing what it has, line by line."""
        return any(head.text for head in self.heads)


def table_of(
    title: str,
    records: Sequence[Mapping[str, Any]],
    names: Iterable[str],
    bounds: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Table:
    """A row for each record; in the headings name, unit and, in a table with ``bounds``, the limit.

    ``units`` are those of columns that are no quantities.
    """
    names, bounds, units = [*names], bounds or {}, units or {}
    limited = any(name in bounds for name in names)
    heads = []
    for name in names:
        words = heading(name, units.get(name)) + (f"\n{bounds.get(name, ' ')}" if limited else "")
        texts = all(isinstance(record.get(name, ""), str) for record in records)
        heads.append(Cell(words, WORDS if texts else NUMERIC))
    rows = ([quantity_text(name, record.get(name, ""), units.get(name)) for name in names] for record in records)
    return Table.from_texts(title, heads, rows)


BODY_SIZES = frozenset({"base_radius_mm", "mean_radius_mm"})  # the sizes of a disc and of a cylinder


NAMES_SHOWN = 4  # columns


class Result(HasHtml):
    """What a function of camopt returns, and a command prints.

    Examples
    --------
    >>> found = camopt.timing(camopt.find_scene("bucket-valve"), [1.0])
    >>> found.to_pandas()["lift"].tolist(), [table.title for table in found.tables()], found.exit_code
    ([1.0], ['Inlet valve, bucket tappet, with ramps: above a lift'], 0)
    """

    __slots__ = ()
    main_rows: ClassVar[str] = ""
    """The rows that ``to_pandas`` gives without a name; without any, the values of the result are one row."""

    def sections(self) -> Iterable[Any]:
        """The tables and the sentences of the result, in the order in which people read them."""
        return filter(None, (self.table(),))

    @property
    def notes(self) -> Iterable[str]:
        """What to know beside the result; commands print it to standard error."""
        return ()

    def document(self) -> Any:
        """The values of the result by key, as they are: ``to_dict`` makes JSON of them."""
        raise NotImplementedError

    @property
    def half_width(self) -> float:
        """The largest relative error that a value may have."""
        return 0.0

    @property
    def exit_code(self) -> int:
        """The exit code of the command: 0 done, 1 nothing feasible, 4 less accurate than the scene asks."""
        return NOT_REACHED if self.half_width > self.asked_accuracy else 0

    @property
    def asked_accuracy(self) -> float:
        """The largest relative error that the scene allows; infinite for a result without a scene."""
        scene = getattr(self, "scene", None)
        return float("inf") if scene is None else float(scene.accuracy.relative_error)

    @property
    def shown_cam(self) -> Any:
        """The scene of the cam that a notebook shows beside the tables; None if there is none."""
        return getattr(self, "scene", None)

    @property
    def kept_tables(self) -> Iterable[str]:
        """The names of tables that ``to_pandas`` gives beside the rows of ``to_dict``."""
        return ()

    def table(self) -> Table | None:
        """The main table; None if there is none."""
        return None

    def tables(self) -> tuple[Table, ...]:
        """The tables of the result, as people read them: texts, in the units that are shown."""
        return tuple(each for each in self.sections() if isinstance(each, Table))

    def to_dict(self) -> Any:
        """What ``--json`` prints: values by key, None for infinite ones, whose names are under ``unbounded``."""
        return to_json_values(self.document())

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """Rows of the result as a DataFrame, with the units of its columns in ``attrs``; of designs also the scene.

        Parameters
        ----------
        name : str, optional
            Which rows, if the result has several kinds: a key of ``to_dict``.

        Returns
        -------
        pandas.DataFrame
            A row each; values in a mapping have columns of their own, such as ``shares.profile``.

        Raises
        ------
        UnknownName
            If the result has no such rows.
        """
        import pandas as pd

        document, name = self.document(), self.main_rows if name is None else name
        index: list[str] | None = None
        if isinstance(document, list):
            records = document
        elif name:
            index, records = records_of(document, name, self.kept_tables)
        else:
            records = [{key: each for key, each in document.items() if isinstance(each, (int, float, str))}]
        frame = pd.json_normalize([record_values(each) for each in records])
        if index is not None:
            frame.index = pd.Index(index)
        scene = getattr(self, "scene", None)
        own = getattr(scene, "quantities", {})
        units = {each: QUANTITIES[each].unit for each in frame if each in QUANTITIES}
        frame.attrs = {"units": units | {each: own[each].unit for each in frame if each in own}}
        if scene is not None and not BODY_SIZES.isdisjoint(frame.columns):  # rows of designs
            frame.attrs["scene"] = scene.to_toml()
        return frame


class Columns(Result, dict[str, Any]):
    """Columns of equal length by name: a mapping to arrays, whose rows ``to_pandas`` gives.

    Parameters
    ----------
    columns : Mapping
        Arrays, or a value for all rows.
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
        rows = max((len(each) for each in self.values() if np.ndim(each)), default=0)
        names, more = [*self][:NAMES_SHOWN], len(self) - NAMES_SHOWN
        words = ", ".join(names) + (f" and {more} more columns" if more > 0 else "")
        return f"<{type(self).__name__}: {rows:,} row{'s' * (rows != 1)} of {words}>"

    def table(self) -> Table:
        """A row for each point."""
        rows: list[Any] = self.to_pandas().to_dict("records")
        return table_of(f"{len(rows):,} rows", rows, [*self], units=self.units)

    def document(self) -> dict[str, Any]:
        """The columns by name."""
        return dict(self)

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """The columns as a DataFrame, with their units in ``attrs``.

        Raises
        ------
        UnknownName
            For a name: there is one kind of rows.
        """
        import pandas as pd

        if name is not None:
            records_of({}, name)
        frame = pd.DataFrame(dict(self))
        frame.attrs = {"units": self.units}
        return frame


@dataclass(frozen=True)
class Listing(Result):
    """A list of records, and how people read it."""

    records: list[Any]
    parts: tuple[Table | str, ...]

    def sections(self) -> tuple[Table | str, ...]:
        """Tables and sentences."""
        return self.parts

    def document(self) -> list[Any]:
        """The records."""
        return self.records


def records_of(
    document: Mapping[str, Any], name: str, tables: Iterable[str] = ()
) -> tuple[list[str] | None, list[Any]]:
    """The rows under a key of a document, and their names if they have any; a message names other tables too."""
    kinds = {key: each for key, each in document.items() if has_rows(each)}
    if name not in [*kinds]:
        raise UnknownName(f"{name!r} names no rows of this result; {suggest_names(str(name), [*tables, *kinds])}")
    rows = kinds[name]
    return ([*rows], [*rows.values()]) if isinstance(rows, Mapping) else (None, [*rows])


def has_rows(value: Any) -> bool:
    """Whether a value has rows: records one after the other, or by name."""
    rows = [*value.values()] if isinstance(value, Mapping) else value
    return isinstance(rows, (list, tuple)) and not is_record(rows) and all(map(is_record, rows))


def is_record(value: Any) -> bool:
    """Whether a value has values by name: a mapping, a named tuple or a dataclass."""
    return isinstance(value, Mapping) or is_dataclass(value) or hasattr(value, "_asdict")


def record_values(value: Any) -> dict[str, Any]:
    """The values of a record by name."""
    if isinstance(value, Mapping):
        return dict(value)
    names = value._fields if hasattr(value, "_asdict") else [each.name for each in fields(value)]
    return {name: getattr(value, name) for name in names}


def to_json_values(value: Any) -> Any:
    """A value as JSON has it: None for infinite numbers, whose names are under ``unbounded``."""
    if is_record(value):
        record = record_values(value)
        infinite = [name for name, each in record.items() if isinstance(each, float) and isinf(each)]
        named = {"unbounded": infinite} if infinite and "unbounded" not in record else {}
        return {name: to_json_values(each) for name, each in record.items()} | named
    if isinstance(value, (list, tuple)):
        return [to_json_values(each) for each in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return to_json_values(value.tolist())
    if isinstance(value, float):
        return None if isinf(value) else value
    return str(value) if isinstance(value, Path) else value

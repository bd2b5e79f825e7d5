"""Designs from any container (tables of pandas, polars and pyarrow, mappings, arrays) as numpy columns."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

import narwhals.stable.v2 as nw
import numpy as np
from narwhals.exceptions import DuplicateError
from narwhals.stable.v2.dependencies import is_pandas_dataframe as is_pandas
from narwhals.stable.v2.dependencies import is_pandas_series as is_pandas_row
from numpy.typing import NDArray

from camopt.core.mistakes import BadInput, Mistake

if TYPE_CHECKING:
    import pandas as pd

DESIGNS_LABEL = "designs"  # the name of the table in messages
CONTAINERS = (
    "a table of pandas, polars or pyarrow, a mapping of columns, a list of mappings, or an array with names="
)
ABSENT_VALUE = object()


@dataclass(frozen=True)
class DesignColumns:
    """The known columns of a table of designs, and the names of the others."""

    values: dict[str, NDArray[Any]]
    """Arrays (rows,) by name."""
    others: list[str]
    count: int
    labels: "pd.Index[Any] | range"
    """The labels of the rows."""


def read_design_columns(designs: Any, known_names: Collection[str], names: Iterable[str] | None) -> DesignColumns:
    """The known columns of a container of designs.

    Raises
    ------
    BadInput
        If it is not such a container, has columns of different lengths, has a column twice, or lacks a value.
    """
    table, labels = _columns_and_row_labels(designs, known_names, names)
    arrays = {str(name): _column_array(name, table[name]) for name in table if name in known_names}
    if labels is None:
        # the rows are as many as all columns but single values are long; single values alone are one row
        lengths = {name: len(value) for name, value in arrays.items() if value.ndim == 1}
        if len({*lengths.values()}) > 1:
            sizes = ", ".join(f"{name} has {size}" for name, size in lengths.items())
            raise BadInput([Mistake("camopt", DESIGNS_LABEL, None, f"columns of equal length; {sizes}")])
        labels = range(next(iter(lengths.values()), min(len(table), 1)))
    values = {name: np.broadcast_to(value, (len(labels),)) for name, value in arrays.items()}
    others = [str(name) for name in table if name not in known_names]
    return DesignColumns(values, others, len(labels), labels)


def _columns_and_row_labels(
    designs: Any, known_names: Collection[str], names: Iterable[str] | None
) -> "tuple[Any, pd.Index[Any] | range | None]":
    """The columns of a container by name, and the labels of its rows, if it has any."""
    if names is not None:
        return _columns_of_array(designs, [names] if isinstance(names, str) else [*names]), None
    if is_pandas_row(designs):
        return dict(designs), designs.to_frame().columns
    if isinstance(designs, Mapping) and (labelled := list(filter(is_pandas_row, designs.values()))):
        designs = labelled[0].to_frame("").assign(**designs)[[*designs]]  # rows of equal labels go together
    if is_pandas(designs):
        _check_unique_column_names(designs.columns)
        # index levels with known names become columns
        levels = [str(name) for name in designs.index.names if name in known_names and name not in designs.columns]
        return designs.assign(**{name: designs.index.get_level_values(name) for name in levels}), designs.index
    if isinstance(designs, Mapping):
        return designs, None
    if isinstance(designs, np.ndarray) and designs.dtype.names:
        return {name: designs[name] for name in designs.dtype.names}, None
    if isinstance(designs, (list, tuple)) and all(isinstance(r, Mapping) or is_pandas_row(r) for r in designs):
        return _columns_of_rows([dict(row) for row in designs]), None
    try:
        frame = nw.from_native(designs, eager_only=True, pass_through=True)
    except DuplicateError:
        frame = None
        _check_unique_column_names(designs.column_names)  # pyarrow alone takes a name twice
    if isinstance(frame, nw.DataFrame):
        return {name: frame[name] for name in frame.columns}, range(len(frame))
    hint = ": give its .to_pandas()" if hasattr(designs, "to_pandas") else ""
    raise BadInput(
        [Mistake("camopt", DESIGNS_LABEL, None, f"{CONTAINERS}; this is a {type(designs).__name__}{hint}")]
    )


def _check_unique_column_names(names: Iterable[Any]) -> None:
    if twice := [str(name) for name, count in Counter(names).items() if count > 1]:
        raise BadInput(Mistake(DESIGNS_LABEL, name, None, "occurs twice", bare=True) for name in twice)


def _column_array(name: str, value: Any) -> NDArray[Any]:
    """A column as an array; numbers beside texts stay numbers, and masked values are None."""
    value = value.tolist() if np.ma.is_masked(value) else value
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = None
    if array is None or array.ndim > 1 or array.dtype.names:
        raise BadInput(
            [Mistake("camopt", DESIGNS_LABEL, None, f"columns with one value per row; {name} has more")]
        ) from None
    return np.asarray(value, dtype=object) if array.dtype.kind in "US" else array


def _columns_of_rows(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The columns of a list of mappings; BadInput if a row lacks a value."""
    names = dict.fromkeys(chain.from_iterable(rows))
    columns = {name: [row.get(name, ABSENT_VALUE) for row in rows] for name in names}
    absent = [(name, column.index(ABSENT_VALUE)) for name, column in columns.items() if ABSENT_VALUE in column]
    if absent:
        raise BadInput(Mistake(DESIGNS_LABEL, f"{name}[{row}]", None, "missing", bare=True) for name, row in absent)
    return columns


def _columns_of_array(designs: Any, names: Sequence[str]) -> dict[str, Any]:
    """The columns of an array (rows, names), or of one design (names,)."""
    array = designs if np.ma.is_masked(designs) else np.asarray(designs)
    if array.ndim not in (1, 2) or array.shape[-1] != len(names):
        allowed = f"an array with a column for each of the {len(names)} names; this has the shape {array.shape}"
        raise BadInput([Mistake("camopt", DESIGNS_LABEL, None, allowed)])
    _check_unique_column_names(names)
    return dict(zip(names, array.T, strict=True))

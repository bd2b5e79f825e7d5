"""Rows of designs and their quantities as arrays, before they become a table."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.core.numerics import IndexArray

QuantityColumns = dict[str, Any]
"""Quantities by name: an array (rows,), or one value for all rows."""
Objectives = Mapping[str, float]
"""The objectives by name, each with the sign that makes it a cost: 1 if minimised, −1 if maximised."""
VERDICT_COLUMNS = ("feasible", "violated", "status", "relative_half_width")
"""The columns of a verdict."""


@dataclass(frozen=True)
class DesignRows:
    """Rows with their columns.

    The true value of a quantity lies between its column and the column plus ``outward``; without an entry there,
    the column is exact to rounding. ``half_width`` is the largest relative width of an enclosure in each row.
    """

    columns: QuantityColumns
    count: int
    outward: QuantityColumns = field(default_factory=dict)
    half_width: Any = 0.0

    def columns_shifted_by_width_share(self, share: Any) -> QuantityColumns:
        """The columns moved by a share of their widths: 1 for the far side, −1 for the same distance inward.

        Shares (n, 1) give columns (n, rows).
        """
        return self.columns | {name: self.columns[name] + share * width for name, width in self.outward.items()}

    def select_columns(self, names: Iterable[str]) -> "DesignRows":
        """The columns of some names."""
        names = set(names)
        return replace(
            self,
            columns={name: values for name, values in self.columns.items() if name in names},
            outward={name: width for name, width in self.outward.items() if name in names},
        )

    def take(self, index: NDArray[Any]) -> "DesignRows":
        """The rows at an index or mask."""
        index = np.flatnonzero(index) if index.dtype == bool else index

        def take_values(values: Any) -> Any:
            return values[index] if is_per_row(values) else values

        columns, outward = ({n: take_values(v) for n, v in each.items()} for each in (self.columns, self.outward))
        return DesignRows(columns, index.size, outward, take_values(self.half_width))

    def take_and_release(self, index: NDArray[Any]) -> "DesignRows":
        """As ``take``, but it frees each column of these rows as soon as its values are taken."""
        count, columns = int(np.count_nonzero(index)) if index.dtype == bool else index.size, self.columns
        return DesignRows({n: v[index] if is_per_row(v := columns.pop(n)) else v for n in [*columns]}, count)

    def slice_rows(self, row_slice: slice) -> "DesignRows":
        """Consecutive rows, as views of these columns."""
        columns = {
            name: values[row_slice] if is_per_row(values) else values for name, values in self.columns.items()
        }
        return DesignRows(columns, len(range(*row_slice.indices(self.count))))

    def replace_rows(self, index: IndexArray, new_rows: "DesignRows") -> "DesignRows":
        """The rows with those at an index replaced by other rows."""
        columns = {}
        for name, value in self.columns.items():
            if not (is_per_row(value) or is_per_row(new_rows.columns[name])) and value == new_rows.columns[name]:
                columns[name] = value
                continue
            here, there = self.column(name), new_rows.column(name)
            columns[name] = here.astype(np.promote_types(here.dtype, there.dtype))
            columns[name][index] = there
        return DesignRows(columns, self.count)

    def column(self, name: str) -> NDArray[Any]:
        """One column, repeated if it is a single value."""
        values = self.columns[name]
        return values if is_per_row(values) else np.broadcast_to(values, (self.count,))

    def records(self) -> list[dict[str, Any]]:
        """The rows as mappings of plain Python values."""
        plain = {name: np.asarray(values).tolist() for name, values in self.columns.items()}
        lists = {n: v if is_per_row(self.columns[n]) else [v] * self.count for n, v in plain.items()}
        return [{name: values[i] for name, values in lists.items()} for i in range(self.count)]


def is_per_row(values: Any) -> bool:
    """Whether a column has a value for each row, not one for all."""
    return bool(getattr(values, "ndim", 0))


def concatenate_rows(parts: Iterable[DesignRows]) -> DesignRows:
    """All rows of several parts, which must have the same columns."""
    parts = list(parts)
    return DesignRows(
        {name: _concatenate_column(name, parts) for name in parts[0].columns}, sum(part.count for part in parts)
    )


def join_and_release_rows(parts: list[DesignRows]) -> DesignRows:
    """As ``concatenate_rows``, but it frees each column of the parts as soon as it is joined."""
    count = sum(part.count for part in parts)
    columns = {}
    for name in [*parts[0].columns]:
        columns[name] = _concatenate_column(name, parts)
        for part in parts:
            del part.columns[name]
    return DesignRows(columns, count)


def _concatenate_column(name: str, parts: list[DesignRows]) -> Any:
    """A column of several parts; a single value if all parts share it."""
    values = [part.columns[name] for part in parts]
    if not any(map(is_per_row, values)):
        same = all(value == values[0] for value in values)
        return values[0] if same else np.repeat(values, [part.count for part in parts])
    return np.concatenate([part.column(name) for part in parts])


def scatter_rows(parts: Iterable[tuple[Any, DesignRows]], count: int) -> DesignRows:
    """``count`` rows from parts, each with the places of its rows; no column is held twice.

    Columns of texts hold references, since arrays of texts take four bytes a letter.
    """
    columns: QuantityColumns = {}
    for places, rows in parts:
        for name, values in rows.columns.items():
            if name not in columns:
                kind = rows.column(name).dtype
                columns[name] = np.empty(count, dtype=object if kind.kind == "U" else kind)
            columns[name][places] = values
    return DesignRows(columns, count)

"""Rows: designs and their quantities inside the program, before they become a table."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Columns = dict[str, Any]
"""Quantities by name: an array (rows,), or one value that holds for all rows."""


@dataclass(frozen=True)
class Rows:
    """A number of rows with their columns."""

    columns: Columns
    count: int

    def take(self, index: NDArray[Any]) -> "Rows":
        """The rows at an index or mask."""
        count = int(np.count_nonzero(index)) if index.dtype == bool else index.size
        return Rows({n: v[index] if np.ndim(v) else v for n, v in self.columns.items()}, count)

    def column(self, name: str) -> NDArray[Any]:
        """One column, repeated if it is a single value."""
        return np.broadcast_to(self.columns[name], (self.count,))

    def records(self) -> list[dict[str, Any]]:
        """The rows as mappings of plain Python values."""
        lists = {name: self.column(name).tolist() for name in self.columns}
        return [{name: values[i] for name, values in lists.items()} for i in range(self.count)]


def joined(parts: Iterable[Rows]) -> Rows:
    """Rows put one after the other; all must have the same columns."""
    parts = list(parts)
    names = parts[0].columns
    columns = {name: np.concatenate([part.column(name) for part in parts]) for name in names}
    return Rows(columns, sum(part.count for part in parts))

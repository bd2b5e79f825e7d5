"""Certify each row of a table that a sweep wrote."""

import os
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from camopt.front.asked import column_names
from camopt.mechanisms import SIZES
from camopt.mistakes import BadInput
from camopt.problem.problem import Problem, resolve
from camopt.problem.rows import Rows
from camopt.problem.settings import problems_of
from camopt.problem.space import Space
from camopt.publishing import revised
from camopt.quantities import QUANTITIES
from camopt.scene.tables import LONGEST, SHORTEST
from camopt.smallest.result import Progress, report_progress
from camopt.tables.sealed import no_table, read_table, scene_in, write_table
from camopt.tables.table import schema
from camopt.verdicts.certify import certify_design, summary

COLUMN = "proof"


def certify_table(path: str | os.PathLike[str], progress: Progress | None = None) -> Counter[str]:
    """Prove or refute the limits of the scene for each row of a table, and add the verdict as the column ``proof``.

    Returns how many rows are held, broken and undecided.

    Raises
    ------
    BadInput
        If the file is no table of a sweep: other columns than its scene asks for, other types, numbers or laws
        that are none of a design, or damage.
    Stopped
        If ``progress``, called with (rows done, rows in all), returned False; the table stays as it was.
    OSError
        If there is no such file, it cannot be read or written, or another run writes to its folder.
    """
    table = read_table(path)
    if COLUMN in table.column_names:
        table = table.drop_columns([COLUMN])
    problem = resolve(scene_in(table.schema, path))
    for why in _oddities(table, problem):
        raise no_table(path, why)
    rows = Rows({name: table[name].to_numpy() for name in table.column_names}, table.num_rows)
    space = Space(problem, problems_of(problem), {})
    with revised(path) as place:
        verdicts = _verdicts(space, rows, progress)
        if "" in verdicts:
            raise no_table(path, "this has laws that its scene does not have")
        field = schema((COLUMN,), "").field(COLUMN)
        write_table(table.append_column(field, pa.array(verdicts, type=pa.string())), place)
    return Counter(verdicts)


def _verdicts(space: Space, rows: Rows, progress: Progress | None) -> list[str]:
    """The verdict on each row; empty where its laws are none of the space."""
    verdicts, done = [""] * rows.count, 0
    for each, index, designs in space.designs_of(rows):
        for row, number in enumerate(index):
            verdicts[number] = summary(certify_design(each, designs.take(np.array([row]))))
            done += 1
            report_progress(progress, done, rows.count)
    return verdicts


def _oddities(table: pa.Table, problem: Problem) -> Iterator[str]:
    """What keeps a table from being one of a sweep of a scene."""
    names = column_names(problem)
    expected = schema((*names, "refined") if "refined" in table.column_names else names, "")
    if table.column_names != expected.names:
        differ = ", ".join(sorted({*table.column_names} ^ {*expected.names})) or "in another order"
        yield f"its columns are not those of its scene: {differ}"
        return
    for column in expected:
        found = table.schema.field(column.name)
        if (found.type, found.nullable) != (column.type, column.nullable) or table[column.name].null_count:
            yield f"its column {column.name} has not the type {column.type}"
            return
        odd = np.isnan if QUANTITIES[column.name].effect != "sizes" else lambda values: ~np.isfinite(values)
        if column.type == pa.float64() and odd(table[column.name].to_numpy()).any():
            yield f"its column {column.name} has values that are no numbers, or no sizes"
            return
    for key, name in problem.numbers.items():
        try:
            problem.scene.replace(**{f"search.{key}": pc.unique(table[name]).to_pylist() or None})
        except BadInput as error:
            yield f"its column {name} has values that {key} cannot have: {error.mistakes[0]}"
            return
    for name in (problem.size_name, *(f"{size}_mm" for size in SIZES)):
        least = -LONGEST if "offset" in name else SHORTEST
        if name in names and not all(least <= value <= LONGEST for value in table[name].to_pylist()):
            yield f"its column {name} has values that are no sizes"
            return

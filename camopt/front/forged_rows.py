"""Faults of rows of a table, or of a part of a sweep, that a sweep of its scene cannot have."""

from collections.abc import Iterator

import numpy as np
import pyarrow as pa

from camopt.mistakes import BadInput, listed_words
from camopt.motion.table import RETURN, RISE
from camopt.problem.problem import Problem
from camopt.problem.settings import problems_of
from camopt.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.scene.tables import LARGEST_VALUE, SMALLEST_VALUE
from camopt.tables.table import arrow_schema


def table_oddities(table: pa.Table, names: tuple[str, ...], scene: Scene, problem: Problem) -> Iterator[str]:
    """Faults of a table with columns of some names that a sweep of a scene cannot have."""
    expected = arrow_schema((*names, "refined") if "refined" in table.column_names else names, "")
    if table.column_names != expected.names:
        differ = listed_words(sorted({*table.column_names} ^ {*expected.names})) or "in another order"
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
    for each in problem.choices.numbers:
        try:
            scene.replace(**{each.searched: table[each.quantity].unique().to_pylist() or None})
        except BadInput as error:
            yield f"its column {each.quantity} has values that {each.key} cannot have: {error.mistakes[0]}"
            return
    for each in problem.variables:
        least = max(each.least, -LARGEST_VALUE) or SMALLEST_VALUE
        values = table[each.quantity].to_numpy() if each.is_size else np.zeros(0)
        if not np.all((least <= values) & (values <= LARGEST_VALUE)):
            yield f"its column {each.quantity} has values that are no sizes"
            return
    laws = table.select(["law_rise", "law_return"]).group_by(["law_rise", "law_return"]).aggregate([]).to_pylist()
    known = {(each.programme.law_names(RISE), each.programme.law_names(RETURN)) for each in problems_of(problem)}
    if any((row["law_rise"], row["law_return"]) not in known for row in laws):
        yield "this has laws that its scene does not have"

"""A batch of results as bytes, which a journal keeps: numbers as JSON, then its rows as Parquet."""

import json
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.front.blocks import Batch
from camopt.front.forged_rows import table_oddities
from camopt.front.plan import SweepPlan
from camopt.problem.rows import Rows
from camopt.storage.damage import ARROW_ERRORS, raise_if_of_the_disk
from camopt.tables.table import arrow_schema, parquet_options, to_table
from camopt.verdicts.judging import Effort

BATCH_TABLES = ("kept", "front", "best")


def encoded(batch: Batch, names: tuple[str, ...]) -> bytes:
    """A batch as bytes."""
    layout = arrow_schema(names, "")
    tables = [_table_bytes(to_table(getattr(batch, name), layout)) for name in BATCH_TABLES]
    numbers = {name: value for name, value in vars(batch).items() if name not in BATCH_TABLES}
    head = json.dumps([numbers, [*map(len, tables)]]).encode()
    return b"".join([len(head).to_bytes(4, "little"), head, *tables])


def batch_of(payload: bytes) -> Batch:
    """A batch from its bytes."""
    return _batch(*_parted(payload))


def sound(payload: bytes, plan: SweepPlan) -> Batch | None:
    """A batch from its bytes; None if no sweep can have made it, though its digest may be right."""
    try:
        numbers, tables = _parted(payload)
        names, of = plan.row_names, (plan.scene, plan.problem)
        if any(why for table in tables.values() for why in table_oddities(table, names, *of)):
            return None
        batch = _batch(numbers, tables)
        return batch if _counted(batch, plan) else None
    except (*ARROW_ERRORS, LookupError, TypeError, AttributeError, RecursionError) as trouble:
        raise_if_of_the_disk(trouble)
        return None


def _counted(batch: Batch, plan: SweepPlan) -> bool:
    """Whether the numbers of a batch can be those of its blocks."""
    counts = (batch.first, batch.last, batch.designs, batch.existing, batch.feasible, *batch.effort)
    if not all(type(count) is int and count >= 0 for count in counts) or batch.first >= batch.last:
        return False
    if type(batch.reached) not in (int, float) or not batch.reached >= 0.0:
        return False
    before = plan.blocks.designs_before
    rows = max(batch.kept.count, batch.front.count, batch.best.count)
    most = batch.existing if plan.keep == "all" else batch.feasible
    designs = before(batch.last) - before(batch.first)
    return designs == batch.designs >= batch.existing >= batch.feasible and rows <= most


def _parted(payload: bytes) -> tuple[dict[str, Any], dict[str, pa.Table]]:
    """The numbers of a batch, and its tables by name."""
    start = 4 + int.from_bytes(payload[:4], "little")
    numbers, lengths = json.loads(payload[4:start])
    tables = {}
    for name, length in zip(BATCH_TABLES, lengths, strict=True):
        tables[name] = pq.read_table(pa.BufferReader(payload[start : start + length]))
        start += length
    return numbers, tables


def _batch(numbers: dict[str, Any], tables: dict[str, pa.Table]) -> Batch:
    rows: dict[str, Any] = {name: _rows(table) for name, table in tables.items()}
    return Batch(**{**numbers, "effort": Effort._make(numbers["effort"])}, **rows)


def _table_bytes(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    plain = table.replace_schema_metadata(None)
    pq.write_table(plain, sink, compression="zstd", **parquet_options(plain.schema))
    return bytes(sink.getvalue())


def _rows(table: pa.Table) -> Rows:
    return Rows({name: _column(table[name]) for name in table.column_names}, table.num_rows)


def _column(column: pa.ChunkedArray) -> Any:
    if column.type != pa.string():
        return column.to_numpy()
    coded = column.combine_chunks().dictionary_encode()
    words = np.array(coded.dictionary.to_pylist() or [""], dtype=str)
    return words[coded.indices.to_numpy()]

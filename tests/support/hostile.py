"""Tables that camopt did not write: what may be wrong with one, by name, each made from a table of a sweep."""

import io
from collections.abc import Callable, Iterator

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.core.storage.tables import SCENE_KEY

Change = Callable[[pa.Table], pa.Table]


def in_bytes(table: pa.Table) -> bytes:
    """A table as camopt or another program saves it."""
    sink = io.BytesIO()
    pq.write_table(table, sink, compression="zstd", write_page_checksum=True)
    return sink.getvalue()


def with_column(table: pa.Table, name: str, column: pa.Array, nullable: bool = False) -> pa.Table:
    """A column replaced."""
    place = table.column_names.index(name)
    return table.set_column(place, pa.field(name, column.type, nullable=nullable), column)


def replace_first_value(table: pa.Table, name: str, value: object) -> pa.Table:
    """The first value of a column replaced."""
    values = [value, *table[name].to_pylist()[1:]]
    return with_column(table, name, pa.array(values, type=table[name].type), nullable=value is None)


def with_metadata(table: pa.Table, key: bytes, value: bytes | None) -> pa.Table:
    kept = {k: v for k, v in table.schema.metadata.items() if k != key}
    return table.replace_schema_metadata(kept if value is None else {**kept, key: value})


def rename_column(table: pa.Table, name: str) -> pa.Table:
    """A column with another name; the metadata as they were."""
    names = [f"{column}x" if column == name else column for column in table.column_names]
    return table.rename_columns(names).replace_schema_metadata(table.schema.metadata)


NUMBERS = (float("nan"), float("inf"), float("-inf"), None, -1.0, 1e300, 5e-324)
TEXTS = ("", "no-law", "harmonic+cycloidal", "x" * 1_000_000, "\x1b[31m\n", None)
TYPES = (
    pa.float32(),
    pa.string(),
    pa.int64(),
    pa.null(),
    pa.large_string(),
    pa.dictionary(pa.int32(), pa.string()),
)
SCENES = {
    "no scene": None,
    "an empty scene": b"",
    "no TOML": b"= = =",
    "no text": b"\xff\xfe\x00",
    "a scene of nothing": b"name = 'x'",
    "deep tables": b"a." * 5000 + b"a = 1",
    "deep lists": b"a = " + b"[" * 50_000,
    "a pipe for a law": b'laws.mine.file = "/dev/stdin"',
    "zeros for a load": b'follower.dynamics.load = "/dev/zero"',
    "keys with escapes": b'"\\u001b[31m\\nroot" = 1',
    "a number without end": b"cam = " + b"9" * 10_000,
}


def changes(table: pa.Table) -> Iterator[tuple[str, Change]]:
    """What may be wrong with the columns and the metadata."""
    for name in table.column_names:
        yield f"without {name}", lambda t, n=name: t.drop_columns([n])
        yield (
            f"{name} renamed",
            lambda t, n=name: t.rename_columns([f"{c}x" if c == n else c for c in t.column_names]),
        )
        kind = table[name].type
        values = NUMBERS if kind == pa.float64() else TEXTS if kind == pa.string() else (None,)
        for value in values:
            what = f"{name} = {value!r:.20}"
            yield what, lambda t, n=name, v=value: replace_first_value(t, n, v)
        for other in TYPES:
            empty = pa.array([None] * table.num_rows, type=other)
            yield f"{name} as {other}", lambda t, n=name, e=empty: with_column(t, n, e, nullable=True)
    rows = table.num_rows
    nested = {
        "lists": pa.array([[1.0]] * rows),
        "structs": pa.array([{"a": 1}] * rows),
        "dates": pa.array([2**62] * rows, type=pa.timestamp("ms")),
        "bytes": pa.array([b"\xff"] * rows),
        "numbers": pa.array([1.0] * rows),
    }
    for what, column in nested.items():
        yield f"one more column, of {what}", lambda t, c=column: t.append_column("more", c)
        yield f"a proof of {what}", lambda t, c=column: t.append_column("proof", c)
    yield "a column twice", lambda t: t.append_column(t.column_names[0], t[0])
    yield "another order", lambda t: t.select(t.column_names[::-1])
    yield "no columns", lambda t: t.select([])
    yield "no rows", lambda t: t.slice(0, 0)
    for what, text in SCENES.items():
        yield what, lambda t, s=text: with_metadata(t, SCENE_KEY, s)
    for what, text in {"no JSON": b"{", "deep JSON": b"[" * 100_000, "NaN": b"NaN", "no text": b"\xff"}.items():
        yield f"a front of {what}", lambda t, s=text: with_metadata(t, b"camopt_front", s)
        yield f"counts of {what}", lambda t, s=text: with_metadata(t, b"camopt_sweep", s)
    for version in (None, b"0.0.1", b"99", b"\xff"):
        yield f"version {version!r}", lambda t, v=version: with_metadata(t, b"camopt_version", v)
    yield "pandas metadata of nothing", lambda t: with_metadata(t, b"pandas", b"{")
    yield "no metadata", lambda t: t.replace_schema_metadata(None)


def tables(table: pa.Table) -> Iterator[tuple[str, Callable[[], bytes]]]:
    """Hostile tables by name, each as a function that makes its bytes."""
    for what, change in changes(table):
        yield what, lambda c=change: in_bytes(c(table))
    whole = in_bytes(table)
    for share in np.linspace(0.0, 0.999, 24):
        yield f"cut after {share:.1%}", lambda s=share: whole[: int(s * len(whole))]
    for number, place in enumerate(np.linspace(0, len(whole) - 1, 160).astype(int)):
        yield f"bit flipped at byte {place}", lambda p=place, n=number: flip_bit(whole, 8 * p + n % 8)
    for what, data in {
        "text": b"no table",
        "nothing": b"",
        "a frame": b"PAR1" * 3,
        "zip": b"PK\x03\x04" * 9,
    }.items():
        yield what, lambda d=data: d


def flip_bit(data: bytes, bit: int) -> bytes:
    """With one bit another."""
    found = bytearray(data)
    found[bit // 8] ^= 1 << bit % 8
    return bytes(found)

"""Parts of a sweep that are rightly sealed, and odd: one message names the right file, and nothing is written."""

import json
import shutil
from dataclasses import replace
from itertools import islice

import numpy as np
import pyarrow as pa
import pytest
from support import hostile
from support.depth import times

import camopt
from camopt.cli.exits import BAD_INPUT
from camopt.cli.main import main
from camopt.front.batch_bytes import BATCH_TABLES, _parted, _table_bytes
from camopt.front.plan import SweepKey
from camopt.storage.records import END_RECORD, JOURNAL_MAGIC, record, records

SCENE = camopt.find_scene("roller-1000rpm").replace(
    search={"base_radius": [60, 80, 100, 120], "offset": [0, 10], "roller_radius": [20], "law": ["cycloidal"]}
)
PARTS = 2


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """The records of each part: the question, and the numbers and tables of batches."""
    folder = tmp_path_factory.mktemp("parts")
    return [camopt.sweep_part(SCENE, (number, PARTS), folder, "all").file for number in range(1, PARTS + 1)]


def records_of(path):
    with path.open("rb") as file:
        question, *batches, end = [payload for payload, _ in records(file)]
    assert end == END_RECORD
    return question, batches


def batch_in_bytes(numbers, tables):
    """As the journal has it, whatever is in it."""
    data = [table if isinstance(table, bytes) else _table_bytes(table) for table in tables.values()]
    head = numbers if isinstance(numbers, bytes) else json.dumps([numbers, [*map(len, data)]]).encode()
    return b"".join([len(head).to_bytes(4, "little"), head, *data])


def with_question(question, batches, **changes):
    return json.dumps({**json.loads(question), **changes}).encode(), batches


def with_numbers(question, batches, **changes):
    numbers, tables = _parted(batches[0])
    return question, [batch_in_bytes({**numbers, **changes}, tables), *batches[1:]]


def with_table(question, batches, name, change):
    numbers, tables = _parted(batches[0])
    return question, [batch_in_bytes(numbers, {**tables, name: change(tables[name])}), *batches[1:]]


def with_column(name, values):
    return lambda table: hostile.with_column(table, name, pa.array(values(table), type=table[name].type))


def filled(value):
    return lambda table: [value] * table.num_rows


def oddities():
    """Ways in which a part may be odd, by name."""
    lies = {
        "part": [0, 1, 3, -1, "2", 2.0, None, True, 10**30],
        "parts": [0, 1, 3, 10**9, 10**30, "2", None],
        "block": [0, -1, 1, "1", None],
        "keep": ["", "none", "front-only", 1, None],
        "version": ["", "99", 1, None],
        "scene": ["", "= = =", "name = 'x'", 1, None, "a = " + "[" * 50_000],
    }
    for key, values in lies.items():
        for value in values:
            yield f"{key} = {value!r:.20}", lambda q, b, k=key, v=value: with_question(q, b, **{k: v})
    for data in (b"", b"{", b"[]", b"null", b"\xff", b"[" * 100_000):
        yield f"a question of {data!r:.20}", lambda q, b, d=data: (d, b)
    yield "a question without a key", lambda q, b: (json.dumps({"scene": "", "keep": "all"}).encode(), b)
    for key in ("first", "last", "designs", "existing", "feasible", "reached", "effort"):
        huge = () if key == "reached" else (10**9, 10**30)  # of what is exact to so much one is told
        for value in (-1, *huge, "1", None, True, [], [1], {}, float("nan")):
            yield f"{key} = {value!r:.20}", lambda q, b, k=key, v=value: with_numbers(q, b, **{k: v})
    yield "another number", lambda q, b: with_numbers(q, b, more=1)
    for data in (b"", b"{", b"[]", b"[1, 2]", b"[{}, [0, 0, 0]]", b"\xff", b"[" * 100_000):
        yield f"numbers of {data!r:.20}", lambda q, b, d=data: (q, [batch_in_bytes(d, {})])
    yield "no batches", lambda q, b: (q, [])
    yield "a batch twice", lambda q, b: (q, [b[0], *b])
    yield "another order", lambda q, b: (q, b[::-1] if len(b) > 1 else [b[0], b[0]])
    yield "an empty batch", lambda q, b: (q, [b"", *b])
    for table in BATCH_TABLES:
        yield f"{table}: no table", lambda q, b, t=table: with_table(q, b, t, lambda _: b"PAR1" * 3)
        for what, change in CHANGES.items():
            yield f"{table}: {what}", lambda q, b, t=table, c=change: with_table(q, b, t, c)


SIZE, ANGLE = "base_radius_mm", "pressure_angle_max_deg"
CHANGES = {
    "a column less": lambda table: table.drop_columns([SIZE]),
    "a column more": lambda table: table.append_column("more", pa.array([1.0] * table.num_rows)),
    "columns in another order": lambda table: table.select(table.column_names[::-1]),
    "no columns": lambda table: table.select([]),
    "rows twice": lambda table: pa.concat_tables([table] * 20),
    "a size of text": lambda table: hostile.with_column(table, SIZE, pa.array(["x"] * table.num_rows)),
    "a size of whole numbers": lambda table: hostile.with_column(table, SIZE, pa.array([1] * table.num_rows)),
    "no sizes": lambda table: hostile.with_column(table, SIZE, pa.nulls(table.num_rows, pa.float64()), True),
    "sizes that are no numbers": with_column(SIZE, filled(np.nan)),
    "sizes without end": with_column(SIZE, filled(np.inf)),
    "sizes below zero": with_column(SIZE, filled(-1.0)),
    "huge sizes": with_column(SIZE, filled(1e300)),
    "angles that are no numbers": with_column(ANGLE, filled(np.nan)),
    "laws that nobody knows": with_column("law_rise", filled("no-law")),
    "laws with escapes": with_column("law_rise", filled("\x1b[31m\n")),
}


def test_a_rightly_sealed_odd_part_is_refused_by_its_name(parts, tmp_path, capsys):
    one, two = (records_of(file) for file in parts)
    odd = tmp_path / "part-2-of-2.sweep"
    out, tried, unlike = tmp_path / "out", 0, []
    for what, change in islice(oddities(), 0, None, times(4, deep=1)):
        question, batches = change(*two)
        odd.write_bytes(JOURNAL_MAGIC + b"".join(map(record, (question, *batches, END_RECORD))))
        same = (question, batches) == two
        code = main(["merge", str(parts[0]), str(odd), "--out", str(out), "--quiet", "--json"])
        told = capsys.readouterr().err.strip()
        tried += 1
        if same:
            shutil.rmtree(out)
            continue
        first, *rest = told.splitlines() or [""]
        of_another = "it differs in version" in first  # then the part of this sweep is missing, which is told, too
        if code != BAD_INPUT or len(rest) != of_another or str(odd) not in first or out.exists():
            unlike.append((what, code, told))
    assert not unlike, "\n".join(map(str, unlike))
    assert tried > times(35, deep=140)
    assert one[0] != two[0]


def test_a_part_that_is_damaged_is_not_said_to_be_missing(parts, tmp_path, capsys):
    odd = tmp_path / "part-2-of-2.sweep"
    odd.write_bytes(b"\0" * 100)
    assert main(["merge", str(parts[0]), str(odd), "--out", str(tmp_path / "out")]) == BAD_INPUT
    (told,) = capsys.readouterr().err.splitlines()
    assert told.endswith("must be a whole part of a sweep; this is none, or damaged at its beginning")


def test_a_question_is_that_of_its_bytes_alone():
    question = SweepKey("name = 'x'", "all", 8, "1", 2, 3)
    assert SweepKey.decoded(question.encoded()) == question
    for changes in ({"part": 4}, {"block": 0}, {"parts": True}, {"keep": 1}):
        with pytest.raises(ValueError, match="no "):
            SweepKey.decoded(replace(question, **changes).encoded())

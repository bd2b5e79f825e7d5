"""Tables that are written beside other work, by a thread or by a process."""

import subprocess
import sys
from errno import ENOSPC

import numpy as np
import pyarrow.parquet as pq
import pytest

from camopt.problem.rows import Rows
from camopt.storage.manifest import fact_of
from camopt.storage.seal import is_intact
from camopt.tables.row_groups import RowGroups
from camopt.tables.writing import table_file

NAMES = ("base_radius_mm",)


def rows(*values):
    return Rows({NAMES[0]: np.array(values)}, len(values))


def test_batches_are_written_in_their_order_and_the_digest_is_that_of_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr("camopt.tables.row_groups.ROWS_IN_GROUP", 8)
    told = []
    with table_file(tmp_path / "a.parquet", NAMES, "", told.append) as table:
        table.describe("told", "before")
        for k in range(0, 30, 3):
            table.append(rows(k, k + 1.0, k + 2.0))
        table.end()
    found = pq.read_table(tmp_path / "a.parquet")
    assert (found[NAMES[0]].to_pylist(), found.schema.metadata[b"told"]) == ([*range(30)], b"before")
    with (tmp_path / "a.parquet").open("rb") as file:
        assert is_intact(file)
    assert told == [fact_of(tmp_path / "a.parquet")]


@pytest.mark.parametrize("method", ["append", "finish"])
def test_trouble_of_the_thread_names_its_own_table_and_leaves_none(tmp_path, monkeypatch, method):
    def full(self, *_):
        raise OSError(ENOSPC, "no room")

    monkeypatch.setattr(RowGroups, method, full)
    paths = [tmp_path / f"{name}.parquet" for name in ("designs", "pareto")]

    def write():
        with table_file(paths[0], NAMES, "") as table, table_file(paths[1], NAMES, ""):
            table.append(rows(1.0))
            table.finish()

    with pytest.raises(OSError, match="space") as caught:
        write()
    assert (caught.value.filename, [*tmp_path.iterdir()]) == (str(paths[0]), [])


BY_PROCESS = """
import os, signal, sys
from pathlib import Path
from camopt.tables.writing import table_file
from camopt.tables.writing_process import PROCESSES, writing_process

def write(name, before=lambda: None, **columns):
    from camopt.problem.rows import Rows
    try:
        with table_file(Path(name), ("base_radius_mm",), "") as table:
            before()
            table.append(Rows(columns, 1))
    except Exception as trouble:
        print(repr(trouble))

with writing_process():
    [process] = PROCESSES
    write("whole.parquet", base_radius_mm=1.0)
    write("odd.parquet", offset_mm=1.0)
    write("lost.parquet", lambda: os.kill(process.number, signal.SIGKILL), base_radius_mm=1.0)
print(sorted(os.listdir()), len(PROCESSES), "pyarrow" in sys.modules)

def fork():
    raise BlockingIOError
os.fork = fork
with writing_process():
    print(len(PROCESSES), signal.pthread_sigmask(signal.SIG_BLOCK, ()))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a thread writes")
def test_a_process_writes_the_same_bytes_and_its_trouble_is_told_here(tmp_path):
    made, folder = tmp_path / "thread.parquet", tmp_path / "made"
    with table_file(made, NAMES, "") as table:
        table.append(Rows({NAMES[0]: 1.0}, 1))
    folder.mkdir()
    done = subprocess.run([sys.executable, "-P", "-c", BY_PROCESS], cwd=folder, capture_output=True, text=True)
    assert (done.stderr, done.stdout.splitlines()) == (
        "",
        [
            "KeyError('base_radius_mm')",
            "OSError(5, 'Input/output error')",
            "['whole.parquet'] 0 False",
            "0 set()",
        ],
    )
    assert (folder / "whole.parquet").read_bytes() == made.read_bytes()

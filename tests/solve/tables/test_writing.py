"""Tables that a thread of their own writes."""

from errno import ENOSPC

import numpy as np
import pyarrow.parquet as pq
import pytest

from camopt.core.quantities import QUANTITIES
from camopt.scene.problem.rows import DesignRows
from camopt.solve.tables.table import RowGroupWriter
from camopt.solve.tables.table_writers import table_file

NAMES = ("base_radius_mm",)
COLUMNS = [QUANTITIES[name] for name in NAMES]


def rows(*values):
    return DesignRows({NAMES[0]: np.array(values)}, len(values))


def test_batches_are_written_in_their_order(tmp_path, monkeypatch):
    monkeypatch.setattr("camopt.solve.tables.table.ROWS_IN_GROUP", 8)
    with table_file(tmp_path / "a.parquet", COLUMNS, "") as table:
        table.add_metadata_text("told", "before")
        for k in range(0, 30, 3):
            table.append(rows(k, k + 1.0, k + 2.0))
        table.take_no_more_rows()
    found = pq.read_table(tmp_path / "a.parquet")
    assert (found[NAMES[0]].to_pylist(), found.schema.metadata[b"told"]) == ([*range(30)], b"before")


@pytest.mark.parametrize("method", ["append", "write_last_group"])
def test_trouble_of_the_thread_names_its_own_table_and_leaves_none(tmp_path, monkeypatch, method):
    def full(self, *_):
        raise OSError(ENOSPC, "no room")

    monkeypatch.setattr(RowGroupWriter, method, full)
    paths = [tmp_path / f"{name}.parquet" for name in ("designs", "pareto")]

    def write():
        with table_file(paths[0], COLUMNS, "") as table, table_file(paths[1], COLUMNS, ""):
            table.append(rows(1.0))
            table.wait_until_written()

    with pytest.raises(OSError, match="space") as caught:
        write()
    assert (caught.value.filename, [*tmp_path.iterdir()]) == (str(paths[0]), [])

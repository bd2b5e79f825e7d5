"""Tables that grow batch by batch: a file that a thread writes during the search, or rows in memory."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.core.quantities import Quantity
from camopt.core.storage.files import atomically_written_file, attribute_errors_to
from camopt.scene.problem.rows import DesignRows

if TYPE_CHECKING:
    import pandas as pd

    from camopt.solve.tables.table import RowGroupWriter

WAITING_BATCHES = 2  # most batches in memory while another is written


def import_table_module() -> Any:
    """Import the module of tables on disk when it is first needed, because pyarrow takes long."""
    from camopt.solve.tables import table

    return table


@contextmanager
def table_file(path: Path, quantities: Iterable[Quantity], scene: str) -> Iterator["TableWriter"]:
    """Open a Parquet file of some quantities that grows batch by batch and gets its name when it is complete."""
    with atomically_written_file(path) as partial, ExitStack() as open_file:
        writer = TableWriter(path, partial, open_file, quantities, {"camopt_scene": scene})
        with writer.thread:
            yield writer
            writer.wait_until_written()


class TableWriter:
    """Writes rows in a thread, which imports pyarrow. An error is raised with a later batch."""

    def __init__(
        self,
        path: Path,
        partial: Path,
        open_file: ExitStack,
        quantities: Iterable[Quantity],
        about: dict[str, str],
    ) -> None:
        self._path, self._partial, self._open_file = path, partial, open_file
        self._quantities, self._about = tuple(quantities), about
        self.thread = ThreadPoolExecutor(1)
        self._writing: deque[Future[None]] = deque()
        self._groups: RowGroupWriter | None = None
        self._ended = False

    def add_metadata_text(self, key: str, text: str) -> None:
        """Add a text to the metadata, before the first rows."""
        self._about[key] = text

    def append(self, rows: DesignRows) -> None:
        """Add rows."""
        if rows.count:
            self._submit(lambda: self._opened_row_group_writer().append(rows))

    def take_no_more_rows(self) -> None:
        """Take no more rows; the thread writes the remaining ones while other work goes on."""
        if not self._ended:
            self._ended = True
            self._submit(self._finish_file)

    def wait_until_written(self) -> None:
        """Wait until all rows are written."""
        self.take_no_more_rows()
        self._wait_for_writes(0)

    def _submit(self, work: Callable[[], None]) -> None:
        self._wait_for_writes(WAITING_BATCHES)
        self._writing.append(self.thread.submit(work))

    def _wait_for_writes(self, most_pending: int) -> None:
        with attribute_errors_to(self._path, self._partial):
            while len(self._writing) > most_pending:
                self._writing.popleft().result()

    def _opened_row_group_writer(self) -> "RowGroupWriter":
        if self._groups is None:
            rows = import_table_module().open_row_group_writer(self._partial, self._quantities, self._about)
            self._groups = self._open_file.enter_context(rows)
        return self._groups

    def _finish_file(self) -> None:
        self._opened_row_group_writer().write_last_group()
        self._open_file.close()


class TableInMemory:
    """Keeps rows of some quantities in memory for pandas, if no file is written."""

    def __init__(self, quantities: Iterable[Quantity], scene: str) -> None:
        self._quantities, self._about, self._rows = tuple(quantities), {"camopt_scene": scene}, list[DesignRows]()

    def add_metadata_text(self, key: str, text: str) -> None:
        """Add a text to the metadata."""
        self._about[key] = text

    def append(self, rows: DesignRows) -> None:
        """Add rows."""
        if rows.count:
            self._rows.append(rows.select_columns(quantity.name for quantity in self._quantities))

    def take_no_more_rows(self) -> None:
        """Take no more rows."""

    def to_pandas(self) -> "pd.DataFrame":
        """The rows as a DataFrame like that of ``load``."""
        frame: pd.DataFrame = import_table_module().data_frame_from_rows(self._rows, self._quantities, self._about)
        return frame

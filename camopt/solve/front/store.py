"""Finished work of a sweep on disk: a Parquet file for each batch, named by its blocks and its digest.

A sweep resumes from all whole batches on disk, even if others between them are missing. A part of a sweep is a
folder of such files, with a manifest that names them.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.core.engines import Engine
from camopt.core.mistakes import Stopped
from camopt.core.quantities import Quantity
from camopt.core.storage.files import (
    WORK_FOLDER,
    LossWarning,
    atomically_written_file,
    open_regular_file,
    read_bytes,
    write_text,
)
from camopt.core.storage.tables import ARROW_ERRORS, PARQUET_OPTIONS
from camopt.scene.problem.rows import DesignRows
from camopt.solve.front.blocks import BlockBatch, merge_batches
from camopt.solve.front.plan import SweepKey, SweepPlan
from camopt.solve.tables.table import parquet_options, schema_of, to_arrow_table
from camopt.solve.verdicts.limit_verdicts import Effort

BATCH_FILES, QUESTION_FILE = "blocks-*.parquet", "question.json"
BATCH_NAME = re.compile(r"blocks-(\d{1,12})-(\d{1,12})-([0-9a-f]{16})\.parquet")
BATCH_TABLES = ("kept", "front", "best")
BATCH_METADATA = b"camopt_batch"
SAVE_SECONDS = 1.0  # time between files: an interrupt loses no more, and a shorter sweep writes no file
SAVE_ROWS = 2**19  # a file is written sooner once so many rows wait, which bounds the memory: some 150 bytes each

MessageSink = Callable[[str], None]
"""A function that is called with sentences for the user."""


class Store:
    """The finished batches of a sweep, or of a part of one, in a folder.

    Parameters
    ----------
    folder : pathlib.Path
        The folder. The first batch that is written replaces batches of another question in it.
    plan : SweepPlan
        The plan of the sweep.
    sweep_key : SweepKey
        The key of the sweep or part.
    tell : callable, optional
        Called with a sentence if the folder has work of another question, which will be replaced, and with the
        progress of resumed work.

    Attributes
    ----------
    trouble : OSError or None
        The error that ended writing. The sweep continues without the store; written files stay.
    """

    def __init__(self, folder: Path, plan: SweepPlan, sweep_key: SweepKey, tell: MessageSink | None = None) -> None:
        self.folder, self.plan, self.question, self._tell = folder, plan, sweep_key, tell
        self.numbers = plan.part_blocks(sweep_key.part, sweep_key.parts)
        self.trouble: OSError | None = None
        self._pending: list[BlockBatch] = []
        other = stored_key(folder)
        self._is_own = other == sweep_key
        if tell and other and not self._is_own:
            named = ", ".join(other.differences_from(sweep_key))
            tell(
                LossWarning(
                    f"the folder has an interrupted sweep that differs in {named}; the new sweep replaces it"
                )
            )

    def block_ranges_and_batch_files(self) -> list[tuple[range, Path]]:
        """The files of this sweep with their blocks, in order; a file that overlaps an earlier one is left out."""
        files: list[tuple[range, Path]] = []
        for blocks, path in sorted_batch_files(self.folder.iterdir()) if self._is_own else ():
            start = files[-1][0].stop if files else self.numbers.start
            if start <= blocks.start and blocks.stop <= self.numbers.stop:
                files.append((blocks, path))
        return files

    def load_or_evaluate_batches(self, engine: Engine) -> Iterator[BlockBatch]:
        """All batches in order: whole ones from disk, and the others from an engine, which are then saved."""
        files = self.block_ranges_and_batch_files()
        if files and self._tell:
            self._tell(f"resuming an interrupted sweep: {self.progress_in_words} are done")
        for path in {*self.folder.glob(BATCH_FILES)} - {path for _, path in files} if self._is_own else ():
            path.unlink()
        position = self.numbers.start
        for blocks, path in files:
            try:
                batch = read_batch(path, self.plan)
            except BrokenBatch:
                path.unlink()  # its blocks are evaluated again
                continue
            yield from self._evaluate_and_save_blocks(range(position, blocks.start), engine)
            yield batch
            position = blocks.stop
        yield from self._evaluate_and_save_blocks(range(position, self.numbers.stop), engine)

    def _evaluate_and_save_blocks(self, block_numbers: range, engine: Engine) -> Iterator[BlockBatch]:
        since = monotonic()
        for batch in self.plan.evaluate_in_batches(block_numbers, engine) if block_numbers else ():
            self._pending.append(batch)
            rows = sum(pending.kept.count for pending in self._pending)
            if rows >= SAVE_ROWS or monotonic() - since >= SAVE_SECONDS:
                self.write_pending_batches()
                since = monotonic()
            yield batch
        if block_numbers and block_numbers.stop < self.numbers.stop:
            self.write_pending_batches()  # the next blocks are on disk

    def write_pending_batches(self) -> None:
        """Write the pending batches. If the disk refuses them, the sweep continues without."""
        pending, self._pending = self._pending, []
        if not pending or self.trouble:
            return
        try:
            if not self._is_own:
                for path in self.folder.glob(BATCH_FILES):
                    path.unlink()
                write_text(self.folder / QUESTION_FILE, json.dumps(asdict(self.question)))
                self._is_own = True
            write_batch(
                merge_batches(pending, self.plan.problem.objectives), self.plan.searched_row_quantities, self.folder
            )
        except OSError as trouble:
            self.trouble = trouble

    @property
    def progress_in_words(self) -> str:
        """The number of finished designs, in words."""
        before = self.plan.blocks.design_count_before_block
        done = sum(before(blocks.stop) - before(blocks.start) for blocks, _ in self.block_ranges_and_batch_files())
        return f"{done:,} of {before(self.numbers.stop) - before(self.numbers.start):,} designs"


def stored_key(folder: Path) -> SweepKey | None:
    """The key of finished work in a folder; None if there is none, or it is damaged."""
    with suppress(FileNotFoundError, ValueError, TypeError, RecursionError):
        return SweepKey.from_json(json.loads(read_bytes(folder / QUESTION_FILE)))
    return None


def interrupted_key(folder: Path, command: str) -> SweepKey | None:
    """The key of an interrupted sweep in the folder of its result; None if there is none."""
    return stored_key(folder / WORK_FOLDER / command)


@contextmanager
def save_batches_on_early_end(store: Store | None) -> Iterator[None]:
    """Save pending batches if work ends early, and add the progress to the message of the error or interrupt."""
    try:
        yield
    except BaseException as end:
        if store:
            store.write_pending_batches()
            if store.block_ranges_and_batch_files():
                message = f"{store.progress_in_words} are done and kept; the same command goes on from there"
                if isinstance(end, (KeyboardInterrupt, Stopped)):
                    end.args = (f"{end if end.args else 'interrupted'}; {message}",)
                else:
                    end.add_note(message)
        raise


def sorted_batch_files(paths: Iterable[Path]) -> list[tuple[range, Path]]:
    """The files of batches among some paths, with their blocks, in order; the longest first at equal starts."""
    named = [(BATCH_NAME.fullmatch(path.name), path) for path in paths]
    files = [(range(int(name[1]), int(name[2])), path) for name, path in named if name]
    return sorted(files, key=lambda file: (file[0].start, -file[0].stop, file[1].name))


class BrokenBatch(ValueError):
    """A file is no whole batch of a sweep; the message completes "this is …"."""


def batch_bytes(batch: BlockBatch, quantities: Iterable[Quantity]) -> bytes:
    """A batch as a Parquet file: its rows of all three kinds, with its counts in the metadata."""
    layout = schema_of(quantities, camopt_scene="")
    tables = [to_arrow_table(getattr(batch, name), layout) for name in BATCH_TABLES]
    numbers = {name: value for name, value in vars(batch).items() if name not in BATCH_TABLES}
    metadata = {BATCH_METADATA: json.dumps([numbers, [table.num_rows for table in tables]])}
    sink = pa.BufferOutputStream()
    whole = pa.concat_tables(tables).replace_schema_metadata(metadata)
    pq.write_table(whole, sink, **PARQUET_OPTIONS, **parquet_options(layout))
    return bytes(sink.getvalue())


def write_batch(batch: BlockBatch, quantities: Iterable[Quantity], folder: Path) -> None:
    """Write a batch, whole or not at all, under a name with its blocks and its digest."""
    data = batch_bytes(batch, quantities)
    digest = sha256(data).hexdigest()[:16]
    with atomically_written_file(folder / f"blocks-{batch.first:09d}-{batch.last:09d}-{digest}.parquet") as partial:
        partial.write_bytes(data)


def read_batch(path: Path, plan: SweepPlan) -> BlockBatch:
    """The batch in a file.

    Raises
    ------
    BrokenBatch
        If the file does not match its name, or does not belong to the plan.
    OSError
        If it cannot be read.
    """
    name = BATCH_NAME.fullmatch(path.name)
    with open_regular_file(path) as file:
        data = file.read()
    if not name or sha256(data).hexdigest()[:16] != name[3]:
        raise BrokenBatch("damaged, or changed since it was written")
    try:
        table = pq.read_table(pa.BufferReader(data))
        numbers, counts = json.loads(table.schema.metadata[BATCH_METADATA])
        expected = schema_of(plan.searched_row_quantities).remove_metadata()
        if table.schema.remove_metadata() != expected or any(column.null_count for column in table.columns):
            raise BrokenBatch("not what a sweep of its scene gives")
        starts = np.cumsum([0, *counts]).tolist()
        rows: dict[str, Any] = {
            kind: _design_rows_from_arrow_table(table.slice(start, count))
            for kind, start, count in zip(BATCH_TABLES, starts, counts, strict=False)
        }
        batch = BlockBatch(**{**numbers, "effort": Effort._make(numbers["effort"])}, **rows)
        before = plan.blocks.design_count_before_block
        is_of_plan = batch.designs == before(batch.last) - before(batch.first) and sum(counts) == table.num_rows
    except (*ARROW_ERRORS, LookupError, TypeError, AttributeError, RecursionError) as trouble:
        raise BrokenBatch("not what a sweep of its scene gives") from trouble
    if not is_of_plan or (batch.first, batch.last) != (int(name[1]), int(name[2])):
        raise BrokenBatch("not what a sweep of its scene gives")
    return batch


def _design_rows_from_arrow_table(table: Any) -> DesignRows:
    return DesignRows({name: _array_from_arrow_column(table[name]) for name in table.column_names}, table.num_rows)


def _array_from_arrow_column(column: Any) -> Any:
    if column.type != pa.string():
        return column.to_numpy()
    coded = column.combine_chunks().dictionary_encode()
    return np.array(coded.dictionary.to_pylist() or [""], dtype=str)[coded.indices.to_numpy()]

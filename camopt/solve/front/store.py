"""Finished work of a sweep on disk: a Parquet file for each batch, named by its blocks and its digest.

A sweep goes on with the batches that are there and whole, whatever is missing between them. A part of a sweep is a
folder of such files, with a manifest that names them.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.core.engines import Engine
from camopt.core.mistakes import Stopped
from camopt.core.numerics.clock import clock_seconds
from camopt.core.quantities import Quantity
from camopt.core.storage.files import WORK_FOLDER, LossWarning, read_bytes, regular_file, whole_file, write_text
from camopt.core.storage.tables import ARROW_ERRORS, PARQUET_OPTIONS
from camopt.scene.problem.rows import DesignRows
from camopt.solve.front.blocks import BlockBatch, merge_batches
from camopt.solve.front.plan import SweepKey, SweepPlan
from camopt.solve.tables.table import parquet_options, schema_of, to_table
from camopt.solve.verdicts.limit_verdicts import Effort

BATCH_FILES, QUESTION_FILE = "blocks-*.parquet", "question.json"
BATCH_NAME = re.compile(r"blocks-(\d{1,12})-(\d{1,12})-([0-9a-f]{16})\.parquet")
BATCH_TABLES = ("kept", "front", "best")
BATCH_METADATA = b"camopt_batch"
SAVE_SECONDS = 1.0  # between files: less is lost at most, and a sweep that is shorter writes none
SAVE_ROWS = 2**19  # or as soon as so many rows wait, which bounds the memory: some 150 bytes each

MessageSink = Callable[[str], None]
"""What takes sentences that a user should know before the work."""


class Store:
    """The finished batches of a sweep, or of a part of one, in a folder.

    Parameters
    ----------
    folder : pathlib.Path
        The folder; batches of another question in it go when the first one is written.
    plan : SweepPlan
        Of the sweep as it is asked now.
    question : SweepKey
        Its key.
    tell : callable, optional
        Told if work of another question is there, which goes; and how far this one is.

    Attributes
    ----------
    trouble : OSError or None
        Why no more could be written. A sweep goes on without it; what was written is kept.
    """

    def __init__(self, folder: Path, plan: SweepPlan, question: SweepKey, tell: MessageSink | None = None) -> None:
        self.folder, self.plan, self.question, self._tell = folder, plan, question, tell
        self.numbers = plan.part_blocks(question.part, question.parts)
        self.trouble: OSError | None = None
        self._pending: list[BlockBatch] = []
        self._since = clock_seconds()
        other = stored_key(folder)
        self._is_own = other == question
        if tell and other and not self._is_own:
            named = ", ".join(other.differences_from(question))
            tell(
                LossWarning(
                    f"an interrupted sweep was here that differs in {named}; this one starts anew and replaces it"
                )
            )

    def files(self) -> list[tuple[range, Path]]:
        """The files of this sweep with their blocks, in order; of those that overlap the one that begins first."""
        found: list[tuple[range, Path]] = []
        for blocks, path in batch_files(self.folder.iterdir()) if self._is_own else ():
            if (
                blocks.start >= (found[-1][0].stop if found else self.numbers.start)
                and blocks.stop <= self.numbers.stop
            ):
                found.append((blocks, path))
        return found

    def batches(self, engine: Engine) -> Iterator[BlockBatch]:
        """All batches in order: those on disk that are whole; others are evaluated by an engine, and kept."""
        there = self.files()
        if there and self._tell:
            self._tell(f"going on where an interrupted sweep ended: {self.progress} are done")
        for path in {*self.folder.glob(BATCH_FILES)} - {path for _, path in there} if self._is_own else ():
            path.unlink()
        position = self.numbers.start
        for blocks, path in there:
            try:
                batch = read_batch(path, self.plan)
            except BrokenBatch:
                path.unlink()  # evaluated anew
                continue
            yield from self._evaluate_missing(range(position, blocks.start), engine)
            yield batch
            position = blocks.stop
        yield from self._evaluate_missing(range(position, self.numbers.stop), engine)

    def _evaluate_missing(self, numbers: range, engine: Engine) -> Iterator[BlockBatch]:
        self._since = clock_seconds()
        for batch in self.plan.batches(numbers, engine) if numbers else ():
            self._pending.append(batch)
            rows = sum(each.kept.count for each in self._pending)
            if rows >= SAVE_ROWS or clock_seconds() - self._since >= SAVE_SECONDS:
                self.save()
                self._since = clock_seconds()
            yield batch
        if numbers and numbers.stop < self.numbers.stop:
            self.save()  # what follows is on disk

    def save(self) -> None:
        """Write what waits. A disk that takes none does not end the sweep."""
        some, self._pending = self._pending, []
        if not some or self.trouble:
            return
        try:
            if not self._is_own:
                for path in self.folder.glob(BATCH_FILES):
                    path.unlink()
                write_text(self.folder / QUESTION_FILE, json.dumps(self.question.to_manifest))
                self._is_own = True
            write_batch(merge_batches(some, self.plan.problem.objectives), self.plan.row_quantities, self.folder)
        except OSError as trouble:
            self.trouble = trouble

    @property
    def progress(self) -> str:
        """The number of finished designs, in words."""
        before = self.plan.blocks.designs_before
        done = sum(before(blocks.stop) - before(blocks.start) for blocks, _ in self.files())
        return f"{done:,} of {before(self.numbers.stop) - before(self.numbers.start):,} designs"


def stored_key(folder: Path) -> SweepKey | None:
    """The question of finished work in a folder; None if there is none, or it is damaged."""
    with suppress(FileNotFoundError, ValueError, TypeError, RecursionError):
        return SweepKey.from_json(json.loads(read_bytes(folder / QUESTION_FILE)))
    return None


def interrupted_key(folder: Path, command: str) -> SweepKey | None:
    """The question of an interrupted sweep in the folder of its result; None if there is none."""
    return stored_key(folder / WORK_FOLDER / command)


@contextmanager
def save_at_end(store: Store | None) -> Iterator[None]:
    """Save what waits when work ends early, and say so: an error, or the end of a stopped sweep, gets a note."""
    try:
        yield
    except BaseException as end:
        if store:
            store.save()
            if store.files():
                told = f"{store.progress} are done and kept; the same command goes on from there"
                if isinstance(end, (KeyboardInterrupt, Stopped)):
                    end.args = (f"{end if end.args else 'interrupted'}; {told}",)
                else:
                    end.add_note(told)
        raise


def batch_files(paths: Iterable[Path]) -> list[tuple[range, Path]]:
    """The files of batches among some, with their blocks, in order; the longest first of those that begin alike."""
    named = [(BATCH_NAME.fullmatch(path.name), path) for path in paths]
    found = [(range(int(name[1]), int(name[2])), path) for name, path in named if name]
    return sorted(found, key=lambda each: (each[0].start, -each[0].stop, each[1].name))


class BrokenBatch(ValueError):
    """A file is no whole batch of a sweep; the message completes "this is …"."""


def batch_bytes(batch: BlockBatch, quantities: Iterable[Quantity]) -> bytes:
    """A batch as a Parquet file: its rows of all three kinds, and its numbers in the metadata."""
    layout = schema_of(quantities, camopt_scene="")
    tables = [to_table(getattr(batch, name), layout) for name in BATCH_TABLES]
    numbers = {name: value for name, value in vars(batch).items() if name not in BATCH_TABLES}
    about = {BATCH_METADATA: json.dumps([numbers, [table.num_rows for table in tables]])}
    sink = pa.BufferOutputStream()
    whole = pa.concat_tables(tables).replace_schema_metadata(about)
    pq.write_table(whole, sink, **PARQUET_OPTIONS, **parquet_options(layout))
    return bytes(sink.getvalue())


def write_batch(batch: BlockBatch, quantities: Iterable[Quantity], folder: Path) -> None:
    """Write a batch, whole or not at all, under the name that tells its blocks and its digest."""
    data = batch_bytes(batch, quantities)
    digest = sha256(data).hexdigest()[:16]
    with whole_file(folder / f"blocks-{batch.first:09d}-{batch.last:09d}-{digest}.parquet") as partial:
        partial.write_bytes(data)


def read_batch(path: Path, plan: SweepPlan) -> BlockBatch:
    """The batch in a file.

    Raises
    ------
    BrokenBatch
        If it is not the one that its name tells, or none of the plan.
    OSError
        If it cannot be read.
    """
    name = BATCH_NAME.fullmatch(path.name)
    with regular_file(path) as file:
        data = file.read()
    if not name or sha256(data).hexdigest()[:16] != name[3]:
        raise BrokenBatch("damaged, or changed since it was written")
    try:
        table = pq.read_table(pa.BufferReader(data))
        numbers, counts = json.loads(table.schema.metadata[BATCH_METADATA])
        expected = schema_of(plan.row_quantities).remove_metadata()
        if table.schema.remove_metadata() != expected or any(column.null_count for column in table.columns):
            raise BrokenBatch("not what a sweep of its scene gives")
        starts = np.cumsum([0, *counts]).tolist()
        rows: dict[str, Any] = {
            kind: _rows_of_table(table.slice(start, count))
            for kind, start, count in zip(BATCH_TABLES, starts, counts, strict=False)
        }
        batch = BlockBatch(**{**numbers, "effort": Effort._make(numbers["effort"])}, **rows)
        before = plan.blocks.designs_before
        is_of_plan = batch.designs == before(batch.last) - before(batch.first) and sum(counts) == table.num_rows
    except (*ARROW_ERRORS, LookupError, TypeError, AttributeError, RecursionError) as trouble:
        raise BrokenBatch("not what a sweep of its scene gives") from trouble
    if not is_of_plan or (batch.first, batch.last) != (int(name[1]), int(name[2])):
        raise BrokenBatch("not what a sweep of its scene gives")
    return batch


def _rows_of_table(table: Any) -> DesignRows:
    return DesignRows({name: _array_of_column(table[name]) for name in table.column_names}, table.num_rows)


def _array_of_column(column: Any) -> Any:
    if column.type != pa.string():
        return column.to_numpy()
    coded = column.combine_chunks().dictionary_encode()
    words = np.array(coded.dictionary.to_pylist() or [""], dtype=str)
    return words[coded.indices.to_numpy()]

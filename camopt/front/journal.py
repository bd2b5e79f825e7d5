"""The journal of a sweep: the results of finished blocks, on disk, so that no evaluation is lost.

A journal starts with the question that was asked. Records follow, each some blocks that follow those of the record
before, with its length and digest: what a death cut short, or a flipped bit changed, is known, and evaluated anew.
A part of a sweep is a journal that is whole.
"""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import copyfile
from typing import Any, BinaryIO, TypeVar

from camopt.engines import Engine
from camopt.front.blocks import Batch, merged
from camopt.front.plan import SweepKey, SweepPlan
from camopt.mistakes import Stopped
from camopt.numerics.clock import now
from camopt.storage.files import regular_file, synced, whole_file
from camopt.storage.publishing import already_done, answered
from camopt.storage.records import END_RECORD, JOURNAL_MAGIC, cut_after, record, records
from camopt.storage.unit import journal_path

RECORD_SECONDS = 1.0  # between records: less is lost at most, and a sweep that is shorter writes none
RECORD_ROWS = 2**19  # or as soon as so many rows wait, which bounds the memory: some 150 bytes each

Found = TypeVar("Found")


class Journal:
    """A journal that is read as far as it is intact, and then continued.

    Parameters
    ----------
    path : pathlib.Path
        The file; a new one if there is none.
    plan : SweepPlan
        Of the sweep as it is asked now.
    question : SweepKey
        Its key, as texts. A journal of another key is replaced.

    Attributes
    ----------
    done : int
        The number after that of the last block that is on disk.
    trouble : OSError or None
        Why no more could be written. A sweep goes on without it; what was written is kept.
    """

    def __init__(self, path: Path, plan: SweepPlan, question: SweepKey) -> None:
        self.path, self.plan, self.question = path, plan, question
        self.numbers = plan.numbers(question.part, question.parts)
        self.done = self.numbers.start
        self.trouble: OSError | None = None
        self._whole = 0  # bytes
        self._is_replayed = False
        self._pending: list[Batch] = []
        self._since = now()
        self._thread = ThreadPoolExecutor(1)
        self._writing: Future[None] | None = None
        _separate(path)

    def replayed(self) -> Iterator[Batch]:
        """The batches of a journal of the same question, in order, up to where it is whole."""
        with suppress(FileNotFoundError), self.path.open("rb") as file:
            for batch, end in batches_of(file, self.question, self.plan):
                self.done, self._whole = batch.last, end
                yield batch
        self._is_replayed = True
        self._since = now()

    def add(self, batch: Batch) -> None:
        """Add the next batch. It is written within about a second, beside the work."""
        if self.trouble:
            return
        self._pending.append(batch)
        rows = sum(each.kept.count for each in self._pending)
        if rows >= RECORD_ROWS or now() - self._since >= RECORD_SECONDS:
            self._write_pending()
            self._since = now()

    def write_all(self) -> None:
        """Write what is pending, now."""
        self._write_pending()
        self._wait()

    def close(self) -> None:
        """Write no more."""
        self._wait()
        self._thread.shutdown()

    def finish(self, path: Path) -> None:
        """Write the rest and the end, and give the file a name: it is a whole part of a sweep.

        Raises
        ------
        OSError
            If it could not be written.
        """
        self.write_all()
        if self.trouble:
            raise self.trouble
        self._append(END_RECORD)
        try:
            os.link(self.path, path)  # the journal stays until the part is published
        except OSError:  # no links here
            copyfile(self.path, path)

    @property
    def kept(self) -> str:
        """The finished work, in words; empty if there is none."""
        kept = self.done > self.numbers.start and self.path.exists()
        least = "" if self._is_replayed else "at least "  # an interrupt may come before it is read to its end
        return f"{least}{self.progress} are done and kept" if kept else ""

    @property
    def progress(self) -> str:
        """The number of finished designs, in words."""
        places = (self.numbers.start, self.done, self.numbers.stop)
        before, done, after = map(self.plan.blocks.designs_before, places)
        return f"{done - before:,} of {after - before:,} designs"

    def _write_pending(self) -> None:
        """Have what is pending written once the record before is: no more than two wait in memory."""
        self._wait()
        some, self._pending = self._pending, []
        if some and not self.trouble:
            batch = merged(some, self.plan.problem.objectives)
            self._writing = self._thread.submit(self._write, batch)

    def _wait(self) -> None:
        if self._writing is None:
            return
        try:
            self._writing.result()
        except OSError as trouble:
            self.trouble = trouble
        self._writing = None

    def _write(self, batch: Batch) -> None:
        from camopt.front.batch_bytes import encoded

        self._append(encoded(batch, self.plan.row_names))
        self.done = batch.last

    def _append(self, payload: bytes) -> None:
        """Write a record behind the last whole one; in a new file behind the question."""
        with self.path.open("r+b" if self._whole else "wb") as file:
            file.seek(self._whole)
            file.truncate()
            if not self._whole:
                file.write(JOURNAL_MAGIC + record(self.question.encoded()))
            file.write(record(payload))
            file.flush()
            synced(self.path)
            self._whole = file.tell()


def _separate(path: Path) -> None:
    """Give a journal a file of its own, if a death left it as a part that is published, and stays as it is."""
    with suppress(FileNotFoundError):
        if path.stat().st_nlink > 1:
            with whole_file(path) as partial:
                copyfile(path, partial)


Tell = Callable[[str], None]
"""What takes sentences that a user should know before the work."""


class Lost(str):
    """A sentence on data that will be removed."""


@contextmanager
def journal_at(
    path: Path, plan: SweepPlan, part: int = 1, parts: int = 1, tell: Tell | None = None
) -> Iterator[Journal]:
    """The journal of a sweep or of a part of one, closed in the end. ``tell`` is told if another one was there."""
    journal = Journal(path, plan, plan.question(part, parts))
    say_of_another(path, journal.question, tell)
    try:
        yield journal
    except BaseException:
        journal.write_all()
        raise
    finally:
        journal.close()


def say_of_another(path: Path, question: SweepKey, tell: Tell | None) -> None:
    """Say so if there is a journal of another question."""
    found = question_of(path)
    if tell and found and found != question:
        other = ", ".join(found.other_than(question))
        tell(Lost(f"an interrupted sweep was here that differs in {other}; this one starts anew and replaces it"))


@contextmanager
def what_is_kept(kept: Callable[[], str]) -> Iterator[None]:
    """Add to an error, or to the end of a stopped sweep, a note on the finished work that is kept."""
    try:
        yield
    except BaseException as end:
        told = (words := kept()) and f"{words}; the same command goes on from there"
        if told and isinstance(end, (KeyboardInterrupt, Stopped)):
            end.args = (f"{end if end.args else 'interrupted'}; {told}",)
        elif told:
            end.add_note(told)
        raise


def all_batches(journal: Journal, engine: Engine, tell: Tell | None = None) -> Iterator[Batch]:
    """The batches of a journal, and those that follow, which it takes. ``tell`` is told how many there were."""
    yield from journal.replayed()
    if tell and journal.done > journal.numbers.start:
        tell(f"going on where an interrupted sweep ended: {journal.progress} are done")
    for batch in journal.plan.batches(range(journal.done, journal.numbers.stop), engine):
        journal.add(batch)
        yield batch


def interrupted(folder: Path, command: str) -> SweepKey | None:
    """The question of an interrupted sweep of a folder; None if there is none."""
    return question_of(journal_path(folder, command))


def question_of(path: Path) -> SweepKey | None:
    """The question of a journal; None if there is none, or it is damaged.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    with suppress(FileNotFoundError, ValueError, TypeError, RecursionError), regular_file(path) as file:
        for payload, _ in records(file):
            return SweepKey.decoded(payload)
    return None


def batches_of(file: BinaryIO, question: SweepKey, plan: SweepPlan) -> Iterator[tuple[Batch, int]]:
    """The batches of a journal up to an odd one, each with where it ends; none if it is of another question."""
    from camopt.front.batch_bytes import sound

    numbers = plan.numbers(question.part, question.parts)
    found, expected = records(file), numbers.start
    for payload, _ in found:
        if payload != question.encoded():
            return
        break
    for payload, end in found:
        if payload == END_RECORD:
            return
        batch = sound(payload, plan)
        if batch is None or batch.first != expected or batch.last > numbers.stop:
            return
        expected = batch.last
        yield batch, end


def recalled(
    folder: str | os.PathLike[str],
    command: str,
    question: SweepKey,
    result: Callable[[Any], Found],
    tell: Tell | None,
) -> Found | None:
    """The result of a sweep that is in a folder already, made of what its manifest says; None if it is not there.

    ``tell`` is told. The journal of the same question, which a death may have left, has been used up.
    """

    def is_spent(journal: Path) -> bool:
        kept = question_of(journal)
        return kept is not None and kept.plain == question.plain

    answer = answered(folder, command, question.plain, is_spent)
    with suppress(LookupError, TypeError, ValueError, AttributeError):  # a manifest may say anything
        found = None if answer is None else result(answer)
        if found is not None and tell:
            tell(already_done(folder))
        return found
    return None


class Broken(ValueError):
    """A part of a sweep is damaged; the message says where."""


def whole_batches(path: Path, question: SweepKey, plan: SweepPlan) -> Iterator[Batch]:
    """The batches of a part of a sweep.

    Raises
    ------
    Broken
        If it is not as it was written; after the batches before that place.
    """
    numbers = plan.numbers(question.part, question.parts)
    done, whole = numbers.start, len(JOURNAL_MAGIC + record(question.encoded()))
    with regular_file(path) as file:
        for batch, end in batches_of(file, question, plan):
            done, whole = batch.last, end
            yield batch
        file.seek(whole)
        last = file.read()
    if done != numbers.stop or last != record(END_RECORD):
        raise Broken(f"this is {cut_after(whole)}, or not what a sweep of its scene gives there")

"""The state of a search for the front only, kept now and then, so that an ended search goes on from there."""

import io
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np

from camopt.front.front_search import FrontSearch
from camopt.front.grid_boxes import GridBoxes
from camopt.front.journal import Tell, say_of_another
from camopt.front.plan import SweepKey, SweepPlan
from camopt.numerics.clock import now
from camopt.problem.rows import Rows
from camopt.storage.files import whole_file
from camopt.storage.records import JOURNAL_MAGIC, record, records, write_record
from camopt.verdicts.judging import Effort

STATE_SECONDS = 10.0  # between states: a search that is shorter keeps none
ARCHIVE = b"PK"  # what arrays begin with; blocks, which a cluster evaluated for the same question, do not
BOX_LISTS = ("waiting", "small")
STATE_NUMBERS = ("started", "boxes", "finished", "evaluated", "decided", "reached")


class Checkpoint:
    """The last state of a search in a file that begins as a journal does: with the question."""

    def __init__(self, path: Path, question: SweepKey) -> None:
        self.path, self.question = path, question
        self.kept = ""
        """What is kept, in words; empty if nothing is."""
        self._since = now()

    def restore(self, search: FrontSearch, tell: Tell | None = None) -> None:
        """Give a search the state that was kept for the same question, if there is one; ``tell`` is told."""
        with suppress(FileNotFoundError), self.path.open("rb") as file:
            payloads = [payload for payload, _ in records(file)]
            if len(payloads) == 2 and payloads[0] == self.question.encoded() and payloads[1].startswith(ARCHIVE):
                set_state(search, payloads[1])
                self.kept = kept_of(search)
                if tell:
                    tell(f"going on where an interrupted sweep ended: {self.kept}")

    def offer(self, search: FrontSearch) -> None:
        """Keep the state if the last one is old. A disk that takes none does not end the search."""
        if now() - self._since >= STATE_SECONDS:
            with suppress(OSError), whole_file(self.path) as partial:
                with partial.open("wb") as file, TemporaryFile(dir=self.path.parent) as state:
                    file.write(JOURNAL_MAGIC + record(self.question.encoded()))
                    write_state(state, search)
                    write_record(file, state)
                self.kept = kept_of(search)
            self._since = now()


@contextmanager
def checkpoint_at(path: Path, plan: SweepPlan, tell: Tell | None = None) -> Iterator[Checkpoint]:
    """The checkpoint of a search. ``tell`` is told if there was one of another question."""
    checkpoint = Checkpoint(path, plan.question())
    say_of_another(path, checkpoint.question, tell)
    yield checkpoint


def kept_of(search: FrontSearch) -> str:
    """The progress of a search, in words."""
    return f"{search.boxes + search.finished:,} boxes of designs are decided and kept"


def write_state(file: IO[bytes], search: FrontSearch) -> None:
    """Write the state of a search between two steps, as arrays of NumPy."""
    rows = search.archive.front()
    arrays: dict[str, Any] = {f"row {name}": rows.column(name) for name in rows.columns}
    for name in BOX_LISTS:
        parts: list[GridBoxes] = getattr(search, name)
        arrays |= {f"{name} {i} {key}": value for i, part in enumerate(parts) for key, value in vars(part).items()}
    numbers = {name: getattr(search, name) for name in STATE_NUMBERS} | {"effort": search.effort}
    counts = {name: len(getattr(search, name)) for name in BOX_LISTS} | {"rows": rows.count}
    np.savez(file, numbers=np.array(json.dumps([numbers, counts])), **arrays)


def set_state(search: FrontSearch, data: bytes) -> None:
    """Give a search the state of another."""
    with np.load(io.BytesIO(data)) as arrays:
        numbers, counts = json.loads(str(arrays["numbers"]))
        columns = {key.removeprefix("row "): arrays[key] for key in arrays.files if key.startswith("row ")}
        for name in BOX_LISTS:
            keys = [f"{name} {i}" for i in range(counts[name])]
            fields = GridBoxes.__dataclass_fields__
            setattr(search, name, [GridBoxes(*(arrays[f"{key} {field}"] for field in fields)) for key in keys])
    for name in STATE_NUMBERS:
        setattr(search, name, numbers[name])
    search.effort = Effort(*numbers["effort"])
    search.learn(Rows(columns, counts["rows"]))

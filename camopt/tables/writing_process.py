"""A process of its own that writes tables: it imports pyarrow while this one reads the scene and searches.

It is forked while this process has one thread, so it need not start anew. It writes unfinished files, and gives
none its name: that is done here, once a table is whole. Where none can be forked, a thread writes.
"""

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from errno import EIO
from functools import partial
from pathlib import Path
from threading import Lock
from typing import IO, Any, NamedTuple, NoReturn

from camopt.storage.manifest import Fact

PROCESSES: list["WritingProcess"] = []
"""Of this process: the one that writes its tables, if there is one."""
INTERRUPTS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if sys.platform == "linux" else ()
THREADS = Path("/proc/self/task")
"""The folder with a file for each thread of this process, on Linux."""


@contextmanager
def writing_process() -> Iterator[None]:
    """Within the block, a process of its own writes tables, if one can be forked."""
    import numpy  # noqa: F401  # both need it

    with ExitStack() as stack:
        if _is_forked_safely():
            with suppress(OSError):  # too many processes, or no memory
                PROCESSES.append(stack.enter_context(WritingProcess()))
                stack.callback(end_writing_process)
        yield


def end_writing_process() -> None:
    """End it, if there is one: its memory is freed beside other work. What is not whole is lost."""
    while PROCESSES:
        os.kill(PROCESSES.pop().number, signal.SIGKILL)


def _is_forked_safely() -> bool:
    """Whether no thread would be missed; and a process that has pyarrow need not wait for its import."""
    return "pyarrow" not in sys.modules and THREADS.is_dir() and len(os.listdir(THREADS)) == 1


class WritingProcess:
    """The process that writes tables, as this one sees it; at the end of its block it has been ended."""

    def __init__(self) -> None:
        (asked, self._ask), (self._told, tell) = _pipe(), _pipe()
        self._one_at_a_time = Lock()
        heeded = signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTS)  # what interrupts this process is its matter
        try:
            self.number = os.fork()
            if not self.number:
                self._ask.close()  # or the process would wait for itself
                _work(asked, tell)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, heeded)
        asked.close()
        tell.close()

    def __enter__(self) -> "WritingProcess":
        return self

    def __exit__(self, *_: object) -> None:
        os.waitpid(self.number, 0)
        self._told.close()
        with suppress(OSError):  # what is left to be asked
            self._ask.close()

    @contextmanager
    def row_groups(
        self, path: Path, names: tuple[str, ...], about: dict[str, str], tell: Callable[[Fact], Any]
    ) -> Iterator[Callable[[Any], None]]:
        """As ``camopt.tables.row_groups.row_groups``."""
        self._answer("open", path, names, about)
        yield partial(self._answer, "append", path)
        tell(self._answer("close", path))

    def _answer(self, method: str, *arguments: Any) -> Any:
        """What a method of ``Tables`` gives there; what it raises is raised here."""
        with self._one_at_a_time:
            try:
                pickle.dump((method, arguments), self._ask, pickle.HIGHEST_PROTOCOL)
                self._ask.flush()
                found, trouble = pickle.load(self._told)
            except (EOFError, BrokenPipeError, pickle.UnpicklingError):
                raise OSError(EIO, "the process that writes it has ended") from None
        if trouble:
            raise trouble
        return found


def _pipe() -> tuple[IO[bytes], IO[bytes]]:
    """The ends of a pipe: where it is read, and where it is written to."""
    read, written = os.pipe()
    return os.fdopen(read, "rb"), os.fdopen(written, "wb")


class _Table(NamedTuple):
    """A table that the process writes."""

    whole: ExitStack
    append: Callable[[Any], None]
    facts: list[Fact]


class Tables:
    """The tables that the process writes."""

    def __init__(self) -> None:
        self._tables: dict[Path, _Table] = {}

    def open(self, path: Path, names: tuple[str, ...], about: dict[str, str]) -> None:
        """Begin one."""
        from camopt.tables.row_groups import row_groups

        whole, facts = ExitStack(), list[Fact]()
        append = whole.enter_context(row_groups(path, names, about, facts.append))
        self._tables[path] = _Table(whole, append, facts)

    def append(self, path: Path, rows: Any) -> None:
        """Add rows to it."""
        self._tables[path].append(rows)

    def close(self, path: Path) -> Fact:
        """Write what is left, and its seal; the manifest's record of it."""
        table = self._tables.pop(path)
        table.whole.close()
        return table.facts[0]


def _work(asked: IO[bytes], tell: IO[bytes]) -> NoReturn:
    """Do what the other process asks, as long as that one is there."""
    try:
        import camopt.tables.row_groups  # noqa: F401  # before it is asked for

        tables = Tables()
        while True:
            method, arguments = pickle.load(asked)
            found = trouble = None
            try:
                found = getattr(tables, method)(*arguments)
            except Exception as raised:
                trouble = raised
            pickle.dump((found, trouble), tell)
            tell.flush()
    finally:
        os._exit(0)

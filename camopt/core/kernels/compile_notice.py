"""A notice when a compilation begins, and the loaded kernels."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

READY_KERNELS: list[str] = []
"""Names of the kernels whose machine code is loaded, once for each kind of arguments."""
_NOTICES: list[Callable[[], None]] = []


def announce_compilation() -> None:
    """Call the notice of the block, if it was not called before. Compilations hold a lock."""
    while _NOTICES:
        _NOTICES.pop()()


@contextmanager
def compilation_notice(notify: Callable[[], None]) -> Iterator[None]:
    """Call ``notify`` once if a kernel is compiled within the block."""
    _NOTICES.append(notify)
    try:
        yield
    finally:
        _NOTICES.clear()

"""Locks of open files, which the system lets go when their process ends, however it does."""

from time import monotonic, sleep

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

OFTEN = 0.02  # seconds between two looks at a lock


def lock(descriptor: int) -> bool | None:
    """Lock an open file until it is closed or the process ends: False if another one has it, None without locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def lock_in_time(descriptor: int, patience: float) -> None:
    """Lock an open file once another process lets it go, or go on without after some seconds."""
    end = monotonic() + patience
    while lock(descriptor) is False and monotonic() < end:
        sleep(OFTEN)

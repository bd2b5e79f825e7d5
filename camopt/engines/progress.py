"""Progress of long work: how callers see it, and how they end the work."""

from collections.abc import Callable

from camopt.mistakes import Stopped

Progress = Callable[[int, int], bool | None]
"""Called with how much is done, and of how much, which may change; False ends the work."""


def report_progress(progress: Progress | None, done: int, total: int) -> None:
    """Tell a caller how far the work is.

    Raises
    ------
    Stopped
        If the caller's answer is False. None, which most functions return, is no answer.
    """
    if progress and progress(done, total) is False:
        raise Stopped("stopped by the caller")

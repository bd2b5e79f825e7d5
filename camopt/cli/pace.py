"""Progress of a command: the share done, the rate, and the time for the rest."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf

from camopt.tables.cells import duration

QUIET_SECONDS, LINE_SECONDS = 10.0, 30.0  # seconds before the first line, and between lines at most
PACE_SHARE = 0.1  # of all: what is done between lines, if it takes less


@dataclass
class Pace:
    """The pace since the first call, before which what is done may have been kept from another run."""

    clock: Callable[[], float]
    """Seconds."""
    first: tuple[float, int] | None = None
    """When it was called first, and what was done then."""

    def __call__(self, done: int, total: int) -> tuple[float, float]:
        """What is done by second, and the seconds that the rest takes at that rate; 0 and inf if it is not known.

        The total may change.
        """
        now = self.clock()
        start, before = self.first = self.first or (now, done)
        rate = (done - before) / (now - start) if now > start else 0.0
        return rate, (total - done) / rate if rate > 0.0 else inf


def rate_of(rate: float, unit: str) -> str:
    return f"{rate:,.0f} {unit}/s" if rate >= 10.0 else f"{rate:.2g} {unit}/s" if rate >= 0.1 else ""


def time_left(seconds: float) -> str:
    """The time left as h:mm:ss, or nothing if it is not known."""
    return f"{duration(seconds)} left" if seconds < inf else ""


@dataclass
class LogLines:
    """Lines for where there is no terminal, in a log for instance: none of short work, and some of long work."""

    unit: str
    clock: Callable[[], float]
    say: Callable[[str], None]
    pace: Pace = field(init=False)
    start: float = field(init=False)
    told: tuple[float, float] | None = None
    """When the last line was, and what share was done."""

    def __post_init__(self) -> None:
        self.pace, self.start = Pace(self.clock), self.clock()

    def __call__(self, done: int, total: int) -> None:
        rate, left = self.pace(done, total)
        now, share = self.clock(), done / total if total else 1.0
        if self.told:
            when, before = self.told
            due = now - when >= LINE_SECONDS or share - before >= PACE_SHARE
        else:
            due = now - self.start >= QUIET_SECONDS
        if due:
            self.told = now, share
            parts = f"{done:,} of {total:,} {self.unit} ({share:.0%})", rate_of(rate, self.unit), time_left(left)
            self.say(f"camopt: {', '.join(filter(None, parts))}")

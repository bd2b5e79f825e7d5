"""Budgets of searches: each stops after some work, so that no load and no speed of a machine changes its answer.

A search counts the work of each step before it does it. The count depends on the problem alone, and not on what is
cached or compiled. The unit of work takes about a microsecond on a usual machine. If a user gives a time, the clock
decides instead.
"""

from dataclasses import dataclass, field, replace
from math import inf
from time import monotonic

from camopt.core.mistakes import BadInput, Mistake


@dataclass
class Meter:
    """Counts work, or reads the clock."""

    is_clock: bool = False
    work: float = 0.0

    def read(self) -> float:
        """The work so far, or the time [s]."""
        return monotonic() if self.is_clock else self.work


@dataclass(frozen=True)
class Budget:
    """What a search may use: up to the reading ``end`` of a meter.

    Shares of a budget have one meter. So what one share leaves is free for the next.
    """

    end: float
    meter: Meter = field(default_factory=Meter)

    def spend(self, work: float) -> None:
        """Count the work of the next step."""
        self.meter.work += work

    @property
    def is_spent(self) -> bool:
        """Whether the search must stop."""
        return self.meter.read() >= self.end

    def share(self, tasks_left: float) -> "Budget":
        """The budget of the first of ``tasks_left`` equal tasks, which leaves the others as much."""
        start = self.meter.read()
        return replace(self, end=start + max(self.end - start, 0.0) / tasks_left)


UNLIMITED = Budget(inf)


def search_budget(seconds: float | None, work: float) -> Budget:
    """The budget of a search: the seconds that a user gives, else some work.

    Raises
    ------
    BadInput
        If ``seconds`` is not a number above 0.
    """
    if seconds is None:
        return Budget(work)
    if not (isinstance(seconds, int | float) and seconds > 0.0):
        raise BadInput([Mistake("camopt", "seconds", seconds, "a number above 0")])
    return Budget(monotonic() + seconds, Meter(is_clock=True))

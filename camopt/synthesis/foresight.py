"""An estimate of the time of a frontier, given as soon as its first searches have been timed."""

from collections.abc import Callable, Sequence
from math import ceil

from camopt.numerics.clock import now
from camopt.tables.cells import duration

LONG = 20.0  # seconds: a shorter time is over before anyone wonders
FAR_MORE = 2.0  # times what was told, which is told again


class Foresight:
    """The time of searches that run one kind after the other, each kind on all workers.

    Those to come are taken to be as long as those of the last kind: where a load is an axis, the first kind that
    has it tells more than the kinds before.
    """

    def __init__(self, kinds: Sequence[int], workers: int, tell: Callable[[str], None] | None) -> None:
        """``kinds`` are the numbers of searches, in order."""
        self._kinds, self._workers, self._tell = [*kinds], workers, tell
        self._begun, self._since, self._told = now(), now(), LONG / FAR_MORE

    def kind_done(self) -> None:
        """The searches of the next kind are done: say what all of them will take, where that is long."""
        count, here = self._kinds.pop(0), now()
        if not count or not self._tell:
            return
        each = (here - self._since) / self._rounds(count)
        rest = sum(map(self._rounds, self._kinds)) * each
        whole, self._since = here - self._begun + rest, here
        if rest > 0.0 and whole > FAR_MORE * self._told:
            self._told = whole
            more = f"{sum(self._kinds):,} more searches for a motion"
            self._tell(f"{more}, about {duration(whole)} in all; fewer points take less")

    def _rounds(self, count: int) -> int:
        """The number of searches of a worker, one after the other."""
        return ceil(count / self._workers)

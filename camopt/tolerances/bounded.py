"""A bound that is a little more than what a cam has that was found, proved; a worse cam takes its place."""

from collections.abc import Callable, Sequence
from math import inf, sqrt
from typing import Generic, NamedTuple, TypeVar

from camopt.numerics.clock import now, share
from camopt.verdicts.words import BROKEN, HELD

WORSE = 8
"""How often a worse cam than the worst so far is taken for it, for one gap."""
SECONDS = 10.0
"""For the bounds of all dwells of a motion, and for those of all passages of a lift."""

Values = dict[str, float]
Cam = TypeVar("Cam")


class Tried(NamedTuple):
    """Whether no cam exceeds a bound, and one that does, if one is found."""

    verdict: str
    cam: Values | None = None


class Bounded(NamedTuple, Generic[Cam]):
    """What a cam has that was found, and what none exceeds."""

    found: float
    cam: Cam
    bound: float = inf
    """Infinite if it is not known."""
    unproved: str = ""
    """Why it is not; "" if it is."""


class Gaps(NamedTuple):
    """By no more than how much, relative, a cam is to be proved no worse than the worst that is found."""

    first: Sequence[float]
    """The first of these that is proved is enough where there are no closer ones."""
    closer: Sequence[float] = ()
    """What is asked if the first of all is proved, as long as it is proved and time remains; and at last the middle
    of what is proved and what is not."""


def bounded(
    found: float,
    cam: Cam,
    proof: Callable[[float, float], Tried],
    worse: Callable[[Values, float], tuple[float, Cam]],
    until: float,
    gaps: Gaps,
    seconds: float,
) -> Bounded[Cam]:
    """The least bound that is proved until a time (``clock.now``), by the proof of one until another time.

    ``worse`` is what a cam has that was found to exceed a bound. ``seconds`` are those in which all is done.
    """
    bound = proved = inf
    failed = 0.0

    def holds(gap: float, end: float) -> bool:
        nonlocal found, cam, bound, proved, failed
        for _ in range(WORSE):
            tried = proof(found * (1.0 + gap), end)
            if tried.verdict == HELD:
                bound, proved = found * (1.0 + gap), gap
                return True
            if tried.verdict != BROKEN or tried.cam is None:
                break
            more, other = worse(tried.cam, found * (1.0 + gap))
            if more <= found:
                break
            found, cam = more, other
        failed = gap
        return False

    left = len(gaps.first)
    if any(holds(gap, share(until, left - k)) for k, gap in enumerate(gaps.first)) and gaps.closer:
        if not failed:
            all(holds(gap, share(until, 2)) for gap in gaps.closer)
        if failed:
            holds(sqrt(failed * proved), until)
    late = f"the time of {seconds:g} s was over"
    why = "" if bound < inf else late if now() > until else "the tolerances are too large for it"
    return Bounded(found, cam, bound, why)

"""Verdicts as words, and one of several."""

from collections.abc import Iterable

ARM_UNCHECKED = "Whether the cam meets the arm or its pivot is not checked"
"""Of an oscillating follower, beside every verdict."""
HELD, BROKEN, UNDECIDED = "held", "broken", "undecided"


def worst_verdict(verdicts: Iterable[str]) -> str:
    """One verdict of several: broken if any is, undecided if any is, else held."""
    found = {*verdicts}
    return next((verdict for verdict in (BROKEN, UNDECIDED) if verdict in found), HELD)

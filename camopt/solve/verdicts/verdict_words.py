"""The words for verdicts, and the verdict on several limits together."""

from collections.abc import Iterable

ARM_UNCHECKED = "Whether the cam meets the arm or its pivot is not checked"
"""Remark beside every verdict on an oscillating follower."""
HELD, BROKEN, UNDECIDED = "held", "broken", "undecided"
WORST_FIRST = (BROKEN, UNDECIDED, HELD)


def worst_verdict(verdicts: Iterable[str]) -> str:
    """The verdict on several limits together: broken if any is, else undecided if any is, else held."""
    return min(verdicts, key=WORST_FIRST.index, default=HELD)

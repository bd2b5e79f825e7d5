"""A bound that is a little more than what a cam has that was found, proved; a worse cam takes its place."""

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

from camopt.mechanisms import Designs
from camopt.numerics.clock import now
from camopt.tolerances.worst_case import WORSE
from camopt.verdicts.claim_boxes import Answer
from camopt.verdicts.words import BROKEN, HELD

SECONDS = 10.0
"""For the bounds of all dwells of a motion, and for those of all passages of a lift."""

Values = dict[str, float]


class Bounded(NamedTuple):
    """What a cam has with some values of the variables, and what none exceeds."""

    found: float
    values: Values
    bound: float = inf
    """Infinite if it is not known."""
    unproved: str = ""
    """Why it is not; "" if it is."""


def bounded(
    found: float,
    values: Values,
    proof: Callable[[float, float], Answer],
    worse: Callable[[Values, float], tuple[float, Values]],
    until: float,
    gaps: Sequence[float],
) -> Bounded:
    """The least bound that is proved until a time (``clock.now``), by the proof of one until another time.

    ``worse`` is what a cam has that was found to exceed a bound, and its values. Gaps become smaller: the widest is
    proved the soonest, and each other one is tried while time remains.
    """
    proved = inf
    for gap in gaps:
        for _ in range(WORSE):
            bound = found * (1.0 + gap)
            answer = proof(bound, until)
            if answer.verdict != BROKEN or answer.witness is None:
                break
            more, other = worse(_numbers(answer.witness, values), bound)
            if more <= found:
                break
            found, values = more, other
        if answer.verdict != HELD:
            break
        proved = bound
    late = f"the time of {SECONDS:g} s was over"
    why = "" if proved < inf else late if now() > until else "the tolerances are too large for it"
    return Bounded(found, values, proved, why)


def _numbers(witness: Designs, keys: Values) -> Values:
    return {key: float(witness.numbers[key][0]) for key in keys}

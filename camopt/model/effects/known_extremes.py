"""Extremes that are known of the curves of some designs, so that what is asked again need not be searched again."""

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import or_
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, IntArray
from camopt.core.numerics.extremes import Extremes

Question = tuple[int, int]
"""The kinds of piece to look at, and the goal: LARGEST, LEAST or LARGEST_MAGNITUDE."""


class OverallExtreme(NamedTuple):
    """The extreme of several for each design, and which of them it is, (designs,) each."""

    extreme: Extremes
    number: IntArray


def overall_extreme(each: Sequence[Extremes], goal: int) -> OverallExtreme:
    """The extreme of several, (designs,) each: the largest, or the least if that is the goal."""
    outwards = -1.0 if goal == LEAST else 1.0
    far = outwards * each[0].value
    top, where, number = far + each[0].width, each[0].where, np.zeros(far.size, np.int64)
    for k, one in enumerate(each[1:], start=1):
        value = outwards * one.value
        further = value > far
        far, top = np.where(further, value, far), np.maximum(top, value + one.width)
        where, number = np.where(further, one.where, where), np.where(further, k, number)
    with np.errstate(invalid="ignore"):  # ∞ − ∞ is no width
        width = top - far
    if not (finite := np.isfinite(far)).all():
        width[~finite] = 0.0
    return OverallExtreme(Extremes(outwards * far, where, width), number)


class KnownExtremes(NamedTuple):
    """Extremes of curves of some designs, by curve and by what was asked of it, (designs,) each."""

    by_curve: Mapping[Callable[..., Any], Mapping[Question, Extremes]]

    def with_extremes(
        self, curve: Callable[..., Any], questions: Sequence[Question], answers: Extremes
    ) -> "KnownExtremes":
        """These and the answers to some questions, (questions, designs)."""
        own = {question: Extremes(*(values[k] for values in answers)) for k, question in enumerate(questions)}
        return KnownExtremes({**self.by_curve, curve: {**self.by_curve.get(curve, {}), **own}})

    def take(self, index: Any) -> "KnownExtremes":
        """Those of the designs at an index."""

        def select_extremes(extremes: Extremes) -> Extremes:
            return Extremes(*(values[index] for values in extremes))

        return KnownExtremes(
            {make: {q: select_extremes(one) for q, one in own.items()} for make, own in self.by_curve.items()}
        )

    def known_parts(self, curve: Callable[..., Any], question: Question) -> list[Extremes]:
        """What is known of all pieces of a question, of some together or apart; nothing if it is not of all."""
        kinds, goal = question
        own = self.by_curve.get(curve, {})
        if question in own:
            return [own[question]]
        found = {part: one for (part, aim), one in own.items() if aim == goal and not part & ~kinds}
        return [*found.values()] if reduce(or_, found, 0) == kinds else []

    def find_extreme(self, curve: Callable[..., Any], question: Question) -> Extremes | None:
        """The answer to a question; None if it is not known."""
        parts = self.known_parts(curve, question)
        return overall_extreme(parts, question[1]).extreme if len(parts) > 1 else next(iter(parts), None)

    def find_extremes(self, curve: Callable[..., Any], questions: Sequence[Question]) -> Extremes | None:
        """The answers to some questions, (questions, designs); None if one is unknown."""
        if curve not in self.by_curve:
            return None
        each = [self.find_extreme(curve, question) for question in questions]
        known = [one for one in each if one is not None]
        return Extremes(*map(np.array, zip(*known, strict=True))) if len(known) == len(each) else None


NOTHING_KNOWN = KnownExtremes({})

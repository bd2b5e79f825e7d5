"""Known extremes of the curves of some designs, so that no extreme is searched twice."""

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import or_
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LEAST, IntArray
from camopt.core.numerics.extremes import Extremes

Question = tuple[int, int]
"""The kinds of pieces, and the goal: LARGEST, LEAST or LARGEST_MAGNITUDE."""


class OverallExtreme(NamedTuple):
    """The overall extreme of several curves for each design, and the number of its curve, (designs,) each."""

    extreme: Extremes
    number: IntArray


def overall_extreme(extremes: Sequence[Extremes], goal: int) -> OverallExtreme:
    """Overall extreme of several extremes, (designs,) each: the largest, or the least if that is the goal."""
    outwards = -1.0 if goal == LEAST else 1.0
    far = outwards * extremes[0].value
    top, where, number = far + extremes[0].width, extremes[0].where, np.zeros(far.size, np.int64)
    for k, one in enumerate(extremes[1:], start=1):
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
    """Extremes of curves of some designs, by curve and question, (designs,) each."""

    by_curve: Mapping[Callable[..., Any], Mapping[Question, Extremes]]

    def with_extremes(
        self, curve: Callable[..., Any], questions: Sequence[Question], extremes: Extremes
    ) -> "KnownExtremes":
        """The known extremes with the answers to some more questions, (questions, designs)."""
        added = {question: Extremes(*(values[k] for values in extremes)) for k, question in enumerate(questions)}
        return KnownExtremes({**self.by_curve, curve: {**self.by_curve.get(curve, {}), **added}})

    def take(self, index: Any) -> "KnownExtremes":
        """The extremes of the designs at an index."""

        def select_extremes(extremes: Extremes) -> Extremes:
            return Extremes(*(values[index] for values in extremes))

        return KnownExtremes(
            {make: {q: select_extremes(one) for q, one in known.items()} for make, known in self.by_curve.items()}
        )

    def extremes_covering_question(self, curve: Callable[..., Any], question: Question) -> list[Extremes]:
        """Known extremes that together cover all pieces of a question; empty if there are none."""
        kinds, goal = question
        known = self.by_curve.get(curve, {})
        if question in known:
            return [known[question]]
        parts = {part: one for (part, aim), one in known.items() if aim == goal and not part & ~kinds}
        return [*parts.values()] if reduce(or_, parts, 0) == kinds else []

    def find_known_extreme(self, curve: Callable[..., Any], question: Question) -> Extremes | None:
        """The answer to a question, or None if it is not known."""
        parts = self.extremes_covering_question(curve, question)
        return overall_extreme(parts, question[1]).extreme if len(parts) > 1 else next(iter(parts), None)

    def find_known_extremes(self, curve: Callable[..., Any], questions: Sequence[Question]) -> Extremes | None:
        """The answers to some questions, (questions, designs), or None if one is unknown."""
        if curve not in self.by_curve:
            return None
        answers = [self.find_known_extreme(curve, question) for question in questions]
        known = [answer for answer in answers if answer is not None]
        return Extremes(*map(np.array, zip(*known, strict=True))) if len(known) == len(answers) else None


NOTHING_KNOWN = KnownExtremes({})

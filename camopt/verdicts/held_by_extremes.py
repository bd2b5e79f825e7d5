"""Which designs hold claims on curves, from the extremes of these: what many are asked first."""

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from operator import or_

import numpy as np

from camopt.effects import Case
from camopt.effects.known import KnownExtremes, Question
from camopt.effects.peak import CLEAR, Variant
from camopt.numerics import LEAST, BoolArray
from camopt.problem.claims import Claim


def with_extremes(case: Case, claims: Sequence[Claim], apart: Iterable[Variant]) -> KnownExtremes:
    """What is known of designs, with the extremes of the curve of some claims that these are about.

    Kinds of piece that curves ``apart`` tell apart are asked apart.
    """
    curve = claims[0].curve
    questions = _questions(case, claims, [kinds for make, kinds in apart if make is curve])
    return case.known.with_answers(curve, questions, case.extremes(curve, questions))


def _questions(case: Case, claims: Sequence[Claim], apart: Sequence[int]) -> list[Question]:
    """As few questions as tell of each claim: one about all kinds of piece that none of them tells apart."""
    found: dict[tuple[int, ...], int] = {}
    for goal in dict.fromkeys(claim.goal for claim in claims):
        about = [claim.kinds for claim in claims if claim.goal == goal]
        for bit in _bits(reduce(or_, about) & case.programme.kinds):
            same = (goal, *(bool(bit & kinds) for kinds in (*about, *apart)))
            found[same] = found.get(same, 0) | bit
    return [(kinds, goal) for (goal, *_), kinds in found.items()]


def _bits(number: int) -> Iterator[int]:
    """The powers of two of which a number is the sum."""
    while number:
        yield number & -number
        number &= number - 1


def held_by_extremes(known: KnownExtremes, claims: Iterable[Claim], case: Case) -> tuple[BoolArray, BoolArray]:
    """Which designs may hold some claims by what is known of their curves, and which do for certain."""
    possible, held = np.ones((2, len(case.designs)), dtype=bool)
    for claim in claims:
        kinds, allowed = claim.kinds & case.programme.kinds, claim.allowed()
        room = CLEAR * abs(allowed) or CLEAR * claim.unit(case.designs)
        parts = known.parts(claim.curve, (kinds, claim.goal)) if kinds else []
        assert bool(parts) == bool(kinds)
        for found in parts:
            near = -found.value if claim.goal == LEAST else found.value
            possible &= near <= allowed + room
            held &= near + found.width <= allowed - room
    return possible, held

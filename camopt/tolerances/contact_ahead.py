"""Where a cam touches at another place or at a given cam angle, over boxes of its errors.

A contact touches at θ = φ + turned(φ). The place φ + a that it touches at the cam angle φ + b is that of which

    a = b − turned(φ + a)

Where b − turned(φ + A) is within a range A, there is such an a in it (Brouwer); its slopes are those of the
equation. b is 0 at a given cam angle φ, and of a second contact what the first one has turned where it touches φ.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from camopt.mechanisms import Designs
from camopt.mechanisms.rest import Rest
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, as_sloped, by_chain
from camopt.problem.problem import Problem
from camopt.tolerances.touching import BORE_WAY
from camopt.tolerances.two_contacts import back, own_errors
from camopt.tolerances.worst_case import FurtherOn, Place, ahead_of, rest_over

FINER = 2
"""How often the place is found closer."""
ROOM = 2.0
"""Of what is looked at first for it, to where it seems to be."""


@dataclass(frozen=True)
class ContactAhead:
    """One contact of a follower over parts of the turn, at places that are ahead."""

    whole: Problem
    number: int
    problem: Problem
    """That of the contact."""
    given: Designs
    errors: Mapping[str, Any]
    """Of the whole; the direction of the bore is in the ground where nothing is ahead."""
    at: Place

    @property
    def sign(self) -> float:
        """What its own motion is to that of the follower."""
        return -back(self.whole) if self.number else 1.0

    def moved(self, ahead: Sloped) -> Sloped:
        """How much further it would move the follower than the motion has it where nothing is ahead."""
        moved: Sloped = self.further(ahead).y + self.rest(ahead).moved * self.sign
        return moved

    def further(self, ahead: Sloped) -> FurtherOn:
        """The motion there."""
        return ahead_of(self.whole.programme, self.at, ahead)

    def rest(self, ahead: Sloped) -> Rest:
        """Where its follower rests, in its own motion."""
        further = self.further(ahead)
        errors = own_errors(self.whole, self.number, self.errors)
        if BORE_WAY in errors:
            errors[BORE_WAY] = errors[BORE_WAY] + ahead * self.problem.design.sense
        y, y1 = self.at.y + further.y, further.y1
        if self.sign < 0.0:
            y, y1 = y * -1.0 + self.problem.programme.lift, y1 * -1.0
        return rest_over(self.problem, self.design, errors, y, y1)

    @cached_property
    def design(self) -> Designs:
        further = self.whole.setup.mechanism.further
        return further[0].seen(self.given) if self.number else self.given

    def ahead(self, turned: Sloped) -> Sloped:
        """How far ahead it touches where the cam is turned on by so much."""
        there = as_sloped(0.0, turned)
        guess = turned - self.rest(there).turned
        most = ROOM * (turned.value.largest_magnitude + guess.value.largest_magnitude)
        there, inside = as_sloped(Interval(-most, most), turned), np.ones(most.shape, dtype=bool)
        for _ in range(FINER):  # a contraction by the share that errors are of the cam
            of = self.rest(there).turned
            found = turned - of  # of errors that both have in common little is left
            inside &= (found.value.low >= there.value.low) & (found.value.high <= there.value.high)
            there = replace(there, value=_where(inside, found.value), at=_where(inside, found.at))
        slope = 1.0 / (self._by_place(of) + 1.0)
        return by_chain(there.value, there.at, [(turned, slope), (of, slope * -1.0)])

    def _by_place(self, of: Sloped) -> Interval:
        """The slope of where the cam touches by the place."""
        keys, found = [*self.errors], as_interval(of.slopes[0])
        if BORE_WAY in keys:
            found = found + of.slopes[1 + keys.index(BORE_WAY)] * self.whole.design.sense
        return found


class RestingContact(ContactAhead):
    """A contact that touches the arc of a dwell, wherever it is ahead."""

    def further(self, ahead: Sloped) -> FurtherOn:
        return FurtherOn(ahead * 0.0, ahead * 0.0)


def _where(known: Any, value: Interval) -> Interval:
    return Interval(np.where(known, value.low, np.nan), np.where(known, value.high, np.nan))

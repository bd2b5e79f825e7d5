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
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, as_sloped, by_chain, range_of
from camopt.problem.problem import Problem
from camopt.tolerances.errors import BORE, BORE_WAY, turned_on
from camopt.tolerances.exact import Moved, errors_of, moved_of
from camopt.tolerances.further_on import FurtherOn, Place, StillOn
from camopt.tolerances.two_contacts import back, own_errors

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
    """With errors of the whole, flat, as the numbers that boxes are of."""
    errors: Mapping[str, Any]
    """The same, or what they are at another cam angle; the bore is in the ground where nothing is ahead."""
    at: Place
    waves: int = 0

    @property
    def sign(self) -> float:
        """What its own motion is to that of the follower."""
        return -back(self.whole) if self.number else 1.0

    def moved(self, ahead: Sloped) -> Any:
        """How much further it would move the follower than the motion has it where nothing is ahead."""
        there = self.further(ahead)
        return there.by(0) + self._moved(there, self._motion(there, 2), 0).moved.terms[0] * self.sign

    def errors_at(self, further: FurtherOn, order: int) -> list[Any]:
        """Its errors, in its own motion, at the cam angle that the first contact has where it touches."""
        there = self.further(self.ahead(further.turned))
        motion = self._motion(there, order + 2)

        def differs(k: int) -> Any:
            return (further.by(k) - there.by(k)) * self.sign

        jumped = (self.at.jumped.by2 - self.at.ahead.by2) * self.sign
        return errors_of(self._moved(there, motion, order), motion, differs, jumped, order)

    def further(self, ahead: Sloped) -> FurtherOn:
        """The motion there."""
        return FurtherOn(self.whole.programme, self.at, ahead, self.at.ahead)

    def ahead(self, turned: Sloped) -> Sloped:
        """How far ahead it touches where the cam is turned on by so much."""
        there = as_sloped(0.0, turned)
        guess = turned - self._turned(there)
        most = ROOM * (turned.value.largest_magnitude + guess.value.largest_magnitude)
        there, inside = as_sloped(Interval(-most, most), turned), np.ones(most.shape, dtype=bool)
        for _ in range(FINER):  # a contraction by the share that errors are of the cam
            of = self._turned(there)
            found = turned - of  # of errors that both have in common little is left
            inside &= (found.value.low >= there.value.low) & (found.value.high <= there.value.high)
            there = replace(there, value=_where(inside, found.value), at=_where(inside, found.at))
        slope = 1.0 / (self._by_place(of) + 1.0)
        return by_chain(there.value, there.at, [(turned, slope), (of, slope * -1.0)])

    @cached_property
    def design(self) -> Designs:
        further = self.whole.setup.mechanism.further
        return further[0].seen(self.given) if self.number else self.given

    def _turned(self, ahead: Sloped) -> Any:
        there = self.further(ahead)
        return self._moved(there, self._motion(there, 2), 0).turned.terms[0]

    def _moved(self, there: FurtherOn, motion: list[Any], order: int) -> Moved:
        """Where its follower rests."""
        errors = errors_ahead(self.whole, self.number, self.problem, self.errors, there.turned)
        return moved_of(self.problem, self.design, errors, self.waves, motion, order)

    def _motion(self, there: FurtherOn, count: int) -> list[Any]:
        """Its own motion at a place."""
        found = [there.motion(order) * self.sign for order in range(count)]
        return [found[0] + self.problem.programme.lift, *found[1:]] if self.sign < 0.0 else found

    def _by_place(self, of: Sloped) -> Interval:
        """The slope of where the cam touches by the place: the bore turns with it."""
        keys, found = [*self.errors], as_interval(of.slopes[0])
        if BORE in keys and not self.whole.setup.mechanism.body.developed:
            x, y = (range_of(self.given.numbers[key]) for key in (BORE, BORE_WAY))
            by_x, by_y = (of.slopes[1 + keys.index(key)] for key in (BORE, BORE_WAY))
            found = found + (by_y * x - by_x * y) * self.whole.design.sense
        return found


class RestingContact(ContactAhead):
    """A contact that touches the arc of a dwell, wherever it is ahead."""

    def further(self, ahead: Sloped) -> FurtherOn:
        return StillOn(self.whole.programme, self.at, ahead, self.at.ahead)


def errors_ahead(
    whole: Problem, number: int, contact: Problem, errors: Mapping[str, Any], ahead: Any
) -> dict[str, Any]:
    """Errors as a contact has them that touches ahead, flat.

    The axis of the bore is as it is then in the ground; of a cylinder it is as where nothing is ahead.
    """
    found = own_errors(whole, number, errors)
    developed = contact.setup.mechanism.body.developed
    return found if developed else turned_on(found, ahead * contact.design.sense)


def _where(known: Any, value: Interval) -> Interval:
    return Interval(np.where(known, value.low, np.nan), np.where(known, value.high, np.nan))

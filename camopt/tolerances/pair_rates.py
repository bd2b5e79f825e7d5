"""The largest errors of velocity and acceleration of the tool with two contacts of a follower.

Of a follower that stands in the middle they are δ' = (e₁' − e₂')/2 and δ'' = (e₁'' − e₂'')/2, by one cam angle θ:
at θ = φ + turned₁(φ), where the first contact touches the place φ, the second one touches φ + a
(``tolerances.contact_ahead``). At each place the errors of a contact are those of an ordinary cam with the motion
of its own (``tolerances.rates``).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.answers import SECOND, errors_at
from camopt.mechanisms import Designs
from camopt.mechanisms.rest import Rest
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped
from camopt.problem.problem import Problem
from camopt.tolerances.contact_ahead import ContactAhead
from camopt.tolerances.further_on import FurtherOn, Place
from camopt.tolerances.ranges import plain
from camopt.tolerances.rates import LEVEL, Moved, Touched, errors_of, moved_of, touched
from camopt.tolerances.touching import BORE, BORE_WAY, WAY
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import back, contacts_of, own_errors
from camopt.tolerances.worst_rates import RateSearch, at_tool, rate_ends

TOUCHES = 3
"""How often the place of the second contact is found anew, of numbers."""


class PairRateError(NamedTuple):
    """The exact error of a derivative of the tool's motion where the first contact touches, mm (rad) by powers of
    rad; on ranges with slopes alone."""

    problem: Problem
    contacts: tuple[Problem, Problem]
    design: Designs
    errors: Mapping[str, Any]
    order: int
    waves: int

    def first(self, at: Place, order: int) -> Moved:
        """Where the follower of the first contact rests."""
        own = own_rates(self.problem, 0, self.errors)
        return moved_of(self.contacts[0], self.design, own, self.waves, at.motion, order)

    def second(self, at: Place) -> "SecondRates":
        """The second contact, at places that are ahead."""
        return SecondRates(self.problem, 1, self.contacts[1], self.design, self.errors, at, self.waves)

    def turned(self, at: Place) -> list[Sloped]:
        """How far from the cam angle of the place the motion counts, and the second contact touches."""
        turned = plain(self.first(at, 0).turned.terms[0], at.y)
        return [turned, self.second(at).ahead(turned)]


@formula(PairRateError)
def pair_rate_error(f, i, at):  # type: ignore[no-untyped-def]
    moved, second = f.first(at, f.order), f.second(at)
    further = FurtherOn(f.problem.programme, at, plain(moved.turned.terms[0], at.y))
    own = errors_of(moved, at.motion, further.by, at.jumped, f.order)
    both = zip(own, second.rates(further, f.order), strict=True)
    return at_tool(f.problem, f.errors, [(a + b * second.sign) * 0.5 for a, b in both], further), 0.0


@dataclass(frozen=True)
class SecondRates(ContactAhead):
    """The second contact over parts of the turn, at places that are ahead; with derivatives."""

    at: Any  # a place with more derivatives than that of the displacement
    waves: int = 0

    def rates(self, further: FurtherOn, order: int) -> list[Any]:
        """Its errors, in its own motion, at the cam angle where the first contact touches."""
        there = FurtherOn(further.programme, self.at, self.ahead(further.turned))
        motion = self._motion(there, order + 2)

        def differs(k: int) -> Any:
            return (further.by(k) - there.by(k)) * self.sign

        jumped = (self.at.jumped - self.at.jumped) * self.sign
        return errors_of(self._moved(motion, there.turned, order), motion, differs, jumped, order)

    def rest(self, ahead: Sloped) -> Rest:
        motion = self._motion(FurtherOn(self.whole.programme, self.at, ahead), 2)
        found = self._moved(motion, ahead, 0)
        return Rest(*(plain(each.terms[0], ahead) for each in found))

    def _moved(self, motion: list[Any], ahead: Sloped, order: int) -> Moved:
        errors = second_rates(self.whole, self.errors, ahead)
        return moved_of(self.problem, self.design, errors, self.waves, motion, order)

    def _motion(self, there: FurtherOn, count: int) -> list[Any]:
        """Its own motion at a place."""
        found = [there.motion(order) * self.sign for order in range(count)]
        return [found[0] + self.problem.programme.lift, *found[1:]] if self.sign < 0.0 else found

    def _by_place(self, of: Sloped) -> Interval:
        keys, found = [*self.errors], as_interval(of.slopes[0])
        if BORE in keys and not self.whole.setup.mechanism.body.developed:
            x, y = (self.errors[key].value for key in (BORE, BORE_WAY))
            by_x, by_y = (of.slopes[1 + keys.index(key)] for key in (BORE, BORE_WAY))
            found = found + (by_y * x - by_x * y) * self.whole.design.sense
        return found


def own_rates(problem: Problem, place: int, errors: Mapping[str, Any]) -> dict[str, Any]:
    """Errors as a contact has them, with both coordinates of those that have a way."""
    waves = {key: each for key, each in errors.items() if key.startswith((WAY, LEVEL))}
    found = own_errors(problem, place, {key: each for key, each in errors.items() if key not in waves})
    for key, value in waves.items():
        second = SECOND if key.endswith(SECOND) else ""
        own = errors_at(problem.setup.mechanism, "profile")[f"profile{second}"][place]
        if own is not None:
            found[key.removesuffix(SECOND)] = own[1] * value
    return found


def second_rates(problem: Problem, errors: Mapping[str, Any], ahead: Any) -> dict[str, Any]:
    """Errors as the second contact has them, which touches ahead of the first one.

    The axis of the bore is as it is then in the ground; of a cylinder as where both touch.
    """
    found = own_rates(problem, 1, errors)
    if BORE in found and not problem.setup.mechanism.body.developed:
        (further,) = problem.setup.mechanism.further
        turned = ahead * further.seen(problem.design).sense
        x, y, cosine, sine = found[BORE], found[BORE_WAY], np.cos(turned), np.sin(turned)
        found |= {BORE: x * cosine - y * sine, BORE_WAY: x * sine + y * cosine}
    return found


@dataclass(frozen=True)
class PairRateSearch(RateSearch):
    """The search for the worst of the cams with two contacts."""

    @cached_property
    def contacts(self) -> tuple[Problem, Problem]:
        return contacts_of(self.problem)

    @property
    def last(self) -> int:
        return self.order + 1  # where the second contact touches

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> PairRateError:
        return PairRateError(self.problem, self.contacts, design, errors, self.order, self.waves)

    def follower(self, errors: Mapping[str, Any], angles: FloatArray, jumps: bool) -> Touched:
        (first, second), way = self.contacts, back(self.problem)
        own = own_rates(self.problem, 0, errors)
        one = touched(first, own, angles, self.order, waves=self.waves, jumps=jumps)
        ahead = self._ahead(errors, angles, one.turned)
        other = second_rates(self.problem, errors, ahead)
        two = touched(second, other, angles + ahead, self.order, waves=self.waves, jumps=jumps)
        return Touched(one.turned, [(a - way * b) / 2.0 for a, b in zip(one.errors, two.errors, strict=True)])

    def _ahead(self, errors: Mapping[str, Any], angles: FloatArray, turned: FloatArray) -> FloatArray:
        """How far ahead of the first contact the second one touches."""
        ahead = np.zeros_like(turned)
        for _ in range(TOUCHES):
            other = second_rates(self.problem, errors, ahead)
            ahead = turned - touched(self.contacts[1], other, angles + ahead, 0, waves=self.waves).turned
        return ahead

    def place_of(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        if not key.endswith(SECOND):
            return angle
        at, flat = np.array([angle]), self.flat(errors)
        turned = touched(self.contacts[0], own_rates(self.problem, 0, flat), at, 0, waves=self.waves).turned
        return angle + float(self._ahead(flat, at, turned)[0])


def rate_search(turn: TurnErrors, order: int) -> RateSearch:
    """The search for the worst velocity (1) or acceleration (2), with one contact or two."""
    kind = PairRateSearch if turn.problem.setup.mechanism.further else RateSearch
    return kind(turn, rate_ends(turn), order)

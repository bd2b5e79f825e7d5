"""The largest errors of the motion of the tool, of all cams within tolerances with two contacts of a follower.

A follower that stands in the middle between two contacts is off by δ = (e₁ − e₂)/2 (``tolerances.two_contacts``),
and so are its velocity and acceleration, with both errors at one cam angle. The first contact touches at
θ = φ + turned₁(φ), the second one a little ahead of φ, at the place φ + a of which

    φ + a + turned₂(φ + a) = φ + turned₁(φ)

It is enclosed by the equation itself (``tolerances.contact_ahead``). At each place the errors of a contact are
those of an ordinary cam with the motion of its own (``tolerances.exact``): a formula as that of one contact is, run
on the same ranges with slopes (``tolerances.worst_case``).

A jump of y'' or y''' next to φ may lie between φ and θ or not, and between φ and φ + a or not. Each of these cases
is proved of all cams: the motion has no jump then, so that slopes of errors are those of one side of it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.answers import SECOND
from camopt.mechanisms import Designs
from camopt.motion.programme import Jump
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula
from camopt.numerics.sloped import Sloped
from camopt.problem.problem import Problem
from camopt.tolerances.contact_ahead import ContactAhead, RestingContact, errors_ahead
from camopt.tolerances.errors import flat, polar
from camopt.tolerances.exact import Moved, Touched, errors_of, moved_of, touched
from camopt.tolerances.further_on import FurtherOn, Place
from camopt.tolerances.off_train import through
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import TOUCHES, back, contacts_of, ends_of, own_errors
from camopt.tolerances.worst_case import LATE, Found, Passed, WorstSearch

BESIDE = 1e-9
"""Of a jump, rad."""
LATER = [*product((1.0, -1.0), (1.0, -1.0), LATE)]
FINER, ZOOMS = 9, 6
"""Cams between two that are looked at, and how often between the neighbours of the worst one."""


class PairError(NamedTuple):
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
        own = own_errors(self.problem, 0, self.errors)
        return moved_of(self.contacts[0], self.design, own, self.waves, at.motion, order)

    def second(self, at: Place, kind: type[ContactAhead] = ContactAhead) -> ContactAhead:
        """The second contact, at places that are ahead."""
        return kind(self.problem, 1, self.contacts[1], self.design, self.errors, at, self.waves)

    def turned(self, at: Place) -> list[Sloped]:
        """How far from the cam angle of the place the motion counts, and the second contact touches."""
        turned = self.first(at, 0).turned.terms[0]
        return [turned, self.second(at).ahead(turned)]


@formula(PairError)
def pair_error(f, i, at):  # type: ignore[no-untyped-def]
    moved, second = f.first(at, f.order), f.second(at)
    further = FurtherOn(f.problem.programme, at, moved.turned.terms[0], at.jumped)
    own = errors_of(moved, at.motion, further.by, at.jumped.by2, f.order)
    both = zip(own, second.errors_at(further, f.order), strict=True)
    middle = [(a + b * second.sign) * 0.5 for a, b in both]
    return through(f.problem, f.errors, middle, further.motion), 0.0


@dataclass(frozen=True)
class PairSearch(WorstSearch):
    """The search for the worst of the cams with two contacts."""

    @cached_property
    def contacts(self) -> tuple[Problem, Problem]:
        return contacts_of(self.problem)

    @property
    def last(self) -> int:
        return self.order + 1  # where the second contact touches

    @property
    def cases(self) -> Iterable[Passed]:
        return product((False, True) if self._whole else (None,), (False, True))

    @cached_property
    def _whole(self) -> list[Jump]:
        """The jumps of y'' where these count for the acceleration."""
        return [jump for jump in self.jumps if jump.order == self.order == 2]

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> PairError:
        return PairError(self.problem, self.contacts, design, errors, self.order, self.waves)

    def first(self) -> dict[str, float]:
        """Where y'' jumps, both contacts have the whole jump for an error of cams that are hardly late: these are
        between late ones and those that are the worst but for it."""
        usual = super().first()
        if not self._whole:
            return usual
        starts = {side: self._at_jump(side, 0.0) for side in (1.0, -1.0)}
        every = (self._between(starts[side], self._at_jump(side, way * each)) for side, way, each in LATER)
        found = max(every, key=lambda each: each.error)
        return found.errors if found.error > abs(self.highest(usual)[1]) else usual

    def _between(self, one: Found, other: Found) -> Found:
        """The worst of the cams between two, next to a jump."""
        ends, low, high = [flat(each.errors) for each in (one, other)], 0.0, 1.0
        for _ in range(ZOOMS):
            shares = np.linspace(low, high, FINER)
            errors = polar(
                {key: (1.0 - shares) * ends[0][key] + shares * ends[1][key] for key in ends[0]}, self.ends
            )
            places = self._beside_jumps(errors)
            every = {key: np.tile(each, len(places)) for key, each in errors.items()}
            found = np.abs(self.error(every, places.ravel())).reshape(places.shape)
            row, k = (int(each) for each in np.unravel_index(found.argmax(), found.shape))
            low, high = shares[max(k - 1, 0)], shares[min(k + 1, FINER - 1)]
        return Found(
            {key: float(each[k]) for key, each in errors.items()}, float(places[row, k]), float(found[row, k])
        )

    def _beside_jumps(self, errors: Mapping[str, FloatArray]) -> FloatArray:
        """The places next to which jumps begin and end to count for cams (m,), on both sides: (places, m)."""
        count, jumps = len(next(iter(errors.values()))), [jump.at for jump in self._whole]
        every, at = {key: np.tile(each, len(jumps)) for key, each in errors.items()}, np.repeat(jumps, count)
        found = np.reshape([at, *self._reaching(every, at)], (-1, count))
        return self.within(np.concatenate([found - BESIDE, found + BESIDE]))

    def _reaching(self, errors: Mapping[str, FloatArray], angles: FloatArray) -> list[FloatArray]:
        """The places of the first contact when it touches at cam angles, and when the second one touches there."""
        known, found = flat(errors), [angles, angles]
        for _ in range(TOUCHES):
            turned = [
                touched(self.contacts[0], own_errors(self.problem, 0, known), each, 0, waves=self.waves).turned
                for each in found
            ]
            found = [angles - turned[0], angles - self._ahead(known, found[1], turned[1])]
        return found

    def highest(self, errors: Mapping[str, float]) -> tuple[float, float]:
        usual = super().highest(errors)
        if not self._whole:
            return usual
        places = self._beside_jumps({key: np.array([each]) for key, each in errors.items()}).ravel()
        found = self.error({key: np.full(places.size, each) for key, each in errors.items()}, places)
        most = np.abs(found).argmax()
        return (float(places[most]), float(found[most])) if abs(found[most]) > abs(usual[1]) else usual

    def resting(self, design: Designs, errors: Mapping[str, Any], at: Place) -> Any:
        error = self.curve(design, errors)
        first, second = error.first(at, 0), error.second(at, RestingContact)
        return (first.moved.terms[0] + second.moved(second.ahead(first.turned.terms[0]))) * 0.5

    def follower(self, errors: Mapping[str, Any], angles: FloatArray, jumps: bool) -> Touched:
        (first, second), way = self.contacts, back(self.problem)
        own = own_errors(self.problem, 0, errors)
        one = touched(first, own, angles, self.order, waves=self.waves, jumps=jumps)
        ahead = self._ahead(errors, angles, one.turned)
        other = errors_ahead(self.problem, 1, second, errors, ahead)
        two = touched(second, other, angles + ahead, self.order, waves=self.waves, jumps=jumps)
        return Touched(one.turned, [(a - way * b) / 2.0 for a, b in zip(one.errors, two.errors, strict=True)])

    def _ahead(self, errors: Mapping[str, Any], angles: FloatArray, turned: FloatArray) -> FloatArray:
        """How far ahead of the first contact the second one touches."""
        ahead, (_, second) = np.zeros_like(turned), self.contacts
        for _ in range(TOUCHES):
            other = errors_ahead(self.problem, 1, second, errors, ahead)
            ahead = turned - touched(second, other, angles + ahead, 0, waves=self.waves).turned
        return ahead

    def place_of(self, key: str, errors: Mapping[str, float], angle: float) -> float:
        if not key.endswith(SECOND):
            return angle
        at, known = np.array([angle]), flat(errors)
        turned = touched(self.contacts[0], own_errors(self.problem, 0, known), at, 0, waves=self.waves).turned
        return angle + float(self._ahead(known, at, turned)[0])


def worst_search(
    turn: TurnErrors, order: int = 0, changed: Mapping[str, tuple[float, float]] | None = None
) -> WorstSearch:
    """The search for the worst cam in displacement (0), velocity (1) or acceleration (2), within its tolerances.

    With one contact or two; ``changed`` are other ends of errors than those of the scene.
    """
    kind = PairSearch if turn.problem.setup.mechanism.further else WorstSearch
    return kind(turn, {**ends_of(turn.scene, turn.problem, order), **(changed or {})}, order)

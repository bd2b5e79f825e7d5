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
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula
from camopt.numerics.sloped import Sloped
from camopt.problem.problem import Problem
from camopt.tolerances.contact_ahead import ContactAhead, RestingContact, errors_ahead
from camopt.tolerances.errors import flat
from camopt.tolerances.exact import Moved, Touched, errors_of, moved_of, touched
from camopt.tolerances.further_on import FurtherOn, Place
from camopt.tolerances.off_train import through
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import TOUCHES, back, contacts_of, ends_of, own_errors
from camopt.tolerances.worst_case import Passed, WorstSearch


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
        """Of the acceleration alone a jump of y'' counts at θ."""
        jumps = any(each.order == self.order == 2 for each in self.jumps)
        return product((False, True) if jumps else (None,), (False, True))

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> PairError:
        return PairError(self.problem, self.contacts, design, errors, self.order, self.waves)

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

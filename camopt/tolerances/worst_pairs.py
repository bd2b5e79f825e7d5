"""The largest error of the displacement of the tool, of all cams within tolerances with two contacts of a follower.

A follower that stands in the middle between two contacts is off by δ = (e₁ − e₂)/2 (``tolerances.two_contacts``),
with both errors at one cam angle. The first contact touches at θ = φ + turned₁(φ), the second one a little ahead of
φ, at the place φ + a of which

    φ + a + turned₂(φ + a) = φ + turned₁(φ)

It is enclosed by the equation itself (``tolerances.contact_ahead``). With what the first contact has moved its
follower, and the second one, in its own motion,

    δ = (moved₁ − moved₂ + y(φ + a) − y(φ))/2 − (y(θ) − y(φ))

is a formula as that of one contact is, run on the same ranges with slopes (``tolerances.worst_case``).

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import Designs
from camopt.mechanisms.rest import Rest
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.tolerances.contact_ahead import ContactAhead, RestingContact
from camopt.tolerances.touching import BORE_WAY, Contact
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import PairCams, PairResponses, contacts_of, ends_of, own_errors
from camopt.tolerances.worst_case import Place, WorstSearch, ahead_of, rest_over, through


class PairError(NamedTuple):
    """The exact error of the tool where the first contact touches, mm (rad); on ranges with slopes alone."""

    problem: Problem
    contacts: tuple[Problem, Problem]
    design: Designs
    errors: Mapping[str, Any]


@formula(PairError)
def pair_error(f, i, at):  # type: ignore[no-untyped-def]
    moved, turned = pair_rest(f, at)
    risen = ahead_of(f.problem.programme, at, turned).y
    moved = moved - risen
    return (moved if f.problem.setup.train is None else through(f.problem, f.errors, moved, at.y + risen)), 0.0


def pair_rest(f: PairError, at: Place, kind: type[ContactAhead] = ContactAhead) -> Rest:
    """Where a follower rests that stands in the middle, as the first contact touches."""
    first, second = f.contacts
    own = rest_over(first, f.design, own_errors(f.problem, 0, f.errors), at.y, at.y1)
    other = kind(f.problem, 1, second, f.design, f.errors, at)
    return Rest((own.moved + other.moved(other.ahead(own.turned))) * 0.5, own.turned)


@dataclass(frozen=True)
class PairSearch(WorstSearch):
    """The search for the worst of the cams with two contacts."""

    @cached_property
    def contacts(self) -> tuple[Problem, Problem]:
        return contacts_of(self.problem)

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> PairError:
        return PairError(self.problem, self.contacts, design, errors)

    def rest(self, design: Designs, errors: Mapping[str, Any], at: Place) -> Rest:
        """Where a follower rests over boxes, in a dwell, as the first contact touches."""
        return pair_rest(self.curve(design, errors), at, RestingContact)

    def contact(self, errors: Mapping[str, Any], angles: FloatArray) -> Contact:
        """At the cam angles themselves."""
        problem, train = self.problem, self.problem.setup.train
        own = {key: each for key, each in errors.items() if not is_of_train(key)}
        if BORE_WAY in own:  # in the frame of the cam
            own[BORE_WAY] = own[BORE_WAY] - problem.design.sense * angles
        moved, _ = PairCams(problem).at(own, angles)
        if train is None:
            return Contact(angles, moved)
        stands = train.follower_at(tool_position(problem.programme, self.within(angles)))
        there = problem.train_off(errors).tool(Taylor([stands + moved])).terms[0]
        return Contact(angles, np.asarray(there - train.tool(Taylor([stands])).terms[0]))

    def ways(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The two directions of the bore that move the follower the most."""
        x, y = ((first - second)[0] for first, second in PairResponses(self.problem, self.within(angles)).bores)
        turned = self.problem.design.sense * angles
        return np.arctan2(y, x) + turned, np.arctan2(-y, -x) + turned


def worst_search(turn: TurnErrors, changed: Mapping[str, tuple[float, float]] | None = None) -> WorstSearch:
    """The search for the worst cam of a follower with one contact or two, within its tolerances but for some."""
    kind = PairSearch if turn.problem.setup.mechanism.further else WorstSearch
    return kind(turn, {**ends_of(turn.scene, turn.problem), **(changed or {})})

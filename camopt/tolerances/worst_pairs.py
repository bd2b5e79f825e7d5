"""The largest error of the displacement of the tool, of all cams within tolerances with two contacts of a follower.

A follower that stands in the middle between two contacts is off by δ = (e₁ − e₂)/2 (``tolerances.two_contacts``),
with both errors at one cam angle. The first contact touches at θ = φ + turned₁(φ), the second one a little ahead of
φ, at the place φ + a of which

    φ + a + turned₂(φ + a) = φ + turned₁(φ)

Where turned₁ − turned₂(φ + A) is within a range A, there is such an a in it (Brouwer); its slopes are those of the
equation. With what the first contact and the second one, in its own motion, have moved their followers,

    δ = (moved₁ − moved₂ + y(φ + a) − y(φ))/2 − (y(θ) − y(φ))

is a formula as that of one contact is, run on the same ranges with slopes (``tolerances.worst_case``).

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import Designs
from camopt.mechanisms.rest import Rest
from camopt.motion.driven import tool_position
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula
from camopt.numerics.interval import Interval, as_interval
from camopt.numerics.sloped import Sloped, as_sloped, by_chain
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.tolerances.touching import BORE_WAY, Contact
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import PairCams, PairResponses, back, contacts_of, ends_of, own_errors
from camopt.tolerances.worst_case import Place, WorstSearch, ahead_of, rest_over, through

FINER = 2
"""How often the place of the second contact is found closer."""
ROOM = 2.0
"""Of what is looked at first for it, to where it seems to be."""


class PairError(NamedTuple):
    """The exact error of the tool where the first contact touches, mm (rad); on ranges with slopes alone."""

    problem: Problem
    contacts: tuple[Problem, Problem]
    design: Designs
    errors: Mapping[str, Any]


@formula(PairError)
def pair_error(f, i, at):  # type: ignore[no-untyped-def]
    programme, (first, second) = f.problem.programme, f.contacts
    own = rest_over(first, f.design, own_errors(f.problem, 0, f.errors), at.y, at.y1)
    other = _Second(f, second, at)
    a = other.ahead(own.turned)
    risen = ahead_of(programme, at, own.turned).y
    moved = (own.moved - other.rest(a).moved * back(f.problem) + ahead_of(programme, at, a).y) * 0.5 - risen
    return (moved if f.problem.setup.train is None else through(f.problem, f.errors, moved, at.y + risen)), 0.0


@dataclass(frozen=True)
class _Second:
    """The second contact over parts of the turn, at places that are ahead."""

    error: PairError
    problem: Problem
    at: Place

    def rest(self, ahead: Sloped) -> Rest:
        """Where its follower rests, in its own motion."""
        f, lift = self.error, self.problem.programme.lift
        further = ahead_of(f.problem.programme, self.at, ahead)
        errors = own_errors(f.problem, 1, f.errors)
        if BORE_WAY in errors:  # in the ground, where the first contact touches
            errors[BORE_WAY] = errors[BORE_WAY] + ahead * self.problem.design.sense
        y, y1 = self.at.y + further.y, further.y1
        if back(f.problem) > 0.0:
            y, y1 = y * -1.0 + lift, y1 * -1.0
        return rest_over(self.problem, self.design, errors, y, y1)

    @cached_property
    def design(self) -> Designs:
        (further,) = self.error.problem.setup.mechanism.further
        return further.seen(self.error.design)

    def ahead(self, turned: Sloped) -> Sloped:
        """How far ahead of the first contact it touches at the same cam angle."""
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
        keys, found = [*self.error.errors], as_interval(of.slopes[0])
        if BORE_WAY in keys:
            found = found + of.slopes[1 + keys.index(BORE_WAY)] * self.error.problem.design.sense
        return found


def _where(known: Any, value: Interval) -> Interval:
    return Interval(np.where(known, value.low, np.nan), np.where(known, value.high, np.nan))


@dataclass(frozen=True)
class PairSearch(WorstSearch):
    """The search for the worst of the cams with two contacts."""

    @cached_property
    def contacts(self) -> tuple[Problem, Problem]:
        return contacts_of(self.problem)

    def curve(self, design: Designs, errors: Mapping[str, Any]) -> PairError:
        return PairError(self.problem, self.contacts, design, errors)

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

    def within(self, angles: FloatArray) -> FloatArray:
        """Cam angles within the turn, rad."""
        return np.asarray(np.mod(angles, self.problem.programme.strokes[-1].end))

    def ways(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The two directions of the bore that move the follower the most."""
        x, y = ((first - second)[0] for first, second in PairResponses(self.problem, self.within(angles)).bores)
        turned = self.problem.design.sense * angles
        return np.arctan2(y, x) + turned, np.arctan2(-y, -x) + turned


def worst_search(turn: TurnErrors, changed: Mapping[str, tuple[float, float]] | None = None) -> WorstSearch:
    """The search for the worst cam of a follower with one contact or two, within its tolerances but for some."""
    kind = PairSearch if turn.problem.setup.mechanism.further else WorstSearch
    return kind(turn, {**ends_of(turn.scene, turn.problem), **(changed or {})})

"""When tools pass a position, of all cams within tolerances, proved by exact contact.

A cam passes a level about the cam angle of the nominal one. If at the cam angle θ no cam within the tolerances is
at the level yet,

    f(y(θ)) + δ(θ; x) ≤ level    for all errors x,

none passes it outward before θ; after θ, if at θ all are at the level or beyond it. Inward it is the other way
round. δ(θ; x) is the exact error at a given cam angle: each contact touches at a place φ with φ + turned(φ) = θ
(``tolerances.contact_ahead``), and

    δ = Σ (±moved + y(φ) − y(θ)) / contacts

comes through the train as that of the worst case does. Whether any cam is beyond is decided over boxes of errors at
the one cam angle. The cam that passes the first or the last is at those ends of its errors that move the tool the
furthest there; the proof is asked a little further out.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from math import degrees, inf, isinf
from operator import add
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import Designs
from camopt.motion.table import ALL_STROKES
from camopt.numerics import LARGEST, LEAST, FloatArray
from camopt.numerics.clock import now, share
from camopt.numerics.curves import formula
from camopt.numerics.sloped import as_sloped
from camopt.problem.claims import Claim, Plain
from camopt.problem.problem import Problem
from camopt.tolerances.bounded import SECONDS, Bounded, Gaps, Tried, Values, bounded
from camopt.tolerances.contact_ahead import ContactAhead
from camopt.tolerances.errors import BORE_WAY
from camopt.tolerances.off_train import through
from camopt.tolerances.passing import until as until_not
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import TOUCHES, contacts_of
from camopt.tolerances.vectors import box_of
from camopt.tolerances.worst_case import CORNERS, Proof, WorstSearch
from camopt.tolerances.worst_pairs import worst_search
from camopt.verdicts.claim_boxes import Parts

GAPS = Gaps((1e-2,), (1e-3, 1e-4, 1e-5))
"""Relative, of the distance from the nominal passage: by no more than this a cam is further, the last proved."""
NEVER = "some cam never passes it"
BEYOND = 1e-10
"""How much further out the proof is asked at least, rad."""


class WorstPassage(NamedTuple):
    """The cam angle before which, or after which, no cam within the tolerances passes a lift.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(tolerances={"profile": 0.01})
    >>> first = camopt.timing(scene, [1.0]).worst[0]
    >>> first.passage, first.end, first.bound_deg < first.found_deg < 34.1269
    ('rises', 'earliest', True)
    """

    lift: float
    """mm (deg), from the lowest position."""
    passage: str
    """"rises" where the tool passes outward, "falls" where inward."""
    end: str
    """"earliest" or "latest"."""
    bound_deg: float
    """No cam passes sooner, or later, proved; infinite if that is not known, or where some cam does not pass."""
    found_deg: float
    """A cam with these ``errors`` has passed then already, or not yet before, by exact contact."""
    errors: dict[str, float]
    """Of that cam, by key of ``[tolerances]``, mm and deg, as those of ``WorstCase``."""
    unproved: str = ""
    """Why there is no bound: none is proved, or some cam never passes; "" if there is one."""

    @property
    def gap_deg(self) -> float:
        """By how much some cam may be sooner or later than that one."""
        return 0.0 if self.bound_deg == self.found_deg else abs(self.bound_deg - self.found_deg)


Cams = Callable[[FloatArray], dict[str, FloatArray]]
"""Errors of cams by the places with which they touch."""


class AngleError(NamedTuple):
    """The exact error of the tool at a cam angle, mm (rad); on ranges with slopes alone."""

    problem: Problem
    contacts: tuple[Problem, ...]
    design: Designs
    errors: Mapping[str, Any]


@formula(AngleError)
def angle_error(f, i, at):  # type: ignore[no-untyped-def]
    contacts = [ContactAhead(f.problem, k, each, f.design, f.errors, at) for k, each in enumerate(f.contacts)]
    moved = (each.moved(each.ahead(as_sloped(0.0, at.y))) for each in contacts)
    error = reduce(add, moved) * (1.0 / len(contacts))
    return through(f.problem, f.errors, [error], at.motion.__getitem__), 0.0


@dataclass(frozen=True)
class PassageSearch:
    """The search for the cam that passes a level the first, or the last."""

    of: WorstSearch
    level: float
    """mm (rad)."""
    angle: float
    """Where the nominal cam passes, rad."""
    way: float
    """−1 for the earliest, 1 for the latest."""
    side: float
    """1 where cams that stand out the most decide, −1 where those that stand back do."""

    def run(self, until: float) -> Bounded[Values]:
        """How far from the nominal one a cam passes, and none does, rad."""
        place = self._passes(self.angle, self._corner)
        if isinf(place):
            return Bounded(inf, {}, unproved=NEVER)
        found, errors = self._touching(place, self._corner)
        if self.of.problem.programme.corners:
            return Bounded(found, errors, unproved=CORNERS)
        return bounded(found, errors, self.proof, self._worse, until, GAPS, SECONDS)

    def _corner(self, places: FloatArray) -> dict[str, FloatArray]:
        """The errors of the furthest cams, where they touch with places."""
        return self.of.corner(self.of.within(places), self.side)

    def _passes(self, start: float, errors: Cams) -> float:
        """The place with which cams touch that pass the furthest from a start."""

        def beyond(places: FloatArray) -> FloatArray:
            found = self.of.contact(errors(places), places)
            return self.side * (self._tool(found.angle) + found.error - self.level)

        return until_not(start, self.way, beyond)

    def _touching(self, place: float, errors: Cams) -> tuple[float, Values]:
        """How far from the nominal passage a cam touches with a place, and its errors at that cam angle."""
        cam = {key: float(each[0]) for key, each in errors(np.array([place])).items()}
        angle = float(self.of.contact(cam, np.array([place])).angle[0])
        if BORE_WAY in cam:  # in the ground at that cam angle, not where the point is touched
            cam[BORE_WAY] += self.of.problem.design.sense * (angle - place)
        return max(self.way * (angle - self.angle), 0.0), cam

    def _worse(self, values: Values, bound: float) -> tuple[float, Values]:
        """Where a cam passes that is at the level, or beyond it, at a distance from the nominal passage."""
        angle, sense = self.angle + self.way * (bound + BEYOND), self.of.problem.design.sense

        def errors(places: FloatArray) -> dict[str, FloatArray]:
            found = {key: np.full(places.size, each) for key, each in values.items()}
            if BORE_WAY in found:
                found[BORE_WAY] += sense * (places - angle)
            return found

        place = np.array([angle])
        for _ in range(TOUCHES):
            place = place - (self.of.contact(errors(place), place).angle - angle)
        return self._touching(self._passes(float(place[0]), errors), errors)

    def _tool(self, angles: FloatArray) -> FloatArray:
        return np.asarray(self.of.problem.programme.tool.at(self.of.within(angles))[0])

    def proof(self, distance: float, until: float) -> Tried:
        """Whether at a distance from the nominal passage no cam is at the level yet, or all are beyond it."""
        problem, box = self.of.problem, box_of(self.of.ends)
        contacts = contacts_of(problem) if problem.setup.mechanism.further else (problem,)
        angle = self.of.within(np.array([self.angle + self.way * (distance + BEYOND)]))

        def error(designs: Designs, programme: Any) -> Any:
            return AngleError(problem, contacts, designs, {key: designs.numbers[key] for key in box})

        bound = self.level - float(self._tool(angle)[0])
        claim = Claim(error, ALL_STROKES, LARGEST if self.side > 0.0 else LEAST, Plain(bound))
        table = problem.programme.table
        panel = np.minimum(np.searchsorted(table.centre + table.half_width, angle), table.centre.size - 1)
        parts, u = Parts.of(panel, claim, box), (angle - table.centre[panel]) / table.half_width[panel]
        parts.low[0], parts.high[0] = u, u
        return Proof(problem, claim, problem.design, tuple(box), until, self.of.ends).tried(parts)

    def said(self, values: Values, distance: float) -> Values:
        """Errors in mm and deg, with the direction of the bore as the cam has it."""
        angle = self.angle + self.way * distance
        return self.of.said(values, angle, angle)


class Asked(NamedTuple):
    """A passage of the nominal cam."""

    lift: float
    """As it is told."""
    level: float
    """mm (rad)."""
    passage: str
    angle: float
    """rad."""


ENDS = {"earliest": -1.0, "latest": 1.0}
SIDES = {
    ("rises", "earliest"): 1.0,
    ("rises", "latest"): -1.0,
    ("falls", "earliest"): -1.0,
    ("falls", "latest"): 1.0,
}


def worst_passages(turn: TurnErrors, asked: list[Asked]) -> Iterator[WorstPassage]:
    """Those of the passages of the nominal cam, the earliest and the latest of each.

    BadInput for tolerances so large that a follower has no place on its cam.
    """
    of, until = worst_search(turn), now() + SECONDS
    every = [(each, end) for each in asked for end in ENDS]
    try:
        for number, (each, end) in enumerate(every):
            yield _worst(of, each, end, share(until, len(every) - number))
    except FloatingPointError:
        raise of.lost() from None


def _worst(of: WorstSearch, asked: Asked, end: str, until: float) -> WorstPassage:
    way = ENDS[end]
    search = PassageSearch(of, asked.level, asked.angle, way, SIDES[asked.passage, end])
    found = search.run(until)
    bound, passed = (degrees(asked.angle + way * each) for each in (found.bound + BEYOND, found.found))
    errors = search.said(found.cam, found.found) if found.cam else {}
    return WorstPassage(asked.lift, asked.passage, end, bound, passed, errors, found.unproved)

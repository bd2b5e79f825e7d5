"""How the motion of one design answers to a small error, at the tool: f'·δ with the ratio f' of the train.

What the follower answers is ``effects.answers``; of a number p of the train the tool moves by ∂f/∂p.

Errors of a follower with two contacts are half of the difference of both, and their sum is what holds these apart.
Each contact, as of an ordinary cam with the motion of its own (``mechanisms.pairs``), would move the follower by e₁
outward, or by e₂ back, more than is asked. Both are equally stiff (``effects.preload``), so that a follower which
both hold stands in the middle, and they are nearer to each other by the sum:

    δ = (e₁ − e₂)/2,    s = e₁ + e₂,    P = k·(δ₀ + s)

with the interference δ₀ against the stiffness k; where δ₀ + s is below 0 there is a clearance as large. What the
preload stores, ½·k·(δ₀ + s)², changes over a turn, and so it turns the camshaft back and forth by the torque P·s':
that is 0 of the nominal cam. Where the nominal follower has a clearance, δ is that of the middle of it.

What is of one disc or its roller counts at one contact: sizes under ``[drive]``, the angle between the discs and a
profile of its own at the second. The pivot, the angle on the shaft and the bore of both discs count at both. So do
the arms of two rollers about a rib, which are of one length, and the distance of these, by half at each; its two
flanks and rollers are off each by itself.
Another base radius has the motion that is asked, and moves the roller by ∂s₀/∂R_b: that is an error of s alone.

Source: Rothbart, Cam Design Handbook, ch. 3 (conjugate and yoke cams).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.effects.answers import (
    ORDERS,
    SECOND,
    Answers,
    At,
    Own,
    back_of,
    derivatives_of,
    errors_at,
    most_of_profile,
    moved_by_link,
    outward_of,
)
from camopt.model.mechanisms import Designs
from camopt.model.motion.driven import ratio_of
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_of_train
from camopt.scene.problem.zones import number_zones, tool_zones
from camopt.scene.scene import Scene
from camopt.solve.tolerances.errors import BORE, contacts_of, in_mirror

BASES = "cam.base_radius", "drive.base_radius"
STEP = 1e-6
"""Of a base radius, relative, for the slope of where its roller stands."""


@dataclass(frozen=True)
class Responses:
    """The answers of the motion of one design at cam angles (m,) in rad: δ, δ' and δ'' of the tool, each (3, m).

    In mm or rad by mm or rad of the error; the derivatives by the cam angle in rad.
    """

    problem: Problem
    angles: FloatArray

    @cached_property
    def follower(self) -> Answers:
        """Those of the follower."""
        return Answers(self.problem.setup.mechanism, self.problem.design, self.problem.programme, self.angles)

    def to_number(self, key: str) -> FloatArray:
        """To a number that is larger than it should be, by its key: a size of the follower, a link, or an angle."""
        return self._to_link(key) if is_of_train(key) else self._tool(self.follower.to_number(key))

    def rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """To an error of a key of ``[tolerances]``, to its real and its imaginary part."""
        if key == "bore_eccentricity":
            return self.to_bore
        if key == "profile":
            return self.to_waves(waves) if waves else (self.to_profile,)
        return (self.to_number(key),)

    def to_size(self, field: str) -> FloatArray:
        """To a size of the follower, by field of ``Designs``, that is larger than it should be."""
        return self._tool(self.follower.to_size(field))

    @cached_property
    def to_profile(self) -> FloatArray:
        """To a profile that stands out along its normal everywhere, as to a roller that is larger by as much."""
        return self._tool(self.follower.to_profile)

    def to_waves(self, count: int) -> tuple[FloatArray, FloatArray]:
        """To a profile that stands out as a cosine, and as a sine, of so many waves in a turn."""
        cosine, sine = map(self._tool, self.follower.to_waves(count))
        return cosine, sine

    @cached_property
    def to_bore(self) -> tuple[FloatArray, FloatArray]:
        """To a profile whose axis is off that of the bore, in each of two directions that turn with the cam."""
        first, second = map(self._tool, self.follower.to_bore)
        return first, second

    @cached_property
    def ratio(self) -> Series | None:
        """The ratio of the train; None without one."""
        train = self.problem.setup.train
        return None if train is None else ratio_of(train, self.problem.programme, self.angles)

    def _to_link(self, key: str) -> FloatArray:
        """To a number of the train, from the series of the tool by it, whose terms are series by the cam angle."""
        problem, train = self.problem, self.problem.setup.train
        assert train is not None
        made = problem.trains({key: Taylor([problem.nominal[key], 1.0])})
        return self._terms(moved_by_link(made, train, problem.programme, self.angles))

    def _tool(self, found: Series) -> FloatArray:
        """What a series of the follower is at the tool."""
        return self._terms(found if self.ratio is None else found * self.ratio)

    def _terms(self, found: Series) -> FloatArray:
        return derivatives_of(found, self.angles.shape)


def wider(problem: Problem) -> At:
    """Both profiles that stand out alike: what holds the contacts further apart."""
    return At(("profile", 1.0), ("profile", outward_of(problem.setup.mechanism)))


@dataclass(frozen=True)
class PairResponses:
    """The answers of both contacts, and of the tool, at cam angles (m,), rad."""

    problem: Problem
    angles: FloatArray

    @cached_property
    def contacts(self) -> tuple[Responses, Responses]:
        first, second = (Responses(each, self.angles) for each in contacts_of(self.problem))
        return first, second

    def to(self, at: At) -> FloatArray:
        """Of the tool, to an error, (3, m)."""
        return self.through_train((self._of(0, at.first) - self._of(1, at.second)) / 2.0)

    def apart(self, at: At) -> FloatArray:
        """Of what both contacts are apart, to an error, (m,)."""
        return np.asarray(self.moving_apart(at)[0])

    def moving_apart(self, at: At) -> FloatArray:
        """The same with its derivatives by the cam angle, (3, m)."""
        return self._of(0, at.first) + self._of(1, at.second)

    @cached_property
    def bores(self) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """To the axis of the bore in two directions that turn with the cam, at both contacts; y in the mirror."""
        (x, y), (across, up) = (each.to_bore for each in self.contacts)
        way = back_of(self.problem.setup.mechanism)
        return (x, way * across), (y, -way * up if in_mirror(self.problem) else way * up)

    @property
    def ratio(self) -> FloatArray:
        """Of the tool to the follower, (m,)."""
        return np.asarray(self.through_train(np.ones((ORDERS, self.angles.size)))[0])

    def through_train(self, found: FloatArray) -> FloatArray:
        """What derivatives at the follower are at the tool."""
        if self.problem.setup.train is None:
            return found
        moved = Taylor([found[0], found[1], found[2] / 2.0]) * Responses(self.problem, self.angles).ratio
        return derivatives_of(moved, self.angles.shape)

    def rows(self, key: str, waves: int) -> Sequence[FloatArray]:
        """To an error of one key, to its real and its imaginary part."""
        if key == BORE:
            return tuple(self.through_train((first - second) / 2.0) for first, second in self.bores)
        if is_of_train(key):
            return (Responses(self.problem, self.angles).to_number(key),)
        at = errors_at(self.problem.setup.mechanism, key.removesuffix(SECOND))[key]
        if not (waves and key.startswith("profile")):
            return (self.to(at),)
        place, sign = self._at(at)
        half = 0.5 - place  # of e₁, or of −e₂
        return tuple(self.through_train(half * sign * each) for each in self.contacts[place].to_waves(waves))

    def rows_apart(self, key: str, waves: int) -> Sequence[FloatArray]:
        """The same of what both contacts are apart, (m,) each: of a base radius too, 0 of a number of the train."""
        if key == BORE:
            return tuple((first + second)[0] for first, second in self.bores)
        if key in BASES:
            return (np.full(self.angles.size, _slope_of_start(self.problem)[key]),)
        if is_of_train(key):
            return (np.zeros(self.angles.size),)
        at = errors_at(self.problem.setup.mechanism, key.removesuffix(SECOND))[key]
        if not (waves and key.startswith("profile")):
            return (self.apart(at),)
        place, sign = self._at(at)
        return tuple(sign * each[0] for each in self.contacts[place].to_waves(waves))

    def _at(self, at: At) -> tuple[int, float]:
        """The contact that an error is of alone, and its sign there."""
        return (0, 1.0) if at.second is None else (1, back_of(self.problem.setup.mechanism) * at.second[1])

    def _of(self, place: int, own: Own | None) -> FloatArray:
        if own is None:
            return np.zeros((ORDERS, self.angles.size))
        key, sign = own
        answers = self.contacts[place]
        sign *= back_of(self.problem.setup.mechanism) if place else 1.0
        return sign * (answers.to_profile if key == "profile" else answers.to_number(key))


class Between(NamedTuple):
    """By how much both contacts are held further apart at least and at most, mm (rad), at each cam angle."""

    low: FloatArray
    high: FloatArray

    @property
    def least(self) -> float:
        return float(self.low.min())

    @property
    def most(self) -> float:
        return float(self.high.max())


def off_apart(scene: Scene, problem: Problem, angles: FloatArray) -> Between:
    """s of all cams within the tolerances, at cam angles, to first order."""
    found, none = [*apart_by(scene, problem, angles)], np.zeros(angles.size)
    return Between(*(sum((each[end] for _, each in found), none) for end in (0, 1)))


class AnswerApart(NamedTuple):
    """What errors of a tolerance make of s, at cam angles, and between which values they are."""

    key: str
    rows: FloatArray
    """For each of the errors that the tolerance is of, (k, m)."""
    lower: float
    upper: float

    @property
    def between(self) -> Between:
        return Between(*np.sort([self.lower * self.rows, self.upper * self.rows], axis=0).sum(axis=1))

    def of(self, off: FloatArray | None, end: int) -> FloatArray:
        """What it makes at least (0) or at most (1); of cams (n,) that are off so, at all of them, (n, m)."""
        return self.between[end] if off is None else np.multiply.outer(off, self.rows.sum(axis=0))


def apart_by(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[tuple[str, Between]]:
    """What each tolerance makes of s, by its key."""
    for each in answers_apart(scene, problem, angles):
        yield each.key, each.between


def answers_apart(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[AnswerApart]:
    """The answers of s to all that tolerances are of; that of the bore is in the direction with the largest."""
    answers, given = PairResponses(problem, angles), scene.tolerances
    zones = {key: (zone.lower, zone.upper) for key, zone in tool_zones(scene, problem.nominal).items()}
    if given.profile:
        zones["profile"] = -given.profile, given.profile
    for key, ends in zones.items():
        if not is_of_train(key):
            every = [answers.apart(at) for at in errors_at(problem.setup.mechanism, key).values()]
            yield AnswerApart(key, np.array(every), *ends)
    if bore := given.bore_eccentricity:
        most = np.hypot(*(first[0] + second[0] for first, second in answers.bores))
        yield AnswerApart(BORE, most[None], -bore, bore)
    for key, (lower, upper) in _base_zones(scene, problem).items():
        yield AnswerApart(key, np.full((1, angles.size), _slope_of_start(problem)[key]), lower, upper)


def fastest_apart(scene: Scene, problem: Problem, angles: FloatArray) -> FloatArray:
    """The largest |s'| by the cam angle of all cams within the tolerances, to first order.

    Infinite for a profile without a number of waves.
    """
    answers, given, found = PairResponses(problem, angles), scene.tolerances, np.zeros(angles.size)
    for key, zone in tool_zones(scene, problem.nominal).items():
        if not is_of_train(key):
            for at in errors_at(problem.setup.mechanism, key).values():
                found += max(-zone.lower, zone.upper) * np.abs(answers.moving_apart(at)[1])
    if given.profile:
        for at in errors_at(problem.setup.mechanism, "profile").values():
            found += most_of_profile(answers.moving_apart(at), given.profile, given.waves)[1]
    if given.bore_eccentricity:
        found += given.bore_eccentricity * np.hypot(*(first[1] + second[1] for first, second in answers.bores))
    return found


def _base_zones(scene: Scene, problem: Problem) -> dict[str, tuple[float, float]]:
    """By how much base radii may be off, mm."""
    zones = number_zones(scene, problem.nominal)
    return {key: (zones[key].lower, zones[key].upper) for key in BASES if key in zones}


def _slope_of_start(problem: Problem) -> dict[str, float]:
    """By how much both contacts stand further apart for a larger base radius, mm/mm (rad/mm)."""
    mechanism = problem.setup.mechanism
    start = mechanism.start or (lambda designs: designs.size)

    def slope(designs: Designs) -> float:
        step = STEP * designs.size
        ends = (start(replace(designs, size=designs.size + side * step)) for side in (1.0, -1.0))
        return float(((next(ends) - next(ends)) / (2.0 * step))[0])

    if mechanism.ribbed:
        return {"cam.base_radius": 0.0}  # both stand further out alike
    first, second = slope(problem.design), slope(mechanism.further[0].seen(problem.design))
    if mechanism.drive.one_disc:
        return {"cam.base_radius": first + second}
    return {"cam.base_radius": first, "drive.base_radius": second}


def responses_of(problem: Problem, angles: FloatArray) -> Responses | PairResponses:
    """The answers of the motion of a problem, with one contact or two."""
    return (PairResponses if problem.setup.mechanism.further else Responses)(problem, angles)

"""Errors of a follower with two contacts: half of the difference of both, and their sum is what holds them apart.

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

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.effects.answers import (
    ORDERS,
    SECOND,
    At,
    Own,
    back_of,
    derivatives_of,
    errors_at,
    most_of_profile,
    outward_of,
)
from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.numerics.taylor import Taylor
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.problem.zones import number_zones, tool_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import moves_tool
from camopt.tolerances.errors import BORE, BORE_WAY, LEVEL, WAY, error_ends, way_of
from camopt.tolerances.exact import contact_of
from camopt.tolerances.recontact import Off, RealCams, RealMotion
from camopt.tolerances.response import Responses

TOUCHES = 3
"""How often the place is found anew that is touched at a cam angle."""
FACTORIALS = 1.0, 1.0, 2.0
BASES = "cam.base_radius", "drive.base_radius"
STEP = 1e-6
"""Of a base radius, relative, for the slope of where its roller stands."""


def contacts_of(problem: Problem) -> tuple[Problem, Problem]:
    """Both contacts, each as that of an ordinary cam, without a train."""
    alone, programme = replace(problem.setup, train=None), replace(problem.programme, asked=None)
    first, second = replace(problem, setup=alone, programme=programme).contacts
    return first, second


def back(problem: Problem) -> float:
    """What its own motion at the second contact is to e₂ (``effects.answers.back_of``)."""
    return back_of(problem.setup.mechanism)


def wider(problem: Problem) -> At:
    """Both profiles that stand out alike: what holds the contacts further apart."""
    return At(("profile", 1.0), ("profile", outward_of(problem.setup.mechanism)))


def in_mirror(problem: Problem) -> bool:
    """Whether the second contact sees the cam turn the other way: in a mirror along its axis, not across it."""
    (further,) = problem.setup.mechanism.further
    return bool(further.seen(problem.design).sense != problem.design.sense)


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
        way = back(self.problem)
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
        place, sign = (0, 0.5) if at.second is None else (1, -0.5 * back(self.problem) * at.second[1])
        return tuple(self.through_train(sign * each) for each in self.contacts[place].to_waves(waves))

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
        place, sign = (0, 1.0) if at.second is None else (1, back(self.problem) * at.second[1])
        return tuple(sign * each[0] for each in self.contacts[place].to_waves(waves))

    def _of(self, place: int, own: Own | None) -> FloatArray:
        if own is None:
            return np.zeros((ORDERS, self.angles.size))
        key, sign = own
        answers = self.contacts[place]
        sign *= back(self.problem) if place else 1.0
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


@dataclass(frozen=True)
class PairCams:
    """The exact errors of cams that are off, at cam angles."""

    problem: Problem

    @cached_property
    def contacts(self) -> tuple[Problem, Problem]:
        return contacts_of(self.problem)

    def at(self, errors: Mapping[str, Any], angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """δ of the follower, and s, mm (rad), of cams whose errors are numbers or arrays (m,)."""
        first, own = (self._of(place, errors, angles) for place in (0, 1))
        second = back(self.problem) * own
        return (first - second) / 2.0, first + second

    def _of(self, place: int, errors: Mapping[str, Any], angles: FloatArray) -> FloatArray:
        """The errors of the motion of a contact, of which the place is found that touches at each cam angle."""
        own, problem, places = own_errors(self.problem, place, errors), self.contacts[place], angles
        way, developed = own.pop(BORE_WAY, None), problem.setup.mechanism.body.developed
        for _ in range(TOUCHES):
            given = dict(own)
            if way is not None and developed:  # along the surface of the cylinder, where it is touched
                there = angles + own.get("phase", 0.0)
                given[BORE] = own[BORE] * np.cos(way + problem.design.sense * there)
            elif way is not None:  # in the ground
                given[BORE_WAY] = way + problem.design.sense * places
            found = contact_of(problem, given, places)
            places = places - (found.angle - angles)
        return found.error


def own_errors(problem: Problem, place: int, errors: Mapping[str, Any]) -> dict[str, Any]:
    """Errors as a contact has them; that of the bore, in the frame of the cam, is in the mirror at the second."""
    if not problem.setup.mechanism.further:
        return dict(errors)
    found, turned = dict[str, Any](), bool(place) and in_mirror(problem)
    for key, value in errors.items():
        if key == BORE:
            found[key] = np.conj(value) if turned and BORE_WAY not in errors else value
        elif key == BORE_WAY:
            found[key] = -value if turned else value
        elif key.startswith((WAY, LEVEL)):
            second = SECOND if key.endswith(SECOND) else ""
            own = errors_at(problem.setup.mechanism, "profile")[f"profile{second}"][place]
            found |= {key.removesuffix(SECOND): own[1] * value} if own else {}
        elif (own := errors_at(problem.setup.mechanism, key.removesuffix(SECOND))[key][place]) is not None:
            found[own[0]] = found.get(own[0], 0.0) + own[1] * value
    return found


def errors_of(problem: Problem, key: str) -> tuple[str, ...]:
    """The keys of the errors that a tolerance is of: with two contacts it may be one of each."""
    both = problem.setup.mechanism.further and moves_tool(key)
    alone = not both or key == BORE_WAY or is_of_train(key)
    return (key,) if alone else tuple(errors_at(problem.setup.mechanism, key))


def ends_of(scene: Scene, problem: Problem, order: int = 0) -> dict[str, tuple[float, float]]:
    """Between which values each error of the cams within the tolerances is, with one contact or two.

    To velocity (1) and acceleration (2) the axis of a cylinder counts with its way, and a profile with that of its
    waves; one whose waves are not limited counts as one that is off by a constant: it has no bound.
    """
    found = {each: ends for key, ends in error_ends(scene, problem).items() for each in errors_of(problem, key)}
    for key, (_, high) in [*found.items()] if order else ():
        if key == BORE or (scene.tolerances.waves and key.startswith("profile")):
            found |= {key: (0.0, high), way_of(key): (-pi, pi)}
    return found


@dataclass(frozen=True)
class RealPairs(RealCams):
    """Cams with two contacts of the follower; places are those of the first one."""

    @cached_property
    def contacts(self) -> tuple[RealCams, RealCams]:
        first, second = (RealCams(each, self.waves) for each in contacts_of(self.problem))
        return first, second

    def errors(self, off: Off, places: FloatArray, order: int) -> FloatArray:
        return self._errors(self.contacts[0].motion(self._own(0, off), places, order), off, order)

    def _errors(self, first: RealMotion, off: Off, order: int) -> FloatArray:
        """The same from the motion of the first contact."""
        train = self.problem.setup.train
        if train is None:
            return next(self._moved(first, off, [order]))
        orders, angles = range(order + 1), self.within(first.angle.terms[0])
        asked = zip(self.problem.programme.at(angles), self._moved(first, off, orders), FACTORIALS, strict=False)
        follower = Taylor([(stands + moved) / factor for stands, moved, factor in asked])
        tool = self.problem.train_off(off).tool(follower + self._follower_zero).terms[order]
        return np.asarray(tool * FACTORIALS[order] - self._asked(angles, order))

    def angle(self, off: Off, places: FloatArray) -> FloatArray:
        return self.contacts[0].angle(self._own(0, off), places)

    def motion(self, off: Off, places: FloatArray, order: int) -> RealMotion:
        """The cam angle by the place, and to order 0 the tool."""
        found = self.contacts[0].motion(self._own(0, off), places, order)
        if order > 0:
            return found
        asked = self._asked(self.within(found.angle.terms[0]), 0)
        return RealMotion(found.angle, Taylor([asked + self._errors(found, off, 0)]))

    def _moved(self, first: RealMotion, off: Off, orders: Iterable[int]) -> Iterator[FloatArray]:
        """The errors of the follower, in the middle of both contacts, and their derivatives by the cam angle."""
        (one, second), other = self.contacts, self._own(1, off)
        places = second.touched(other, first.angle.terms[0])
        for order in orders:
            moved = back(self.problem) * second.errors(other, places, order)
            yield (one.beyond(first, order) - moved) / 2.0

    def _own(self, place: int, off: Off) -> Off:
        """Errors as a contact has them."""
        return own_errors(self.problem, place, {key: each for key, each in off.items() if not is_of_train(key)})


def cams_of(problem: Problem, waves: int) -> RealCams:
    """Real cams of a problem, with one contact or two."""
    return (RealPairs if problem.setup.mechanism.further else RealCams)(problem, waves)


def responses_of(problem: Problem, angles: FloatArray) -> Responses | PairResponses:
    """The answers of the motion of a problem, with one contact or two."""
    return (PairResponses if problem.setup.mechanism.further else Responses)(problem, angles)

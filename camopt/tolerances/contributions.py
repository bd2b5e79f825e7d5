"""What each tolerance contributes to the error of the motion at each cam angle.

A size that is off by t moves the motion by c·t (``effects.answers``): from c·lower to c·upper at worst. An axis
of the bore that is off by ε in some direction moves it by ε times the length of a vector of two answers.
"""

from collections.abc import Callable, Iterator
from itertools import permutations
from math import inf, pi, radians, sin
from typing import NamedTuple

import numpy as np

from camopt.effects.answers import ORDERS, errors_at, most_of_profile
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem
from camopt.problem.variables import is_of_train
from camopt.problem.zones import tool_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLES, WITHIN, Tolerance, Zone
from camopt.tolerances.draw import shared_part
from camopt.tolerances.response import Responses
from camopt.tolerances.two_contacts import PairResponses


class Contribution(NamedTuple):
    """What a tolerance contributes to displacement, velocity and acceleration, each (3, m), by the cam angle."""

    key: str
    """Of the tolerance, as ``follower.offset``."""
    lower: FloatArray
    upper: FloatArray
    deviation: FloatArray
    """Standard deviation, of parts that are spread as the tolerance says."""
    change: Callable[[], float]
    """By how much it can change the displacement over the cam angles, of a dwell."""
    middle: FloatArray = np.zeros((ORDERS, 1))
    """Its mean over parts."""
    answer: FloatArray = np.zeros((ORDERS, 1))
    """Of the motion to an error that may be one of a batch."""
    batch: str | None = None
    shared: FloatArray = np.zeros(1)
    """What errors of the batch have in common (``draw.shared_part``)."""
    beyond: tuple[FloatArray, FloatArray] = (np.zeros((ORDERS, 1)), np.zeros((ORDERS, 1)))
    """By how much parts outside of the zone are below ``lower`` and above ``upper`` (``Zone.under``, ``over``)."""

    @property
    def spreads_beyond(self) -> bool:
        """Whether parts are outside of the zone, more than the ends of a normal distribution."""
        return any(bool(each.any()) for each in self.beyond)


def contributions(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[Contribution]:
    """Those of the tolerances of a scene at cam angles (m,), rad."""
    if problem.setup.mechanism.further:
        yield from _of_pair(scene, problem, angles)
        return
    given, answers = scene.tolerances, Responses(problem, angles)
    for key, zone in tool_zones(scene, problem.nominal).items():
        yield _in_batch(_of_number(key, answers.to_number(key), zone), key, given.spread[key], zone)
    if given.profile:
        yield _of_profile(answers.to_profile, given.profile, given.waves, float(np.ptp(angles)))
    if given.bore_eccentricity:
        yield _of_bore(answers.to_bore, given.bore_eccentricity, float(np.ptp(angles)))


def _of_pair(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[Contribution]:
    """The same of a follower with two contacts."""
    given, answers, turned = scene.tolerances, PairResponses(problem, angles), float(np.ptp(angles))
    for tolerance, zone in tool_zones(scene, problem.nominal).items():
        if is_of_train(tolerance):
            answer = Responses(problem, angles).to_number(tolerance)
            yield _in_batch(_of_number(tolerance, answer, zone), tolerance, given.spread[tolerance], zone)
            continue
        for key, at in errors_at(problem.setup.mechanism, tolerance).items():
            found = _of_number(key, answers.to(at), zone)
            yield _in_batch(found, tolerance, given.spread[tolerance], zone)
    if given.profile:
        for key, at in errors_at(problem.setup.mechanism, "profile").items():
            yield _of_profile(answers.to(at), given.profile, given.waves, turned)._replace(key=key)
    if given.bore_eccentricity:
        x, y = (answers.through_train((first - second) / 2.0) for first, second in answers.bores)
        yield _of_bore((x, y), given.bore_eccentricity, turned)


def _in_batch(found: Contribution, key: str, given: Tolerance, zone: Zone) -> Contribution:
    """What a number contributes, with the batch that it is of."""
    if given.batch is None:
        return found
    unit = radians(1.0) if key in ANGLES else 1.0
    return found._replace(batch=given.batch, shared=shared_part(given, zone, unit))


def _of_number(key: str, answer: FloatArray, zone: Zone) -> Contribution:
    """What a number contributes that is off by no more than its zone."""
    ends, most = (answer * zone.lower, answer * zone.upper), max(-zone.lower, zone.upper)
    lower, upper, deviation = np.minimum(*ends), np.maximum(*ends), np.abs(answer) * zone.deviation
    change, middle = lambda: most * float(np.ptp(answer[0])), answer * zone.mean
    furthest = answer * (zone.lower - zone.under), answer * (zone.upper + zone.over)
    beyond = lower - np.minimum(*furthest), np.maximum(*furthest) - upper
    return Contribution(key, lower, upper, deviation, change, middle, answer, beyond=beyond)


def variances(found: list[Contribution], order: int) -> FloatArray:
    """What each contributes to the variance of an order: its own, and half of what it has with each of its batch.

    Below 0 of one that takes off what others of its batch add; their sum is the variance, (tolerances, m).
    """
    own = np.array([np.square(each.deviation[order]) for each in found])
    for one, other in permutations(range(len(found)), 2):
        first, second = found[one], found[other]
        if first.batch is not None and first.batch == second.batch:
            together = float(np.mean(first.shared * second.shared))
            own[one] = own[one] + first.answer[order] * second.answer[order] * together
    return own


def _of_bore(answers: tuple[FloatArray, FloatArray], distance: float, turned: float) -> Contribution:
    """What an axis contributes that is off by no more than a distance, in any direction."""
    most, swung = distance * np.hypot(*answers), sin(min(0.5 * turned, 0.5 * pi))
    return Contribution("bore_eccentricity", -most, most, most / WITHIN, lambda: 2.0 * float(most[0].max()) * swung)


def _of_profile(answer: FloatArray, zone: float, waves: int | None, turned: float) -> Contribution:
    """What a profile contributes that stands out by no more than a zone, with some waves in a turn."""
    most, swung = most_of_profile(answer, zone, waves), sin(min(0.5 * turned * (waves or inf), 0.5 * pi))
    return Contribution("profile", -most, most, most / WITHIN, lambda: 2.0 * float(most[0].max()) * swung)

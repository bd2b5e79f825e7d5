"""The errors of a motion over the turn: totals at cam angles, where they are largest, and where they jump.

Contributions are sampled on every panel of the motion, on both sides of each jump, and every top that is nearly
as high as the highest is looked at again between its neighbours: there they are smooth, but for kinks.

What each tolerance contributes to the error of the motion at each cam angle.

A size that is off by t moves the motion by c·t (``effects.answers``): from c·lower to c·upper at worst. An axis
of the bore that is off by ε in some direction moves it by ε times the length of a vector of two answers.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from math import degrees, inf, pi, radians, sin
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.model.effects.answers import ORDERS, errors_at, most_of_profile
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_of_train
from camopt.scene.problem.zones import tool_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLES, WITHIN, Tolerance, Zone
from camopt.solve.tolerances.drawn_cams import shared_part
from camopt.solve.tolerances.response import PairResponses, Responses

NAMES = ("displacement", "velocity", "acceleration")
BAND = "root sum square, 3σ"
"""What the band of independent errors is called."""
NODES = 24
"""Cam angles of a panel of the motion."""
NEAR = 1e-3
"""Places this near to the highest, relative, are looked at again."""
ZOOMS, FINER = 5, 33
"""How often, and with how many cam angles between the neighbours of the highest one."""
SAID = 6
"""How many cam angles of impulses are named."""
SAME = 1e-9
"""Two sides of a jump that differ by less, relative to the largest of the turn, are the same."""


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


Total = Callable[[list[Contribution], int], FloatArray]


def no_tolerances(file: str) -> BadInput:
    """The message on a scene without any."""
    why = "names none: give one, such as profile = 0.02 or follower.roller_radius = 'h6'"
    return BadInput([Mistake(file, "tolerances", None, why, bare=True)])


class Ends(NamedTuple):
    """Between which values an error is, at each cam angle."""

    lower: FloatArray
    upper: FloatArray

    @property
    def magnitude(self) -> FloatArray:
        return np.asarray(np.maximum(-self.lower, self.upper))


def worst_ends(found: list[Contribution], order: int) -> Ends:
    """Those of the worst case of an order: all errors at the ends that move the motion the same way."""
    lower, upper = (sum(getattr(each, end)[order] for each in found) for end in ("lower", "upper"))
    return Ends(lower, upper)


def band_ends(found: list[Contribution], order: int) -> Ends:
    """The root sum square of an order: 3σ to either side of the mean, but within the worst case.

    Of parts that spread beyond their zones the worst case is that of the furthest parts.
    """
    middle, most = sum(each.middle[order] for each in found), worst_ends(found, order)
    half = WITHIN * np.sqrt(np.maximum(variances(found, order).sum(axis=0), 0.0))
    under, over = (sum(each.beyond[side][order] for each in found) for side in (0, 1))
    return Ends(np.maximum(middle - half, most.lower - under), np.minimum(middle + half, most.upper + over))


def worst(found: list[Contribution], order: int) -> FloatArray:
    """The worst case of an order, at each cam angle."""
    return worst_ends(found, order).magnitude


def band(found: list[Contribution], order: int) -> FloatArray:
    """The root sum square of an order, at each cam angle: |mean| + 3σ, but within the furthest parts."""
    return band_ends(found, order).magnitude


def highest(nodes: FloatArray, value: Callable[[FloatArray], FloatArray]) -> float:
    """The cam angle of the largest of a value over the turn, from those at nodes (``TurnErrors.nodes``), rad."""
    values = value(nodes)
    most, same = values.max(), SAME * abs(values.max())
    rising = values > np.roll(values, 1) + same  # of a plateau, as in a dwell, the first node alone
    tops = np.flatnonzero(rising & (values >= np.roll(values, -1) - same) & (values >= most - NEAR * abs(most)))
    tops = np.union1d(tops, values.argmax())
    low, high = nodes[np.maximum(tops - 1, 0)], nodes[np.minimum(tops + 1, nodes.size - 1)]
    for _ in range(ZOOMS):
        inside = low + (high - low) * np.linspace(0.0, 1.0, FINER)[:, None]
        found = value(inside.ravel()).reshape(inside.shape)
        k, column = found.argmax(axis=0), np.arange(tops.size)
        low, high = inside[np.maximum(k - 1, 0), column], inside[np.minimum(k + 1, FINER - 1), column]
    places, heights = np.concatenate([inside[k, column], nodes]), np.concatenate([found.max(axis=0), values])
    return float(places[heights.argmax()])


class Impulse(NamedTuple):
    """The impulses of what a tolerance contributes: infinite from an order on, at some cam angles, rad."""

    order: int
    at: float
    """The first of ``places``."""
    places: tuple[float, ...]


@dataclass(frozen=True)
class TurnErrors:
    """The errors of one design over a turn of the cam, by its cam angle."""

    scene: Scene
    problem: Problem

    def at(self, angles: FloatArray) -> list[Contribution]:
        """What each tolerance contributes at cam angles, rad."""
        return [*contributions(self.scene, self.problem, angles)]

    def highest(self, total: Total, order: int) -> float:
        """The cam angle of the largest total of an order that is bounded, rad."""
        return highest(self.nodes, lambda angles: total(self.at(angles), order))

    def unbounded(self, order: int) -> dict[str, float | None]:
        """The keys of tolerances whose contribution to an order has no bound, each with the cam angle, rad.

        None of one that has no bound at any angle.
        """
        jumps = {key: impulse.at for key, impulse in self.impulses.items() if impulse.order <= order}
        return jumps | {each.key: None for each in self.sampled if np.isinf(each.upper[order]).any()}

    def impulses_said(self, order: int) -> str:
        """The cam angles of the impulses of an order in words, the first ones of many."""
        every = sorted({at for each in self.impulses.values() if each.order <= order for at in each.places})
        said = ", ".join(f"{degrees(at):.6g}" for at in every[:SAID])
        return f"{said} deg" + (f" and at {len(every) - SAID} more cam angles" if len(every) > SAID else "")

    @cached_property
    def impulses(self) -> dict[str, "Impulse"]:
        """The impulses of what tolerances contribute, by key of the tolerance; of those that have one.

        Where velocity or acceleration of the motion jumps, what an error does to it may jump too: the next slope is
        an impulse there.
        """
        places = np.array([jump.at for jump in self.problem.programme.jumps])
        turn, found = self.problem.programme.strokes[-1].end, dict[str, Impulse]()
        if not places.size:
            return found
        before, after = (self.at(np.mod(places + side, turn)) for side in (-JUMP_SIDE, JUMP_SIDE))
        for left, right, usual in zip(before, after, self.sampled, strict=True):
            for order in reversed(range(ORDERS - 1)):
                with np.errstate(invalid="ignore"):
                    ends = (right.lower - left.lower)[order], (right.upper - left.upper)[order]
                jumps = np.flatnonzero(np.abs(ends).max(axis=0) > SAME * worst([usual], order).max())
                if jumps.size:
                    where = tuple(float(each) for each in places[jumps])
                    found[left.key] = Impulse(order + 1, where[0], where)
        return found

    @cached_property
    def sampled(self) -> list[Contribution]:
        """The contributions at the nodes."""
        return self.at(self.nodes)

    @cached_property
    def nodes(self) -> FloatArray:
        """The cam angles at which errors are sampled, rad, in the order of the turn."""
        table = self.problem.programme.table
        half = table.half_width[:, None]
        inner = np.clip(np.linspace(-1.0, 1.0, NODES) * half, JUMP_SIDE - half, half - JUMP_SIDE)
        return np.asarray((table.centre[:, None] + inner).ravel())

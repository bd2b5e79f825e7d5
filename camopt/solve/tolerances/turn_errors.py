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
from camopt.model.effects.error_response import RESPONSE_ORDERS, errors_by_contact, largest_profile_response
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import tool_zones
from camopt.scene.problem.variables import is_train_key
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, DEVIATIONS_AT_CPK_1, Tolerance, ToleranceZone
from camopt.solve.tolerances.error_samples import batch_mean_errors
from camopt.solve.tolerances.response import PairResponse, ToolResponse

MOTION_NAMES = ("displacement", "velocity", "acceleration")
BAND_NAME = "root sum square, 3σ"
"""What the band of independent errors is called."""
PANEL_NODES = 24
"""Cam angles of a panel of the motion."""
NEAR_HIGHEST = 1e-3
"""Places this near to the highest, relative, are looked at again."""
PEAK_ZOOMS, PEAK_NODES = 5, 33
"""How often, and with how many cam angles between the neighbours of the highest one."""
MOST_NAMED_ANGLES = 6
"""How many cam angles of impulses are named."""
SAME_JUMP_SIDES = 1e-9
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
    mean: FloatArray = np.zeros((RESPONSE_ORDERS, 1))
    """Its mean over parts."""
    response: FloatArray = np.zeros((RESPONSE_ORDERS, 1))
    """Of the motion to an error that may be one of a batch."""
    batch: str | None = None
    batch_means: FloatArray = np.zeros(1)
    """What errors of the batch have in common (``draw.batch_mean_errors``)."""
    beyond_zone: tuple[FloatArray, FloatArray] = (np.zeros((RESPONSE_ORDERS, 1)), np.zeros((RESPONSE_ORDERS, 1)))
    """By how much values outside of the zone are below ``lower`` and above ``upper``."""

    @property
    def spreads_beyond_zone(self) -> bool:
        """Whether parts are outside of the zone, more than the ends of a normal distribution."""
        return any(bool(each.any()) for each in self.beyond_zone)


def contributions(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[Contribution]:
    """Those of the tolerances of a scene at cam angles (m,), rad."""
    if problem.setup.mechanism.further_contacts:
        yield from _pair_contributions(scene, problem, angles)
        return
    given, answers = scene.tolerances, ToolResponse(problem, angles)
    for key, zone in tool_zones(scene, problem.nominal_numbers).items():
        yield _with_batch(
            _number_contribution(key, answers.number_response(key), zone),
            key,
            given.number_and_angle_tolerances[key],
            zone,
        )
    if given.profile:
        yield _profile_contribution(answers.profile_response, given.profile, given.waves, float(np.ptp(angles)))
    if given.bore_eccentricity:
        yield _bore_contribution(answers.bore_responses, given.bore_eccentricity, float(np.ptp(angles)))


def _pair_contributions(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[Contribution]:
    """The same of a follower with two contacts."""
    given, answers, turned = scene.tolerances, PairResponse(problem, angles), float(np.ptp(angles))
    for tolerance, zone in tool_zones(scene, problem.nominal_numbers).items():
        if is_train_key(tolerance):
            answer = ToolResponse(problem, angles).number_response(tolerance)
            yield _with_batch(
                _number_contribution(tolerance, answer, zone),
                tolerance,
                given.number_and_angle_tolerances[tolerance],
                zone,
            )
            continue
        for key, at in errors_by_contact(problem.setup.mechanism, tolerance).items():
            found = _number_contribution(key, answers.error_response(at), zone)
            yield _with_batch(found, tolerance, given.number_and_angle_tolerances[tolerance], zone)
    if given.profile:
        for key, at in errors_by_contact(problem.setup.mechanism, "profile").items():
            yield _profile_contribution(answers.error_response(at), given.profile, given.waves, turned)._replace(
                key=key
            )
    if given.bore_eccentricity:
        x, y = (answers.through_train((first - second) / 2.0) for first, second in answers.bore_responses)
        yield _bore_contribution((x, y), given.bore_eccentricity, turned)


def _with_batch(found: Contribution, key: str, given: Tolerance, zone: ToleranceZone) -> Contribution:
    """What a number contributes, with the batch that it is of."""
    if given.batch is None:
        return found
    unit = radians(1.0) if key in ANGLE_TOLERANCES else 1.0
    return found._replace(batch=given.batch, batch_means=batch_mean_errors(given, zone, unit))


def _number_contribution(key: str, answer: FloatArray, zone: ToleranceZone) -> Contribution:
    """What a number contributes that is off by no more than its zone."""
    ends, most = (answer * zone.lower, answer * zone.upper), max(-zone.lower, zone.upper)
    lower, upper, deviation = np.minimum(*ends), np.maximum(*ends), np.abs(answer) * zone.deviation
    change, middle = lambda: most * float(np.ptp(answer[0])), answer * zone.mean
    furthest = answer * (zone.lower - zone.below_lower), answer * (zone.upper + zone.above_upper)
    beyond = lower - np.minimum(*furthest), np.maximum(*furthest) - upper
    return Contribution(key, lower, upper, deviation, change, middle, answer, beyond_zone=beyond)


def variances(found: list[Contribution], order: int) -> FloatArray:
    """What each contributes to the variance of an order: its own, and half of what it has with each of its batch.

    Below 0 of one that takes off what others of its batch add; their sum is the variance, (tolerances, m).
    """
    own = np.array([np.square(each.deviation[order]) for each in found])
    for one, other in permutations(range(len(found)), 2):
        first, second = found[one], found[other]
        if first.batch is not None and first.batch == second.batch:
            together = float(np.mean(first.batch_means * second.batch_means))
            own[one] = own[one] + first.response[order] * second.response[order] * together
    return own


def _bore_contribution(answers: tuple[FloatArray, FloatArray], distance: float, turned: float) -> Contribution:
    """What an axis contributes that is off by no more than a distance, in any direction."""
    most, swung = distance * np.hypot(*answers), sin(min(0.5 * turned, 0.5 * pi))
    return Contribution(
        "bore_eccentricity", -most, most, most / DEVIATIONS_AT_CPK_1, lambda: 2.0 * float(most[0].max()) * swung
    )


def _profile_contribution(answer: FloatArray, zone: float, waves: int | None, turned: float) -> Contribution:
    """What a profile contributes that stands out by no more than a zone, with some waves in a turn."""
    most, swung = largest_profile_response(answer, zone, waves), sin(min(0.5 * turned * (waves or inf), 0.5 * pi))
    return Contribution(
        "profile", -most, most, most / DEVIATIONS_AT_CPK_1, lambda: 2.0 * float(most[0].max()) * swung
    )


TotalError = Callable[[list[Contribution], int], FloatArray]


def no_tolerances_error(file: str) -> BadInput:
    """The message on a scene without any."""
    why = "names none: give one, such as profile = 0.02 or follower.roller_radius = 'h6'"
    return BadInput([Mistake(file, "tolerances", None, why, bare=True)])


class ErrorRange(NamedTuple):
    """Between which values an error is, at each cam angle."""

    lower: FloatArray
    upper: FloatArray

    @property
    def magnitude(self) -> FloatArray:
        return np.asarray(np.maximum(-self.lower, self.upper))


def worst_case_range(found: list[Contribution], order: int) -> ErrorRange:
    """Those of the worst case of an order: all errors at the ends that move the motion the same way."""
    lower, upper = (sum(getattr(each, end)[order] for each in found) for end in ("lower", "upper"))
    return ErrorRange(lower, upper)


def root_sum_square_range(found: list[Contribution], order: int) -> ErrorRange:
    """The root sum square of an order: 3σ to either side of the mean, but within the worst case.

    Of parts that spread beyond their zones the worst case is that of the furthest parts.
    """
    middle, most = sum(each.mean[order] for each in found), worst_case_range(found, order)
    half = DEVIATIONS_AT_CPK_1 * np.sqrt(np.maximum(variances(found, order).sum(axis=0), 0.0))
    under, over = (sum(each.beyond_zone[side][order] for each in found) for side in (0, 1))
    return ErrorRange(np.maximum(middle - half, most.lower - under), np.minimum(middle + half, most.upper + over))


def worst_case_magnitude(found: list[Contribution], order: int) -> FloatArray:
    """The worst case of an order, at each cam angle."""
    return worst_case_range(found, order).magnitude


def root_sum_square_magnitude(found: list[Contribution], order: int) -> FloatArray:
    """The root sum square of an order, at each cam angle: |mean| + 3σ, but within the furthest parts."""
    return root_sum_square_range(found, order).magnitude


def angle_of_largest(nodes: FloatArray, value: Callable[[FloatArray], FloatArray]) -> float:
    """The cam angle of the largest of a value over the turn, from those at nodes (``TurnErrors.nodes``), rad."""
    values = value(nodes)
    most, same = values.max(), SAME_JUMP_SIDES * abs(values.max())
    rising = values > np.roll(values, 1) + same  # of a plateau, as in a dwell, the first node alone
    tops = np.flatnonzero(
        rising & (values >= np.roll(values, -1) - same) & (values >= most - NEAR_HIGHEST * abs(most))
    )
    tops = np.union1d(tops, values.argmax())
    low, high = nodes[np.maximum(tops - 1, 0)], nodes[np.minimum(tops + 1, nodes.size - 1)]
    for _ in range(PEAK_ZOOMS):
        inside = low + (high - low) * np.linspace(0.0, 1.0, PEAK_NODES)[:, None]
        found = value(inside.ravel()).reshape(inside.shape)
        k, column = found.argmax(axis=0), np.arange(tops.size)
        low, high = inside[np.maximum(k - 1, 0), column], inside[np.minimum(k + 1, PEAK_NODES - 1), column]
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

    def contributions_at(self, angles: FloatArray) -> list[Contribution]:
        """What each tolerance contributes at cam angles, rad."""
        return [*contributions(self.scene, self.problem, angles)]

    def angle_of_largest_total(self, total: TotalError, order: int) -> float:
        """The cam angle of the largest total of an order that is bounded, rad."""
        return angle_of_largest(self.nodes, lambda angles: total(self.contributions_at(angles), order))

    def unbounded_tolerances(self, order: int) -> dict[str, float | None]:
        """The keys of tolerances whose contribution to an order has no bound, each with the cam angle, rad.

        None of one that has no bound at any angle.
        """
        jumps = {key: impulse.at for key, impulse in self.impulses.items() if impulse.order <= order}
        return jumps | {each.key: None for each in self.node_contributions if np.isinf(each.upper[order]).any()}

    def impulse_angles_text(self, order: int) -> str:
        """The cam angles of the impulses of an order in words, the first ones of many."""
        every = sorted({at for each in self.impulses.values() if each.order <= order for at in each.places})
        said = ", ".join(f"{degrees(at):.6g}" for at in every[:MOST_NAMED_ANGLES])
        return f"{said} deg" + (
            f" and at {len(every) - MOST_NAMED_ANGLES} more cam angles" if len(every) > MOST_NAMED_ANGLES else ""
        )

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
        before, after = (self.contributions_at(np.mod(places + side, turn)) for side in (-JUMP_SIDE, JUMP_SIDE))
        for left, right, usual in zip(before, after, self.node_contributions, strict=True):
            for order in reversed(range(RESPONSE_ORDERS - 1)):
                with np.errstate(invalid="ignore"):
                    ends = (right.lower - left.lower)[order], (right.upper - left.upper)[order]
                jumps = np.flatnonzero(
                    np.abs(ends).max(axis=0) > SAME_JUMP_SIDES * worst_case_magnitude([usual], order).max()
                )
                if jumps.size:
                    where = tuple(float(each) for each in places[jumps])
                    found[left.key] = Impulse(order + 1, where[0], where)
        return found

    @cached_property
    def node_contributions(self) -> list[Contribution]:
        """The contributions at the nodes."""
        return self.contributions_at(self.nodes)

    @cached_property
    def nodes(self) -> FloatArray:
        """The cam angles at which errors are sampled, rad, in the order of the turn."""
        table = self.problem.programme.table
        half = table.half_width[:, None]
        inner = np.clip(np.linspace(-1.0, 1.0, PANEL_NODES) * half, JUMP_SIDE - half, half - JUMP_SIDE)
        return np.asarray((table.centre[:, None] + inner).ravel())

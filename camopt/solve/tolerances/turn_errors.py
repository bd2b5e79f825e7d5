"""First-order errors of the motion over the turn: contribution of each tolerance, totals, largest values and jumps.

A size with the error t moves the follower by c·t (``effects.tool_response``), so its contribution lies between
c·lower and c·upper. An eccentricity ε of the bore in any direction moves it by up to ε times the length of a vector
of two responses.

Contributions are sampled on every panel of the motion, and on both sides of each jump. Every local maximum that is
nearly as high as the highest is refined between its neighbours. There the contributions are smooth but for kinks.
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
from camopt.model.effects.error_response import (
    RESPONSE_ORDERS,
    largest_error_by_profile_zone,
)
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.tolerance_zones import tolerance_zones_that_move_tool
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, DEVIATIONS_AT_CPK_1, Tolerance, ToleranceZone
from camopt.solve.tolerances.error_samples import batch_mean_errors_at_quantiles
from camopt.solve.tolerances.errors import BORE, error_keys_at_contacts
from camopt.solve.tolerances.response import motion_response

MOTION_NAMES = ("displacement", "velocity", "acceleration")
BAND_NAME = "root sum square, 3σ"
"""Name of the root sum square in tables."""
PANEL_NODES = 24
"""Number of cam angles on a panel of the motion."""
NEAR_HIGHEST = 1e-3
"""Local maxima with a smaller relative distance from the highest are refined."""
PEAK_ZOOMS, PEAK_NODES = 5, 33
"""Number of refinements of a maximum, and of cam angles between its neighbours in each."""
MOST_NAMED_ANGLES = 6
"""Largest number of impulses whose cam angles a message names."""
SAME_JUMP_SIDES = 1e-9
"""Both sides of a jump are equal if they differ by less, relative to the largest value of the turn."""


class Contribution(NamedTuple):
    """Contribution of a tolerance to the errors of displacement, velocity and acceleration, shape (3, angles)."""

    key: str
    """Key of the tolerance, as ``follower.offset``."""
    lower: FloatArray
    upper: FloatArray
    deviation: FloatArray
    """Standard deviation over parts with the tolerance's distribution."""
    change: Callable[[], float]
    """Computes the largest change of the displacement over the cam angles, for a dwell."""
    mean: FloatArray = np.zeros((RESPONSE_ORDERS, 1))
    """Mean over parts."""
    response: FloatArray = np.zeros((RESPONSE_ORDERS, 1))
    """Response of the motion to an error of 1, for errors that may belong to a batch."""
    batch: str | None = None
    batch_means: FloatArray = np.zeros(1)
    """Mean errors of batches (``error_samples.batch_mean_errors_at_quantiles``)."""
    beyond_zone: tuple[FloatArray, FloatArray] = (np.zeros((RESPONSE_ORDERS, 1)), np.zeros((RESPONSE_ORDERS, 1)))
    """Distance of the furthest parts below ``lower`` and above ``upper``, beyond the tails of a Cpk of 1."""


def tolerance_contributions(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[Contribution]:
    """Contributions of all tolerances of a scene at cam angles (rad)."""
    tolerances, response, span = scene.tolerances, motion_response(problem, angles), float(np.ptp(angles))
    for tolerance_key, zone in tolerance_zones_that_move_tool(scene, problem.nominal_numbers).items():
        tolerance = tolerances.number_and_angle_tolerances[tolerance_key]
        for key in error_keys_at_contacts(problem, tolerance_key):
            (number_response,) = response.response_rows(key, 0)
            yield _number_contribution(key, number_response, zone, tolerance_key, tolerance)
    if tolerances.profile:
        for key in error_keys_at_contacts(problem, "profile"):
            (profile_response,) = response.response_rows(key, 0)
            most = largest_error_by_profile_zone(profile_response, tolerances.profile, tolerances.waves)
            yield _contribution_along_profile(key, most, span * (tolerances.waves or inf))
    if tolerances.bore_eccentricity:
        most = tolerances.bore_eccentricity * np.hypot(*response.response_rows(BORE, 0))
        yield _contribution_along_profile(BORE, most, span)


def _number_contribution(
    key: str, response: FloatArray, zone: ToleranceZone, tolerance_key: str, tolerance: Tolerance
) -> Contribution:
    """Contribution of a number with an error within its zone, with the batch of its tolerance if it has one."""
    ends, most = (response * zone.lower, response * zone.upper), max(-zone.lower, zone.upper)
    lower, upper, deviation = np.minimum(*ends), np.maximum(*ends), np.abs(response) * zone.deviation
    change, middle = lambda: most * float(np.ptp(response[0])), response * zone.mean
    furthest = response * (zone.lower - zone.below_lower), response * (zone.upper + zone.above_upper)
    beyond = lower - np.minimum(*furthest), np.maximum(*furthest) - upper
    unit, batch = radians(1.0) if tolerance_key in ANGLE_TOLERANCES else 1.0, tolerance.batch
    means = np.zeros(1) if batch is None else batch_mean_errors_at_quantiles(tolerance, zone, unit)
    return Contribution(key, lower, upper, deviation, change, middle, response, batch, means, beyond)


def variance_by_tolerance(contributions: list[Contribution], order: int) -> FloatArray:
    """Contribution of each tolerance to the variance of an order, shape (tolerances, angles).

    It is the tolerance's own variance plus its covariances with tolerances of the same batch. It is negative if the
    error compensates the others of its batch. The contributions add up to the variance.
    """
    shares = np.array([np.square(each.deviation[order]) for each in contributions])
    for i, k in permutations(range(len(contributions)), 2):
        first, second = contributions[i], contributions[k]
        if first.batch is not None and first.batch == second.batch:
            covariance = float(np.mean(first.batch_means * second.batch_means))
            shares[i] = shares[i] + first.response[order] * second.response[order] * covariance
    return shares


def _contribution_along_profile(key: str, most: FloatArray, span: float) -> Contribution:
    """Contribution of an error up to ``most`` that may take any value in turn as it runs through ``span`` [rad]."""
    swing = sin(min(0.5 * span, 0.5 * pi))
    return Contribution(key, -most, most, most / DEVIATIONS_AT_CPK_1, lambda: 2.0 * float(most[0].max()) * swing)


def no_tolerances_error(file: str) -> BadInput:
    why = "has no tolerance: add one, such as profile = 0.02 or follower.roller_radius = 'h6'"
    return BadInput([Mistake(file, "tolerances", None, why, bare=True)])


class ErrorRange(NamedTuple):
    """Least and largest error at each cam angle."""

    lower: FloatArray
    upper: FloatArray

    @property
    def magnitude(self) -> FloatArray:
        """Largest |error| at each cam angle."""
        return np.asarray(np.maximum(-self.lower, self.upper))


def worst_case_range(contributions: list[Contribution], order: int) -> ErrorRange:
    """Worst case of an order: all errors at the ends of their zones that move the tool in the same direction."""
    lower, upper = (sum(getattr(each, end)[order] for each in contributions) for end in ("lower", "upper"))
    return ErrorRange(lower, upper)


def root_sum_square_range(contributions: list[Contribution], order: int) -> ErrorRange:
    """Root sum square of an order: mean ± 3σ, but within the worst case.

    For parts that spread beyond their zones the limit is the worst case of the furthest parts.
    """
    middle, most = sum(each.mean[order] for each in contributions), worst_case_range(contributions, order)
    half = DEVIATIONS_AT_CPK_1 * np.sqrt(np.maximum(variance_by_tolerance(contributions, order).sum(axis=0), 0.0))
    under, over = (sum(each.beyond_zone[side][order] for each in contributions) for side in (0, 1))
    return ErrorRange(np.maximum(middle - half, most.lower - under), np.minimum(middle + half, most.upper + over))


def angle_of_largest_value(nodes: FloatArray, value_at_angles: Callable[[FloatArray], FloatArray]) -> float:
    """Cam angle of the largest value over the turn [rad], refined from the nodes (``TurnErrors.nodes``)."""
    values = value_at_angles(nodes)
    most, same = values.max(), SAME_JUMP_SIDES * abs(values.max())
    rising = values > np.roll(values, 1) + same  # on a plateau, as in a dwell, only the first node counts
    tops = np.flatnonzero(
        rising & (values >= np.roll(values, -1) - same) & (values >= most - NEAR_HIGHEST * abs(most))
    )
    tops = np.union1d(tops, values.argmax())
    low, high = nodes[np.maximum(tops - 1, 0)], nodes[np.minimum(tops + 1, nodes.size - 1)]
    for _ in range(PEAK_ZOOMS):
        inside = low + (high - low) * np.linspace(0.0, 1.0, PEAK_NODES)[:, None]
        heights = value_at_angles(inside.ravel()).reshape(inside.shape)
        k, column = heights.argmax(axis=0), np.arange(tops.size)
        low, high = inside[np.maximum(k - 1, 0), column], inside[np.minimum(k + 1, PEAK_NODES - 1), column]
    places, heights = np.concatenate([inside[k, column], nodes]), np.concatenate([heights.max(axis=0), values])
    return float(places[heights.argmax()])


class Impulse(NamedTuple):
    """Cam angles (rad) at which a tolerance's contribution of an order, and of higher ones, is infinite."""

    order: int
    places: tuple[float, ...]


@dataclass(frozen=True)
class TurnErrors:
    """First-order errors of one design over a turn of the cam."""

    scene: Scene
    problem: Problem

    def contributions_at(self, angles: FloatArray) -> list[Contribution]:
        return [*tolerance_contributions(self.scene, self.problem, angles)]

    def angle_of_largest_total(self, total: Callable[[list[Contribution], int], ErrorRange], order: int) -> float:
        """Cam angle of the largest total |error| of a bounded order [rad]."""
        return angle_of_largest_value(
            self.nodes, lambda angles: total(self.contributions_at(angles), order).magnitude
        )

    def angles_of_unbounded_tolerances(self, order: int) -> dict[str, float | None]:
        """Tolerances whose contribution to an order is infinite, with the first cam angle at which it is [rad].

        None instead of an angle if the contribution is infinite everywhere.
        """
        jumps = {key: impulse.places[0] for key, impulse in self.impulses.items() if impulse.order <= order}
        return jumps | {each.key: None for each in self.node_contributions if np.isinf(each.upper[order]).any()}

    def impulse_angles_text(self, order: int) -> str:
        """The cam angles of the impulses of an order as text; only the first ones of many."""
        angles = sorted({at for each in self.impulses.values() if each.order <= order for at in each.places})
        text = ", ".join(f"{degrees(at):.6g}" for at in angles[:MOST_NAMED_ANGLES])
        return f"{text} deg" + (
            f" and at {len(angles) - MOST_NAMED_ANGLES} more cam angles" if len(angles) > MOST_NAMED_ANGLES else ""
        )

    @cached_property
    def impulses(self) -> dict[str, "Impulse"]:
        """Impulses of contributions, by key of the tolerance; tolerances without an impulse are left out.

        Where velocity or acceleration of the motion jumps, a contribution may jump too. Its derivative is then an
        impulse.
        """
        places = np.array([jump.at for jump in self.problem.programme.jumps])
        turn, impulses = self.problem.programme.strokes[-1].end, dict[str, Impulse]()
        if not places.size:
            return impulses
        before, after = (self.contributions_at(np.mod(places + side, turn)) for side in (-JUMP_SIDE, JUMP_SIDE))
        for left, right, usual in zip(before, after, self.node_contributions, strict=True):
            for order in reversed(range(RESPONSE_ORDERS - 1)):
                with np.errstate(invalid="ignore"):
                    ends = (right.lower - left.lower)[order], (right.upper - left.upper)[order]
                jumps = np.flatnonzero(
                    np.abs(ends).max(axis=0) > SAME_JUMP_SIDES * worst_case_range([usual], order).magnitude.max()
                )
                if jumps.size:
                    impulses[left.key] = Impulse(order + 1, tuple(places[jumps].tolist()))
        return impulses

    @cached_property
    def node_contributions(self) -> list[Contribution]:
        return self.contributions_at(self.nodes)

    @cached_property
    def nodes(self) -> FloatArray:
        """Cam angles at which errors are sampled [rad], in the order of the turn."""
        return self.problem.programme.panel_angles(PANEL_NODES)

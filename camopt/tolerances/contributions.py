"""What each tolerance contributes to the error of the motion at each cam angle.

A size that is off by t moves the motion by c·t (``tolerances.response``): from c·lower to c·upper at worst. An axis
of the bore that is off by ε in some direction moves it by ε times the length of a vector of two answers.

A profile within ±t with at most n waves in a turn is a trigonometric polynomial δn of degree n. Its slopes are
bounded by Bernstein's and Szegő's inequality, δn'² + n²·δn² ≤ n²·t², and the same of δn' with n·t: with the answer
g to the profile

    |gδn| ≤ |g|·t,    |(gδn)'| ≤ t·√(g'² + n²g²),    |(gδn)''| ≤ t·(|g''| + n·√(4g'² + n²g²))

The first two are attained by a cosine of n waves. Without n no slope is bounded.

Sources: S. Bernstein, Sur l'ordre de la meilleure approximation des fonctions continues, 1912; R. Boas, Entire
Functions, ch. 11 (Szegő's form).
"""

from collections.abc import Callable, Iterator
from math import inf, pi, radians, sin
from typing import NamedTuple

import numpy as np

from camopt.mechanisms import FIELDS
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem
from camopt.problem.zones import size_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import WITHIN, Zone, zone_of
from camopt.tolerances.response import ORDERS, Responses


class Contribution(NamedTuple):
    """What a tolerance contributes to displacement, velocity and acceleration, each (3, m), by the cam angle."""

    key: str
    """Of the tolerance, as ``follower.offset``."""
    lower: FloatArray
    upper: FloatArray
    deviation: FloatArray
    """Standard deviation, of parts that are spread as the tolerance says."""
    change: Callable[[], float]
    """By how much it can change the displacement from one of the cam angles to another."""
    middle: FloatArray = np.zeros((ORDERS, 1))
    """Its mean over parts."""


def contributions(scene: Scene, problem: Problem, angles: FloatArray) -> Iterator[Contribution]:
    """Those of the tolerances of a scene at cam angles (m,), rad."""
    given, answers = scene.tolerances, Responses(problem, angles)
    for key, zone in size_zones(scene, problem.design).items():
        yield _of_number(f"follower.{key}", answers.to_size(FIELDS[key]), zone)
    if given.profile is not None:
        yield _of_profile(answers.to_profile, given.profile, given.waves, float(np.ptp(angles)))
    if given.bore_eccentricity is not None:
        yield _of_bore(answers.to_bore, given.bore_eccentricity)
    for key, answer in (("phase", "to_phase"), ("face_tilt", "to_tilt")):
        if (tolerance := getattr(given, key)) is not None:
            yield _of_number(key, getattr(answers, answer), zone_of(tolerance, key, 0.0).scaled(radians(1.0)))


def _of_number(key: str, answer: FloatArray, zone: Zone) -> Contribution:
    """What a number contributes that is off by no more than its zone."""
    ends, most = (answer * zone.lower, answer * zone.upper), max(-zone.lower, zone.upper)
    lower, upper, deviation = np.minimum(*ends), np.maximum(*ends), np.abs(answer) * zone.deviation
    return Contribution(key, lower, upper, deviation, lambda: most * float(np.ptp(answer[0])), answer * zone.middle)


def _of_bore(answers: tuple[FloatArray, FloatArray], distance: float) -> Contribution:
    """What an axis contributes that is off by no more than a distance, in any direction."""
    most = distance * np.hypot(*answers)

    def change() -> float:
        place = answers[0][0] + 1j * answers[1][0]
        return distance * float(np.abs(place[:, None] - place).max())

    return Contribution("bore_eccentricity", -most, most, most / WITHIN, change)


def _of_profile(answer: FloatArray, zone: float, waves: int | None, turned: float) -> Contribution:
    """What a profile contributes that stands out by no more than a zone, with some waves in a turn."""
    g, g1, g2 = np.abs(answer)
    if waves is None:
        most = zone * np.array([g, np.full_like(g, inf), np.full_like(g, inf)])
    else:
        n = float(waves)
        most = zone * np.array([g, np.hypot(g1, n * g), g2 + n * np.hypot(2.0 * g1, n * g)])
    swung = sin(min(0.5 * turned * (waves or inf), 0.5 * pi))
    return Contribution("profile", -most, most, most / WITHIN, lambda: 2.0 * zone * float(g.max()) * swung)

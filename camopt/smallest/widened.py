"""The tolerances of a problem, each of which may be wider: what prices of tolerances are derivatives by."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import radians
from typing import Any

import numpy as np

from camopt.effects.given import Band, GivenErrors
from camopt.numerics import FloatArray
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem
from camopt.problem.zones import looked_at
from camopt.scene.tolerances import Zone
from camopt.verdicts.judging import worst_excesses

MICRON, DEGREE = ("µm", 1e-3), ("deg", radians(1.0))
STEP = 1e-3
"""Of a tolerance: differences are taken over it."""


@dataclass(frozen=True)
class Toleranced:
    """A tolerance, by its key in the scene."""

    key: str
    band: Band
    """mm or rad; of other numbers in their unit."""
    unit: str
    size: float
    """Of the unit, mm or rad."""
    put: Callable[[GivenErrors, Band], GivenErrors]
    field: str = ""
    """Of designs, if they have it."""

    @property
    def bound(self) -> float:
        """The larger of its ends, in its unit."""
        return max(-self.band.low, self.band.high) / self.size

    def in_problem(self, problem: Problem, band: Band) -> Problem:
        """The problem with other ends of this tolerance."""
        given, zones = problem.setup.errors, dict(problem.zones)
        setup = problem.setup if given is None else replace(problem.setup, errors=self.put(given, band))
        if self.field in zones:
            zones[self.field] = Zone(band.low, band.high, zones[self.field].deviation)
            zones = {field: zone for field, zone in zones.items() if zone.lower or zone.upper}
        new = {limit.name: limit for limit in problem.values.limits(setup)}
        limits = tuple(replace(new[each.name], bound=each.bound) for each in problem.limits)
        return replace(problem, setup=setup, limits=limits, zones=zones, offs=looked_at(zones))

    def slopes(self, problem: Problem, limits: list[Limit]) -> FloatArray:
        """How the excess over each limit of a problem's design changes as both ends go out, per unit."""
        step = STEP * self.bound * self.size
        names, found = [limit.name for limit in limits], []
        for by in (step, -step):
            wider = self.in_problem(problem, Band(self.band.low - by, self.band.high + by))
            own = {limit.name: limit for limit in wider.limits}
            found.append(worst_excesses(wider, [own[name] for name in names], problem.design)[:, 0])
        return np.asarray((found[0] - found[1]) / (2.0 * step) * self.size)


def tolerances_of(problem: Problem) -> Iterator[Toleranced]:
    """The tolerances of a problem that are above 0."""
    given, variables = problem.setup.errors, {each.field: each for each in problem.variables}
    fields = {each.key: field for field, each in variables.items()}
    sizes = {} if given is None else {variables[field].key: band for field, band in given.sizes.items()}
    others = {} if given is None else {**given.second, **{key: band for key, (band, _) in given.links.items()}}
    zones = {variables[field].key: Band(zone.lower, zone.upper) for field, zone in problem.zones.items()}
    for key, band in {**sizes, **others, **zones}.items():
        if band.low or band.high:
            variable = variables[fields[key]]
            unit = MICRON if variable.unit == "mm" else (variable.unit, 1.0)
            yield Toleranced(f"tolerances.{key}", band, *unit, _of_number(key, fields[key]), fields[key])
    if given is None:
        return
    for key, name in (("profile", "profile"), ("bore_eccentricity", "bore")):
        if size := getattr(given, name):
            yield Toleranced(f"tolerances.{key}", Band(-size, size), *MICRON, _of_distance(name))
    for key, name in (("phase", "phase"), ("face_tilt", "tilt"), ("disc_phase", "disc_phase")):
        band = getattr(given, name)
        if band.low or band.high:
            yield Toleranced(f"tolerances.{key}", band, *DEGREE, _of_angle(name))


def _of_number(key: str, field: str) -> Callable[[GivenErrors, Band], GivenErrors]:
    """A size of the follower, one of its second contact, or a number of the train, where errors of the tool are."""

    def put(given: GivenErrors, band: Band) -> GivenErrors:
        sizes, second, links = dict(given.sizes), dict(given.second), dict(given.links)
        if field in sizes:
            sizes[field] = band
        if key in second:
            second[key] = band
        if key in links:
            links[key] = band, links[key][1]
        return replace(given, sizes=sizes, second=second, links=links)

    return put


def _of_distance(name: str) -> Callable[[GivenErrors, Band], GivenErrors]:
    return lambda given, band: _changed(given, {name: band.high})


def _of_angle(name: str) -> Callable[[GivenErrors, Band], GivenErrors]:
    return lambda given, band: _changed(given, {name: band})


def _changed(given: GivenErrors, values: dict[str, Any]) -> GivenErrors:
    return replace(given, **values)

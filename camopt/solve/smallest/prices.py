"""The price of each bound that a smallest cam just meets, and what holds the cam without it.

Prices of tolerances are derivatives by each of them, which may be wider.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, singledispatch
from math import isfinite, radians
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds, time_share
from camopt.model.effects.effect_numbers import NO_BAND, ErrorBand, ToleranceBands
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, at_rounding_error, resolve
from camopt.scene.problem.settings import law_choices, problem_with_free_numbers
from camopt.scene.problem.tolerance_zones import initial_robust_errors
from camopt.scene.tolerances import ToleranceZone
from camopt.solve.smallest.free_variables import FreeVariables
from camopt.solve.smallest.multipliers import (
    ZERO_RATES,
    ActiveConstraint,
    PriceRates,
    active_constraints,
    price_rates,
)
from camopt.solve.smallest.optimise import OPTIMISE_SECONDS, search_end, solve_all_boxes
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.price import Price, Prices
from camopt.solve.smallest.turns import SegmentAngles
from camopt.solve.tables.designs import joined_laws
from camopt.solve.verdicts.effect_runs import columns_for
from camopt.solve.verdicts.limit_verdicts import excesses, worst_excesses

BOUND_ROUNDING = 1e-9  # of a bound
MICRON, DEGREE = ("µm", 1e-3), ("deg", radians(1.0))
TOLERANCE_STEP = 1e-3
"""Of a tolerance: differences are taken over it."""


@dataclass(frozen=True)
class PricedTolerance:
    """A tolerance, by its key in the scene."""

    key: str
    band: ErrorBand
    """mm or rad; of other numbers in their unit."""
    unit: str
    unit_size: float
    """Of the unit, mm or rad."""
    set_band: Callable[[ToleranceBands, ErrorBand], ToleranceBands]
    field: str = ""
    """Of designs, if they have it."""

    @property
    def bound(self) -> float:
        """The larger of its ends, in its unit."""
        return max(-self.band.low, self.band.high) / self.unit_size

    def problem_with_band(self, problem: Problem, band: ErrorBand) -> Problem:
        """The problem with other ends of this tolerance."""
        given, zones = problem.setup.errors, dict(problem.zones)
        setup = problem.setup if given is None else replace(problem.setup, errors=self.set_band(given, band))
        if self.field in zones:
            zones[self.field] = ToleranceZone(band.low, band.high, zones[self.field].deviation)
            zones = {field: zone for field, zone in zones.items() if zone.lower or zone.upper}
        new = {limit.name: limit for limit in problem.scene_values.limits(setup)}
        limits = tuple(replace(new[each.name], bound=each.bound) for each in problem.limits)
        return replace(problem, setup=setup, limits=limits, zones=zones, robust_errors=initial_robust_errors(zones))

    def excess_slopes(self, problem: Problem, limits: list[Limit]) -> FloatArray:
        """How the excess over each limit of a problem's design changes as both ends go out, per unit."""
        step = TOLERANCE_STEP * self.bound * self.unit_size
        names, found = [limit.name for limit in limits], []
        for by in (step, -step):
            wider = self.problem_with_band(problem, ErrorBand(self.band.low - by, self.band.high + by))
            own = {limit.name: limit for limit in wider.limits}
            found.append(worst_excesses(wider, [own[name] for name in names], problem.design)[:, 0])
        return np.asarray((found[0] - found[1]) / (2.0 * step) * self.unit_size)


def tolerances_of(problem: Problem) -> Iterator[PricedTolerance]:
    """The tolerances of a problem that are above 0."""
    given, variables = problem.setup.errors, {each.field: each for each in problem.variables}
    fields = {each.key: field for field, each in variables.items()}
    sizes = {} if given is None else {variables[field].key: band for field, band in given.sizes.items()}
    others = {} if given is None else {**given.second, **{key: band for key, (band, _) in given.links.items()}}
    zones = {variables[field].key: ErrorBand(zone.lower, zone.upper) for field, zone in problem.zones.items()}
    for key, band in {**sizes, **others, **zones}.items():
        if band.low or band.high:
            variable = variables[fields[key]]
            unit = MICRON if variable.unit == "mm" else (variable.unit, 1.0)
            yield PricedTolerance(
                f"tolerances.{key}", band, *unit, partial(_with_number_band, key, fields[key]), fields[key]
            )
    if given is None:
        return
    for key, name in (("profile", "profile"), ("bore_eccentricity", "bore")):
        if size := getattr(given, name):
            yield PricedTolerance(
                f"tolerances.{key}", ErrorBand(-size, size), *MICRON, partial(_with_error_field, name)
            )
    for key, name in (("phase", "phase"), ("face_tilt", "tilt"), ("disc_phase", "disc_phase")):
        band = getattr(given, name)
        if band.low or band.high:
            yield PricedTolerance(f"tolerances.{key}", band, *DEGREE, partial(_with_error_field, name))


def _with_number_band(key: str, field: str, given: ToleranceBands, band: ErrorBand) -> ToleranceBands:
    """Errors with other ends of a size of the follower, of its second contact, or of a number of the train."""
    sizes, second, links = dict(given.sizes), dict(given.second), dict(given.links)
    if field in sizes:
        sizes[field] = band
    if key in second:
        second[key] = band
    if key in links:
        links[key] = band, links[key][1]
    return replace(given, sizes=sizes, second=second, links=links)


def _with_error_field(name: str, given: ToleranceBands, band: ErrorBand) -> ToleranceBands:
    """Errors with another tolerance of an angle, or of a distance, which has one number."""
    value: Any = band if isinstance(getattr(given, name), ErrorBand) else band.high
    return replace(given, **{name: value})


@singledispatch
def prices(what: Any, seconds: float = OPTIMISE_SECONDS) -> Prices:
    """Find what each bound costs that holds a result, and what would hold the smallest cam of known laws next.

    Bounds are those of ``[limits]``, the diameter of the shaft, the ends of ranges in ``[search]``, the tolerances
    that a limit which holds the cam depends on (one on errors, and any with ``search.robust``), and of a synthesis
    the peaks of ``[synthesis]``, also if taken by default. What every cam must hold, such as no undercut, has no
    bound and no price. A price is that of small changes.

    Of what ``optimise`` found: at the smallest cam, ∇R + Σ λ·∇c = 0 for its size R, the excesses c of what it just
    meets, and multipliers λ ≥ 0; then a bound b costs dR/db = Σ λ·∂c/∂b. For large changes the smallest cam is
    sought again without the limit.

    Of what ``synthesise`` found: the derivative of the least objective, with other laws for each value of the
    bound; mm of size per unit of the bound where the size is minimised. With the multipliers λ of the constraints c
    of the convex programme, a bound b costs df/db = ∂(f + Σ λ·c)/∂b. Laws that are a local optimum (``convex`` is
    False) have the prices of that optimum, within a few per cent.

    Parameters
    ----------
    what : Optimum or Synthesis
        What ``optimise`` or ``synthesise`` found.
    seconds : float, default 60
        Time for the searches without each limit, shared between them; a synthesis takes none.

    Returns
    -------
    Prices
        A mapping: for each law, a ``Price`` for each bound that its cam just meets; not for an end of a range that
        holds nothing, where another value makes the cam no larger. Of a synthesis ``tightened`` is ``price``; none
        where a solver fails, or where steps end at no local optimum.

    Raises
    ------
    BadInput
        For another result, seconds that are no number above 0, and a scene that ``synthesise`` does not take.

    References
    ----------
    J. Nocedal, S. J. Wright, Numerical Optimization, ch. 12. S. Boyd, L. Vandenberghe, Convex Optimization, 5.6.

    Examples
    --------
    >>> scene = camopt.find_scene("belt-matching")
    >>> (price,) = camopt.prices(camopt.optimise(scene))[""]
    >>> price.key, round(price.price, 3), price.unit
    ('limits.pressure_angle', -2.708, 'deg')
    """
    others = (
        "any other cam has none: optimise its scene, or see sensitivities for what each size and number changes"
    )
    allowed = f"what optimise or synthesise found; {others}"
    raise BadInput([Mistake("camopt", "what", type(what).__name__, allowed)])


@prices.register
def prices_of_smallest(optimum: Optimum, seconds: float = OPTIMISE_SECONDS) -> Prices:
    """The prices of the smallest cam of each law, what would hold it next sought in so many seconds."""
    end = search_end(seconds)
    cams = dict(_free_variables_by_law(optimum))
    found = {law: _active_prices(cams[law]) for law in optimum.by_law}
    left = sum(len(each) for each in found.values())
    for law, each in found.items():
        for number, price in enumerate(each):
            each[number] = _with_next_optimum(price, cams[law], time_share(end, left))
            left -= 1
    return Prices(found)


def _free_variables_by_law(optimum: Optimum) -> Iterator[tuple[str, FreeVariables]]:
    """The smallest cam of each law; not by its scene, which may be one that a part in it forbids."""
    problem = problem_with_free_numbers(at_rounding_error(resolve(optimum.scene)))
    for programme, pair in law_choices(problem).items():
        laws = joined_laws(programme.law_names(RISE), programme.law_names(RETURN))
        row = optimum.by_law.get(laws)
        if row is None:
            continue
        numbers = {each.key: row[each.quantity] for each in problem.search_space.trains}
        moved = problem.with_programme(programme).with_numbers(numbers)
        turns = SegmentAngles(moved, pair)
        varied = [each for each in problem.variables if each.is_size or each.key in problem.setup.free]
        values = {each.field: np.array([row[each.quantity]]) for each in varied if each.quantity in row}
        freed = np.array([row["angles_deg"][segment] for segment in turns.freed_segments])
        turned = turns.problem_of(freed) if turns.freed_segments else moved
        yield laws, FreeVariables(replace(turned, design=problem.design.with_values(values)), turns, freed)


def _active_prices(cam: FreeVariables) -> list[Price]:
    """The prices of the bounds that a smallest cam just meets, without what would hold it next."""
    bounds = active_constraints(cam)
    tolerances = {each.key: each for each in tolerances_of(cam.problem)}
    slopes = {key: _constraint_slopes(each, cam, bounds) for key, each in tolerances.items()}
    costs = price_rates(cam, bounds, slopes)
    binding = _significant_constraints(bounds, costs)
    asked = {bound.key: bound for bound in binding if bound.limit is None or bound.limit.set_by_scene}
    found = [(key, bound.value, bound.unit, bound.relation) for key, bound in asked.items()]
    found += [(key, each.bound, each.unit, "±") for key, each in tolerances.items() if np.any(slopes[key])]
    return [
        Price(*each, _finite_price(costs[each[0]].eased), _finite_price(costs[each[0]].tightened)) for each in found
    ]


def _constraint_slopes(
    tolerance: PricedTolerance, cam: FreeVariables, bounds: list[ActiveConstraint]
) -> FloatArray:
    """How what bounds ask changes with a tolerance, per unit of it; 0 of ends of ranges."""
    limits = [bound.limit for bound in bounds if bound.limit is not None]
    found = iter(tolerance.excess_slopes(cam.problem, limits))
    return np.array([0.0 if bound.limit is None else next(found) for bound in bounds])


def _significant_constraints(
    bounds: list[ActiveConstraint], costs: Mapping[str, PriceRates]
) -> list[ActiveConstraint]:
    return [bound for bound in bounds if bound.limit is not None or costs[bound.key] != ZERO_RATES]


def _finite_price(value: float) -> float | None:
    return value + 0.0 if isfinite(value) else None  # no −0


def _with_next_optimum(price: Price, cam: FreeVariables, until: float) -> Price:
    """A price with the smallest cam without its limit, if that is found and proved in time."""
    limits = [limit for limit in cam.problem.limits if limit.key == price.key]
    tolerance = next((each for each in tolerances_of(cam.problem) if each.key == price.key), None)
    if not (limits or tolerance) or clock_seconds() >= until:
        return price

    def ease_limit(problem: Problem) -> Problem:
        return tolerance.problem_with_band(problem, NO_BAND) if tolerance else problem.without_bound(price.key)

    easier, turns = ease_limit(cam.problem), replace(cam.turns, problem=ease_limit(cam.turns.problem), until=until)
    try:
        _, least = solve_all_boxes(easier, turns, until)
    except BadInput:  # nothing else limits the size
        return replace(price, size_without=0.0, next=())
    if least is None or least.answer.design is None or not least.answer.is_proved:
        return price
    other = FreeVariables(replace(least.problem, design=least.answer.design), turns, least.freed_angles)
    bounds = active_constraints(other)
    following = tuple(
        dict.fromkeys(bound.key for bound in _significant_constraints(bounds, price_rates(other, bounds)))
    )
    holds_to = _bound_at_cam(price, limits, other) if limits else None
    return replace(price, size_without=least.answer.size, holds_to=holds_to, next=following)


def _bound_at_cam(price: Price, limits: Sequence[Limit], cam: FreeVariables) -> float | None:
    """The bound that a cam just meets: the least strict that one of some limits asks of it."""
    design, problem = cam.problem.design, cam.problem
    columns = columns_for(problem, limits, design)
    slopes = np.array([limit.excess_derivative(columns, design)[0] for limit in limits])
    excess = excesses(limits, columns, design)[:, 0]
    asked = np.argmax(excess / np.abs(slopes))
    met = float(price.bound - excess[asked] / slopes[asked])
    return _finite_price(met if abs(met) > BOUND_ROUNDING * abs(price.bound) else 0.0)

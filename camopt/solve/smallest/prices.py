"""``camopt.prices``: the price of each active limit of a smallest cam, and the cam without this limit.

Tolerances have prices too: derivatives of the size by the width of each tolerance.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, singledispatch
from math import isfinite, radians
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget, search_budget
from camopt.model.effects.effect_numbers import NO_BAND, ErrorBand, ToleranceBands
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, resolve, with_rounding_relative_error
from camopt.scene.problem.settings import law_pair_by_programme, problem_with_searched_numbers_per_design
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
from camopt.solve.smallest.optimise import OPTIMISE_WORK, solve_all_trains_and_boxes
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.price import Price, Prices
from camopt.solve.smallest.turns import SegmentAngles
from camopt.solve.tables.designs import joined_laws
from camopt.solve.verdicts.effect_runs import columns_for_limits
from camopt.solve.verdicts.limit_verdicts import relative_excesses_by_limit, worst_excesses_over_variants

BOUND_ROUNDING = 1e-9  # relative to a bound
MICRON, DEGREE = ("µm", 1e-3), ("deg", radians(1.0))
TOLERANCE_STEP = 1e-3
"""Step of differences, relative to a tolerance."""


@dataclass(frozen=True)
class PricedTolerance:
    """A tolerance that has a price."""

    key: str
    """Its key in the scene."""
    band: ErrorBand
    """mm or rad; for other numbers in their unit."""
    unit: str
    unit_size: float
    """The unit in mm or rad."""
    set_band: Callable[[ToleranceBands, ErrorBand], ToleranceBands]
    field: str = ""
    """The field of designs with this tolerance, if there is one."""

    @property
    def largest_deviation_in_unit(self) -> float:
        """The larger of its two ends, in its unit."""
        return max(-self.band.low, self.band.high) / self.unit_size

    def problem_with_band(self, problem: Problem, band: ErrorBand) -> Problem:
        """The problem with other ends of this tolerance."""
        bands, zones = problem.setup.errors, dict(problem.zones)
        setup = problem.setup if bands is None else replace(problem.setup, errors=self.set_band(bands, band))
        if self.field in zones:
            zones[self.field] = ToleranceZone(band.low, band.high, zones[self.field].deviation)
            zones = {field: zone for field, zone in zones.items() if zone.lower or zone.upper}
        new = {limit.name: limit for limit in problem.limits_with_setup(setup)}
        limits = tuple(replace(new[each.name], bound=each.bound) for each in problem.limits)
        return replace(problem, setup=setup, limits=limits, zones=zones, robust_errors=initial_robust_errors(zones))

    def excess_slopes(self, problem: Problem, limits: list[Limit]) -> FloatArray:
        """Change of the relative excess over each limit per unit of the tolerance, as both ends move outwards."""
        step = TOLERANCE_STEP * self.largest_deviation_in_unit * self.unit_size
        names, excesses = [limit.name for limit in limits], []
        for change in (step, -step):
            changed = self.problem_with_band(problem, ErrorBand(self.band.low - change, self.band.high + change))
            changed_limits = {limit.name: limit for limit in changed.limits}
            excesses.append(
                worst_excesses_over_variants(changed, [changed_limits[name] for name in names], problem.design)[
                    :, 0
                ]
            )
        return np.asarray((excesses[0] - excesses[1]) / (2.0 * step) * self.unit_size)


def nonzero_tolerances(problem: Problem) -> Iterator[PricedTolerance]:
    """The tolerances of a problem that are above 0."""
    bands, variables = problem.setup.errors, {variable.field: variable for variable in problem.variables}
    fields = {variable.key: field for field, variable in variables.items()}
    sizes = {} if bands is None else {variables[field].key: band for field, band in bands.sizes.items()}
    others = {} if bands is None else {**bands.second, **{key: band for key, (band, _) in bands.links.items()}}
    zones = {variables[field].key: ErrorBand(zone.lower, zone.upper) for field, zone in problem.zones.items()}
    for key, band in {**sizes, **others, **zones}.items():
        if band.low or band.high:
            variable = variables[fields[key]]
            unit = MICRON if variable.unit == "mm" else (variable.unit, 1.0)
            yield PricedTolerance(
                f"tolerances.{key}", band, *unit, partial(_with_number_band, key, fields[key]), fields[key]
            )
    if bands is None:
        return
    for key, name, unit in (
        ("profile", "profile", MICRON),
        ("bore_eccentricity", "bore", MICRON),
        ("phase", "phase", DEGREE),
        ("face_tilt", "tilt", DEGREE),
        ("disc_phase", "disc_phase", DEGREE),
    ):
        value = getattr(bands, name)
        band = value if isinstance(value, ErrorBand) else ErrorBand(-value, value)
        if band.low or band.high:
            yield PricedTolerance(f"tolerances.{key}", band, *unit, partial(_with_angle_or_distance_band, name))


def _with_number_band(key: str, field: str, bands: ToleranceBands, band: ErrorBand) -> ToleranceBands:
    """The tolerances with another one of a size of the follower or second contact, or of a number of the train."""
    sizes, second, links = dict(bands.sizes), dict(bands.second), dict(bands.links)
    if field in sizes:
        sizes[field] = band
    if key in second:
        second[key] = band
    if key in links:
        links[key] = band, links[key][1]
    return replace(bands, sizes=sizes, second=second, links=links)


def _with_angle_or_distance_band(name: str, bands: ToleranceBands, band: ErrorBand) -> ToleranceBands:
    """The tolerances with another one of an angle, or of a distance, which has a single number."""
    value: Any = band if isinstance(getattr(bands, name), ErrorBand) else band.high
    return replace(bands, **{name: value})


@singledispatch
def prices(what: Any, seconds: float | None = None) -> Prices:
    """Find what each active limit of a result costs, and for known laws the smallest cam without it.

    Active limits may come from ``[limits]``, the diameter of the shaft, ends of ranges in ``[search]``, and for a
    synthesis the peaks of ``[synthesis]``, defaults included. A tolerance has a price if an active limit depends on
    it: a limit on errors, or any limit with ``search.robust``. Conditions without a value, such as no undercut,
    have no price. Prices hold for small changes.

    For a result of ``optimise``: the smallest cam has ∇R + Σ λ·∇c = 0, with its size R, the excesses c of its
    active limits, and multipliers λ ≥ 0. The price of a bound b is dR/db = Σ λ·∂c/∂b. For large changes, camopt
    solves for the smallest cam again without the limit.

    For a result of ``synthesise``: the price is the derivative of the least objective, while the laws change with
    the bound. It is mm of size per unit of the bound if the size is minimised. With the multipliers λ of the
    constraints c of the convex programme, it is df/db = ∂(f + Σ λ·c)/∂b. If the laws are a local optimum
    (``convex`` is False), the prices are those of this optimum, within a few per cent.

    Parameters
    ----------
    what : Optimum or Synthesis
        A result of ``optimise`` or ``synthesise``.
    seconds : float, optional
        Time for the searches without each limit [s], shared between them; by default a fixed amount of work. A
        synthesis takes none.

    Returns
    -------
    Prices
        A mapping: for each law, a ``Price`` for each active limit of its cam. An end of a range is left out if
        another value makes the cam no larger. For a synthesis ``tightened`` equals ``price``; there are no prices
        if the solver fails, or if its steps do not reach a local optimum.

    Raises
    ------
    BadInput
        For another result, for ``seconds`` that are not a number above 0, and for a scene that ``synthesise`` does
        not accept.

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
    remedy = "for another cam, first optimise its scene; sensitivities show the effect of each size and number"
    allowed = f"a result of optimise or synthesise; {remedy}"
    raise BadInput([Mistake("camopt", "what", type(what).__name__, allowed)])


@prices.register
def prices_of_smallest(optimum: Optimum, seconds: float | None = None) -> Prices:
    """The prices of the smallest cam of each law, with the cams without each limit; see ``prices``."""
    end = search_budget(seconds, OPTIMISE_WORK)
    cams = dict(_free_variables_by_law(optimum))
    prices_by_law = {law: _prices_of_active_limits(cams[law]) for law in optimum.by_law}
    remaining = sum(len(law_prices) for law_prices in prices_by_law.values())
    for law, law_prices in prices_by_law.items():
        for number, price in enumerate(law_prices):
            law_prices[number] = _with_optimum_without_limit(price, cams[law], end.share(remaining))
            remaining -= 1
    return Prices(prices_by_law)


def _free_variables_by_law(optimum: Optimum) -> Iterator[tuple[str, FreeVariables]]:
    """The free variables of the smallest cam of each law, from its quantities: its scene may not be resolvable."""
    problem = problem_with_searched_numbers_per_design(with_rounding_relative_error(resolve(optimum.scene)))
    for programme, pair in law_pair_by_programme(problem).items():
        laws = joined_laws(programme.law_names(RISE), programme.law_names(RETURN))
        row = optimum.by_law.get(laws)
        if row is None:
            continue
        numbers = {each.key: row[each.quantity] for each in problem.search_space.trains}
        law_problem = problem.with_programme(programme).with_numbers(numbers)
        turns = SegmentAngles(law_problem, pair)
        values = {
            each.field: np.array([row[each.quantity]])
            for each in problem.variables
            if each.quantity in row and (each.is_size or each.key in problem.setup.free)
        }
        freed = np.array([row["angles_deg"][segment] for segment in turns.freed_segments])
        turn_problem = turns.problem_with_angles(freed) if turns.freed_segments else law_problem
        yield laws, FreeVariables(replace(turn_problem, design=problem.design.with_values(values)), turns, freed)


def _prices_of_active_limits(cam: FreeVariables) -> list[Price]:
    """The prices of the active limits of a smallest cam, without the cams that lack them."""
    bounds = active_constraints(cam)
    tolerances = {tolerance.key: tolerance for tolerance in nonzero_tolerances(cam.problem)}
    # change of each constraint per unit of each tolerance; ends of ranges do not change
    slopes = {key: np.zeros(len(bounds)) for key in tolerances}
    of_limits = [bound.limit is not None for bound in bounds]
    for key, tolerance in tolerances.items():
        slopes[key][of_limits] = tolerance.excess_slopes(
            cam.problem, [bound.limit for bound in bounds if bound.limit is not None]
        )
    rates = price_rates(cam, bounds, slopes)
    priced = {
        bound.key: bound
        for bound in _drop_range_ends_without_price(bounds, rates)
        if bound.limit is None or bound.limit.set_by_scene
    }
    rows = [(key, bound.value, bound.unit, bound.relation) for key, bound in priced.items()]
    rows += [
        (key, each.largest_deviation_in_unit, each.unit, "±")
        for key, each in tolerances.items()
        if np.any(slopes[key])
    ]
    return [Price(*row, _finite_price(rates[row[0]].eased), _finite_price(rates[row[0]].tightened)) for row in rows]


def _drop_range_ends_without_price(
    bounds: list[ActiveConstraint], rates: Mapping[str, PriceRates]
) -> list[ActiveConstraint]:
    return [bound for bound in bounds if bound.limit is not None or rates[bound.key] != ZERO_RATES]


def _finite_price(value: float) -> float | None:
    return value + 0.0 if isfinite(value) else None  # no −0


def _with_optimum_without_limit(price: Price, cam: FreeVariables, budget: Budget) -> Price:
    """The price with the smallest cam without its limit, if that cam is proved within the budget."""
    limits = [limit for limit in cam.problem.limits if limit.key == price.key]
    tolerance = next((each for each in nonzero_tolerances(cam.problem) if each.key == price.key), None)
    if not (limits or tolerance) or budget.is_spent:
        return price

    def ease_limit(problem: Problem) -> Problem:
        return tolerance.problem_with_band(problem, NO_BAND) if tolerance else problem.without_bound(price.key)

    easier, turns = (
        ease_limit(cam.problem),
        replace(cam.turns, problem=ease_limit(cam.turns.problem), budget=budget),
    )
    try:
        _, least = solve_all_trains_and_boxes(easier, turns, budget)
    except BadInput:  # nothing else limits the size
        return replace(price, size_without=0.0, next=())
    if least is None or least.answer.design is None or not least.answer.is_proved:
        return price
    other = FreeVariables(replace(least.problem, design=least.answer.design), turns, least.freed_angles)
    bounds = active_constraints(other)
    next_keys = (bound.key for bound in _drop_range_ends_without_price(bounds, price_rates(other, bounds)))
    holds_to = _bound_active_at_cam(price, limits, other) if limits else None
    return replace(price, size_without=least.answer.size, holds_to=holds_to, next=tuple(dict.fromkeys(next_keys)))


def _bound_active_at_cam(price: Price, limits: Sequence[Limit], cam: FreeVariables) -> float | None:
    """The bound at which the limits of a price would be active for another cam, in the unit of the bound."""
    design, problem = cam.problem.design, cam.problem
    columns = columns_for_limits(problem, limits, design)
    slopes = np.array([limit.excess_derivative_by_bound(columns, design)[0] for limit in limits])
    excess = relative_excesses_by_limit(limits, columns, design)[:, 0]
    worst = np.argmax(excess / np.abs(slopes))
    bound = float(price.bound - excess[worst] / slopes[worst])
    return _finite_price(bound if abs(bound) > BOUND_ROUNDING * abs(price.bound) else 0.0)

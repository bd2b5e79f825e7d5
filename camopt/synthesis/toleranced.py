"""Free laws for every cam within tolerances: linear limits less what tolerances of sizes take of them.

A cam that is off by δe and δR has the lead e + δe and the height s₀ + δs of its own,

    s₀ + δs = √((R_p + δR)² − (e + δe)²),    R_p² = s₀² + e²

so that a·y + b·y' + c·y'' + l·e + h·s₀ + k ≥ 0 holds for it if the same less a constant, l·δe + h·δs at its worst,
holds for the nominal one. That constant is taken at the sizes of the nominal optimum, and again at those that come
of it; in the end the smallest cam of the laws is the robust one, which is proved as any other.

Source: A. Ben-Tal, L. El Ghaoui, A. Nemirovski, Robust Optimization, 2009, ch. 1.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import sqrt

from camopt.problem.zones import Off
from camopt.synthesis.demand import Demand, LinearConstraint


def with_offs(demand: Demand, lead: float, height: float) -> Demand:
    """The demand with limits that cams which are off hold too, near an optimum of these sizes, mm."""
    shifts = list(_shifts(demand, lead, height))

    def less(floor: LinearConstraint) -> LinearConstraint:
        worst = min(floor.lead * by_lead + floor.height * by_height for by_lead, by_height in shifts)
        return replace(floor, constant=floor.constant + min(worst, 0.0))

    return replace(demand, floors=tuple(map(less, demand.floors)))


def _shifts(demand: Demand, lead: float, height: float) -> Iterator[tuple[float, float]]:
    """δe and δs of each cam that is off."""
    for off in demand.problem.offs:
        by_lead = demand.problem.design.sense * off.get("offset", 0.0)
        yield by_lead, _higher(demand, off, lead, by_lead, height)


def _higher(demand: Demand, off: Off, lead: float, by_lead: float, height: float) -> float:
    larger = off.get("size", 0.0)
    if not demand.traced:
        return larger
    prime = sqrt(height**2 + lead**2) + larger + off.get("roller_radius", 0.0)
    return sqrt(max(prime**2 - (lead + by_lead) ** 2, 0.0)) - height

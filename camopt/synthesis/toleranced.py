"""Free laws for every cam within tolerances: linear limits less what tolerances of sizes take of them.

A cam that is off by δe and δR has the lead e + δe and the height s₀ + δs of its own,

    s₀ + δs = √((R_p + δR)² − (e + δe)²),    R_p² = s₀² + e²

so that a·y + b·y' + c·y'' + l·e + h·s₀ + k ≥ 0 holds for it if the same less a constant, l·δe + h·δs at its worst,
holds for the nominal one. That constant is taken at the sizes of the nominal optimum, and again at those that come
of it; in the end the smallest cam of the laws is the robust one, which is proved as any other. A train whose links
are off gives planes of its own, at its ratio. What is no plane is a curve of each of these cams (``ceilings``).

Source: A. Ben-Tal, L. El Ghaoui, A. Nemirovski, Robust Optimization, 2009, ch. 1.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import sqrt

from camopt.problem.zones import Off
from camopt.synthesis.demand import Demand, LinearConstraint
from camopt.synthesis.linear_constraints import floors_of
from camopt.synthesis.through_train import ratio_of


def with_offs(demand: Demand, lead: float, height: float) -> Demand:
    """The demand with limits that cams which are off hold too, near an optimum of these sizes, mm."""
    nominal = demand.problem.without_errors
    shifts = {id(nominal): (nominal, [(0.0, 0.0)])}
    for problem, off in demand.problem.others:
        _, own = shifts.setdefault(id(problem), (problem, []))
        by_lead = demand.problem.design.sense * off.get("offset", 0.0)
        own.append((by_lead, _higher(demand, off, lead, by_lead, height)))
    unit, floors = abs(ratio_of(nominal) or 1.0), list[LinearConstraint]()
    for problem, own in shifts.values():
        ratio = abs(ratio_of(problem) or 1.0)
        floors += (_less(floor, own, ratio, unit) for floor in floors_of(problem))
    return replace(demand, floors=tuple(floors))


def _less(
    floor: LinearConstraint, shifts: Sequence[tuple[float, float]], ratio: float, unit: float
) -> LinearConstraint:
    """A linear limit of which so much is taken, δe and δs, as the worst of some cams does.

    It is that of a train of a ratio, and of sizes in units of that of another one (``through_train.at_tool``).
    """
    worst = min(floor.lead * by_lead + floor.height * by_height for by_lead, by_height in shifts)
    share = ratio / unit
    lead, height = floor.lead * share, floor.height * share
    return replace(floor, lead=lead, height=height, constant=floor.constant + ratio * worst)


def _higher(demand: Demand, off: Off, lead: float, by_lead: float, height: float) -> float:
    larger = off.get("size", 0.0)
    if not demand.traced:
        return larger
    prime = sqrt(height**2 + lead**2) + larger + off.get("roller_radius", 0.0)
    return sqrt(max(prime**2 - (lead + by_lead) ** 2, 0.0)) - height

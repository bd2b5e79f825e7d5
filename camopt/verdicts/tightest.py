"""Which of several contacts of a follower a limit holds the closest."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from camopt.effects import Case
from camopt.effects.contacts import PLACES
from camopt.effects.peak import Peak
from camopt.effects.peak_columns import peak_column
from camopt.problem.limit import QuantityLimit
from camopt.problem.problem import Problem
from camopt.quantities import QUANTITIES
from camopt.tables.cells import with_unit

ALIKE = 1e-9
"""Relative: two contacts this near to each other are told as one."""


class Tightest(NamedTuple):
    """The contact that is the nearest to a bound, or the furthest beyond it."""

    excess: float
    """Relative."""
    limit: str
    place: str
    words: str


def tightest_contact(problem: Problem) -> str:
    """The contact that the limits of a problem hold the closest, for its own design; empty if there is only one."""
    found = [each for limit in problem.limits if isinstance(limit, QuantityLimit) for each in _of(problem, limit)]
    if not found:
        return ""
    most = max(found)
    others = [each for each in found if each != most and each.limit == most.limit]
    alike = any(abs(each.excess - most.excess) <= ALIKE for each in others)
    place = "both contacts" if alike else f"the {most.place} contact"
    return f"{most.limit} at {place}: {most.words}"


def _of(problem: Problem, limit: QuantityLimit) -> Iterator[Tightest]:
    """The contacts that a limit bounds."""
    if not limit.further or not limit.asked or not isinstance(limit.form, Peak):
        return
    case, quantity = Case(problem.setup, problem.programme, problem.design), QUANTITIES[limit.quantities[0]]
    for place, peak in zip(PLACES, (limit.form, *limit.further), strict=True):
        value = float(np.squeeze(peak_column(case, peak).value))
        excess = quantity.side * (value - limit.bound) / (abs(limit.bound) or 1.0)
        bound = f"{limit.relation} {with_unit(limit.bound, quantity.unit)}"
        yield Tightest(excess, limit.key, place, f"{with_unit(value, quantity.unit)}, {bound}")

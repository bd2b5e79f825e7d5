"""Numbers that searches leave less exact than asked: intervals prove two bounds, as close as rounding lets them.

Next to an undercut a stress is N/R with an R that is nearly 0, and a search for its peak ends with no upper bound.
That a peak is at most a bound is a constraint, which intervals decide: so two bounds are bisected.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite, sqrt

import numpy as np

from camopt.core.numerics.interval import Interval
from camopt.model.effects.peak import Peak
from camopt.model.effects.quantity_expression import column_enclosure, expression_range
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import constraints_on_peak
from camopt.scene.problem.limits import peaks_of_quantity
from camopt.scene.problem.problem import SINGLE_DESIGN_ERROR, Problem
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts.constraint_boxes import constraint_over_box
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, worst_verdict

CERTIFIED_AT_ONCE = 64  # designs at a time: a proof takes some tenths of a second
FURTHEST_SHARE, RANGE_BISECTIONS = 1e9, 60
"""By how much a number may be off, as a share of it, and how often its bounds are bisected at most."""


def certify_numbers(problem: Problem, designs: Designs, rows: DesignRows) -> DesignRows:
    """Rows with numbers as exact as the scene asks, or as can be, if only few designs lack that."""
    asked = problem.accuracy
    half_width = np.broadcast_to(rows.half_width, rows.count)
    open_ = np.flatnonzero(
        ~(half_width <= asked) & problem.setup.mechanism.can_assemble(designs, problem.programme)
    )
    if not 0 < open_.size <= CERTIFIED_AT_ONCE or asked < SINGLE_DESIGN_ERROR:
        return rows
    columns, half_width = dict(rows.columns), half_width.copy()
    for k in open_:
        row = rows.take(np.array([k]))
        proved = _with_own_quantities(
            problem, row, _certified_ranges(*problem.absorb_design_numbers(designs.take([k])), row, asked)
        )
        for name, (low, high) in proved.items():
            if not low <= row.column(name)[0] <= high:
                columns[name] = np.array(np.broadcast_to(columns[name], rows.count))
                columns[name][k] = 0.5 * (low + high)
        if proved:
            others = (_relative_width(row, name) for name in row.outward.keys() - proved.keys())
            half_width[k] = max(*others, *((high - low) / abs(high) for low, high in proved.values()), 0.0)
    return replace(rows, columns=columns, half_width=half_width)


CertifiedRange = tuple[float, float]


def _relative_width(row: DesignRows, name: str) -> float:
    """The width of the enclosure of a quantity of one design, relative to it."""
    width, value = float(np.abs(np.max(row.outward[name]))), abs(float(row.column(name)[0]))
    return width / value if value > 0.0 and isfinite(value) else 0.0


def _with_own_quantities(
    problem: Problem, row: DesignRows, proved: dict[str, CertifiedRange]
) -> dict[str, CertifiedRange]:
    """Proved bounds with those of the scene's own quantities that follow from them."""
    found = dict(proved)
    for name, own in problem.setup.own_quantities.items():
        if name in row.outward and found.keys() & own.reads:
            known = {read: column_enclosure(row.column(read), row.outward.get(read, 0.0)) for read in own.reads}
            known |= {read: Interval(*np.array(found[read])[:, None]) for read in own.reads if read in found}
            made = expression_range(own, known)
            found[name] = float(made.low[0]), float(made.high[0])
    return found


def _certified_ranges(
    problem: Problem, design: Designs, row: DesignRows, asked: float
) -> dict[str, CertifiedRange]:
    """Proved bounds of the quantities of one design that are less exact than asked."""
    found = {}
    for name in row.outward:
        peaks = peaks_of_quantity(name, problem.setup) if _relative_width(row, name) > asked else ()
        value = abs(float(row.column(name)[0]))
        ranges = [_certified_range(problem, peak, design, value, asked) for peak in peaks]  # of each contact
        if len(known := [each for each in ranges if each]) == len(peaks) > 0:
            found[name] = (min if peaks[0].is_least else max)(known)
    return found


def _certified_range(
    problem: Problem, peak: Peak, design: Designs, value: float, asked: float
) -> CertifiedRange | None:
    """Two bounds of a quantity ≥ 0 of a design, as close as asked or as rounding lets them be."""

    def verdict(bound: float) -> str:
        return worst_verdict(
            constraint_over_box(problem, constraint, design, {}).verdict
            for constraint in constraints_on_peak(peak, bound)
        )

    def least_bound(meets: Callable[[str], bool]) -> float:
        """The least bound from which on verdicts meet something, as those of larger bounds do."""
        low, high = value / FURTHEST_SHARE, value * FURTHEST_SHARE
        for _ in range(RANGE_BISECTIONS):
            if high <= low * (1.0 + asked / 4.0):
                break
            middle = sqrt(low * high)
            low, high = (low, middle) if meets(verdict(middle)) else (middle, high)
        return high

    if peak.is_least:
        low, high = least_bound(lambda found: found != HELD), least_bound(lambda found: found == BROKEN)
    else:
        low, high = least_bound(lambda found: found != BROKEN), least_bound(lambda found: found == HELD)
    low /= 1.0 + asked / 4.0
    return (low, high) if value / FURTHEST_SHARE < low < high < value * FURTHEST_SHARE < inf else None

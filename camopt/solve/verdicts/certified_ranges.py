"""Proved bounds of numbers that a search leaves less exact than the scene asks.

Near an undercut the stress divides by a radius of nearly 0, and the search for its peak ends without an upper
bound. A bound on a peak is a constraint, which interval arithmetic decides. So a lower and an upper bound are found
by bisection.
"""

from collections.abc import Callable
from dataclasses import replace
from math import copysign, exp, inf, isfinite, log, sqrt

import numpy as np

from camopt.core.numerics.interval import Interval
from camopt.model.effects.peak import Peak
from camopt.model.effects.quantity_expression import column_enclosure, expression_range
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import constraints_on_peak
from camopt.scene.problem.limits import peaks_of_quantity
from camopt.scene.problem.problem import SINGLE_DESIGN_ERROR, Problem
from camopt.scene.problem.rows import DesignRows
from camopt.solve.verdicts.constraint_boxes import CurveEnclosures, constraint_verdict_over_box
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, worst_verdict

CERTIFIED_AT_ONCE = 64  # most designs at a time: a proof takes some tenths of a second
FURTHEST_SHARE, RANGE_BISECTIONS = 1e9, 60
"""Largest ratio of a bound to the number, and most bisections."""
END_SHARE = 1e-2  # relative error of a proved bound's distance from an undecided one


def certify_inaccurate_quantities(problem: Problem, designs: Designs, rows: DesignRows) -> DesignRows:
    """Rows with proved numbers where the search was less exact than the scene asks, if only few designs need it."""
    accuracy = problem.accuracy
    half_width = np.broadcast_to(rows.half_width, rows.count)
    open_ = np.flatnonzero(
        ~(half_width <= accuracy) & problem.setup.mechanism.can_assemble(designs, problem.programme)
    )
    if not 0 < open_.size <= CERTIFIED_AT_ONCE or accuracy < SINGLE_DESIGN_ERROR:
        return rows
    columns, half_width = dict(rows.columns), half_width.copy()
    for k in open_:
        row = rows.take(np.array([k]))
        proved = _add_ranges_of_own_quantities(
            problem,
            row,
            _certified_ranges_by_quantity(*problem.absorb_design_numbers(designs.take([k])), row, accuracy),
        )
        for name, (low, high) in proved.items():
            if not low <= row.column(name)[0] <= high:
                columns[name] = np.array(np.broadcast_to(columns[name], rows.count))
                columns[name][k] = 0.5 * (low + high)
        if proved:
            others = (_relative_half_width(row, name) for name in row.outward.keys() - proved.keys())
            half_width[k] = max(*others, *((high - low) / abs(high) for low, high in proved.values()), 0.0)
    return replace(rows, columns=columns, half_width=half_width)


CertifiedRange = tuple[float, float]


def _relative_half_width(row: DesignRows, name: str) -> float:
    """Half-width of a quantity's enclosure for one design, relative to the quantity."""
    width, value = float(np.abs(np.max(row.outward[name]))), abs(float(row.column(name)[0]))
    return width / value if value > 0.0 and isfinite(value) else 0.0


def _add_ranges_of_own_quantities(
    problem: Problem, row: DesignRows, proved: dict[str, CertifiedRange]
) -> dict[str, CertifiedRange]:
    """Proved bounds, with those of the scene's own quantities that depend on them."""
    ranges = dict(proved)
    for name, own in problem.setup.own_quantities.items():
        if name in row.outward and ranges.keys() & own.quantities_read:
            values = {
                read: column_enclosure(row.column(read), row.outward.get(read, 0.0)) for read in own.quantities_read
            }
            values |= {
                read: Interval(*np.array(ranges[read])[:, None]) for read in own.quantities_read if read in ranges
            }
            enclosure = expression_range(own, values)
            ranges[name] = float(enclosure.low[0]), float(enclosure.high[0])
    return ranges


def _certified_ranges_by_quantity(
    problem: Problem, design: Designs, row: DesignRows, accuracy: float
) -> dict[str, CertifiedRange]:
    """Proved bounds of one design's quantities that are less exact than ``accuracy``."""
    proved, enclosures = {}, CurveEnclosures()
    for name in row.outward:
        peaks = peaks_of_quantity(name, problem.setup) if _relative_half_width(row, name) > accuracy else ()
        value = abs(float(row.column(name)[0]))
        by_contact = [_certified_range(problem, peak, design, value, accuracy, enclosures) for peak in peaks]
        if len(ranges := [bounds for bounds in by_contact if bounds]) == len(peaks) > 0:
            worst = min if peaks[0].is_least else max
            proved[name] = worst(low for low, _ in ranges), worst(high for _, high in ranges)
    return proved


def _certified_range(
    problem: Problem, peak: Peak, design: Designs, value: float, accuracy: float, enclosures: CurveEnclosures
) -> CertifiedRange | None:
    """Lower and upper bound of a quantity ≥ 0 of a design, as close as ``accuracy`` or rounding allows."""

    def verdict_on_bound(bound: float) -> str:
        return worst_verdict(
            constraint_verdict_over_box(problem, constraint, design, {}, enclosures=enclosures).verdict
            for constraint in constraints_on_peak(peak, bound)
        )

    below, above = (HELD, BROKEN) if peak.is_least else (BROKEN, HELD)
    low, high = value / FURTHEST_SHARE, value * FURTHEST_SHARE
    for _ in range(RANGE_BISECTIONS):
        if high <= low * (1.0 + accuracy / 4.0):
            break
        middle = sqrt(low * high)
        word = verdict_on_bound(middle)
        if word not in {below, above}:
            low = _bisect_to_closest_proved_bound(
                lambda bound: verdict_on_bound(bound) == below, low, middle, accuracy / 4.0
            )
            high = _bisect_to_closest_proved_bound(
                lambda bound: verdict_on_bound(bound) == above, high, middle, accuracy / 4.0
            )
            break
        low, high = (middle, high) if word == below else (low, middle)
    return (low, high) if value / FURTHEST_SHARE < low < high < value * FURTHEST_SHARE < inf else None


def _bisect_to_closest_proved_bound(
    is_proved: Callable[[float], bool], proved: float, undecided: float, least_distance: float
) -> float:
    """Proved bound that is nearly as close to an undecided one as can be.

    The logarithm of their distance is bisected, since the distance may have any size.
    """
    far, near = log(proved / undecided), copysign(least_distance, proved - undecided)
    for _ in range(RANGE_BISECTIONS):
        if far / near <= 1.0 + END_SHARE:
            break
        middle = copysign(sqrt(far * near), far)
        bound = undecided * exp(middle)
        if is_proved(bound):
            far, proved = middle, bound
        else:
            near = middle
    return proved

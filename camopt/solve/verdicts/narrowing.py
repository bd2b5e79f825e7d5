"""Numbers that searches leave less exact than asked: intervals prove two bounds, as close as rounding lets them.

Next to an undercut a stress is N/R with an R that is nearly 0, and a search for its peak ends with no upper bound.
That a peak is at most a bound is a claim, which intervals decide: so two bounds are bisected.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite, sqrt

import numpy as np

from camopt.core.numerics.interval import Interval
from camopt.model.effects.own import enclosure_of, own_range
from camopt.model.effects.peak import Peak
from camopt.model.mechanisms import Designs
from camopt.scene.problem.claims import claims_of
from camopt.scene.problem.limits import peaks_of
from camopt.scene.problem.problem import SINGLE_ERROR, Problem
from camopt.scene.problem.rows import Rows
from camopt.solve.verdicts.claim_boxes import over_box
from camopt.solve.verdicts.words import BROKEN, HELD, worst

PROVED_AT_ONCE = 64  # designs at a time: a proof takes some tenths of a second
FURTHEST, STEPS = 1e9, 60
"""By how much a number may be off, as a share of it, and how often its bounds are bisected at most."""


def narrow(problem: Problem, designs: Designs, rows: Rows) -> Rows:
    """Rows with numbers as exact as the scene asks, or as can be, if only few designs lack that."""
    asked = problem.accuracy
    half_width = np.broadcast_to(rows.half_width, rows.count)
    open_ = np.flatnonzero(~(half_width <= asked) & problem.setup.mechanism.exists(designs, problem.programme))
    if not 0 < open_.size <= PROVED_AT_ONCE or asked < SINGLE_ERROR:
        return rows
    columns, half_width = dict(rows.columns), half_width.copy()
    for k in open_:
        row = rows.take(np.array([k]))
        proved = _with_own(problem, row, _proved(*problem.alone(designs.take([k])), row, asked))
        for name, (low, high) in proved.items():
            if not low <= row.column(name)[0] <= high:
                columns[name] = np.array(np.broadcast_to(columns[name], rows.count))
                columns[name][k] = 0.5 * (low + high)
        if proved:
            others = (_relative(row, name) for name in row.outward.keys() - proved.keys())
            half_width[k] = max(*others, *((high - low) / abs(high) for low, high in proved.values()), 0.0)
    return replace(rows, columns=columns, half_width=half_width)


ProvedRange = tuple[float, float]


def _relative(row: Rows, name: str) -> float:
    """The width of the enclosure of a quantity of one design, relative to it."""
    width, value = float(np.abs(np.max(row.outward[name]))), abs(float(row.column(name)[0]))
    return width / value if value > 0.0 and isfinite(value) else 0.0


def _with_own(problem: Problem, row: Rows, proved: dict[str, ProvedRange]) -> dict[str, ProvedRange]:
    """Proved bounds with those of the scene's own quantities that follow from them."""
    found = dict(proved)
    for name, own in problem.setup.own.items():
        if name in row.outward and found.keys() & own.reads:
            known = {read: enclosure_of(row.column(read), row.outward.get(read, 0.0)) for read in own.reads}
            known |= {read: Interval(*np.array(found[read])[:, None]) for read in own.reads if read in found}
            made = own_range(own, known)
            found[name] = float(made.low[0]), float(made.high[0])
    return found


def _proved(problem: Problem, design: Designs, row: Rows, asked: float) -> dict[str, ProvedRange]:
    """Proved bounds of the quantities of one design that are less exact than asked."""
    found = {}
    for name in row.outward:
        peaks = peaks_of(name, problem.setup) if _relative(row, name) > asked else ()
        value = abs(float(row.column(name)[0]))
        ranges = [_range_of(problem, peak, design, value, asked) for peak in peaks]  # of each contact
        if len(known := [each for each in ranges if each]) == len(peaks) > 0:
            found[name] = (min if peaks[0].is_least else max)(known)
    return found


def _range_of(problem: Problem, peak: Peak, design: Designs, value: float, asked: float) -> ProvedRange | None:
    """Two bounds of a quantity ≥ 0 of a design, as close as asked or as rounding lets them be."""

    def verdict(bound: float) -> str:
        return worst(over_box(problem, claim, design, {}).verdict for claim in claims_of(peak, bound))

    def least(meets: Callable[[str], bool]) -> float:
        """The least bound from which on verdicts meet something, as those of larger bounds do."""
        low, high = value / FURTHEST, value * FURTHEST
        for _ in range(STEPS):
            if high <= low * (1.0 + asked / 4.0):
                break
            middle = sqrt(low * high)
            low, high = (low, middle) if meets(verdict(middle)) else (middle, high)
        return high

    if peak.is_least:
        low, high = least(lambda found: found != HELD), least(lambda found: found == BROKEN)
    else:
        low, high = least(lambda found: found != BROKEN), least(lambda found: found == HELD)
    low /= 1.0 + asked / 4.0
    return (low, high) if value / FURTHEST < low < high < value * FURTHEST < inf else None

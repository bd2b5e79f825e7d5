"""Numbers that are less exact in doubles than asked: ball arithmetic proves two close bounds.

Next to an undercut a stress is N/R with an R that is nearly 0, and rounding alone is more than the error asked.
That a peak is at most a bound is a claim, which balls decide; so is that it is not at most another one. Both bounds
are next to the value that the extreme of its curves has in balls, and what is known of the extreme decides both.
"""

from dataclasses import replace
from math import isfinite

import numpy as np

from camopt.effects.own import enclosure_of, own_range
from camopt.effects.peak import Peak
from camopt.mechanisms import Designs
from camopt.numerics import LEAST
from camopt.numerics.interval import Interval
from camopt.problem.claims import claims_of
from camopt.problem.limits import peaks_of
from camopt.problem.problem import SINGLE_ERROR, Problem
from camopt.problem.rows import Rows
from camopt.verdicts.ball import Ball, as_arb, precisely
from camopt.verdicts.certify import bounded, exact_turn, largest_of, on_arcs
from camopt.verdicts.exact_curve import in_balls
from camopt.verdicts.exact_laws import NoExactForm
from camopt.verdicts.exact_motion import ExactMotion
from camopt.verdicts.words import HELD, UNDECIDED, worst

PROVED_AT_ONCE = 64  # designs at a time: a proof takes some hundredths of a second
CLOSER = (2.0**-4, 2.0**-24, 2.0**-44, 2.0**-64)
"""Shares of the error asked that an extreme is known to, until its quantity is: one beside 0 may take more."""


def narrow(problem: Problem, designs: Designs, rows: Rows) -> Rows:
    """Rows with numbers as exact as the scene asks, if only few designs lack that."""
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


@precisely()
def _proved(problem: Problem, design: Designs, row: Rows, asked: float) -> dict[str, ProvedRange]:
    """Proved bounds of the quantities of one design that are less exact than asked."""
    found, exact = {}, in_balls(design)
    try:
        motion = exact_turn(problem.programme)
    except NoExactForm:
        return {}
    for name in row.outward:
        peaks = peaks_of(name, problem.setup) if _relative(row, name) > asked else ()
        if not peaks or on_arcs(problem, peaks[0].curves[0][0]):
            continue
        ranges = [_range_of(peak, exact, motion, asked) for peak in peaks]  # at each contact: the worst one counts
        if len(known := [each for each in ranges if each]) == len(peaks):
            found[name] = (min if peaks[0].is_least else max)(known)
    return found


def _range_of(peak: Peak, design: Designs, motion: ExactMotion, asked: float) -> ProvedRange | None:
    """Two bounds of a quantity of a design (in balls), as close as asked: found from the extreme, and proved."""
    largest, sign = largest_of(claims_of(peak, 1.0), design, motion), -1.0 if peak.goal == LEAST else 1.0
    for closer in CLOSER:
        found = as_arb(peak.scale.quantity(Ball(largest.within(asked * closer) * sign), design))
        if found.rad() < abs(found) * (asked / 8.0):
            break

    def below(bound: float) -> bool | None:
        """Whether the quantity is at most this, None if that stays open."""
        verdict = worst(bounded(largest, claim, design) for claim in claims_of(peak, bound))
        return None if verdict == UNDECIDED else (verdict == HELD) != peak.is_least

    low, high = sorted(float(found.mid()) * (1.0 + side * asked / 4.0) for side in (-1.0, 1.0))
    return (low, high) if below(low) is False and below(high) is True else None

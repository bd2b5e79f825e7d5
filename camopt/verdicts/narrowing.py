"""Numbers that are less exact in doubles than asked: ball arithmetic proves two close bounds.

Next to an undercut a stress is N/R with an R that is nearly 0, and rounding alone is more than the error asked.
That a peak is at most a bound is a claim, which balls decide; so is that it is not at most another one.
"""

from collections.abc import Callable
from dataclasses import replace
from math import isfinite
from typing import NamedTuple

import numpy as np

from camopt.effects.peak import Peak
from camopt.mechanisms import Designs
from camopt.problem.claims import claims_of
from camopt.problem.limits import peak_of
from camopt.problem.problem import SINGLE_ERROR, Problem
from camopt.problem.rows import Rows
from camopt.verdicts.ball import precisely
from camopt.verdicts.certify import claim_verdicts, exact_turn
from camopt.verdicts.exact_curve import in_balls
from camopt.verdicts.words import BROKEN, HELD, worst

PROVED_AT_ONCE = 64  # designs at a time: a proof takes some hundredths of a second
KERNEL_ERROR = 1e-3  # relative: what kernels are never off by
WIDER = 16.0


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
        proved = _proved(*problem.alone(designs.take([k])), row, asked)
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


@precisely()
def _proved(problem: Problem, design: Designs, row: Rows, asked: float) -> dict[str, ProvedRange]:
    """Proved bounds of the quantities of one design that are less exact than asked."""
    found, exact, motion = {}, in_balls(design), exact_turn(problem.programme)
    for name in row.outward:
        peak = peak_of(name, problem.setup)
        if peak is None or _relative(row, name) <= asked:
            continue

        def decided(bound: float, peak: Peak = peak) -> str:
            claims = claims_of(peak, bound)
            return worst([v for claim in claims for v in claim_verdicts(problem, claim, exact, motion)])

        if (ends := _between(Decided(decided, peak.is_least), float(row.column(name)[0]), asked)) is not None:
            found[name] = ends
    return found


class Decided(NamedTuple):
    """Whether a quantity holds a bound, and whether that is one from below."""

    verdict: Callable[[float], str]
    from_below: bool

    def below(self, bound: float) -> bool | None:
        """Whether the quantity is at most this, None if that stays open."""
        verdict = self.verdict(bound)
        return None if verdict not in (HELD, BROKEN) else (verdict == HELD) != self.from_below


def _between(decided: Decided, value: float, asked: float) -> ProvedRange | None:
    """Two proved bounds of a quantity, as close as asked."""
    apart = 0.25 * asked * abs(value)
    while decided.below(value - apart) is not False or decided.below(value + apart) is not True:
        apart *= WIDER
        if apart > KERNEL_ERROR * abs(value):
            return None
    low, high = value - apart, value + apart
    while high - low > asked * abs(value):
        middle = 0.5 * (low + high)
        below = decided.below(middle)
        if below is None:
            return None
        low, high = (low, middle) if below else (middle, high)
    return low, high

"""What designs have of limits: their excesses and quantities, and which one is the worst."""

from collections.abc import Sequence

import numpy as np

from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem
from camopt.quantities import QUANTITIES
from camopt.verdicts.judging import excesses
from camopt.verdicts.running import columns_for


def limited(problem: Problem, limits: Sequence[Limit], designs: Designs) -> tuple[FloatArray, FloatArray]:
    """The excesses over limits, infinite of what is not assembled, and their quantities; each (limits, designs).

    A limit without a quantity has its excess in the place of one.
    """
    columns = columns_for(problem, limits, designs)
    exists = problem.setup.mechanism.exists(designs, problem.programme)
    excess = np.where(exists, excesses(limits, columns, designs), np.inf)
    values = np.empty(excess.shape)
    for row, limit in enumerate(limits):
        shown = [np.broadcast_to(columns[name], len(designs)) for name in limit.shown] or [excess[row]]
        values[row] = shown[0] if len(shown) == 1 else np.abs(shown).max(axis=0)
    return excess, values


def worst_of(limit: Limit, excess: FloatArray, values: FloatArray) -> int:
    """Which design is the worst by the quantity of a limit (designs,); one that is not assembled before others."""
    outward = QUANTITIES[limit.shown[0]].side * values if limit.shown else excess
    return int(np.argmax(np.where(np.isnan(outward) | np.isposinf(excess), np.inf, outward)))

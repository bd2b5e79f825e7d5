"""What designs have of limits: their excesses and quantities, and which one is the worst."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.effects import Case
from camopt.effects.contacts import changing, some_of, with_designs
from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.problem.limit import Limit, needs_of
from camopt.problem.problem import Problem
from camopt.verdicts.judging import excesses
from camopt.verdicts.running import run_effects

MUCH = 1e6
"""Times a number, or 1: what reads the number has another value then."""


class Limited(NamedTuple):
    """What designs have of limits, each (limits, designs)."""

    excess: FloatArray
    """Infinite of what is not assembled."""
    values: FloatArray
    """The quantity; of a limit without one its excess."""


def limited(problem: Problem, limits: Sequence[Limit], designs: Designs) -> Limited:
    """The excesses of designs over limits, and their quantities."""
    return _of_case(Case(problem.setup, problem.programme, designs), limits)


@dataclass(frozen=True)
class LimitedBy:
    """What designs have of limits with some values of a number; quantities that do not read it are found once."""

    problem: Problem
    limits: Sequence[Limit]
    field: str
    """Of the number."""

    def at(self, designs: Designs, values: Iterable[FloatArray]) -> Iterator[Limited]:
        """For each of the values (n,)."""
        case = self._known(designs)
        for each in values:
            case = with_designs(case, designs.with_values({self.field: each}), self._changed)
            yield _of_case(case, self.limits)

    def _known(self, designs: Designs) -> Case:
        """A case of designs, with what is known of all that are as the one of the problem."""
        nominal = self.problem.design.values
        others = {name: each for name, each in designs.values.items() if name != self.field}
        if all(np.all(each == nominal[name]) for name, each in others.items()):
            return some_of(self._tried, np.zeros(len(designs), dtype=int))
        return Case(self.problem.setup, self.problem.programme, designs)

    @cached_property
    def _changed(self) -> frozenset[str]:
        """The quantities at each contact that read the number."""
        return changing(self._tried)

    @cached_property
    def _tried(self) -> Case:
        """The design of the problem, and with much more of the number, with what contacts have."""
        design = self.problem.design
        (value,) = design.values[self.field]
        both = design.take([0, 0]).with_values({self.field: np.array([value, MUCH * max(value, 1.0)])})
        case = Case(self.problem.setup, self.problem.programme, both)
        run_effects(case, needs_of(self.limits))
        return case


def _of_case(case: Case, limits: Sequence[Limit]) -> Limited:
    columns, designs = run_effects(case, needs_of(limits)).columns, case.designs
    exists = case.setup.mechanism.exists(designs, case.programme)
    excess = np.where(exists, excesses(limits, columns, designs), np.inf)
    values = np.empty(excess.shape)
    for row, limit in enumerate(limits):
        shown = [np.broadcast_to(columns[name], len(designs)) for name in limit.shown] or [excess[row]]
        values[row] = shown[0] if len(shown) == 1 else np.abs(shown).max(axis=0)
    return Limited(excess, values)


def worst_of(limit: Limit, excess: FloatArray, values: FloatArray) -> int:
    """Which design is the worst by the quantity of a limit (designs,); one that is not assembled before others."""
    outward = limit.quantity.side * values if limit.quantity else excess
    return int(np.argmax(np.where(np.isnan(outward) | np.isposinf(excess), np.inf, outward)))

"""The free variables of one cam (sizes, numbers, angles), and the excesses over limits around it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.mechanisms.design import SECOND_SIZE
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import Variable
from camopt.solve.smallest.turns import SegmentAngles
from camopt.solve.verdicts.limit_verdicts import worst_excesses_over_variants

EXCESS_STEP = 1e-6  # step of differences, relative to a variable's scale


def free_train_numbers(problem: Problem) -> list[Variable]:
    """The numbers of the train with a range in ``[search]``."""
    return [number for number in problem.search_space.trains if number.has_range]


class RangeEnd(NamedTuple):
    """An end of a range of ``[search]``: side · (variable − value) ≤ 0."""

    key: str
    value: float
    unit: str
    variable: int
    side: float
    """1 for the end that the variable may not be above, −1 for the other."""

    @property
    def relation(self) -> str:
        return "≤" if self.side > 0.0 else "≥"


@dataclass(frozen=True)
class FreeVariables:
    """The free variables of one cam, the design of a problem.

    Their order: its size and its other sizes (mm), its other numbers (units of the scene), numbers of its train,
    angles (deg).
    """

    problem: Problem
    turns: SegmentAngles
    """The turns that free angles allow."""
    angles: FloatArray
    """The angles of freed segments, deg."""

    @classmethod
    def from_problem(cls, problem: Problem) -> "FreeVariables":
        """The free variables of a problem's design, in the turn of its scene."""
        turns = SegmentAngles(problem, (None, None))
        return cls(problem, turns, turns.scene_angles)

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """The free variables: always the size, others if they have a range in ``[search]``."""
        size, varied = self.problem.variables[0], self.problem.search_space.variables
        designs = [
            each
            for each in varied.values()
            if each.is_searched_continuously and each.field != "size"
            if each.is_size or each.key in self.problem.setup.free
        ]
        return (varied.get("size", size), *designs, *free_train_numbers(self.problem), *self.turns.variables)

    @property
    def design_variables(self) -> tuple[Variable, ...]:
        """The sizes and numbers of the cam itself, without those of its train and angles."""
        return self.variables[
            : len(self.variables) - len(self.turns.freed_segments) - len(free_train_numbers(self.problem))
        ]

    @cached_property
    def values(self) -> FloatArray:
        """The values of the variables for the cam."""
        values = [float(self.problem.design.values[each.field][0]) for each in self.design_variables]
        return np.array(
            [
                *values,
                *(self.problem.setup.given[each.key] for each in free_train_numbers(self.problem)),
                *self.angles,
            ]
        )

    @cached_property
    def scales(self) -> FloatArray:
        """Order of magnitude of each variable, for the prime radius of the cam."""
        return np.array(
            [each.order_of_magnitude(float(self.problem.design.prime_radius[0])) for each in self.variables]
        )

    @cached_property
    def independent_change_directions(self) -> FloatArray:
        """Independent scaled directions of change (variables, directions).

        Changes of angles keep the angles' sum.
        """
        steps, sizes = np.diag(self.scales), len(self.variables) - len(self.turns.freed_segments)
        if not self.turns.freed_segments:
            return steps
        longest = sizes + int(np.argmax(self.values[sizes:]))
        steps[longest, sizes:] -= self.scales[longest]
        return np.delete(steps, longest, axis=1)

    @cached_property
    def indices_of_disc_sizes(self) -> list[int]:
        """The indices of the variables that are sizes of discs; both of a pair, the larger one first."""
        discs = [k for k, variable in enumerate(self.design_variables) if variable.field in ("size", SECOND_SIZE)]
        return sorted(discs, key=lambda k: -float(self.values[k]))

    @property
    def range_ends(self) -> Iterator[RangeEnd]:
        """The ends of the variables' ranges in ``[search]``."""
        for number, each in enumerate(self.variables):
            if each.has_range:
                yield RangeEnd(f"{each.search_key}.start", each.range_ends[0], each.unit, number, -1.0)
                yield RangeEnd(f"{each.search_key}.stop", each.range_ends[1], each.unit, number, 1.0)
            elif each.is_searched:  # a list of the cam's size stands for the range between its ends
                yield RangeEnd(each.search_key, each.range_ends[0], each.unit, number, -1.0)

    def excesses_at_steps(self, limits: Sequence[Limit], steps: FloatArray) -> FloatArray:
        """The relative excesses over limits, (limits, points), at steps along the directions (points, directions).

        A variable within four steps of its lower bound is raised first, so that no step falls below the bound.
        """
        least = np.array([each.least_allowed_value for each in self.variables])
        values = (
            np.maximum(self.values, least + 4.0 * EXCESS_STEP * self.scales)
            + steps @ self.independent_change_directions.T
        )
        excesses = np.empty((len(limits), len(values)))
        motions = values[:, len(self.design_variables) :]
        trains = [each.key for each in free_train_numbers(self.problem)]
        for motion in dict.fromkeys(map(tuple, motions)):
            points = np.flatnonzero((motions == motion).all(axis=1))
            numbers, freed = dict(zip(trains, motion, strict=False)), motion[len(trains) :]
            problem = self.turns.problem_with_angles(np.array(freed)) if freed else self.problem
            problem = problem.with_numbers(numbers) if numbers else problem
            if problem.setup.mechanism.has_no_assembly:
                excesses[:, points] = np.inf
            else:
                varied = {each.field: values[points, number] for number, each in enumerate(self.design_variables)}
                designs = problem.design.take(np.zeros(points.size, dtype=int)).with_values(varied)
                excesses[:, points] = worst_excesses_over_variants(problem, limits, designs)
        return excesses

"""The design space of a sweep: the product of a few axes, indexed and never materialised.

Axes are sizes, and other numbers of the scene: designs bring both.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import inf, prod

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray, IndexArray, IntArray
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.choices import StepRange
from camopt.scene.problem.problem import Problem, missing_variable_mistakes
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import (
    NumberSetting,
    law_choices,
    problem_with_free_numbers,
    problems_by_motion,
    setting_count_mistakes,
)
from camopt.scene.problem.variables import Variable, variation_mistakes

MOST_DESIGNS = 2**63 - 1  # what their numbers can count
MOST_AXIS_VALUES = 10_000_000  # of one axis; a space may have far more designs, it is never materialised
EDGE_OF_SPACE = "edge of the space"
"""In the place of the limits that hold a design, where the space has no smaller cam to compare it with."""

DesignRange = tuple[Problem, int, int]


@dataclass(frozen=True)
class DesignSpace:
    """Motions × numbers of the scene × sizes, with a problem for each motion.

    Designs of a problem are numbered with the cam's radius fastest, and all sizes faster than other numbers.
    """

    problem: Problem
    problems: tuple[Problem, ...]
    """One for each motion, in the order of the laws, and for each setting that is one of problems, these faster."""
    axes: dict[str, FloatArray]
    """The values of other numbers and of sizes, by field of ``Designs``."""

    @property
    def designs_per_problem(self) -> int:
        """Designs of each problem."""
        return prod(values.size for values in self.axes.values())

    def __len__(self) -> int:
        return sum(last - first for _, first, last in self.problem_ranges())

    def problem_ranges(self) -> Iterator[DesignRange]:
        """The problems in order, each with the number of its first design and that after its last."""
        for problem in self.problems:
            yield problem, 0, self.designs_per_problem

    def blocks(self, size: int) -> Iterator[DesignRange]:
        """The space in order, as (problem, first, last) of at most ``size`` designs."""
        for problem, start, stop in self.problem_ranges():
            for first in range(start, stop, size):
                yield problem, first, min(first + size, stop)

    def varied_values(self, index: IntArray) -> dict[str, FloatArray]:
        """The sizes and numbers that vary, of the designs of a problem by number; as ``Designs`` have them."""
        found, rest = dict[str, FloatArray](), index
        for field, values in reversed(self.axes.items()):  # a third of the time of np.unravel_index
            slower = rest // values.size
            found[field], rest = values[rest - slower * values.size], slower
        return {field: found[field] for field in self.axes}

    def next_smaller_size(self, size: float) -> float | None:
        """The next smaller size of the cam; None at the edge of the space."""
        smaller = self.axes.get("size", np.array([]))
        smaller = smaller[smaller < size]
        return float(smaller.max()) if smaller.size else None

    def designs(self, index: IntArray) -> Designs:
        """The designs of a problem by number."""
        return self.designs_with(self.varied_values(index), index.size)

    def designs_with(self, varied: Mapping[str, FloatArray], count: int) -> Designs:
        """So many designs of a problem with some sizes and numbers, by field of ``Designs``."""
        fixed = self.problem.design
        others = {name: value.tobytes() for name, value in fixed.sizes.items() if name not in varied}
        alike = {value: np.full(count, np.frombuffer(value)) for value in set(others.values())}
        return fixed.with_values({name: alike[value] for name, value in others.items()} | dict(varied))

    def designs_of_rows(self, rows: DesignRows) -> Iterator[tuple[Problem, IndexArray, Designs]]:
        """The designs of some rows of a sweep by problem: (problem, numbers of rows, their designs)."""
        fixed, count, varied = self.problem.design, rows.count, self.problem.variables
        brought = [each for each in varied if each.is_size or (each.is_searched and each.varies_by_design)]
        columns = {name: np.broadcast_to(value, (count,)) for name, value in fixed.sizes.items()}
        designs = fixed.with_values(columns | {each.field: rows.column(each.quantity) for each in brought})
        shared = [each for each in self.problem.search_space.numbers if not each.varies_by_design]
        for motion in map(self.problem.with_programme, self._programmes_by_motion.values()):
            rise, fall = (motion.programme.law_names(kind) for kind in (RISE, RETURN))
            here = np.flatnonzero((rows.column("law_rise") == rise) & (rows.column("law_return") == fall))
            for setting, which in _rows_by_setting(
                {v.key: rows.column(v.quantity)[here] for v in shared}, here.size
            ):
                yield motion.with_numbers(setting), here[which], designs.take(here[which])

    @property
    def _programmes_by_motion(self) -> dict[Programme, Programme]:
        """A programme of the problems for each motion that is given, whatever its train."""
        return {each.given_motion: each.programme for each in self.problems}

    def designs_by_setting(self, rows: DesignRows) -> Iterator[tuple[Problem, IndexArray, Designs]]:
        """The same with a problem for each setting, which has the digits of a scene: designs bring no numbers."""
        for problem, index, designs in self.designs_of_rows(rows):
            if not designs.numbers:
                yield problem, index, designs
                continue
            for setting, which in _rows_by_setting(designs.numbers, len(designs)):
                yield problem.with_numbers(setting), index[which], replace(designs.take(which), numbers={})


def _rows_by_setting(columns: Mapping[str, FloatArray], count: int) -> Iterator[tuple[NumberSetting, IndexArray]]:
    """Each combination of values that some columns (count,) have, and the rows that have it."""
    if not columns:
        yield {}, np.arange(count)
        return
    table = np.column_stack([*columns.values()])
    settings, which, counts = np.unique(table, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    for setting, index in zip(settings.tolist(), np.split(order, np.cumsum(counts)[:-1]), strict=False):
        yield dict(zip(columns, setting, strict=False)), index


def grid_space(problem: Problem) -> DesignSpace:
    """The space that a scene's ``[search]`` spans; a range without a step is a mistake here."""
    file, choices = problem.file, problem.search_space
    varied = (*choices.numbers, *choices.sizes)
    mistakes = [m for each in (*choices.sizes, *choices.numbers) for m in _grid_step_mistakes(file, each)]
    mistakes += sweep_mistakes(problem)
    shared = [each for each in varied if not each.varies_by_design]
    settings = prod(each.grid_count for each in shared)
    mistakes += setting_count_mistakes(problem, settings)
    if (count := len(law_choices(problem)) * prod(each.grid_count for each in varied)) > MOST_DESIGNS:
        allowed = f"a space of at most {MOST_DESIGNS:.2g} designs; this one has {count:.2g}"
        mistakes.append(Mistake(file, "search", None, allowed))
    if mistakes:
        raise BadInput(mistakes)
    values = product(*(each.grid_values.tolist() for each in shared))
    combined = [{v.key: x for v, x in zip(shared, each, strict=True)} for each in values]
    free = problem_with_free_numbers(problem)
    return DesignSpace(
        free, problems_by_motion(free, combined), {v.field: v.grid_values for v in varied if v.varies_by_design}
    )


def sweep_mistakes(problem: Problem) -> list[Mistake]:
    """What keeps any space of a problem from being swept: sizes that it does not give, and angles that are free."""
    sized = [each.key for each in problem.variables if each.is_number or each.is_searched]
    return [
        *missing_variable_mistakes(problem, sized),
        *variation_mistakes(problem.file, problem.search_space.angles, "a sweep takes"),
    ]


def _grid_step_mistakes(file: str, variable: Variable) -> Iterator[Mistake]:
    """What keeps a range from being an axis of a grid."""
    key, choice = f"{variable.search_key}.step", variable.choice
    if not isinstance(choice, StepRange):
        return
    if choice.step is None and choice.start != choice.stop:
        yield Mistake(file, key, None, "a step above 0, for a sweep of a grid, or search.samples")
    elif variable.grid_count > MOST_AXIS_VALUES:
        allowed = f"a range of at most {MOST_AXIS_VALUES:,} values; this one has {variable.grid_count:,}"
        yield Mistake(file, key, choice.step, allowed)


def search_boxes(problem: Problem) -> list[SizeBounds]:
    """The boxes to search: every combination of what is listed, with an interval for every range.

    Numbers that designs bring because a tolerance moves them are there as sizes are.
    """
    options = {name: [(float(value[0]), float(value[0]))] for name, value in problem.design.values.items()}
    options["size"] = [(0.0, inf)]
    varied = problem.search_space.variables.values()
    options |= {v.field: v.box_intervals for v in varied if v.is_size or v.key in problem.setup.free}
    return [dict(zip(options, pick, strict=True)) for pick in product(*options.values())]


def describe_listed_values(problem: Problem, bounds: SizeBounds) -> str:
    """What a box has of the variables of which ``[search]`` lists several values, as a user writes them."""
    trains = {
        each.name: problem.setup.given[each.key] for each in problem.search_space.trains if not each.has_range
    }
    listed = trains | {
        each.name: bounds[each.field][0]
        for each in problem.search_space.variables.values()
        if each.field in bounds and each.field != "size" and isinstance(each.choice, tuple)
    }
    return " and ".join(f"{name} = {value:.6g}" for name, value in listed.items())

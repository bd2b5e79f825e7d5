"""The design space of a sweep: the product of a few axes, indexed and never held in memory.

Axes are sizes and other numbers of the scene, both carried by designs.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import inf, prod

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray, IndexArray, IntArray
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.choices import StepRange
from camopt.scene.problem.problem import Problem, missing_variable_mistakes
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import (
    NumberSetting,
    law_pair_by_programme,
    problem_with_searched_numbers_per_design,
    problems_by_motion_and_setting,
    too_many_settings_mistakes,
)
from camopt.scene.problem.variables import Variable, variation_mistakes

MOST_DESIGNS = 2**63 - 1  # largest number of a design
MOST_AXIS_VALUES = (
    10_000_000  # values of one axis; a space may have far more designs, since it is never held in memory
)
EDGE_OF_SPACE = "edge of the space"
"""Stands for the active limits of a design if the space has no smaller cam to compare it with."""

DesignRange = tuple[Problem, int, int]


@dataclass(frozen=True)
class DesignSpace:
    """Motions × numbers of the scene × sizes, with a problem for each motion and setting.

    In the numbering of a problem's designs the cam's radius varies fastest, and sizes faster than other numbers.
    """

    problem: Problem
    problems: tuple[Problem, ...]
    """One for each motion, in the order of the laws, and for each setting; settings vary fastest."""
    axes: dict[str, FloatArray]
    """Values of other numbers and of sizes, by field of ``Designs``."""

    @property
    def designs_per_problem(self) -> int:
        """Number of designs of each problem."""
        return prod(values.size for values in self.axes.values())

    def __len__(self) -> int:
        return sum(last - first for _, first, last in self.design_ranges_by_problem())

    def design_ranges_by_problem(self) -> Iterator[DesignRange]:
        """The problems in order, each with the number of its first design and the number after its last."""
        for problem in self.problems:
            yield problem, 0, self.designs_per_problem

    def blocks(self, size: int) -> Iterator[DesignRange]:
        """The space in order, as (problem, first, last) with at most ``size`` designs each."""
        for problem, start, stop in self.design_ranges_by_problem():
            for first in range(start, stop, size):
                yield problem, first, min(first + size, stop)

    def varied_values(self, index: IntArray) -> dict[str, FloatArray]:
        """The varied sizes and numbers of designs of a problem by number, by field of ``Designs``."""
        columns, rest = dict[str, FloatArray](), index
        for field, values in reversed(self.axes.items()):  # three times as fast as np.unravel_index
            slower = rest // values.size
            columns[field], rest = values[rest - slower * values.size], slower
        return {field: columns[field] for field in self.axes}

    def next_smaller_size(self, size: float) -> float | None:
        """The next smaller size of the cam; None at the edge of the space."""
        smaller = self.axes.get("size", np.array([]))
        smaller = smaller[smaller < size]
        return float(smaller.max()) if smaller.size else None

    def designs(self, index: IntArray) -> Designs:
        """The designs of a problem by number."""
        return self.designs_with_varied_values(self.varied_values(index), index.size)

    def designs_with_varied_values(self, varied: Mapping[str, FloatArray], count: int) -> Designs:
        """``count`` designs of a problem with the varied sizes and numbers, by field of ``Designs``."""
        fixed = self.problem.design
        others = {name: value.tobytes() for name, value in fixed.sizes.items() if name not in varied}
        columns = {
            value: np.full(count, np.frombuffer(value)) for value in set(others.values())
        }  # equal ones shared
        return fixed.with_values({name: columns[value] for name, value in others.items()} | dict(varied))

    def designs_of_rows(self, rows: DesignRows) -> Iterator[tuple[Problem, IndexArray, Designs]]:
        """The designs of rows of a sweep by problem: (problem, numbers of rows, their designs)."""
        fixed, count, varied = self.problem.design, rows.count, self.problem.variables
        carried = [each for each in varied if each.is_size or (each.is_searched and each.varies_by_design)]
        columns = {name: np.broadcast_to(value, (count,)) for name, value in fixed.sizes.items()}
        designs = fixed.with_values(columns | {each.field: rows.column(each.quantity) for each in carried})
        shared = [each for each in self.problem.search_space.numbers if not each.varies_by_design]
        programmes = {each.given_motion: each.programme for each in self.problems}  # with any train
        for motion in map(self.problem.with_programme, programmes.values()):
            rise, fall = (motion.programme.law_names(kind) for kind in (RISE, RETURN))
            here = np.flatnonzero((rows.column("law_rise") == rise) & (rows.column("law_return") == fall))
            for setting, which in _rows_by_setting(
                {v.key: rows.column(v.quantity)[here] for v in shared}, here.size
            ):
                yield motion.with_numbers(setting), here[which], designs.take(here[which])

    def designs_by_setting(self, rows: DesignRows) -> Iterator[tuple[Problem, IndexArray, Designs]]:
        """As ``designs_of_rows``, but with a problem for each setting of all numbers; designs carry only sizes.

        Results then have the same digits as those of a scene with these numbers.
        """
        for problem, index, designs in self.designs_of_rows(rows):
            if not designs.numbers:
                yield problem, index, designs
                continue
            for setting, which in _rows_by_setting(designs.numbers, len(designs)):
                yield problem.with_numbers(setting), index[which], replace(designs.take(which), numbers={})


def _rows_by_setting(columns: Mapping[str, FloatArray], count: int) -> Iterator[tuple[NumberSetting, IndexArray]]:
    """Each combination of values in some columns (count,), with the rows that have it."""
    if not columns:
        yield {}, np.arange(count)
        return
    table = np.column_stack([*columns.values()])
    settings, which, counts = np.unique(table, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    for setting, index in zip(settings.tolist(), np.split(order, np.cumsum(counts)[:-1]), strict=False):
        yield dict(zip(columns, setting, strict=False)), index


def grid_space(problem: Problem) -> DesignSpace:
    """The grid of a scene's ``[search]``; every range needs a step."""
    file, choices = problem.file, problem.search_space
    varied = (*choices.numbers, *choices.sizes)
    mistakes = [m for each in (*choices.sizes, *choices.numbers) for m in _grid_step_mistakes(file, each)]
    mistakes += sweep_mistakes(problem)
    shared = [each for each in varied if not each.varies_by_design]
    mistakes += too_many_settings_mistakes(problem, prod(each.grid_count for each in shared))
    if (count := len(law_pair_by_programme(problem)) * prod(each.grid_count for each in varied)) > MOST_DESIGNS:
        allowed = f"a space of at most {MOST_DESIGNS:.2g} designs; this one has {count:.2g}"
        mistakes.append(Mistake(file, "search", None, allowed))
    if mistakes:
        raise BadInput(mistakes)
    values = product(*(each.grid_values.tolist() for each in shared))
    combined = [{v.key: x for v, x in zip(shared, each, strict=True)} for each in values]
    free = problem_with_searched_numbers_per_design(problem)
    return DesignSpace(
        free,
        problems_by_motion_and_setting(free, combined),
        {v.field: v.grid_values for v in varied if v.varies_by_design},
    )


def sweep_mistakes(problem: Problem) -> list[Mistake]:
    """Mistakes of a scene that no sweep allows: missing sizes, and varied angles of segments."""
    sized = [each.key for each in problem.variables if each.is_scene_number or each.is_searched]
    return [
        *missing_variable_mistakes(problem, sized),
        *variation_mistakes(problem.file, problem.search_space.angles, "a sweep takes"),
    ]


def _grid_step_mistakes(file: str, variable: Variable) -> Iterator[Mistake]:
    """Mistakes of a range as an axis of a grid: no step, or too many values."""
    key, choice = f"{variable.search_key}.step", variable.choice
    if not isinstance(choice, StepRange):
        return
    if choice.step is None and choice.start != choice.stop:
        yield Mistake(file, key, None, "above 0 for a sweep of a grid, unless search.samples is given")
    elif variable.grid_count > MOST_AXIS_VALUES:
        allowed = f"a range of at most {MOST_AXIS_VALUES:,} values; this one has {variable.grid_count:,}"
        yield Mistake(file, key, choice.step, allowed)


def search_boxes(problem: Problem) -> list[SizeBounds]:
    """The boxes to search: every combination of listed values, with an interval for every range.

    Boxes include numbers that designs carry for their tolerances.
    """
    options = {name: [(float(value[0]), float(value[0]))] for name, value in problem.design.values.items()}
    options["size"] = [(0.0, inf)]
    varied = problem.search_space.variables.values()
    options |= {v.field: v.box_intervals for v in varied if v.is_size or v.key in problem.setup.free}
    return [dict(zip(options, pick, strict=True)) for pick in product(*options.values())]


def describe_listed_values(problem: Problem, bounds: SizeBounds) -> str:
    """The values of a box for variables with a list in ``[search]``, as in "rpm = 500 and offset = 3"."""
    trains = {
        each.name: problem.setup.given[each.key] for each in problem.search_space.trains if not each.has_range
    }
    listed = trains | {
        each.name: bounds[each.field][0]
        for each in problem.search_space.variables.values()
        if each.field in bounds and each.field != "size" and isinstance(each.choice, tuple)
    }
    return " and ".join(f"{name} = {value:.6g}" for name, value in listed.items())

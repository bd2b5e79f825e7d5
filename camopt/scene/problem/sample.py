"""A space of random designs, drawn evenly, for more free sizes than a grid can have.

Sobol points fill the space more evenly than a Latin hypercube, which is even along each axis only. Both use a seed,
so that a scene always has the same designs. Sources: Owen, J. Complexity 14 (1998), 466; McKay, Beckman and
Conover, Technometrics 21 (1979), 239.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import cycle, pairwise
from typing import Any

import numpy as np
import scipy

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray, IntArray
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.settings import (
    problem_with_searched_numbers_per_design,
    problems_by_motion_and_setting,
    too_many_settings_mistakes,
)
from camopt.scene.problem.space import DesignRange, DesignSpace, grid_space, sweep_mistakes

NEXT_SIZE_SHARE = 0.01  # share of a cam's size by which the next smaller size is smaller


@dataclass(frozen=True)
class DesignSample(DesignSpace):
    """Motions × designs drawn from ranges and lists of numbers; each motion has the same designs.

    The designs of a problem are consecutive.
    """

    drawn_values: dict[str, FloatArray]
    """Sizes and other numbers of the designs, by field of ``Designs``, each (designs,)."""
    setting_ends: IntArray
    """Number of the design after the last design of each setting, (settings,)."""

    @property
    def designs_per_problem(self) -> int:
        return int(self.setting_ends[-1])

    def design_ranges_by_problem(self) -> Iterator[DesignRange]:
        ends = self.setting_ends.tolist()
        for problem, (first, last) in zip(self.problems, cycle(pairwise([0, *ends])), strict=False):
            yield problem, first, last

    def varied_values(self, index: IntArray) -> dict[str, FloatArray]:
        return {field: values[index] for field, values in self.drawn_values.items()}

    def next_smaller_size(self, size: float) -> float | None:
        return size * (1.0 - NEXT_SIZE_SHARE)


def sweep_space(problem: Problem) -> DesignSpace:
    """The space of a scene's ``[search]``: a sample if it has ``samples``, else a grid.

    Raises
    ------
    BadInput
        As ``grid_space``; for a sample if nothing varies. A sample ignores the steps of ranges.
    """
    choices, file = problem.search_space, problem.file
    if choices.samples is None:
        return grid_space(problem)
    mistakes, varied = sweep_mistakes(problem), (*choices.sizes, *choices.numbers)
    if not varied:
        why = "needs a range or a list for a size or another number in [search]"
        mistakes.append(Mistake(file, "search.samples", choices.samples, why, bare=True))
    if mistakes:
        raise BadInput(mistakes)
    points = SAMPLERS[choices.sampler](len(varied), choices.samples, choices.seed)
    drawn = {each.field: each.values_at_shares(column) for each, column in zip(varied, points.T, strict=True)}
    shared = [each.key for each in varied if not each.varies_by_design]
    settings, which = _distinct_settings([drawn.pop(key) for key in shared], choices.samples)
    if mistakes := too_many_settings_mistakes(problem, len(settings)):
        raise BadInput(mistakes)
    free = problem_with_searched_numbers_per_design(problem)
    problems = problems_by_motion_and_setting(free, [dict(zip(shared, each, strict=True)) for each in settings])
    order = np.argsort(which, kind="stable")
    return DesignSample(free, problems, {}, {k: v[order] for k, v in drawn.items()}, np.cumsum(np.bincount(which)))


def _distinct_settings(columns: list[FloatArray], count: int) -> tuple[list[tuple[float, ...]], IntArray]:
    """The distinct combinations of numbers, and the index of that of each design; without numbers one, empty."""
    if not columns:
        return [()], np.zeros(count, dtype=np.int64)
    settings, which = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    return [*map(tuple, settings.tolist())], which.reshape(-1)


def sobol_points(dimension: int, count: int, seed: int) -> FloatArray:
    """Scrambled Sobol points of the unit cube, (count, axes)."""
    points = scipy.stats.qmc.Sobol(dimension, scramble=True, rng=seed).random_base2(int(np.ceil(np.log2(count))))
    return np.asarray(points[:count])


def _latin_hypercube_points(dimension: int, count: int, seed: int) -> FloatArray:
    return np.asarray(scipy.stats.qmc.LatinHypercube(dimension, rng=seed).random(count))


SAMPLERS: dict[str, Callable[[int, int, int], Any]] = {
    "sobol": sobol_points,
    "latin-hypercube": _latin_hypercube_points,
}
"""Functions for points (count, axes) in [0, 1), by value of ``search.sampler``."""

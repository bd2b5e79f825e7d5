"""A space of evenly drawn random designs, for more free sizes than a grid can have.

Sobol points fill a space more evenly than a Latin hypercube does, which fills each axis by itself. Both are
scrambled with a seed, so that a scene always has the same designs. Sources: Owen, J. Complexity 14 (1998), 466;
McKay, Beckman and Conover, Technometrics 21 (1979), 239.
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
from camopt.scene.problem.settings import freed_of, problems_of, too_many_settings
from camopt.scene.problem.space import DesignRange, Space, space_of, unswept

NEARBY = 0.01  # of a cam's size: how much smaller the next one is said to be


@dataclass(frozen=True)
class Sample(Space):
    """Motions × designs drawn from ranges and lists of numbers, the same designs for each motion.

    Those of one problem stand together.
    """

    drawn: dict[str, FloatArray]
    """The sizes and other numbers of the designs, by field of ``Designs``, each (designs,)."""
    ends: IntArray
    """The number of the design after the last one of each setting of problems, (settings,)."""

    @property
    def designs_each(self) -> int:
        return int(self.ends[-1])

    def parts(self) -> Iterator[DesignRange]:
        ends = self.ends.tolist()
        for problem, (first, last) in zip(self.problems, cycle(pairwise([0, *ends])), strict=False):
            yield problem, first, last

    def values(self, index: IntArray) -> dict[str, FloatArray]:
        return {field: values[index] for field, values in self.drawn.items()}

    def next_smaller(self, size: float) -> float | None:
        return size * (1.0 - NEARBY)


def searched_space(problem: Problem) -> Space:
    """The space of a scene's ``[search]``: a sample if it gives a number of designs, or else the grid.

    Raises
    ------
    BadInput
        As ``space_of``; for a sample if nothing is free. The step of a range does not matter to one.
    """
    choices, file = problem.choices, problem.file
    if choices.samples is None:
        return space_of(problem)
    mistakes, varied = unswept(problem), (*choices.sizes, *choices.numbers)
    if not varied:
        why = "needs a range or a list of some size or other number in [search]"
        mistakes.append(Mistake(file, "search.samples", choices.samples, why, bare=True))
    if mistakes:
        raise BadInput(mistakes)
    points = SAMPLERS[choices.sampler](len(varied), choices.samples, choices.seed)
    drawn = {each.field: each.values_at(column) for each, column in zip(varied, points.T, strict=True)}
    shared = [each.key for each in varied if not each.is_ranged]
    settings, which = _settings([drawn.pop(key) for key in shared], choices.samples)
    if mistakes := too_many_settings(problem, len(settings)):
        raise BadInput(mistakes)
    free = freed_of(problem)
    problems = problems_of(free, [dict(zip(shared, each, strict=True)) for each in settings])
    order = np.argsort(which, kind="stable")
    return Sample(free, problems, {}, {k: v[order] for k, v in drawn.items()}, np.cumsum(np.bincount(which)))


def _settings(columns: list[FloatArray], count: int) -> tuple[list[tuple[float, ...]], IntArray]:
    """The combinations of some numbers, and which of them each design has; without numbers a single, empty one."""
    if not columns:
        return [()], np.zeros(count, dtype=np.int64)
    settings, which = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    return [*map(tuple, settings.tolist())], which.reshape(-1)


def sobol(axes: int, count: int, seed: int) -> FloatArray:
    """Scrambled Sobol points of the unit cube, (count, axes)."""
    points = scipy.stats.qmc.Sobol(axes, scramble=True, rng=seed).random_base2(int(np.ceil(np.log2(count))))
    return np.asarray(points[:count])


def _latin_hypercube(axes: int, count: int, seed: int) -> FloatArray:
    return np.asarray(scipy.stats.qmc.LatinHypercube(axes, rng=seed).random(count))


SAMPLERS: dict[str, Callable[[int, int, int], Any]] = {"sobol": sobol, "latin-hypercube": _latin_hypercube}
"""Points (count, axes) in [0, 1), by the word in ``[search]`` that asks for them."""

"""The design space of a sweep: the product of a few axes, indexed and never materialised.

Axes are sizes, and other numbers of the scene: designs bring both.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import floor, inf, prod

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms import FIELDS, SIZE_FIELDS, Designs
from camopt.mechanisms.design import SizeBounds
from camopt.mistakes import BadInput, Mistake
from camopt.motion.table import RETURN, RISE
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem, missing_sizes
from camopt.problem.rows import Rows
from camopt.problem.settings import OF_PROBLEM, freed_angles, freed_of, laws_of, problems_of, too_many_settings
from camopt.scene.choices import Chosen, StepRange

MOST_DESIGNS = 2**63 - 1  # what their numbers can count
MOST_VALUES = 10_000_000  # of one axis; a space may have far more designs, it is never materialised


Block = tuple[Problem, int, int]


@dataclass(frozen=True)
class Space:
    """Motions × numbers of the scene × sizes, with a problem for each motion.

    Designs of a problem are numbered with the cam's radius fastest, and all sizes faster than other numbers.
    """

    problem: Problem
    problems: tuple[Problem, ...]
    """One for each motion, in the order of the laws, and for each setting that is one of problems, these faster."""
    axes: dict[str, FloatArray]
    """The values of other numbers by key of the scene, and of sizes by key of ``[search]``."""

    @property
    def designs_each(self) -> int:
        """Designs of each problem."""
        return prod(values.size for values in self.axes.values())

    def __len__(self) -> int:
        return sum(last - first for _, first, last in self.parts())

    def parts(self) -> Iterator[Block]:
        """The problems in order, each with the number of its first design and that after its last."""
        for problem in self.problems:
            yield problem, 0, self.designs_each

    def blocks(self, size: int) -> Iterator[Block]:
        """The space in order, as (problem, first, last) of at most ``size`` designs."""
        for problem, start, stop in self.parts():
            for first in range(start, stop, size):
                yield problem, first, min(first + size, stop)

    def values(self, index: NDArray[np.int64]) -> dict[str, FloatArray]:
        """The sizes and numbers that vary, of the designs of a problem by number; as ``Designs`` have them."""
        shape = tuple(values.size for values in self.axes.values())
        where = np.unravel_index(index, shape) if shape else ()
        return {field_of(key): values[i] for (key, values), i in zip(self.axes.items(), where, strict=True)}

    def check_apart(self) -> None:
        """Whether settings can be taken one by one: a BadInput if there are too many."""
        counts = (values.size for key, values in self.axes.items() if key not in FIELDS)
        if mistakes := too_many_settings(self.problem, prod(counts)):
            raise BadInput(mistakes)

    def apart(self) -> "Space":
        """The same space with a problem for each setting, for searches that take them one by one."""
        numbers = {key: values.tolist() for key, values in self.axes.items() if key not in FIELDS}
        if not numbers:
            return self
        settings = [dict(zip(numbers, each, strict=True)) for each in product(*numbers.values())]
        problems = tuple(problem.with_numbers(setting) for problem in self.problems for setting in settings)
        return replace(self, problems=problems, axes={k: v for k, v in self.axes.items() if k in FIELDS})

    def next_smaller(self, size: float) -> float | None:
        """The next smaller size of the cam; None at the edge of the space."""
        smaller = self.axes.get(self.problem.setup.mechanism.body.size, np.array([]))
        smaller = smaller[smaller < size]
        return float(smaller.max()) if smaller.size else None

    def designs(self, index: NDArray[np.int64]) -> Designs:
        """The designs of a problem by number."""
        varied, fixed = self.values(index), self.problem.design
        columns = {n: np.broadcast_to(v, index.shape) for n, v in fixed.sizes.items()} | varied
        return fixed.with_values({n: np.ascontiguousarray(v) for n, v in columns.items()})

    def designs_of(self, rows: Rows) -> Iterator[tuple[Problem, NDArray[np.int64], Designs]]:
        """The designs of some rows of a sweep by motion and setting: (problem, numbers of rows, their designs)."""
        fixed = self.problem.design
        named = {name: rows.column(f"{name}_mm") for name in SIZE_FIELDS if f"{name}_mm" in rows.columns}
        named["size"] = rows.column(self.problem.size_name)
        columns = {
            name: np.asarray(named.get(name, value + np.zeros(rows.count))) for name, value in fixed.sizes.items()
        }
        rise, fall, numbers = rows.column("law_rise"), rows.column("law_return"), self.problem.numbers
        settings = np.column_stack([rows.column(name) for name in numbers.values()] or [np.zeros(rows.count)])
        kinds, which = np.unique(settings, axis=0, return_inverse=True)
        for motion in problems_of(self.problem):
            programme = motion.programme
            index = np.flatnonzero((rise == programme.law_names(RISE)) & (fall == programme.law_names(RETURN)))
            kind = which.reshape(-1)[index]
            order = np.argsort(kind, kind="stable")
            for some in np.split(index[order], np.flatnonzero(np.diff(kind[order])) + 1) if index.size else ():
                values = kinds[which.reshape(-1)[some[0]]].tolist()
                problem = motion.with_numbers(dict(zip(numbers, values, strict=False)))
                yield problem, some, fixed.with_values(columns).take(some)


def space_of(problem: Problem) -> Space:
    """The space that a scene's ``[search]`` spans; a range without a step is a mistake here."""
    file, sizes, numbers = problem.file, problem.choices.sizes, problem.choices.numbers
    mistakes = [m for key, choice in {**sizes, **numbers}.items() for m in _ungridded(file, key, choice)]
    mistakes += [*missing_sizes(problem, sizes), *freed_angles(problem, "a sweep takes")]
    choices = {**numbers, **sizes}
    of_problem = {key: choices.pop(key) for key in numbers if key in OF_PROBLEM}
    settings = prod(map(value_count, of_problem.values()))
    mistakes += too_many_settings(problem, settings)
    if (count := len(laws_of(problem)) * settings * prod(map(value_count, choices.values()))) > MOST_DESIGNS:
        allowed = f"a space of at most {MOST_DESIGNS:.2g} designs; this one has {count:.2g}"
        mistakes.append(Mistake(file, "search", None, allowed))
    if mistakes:
        raise BadInput(mistakes)
    values = [number_values(choice) for choice in of_problem.values()]
    combined = [dict(zip(of_problem, each, strict=True)) for each in product(*values)]
    axes = {k: axis_values(c) if k in FIELDS else np.array(number_values(c)) for k, c in choices.items()}
    free = freed_of(problem)
    return Space(free, problems_of(free, combined), axes)


def field_of(key: str) -> str:
    """How ``Designs`` name a size or another number, by its key of ``[search]``."""
    return FIELDS.get(key, key)


def _ungridded(file: str, key: str, choice: Chosen) -> Iterator[Mistake]:
    """What keeps a range from being an axis of a grid."""
    if isinstance(choice, StepRange) and choice.step is None and choice.start != choice.stop:
        allowed = "a step above 0, for a sweep of a grid, or search.samples"
        yield Mistake(file, f"search.{key}.step", None, allowed)
    elif isinstance(choice, StepRange) and value_count(choice) > MOST_VALUES:
        allowed = f"a range of at most {MOST_VALUES:,} values; this one has {value_count(choice):,}"
        yield Mistake(file, f"search.{key}.step", choice.step, allowed)


def number_values(choice: Chosen) -> list[float]:
    """The values of a list or range of a number; rounding takes none beyond the end of the range."""
    values = axis_values(choice)
    return [*map(float, np.minimum(values, choice.stop) if isinstance(choice, StepRange) else values)]


def boxes_of(problem: Problem) -> list[SizeBounds]:
    """The boxes to search: every combination of what is listed, with an interval for every range."""
    options = {name: [(float(value[0]), float(value[0]))] for name, value in problem.design.sizes.items()}
    options["size"] = [(0.0, inf)]
    numbers = {key: choice for key, choice in problem.choices.numbers.items() if key in problem.setup.free}
    for key, choice in {**problem.choices.sizes, **numbers}.items():
        field = field_of(key)
        if isinstance(choice, StepRange):
            options[field] = [(choice.start, choice.stop)]
        elif key == problem.setup.mechanism.body.size:
            options[field] = [(float(min(choice)), float(max(choice)))]
        else:
            options[field] = [(float(v), float(v)) for v in axis_values(choice)]
    return [dict(zip(options, pick, strict=True)) for pick in product(*options.values())]


def choices(problem: Problem, bounds: SizeBounds) -> str:
    """What a box has of the sizes of which ``[search]`` lists several, as a user writes them."""
    chosen = {**problem.choices.sizes, **problem.choices.numbers}
    listed = {
        key: bounds[field_of(key)][0]
        for key, choice in chosen.items()
        if field_of(key) in bounds and field_of(key) != "size" and isinstance(choice, tuple)
    }
    return " and ".join(f"{key} = {value:.6g}" for key, value in listed.items())


def axis_values(choice: Chosen) -> FloatArray:
    """The values of a list, or of a range with both its ends (the last step may fall short)."""
    if not isinstance(choice, StepRange):
        return np.array(list(dict.fromkeys(choice)), dtype=float)
    if choice.step is None:
        return np.array([choice.start])
    return np.asarray(choice.start + choice.step * np.arange(value_count(choice)), dtype=float)


def value_count(choice: Chosen) -> int:
    """How many values a list or range has."""
    if not isinstance(choice, StepRange):
        return len(set(choice))
    return 1 + (floor((choice.stop - choice.start) / choice.step + 1e-9) if choice.step else 0)

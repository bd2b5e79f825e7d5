"""The design space of a sweep: the product of a few axes, indexed and never materialised."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import floor, inf, prod

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms import FIELDS, SIZES, Designs
from camopt.mechanisms.design import Bounds
from camopt.mistakes import BadInput, Mistake
from camopt.motion.programme import Programme
from camopt.motion.table import RETURN, RISE
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem, missing_sizes
from camopt.problem.rows import Rows
from camopt.scene.tables import Range

MOST_DESIGNS = 2**63 - 1  # what their numbers can count
MOST_VALUES = 10_000_000  # of one axis; a space may have far more designs, it is never materialised


Block = tuple[Problem, int, int]


@dataclass(frozen=True)
class Space:
    """Motions × sizes. Designs are numbered with the motion slowest and the cam's radius fastest."""

    problem: Problem
    problems: tuple[Problem, ...]
    """One for each motion, in the order of the laws."""
    axes: dict[str, FloatArray]

    @property
    def designs_each(self) -> int:
        """Designs for each motion."""
        return prod(values.size for values in self.axes.values())

    def __len__(self) -> int:
        return len(self.problems) * self.designs_each

    def blocks(self, size: int) -> Iterator[Block]:
        """The space in order, as (problem, first, last) of at most ``size`` designs of one motion."""
        for problem in self.problems:
            for first in range(0, self.designs_each, size):
                yield problem, first, min(first + size, self.designs_each)

    def sizes(self, index: NDArray[np.int64]) -> dict[str, FloatArray]:
        """The sizes that vary, of the designs of a motion by number."""
        shape = tuple(values.size for values in self.axes.values())
        where = np.unravel_index(index, shape) if shape else ()
        return {FIELDS[key]: values[i] for (key, values), i in zip(self.axes.items(), where, strict=True)}

    def next_smaller(self, size: float) -> float | None:
        """The next smaller size of the cam; None at the edge of the space."""
        key = "mean_radius" if self.problem.setup.mechanism.grooved else "base_radius"
        smaller = self.axes.get(key, np.array([]))
        smaller = smaller[smaller < size]
        return float(smaller.max()) if smaller.size else None

    def designs(self, index: NDArray[np.int64]) -> Designs:
        """The designs of a motion by number."""
        sizes, fixed = self.sizes(index), self.problem.design.sizes
        columns = {n: sizes.get(n, np.broadcast_to(v, index.shape)) for n, v in fixed.items()}
        arrays = {n: np.ascontiguousarray(v) for n, v in columns.items()}
        return Designs(**arrays, sense=self.problem.design.sense)

    def designs_of(self, rows: Rows) -> Iterator[tuple[Problem, NDArray[np.int64], Designs]]:
        """The designs of some rows of a sweep, by motion: (problem, the rows' numbers, their designs)."""
        fixed = self.problem.design
        named = {name: rows.column(f"{name}_mm") for name in SIZES if f"{name}_mm" in rows.columns}
        named["size"] = rows.column(self.problem.size_name)
        columns = {
            name: np.asarray(named.get(name, value + np.zeros(rows.count))) for name, value in fixed.sizes.items()
        }
        rise, fall = rows.column("law_rise"), rows.column("law_return")
        for problem in self.problems:
            programme = problem.programme
            index = np.flatnonzero((rise == programme.law_names(RISE)) & (fall == programme.law_names(RETURN)))
            if index.size:
                yield problem, index, Designs(**columns, sense=fixed.sense).take(index)


def laws_of(problem: Problem) -> dict[Programme, tuple[str | None, str | None]]:
    """The scene's programme under every choice of laws in ``[search]``, and the laws on its rises and returns."""
    search = problem.scene.search
    if search.law:
        pairs: list[tuple[str | None, str | None]] = [(law, law) for law in search.law]
    else:
        pairs = list(product(search.law_rise or (None,), search.law_return or (None,)))
    return {problem.with_laws(*pair): pair for pair in pairs}


def problems_of(problem: Problem) -> tuple[Problem, ...]:
    """The problem under every choice of laws in ``[search]``."""
    return tuple(problem.with_programme(programme) for programme in laws_of(problem))


def space_of(problem: Problem) -> Space:
    """The space that a scene's ``[search]`` spans; a range without a step is a mistake here."""
    file, mistakes = problem.scene.file, []
    axes = {}
    for key in FIELDS:
        choice = getattr(problem.scene.search, key)
        if choice is None:
            continue
        if isinstance(choice, Range) and choice.step is None and choice.start != choice.stop:
            allowed = "a step above 0, for a sweep of a grid, or search.samples"
            mistakes.append(Mistake(file, f"search.{key}.step", None, allowed))
            continue
        if value_count(choice) > MOST_VALUES:
            allowed = f"a range of at most {MOST_VALUES:,} values; this one has {value_count(choice):,}"
            mistakes.append(Mistake(file, f"search.{key}.step", choice.step, allowed))
            continue
        axes[key] = axis_values(choice)
    mistakes += [*missing_sizes(problem, axes), *freed_angles(problem, "a sweep takes")]
    problems = problems_of(problem)
    count = len(problems) * prod(values.size for values in axes.values())
    if count > MOST_DESIGNS:
        allowed = f"a space of at most {MOST_DESIGNS:.2g} designs; this one has {count:.2g}"
        mistakes.append(Mistake(file, "search", None, allowed))
    if mistakes:
        raise BadInput(mistakes)
    return Space(problem, problems, axes)


def freed_angles(problem: Problem, who: str) -> list[Mistake]:
    """A mistake for each kind of segment that ``[search]`` frees, for those that take angles as they are."""
    search, what = problem.scene.search, f"{who} the angles of the scene; only optimise can vary them"
    freed = [kind for kind in ("rise", "return", "dwell") if search.angle_of(kind) is not None]
    return [Mistake(problem.scene.file, f"search.angle_{kind}", None, what, bare=True) for kind in freed]


def boxes_of(problem: Problem) -> list[Bounds]:
    """The boxes to search: every combination of listed sizes, with an interval for every range."""
    scene, fixed = problem.scene, problem.design
    cam = scene.cam.form
    size_key = "base_radius" if cam == "disc" else "mean_radius"
    options = {name: [(float(value[0]), float(value[0]))] for name, value in fixed.sizes.items()}
    options["size"] = [(0.0, inf)]
    for key, field in FIELDS.items():
        choice = getattr(scene.search, key)
        if choice is None:
            continue
        if isinstance(choice, Range):
            options[field] = [(choice.start, choice.stop)]
        elif key == size_key:
            options[field] = [(float(min(choice)), float(max(choice)))]
        else:
            options[field] = [(float(v), float(v)) for v in axis_values(choice)]
    return [dict(zip(options, pick, strict=True)) for pick in product(*options.values())]


def choices(problem: Problem, bounds: Bounds) -> str:
    """What a box has of the sizes of which ``[search]`` lists several, as a user writes them."""
    search = problem.scene.search
    listed = {
        key: bounds[field][0]
        for key, field in FIELDS.items()
        if field != "size" and isinstance(getattr(search, key), tuple)
    }
    return " and ".join(f"{key} = {value:.6g}" for key, value in listed.items())


def axis_values(choice: Range | tuple[float, ...]) -> FloatArray:
    """The values of a list, or of a range with both its ends (the last step may fall short)."""
    if not isinstance(choice, Range):
        return np.array(list(dict.fromkeys(choice)), dtype=float)
    if choice.step is None:
        return np.array([choice.start])
    return np.asarray(choice.start + choice.step * np.arange(value_count(choice)), dtype=float)


def value_count(choice: Range | tuple[float, ...]) -> int:
    """How many values a list or range has."""
    if not isinstance(choice, Range):
        return len(set(choice))
    return 1 + (floor((choice.stop - choice.start) / choice.step + 1e-9) if choice.step else 0)

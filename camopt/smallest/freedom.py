"""The free variables of one cam, sizes and angles, and the excesses over limits around it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from camopt.effects import Case
from camopt.mechanisms import FIELDS
from camopt.numerics import FloatArray
from camopt.problem.limit import Limit
from camopt.problem.problem import Problem
from camopt.quantities import QUANTITIES
from camopt.scene.choices import StepRange
from camopt.smallest.turns import SegmentAngles
from camopt.verdicts.judging import excesses, run_effects

DELTA = 1e-6  # of a scale: differences are taken over it
MAY_BE_NEGATIVE = ("offset", "face_offset")


class End(NamedTuple):
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
class Freedom:
    """The free variables of the cam that a problem's design is.

    Its size first, other sizes (mm), other numbers that it brings (in the units of the scene), angles (deg).
    """

    problem: Problem
    turns: SegmentAngles
    """The turns that free angles allow."""
    angles: FloatArray
    """Those of freed segments."""

    @classmethod
    def of(cls, problem: Problem) -> "Freedom":
        """The freedom of a problem's design, in the turn of its scene."""
        turns = SegmentAngles(problem, (None, None))
        return cls(problem, turns, turns.scene_angles)

    @cached_property
    def keys(self) -> dict[str, str]:
        """The keys of free sizes and numbers in ``[search]``, as Designs name them; the size is always free."""
        sizes = self.problem.choices.sizes
        ranges = {FIELDS[key]: key for key, choice in sizes.items() if isinstance(choice, StepRange)}
        return {"size": self.problem.size_name.removesuffix("_mm"), **ranges, **{key: key for key in self.numbers}}

    @property
    def numbers(self) -> dict[str, StepRange]:
        """The ranges of free numbers by key."""
        chosen = self.problem.choices.numbers
        return {k: c for k, c in chosen.items() if k in self.problem.setup.free and isinstance(c, StepRange)}

    @cached_property
    def at(self) -> FloatArray:
        """The variables of the cam."""
        values = [float(self.problem.design.values[field][0]) for field in self.keys]
        return np.array([*values, *self.angles])

    @cached_property
    def scales(self) -> FloatArray:
        """Their orders: the prime radius, the degrees that free segments share, an end of the range of a number."""
        prime, total = float(self.problem.design.prime_radius[0]), self.angles.sum()
        ends = {key: max(abs(choice.start), abs(choice.stop)) for key, choice in self.numbers.items()}
        return np.array([*(ends.get(field, prime) for field in self.keys), *[total] * len(self.turns.freed)])

    @cached_property
    def directions(self) -> FloatArray:
        """Along which the variables may change, scaled, (variables, directions): angles keep their sum."""
        steps, sizes = np.diag(self.scales), len(self.keys)
        if not self.turns.freed:
            return steps
        longest = sizes + int(np.argmax(self.at[sizes:]))
        steps[longest, sizes:] -= self.scales[longest]
        return np.delete(steps, longest, axis=1)

    @property
    def ends(self) -> Iterator[End]:
        """The ends of the ranges that ``[search]`` gives to the variables."""
        choices, segments = self.problem.choices, self.turns.segments
        for number, key in enumerate(self.keys.values()):
            name = self.problem.numbers.get(key)
            choice, unit = (self.numbers[key], QUANTITIES[name].unit) if name else (choices.sizes.get(key), "mm")
            yield from _ends(f"search.{key}", choice, unit, number)
        for number, segment in enumerate(self.turns.freed, start=len(self.keys)):
            kind = segments[segment].segment
            yield from _ends(f"search.angle_{kind}", choices.angles[kind], "deg", number)

    def excesses(self, limits: Sequence[Limit], steps: FloatArray) -> FloatArray:
        """The relative excesses over limits, (limits, points), at steps along the directions (points, directions).

        Lengths and angles that would be below 0 within two steps are moved up before.
        """
        least = np.where([f in MAY_BE_NEGATIVE for f in self.keys] + [False] * len(self.turns.freed), -inf, 4.0)
        values = np.maximum(self.at, least * DELTA * self.scales) + steps @ self.directions.T
        found = np.empty((len(limits), len(values)))
        angles = values[:, len(self.keys) :]
        for freed in dict.fromkeys(map(tuple, angles)):
            some = np.flatnonzero((angles == freed).all(axis=1))
            problem = self.turns.problem_of(np.array(freed)) if freed else self.problem
            varied = {field: values[some, number] for number, field in enumerate(self.keys)}
            designs = problem.design.take(np.zeros(some.size, dtype=int)).with_values(varied)
            needs = [name for limit in limits for name in limit.needs]
            columns = run_effects(Case(problem.setup, problem.programme, designs), needs).columns
            found[:, some] = excesses(limits, columns, designs)
        return found


def _ends(key: str, choice: StepRange | tuple[float, ...] | None, unit: str, variable: int) -> Iterator[End]:
    """The ends of one choice; a list of the cam's own sizes stands for all between them."""
    if isinstance(choice, StepRange):
        yield End(f"{key}.start", choice.start, unit, variable, -1.0)
        yield End(f"{key}.stop", choice.stop, unit, variable, 1.0)
    elif choice is not None:
        yield End(key, min(choice), unit, variable, -1.0)

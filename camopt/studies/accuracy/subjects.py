"""What is computed: the quantities that a designer acts on, and the designs to compute them of."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.problem.problem import Problem
from camopt.problem.sample import searched_space

DESIGNS = 4096
REFERENCED = 24  # designs with a reference in balls


@dataclass(frozen=True)
class Subject:
    """One quantity to compute: its curve, the questions it asks, and the answer a designer reads."""

    name: str
    make: Callable[[Designs, Programme], Any]
    questions: Any
    answer: Callable[[FloatArray], FloatArray]

    @property
    def sign(self) -> float:
        """+1 for an answer that a limit bounds from above, −1 from below."""
        return -1.0 if self.questions[0, 1] == LEAST else 1.0

    def excess(self, value: FloatArray, outward: FloatArray, limit: FloatArray) -> FloatArray:
        """By how much the answer is beyond a limit if the extremes are off by ``outward``; held where ≤ 0."""
        return np.asarray(self.sign * (self.answer(value + self.sign * outward) - limit))


def subjects_of(problem: Problem) -> list[Subject]:
    """Pressure angle, and curvature of pitch curve or profile."""
    mechanism = problem.setup.mechanism
    kinds = [kind for kind in (RISE, RETURN, DWELL) if problem.programme.has(kind)]
    strokes, turn = np.array([(kind, LARGEST_MAGNITUDE) for kind in kinds]), TURN

    def angle(tangents: FloatArray) -> FloatArray:
        return np.asarray(np.degrees(np.arctan(tangents.max(axis=0))))

    def only(values: FloatArray) -> FloatArray:
        return np.asarray(values[0])

    found = [Subject("pressure angle", mechanism.pressure, strokes, angle)]
    if mechanism.curvature:
        goal = LARGEST_MAGNITUDE if mechanism.two_sided else LARGEST
        found.append(Subject("curvature", mechanism.curvature, np.array([(turn, goal)]), only))
    elif mechanism.profile_radius:
        found.append(Subject("radius of curvature", mechanism.profile_radius, np.array([(turn, LEAST)]), only))
    return found


def designs_of(problem: Problem, seed: int = 0) -> Designs:
    """Designs of the scene's space at random; without a space, its own design with sizes varied a little."""
    rng, space = np.random.default_rng(seed), searched_space(problem)
    count = 4 * DESIGNS  # some cannot be put together
    if space.designs_each >= REFERENCED:
        designs = space.designs(rng.integers(0, space.designs_each, count))
    else:
        share = {name: rng.uniform(0.9, 1.3, count) for name in ("size", "roller_radius", "offset")}
        plain = problem.design.sizes.items()
        sizes = {name: value * share.get(name, np.ones(count)) for name, value in plain}
        designs = problem.design.with_values(sizes)
    return designs.take(problem.setup.mechanism.exists(designs, problem.programme)).take(slice(DESIGNS))

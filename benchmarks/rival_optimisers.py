"""What an engineer would reach for: general optimisers on a sampled turn. Nothing of camopt is used."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from rival_numpy import Array
from scipy import optimize

ANGLES = 720  # samples of the turn


class Effort(NamedTuple):
    """How long the rivals may search."""

    starts: int
    """Of SLSQP."""
    points: int
    """Of SHGO, in each of its rounds."""
    rounds: int
    generations: int
    """Of differential evolution."""
    populations: int
    """Generations of NSGA-II."""


FULL = Effort(starts=16, points=256, rounds=3, generations=300, populations=200)
SHORT = Effort(starts=2, points=32, rounds=1, generations=10, populations=10)  # where nothing is measured


@dataclass(frozen=True)
class Problem:
    """Make x[0], the size, small within bounds; ``usage`` (x, samples) is how far limits are used, at most 1."""

    bounds: tuple[tuple[float, float], ...]
    usage: Callable[[Array, int], Array]

    def room(self, x: Array) -> Array:
        """At least 0 where the limits hold, at every sample."""
        return 1.0 - np.nan_to_num(self.usage(np.asarray(x), ANGLES), nan=1e3, posinf=1e3)

    def least_room(self, x: Array) -> float:
        return float(self.room(x).min())

    def excess(self, x: Array) -> float:
        """By how much, relatively, a cam breaks its limits on a dense turn."""
        return float(np.max(self.usage(np.asarray(x), 200_000))) - 1.0


def by_slsqp(problem: Problem, effort: Effort) -> Array:
    """Sequential quadratic programming with a constraint at every sample, from many starts."""
    rng, found = np.random.default_rng(1), []
    low, high = np.transpose(problem.bounds)
    for start in rng.uniform(low, high, (effort.starts, len(low))):
        result = optimize.minimize(
            lambda x: x[0],
            start,
            bounds=problem.bounds,
            constraints={"type": "ineq", "fun": problem.room},
            method="SLSQP",
            options={"ftol": 1e-10, "maxiter": 300},
        )
        if problem.least_room(result.x) >= -1e-6:
            found.append(result.x)
    return min(found, key=lambda x: float(x[0]), default=np.array(high))


def by_differential_evolution(problem: Problem, effort: Effort) -> Array:
    held = optimize.NonlinearConstraint(problem.least_room, 0.0, np.inf)
    result = optimize.differential_evolution(
        lambda x: x[0], problem.bounds, constraints=held, rng=1, tol=1e-10, maxiter=effort.generations, polish=False
    )
    return np.asarray(result.x)


def by_shgo(problem: Problem, effort: Effort) -> Array:
    constraint = {"type": "ineq", "fun": problem.least_room}
    result = optimize.shgo(
        lambda x: x[0],
        problem.bounds,
        constraints=constraint,
        n=effort.points,
        iters=effort.rounds,
        sampling_method="sobol",
    )
    return np.asarray(result.x) if result.x is not None else np.array([b for _, b in problem.bounds])


def by_nsga2(problem: Problem, effort: Effort) -> Array:
    """pymoo's NSGA-II with the size as its one objective."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    low, high = map(np.array, zip(*problem.bounds, strict=True))

    class Sized(ElementwiseProblem):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(n_var=low.size, n_obj=1, n_ieq_constr=1, xl=low, xu=high)

        def _evaluate(self, x: Array, out: dict[str, float], *args: object, **kwargs: object) -> None:
            out["F"], out["G"] = x[0], -problem.least_room(x)

    result = minimize(Sized(), NSGA2(pop_size=60), ("n_gen", effort.populations), seed=1)
    return np.array(high) if result.X is None else np.atleast_2d(result.X)[0]


Rival = Callable[[Problem, Effort], Array]


def quietly(rival: Rival, problem: Problem, effort: Effort) -> Array:
    """A rival's answer without its warnings."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return rival(problem, effort)


RIVALS: dict[str, Rival] = {
    "slsqp": by_slsqp,
    "differential_evolution": by_differential_evolution,
    "shgo": by_shgo,
    "nsga2": by_nsga2,
}

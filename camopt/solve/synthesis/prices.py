"""The price of each bound that free laws hold: multipliers of the convex programme.

At the optimum x of a programme, with multipliers λ of its constraints c ≤ 0 and c = 0, the least objective f
changes with a bound b as the Lagrangian does, df/db = ∂(f + Σ λ·c)/∂b at the same x and λ (envelope theorem). The
derivatives by b are central differences of the programmes of two scenes that differ in b alone: neither is solved.

Where curves that are not convex hold the laws, the programme is the last of the convex steps, with the planes of
these curves: its multipliers are those of a local optimum.

Sources: S. Boyd, L. Vandenberghe, Convex Optimization, 5.6; J. Nocedal, S. J. Wright, Numerical Optimization,
ch. 12.
"""

from collections.abc import Iterator
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Unsolved
from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.model.motion.programme import LAW_PEAKS, law_peaks
from camopt.model.motion.stroke import RETURN, RISE
from camopt.scene.problem.problem import resolve
from camopt.scene.scene import Scene
from camopt.solve.smallest.free_variables import FreeVariables
from camopt.solve.smallest.price import Price
from camopt.solve.synthesis.convex_model import ConvexModel, build_convex_model
from camopt.solve.synthesis.iterate import Iterate
from camopt.solve.synthesis.linear_constraints import with_robust_limits
from camopt.solve.synthesis.nonconvex_constraints import nonconvex_constraints_of
from camopt.solve.synthesis.problem_from_scene import (
    build_synthesis_problem,
    default_peaks,
    objective_weights,
    split_by_offset,
)
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, LIMIT_MARGINS, SynthesisProblem, tighten_limits
from camopt.solve.synthesis.synthesis_result import Synthesis, free_law_names

BOUND_STEP = 1e-4  # of a bound, in differences
LEAST_PRICE = 1e-5  # of the objective: what a bound that does not bind may cost, by a solver's error


class SceneBound(NamedTuple):
    """A bound of a scene that free laws may hold."""

    key: str
    value: float
    unit: str
    relation: str

    def scene_with_value(self, scene: Scene, value: float) -> Scene:
        """The scene with another value of the bound."""
        *names, last = self.key.split(".")
        if not last.isdecimal():
            return scene.replace(**{self.key: value})
        name = ".".join(names)
        pair = list(scene.numbers([name])[name])
        pair[int(last) - 1] = value
        return scene.replace(**{name: pair})


def prices_of_laws(result: Synthesis) -> list[Price]:
    """The price of each bound that holds the free laws of a synthesis; none where a solver fails.

    And none where the force turns round at places that the programme has not chosen.
    """
    if CROSSING_JERK in objective_weights(result.asked.synthesis):
        return []
    scene = _with_numeric_peaks(result.asked)
    optimum = _solved_optimum(scene, result)
    if optimum is None:
        return []
    found = []
    for each in _scene_bounds(scene):
        cost = _price_of_bound(optimum, scene, each)
        if abs(cost) * (abs(each.value) or 1.0) > LEAST_PRICE * (abs(result.objective) + optimum.model.unit):
            found.append(Price(each.key, each.value, each.unit, each.relation, cost, cost))
    return found


class PricedOptimum(NamedTuple):
    """The optimum of one of the programmes of a scene, with its number and the margin of its limits."""

    model: ConvexModel
    number: int
    margin: float
    point: list[Any]
    """Of its variables."""
    multipliers: list[FloatArray]
    """Of its constraints, and after these of the curves that are not convex."""
    steps: SequentialConvex | None = None
    """The convex steps that end at the optimum, where curves that are not convex hold it."""
    at: Iterate | None = None
    """Where they end."""
    sizes: tuple[float, float] = (0.0, 0.0)
    """e and s₀ of the cam, mm."""

    def evaluate_in_scene(self, scene: Scene) -> tuple[float, list[FloatArray]] | None:
        """The objective and the constraints of the same programme of another scene, at this point.

        None if that scene has another number of curves: at its bound a limit may be one that no motion holds.
        """
        side = _convex_model(_robust_problems(scene, self.sizes)[self.number], self.margin)
        for variable, value in zip(side.cvxpy_problem.variables(), self.point, strict=True):
            variable.value = value
        found = [each.expr.value for each in side.constraints]
        if self.steps is not None and self.at is not None:
            constraints = nonconvex_constraints_of(side.problem)
            if len(constraints) != len(nonconvex_constraints_of(self.model.problem)):
                return None
            found += self.steps.curve_ratios(self.at, constraints)
        return side.unit * float(side.objective.value), found


def _robust_problems(scene: Scene, sizes: tuple[float, float]) -> list[SynthesisProblem]:
    """One for each offset that a scene lists; of robust cams with what tolerances take of limits at these sizes."""
    return [
        with_robust_limits(each, *sizes) if each.scene_problem.robust_errors else each
        for each in split_by_offset(build_synthesis_problem(scene))
    ]


def _convex_model(problem: SynthesisProblem, margin: float) -> ConvexModel:
    """The programme of a demand, with its limits held closer by a margin."""
    return build_convex_model(tighten_limits(problem, margin), SplineMotion)


def _solved_optimum(scene: Scene, result: Synthesis) -> PricedOptimum | None:
    """The optimum that a result is; None if the solver fails, or the result is none."""
    # e and s₀ of the cam of free laws, mm
    first = split_by_offset(build_synthesis_problem(scene))[0]
    at = iterate_of_result(first, result)
    sizes = at.lead * first.size_unit, at.height * first.size_unit
    problems = _robust_problems(scene, sizes)
    for margin in LIMIT_MARGINS:
        models = [_convex_model(problem, margin) for problem in problems]
        try:
            values = [model.solve() for model in models]
        except Unsolved:
            continue  # with other numbers it may not fail
        number = values.index(min(values))
        if values[number] < inf:
            found = PricedOptimum(models[number], number, margin, *_primal_and_dual(models[number]), sizes=sizes)
            return found if result.convex else _local_optimum(found, result)
    return None


def _primal_and_dual(model: ConvexModel) -> tuple[list[Any], list[FloatArray]]:
    """The variables of a solved programme, and the multipliers of its constraints."""
    return [each.value for each in model.cvxpy_problem.variables()], [each.dual_value for each in model.constraints]


def _local_optimum(optimum: PricedOptimum, result: Synthesis) -> PricedOptimum | None:
    """The local optimum under curves that are not convex; None if steps do not end there, or offsets are listed."""
    model, problem = optimum.model, optimum.model.problem
    if problem.lowest_angle is not None or isinstance(result.asked.search.offset, tuple):
        return None
    at, constraints = iterate_of_result(problem, result), nonconvex_constraints_of(problem)
    steps = SequentialConvex(model, constraints)
    curves = steps.curve_multipliers(at, constraints)
    if curves is None:
        return None
    point, multipliers = _primal_and_dual(model)
    return optimum._replace(point=point, multipliers=multipliers + curves, steps=steps, at=at)


def iterate_of_result(problem: SynthesisProblem, result: Synthesis) -> Iterate:
    """The laws and the sizes of a result, as a demand counts them."""
    names = iter(free_law_names(result.asked.motion))
    coefficients = []
    for stroke in problem.free_strokes:
        law = result.scene.laws[next(names)].model_dump()
        values = np.array(law["positions"] if stroke.is_move else law["coefficients"])
        coefficients.append(
            (values - problem.zero) * stroke.size / problem.motion_unit if stroke.is_move else values
        )
    prime = result.design[problem.scene_problem.size_name] + problem.roller
    lead = (
        problem.scene_problem.design.sense * result.design.get("offset_mm", 0.0) if problem.has_trace_point else 0.0
    )
    height = float(difference_of_squares_root(prime, lead))
    return Iterate(lead / problem.size_unit, height / problem.size_unit, tuple(coefficients))


def _price_of_bound(optimum: PricedOptimum, scene: Scene, given: SceneBound) -> float:
    """The derivative of the Lagrangian by a bound, at an optimum: one-sided if need be."""
    step = BOUND_STEP * (abs(given.value) or 1.0)

    def side(change: float) -> tuple[float, float, list[FloatArray]] | None:
        """The bound's change, with the objective and the constraints there."""
        try:
            found = optimum.evaluate_in_scene(given.scene_with_value(scene, given.value + change))
        except BadInput:  # the bound may not be so
            return None
        return found and (change, *found)

    last, first = side(step) or side(0.0), side(-step) or side(0.0)
    if last is None or first is None or last[0] == first[0]:
        return 0.0
    change = last[1] - first[1]
    for multiplier, more, less in zip(optimum.multipliers, last[2], first[2], strict=True):
        change += optimum.model.unit * float(np.sum(multiplier * (more - less)))
    return change / (last[0] - first[0])


def _with_numeric_peaks(scene: Scene) -> Scene:
    """The scene with a number for each peak that its rises and returns take from a law, or by default."""
    scene_problem = resolve(scene)
    if not any(stroke.kind in (RISE, RETURN) for stroke in scene_problem.programme.tool.strokes):
        return scene
    given = {name: getattr(scene.synthesis, name) for name in LAW_PEAKS}
    peaks = {name: law_peaks(scene_problem.laws[law])[name] for name, law in given.items() if isinstance(law, str)}
    return scene.replace(**{f"synthesis.{name}": peak for name, peak in (peaks | default_peaks(scene)).items()})


def _scene_bounds(scene: Scene) -> Iterator[SceneBound]:
    """The bounds of a scene that free laws may hold."""
    scene_problem = resolve(scene)
    for limit in scene_problem.limits:
        if limit.set_by_scene and not limit.bound_key.startswith("limits."):
            unit = limit.quantity.unit if limit.quantity else "mm"
            yield SceneBound(limit.key, limit.bound, unit, limit.relation)
    for name in LAW_PEAKS:
        peak = getattr(scene.synthesis, name)
        if isinstance(peak, tuple):
            for number, (end, relation) in enumerate(zip(peak, "≥≤", strict=True), start=1):
                if end:  # 0 makes the laws monotone
                    yield SceneBound(f"synthesis.{name}.{number}", end, "", relation)
        elif peak is not None:
            yield SceneBound(f"synthesis.{name}", peak, "", "±")
    for end in FreeVariables.from_problem(scene_problem).range_ends:
        yield SceneBound(end.key, end.value, end.unit, end.relation)

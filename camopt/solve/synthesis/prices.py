"""Shadow price of each bound that limits the free laws, from the multipliers of the convex programme.

Let x be the optimum of a programme, with multipliers λ of its constraints c ≤ 0 and c = 0. The least objective f
changes with a bound b as the Lagrangian does: df/db = ∂(f + Σ λ·c)/∂b at the same x and λ (envelope theorem). The
derivatives by b are central differences of the programmes of two scenes that differ in b alone. Neither is solved.

With active nonconvex constraints, the programme is the last of the convex steps, with the tangent planes of these
constraints. Its multipliers are those of a local optimum.

Sources: S. Boyd, L. Vandenberghe, Convex Optimization, 5.6; J. Nocedal, S. J. Wright, Numerical Optimization,
ch. 12.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Unsolved
from camopt.core.numerics import FloatArray
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
    default_peak_factors,
    objective_weights,
    split_by_listed_offset_or_arm,
)
from camopt.solve.synthesis.relaxed_optimum import RelaxedOptimum, relaxed_optimum_with_jerk_cuts
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import CROSSING_JERK, LIMIT_MARGINS, SynthesisProblem, tighten_limits
from camopt.solve.synthesis.synthesis_result import Synthesis, free_law_names

BOUND_STEP = 1e-4  # step of differences, as a share of the bound
LEAST_PRICE = 1e-5  # least price times bound, as a share of the objective; below, a price is solver error


class SceneBound(NamedTuple):
    """A bound of a scene that may limit free laws."""

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


def shadow_prices_of_free_laws(result: Synthesis) -> Iterator[Price]:
    """The shadow price of each bound that limits the free laws of a synthesis.

    There are none if a solver fails, or if crossings were chosen outside of the programme.
    """
    if CROSSING_JERK in objective_weights(result.asked.synthesis):
        return
    scene = _with_numeric_peaks(result.asked)
    optimum = _solved_optimum(scene, result)
    if optimum is None:
        return
    for bound in _scene_bounds(scene):
        price = _objective_derivative_by_bound(optimum, scene, bound)
        if abs(price) * (abs(bound.value) or 1.0) > LEAST_PRICE * (abs(result.objective) + optimum.model.unit):
            yield Price(bound.key, bound.value, bound.unit, bound.relation, price, price)


class PricedOptimum(NamedTuple):
    """The optimum of one of a scene's programmes, with its number and the margin of its limits."""

    model: ConvexModel
    number: int
    margin: float
    point: list[Any]
    """Values of the variables."""
    multipliers: list[FloatArray]
    """Multipliers of the constraints, followed by those of the nonconvex curves."""
    steps: SequentialConvex | None = None
    """The convex steps that end at the optimum, if nonconvex constraints limit it."""
    at: Iterate | None = None
    """The iterate at which they end."""
    sizes: tuple[float, float] = (0.0, 0.0)
    """e and s₀ of the cam [mm]."""

    def objective_and_constraints_in_scene(self, scene: Scene) -> tuple[float, list[FloatArray]] | None:
        """Objective and constraints of the same programme for another scene, at this point.

        None if that scene has another number of curves, which happens at a bound that no motion meets.
        """
        own = self.model.problem
        problem = _robust_problem_per_listed_offset_or_arm(scene, self.sizes)[self.number]
        problem = replace(problem, splines=own.splines, jerk_jumps=own.jerk_jumps)
        model = build_convex_model(tighten_limits(problem, self.margin), SplineMotion)
        for variable, value in zip(model.cvxpy_problem.variables(), self.point, strict=True):
            variable.value = value
        values = [constraint.expr.value for constraint in model.constraints]
        if self.steps is not None and self.at is not None:
            constraints = nonconvex_constraints_of(model.problem)
            if len(constraints) != len(nonconvex_constraints_of(self.model.problem)):
                return None
            values += self.steps.curve_ratios_to_bounds(self.at, constraints)
        return model.unit * float(model.objective.value), values


def _robust_problem_per_listed_offset_or_arm(scene: Scene, sizes: tuple[float, float]) -> list[SynthesisProblem]:
    """The problem for each listed offset or arm; for robust cams with limits tightened at these sizes."""
    return [
        with_robust_limits(problem, *sizes) if problem.scene_problem.robust_errors else problem
        for problem in split_by_listed_offset_or_arm(build_synthesis_problem(scene))
    ]


def _solved_optimum(scene: Scene, result: Synthesis) -> PricedOptimum | None:
    """The solved convex programme of a result, with its multipliers; None if no margin gives a solution."""
    # e and s₀ of the cam of free laws [mm]
    first = split_by_listed_offset_or_arm(build_synthesis_problem(scene))[0]
    iterate = iterate_of_result(first, result)
    sizes = iterate.lead * first.size_unit, iterate.height * first.size_unit
    problems = _robust_problem_per_listed_offset_or_arm(scene, sizes)
    if result.convex:
        problems = [
            _problem_with_splines_of(result, problem, relaxed_optimum_with_jerk_cuts(scene, problem))
            for problem in problems
        ]
    for margin in LIMIT_MARGINS:
        models = [build_convex_model(tighten_limits(problem, margin), SplineMotion) for problem in problems]
        try:
            values = [model.solve() for model in models]
        except Unsolved:
            continue  # the next margin may not fail
        number = values.index(min(values))
        if values[number] < inf:
            optimum = PricedOptimum(models[number], number, margin, *_primal_and_dual(models[number]), sizes=sizes)
            return optimum if result.convex else _local_optimum(optimum, result)
    return None


def _problem_with_splines_of(
    result: Synthesis, problem: SynthesisProblem, optimum: RelaxedOptimum
) -> SynthesisProblem:
    """The problem with the splines of a result: those with as many knots in every stroke."""
    counts = [len(result.scene.laws[name].model_dump()["knots"]) for name in free_law_names(result.asked.motion)]
    return next(
        (
            cut
            for cut in optimum.cut_problems
            if [cut.splines_by_stroke[stroke].knots.size for stroke in cut.free_strokes] == counts
        ),
        problem,
    )


def _primal_and_dual(model: ConvexModel) -> tuple[list[Any], list[FloatArray]]:
    """Values of a solved programme's variables, and multipliers of its constraints."""
    return [item.value for item in model.cvxpy_problem.variables()], [item.dual_value for item in model.constraints]


def _local_optimum(optimum: PricedOptimum, result: Synthesis) -> PricedOptimum | None:
    """The local optimum under nonconvex constraints; None if the steps do not end there, or leads are listed."""
    model, problem = optimum.model, optimum.model.problem
    search = result.asked.search
    if problem.lowest_angle is not None or isinstance(search.offset or search.arm_length, tuple):
        return None
    iterate, constraints = iterate_of_result(problem, result), nonconvex_constraints_of(problem)
    steps = SequentialConvex(model, constraints)
    curves = steps.curve_multipliers(iterate, constraints)
    if curves is None:
        return None
    point, multipliers = _primal_and_dual(model)
    return optimum._replace(point=point, multipliers=multipliers + curves, steps=steps, at=iterate)


def iterate_of_result(problem: SynthesisProblem, result: Synthesis) -> Iterate:
    """The laws and the sizes of a result, in the units of a problem."""
    names = iter(free_law_names(result.asked.motion))
    coefficients = []
    for stroke in problem.free_strokes:
        law = result.scene.laws[next(names)].model_dump()
        values = np.array(law["positions"] if stroke.is_move else law["coefficients"])
        coefficients.append(
            (values - problem.zero) * stroke.size / problem.motion_unit if stroke.is_move else values
        )
    row, own_arm = result.design, float(problem.scene_problem.design.arm_length[0])
    lead, height = problem.lead_and_height_of_cam(
        row[problem.scene_problem.size_quantity_name],
        row.get("offset_mm", 0.0),
        row.get("arm_length_mm", own_arm),
    )
    return Iterate(lead, height, tuple(coefficients))


def _objective_derivative_by_bound(optimum: PricedOptimum, scene: Scene, bound: SceneBound) -> float:
    """Derivative of the Lagrangian by a bound at an optimum; one-sided if necessary."""
    step = BOUND_STEP * (abs(bound.value) or 1.0)

    def objective_and_constraints_at_change(change: float) -> tuple[float, float, list[FloatArray]] | None:
        """A change of the bound, with the objective and the constraints there."""
        try:
            values = optimum.objective_and_constraints_in_scene(bound.scene_with_value(scene, bound.value + change))
        except BadInput:  # the value is not allowed
            return None
        return values and (change, *values)

    last, first = (
        objective_and_constraints_at_change(step) or objective_and_constraints_at_change(0.0),
        objective_and_constraints_at_change(-step) or objective_and_constraints_at_change(0.0),
    )
    if last is None or first is None or last[0] == first[0]:
        return 0.0
    change = last[1] - first[1]
    for multiplier, more, less in zip(optimum.multipliers, last[2], first[2], strict=True):
        change += optimum.model.unit * float(np.sum(multiplier * (more - less)))
    return change / (last[0] - first[0])


def _with_numeric_peaks(scene: Scene) -> Scene:
    """The scene with a number for each peak that [synthesis] takes from a law or from the defaults."""
    scene_problem = resolve(scene)
    if not any(stroke.kind in (RISE, RETURN) for stroke in scene_problem.programme.tool.strokes):
        return scene
    peaks_of_laws = {
        name: law_peaks(scene_problem.laws[law])[name]
        for name in LAW_PEAKS
        if isinstance(law := getattr(scene.synthesis, name), str)
    }
    return scene.replace(
        **{f"synthesis.{name}": peak for name, peak in (peaks_of_laws | default_peak_factors(scene)).items()}
    )


def _scene_bounds(scene: Scene) -> Iterator[SceneBound]:
    """The bounds of a scene that may limit free laws."""
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

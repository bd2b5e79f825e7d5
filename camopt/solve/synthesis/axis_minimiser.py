"""Minimise one axis of a frontier while the other axes are held at values.

An axis is an objective term, or a quantity that is the largest value of a curve over the turn. Terms are convex. A
quantity is not: it is held as a limit of the scene and minimised by convex steps from several starts, to a local
optimum. In both cases the laws become a cam that meets every limit, as in ``synthesise``.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from math import inf
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from camopt.core.mistakes import Unsolved
from camopt.core.numerics import FloatArray
from camopt.scene.scene import Scene
from camopt.scene.synthesis import AXIS_TERMS
from camopt.solve.synthesis.cams import (
    motion_holds_limits,
    objective_term_value,
    programme_with_laws,
    scene_with_laws,
    smallest_cam_for_laws,
)
from camopt.solve.synthesis.convex_model import ConvexModel, build_convex_model
from camopt.solve.synthesis.iterate import Iterate, iterate_of
from camopt.solve.synthesis.nonconvex_constraints import (
    load_constraints_at,
    load_limit_keys_by_quantity,
    nonconvex_constraints_of,
)
from camopt.solve.synthesis.problem_from_scene import (
    build_synthesis_problem,
    objective_weights,
    split_by_listed_offset_or_arm,
)
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.relaxed_optimum import PANEL_COUNTS, RelaxedOptimum, subtract_solver_error
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.solver import SOLVER_ERROR
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import LIMIT_MARGINS, SynthesisProblem, tighten_limits
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.synthesis.synthesise import (
    NONCONVEX_GAP,
    best_synthesis,
    least_jerk_laws,
    starting_laws,
)
from camopt.solve.tables.designs import Design
from camopt.solve.verdicts.evaluation import evaluate

STEP_STARTS = 2  # largest number of starts for convex steps: the most promising
QUANTITY_ERROR = 1e-3  # relative slack of a held quantity: the row has the cam's own value
EQUAL_LAWS_CHANGE = 1e-4  # laws that differ by less are one optimum, apart from the solver's error
LEAST_SIZE_SLACK = 1e-4  # relative: a solution this near to the least possible size may have a cam of that size
HELD_VALUE_SLACK = 1e-9  # relative slack of a held term
SIZE_INCREASES = (
    0.0,
    1e-7,
    1e-6,
    1e-5,
    1e-4,
)  # relative: a cam may be larger than the steps report, for a solver's error


class FrontierCam(NamedTuple):
    """A cam of the frontier with its laws.

    Its row has the values of the axes, its quantities, ``bound``, ``local`` and ``scene``.
    """

    row: dict[str, Any]
    laws: Iterate


class AxisMinimiser:
    """The programme that minimises one axis while others are held; built once for all held values."""

    def __init__(
        self,
        scene: Scene,
        axes: tuple[str, ...],
        first: str,
        held: tuple[str, ...],
        margins: Sequence[float] = LIMIT_MARGINS,
    ) -> None:
        self.scene, self.axes, self.first = scene, axes, first
        self.margin, self.wider_margins, self.is_margin_too_small = margins[0], margins[1:], False
        problem = build_synthesis_problem(scene, {axis: 1.0 for axis in axes if axis in AXIS_TERMS})
        self.keys = {
            name: key
            for name, key in load_limit_keys_by_quantity(problem.scene_problem).items()
            if name in (first, *held)
        }
        self.problem = replace(problem, objective={} if first in self.keys else {first: 1.0})
        self.held = {term: cp.Parameter() for term in held if term in AXIS_TERMS}

    @cached_property
    def spline_model(self) -> ConvexModel:
        return build_convex_model(tighten_limits(self.problem, self.margin), SplineMotion, self.held)

    @cached_property
    def with_wider_margin(self) -> "AxisMinimiser":
        """The same with the next margin, where a solver's error breaks limits."""
        return AxisMinimiser(self.scene, self.axes, self.first, tuple(self.held | self.keys), self.wider_margins)

    @cached_property
    def relaxed_model(self) -> ConvexModel:
        """The relaxation, whose optimum is a lower bound for any motion."""
        return build_convex_model(
            tighten_limits(self.problem, -SOLVER_ERROR), partial(RelaxedMotion, PANEL_COUNTS[0]), self.held
        )

    @cached_property
    def convex_steps(self) -> SequentialConvex:
        """The convex steps under the nonconvex constraints of the scene and the held quantities, at any bounds."""
        problem = self._problem_with_held_limits(dict.fromkeys(self.keys.keys() - {self.first}, 1.0))
        return SequentialConvex(self.spline_model, nonconvex_constraints_of(problem), self.minimised_constraints)

    @cached_property
    def minimised_constraints(self) -> tuple[Any, ...]:
        """The constraints of the minimised axis, if it is a quantity; their bounds do not matter."""
        return (
            load_constraints_at(self.problem.scene_problem, self.keys[self.first], 1.0)
            if self.first in self.keys
            else ()
        )

    def minimise_at(
        self, held_values: Mapping[str, float], starts: Sequence[Iterate] = (), with_bound: bool = True
    ) -> FrontierCam | None:
        """The best cam with the other axes held at values; None if none is found."""
        if not held_values and self.first in AXIS_TERMS:
            # nothing is held: as ``synthesise``, with the pieces of all cams of the frontier
            problems = [(problem, RelaxedOptimum(None)) for problem in split_by_listed_offset_or_arm(self.problem)]
            cam, laws_found = best_synthesis(self.scene, problems, lambda done, most: None)
            terms = self._cam_row(cam, laws_found) | {"bound": None, "local": not cam.convex}
            return FrontierCam(terms, laws_found)
        scene, problem, best = (
            self.scene.with_values(self._held_values_as_limits(held_values)),
            self._problem_with_held_limits(held_values),
            None,
        )
        self.is_margin_too_small = False
        for laws, is_last_resort in self._laws_and_whether_last_resort(problem, held_values, starts):
            # apart from margins, the cam is no smaller than the size of the programme
            if best and (is_last_resort or (self.first == "size" and self._solved_size(laws) >= best.row["size"])):
                continue
            row = self._feasible_row(scene, problem, laws, held_values)
            if row and (best is None or row[self.first] < best.row[self.first]):
                best = FrontierCam(row, laws)
            if best and self.first in AXIS_TERMS and self._is_near_optimum(best.row[self.first]):
                break
            # a cam of the value of the programme's solution: another start would end there again
            if (
                row
                and not self.keys
                and (self.first != "size" or row["size"] <= self._solved_size(laws) * (1.0 + NONCONVEX_GAP))
            ):
                break
        may_widen = self.wider_margins and (best is None or self.margin == LIMIT_MARGINS[0])
        if self.is_margin_too_small and may_widen:
            other = self.with_wider_margin.minimise_at(held_values, starts, with_bound)
            if best is None or (other and other.row[self.first] < best.row[self.first]):
                return other
        if best is None:
            return None
        columns = {
            "bound": self._lower_bound(held_values, best) if with_bound else None,
            "local": self.first not in AXIS_TERMS or not self._is_near_optimum(best.row[self.first]),
        }
        return best._replace(row=best.row | columns)

    def _held_values_as_limits(self, held_values: Mapping[str, float]) -> dict[str, float]:
        """The limits of the scene, by key, that hold quantities at their values."""
        limits = {}
        for name in self.keys.keys() & held_values.keys():
            own_bound = getattr(self.scene.limits, self.keys[name])
            limits[f"limits.{self.keys[name]}"] = min(held_values[name], inf if own_bound is None else own_bound)
        return limits

    def _problem_with_held_limits(self, held_values: Mapping[str, float]) -> SynthesisProblem:
        """The problem with the held quantities as limits of the scene."""
        return replace(
            self.problem,
            scene_problem=self.problem.scene_problem.with_numbers(self._held_values_as_limits(held_values)),
        )

    def _least_objective(self, model: ConvexModel, held_values: Mapping[str, float], margin: float) -> float:
        """Least objective with the terms held at values; infinite if there is none.

        It is infinite as well if the solver fails and there are held values, as others may succeed.
        """
        for term, parameter in self.held.items():
            parameter.value = held_values[term] * (1.0 - margin)
        try:
            return model.solve()
        except Unsolved:
            if not held_values:
                raise
            return inf

    def _laws_and_whether_last_resort(
        self, problem: SynthesisProblem, held_values: Mapping[str, float], starts: Sequence[Iterate]
    ) -> Iterator[tuple[Iterate, bool]]:
        """Candidate laws for held values: the convex optimum, then local optima under the nonconvex constraints.

        If the optimum exceeds a nonconvex constraint it comes last, and is a last resort.
        """
        self.optimum = self._least_objective(self.spline_model, held_values, self.margin)
        if self.optimum == inf:
            return
        optimum = iterate_of(self.spline_model)
        least_jerk = least_jerk_laws(self.spline_model, self.optimum) or optimum
        constraints = nonconvex_constraints_of(problem)
        if not (constraints or self.minimised_constraints):
            yield least_jerk, False
            yield optimum, False
            return
        is_last_resort = (
            not self.minimised_constraints
            and self.convex_steps.largest_ratios_to_bounds(least_jerk, constraints, ())[0] > 1.0 + NONCONVEX_GAP
        )
        if not (is_last_resort or self.minimised_constraints):
            yield least_jerk, False
        candidates = [least_jerk, *starts, *known_law_starts(self.scene.to_toml(), self.axes)]
        if held_values:  # at the end of an axis every start is tried, as in ``synthesise``
            candidates = self.convex_steps.rank_starts(
                [optimum, *candidates], constraints, self.minimised_constraints
            )[:STEP_STARTS]
        ends: list[FloatArray] = []
        for start in candidates:
            laws = self.convex_steps.find_local_optimum(start, constraints, self.minimised_constraints)
            end = np.concatenate([laws[:2], *laws.coefficients])
            if not any(np.allclose(end, other, rtol=0.0, atol=EQUAL_LAWS_CHANGE) for other in ends):
                yield laws, False
            ends.append(end)
        if is_last_resort:
            yield least_jerk, True

    def _is_near_optimum(self, objective: float) -> bool:
        """Whether a better cam is not worth a search."""
        return objective <= self.spline_model.largest_accepted_objective(self.optimum) + NONCONVEX_GAP * (
            abs(self.optimum) + self.spline_model.unit
        )

    def _feasible_row(
        self, scene: Scene, problem: SynthesisProblem, laws: Iterate, held_values: Mapping[str, float]
    ) -> dict[str, Any] | None:
        """The row of the laws' cam if it meets every limit and held value; None otherwise."""
        if not motion_holds_limits(problem, programme_with_laws(problem, laws)):
            self.is_margin_too_small = True
            return None
        search = self.scene.search
        choices = (search.base_radius, search.mean_radius, search.offset, search.arm_length)
        if any(isinstance(choice, tuple) and len(choice) > 1 for choice in choices):  # no cam between listed sizes
            cam = smallest_cam_for_laws(scene, problem, laws)
        elif self.keys:
            cam = self._feasible_cam_near_solved_size(laws)
        else:
            least = self._cam_of_least_possible_size(scene, problem, laws)
            cam = least or smallest_cam_for_laws(scene, problem, laws)
        if cam is None:
            return None
        row = self._cam_row(cam, laws)
        slack = {axis: QUANTITY_ERROR if axis in self.keys else HELD_VALUE_SLACK for axis in held_values}
        return row if all(row[axis] <= held_values[axis] * (1.0 + slack[axis]) for axis in held_values) else None

    def _cam_row(self, cam: Synthesis, laws: Iterate) -> dict[str, Any]:
        """The row of a cam: its axes, its quantities and its scene."""
        programme, size = (
            programme_with_laws(self.problem, laws),
            cam.design[self.problem.scene_problem.size_quantity_name],
        )
        terms = {
            axis: objective_term_value(self.problem, programme, axis, size)
            for axis in self.axes
            if axis in AXIS_TERMS
        }
        return {**terms, **cam.design, "scene": cam.scene.to_toml()}

    def _solved_prime_radius(self, laws: Iterate) -> float:
        """Prime radius at which the programme found the laws [mm]."""
        problem, (lead, height) = self.problem, (self.problem.size_unit * size for size in laws[:2])
        return max(
            float(np.hypot(lead, height)) if problem.has_lead_in_prime_radius else height, problem.prime_range[0]
        )

    def _solved_size(self, laws: Iterate) -> float:
        """Cam size at which the programme found the laws [mm]."""
        return self._solved_prime_radius(laws) - self.problem.prime_less_cam_radius

    def _solved_other_sizes(self, laws: Iterate) -> dict[str, float]:
        """The sizes other than the radius at which the programme found the laws, by name [mm]."""
        sizes = self.problem.design_of_sizes(*(self.problem.size_unit * size for size in laws[:2])).sizes
        return {name: float(sizes[name][0]) for name in ("offset", "arm_length", "roller_radius")}

    def _cam_of_least_possible_size(
        self, scene: Scene, problem: SynthesisProblem, laws: Iterate
    ) -> Synthesis | None:
        """The cam of the least possible size with the other sizes of the programme's solution, if it is feasible.

        It is None as well if the solution is larger. A search takes long to find this cam, because few values of
        the other sizes are feasible there.
        """
        least = problem.prime_range[0]
        if self._solved_prime_radius(laws) > least * (1.0 + LEAST_SIZE_SLACK):
            return None
        size_key = problem.scene_problem.size_quantity_name.removesuffix("_mm")
        sizes = {size_key: least - problem.prime_less_cam_radius, **self._solved_other_sizes(laws)}
        free = {size_key, *problem.scene_problem.search_space.variables}
        fixed = scene.with_values({f"search.{name}": (size,) for name, size in sizes.items() if name in free})
        cam = smallest_cam_for_laws(fixed, problem, laws)
        return cam and replace(cam, scene=scene_with_laws(scene, problem, laws).with_row(cam.design))

    def _feasible_cam_near_solved_size(self, laws: Iterate) -> Synthesis | None:
        """The cam at the sizes of the programme's solution, or slightly larger, if it meets every limit.

        The smallest cam for the laws is no smaller, apart from margins, and takes long to find if a load decides.
        """
        problem, prime = self.problem, self._solved_prime_radius(laws)
        scene, name = scene_with_laws(self.scene, problem, laws), problem.scene_problem.size_quantity_name
        sizes = {f"{size}_mm": value for size, value in self._solved_other_sizes(laws).items()}
        for increase in SIZE_INCREASES:
            cam = scene.with_row({**sizes, name: prime * (1.0 + increase) - problem.prime_less_cam_radius})
            row = evaluate(cam)
            if row["feasible"]:
                return Synthesis(self.scene, cam, Design(row, cam), 0.0)
        return None

    def _lower_bound(self, held_values: Mapping[str, float], best: FrontierCam) -> float | None:
        """Lower bound of the axis for any motion at held values; None for a quantity, or if the solver fails."""
        if self.minimised_constraints or (self.first == "size" and not self.problem.has_convex_size_constraints):
            return None
        bound = subtract_solver_error(
            self.relaxed_model, self._least_objective(self.relaxed_model, held_values, -SOLVER_ERROR)
        )
        return bound if self.relaxed_model.is_solved_accurately and bound <= best.row[self.first] else None


@lru_cache(maxsize=1)
def known_law_starts(scene_toml: str, axes: tuple[str, ...]) -> list[Iterate]:
    """Known laws on their smallest cams, from which convex steps start; the same for all axes and held values."""
    scene = Scene.from_dict(tomllib.loads(scene_toml))
    problem = build_synthesis_problem(scene, {axis: 1.0 for axis in axes if axis in AXIS_TERMS})
    return starting_laws(problem, None, objective_weights(scene.synthesis))

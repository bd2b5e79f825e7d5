"""The least of one axis of a frontier, with the others held at values.

An axis is a term of the objective, which is convex, or a quantity that is the largest value of a curve over the
turn, which is not: it is held as a limit of the scene, and reached by convex steps from several starts, a local
optimum. Either way the laws become a cam, as in ``synthesise``, that holds every limit.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
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
    objective_term,
    programme_with_laws,
    scene_with_laws,
    smallest_cam_for_laws,
)
from camopt.solve.synthesis.convex_model import ConvexModel, build_convex_model
from camopt.solve.synthesis.iterate import Iterate, iterate_of
from camopt.solve.synthesis.nonconvex_constraints import (
    load_constraints_at,
    load_quantities,
    nonconvex_constraints_of,
)
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem, objective_weights, split_by_offset
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.solver import SOLVER_ERROR
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import LIMIT_MARGINS, SynthesisProblem, tighten_limits
from camopt.solve.synthesis.synthesis_result import Synthesis
from camopt.solve.synthesis.synthesise import (
    NONCONVEX_GAP,
    PANEL_COUNTS,
    best_synthesis,
    least_jerk_laws,
    starting_laws,
    subtract_solver_error,
)
from camopt.solve.tables.designs import Design
from camopt.solve.verdicts.evaluation import evaluate

STEP_STARTS = 2  # starts of convex steps: those that promise most
QUANTITY_ERROR = 1e-3  # relative: of a quantity's value, which says where to look; what a cam has of it is its own
EQUAL_LAWS_CHANGE = 1e-4  # of their change: steps from several starts end at one optimum, but for a solver's error
HELD_VALUE_SLACK = 1e-9  # relative: of a value that a cam holds
SIZE_INCREASES = (
    0.0,
    1e-7,
    1e-6,
    1e-5,
    1e-4,
)  # by which a cam may be larger than the steps say, for a solver's error


class FrontierCam(NamedTuple):
    """A cam: its row (the axes' values, its quantities, ``bound``, ``local`` and ``scene``), and its laws."""

    row: dict[str, Any]
    laws: Iterate


class AxisMinimiser:
    """The programme of one axis with others held; built once, for all their values."""

    def __init__(self, scene: Scene, axes: Sequence[str], first: str, held: Sequence[str]) -> None:
        self.scene, self.axes, self.first = scene, axes, first
        problem = build_synthesis_problem(scene, {axis: 1.0 for axis in axes if axis in AXIS_TERMS})
        self.keys = {
            name: key for name, key in load_quantities(problem.scene_problem).items() if name in (first, *held)
        }
        self.problem = replace(problem, objective={} if first in self.keys else {first: 1.0})
        self.held = {term: cp.Parameter() for term in held if term in AXIS_TERMS}
        self.known: list[Iterate] | None = None

    @cached_property
    def free_model(self) -> ConvexModel:
        """The programme of free laws."""
        return build_convex_model(tighten_limits(self.problem, LIMIT_MARGINS[0]), SplineMotion, self.held)

    @cached_property
    def relaxed_model(self) -> ConvexModel:
        """The relaxation that bounds it for any motion."""
        wider = tighten_limits(self.problem, -SOLVER_ERROR)
        return build_convex_model(wider, partial(RelaxedMotion, PANEL_COUNTS[0]), self.held)

    @cached_property
    def convex_steps(self) -> SequentialConvex:
        """The steps under the ceilings of the scene and of held quantities, whatever their values."""
        held = self._problem_with_held(dict.fromkeys(self.keys.keys() - {self.first}, 1.0))
        return SequentialConvex(self.free_model, nonconvex_constraints_of(held), self.minimised_curves)

    @cached_property
    def minimised_curves(self) -> tuple[Any, ...]:
        """The ceilings of the axis itself, if it is a quantity; their bounds do not matter."""
        return (
            load_constraints_at(self.problem.scene_problem, self.keys[self.first], 1.0)
            if self.first in self.keys
            else ()
        )

    def minimise_at(
        self, value: Mapping[str, float], starts: Sequence[Iterate] = (), bounded: bool = True
    ) -> FrontierCam | None:
        """The best cam with the other axes held at values; None if none is found."""
        if not value and self.first in AXIS_TERMS:
            # the least of a term with nothing held: what ``synthesise`` finds
            cam, found = best_synthesis(self.scene, split_by_offset(self.problem), lambda done, most: None)
            terms = self._cam_row(cam, found) | {"bound": None, "local": not cam.convex}
            return FrontierCam(terms, found)
        scene, problem, best = (
            self.scene.with_values(self._held_limits(value)),
            self._problem_with_held(value),
            None,
        )
        for laws in self._candidate_laws(problem, value, starts):
            # what laws were found with of a size is no more than their cam has, but for margins
            if best and self.first == "size" and self._prime_radius(laws) - self.problem.roller >= best.row["size"]:
                continue
            row = self._feasible_row(scene, problem, laws, value)
            if row and (best is None or row[self.first] < best.row[self.first]):
                best = FrontierCam(row, laws)
            if best and self.first in AXIS_TERMS and self._is_near_optimum(best.row[self.first]):
                break
        if best is None:
            return None
        local = self.first not in AXIS_TERMS or not self._is_near_optimum(best.row[self.first])
        bound = self._lower_bound(value, best) if bounded else None
        return best._replace(row=best.row | {"bound": bound, "local": local})

    def _held_limits(self, value: Mapping[str, float]) -> dict[str, float]:
        """The bounds of the scene, by key, that hold quantities at a value."""
        limits = {}
        for name in self.keys.keys() & value.keys():
            own = getattr(self.scene.limits, self.keys[name])
            limits[f"limits.{self.keys[name]}"] = min(value[name], inf if own is None else own)
        return limits

    def _problem_with_held(self, value: Mapping[str, float]) -> SynthesisProblem:
        """The demand with the held quantities as limits of the scene."""
        return replace(
            self.problem, scene_problem=self.problem.scene_problem.with_numbers(self._held_limits(value))
        )

    def _least_objective(self, model: ConvexModel, value: Mapping[str, float], margin: float) -> float:
        """The least objective with the terms held at a value; infinite if there is none.

        Also if the solver fails, where there may be other values.
        """
        for term, parameter in self.held.items():
            parameter.value = value[term] * (1.0 - margin)
        try:
            return model.solve()
        except Unsolved:
            if not value:
                raise
            return inf

    def _candidate_laws(
        self, problem: SynthesisProblem, value: Mapping[str, float], starts: Sequence[Iterate]
    ) -> Iterator[Iterate]:
        """Free laws for a value: what the programme gives, and bent below the ceilings if need be."""
        self.optimum = self._least_objective(self.free_model, value, LIMIT_MARGINS[bool(self.keys)])
        if self.optimum == inf:
            return
        plain = iterate_of(self.free_model)
        least_jerk = least_jerk_laws(self.free_model, self.optimum) or plain
        constraints = nonconvex_constraints_of(problem)
        if not self.minimised_curves:
            yield least_jerk
            if not constraints:  # which steps take both of them below
                yield plain
        if constraints or self.minimised_curves:
            # known laws on their smallest cams, which do not depend on the values
            if self.known is None:
                self.known = starting_laws(self.problem, least_jerk, objective_weights(self.scene.synthesis))
            every = [least_jerk, *starts, *self.known]
            if value:  # not the end of an axis, where every start of ``synthesise`` is tried
                every = self.convex_steps.rank_starts([plain, *every], constraints, self.minimised_curves)[
                    :STEP_STARTS
                ]
            ends: list[FloatArray] = []
            for each in every:
                laws = self.convex_steps.find_local_optimum(each, constraints, self.minimised_curves)
                end = np.concatenate([laws[:2], *laws.coefficients])
                if not any(np.allclose(end, other, rtol=0.0, atol=EQUAL_LAWS_CHANGE) for other in ends):
                    yield laws
                ends.append(end)

    def _is_near_optimum(self, objective: float) -> bool:
        """Whether no better cam is worth looking for."""
        return objective <= self.free_model.accepted_objective(self.optimum) + NONCONVEX_GAP * (
            abs(self.optimum) + self.free_model.unit
        )

    def _feasible_row(
        self, scene: Scene, problem: SynthesisProblem, laws: Iterate, value: Mapping[str, float]
    ) -> dict[str, Any] | None:
        """A cam of laws that holds every limit and value; None if there is none."""
        programme = programme_with_laws(problem, laws)
        if not motion_holds_limits(problem, programme):
            return None
        cam = (
            self._cam_of_solved_size(laws)
            if self.keys and not _has_listed_sizes(self.scene)
            else smallest_cam_for_laws(scene, problem, laws)
        )
        if cam is None:
            return None
        row = self._cam_row(cam, laws)
        loose = {axis: QUANTITY_ERROR if axis in self.keys else HELD_VALUE_SLACK for axis in value}
        return row if all(row[axis] <= value[axis] * (1.0 + loose[axis]) for axis in value) else None

    def _cam_row(self, cam: Synthesis, laws: Iterate) -> dict[str, Any]:
        """The row of a cam: its axes, its quantities and its scene."""
        programme, size = programme_with_laws(self.problem, laws), cam.design[self.problem.scene_problem.size_name]
        terms = {
            axis: objective_term(self.problem, programme, axis, size) for axis in self.axes if axis in AXIS_TERMS
        }
        return {**terms, **cam.design, "scene": cam.scene.to_toml()}

    def _prime_radius(self, laws: Iterate) -> float:
        """The size that laws were found with, and the roller."""
        problem = self.problem
        lead, height = (problem.size_unit * each for each in laws[:2])
        return max(float(np.hypot(lead, height)) if problem.has_trace_point else height, problem.prime_range[0])

    def _cam_of_solved_size(self, laws: Iterate) -> Synthesis | None:
        """The cam of the sizes that the laws were found with, or a little larger, if it holds every limit.

        The smallest cam for the laws is no smaller, but for the margins of the steps, and takes long to find where
        a load decides.
        """
        problem, prime = self.problem, self._prime_radius(laws)
        scene, name = scene_with_laws(self.scene, problem, laws), problem.scene_problem.size_name
        offset = problem.scene_problem.design.sense * problem.size_unit * laws.lead
        sizes = {"offset_mm": offset, "roller_radius_mm": problem.largest_roller}
        for larger in SIZE_INCREASES:
            cam = scene.with_row({**sizes, name: prime * (1.0 + larger) - problem.roller})
            found = evaluate(cam)
            if found["feasible"]:
                return Synthesis(self.scene, cam, Design(found, cam), 0.0)
        return None

    def _lower_bound(self, value: Mapping[str, float], best: FrontierCam) -> float | None:
        """What no motion passes with the terms held at a value; None for a quantity, or if the solver fails."""
        if self.minimised_curves or (self.first == "size" and not self.problem.has_convex_size):
            return None
        bound = subtract_solver_error(
            self.relaxed_model, self._least_objective(self.relaxed_model, value, -SOLVER_ERROR)
        )
        return bound if self.relaxed_model.is_exact and bound <= best.row[self.first] else None


def _has_listed_sizes(scene: Scene) -> bool:
    """Whether a scene lists sizes, between which there is no cam."""
    choices = (scene.search.base_radius, scene.search.mean_radius, scene.search.offset)
    return any(isinstance(choice, tuple) and len(choice) > 1 for choice in choices)

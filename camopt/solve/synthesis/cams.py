"""Free laws as laws of a scene, and the smallest cams for them."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from math import isfinite, isnan, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.numerics.clock import clock_seconds
from camopt.model.effects.vibration import vibration
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion import LAWS
from camopt.model.motion.law import is_still
from camopt.model.motion.programme import (
    Programme,
    derivative_peak,
    mean_of_powers,
    root_mean_square,
    weighted_range,
)
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.stroke import ALL_STROKES, DERIVATIVE_NAMES, RETURN, RISE, Condition, Stroke
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.space import search_boxes
from camopt.scene.scene import Scene
from camopt.solve.smallest.optimise import OPTIMISE_SECONDS, optimise
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.crossing_jerk import crossing_jerk
from camopt.solve.synthesis.problem_from_scene import objective_weights
from camopt.solve.synthesis.synthesis_problem import (
    CROSSING_JERK,
    LOST_AREA,
    RMS_TERM_ORDERS,
    SIZE_WORDS,
    TERM_ORDERS,
    SynthesisProblem,
)
from camopt.solve.synthesis.synthesis_result import Synthesis, free_law_names
from camopt.solve.tables.designs import Design

if TYPE_CHECKING:
    from camopt.solve.synthesis.iterate import Iterate

LEAST_DERIVATIVE = 1e-12  # of the range of a derivative: rounding
CONDITION_SLACKS = (
    1e-6,
    1e-5,
    1e-3,
    0.1,
)  # of the lift by the stroke's angle: by how much a solver may miss a condition


def smallest_known_cams(scene: Scene) -> dict[str, Design]:
    """The smallest cam of each known law: those of [search] or all without a corner, and the scene's own."""
    named = scene.search.law or scene.search.law_rise or scene.search.law_return
    chosen_by_law = any(segment.segment in ("rise", "return") for segment in scene.motion)
    known = [name for name, law in LAWS.items() if is_still(law)]
    sought = scene if named or not chosen_by_law else scene.with_values({"search.law": tuple(known)})
    found = smallest_cams(sought).by_law
    own = scene.with_values(dict.fromkeys(("search.law", "search.law_rise", "search.law_return"), ()))
    if not any(own_law_names(scene) == law_names_of(row) for row in found.values()):
        found = {**found, **smallest_cams(own).by_law}
    return found


def own_law_names(scene: Scene) -> tuple[str, str]:
    """The names of the scene's own laws, of rises and of returns, as the rows of designs have them."""
    programme = resolve(scene).programme
    return programme.law_names(RISE), programme.law_names(RETURN)


def law_names_of(row: Mapping[str, Any]) -> tuple[str, str]:
    """The names of the laws of a design's rises and returns."""
    return row["law_rise"], row["law_return"]


def known_cam_row(problem: SynthesisProblem, row: Design) -> Design:
    """A known law's cam with what it has of the objective, and whether it holds all that free laws hold."""
    programme, size = _programme_of_design(problem, row), row[problem.scene_problem.size_name]
    terms = {name: objective_term(problem, programme, name, size) for name in problem.objective}
    known: dict[str, Any] = {**terms, **row, "within": not limits_broken_by_cam(problem, row)}
    return Design(known, row.searched)


def limits_broken_by_cam(problem: SynthesisProblem, row: Design) -> list[str]:
    """What a known law's cam breaks of all that free laws hold: names of limits, jumps, and the size."""
    programme, size = _programme_of_design(problem, row), row[problem.scene_problem.size_name]
    jumps = {DERIVATIVE_NAMES[jump.order] for jump in programme.jumps if jump.order <= problem.rest}
    found = [f"no jump of {name}" for name in sorted(jumps)] + list(limits_broken_by_motion(problem, programme))
    return list(dict.fromkeys(found + [SIZE_WORDS] * (size > largest_cam_size(problem) * (1.0 + LEAST_DERIVATIVE))))


def largest_cam_size(problem: SynthesisProblem) -> float:
    """Of the cam, mm; infinite if nothing keeps it from being larger."""
    return problem.prime_range[1] - problem.roller


def _programme_of_design(problem: SynthesisProblem, row: Design) -> Programme:
    """The turn with the known laws of a design."""
    scene_problem = problem.scene_problem
    return scene_problem.given_motion_with_laws(
        *(name if name in scene_problem.laws else None for name in law_names_of(row))
    )


def smallest_cams(scene: Scene) -> Optimum:
    """The result of ``optimise``; with the scene's own size if neither limits nor objective depend on it."""
    scene_problem = resolve(scene)
    if has_own_size(scene_problem, objective_weights(scene.synthesis)):
        scene = scene.with_values({scene_problem.variables[0].search_key: (float(scene_problem.design.size[0]),)})
    return optimise(scene)


def smallest_design(scene_problem: Problem, objective: Collection[str]) -> Designs | None:
    """The smallest design that holds all limits; else one that breaks them by little, if any is found.

    Of the scene's own size where neither limits nor the terms of the objective bear on it.
    """
    until, own = clock_seconds() + OPTIMISE_SECONDS, float(scene_problem.design.size[0])
    kept: SizeBounds = {"size": (own, own)} if has_own_size(scene_problem, objective) else {}
    boxes = [{**bounds, **kept} for bounds in search_boxes(scene_problem)]
    answers = sorted(
        (solve_smallest_cam(scene_problem, bounds, until) for bounds in boxes), key=lambda each: each.size
    )
    found = (*(each.design for each in answers), *(each.nearest for each in answers))
    return next((design for design in found if design is not None), None)


def has_own_size(scene_problem: Problem, objective: Collection[str]) -> bool:
    """Whether the size is the scene's own: neither its search, nor limits, nor the objective bear on it."""
    limited = any(limit.set_by_scene and not limit.is_of_motion for limit in scene_problem.limits)
    sought = "size" in scene_problem.search_space.variables or "size" in objective
    return not (limited or sought or isnan(scene_problem.design.size[0]))


def scene_with_laws(scene: Scene, problem: SynthesisProblem, found: "Iterate") -> Scene:
    """The scene of a demand with free laws in place of its own."""
    data, strokes = scene.to_dict(), iter(strokes_with_laws(problem, found))
    laws = data.setdefault("laws", {})
    for segment in data["motion"]:
        stroke = next(strokes) if segment["angle"] > 0.0 else None
        if stroke is None or not stroke.is_free:
            continue
        law = stroke.law
        assert isinstance(law, SplineLaw)
        values = list(law.coefficients)
        segment["law"] = law.NAME
        laws[law.NAME] = {"degree": law.degree, "knots": list(law.knots)}
        if stroke.is_move:
            start = problem.zero + stroke.low / stroke.size
            laws[law.NAME]["positions"] = [start + value for value in values]
            segment["to"] = laws[law.NAME]["positions"][-1]
        else:
            laws[law.NAME]["coefficients"] = values
    for key in ("law", "law_rise", "law_return"):
        data.get("search", {}).pop(key, None)
    return Scene.from_dict(data, scene.file)


def strokes_with_laws(problem: SynthesisProblem, found: "Iterate") -> tuple[Stroke, ...]:
    """The strokes of a demand with free laws."""
    free = iter(zip(free_law_names(problem.scene_problem.segments), found.coefficients, strict=True))
    return tuple(
        problem.splines_of(stroke).stroke_with_law(stroke, *next(free), problem.motion_unit)
        if stroke.is_free
        else stroke
        for stroke in problem.strokes
    )


def programme_with_laws(problem: SynthesisProblem, found: "Iterate") -> Programme:
    """The turn with free laws, which is asked of the tool where there is a train."""
    own, strokes = problem.scene_problem.programme.tool, strokes_with_laws(problem, found)
    return replace(own, strokes=strokes, start=strokes[0].low / own.unit).on_base_circle()


def motion_holds_limits(problem: SynthesisProblem, programme: Programme) -> bool:
    """Whether a motion itself, not a solver's word, holds the limits on it and the conditions."""
    return next(limits_broken_by_motion(problem, programme), None) is None


def limits_broken_by_motion(problem: SynthesisProblem, programme: Programme) -> Iterator[str]:
    """The names of the limits on the motion, and of the conditions, that a motion breaks; again for each stroke."""
    for stroke, ranges in zip(programme.strokes, problem.derivative_ranges, strict=True):
        for order, (low, high) in ranges.items():
            least, largest = weighted_range(Programme((stroke,)), (0.0,) * order + (1.0,), ALL_STROKES)
            rounding = LEAST_DERIVATIVE * max(abs(end) for end in (low, high) if isfinite(end))
            if least < low - rounding or largest > high + rounding:
                yield DERIVATIVE_NAMES[order]
    if (
        problem.residual_limit is not None
        and objective_term(problem, programme, residual.RESIDUAL_TERM, 0.0) > problem.residual_limit
    ):
        yield residual.RESIDUAL_TERM
    up = problem.strokes[0].low - programme.strokes[0].low  # the base circle may be another
    for stroke in (each for each in programme.strokes if each.is_free):
        yield from (each.key for each in problem.conditions if not _meets_condition(problem, stroke, up, each))


def _meets_condition(problem: SynthesisProblem, stroke: Stroke, up: float, condition: Condition) -> bool:
    """Whether a stroke meets a condition, as far as a solver can."""
    values = stroke.values_at(condition) + up * (condition.order == 0)
    room = CONDITION_SLACKS[condition.order] * problem.motion_unit / stroke.angle**condition.order
    return bool(np.all((values >= condition.low - room) & (values <= condition.high + room)))


def smallest_cam_for_laws(asked: Scene, problem: SynthesisProblem, found: "Iterate") -> Synthesis | None:
    """The smallest cam for free laws, proved, under every limit of the scene; None if there is none."""
    scene = scene_with_laws(asked, problem, found)
    best = smallest_cams(scene).best
    if best is None:
        return None
    size = problem.scene_problem.size_name
    if best[size] > largest_cam_size(problem):
        return None
    # the objective of free laws and a size, from the motion itself
    programme = programme_with_laws(problem, found)
    objective = sum(
        weight * objective_term(problem, programme, name, best[size]) for name, weight in problem.objective.items()
    )
    return Synthesis(asked, scene.with_row(best), best, objective)


def objective_term(problem: SynthesisProblem, programme: Programme, name: str, size: float) -> float:
    """A term of the objective, from the motion itself or the size."""
    if name == "size":
        return size
    if name == residual.RESIDUAL_TERM:
        return float(
            problem.term_factors[name] * vibration(programme, *problem.train_frequency_and_damping).residual
        )
    if name == CROSSING_JERK:
        return problem.term_factors[name] * crossing_jerk(programme, problem.crossing_window, problem.crossings)
    if name == LOST_AREA:
        area = 2.0 * pi * mean_of_powers(programme, 0, 1)
        return problem.term_factors[name] * (problem.largest_area - area)
    if name in TERM_ORDERS:
        return problem.term_factors[name] * derivative_peak(programme, TERM_ORDERS[name], ALL_STROKES)
    return problem.term_factors[name] * root_mean_square(programme, RMS_TERM_ORDERS[name])

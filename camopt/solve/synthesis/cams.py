"""Free laws as laws of a scene, and the smallest cams for them and for known laws."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from math import isfinite, isnan, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.numerics.budget import Budget
from camopt.model.effects.vibration import vibration_extremes
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion import LAWS
from camopt.model.motion.law import rests_at_both_ends
from camopt.model.motion.programme import (
    Programme,
    derivative_peak,
    derivative_power_mean,
    derivative_root_mean_square,
    weighted_derivative_range,
)
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.stroke import ALL_STROKES, DERIVATIVE_NAMES, RETURN, RISE, Stroke
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.space import search_boxes
from camopt.scene.scene import Scene
from camopt.solve.smallest.optimise import OPTIMISE_WORK, optimise
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.crossing_jerk import largest_jerk_after_crossings
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
from camopt.solve.verdicts.certify import certify_limits
from camopt.solve.verdicts.verdict_words import UNDECIDED

if TYPE_CHECKING:
    from camopt.solve.synthesis.iterate import Iterate

LEAST_DERIVATIVE = 1e-12  # rounding, as a share of a derivative's range
STEP_BACK = 1e-9  # relative increase of a size at which rounding hides if limits hold
CONDITION_SLACKS = (
    1e-6,
    1e-5,
    1e-3,
    0.1,
)  # what a solver may miss of a condition on y to y''', in units of the lift per stroke angleᵏ


def smallest_designs_by_known_law(scene: Scene) -> dict[str, Design]:
    """The smallest cam of each known law, and that of the scene's own laws.

    The known laws are those of [search], or else all that have no corner.
    """
    search, search_scene = scene.search, scene
    chosen_by_law = any(segment.segment in ("rise", "return") for segment in scene.motion)
    if chosen_by_law and not (search.law or search.law_rise or search.law_return):
        smooth_laws = (name for name, law in LAWS.items() if rests_at_both_ends(law))
        search_scene = scene.with_values({"search.law": tuple(smooth_laws)})
    cams = optimise_or_keep_irrelevant_size(search_scene).by_law
    if not any(has_laws_of_scene(row, scene) for row in cams.values()):
        own_scene = scene.with_values(dict.fromkeys(("search.law", "search.law_rise", "search.law_return"), ()))
        cams = {**cams, **optimise_or_keep_irrelevant_size(own_scene).by_law}
    return cams


def has_laws_of_scene(row: Mapping[str, Any], scene: Scene) -> bool:
    """Whether a design has the scene's own laws of rises and of returns."""
    programme = resolve(scene).programme
    return (row["law_rise"], row["law_return"]) == (programme.law_names(RISE), programme.law_names(RETURN))


def known_cam_with_objective_terms(problem: SynthesisProblem, row: Design) -> Design:
    """The cam of a known law with its objective terms; ``within`` says if it meets all limits of the free laws."""
    programme, size = _programme_of_design(problem, row), row[problem.scene_problem.size_quantity_name]
    terms = {name: objective_term_value(problem, programme, name, size) for name in problem.objective}
    columns: dict[str, Any] = {**terms, **row, "within": not limits_broken_by_cam(problem, row)}
    return Design(columns, row.searched)


def limits_broken_by_cam(problem: SynthesisProblem, row: Design) -> list[str]:
    """Names of the free laws' limits that the cam of a known law breaks: limits, jumps and the size."""
    programme, size = _programme_of_design(problem, row), row[problem.scene_problem.size_quantity_name]
    jumps = {DERIVATIVE_NAMES[jump.order] for jump in programme.jumps if jump.order <= problem.rest}
    broken = [f"no jump of {name}" for name in sorted(jumps)] + list(limits_broken_by_motion(problem, programme))
    return list(
        dict.fromkeys(broken + [SIZE_WORDS] * (size > largest_cam_size(problem) * (1.0 + LEAST_DERIVATIVE)))
    )


def largest_cam_size(problem: SynthesisProblem) -> float:
    """Largest cam size allowed [mm]; infinite without a limit."""
    return problem.prime_range[1] - problem.prime_less_cam_radius


def _programme_of_design(problem: SynthesisProblem, row: Design) -> Programme:
    """The motion of a turn with the known laws of a design."""
    scene_problem = problem.scene_problem
    return scene_problem.given_motion_with_laws(
        *(name if name in scene_problem.laws else None for name in (row["law_rise"], row["law_return"]))
    )


def optimise_or_keep_irrelevant_size(scene: Scene) -> Optimum:
    """Smallest cam of each law (``optimise``).

    The scene's own size is kept if no limit or objective depends on it.
    """
    scene_problem = resolve(scene)
    if nothing_depends_on_size(scene_problem, objective_weights(scene.synthesis)):
        scene = scene.with_values({scene_problem.variables[0].search_key: (float(scene_problem.design.size[0]),)})
    return optimise(scene)


def smallest_or_nearest_design(scene_problem: Problem, objective_terms: Collection[str]) -> Designs | None:
    """The smallest design that meets all limits, else one that breaks them by little; None if neither is found.

    If nothing depends on the size, the design has the scene's own.
    """
    budget, own_size = Budget(OPTIMISE_WORK), float(scene_problem.design.size[0])
    fixed_size: SizeBounds = (
        {"size": (own_size, own_size)} if nothing_depends_on_size(scene_problem, objective_terms) else {}
    )
    optima = sorted(
        (
            solve_smallest_cam(scene_problem, {**bounds, **fixed_size}, budget)
            for bounds in search_boxes(scene_problem)
        ),
        key=lambda optimum: optimum.size,
    )
    designs = (*(optimum.design for optimum in optima), *(optimum.nearest for optimum in optima))
    return next((design for design in designs if design is not None), None)


def nothing_depends_on_size(scene_problem: Problem, objective_terms: Collection[str]) -> bool:
    """Whether the size stays the scene's own: no search, no limit and no objective depends on it."""
    is_limited = any(limit.set_by_scene and not limit.is_decided_by_motion_alone for limit in scene_problem.limits)
    is_variable = "size" in scene_problem.search_space.variables or "size" in objective_terms
    return not (is_limited or is_variable or isnan(scene_problem.design.size[0]))


def scene_with_laws(scene: Scene, problem: SynthesisProblem, iterate: "Iterate") -> Scene:
    """The scene with free laws in place of its own."""
    data, strokes = scene.to_dict(), iter(strokes_with_laws(problem, iterate))
    laws = data.setdefault("laws", {})
    for segment in data["motion"]:
        stroke = next(strokes) if segment["angle"] > 0.0 else None
        if stroke is None or not stroke.is_law_replaceable:
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


def strokes_with_laws(problem: SynthesisProblem, iterate: "Iterate") -> tuple[Stroke, ...]:
    """The strokes of a problem with free laws."""
    free = iter(zip(free_law_names(problem.scene_problem.segments), iterate.coefficients, strict=True))
    return tuple(
        problem.splines_by_stroke[stroke].stroke_with_law(stroke, *next(free), problem.motion_unit)
        if stroke.is_law_replaceable
        else stroke
        for stroke in problem.strokes
    )


def programme_with_laws(problem: SynthesisProblem, iterate: "Iterate") -> Programme:
    """The motion of a turn with free laws: of the tool, if there is a train."""
    own_programme, strokes = problem.scene_problem.programme.tool, strokes_with_laws(problem, iterate)
    return replace(
        own_programme, strokes=strokes, start=strokes[0].low / own_programme.unit_in_mm_or_rad
    ).on_base_circle()


def motion_holds_limits(problem: SynthesisProblem, programme: Programme) -> bool:
    """Whether a motion meets its limits and conditions, evaluated on the motion itself."""
    return next(limits_broken_by_motion(problem, programme), None) is None


def limits_broken_by_motion(problem: SynthesisProblem, programme: Programme) -> Iterator[str]:
    """Names of the limits and conditions that a motion breaks, repeated for each stroke."""
    for stroke, ranges in zip(programme.strokes, problem.derivative_ranges, strict=True):
        for order, (low, high) in ranges.items():
            least, largest = weighted_derivative_range(Programme((stroke,)), (0.0,) * order + (1.0,), ALL_STROKES)
            rounding = LEAST_DERIVATIVE * max(abs(end) for end in (low, high) if isfinite(end))
            if least < low - rounding or largest > high + rounding:
                yield DERIVATIVE_NAMES[order]
    if (
        problem.residual_limit is not None
        and objective_term_value(problem, programme, residual.RESIDUAL_TERM, 0.0) > problem.residual_limit
    ):
        yield residual.RESIDUAL_TERM
    origin_shift = problem.strokes[0].low - programme.strokes[0].low  # the base circle may differ
    for stroke in (item for item in programme.strokes if item.is_law_replaceable):
        for condition in problem.conditions:
            values = stroke.values_under_condition(condition) + origin_shift * (condition.order == 0)
            slack = CONDITION_SLACKS[condition.order] * problem.motion_unit / stroke.angle**condition.order
            if not np.all((values >= condition.low - slack) & (values <= condition.high + slack)):
                yield condition.key


def smallest_cam_for_laws(original_scene: Scene, problem: SynthesisProblem, iterate: "Iterate") -> Synthesis | None:
    """The smallest cam for free laws under every limit of the scene; None if there is none."""
    scene = scene_with_laws(original_scene, problem, iterate)
    best, size = optimise_or_keep_irrelevant_size(scene).best, problem.scene_problem.size_quantity_name
    if best is not None and problem.has_convex_size_constraints:
        cam_problem = resolve(scene.with_row(best))
        # rounding may hide if the cam holds a limit on which its law lies over an arc
        if not cam_problem.robust_errors and UNDECIDED in certify_limits(cam_problem, cam_problem.design).values():
            larger = scene.replace(**{f"search.{size.removesuffix('_mm')}": [best[size] * (1.0 + STEP_BACK)]})
            best = optimise_or_keep_irrelevant_size(larger).best or best
    if best is None or best[size] > largest_cam_size(problem):
        return None
    # evaluated from the motion itself, not taken from the solver
    programme = programme_with_laws(problem, iterate)
    objective = sum(
        weight * objective_term_value(problem, programme, name, best[size])
        for name, weight in problem.objective.items()
    )
    return Synthesis(original_scene, scene.with_row(best), best, objective)


def objective_term_value(problem: SynthesisProblem, programme: Programme, name: str, size: float) -> float:
    """An objective term in its own unit, from the motion itself or the size."""
    if name == "size":
        return size
    if name == residual.RESIDUAL_TERM:
        return float(
            problem.term_unit_factors[name]
            * vibration_extremes(programme, *problem.train_frequency_and_damping).residual
        )
    if name == CROSSING_JERK:
        return problem.term_unit_factors[name] * largest_jerk_after_crossings(
            programme, problem.crossing_window, problem.crossings
        )
    if name == LOST_AREA:
        area = 2.0 * pi * derivative_power_mean(programme, 0, 1)
        return problem.term_unit_factors[name] * (problem.lift_times_turn_angle - area)
    if name in TERM_ORDERS:
        return problem.term_unit_factors[name] * derivative_peak(programme, TERM_ORDERS[name], ALL_STROKES)
    return problem.term_unit_factors[name] * derivative_root_mean_square(programme, RMS_TERM_ORDERS[name])

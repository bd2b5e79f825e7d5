"""Free laws as laws of a scene, and the smallest cams for them."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from math import isfinite, isnan, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.numerics.clock import now
from camopt.model.effects.vibration import vibration
from camopt.model.mechanisms.design import Designs, SizeBounds
from camopt.model.motion import LAWS
from camopt.model.motion.law import is_still
from camopt.model.motion.programme import Programme, mean_of_powers, peak, root_mean_square, span
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.stroke import ALL_STROKES, DERIVATIVE_NAMES, RETURN, RISE, Condition, Stroke
from camopt.scene.problem.problem import Problem, resolve
from camopt.scene.problem.space import boxes_of
from camopt.scene.scene import Scene
from camopt.solve.smallest.optimise import SECONDS, optimise
from camopt.solve.smallest.optimum import Optimum
from camopt.solve.smallest.smallest import smallest
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.crossing_jerk import crossing_jerk
from camopt.solve.synthesis.demand import CROSSING_JERK, LOST_AREA, SIZE_WORDS, SQUARES, TERM_ORDERS, Demand
from camopt.solve.synthesis.from_scene import objective_in
from camopt.solve.synthesis.synthesised import Synthesis, free_names
from camopt.solve.tables.designs import Design

if TYPE_CHECKING:
    from camopt.solve.synthesis.iterate import Iterate

LEAST_DERIVATIVE = 1e-12  # of the range of a derivative: rounding
OFF = (1e-6, 1e-5, 1e-3, 0.1)  # of the lift by the stroke's angle: by how much a solver may miss a condition


def known_laws(scene: Scene) -> dict[str, Design]:
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


def known_row(demand: Demand, row: Design) -> Design:
    """A known law's cam with what it has of the objective, and whether it holds all that free laws hold."""
    programme, size = _programme_of(demand, row), row[demand.problem.size_name]
    terms = {name: term_of(demand, programme, name, size) for name in demand.objective}
    known: dict[str, Any] = {**terms, **row, "within": not beyond(demand, row)}
    return Design(known, row.searched)


def beyond(demand: Demand, row: Design) -> list[str]:
    """What a known law's cam breaks of all that free laws hold: names of limits, jumps, and the size."""
    programme, size = _programme_of(demand, row), row[demand.problem.size_name]
    jumps = {DERIVATIVE_NAMES[jump.order] for jump in programme.jumps if jump.order <= demand.rest}
    found = [f"no jump of {name}" for name in sorted(jumps)] + list(broken_by(demand, programme))
    return list(dict.fromkeys(found + [SIZE_WORDS] * (size > largest_size(demand) * (1.0 + LEAST_DERIVATIVE))))


def largest_size(demand: Demand) -> float:
    """Of the cam, mm; infinite if nothing keeps it from being larger."""
    return demand.prime[1] - demand.roller


def _programme_of(demand: Demand, row: Design) -> Programme:
    """The turn with the known laws of a design."""
    problem = demand.problem
    return problem.asked_by(*(name if name in problem.laws else None for name in law_names_of(row)))


def smallest_cams(scene: Scene) -> Optimum:
    """The result of ``optimise``; with the scene's own size if neither limits nor objective depend on it."""
    problem = resolve(scene)
    if has_own_size(problem, objective_in(scene.synthesis)):
        scene = scene.with_values({problem.variables[0].searched: (float(problem.design.size[0]),)})
    return optimise(scene)


def smallest_design(problem: Problem, objective: Collection[str]) -> Designs | None:
    """The smallest design that holds all limits; else one that breaks them by little, if any is found.

    Of the scene's own size where neither limits nor the terms of the objective bear on it.
    """
    until, own = now() + SECONDS, float(problem.design.size[0])
    kept: SizeBounds = {"size": (own, own)} if has_own_size(problem, objective) else {}
    boxes = [{**bounds, **kept} for bounds in boxes_of(problem)]
    answers = sorted((smallest(problem, bounds, until) for bounds in boxes), key=lambda each: each.size)
    found = (*(each.design for each in answers), *(each.nearest for each in answers))
    return next((design for design in found if design is not None), None)


def has_own_size(problem: Problem, objective: Collection[str]) -> bool:
    """Whether the size is the scene's own: neither its search, nor limits, nor the objective bear on it."""
    limited = any(limit.asked and not limit.is_of_motion for limit in problem.limits)
    sought = "size" in problem.choices.variables or "size" in objective
    return not (limited or sought or isnan(problem.design.size[0]))


def scene_with_laws(scene: Scene, demand: Demand, found: "Iterate") -> Scene:
    """The scene of a demand with free laws in place of its own."""
    data, strokes = scene.to_dict(), iter(strokes_with(demand, found))
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
            start = demand.zero + stroke.low / stroke.size
            laws[law.NAME]["positions"] = [start + value for value in values]
            segment["to"] = laws[law.NAME]["positions"][-1]
        else:
            laws[law.NAME]["coefficients"] = values
    for key in ("law", "law_rise", "law_return"):
        data.get("search", {}).pop(key, None)
    return Scene.from_dict(data, scene.file)


def strokes_with(demand: Demand, found: "Iterate") -> tuple[Stroke, ...]:
    """The strokes of a demand with free laws."""
    free = iter(zip(free_names(demand.problem.segments), found.coefficients, strict=True))
    return tuple(
        demand.splines_of(stroke).on(stroke, *next(free), demand.scale) if stroke.is_free else stroke
        for stroke in demand.strokes
    )


def programme_with(demand: Demand, found: "Iterate") -> Programme:
    """The turn with free laws, which is asked of the tool where there is a train."""
    own, strokes = demand.problem.programme.tool, strokes_with(demand, found)
    return replace(own, strokes=strokes, start=strokes[0].low / own.unit).on_base_circle()


def within(demand: Demand, programme: Programme) -> bool:
    """Whether a motion itself, not a solver's word, holds the limits on it and the conditions."""
    return next(broken_by(demand, programme), None) is None


def broken_by(demand: Demand, programme: Programme) -> Iterator[str]:
    """The names of the limits on the motion, and of the conditions, that a motion breaks; again for each stroke."""
    for stroke, ranges in zip(programme.strokes, demand.ranges, strict=True):
        for order, (low, high) in ranges.items():
            least, largest = span(Programme((stroke,)), (0.0,) * order + (1.0,), ALL_STROKES)
            rounding = LEAST_DERIVATIVE * max(abs(end) for end in (low, high) if isfinite(end))
            if least < low - rounding or largest > high + rounding:
                yield DERIVATIVE_NAMES[order]
    if demand.residual is not None and term_of(demand, programme, residual.TERM, 0.0) > demand.residual:
        yield residual.TERM
    up = demand.strokes[0].low - programme.strokes[0].low  # the base circle may be another
    for stroke in (each for each in programme.strokes if each.is_free):
        yield from (each.key for each in demand.conditions if not _meets(demand, stroke, up, each))


def _meets(demand: Demand, stroke: Stroke, up: float, condition: Condition) -> bool:
    """Whether a stroke meets a condition, as far as a solver can."""
    values = stroke.values_at(condition) + up * (condition.order == 0)
    room = OFF[condition.order] * demand.scale / stroke.angle**condition.order
    return bool(np.all((values >= condition.low - room) & (values <= condition.high + room)))


def cam_for(asked: Scene, demand: Demand, found: "Iterate") -> Synthesis | None:
    """The smallest cam for free laws, proved, under every limit of the scene; None if there is none."""
    scene = scene_with_laws(asked, demand, found)
    best = smallest_cams(scene).best
    if best is None:
        return None
    size = demand.problem.size_name
    if best[size] > largest_size(demand):
        return None
    # the objective of free laws and a size, from the motion itself
    programme = programme_with(demand, found)
    objective = sum(
        weight * term_of(demand, programme, name, best[size]) for name, weight in demand.objective.items()
    )
    return Synthesis(asked, scene.with_row(best), best, objective)


def term_of(demand: Demand, programme: Programme, name: str, size: float) -> float:
    """A term of the objective, from the motion itself or the size."""
    if name == "size":
        return size
    if name == residual.TERM:
        return float(demand.per_unit[name] * vibration(programme, *demand.train).residual)
    if name == CROSSING_JERK:
        return demand.per_unit[name] * crossing_jerk(programme, demand.window, demand.crossings)
    if name == LOST_AREA:
        area = 2.0 * pi * mean_of_powers(programme, 0, 1)
        return demand.per_unit[name] * (demand.largest_area - area)
    if name in TERM_ORDERS:
        return demand.per_unit[name] * peak(programme, TERM_ORDERS[name], ALL_STROKES)
    return demand.per_unit[name] * root_mean_square(programme, SQUARES[name])

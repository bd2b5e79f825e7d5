"""Free laws as laws of a scene, and the smallest cams for them."""

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from camopt.effects.vibration import vibration
from camopt.mechanisms import Designs
from camopt.motion import LAWS
from camopt.motion.law import is_still
from camopt.motion.programme import Programme, peak, root_mean_square, span
from camopt.motion.spline import SplineLaw
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics.clock import now
from camopt.problem.problem import Problem, resolve
from camopt.problem.space import boxes_of
from camopt.scene.scene import Scene
from camopt.smallest.optimise import SECONDS, Optimum, optimise
from camopt.smallest.smallest import smallest
from camopt.synthesis import residual
from camopt.synthesis.convex import SQUARES
from camopt.synthesis.demand import ORDERS, Demand
from camopt.synthesis.from_scene import objective_in
from camopt.synthesis.iterate import Iterate
from camopt.synthesis.synthesised import Synthesised, free_names
from camopt.tables.designs import Design, chosen

NOTHING = 1e-12  # of the range of a derivative: rounding
OFF_POINT = 1e-6  # of the lift: by how much a solver may miss a point


def known_laws(scene: Scene) -> dict[str, Design]:
    """The smallest cam of each known law: those of [search] or all without a corner, and the scene's own."""
    named = scene.search.law or scene.search.law_rise or scene.search.law_return
    known = [name for name, law in LAWS.items() if is_still(law)]
    found = smallest_cams(scene if named else scene.replace(**{"search.law": known})).by_law
    own = scene.replace(**dict.fromkeys(("search.law", "search.law_rise", "search.law_return")))
    if not any(own_laws(scene) == law_names_of(row) for row in found.values()):
        found = {**found, **smallest_cams(own).by_law}
    return found


def own_laws(scene: Scene) -> tuple[str, str]:
    """The names of the scene's own laws, of rises and of returns, as the rows of designs have them."""
    programme = resolve(scene).programme
    return programme.law_names(RISE), programme.law_names(RETURN)


def law_names_of(row: Mapping[str, Any]) -> tuple[str, str]:
    """The names of the laws of a design's rises and returns."""
    return row["law_rise"], row["law_return"]


def known_row(demand: Demand, row: Design) -> Design:
    """A known law's cam with what it has of the objective, and whether it holds all that free laws hold."""
    problem = demand.problem
    names = (name if name in problem.laws else None for name in law_names_of(row))
    programme, size = problem.with_laws(*names), row[problem.size_name]
    terms = {name: term_of(demand, programme, name, size) for name in demand.objective}
    smooth = all(jump.order > demand.rest for jump in programme.jumps)
    small = size + demand.roller <= demand.prime[1] * (1.0 + NOTHING)
    known = {**terms, **row, "within": small and smooth and within(demand, programme)}
    return Design(known, row.searched)


def smallest_cams(scene: Scene) -> Optimum:
    """What ``optimise`` finds; of the scene's own size where neither limits nor the objective bear on it."""
    return optimise(_with_size_sought(scene))


def smallest_design(problem: Problem) -> Designs | None:
    """The smallest design that holds all limits; else one that breaks them by little, if any is found."""
    sought = resolve(_with_size_sought(problem.scene)).with_programme(problem.programme)
    until = now() + SECONDS
    answers = sorted((smallest(sought, bounds, until) for bounds in boxes_of(sought)), key=lambda each: each.size)
    found = (*(each.design for each in answers), *(each.nearest for each in answers))
    return next((design for design in found if design is not None), None)


def _with_size_sought(scene: Scene) -> Scene:
    key = "base_radius" if scene.cam.form == "disc" else "mean_radius"
    own, sought = getattr(scene.cam, key), getattr(scene.search, key)
    limited = any(limit.asked and not limit.of_motion for limit in resolve(scene).limits)
    if own is None or sought is not None or limited or "size" in objective_in(scene.synthesis):
        return scene
    return scene.replace(**{f"search.{key}": [own]})


def scene_with(scene: Scene, laws: list[SplineLaw]) -> Scene:
    """The scene with free laws in place of its own."""
    data = scene.to_dict()
    moving = [segment for segment in data["motion"] if segment["segment"] != "dwell"]
    for segment, law in zip(moving, laws, strict=True):
        segment["law"] = law.NAME
        data.setdefault("laws", {})[law.NAME] = {
            "degree": law.degree, "knots": list(law.knots), "coefficients": list(law.coefficients),
        }  # fmt: skip
    for key in ("law", "law_rise", "law_return"):
        data.get("search", {}).pop(key, None)
    return Scene.from_dict(data, scene.file)


def free_laws(demand: Demand, found: Iterate) -> list[SplineLaw]:
    """The laws of a solution, by the order of their strokes."""
    return list(map(demand.splines.law, free_names(demand.problem.scene), found.coefficients))


def programme_with(demand: Demand, found: Iterate) -> Programme:
    """The turn with free laws."""
    laws = iter(free_laws(demand, found))
    strokes = tuple(s if s.kind == DWELL else replace(s, law=next(laws)) for s in demand.strokes)
    return replace(demand.problem.programme, strokes=strokes)


def within(demand: Demand, programme: Programme) -> bool:
    """Whether laws themselves, not a solver's word, hold the limits on their motion alone, and the points."""
    for stroke, ranges in zip(programme.strokes, demand.ranges, strict=True):
        for order, (low, high) in ranges.items():
            least, largest = span(Programme((stroke,)), (0.0,) * order + (1.0,), TURN)
            rounding = NOTHING * max(abs(end) for end in (low, high) if isfinite(end))
            if least < low - rounding or largest > high + rounding:
                return False
    if demand.residual is not None and term_of(demand, programme, residual.TERM, 0.0) > demand.residual:
        return False
    angles, wanted = np.array(demand.points).reshape(-1, 2).T
    return bool(np.all(np.abs(programme.at(angles)[0] - wanted) <= OFF_POINT * demand.scale))


def cam_for(demand: Demand, found: Iterate) -> Synthesised | None:
    """The smallest cam for free laws, proved, under every limit of the scene; None if there is none."""
    scene = scene_with(demand.problem.scene, free_laws(demand, found))
    best = smallest_cams(scene).best
    if best is None:
        return None
    size = demand.problem.size_name
    if best[size] + demand.roller > demand.prime[1]:
        return None
    objective = objective_of(demand, found, best[size])
    return Synthesised(demand.problem.scene, chosen(scene, best), best, objective)


def objective_of(demand: Demand, found: Iterate, size: float) -> float:
    """The objective of free laws and a size, from the motion itself."""
    programme = programme_with(demand, found)
    return sum(weight * term_of(demand, programme, name, size) for name, weight in demand.objective.items())


def term_of(demand: Demand, programme: Programme, name: str, size: float) -> float:
    """A term of the objective, from the motion itself or the size."""
    if name == "size":
        return size
    if name == residual.TERM:
        return demand.per_unit[name] * vibration(programme, *demand.train).residual
    if name in ORDERS:
        return demand.per_unit[name] * peak(programme, ORDERS[name], TURN)
    return demand.per_unit[name] * root_mean_square(programme, SQUARES[name])

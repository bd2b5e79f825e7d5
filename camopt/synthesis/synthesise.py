"""Synthesis: free motion laws that make the cam smallest, or gentlest, under the limits of a scene.

The convex programme gives laws, and a bound that no law whatever can pass. The laws become laws of the scene, and
the smallest cam for them is found and proved as for any other: every limit of the scene holds in the end, whether
the convex programme knows it or not, and the gap to the bound says what that costs.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from camopt.effects.vibration import vibration
from camopt.mistakes import Unmet, Unsolved
from camopt.motion import LAWS
from camopt.motion.law import Law
from camopt.motion.programme import Programme, Stroke, law_peaks, peak, root_mean_square, span
from camopt.motion.spline import SplineLaw
from camopt.motion.table import DWELL, RISE, TURN
from camopt.question import resolve
from camopt.scene import Scene
from camopt.search.answer import Progress
from camopt.search.optimise import optimise
from camopt.synthesis import residual
from camopt.synthesis.ceilings import ceilings_of
from camopt.synthesis.convex import SOLVED, SQUARES, Convex, convex, solve
from camopt.synthesis.demand import ORDERS, PEAKS, Demand, by_offset, demand_of
from camopt.synthesis.free import FreeMotion
from camopt.synthesis.iterate import Iterate, iterate_of, joined
from camopt.synthesis.relaxation import RelaxedMotion
from camopt.synthesis.steps import Steps

SLACK = 1e-4  # of the unit of the objective, given up for the gentlest jerk among the laws that reach it
SOLVER_ERROR = 1e-6  # relative, of an optimum
PANELS = (96, 64, 32, 16)  # of a stroke in the relaxation: fewer where the solver fails
MARGINS = (1e-7, 1e-6, 1e-5, 1e-4)  # by which limits are held closer than asked, for a solver's error
NOTHING = 1e-12  # of a range that ends at 0: rounding
OFF_POINT = 1e-6  # of the lift: by how much a solver may miss a point
WORSE = 1e-3  # relative: a cam above its convex optimum by more is held by a limit that is not convex


@dataclass(frozen=True)
class Synthesised:
    """Free laws, the smallest cam for them, and how good they are.

    ``scene`` has the laws, the size and the offset, ``design`` is the row that ``optimise`` gives for it. No motion
    whatever that holds the convex limits has an objective below ``bound``; it is None where none was computed.
    """

    scene: Scene
    design: dict[str, Any]
    objective: float
    bound: float | None = None
    convex: bool = True
    """Whether the convex limits alone decide; if not, the laws are a local optimum."""

    @property
    def gap(self) -> float | None:
        """By how much the best law could have less, as a share of the objective."""
        return None if self.bound is None else max(0.0, 1.0 - self.bound / self.objective)

    @cached_property
    def laws(self) -> dict[str, SplineLaw]:
        """The free laws by name."""
        names = free_names(self.scene)
        return {n: law for n, law in resolve(self.scene).laws.items() if n in names and isinstance(law, SplineLaw)}

    @cached_property
    def peaks(self) -> dict[str, dict[str, float | str]]:
        """The peak factors of each free law, inside its stroke: one that meets another has no dwells around it."""
        return {name: {**law_peaks(law), **_inside(law)} for name, law in self.laws.items()}


def _inside(law: Law) -> dict[str, float]:
    """The largest derivatives of a unit stroke, whatever is around it."""
    alone = Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),))
    spans = {name: span(alone, (0.0,) * order + (1.0,), RISE) for name, order in PEAKS.items()}
    return {name: max(-least, largest) for name, (least, largest) in spans.items()}


def peaks_of(row: Mapping[str, Any], result: Synthesised) -> dict[str, float]:
    """The largest peak factors of a row's laws, known or free."""
    peaks = {**{name: law_peaks(law) for name, law in LAWS.items()}, **result.peaks}
    each = [peaks[n] for key in ("law_rise", "law_return") for n in row[key].split("+") if n in peaks]
    return {name: max(float(peaks[name]) for peaks in each) for name in PEAKS if each}


def known_laws(scene: Scene) -> dict[str, dict[str, Any]]:
    """The smallest cam of each known law, for comparison: the laws of [search], or all of them."""
    named = scene.search.law or scene.search.law_rise or scene.search.law_return
    return optimise(scene if named else scene.replace(**{"search.law": list(LAWS)})).by_law


def synthesise(scene: Scene, progress: Progress | None = None) -> Synthesised:
    """Free motion laws for a scene, by its ``[synthesis]``, and the smallest cam for them.

    ``progress`` is called with (starts done, starts in all).

    Raises
    ------
    BadInput
        If nothing limits the size from below.
    Unmet
        If no free law holds all limits.
    Unsolved
        If a solver fails.
    """
    advance = progress or (lambda done, most: None)
    demands = by_offset(demand_of(resolve(scene)))
    bounds = [bound_of(demand) for demand in demands]
    cams, why = [], Unmet("no motion whatever holds all limits")
    for demand, bound in zip(demands, bounds, strict=True):
        try:
            cams += [_best(demand, advance)] if bound != inf else []
        except Unmet as reason:
            why = reason
    if not cams:
        raise why
    best = min(cams, key=lambda cam: cam.objective)
    known = [bound for bound in bounds if bound is not None]
    right = len(known) == len(bounds) and min(known) <= best.objective  # or else a solver erred
    return replace(best, bound=min(known) if right else None)


def _best(demand: Demand, advance: Progress) -> Synthesised:
    """The best free laws of a demand."""
    model, start, least = solved(demand)
    found = cam_for(demand, start)
    free = found is not None and found.objective <= least + WORSE * (abs(least) + model.unit)
    if not free and ceilings_of(demand):
        cams = [*([found] if found else []), *_bent(model, demand, start, advance)]
        found = min(cams, key=lambda cam: cam.objective, default=None)
    if found is None:
        raise Unmet("these free laws hold the convex limits, but then no cam holds the others")
    return replace(found, convex=free)


def bound_of(demand: Demand) -> float | None:
    """What no motion whatever can pass; infinite if none holds the limits, None if the solver gives no bound.

    Nothing convex bounds the size of a cam whose follower oscillates.
    """
    wider = tightened(demand, -SOLVER_ERROR)  # then a solver's error leaves it below
    for panels in PANELS:
        relaxed = convex(wider, partial(RelaxedMotion, panels))
        try:
            value = relaxed.solve()
        except Unsolved:
            continue
        if relaxed.exact:
            unknown = "size" in demand.objective and not demand.sized and value < inf
            return None if unknown else lowered(relaxed, value)
    return None


def lowered(relaxed: Convex, value: float) -> float:
    """An optimum less what a solver may err by."""
    return max(value - SOLVER_ERROR * (value + relaxed.unit), 0.0) if value < inf else inf


def solved(demand: Demand) -> tuple[Convex, Iterate, float]:
    """The convex programme with free laws, its solution and its least objective.

    Among the laws that reach it the one of the gentlest jerk is taken. Margins widen until the laws hold the
    ranges of their derivatives exactly.
    """
    for margin in MARGINS:
        model = convex(tightened(demand, margin), FreeMotion)
        least = model.solve()
        if least == inf:
            raise Unmet("no free law of this kind holds all limits; more pieces may")
        found = iterate_of(model)
        calm = gentlest(model, least)
        for each in (calm, found):
            if each is not None and within(demand, programme_with(demand, each)):
                return model, each, least
    raise Unsolved("the convex solver does not hold the limits closely enough")


def gentlest(model: Convex, least: float) -> Iterate | None:
    """The laws of the least mean square of the jerk at nearly the least objective; None if the solver fails."""
    jerk = cp.norm(cp.hstack([motion.square(3) for motion in model.motions if motion]))
    close = model.goal <= least / model.unit + SLACK
    problem = cp.Problem(cp.Minimize(jerk), [*model.problem.constraints, close])
    return iterate_of(model) if solve(problem) in SOLVED else None


def tightened(demand: Demand, margin: float) -> Demand:
    """The demand with limits held closer by a share."""
    kept = 1.0 - margin
    return replace(
        demand,
        ranges=tuple({k: (kept * low, kept * high) for k, (low, high) in row.items()} for row in demand.ranges),
        floors=tuple(replace(f, constant=f.constant - margin * abs(f.constant)) for f in demand.floors),
        prime=(demand.prime[0], max(demand.prime[0], kept * demand.prime[1])),
        residual=None if demand.residual is None else kept * demand.residual,
    )


def free_names(scene: Scene) -> list[str]:
    """Names for the free laws of a scene's moving segments, in order."""
    kinds = [segment.segment for segment in scene.motion if segment.segment != "dwell"]
    counts = [kinds[: n + 1].count(kind) for n, kind in enumerate(kinds)]
    return [f"free-{k}-{n}" if kinds.count(k) > 1 else f"free-{k}" for k, n in zip(kinds, counts, strict=True)]


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
    return list(map(demand.splines.law, free_names(demand.question.scene), found.coefficients))


def programme_with(demand: Demand, found: Iterate) -> Programme:
    """The turn with free laws."""
    laws = iter(free_laws(demand, found))
    strokes = tuple(s if s.kind == DWELL else replace(s, law=next(laws)) for s in demand.strokes)
    return replace(demand.question.programme, strokes=strokes)


def within(demand: Demand, programme: Programme) -> bool:
    """Whether laws themselves, not a solver's word, hold the limits on their motion alone, and the points."""
    for stroke, ranges in zip(programme.strokes, demand.ranges, strict=True):
        for order, (low, high) in ranges.items():
            least, largest = span(Programme((stroke,)), (0.0,) * order + (1.0,), TURN)
            rounding = NOTHING * (high - low)
            if least < low - rounding * (low == 0.0) or largest > high + rounding * (high == 0.0):
                return False
    if demand.residual is not None and vibration(programme, *demand.train).residual > demand.residual:
        return False
    angles, wanted = np.array(demand.points).reshape(-1, 2).T
    return bool(np.all(np.abs(programme.at(angles)[0] - wanted) <= OFF_POINT * demand.scale))


def cam_for(demand: Demand, found: Iterate) -> Synthesised | None:
    """The smallest cam for free laws, proved, under every limit of the scene; None if there is none."""
    scene = scene_with(demand.question.scene, free_laws(demand, found))
    best = optimise(scene).best
    if best is None:
        return None
    size = demand.question.size_name
    if best[size] + demand.roller > demand.prime[1]:
        return None
    return Synthesised(chosen(scene, best), best, objective_of(demand, found, best[size]))


def chosen(scene: Scene, row: Mapping[str, Any]) -> Scene:
    """The scene with the sizes of a row."""
    size = "base_radius" if scene.cam.form == "disc" else "mean_radius"
    changes = {f"cam.{size}": row[f"{size}_mm"]}
    for name in ("offset", "roller_radius", "face_radius", "arm_length", "centre_distance", "face_offset"):
        if f"{name}_mm" in row and getattr(scene.follower, name) is not None:
            changes[f"follower.{name}"] = row[f"{name}_mm"] + 0.0  # no −0
    return scene.replace(**changes)


def objective_of(demand: Demand, found: Iterate, size: float) -> float:
    """The objective of free laws and a size, from the motion itself."""
    programme = programme_with(demand, found)
    return sum(weight * term_of(demand, programme, name, size) for name, weight in demand.objective.items())


def term_of(demand: Demand, programme: Programme, name: str, size: float) -> float:
    """A term of the objective, from the motion itself or the size."""
    if name == "size":
        return size
    if name == residual.TERM:
        return vibration(programme, *demand.train).residual
    if name in ORDERS:
        return demand.per_unit[name] * peak(programme, ORDERS[name], TURN)
    return demand.per_unit[name] * root_mean_square(programme, SQUARES[name])


def _bent(model: Convex, demand: Demand, start: Iterate, advance: Progress) -> list[Synthesised]:
    """The cams that convex steps reach from the convex optimum and from known laws."""
    starts = [start, *placed(demand, start)]
    ceilings = ceilings_of(demand)
    steps = Steps(model, ceilings)
    found = []
    for number, each in enumerate(starts):
        advance(number, len(starts))
        last = steps.run(each, ceilings)
        if within(demand, programme_with(demand, last)) and (cam := cam_for(demand, last)):
            found.append(cam)
    return found


def placed(demand: Demand, start: Iterate) -> list[Iterate]:
    """Laws on the smallest cam for them: the known ones within the limits, and the convex optimum.

    Not the latter where the size is part of it: it lies on its smallest cam already, but for other limits.
    """
    laws = [*([] if demand.sized else [start]), *_known(demand, start)]
    return [_placed(demand, each) for each in laws]


def _known(demand: Demand, start: Iterate) -> Iterator[Iterate]:
    """The known laws that are splines of this kind to rounding, or near them, and within the limits."""
    x = (np.arange(4 * demand.splines.count) + 0.5) / (4 * demand.splines.count)
    for law in LAWS.values():
        fit = np.linalg.lstsq(demand.splines.at(x, 0).toarray(), law.displacement(x), rcond=None)[0]
        known = start._replace(coefficients=joined(demand, [fit] * len(start.coefficients)))
        if within(demand, programme_with(demand, known)):
            yield known


def _placed(demand: Demand, known: Iterate) -> Iterate:
    """Laws on the smallest cam for them, or on the one that misses its limits the least."""
    found = optimise(scene_with(demand.question.scene, free_laws(demand, known)))
    row = found.best or found.nearest_miss
    if row is None:
        return known
    lead = demand.question.design.sense * row.get("offset_mm", 0.0)
    prime = row[demand.question.size_name] + demand.roller
    return known._replace(lead=lead / demand.length, height=sqrt(prime**2 - lead**2) / demand.length)

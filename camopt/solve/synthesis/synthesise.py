"""Synthesis: free motion laws that make the cam smallest, or gentlest, under the limits of a scene.

The convex programme gives laws, and a bound that no law whatever can pass. The laws become laws of the scene, and
the smallest cam for them is found and proved as for any other: every limit of the scene holds in the end, whether
the convex programme knows it or not, and the gap to the bound says what that costs.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from camopt.core.engines.progress import Advance, Progress, report_progress, with_progress_bar
from camopt.core.mistakes import Unmet, Unsolved
from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable import difference_of_squares_root
from camopt.model.motion import LAWS
from camopt.model.motion.law import Law
from camopt.model.motion.stroke import Stroke
from camopt.scene.arguments import SceneSource, options_by_keyword, scene_from
from camopt.scene.scene import Scene
from camopt.solve.smallest.price import Prices
from camopt.solve.smallest.prices import prices
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.cams import (
    cam_for,
    programme_with,
    scene_with_laws,
    smallest_cams,
    smallest_design,
    within,
)
from camopt.solve.synthesis.ceilings import ceilings_of
from camopt.solve.synthesis.convex import Convex, convex
from camopt.solve.synthesis.crossings import with_crossings
from camopt.solve.synthesis.demand import CROSSING_JERK, LIMIT_MARGINS, Demand, tightened
from camopt.solve.synthesis.from_scene import by_offset, demand_of, objective_in
from camopt.solve.synthesis.iterate import Iterate, cleaned, iterate_of
from camopt.solve.synthesis.linear_constraints import with_offs
from camopt.solve.synthesis.prices import prices_of_laws
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.solver import SOLVER_ENDS, SOLVER_ERROR, solve
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesised import Synthesis
from camopt.solve.synthesis.units import objective_unit
from camopt.solve.synthesis.unmet import contradiction, no_cam
from camopt.solve.tables.designs import joined_laws

GENTLE_SLACK = 1e-4  # of the unit of the objective, given up for the gentlest jerk among the laws that reach it
PANEL_COUNTS = (96, 64, 32, 16)  # of a stroke in the relaxation: fewer where the solver fails
MISSES_SHOWN = 3  # laws whose cams miss the limits, for what they reach
ROBUST_ROUNDS = 2  # of what tolerances take of limits: at the sizes of the optimum before
WORSE = 1e-3  # relative: a cam above its convex optimum by more is held by a limit that is not convex


@options_by_keyword
@with_progress_bar("starts")
def synthesise(scene: SceneSource, *, progress: Progress | None = None) -> Synthesis:
    """Compute new motion laws for a scene, as its ``[synthesis]`` asks, and the smallest cam for them.

    With ``search.robust`` the cam is a robust one, as of ``optimise``: every cam within the tolerances of its
    numbers holds each limit. Laws hold linear limits less what tolerances take of them, and in convex steps the
    curves of all cams at the corners of the tolerances; the bound is that of nominal cams.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        The limits, the ranges of sizes, and ``[synthesis]``.
    progress : callable or True, optional
        True shows a progress bar. A function is called with (starting points done, starting points in all).
        If it returns False, the search ends.

    Returns
    -------
    Synthesis
        The laws, the smallest cam for them with its scene, and a bound that no motion can pass.

    Raises
    ------
    BadInput
        If nothing limits the size from below, and it is part of the objective.
    Unmet
        If no new law meets all limits.
    Unsolved
        If the convex solver fails.
    Stopped
        If ``progress`` returned False.

    References
    ----------
    S. Boyd, L. Vandenberghe, Convex Optimization; C. de Boor, A Practical Guide to Splines, ch. IX.

    Examples
    --------
    >>> coarse = camopt.find_scene("roller-1000rpm").replace(**{"synthesis.pieces": 12})
    >>> round(camopt.synthesise(coarse).design["base_radius_mm"], 1)
    39.8
    """
    scene = scene_from(scene)
    demands = by_offset(demand_of(scene))
    bounds: list[float | None]
    if CROSSING_JERK in demands[0].objective:
        demands, bounds = map(list, zip(*map(with_crossings, demands), strict=True))
    else:
        bounds = [bound_of(demand) for demand in demands]
    some = [demand for demand, bound in zip(demands, bounds, strict=True) if bound != inf]
    if not some:
        raise contradiction(scene, demands[0], bound_of)
    best, _ = best_of(scene, some, partial(report_progress, progress))
    known = [bound for bound in bounds if bound is not None]
    right = len(known) == len(bounds) and min(known) <= best.objective  # or else a solver erred
    return replace(best, bound=min(known) if right else None)


def best_of(scene: Scene, demands: Sequence[Demand], advance: Advance) -> tuple[Synthesis, Iterate]:
    """The best cam of some demands of a scene, without a bound, and its free laws.

    Raises
    ------
    Unmet
        If no free laws meet any of them.
    Unsolved
        If the convex solver fails.
    """
    found, why = [], Unmet("")
    for demand in demands:
        try:
            found.append(_best(scene, demand, advance))
        except Unmet as reason:
            why = reason
    if not found:
        raise why
    return _least(found)


def _best(scene: Scene, demand: Demand, advance: Advance) -> tuple[Synthesis, Iterate]:
    """The best free laws of a demand, and their cam."""
    advance(0, 1)  # as far as is known: where the convex optimum is a cam, nothing starts from other laws
    demand = within_tolerances(demand)
    ceilings = ceilings_of(demand)
    for first in range(len(LIMIT_MARGINS)):
        model, start, least = solved(demand, LIMIT_MARGINS[first:])
        cam = cam_for(scene, demand, start)
        if cam or ceilings:
            break  # if not, a solver's error takes the cam beyond its limits, which a wider margin mends
    found = [(cam, start)] if cam else []
    free = cam is not None and cam.objective <= least + WORSE * (abs(least) + model.unit)
    steps = [] if free or not ceilings else list(_by_convex_steps(scene, model, demand, start, advance))
    found += [(each, last) for each, last in steps if each]
    if not found:  # steps may end where a limit is missed by little, or that they do not know
        known = list(_known(demand, start))
        found = [(cam, laws) for laws in known if (cam := cam_for(scene, demand, laws))]
    if not found:
        tried = [start, *(last for _, last in steps)][:MISSES_SHOWN]
        raise no_cam(scene, demand, [smallest_cams(scene_with_laws(scene, demand, each)) for each in tried])
    cam, laws = _least(found)
    return replace(cam, convex=free), laws


def within_tolerances(demand: Demand) -> Demand:
    """The demand of a robust cam: with limits that all cams which have to hold them do, near its optimum."""
    found = demand
    for _ in range(ROBUST_ROUNDS if demand.problem.offs and demand.floors else 0):
        _, start, _ = solved(found)
        found = with_offs(demand, start.lead * demand.length, start.height * demand.length)
    return found


def _least(found: Sequence[tuple[Synthesis, Iterate]]) -> tuple[Synthesis, Iterate]:
    return min(found, key=lambda each: each[0].objective)


def bound_of(demand: Demand) -> float | None:
    """What no motion whatever can pass; infinite if none holds the limits, None if the solver gives no bound.

    Nothing convex bounds the size of a cam whose follower oscillates.
    """
    wider = tightened(demand, -SOLVER_ERROR)  # then a solver's error leaves it below
    for panels in PANEL_COUNTS:
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


def solved(demand: Demand, margins: Sequence[float] = LIMIT_MARGINS) -> tuple[Convex, Iterate, float]:
    """The convex programme with free laws, its solution and its least objective, or what a smooth one may have.

    Among the laws that reach it the one of the gentlest jerk is taken. Margins widen until the laws hold the
    ranges of their derivatives exactly.
    """
    for margin in margins:
        model = convex(tightened(demand, margin), SplineMotion)
        try:
            least = model.solve()
        except Unsolved:
            if margin == margins[-1]:
                raise
            continue  # with other numbers it may not fail
        if least == inf:
            raise Unmet("no free law with so many pieces holds all limits; try more (synthesis.pieces)")
        found = iterate_of(model)
        least_jerk = gentlest(model, least)
        for each in (least_jerk, found):
            if each is not None and within(demand, programme_with(demand, each)):
                return model, each, model.enough(least)
    raise Unsolved("the convex solver does not hold the limits closely enough")


def gentlest(model: Convex, least: float) -> Iterate | None:
    """The laws of the least mean square of the jerk at nearly the least objective; None if the solver fails."""
    programme, most = model.gentle
    most.value = model.enough(least) / model.unit + GENTLE_SLACK
    return iterate_of(model) if solve(programme) in SOLVER_ENDS else None


def _by_convex_steps(
    scene: Scene, model: Convex, demand: Demand, start: Iterate, advance: Advance
) -> Iterator[tuple[Synthesis | None, Iterate]]:
    """The laws that convex steps reach from the convex optimum and from known laws, and their cams, if any."""
    starts = [start, *starting_laws(demand, start, objective_in(scene.synthesis))]
    ceilings = ceilings_of(demand)
    steps = SequentialConvex(model, ceilings)
    for number, each in enumerate(starts):
        advance(number, len(starts))
        last = steps.run(each, ceilings)
        yield cam_for(scene, demand, last) if within(demand, programme_with(demand, last)) else None, last


def starting_laws(demand: Demand, start: Iterate, objective: Collection[str]) -> list[Iterate]:
    """Laws on the smallest cam for them: the known ones within the limits, and the convex optimum.

    Not the latter where the size is part of it: it lies on its smallest cam already, but for other limits.
    ``objective`` are the terms that the scene minimises.
    """
    if demand.residual is not None:  # known laws have more of it; the steps begin at the nearest that have not
        demand = replace(demand, residual=None, problem=demand.problem.without(f"limits.{residual.TERM}"))
    laws = [*([] if demand.sized else [start]), *_known(demand, start)]
    return [_placed(demand, each, objective) for each in laws]


def _known(demand: Demand, start: Iterate) -> Iterator[Iterate]:
    """The scene's own motion and the known laws, as splines of this kind or near them, where within the limits."""
    own = {id(stroke.law) for stroke in demand.free if not stroke.is_move}
    others = [law for law in LAWS.values() if own and own != {id(law)}]
    for law in (None, *others):
        fits = [_fit(demand, stroke, law) for stroke in demand.free]
        known = start._replace(coefficients=cleaned(demand, fits))
        if within(demand, programme_with(demand, known)):
            yield known


def _fit(demand: Demand, stroke: Stroke, law: Law | None) -> FloatArray:
    """The spline nearest to a known law on a rise or return, or to the scene's own, which a move keeps."""
    splines = demand.splines_of(stroke)
    x = (np.arange(4 * splines.count) + 0.5) / (4 * splines.count)
    low, change = demand.law_scale(stroke)
    own = (stroke.motion(stroke.start + x * stroke.angle)[0] / demand.scale - low) / change
    values = own if law is None or stroke.is_move else law.displacement(x)
    return np.asarray(np.linalg.lstsq(splines.at(x, 0).toarray(), values, rcond=None)[0])


def _placed(demand: Demand, known: Iterate, objective: Collection[str]) -> Iterate:
    """Laws on the smallest cam for them, or on one that misses its limits by little."""
    cam = smallest_design(demand.problem.moving(programme_with(demand, known)), objective)
    if cam is None:
        return known
    lead, prime = float(cam.sense * cam.offset[0]), float(cam.size[0]) + demand.roller
    return known._replace(
        lead=lead / demand.length, height=float(difference_of_squares_root(prime, lead)) / demand.length
    )


@prices.register
def _prices_of_free_laws(result: Synthesis, seconds: float | None = None) -> Prices:
    """By the laws of the cam, as those of known laws."""
    laws = joined_laws(result.design["law_rise"], result.design["law_return"])
    return Prices({laws: prices_of_laws(result)}, objective_unit(result.asked))

"""Little jerk where the force turns round: a roller with clearance then lands softly on the other flank.

A follower of the mass m without spring and load is pushed by F = m·y''. In a rise F turns round once, at θ_c, from
pushing to pulling. The roller leaves its flank there and lands on the other one once

    ∫∫ (−y'') dθ² = y(θ_c) + W·y'(θ_c) − y(θ_c + W) ≥ j

after an angle W, with the clearance j along the motion: that of the groove over the cosine of the largest pressure
angle that is allowed. If |y'''| ≤ J up to then, the follower is no faster than with the whole of that jerk: the
crossing speed is at most (9/2·J·j²)^⅓, by the cam angle. With y'' ≥ 0 before θ_c and y'' ≤ 0 after it, all of this
is linear in the motion at a given θ_c. That is found by bisection: for all θ_c from p to q, whatever the motion
does between them,

    y'' ≥ 0 up to p,   y'' ≤ 0 from q on,   −y''(q) ≤ (q − p)·J,   |y'''| ≤ J from q to p + W,
    y(q) + W·y'(q) − y(q + W) + ½·W·(q − p)²·J ≥ j,   W³·J ≥ 6·j

so that the least J with these bounds J for every θ_c there (R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction
to Interval Analysis, ch. 11). A return is a rise upside down.
"""

from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf

import numpy as np

from camopt.core.mistakes import Unmet, Unsolved
from camopt.solve.synthesis.convex_model import build_convex_model
from camopt.solve.synthesis.relaxation import RelaxedMotion
from camopt.solve.synthesis.solver import SOLVER_ERROR
from camopt.solve.synthesis.spline_motion import SplineMotion
from camopt.solve.synthesis.synthesis_problem import LIMIT_MARGINS, StrokeCrossing, SynthesisProblem, tighten_limits

FIRST_STROKE_PARTS, MOST_STROKE_PARTS = (
    8,
    40,
)  # parts of a stroke in which the force may turn round: at first, and in all
LEAST_PLACE_STEP = 2e-3  # of a stroke: a place so near to another one is as good
CLOSE_BOUND_GAP = 0.02  # relative: a bound so near to what is reached is near enough
BOUND_PANELS = 48  # of a stroke, for a bound
SEARCH_PIECES = 24  # of a stroke, at most, while the place is looked for


def with_crossings(problem: SynthesisProblem) -> tuple[SynthesisProblem, float | None]:
    """The demand with the place in each free stroke where its force turns round, and a bound for all places.

    Raises
    ------
    Unmet
        If no place is found where the roller crosses the clearance within the angle given.
    """
    places: list[StrokeCrossing] = []
    bounds: list[float | None] = []
    for number, stroke in enumerate(problem.strokes):
        if not stroke.is_free:
            continue
        known = _image_crossing(problem, places, number)
        if known is None:
            known, bound = _best_crossing(problem, number)
            bounds.append(bound)
        places.append(known)
    lowest = [bound for bound in bounds if bound is not None]
    return replace(problem, crossings=tuple(places)), max(lowest) if lowest else None


def _image_crossing(problem: SynthesisProblem, places: list[StrokeCrossing], number: int) -> StrokeCrossing | None:
    """The place in a stroke that is the image of another one, by what that has."""
    for place in places:
        if problem.mirror_strokes is not None and problem.mirror_strokes[number] == place.stroke:
            return place._replace(stroke=number, low=1.0 - place.high, high=1.0 - place.low)
        if problem.opposed_strokes is not None and problem.opposed_strokes[number] == place.stroke:
            return place._replace(stroke=number)
    return None


def _best_crossing(problem: SynthesisProblem, number: int) -> tuple[StrokeCrossing, float | None]:
    """The best place in a stroke, and what the objective has at least for any place in it."""
    few = replace(problem.splines, pieces=min(problem.splines.pieces, SEARCH_PIECES))
    coarse = replace(problem, splines=few)

    def objective_at(x: float) -> float:
        place = problem.stroke_crossing(number, x, x)
        images = [_image_crossing(problem, [place], other) for other in range(number + 1, len(problem.strokes))]
        asked = replace(coarse, crossings=(place, *(each for each in images if each)))
        try:
            return build_convex_model(tighten_limits(asked, LIMIT_MARGINS[0]), SplineMotion).solve()
        except Unsolved:
            return inf

    def lower_bound(low: float, high: float) -> float:
        """0 where the solver gives no bound."""
        asked = replace(problem, crossings=(problem.stroke_crossing(number, low, high),))
        relaxed = build_convex_model(tighten_limits(asked, -SOLVER_ERROR), partial(RelaxedMotion, BOUND_PANELS))
        try:
            value = relaxed.solve()
        except Unsolved:
            return 0.0
        return max(value * (1.0 - SOLVER_ERROR) - SOLVER_ERROR * relaxed.unit, 0.0) if relaxed.is_exact else 0.0

    ends = np.linspace(0.0, 1.0, FIRST_STROKE_PARTS + 1).tolist()
    parts = [(lower_bound(low, high), low, high) for low, high in pairwise(ends)]
    best, at = inf, 0.5
    for _ in range(MOST_STROKE_PARTS):
        lowest = min(parts)[0]
        if lowest >= best * (1.0 - CLOSE_BOUND_GAP):
            break
        promising = [part for part in parts if part[0] <= lowest * (1.0 + CLOSE_BOUND_GAP)]
        bound, low, high = part = max(promising, key=lambda each: each[2] - each[1])
        parts.remove(part)
        middle = (low + high) / 2.0
        if (value := objective_at(middle)) < best:
            best, at = value, middle
        parts += [(max(bound, lower_bound(*ends)), *ends) for ends in ((low, middle), (middle, high))]
    step = 0.5 / FIRST_STROKE_PARTS
    while min(parts)[0] < best * (1.0 - CLOSE_BOUND_GAP) < inf and step > LEAST_PLACE_STEP:
        step /= 2.0
        for x in (at - step, at + step):
            if 0.0 < x < 1.0 and (value := objective_at(x)) < best:
                best, at = value, x
    if best == inf:
        window = np.degrees(problem.crossing_window)
        raise Unmet(f"no free law was found with which the roller crosses its clearance within {window:g} deg")
    return problem.stroke_crossing(number, at, at), min(bound for bound, _, _ in parts)

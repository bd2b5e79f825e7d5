"""Little jerk where the force changes its sign, so that a roller with clearance lands softly on the other flank.

A follower of the mass m without spring and load is pushed by F = m·y''. In a rise, F changes its sign once, at θ_c,
from pushing to pulling. There the roller leaves its flank. It lands on the other flank after an angle W, once

    ∫∫ (−y'') dθ² = y(θ_c) + W·y'(θ_c) − y(θ_c + W) ≥ j

with the clearance j along the motion: the clearance of the groove over the cosine of the largest allowed pressure
angle. If |y'''| ≤ J until then, the follower is fastest with the whole of that jerk. So the crossing speed is at
most (9/2·J·j²)^⅓, per rad of the cam angle. With y'' ≥ 0 before θ_c and y'' ≤ 0 after it, all these
constraints are linear in the motion for a given θ_c.

θ_c is found by bisection. For all θ_c from p to q, any motion meets

    y'' ≥ 0 up to p,   y'' ≤ 0 from q on,   −y''(q) ≤ (q − p)·J,   |y'''| ≤ J from q to p + W,
    y(q) + W·y'(q) − y(q + W) + ½·W·(q − p)²·J ≥ j,   W³·J ≥ 6·j

So the least J under these constraints is a lower bound of J for every θ_c between p and q. A return is a negative
rise.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
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
)  # parts of a stroke that are searched for the crossing: at first, and in all
LEAST_PLACE_STEP = 2e-3  # least step of the search, as a share of the stroke
CLOSE_BOUND_GAP = 0.02  # relative gap to the bound at which the search ends
BOUND_PANELS = 48  # panels of a stroke, for a bound
SEARCH_PIECES = 24  # most pieces of a stroke during the search


def with_best_crossings_and_bound(problem: SynthesisProblem) -> tuple[SynthesisProblem, float | None]:
    """The problem with the best crossing in each free stroke, and a bound for any crossing.

    Raises
    ------
    Unmet
        If no place lets the roller cross its clearance within the given angle.
    """
    crossings: list[StrokeCrossing] = []
    bounds: list[float | None] = []
    for number, stroke in enumerate(problem.strokes):
        if stroke.is_law_replaceable:
            crossing = _image_crossing(problem, crossings, number)
            if crossing is None:
                crossing, bound = _best_crossing_and_lower_bound(problem, number)
                bounds.append(bound)
            crossings.append(crossing)
    largest_bound = max((bound for bound in bounds if bound is not None), default=None)
    return replace(problem, crossings=tuple(crossings)), largest_bound


def _image_crossing(
    problem: SynthesisProblem, crossings: list[StrokeCrossing], stroke_number: int
) -> StrokeCrossing | None:
    """The crossing of a stroke as the image of a known one, if the stroke mirrors or opposes it."""
    for crossing in crossings:
        if problem.mirror_strokes is not None and problem.mirror_strokes[stroke_number] == crossing.stroke:
            return crossing._replace(stroke=stroke_number, low=1.0 - crossing.high, high=1.0 - crossing.low)
        if problem.opposed_strokes is not None and problem.opposed_strokes[stroke_number] == crossing.stroke:
            return crossing._replace(stroke=stroke_number)
    return None


def _best_crossing_and_lower_bound(
    problem: SynthesisProblem, stroke_number: int
) -> tuple[StrokeCrossing, float | None]:
    """The best crossing of a stroke, and a lower bound of the objective for any crossing in it."""
    coarse = replace(problem, splines=replace(problem.splines, pieces=min(problem.splines.pieces, SEARCH_PIECES)))

    def objective_at(x: float) -> float:
        crossing = problem.stroke_crossing(stroke_number, x, x)
        image_crossings = [
            _image_crossing(problem, [crossing], other) for other in range(stroke_number + 1, len(problem.strokes))
        ]
        trial = replace(coarse, crossings=(crossing, *(item for item in image_crossings if item)))
        try:
            return build_convex_model(tighten_limits(trial, LIMIT_MARGINS[0]), SplineMotion).solve()
        except Unsolved:
            return inf

    def objective_lower_bound(low: float, high: float) -> float:
        """Lower bound for a crossing from ``low`` to ``high``; 0 if the solver gives none."""
        trial = replace(problem, crossings=(problem.stroke_crossing(stroke_number, low, high),))
        relaxed = build_convex_model(tighten_limits(trial, -SOLVER_ERROR), partial(RelaxedMotion, BOUND_PANELS))
        try:
            value = relaxed.solve()
        except Unsolved:
            return 0.0
        return (
            max(value * (1.0 - SOLVER_ERROR) - SOLVER_ERROR * relaxed.unit, 0.0)
            if relaxed.is_solved_accurately
            else 0.0
        )

    ends = np.linspace(0.0, 1.0, FIRST_STROKE_PARTS + 1).tolist()
    parts = [(objective_lower_bound(low, high), low, high) for low, high in pairwise(ends)]
    best, best_x = inf, 0.5
    for _ in range(MOST_STROKE_PARTS):
        lowest = min(parts)[0]
        if lowest >= best * (1.0 - CLOSE_BOUND_GAP):
            break
        promising = [part for part in parts if part[0] <= lowest * (1.0 + CLOSE_BOUND_GAP)]
        bound, low, high = part = max(promising, key=lambda item: item[2] - item[1])
        parts.remove(part)
        middle = (low + high) / 2.0
        if (value := objective_at(middle)) < best:
            best, best_x = value, middle
        parts += [(max(bound, objective_lower_bound(*ends)), *ends) for ends in ((low, middle), (middle, high))]
    step = 0.5 / FIRST_STROKE_PARTS
    while min(parts)[0] < best * (1.0 - CLOSE_BOUND_GAP) < inf and step > LEAST_PLACE_STEP:
        step /= 2.0
        for x in (best_x - step, best_x + step):
            if 0.0 < x < 1.0 and (value := objective_at(x)) < best:
                best, best_x = value, x
    if best == inf:
        window = np.degrees(problem.crossing_window)
        raise Unmet(f"no free law was found that lets the roller cross its clearance within {window:g} deg")
    return problem.stroke_crossing(stroke_number, best_x, best_x), min(bound for bound, _, _ in parts)

"""The motion of the least mean-square jerk within a band of points, as convex programmes.

``least_jerk_curve`` has nothing but its room: its optimum is the least of any motion whatever, and the motion turns
where it does. ``least_jerk_motion`` rests in the dwells of the outline, turns where it turns and goes one way in
between; it is the result, and what it has more than the freest is the price of its shape.

Among errors, the least mean-square jerk alone makes peaks of the acceleration too high: most by about 1 %, and
a flat one whose corners are hidden by up to 15 %, so that it comes out round. Where the room is that of errors,
``least_jerk_motion`` has therefore the least of

    ∫ (u² + λ·|u|) dθ,   u = y'''/j,   λ = 1/4,

with the root mean square j of the freest. ∫ |y'''| dθ is the variation of the acceleration, to which each peak adds
twice its height. Peaks of random files are then lower by 0.3 to 1.5 %, and the root mean square of the jerk is
larger by 0.2 % at most. λ does not tell flat peaks from round ones: it lowers both. A band that is room to use has
λ = 0.

Lifts are in units of their range, and each spline is on the unit stroke, so that numbers are near 1.

Sources: Rudin, Osher and Fatemi, Nonlinear total variation based noise removal algorithms, Physica D 60, 1992; Zou
and Hastie, Regularization and variable selection via the elastic net, J. R. Statist. Soc. B 67, 2005 (u² and |u|).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf, radians, sqrt
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from camopt.core.mistakes import Unsolved
from camopt.core.numerics import FloatArray, IndexArray
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints, angle_from
from camopt.solve.measured.outline import ANGLE_DIGITS, DWELL_END_SLACK, Dwell, MotionOutline
from camopt.solve.measured.spline_chain import JOINED_ORDERS, SplineChain
from camopt.solve.synthesis.solver import SOLVED_STATUSES, SOLVER_ERROR, failure_message, solve

LEAST_STROKE_KNOTS, MOST_STROKE_KNOTS = 32, 200  # about, inside a stroke
LEAST_KNOT_STEPS = 0.5  # median steps of the points: the least distance of knots
LEAST_LIFT_SHARE, LEAST_RANGE_SHARE = (
    1e-3,
    1e-6,
)  # the least lift of a stroke: of what points show, and of the range of the lifts
TURN_ANGLES = 2001  # angles at which a turn is looked for
AMPLE_JERK = 10.0  # times a usual jerk: in units that are rather large a solver errs less
LEVELLING = 0.25  # times the least jerk: what the mean of |jerk| weighs beside the mean square, among errors
USUAL_JERKS = tuple(60.0 * each**3 for each in (6.0, 3.0, 12.0))
"""By x over a turn: the jerk of cubic rises in 60, 120 and 30 deg."""


class AllowedDeviation(NamedTuple):
    """The allowed deviation of a motion from its points: from each, and in the root mean square if limited."""

    band: float
    rms: float | None = None

    def reduce_by(self, margin: float) -> "AllowedDeviation":
        """A room that is less by a share."""
        kept = 1.0 - margin
        return AllowedDeviation(kept * self.band, None if self.rms is None else kept * self.rms)

    def constraints_on(self, off: Any, unit: float) -> list[Any]:
        """The limits on deviations in a unit."""
        band = cp.abs(off) <= self.band / unit
        return [band] if self.rms is None else [band, cp.norm(off) <= sqrt(off.size) * self.rms / unit]


class OutlineNode(NamedTuple):
    """A dwell, or a turn of no length: its angles in deg, its points, and its level in the unit of the lifts."""

    start: float
    end: float
    places: IndexArray
    level: float

    @property
    def is_dwell(self) -> bool:
        return self.end > self.start


class SplineStroke(NamedTuple):
    """A spline from one node to the next: its angles in deg, and its points."""

    chain: SplineChain
    start: float
    angle: float
    places: IndexArray
    x: FloatArray  # of its points


@dataclass(frozen=True)
class OutlineMotion:
    """A motion as nodes and the strokes after each, with the coefficients of each stroke's s, from 0 to 1."""

    nodes: tuple[OutlineNode, ...]
    strokes: tuple[SplineStroke, ...]
    coefficients: tuple[FloatArray, ...]


class _SplineVariables:
    """The coefficients c₀ … c₃ of a spline by x as unknowns, in units of 1, u^⅓, u^⅔ and u, an ample jerk."""

    def __init__(self, chain: SplineChain, jerk: float) -> None:
        self.chain, self.unit = chain, AMPLE_JERK * jerk
        scaled = [cp.Variable(chain.count - k) for k in range(JOINED_ORDERS)]
        self.c = [self.unit ** (k / 3.0) * c for k, c in enumerate(scaled)]
        joined = zip(chain.steps, scaled[:-1], scaled[1:], strict=True)
        per = self.unit ** (1.0 / 3.0)
        self.limits = [cp.multiply(per * step, after) == before[1:] - before[:-1] for step, before, after in joined]
        self.square = cp.sum_squares(chain.jerk_square_matrix @ scaled[3])
        """∫ (y''')² dx over the square of the unit."""
        self.variation = cp.norm1(cp.multiply(chain.steps[-1], scaled[3]))
        """∫ |y'''| dx over the unit, or a little more: what the coefficients of y'' vary by."""

    def values_at(self, x: FloatArray) -> Any:
        return self.chain.value_matrix(x) @ self.c[0]


# ---------------------------------------------------------------------------------------------------- freest


@dataclass(frozen=True)
class LeastJerkCurve:
    """The optimum of the band alone: ``square`` is the least ∫ (y''')² dθ of any motion, by the angle in rad."""

    chain: SplineChain
    first_angle: float  # cam angle at x = 0, deg
    coefficients: FloatArray
    square: float

    @property
    def rms_jerk(self) -> float:
        """Its root mean square, by the angle in rad."""
        return sqrt(self.square / radians(TURN_DEG))

    def lifts_at(self, angles: FloatArray) -> FloatArray:
        return np.asarray(
            self.chain.value_matrix(angle_from(self.first_angle, angles) / TURN_DEG) @ self.coefficients
        )

    def slopes_at(self, angles: FloatArray) -> FloatArray:
        """Its derivative by the angle in rad."""
        coefficients = np.diff(self.coefficients) / self.chain.steps[0]
        return np.asarray(
            self.chain.value_matrix(angle_from(self.first_angle, angles) / TURN_DEG, 1) @ coefficients
        ) / radians(TURN_DEG)


def least_jerk_curve(points: MeasuredPoints, room: AllowedDeviation) -> LeastJerkCurve:
    """The optimum of the room alone: a closed spline with a knot at each angle.

    Raises
    ------
    Unsolved
        If the solver fails in each of the units of the jerk that are tried.
    """
    for usual in USUAL_JERKS[:-1]:
        with suppress(Unsolved):
            return _solve_least_jerk(points, room, usual)
    return _solve_least_jerk(points, room, USUAL_JERKS[-1])


def _solve_least_jerk(points: MeasuredPoints, room: AllowedDeviation, usual: float) -> LeastJerkCurve:
    """The optimum by a solver in the units of a usual jerk, by x over a turn."""
    angles, unit = np.unique(points.angles), np.ptp(points.lifts)
    chain = SplineChain(tuple(((angles[1:] - angles[0]) / TURN_DEG).tolist()))
    y = _SplineVariables(chain, usual)
    closed = [c[0] == c[-1] for c in y.c]
    first, last = chain.inner_knots[0], 1.0 - chain.inner_knots[-1]  # its fourth derivative goes on, too
    closed.append(last * (y.c[3][1] - y.c[3][0]) == first * (y.c[3][-1] - y.c[3][-2]))
    middle, x = _middle_lift(points), angle_from(angles[0], points.angles) / TURN_DEG
    within = room.constraints_on(y.values_at(x) - (points.lifts - middle) / unit, unit)
    problem = cp.Problem(cp.Minimize(y.square), [*y.limits, *closed, *within])
    if (status := solve(problem)) not in SOLVED_STATUSES:
        raise Unsolved(failure_message(status))
    least = (1.0 - SOLVER_ERROR) * problem.value * (y.unit * unit) ** 2 / radians(TURN_DEG) ** 5
    return LeastJerkCurve(chain, float(angles[0]), np.asarray(y.c[0].value) * unit + middle, float(least))


def _middle_lift(points: MeasuredPoints) -> float:
    return float(points.lifts.max() + points.lifts.min()) / 2.0


def outline_nodes(
    points: MeasuredPoints, outline: MotionOutline, motion: LeastJerkCurve
) -> tuple[OutlineNode, ...]:
    """Dwells, and turns at the places where a motion turns in them."""
    found = []
    for part in outline:
        if isinstance(part, Dwell):
            found.append(OutlineNode(part.start, part.end, part.places, part.level))
        else:
            # where a motion is highest or lowest in a turn, deg
            angles = np.linspace(part.low, part.high, TURN_ANGLES)[1:-1]
            lifts = motion.lifts_at(angles) * (1.0 if part.highest else -1.0)
            at = round(float(angles[lifts.argmax()] % TURN_DEG), ANGLE_DIGITS)
            found.append(OutlineNode(at, at, np.empty(0, dtype=np.intp), part.level))
    return tuple(found)


# ---------------------------------------------------------------------------------------------------- shaped


def spline_strokes(points: MeasuredPoints, nodes: Sequence[OutlineNode]) -> tuple[SplineStroke, ...]:
    """The stroke after each node, to the next one: knots at its points, as far as they are apart."""
    found, resting = [], np.zeros(points.angles.size, dtype=bool)
    resting[np.concatenate([node.places for node in nodes])] = True
    for node, after in zip(nodes, [*nodes[1:], nodes[0]], strict=True):
        angle = float(round(float(angle_from(node.end, after.start)), ANGLE_DIGITS)) or TURN_DEG
        away = angle_from(node.end - DWELL_END_SLACK, points.angles)
        places = np.flatnonzero((away < angle) & ~resting)
        places = places[np.argsort(away[places], kind="stable")]
        x = np.maximum(away[places] - DWELL_END_SLACK, 0.0) / angle
        found.append(SplineStroke(SplineChain(_stroke_knots(np.unique(x))), node.end % TURN_DEG, angle, places, x))
    return tuple(found)


def _stroke_knots(x: FloatArray) -> tuple[float, ...]:
    """Points inside a stroke as knots, but for those too near to the one before or to an end, and halves of few."""
    least = max(LEAST_KNOT_STEPS * float(np.median(np.diff(x))) if x.size > 1 else 1.0, 1.0 / MOST_STROKE_KNOTS)
    found = [0.0]
    for each in x:
        if each - found[-1] >= least and 1.0 - each >= least:
            found.append(float(each))
    knots = np.array([*found, 1.0])
    while knots.size < LEAST_STROKE_KNOTS:
        knots = np.sort(np.concatenate([knots, (knots[1:] + knots[:-1]) / 2.0]))
    return tuple(knots[1:-1].tolist())


def least_jerk_motion(
    points: MeasuredPoints, nodes: Sequence[OutlineNode], room: AllowedDeviation, jerk: float
) -> OutlineMotion | None:
    """The motion of an outline within a room; None if none is found. A usual ``jerk`` is by rad."""
    model = _OutlineModel(points, nodes, jerk)
    within = room.constraints_on(model.off, model.unit)
    rough = model.square if room.rms is None else model.square + LEVELLING / AMPLE_JERK * model.variation
    status = solve(cp.Problem(cp.Minimize(rough), [*model.limits, *within]))
    return model.exact_motion() if status in SOLVED_STATUSES else None


def least_band(points: MeasuredPoints, nodes: Sequence[OutlineNode], jerk: float) -> tuple[float, list[int]]:
    """The least band of an outline, and the places of the points that are as far away."""
    model, band = _OutlineModel(points, nodes, jerk), cp.Variable()
    if solve(cp.Problem(cp.Minimize(band), [*model.limits, cp.abs(model.off) <= band])) not in SOLVED_STATUSES:
        return inf, []
    off = np.abs(model.off.value)
    return float(band.value) * model.unit, list(map(int, model.places[off >= (1.0 - 1e-3) * band.value]))


class _OutlineModel:
    """The unknowns of an outline, what joins them, and what its points are off by."""

    def __init__(self, points: MeasuredPoints, nodes: Sequence[OutlineNode], jerk: float) -> None:
        self.points, self.nodes, self.strokes = points, nodes, spline_strokes(points, nodes)
        self.unit, self.middle = float(np.ptp(points.lifts)), _middle_lift(points)
        self.levels = cp.Variable(len(nodes))
        angles = [radians(stroke.angle) for stroke in self.strokes]
        moving = list(zip(self.strokes, angles, strict=True))
        self.motions = [_SplineVariables(stroke.chain, jerk * angle**3 / self.unit) for stroke, angle in moving]
        self.square = sum(a * motion.square for a, motion in zip(angles, self.motions, strict=True))
        self.variation = sum(a * motion.variation for a, motion in zip(angles, self.motions, strict=True))
        self.limits = [limit for motion in self.motions for limit in motion.limits]
        for k in range(len(nodes)):
            # a stroke goes one way: no coefficient of its velocity is of the other sign
            following = (k + 1) % len(self.nodes)
            lift = (self.nodes[following].level - self.nodes[k].level) / self.unit
            way = 1.0 if lift >= 0.0 else -1.0
            least = LEAST_LIFT_SHARE * abs(lift) + LEAST_RANGE_SHARE
            self.limits += [
                *self._joint_limits(k),
                way * self.motions[k].c[1] >= 0,
                way * (self.levels[following] - self.levels[k]) >= least,
            ]
        lifts = (points.lifts - self.middle) / self.unit
        off = [
            motion.values_at(s.x) - lifts[s.places] for s, motion in zip(self.strokes, self.motions, strict=True)
        ]
        off += [self.levels[k] - lifts[node.places] for k, node in enumerate(nodes) if node.places.size]
        self.off = cp.hstack(off)
        self.places = np.concatenate([*(s.places for s in self.strokes), *(node.places for node in nodes)])

    def _joint_limits(self, k: int) -> list[Any]:
        """A node: its level, no velocity, and beside a dwell no acceleration; through a turn both go on."""
        before, after = self.motions[k - 1].c, self.motions[k].c
        limits = [
            before[0][-1] == self.levels[k],
            after[0][0] == self.levels[k],
            before[1][-1] == 0,
            after[1][0] == 0,
        ]
        if self.nodes[k].is_dwell:
            return [*limits, before[2][-1] == 0, after[2][0] == 0]
        ratio = self.strokes[k].angle / self.strokes[k - 1].angle
        return [*limits, *(ratio**order * before[order][-1] == after[order][0] for order in (2, 3))]

    def exact_motion(self) -> OutlineMotion:
        """The solution without a solver's error: levels in few digits, and strokes that meet there exactly."""
        digits = 7 - int(np.floor(np.log10(self.unit)))
        levels = [round(float(level) * self.unit + self.middle, digits) for level in self.levels.value]
        nodes = tuple(node._replace(level=level) for node, level in zip(self.nodes, levels, strict=True))
        return OutlineMotion(
            nodes, self.strokes, tuple(self._stroke_coefficients(k, levels) for k in range(len(nodes)))
        )

    def _stroke_coefficients(self, k: int, levels: Sequence[float]) -> FloatArray:
        """The coefficients of a stroke's s, from 0 to 1, at rest beside a dwell and as bent as beyond a turn."""
        following = (k + 1) % len(levels)
        lift = (levels[following] - levels[k]) / self.unit
        chain, jerk = self.motions[k].chain, np.asarray(self.motions[k].c[3].value) / lift
        bends = [self._node_acceleration(j) * self.strokes[k].angle ** 2 / lift for j in (k, following)]
        start = (0.0, 0.0, bends[0])
        found = chain.integrate_jerk(chain.adjust_jerk(jerk, start, np.array([1.0, 0.0, bends[1]])), start)[0]
        found[:2], found[-2:] = 0.0, 1.0
        if self.nodes[k].is_dwell:
            found[2] = 0.0
        if self.nodes[following].is_dwell:
            found[-3] = 1.0
        return np.asarray(np.maximum.accumulate(np.clip(found, 0.0, 1.0)))

    def _node_acceleration(self, k: int) -> float:
        """y'' at a node, in units of the lift by the angle in deg: the mean of what both sides have."""
        if self.nodes[k].is_dwell:
            return 0.0
        sides = (
            (self.motions[k - 1].c[2].value[-1], self.strokes[k - 1]),
            (self.motions[k].c[2].value[0], self.strokes[k]),
        )
        return float(np.mean([bend / stroke.angle**2 for bend, stroke in sides]))

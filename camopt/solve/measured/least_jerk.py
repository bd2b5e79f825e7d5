"""The motion of least mean-square jerk within a band of points, as convex programmes.

``least_jerk_curve`` has only the band as its constraint. Its optimum is a lower bound for any motion, and it turns
freely. ``least_jerk_motion`` rests in the dwells of the outline, turns where the outline turns and is monotone in
between. It is the result; its extra jerk is the price of its shape.

With errors, least mean-square jerk alone raises peaks of the acceleration: mostly by about 1 %, and by up to 15 %
for a flat peak with hidden corners, which then becomes round. So for a band of errors, ``least_jerk_motion``
minimises

    ∫ (u² + λ·|u|) dθ,   u = y'''/j,   λ = 1/4,

with the root mean square jerk j of the free curve. ∫ |y'''| dθ is the variation of the acceleration, to which each
peak adds twice its height. For random files the peaks are then lower by 0.3 to 1.5 %, and the root mean square jerk
is larger by 0.2 % at most. λ lowers flat and round peaks alike. For a band that is wider than errors, λ = 0.

Lifts are in units of their range and each spline is on the unit stroke, so that numbers are near 1.

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
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints, forward_angle_deg
from camopt.solve.measured.outline import ANGLE_DIGITS, DWELL_END_SLACK, Dwell, MotionOutline
from camopt.solve.measured.spline_chain import JOINED_ORDERS, SplineChain
from camopt.solve.synthesis.solver import SOLVED_STATUSES, SOLVER_ERROR, failure_message, solve

LEAST_STROKE_KNOTS, MOST_STROKE_KNOTS = 32, 200  # approximate numbers of knots in a stroke
LEAST_KNOT_STEPS = 0.5  # least distance of knots, in median steps of the points
LEAST_LIFT_SHARE, LEAST_RANGE_SHARE = (
    1e-3,
    1e-6,
)  # least lift of a stroke, as a share of its measured lift, and of the range of the lifts
TURN_ANGLES = 2001  # trial angles of a turning point
AMPLE_JERK = 10.0  # unit of the jerk over a usual jerk: with a large unit the solver errs less
LEVELLING = 0.25  # weight λ of the mean |jerk| beside the mean square
USUAL_JERKS = tuple(60.0 * each**3 for each in (6.0, 3.0, 12.0))
"""Jerk of cubic rises in 60, 120 and 30 deg, by x over a turn."""


class AllowedDeviation(NamedTuple):
    """Allowed deviation of a motion from each point, and in the root mean square if that is limited."""

    band: float
    rms: float | None = None

    def deviation_constraints(self, deviations: Any, unit: float) -> list[Any]:
        """Constraints on deviations in a unit."""
        band = cp.abs(deviations) <= self.band / unit
        return (
            [band] if self.rms is None else [band, cp.norm(deviations) <= sqrt(deviations.size) * self.rms / unit]
        )


class OutlineNode(NamedTuple):
    """A dwell or a turning point: its angles [deg], its points, and its level in the unit of the lifts."""

    start: float
    end: float
    places: IndexArray
    level: float

    @property
    def is_dwell(self) -> bool:
        return self.end > self.start


class SplineStroke(NamedTuple):
    """A spline from one node to the next: its angles [deg], and its points."""

    chain: SplineChain
    start: float
    angle: float
    places: IndexArray
    x: FloatArray  # of its points


@dataclass(frozen=True)
class OutlineMotion:
    """A motion of nodes and the strokes after them, with the coefficients of each stroke from 0 to 1."""

    nodes: tuple[OutlineNode, ...]
    strokes: tuple[SplineStroke, ...]
    coefficients: tuple[FloatArray, ...]


class _SplineVariables:
    """Coefficients c₀ … c₃ of a spline by x as variables, in units of 1, u^⅓, u^⅔ and u, an ample jerk."""

    def __init__(self, chain: SplineChain, usual_jerk: float) -> None:
        self.chain, self.unit = chain, AMPLE_JERK * usual_jerk
        scaled = [cp.Variable(chain.coefficient_count - k) for k in range(JOINED_ORDERS)]
        self.c = [self.unit ** (k / 3.0) * c for k, c in enumerate(scaled)]
        orders = zip(chain.difference_factors, scaled[:-1], scaled[1:], strict=True)
        factor = self.unit ** (1.0 / 3.0)
        self.limits = [
            cp.multiply(factor * step, after) == before[1:] - before[:-1] for step, before, after in orders
        ]
        self.square = cp.sum_squares(chain.jerk_norm_matrix @ scaled[3])
        """∫ (y''')² dx in units of the squared jerk unit."""
        self.variation = cp.norm1(cp.multiply(chain.difference_factors[-1], scaled[3]))
        """∫ |y'''| dx in jerk units, or a little more: the variation of the coefficients of y''."""


# ---------------------------------------------------------------------------------------------------- freest


@dataclass(frozen=True)
class LeastJerkCurve:
    """The optimum of the band alone; ``square`` is the least ∫ (y''')² dθ of any motion, by the angle in rad."""

    chain: SplineChain
    first_angle: float  # cam angle at x = 0, deg
    coefficients: FloatArray
    square: float

    @property
    def rms_jerk(self) -> float:
        """Root mean square jerk, by the angle in rad."""
        return sqrt(self.square / radians(TURN_DEG))

    def lifts_at(self, angles: FloatArray) -> FloatArray:
        return np.asarray(
            self.chain.value_matrix(forward_angle_deg(self.first_angle, angles) / TURN_DEG) @ self.coefficients
        )

    def slopes_at(self, angles: FloatArray) -> FloatArray:
        """Derivative of the lift by the angle in rad."""
        coefficients = np.diff(self.coefficients) / self.chain.difference_factors[0]
        return np.asarray(
            self.chain.value_matrix(forward_angle_deg(self.first_angle, angles) / TURN_DEG, 1) @ coefficients
        ) / radians(TURN_DEG)


def least_jerk_curve(points: MeasuredPoints, allowed: AllowedDeviation) -> LeastJerkCurve:
    """The closed curve of least mean-square jerk within the allowed deviation, with a knot at each angle.

    Raises
    ------
    Unsolved
        If the solver fails in each unit of the jerk.
    """
    for usual_jerk in USUAL_JERKS[:-1]:
        with suppress(Unsolved):
            return _solve_least_jerk(points, allowed, usual_jerk)
    return _solve_least_jerk(points, allowed, USUAL_JERKS[-1])


def _solve_least_jerk(points: MeasuredPoints, allowed: AllowedDeviation, usual_jerk: float) -> LeastJerkCurve:
    """The optimum in units of a usual jerk, by x over a turn."""
    angles, unit = np.unique(points.angles), np.ptp(points.lifts)
    chain = SplineChain(tuple(((angles[1:] - angles[0]) / TURN_DEG).tolist()))
    variables = _SplineVariables(chain, usual_jerk)
    first, last = chain.inner_knots[0], 1.0 - chain.inner_knots[-1]
    closed = [
        *(c[0] == c[-1] for c in variables.c),
        # its fourth derivative is continuous too
        last * (variables.c[3][1] - variables.c[3][0]) == first * (variables.c[3][-1] - variables.c[3][-2]),
    ]
    middle, x = _mid_range_lift(points), forward_angle_deg(angles[0], points.angles) / TURN_DEG
    band_constraints = allowed.deviation_constraints(
        chain.value_matrix(x) @ variables.c[0] - (points.lifts - middle) / unit, unit
    )
    problem = cp.Problem(cp.Minimize(variables.square), [*variables.limits, *closed, *band_constraints])
    if (status := solve(problem)) not in SOLVED_STATUSES:
        raise Unsolved(failure_message(status))
    least = (1.0 - SOLVER_ERROR) * problem.value * (variables.unit * unit) ** 2 / radians(TURN_DEG) ** 5
    return LeastJerkCurve(chain, float(angles[0]), np.asarray(variables.c[0].value) * unit + middle, float(least))


def _mid_range_lift(points: MeasuredPoints) -> float:
    return float(points.lifts.max() + points.lifts.min()) / 2.0


def outline_nodes(
    points: MeasuredPoints, outline: MotionOutline, motion: LeastJerkCurve
) -> tuple[OutlineNode, ...]:
    """Dwells, and turning points where a motion turns."""
    nodes = []
    for part in outline:
        if isinstance(part, Dwell):
            nodes.append(OutlineNode(part.start, part.end, part.places, part.level))
        else:
            # the highest or lowest angle of the motion [deg]
            angles = np.linspace(part.low, part.high, TURN_ANGLES)[1:-1]
            lifts = motion.lifts_at(angles) * (1.0 if part.highest else -1.0)
            angle = round(float(angles[lifts.argmax()] % TURN_DEG), ANGLE_DIGITS)
            nodes.append(OutlineNode(angle, angle, np.empty(0, dtype=np.intp), part.level))
    return tuple(nodes)


# ---------------------------------------------------------------------------------------------------- shaped


def spline_strokes(points: MeasuredPoints, nodes: Sequence[OutlineNode]) -> tuple[SplineStroke, ...]:
    """The stroke after each node up to the next one, with knots at its points if these are far enough apart."""
    strokes, is_resting = [], np.zeros(points.angles.size, dtype=bool)
    is_resting[np.concatenate([node.places for node in nodes])] = True
    for node, next_node in zip(nodes, [*nodes[1:], nodes[0]], strict=True):
        angle = float(round(float(forward_angle_deg(node.end, next_node.start)), ANGLE_DIGITS)) or TURN_DEG
        offsets = forward_angle_deg(node.end - DWELL_END_SLACK, points.angles)
        places = np.flatnonzero((offsets < angle) & ~is_resting)
        places = places[np.argsort(offsets[places], kind="stable")]
        x = np.maximum(offsets[places] - DWELL_END_SLACK, 0.0) / angle
        strokes.append(
            SplineStroke(SplineChain(_stroke_knots(np.unique(x))), node.end % TURN_DEG, angle, places, x)
        )
    return tuple(strokes)


def _stroke_knots(x: FloatArray) -> tuple[float, ...]:
    """Inner knots of a stroke: points that are far enough apart, and halves between few points."""
    least = max(LEAST_KNOT_STEPS * float(np.median(np.diff(x))) if x.size > 1 else 1.0, 1.0 / MOST_STROKE_KNOTS)
    distinct = [0.0]
    for point in x:
        if point - distinct[-1] >= least and 1.0 - point >= least:
            distinct.append(float(point))
    knots = np.array([*distinct, 1.0])
    while knots.size < LEAST_STROKE_KNOTS:
        knots = np.sort(np.concatenate([knots, (knots[1:] + knots[:-1]) / 2.0]))
    return tuple(knots[1:-1].tolist())


def least_jerk_motion(
    points: MeasuredPoints, nodes: Sequence[OutlineNode], allowed: AllowedDeviation, usual_jerk: float
) -> OutlineMotion | None:
    """The motion of an outline within the allowed deviation; None if none is found.

    A usual ``usual_jerk`` is by rad.
    """
    model = _OutlineModel(points, nodes, usual_jerk)
    band_constraints = allowed.deviation_constraints(model.deviations, model.unit)
    objective = model.square if allowed.rms is None else model.square + LEVELLING / AMPLE_JERK * model.variation
    status = solve(cp.Problem(cp.Minimize(objective), [*model.limits, *band_constraints]))
    return model.motion_with_exact_joints() if status in SOLVED_STATUSES else None


def least_band_and_active_points(
    points: MeasuredPoints, nodes: Sequence[OutlineNode], usual_jerk: float
) -> tuple[float, list[int]]:
    """Least band of an outline, and the places of the points at that distance."""
    model, band = _OutlineModel(points, nodes, usual_jerk), cp.Variable()
    if (
        solve(cp.Problem(cp.Minimize(band), [*model.limits, cp.abs(model.deviations) <= band]))
        not in SOLVED_STATUSES
    ):
        return inf, []
    deviations = np.abs(model.deviations.value)
    return float(band.value) * model.unit, list(map(int, model.places[deviations >= (1.0 - 1e-3) * band.value]))


class _OutlineModel:
    """The variables of an outline, their joints, and the deviations of its points."""

    def __init__(self, points: MeasuredPoints, nodes: Sequence[OutlineNode], usual_jerk: float) -> None:
        self.points, self.nodes, self.strokes = points, nodes, spline_strokes(points, nodes)
        self.unit, self.middle = float(np.ptp(points.lifts)), _mid_range_lift(points)
        self.levels = cp.Variable(len(nodes))
        angles = [radians(stroke.angle) for stroke in self.strokes]
        moving = list(zip(self.strokes, angles, strict=True))
        self.motions = [
            _SplineVariables(stroke.chain, usual_jerk * angle**3 / self.unit) for stroke, angle in moving
        ]
        self.square = sum(a * motion.square for a, motion in zip(angles, self.motions, strict=True))
        self.variation = sum(a * motion.variation for a, motion in zip(angles, self.motions, strict=True))
        self.limits = [limit for motion in self.motions for limit in motion.limits]
        for k in range(len(nodes)):
            # a stroke is monotone: all coefficients of its velocity have one sign
            following = (k + 1) % len(self.nodes)
            lift = (self.nodes[following].level - self.nodes[k].level) / self.unit
            way = 1.0 if lift >= 0.0 else -1.0
            least = LEAST_LIFT_SHARE * abs(lift) + LEAST_RANGE_SHARE
            self.limits += [
                *self._node_constraints(k),
                way * self.motions[k].c[1] >= 0,
                way * (self.levels[following] - self.levels[k]) >= least,
            ]
        lifts = (points.lifts - self.middle) / self.unit
        deviations = [
            *(
                motion.chain.value_matrix(s.x) @ motion.c[0] - lifts[s.places]
                for s, motion in zip(self.strokes, self.motions, strict=True)
            ),
            *(self.levels[k] - lifts[node.places] for k, node in enumerate(nodes) if node.places.size),
        ]
        self.deviations = cp.hstack(deviations)
        self.places = np.concatenate([*(s.places for s in self.strokes), *(node.places for node in nodes)])

    def _node_constraints(self, node_index: int) -> list[Any]:
        """Constraints at a node: its level and no velocity.

        Beside a dwell there is no acceleration. At a turning point, acceleration and jerk are continuous.
        """
        before, after = self.motions[node_index - 1].c, self.motions[node_index].c
        limits = [
            before[0][-1] == self.levels[node_index],
            after[0][0] == self.levels[node_index],
            before[1][-1] == 0,
            after[1][0] == 0,
        ]
        if self.nodes[node_index].is_dwell:
            return [*limits, before[2][-1] == 0, after[2][0] == 0]
        ratio = self.strokes[node_index].angle / self.strokes[node_index - 1].angle
        return [*limits, *(ratio**order * before[order][-1] == after[order][0] for order in (2, 3))]

    def motion_with_exact_joints(self) -> OutlineMotion:
        """The solution without the solver's error: levels of few digits, and strokes that meet them exactly."""
        digits = 7 - int(np.floor(np.log10(self.unit)))
        levels = [round(float(level) * self.unit + self.middle, digits) for level in self.levels.value]
        nodes = tuple(node._replace(level=level) for node, level in zip(self.nodes, levels, strict=True))
        return OutlineMotion(
            nodes, self.strokes, tuple(self._stroke_coefficients(k, levels) for k in range(len(nodes)))
        )

    def _stroke_coefficients(self, stroke_index: int, levels: Sequence[float]) -> FloatArray:
        """Coefficients of a stroke from 0 to 1, at rest beside a dwell and with y'' of a turning point."""
        following = (stroke_index + 1) % len(levels)
        lift = (levels[following] - levels[stroke_index]) / self.unit
        chain, jerk = self.motions[stroke_index].chain, np.asarray(self.motions[stroke_index].c[3].value) / lift
        accelerations = [
            self._node_acceleration(j) * self.strokes[stroke_index].angle ** 2 / lift
            for j in (stroke_index, following)
        ]
        start = (0.0, 0.0, accelerations[0])
        coefficients = chain.integrate_jerk(
            chain.adjust_jerk_to_end_state(jerk, start, np.array([1.0, 0.0, accelerations[1]])), start
        )[0]
        coefficients[:2], coefficients[-2:] = 0.0, 1.0
        if self.nodes[stroke_index].is_dwell:
            coefficients[2] = 0.0
        if self.nodes[following].is_dwell:
            coefficients[-3] = 1.0
        return np.asarray(np.maximum.accumulate(np.clip(coefficients, 0.0, 1.0)))

    def _node_acceleration(self, node_index: int) -> float:
        """y'' at a node, in units of the lift by the angle in deg: the mean of both sides."""
        if self.nodes[node_index].is_dwell:
            return 0.0
        sides = (
            (self.motions[node_index - 1].c[2].value[-1], self.strokes[node_index - 1]),
            (self.motions[node_index].c[2].value[0], self.strokes[node_index]),
        )
        return float(np.mean([acceleration / stroke.angle**2 for acceleration, stroke in sides]))

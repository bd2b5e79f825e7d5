"""A programme: the rises, dwells and returns of one turn in order, with the load over the turn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import groupby
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.panels import TABLE_DEGREE
from camopt.core.numerics.piecewise import (
    MotionTable,
    derivative_ranges_and_errors,
    external_load_polynomials_by_panel,
    group_number_of_each_panel,
    node_displacements_and_derivatives,
    places_of_sign_change,
    powers_to_bernstein_matrix,
    train_inertia_polynomials_by_panel,
)
from camopt.core.numerics.quadrature import gauss_rule
from camopt.core.numerics.stable_functions import matrix_product
from camopt.core.numerics.state import State
from camopt.core.numerics.turn_curve import TURN, TurnCurve
from camopt.model.motion import LAWS
from camopt.model.motion.installed_laws import InstalledLaw
from camopt.model.motion.law import Law
from camopt.model.motion.law_panels import breaks_with_cuts, law_panel_polynomials, turning_points
from camopt.model.motion.load import ExternalLoad, TrainLoad
from camopt.model.motion.move_joints import strokes_with_move_laws
from camopt.model.motion.segments import MotionSegment, start_position_and_strokes
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.stroke import (
    ALL_STROKES,
    DWELL,
    INWARD,
    OUTWARD,
    RESTING,
    RETURN,
    RISE,
    WAY_OF,
    Stroke,
    motion_directions,
)

TURN_PANELS = 24
LEAST_JUMP = 1e-9  # of the largest value in the turn: smaller jumps are rounding
JUMP_SIDE = 1e-12  # rad: distance to either side of a jump
OVERSHOOT = 1e-12  # rounding may take a law below 0 or above 1 by this much


class Jump(NamedTuple):
    """A discontinuity of y' (a corner) or y'' between two smooth pieces."""

    order: int  # of the derivative that jumps
    at: float  # cam angle, rad
    size: float  # right value minus left value
    after: float  # right value
    kinds: int  # of the two strokes that meet there


@dataclass(frozen=True)
class Programme:
    """The motion of one turn. Hashable; its tables are computed once and shared.

    Displacements count from the lowest position of the turn, which is on the base circle.
    """

    strokes: tuple[Stroke, ...]
    load: ExternalLoad | TrainLoad | None = None
    """The external load over the turn, if it is not constant; with a train, the load of the train."""
    start: float = 0.0
    """The displacement at the start of the turn as proofs take it [mm, or deg if angular]."""
    radii: tuple[float, ...] = ()
    """Radii of a given profile's pitch curve, with a flat face of the profile itself [mm].

    Negative on hollow flanks, infinite for lines; empty if the profile is not given.
    """
    tool_programme: "Programme | None" = None
    """The motion of the tool that the follower drives through a train; without loads."""
    given_at_follower: bool = False
    """Whether the scene gives the motion of the follower, so that the tool's motion follows from it."""
    reverse_of: "Programme | None" = None
    """The turn of which this is the reversed one, lift − y."""

    @property
    def tool(self) -> "Programme":
        """The motion of the tool; without a train, the follower is the tool."""
        return self.tool_programme or self

    @property
    def programme_given_by_scene(self) -> "Programme":
        """The motion that the scene gives, of the tool or of the follower; without the load of a train."""
        if self.tool_programme is None:
            return self
        return replace(self, tool_programme=None, load=None) if self.given_at_follower else self.tool_programme

    @classmethod
    def from_segments(
        cls,
        segments: Sequence[MotionSegment | tuple[str, float, float, str | None]],
        *,
        angular: bool,
        laws: Mapping[str, Law] = LAWS,
        load: ExternalLoad | TrainLoad | None = None,
    ) -> "Programme":
        """The motion of the scene's segments; those of no length are left out. Lifts in deg if ``angular``."""
        start, strokes = start_position_and_strokes(
            [MotionSegment(*each) for each in segments], angular=angular, laws=laws
        )
        return cls(strokes_with_move_laws(tuple(strokes)), load, start).on_base_circle()

    def with_laws(self, rise: Law | None, fall: Law | None) -> "Programme":
        """The same turn with other laws on its rises and returns (None keeps them)."""
        laws = {RISE: rise, RETURN: fall}
        strokes = tuple(replace(s, law=laws.get(s.kind) or s.law) for s in self.strokes)
        return replace(self, strokes=strokes_with_move_laws(strokes)).on_base_circle()

    @cached_property
    def reversed_programme(self) -> "Programme":
        """The turn with the displacement lift − y, without loads and train, as for the second disc of a pair."""
        strokes = tuple(stroke.reversed_stroke(self.lift) for stroke in self.strokes)
        return Programme(strokes, start=(self.lift - self.strokes[0].low) / self.unit_in_mm_or_rad, reverse_of=self)

    def on_base_circle(self) -> "Programme":
        """The same turn with displacements from its lowest position."""
        least, most = self.lowest_and_highest_displacement
        if abs(least) <= LEAST_JUMP * (most - least):
            return self
        start = self.start - least / self.unit_in_mm_or_rad
        up = start * self.unit_in_mm_or_rad - self.strokes[0].low
        strokes = tuple(replace(s, low=s.low + up, high=s.high + up) for s in self.strokes)
        return replace(self, strokes=strokes, start=start)

    @property
    def unit_in_mm_or_rad(self) -> float:
        """The scene's unit of displacement, in mm or rad."""
        return next((stroke.given.unit_in_mm_or_rad for stroke in self.strokes if stroke.given), 1.0)

    def law_names(self, kind: int) -> str:
        """The laws of the tool's strokes of a kind, in order; different ones are joined by "+"."""
        return "+".join(dict.fromkeys(s.law.NAME for s in self.tool.strokes if s.kind == kind and s.law))

    @property
    def has_sampled_law(self) -> bool:
        """Whether a law is known at samples only: from the points of a table, or the functions of a package."""
        return any(isinstance(s.law, SplineLaw | InstalledLaw) and s.law.sampled for s in self.tool.strokes)

    @property
    def lift(self) -> float:
        """Highest displacement of the turn [mm or rad]."""
        return self.lowest_and_highest_displacement[1]

    @cached_property
    def lowest_and_highest_displacement(self) -> tuple[float, float]:
        """Lowest and highest displacement of the turn [mm or rad], at ends of strokes or turning points."""
        levels = [y for stroke in self.strokes for y in (stroke.low, stroke.high)]
        for stroke in self.strokes:
            if stroke.law is not None and (places := turning_points(stroke.law, TURN_PANELS)):
                levels += (stroke.low + stroke.size * stroke.law.displacement(np.array(places))).tolist()
        return min(levels), max(levels)

    def has_kinds(self, kinds: int) -> bool:
        """Whether any piece of the turn has one of some kinds or directions."""
        return bool(self.kinds & kinds)

    @cached_property
    def kinds(self) -> int:
        """All kinds and directions of its pieces, as bits."""
        return int(np.bitwise_or.reduce(self.table.kind))

    @cached_property
    def table(self) -> MotionTable:
        return _build_table(self)

    @cached_property
    def lift_curve(self) -> TurnCurve:
        """The displacement over the turn [mm or rad]."""
        table = self.table
        ends = np.append(table.centre - table.half_width, TURN)
        ends[0] = 0.0
        return TurnCurve(ends, table.coefficients.T, float(table.error[:, 0].max()))

    @property
    def piece_starts(self) -> FloatArray:
        """Cam angle at which each piece of the table starts [rad]."""
        first = self.table.first_panel[:-1]
        return np.asarray(self.table.centre[first] - self.table.half_width[first])

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """The jumps of y' or y''; the end of the turn is joined to its start."""
        return tuple(find_jumps(self, (1, 2)))

    @cached_property
    def acceleration_jump_rounding(self) -> float:
        """Largest jump of y'' that counts as rounding and not as a jump."""
        return LEAST_JUMP * float(self.table.most[:, 2].max()) + 2.0 * float(self.table.error[:, 2].max())

    @cached_property
    def dwells(self) -> tuple[Stroke, ...]:
        """The dwells in the order of the turn; neighbouring dwells are joined, also across the end of the turn.

        A dwell across the end of the turn has its end beyond 2π; the last stroke continues at these angles.
        """
        rests = [stroke.kind == DWELL for stroke in self.strokes]
        first = rests.index(False) if rests[-1] and not all(rests) else 0
        order = self.strokes[first:] + self.strokes[:first]
        runs = [[*run] for rest, run in groupby(order, lambda stroke: stroke.kind == DWELL) if rest]
        return tuple(replace(run[0], angle=sum(stroke.angle for stroke in run), given=None) for run in runs)

    @property
    def corners(self) -> tuple[Jump, ...]:
        """The jumps of y', where the acceleration is an impulse and the pitch curve has a corner."""
        return tuple(j for j in self.jumps if j.order == 1)

    @property
    def nose_angle_deg(self) -> float:
        """Cam angle of the highest point, or of the middle of the first dwell there [deg], within 0.01 deg."""
        angles = np.arange(36_000) / 100.0
        y = self.motion_at(np.radians(angles), 0)[0]
        highest = y >= y.max() - 1e-9 * self.lift
        first = int(np.argmax(highest & ~np.roll(highest, 1)))
        length = max(int(np.argmin(np.roll(highest, -first))) - 1, 0)
        return float((angles[first] + 0.5 * length * angles[1]) % 360.0)

    def motion_at(self, angles: FloatArray, order: int = 3) -> FloatArray:
        """Rows of y, y', y'' … up to an order, at cam angles in rad, from the laws themselves."""
        angles = np.asarray(angles, dtype=float)
        rows = np.zeros((order + 1, *angles.shape))
        index = np.searchsorted(np.array([s.start for s in self.strokes]), angles, side="right") - 1
        for k in np.unique(index[index >= 0]):
            here = index == k
            rows[:, here] = self.strokes[k].motion(angles[here], order)
        return rows

    def state(self, angles: FloatArray) -> State:
        """The state of the follower at cam angles, which curves take."""
        motion = self.motion_at(angles)
        load = (
            None
            if self.load is None
            else self.load.load_state(angles, motion, motion_directions(self.kinds_at(angles)))
        )
        y, y1, y2, y3 = motion
        return State(y, y1, y2, y3, load)

    def least_speed(self, sense: float) -> float:
        """Least y' of the turn; with the sense −1 that of the turn run backwards [mm or rad per rad]."""
        return min(sense * speed for speed in weighted_derivative_range(self, (0, 1), ALL_STROKES))

    def panels_with_kinds(self, kinds: int) -> BoolArray:
        """Mask of the table's panels in pieces of some kinds or directions."""
        return np.repeat((self.table.kind & kinds) != 0, np.diff(self.table.first_panel))

    def panel_angles(self, angles_per_panel: int) -> FloatArray:
        """Cam angles on every panel [rad], ``angles_per_panel`` each, and on both sides of each jump, in order."""
        half = self.table.half_width[:, None]
        inner = np.clip(np.linspace(-1.0, 1.0, angles_per_panel) * half, JUMP_SIDE - half, half - JUMP_SIDE)
        return np.asarray((self.table.centre[:, None] + inner).ravel())

    def kinds_at(self, angles: FloatArray) -> IntArray:
        """Kinds and directions of the pieces at cam angles."""
        return np.asarray(self.table.kind[np.searchsorted(self.piece_starts[1:], angles, side="right")])

    def one_sided_angles(self, angles: FloatArray, kinds: int) -> FloatArray:
        """Cam angles just before and just after others, (2, …), for both one-sided values at a jump.

        All are in pieces of some kinds. An angle outside them is replaced by that of the other side, or else by the
        middle of such a piece. (0, …) if there is no such piece.
        """
        table, starts = self.table, self.piece_starts
        pieces = np.flatnonzero(table.kind & kinds)
        if not pieces.size:
            return np.empty((0, *angles.shape))
        middle = np.mean([*starts, self.strokes[-1].end][pieces[0] : pieces[0] + 2])
        sides = np.mod(np.stack([angles - JUMP_SIDE, angles + JUMP_SIDE]), self.strokes[-1].end)
        inside = (self.kinds_at(sides) & kinds) != 0
        return np.where(inside, sides, np.where(inside[::-1], sides[::-1], middle))

    def cuts_as_stroke_shares(self, stroke: Stroke) -> tuple[float, ...]:
        """Turning points of the motion and corners of the load, as shares of a stroke; corners outside it too."""
        corners = tuple((angle - stroke.start) / stroke.angle for angle in (self.load.angles if self.load else ()))
        return corners if stroke.law is None else (*turning_points(stroke.law, TURN_PANELS), *corners)


@lru_cache(maxsize=512)
def _build_table(programme: Programme) -> MotionTable:
    rows, centres, halves, pieces, kinds = [], [], [], [0], []
    numbers: list[IntArray] = []
    for stroke in programme.strokes:
        if stroke.law is None:
            ends = np.array(breaks_with_cuts((0.0, 1.0), programme.cuts_as_stroke_shares(stroke)))
            counts: tuple[int, ...] = (1,) * (len(ends) - 1)
            coefficients = np.zeros((len(counts), TABLE_DEGREE + 1))
        else:
            coefficients, ends, counts = law_panel_polynomials(
                stroke.law, TURN_PANELS, programme.cuts_as_stroke_shares(stroke)
            )
        row = coefficients * stroke.size
        # the direction of motion of each piece of a stroke, from its coefficients (panels, powers)
        last = np.cumsum(counts) - 1
        first = last - np.array(counts) + 1
        left, right = polynomial.polyval(np.array([-1.0, 1.0]), row.T).T
        ways = [int({1: OUTWARD, -1: INWARD}.get(way, RESTING)) for way in np.sign(right[last] - left[first])]
        row[:, 0] += stroke.low
        rows.append(row)
        centres.append(stroke.start + stroke.angle * (ends[1:] + ends[:-1]) / 2)
        halves.append(stroke.angle * np.diff(ends) / 2)
        numbers.append(np.full(len(row), len(numbers), dtype=np.int64))
        for count, way in zip(counts, ways, strict=True):
            pieces.append(pieces[-1] + count)
            kind = next(kind for kind in WAY_OF if WAY_OF[kind] == way) if stroke.is_move else stroke.kind
            kinds.append(kind | way)
    coefficients, centre, half_width = np.concatenate(rows), np.concatenate(centres), np.concatenate(halves)
    first_panel, number = np.array(pieces), np.concatenate(numbers)
    group = group_number_of_each_panel(first_panel)
    low, high, most, error = derivative_ranges_and_errors(coefficients, half_width, number, group)
    table = MotionTable(
        coefficients,
        centre,
        half_width,
        first_panel,
        np.array(kinds),
        np.empty(0),
        group,
        low,
        high,
        most,
        error,
        None,
    )
    table = table._replace(nodes=node_displacements_and_derivatives(table, first_panel))
    return table if programme.load is None else table._replace(load=programme.load.panel_table(table, number))


def find_jumps(programme: Programme, orders: Sequence[int]) -> list[Jump]:
    """The jumps of derivatives of some orders; at the start of a piece only the first order that jumps."""
    table = programme.table
    pieces = np.arange(table.kind.size)
    first = table.nodes[table.first_panel[:-1] + pieces]
    last = table.nodes[table.first_panel[1:] + pieces]
    scale = np.max(np.abs(table.nodes), axis=0)
    start = table.centre[table.first_panel[:-1]] - table.half_width[table.first_panel[:-1]]
    jumps = []
    for q in pieces:
        change = first[q] - last[q - 1]
        for order in orders:
            if abs(change[order]) > LEAST_JUMP * scale[order]:
                kinds = int(table.kind[q] | table.kind[q - 1])
                jumps.append(Jump(order, float(start[q]), float(change[order]), float(first[q, order]), kinds))
                break
    return jumps


def derivative_peak(programme: Programme, order: int, kinds: int) -> float:
    """Largest magnitude of a derivative by the cam angle, over strokes of some kinds.

    Infinite if a lower derivative jumps in one of them or at its ends.
    """
    if any(j.order < order and j.kinds & kinds for j in programme.jumps):
        return inf
    least, largest = weighted_derivative_range(programme, (0.0,) * order + (1.0,), kinds)
    return max(-least, largest, 0.0)


USUAL_ORDERS = 4  # up to the jerk: all are computed together, as callers seldom need only one


@lru_cache(maxsize=4096)
def weighted_derivative_range(
    programme: Programme,
    weights: tuple[float, ...],
    kinds: int,
    load_weight: float = 0.0,
    inertia_weight: float = 0.0,
) -> tuple[float, float]:
    """Least and largest value of w₀·y + w₁·y' + w₂·y'' + … over strokes of some kinds.

    ``load_weight`` is the weight of a changing external load, ``inertia_weight`` that of the inertia of a train.
    The values are exact: extremes of the panels' polynomials, from the roots of their derivatives, and one-sided
    values at jumps. (inf, -inf) if there is no such stroke.
    """
    arrays = _derivative_polynomials_and_bounds(programme, max(len(weights), USUAL_ORDERS), kinds)
    if arrays is None:
        return inf, -inf
    factors, terms = np.array((*weights, load_weight, inertia_weight)), [*range(len(weights)), -2, -1]
    used = np.flatnonzero(factors)
    series, slope, ends, slopes, bounds = (matrix_product(factors[used], array[terms][used]) for array in arrays)
    low, high = bounds.min(axis=0), bounds.max(axis=0)
    least, largest, rounding = float(ends.min()), float(ends.max()), OVERSHOOT * max(-low.min(), high.max())
    turning = (slopes.min(axis=0) < 0) & (slopes.max(axis=0) > 0)  # other panels have no extreme inside,
    beyond = (low < least + rounding) | (high > largest - rounding)  # or none that exceeds the ends'
    inside = [
        float(polynomial.polyval(u, series[:, k]))
        for k in np.flatnonzero(turning & beyond)
        for u in places_of_sign_change(slope[:, k])
    ]
    return min([least, *inside]), max([largest, *inside])


@lru_cache(maxsize=256)
def _derivative_polynomials_and_bounds(
    programme: Programme, orders: int, kinds: int
) -> tuple[FloatArray, ...] | None:
    """Polynomials of y, y', y'' …, load and inertia on panels of some kinds, with their slopes and bounds.

    Returns the coefficients, those of the slopes, the values at the ends, bounds of the slopes and bounds of the
    values. Each array is (orders + 2, …, panels), that of the ends (orders + 2, panels, 2). Bounds are Bernstein
    coefficients: if those of a slope have one sign, it has no root.
    """
    table = programme.table
    panels = programme.panels_with_kinds(kinds)
    if not panels.any():
        return None
    y, h = table.coefficients[panels].T, table.half_width[panels]
    series = np.zeros((orders + 2, *y.shape))
    for order in range(orders):
        series[order, : len(y) - order] = polynomial.polyder(y, order) / h**order
    for place, force in enumerate(
        (external_load_polynomials_by_panel(table), train_inertia_polynomials_by_panel(table)), start=orders
    ):
        series[place, : len(force)] = force[:, panels]
    slope = series[:, 1:] * np.arange(1.0, len(y))[:, None]
    by_powers, slopes = np.moveaxis(series, 1, 0), np.moveaxis(slope, 1, 0)
    bounds = (matrix_product(powers_to_bernstein_matrix(len(each) - 1), each) for each in (slopes, by_powers))
    ends = polynomial.polyval(np.array([-1.0, 1.0]), by_powers)
    return series, slope, ends, *(np.moveaxis(each, 1, 0) for each in bounds)


def derivative_power_mean(programme: Programme, order: int, power: int) -> float:
    """Mean of a power of a derivative over the turn, 1/2π·∫ (y⁽ᵏ⁾)ᵖ dθ with p = 1 or 2.

    Gauss's rule on each panel is exact for its polynomial.
    """
    table = programme.table
    nodes, weights, _ = gauss_rule(table.coefficients.shape[1])
    values = polynomial.polyval(nodes, polynomial.polyder(table.coefficients.T, order), tensor=True)
    powers = matrix_product((values / table.half_width[:, None] ** order) ** power, weights) * table.half_width
    return float(powers.sum() / (2 * pi))


def derivative_root_mean_square(programme: Programme, order: int) -> float:
    """Root mean square of a derivative over the turn, √(1/2π·∫ (y⁽ᵏ⁾)² dθ)."""
    return sqrt(derivative_power_mean(programme, order, 2))


def law_displacement_range(law: Law) -> tuple[float, float]:
    """Least and largest displacement of a law's unit stroke; exactly 0 and 1 up to rounding."""
    least, largest = weighted_derivative_range(Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),)), (1.0,), RISE)
    return least if least < -OVERSHOOT else 0.0, largest if largest > 1.0 + OVERSHOOT else 1.0


LAW_PEAKS = {"peak_velocity": 1, "peak_acceleration": 2, "peak_jerk": 3}


def law_peaks(law: Law) -> dict[str, float | str]:
    """Peak velocity, acceleration and jerk of a law's unit stroke between dwells, and the derivative that jumps."""
    rest = Stroke(DWELL, None, 1.0, 1.0, 1.0, 1.0)
    rise = Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0)
    fall = Stroke(RETURN, law, 2.0, 1.0, 1.0, 0.0)
    turn = Programme((rise, rest, fall, replace(rest, start=3.0, low=0.0, high=0.0)))
    jumps = {1: "velocity", 2: "acceleration"}
    lowest = min((jump.order for jump in turn.jumps if jump.kinds & RISE), default=0)
    return {
        **{name: derivative_peak(turn, order, RISE) for name, order in LAW_PEAKS.items()},
        "jumps": jumps.get(lowest, ""),
    }


def law_peaks_inside_stroke(law: Law) -> dict[str, float]:
    """Peak velocity, acceleration and jerk within a law's unit stroke; jumps at its ends do not count."""
    stroke = Programme((Stroke(RISE, law, 0.0, 1.0, 0.0, 1.0),))
    ranges = {
        name: weighted_derivative_range(stroke, (0.0,) * order + (1.0,), RISE) for name, order in LAW_PEAKS.items()
    }
    return {name: max(abs(least), abs(largest)) for name, (least, largest) in ranges.items()}

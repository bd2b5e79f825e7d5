"""The problem that free motion laws solve: an objective and constraints on the motion and on two sizes.

The two sizes are the lead e and the height s₀ of the trace point. The cam radius is √(s₀² + e²) less the roller
radius. A flat face and a cylindrical cam have no lead: their height is their radius. Lengths are in mm, angles in
rad, derivatives per rad of the cam angle.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, hypot, inf, pi
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.mechanisms import Designs, oscillating, translating
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE, Condition, Stroke
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.closed_form import pressure_tangents_by_stroke
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.residual import ResidualResponse, residual_response
from camopt.solve.synthesis.splines import Splines

TERM_ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}
RMS_TERM_ORDERS = {"acceleration_rms": 2, "jerk_rms": 3}
CROSSING_JERK = "crossing_jerk"
"""Objective term: largest jerk while a roller crosses its clearance (``crossings``)."""
LOST_AREA = "lost_lift_area"
"""Objective term: lift area that the motion gives up. It is linear, and least where the lift area is largest."""

SIZE_WORDS = "the size"
LIMIT_MARGINS = (1e-7, 1e-6, 1e-5, 1e-4)  # relative margins that keep a solver's error within the limits
CONE_MARGIN_FACTOR = 100.0  # times the margin for a cone constraint, where solvers err more

LowHigh = tuple[float, float]


@dataclass(frozen=True)
class LinearConstraint:
    """A linear constraint that holds all along strokes of some kinds:

    displacement·y + velocity·y' + acceleration·y'' + lead·e + height·s₀ + constant ≥ 0
    """

    name: str
    displacement: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    lead: float = 0.0
    height: float = 0.0
    constant: float = 0.0
    kinds: int = ALL_STROKES

    def must_hold_on_stroke_or_move(self, stroke: Stroke) -> bool:
        """Whether a free stroke must hold the constraint everywhere.

        Where a move rests, the constraint holds as it did on the way there. A move must also hold a constraint on
        rises that bounds y' from above, and one on returns that bounds y' from below.
        """
        kinds = stroke.kind & (RISE | RETURN) if stroke.is_move else stroke.kind
        ways = self.kinds & (RISE | RETURN)
        about = (ways == RISE and self.velocity < 0.0) or (ways == RETURN and self.velocity > 0.0)
        return self.kinds & kinds == kinds or (stroke.is_move and about)


@dataclass(frozen=True)
class MeanConstraint:
    """A bound on the mean, or on the root mean square, of a derivative over the turn [mm or rad, per radᵏ]."""

    name: str
    order: int
    power: int
    bound: float
    side: float
    """−1 for a lower bound, 1 for an upper bound."""


class StrokeCrossing(NamedTuple):
    """Where the force changes its sign in a stroke: the range of x of the unit stroke, and what must follow it."""

    stroke: int
    """Number of the stroke."""
    low: float
    high: float
    window: float
    """Part of the unit stroke within which the roller must land."""
    angle: float
    """The same as a cam angle [rad]."""
    acceleration_allowance: float
    """Acceleration that is allowed at ``high``, per unit of the largest jerk [rad]."""
    clearance_allowance: float
    """Part of the clearance that may be left to cross, per unit of the largest jerk [rad³]."""
    gap: float
    """Largest clearance along the motion, at the allowed pressure angle, in units of the lift."""

    @property
    def ends(self) -> tuple[float, ...]:
        """The x at which constraints of the crossing begin or end."""
        windows = (min(x + self.window, 1.0) for x in (self.low, self.high))
        return self.low, self.high, *windows


@dataclass(frozen=True)
class SynthesisProblem:
    """All constraints on free laws, and their objective.

    Displacements count from the lowest position that the scene gives, if the motion may rest there; free moves do
    not go below it. Otherwise they count from the lowest point of the scene's own motion, at ``lowest_angle``.
    """

    scene_problem: Problem
    splines: Splines
    strokes: tuple[Stroke, ...]
    zero: float
    """Position where the displacement is 0, as the scene gives it [mm or deg]."""
    lowest_angle: float | None
    lead_range: LowHigh
    """Least and largest lead e [mm]. An arm has no lead: in its place is the change of the arm's length."""
    prime_range: LowHigh
    """Least and largest prime radius √(s₀² + e²): the cam radius plus the roller radius [mm]."""
    largest_roller: float
    """Largest radius of the roller or spherical face [mm]; it gives the least base radius for a prime radius."""
    derivative_ranges: tuple[dict[int, LowHigh], ...]
    """For each stroke, the range of each limited derivative, by its order."""
    linear_constraints: tuple[LinearConstraint, ...]
    mean_constraints: tuple[MeanConstraint, ...]
    residual_limit: float | None
    """Largest residual vibration allowed [mm or deg]."""
    rest: int
    """Number of derivatives that are 0 at the ends of a dwell."""
    monotone: bool
    conditions: tuple[Condition, ...]
    objective: dict[str, float]
    mirror_strokes: tuple[int, ...] | None = None
    """For each stroke, the stroke that must mirror it, if the motion is to be symmetric."""
    opposed_strokes: tuple[int, ...] | None = None
    """For each stroke, the stroke half a turn later that must be its negative, for a yoke on one disc."""
    crossings: tuple[StrokeCrossing, ...] = ()
    """Where the force changes its sign, for the objective term ``CROSSING_JERK``."""
    crossing_window: float = 0.0
    """Cam angle within which the roller must land after that [rad]."""
    smooth: float = 0.0
    """Share of the objective that is given up for the least variation of the jerk."""
    jerk_jumps: tuple[tuple[float, ...], ...] = ()
    """For each stroke, the x beside which the jerk of an optimal motion jumps; splines are cut there."""

    @property
    def prime_less_cam_radius(self) -> float:
        """Prime radius less the cam radius [mm]."""
        return prime_less_cam_radius(self.scene_problem, self.largest_roller)

    @property
    def motion_unit(self) -> float:
        """Unit of the motion in the convex programme: the highest lift [mm or rad]."""
        return max(stroke.high for stroke in self.strokes) or self.scene_problem.programme.tool.lift

    @property
    def size_unit(self) -> float:
        """Unit of the sizes [mm]: the highest lift, or the arc through which an oscillating follower swings."""
        design, train = self.scene_problem.design, self.scene_problem.setup.train
        lift = self.motion_unit
        if train is not None:
            lift = (
                self.scene_problem.programme.lift if (ratio := train.constant_ratio) is None else lift / abs(ratio)
            )
        radius = float(max(design.arm_length[0], design.centre_distance[0]))
        return radius * lift if self.scene_problem.setup.angular else lift

    @property
    def has_lead_in_prime_radius(self) -> bool:
        """Whether the lead is part of the size, as for a follower with a trace point on a disc cam."""
        return self.scene_problem.setup.mechanism.moves_as(translating.MECHANISM)

    def lead_and_height_of_cam(self, size: float, offset: float, arm_length: float) -> tuple[float, float]:
        """The lead (or the change of the arm) and the height of a cam, in units of the sizes."""
        design, prime = self.scene_problem.design, size + self.prime_less_cam_radius
        lead = (
            arm_length - float(design.arm_length[0]) if self.scene_problem.setup.angular else design.sense * offset
        )
        height = float(difference_of_squares_root(prime, lead)) if self.has_lead_in_prime_radius else prime
        return lead / self.size_unit, height / self.size_unit

    def design_of_sizes(self, lead: float | FloatArray, height: float | FloatArray) -> Designs:
        """The designs of leads (or changes of the arm) and heights [mm], with the largest roller."""
        prime, design = (
            np.hypot(lead, height) if self.has_lead_in_prime_radius else height,
            self.scene_problem.design,
        )
        offset, change = (0.0, lead) if self.scene_problem.setup.angular else (design.sense * lead, 0.0)
        return replace(
            design,
            size=np.atleast_1d(prime - self.prime_less_cam_radius),
            roller_radius=np.array([self.largest_roller]),
            offset=np.atleast_1d(offset),
            arm_length=design.arm_length + change,
        )

    @property
    def has_convex_size_constraints(self) -> bool:
        """Whether the constraints that make the cam large are convex.

        They are not if the follower oscillates, is lowest within a move, or drives its tool at a changing ratio.
        """
        train = self.scene_problem.setup.train
        constant = train is None or train.constant_ratio is not None
        return constant and not self.scene_problem.setup.angular and self.lowest_angle is None

    @property
    def train_frequency_and_damping(self) -> tuple[float, float]:
        """Frequency ratio ω_n/ω and damping ratio of the follower train; only if its residual vibration counts."""
        frequency_and_damping = residual.train_frequency_and_damping(self.scene_problem.setup)
        assert frequency_and_damping is not None
        return frequency_and_damping

    @property
    def residual_response(self) -> ResidualResponse:
        """Residual vibration that the free strokes leave, linear in their coefficients."""
        splines = tuple(self.splines_by_stroke[stroke] for stroke in self.free_strokes)
        return residual_response(self.strokes, splines, self.motion_unit, *self.train_frequency_and_damping)

    @property
    def limit_names(self) -> list[str]:
        """Names of all limits and conditions, each of which can be left out (``keep_limits``)."""
        orders = [
            name for name, order in TERM_ORDERS.items() if any(order in row for row in self.derivative_ranges)
        ]
        limits = [
            *orders,
            *(constraint.name for constraint in self.linear_constraints),
            *(mean.name for mean in self.mean_constraints),
        ]
        limits += [SIZE_WORDS] if self.prime_range[1] < inf else []
        limits += [] if self.residual_limit is None else [residual.RESIDUAL_TERM]
        return list(dict.fromkeys([*limits, *(condition.key for condition in self.conditions)]))

    def keep_limits(self, names: Collection[str]) -> "SynthesisProblem":
        """The problem with only the named limits and conditions."""
        kept_orders = {order for name, order in TERM_ORDERS.items() if name in names}
        return replace(
            self,
            derivative_ranges=tuple(
                {order: ends for order, ends in row.items() if order in kept_orders}
                for row in self.derivative_ranges
            ),
            linear_constraints=tuple(
                constraint for constraint in self.linear_constraints if constraint.name in names
            ),
            mean_constraints=tuple(mean for mean in self.mean_constraints if mean.name in names),
            prime_range=self.prime_range if SIZE_WORDS in names else (self.prime_range[0], inf),
            residual_limit=self.residual_limit if residual.RESIDUAL_TERM in names else None,
            conditions=tuple(condition for condition in self.conditions if condition.key in names),
        )

    @cached_property
    def splines_by_stroke(self) -> dict[Stroke, Splines]:
        """The splines of free strokes, cut where constraints begin or end and where the optimal jerk jumps."""
        continuity = max(self.rest, self.splines.continuity_at_cuts)
        return {
            stroke: replace(self.splines, cuts=self._spline_cut_positions(stroke), continuity_at_cuts=continuity)
            for stroke in self.free_strokes
        }

    def _spline_cut_positions(self, stroke: Stroke) -> tuple[float, ...]:
        """The x at which to cut a stroke, with those of its mirrored or opposed stroke; constraints come first."""
        number = self.strokes.index(stroke)
        strokes = [
            stroke,
            *(self.strokes[partner_number] for partner_number in (self.opposed_strokes or ())[number : number + 1]),
        ]
        partner, cuts = self.mirror_partner(stroke), list[float]()
        for places_of in (self._stroke_x_of_conditions_and_crossings, self._jerk_jumps_of):
            places = {x for other in strokes for x in places_of(other)}
            if partner is not None:
                places |= {1.0 - x for x in places_of(partner)}
            cuts += sorted(x for x in places if 0.0 < x < 1.0)
        return tuple(cuts)

    def _jerk_jumps_of(self, stroke: Stroke) -> tuple[float, ...]:
        return self.jerk_jumps[self.strokes.index(stroke)] if self.jerk_jumps else ()

    def _stroke_x_of_conditions_and_crossings(self, stroke: Stroke) -> Iterator[float]:
        """The x at which the conditions and crossings of one stroke begin or end."""
        for part in (stroke.part_under_condition(item) for item in self.conditions):
            yield from part or ()
        for item in self.crossings_in(stroke):
            yield from item.ends

    def mirror_partner(self, stroke: Stroke) -> Stroke | None:
        """The stroke that must mirror a stroke; None if the motion need not be symmetric."""
        return (
            None if self.mirror_strokes is None else self.strokes[self.mirror_strokes[self.strokes.index(stroke)]]
        )

    def stroke_crossing(self, stroke_number: int, low: float, high: float) -> StrokeCrossing:
        """The crossing of a stroke whose force changes its sign between two x."""
        angle, window, scene_problem = self.strokes[stroke_number].angle, self.crossing_window, self.scene_problem
        steepest = [
            slope
            for slope, kinds in pressure_tangents_by_stroke(scene_problem)
            if kinds & self.strokes[stroke_number].kind
        ]
        clearance = float(scene_problem.setup.given.drive.clearance or 0.0) * hypot(1.0, min(steepest, default=0.0))
        arm = scene_problem.search_space.variables.get("arm_length")
        shortest = arm.range_ends[0] if arm else float(scene_problem.design.arm_length[0])
        gap = clearance / (shortest if scene_problem.setup.angular else 1.0)
        angle_range = (high - low) * angle
        return StrokeCrossing(
            stroke_number,
            low,
            high,
            window / angle,
            window,
            angle_range,
            window * angle_range**2 / 2.0,
            gap / self.motion_unit,
        )

    def crossings_in(self, stroke: Stroke) -> list[StrokeCrossing]:
        """The crossings of one stroke."""
        return [each for each in self.crossings if self.strokes[each.stroke] is stroke]

    @property
    def opposed_pairs(self) -> list[tuple[int, int, float]]:
        """Pairs of opposed strokes, by number, and the sum of their displacements, in units of the lift.

        The stroke of the first half turn is the first of a pair.
        """
        return [
            (one, other, (self.strokes[one].low + self.strokes[other].low) / self.motion_unit)
            for one, other in enumerate(self.opposed_strokes or ())
            if one < other
        ]

    def law_offset_and_scale(self, stroke: Stroke) -> tuple[float, float]:
        """Displacement at law value 0, and its increase up to law value 1, in units of the lift.

        The law of a move is the displacement itself, in these units.
        """
        return (
            (0.0, 1.0)
            if stroke.is_move
            else (stroke.low / self.motion_unit, (stroke.high - stroke.low) / self.motion_unit)
        )

    def required_continuity_at_joint(self, angle: float) -> int:
        """Number of continuous derivatives where two moving strokes meet at a cam angle."""
        orders = (condition.order for condition in self.conditions if condition.start == condition.end == angle)
        return max(self.rest, *orders, 0)

    @property
    def free_strokes(self) -> list[Stroke]:
        """The strokes whose laws are computed."""
        return [stroke for stroke in self.strokes if stroke.is_law_replaceable]

    @property
    def term_unit_factors(self) -> dict[str, float]:
        """Factor of each objective term from mm or rad per radᵏ to the unit of [limits]."""
        setup = self.scene_problem.setup
        factors = {name: motion_unit_factor(setup, order) for name, order in TERM_ORDERS.items()}
        factors |= {"acceleration_rms": factors["acceleration"], "jerk_rms": factors["jerk"]}
        displacement = degrees(1.0) if setup.tool_turns else 1.0
        factors[CROSSING_JERK] = factors["jerk"]
        return {"size": 1.0, **factors, residual.RESIDUAL_TERM: displacement, LOST_AREA: degrees(displacement)}

    @property
    def lift_times_turn_angle(self) -> float:
        """Area under the highest displacement of the scene's own motion, over the whole turn [mm·rad or rad²]."""
        return 2.0 * pi * self.scene_problem.programme.tool.lift


def prime_less_cam_radius(scene_problem: Problem, roller_radius: float) -> float:
    """Prime radius less the cam radius [mm]: ``roller_radius`` for a trace point on a disc cam, else 0."""
    return (
        roller_radius
        if scene_problem.setup.mechanism.moves_as(translating.MECHANISM, oscillating.MECHANISM)
        else 0.0
    )


def tighten_limits(problem: SynthesisProblem, margin: float) -> SynthesisProblem:
    """The problem with its limits tightened by a relative margin, or widened if the margin is negative.

    Conditions are widened but never tightened. Two of them may leave no room, such as a motion that ends at 40 mm
    and may nowhere exceed 40 mm.
    """
    factor = 1.0 - margin
    return replace(
        problem,
        conditions=tuple(condition.with_widened_range(max(0.0, -margin)) for condition in problem.conditions),
        derivative_ranges=tuple(
            {order: (factor * low, factor * high) for order, (low, high) in ranges.items()}
            for ranges in problem.derivative_ranges
        ),
        linear_constraints=tuple(
            replace(constraint, constant=constraint.constant - margin * abs(constraint.constant))
            for constraint in problem.linear_constraints
        ),
        mean_constraints=tuple(
            replace(
                mean,
                bound=mean.bound * (1.0 - mean.side * (CONE_MARGIN_FACTOR * margin if mean.power > 1 else margin)),
            )
            for mean in problem.mean_constraints
        ),
        prime_range=(problem.prime_range[0], max(problem.prime_range[0], factor * problem.prime_range[1])),
        residual_limit=None
        if problem.residual_limit is None
        else (1.0 - CONE_MARGIN_FACTOR * margin) * problem.residual_limit,
    )

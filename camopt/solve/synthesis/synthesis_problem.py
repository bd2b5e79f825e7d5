"""The demand on new motion laws: linear limits on the motion and two sizes, and the objective.

The sizes are the lead e and the height s₀ of the trace point (a flat face and a cylindrical cam have a height
alone, their radius), so that the size of the cam is √(s₀² + e²) less the roller. Lengths in mm, angles in rad,
derivatives by the cam angle.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, hypot, inf, pi
from typing import NamedTuple

from camopt.model.effects.motion import motion_scale
from camopt.model.mechanisms import oscillating, translating
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE, Condition, Stroke
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.closed_form import pressure_tangents
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.residual import ResidualResponse, residual_response
from camopt.solve.synthesis.splines import Splines

TERM_ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}
RMS_TERM_ORDERS = {"acceleration_rms": 2, "jerk_rms": 3}
CROSSING_JERK = "crossing_jerk"
"""The term that is the largest jerk while a roller crosses its clearance (``crossings``)."""
LOST_AREA = "lost_lift_area"
"""The term that is least where the lift area is largest, and linear: less of it is better, as of the others."""

SIZE_WORDS = "the size"
LIMIT_MARGINS = (1e-7, 1e-6, 1e-5, 1e-4)  # by which limits are held closer than asked, for a solver's error
CONE_MARGIN_FACTOR = 100.0  # times that, for a limit that is a cone: a solver errs more there

LowHigh = tuple[float, float]


@dataclass(frozen=True)
class LinearConstraint:
    """A linear limit that holds all along strokes of some kinds:

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

    def holds_along(self, stroke: Stroke) -> bool:
        """Whether it holds all along a stroke. Where a move rests it does too, as it did on the way there."""
        kinds = stroke.kind & (RISE | RETURN) if stroke.is_move else stroke.kind
        return self.kinds & kinds == kinds

    def is_imposed_on(self, stroke: Stroke) -> bool:
        """Whether it is to hold all along a free stroke: also one about the way in which it pulls, in a move."""
        ways = self.kinds & (RISE | RETURN)
        about = (ways == RISE and self.velocity < 0.0) or (ways == RETURN and self.velocity > 0.0)
        return self.holds_along(stroke) or (stroke.is_move and about)


@dataclass(frozen=True)
class MeanConstraint:
    """A bound, in mm or rad, on the mean of a derivative over the turn, or on its root mean square."""

    name: str
    order: int
    power: int
    bound: float
    side: float
    """−1 where it must be at least so much, else 1."""

    def with_margin(self, share: float) -> "MeanConstraint":
        """The limit held closer by a share of its bound, or wider."""
        return replace(self, bound=self.bound * (1.0 - self.side * share))


class StrokeCrossing(NamedTuple):
    """Where the force turns round in a stroke: between which x of the unit stroke, and what it does from there."""

    stroke: int
    """By number."""
    low: float
    high: float
    window: float
    """By x, within which the roller has to land."""
    angle: float
    """The same as a cam angle, rad."""
    acceleration_allowance: float
    """How much acceleration there may be at ``high``, for 1 of the largest jerk, rad."""
    clearance_allowance: float
    """By how much less than the clearance it may have gone, for 1 of the largest jerk, rad³."""
    gap: float
    """The largest clearance along the motion, by the pressure angle that is allowed, in units of the lift."""

    @property
    def ends(self) -> tuple[float, ...]:
        """Where something is asked for begins and ends."""
        windows = (min(x + self.window, 1.0) for x in (self.low, self.high))
        return self.low, self.high, *windows


@dataclass(frozen=True)
class SynthesisProblem:
    """Everything that free laws have to hold, and what they minimise.

    Displacements are counted from the lowest that is given, where the motion may rest there: free moves do not go
    below it. Else they are from the lowest of the scene's own motion, at the angle ``lowest_angle``.
    """

    scene_problem: Problem
    splines: Splines
    strokes: tuple[Stroke, ...]
    zero: float
    """The position where the displacement is 0, as given: mm, or deg."""
    lowest_angle: float | None
    lead_range: LowHigh
    prime_range: LowHigh
    """The size with the roller: √(s₀² + e²)."""
    largest_roller: float
    """The largest radius of the roller or spherical face: it makes the least base radius of a prime radius."""
    derivative_ranges: tuple[dict[int, LowHigh], ...]
    """For each stroke, the range of each limited derivative, by its order."""
    linear_constraints: tuple[LinearConstraint, ...]
    mean_constraints: tuple[MeanConstraint, ...]
    residual_limit: float | None
    """The largest residual vibration, mm or deg."""
    rest: int
    monotone: bool
    conditions: tuple[Condition, ...]
    objective: dict[str, float]
    mirror_strokes: tuple[int, ...] | None = None
    """For each stroke the one that has to mirror it, where the motion is to be symmetric."""
    opposed_strokes: tuple[int, ...] | None = None
    """For each stroke the one half a turn later, which has to be it upside down, where a yoke is on one disc."""
    crossings: tuple[StrokeCrossing, ...] = ()
    """Where the force turns round, for the jerk there."""
    crossing_window: float = 0.0
    """The cam angle within which the roller has to land then, rad."""
    smooth: float = 0.0
    """The share of the objective that is given up for the least variation of the jerk."""

    @property
    def roller(self) -> float:
        """The prime radius minus the size."""
        return traced_roller_radius(self.scene_problem, self.largest_roller)

    @property
    def motion_unit(self) -> float:
        """The unit of the motion in the convex programme: the highest lift, mm or rad."""
        return max(stroke.high for stroke in self.strokes) or self.scene_problem.programme.tool.lift

    @property
    def size_unit(self) -> float:
        """The unit of the sizes, mm: the highest lift, or the arc that an oscillating follower swings through."""
        design, train = self.scene_problem.design, self.scene_problem.setup.train
        lift = self.motion_unit
        if train is not None:
            lift = (
                self.scene_problem.programme.lift if (ratio := train.constant_ratio) is None else lift / abs(ratio)
            )
        radius = float(max(design.arm_length[0], design.centre_distance[0]))
        return radius * lift if self.scene_problem.setup.angular else lift

    @property
    def has_trace_point(self) -> bool:
        """Whether the lead is part of the size: the follower has a trace point on a disc cam."""
        return self.scene_problem.setup.mechanism.moves_as(translating.MECHANISM)

    @property
    def has_convex_size(self) -> bool:
        """Whether what makes the cam large is convex.

        Not where the follower oscillates, is lowest in a move, or drives a tool by a ratio that changes.
        """
        train = self.scene_problem.setup.train
        constant = train is None or train.constant_ratio is not None
        return constant and not self.scene_problem.setup.angular and self.lowest_angle is None

    @property
    def train_frequency_and_damping(self) -> tuple[float, float]:
        """ω_n/ω and the damping ratio of the follower train, where something asks for its residual vibration."""
        found = residual.train_frequency_and_damping(self.scene_problem.setup)
        assert found is not None
        return found

    @property
    def residual_response(self) -> ResidualResponse:
        """The residual vibration that free strokes leave, by their coefficients."""
        every = tuple(self.splines_of(stroke) for stroke in self.free_strokes)
        return residual_response(self.strokes, every, self.motion_unit, *self.train_frequency_and_damping)

    @property
    def limit_names(self) -> list[str]:
        """The names of its limits and conditions, each of which can be left out."""
        orders = [
            name for name, order in TERM_ORDERS.items() if any(order in row for row in self.derivative_ranges)
        ]
        limits = [
            *orders,
            *(floor.name for floor in self.linear_constraints),
            *(mean.name for mean in self.mean_constraints),
        ]
        limits += [SIZE_WORDS] if self.prime_range[1] < inf else []
        limits += [] if self.residual_limit is None else [residual.RESIDUAL_TERM]
        return list(dict.fromkeys([*limits, *(condition.key for condition in self.conditions)]))

    def keep_limits(self, names: Collection[str]) -> "SynthesisProblem":
        """The demand with none but some of its limits and conditions."""
        kept = {order for name, order in TERM_ORDERS.items() if name in names}
        return replace(
            self,
            derivative_ranges=tuple(
                {order: ends for order, ends in row.items() if order in kept} for row in self.derivative_ranges
            ),
            linear_constraints=tuple(floor for floor in self.linear_constraints if floor.name in names),
            mean_constraints=tuple(mean for mean in self.mean_constraints if mean.name in names),
            prime_range=self.prime_range if SIZE_WORDS in names else (self.prime_range[0], inf),
            residual_limit=self.residual_limit if residual.RESIDUAL_TERM in names else None,
            conditions=tuple(condition for condition in self.conditions if condition.key in names),
        )

    def splines_of(self, stroke: Stroke) -> Splines:
        """The splines of a free stroke: cut where something is asked for, so that the jerk may jump there."""
        return self._splines[stroke]

    @cached_property
    def _splines(self) -> dict[Stroke, Splines]:
        at_cuts = max(self.rest, self.splines.continuity_at_cuts)
        return {
            each: replace(self.splines, cuts=self._cut_places(each), continuity_at_cuts=at_cuts)
            for each in self.free_strokes
        }

    def _cut_places(self, stroke: Stroke) -> tuple[float, ...]:
        """Where something is asked for in a stroke, or in one that has to be as it is."""
        place = self.strokes.index(stroke)
        alike = [stroke, *(self.strokes[each] for each in (self.opposed_strokes or ())[place : place + 1])]
        ends = {x for one in alike for x in self._condition_places(one)}
        if (partner := self.mirror_partner(stroke)) is not None:
            ends |= {1.0 - x for x in self._condition_places(partner)}
        return tuple(sorted(x for x in ends if 0.0 < x < 1.0))

    def _condition_places(self, stroke: Stroke) -> Iterator[float]:
        """Where in a stroke something that is asked begins or ends."""
        for part in (stroke.part_under(each) for each in self.conditions):
            yield from part or ()
        for each in self.crossings_in(stroke):
            yield from each.ends

    def mirror_partner(self, stroke: Stroke) -> Stroke | None:
        """The stroke that has to mirror a stroke."""
        return (
            None if self.mirror_strokes is None else self.strokes[self.mirror_strokes[self.strokes.index(stroke)]]
        )

    def stroke_crossing(self, stroke: int, low: float, high: float) -> StrokeCrossing:
        """That the force of a stroke turns round between two x of it."""
        angle, width, scene_problem = self.strokes[stroke].angle, self.crossing_window, self.scene_problem
        steepest = [slope for slope, kinds in pressure_tangents(scene_problem) if kinds & self.strokes[stroke].kind]
        across = float(scene_problem.setup.given.drive.clearance or 0.0) * hypot(1.0, min(steepest, default=0.0))
        arm = scene_problem.search_space.variables.get("arm_length")
        shortest = arm.range_ends[0] if arm else float(scene_problem.design.arm_length[0])
        gap = across / (shortest if scene_problem.setup.angular else 1.0)
        between = (high - low) * angle
        missing = width * between**2 / 2.0
        return StrokeCrossing(stroke, low, high, width / angle, width, between, missing, gap / self.motion_unit)

    def crossings_in(self, stroke: Stroke) -> list[StrokeCrossing]:
        """Those in one stroke."""
        return [each for each in self.crossings if self.strokes[each.stroke] is stroke]

    @property
    def opposed_pairs(self) -> list[tuple[int, int]]:
        """The strokes of the first half of the turn, by number, each with the one that is it upside down."""
        return [(one, other) for one, other in enumerate(self.opposed_strokes or ()) if one < other]

    def sum_of_starts(self, one: int, other: int) -> float:
        """The sum of the displacements where two strokes start, in units of the lift."""
        return (self.strokes[one].low + self.strokes[other].low) / self.motion_unit

    def law_offset_and_scale(self, stroke: Stroke) -> tuple[float, float]:
        """The displacement where a law is 0, and what it has more where that is 1, in units of the lift.

        The law of a move is the displacement itself, in these units.
        """
        return (
            (0.0, 1.0)
            if stroke.is_move
            else (stroke.low / self.motion_unit, (stroke.high - stroke.low) / self.motion_unit)
        )

    def stroke_place(self, angle: float) -> tuple[int, float]:
        """The number of the stroke at a cam angle, and where in it that is, from 0 to 1."""
        number = next((n for n, stroke in enumerate(self.strokes) if angle < stroke.end), len(self.strokes) - 1)
        stroke = self.strokes[number]
        return number, min(max((angle - stroke.start) / stroke.angle, 0.0), 1.0)

    def continuity_at(self, angle: float) -> int:
        """The number of continuous derivatives where two moving strokes meet; with the jerk, if it is limited."""
        asked = (each.order for each in self.conditions if each.start == each.end == angle)
        return max(self.rest, *asked, 0)

    @property
    def free_strokes(self) -> list[Stroke]:
        """The strokes whose laws are sought."""
        return [stroke for stroke in self.strokes if stroke.is_free]

    @property
    def term_factors(self) -> dict[str, float]:
        """What terms of the objective have for 1 mm or rad by radᵏ: the units of [limits]."""
        setup = self.scene_problem.setup
        per = {name: motion_scale(setup, order) for name, order in TERM_ORDERS.items()}
        per |= {"acceleration_rms": per["acceleration"], "jerk_rms": per["jerk"]}
        displacement = degrees(1.0) if setup.tool_turns else 1.0
        per[CROSSING_JERK] = per["jerk"]
        return {"size": 1.0, **per, residual.RESIDUAL_TERM: displacement, LOST_AREA: degrees(displacement)}

    @property
    def largest_area(self) -> float:
        """The area below the highest displacement of the scene's own motion all round the turn, mm·rad (rad²)."""
        return 2.0 * pi * self.scene_problem.programme.tool.lift


def traced_roller_radius(scene_problem: Problem, body: float) -> float:
    """The prime radius minus the size, for a follower with a trace point on a disc cam."""
    return body if scene_problem.setup.mechanism.moves_as(translating.MECHANISM, oscillating.MECHANISM) else 0.0


def tighten_limits(problem: SynthesisProblem, margin: float) -> SynthesisProblem:
    """The demand with limits held closer by a share, or wider; conditions are not held closer than they are given.

    They may hold each other just so: a motion that ends at 40 mm and may nowhere have more.
    """
    kept = 1.0 - margin
    return replace(
        problem,
        conditions=tuple(each.widen_range(max(0.0, -margin)) for each in problem.conditions),
        derivative_ranges=tuple(
            {k: (kept * low, kept * high) for k, (low, high) in row.items()} for row in problem.derivative_ranges
        ),
        linear_constraints=tuple(
            replace(f, constant=f.constant - margin * abs(f.constant)) for f in problem.linear_constraints
        ),
        mean_constraints=tuple(
            mean.with_margin(CONE_MARGIN_FACTOR * margin if mean.power > 1 else margin)
            for mean in problem.mean_constraints
        ),
        prime_range=(problem.prime_range[0], max(problem.prime_range[0], kept * problem.prime_range[1])),
        residual_limit=None
        if problem.residual_limit is None
        else (1.0 - CONE_MARGIN_FACTOR * margin) * problem.residual_limit,
    )

"""What free motion laws are to hold and to minimise: linear limits on the motion and on two sizes.

The sizes are the lead e and the height s₀ of the trace point (a flat face and a cylindrical cam have a height
alone, their radius), so that the size of the cam is √(s₀² + e²) less the roller. Lengths in mm, angles in rad,
derivatives by the cam angle.
"""

from dataclasses import dataclass, replace
from math import degrees, inf

from camopt.effects.motion import scale
from camopt.mechanisms import oscillating, translating
from camopt.motion.stroke import Stroke
from camopt.motion.table import DWELL, TURN
from camopt.problem.problem import Problem
from camopt.synthesis import residual
from camopt.synthesis.splines import Splines

ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}

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
    kinds: int = TURN


@dataclass(frozen=True)
class Demand:
    """Everything that free laws have to hold, and what they minimise."""

    problem: Problem
    splines: Splines
    strokes: tuple[Stroke, ...]
    lead: LowHigh
    prime: LowHigh
    """The size with the roller: √(s₀² + e²)."""
    body: float
    """The largest radius of the roller or spherical face: it makes the least base radius of a prime radius."""
    ranges: tuple[dict[int, LowHigh], ...]
    """For each stroke, the range of each limited derivative, by its order."""
    floors: tuple[LinearConstraint, ...]
    residual: float | None
    """The largest residual vibration, mm or deg."""
    rest: int
    monotone: bool
    points: tuple[tuple[float, float], ...]
    objective: dict[str, float]

    @property
    def roller(self) -> float:
        """What the prime radius has over the size."""
        return roller_of(self.problem, self.body)

    @property
    def scale(self) -> float:
        """The unit of the motion in the convex programme: the highest lift, mm or rad."""
        return max(stroke.high for stroke in self.strokes)

    @property
    def length(self) -> float:
        """The unit of the sizes, mm: the highest lift, or the arc that an oscillating follower swings through."""
        design = self.problem.design
        radius = float(max(design.arm_length[0], design.centre_distance[0]))
        return radius * self.scale if self.problem.setup.angular else self.scale

    @property
    def traced(self) -> bool:
        """Whether the lead is part of the size: the follower has a trace point on a disc cam."""
        return self.problem.setup.mechanism is translating.MECHANISM

    @property
    def sized(self) -> bool:
        """Whether what makes the cam large is convex in the motion: not where the follower oscillates."""
        return not self.problem.setup.angular

    @property
    def train(self) -> tuple[float, float]:
        """ω_n/ω and the damping ratio of the follower train, where something asks for its residual vibration."""
        found = residual.train_of(self.problem.setup)
        assert found is not None
        return found

    def without_each(self) -> dict[str, "Demand"]:
        """The demand without each of its limits, by name."""
        found = {
            name: replace(self, ranges=tuple({k: r for k, r in row.items() if k != order} for row in self.ranges))
            for name, order in ORDERS.items()
            if any(order in row for row in self.ranges)
        }
        for floor in self.floors:
            others = tuple(each for each in self.floors if each.name != floor.name)
            found[floor.name] = replace(self, floors=others)
        if self.prime[1] < inf:
            found["the size"] = replace(self, prime=(self.prime[0], inf))
        if self.residual is not None:
            found[residual.TERM] = replace(self, residual=None)
        if self.points:
            found["points"] = replace(self, points=())
        return found

    def place(self, stroke: Stroke) -> int:
        """The number of a stroke among those that move."""
        return [each for each in self.strokes if each.kind != DWELL].index(stroke)

    def beside_dwells(self, stroke: Stroke) -> tuple[bool, bool]:
        """Whether a stroke starts beside a dwell, and whether it ends so."""
        place = self.strokes.index(stroke)
        around = self.strokes[place - 1], self.strokes[(place + 1) % len(self.strokes)]
        return around[0].kind == DWELL, around[1].kind == DWELL

    @property
    def per_unit(self) -> dict[str, float]:
        """What terms of the objective have for 1 mm or rad by radᵏ: the units of [limits]."""
        setup = self.problem.setup
        per = {name: scale(setup, order) for name, order in ORDERS.items()}
        per |= {"acceleration_rms": per["acceleration"], "jerk_rms": per["jerk"]}
        return {"size": 1.0, **per, residual.TERM: degrees(1.0) if setup.angular else 1.0}


def roller_of(problem: Problem, body: float) -> float:
    """What the prime radius of a follower with a trace point on a disc cam has over the size."""
    return body if problem.setup.mechanism in (translating.MECHANISM, oscillating.MECHANISM) else 0.0

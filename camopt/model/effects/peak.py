"""Peaks: quantities that are extremes of curves over the turn.

An effect declares once the curves, which extreme of them counts, and the scale: the monotone map from the extreme
to the quantity. Bounds over boxes of designs, and the constraint on the curves that a limit sets, follow from that
in any kind of number.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, LEAST, FloatArray, Number
from camopt.core.numerics.trigonometry import arctangent
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme
from camopt.model.trains.joint_forces import WeightedForce

Variant = tuple[Callable[[Designs, Programme], Any], int]
"""A curve, and the kinds of pieces over which it counts."""


class NumberKind(NamedTuple):
    """A kind of number: how to make one from a double, its π, and its tangent."""

    of: Callable[[float], Any]
    pi: Callable[[], Any]
    tan: Callable[[Any], Any]


DOUBLES = NumberKind(float, lambda: math.pi, math.tan)


CLEAR_SHARE = 1e-9  # relative distance from a bound that is more than rounding


def unit_weight(designs: Designs) -> float:
    return 1.0


class RadiusRange(NamedTuple):
    """A range of radii of the body that touches the cam [mm], for all pitch curves or for each."""

    least: Any = -math.inf
    most: Any = math.inf

    def intersection(self, other: "RadiusRange") -> "RadiusRange":
        """The radii that are in both ranges."""
        return RadiusRange(np.maximum(self.least, other.least), np.minimum(self.most, other.most))

    def contains(self, radius: FloatArray) -> Any:
        """Which radii are in the range."""
        return (self.least <= radius) & (radius <= self.most)


RadiiOfCurves = Callable[[Any, Callable[[Designs], Any], RadiusRange], tuple[RadiusRange, RadiusRange]]
"""The radii of bodies with which pitch curves surely meet a limit, and those with which they may.

It takes a block of pitch curves, the inverse of the designs' limit, and the range of bodies.
"""


class RadiusWeight(ABC):
    """A weight that depends only on the radius of the body that touches the cam."""

    @abstractmethod
    def __call__(self, designs: Designs) -> Any: ...

    @abstractmethod
    def radii_with_weighted_extreme_below_1(self, curve_extreme: FloatArray, relative_margin: float) -> RadiusRange:
        """The radii with which the weight times an extreme is at most 1.

        ``relative_margin`` is a relative margin at the ends of the range, inwards, or outwards if negative.
        """

    @abstractmethod
    def largest_weight(self, body_radii: RadiusRange) -> float:
        """Largest weight over a range of radii."""


@dataclass(frozen=True)
class BodyRadiusPlus(RadiusWeight):
    """R_r + ρ [mm]; times the curvature of the pitch curve it is 1 where the profile has the radius ρ."""

    radius: float

    def __call__(self, designs: Designs) -> Any:
        return designs.roller_radius + self.radius

    def radii_with_weighted_extreme_below_1(self, curve_extreme: FloatArray, relative_margin: float) -> RadiusRange:
        return RadiusRange(
            most=_largest_weight_for_unit_product(curve_extreme) * (1.0 - relative_margin)
            - self.radius * (1.0 + relative_margin)
        )

    def largest_weight(self, body_radii: RadiusRange) -> float:
        return float(body_radii.most + self.radius)


@dataclass(frozen=True)
class CutterExcessOverRoller(RadiusWeight):
    """R_c − R_r for a cutter larger than the roller, else 0 [mm].

    Times the curvature of the pitch curve it is −1 where the cutter just reaches a hollow flank.
    """

    radius: float

    def __call__(self, designs: Designs) -> Any:
        return np.maximum(self.radius - designs.roller_radius, 0.0)

    def radii_with_weighted_extreme_below_1(self, curve_extreme: FloatArray, relative_margin: float) -> RadiusRange:
        return RadiusRange(
            least=self.radius * (1.0 + relative_margin)
            - _largest_weight_for_unit_product(curve_extreme) * (1.0 - relative_margin)
        )

    def largest_weight(self, body_radii: RadiusRange) -> float:
        return float(max(self.radius - body_radii.least, 0.0))


def _largest_weight_for_unit_product(extreme: FloatArray) -> FloatArray:
    """Largest weight whose product with an extreme is at most 1; −∞ if the extreme is infinite."""
    with np.errstate(divide="ignore"):
        return np.where(extreme == np.inf, -np.inf, 1.0 / np.maximum(extreme, 0.0))


def inverse_roller_radius(designs: Designs) -> Number:
    return 1.0 / designs.roller_radius


class Scale(ABC):
    """A monotone map from the extreme of a curve to a quantity.

    The quantity is q where weight(q)·extreme equals ``weighted_extreme_for_quantity`` q. Weights are not negative,
    because searches look where the curve itself is largest or least.
    """

    is_decreasing: ClassVar[bool] = False
    """Whether the quantity falls as the extreme rises."""

    @abstractmethod
    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        """The quantity of designs, from the extreme; numbers or ranges."""

    def quantity_change(self, extreme: FloatArray, extreme_change: FloatArray, designs: Designs) -> FloatArray:
        """Change of the quantity for a change of the extreme; 0 if the quantity is infinite."""
        with np.errstate(divide="ignore"):
            near, far = (
                np.asarray(self.quantity_from_extreme(each, designs))
                for each in (extreme, extreme + extreme_change)
            )
        finite = np.isfinite(near)
        return np.where(finite, far - np.where(finite, near, 0.0), 0.0)

    @abstractmethod
    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        """The weighted extreme at a value of the quantity, in a kind of number."""

    def curve_weight_by_design(self, quantity: float) -> Callable[[Designs], Any]:
        """The weight of the curve at a value of the quantity, by design."""
        return unit_weight


@dataclass(frozen=True)
class MultipleScale(Scale):
    """A multiple of the extreme."""

    factor: float = 1.0

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return self.factor * extreme

    def quantity_change(self, extreme: FloatArray, extreme_change: FloatArray, designs: Designs) -> FloatArray:
        return self.factor * extreme_change

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(quantity) / number_kind.of(self.factor)


IDENTITY_SCALE = MultipleScale()


@dataclass(frozen=True)
class AngleOfTangentScale(Scale):
    """The angle of a tangent ≥ 0 [deg]."""

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return np.degrees(arctangent(extreme))

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.tan(number_kind.of(quantity) * number_kind.pi() / 180)


@dataclass(frozen=True)
class TimeDerivativeScale(Scale):
    """A derivative by time, from the derivative by the cam angle: extreme·ωⁿ/unit."""

    unit: float
    """The unit of the quantity, in mm (rad) per sⁿ."""
    order: int
    rpm: float

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return extreme * ((self.rpm * 2 * math.pi / 60) ** self.order * (1.0 / self.unit))

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        speed = number_kind.of(self.rpm) * number_kind.pi() / 30
        return number_kind.of(quantity) * number_kind.of(self.unit) / speed**self.order


@dataclass(frozen=True)
class TurnIntegralScale(Scale):
    """The integral over the turn, from the mean: 2π·extreme."""

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return extreme * (2.0 * math.pi)

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(quantity) / (2 * number_kind.pi())


@dataclass(frozen=True)
class DegreeScale(Scale):
    """A multiple of the extreme with rad converted to deg: factor·extreme·(180/π)ⁿ, n = 1, 0 or −1."""

    power: int
    factor: float = 1.0

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return self.factor * extreme * (180.0 / math.pi) ** self.power

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(quantity) / number_kind.of(self.factor) / (180 / number_kind.pi()) ** self.power


@dataclass(frozen=True)
class LoadRootScale(Scale):
    """A stress that grows with a root of the load: factor·(load/unit)^(1/degree), 0 for a load below 0."""

    degree: int
    unit: float
    """The load at a stress of 1."""
    factor: float = 1.0

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        ratio = np.maximum(extreme, 0.0) / self.unit
        return self.factor * (np.cbrt(ratio) if self.degree == 3 else np.sqrt(ratio))

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return (number_kind.of(quantity) / number_kind.of(self.factor)) ** self.degree * number_kind.of(self.unit)


@dataclass(frozen=True)
class InverseScale(Scale):
    """The inverse of the extreme: factor/extreme, infinite if the extreme is 0 or less."""

    factor: float
    is_decreasing: ClassVar[bool] = True

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return self.factor / np.maximum(extreme, 0.0)

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(self.factor) / number_kind.of(quantity)


@dataclass(frozen=True)
class OneMinusScale(Scale):
    """The difference from 1: 1 − extreme."""

    is_decreasing: ClassVar[bool] = True

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return 1.0 - extreme

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return 1 - number_kind.of(quantity)


@dataclass(frozen=True)
class PerRollerRadiusScale(Scale):
    """A multiple of the extreme divided by the radius of the roller."""

    factor: float

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return extreme * self.factor / designs.roller_radius

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(quantity) / number_kind.of(self.factor)

    def curve_weight_by_design(self, quantity: float) -> Callable[[Designs], Any]:
        return inverse_roller_radius


@dataclass(frozen=True)
class ConvexRadiusScale(Scale):
    """The least convex radius of the profile, from the sharpest curvature of the pitch curve: 1/κ − R_r.

    A ``half_width``, the distance of walls from the pitch curve, takes the place of R_r.
    """

    half_width: Callable[[Designs], Any] | None = None

    is_decreasing: ClassVar[bool] = True

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return 1.0 / np.maximum(extreme, 0.0) - self.curve_weight_by_design(0.0)(designs)

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(1.0)

    def curve_weight_by_design(self, quantity: float) -> Callable[[Designs], Any]:
        half_width = self.half_width
        return BodyRadiusPlus(quantity) if half_width is None else lambda designs: half_width(designs) + quantity


@dataclass(frozen=True)
class CutterRadiusScale(Scale):
    """The largest cutter that reaches every hollow flank: R_r − 1/κ, with the pitch curve's κ < 0 where hollow."""

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return designs.roller_radius + 1.0 / np.maximum(-extreme, 0.0)

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return number_kind.of(-1.0)

    def curve_weight_by_design(self, quantity: float) -> Callable[[Designs], Any]:
        return CutterExcessOverRoller(quantity)


@dataclass(frozen=True)
class PerDesignFactorScale(Scale):
    """A scale of the extreme times a factor ≥ 0 that depends on the design."""

    scale: Scale
    factor: Callable[[Designs], Any]

    @property
    def is_decreasing(self) -> bool:  # type: ignore[override]
        return self.scale.is_decreasing

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return self.scale.quantity_from_extreme(extreme * self.factor(designs), designs)

    def quantity_change(self, extreme: FloatArray, extreme_change: FloatArray, designs: Designs) -> FloatArray:
        factor = self.factor(designs)
        return self.scale.quantity_change(extreme * factor, extreme_change * factor, designs)

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return self.scale.weighted_extreme_for_quantity(quantity, number_kind)

    def curve_weight_by_design(self, quantity: float) -> Callable[[Designs], Any]:
        weight = self.scale.curve_weight_by_design(quantity)
        return self.factor if weight is unit_weight else lambda designs: self.factor(designs) * weight(designs)


def never_infinite_by_jumps(programme: Programme) -> bool:
    """False, for quantities that stay finite at every jump of the motion."""
    return False


def is_infinite_by_velocity_jumps(programme: Programme) -> bool:
    """Whether the velocity jumps, so that inertia makes loads infinite."""
    return bool(programme.corners)


@dataclass(frozen=True)
class MotionDerivative:
    """A derivative of the displacement by the cam angle, as a curve that is the same for all designs.

    It is that of the tool, or ``at_follower`` that of the follower. Without a train both are the same.
    """

    order: int
    at_follower: bool = False

    def __call__(self, designs: Designs, programme: Programme) -> "MotionDerivative":
        return self

    def is_infinite_somewhere(self, programme: Programme) -> bool:
        """Whether the derivative is infinite somewhere."""
        return any(jump.order < self.order for jump in self.motion_of_tool_or_follower(programme).jumps)

    def motion_of_tool_or_follower(self, programme: Programme) -> Programme:
        """The motion of the tool or the follower, from that of the follower."""
        return programme if self.at_follower else programme.tool


class Peak(NamedTuple):
    """A quantity that is the extreme of some curves over the turn."""

    curves: tuple[Variant, ...]
    goal: int
    """LARGEST, LEAST or LARGEST_MAGNITUDE, over all curves together."""
    scale: Scale = IDENTITY_SCALE
    jumps: Callable[[Programme], bool] = never_infinite_by_jumps
    """Whether jumps of a motion make it infinite for every design."""
    unit: Callable[[Designs], Any] | None = None
    """The scale of its error where that is larger than the quantity itself."""
    extremes: tuple[str, ...] = ()
    """The quantities that are the largest and the least value of its curves, if bounds are compared with these."""
    open_at_zero: bool = False
    """Whether a value of 0 breaks a bound of 0."""
    per_body: float = 0.0
    """Its rise per mm of the body that touches the cam (``Mechanism.parallel``); 0 if it is not linear in that."""
    at_ends: bool = False
    """Whether its curves depend only on the displacement, and are monotone in it."""
    bodies: RadiiOfCurves | None = None
    """The bodies with which it meets the designs' limit, on profiles that are not undercut."""
    forces: tuple[Variant, ...] = ()
    """Curves of the force on a contact that must be kept, if its loss is not seen in the curves of the quantity."""

    @property
    def is_least(self) -> bool:
        """Whether the quantity is a least value over the turn, so that its limit is a lower bound."""
        return (self.goal == LEAST) != self.scale.is_decreasing

    def as_magnitude(self) -> "Peak":
        return self._replace(goal=LARGEST_MAGNITUDE)


class TrainMotion(Protocol):
    """The motion and the forces of trains at cam angles, in any kind of number."""

    def transmission_angle(self, link: int) -> Number:
        """Transmission angle of a link's coupler [rad]."""

    def link_force_sum(self, parts: Sequence[WeightedForce], speed: Any) -> Number:
        """Sum of forces of links [N] at a speed [rad/s]."""


class TrainPeak(NamedTuple):
    """A quantity that is the extreme of some curves of links of a train over the turn, for any cam.

    Effects compute the quantity of a single train by other formulas (``effects.transmission``, ``effects.joints``);
    boxes of trains use these curves.
    """

    curves: tuple[Callable[[Designs, TrainMotion], Any], ...]
    goal: int
    """LEAST or LARGEST_MAGNITUDE, over all curves together."""
    scale: Scale = IDENTITY_SCALE

    def jumps(self, programme: Programme) -> bool:
        """Always False; its effect considers jumps of the motion."""
        return False

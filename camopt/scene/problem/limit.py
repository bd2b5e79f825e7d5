"""Limits: bounds on quantities, with what verdicts, searches, proofs, shadow prices and pictures read of them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray, Number
from camopt.core.quantities import AT_LEAST, AT_MOST, QUANTITIES, Quantity
from camopt.core.quantities.own_quantity import OwnQuantity
from camopt.model.effects import (
    EvaluationBlock,
    Setup,
    find_quantity,
    quantities_with_expression_inputs,
    require_effect,
)
from camopt.model.effects.contacts import all_follower_contacts, smallest_disc_size
from camopt.model.effects.effect import LeastForce, NecessaryConditions, no_columns
from camopt.model.effects.mean import Mean
from camopt.model.effects.motion_errors import EFFECT as MOTION_ERRORS
from camopt.model.effects.peak import (
    CLEAR_SHARE,
    DOUBLES,
    Peak,
    RadiiOfCurves,
    RadiusRange,
    RadiusWeight,
    TrainPeak,
)
from camopt.model.effects.peak_columns import peak_extremes
from camopt.model.effects.self_crossing import proved_uncrossed_roller_radius, self_crossing_verdict
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.constraints import (
    LEAST_CONTACT_FORCE,
    ConstantBound,
    Constraint,
    QuantityBound,
    TurnMeanConstraint,
    constraints_on_peak,
)
from camopt.scene.problem.rows import QuantityColumns

ASSEMBLY = "assembly"  # the limit that a design violates if it cannot be assembled
UNDERCUT, SELF_CROSSING, NO_RIB, PIVOT_IN_CAM = (
    "undercut",
    "self_crossing",
    "no_rib",
    "pivot_in_cam",
)  # names of limits that every cam has to meet

Decider = Callable[[Setup, Designs, Programme], bool | None]
EXTREME_FLOOR = 4.0 * CLEAR_SHARE  # relative distance from a bound beyond which an extreme needs no more digits


class FeasibleBodies(NamedTuple):
    """Ranges of the radius of roller or face for given pitch curves, with regard to a limit."""

    sure_bodies: RadiusRange = RadiusRange()
    """Radii that meet the limit for certain."""
    possible_bodies: RadiusRange = RadiusRange()
    """Radii that may meet it."""

    def intersection(self, other: "FeasibleBodies") -> "FeasibleBodies":
        """The ranges for both limits together."""
        return FeasibleBodies(
            self.sure_bodies.intersection(other.sure_bodies),
            self.possible_bodies.intersection(other.possible_bodies),
        )


@dataclass(frozen=True, eq=False)
class Limit(ABC):
    """One limit of a scene, under its key in ``[limits]``."""

    name: str
    bound: float
    """The bound, in the unit of the key."""
    setup: Setup = field(repr=False)
    set_by_scene: bool = True
    """Whether the scene sets the limit; False for limits that every cam must meet."""
    bound_key: str = ""
    """The key of the scene that gives the bound, if it is not the limit's name in ``[limits]``."""
    prerequisite_limit_name: ClassVar[str] = ""
    """The name of another limit that must be met first; "" without one."""
    is_on_base_circle: ClassVar[bool] = False
    """Whether the bound is a least diameter of the base circle."""

    @abstractmethod
    def excess(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        """Relative excess of designs over the limit: met where ≤ 0, exceeded by 10 % at 0.1. The sign is exact."""

    def excess_derivative_by_bound(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        """∂excess/∂bound for designs that just meet the limit; a design meets the bound − excess/derivative."""
        return np.full(len(designs), np.nan)

    @property
    def deciding_pitch_curve_quantities(self) -> tuple[str, ...] | None:
        """The quantities that decide the limit from pitch curves alone; None if pitch curves do not decide it."""
        return None

    def sure_and_possible_body_radii(
        self, block: EvaluationBlock, body_radii: RadiusRange
    ) -> FeasibleBodies | None:
        """The radii of roller or face among ``body_radii`` with which a block's designs meet the limit.

        None if pitch curves do not decide the limit.
        """
        return None

    @property
    def required_quantities(self) -> tuple[str, ...]:
        """The quantities that the limit needs."""
        return ()

    @property
    def shown_quantities(self) -> tuple[str, ...]:
        """The quantities to show beside the bound."""
        return ()

    @property
    def quantity(self) -> Quantity | None:
        """The first quantity to show; None without one."""
        return find_quantity(self.shown_quantities[0], self.setup) if self.shown_quantities else None

    @property
    def relation(self) -> str:
        """The relation of the shown quantities to the bound; ± if their magnitude must be ≤."""
        return AT_MOST

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints on curves that decide the limit, for searches, proofs and pictures; may be empty."""
        return ()

    def constraints_at_contact(self, contact_number: int) -> tuple[Constraint, ...]:
        """The constraints of one contact, by number, of a follower with several; empty if contacts act together."""
        return ()

    @property
    def mean_constraint(self) -> TurnMeanConstraint | None:
        """The constraint on the mean of a curve that decides the limit, if there is one."""
        return None

    @property
    def contact_conditions(self) -> tuple[tuple[Constraint, ...], ...]:
        """Conditions on contact forces, for proofs. A design meets a condition if it holds one of its constraints.

        Each contact is kept or, if it is one of two, never bears. No follower with two contacts has friction in its
        guide, so that there is one force for all strokes.
        """
        return ()

    @property
    def train_constraints(self) -> tuple[Constraint, ...]:
        """The constraints on curves of a train that decide the limit, for searches among trains."""
        return ()

    def is_infinite_on_motion(self, programme: Programme) -> bool:
        """Whether jumps of a motion make the quantity infinite, so that no design meets the limit."""
        return False

    @property
    def single_design_decider(self) -> Decider | None:
        """Decides whether one design breaks the limit (None if undecided); for limits not on curves."""
        return None

    @property
    def necessary_conditions(self) -> NecessaryConditions:
        """Necessary conditions on any cam that meets the limit."""
        return NecessaryConditions()

    @property
    def least_contact_force(self) -> LeastForce | None:
        """The least contact force that the limit requires."""
        return self.necessary_conditions.force

    @property
    def least_size(self) -> float:
        """Base (mean) radius below which no design meets the limit [mm]."""
        return self.necessary_conditions.least_size

    @property
    def least_base_radius(self) -> float:
        """Base radius of any disc below which no design meets the limit [mm]."""
        return self.bound / 2.0 if self.is_on_base_circle else 0.0

    @property
    def most_size(self) -> float:
        """Base (mean) radius above which no design meets the limit [mm]."""
        return self.necessary_conditions.most_size

    @cached_property
    def is_decided_by_motion_alone(self) -> bool:
        """Whether motion and speed alone decide the limit, not the design."""
        effects = [require_effect(name, self.setup) for name in self.required_quantities]
        return bool(effects) and not self.setup.free and all(effect.is_of_motion(self.setup) for effect in effects)

    @cached_property
    def is_on_motion_error(self) -> bool:
        """Whether the limit is on motion errors by tolerances, which cover all cams within the tolerances."""
        return any(
            find_quantity(name, self.setup).effect == MOTION_ERRORS.name
            for name in quantities_with_expression_inputs(self.shown_quantities, self.setup)
        )

    @property
    def lacks_enclosure(self) -> bool:
        """Whether the limit depends on a number without an enclosure."""
        return False

    @property
    def key(self) -> str:
        """The key of the scene that gives the bound; without a key, the name of the limit."""
        return self.bound_key or (f"limits.{self.name}" if self.set_by_scene else self.name)

    @cached_property
    def is_deferred(self) -> bool:
        """Whether the limit is checked only for designs that meet all other limits."""
        return any(require_effect(name, self.setup).last for name in self.required_quantities)


def quantities_of_limits(limits: Iterable[Limit]) -> frozenset[str]:
    """The quantities that some limits need."""
    return frozenset(need for limit in limits for need in limit.required_quantities)


@dataclass(frozen=True, eq=False)
class QuantityLimit(Limit):
    """A bound on a quantity, from above or below as the quantity says; on several, on their largest magnitude."""

    quantities: tuple[str, ...] = ()
    peak_or_mean: Peak | Mean | TrainPeak | None = None
    """The extreme or mean of curves, or extreme of a train's curves, behind the quantities; None if neither."""
    other_constraints: tuple[Constraint, ...] = ()
    """Constraints on other curves."""
    further_peaks: tuple[Peak, ...] = ()
    """The same extreme at further contacts of the follower."""

    def with_changed_peaks(self, change: Callable[[Peak], Peak]) -> "QuantityLimit":
        """The limit with changed extremes."""
        assert isinstance(self.peak_or_mean, Peak)
        return replace(
            self, peak_or_mean=change(self.peak_or_mean), further_peaks=tuple(map(change, self.further_peaks))
        )

    @property
    def required_quantities(self) -> tuple[str, ...]:
        first, extremes = (
            self.quantities[0],
            self.peak_or_mean.extremes if isinstance(self.peak_or_mean, Peak) else (),
        )
        by_arm = first.startswith("contact_force") and self.setup.angular  # a moment over the length of the arm
        return (*extremes, *self.quantities, *(("arm_length_mm",) if by_arm else ()))

    @property
    def shown_quantities(self) -> tuple[str, ...]:
        return self.quantities if self._is_two_sided else self.quantities[:1]

    @property
    def _is_two_sided(self) -> bool:
        return len(self.quantities) > 1 and QUANTITIES[self.quantities[0]].signed

    @property
    def relation(self) -> str:
        if self._is_two_sided:
            return "±"
        return ">" if self._bound_itself_breaks_limit else QUANTITIES[self.quantities[0]].relation_to_limit

    @property
    def _bound_itself_breaks_limit(self) -> bool:
        """Whether a design exactly at the bound breaks the limit."""
        return self.bound == 0.0 and isinstance(self.peak_or_mean, Peak) and self.peak_or_mean.open_at_zero

    @property
    def bound_sign(self) -> float:
        """1 if the quantity must not exceed the bound, −1 if it must not fall below."""
        return QUANTITIES[self.quantities[0]].limit_sign

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        if not isinstance(self.peak_or_mean, Peak):
            return self.other_constraints
        return tuple(
            constraint
            for peak in (self.peak_or_mean, *self.further_peaks)
            for constraint in constraints_on_peak(peak, self.bound)
        )

    @cached_property
    def contact_conditions(self) -> tuple[tuple[Constraint, ...], ...]:
        peaks = (self.peak_or_mean, *self.further_peaks) if isinstance(self.peak_or_mean, Peak) else ()
        bounds = {LEAST: LEAST_CONTACT_FORCE, **({LARGEST: 0.0} if self.further_peaks else {})}
        return tuple(
            tuple(Constraint(make, kinds, goal, ConstantBound(bound)) for goal, bound in bounds.items())
            for peak in peaks
            for make, kinds in peak.forces
        )

    def constraints_at_contact(self, contact_number: int) -> tuple[Constraint, ...]:
        if not (self.further_peaks and isinstance(self.peak_or_mean, Peak)):
            return ()
        return constraints_on_peak((self.peak_or_mean, *self.further_peaks)[contact_number], self.bound)

    @cached_property
    def mean_constraint(self) -> TurnMeanConstraint | None:
        if not isinstance(self.peak_or_mean, Mean):
            return None
        side = -self.bound_sign if self.peak_or_mean.scale.is_decreasing else self.bound_sign
        return TurnMeanConstraint(self.peak_or_mean, self.bound, side)

    @cached_property
    def train_constraints(self) -> tuple[Constraint, ...]:
        peak = self.peak_or_mean
        if not isinstance(peak, TrainPeak):
            return ()
        bound = QuantityBound(peak.scale, self.bound)
        return tuple(Constraint(curve, ALL_STROKES, peak.goal, bound) for curve in peak.curves)

    def is_infinite_on_motion(self, programme: Programme) -> bool:
        return self.peak_or_mean is not None and any(
            each.jumps(programme) for each in (self.peak_or_mean, *self.further_peaks)
        )

    @cached_property
    def necessary_conditions(self) -> NecessaryConditions:
        name = self.quantities[0]
        return require_effect(name, self.setup).necessary_conditions(self.setup, name, self.bound)

    def excess(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        peak = self.peak_or_mean
        if isinstance(peak, Peak) and peak.extremes:  # from the weighted extreme, relative to its allowed value
            extreme = self._extreme_as_share_of_allowed(peak, columns, designs)
            weight = peak.scale.curve_weight_by_design(self.bound)(designs)
            finite = np.isfinite(extreme)
            excess = np.asarray(np.where(finite, np.where(finite, extreme, 0.0) * weight, extreme) - 1.0)
        else:
            values = [columns[name] for name in self.quantities]
            value = values[0] if len(values) == 1 else reduce(np.maximum, map(np.abs, values))
            with np.errstate(over="ignore"):  # for a bound near 0
                excess = self.bound_sign * (value - self.bound) / self._reference_value_of_excess(
                    designs
                ) + np.zeros(len(designs))
        return np.where(excess == 0.0, np.finfo(float).tiny, excess) if self._bound_itself_breaks_limit else excess

    def _reference_value_of_excess(self, designs: Designs) -> Number:
        """The value that a relative excess is relative to."""
        if self.bound or not isinstance(self.peak_or_mean, Peak) or self.peak_or_mean.unit is None:
            return abs(self.bound) or 1.0
        return self.peak_or_mean.unit(designs)

    @cached_property
    def deciding_pitch_curve_quantities(self) -> tuple[str, ...] | None:
        if (
            isinstance(self._extreme_weight_by_design, RadiusWeight)
            or self._value_change_per_radius
            or self._feasible_radius_rule
        ):
            return ()
        effects = [require_effect(name, self.setup) for name in self.required_quantities]
        return (
            self.required_quantities if all(effect.evaluate_columns is no_columns for effect in effects) else None
        )

    @property
    def _extreme_weight_by_design(self) -> Callable[[Designs], Any] | None:
        """The weight of the extreme that is compared with the bound; None without an extreme."""
        peak = self.peak_or_mean
        return peak.scale.curve_weight_by_design(self.bound) if isinstance(peak, Peak) and peak.extremes else None

    @property
    def _value_change_per_radius(self) -> float:
        return self.peak_or_mean.per_body if isinstance(self.peak_or_mean, Peak) and not self.further_peaks else 0.0

    @property
    def _feasible_radius_rule(self) -> RadiiOfCurves | None:
        """The rule for the radii with which pitch curves meet the limit, if the peak has one."""
        return self.peak_or_mean.bodies if isinstance(self.peak_or_mean, Peak) and not self.further_peaks else None

    def _inverse_of_allowed_extreme(self, designs: Designs) -> Number:
        """The inverse of the extreme allowed for designs."""
        assert isinstance(self.peak_or_mean, Peak)
        scale = self.peak_or_mean.scale
        return scale.curve_weight_by_design(self.bound)(designs) / scale.weighted_extreme_for_quantity(
            self.bound, DOUBLES
        )

    def sure_and_possible_body_radii(
        self, block: EvaluationBlock, body_radii: RadiusRange
    ) -> FeasibleBodies | None:
        peak, weight = self.peak_or_mean, self._extreme_weight_by_design
        if isinstance(peak, Peak) and self._value_change_per_radius and not block.programme.radii:
            return self._feasible_radii_for_least_value(block, peak)
        if self._feasible_radius_rule and not block.programme.radii:
            return FeasibleBodies(*self._feasible_radius_rule(block, self._inverse_of_allowed_extreme, body_radii))
        if not isinstance(peak, Peak) or not isinstance(weight, RadiusWeight):
            return None
        if block.columns.keys() >= set(peak.extremes):
            sides = [
                {name: block.columns[name] + side * block.outward.get(name, 0.0) for name in peak.extremes}
                for side in (1.0, -1.0)
            ]
            far, near = (self._extreme_as_share_of_allowed(peak, columns, block.designs) for columns in sides)
        else:
            # the ends of the share, less exact where the limit holds with the largest weight
            largest = weight.largest_weight(body_radii)
            allowed = peak.scale.weighted_extreme_for_quantity(self.bound, DOUBLES)
            floor = (1.0 - EXTREME_FLOOR) / (largest * abs(allowed)) if largest > 0.0 else -np.inf
            extremes = peak_extremes(block, peak, floor=floor)
            far, near = (allowed * extremes.value + side * abs(allowed) * extremes.width for side in (1.0, -1.0))
        return FeasibleBodies(
            weight.radii_with_weighted_extreme_below_1(far, CLEAR_SHARE),
            weight.radii_with_weighted_extreme_below_1(near, -CLEAR_SHARE),
        )

    def _feasible_radii_for_least_value(self, block: EvaluationBlock, peak: Peak) -> FeasibleBodies:
        """The radii that are large or small enough for a least value, from the value at radius 0."""
        extremes = peak_extremes(block, peak)
        finite = np.where(np.isfinite(extremes.value), extremes.value, 0.0)
        room = CLEAR_SHARE * np.maximum(self._reference_value_of_excess(block.designs), np.abs(finite))
        far, near = (self.bound - extremes.value + side * (extremes.width + room) for side in (1.0, -1.0))
        if peak.per_body < 0.0:
            return FeasibleBodies(RadiusRange(most=-far), RadiusRange(most=-near))
        return FeasibleBodies(RadiusRange(least=far), RadiusRange(least=near))

    def _extreme_as_share_of_allowed(self, peak: Peak, columns: Mapping[str, Any], designs: Designs) -> FloatArray:
        """The extreme as a share of its allowed value, without the weight."""
        most, least = (np.asarray(columns[name] + np.zeros(len(designs))) for name in peak.extremes)
        if peak.goal == LARGEST_MAGNITUDE:
            most = np.maximum(most, -least)
        extreme = most if peak.goal in (LARGEST, LARGEST_MAGNITUDE) else least
        return np.asarray(extreme * peak.scale.weighted_extreme_for_quantity(self.bound, DOUBLES))

    def excess_derivative_by_bound(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        if isinstance(self.peak_or_mean, Peak) and self.peak_or_mean.extremes:
            return self._extreme_as_share_of_allowed(
                self.peak_or_mean, columns, designs
            )  # weights are linear in the bound
        return np.asarray(-self.bound_sign / self._reference_value_of_excess(designs) + np.zeros(len(designs)))


@dataclass(frozen=True, eq=False)
class OwnQuantityLimit(Limit):
    """A limit on a quantity that the scene defines: finite, and at most the bound if that is finite."""

    @property
    def required_quantities(self) -> tuple[str, ...]:
        return (self.name,)

    @property
    def shown_quantities(self) -> tuple[str, ...]:
        return self.required_quantities if self.set_by_scene else ()

    @cached_property
    def lacks_enclosure(self) -> bool:
        """Whether the quantity reads a Python function, or a quantity without a bound such as a cam angle."""
        quantities = [
            find_quantity(name, self.setup)
            for name in quantities_with_expression_inputs(self.required_quantities, self.setup)
        ]
        functions = [isinstance(each, OwnQuantity) and each.function_call for each in quantities]
        return any(functions) or not all(each.relation_to_limit or each.effect == "sizes" for each in quantities)

    def excess(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        value = columns[self.name]
        excess = (value - self.bound) / (abs(self.bound) or 1.0) if self.set_by_scene else -1.0
        return np.asarray(np.where(value == np.inf, np.inf, excess) + np.zeros(len(designs)))

    def excess_derivative_by_bound(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        return np.full(len(designs), -1.0 / (abs(self.bound) or 1.0))


def _profile_crosses_itself(setup: Setup, design: Designs, programme: Programme) -> bool | None:
    """Whether any profile of one design crosses itself; None if undecided."""
    verdicts = [
        self_crossing_verdict(
            replace(setup, mechanism=each.mechanism), each.local_designs(design), programme
        ).crosses
        for each in all_follower_contacts(setup)
    ]
    return True if True in verdicts else None if None in verdicts else False


@dataclass(frozen=True, eq=False)
class SelfCrossingLimit(Limit):
    """The limit that no profile crosses itself; it is met or broken, with nothing between."""

    prerequisite_limit_name: ClassVar[str] = UNDERCUT

    @property
    def required_quantities(self) -> tuple[str, ...]:
        return (SELF_CROSSING,)

    @property
    def deciding_pitch_curve_quantities(self) -> tuple[str, ...]:
        return ("pressure_angle_max_deg",)

    def sure_and_possible_body_radii(
        self, block: EvaluationBlock, body_radii: RadiusRange
    ) -> FeasibleBodies | None:
        wider = block.setup.pitch_to_flank_distance(block.designs) - block.designs.roller_radius
        return FeasibleBodies(
            sure_bodies=RadiusRange(most=proved_uncrossed_roller_radius(block) * (1.0 - CLEAR_SHARE) - wider)
        )

    def excess(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        return np.asarray(columns[SELF_CROSSING] - 0.5 + np.zeros(len(designs)))

    @property
    def single_design_decider(self) -> Decider:
        return _profile_crosses_itself


@dataclass(frozen=True, eq=False)
class BaseCircleLimit(Limit):
    """The limit that a circle of a diameter (the bound) lies within the base circle."""

    is_on_base_circle: ClassVar[bool] = True

    @property
    def relation(self) -> str:
        return AT_LEAST

    @property
    def necessary_conditions(self) -> NecessaryConditions:
        return NecessaryConditions(least_size=self.bound / 2.0)

    def excess(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        radius = self.bound / 2.0
        result: FloatArray = (radius - smallest_disc_size(self.setup, designs)) / radius
        return result

    def excess_derivative_by_bound(self, columns: QuantityColumns, designs: Designs) -> FloatArray:
        return np.full(len(designs), 1.0 / self.bound)

"""An effect, and the block that it computes: a setup, a programme and designs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import Number
from camopt.core.numerics.extremes import Extremes, Precision, extremes_of_curve
from camopt.core.quantities.own_quantity import OwnQuantity
from camopt.model.effects.effect_numbers import ContactBodies, FollowerDynamics, SceneNumbers, ToleranceBands
from camopt.model.effects.known_extremes import NOTHING_KNOWN, KnownExtremes
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import (
    IDENTITY_SCALE,
    MultipleScale,
    Peak,
    PerDesignFactorScale,
    Scale,
    TrainPeak,
)
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.mechanisms.elements import KNIFE, ROLLER, SPHERICAL, Tip
from camopt.model.motion.programme import Programme
from camopt.model.trains.train import Train


class SolidSizes(NamedTuple):
    """The sizes of the cam as a solid [mm, t/mm³, rad]; None if the scene does not give one, 0 if it is absent."""

    thickness: Number = None
    density: Number = None
    bore_radius: float = 0.0
    bore_reach: float = 0.0
    """Largest distance of the bore and its keyway from the axis."""
    keyway_width: float = 0.0
    keyway_depth: float = 0.0
    keyway_angle: float = 0.0
    hub_radius: float = 0.0
    hub_length: float = 0.0
    groove_depth: Number = None
    rib_height: Number = None
    outer_diameter: Number = None

    @property
    def groove_depth_or_rib_height(self) -> Number:
        """Depth of the groove, or height of the rib [mm]."""
        return self.groove_depth if self.rib_height is None else self.rib_height


NO_SOLID = SolidSizes()


@dataclass(frozen=True)
class Setup:
    """The values that all designs of a problem share: mechanism, speed, loads and materials. Lengths in mm."""

    mechanism: Mechanism
    tip: Tip
    """The tip of the follower, which touches the cam."""
    relative_error: float = 1e-9
    given: SceneNumbers = field(default_factory=SceneNumbers)
    """Speed, loads and materials, as the scene gives them."""
    solid: SolidSizes = NO_SOLID
    train: Train | None = None
    """The train between the follower and the tool; the scene then gives the motion of the tool."""
    errors: ToleranceBands | None = None
    """The tolerances of cams and followers; None if the scene has none."""
    varied: Mapping[str, str] = field(default_factory=dict)
    """The quantities of numbers of the scene that a search varies, by key."""
    free: frozenset[str] = frozenset()
    """The keys of numbers that differ between designs; ``given`` has the largest value of each."""
    own_quantities: Mapping[str, OwnQuantity] = field(default_factory=dict)
    """The quantities that the scene defines, by name, each after those that it reads."""

    def with_numbers(self, numbers: Mapping[str, Any]) -> "Setup":
        """The setup with some numbers fixed, by key of the scene."""
        return replace(self, given=self.given.with_numbers(numbers), free=self.free - numbers.keys())

    def absorb_design_numbers(self, design: Designs) -> "tuple[Setup, Designs]":
        """The setup with the numbers of one design, and the design without them."""
        return (
            (self.with_numbers(design.number_values), replace(design, numbers={}))
            if design.numbers
            else (self, design)
        )

    def with_design_numbers(self, designs: Designs) -> "Setup":
        """The setup with the numbers of the designs, as arrays or ranges."""
        return replace(self, given=self.given.with_numbers(designs.numbers)) if designs.numbers else self

    def pitch_to_flank_distance(self, designs: Designs) -> Number:
        """Distance of walls and profile from the pitch curve: the roller's radius plus half its clearance [mm]."""
        clearance = self.with_design_numbers(designs).given.drive.clearance
        return designs.roller_radius if clearance is None else designs.roller_radius + 0.5 * clearance

    @property
    def angular(self) -> bool:
        """Whether the follower oscillates, so that its displacement is an angle."""
        return self.mechanism.motion.angular

    @property
    def tool_turns(self) -> bool:
        """Whether the displacement of the tool is an angle; without a train, the follower is the tool."""
        return self.angular if self.train is None else self.train.angular

    @property
    def is_knife(self) -> bool:
        return self.tip == KNIFE

    @property
    def rolls(self) -> bool:
        return self.tip == ROLLER

    @property
    def spherical(self) -> bool:
        """Whether the follower has a spherical face, which touches the cam at a point."""
        return self.tip == SPHERICAL

    @cached_property
    def dynamics(self) -> FollowerDynamics:
        return FollowerDynamics(self.given, "follower.dynamics")

    @cached_property
    def bodies(self) -> ContactBodies:
        return ContactBodies(self.given, "materials")

    @property
    def rpm(self) -> Number:
        """Speed of the cam [rev/min]; None if the scene gives none."""
        return self.given["cam.rpm"]

    @property
    def omega(self) -> Number:
        """Speed of the cam [rad/s]; None if the scene gives none."""
        return None if self.rpm is None else self.rpm * 2 * pi / 60

    @property
    def shaft_radius(self) -> Number:
        """Radius of the shaft [mm]; None if the scene gives none."""
        return self.given.number_times_factor("cam.shaft_diameter", 0.5)


class EnclosedValue(NamedTuple):
    """A quantity with its enclosure: the true value is between ``value`` and ``value + outward``, up to rounding.

    Relative errors refer to ``scale``.
    """

    value: Any
    outward: Any
    scale: Any


@dataclass(frozen=True)
class EvaluationBlock:
    """A block of designs that share a programme, with the results of earlier effects."""

    setup: Setup
    programme: Programme
    designs: Designs
    columns: Mapping[str, Any] = field(default_factory=dict)
    outward: Mapping[str, Any] = field(default_factory=dict)
    """The signed widths of the columns' enclosures (``EnclosedValue.outward``)."""
    memory: dict[str, Any] = field(default_factory=dict, compare=False)
    """The columns at each of several contacts, remembered for later effects (``effects.contacts``)."""
    known_extremes: KnownExtremes = field(default=NOTHING_KNOWN, compare=False)
    """Extremes of the designs' curves that are known already, to the setup's error."""

    @cached_property
    def setup_per_design(self) -> Setup:
        """The setup with the numbers of each design."""
        return self.setup.with_design_numbers(self.designs)

    def outer_end_of_column_enclosure(self, name: str) -> Number:
        """The far end of the enclosure of a column."""
        return self.columns[name] + self.outward.get(name, 0.0)

    def extremes(
        self,
        curve: Callable[[Designs, Programme], Any],
        questions: list[tuple[int, int]],
        *,
        exact_angles: bool = False,
        floor: float = -np.inf,
    ) -> Extremes:
        """Extremes of one of the mechanism's curves, for questions (kinds of stroke, goal).

        Cam angles are as exact as values only if ``exact_angles``. ``floor`` is that of ``Precision``.
        """
        if (
            not exact_angles
            and floor == -np.inf
            and (known := self.known_extremes.find_known_extremes(curve, questions))
        ):
            return known
        precision = Precision(
            self.setup.relative_error, self.setup.relative_error if exact_angles else np.inf, floor
        )
        return extremes_of_curve(
            curve(self.designs, self.programme), len(self.designs), self.programme.table, questions, precision
        )


def scale_per_design_if_varied(
    setup: Setup, scale: Scale, unit_scale: Scale, factor: Callable[[Setup], Any]
) -> Scale:
    """A scale; with numbers of the designs, ``unit_scale`` of the extreme times a factor of each design."""
    return (
        PerDesignFactorScale(unit_scale, lambda designs: factor(setup.with_design_numbers(designs)))
        if setup.free
        else scale
    )


class LeastForce(NamedTuple):
    """A least contact force at every cam angle, at a speed of the cam."""

    omega: float
    """Speed of the cam [rad/s]."""
    force: float
    """Force at the trace point [N]."""


class NecessaryConditions(NamedTuple):
    """Conditions that every design meets within a bound on a quantity."""

    least_size: float = 0.0
    """Least base or mean radius [mm]."""
    most_size: float = inf
    """Largest base or mean radius [mm]."""
    reach: float = inf
    """Largest reach along a flat face [mm]."""
    force: LeastForce | None = None
    """Least contact force."""


def multiple_scale(setup: Setup, factor: Callable[[Setup], Any]) -> Scale:
    """A multiple of the extreme, by a factor of the scene's numbers, which may vary from design to design."""
    return scale_per_design_if_varied(setup, MultipleScale(factor(setup)), IDENTITY_SCALE, factor)


def no_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    """No column; for effects without ``evaluate_columns`` or ``evaluate_pitch_curve_columns``."""
    return {}


class Effect(NamedTuple):
    """A discipline that computes quantities: which ones it offers for a setup, and how."""

    name: str
    applicable_quantities: Callable[[Setup], tuple[str, ...]]
    """The quantities that it has for the setup's mechanism."""
    evaluate_columns: Callable[[EvaluationBlock, frozenset[str]], dict[str, Any]] = no_columns
    """Computes the wanted columns of a block: arrays (designs,) or one value for all; inexact ones are enclosed."""
    missing_keys_by_quantity: Callable[[Setup], Mapping[str, tuple[str, ...]]] = lambda setup: {}
    """The missing keys of the scene, by offered quantity that cannot be computed without them."""
    input_quantities: Callable[[Setup], tuple[str, ...]] = lambda setup: ()
    """The quantities that ``evaluate_columns`` reads from the block: of other effects, or of the pitch curve."""
    evaluate_pitch_curve_columns: Callable[[EvaluationBlock, frozenset[str]], dict[str, Any]] = no_columns
    """Computes what depends on the pitch curve only, once for all designs that share the curve."""
    is_of_motion: Callable[[Setup], bool] = lambda setup: False
    """Whether its quantities depend only on the motion and the speed, and not on the design."""
    peaks: Callable[[Setup], Mapping[str, Peak]] = lambda setup: {}
    """Its quantities that are extremes of curves; there may be more than it offers."""
    means: Callable[[Setup], Mapping[str, Mean]] = lambda setup: {}
    """Its quantities that are means of curves over the turn."""
    train_peaks: Callable[[Setup], Mapping[str, TrainPeak]] = lambda setup: {}
    """Its quantities that are extremes of curves of a train."""
    necessary_conditions: Callable[[Setup, str, float], NecessaryConditions] = lambda setup, name, bound: (
        NecessaryConditions()
    )
    """Conditions that follow, for any cam, from a bound on one of its quantities."""
    is_of_sizes: bool = False
    """Whether it is arithmetic on sizes, which also runs on ranges of them (Intervals)."""
    is_per_contact: bool = False
    """Whether it describes one contact of follower and cam; of several contacts the worst counts."""
    is_single_disc: bool = False
    """Whether it describes a single disc; a pair of discs has none of its quantities."""
    holds_between_speeds: bool = False
    """Whether its quantities hold a bound at all speeds between two at which they hold it (docs/theory/speed)."""
    exact: bool = False
    """Whether its quantities have no enclosure, so that computing them or not affects no other quantity."""
    last: bool = False
    """Whether it is so expensive that its limits are checked only for designs that meet all others."""
    work: float = 0.0
    """Work for a design beyond that of its curves (``core.numerics.budget``)."""

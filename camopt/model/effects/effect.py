"""An effect, and the case that it works on: a setup, a programme and a block of designs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics.extremes import Extremes, Precision, extremes
from camopt.core.quantities.own_quantity import OwnQuantity
from camopt.model.effects.effect_numbers import ContactBodies, FollowerDynamics, SceneNumbers, ToleranceBands
from camopt.model.effects.known_extremes import NOTHING_KNOWN, KnownExtremes
from camopt.model.effects.mean import Mean
from camopt.model.effects.necessary_conditions import NecessaryConditions
from camopt.model.effects.peak import Peak, PerDesignFactor, Scale
from camopt.model.effects.train_peak import TrainPeak
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.mechanisms.elements import KNIFE, ROLLER, SPHERICAL, Tip
from camopt.model.motion.programme import Programme
from camopt.model.trains.train import Train


class SolidSizes(NamedTuple):
    """The cam as a solid: mm, t/mm³, rad. None where a scene does not say; 0 where there is no such thing."""

    thickness: float | None = None
    density: float | None = None
    bore_radius: float = 0.0
    bore_reach: float = 0.0
    """The largest distance of the bore, its keyway included, from the axis."""
    keyway_width: float = 0.0
    keyway_depth: float = 0.0
    keyway_angle: float = 0.0
    hub_radius: float = 0.0
    hub_length: float = 0.0
    groove_depth: float | None = None
    rib_height: float | None = None
    outer_diameter: float | None = None

    @property
    def flank_height(self) -> float | None:
        """How high flanks are: the depth of a groove, or the height of a rib."""
        return self.groove_depth if self.rib_height is None else self.rib_height


NO_SOLID = SolidSizes()


@dataclass(frozen=True)
class Setup:
    """The values that all designs of a problem share: mechanism, speed, loads and materials. Lengths in mm."""

    mechanism: Mechanism
    tip: Tip
    """What of the follower touches the cam."""
    relative_error: float = 1e-9
    given: SceneNumbers = field(default_factory=SceneNumbers)
    """Speed, loads and materials, as the scene gives them."""
    solid: SolidSizes = NO_SOLID
    train: Train | None = None
    """What is between the follower and the tool, whose motion is asked then."""
    errors: ToleranceBands | None = None
    """By how much cams and followers may be off; None if the scene has no tolerances."""
    varied: Mapping[str, str] = field(default_factory=dict)
    """The quantities that numbers of the scene are which a search varies, by key."""
    free: frozenset[str] = frozenset()
    """The keys of those numbers that designs bring; ``given`` has the largest of each then."""
    own_quantities: Mapping[str, OwnQuantity] = field(default_factory=dict)
    """The scene's own quantities by name, each after those that it reads."""

    def with_numbers(self, numbers: Mapping[str, Any]) -> "Setup":
        """The setup of one choice of numbers, by key of the scene."""
        return replace(self, given=self.given.with_numbers(numbers), free=self.free - numbers.keys())

    def absorb_design_numbers(self, design: Designs) -> "tuple[Setup, Designs]":
        """The setup with the numbers of one design in it, and the design without them."""
        return (
            (self.with_numbers(design.number_values), replace(design, numbers={}))
            if design.numbers
            else (self, design)
        )

    def with_design_numbers(self, designs: Designs) -> "Setup":
        """The setup with the designs' own numbers in it: arrays, or ranges."""
        return replace(self, given=self.given.with_numbers(designs.numbers)) if designs.numbers else self

    def half_width(self, designs: Designs) -> Any:
        """How far walls and profile are from the pitch curves: the roller's radius and half its clearance, mm."""
        clearance = self.with_design_numbers(designs).given.drive.clearance
        return designs.roller_radius if clearance is None else designs.roller_radius + 0.5 * clearance

    @property
    def angular(self) -> bool:
        """Whether the follower oscillates, so that its displacement is an angle."""
        return self.mechanism.motion.angular

    @property
    def tool_turns(self) -> bool:
        """Whether the displacement that is asked, of the tool or without a train of the follower, is an angle."""
        return self.angular if self.train is None else self.train.angular

    @property
    def is_knife(self) -> bool:
        """Whether the follower is a knife edge."""
        return self.tip == KNIFE

    @property
    def rolls(self) -> bool:
        """Whether the follower has a roller."""
        return self.tip == ROLLER

    @property
    def spherical(self) -> bool:
        """Whether the follower has a spherical face, which touches the cam in a point."""
        return self.tip == SPHERICAL

    @cached_property
    def dynamics(self) -> FollowerDynamics:
        """The dynamics of the follower."""
        return self.given.dynamics

    @cached_property
    def bodies(self) -> ContactBodies:
        """The bodies in contact."""
        return self.given.bodies

    @property
    def rpm(self) -> Any:
        """The speed, rev/min; None if the scene gives none."""
        return self.given.rpm

    @property
    def omega(self) -> Any:
        """The speed, rad/s."""
        return None if self.rpm is None else self.rpm * 2 * pi / 60

    @property
    def shaft_radius(self) -> Any:
        """None if the scene gives no shaft."""
        return self.given.shaft_radius


class EnclosedValue(NamedTuple):
    """A quantity with its enclosure: the true value lies between ``value`` and ``value + outward``.

    Apart from rounding, it lies only on the side of ``outward``. Relative errors refer to ``scale``.
    """

    value: Any
    outward: Any
    scale: Any


@dataclass(frozen=True)
class EvaluationBlock:
    """A block of designs that share a programme, with the results of earlier effects."""

    setup: Setup
    """What they share."""
    programme: Programme
    designs: Designs
    columns: Mapping[str, Any] = field(default_factory=dict)
    outward: Mapping[str, Any] = field(default_factory=dict)
    """How far the true value of each may lie from what was found, with its sign."""
    memory: dict[str, Any] = field(default_factory=dict, compare=False)
    """What effects of several contacts remember of these designs (``effects.contacts``)."""
    known_extremes: KnownExtremes = field(default=NOTHING_KNOWN, compare=False)
    """Extremes of their curves that were found before, to the setup's error."""

    @cached_property
    def setup_per_design(self) -> Setup:
        """The setup with the numbers of each design in it."""
        return self.setup.with_design_numbers(self.designs)

    def outer_bound(self, name: str) -> Any:
        """The far side of the enclosure of a quantity that an earlier effect found."""
        return self.shifted_value(name, 1.0)

    def shifted_value(self, name: str, share: float) -> Any:
        """Such a quantity moved by a share of its width: 1 for the far side, −1 for as much inwards."""
        return self.columns[name] + share * self.outward.get(name, 0.0)

    def extremes(
        self,
        curve: Callable[[Designs, Programme], Any],
        questions: list[tuple[int, int]],
        *,
        located: bool = False,
        floor: float = -np.inf,
    ) -> Extremes:
        """Extremes of one of the mechanism's curves, for questions (kinds of stroke, goal).

        Cam angles are as exact as values only if ``located``. ``floor`` is that of ``Precision``.
        """
        if not located and floor == -np.inf and (known := self.known_extremes.find_extremes(curve, questions)):
            return known
        precision = Precision(self.setup.relative_error, self.setup.relative_error if located else np.inf, floor)
        made = curve(self.designs, self.programme)
        return extremes(made, len(self.designs), self.programme.table, questions, precision)


def scale_by_setting(setup: Setup, scale: Scale, unit: Scale, factor: Callable[[Setup], Any]) -> Scale:
    """A scale; if it depends on the designs' own numbers, one of the extreme times a factor of each design."""
    return (
        PerDesignFactor(unit, lambda designs: factor(setup.with_design_numbers(designs))) if setup.free else scale
    )


def no_columns(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    """No quantity at all."""
    return {}


class Effect(NamedTuple):
    """A discipline that computes quantities: which ones it offers for a setup, and how."""

    name: str
    offers: Callable[[Setup], tuple[str, ...]]
    """The quantities of the setup's mechanism."""
    run: Callable[[EvaluationBlock, frozenset[str]], dict[str, Any]] = no_columns
    """From a case and the wanted names to columns: arrays (designs,) or one value for all, Bounded if inexact."""
    lacks: Callable[[Setup], Mapping[str, tuple[str, ...]]] = lambda setup: {}
    """For each offered quantity that cannot be computed from what the scene gives: the keys that it lacks."""
    reads: Callable[[Setup], tuple[str, ...]] = lambda setup: ()
    """Quantities that ``run`` reads from ``Case.columns``: of other effects, or found of the pitch curve."""
    run_on_pitch: Callable[[EvaluationBlock, frozenset[str]], dict[str, Any]] = no_columns
    """Runs before ``run``, for what the pitch curve alone decides: designs that share it share the result."""
    is_of_motion: Callable[[Setup], bool] = lambda setup: False
    """Whether its quantities depend on the motion and the speed alone, whatever the design."""
    peaks: Callable[[Setup], Mapping[str, Peak]] = lambda setup: {}
    """Its quantities that extremes of curves decide; of those that it offers, or more."""
    means: Callable[[Setup], Mapping[str, Mean]] = lambda setup: {}
    """And those that are means of curves over the turn."""
    train_peaks: Callable[[Setup], Mapping[str, TrainPeak]] = lambda setup: {}
    """And those that extremes of curves of a train decide."""
    implies: Callable[[Setup, str, float], NecessaryConditions] = lambda setup, name, bound: NecessaryConditions()
    """What a bound on one of its quantities implies of the cam, whatever else it is."""
    is_of_sizes: bool = False
    """Whether it is arithmetic on sizes, which runs on ranges of them (Intervals) too."""
    is_per_contact: bool = False
    """Whether it is about one contact of the follower with a cam, so that of several the worst counts."""
    is_single_disc: bool = False
    """Whether it is about the one disc that there is: two have none of its quantities."""
    exact: bool = False
    """Whether its quantities have no enclosure, so that nothing else depends on whether they are asked for."""
    last: bool = False
    """Whether it costs so much that a limit on its quantities is checked only for designs that meet all others."""

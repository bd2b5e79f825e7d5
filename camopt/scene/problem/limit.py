"""A limit: a bound on a quantity, with all that verdicts, searches, proofs, prices and pictures need of it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, FloatArray
from camopt.core.quantities import AT_LEAST, AT_MOST, QUANTITIES, Quantity
from camopt.core.quantities.own import OwnQuantity
from camopt.model.effects import Case, Setup, effect_of, quantity_of, with_read_quantities
from camopt.model.effects.case import nothing
from camopt.model.effects.contacts import contacts_of, least_size_of
from camopt.model.effects.crossing import find_crossing, round_bodies
from camopt.model.effects.implied import Implied, LeastForce
from camopt.model.effects.mean import Mean
from camopt.model.effects.motion_errors import EFFECT as MOTION_ERRORS
from camopt.model.effects.peak import CLEAR, DOUBLES, Bodies, BodiesOfCurves, OfBody, Peak
from camopt.model.effects.peak_columns import extreme_of
from camopt.model.effects.train_peak import TrainPeak
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.scene.problem.claims import Claim, MeanClaim, claims_of, mean_claim_of, train_claims_of
from camopt.scene.problem.rows import Columns

ASSEMBLY = "assembly"  # what a design violates that cannot be put together
UNDERCUT, SELF_CROSSING, NO_RIB, PIVOT_IN_CAM = (
    "undercut",
    "self_crossing",
    "no_rib",
    "pivot_in_cam",
)  # names of limits that every cam has to hold

Decide = Callable[[Setup, Designs, Programme], bool | None]
FLOOR = 4.0 * CLEAR  # relative, of what is further from a bound than rounding and a relative error


class OnCurves(NamedTuple):
    """The bodies with which designs of some curves hold a limit for certain, and those with which they may."""

    surely: Bodies = Bodies()
    perhaps: Bodies = Bodies()

    def both(self, other: "OnCurves") -> "OnCurves":
        """The same of two limits together."""
        return OnCurves(self.surely.both(other.surely), self.perhaps.both(other.perhaps))


@dataclass(frozen=True, eq=False)
class Limit(ABC):
    """One limit of a scene, under its key in ``[limits]``."""

    name: str
    bound: float
    """In the unit of its key."""
    setup: Setup = field(repr=False)
    asked: bool = True
    """Whether the scene asks for it; False for limits that every cam must meet."""
    given_by: str = ""
    """The key of the scene that gives its bound, if that is not ``[limits]`` with its name."""

    @abstractmethod
    def excess(self, columns: Columns, designs: Designs) -> Any:
        """Relative excess of designs over it: held where ≤ 0, exceeded by 10 % at 0.1. Its sign is exact."""

    def by_bound(self, columns: Columns, designs: Designs) -> FloatArray:
        """∂excess/∂bound of designs that just meet it; bound − excess/by_bound is the bound that a design meets."""
        return np.full(len(designs), np.nan)

    @property
    def of_curves(self) -> tuple[str, ...] | None:
        """The quantities from which pitch curves alone tell whether designs hold it; None if they do not."""
        return None

    def on_curves(self, case: Case, bodies: Bodies) -> OnCurves | None:
        """With which of some bodies designs hold it that have the pitch curves of a case, and what is found of it.

        None if pitch curves do not tell.
        """
        return None

    @property
    def needs(self) -> tuple[str, ...]:
        """The quantities that it calls for."""
        return ()

    @property
    def shown(self) -> tuple[str, ...]:
        """The quantities that people read beside the bound."""
        return ()

    @property
    def quantity(self) -> Quantity | None:
        """The first of these."""
        return quantity_of(self.shown[0], self.setup) if self.shown else None

    @property
    def relation(self) -> str:
        """The relation of each of them to the bound; ± if the magnitude must be ≤."""
        return AT_MOST

    @property
    def claims(self) -> tuple[Claim, ...]:
        """The curves that decide it, for searches, proofs and pictures; none if it is not decided by curves."""
        return ()

    def claims_at(self, contact: int) -> tuple[Claim, ...]:
        """Those of one contact of a follower that has more, by its number; none that several contacts decide."""
        return ()

    @property
    def mean(self) -> MeanClaim | None:
        """The mean of a curve that decides it, if there is one."""
        return None

    @property
    def of_train(self) -> tuple[Claim, ...]:
        """The curves of a train that decide it, for searches among trains; none if they do not."""
        return ()

    def infinite_at(self, programme: Programme) -> bool:
        """Whether jumps of a motion make its quantity infinite, so that no design meets it."""
        return False

    @property
    def decided(self) -> Decide | None:
        """Whether one design breaks it, None if undecided; for a limit that is not decided by curves."""
        return None

    @property
    def presumes(self) -> str:
        """Another limit that must be met first."""
        return ""

    @property
    def implied(self) -> Implied:
        """Necessary conditions on any cam that meets it."""
        return Implied()

    @property
    def implies(self) -> LeastForce | None:
        """The least contact force that it needs."""
        return self.implied.force

    @property
    def least_size(self) -> float:
        """A base (mean) radius below which no design meets it."""
        return self.implied.least_size

    @property
    def least_base(self) -> float:
        """A base radius of any disc below which no design meets it."""
        return self.bound / 2.0 if self.of_base else 0.0

    @property
    def most_size(self) -> float:
        """A base (mean) radius above which no design meets it."""
        return self.implied.most_size

    @property
    def of_base(self) -> bool:
        """Whether its bound is a least diameter of the base circle."""
        return False

    @cached_property
    def is_of_motion(self) -> bool:
        """Whether motion and speed alone decide it, not the design."""
        effects = [effect_of(name, self.setup) for name in self.needs]
        return bool(effects) and not self.setup.free and all(effect.is_of_motion(self.setup) for effect in effects)

    @cached_property
    def of_errors(self) -> bool:
        """Whether it is on errors by tolerances: those of all cams within them, of the nominal one as it is cut."""
        return any(
            quantity_of(name, self.setup).effect == MOTION_ERRORS.name
            for name in with_read_quantities(self.shown, self.setup)
        )

    @property
    def is_unproved(self) -> bool:
        """Whether a number decides it that has no enclosure."""
        return False

    @property
    def key(self) -> str:
        """The key of the scene that gives its bound; the name of a limit that has none there."""
        return self.given_by or (f"limits.{self.name}" if self.asked else self.name)

    @cached_property
    def last(self) -> bool:
        """Whether it is checked only for designs that meet all other limits."""
        return any(effect_of(name, self.setup).last for name in self.needs)


def needs_of(limits: Iterable[Limit]) -> frozenset[str]:
    """The quantities that some limits call for."""
    return frozenset(need for limit in limits for need in limit.needs)


@dataclass(frozen=True, eq=False)
class QuantityLimit(Limit):
    """A bound on a quantity, from the side that its list says; on several, of their largest magnitude."""

    quantities: tuple[str, ...] = ()
    form: Peak | Mean | TrainPeak | None = None
    """The extreme or the mean of curves that they are, if they are one; or the extreme of those of a train."""
    others: tuple[Claim, ...] = ()
    """What it says of other curves."""
    further: tuple[Peak, ...] = ()
    """The same extreme at further contacts of the follower."""

    def about(self, change: Callable[[Peak], Peak]) -> "QuantityLimit":
        """The same bound on other extremes of the same curves."""
        assert isinstance(self.form, Peak)
        return replace(self, form=change(self.form), further=tuple(map(change, self.further)))

    @property
    def needs(self) -> tuple[str, ...]:
        first, extremes = self.quantities[0], self.form.extremes if isinstance(self.form, Peak) else ()
        by_arm = first.startswith("contact_force") and self.setup.angular  # a moment over the length of the arm
        return (*extremes, *self.quantities, *(("arm_length_mm",) if by_arm else ()))

    @property
    def shown(self) -> tuple[str, ...]:
        return self.quantities if self._of_both_signs else self.quantities[:1]

    @property
    def _of_both_signs(self) -> bool:
        return len(self.quantities) > 1 and QUANTITIES[self.quantities[0]].signed

    @property
    def relation(self) -> str:
        if self._of_both_signs:
            return "±"
        return ">" if self._is_open else QUANTITIES[self.quantities[0]].relation

    @property
    def _is_open(self) -> bool:
        """Whether a design at the bound itself does not meet it."""
        return self.bound == 0.0 and isinstance(self.form, Peak) and self.form.open_at_zero

    @property
    def _side(self) -> float:
        return QUANTITIES[self.quantities[0]].side

    @cached_property
    def claims(self) -> tuple[Claim, ...]:
        if not isinstance(self.form, Peak):
            return self.others
        return tuple(claim for peak in (self.form, *self.further) for claim in claims_of(peak, self.bound))

    def claims_at(self, contact: int) -> tuple[Claim, ...]:
        if not (self.further and isinstance(self.form, Peak)):
            return ()
        return claims_of((self.form, *self.further)[contact], self.bound)

    @cached_property
    def mean(self) -> MeanClaim | None:
        return mean_claim_of(self.form, self.bound, self._side) if isinstance(self.form, Mean) else None

    @cached_property
    def of_train(self) -> tuple[Claim, ...]:
        return train_claims_of(self.form, self.bound) if isinstance(self.form, TrainPeak) else ()

    def infinite_at(self, programme: Programme) -> bool:
        return self.form is not None and any(each.jumps(programme) for each in (self.form, *self.further))

    @cached_property
    def implied(self) -> Implied:
        name = self.quantities[0]
        return effect_of(name, self.setup).implies(self.setup, name, self.bound)

    def excess(self, columns: Columns, designs: Designs) -> Any:
        peak = self.form
        over = self._of_extreme(peak, columns, designs) if isinstance(peak, Peak) and peak.extremes else None
        if over is None:
            values = [columns[name] for name in self.quantities]
            value = values[0] if len(values) == 1 else reduce(np.maximum, map(np.abs, values))
            with np.errstate(over="ignore"):  # of a bound near 0
                over = self._side * (value - self.bound) / self._unit(designs) + np.zeros(len(designs))
        return np.where(over == 0.0, np.finfo(float).tiny, over) if self._is_open else over

    def _unit(self, designs: Designs) -> Any:
        """The unit of a relative excess."""
        if self.bound or not isinstance(self.form, Peak) or self.form.unit is None:
            return abs(self.bound) or 1.0
        return self.form.unit(designs)

    def _of_extreme(self, peak: Peak, columns: Columns, designs: Designs) -> FloatArray:
        """The excess from the weighted extreme of the curve, relative to its allowed value."""
        extreme, weight = self._outward(peak, columns, designs), peak.scale.weight(self.bound)(designs)
        finite = np.isfinite(extreme)
        return np.asarray(np.where(finite, np.where(finite, extreme, 0.0) * weight, extreme) - 1.0)

    @cached_property
    def of_curves(self) -> tuple[str, ...] | None:
        if isinstance(self._weight, OfBody) or self._per_body or self._bodies:
            return ()
        effects = [effect_of(name, self.setup) for name in self.needs]
        return self.needs if all(effect.run is nothing for effect in effects) else None

    @property
    def _weight(self) -> Callable[[Designs], Any] | None:
        """The weight of the extreme that a bound is compared with, if it is one."""
        peak = self.form
        return peak.scale.weight(self.bound) if isinstance(peak, Peak) and peak.extremes else None

    @property
    def _per_body(self) -> float:
        return self.form.per_body if isinstance(self.form, Peak) and not self.further else 0.0

    @property
    def _bodies(self) -> BodiesOfCurves | None:
        """What gives the bodies with which pitch curves meet it, if its peak has that."""
        return self.form.bodies if isinstance(self.form, Peak) and not self.further else None

    def _share(self, designs: Designs) -> Any:
        """The inverse of the extreme that designs are allowed."""
        assert isinstance(self.form, Peak)
        scale = self.form.scale
        return scale.weight(self.bound)(designs) / scale.extreme_at(self.bound, DOUBLES)

    def on_curves(self, case: Case, bodies: Bodies) -> OnCurves | None:
        peak, weight = self.form, self._weight
        if isinstance(peak, Peak) and self._per_body and not case.programme.radii:
            return self._with_more(case, peak)
        if self._bodies and not case.programme.radii:
            return OnCurves(*self._bodies(case, self._share, bodies))
        if not isinstance(peak, Peak) or not isinstance(weight, OfBody):
            return None
        if case.found.keys() >= set(peak.extremes):
            sides = [{name: case.shifted(name, side) for name in peak.extremes} for side in (1.0, -1.0)]
            far, near = (self._outward(peak, columns, case.designs) for columns in sides)
        else:
            far, near = self._beyond_all(case, peak, weight.largest(bodies))
        return OnCurves(weight.bodies(far, CLEAR), weight.bodies(near, -CLEAR))

    def _with_more(self, case: Case, peak: Peak) -> OnCurves:
        """The bodies that are large or small enough for a least value, by that with a body of none."""
        found = extreme_of(case, peak)
        finite = np.where(np.isfinite(found.value), found.value, 0.0)
        room = CLEAR * np.maximum(self._unit(case.designs), np.abs(finite))
        far, near = (self.bound - found.value + side * (found.width + room) for side in (1.0, -1.0))
        if peak.per_body < 0.0:
            return OnCurves(Bodies(most=-far), Bodies(most=-near))
        return OnCurves(Bodies(least=far), Bodies(least=near))

    def _beyond_all(self, case: Case, peak: Peak, weight: float) -> tuple[FloatArray, FloatArray]:
        """The far and the near side of what ``_outward`` gives, or of what holds with the largest weight."""
        allowed = peak.scale.extreme_at(self.bound, DOUBLES)
        floor = (1.0 - FLOOR) / (weight * abs(allowed)) if weight > 0.0 else -np.inf
        found = extreme_of(case, peak, floor=floor)
        far, near = (allowed * found.value + side * abs(allowed) * found.width for side in (1.0, -1.0))
        return far, near

    def _outward(self, peak: Peak, columns: Mapping[str, Any], designs: Designs) -> FloatArray:
        """The extreme as a share of what it is allowed to be, but for its weight."""
        most, least = (np.asarray(columns[name] + np.zeros(len(designs))) for name in peak.extremes)
        if peak.goal == LARGEST_MAGNITUDE:
            most = np.maximum(most, -least)
        extreme = most if peak.goal in (LARGEST, LARGEST_MAGNITUDE) else least
        return np.asarray(extreme * peak.scale.extreme_at(self.bound, DOUBLES))

    def by_bound(self, columns: Columns, designs: Designs) -> FloatArray:
        if isinstance(self.form, Peak) and self.form.extremes:
            return self._outward(self.form, columns, designs)  # weights rise with a bound as 1 does
        return np.asarray(-self._side / self._unit(designs) + np.zeros(len(designs)))


@dataclass(frozen=True, eq=False)
class OwnLimit(Limit):
    """A quantity of the scene's own is a finite number, and at most the bound; an infinite bound is none."""

    @property
    def needs(self) -> tuple[str, ...]:
        return (self.name,)

    @property
    def shown(self) -> tuple[str, ...]:
        return self.needs if self.asked else ()

    @cached_property
    def is_unproved(self) -> bool:
        """Whether it reads a Python function, or what is no quantity to be bounded, as where something is."""
        read = [quantity_of(name, self.setup) for name in with_read_quantities(self.needs, self.setup)]
        functions = [isinstance(each, OwnQuantity) and each.call for each in read]
        return any(functions) or not all(each.relation or each.effect == "sizes" for each in read)

    def excess(self, columns: Columns, designs: Designs) -> FloatArray:
        value = columns[self.name]
        over = (value - self.bound) / (abs(self.bound) or 1.0) if self.asked else -1.0
        return np.asarray(np.where(value == np.inf, np.inf, over) + np.zeros(len(designs)))

    def by_bound(self, columns: Columns, designs: Designs) -> FloatArray:
        return np.full(len(designs), -1.0 / (abs(self.bound) or 1.0))


def _crosses(setup: Setup, design: Designs, programme: Programme) -> bool | None:
    """Whether any profile of one design crosses itself; None if that is not known."""
    found = [
        find_crossing(replace(setup, mechanism=each.mechanism), each.seen(design), programme).shown
        for each in contacts_of(setup)
    ]
    return True if True in found else None if None in found else False


@dataclass(frozen=True, eq=False)
class SelfCrossing(Limit):
    """The profile does not cross itself: held or broken, without a measure between."""

    @property
    def needs(self) -> tuple[str, ...]:
        return (SELF_CROSSING,)

    @property
    def presumes(self) -> str:
        return UNDERCUT

    @property
    def of_curves(self) -> tuple[str, ...]:
        return ("pressure_angle_max_deg",)

    def on_curves(self, case: Case, bodies: Bodies) -> OnCurves | None:
        wider = case.setup.half_width(case.designs) - case.designs.roller_radius
        return OnCurves(surely=Bodies(most=round_bodies(case) * (1.0 - CLEAR) - wider))

    def excess(self, columns: Columns, designs: Designs) -> FloatArray:
        return np.asarray(columns[SELF_CROSSING] - 0.5 + np.zeros(len(designs)))

    @property
    def decided(self) -> Decide:
        return _crosses


@dataclass(frozen=True, eq=False)
class WithinBase(Limit):
    """A circle with the bound as its diameter lies within the base circle, the least radius of every profile."""

    @property
    def relation(self) -> str:
        return AT_LEAST

    @property
    def of_base(self) -> bool:
        return True

    @property
    def implied(self) -> Implied:
        return Implied(least_size=self.bound / 2.0)

    def excess(self, columns: Columns, designs: Designs) -> FloatArray:
        radius = self.bound / 2.0
        result: FloatArray = (radius - least_size_of(self.setup, designs)) / radius
        return result

    def by_bound(self, columns: Columns, designs: Designs) -> FloatArray:
        return np.full(len(designs), 1.0 / self.bound)

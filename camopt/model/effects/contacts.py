"""Effects of followers with several contacts: each contact is computed alone, and the worst value counts.

An effect is written for one contact. If the follower has further contacts (``Mechanism.further_contacts``), the
effect runs once for each, with the sizes and curves of that contact. The worst value is the largest of a quantity
that should be small, and the least of one that should be large. Peaks of a further contact are peaks over the same
motion; their curves and scales take the sizes at that contact (``contact_peaks``).
"""

from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import reduce, wraps
from operator import is_
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, IntArray, Number
from camopt.core.quantities import QUANTITIES
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup, no_columns
from camopt.model.effects.peak import NumberKind, Peak, Scale, unit_weight
from camopt.model.mechanisms.design import Designs, FurtherContact
from camopt.model.motion.programme import Programme

ColumnFinder = Callable[[EvaluationBlock, frozenset[str], dict[str, Any]], None]
"""Adds columns of a block with one contact, by name, and all that they need, to known ones."""


def all_follower_contacts(setup: Setup) -> tuple[FurtherContact, ...]:
    """All contacts of a follower, each as the contact of an ordinary cam."""
    first = setup.mechanism._replace(further_contacts=())
    return (FurtherContact(first, _unchanged_designs), *setup.mechanism.further_contacts)


def _unchanged_designs(designs: Designs) -> Designs:
    return designs


def block_at_contact(case: EvaluationBlock, contact: FurtherContact) -> EvaluationBlock:
    """A block with the mechanism and the sizes of one contact."""
    setup = replace(case.setup, mechanism=contact.mechanism)
    return EvaluationBlock(setup, case.programme, contact.local_designs(case.designs))


def columns_at_each_contact(
    case: EvaluationBlock, find_columns: ColumnFinder, wanted_quantities: frozenset[str]
) -> list[dict[str, Any]]:
    """Wanted columns of a block at each contact; the block remembers them for later effects."""
    if _remembered_contact_columns(case) is None:
        of = (case.setup, case.programme, case.designs)
        case.memory.update(of=of, known=[{} for _ in all_follower_contacts(case.setup)])
    for contact, known in zip(all_follower_contacts(case.setup), case.memory["known"], strict=True):
        if missing := wanted_quantities - known.keys():
            find_columns(block_at_contact(case, contact), missing, known)
    return [{name: known[name] for name in wanted_quantities & known.keys()} for known in case.memory["known"]]


def _remembered_contact_columns(case: EvaluationBlock) -> list[dict[str, Any]] | None:
    """The columns computed so far at each contact of a block; None before the first."""
    of = (case.setup, case.programme, case.designs)
    return case.memory["known"] if all(map(is_, case.memory.get("of", (None,) * 3), of)) else None


def select_designs(case: EvaluationBlock, index: IntArray) -> EvaluationBlock:
    """The block of some designs, with the remembered columns of their contacts."""

    def select_rows(value: Any) -> Any:
        if isinstance(value, EnclosedValue):
            return EnclosedValue(*map(select_rows, value))
        return value[index] if np.ndim(value) else value

    part = replace(case, designs=case.designs.take(index), memory={})
    if known := _remembered_contact_columns(case):
        columns = [{name: select_rows(value) for name, value in each.items()} for each in known]
        part.memory.update(of=(part.setup, part.programme, part.designs), known=columns)
    return part


def with_designs_and_kept_columns(
    case: EvaluationBlock, designs: Designs, changed_quantities: Container[str]
) -> EvaluationBlock:
    """The block with other designs, with the remembered columns of quantities that do not change."""
    other = replace(case, designs=designs, memory={})
    if known := _remembered_contact_columns(case):
        kept = [
            {name: value for name, value in columns.items() if name not in changed_quantities} for columns in known
        ]
        other.memory.update(of=(other.setup, other.programme, other.designs), known=kept)
    return other


def quantities_that_differ_by_design(case: EvaluationBlock) -> frozenset[str]:
    """The remembered quantities in which the designs of a block differ."""

    def differs_between_designs(value: Any) -> bool:
        parts = value if isinstance(value, EnclosedValue) else (value,)
        return not all(np.array_equal(part, np.roll(part, 1), equal_nan=True) for part in parts)

    return frozenset(
        name
        for columns in _remembered_contact_columns(case) or ()
        for name, value in columns.items()
        if differs_between_designs(value)
    )


def smallest_disc_size(setup: Setup, designs: Designs) -> Number:
    """Size of the smallest disc that the follower touches [mm]."""
    further = (contact.local_designs(designs).size for contact in setup.mechanism.further_contacts)
    return reduce(np.minimum, [designs.size, *further])


def worst_contact_effect(effect: Effect, find_columns: ColumnFinder) -> Effect:
    """An effect of one contact as an effect of all contacts: its quantities are the worst of them."""

    @wraps(effect.applicable_quantities)
    def applicable_quantities(setup: Setup) -> tuple[str, ...]:
        names = effect.applicable_quantities(setup)
        return tuple(filter(_quantity_has_worst_value, names)) if setup.mechanism.further_contacts else names

    def input_quantities(setup: Setup) -> tuple[str, ...]:
        names = effect.input_quantities(setup)
        return tuple(filter(_quantity_has_worst_value, names)) if setup.mechanism.further_contacts else names

    def worst_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
        contacts = columns_at_each_contact(case, find_columns, wanted_quantities)
        return {name: _worst_column(name, [columns[name] for columns in contacts]) for name in contacts[0]}

    def evaluate_pitch_curve_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
        if not case.setup.mechanism.further_contacts:
            return effect.evaluate_pitch_curve_columns(case, wanted_quantities)
        return worst_columns(case, wanted_quantities) if effect.evaluate_columns is no_columns else {}

    def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
        return (
            worst_columns(case, wanted_quantities)
            if case.setup.mechanism.further_contacts
            else effect.evaluate_columns(case, wanted_quantities)
        )

    only_run = effect.evaluate_pitch_curve_columns is no_columns and effect.evaluate_columns is not no_columns
    return effect._replace(
        applicable_quantities=applicable_quantities,
        input_quantities=input_quantities,
        evaluate_pitch_curve_columns=no_columns if only_run else evaluate_pitch_curve_columns,
        evaluate_columns=no_columns if effect.evaluate_columns is no_columns else evaluate_columns,
    )


def effect_of_single_discs_only(effect: Effect) -> Effect:
    """An effect of a single disc: a pair of discs has none of its quantities."""

    @wraps(effect.applicable_quantities)
    def applicable_quantities(setup: Setup) -> tuple[str, ...]:
        return () if setup.mechanism.second_contact_size_keys else effect.applicable_quantities(setup)

    return effect._replace(applicable_quantities=applicable_quantities)


def _quantity_has_worst_value(name: str) -> bool:
    """Whether one value of a quantity can be worse than another; not so for places."""
    return bool(QUANTITIES[name].relation_to_limit) or QUANTITIES[name].kind is bool


def _worst_column(name: str, values: list[Any]) -> Any:
    """The worst of the values of a quantity at the contacts."""
    worse = np.minimum if QUANTITIES[name].limit_sign < 0.0 else np.maximum
    if not any(isinstance(each, EnclosedValue) for each in values):
        return reduce(worse, values)
    bounded = [
        each if isinstance(each, EnclosedValue) else EnclosedValue(each, 0.0, np.abs(each)) for each in values
    ]
    value = reduce(worse, [each.value for each in bounded])
    far = reduce(worse, [each.value + each.outward for each in bounded])
    with np.errstate(invalid="ignore"):
        outward = np.where(np.isfinite(np.asarray(value, float)), np.asarray(far, float) - value, 0.0)
    return EnclosedValue(value, outward, reduce(np.maximum, [each.scale for each in bounded]))


@dataclass(frozen=True)
class FunctionAtContact:
    """A maker of curves, or a weight, that takes the sizes of designs at a contact."""

    function: Callable[..., Any]
    local_designs: Callable[[Designs], Designs]

    def __call__(self, designs: Designs, *programme: Programme) -> Any:
        return self.function(self.local_designs(designs), *programme)


@dataclass(frozen=True)
class ContactScale(Scale):
    """A scale that takes the sizes of designs at a contact."""

    scale: Scale
    local_designs: Callable[[Designs], Designs]

    @property
    def is_decreasing(self) -> bool:  # type: ignore[override]
        return self.scale.is_decreasing

    def quantity_from_extreme(self, extreme: Any, designs: Designs) -> Number:
        return self.scale.quantity_from_extreme(extreme, self.local_designs(designs))

    def quantity_change(self, extreme: FloatArray, extreme_change: FloatArray, designs: Designs) -> FloatArray:
        return self.scale.quantity_change(extreme, extreme_change, self.local_designs(designs))

    def weighted_extreme_for_quantity(self, quantity: float, number_kind: NumberKind) -> Number:
        return self.scale.weighted_extreme_for_quantity(quantity, number_kind)

    def curve_weight_by_design(self, quantity: float) -> Callable[[Designs], Any]:
        weight = self.scale.curve_weight_by_design(quantity)
        return weight if weight is unit_weight else FunctionAtContact(weight, self.local_designs)


def contact_peaks(effect: Effect, setup: Setup, quantity_name: str) -> Iterator[Peak]:
    """The peak of an effect's quantity at each contact; none if the quantity is no peak."""
    if not (effect.is_per_contact and setup.mechanism.further_contacts):
        if peak := effect.peaks(setup).get(quantity_name):
            yield peak
        return
    for mechanism, local in all_follower_contacts(setup):
        peak = effect.peaks(replace(setup, mechanism=mechanism)).get(quantity_name)
        if peak and local is not _unchanged_designs:
            peak = peak._replace(
                curves=tuple((FunctionAtContact(make, local), kinds) for make, kinds in peak.curves),
                scale=ContactScale(peak.scale, local),
                unit=peak.unit and FunctionAtContact(peak.unit, local),
                forces=tuple((FunctionAtContact(make, local), kinds) for make, kinds in peak.forces),
            )
        if peak:
            yield peak._replace(extremes=())


CONTACT_QUANTITIES = (
    "pressure_angle_max_deg",
    "profile_radius_min_mm",
    "outer_radius_mm",
    "contact_stress_max_MPa",
)
"""Quantities that are reported of each contact too, as ``first_…`` and ``second_…``."""
CONTACT_NAMES = ("first", "second")


def per_contact_effect(effects: Mapping[str, Effect], find_columns: ColumnFinder) -> Effect:
    """The effect that reports some quantities of each contact, if the follower has more than one."""

    def applicable_quantities(setup: Setup) -> tuple[str, ...]:
        if not setup.mechanism.further_contacts:
            return ()
        # a single disc has one shape
        reported = CONTACT_QUANTITIES if setup.mechanism.has_two_profiles else CONTACT_QUANTITIES[-1:]
        known = {name for name in reported if name in effects[QUANTITIES[name].effect].applicable_quantities(setup)}
        return tuple(f"{place}_{name}" for name in CONTACT_QUANTITIES if name in known for place in CONTACT_NAMES)

    def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
        lacking = {
            name: effects[QUANTITIES[name].effect].missing_keys_by_quantity(setup).get(name)
            for name in CONTACT_QUANTITIES
        }
        every = {name: lacking[name.partition("_")[2]] for name in applicable_quantities(setup)}
        return {name: keys for name, keys in every.items() if keys}

    def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
        columns: dict[str, Any] = {}
        names = frozenset(
            name
            for name in CONTACT_QUANTITIES
            if any(f"{place}_{name}" in wanted_quantities for place in CONTACT_NAMES)
        )
        for place, values in zip(CONTACT_NAMES, columns_at_each_contact(case, find_columns, names), strict=True):
            columns |= {f"{place}_{name}": value for name, value in values.items()}
        return columns

    def peaks(setup: Setup) -> dict[str, Peak]:
        if not setup.mechanism.further_contacts:
            return {}
        return {
            f"{place}_{name}": peak
            for name in CONTACT_QUANTITIES
            for place, peak in zip(
                CONTACT_NAMES, contact_peaks(effects[QUANTITIES[name].effect], setup, name), strict=False
            )
        }

    return Effect("pair", applicable_quantities, evaluate_columns, missing_keys_by_quantity, peaks=peaks)

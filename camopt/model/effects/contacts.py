"""Effects of a contact, where the follower has more than one: each on its own, and the worst of all counts.

An effect is written for one contact. Of a follower with further ones (``Mechanism.further``) it runs once for each,
on the sizes of that contact and with the curves of its motion, and a quantity is the worst: the largest of what one
wants small, the least of what one wants large. Peaks of a further contact are peaks of the same motion: their
curves and scales look at designs as that contact does (``seen_peak``).
"""

from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import wraps
from operator import is_
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.quantities import QUANTITIES
from camopt.model.effects.case import Bounded, Case, Effect, Setup, nothing
from camopt.model.effects.peak import NumberKind, Peak, Scale, unweighted
from camopt.model.mechanisms.design import Contact, Designs
from camopt.model.motion.programme import Programme

Found = Callable[[Case, frozenset[str], dict[str, Any]], None]
"""Of a case of one contact: adds columns, by name, and all that they need, to those that are known."""


def contacts_of(setup: Setup) -> tuple[Contact, ...]:
    """All contacts of a follower, each as that of an ordinary cam."""
    first = setup.mechanism._replace(further=())
    return (Contact(first, _as_it_is), *setup.mechanism.further)


def _as_it_is(designs: Designs) -> Designs:
    return designs


def at_contact(case: Case, contact: Contact) -> Case:
    """A case as a contact has it."""
    setup = replace(case.setup, mechanism=contact.mechanism)
    return Case(setup, case.programme, contact.seen(case.designs))


def columns_at(case: Case, found: Found, wanted: frozenset[str]) -> list[dict[str, Any]]:
    """Columns of a case at each contact; what one effect asks, the next ones need not look for again."""
    if _known_of(case) is None:
        of = (case.setup, case.programme, case.designs)
        case.memory.update(of=of, known=[{} for _ in contacts_of(case.setup)])
    for contact, known in zip(contacts_of(case.setup), case.memory["known"], strict=True):
        if missing := wanted - known.keys():
            found(at_contact(case, contact), missing, known)
    return [{name: known[name] for name in wanted & known.keys()} for known in case.memory["known"]]


def _known_of(case: Case) -> list[dict[str, Any]] | None:
    """The columns that were found at each contact of a case; None if none were sought."""
    of = (case.setup, case.programme, case.designs)
    return case.memory["known"] if all(map(is_, case.memory.get("of", (None,) * 3), of)) else None


def some_of(case: Case, index: IntArray) -> Case:
    """A case of some of its designs, with what was found at each contact of them."""

    def taken(value: Any) -> Any:
        if isinstance(value, Bounded):
            return Bounded(*map(taken, value))
        return value[index] if np.ndim(value) else value

    part = replace(case, designs=case.designs.take(index), memory={})
    if known := _known_of(case):
        columns = [{name: taken(value) for name, value in each.items()} for each in known]
        part.memory.update(of=(part.setup, part.programme, part.designs), known=columns)
    return part


def with_designs(case: Case, designs: Designs, changed: Container[str]) -> Case:
    """A case of designs for which some quantities change, with what was found at each contact of the others."""
    other = replace(case, designs=designs, memory={})
    if known := _known_of(case):
        kept = [{name: value for name, value in each.items() if name not in changed} for each in known]
        other.memory.update(of=(other.setup, other.programme, other.designs), known=kept)
    return other


def changing(case: Case) -> frozenset[str]:
    """The quantities, of those found at each contact, in which designs of a case differ."""

    def differs(value: Any) -> bool:
        parts = value if isinstance(value, Bounded) else (value,)
        return not all(np.array_equal(each, np.roll(each, 1), equal_nan=True) for each in parts)

    return frozenset(name for each in _known_of(case) or () for name, value in each.items() if differs(value))


def least_size_of(setup: Setup, designs: Designs) -> Any:
    """The size of the smallest of the discs that the follower touches."""
    return _reduced(np.minimum, [designs.size, *(each.seen(designs).size for each in setup.mechanism.further)])


def on_each_contact(effect: Effect, found: Found) -> Effect:
    """An effect of one contact as one of all: what it offers is the worst of them."""

    @wraps(effect.offers)
    def offers(setup: Setup) -> tuple[str, ...]:
        names = effect.offers(setup)
        return tuple(filter(_has_worst, names)) if setup.mechanism.further else names

    def reads(setup: Setup) -> tuple[str, ...]:
        names = effect.reads(setup)
        return tuple(filter(_has_worst, names)) if setup.mechanism.further else names

    def worst_of_all(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
        each = columns_at(case, found, wanted)
        return {name: _worst(name, [columns[name] for columns in each]) for name in each[0]}

    def of_pitch(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
        if not case.setup.mechanism.further:
            return effect.of_pitch(case, wanted)
        return worst_of_all(case, wanted) if effect.run is nothing else {}

    def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
        return worst_of_all(case, wanted) if case.setup.mechanism.further else effect.run(case, wanted)

    return effect._replace(
        offers=offers,
        reads=reads,
        of_pitch=nothing if effect.of_pitch is nothing and effect.run is not nothing else of_pitch,
        run=nothing if effect.run is nothing else run,
    )


def on_one_disc(effect: Effect) -> Effect:
    """An effect of the only disc that there is: of two discs it offers nothing."""

    @wraps(effect.offers)
    def offers(setup: Setup) -> tuple[str, ...]:
        return () if setup.mechanism.second_keys else effect.offers(setup)

    return effect._replace(offers=offers)


def _has_worst(name: str) -> bool:
    """Whether one value of a quantity is worse than another; not of what says where something is."""
    return bool(QUANTITIES[name].relation) or QUANTITIES[name].kind is bool


def _worst(name: str, values: list[Any]) -> Any:
    """The worst of the values of a quantity at the contacts."""
    worse = np.minimum if QUANTITIES[name].side < 0.0 else np.maximum
    if not any(isinstance(each, Bounded) for each in values):
        return _reduced(worse, values)
    bounded = [each if isinstance(each, Bounded) else Bounded(each, 0.0, np.abs(each)) for each in values]
    value = _reduced(worse, [each.value for each in bounded])
    far = _reduced(worse, [each.value + each.outward for each in bounded])
    with np.errstate(invalid="ignore"):
        outward = np.where(np.isfinite(np.asarray(value, float)), np.asarray(far, float) - value, 0.0)
    return Bounded(value, outward, _reduced(np.maximum, [each.scale for each in bounded]))


def _reduced(worse: Any, values: list[Any]) -> Any:
    first, *rest = values
    for each in rest:
        first = worse(first, each)
    return first


@dataclass(frozen=True)
class SeenCurve:
    """A curve of designs as a contact sees them."""

    make: Callable[[Designs, Programme], Any]
    seen: Callable[[Designs], Designs]

    def __call__(self, designs: Designs, programme: Programme) -> Any:
        return self.make(self.seen(designs), programme)


@dataclass(frozen=True)
class SeenWeight:
    """A number of designs as a contact sees them."""

    weight: Callable[[Designs], Any]
    seen: Callable[[Designs], Designs]

    def __call__(self, designs: Designs) -> Any:
        return self.weight(self.seen(designs))


@dataclass(frozen=True)
class SeenScale(Scale):
    """The scale of an extreme of designs as a contact sees them."""

    scale: Scale
    seen: Callable[[Designs], Designs]

    @property
    def falls(self) -> bool:  # type: ignore[override]
        return self.scale.falls

    def quantity(self, extreme: Any, designs: Designs) -> Any:
        return self.scale.quantity(extreme, self.seen(designs))

    def change(self, extreme: FloatArray, by: FloatArray, designs: Designs) -> FloatArray:
        return self.scale.change(extreme, by, self.seen(designs))

    def extreme_at(self, quantity: float, numbers: NumberKind) -> Any:
        return self.scale.extreme_at(quantity, numbers)

    def weight(self, quantity: float) -> Callable[[Designs], Any]:
        weight = self.scale.weight(quantity)
        return weight if weight is unweighted else SeenWeight(weight, self.seen)


def seen_peak(peak: Peak, contact: Contact) -> Peak:
    """A peak of the designs that a contact sees, as one of all designs."""
    curves = tuple((SeenCurve(make, contact.seen), kinds) for make, kinds in peak.curves)
    unit = peak.unit and SeenWeight(peak.unit, contact.seen)
    return peak._replace(curves=curves, scale=SeenScale(peak.scale, contact.seen), unit=unit, extremes=())


def peaks_at(effect: Effect, setup: Setup, name: str) -> Iterator[Peak]:
    """The peak behind a quantity of an effect at each contact, if it is one; the only one as it is."""
    if not (effect.of_contact and setup.mechanism.further):
        if peak := effect.peaks(setup).get(name):
            yield peak
        return
    for contact in contacts_of(setup):
        if peak := effect.peaks(replace(setup, mechanism=contact.mechanism)).get(name):
            first = contact.seen is _as_it_is
            yield peak._replace(extremes=()) if first else seen_peak(peak, contact)


OF_EACH = ("pressure_angle_max_deg", "profile_radius_min_mm", "outer_radius_mm", "contact_stress_max_MPa")
"""Quantities that are told of each contact too, as ``first_…`` and ``second_…``."""
PLACES = ("first", "second")


def of_each_contact(effects: Mapping[str, Effect], found: Found) -> Effect:
    """The effect that tells some quantities of each contact of a follower that has more than one."""

    def offers(setup: Setup) -> tuple[str, ...]:
        if not setup.mechanism.further:
            return ()
        told = OF_EACH if setup.mechanism.two_profiles else OF_EACH[-1:]  # one disc has one shape
        known = {name for name in told if name in effects[QUANTITIES[name].effect].offers(setup)}
        return tuple(f"{place}_{name}" for name in OF_EACH if name in known for place in PLACES)

    def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
        lacking = {name: effects[QUANTITIES[name].effect].lacks(setup).get(name) for name in OF_EACH}
        every = {each: lacking[each.partition("_")[2]] for each in offers(setup)}
        return {each: keys for each, keys in every.items() if keys}

    def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
        columns: dict[str, Any] = {}
        asked = frozenset(name for name in OF_EACH if any(f"{place}_{name}" in wanted for place in PLACES))
        for place, told in zip(PLACES, columns_at(case, found, asked), strict=True):
            columns |= {f"{place}_{name}": value for name, value in told.items()}
        return columns

    def peaks(setup: Setup) -> dict[str, Peak]:
        if not setup.mechanism.further:
            return {}
        every = {name: peaks_at(effects[QUANTITIES[name].effect], setup, name) for name in OF_EACH}
        return {f"{p}_{name}": peak for name, each in every.items() for p, peak in zip(PLACES, each, strict=False)}

    return Effect("pair", offers, run, lacks, peaks=peaks)

"""Effects compute quantities; a plan runs only the effects that are needed."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from camopt.core.numerics.same import Same
from camopt.core.quantities import QUANTITIES, Quantity, in_order
from camopt.model.effects import (
    clearance,
    crossing,
    curvature,
    face,
    force,
    frame,
    hertz,
    joints,
    lash,
    lift_change,
    motion,
    motion_errors,
    outline,
    pitch_circle,
    preload,
    pressure,
    reach,
    rib,
    rms,
    section,
    sizes,
    solid,
    surface,
    thrust,
    torque,
    transmission,
    vibration,
    wall,
)
from camopt.model.effects.case import Bounded, Case, Effect, Setup, SolidGiven
from camopt.model.effects.contacts import of_each_contact, on_each_contact, on_one_disc
from camopt.model.effects.given import Bodies, GivenDynamics, GivenErrors, GivenNumbers
from camopt.model.effects.own import own_effect

__all__ = [
    "EFFECTS",
    "Bodies",
    "Case",
    "Effect",
    "GivenDynamics",
    "GivenErrors",
    "GivenNumbers",
    "Setup",
    "SolidGiven",
    "effect_of",
    "effects_needed",
    "effects_of",
    "find_effect",
    "lacking",
    "offered",
    "quantity_of",
    "with_read_quantities",
]

_OWN = {
    effect.name: effect
    for effect in (
        sizes.EFFECT,
        frame.EFFECT,
        wall.EFFECT,
        motion.EFFECT,
        lift_change.EFFECT,
        transmission.EFFECT,
        rms.EFFECT,
        lash.EFFECT,
        force.EFFECT,
        preload.EFFECT,
        torque.EFFECT,
        joints.EFFECT,
        clearance.EFFECT,
        vibration.EFFECT,
        pressure.EFFECT,
        pitch_circle.EFFECT,
        curvature.EFFECT,
        reach.EFFECT,
        rib.EFFECT,
        face.EFFECT,
        outline.EFFECT,
        motion_errors.EFFECT,
        thrust.EFFECT,
        hertz.EFFECT,
        surface.EFFECT,
        section.EFFECT,
        solid.EFFECT,
        crossing.EFFECT,
    )
}
"""Every effect as it is written, for a follower that one cam touches."""


def _find(case: Case, wanted: frozenset[str], known: dict[str, Any]) -> None:
    """Add columns of a case of one contact, and all that they need, to those that are known."""
    for name, needed in effects_needed(wanted, case.setup).items():
        for run in (_OWN[name].of_pitch, _OWN[name].run) if needed - known.keys() else ():
            bounded = {key: value for key, value in known.items() if isinstance(value, Bounded)}
            columns = known | {key: value.value for key, value in bounded.items()}
            outward = {key: value.outward for key, value in bounded.items()}
            found = run(replace(case, found=columns, outward=outward), frozenset(needed))
            known |= {key: value for key, value in found.items() if key in needed}


def _for_all_drives(effect: Effect) -> Effect:
    """An effect for followers with any drive."""
    if effect.of_contact:
        return on_each_contact(effect, _find)
    return on_one_disc(effect) if effect.of_disc else effect


_PAIR = of_each_contact(_OWN, _find)
EFFECTS: dict[str, Effect] = {e.name: _for_all_drives(e) for e in (*_OWN.values(), _PAIR)}
"""Every effect by name, cheapest first: the order in which they run."""


def quantity_of(name: str, setup: Setup) -> Quantity:
    """A quantity by name: one of the scene's own, or one that every scene has."""
    return setup.own[name] if name in setup.own else QUANTITIES[name]


def effects_of(setup: Setup) -> Mapping[str, Effect]:
    """Every effect of a setup by name: those of all scenes, then those of the scene's own quantities."""
    return EFFECTS | {each.name: each for each in _own_effects(Same(setup)).values()} if setup.own else EFFECTS


def find_effect(name: str, setup: Setup) -> Effect | None:
    """The effect that computes a quantity; None of a verdict."""
    return _own_effects(Same(setup))[name] if name in setup.own else EFFECTS.get(QUANTITIES[name].effect)


def effect_of(name: str, setup: Setup) -> Effect:
    """The effect that computes a quantity."""
    found = find_effect(name, setup)
    assert found is not None
    return found


@lru_cache(maxsize=16)
def _own_effects(same: Same[Setup]) -> Mapping[str, Effect]:
    """The effect of each of the scene's own quantities; one that reads what is computed last is last too."""
    found: dict[str, Effect] = {}
    for name, each in same.value.own.items():
        read = [found.get(read) or EFFECTS[QUANTITIES[read].effect] for read in each.reads]
        found[name] = own_effect(each, last=any(effect.last for effect in read))
    return found


def with_read_quantities(names: Iterable[str], setup: Setup) -> frozenset[str]:
    """Some quantities, and all that those of the scene's own among them read."""
    found = set(names)
    for each in reversed([*setup.own.values()]):
        if each.name in found:
            found.update(each.reads)
    return frozenset(found)


def offered(setup: Setup) -> tuple[str, ...]:
    """All quantities of a setup for which the scene gives enough values, in the order of the columns."""
    return _offered(Same(setup))


@lru_cache(maxsize=16)
def _offered(same: Same[Setup]) -> tuple[str, ...]:
    names = {name for effect in EFFECTS.values() for name in effect.offers(same.value)}
    names -= lacking(same.value).keys()
    for each in same.value.own.values():
        names |= {each.name} if names.issuperset(each.reads) else set()
    return tuple(in_order(names))


def lacking(setup: Setup) -> Mapping[str, tuple[str, ...]]:
    """The keys that the scene lacks, for each quantity that a setup would have with them."""
    return _lacking(Same(setup))


@lru_cache(maxsize=16)
def _lacking(same: Same[Setup]) -> Mapping[str, tuple[str, ...]]:
    found = {name: keys for effect in EFFECTS.values() for name, keys in effect.lacks(same.value).items()}
    for each in same.value.own.values():
        if keys := [key for read in each.reads for key in found.get(read, ())]:
            found[each.name] = tuple(dict.fromkeys(keys))
    return found


def effects_needed(wanted: Iterable[str], setup: Setup) -> Mapping[str, frozenset[str]]:
    """The quantities needed of each effect, by its name, in the order in which effects run."""
    return _needed(frozenset(wanted), Same(setup))


@lru_cache(maxsize=16)
def _needed(wanted: frozenset[str], same: Same[Setup]) -> Mapping[str, frozenset[str]]:
    setup, asked, open_ = same.value, dict[str, set[str]](), set(wanted)
    while open_:
        name = open_.pop()
        effect = find_effect(name, setup)
        if effect is None:
            continue
        if effect.name not in asked:
            open_ |= set(effect.reads(setup))
        asked.setdefault(effect.name, set()).add(name)
    return {name: frozenset(asked[name]) for name in effects_of(setup) if name in asked}

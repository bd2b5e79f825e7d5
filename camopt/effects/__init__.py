"""Effects compute quantities; a plan runs only the effects that are needed."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from camopt.effects import (
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
from camopt.effects.case import Bounded, Case, Effect, Setup, SolidGiven
from camopt.effects.contacts import of_each_contact, on_each_contact, on_one_disc
from camopt.effects.given import Bodies, GivenDynamics, GivenErrors, GivenNumbers
from camopt.numerics.same import Same
from camopt.quantities import QUANTITIES, in_order

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
    "effects_needed",
    "lacking",
    "offered",
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


def offered(setup: Setup) -> tuple[str, ...]:
    """All quantities of a setup for which the scene gives enough values, in the order of the columns."""
    return _offered(Same(setup))


@lru_cache(maxsize=16)
def _offered(same: Same[Setup]) -> tuple[str, ...]:
    names = {name for effect in EFFECTS.values() for name in effect.offers(same.value)}
    return tuple(in_order(names - lacking(same.value).keys()))


def lacking(setup: Setup) -> Mapping[str, tuple[str, ...]]:
    """The keys that the scene lacks, for each quantity that a setup would have with them."""
    return _lacking(Same(setup))


@lru_cache(maxsize=16)
def _lacking(same: Same[Setup]) -> Mapping[str, tuple[str, ...]]:
    return {name: keys for effect in EFFECTS.values() for name, keys in effect.lacks(same.value).items()}


def effects_needed(wanted: Iterable[str], setup: Setup) -> Mapping[str, frozenset[str]]:
    """The quantities needed of each effect, by its name, in the order in which effects run."""
    return _needed(frozenset(wanted), Same(setup))


@lru_cache(maxsize=16)
def _needed(wanted: frozenset[str], same: Same[Setup]) -> Mapping[str, frozenset[str]]:
    setup, asked, open_ = same.value, dict[str, set[str]](), set(wanted)
    while open_:
        name = open_.pop()
        effect = EFFECTS.get(QUANTITIES[name].effect)
        if effect is None:
            continue
        if effect.name not in asked:
            open_ |= set(effect.reads(setup))
        asked.setdefault(effect.name, set()).add(name)
    return {name: frozenset(asked[name]) for name in EFFECTS if name in asked}

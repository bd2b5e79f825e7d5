"""Effects compute quantities; a plan runs only the effects that are needed."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from camopt.core.numerics.identity_key import IdentityKey
from camopt.core.quantities import QUANTITIES, Quantity, in_column_order
from camopt.model.effects import (
    clearance,
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
    self_crossing,
    sizes,
    solid,
    surface,
    thrust,
    torque,
    transmission,
    vibration,
    wall,
)
from camopt.model.effects.contacts import per_contact_effect, single_disc_effect, worst_contact_effect
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup, SolidSizes
from camopt.model.effects.effect_numbers import ContactBodies, FollowerDynamics, SceneNumbers, ToleranceBands
from camopt.model.effects.quantity_expression import expression_effect

__all__ = [
    "EFFECTS",
    "ContactBodies",
    "Effect",
    "EvaluationBlock",
    "FollowerDynamics",
    "SceneNumbers",
    "Setup",
    "SolidSizes",
    "ToleranceBands",
    "available_quantities",
    "find_effect",
    "find_quantity",
    "missing_keys_by_quantity",
    "plan_effects",
    "require_effect",
    "setup_effects",
    "with_read_quantities",
]

_ONE_CONTACT_EFFECTS = {
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
        self_crossing.EFFECT,
    )
}
"""Every effect as it is written, for a follower that one cam touches."""


def _add_columns(case: EvaluationBlock, wanted: frozenset[str], known: dict[str, Any]) -> None:
    """Add columns of a case of one contact, and all that they need, to those that are known."""
    for name, needed in plan_effects(wanted, case.setup).items():
        for run in (
            (_ONE_CONTACT_EFFECTS[name].run_on_pitch, _ONE_CONTACT_EFFECTS[name].run)
            if needed - known.keys()
            else ()
        ):
            bounded = {key: value for key, value in known.items() if isinstance(value, EnclosedValue)}
            columns = known | {key: value.value for key, value in bounded.items()}
            outward = {key: value.outward for key, value in bounded.items()}
            found = run(replace(case, columns=columns, outward=outward), frozenset(needed))
            known |= {key: value for key, value in found.items() if key in needed}


def _for_any_drive(effect: Effect) -> Effect:
    """An effect for followers with any drive."""
    if effect.is_per_contact:
        return worst_contact_effect(effect, _add_columns)
    return single_disc_effect(effect) if effect.is_single_disc else effect


_PAIR_EFFECT = per_contact_effect(_ONE_CONTACT_EFFECTS, _add_columns)
EFFECTS: dict[str, Effect] = {e.name: _for_any_drive(e) for e in (*_ONE_CONTACT_EFFECTS.values(), _PAIR_EFFECT)}
"""Every effect by name, cheapest first: the order in which they run."""


def find_quantity(name: str, setup: Setup) -> Quantity:
    """A quantity by name: one of the scene's own, or one that every scene has."""
    return setup.own_quantities[name] if name in setup.own_quantities else QUANTITIES[name]


def setup_effects(setup: Setup) -> Mapping[str, Effect]:
    """Every effect of a setup by name: those of all scenes, then those of the scene's own quantities."""
    return (
        EFFECTS | {each.name: each for each in _own_quantity_effects(IdentityKey(setup)).values()}
        if setup.own_quantities
        else EFFECTS
    )


def find_effect(name: str, setup: Setup) -> Effect | None:
    """The effect that computes a quantity; None of a verdict."""
    return (
        _own_quantity_effects(IdentityKey(setup))[name]
        if name in setup.own_quantities
        else EFFECTS.get(QUANTITIES[name].effect)
    )


def require_effect(name: str, setup: Setup) -> Effect:
    """The effect that computes a quantity."""
    found = find_effect(name, setup)
    assert found is not None
    return found


@lru_cache(maxsize=16)
def _own_quantity_effects(same: IdentityKey[Setup]) -> Mapping[str, Effect]:
    """The effect of each of the scene's own quantities; one that reads what is computed last is last too."""
    found: dict[str, Effect] = {}
    for name, each in same.value.own_quantities.items():
        read = [found.get(read) or EFFECTS[QUANTITIES[read].effect] for read in each.reads]
        found[name] = expression_effect(each, last=any(effect.last for effect in read))
    return found


def with_read_quantities(names: Iterable[str], setup: Setup) -> frozenset[str]:
    """Some quantities, and all that those of the scene's own among them read."""
    found = set(names)
    for each in reversed([*setup.own_quantities.values()]):
        if each.name in found:
            found.update(each.reads)
    return frozenset(found)


def available_quantities(setup: Setup) -> tuple[str, ...]:
    """All quantities of a setup for which the scene gives enough values, in the order of the columns."""
    return _find_available_quantities(IdentityKey(setup))


@lru_cache(maxsize=16)
def _find_available_quantities(same: IdentityKey[Setup]) -> tuple[str, ...]:
    names = {name for effect in EFFECTS.values() for name in effect.offers(same.value)}
    names -= missing_keys_by_quantity(same.value).keys()
    for each in same.value.own_quantities.values():
        names |= {each.name} if names.issuperset(each.reads) else set()
    return tuple(in_column_order(names))


def missing_keys_by_quantity(setup: Setup) -> Mapping[str, tuple[str, ...]]:
    """The keys that the scene lacks, for each quantity that a setup would have with them."""
    return _find_missing_keys(IdentityKey(setup))


@lru_cache(maxsize=16)
def _find_missing_keys(same: IdentityKey[Setup]) -> Mapping[str, tuple[str, ...]]:
    found = {name: keys for effect in EFFECTS.values() for name, keys in effect.lacks(same.value).items()}
    for each in same.value.own_quantities.values():
        if keys := [key for read in each.reads for key in found.get(read, ())]:
            found[each.name] = tuple(dict.fromkeys(keys))
    return found


def plan_effects(wanted: Iterable[str], setup: Setup) -> Mapping[str, frozenset[str]]:
    """The quantities needed of each effect, by its name, in the order in which effects run."""
    return _plan_sorted_effects(frozenset(wanted), IdentityKey(setup))


@lru_cache(maxsize=16)
def _plan_sorted_effects(wanted: frozenset[str], same: IdentityKey[Setup]) -> Mapping[str, frozenset[str]]:
    setup, asked, open_ = same.value, dict[str, set[str]](), set(wanted)
    while open_:
        name = open_.pop()
        effect = find_effect(name, setup)
        if effect is None:
            continue
        if effect.name not in asked:
            open_ |= set(effect.reads(setup))
        asked.setdefault(effect.name, set()).add(name)
    return {name: frozenset(asked[name]) for name in setup_effects(setup) if name in asked}

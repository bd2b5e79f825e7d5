"""Effects compute quantities; a plan runs only those that the wanted quantities need."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from camopt.core.numerics.identity_cache import cached_by_identity
from camopt.core.quantities import QUANTITIES, Quantity, in_column_order
from camopt.model.effects import (
    bore_wall_thickness,
    clearance,
    contact_distance,
    curvature,
    flat_face_diameter,
    flat_face_reach,
    force,
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
)
from camopt.model.effects.contacts import effect_of_single_discs_only, per_contact_effect, worst_contact_effect
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
    "quantities_to_compute_by_effect",
    "quantities_with_expression_inputs",
    "require_effect",
    "setup_effects",
]

_ONE_CONTACT_EFFECTS = {
    effect.name: effect
    for effect in (
        sizes.EFFECT,
        contact_distance.EFFECT,
        bore_wall_thickness.EFFECT,
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
        flat_face_reach.EFFECT,
        rib.EFFECT,
        flat_face_diameter.EFFECT,
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
"""Every effect by name, as written for a follower with one contact."""


def _add_columns(case: EvaluationBlock, wanted_quantities: frozenset[str], known_columns: dict[str, Any]) -> None:
    """Add the wanted columns of one contact, and all that they need, to ``known_columns``."""
    for name, needed in quantities_to_compute_by_effect(wanted_quantities, case.setup).items():
        effect = _ONE_CONTACT_EFFECTS[name]
        for run in (
            (effect.evaluate_pitch_curve_columns, effect.evaluate_columns) if needed - known_columns.keys() else ()
        ):
            enclosed = {key: value for key, value in known_columns.items() if isinstance(value, EnclosedValue)}
            columns = known_columns | {key: value.value for key, value in enclosed.items()}
            outward = {key: value.outward for key, value in enclosed.items()}
            results = run(replace(case, columns=columns, outward=outward), frozenset(needed))
            known_columns |= {key: value for key, value in results.items() if key in needed}


EFFECTS: dict[str, Effect] = {
    effect.name: worst_contact_effect(effect, _add_columns)
    if effect.is_per_contact
    else effect_of_single_discs_only(effect)
    if effect.is_single_disc
    else effect
    for effect in (*_ONE_CONTACT_EFFECTS.values(), per_contact_effect(_ONE_CONTACT_EFFECTS, _add_columns))
}
"""Every effect by name, in the order in which effects run: the cheapest first."""


def find_quantity(name: str, setup: Setup) -> Quantity:
    """A quantity by name: one that the scene defines, or one that camopt has."""
    return setup.own_quantities[name] if name in setup.own_quantities else QUANTITIES[name]


def setup_effects(setup: Setup) -> Mapping[str, Effect]:
    """Every effect of a setup by name: those of all scenes, then those of quantities that the scene defines."""
    if not setup.own_quantities:
        return EFFECTS
    return EFFECTS | {effect.name: effect for effect in _scene_defined_effects(setup).values()}


def find_effect(name: str, setup: Setup) -> Effect | None:
    """The effect that computes a quantity; None for a verdict."""
    return (
        _scene_defined_effects(setup)[name]
        if name in setup.own_quantities
        else EFFECTS.get(QUANTITIES[name].effect)
    )


def require_effect(name: str, setup: Setup) -> Effect:
    effect = find_effect(name, setup)
    assert effect is not None
    return effect


@cached_by_identity(maxsize=16)
def _scene_defined_effects(setup: Setup) -> Mapping[str, Effect]:
    """The effects of quantities that the scene defines; one that reads a late quantity is late too."""
    effects: dict[str, Effect] = {}
    for name, quantity in setup.own_quantities.items():
        sources = [effects.get(read) or EFFECTS[QUANTITIES[read].effect] for read in quantity.quantities_read]
        effects[name] = expression_effect(quantity, runs_last=any(effect.last for effect in sources))
    return effects


def quantities_with_expression_inputs(names: Iterable[str], setup: Setup) -> frozenset[str]:
    """Some quantities, with all that the scene's definitions of them read."""
    quantities = set(names)
    for own in reversed([*setup.own_quantities.values()]):
        if own.name in quantities:
            quantities.update(own.quantities_read)
    return frozenset(quantities)


@cached_by_identity(maxsize=16)
def available_quantities(setup: Setup) -> tuple[str, ...]:
    """All quantities that can be computed from what the scene gives, in the order of columns."""
    names = {name for effect in EFFECTS.values() for name in effect.applicable_quantities(setup)}
    names -= missing_keys_by_quantity(setup).keys()
    for each in setup.own_quantities.values():
        names |= {each.name} if names.issuperset(each.quantities_read) else set()
    return tuple(in_column_order(names))


@cached_by_identity(maxsize=16)
def missing_keys_by_quantity(setup: Setup) -> Mapping[str, tuple[str, ...]]:
    """The missing keys of the scene, by the quantity that cannot be computed without them."""
    missing = {
        name: keys for effect in EFFECTS.values() for name, keys in effect.missing_keys_by_quantity(setup).items()
    }
    for quantity in setup.own_quantities.values():
        if keys := [key for read in quantity.quantities_read for key in missing.get(read, ())]:
            missing[quantity.name] = tuple(dict.fromkeys(keys))
    return missing


def quantities_to_compute_by_effect(wanted_quantities: Iterable[str], setup: Setup) -> Mapping[str, frozenset[str]]:
    """The quantities that each effect has to compute, by its name, in the order in which effects run."""
    return _cached_quantities_by_effect(setup, frozenset(wanted_quantities))


@cached_by_identity(maxsize=16)
def _cached_quantities_by_effect(setup: Setup, wanted_quantities: frozenset[str]) -> Mapping[str, frozenset[str]]:
    plan, pending = dict[str, set[str]](), set(wanted_quantities)
    while pending:
        name = pending.pop()
        effect = find_effect(name, setup)
        if effect is None:
            continue
        if effect.name not in plan:
            pending |= set(effect.input_quantities(setup))
        plan.setdefault(effect.name, set()).add(name)
    return {name: frozenset(plan[name]) for name in setup_effects(setup) if name in plan}

"""Notes on a scene: unusual values, unused values, outputs that lack data, constant objectives."""

from collections.abc import Mapping

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.scene_numbers import NUMBERS, PRESS_EFFECTS
from camopt.model.effects import (
    EFFECTS,
    available_quantities,
    find_quantity,
    missing_keys_by_quantity,
    quantities_to_compute_by_effect,
    require_effect,
)
from camopt.model.effects.contacts import CONTACT_NAMES, CONTACT_QUANTITIES
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.settings import law_pair_by_programme
from camopt.scene.scene import Scene
from camopt.scene.train import CARRIED_KEYS
from camopt.scene.unusual_values import unusual_value_notes

MASS_KEYS = ("follower.dynamics.mass", "follower.dynamics.inertia")
PRESSING_NUMBERS = tuple(each.name for each in NUMBERS if each.read_by == PRESS_EFFECTS)
READING_EFFECTS = {each.name: each.read_by for each in NUMBERS if each.read_by} | dict.fromkeys(
    ("cam", "follower"), ("hertz", "surface")
)
"""The effects that read each key of ``[follower.dynamics]`` and ``[materials]``."""


def notes_on_scene(scene: Scene) -> tuple[str, ...]:
    """Sentences on unusual and unused values of a scene, and on data that its outputs lack."""
    return (*unusual_value_notes(scene), *unused_value_notes(scene), *empty_output_notes(scene))


def notes_on_search(scene: Scene) -> tuple[str, ...]:
    """The sentences of ``notes_on_scene``, and one on objectives that are equal for all designs."""
    return (*notes_on_scene(scene), *constant_objective_notes(scene))


def unused_value_notes(scene: Scene) -> list[str]:
    """Sentences on values that no requested quantity uses, with the effects that would use them."""
    problem = resolve(scene)
    setup = problem.setup
    running, offers = (
        quantities_to_compute_by_effect(problem.evaluated_quantities, setup),
        frozenset(available_quantities(setup)),
    )
    massless = missing_keys_by_quantity(setup.with_numbers(dict.fromkeys(MASS_KEYS)))

    def does_effect_read_key(effect: str, key: str, names: frozenset[str]) -> bool:
        """Whether some of the quantities of an effect read a key; only loads read pressing forces."""
        here = {name for name in names if name in QUANTITIES and _effect_of_quantity(name) == effect}
        return bool(here & massless.keys() if key in PRESSING_NUMBERS or effect == "surface" else here)

    evaluated = frozenset(name for names in running.values() for name in names)
    idle = [
        key
        for key in _used_dynamics_and_material_keys(scene)
        if not any(does_effect_read_key(effect, key, evaluated) for effect in READING_EFFECTS[key])
    ]
    able = {
        key: [effect for effect in READING_EFFECTS[key] if does_effect_read_key(effect, key, offers)]
        for key in idle
    }
    effects = [name for name in EFFECTS if any(name in users for users in able.values())]
    sentences = []
    if ready := [key for key in idle if able[key]]:
        them, do = ("them", "they do") if len(ready) > 1 else ("it", "it does")
        shown = f"--outputs {','.join(effects)} shows what {do}"
        sentences.append(f"{', '.join(ready)}: no limit, objective or output uses {them}; {shown}")
    if short := [key for key in idle if not able[key]]:
        sentences.append(
            f"{', '.join(short)}: not used{_missing_keys_text(short, missing_keys_by_quantity(setup))}"
        )
    return sentences


def _effect_of_quantity(name: str) -> str:
    """The effect that computes a quantity, or the quantity of one contact."""
    place, _, each = name.partition("_")
    return QUANTITIES[each if place in CONTACT_NAMES and each in CONTACT_QUANTITIES else name].effect


def empty_output_notes(scene: Scene) -> list[str]:
    """Sentences on requested effects without a result, with the keys that they lack."""
    setup = resolve(scene).setup
    shown, lacks = (
        {find_quantity(name, setup).effect for name in available_quantities(setup)},
        missing_keys_by_quantity(setup),
    )
    sentences = []
    for effect in dict.fromkeys(scene.outputs):
        needs = [keys for name, keys in lacks.items() if find_quantity(name, setup).effect == effect]
        if needs and effect not in shown:
            carried = any(getattr(stage, key) for stage in scene.train for key in CARRIED_KEYS)
            also = "; masses and forces of the train alone are not enough" if carried else ""
            sentences.append(
                f"outputs: {effect} shows nothing without {', '.join(sorted(needs, key=len)[0])}{also}"
            )
    return sentences


def constant_objective_notes(scene: Scene) -> list[str]:
    """A sentence on objectives that have the same value in all designs of a sweep.

    These are sizes that ``[search]`` does not vary and, with one motion at one speed, quantities of the motion.
    """
    problem = resolve(scene)
    fixed = {each.quantity for each in problem.variables if not each.is_searched}
    moving = len(law_pair_by_programme(problem)) > 1 or problem.search_space.numbers
    same = [
        name
        for name in problem.objectives
        if name in fixed or (not moving and require_effect(name, problem.setup).is_of_motion(problem.setup))
    ]
    has = "has" if len(same) == 1 else "have"
    return [f"objectives: {', '.join(same)} {has} no effect: all designs have the same value"] if same else []


def _used_dynamics_and_material_keys(scene: Scene) -> list[str]:
    """The keys of ``[follower.dynamics]`` and ``[materials]`` with a value other than 0, or with a choice."""
    tables = (scene.follower.dynamics, scene.materials)
    given = [key for table in tables if table for key, value in table if value is not None and value != 0.0]
    varied = [key.rpartition(".")[2] for key in scene.search.numbers]
    return list(dict.fromkeys([*given, *(key for key in varied if key in READING_EFFECTS)]))


def _missing_keys_text(unused_keys: list[str], missing_keys_by_name: Mapping[str, tuple[str, ...]]) -> str:
    """The fewest missing keys of a quantity that reads some of the keys, as the end of a sentence."""
    effects = {effect for key in unused_keys for effect in READING_EFFECTS[key]}
    known = {name: QUANTITIES[name].effect for name in missing_keys_by_name if name in QUANTITIES}
    wanting = [tuple(missing_keys_by_name[name]) for name, effect in known.items() if effect in effects]
    pressed = [needs for needs in wanting if any(n.endswith((".mass", ".inertia")) for n in needs)]
    chosen = pressed if set(unused_keys) <= {*PRESSING_NUMBERS} and pressed else wanting
    return f" without {', '.join(sorted(chosen, key=len)[0])}" if chosen else " with this follower"

"""Values of dynamics and materials that nothing reads, wanted effects that lack data, constant objectives."""

from collections.abc import Mapping

from camopt.core.quantities import QUANTITIES
from camopt.core.quantities.scene_numbers import NUMBERS, PRESSED
from camopt.model.effects import EFFECTS, effect_of, effects_needed, lacking, offered, quantity_of
from camopt.model.effects.contacts import OF_EACH, PLACES
from camopt.scene.oddities import oddities
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.settings import laws_of
from camopt.scene.scene import Scene
from camopt.scene.train import CARRIED

MASSES = ("follower.dynamics.mass", "follower.dynamics.inertia")
PRESSING = tuple(each.name for each in NUMBERS if each.read_by == PRESSED)
READERS = {each.name: each.read_by for each in NUMBERS if each.read_by} | dict.fromkeys(
    ("cam", "follower"), ("hertz", "surface")
)
"""The effects that read each key of ``[follower.dynamics]`` and ``[materials]``."""


def notes_of(scene: Scene) -> tuple[str, ...]:
    """Sentences on what of a scene is odd, what of it nothing called for, and what its outputs lack."""
    return (*oddities(scene), *unused(scene), *unanswered(scene))


def notes_of_search(scene: Scene) -> tuple[str, ...]:
    """Sentences as of ``notes_of``, and on objectives that are the same for all designs."""
    return (*notes_of(scene), *constant_objectives(scene))


def unused(scene: Scene) -> list[str]:
    """Sentences on values that nothing reads: the keys, and the effects that would use them."""
    problem = resolve(scene)
    setup = problem.setup
    running, offers = effects_needed(problem.wanted, setup), frozenset(offered(setup))
    massless = lacking(setup.with_numbers(dict.fromkeys(MASSES)))

    def reads(effect: str, key: str, names: frozenset[str]) -> bool:
        """Whether some quantities of an effect read a key; only loads read what presses on the cam."""
        here = {name for name in names if name in QUANTITIES and _effect_of(name) == effect}
        return bool(here & massless.keys() if key in PRESSING or effect == "surface" else here)

    asked = frozenset(name for names in running.values() for name in names)
    idle = [key for key in _given(scene) if not any(reads(effect, key, asked) for effect in READERS[key])]
    able = {key: [effect for effect in READERS[key] if reads(effect, key, offers)] for key in idle}
    effects = [name for name in EFFECTS if any(name in users for users in able.values())]
    sentences = []
    if ready := [key for key in idle if able[key]]:
        them, do = ("them", "they do") if len(ready) > 1 else ("it", "it does")
        shown = f"--outputs {','.join(effects)} shows what {do}"
        sentences.append(f"{', '.join(ready)}: no limit, objective or output uses {them}; {shown}")
    if short := [key for key in idle if not able[key]]:
        sentences.append(f"{', '.join(short)}: not used{_for_want(short, lacking(setup))}")
    return sentences


def _effect_of(name: str) -> str:
    """The effect that finds a quantity; of one that is told of each contact, that which finds it there."""
    place, _, each = name.partition("_")
    return QUANTITIES[each if place in PLACES and each in OF_EACH else name].effect


def unanswered(scene: Scene) -> list[str]:
    """Sentences on wanted effects without a result: the keys that they lack."""
    setup = resolve(scene).setup
    shown, lacks = {quantity_of(name, setup).effect for name in offered(setup)}, lacking(setup)
    sentences = []
    for effect in dict.fromkeys(scene.outputs):
        needs = [keys for name, keys in lacks.items() if quantity_of(name, setup).effect == effect]
        if needs and effect not in shown:
            carried = any(getattr(stage, key) for stage in scene.train for key in CARRIED)
            also = ", and does not count what the train carries alone" if carried else ""
            sentences.append(
                f"outputs: {effect} shows nothing without {', '.join(sorted(needs, key=len)[0])}{also}"
            )
    return sentences


def constant_objectives(scene: Scene) -> list[str]:
    """A sentence on the objectives that have the same value in all designs of a sweep.

    They are sizes that ``[search]`` does not vary, and what the motion alone decides, where there is one motion at
    one speed.
    """
    problem = resolve(scene)
    fixed = {each.quantity for each in problem.variables if not each.is_searched}
    moving = len(laws_of(problem)) > 1 or problem.choices.numbers
    same = [
        name
        for name in problem.objectives
        if name in fixed or (not moving and effect_of(name, problem.setup).is_of_motion(problem.setup))
    ]
    decide = "decides" if len(same) == 1 else "decide"
    return [f"objectives: {', '.join(same)} {decide} nothing, being the same for all designs"] if same else []


def _given(scene: Scene) -> list[str]:
    """The keys of ``[follower.dynamics]`` and ``[materials]`` that a scene gives, but for zeros, or varies."""
    tables = (scene.follower.dynamics, scene.materials)
    given = [key for table in tables if table for key, value in table if value is not None and value != 0.0]
    varied = [key.rpartition(".")[2] for key in scene.search.numbers]
    return list(dict.fromkeys([*given, *(key for key in varied if key in READERS)]))


def _for_want(keys: list[str], lacks: Mapping[str, tuple[str, ...]]) -> str:
    """The fewest keys that would make one of the quantities that read some keys computable."""
    effects = {effect for key in keys for effect in READERS[key]}
    known = {name: QUANTITIES[name].effect for name in lacks if name in QUANTITIES}
    wanting = [tuple(lacks[name]) for name, effect in known.items() if effect in effects]
    pressed = [needs for needs in wanting if any(n.endswith((".mass", ".inertia")) for n in needs)]
    chosen = pressed if set(keys) <= {*PRESSING} and pressed else wanting
    return f" without {', '.join(sorted(chosen, key=len)[0])}" if chosen else " with this follower"

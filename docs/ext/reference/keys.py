"""The keys of scenes and machines, out of their tables: sentence, unit, what each allows and what needs it."""

import json
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from itertools import product

from camopt import BadInput, Scene
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.model.effects import missing_keys_by_quantity
from camopt.model.mechanisms import Mechanism
from camopt.model.mechanisms.elements import Tip
from camopt.scene.keys import KeyDescription, keys_of_table
from camopt.scene.machine import MACHINE_TABLES
from camopt.scene.materials import MATERIALS
from camopt.scene.problem.limits import Limit
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.scene_notes import READING_EFFECTS
from camopt.scene.scene import SCENE_TABLES
from camopt.scene.scene_templates import PAIRINGS, further_key_examples_by_table, minimal_scene_tables
from camopt.scene.table_places import TOP_TABLE, table_heading

from .markdown import entry, prose, table

ORDER = [
    place
    for name in Scene.model_fields
    if name != "limits"
    for place in SCENE_TABLES
    if place.split(".")[0] == name
]
"""The tables, each with those in it after it; ``limits`` have a page of their own."""


def needed_by(place: str, key: str) -> str:
    """What reads a key: effects, or the followers that have such a size."""
    if place in ("follower.dynamics", "materials"):
        readers = READING_EFFECTS[key]
        return ", ".join(f"[{effect}](quantities.md#{effect})" for effect in readers)
    if place == "follower":
        having = [name for name, (mechanism, tip) in PAIRINGS.items() if key in mechanism.follower_size_keys(tip)]
        return "; ".join(having)
    return ""


def facts_of(key: KeyDescription) -> str:
    """What a key is, its unit, what it allows, and what it is if not given."""
    gives = f"; `{json.dumps(key.default)}` if not given" if key.default is not None else ""
    gives = "; needed" if key.needed else gives
    return " ".join([key.sentence, *([f"**{key.unit}**."] if key.unit else []), f"Allowed: {key.allowed}{gives}."])


def entries(place: str) -> Iterator[str]:
    """The keys of a table, each an entry."""
    for key in keys_of_table(place):
        users = needed_by(place, key.key.rpartition(".")[2])
        yield from entry("key", [key.key], facts_of(key) + (f" Used by {users}." if users else ""))


def of_scene() -> Iterator[str]:
    """All tables of a scene but the limits."""
    yield "## At the top"
    yield from entries(TOP_TABLE)
    for place in ORDER:
        label = f"(table-{place.replace('.', '-').lower()})="
        yield from ("", label, f"## {table_heading(place)}", "", prose(SCENE_TABLES[place].__doc__))
        yield from entries(place)


def of_machine() -> Iterator[str]:
    """All tables of a machine."""
    for place, model in MACHINE_TABLES.items():
        if place:
            yield from ("", f"(machine-table-{place})=", f"## {table_heading(place)}", "", prose(model.__doc__))
        else:
            yield "## At the top"
        for key in keys_of_table(place, tables=MACHINE_TABLES):
            yield from entry("key", [f"machine.{key.key}"], facts_of(key))


def materials() -> Iterator[str]:
    """The materials that scenes name."""
    rows = [(f"`{name}`", f"{m.modulus:g}", f"{m.poisson:g}", f"{m.density:g}") for name, m in MATERIALS.items()]
    return table(("material", "Young's modulus, GPa", "Poisson's ratio", "density, kg/m³"), rows)


# ------------------------------------------------------------------------------------ scenes that give everything


def scene_of(mechanism: Mechanism, tip: Tip, *, full: bool) -> Scene:
    """A cam with a follower of a kind: its sizes alone, or all that a scene can give."""
    plain = Scene.from_dict(minimal_scene_tables(mechanism, tip))
    if not full:
        return plain
    more, needed = further_key_examples_by_table(plain), ("thickness", "bore", *mechanism.body.solid)
    part = {f"part.{key}": more["part"][key] for key in needed}
    tables = {name: more[name] for name in ("follower.dynamics", "drive", "materials")}
    return plain.replace(**{"cam.rpm": 300}, **tables, **part)


@cache
def missing() -> dict[str, set[str]]:
    """What each quantity needs besides sizes and motion: keys, for any of the mechanisms."""
    found: dict[str, set[str]] = {}
    for mechanism, tip in PAIRINGS.values():
        for name, needs in missing_keys_by_quantity(resolve(scene_of(mechanism, tip, full=False)).setup).items():
            found.setdefault(name, set()).update(needs)
    return found


ERRORS = {"tolerances.profile": 0.02, "tolerances.waves": 9}
"""What limits on errors need."""


@cache
def limits() -> dict[str, list[Limit]]:
    """Every limit by its key, as it is for each mechanism that may have it."""
    found: dict[str, list[Limit]] = {key: [] for key in LIMIT_KEYS}
    for (mechanism, tip), key in product(PAIRINGS.values(), found):
        with suppress(BadInput):  # this follower has no such limit
            scene = scene_of(mechanism, tip, full=True).replace(
                limits={key: 0.5}, **ERRORS if key.endswith("_error") else {}
            )
            found[key] += [limit for limit in resolve(scene).limits if limit.name == key]
    return found


def of_limits() -> Iterator[str]:
    """The keys of ``[limits]``, each with the quantities that it is compared with."""
    for key in keys_of_table("limits", LIMIT_KEYS):
        each = limits()[key.key.removeprefix("limits.")]
        relation = each[0].relation
        compared = dict.fromkeys(name for limit in each for name in limit.shown_quantities)
        columns = ", ".join(f"{{quantity}}`{name}`" for name in compared)
        words = {"±": "magnitude at most the bound", "≤": "at most the bound", "≥": "at least the bound"}
        yield from entry("key", [key.key], f"{facts_of(key)} Compares {columns}: {words[relation]}.")

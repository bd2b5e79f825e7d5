"""The keys of a scene, out of its tables: what each is, its unit, what it allows and what needs it."""

import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from itertools import product
from typing import Any

from sphinx.pycode import ModuleAnalyzer

from camopt import BadInput, Scene
from camopt.effects import lacking
from camopt.mechanisms import MECHANISMS, Mechanism
from camopt.mechanisms.follower import Tip
from camopt.problem.limits import Limit
from camopt.problem.problem import resolve
from camopt.problem.unused import READERS
from camopt.scene.choices import Range
from camopt.scene.materials import MATERIALS
from camopt.scene.tables import Dynamics, Element, OwnLaw, Segment, ShortLimits, Table, Through

from .markdown import code, digits, entry, prose, table

PAIRINGS = {
    f"{mechanism.body.form}, {mechanism.motion.name} {tip.name}": (mechanism, tip)
    for mechanism in MECHANISMS.values()
    for tip in mechanism.tips
}
PLACES: dict[str, tuple[type[Table], str]] = {
    **{
        name: (field.annotation, f"[{name}]")  # type: ignore[dict-item]
        for name, field in Scene.model_fields.items()
        if isinstance(field.annotation, type) and issubclass(field.annotation, Table)
    },
    "follower.dynamics": (Dynamics, "[follower.dynamics]"),
    "motion": (Segment, "[[motion]]"),
    "motion.through": (Through, "[[motion.through]]"),
    "profile": (Element, "[[profile]]"),
    "laws.NAME": (OwnLaw, "[laws.NAME]"),
    "search.KEY": (Range, "[search.KEY]"),
}
"""Every table by where it stands in a scene, with its heading there. ``limits`` have a page of their own."""
ORDER = ("cam", "follower", "follower.dynamics", "motion", "motion.through", "profile", "laws.NAME", "search")
ORDER += ("search.KEY", "synthesis", "materials", "part", "accuracy")


def said_of(model: type[Table], key: str) -> tuple[str, str]:
    """What the docstring of a key says, and the unit that it ends with; "" where it has none."""
    home = next(base for base in model.__mro__ if key in vars(base).get("__annotations__", {}))
    lines = ModuleAnalyzer.for_module(home.__module__).find_attr_docs()[home.__name__, key]
    text = " ".join(lines).strip().removesuffix(".")
    sentence, mark, unit = text.rpartition("; ")
    return (sentence, unit) if mark else (text, "")


def allowed(schema: dict[str, Any]) -> str:
    """What a JSON schema allows, in words."""
    match schema:
        case {"anyOf": kinds} | {"oneOf": kinds}:
            return " or ".join(allowed(kind) for kind in kinds if kind.get("type") != "null")
        case {"enum": values}:
            return code(f'"{value}"' for value in values)
        case {"$ref": target}:
            return f"a table of {target.rpartition('/')[2]}"
        case {"type": "array", "prefixItems": items}:
            return f"[{', '.join(allowed(item) for item in items)}]"
        case {"type": "array", "items": item}:
            return f"a list of: {allowed(item)}" if item else "rows"
        case {"type": "object"}:
            return "a table"
        case {"type": "number" | "integer" as kind}:
            return f"{'a whole number' if kind == 'integer' else 'a number'}{between(schema)}"
        case {"type": "boolean"}:
            return "true or false"
    return "a text"


def between(schema: dict[str, Any]) -> str:
    """The bounds of a number in words."""
    least, most, below = (
        schema.get(word, schema.get(short))  # pydantic writes the short ones beside a validator
        for word, short in (("minimum", "ge"), ("maximum", "le"), ("exclusiveMaximum", "lt"))
    )
    words = [f"from {digits(least)}"] if least is not None else []
    words += [f"to {digits(most)}"] if most is not None else [f"below {digits(below)}"] if below is not None else []
    return " ".join(["", *words])


def needed_by(place: str, key: str) -> str:
    """What reads a key: effects, or the followers that have such a size."""
    if place in ("follower.dynamics", "materials"):
        return ", ".join(f"[{effect}](quantities.md#{effect})" for effect in READERS[key])
    if place == "follower":
        having = [name for name, (mechanism, tip) in PAIRINGS.items() if key in mechanism.follower_keys(tip)]
        return "; ".join(having)
    return ""


def keys_of(place: str, names: Iterable[str] = ()) -> Iterator[str]:
    """The keys of a table, each an entry."""
    model = PLACES[place][0] if place else Scene
    properties = model.model_json_schema()["properties"]
    for key in names or model.model_fields:
        sentence, unit = said_of(model, key)
        schema, field = properties[key], model.model_fields[key]
        default = schema.get("default")
        gives = f"; `{json.dumps(default)}` if not given" if default not in (None, []) else ""
        gives = "; needed" if field.is_required() else gives
        facts = [f"{sentence}.", f"**{unit}**." if unit else "", f"Allowed: {allowed(schema)}{gives}."]
        if users := needed_by(place, key):
            facts.append(f"Used by {users}.")
        yield from entry("key", [f"{place}.{key}" if place else key], " ".join(filter(None, facts)))


def of_scene() -> Iterator[str]:
    """All tables of a scene but the limits."""
    yield "## At the top"
    yield from keys_of("", ("name", "outputs"))
    for place in ORDER:
        model, heading = PLACES[place]
        yield from ("", f"(table-{place.replace('.', '-').lower()})=", f"## {heading}", "", prose(model.__doc__))
        yield from keys_of(place)


def materials() -> Iterator[str]:
    """The materials that scenes name."""
    rows = [(f"`{name}`", f"{m.modulus:g}", f"{m.poisson:g}", f"{m.density:g}") for name, m in MATERIALS.items()]
    return table(("material", "Young's modulus, GPa", "Poisson's ratio", "density, kg/m³"), rows)


# ------------------------------------------------------------------------------------ scenes that give everything

TURN = [
    {"segment": "rise", "angle": 120, "lift": 10, "law": "cycloidal"},
    {"segment": "dwell", "angle": 60},
    {"segment": "return", "angle": 120, "lift": 10, "law": "cycloidal"},
    {"segment": "dwell", "angle": 60},
]
SIZE = {"roller_radius": 10, "face_radius": 10, "arm_length": 80, "centre_distance": 100, "face_offset": 10}
COMMON = {"spring_rate": 5, "preload": 100, "damping": 0.01, "natural_frequency": 200, "damping_ratio": 0.05}
COMMON |= {"fluctuation": 0.02, "lash": 0.2, "lash_variation": 0.1}
GUIDE = {"mass": 0.5, "guide_length": 60, "overhang": 60, "friction": 0.1, "stem_diameter": 12}
SWUNG = {"inertia": 0.01}
SOLID = {"thickness": 20, "groove_depth": 8}
BODIES = {"cam": "steel", "follower": "steel", "face_width": 15, "wear_rate": 1e-10, "viscosity": 0.05}
BODIES |= {"pressure_viscosity": 20, "roughness": 0.4}


def scene_of(mechanism: Mechanism, tip: Tip, *, full: bool) -> Scene:
    """A cam with a follower of a kind: its sizes alone, or all that a scene can give."""
    body, motion, own = mechanism.body, mechanism.motion, mechanism.follower_keys(tip)
    sizes = {key: value for key, value in SIZE.items() if key in own}
    data: dict[str, Any] = {
        "cam": {"form": body.form, body.size: 40},
        "follower": {"motion": motion.name, "contact": tip.name, **sizes},
        "motion": TURN,
    }
    if full:
        data["cam"]["rpm"] = 300
        data["follower"]["dynamics"] = {**COMMON, **(SWUNG if motion.angular else GUIDE)}
        data["materials"] = BODIES
        data["part"] = {"bore": 20, **{key: SOLID[key] for key in body.solid}}
    return Scene.from_dict(data)


@cache
def missing() -> dict[str, set[str]]:
    """What each quantity needs besides sizes and motion: keys, for any of the mechanisms."""
    found: dict[str, set[str]] = {}
    for mechanism, tip in PAIRINGS.values():
        for name, needs in lacking(resolve(scene_of(mechanism, tip, full=False)).setup).items():
            found.setdefault(name, set()).update(needs)
    return found


@cache
def limits() -> dict[str, list[Limit]]:
    """Every limit by its key, as it is for each mechanism that may have it."""
    found: dict[str, list[Limit]] = {key: [] for key in ShortLimits.model_fields}
    for (mechanism, tip), key in product(PAIRINGS.values(), found):
        with suppress(BadInput):  # this follower has no such limit
            scene = scene_of(mechanism, tip, full=True).replace(limits={key: 0.5})
            found[key] += [limit for limit in resolve(scene).limits if limit.name == key]
    return found


def of_limits() -> Iterator[str]:
    """The keys of ``[limits]``, each with the quantities that it is compared with."""
    properties = ShortLimits.model_json_schema()["properties"]
    for key, each in limits().items():
        sentence, unit = said_of(ShortLimits, key)
        relation = each[0].relation
        compared = dict.fromkeys(name for limit in each for name in limit.shown)
        columns = ", ".join(f"{{quantity}}`{name}`" for name in compared)
        words = {"±": "magnitude at most the bound", "≤": "at most the bound", "≥": "at least the bound"}
        facts = f"{sentence}. **{unit}**. Allowed: {allowed(properties[key])}."
        yield from entry("key", [f"limits.{key}"], f"{facts} Compares {columns}: {words[relation]}.")

"""The keys of a scene in words: sentence, unit, allowed values and default of each."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.scene.machine import MACHINE_TABLES
from camopt.scene.scene import SCENE_TABLES
from camopt.scene.schema import table_schema
from camopt.scene.table_places import TOP_TABLE, key_record
from camopt.scene.tables import SceneTable

MACHINE_KEYS = "machine"
"""The name that stands for all tables of a machine."""


class KeyDescription(NamedTuple):
    """A key of a scene in words."""

    key: str
    table: str
    unit: str
    """"" without a unit."""
    allowed: str
    default: Any
    """None without a default."""
    needed: bool
    sentence: str


def keys_of_table(
    place: str, key_names: Iterable[str] = (), tables: Mapping[str, type[SceneTable]] = SCENE_TABLES
) -> Iterator[KeyDescription]:
    """The keys of a table of a scene, or of a machine."""
    model = tables[place]
    properties = table_schema(model, tables[TOP_TABLE])
    for name in key_names or model.model_fields:
        if place != TOP_TABLE or name not in {each.split(".")[0] for each in tables}:
            record = key_record(model, name)
            field, schema = model.model_fields[name], properties[name]
            default = None if schema.get("default") in (None, []) else schema["default"]
            key = f"{place}.{name}" if place else name
            yield KeyDescription(
                key,
                place,
                record.both_units_text,
                allowed_values_in_words(schema),
                default,
                field.is_required(),
                f"{record.sentence}.",
            )


def find_keys(name: str | None = None) -> list[KeyDescription]:
    """The keys of a table, or with a name such as rpm or cam.rpm; all keys of scenes without a name.

    ``machine`` has all keys of machines. A key that scenes do not have is that of machines.

    Raises
    ------
    BadInput
        If no table and no key has the name.
    """
    named = f"{name}.NAME"  # a table of inner tables that the user names, such as laws
    if name in SCENE_TABLES or named in SCENE_TABLES:
        return [*keys_of_table(str(name) if name in SCENE_TABLES else named)]
    of_machines = [key for place in MACHINE_TABLES for key in keys_of_table(place, tables=MACHINE_TABLES)]
    if name == MACHINE_KEYS or name in MACHINE_TABLES:
        return [key for key in of_machines if name in (MACHINE_KEYS, key.table)]
    keys = [key for place in SCENE_TABLES for key in keys_of_table(place)]
    if name is None:
        return keys
    named_keys = ([key for key in group if f".{key.key}".endswith(f".{name}")] for group in (keys, of_machines))
    matching = next(filter(None, named_keys), [])
    if not matching:
        known = [
            *dict.fromkeys(
                [*filter(None, SCENE_TABLES), MACHINE_KEYS, *(key.key.rpartition(".")[2] for key in keys)]
            )
        ]
        raise BadInput([Mistake("camopt", "table", name, f"a table or a key; {suggest_names(str(name), known)}")])
    return matching


def allowed_values_in_words(schema: dict[str, Any]) -> str:
    """What a JSON schema allows, in words."""
    match schema:
        case {"anyOf": kinds}:
            free = {"type": "string"} in kinds  # any text is allowed, and the names are only suggestions
            listed = [kind for kind in kinds if "pattern" not in kind and not (free and "enum" in kind)]
            return " or ".join(map(allowed_values_in_words, listed))
        case {"enum": [_, *_] as values}:
            if len(values) > MOST_QUOTED_NAMES:
                return f"one of {len(values)} names"
            return ", ".join(f'"{value}"' for value in values)
        case {"$ref": target} | {"allOf": [{"$ref": target}]}:
            return "a range" if target.endswith("Range") else "a table"
        case {"type": "array", "items": item, "maxItems": 2}:
            return f"[{allowed_values_in_words(item)}, {allowed_values_in_words(item)}]"
        case {"type": "array", "items": item}:
            return f"a list of: {allowed_values_in_words(item)}"
        case {"type": "object"}:
            return "a table"
        case {"type": "number" | "integer" as kind}:
            return f"{'a whole number' if kind == 'integer' else 'a number'}{bounds_in_words(schema)}"
        case {"type": "boolean"}:
            return "true or false"
    return "a text"


MOST_QUOTED_NAMES = 12


def bounds_in_words(schema: dict[str, Any]) -> str:
    """The bounds of a number in words."""
    least, most, below = map(schema.get, ("minimum", "maximum", "exclusiveMaximum"))
    start = "" if least is None else f" from {short_number_text(least)}"
    if most is not None:
        return f"{start} to {short_number_text(most)}"
    return start if below is None else f"{start} below {short_number_text(below)}"


def short_number_text(value: float) -> str:
    """A number in few characters, with a true minus sign."""
    return re.sub(r"e([+-])0*", lambda match: "e" + match[1].strip("+"), f"{value:g}").replace("-", "−")

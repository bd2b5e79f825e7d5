"""The keys of a scene in words: what each is, its unit, what it allows, and what it is if not given."""

import re
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from camopt.core.mistakes import BadInput, Mistake, nearest
from camopt.scene.places import TOP, key_of
from camopt.scene.schema import TABLES, table_schema


class KeyInWords(NamedTuple):
    """A key of a scene, as people read of it."""

    key: str
    table: str
    unit: str
    """"" where it has none to say."""
    allowed: str
    default: Any
    """None where there is none."""
    needed: bool
    sentence: str


def keys_of(place: str, names: Iterable[str] = ()) -> Iterator[KeyInWords]:
    """The keys of a table."""
    model = TABLES[place]
    properties = table_schema(place)
    for name in names or model.model_fields:
        if place != TOP or name not in {each.split(".")[0] for each in TABLES}:
            record = key_of(model, name)
            field, schema = model.model_fields[name], properties[name]
            default = None if schema.get("default") in (None, []) else schema["default"]
            key = f"{place}.{name}" if place else name
            yield KeyInWords(
                key, place, record.units, allowed(schema), default, field.is_required(), f"{record.sentence}."
            )


def found_keys(name: str | None = None) -> list[KeyInWords]:
    """The keys of a table, or those of a name, such as rpm or cam.rpm; all without one.

    Raises
    ------
    BadInput
        If there is neither such a table nor such a key.
    """
    named = f"{name}.NAME"  # a table of tables with names of the user's, as laws are
    if name in TABLES or named in TABLES:
        return [*keys_of(str(name) if name in TABLES else named)]
    keys = [key for place in TABLES for key in keys_of(place)]
    found = [key for key in keys if name is None or f".{key.key}".endswith(f".{name}")]
    if not found:
        known = [*dict.fromkeys([*filter(None, TABLES), *(key.key.rpartition(".")[2] for key in keys)])]
        raise BadInput([Mistake("camopt", "table", name, f"a table or a key; {nearest(str(name), known)}")])
    return found


def allowed(schema: dict[str, Any]) -> str:
    """What a JSON schema allows, in words."""
    match schema:
        case {"anyOf": kinds}:
            free = {"type": "string"} in kinds  # then names are only proposed; a number with a unit is a number
            told = [kind for kind in kinds if "pattern" not in kind and not (free and "enum" in kind)]
            return " or ".join(map(allowed, told))
        case {"enum": [_, *_] as values}:
            return names_of(values)
        case {"$ref": target} | {"allOf": [{"$ref": target}]}:
            return "a range" if target.endswith("Range") else "a table"
        case {"type": "array", "items": item, "maxItems": 2}:
            return f"[{allowed(item)}, {allowed(item)}]"
        case {"type": "array", "items": item}:
            return f"a list of: {allowed(item)}"
        case {"type": "object"}:
            return "a table"
        case {"type": "number" | "integer" as kind}:
            return f"{'a whole number' if kind == 'integer' else 'a number'}{between(schema)}"
        case {"type": "boolean"}:
            return "true or false"
    return "a text"


MOST_NAMES = 12


def names_of(values: list[str]) -> str:
    """Words that a key may have; of many, how many there are."""
    if len(values) > MOST_NAMES:
        return f"one of {len(values)} names"
    return ", ".join(f'"{value}"' for value in values)


def between(schema: dict[str, Any]) -> str:
    """The bounds of a number in words."""
    least, most, below = map(schema.get, ("minimum", "maximum", "exclusiveMaximum"))
    words = [f"from {digits(least)}"] if least is not None else []
    words += [f"to {digits(most)}"] if most is not None else [f"below {digits(below)}"] if below is not None else []
    return " ".join(["", *words])


def digits(value: float) -> str:
    """A number, short."""
    return re.sub(r"e([+-])0*", lambda found: "e" + found[1].strip("+"), f"{value:g}").replace("-", "−")

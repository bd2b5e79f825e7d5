"""Turn errors of pydantic about a scene into mistakes in plain words, one for each key."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from pydantic import BaseModel, ValidationError

from camopt.core.mistakes import BadInput, Mistake, suggest_names

LOCATION_TAGS = (
    "range/",
    "values/",
    "constant/",
    "file/",
    "rows/",
)  # parts of a location in pydantic's errors that are no keys


KNOWN_TABLES: dict[str, type[BaseModel]] = {}
"""Every table by its place in a scene: the module of ``Scene`` fills it."""


def mistakes_from_pydantic(
    error: ValidationError, model: type[BaseModel], prefix: str, file: str = "scene"
) -> list[Mistake]:
    """Pydantic's errors as mistakes in plain words, one for each key."""
    mistakes: dict[str, Mistake] = {}
    for each in error.errors():
        *tables, last = each["loc"] or LOCATION_TAGS[:1]
        unknown = (
            each["type"] == "extra_forbidden"
        )  # the last part is then the user's key, even if it looks like a tag
        where = (
            *(p for p in tables if p not in LOCATION_TAGS),
            *([last] if unknown or last not in LOCATION_TAGS else []),
        )
        parts = [str(p + 1) if isinstance(p, int) else p for p in where]
        key = ".".join([prefix, *parts] if prefix else parts)
        within = each.get("ctx", {}).get("error")
        if isinstance(within, BadInput):  # from an inner table, whose keys start with its class name
            for mistake in within.mistakes:
                name = ".".join([key, *mistake.key.split(".")[1:]])
                mistakes.setdefault(name, replace(mistake, file=file, key=name))
        elif each["type"] != "too_short" or not each["input"]:  # a list of wrong items is not too short
            mistakes.setdefault(key, _mistake_from_error(each, str(last), model, key, file))
    return list(mistakes.values())


def _mistake_from_error(
    pydantic_error: Any, last_location: str, model: type[BaseModel], key: str, file: str
) -> Mistake:
    kind, value, context = pydantic_error["type"], pydantic_error["input"], pydantic_error.get("ctx", {})
    if kind == "extra_forbidden":
        return Mistake(file, key, value, unknown_key_message(last_location, model), bare=True)
    if kind == "missing":
        return Mistake(file, key, None, "missing", bare=True)
    if kind == "literal_error":
        return Mistake(file, key, value, f"one of {context['expected']}")
    if kind == "value_error":
        return Mistake(file, key, value, str(context["error"]))
    if kind == "too_long":
        allowed = f"has {context['actual_length']:,} entries; at most {context['max_length']:,} are allowed"
        return Mistake(file, key, None, allowed, bare=True)
    words = {
        "greater_than": "above",
        "greater_than_equal": "at least",
        "less_than": "below",
        "less_than_equal": "at most",
    }
    if kind in words:
        bound = next(iter(context.values()))
        return Mistake(file, key, value, f"{words[kind]} {bound:g}")
    plain = {
        "finite_number": "a finite number",
        "model_type": "a table",
        "dict_type": "a table",
        "model_attributes_type": "a table",
        "tuple_type": "a list",
        "string_type": "a text",
        "string_unicode": "a text",
        "too_short": "a list of at least one value",
    }
    return Mistake(file, key, value, plain.get(kind, pydantic_error["msg"].lower()))


def unknown_key_message(name: str, model: type[BaseModel], further_known_keys: Iterable[str] = ()) -> str:
    """The message for a key that a table does not have; ``further_known_keys`` are further known keys.

    It names the only key with this last part, outside tables that repeat names of others.
    """
    tables = [place for place in KNOWN_TABLES if place.split(".")[0] not in ("", "search", "synthesis", "train")]
    same = [f"{place}.{name}" for place in tables if name in KNOWN_TABLES[place].model_fields]
    known = (*model.model_fields, *further_known_keys)
    meant = f"did you mean {same[0]}?" if len(same) == 1 else suggest_names(name, known)
    why = f"not a known key; {meant}"
    if "." in name and name.partition(".")[0] in model.model_fields:  # a dotted key that ``nest_dotted_keys`` left
        why = "is given twice: leave one of them out"
    return str(getattr(model, "elsewhere", {}).get(name, why))

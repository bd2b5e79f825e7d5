"""A scene with mistakes as a typed one without its wrong values, for checks of what goes together."""

from collections.abc import Collection, Mapping
from functools import cache
from math import nan
from typing import Any, Literal, get_origin

from pydantic import TypeAdapter, ValidationError

from camopt.core.mistakes import BadInput
from camopt.scene.choices import StepRange
from camopt.scene.shape import members_of
from camopt.scene.tables import AnyTable, SceneTable, table_in

LEFT_OUT = object()


def sound_table(
    model: type[AnyTable], given: Mapping[str, Any], wrong: Collection[str], place: str = ""
) -> AnyTable:
    """The typed table of a mapping, unchecked, but for the values of some keys.

    A wrong number is not a number, a wrong word stays what it is, and any other wrong value is left out.
    """
    found: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        table, value = table_in(_hint_of(model, name)), LEFT_OUT
        if given.get(name) is not None:
            value = _sound_value(model, name, given[name], wrong, f"{place}{name}")
        if value is LEFT_OUT and field.is_required():
            value = table and sound_table(table, {}, wrong)
        found |= {} if value is LEFT_OUT else {name: value}
    extra = given if model.model_config.get("extra") == "allow" else {}
    return model.model_construct(**{**extra, **found})


@cache
def _hint_of(model: type[SceneTable], name: str) -> Any:
    return model.model_fields[name].rebuild_annotation()


@cache
def _adapter(model: type[SceneTable], name: str) -> TypeAdapter[Any]:
    return TypeAdapter(_hint_of(model, name))


def _sound_value(model: type[SceneTable], name: str, value: Any, wrong: Collection[str], key: str) -> Any:
    """The typed value of a key of a table."""
    kinds: list[Any] = [*members_of(_hint_of(model, name))]
    origins: set[Any] = {get_origin(kind) for kind in kinds}
    table = table_in(_hint_of(model, name))
    if key in wrong:
        words = str in kinds or Literal in origins
        if StepRange in kinds and tuple not in origins:
            return StepRange.model_construct(start=nan, stop=nan)  # a range is asked, whatever its ends
        return nan if float in kinds else value if words and isinstance(value, str) else LEFT_OUT
    if table and isinstance(value, Mapping) and dict in origins:
        named = {each: row if isinstance(row, Mapping) else {} for each, row in value.items()}
        return {each: sound_table(table, row, wrong, f"{key}.{each}.") for each, row in named.items()}
    if table and isinstance(value, Mapping):
        return sound_table(table, value, wrong, f"{key}.")
    if table and isinstance(value, list) and any(table_in(kind) for kind in kinds if get_origin(kind) is tuple):
        rows = [row if isinstance(row, Mapping) else {} for row in value]
        return tuple(sound_table(table, row, wrong, f"{key}.{k}.") for k, row in enumerate(rows, start=1))
    try:
        return _adapter(model, name).validate_python(_pruned(value, wrong, f"{key}."))
    except (ValidationError, BadInput):
        return value if isinstance(value, list) else LEFT_OUT


def _pruned(value: Any, wrong: Collection[str], place: str) -> Any:
    """A value without the wrong keys of the mappings in it, and lists of which an item is wrong."""
    if not isinstance(value, Mapping):
        return value
    kept = {name: each for name, each in value.items() if f"{place}{name}" not in wrong}
    lists = [name for name, each in kept.items() if isinstance(each, list) and _has_wrong(wrong, f"{place}{name}.")]
    return {name: _pruned(each, wrong, f"{place}{name}.") for name, each in kept.items() if name not in lists}


def _has_wrong(wrong: Collection[str], place: str) -> bool:
    return any(key.startswith(place) for key in wrong)

"""A scene with mistakes as a typed scene without its wrong values, for the checks across tables."""

from collections.abc import Collection, Mapping
from functools import cache
from math import nan
from typing import Any, Literal, get_origin

from pydantic import TypeAdapter, ValidationError

from camopt.core.mistakes import BadInput
from camopt.scene.choices import StepRange
from camopt.scene.table_shapes import union_members
from camopt.scene.tables import AnyTable, SceneTable, table_type_in

OMITTED = object()


def faultless_table(
    model: type[AnyTable], given: Mapping[str, Any], wrong_keys: Collection[str], place: str = ""
) -> AnyTable:
    """The typed table of a mapping, unchecked, without the values of wrong keys.

    A wrong number becomes NaN, a wrong word stays, and any other wrong value is left out.
    """
    values: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        table, value = _table_type_of_key(model, name), OMITTED
        if given.get(name) is not None:
            value = _faultless_value(model, name, given[name], wrong_keys, f"{place}{name}")
        if value is OMITTED and field.is_required():
            value = table and faultless_table(table, {}, wrong_keys)
        values |= {} if value is OMITTED else {name: value}
    return model.model_construct(**{**(given if model.model_config.get("extra") == "allow" else {}), **values})


@cache
def _type_hint_of_key(model: type[SceneTable], name: str) -> Any:
    return model.model_fields[name].rebuild_annotation()


@cache
def _table_type_of_key(model: type[SceneTable], name: str) -> type[SceneTable] | None:
    return table_type_in(_type_hint_of_key(model, name))


@cache
def _type_adapter(model: type[SceneTable], name: str) -> TypeAdapter[Any]:
    return TypeAdapter(_type_hint_of_key(model, name))


def _faultless_value(model: type[SceneTable], name: str, value: Any, wrong_keys: Collection[str], key: str) -> Any:
    """The typed value of a key of a table, or OMITTED."""
    kinds: list[Any] = [*union_members(_type_hint_of_key(model, name))]
    origins: set[Any] = {get_origin(kind) for kind in kinds}
    table = _table_type_of_key(model, name)
    if key in wrong_keys:
        words = str in kinds or Literal in origins
        if StepRange in kinds and tuple not in origins:
            return StepRange.model_construct(start=nan, stop=nan)  # still a range, with unknown ends
        return nan if float in kinds else value if words and isinstance(value, str) else OMITTED
    if table and isinstance(value, Mapping) and dict in origins:
        named = {each: row if isinstance(row, Mapping) else {} for each, row in value.items()}
        return {each: faultless_table(table, row, wrong_keys, f"{key}.{each}.") for each, row in named.items()}
    if table and isinstance(value, Mapping):
        return faultless_table(table, value, wrong_keys, f"{key}.")
    if (
        table
        and isinstance(value, list)
        and any(table_type_in(kind) for kind in kinds if get_origin(kind) is tuple)
    ):
        rows = [row if isinstance(row, Mapping) else {} for row in value]
        return tuple(faultless_table(table, row, wrong_keys, f"{key}.{k}.") for k, row in enumerate(rows, start=1))
    try:
        return _type_adapter(model, name).validate_python(_drop_wrong_keys(value, wrong_keys, f"{key}."))
    except (ValidationError, BadInput):
        return value if isinstance(value, list) else OMITTED


def _drop_wrong_keys(value: Any, wrong_keys: Collection[str], place: str) -> Any:
    """A value without wrong keys of inner mappings, and without lists that have a wrong item."""
    if not isinstance(value, Mapping):
        return value
    return {
        name: _drop_wrong_keys(each, wrong_keys, f"{place}{name}.")
        for name, each in value.items()
        if f"{place}{name}" not in wrong_keys
        and not (isinstance(each, list) and any(key.startswith(f"{place}{name}.") for key in wrong_keys))
    }

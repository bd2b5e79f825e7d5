"""Find lists, tables and huge integers where a key takes a word or a number, before all other checks."""

from collections.abc import Hashable, Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from camopt.core.mistakes import Mistake
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.table_places import TOP_TABLE
from camopt.scene.tables import SceneTable, table_type_in

TablesByPlace = Mapping[str, type[SceneTable]]
"""The tables of a scene by their place (``tables_by_place``)."""


LARGEST_INTEGER = 10**308
"""Larger integers are no floats."""


class WrongShape(NamedTuple):
    """A list, a table or a huge integer that a key cannot have."""

    place: str
    holder: Any
    """The table or the list that contains it."""
    key: Any
    """Its key or index in the holder."""
    hint: Any
    """The type that the key takes."""


def replace_wrong_shapes(tables: dict[str, Any], models: TablesByPlace, file: str) -> Iterator[Mistake]:
    """Replace each value of a wrong shape by an empty text, with a mistake for each.

    It changes ``tables`` itself. An empty text is still wrong there, but all readers and checks can handle a text.
    """
    for place, holder, key, hint in _wrong_shapes_in_table(tables, models[TOP_TABLE], "", models):
        try:
            TypeAdapter(hint).validate_python(holder[key])
        except ValidationError as error:
            yield mistakes_from_pydantic(error, SceneTable, place, file)[0]
            holder[key] = ""


def _wrong_shapes_in_table(
    table: Mapping[str, Any], model: type[SceneTable], place: str, models: TablesByPlace, nested: bool = False
) -> Iterator[WrongShape]:
    """The wrong shapes in a table; if ``nested``, also in inner tables whose names the model does not know."""
    for key, value in table.items():
        where = f"{place}.{key}".lstrip(".")
        if key in model.model_fields and not _is_scalar(value):
            hint = model.model_fields[key].rebuild_annotation()
            yield from _wrong_shapes_in_value(WrongShape(where, table, key, hint), models)
        elif nested and isinstance(value, Mapping):
            yield from _wrong_shapes_in_table(value, model, where, models, nested)


def _wrong_shapes_in_value(suspect: WrongShape, models: TablesByPlace) -> Iterator[WrongShape]:
    """The value itself if its key takes no list or table, else the wrong shapes inside it."""
    place, holder, key, hint = suspect
    value, members = holder[key], [*union_members(hint)]
    if _is_scalar(value):
        return
    if isinstance(value, Mapping):
        table = next((each for each in members if each is table_type_in(each)), None)
        named = next((each for each in members if get_origin(each) is dict), None)
        if table:
            yield from _wrong_shapes_in_table(value, table, place, models)
        elif named == dict[str, Any]:  # values in search and tolerances for numbers of other tables; or a scene
            if inner := models.get(f"{place.partition('.')[0]}.KEY"):
                yield from _wrong_shapes_in_table(value, inner, place, models, nested=True)
        elif named:
            for name in value:
                yield from _wrong_shapes_in_value(
                    WrongShape(f"{place}.{name}", value, name, get_args(named)[1]), models
                )
        else:
            yield suspect
        return
    rows = next((each for each in members if get_origin(each) is tuple), None)
    if rows is None or isinstance(value, int):
        yield suspect
    elif isinstance(value, list) and table_type_in(row_hint := get_args(rows)[0]):
        for index in range(len(value)):
            yield from _wrong_shapes_in_value(WrongShape(f"{place}.{index + 1}", value, index, row_hint), models)


def _is_scalar(value: Any) -> bool:
    """Whether a value is a text, a switch, a date or a number that a float can hold."""
    huge = isinstance(value, int) and abs(value) > LARGEST_INTEGER
    return isinstance(value, Hashable) and not huge


def union_members(hint: Any) -> Iterator[Any]:
    """The members of a union type; of any other type, the type itself."""
    if get_origin(hint) is Annotated:
        yield from union_members(get_args(hint)[0])
    elif get_origin(hint) in (Union, UnionType):
        for each in get_args(hint):
            yield from union_members(each)
    else:
        yield hint

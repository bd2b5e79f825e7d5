"""Lists, tables and endless numbers where a scene has a word or a number: mistakes that are told before others."""

from collections.abc import Hashable, Iterator, Mapping
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from camopt.core.mistakes import Mistake
from camopt.scene.complaints import mistakes_of
from camopt.scene.places import TOP
from camopt.scene.tables import SceneTable, table_in

Models = Mapping[str, type[SceneTable]]
"""The tables of a scene by their place (``tables_of``)."""


LARGEST_WHOLE = 10**308
"""Whole numbers above it are no floats."""


class Misfit(NamedTuple):
    """A list, a table or an endless number where none belongs."""

    place: str
    holder: Any
    """The table or the list that it is in."""
    key: Any
    """Its key, or its index."""
    hint: Any
    """The type of what belongs there."""


def read_shape(tables: dict[str, Any], models: Models, file: str) -> Iterator[Mistake]:
    """Put an empty text in place of each list, table or endless number that a key cannot have; a mistake for each.

    It changes ``tables`` itself. An empty text is as wrong there, and all readers and checks of a scene take texts.
    """
    for place, holder, key, hint in _misfits_in(tables, models[TOP], "", models):
        try:
            TypeAdapter(hint).validate_python(holder[key])
        except ValidationError as error:
            yield mistakes_of(error, SceneTable, place, file)[0]
            holder[key] = ""


def _misfits_in(
    table: Mapping[str, Any], model: type[SceneTable], place: str, models: Models, nested: bool = False
) -> Iterator[Misfit]:
    """The misfits in a table; if it is ``nested``, also in tables in it whose names the model does not know."""
    for key, value in table.items():
        where = f"{place}.{key}".lstrip(".")
        if key in model.model_fields and not _is_plain(value):
            hint = model.model_fields[key].rebuild_annotation()
            yield from _misfits_at(Misfit(where, table, key, hint), models)
        elif nested and isinstance(value, Mapping):
            yield from _misfits_in(value, model, where, models, nested)


def _misfits_at(whole: Misfit, models: Models) -> Iterator[Misfit]:
    """A value itself, if its key takes no list or no table, or else the misfits in it."""
    place, holder, key, hint = whole
    value, members = holder[key], [*members_of(hint)]
    if _is_plain(value):
        return
    if isinstance(value, Mapping):
        table = next((each for each in members if each is table_in(each)), None)
        named = next((each for each in members if get_origin(each) is dict), None)
        if table:
            yield from _misfits_in(value, table, place, models)
        elif named == dict[str, Any]:  # what search and tolerances have of numbers of other tables
            yield from _misfits_in(value, models[f"{place.partition('.')[0]}.KEY"], place, models, nested=True)
        elif named:
            for name in value:
                yield from _misfits_at(Misfit(f"{place}.{name}", value, name, get_args(named)[1]), models)
        else:
            yield whole
        return
    rows = next((each for each in members if get_origin(each) is tuple), None)
    if rows is None or isinstance(value, int):
        yield whole
    elif isinstance(value, list) and table_in(row_hint := get_args(rows)[0]):
        for index in range(len(value)):
            yield from _misfits_at(Misfit(f"{place}.{index + 1}", value, index, row_hint), models)


def _is_plain(value: Any) -> bool:
    """Whether a value is a text, a switch, a date or a number that a float can hold."""
    endless = isinstance(value, int) and abs(value) > LARGEST_WHOLE
    return isinstance(value, Hashable) and not endless


def members_of(hint: Any) -> Iterator[Any]:
    """The types that a value may have."""
    if get_origin(hint) is Annotated:
        yield from members_of(get_args(hint)[0])
    elif get_origin(hint) in (Union, UnionType):
        for each in get_args(hint):
            yield from members_of(each)
    else:
        yield hint

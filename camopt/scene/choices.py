"""Choices of ``[search]``, each a range or a list of values for a number of the scene."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple, Self, get_args, get_origin

from pydantic import ConfigDict, Discriminator, Field, Tag, TypeAdapter, ValidationError, model_validator

from camopt.core.mistakes import BadInput, Mistake, suggest_names
from camopt.core.quantities.key import Key
from camopt.scene.pydantic_mistakes import mistakes_from_pydantic
from camopt.scene.sizes import SEARCH_SIZES
from camopt.scene.tables import (
    Cam,
    Follower,
    InnerTable,
    Length,
    ListOrItem,
    Positive,
    SceneNumber,
    SceneTable,
    SignedNumber,
    single_value_as_list,
    table_type_in,
)

OF_NUMBER = "in the unit of the number"
LOWEST_KEY, HIGHEST_KEY = Key("Lowest value", OF_NUMBER), Key("Highest value", OF_NUMBER)
STEP_KEY = Key("Distance between values in the grid of a sweep", OF_NUMBER)


class StepRange(SceneTable):
    """A range from ``start`` to ``stop``, both included; only a sweep of a grid needs the ``step``."""

    start: Annotated[SignedNumber, LOWEST_KEY]
    stop: Annotated[SignedNumber, HIGHEST_KEY]
    step: Annotated[Length | None, STEP_KEY] = None

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if self.stop < self.start:
            raise ValueError("a range whose stop is not below its start")
        return self


class NumberRange(StepRange):
    """A range of a number other than a size."""

    start: Annotated[SceneNumber, LOWEST_KEY]
    stop: Annotated[SceneNumber, HIGHEST_KEY]
    step: Annotated[Positive | None, STEP_KEY] = None


CheckedChoice = StepRange | tuple[float, ...]
"""A choice after its checks."""


def _value_as_list_unless_text(value: Any) -> Any:
    """A value or a list of values, as a list."""
    if isinstance(value, str):
        raise ValueError("a number, a list of numbers, or a table with start, stop and step")
    return single_value_as_list(value)


CHOICE_KIND = Discriminator(lambda value: "range/" if isinstance(value, (dict, StepRange)) else "values/")
ListedValues = Annotated[tuple[SignedNumber, ...], Field(min_length=1), ListOrItem(_value_as_list_unless_text)]
Choice = (
    Annotated[
        Annotated[InnerTable[StepRange], Tag("range/")] | Annotated[ListedValues, Tag("values/")],
        CHOICE_KIND,
    ]
    | None
)
ListedNumbers = Annotated[tuple[SceneNumber, ...], Field(min_length=1), ListOrItem(_value_as_list_unless_text)]
NumberChoice = Annotated[
    Annotated[NumberRange, Tag("range/")] | Annotated[ListedNumbers, Tag("values/")],
    CHOICE_KIND,
]


CHOICE_VALIDATOR = TypeAdapter[Any](NumberChoice, config=ConfigDict(defer_build=True))  # milliseconds to build
NumberReader = Callable[[Any, Any, str], Any]
"""From (type of a number, value, place in the scene) to the checked value; raises BadInput."""


def _read_search_choice(number_type: Any, value: Any, choice_key: str) -> Any:
    """The choice of ``[search]`` for one number."""
    try:
        choice = CHOICE_VALIDATOR.validate_python(value.model_dump() if isinstance(value, StepRange) else value)
    except ValidationError as error:
        raise BadInput(mistakes_from_pydantic(error, NumberRange, choice_key)) from None
    number, mistakes = TypeAdapter(number_type), list[Mistake]()
    ends = choice.model_dump(include={"start", "stop"}) if isinstance(choice, StepRange) else {}
    for name, each in ends.items() or enumerate(choice, start=1):
        try:
            number.validate_python(each)
        except ValidationError as error:
            mistakes += mistakes_from_pydantic(error, NumberRange, f"{choice_key}.{name}")
    if mistakes:
        raise BadInput(mistakes)
    return choice


class Reader(NamedTuple):
    """How a table such as ``[search]`` reads its values for numbers of other tables."""

    read: NumberReader = _read_search_choice
    sizes: bool = False
    """Whether the table takes sizes here; ``[search]`` has keys of its own for them."""


CHOICE_READER = Reader()


def read_number_choices(
    table: type[SceneTable], given_choices: Any, table_key: str = "", reader: Reader = CHOICE_READER
) -> dict[str, Any]:
    """The choices for numbers of a table and its inner tables, by key; ``table_key`` is the key of the table.

    Raises
    ------
    BadInput
        For each key that is not a number of the table, and each value that the number may not have.
    """
    table_key = table_key or table.__name__
    if not isinstance(given_choices, Mapping):
        raise BadInput([Mistake("", table_key, given_choices, "a table")])
    chosen = _read_each(
        given_choices, lambda key, value: _read_number_choice(table, key, value, f"{table_key}.{key}", reader)
    )
    return {key: choice for key, choice in chosen.items() if choice != {}}


def read_row_choices(table: type[SceneTable], given_choices: Any, reader: Reader = CHOICE_READER) -> dict[str, Any]:
    """The choices for numbers in the rows of a list of tables, by number of the row from 1.

    Raises
    ------
    BadInput
        As ``read_number_choices``; also for each key that is not the number of a row.
    """
    where = table.__name__
    if not isinstance(given_choices, Mapping):
        raise BadInput([Mistake("", where, given_choices, f"a table, such as {{ 1 = {{ {where.lower()} = 3 }} }}")])

    def read_row(row: str, values: Any) -> dict[str, Any]:
        if not (row.isdecimal() and row == str(int(row)) != "0"):
            why = "not the number of a row, counted from 1"
            raise BadInput([Mistake("", f"{where}.{row}", values, why, bare=True)])
        return read_number_choices(table, values, f"{where}.{row}", reader)

    return _read_each(given_choices, read_row)


def _read_each(values_by_key: Mapping[str, Any], read: Callable[[str, Any], Any]) -> dict[str, Any]:
    """What ``read`` makes of each key and value; one BadInput with the mistakes in all of them."""
    results, mistakes = dict[str, Any](), list[Mistake]()
    for key, value in values_by_key.items():
        try:
            results[key] = read(key, value)
        except BadInput as error:
            mistakes += error.mistakes
    if mistakes:
        raise BadInput(mistakes)
    return results


def _read_number_choice(table: type[SceneTable], key: str, value: Any, where: str, reader: Reader) -> Any:
    """The choice for one number of a table, or the choices for its inner table."""
    numbers = searchable_number_types(table, sizes=reader.sizes)
    number = numbers.get(key)
    if isinstance(number, type):
        return read_number_choices(number, value, where, reader)
    if number is None:
        known = [name for name, hint in numbers.items() if not isinstance(hint, type)]
        why = (
            f"is a size: write search.{key}"
            if key in _size_keys_of_table(table)
            else f"not a number of this table; {suggest_names(key, known)}"
        )
        raise BadInput([Mistake("", where, value, why, bare=True)])
    return reader.read(number, value, where)


def searchable_number_types(table: type[SceneTable], *, sizes: bool = False) -> dict[str, Any]:
    """The keys of a table that ``[search]`` may vary, each with the type of its number or with its inner table.

    Sizes are included only with ``sizes``, since ``[search]`` has keys of its own for them.
    """
    excluded = {*(() if sizes else _size_keys_of_table(table)), *table.read_as}
    fields = {key: field for key, field in table.model_fields.items() if key not in excluded}
    types = {
        key: table_type_in(hint := field.rebuild_annotation()) or _number_type_in(hint)
        for key, field in fields.items()
    }
    return {key: found for key, found in types.items() if found is not None}


def _size_keys_of_table(table: type[SceneTable]) -> tuple[str, ...]:
    """The keys of sizes in a table; ``[search]`` has keys of its own for them."""
    return SEARCH_SIZES if table in (Cam, Follower) else ()


def _number_type_in(hint: Any) -> Any:
    """The number in a type hint, with its bounds; None without one."""
    if get_origin(hint) is Annotated and get_args(hint)[0] is float:
        return hint
    return next((found for each in get_args(hint) if (found := _number_type_in(each)) is not None), None)

"""The choice of ``[search]`` for a number of the scene: a range or a list of values."""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Annotated, Any, NamedTuple, Self, get_args, get_origin

from pydantic import Discriminator, Field, Tag, TypeAdapter, ValidationError, model_validator

from camopt.core.mistakes import BadInput, Mistake, nearest
from camopt.core.quantities.key import Key
from camopt.scene.complaints import mistakes_of
from camopt.scene.sizes import SEARCHED
from camopt.scene.tables import (
    Anywhere,
    Cam,
    Follower,
    Inner,
    Length,
    Listed,
    Positive,
    SceneNumber,
    SceneTable,
    as_list,
    table_in,
)

OF_NUMBER = "in the unit of the number"
LOWEST, HIGHEST = Key("Lowest value", OF_NUMBER), Key("Highest value", OF_NUMBER)
STEP = Key("Distance of values in the grid of a sweep", OF_NUMBER)


class StepRange(SceneTable):
    """A closed interval; the step matters to a sweep of a grid alone."""

    start: Annotated[Anywhere, LOWEST]
    stop: Annotated[Anywhere, HIGHEST]
    step: Annotated[Length | None, STEP] = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.stop < self.start:
            raise ValueError("a range whose stop is not below its start")
        return self


class NumberRange(StepRange):
    """A closed interval of a number that is no size."""

    start: Annotated[SceneNumber, LOWEST]
    stop: Annotated[SceneNumber, HIGHEST]
    step: Annotated[Positive | None, STEP] = None


Chosen = StepRange | tuple[float, ...]
"""What a checked choice is."""


def _kind_of_choice(value: Any) -> str:
    return "range/" if isinstance(value, (dict, StepRange)) else "values/"


def _listed(value: Any) -> Any:
    """A value, or a list of such, as a list."""
    if isinstance(value, str):
        raise ValueError("a number, a list of numbers, or a table with start, stop and step")
    return as_list(value)


ListedValues = Annotated[tuple[Anywhere, ...], Field(min_length=1), Listed(_listed)]
Choice = (
    Annotated[
        Annotated[Inner[StepRange], Tag("range/")] | Annotated[ListedValues, Tag("values/")],
        Discriminator(_kind_of_choice),
    ]
    | None
)
ListedNumbers = Annotated[tuple[SceneNumber, ...], Field(min_length=1), Listed(_listed)]
NumberChoice = Annotated[
    Annotated[NumberRange, Tag("range/")] | Annotated[ListedNumbers, Tag("values/")],
    Discriminator(_kind_of_choice),
]


@cache
def _choices() -> TypeAdapter[Any]:
    """The validator of a choice, made when needed: that takes milliseconds."""
    return TypeAdapter(NumberChoice)


Read = Callable[[Any, Any, str], Any]
"""From the type of a number, what is given for it, and its place to what is checked; raises BadInput."""


def _choice(number: Any, value: Any, where: str) -> Any:
    """The choice of ``[search]`` for one number."""
    try:
        choice = _choices().validate_python(value.model_dump() if isinstance(value, StepRange) else value)
    except ValidationError as error:
        raise BadInput(mistakes_of(error, NumberRange, where)) from None
    if mistakes := list(_out_of_bounds(TypeAdapter(number), choice, where)):
        raise BadInput(mistakes)
    return choice


class Reader(NamedTuple):
    """What reads values that a table of the scene has for numbers of another one."""

    read: Read = _choice
    sizes: bool = False
    """Whether sizes are among the numbers; ``[search]`` has them in a place of their own."""


CHOICES = Reader()


def free_numbers(table: type[SceneTable], given: Any, where: str = "", reader: Reader = CHOICES) -> dict[str, Any]:
    """The choices for numbers of a table of the scene, and of tables in it, by key; ``where`` leads to the table.

    Raises
    ------
    BadInput
        For each key that is no number of the table, and each value that the number itself may not have.
    """
    where = where or table.__name__
    if not isinstance(given, Mapping):
        raise BadInput([Mistake("", where, given, "a table")])
    chosen: dict[str, Any] = {}
    mistakes: list[Mistake] = []
    for key, value in given.items():
        try:
            chosen[key] = _free(table, key, value, f"{where}.{key}", reader)
        except BadInput as error:
            mistakes += error.mistakes
    if mistakes:
        raise BadInput(mistakes)
    return {key: choice for key, choice in chosen.items() if choice != {}}


def free_rows(table: type[SceneTable], given: Any, reader: Reader = CHOICES) -> dict[str, Any]:
    """The choices for numbers of the rows of a list of tables, by the number of the row from 1.

    Raises
    ------
    BadInput
        As ``free_numbers``; for each key that is no number of a row.
    """
    where = table.__name__
    if not isinstance(given, Mapping):
        raise BadInput([Mistake("", where, given, f"a table, such as {{ 1 = {{ {where.lower()} = 3 }} }}")])
    chosen: dict[str, Any] = {}
    mistakes: list[Mistake] = []
    for row, values in given.items():
        try:
            if not (row.isdecimal() and row == str(int(row)) != "0"):
                why = "not the number of a row, counted from 1"
                raise BadInput([Mistake("", f"{where}.{row}", values, why, bare=True)])
            chosen[row] = free_numbers(table, values, f"{where}.{row}", reader)
        except BadInput as error:
            mistakes += error.mistakes
    if mistakes:
        raise BadInput(mistakes)
    return chosen


def _free(table: type[SceneTable], key: str, value: Any, where: str, reader: Reader) -> Any:
    """What is read of one number of a table, or of those of a table in it."""
    numbers = numbers_of(table, sizes=reader.sizes)
    number = numbers.get(key)
    if isinstance(number, type):
        return free_numbers(number, value, where, reader)
    if number is None:
        known = [name for name, hint in numbers.items() if not isinstance(hint, type)]
        why = (
            f"is a size: write search.{key}"
            if key in _sizes_of(table)
            else f"not a number of this table; {nearest(key, known)}"
        )
        raise BadInput([Mistake("", where, value, why, bare=True)])
    return reader.read(number, value, where)


def numbers_of(table: type[SceneTable], *, sizes: bool = False) -> dict[str, Any]:
    """The keys of a table that ``[search]`` may free, each with the type of its number, or the table in it.

    With those of sizes, if asked, which ``[search]`` has in a place of their own.
    """
    left_out = {*(() if sizes else _sizes_of(table)), *table.read_as}
    fields = {key: field for key, field in table.model_fields.items() if key not in left_out}
    found = {key: _free_in(field.rebuild_annotation()) for key, field in fields.items()}
    return {key: hint for key, hint in found.items() if hint is not None}


def _sizes_of(table: type[SceneTable]) -> tuple[str, ...]:
    """The keys of a table that may be those of sizes, which ``[search]`` has in a place of their own."""
    return SEARCHED if table in (Cam, Follower) else ()


def _free_in(hint: Any) -> Any:
    """The table or the number that a type has among its members."""
    return table_in(hint) or _number_in(hint)


def _number_in(hint: Any) -> Any:
    """The number that a type has among its members, with its bounds; None if it has none."""
    if get_origin(hint) is Annotated and get_args(hint)[0] is float:
        return hint
    return next((found for each in get_args(hint) if (found := _number_in(each)) is not None), None)


def _out_of_bounds(number: TypeAdapter[Any], choice: Any, where: str) -> Iterator[Mistake]:
    """A mistake for each value of a choice that the number may not have."""
    ends = choice.model_dump(include={"start", "stop"}) if isinstance(choice, StepRange) else {}
    for name, value in ends.items() or enumerate(choice, start=1):
        try:
            number.validate_python(value)
        except ValidationError as error:
            yield from mistakes_of(error, NumberRange, f"{where}.{name}")

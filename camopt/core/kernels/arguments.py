"""What machine code is called with: the kinds of a kernel's arguments, and the numbers it takes for them.

numba takes values apart until only numbers are left: of an array two places that count references to it (unused
here), its size, the bytes of an item, its address, its shape and its strides; of a tuple what is in it.
"""

from collections.abc import Iterator
from ctypes import addressof, c_bool, c_char, c_double, c_int64, c_void_p
from functools import cache
from typing import Any, NamedTuple

import numpy as np


class ArgumentKind(NamedTuple):
    """What numba calls the type of a number, and the dimensions and layout of an array of such; 0: the number."""

    name: str
    dimensions: int = 0
    layout: str = "C"


class Record(NamedTuple):
    """The type of a tuple: its class, and the types of its fields."""

    owner: type
    fields: tuple[Any, ...]


class Code(NamedTuple):
    """The type of a function's address: what it returns, and the types of its arguments."""

    returns: Any
    arguments: tuple[Any, ...]


NONE, COUNT, NUMBER, BOOLEAN, ADDRESS = map(ArgumentKind, ("none", "int64", "float64", "boolean", "voidptr"))
NUMBER_KINDS: dict[type, ArgumentKind] = {
    type(None): NONE,
    bool: BOOLEAN,
    **dict.fromkeys((int, np.int64), COUNT),
    **dict.fromkeys((float, np.float64), NUMBER),
}
ITEM_KINDS = {np.dtype(float): "float64", np.dtype(np.int64): "int64", np.dtype(bool): "boolean"}
C_TYPES = {NONE: c_void_p, COUNT: c_int64, NUMBER: c_double, BOOLEAN: c_bool, ADDRESS: c_void_p}
POINTERS = None, None  # to what counts the references to an array


def kind_of(value: Any) -> Any:
    """The type of an argument: a ``ArgumentKind``, a ``Record``, or the ``Code`` of a kernel that is called by its
    address.

    Raises
    ------
    TypeError
        If no kernel takes it.
    """
    owner = type(value)
    if owner is np.ndarray and value.ndim and value.dtype in ITEM_KINDS:
        flags = value.flags
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return ArgumentKind(ITEM_KINDS[value.dtype], value.ndim, layout)
    if isinstance(value, tuple):
        return value.record if isinstance(value, PinnedTuple) else Record(owner, tuple(map(kind_of, value)))
    kind = NUMBER_KINDS.get(owner) or getattr(value, "code", None)
    if kind is None:
        raise TypeError(f"a kernel takes numbers, arrays of them, and tuples, not {value!r}")
    return kind


def flatten_arguments(values: Any) -> list[Any]:
    """What machine code takes for some arguments."""
    numbers: list[Any] = []
    for value in values:
        if type(value) is np.ndarray:
            numbers += (*POINTERS, value.size, value.itemsize, _array_address(value), *value.shape, *value.strides)
        elif isinstance(value, tuple):
            numbers += value.numbers if isinstance(value, PinnedTuple) else flatten_arguments(value)
        else:
            numbers.append(getattr(value, "address", value))
    return numbers


class PinnedTuple:
    """A tuple whose arrays stay where they are: its type and numbers are found once, not in each call."""

    record: Record
    numbers: list[Any]


def pin_arrays(value: Any) -> Any:
    """A NamedTuple as one of arrays that nobody replaces by others."""
    owner: Any = type(value)
    made = _pinned_class(owner)(*value)
    made.record, made.numbers = kind_of(value), flatten_arguments(value)
    return made


@cache
def _pinned_class(owner: Any) -> Any:
    return type(owner.__name__, (owner, PinnedTuple), {})


def _array_address(array: Any) -> int:
    """Where the numbers of an array are; what numpy says takes several times as long."""
    try:
        return addressof(c_char.from_buffer(array))
    except (TypeError, ValueError, BufferError):  # not in C order, read-only, or empty
        return int(array.__array_interface__["data"][0])


def c_types_of(kinds: Any) -> Iterator[Any]:
    """The types of these numbers."""
    for kind in kinds:
        if isinstance(kind, Record):
            yield from c_types_of(kind.fields)
        elif isinstance(kind, Code):
            yield c_void_p
        elif kind.dimensions:
            yield from (c_void_p, c_void_p, c_int64, c_int64, c_void_p, *[c_int64] * (2 * kind.dimensions))
        else:
            yield C_TYPES[kind]

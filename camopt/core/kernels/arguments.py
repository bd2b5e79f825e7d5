"""Arguments of machine code: their kinds, and the numbers that are passed for them.

Machine code takes only numbers. For an array these are two pointers for reference counts (unused here), its size,
the bytes of an item, its address, its shape and its strides. For a tuple they are the numbers of its items.
"""

from collections.abc import Iterator
from ctypes import addressof, c_bool, c_char, c_double, c_int64, c_void_p
from functools import cache
from typing import Any, NamedTuple

import numpy as np


class ArgumentKind(NamedTuple):
    """Type of a number by numba's name, with dimensions and layout of an array of such; 0 dimensions: a number."""

    name: str
    dimensions: int = 0
    layout: str = "C"


class Record(NamedTuple):
    """Type of a tuple: its class and the types of its fields."""

    owner: type
    fields: tuple[Any, ...]


class Code(NamedTuple):
    """Type of a function's address: the types of its result and of its arguments."""

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
POINTERS = None, None  # to the reference counts of an array


def kernel_argument_type(value: Any) -> Any:
    """Type of an argument: an ``ArgumentKind``, a ``Record``, or the ``Code`` of a kernel called by its address.

    Raises
    ------
    TypeError
        If no kernel takes such an argument.
    """
    owner = type(value)
    if owner is np.ndarray and value.ndim and value.dtype in ITEM_KINDS:
        flags = value.flags
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return ArgumentKind(ITEM_KINDS[value.dtype], value.ndim, layout)
    if isinstance(value, tuple):
        return (
            value.record
            if isinstance(value, PinnedTuple)
            else Record(owner, tuple(map(kernel_argument_type, value)))
        )
    kind = NUMBER_KINDS.get(owner) or getattr(value, "code", None)
    if kind is None:
        raise TypeError(f"a kernel takes numbers, arrays of them, and tuples, not {value!r}")
    return kind


def flatten_to_machine_arguments(values: Any) -> list[Any]:
    """Numbers that machine code takes for some arguments."""
    numbers: list[Any] = []
    for value in values:
        if type(value) is np.ndarray:
            numbers += (*POINTERS, value.size, value.itemsize, _array_address(value), *value.shape, *value.strides)
        elif isinstance(value, tuple):
            numbers += value.numbers if isinstance(value, PinnedTuple) else flatten_to_machine_arguments(value)
        else:
            numbers.append(getattr(value, "address", value))
    return numbers


class PinnedTuple:
    """A tuple whose arrays never move, so that its type and numbers are computed once and not at each call."""

    record: Record
    numbers: list[Any]


def as_pinned_tuple(named_tuple: Any) -> Any:
    """Copy a NamedTuple to a ``PinnedTuple``; its arrays must never be replaced."""
    owner: Any = type(named_tuple)
    pinned = _pinned_tuple_class(owner)(*named_tuple)
    pinned.record, pinned.numbers = kernel_argument_type(named_tuple), flatten_to_machine_arguments(named_tuple)
    return pinned


@cache
def _pinned_tuple_class(tuple_class: Any) -> Any:
    return type(tuple_class.__name__, (tuple_class, PinnedTuple), {})


def _array_address(array: Any) -> int:
    """Address of an array's numbers; numpy's own interface takes several times as long."""
    try:
        return addressof(c_char.from_buffer(array))
    except (TypeError, ValueError, BufferError):  # not in C order, read-only, or empty
        return int(array.__array_interface__["data"][0])


def argument_c_types(kinds: Any) -> Iterator[Any]:
    """C types of the numbers that are passed for arguments of some kinds."""
    for kind in kinds:
        if isinstance(kind, Record):
            yield from argument_c_types(kind.fields)
        elif isinstance(kind, Code):
            yield c_void_p
        elif kind.dimensions:
            yield from (c_void_p, c_void_p, c_int64, c_int64, c_void_p, *[c_int64] * (2 * kind.dimensions))
        else:
            yield C_TYPES[kind]

"""Read values from the plain, unchecked mapping of a scene."""

from collections.abc import Iterator, Mapping
from math import isfinite
from numbers import Real
from typing import Any

MOTION_AT_FOLLOWER = "follower"
"""The value of ``motion_at`` for the motion of the follower."""


def value_at_key(data: Mapping[str, Any], key: str) -> Any:
    """The value under a key; items of lists are counted from 1."""
    value: Any = data
    for part in key.split("."):
        value = (
            {str(place): each for place, each in enumerate(value, start=1)} if isinstance(value, list) else value
        )
        value = value.get(part) if isinstance(value, Mapping) else None
    return value


def finite_number_or_none(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, Real):
        return None
    try:
        return float(value) if isfinite(value) else None
    except OverflowError:
        return None


def table_named(tables: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The table of a name; an empty one if it is missing or no table."""
    table = tables.get(name)
    return table if isinstance(table, Mapping) else {}


def tables_in_list(value: Any) -> list[Mapping[str, Any]]:
    """The tables in a list; any other item counts as an empty table."""
    rows = value if isinstance(value, (list, tuple)) else ()
    return [each if isinstance(each, Mapping) else {} for each in rows]


def leaf_values_by_key(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """The values of nested tables by dotted key; lists of tables count from 1, any other list is one value."""
    if isinstance(value, list) and any(isinstance(each, Mapping) for each in value):
        value = dict(enumerate(value, start=1))
    if not isinstance(value, Mapping):
        yield key, value
        return
    for name, each in value.items():
        yield from leaf_values_by_key(each, f"{key}.{name}" if key else str(name))


def is_motion_given_at_follower(data: Mapping[str, Any]) -> bool:
    """Whether a scene gives the motion of its follower, by a profile or by ``motion_at``."""
    return bool(data.get("profile")) or data.get("motion_at") == MOTION_AT_FOLLOWER

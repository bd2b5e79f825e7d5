"""The plain mapping of a scene, in which anything may be wrong: its values by key, its numbers, its segments."""

from collections.abc import Mapping
from math import isfinite
from numbers import Real
from typing import Any


def at(data: Mapping[str, Any], key: str) -> Any:
    value: Any = data
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return value


def number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, Real):
        return None
    try:
        return float(value) if isfinite(value) else None
    except OverflowError:
        return None


def length(data: Mapping[str, Any], key: str) -> float | None:
    """A size, mm; None where it is missing or wrong."""
    size = number(at(data, key))
    return size if size and size > 0.0 else None


def segments(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The segments; what is no table there has no keys."""
    motion = data.get("motion")
    return [s if isinstance(s, Mapping) else {} for s in motion] if isinstance(motion, list) else []

"""Keys that had another name once, and are still read by it."""

from collections.abc import Iterator
from typing import Any

from camopt.scene.law_forms import Fault
from camopt.scene.mapping import value_at_key

FORMER_KEYS = {"accuracy.tolerance": "accuracy.relative_error"}
"""The key of today, by the one that it was."""


def read_former_keys(tables: dict[str, Any]) -> Iterator[Fault]:
    """Put values of former keys under those of today, in ``tables`` itself; a fault where both are given."""
    for former, key in FORMER_KEYS.items():
        if (value := value_at_key(tables, former)) is None:
            continue
        if value_at_key(tables, key) is not None:
            yield former, value, f"is the old name of {key}, which is given too: leave this one out"
        place, _, name = former.rpartition(".")
        table = tables[place]
        del table[name]
        table.setdefault(key.removeprefix(f"{place}."), value)

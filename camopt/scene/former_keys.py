"""Former names of keys, which scenes may still use."""

from collections.abc import Iterator
from typing import Any

from camopt.scene.law_forms import Fault
from camopt.scene.mapping import value_at_key

FORMER_KEYS = {"accuracy.tolerance": "accuracy.relative_error"}
"""The present key, by its former name."""


def replace_former_keys(tables: dict[str, Any]) -> Iterator[Fault]:
    """Replace former keys by present ones, in ``tables`` itself; a fault where both are given."""
    for former, key in FORMER_KEYS.items():
        if (value := value_at_key(tables, former)) is None:
            continue
        if value_at_key(tables, key) is not None:
            yield former, value, f"is the old name of {key}, which is given too: leave this one out"
        place, _, name = former.rpartition(".")
        table = tables[place]
        del table[name]
        table.setdefault(key.removeprefix(f"{place}."), value)

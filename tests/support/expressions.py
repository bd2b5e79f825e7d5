"""Random expressions over quantities, and their values by Python itself and by pandas."""

import random
import re
from collections.abc import Sequence

LEAVES = ("0.5", "2", "3.25", "pi", "1e-3")
ONE = ("abs", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "radians", "degrees")
TWO = ("min", "max", "atan2")
OF_PANDAS = {
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "atan2": "arctan2",
    "min": "@minimum",
    "max": "@maximum",
    "radians": "@radians",
    "degrees": "@degrees",
}
"""What pandas calls a function, or where it takes one of numpy."""


def random_expression(
    random: random.Random, names: Sequence[str], depth: int, called: dict[str, str] | None = None
) -> str:
    """An expression over some names; functions under other names where ``called`` has some."""
    called = called or {}
    kind = random.random() if depth else 1.0
    if kind > 0.85:
        return random.choice([*names, *names, *LEAVES])
    inner = [random_expression(random, names, depth - 1, called) for _ in range(2)]
    if kind < 0.4:
        return f"({inner[0]} {random.choice('+-*/')} {inner[1]})"
    if kind < 0.5:
        return f"({inner[0]}) ** {random.choice(['2', '3', '(-1)', '0.5'])}"
    if kind < 0.55:
        return f"-{inner[0]}"
    if kind < 0.75:
        function = random.choice(ONE)
        return f"{called.get(function, function)}({inner[0]})"
    function = random.choice(TWO)
    return f"{called.get(function, function)}({inner[0]}, {inner[1]})"


def for_pandas(random_seed: int, names: Sequence[str], depth: int) -> tuple[str, str]:
    """A random expression, and the same as pandas has it."""
    ours, theirs = (random_expression(random.Random(random_seed), names, depth, c) for c in ({}, OF_PANDAS))
    return ours, re.sub(r"\bpi\b", "3.141592653589793", theirs)

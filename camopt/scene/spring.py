"""A straight spring on the arm of an oscillating follower, read as the spring about its pivot that it acts as.

    k_θ = k·a²,    M₀ = F₀·a

for a spring that stands square to its lever, a from the pivot, where the follower is lowest. Away from there the
moment of the straight spring is (F₀ + k·a·sin φ)·a·cos φ: over a swing φ of 10 deg it is about 1.5 % less.
"""

from collections.abc import Iterator
from typing import Any

from camopt.scene.law_forms import Fault
from camopt.scene.mapping import at, length, number_of
from camopt.scene.sizes import mechanism_in

SPRING_AT = "follower.dynamics.spring_at"
POWERS = {"spring_rate": 2, "preload": 1}
"""Of the lever, by which what a straight spring has becomes what one about the pivot has."""


def read_spring(tables: dict[str, Any]) -> Iterator[Fault]:
    """Put a spring about the pivot, in N·m/rad and N·m, in the place of a straight one, in N/mm and N."""
    given = at(tables, SPRING_AT)
    found = mechanism_in(tables)
    if given is None or found is None:
        return
    dynamics, lever = tables["follower"]["dynamics"], length(tables, SPRING_AT)
    if not found[0].motion.angular:
        yield SPRING_AT, given, "only an oscillating follower has one; a translating one has its spring in line"
    elif not any(key in dynamics for key in POWERS):
        yield SPRING_AT, given, "goes with spring_rate in N/mm or preload in N, which are missing"
    elif lever:
        for key, power in POWERS.items():
            if (value := number_of(dynamics.get(key))) is not None:
                dynamics[key] = value * lever**power / 1e3
        del dynamics["spring_at"]


def is_straight(tables: Any, key: str) -> bool:
    """Whether a key is that of a straight spring, whose numbers are no moments."""
    table, _, name = key.rpartition(".")
    return at(tables, SPRING_AT) is not None and f"{table}.spring_at" == SPRING_AT and name in POWERS

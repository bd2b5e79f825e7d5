"""How many random cases a test tries: those of every run, or those of ``.ci/deep``.

One switch for all: hypothesis's profile, ``--hypothesis-profile=deep`` or ``ci`` (``conftest``).
"""

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

from hypothesis import settings

Case = TypeVar("Case")


def is_deep() -> bool:
    """Whether this run is ``.ci/deep``."""
    return settings.get_current_profile_name() == "deep"


def times(everyday: int, deep: int) -> int:
    """The number of random cases under the profile of this run."""
    return deep if is_deep() else everyday


def covering_cases(cases: Iterable[Case], features: Callable[[Case], Iterable[Hashable]]) -> list[Case]:
    """Of a long list, the cases with a feature that none before them has; all of them in ``.ci/deep``."""
    seen: set[Hashable] = set()
    chosen = []
    for case in cases:
        new = set(features(case)) - seen
        seen |= new
        chosen += [case] if new or is_deep() else []
    return chosen

"""How much tests try: the random cases of every run, or those of ``.ci/deep``; and the tests whose turn it is.

One switch for all: hypothesis's profile, ``--hypothesis-profile=deep`` or ``ci`` (``conftest``).
"""

import subprocess
from collections.abc import Callable, Hashable, Iterable
from functools import cache
from pathlib import Path
from typing import TypeVar
from zlib import crc32

from hypothesis import settings

Case = TypeVar("Case")

TURNS = 4
"""Commits that share the slow tests: each runs one test in so many."""


def is_deep() -> bool:
    """Whether this run is ``.ci/deep``."""
    return settings.get_current_profile_name() == "deep"


@cache
def number_of_commit() -> int:
    """A number of the last commit, which decides the tests that it runs; 0 outside of a clone."""
    git = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    try:
        return int(subprocess.run(git, capture_output=True, text=True, check=True).stdout[:8], 16)
    except (OSError, subprocess.CalledProcessError):
        return 0


def has_turn(name: str) -> bool:
    """Whether a slow test takes its turn at this commit."""
    return (crc32(name.encode()) + number_of_commit()) % TURNS == 0


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

"""How much tests try: the random cases of every run, or those of ``.ci/deep``; and the tests whose turn it is.

One switch for all: hypothesis's profile, ``--hypothesis-profile=deep`` or ``ci`` (``conftest``).
"""

import os
import subprocess
from collections.abc import Callable, Hashable, Iterable
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


def number_of_commit() -> int:
    """A number of the last commit, which decides the tests that it runs; 0 if git does not know one.

    All processes of a run use the commit of the first one, in the variable TESTED_COMMIT.
    """
    if "TESTED_COMMIT" not in os.environ:
        git = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
        try:
            os.environ["TESTED_COMMIT"] = subprocess.check_output(git, text=True, stderr=subprocess.DEVNULL)
        except (OSError, subprocess.CalledProcessError):
            os.environ["TESTED_COMMIT"] = os.environ.get("GITHUB_SHA", "0")
    return int(os.environ["TESTED_COMMIT"][:8], 16)


def has_turn(name: str, commit: int) -> bool:
    """Whether a slow test takes its turn at a commit."""
    return (crc32(name.encode()) + commit) % TURNS == 0


def is_shared(case: int, share: int, commit: int) -> bool:
    """Whether a case of a test that runs one in ``share`` runs at a commit, in turns of its own."""
    return (case + commit // TURNS) % share == 0


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

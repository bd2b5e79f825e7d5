"""How many random cases a test tries: those of every run, or those of ``.ci/deep``.

One switch for all: hypothesis's profile, ``--hypothesis-profile=deep`` or ``ci`` (``conftest``).
"""

from hypothesis import settings


def times(everyday: int, deep: int) -> int:
    """The number of random cases under the profile of this run."""
    return deep if settings.get_current_profile_name() == "deep" else everyday

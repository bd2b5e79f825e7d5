"""A user without a home, as in a container that runs as a number."""

import os
from pathlib import Path


def settle_home() -> None:
    """Give a user whom the system does not know an empty home; ezdxf looks for settings and fonts there."""
    try:
        Path.home()
    except RuntimeError:
        os.environ["HOME"] = os.devnull

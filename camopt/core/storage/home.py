"""Users without a home folder, as in a container that runs under a numeric user id."""

import os
from pathlib import Path


def ensure_home_folder() -> None:
    """Set an empty home folder if the system knows none; ezdxf looks for settings and fonts there."""
    try:
        Path.home()
    except RuntimeError:
        os.environ["HOME"] = os.devnull

"""The cam for other programs, machines and people: files of drawings, solids, points and tables."""

import os
from pathlib import Path

try:
    Path.home()
except RuntimeError:  # a user whom the system does not know; ezdxf looks for settings and fonts there
    os.environ["HOME"] = os.devnull

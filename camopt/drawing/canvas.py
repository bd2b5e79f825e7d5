"""The sheet of every picture: a figure in the one style, and its file, which appears only when whole."""

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.drawing.style import RC
from camopt.storage.files import checked_suffix, whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STILL_KINDS = (".png", ".svg", ".pdf")
DATES: dict[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


Target = str | os.PathLike[str] | None
"""The file of a picture; None for a figure that is only drawn."""


@contextmanager
def canvas(path: Target, size: tuple[float, float], *, powers: bool = False, **options: Any) -> "Iterator[Figure]":
    """An empty figure of a size in inches, which is saved to the path, if any, when the block ends without error.

    The suffix of the path gives the format; the errors are those of ``plot``. The same drawing gives the same
    file. A $ in a text stays a $, unless ``powers`` asks for axes with powers of ten.
    """
    import matplotlib.style

    from camopt.drawing.empty_figure import EmptyFigure

    if path is not None:
        checked_suffix(path, "path", STILL_KINDS)
    with (
        matplotlib.style.context(["default", {**RC, "text.parse_math": powers}], after_reset=True),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script the font lacks
        figure = EmptyFigure(size, **options)
        yield figure
        if path is None:
            figure.draw_without_rendering()  # makes the ticks, in this style, wherever the figure is shown later
        else:
            suffix = Path(path).suffix.lower()
            drawn = BytesIO()  # a file that cannot be finished gives matplotlib other trouble than the disk's
            figure.savefig(drawn, format=suffix[1:], metadata=DATES.get(suffix))
            with whole_file(path) as partial:
                partial.write_bytes(drawn.getvalue())

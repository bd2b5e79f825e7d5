"""The sheet of every picture: a figure in the one style, and its file, which appears only when whole."""

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.drawing.style import RC
from camopt.files import checked_suffix, whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (".png", ".svg", ".pdf")
DATES: dict[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


@contextmanager
def canvas(
    path: str | os.PathLike[str] | None, size: tuple[float, float], *, powers: bool = False, **options: Any
) -> "Iterator[Figure]":
    """An empty figure of a size in inches, saved as the suffix of the path says when the block ends well.

    Without a path it is only drawn. The same drawing gives the same file. Text stays as it is, unless axes are
    marked with ``powers`` of ten.

    Raises
    ------
    BadInput
        For another suffix.
    OSError
        If the file cannot be written.
    """
    import matplotlib.style

    from camopt.drawing.sheet import Sheet

    if path is not None:
        checked_suffix(path, "path", KINDS)
    with (
        matplotlib.style.context(["default", {**RC, "text.parse_math": powers}], after_reset=True),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script the font lacks
        figure = Sheet(size, **options)
        yield figure
        figure.draw_without_rendering()  # ticks are made here, in this style, wherever the figure is shown
        if path is not None:
            suffix = Path(path).suffix.lower()
            with whole_file(path) as partial:
                figure.savefig(partial, format=suffix[1:], metadata=DATES.get(suffix))

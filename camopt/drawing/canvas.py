"""The sheet of every picture: a figure in the one style, and its file, which appears only when whole."""

import os
import warnings
from collections.abc import Iterator, Sequence
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
    with pages(path, [size], powers=powers, **options) as (figure,):
        yield figure


@contextmanager
def style(*, powers: bool = False) -> Iterator[None]:
    """The one style of all pictures, while the block runs."""
    import matplotlib.style

    with (
        matplotlib.style.context(["default", {**RC, "text.parse_math": powers}], after_reset=True),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script the font lacks
        yield


@contextmanager
def pages(
    path: Target, sizes: Sequence[tuple[float, float]], *, powers: bool = False, **options: Any
) -> "Iterator[Sequence[Figure]]":
    """Empty figures as of ``canvas``, the pages of one file; only a PDF has more than one."""
    from camopt.drawing.empty_figure import EmptyFigure  # noqa: PLC0415  it imports matplotlib

    if path is not None:
        checked_suffix(path, "path", STILL_KINDS if len(sizes) == 1 else (".pdf",))
    with style(powers=powers):
        figures = [EmptyFigure(size, **options) for size in sizes]
        yield figures
        if path is None:
            for figure in figures:
                figure.draw_without_rendering()  # makes the ticks, in this style, wherever it is shown later
        else:
            drawn = _drawn(figures, Path(path).suffix.lower())
            with whole_file(path) as partial:
                partial.write_bytes(drawn)


def _drawn(figures: "Sequence[Figure]", suffix: str) -> bytes:
    """The bytes of a file; one that cannot be finished gives matplotlib other trouble than the disk's."""
    file = BytesIO()
    if suffix == ".pdf":
        from matplotlib.backends.backend_pdf import PdfPages

        with PdfPages(file, metadata=DATES[suffix]) as book:
            for figure in figures:
                figure.savefig(book, format="pdf")
    else:
        (figure,) = figures
        figure.savefig(file, format=suffix[1:], metadata=DATES.get(suffix))
    return file.getvalue()

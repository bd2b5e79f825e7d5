"""The style of all pictures (colours, lines, text sizes), and figures that are saved as whole files.

The colours of a series are from Okabe and Ito, Color Universal Design (2008): people with any colour vision can
tell them apart. Lines of a series also differ in dashes or marks.
"""

import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camopt.core.storage.files import atomically_written_file, checked_suffix
from camopt.model.motion.stroke import DWELL, RETURN, RISE

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure
else:
    Figure = Any  # matplotlib is imported only when a picture is drawn

INK, MUTED, FAINT, FILL, BODY, ALARM = "#22303c", "#5f6b76", "#c3cad1", "#eef2f5", "#dbe1e7", "#b3261e"
PALE_ALARM = "#f4dedd"  # for areas, since printers lose opacity
PITCH_COLOUR, REFERENCE_COLOUR, SECOND_COLOUR = "#3f7d58", "#8a6fae", "#b58a1b"
COLOURS = {RISE: "#2a6ca3", RETURN: "#c0632a", DWELL: "#45525e"}
SHADES = {RISE: "#e9f1f8", RETURN: "#faefe6", DWELL: "white"}
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#22303c", "#8c8c8c")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (1, 1.5)), (0, (7, 2, 1.5, 2)))

PAGE_TITLE, TITLE_SIZE, HEADING_SIZE, TEXT_SIZE, SMALL_SIZE = 14.0, 10.5, 8.5, 8.0, 7.5  # points
PROFILE_WIDTH = 1.3  # points: outlines of cam and follower are at least this thick
GRID_STYLE: dict[str, Any] = {"lw": 0.4, "color": FAINT, "alpha": 0.6}
DOT_STYLE: dict[str, Any] = {"ls": "none", "marker": ".", "ms": 3.0, "mew": 0.0}
LIMIT_STYLE: dict[str, Any] = {"color": ALARM, "lw": 1.0, "ls": (0, (5, 3))}

RC_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "camopt",  # the same picture gives the same file
    "pdf.fonttype": 42,
    "font.size": TEXT_SIZE,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": HEADING_SIZE,
    "axes.titley": 1.0,  # else matplotlib looks for ticks above the axes, which no picture has
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": SMALL_SIZE,
    "ytick.labelsize": SMALL_SIZE,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.frameon": False,
    "legend.fontsize": TEXT_SIZE,
    "hatch.linewidth": 0.6,
    "hatch.color": MUTED,
}
WHITE_BACKGROUND: dict[str, Any] = {"zorder": 6, "bbox": {"fc": "white", "ec": "none", "pad": 1.0}}
"""Style of a text on a white background, so that lines do not cross it."""


def series_line_style(series_index: int) -> dict[str, Any]:
    """Colour and dashes of a line of a series. Lines of the same colour differ in dashes."""
    rounds, colour = divmod(series_index, len(SERIES))
    return {"color": SERIES[colour], "ls": DASHES[(colour + rounds) % len(DASHES)]}


def add_grid(axes: Any) -> None:
    """Draw the grid of a diagram."""
    axes.grid(True, which="major", zorder=0.5, **GRID_STYLE)


STILL_KINDS = (".png", ".svg", ".pdf")
DATE_METADATA: dict[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


Target = str | os.PathLike[str] | None
"""The file of a picture; None to draw without saving."""
Targets = Target | Sequence[str | os.PathLike[str]]
"""The file of a picture, or its files; None to draw without saving."""


@contextmanager
def new_figure(path: Targets, size: tuple[float, float], **options: Any) -> "Iterator[Figure]":
    """An empty figure of a size in inches. With a path or several, it is saved when the block ends without error.

    The suffix of a path gives the format; the errors are those of ``plot``. The same drawing gives the same
    file. A $ in a text stays a $.
    """
    with figure_pages(path, [size], **options) as (figure,):
        yield figure


@contextmanager
def picture_style() -> Iterator[None]:
    """Within the block, the style of all pictures."""
    import matplotlib.style

    with (
        matplotlib.style.context(["default", RC_SETTINGS], after_reset=True),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script the font lacks
        yield


@contextmanager
def figure_pages(
    path: Targets, sizes: Sequence[tuple[float, float]], **options: Any
) -> "Iterator[Sequence[Figure]]":
    """Empty figures as in ``canvas``, the pages of one file. Only a PDF has several pages."""
    from camopt.show.drawing.empty_figure import EmptyFigure  # noqa: PLC0415  it imports matplotlib

    paths = [] if path is None else [path] if isinstance(path, str | os.PathLike) else path
    for each in paths:
        checked_suffix(each, "path", STILL_KINDS if len(sizes) == 1 else (".pdf",))
    with picture_style():
        figures = [EmptyFigure(size, **options) for size in sizes]
        yield figures
        layouts = [figure.get_layout_engine() for figure in figures]
        for figure, layout in zip(figures, layouts, strict=True):  # else matplotlib lays out twice a drawing
            if layout is not None:
                layout.execute(figure)
            figure.set_layout_engine(None)
        for each in paths:
            data = _figure_bytes(figures, Path(each).suffix.lower())
            with atomically_written_file(each) as partial:
                partial.write_bytes(data)
        for figure, layout in zip(figures, layouts, strict=True):
            figure.set_layout_engine(layout)
        if not paths:
            for figure in figures:
                figure.draw_without_rendering()  # makes the ticks in this style, also if the figure is shown later


def _figure_bytes(figures: "Sequence[Figure]", suffix: str) -> bytes:
    """The bytes of a picture file, made in memory: matplotlib hides errors of the disk."""
    file = BytesIO()
    if suffix == ".pdf":
        from matplotlib.backends.backend_pdf import PdfPages

        with PdfPages(file, metadata=DATE_METADATA[suffix]) as book:
            for figure in figures:
                figure.savefig(book, format="pdf")
    else:
        (figure,) = figures
        figure.savefig(file, format=suffix[1:], metadata=DATE_METADATA.get(suffix))
    return file.getvalue()

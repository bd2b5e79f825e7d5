"""The sheet that every picture is drawn on: its style, and its file, which appears only when whole."""

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from camopt.drawing.picture import FAINT, INK, MUTED
from camopt.files import whole_file

KINDS = (".png", ".svg", ".pdf")
DATES: dict[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
STYLE: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "camopt",  # the same picture gives the same file
    "font.size": 8,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "hatch.linewidth": 0.6,
    "hatch.color": MUTED,
}


@contextmanager
def canvas(
    path: str | os.PathLike[str], size: tuple[float, float], *, dpi: int = 150, powers: bool = False, **options: Any
) -> Iterator[Any]:
    """An empty figure of a size in inches, saved as the suffix of the path says when the block ends well.

    The same drawing gives the same file. Text stays as it is, unless axes are marked with ``powers`` of ten.
    """
    import matplotlib.style
    from matplotlib.figure import Figure

    suffix, style = Path(path).suffix.lower(), {**STYLE, "text.parse_math": powers}
    with matplotlib.style.context(["default", style], after_reset=True), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script the font lacks
        figure = Figure(figsize=size, facecolor="white", **options)
        yield figure
        with whole_file(path) as partial:
            figure.savefig(partial, format=suffix[1:], dpi=dpi, metadata=DATES.get(suffix))

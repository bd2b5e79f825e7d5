"""The gallery's eye for camopt's own figures, which pyplot does not know of, and the style of all others."""

import gc
from typing import Any

import matplotlib
from cycler import cycler
from sphinx_gallery.scrapers import figure_rst

from camopt.show.drawing.empty_figure import EmptyFigure
from camopt.show.drawing.style import FAINT, RC_SETTINGS, SERIES

DPI = 110
STYLE: dict[str, Any] = {
    **RC_SETTINGS,
    "axes.grid": True,
    "axes.prop_cycle": cycler(color=SERIES),
    "figure.constrained_layout.use": True,
    "figure.figsize": (8.0, 4.5),
    "grid.alpha": 0.5,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "savefig.dpi": 160,  # pages scale it down
    **dict.fromkeys(("font.size", "axes.titlesize"), 9.5),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8.5),
}


def dress(gallery_conf: dict[str, Any], name: str) -> None:
    """Give the plain figures of a script the colours and lines of camopt's own."""
    matplotlib.rcParams.update(STYLE)
    gc.freeze()  # the gallery looks for garbage before each script: not among what the others have imported


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """The figure that the last expression of a block gives, and those that it names, each drawn once."""
    seen: list[EmptyFigure] = block_vars.setdefault("sheets", [])
    values = block_vars["example_globals"].values()
    found = {id(value): value for value in values if isinstance(value, EmptyFigure) and value not in seen}
    seen += found.values()
    paths = []
    for sheet, path in zip(found.values(), block_vars["image_path_iterator"], strict=False):
        sheet.savefig(path, dpi=DPI)
        paths.append(path)
    return figure_rst(paths, gallery_conf["src_dir"])

"""The one style of all pictures: colours, pens, sizes of text.

The colours of a series are those of Okabe and Ito, Color Universal Design (2008), which people of every colour
vision tell apart; its lines differ in dashes or marks as well.
"""

from typing import Any

from camopt.motion.table import DWELL, RETURN, RISE

INK, MUTED, FAINT, FILL, BODY, ALARM = "#22303c", "#5f6b76", "#c3cad1", "#eef2f5", "#dbe1e7", "#b3261e"
PALE_ALARM = "#f4dedd"  # of areas: printers lose opacity
PITCH_COLOUR, REFERENCE_COLOUR, SECOND_COLOUR = "#3f7d58", "#8a6fae", "#b58a1b"
COLOURS = {RISE: "#2a6ca3", RETURN: "#c0632a", DWELL: "#45525e"}
SHADES = {RISE: "#e9f1f8", RETURN: "#faefe6", DWELL: "white"}
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#22303c", "#8c8c8c")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (1, 1.5)), (0, (7, 2, 1.5, 2)))

PAGE_TITLE, TITLE_SIZE, HEADING, TEXT, SMALL = 14.0, 10.5, 8.5, 8.0, 7.5  # points
PROFILE = 1.3  # points: lines as thick as that are the outlines of a cam and its follower
GRID_STYLE: dict[str, Any] = {"lw": 0.4, "color": FAINT, "alpha": 0.6}
DOT: dict[str, Any] = {"ls": "none", "marker": ".", "ms": 3.0, "mew": 0.0}
LIMIT: dict[str, Any] = {"color": ALARM, "lw": 1.0, "ls": (0, (5, 3))}

RC: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "camopt",  # the same picture gives the same file
    "pdf.fonttype": 42,
    "font.size": TEXT,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": HEADING,
    "axes.titley": 1.0,  # or each drawing looks for ticks above the axes, which no picture has
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.frameon": False,
    "legend.fontsize": TEXT,
    "hatch.linewidth": 0.6,
    "hatch.color": MUTED,
}
ON_WHITE: dict[str, Any] = {"zorder": 6, "bbox": {"fc": "white", "ec": "none", "pad": 1.0}}
"""Text that lines do not cross."""


def pen_of(place: int) -> dict[str, Any]:
    """Colour and dashes of a line of a series, by its place; lines of one colour have other dashes."""
    rounds, colour = divmod(place, len(SERIES))
    return {"color": SERIES[colour], "ls": DASHES[(colour + rounds) % len(DASHES)]}


def dress(axes: Any) -> None:
    """The grid that all diagrams have."""
    axes.grid(True, which="major", zorder=0.5, **GRID_STYLE)

"""The picture of what accuracy costs: error against time, log-log, the losing methods in it."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from camopt.drawing.canvas import Target, canvas
from camopt.drawing.labels import Label, around, settle
from camopt.drawing.style import FAINT, INK, MUTED, PAGE_TITLE, SERIES, SMALL, TITLE, dress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PENS: dict[str, dict[str, Any]] = {
    "sampling": {"color": SERIES[1], "marker": "o"},
    "sampling, polished": {"color": SERIES[4], "marker": "s"},
    "enclosure": {"color": SERIES[0], "marker": "D"},
    "balls": {"color": INK, "marker": "^"},
}
LABELLED = (36, 360, 720, 3600)  # angles that are written at their points
LABELS: dict[str, Callable[[dict[str, Any]], str]] = {
    "sampling": lambda row: f"{row['setting']:g} angles" if row["setting"] in LABELLED else "",
    "sampling, polished": lambda row: "",
    "enclosure": lambda row: f"to {row['setting']:.0e}",
    "balls": lambda row: "any digits, proved",
}
LABEL_DISTANCES = (7.0, 14.0, 22.0, 32.0)  # points: of a label from its point
FLOOR = 3e-17  # errors below a double's rounding are drawn there
EPSILON = 2.2e-16


def draw(rows: Sequence[dict[str, Any]], path: Target = None, title: str = "") -> "Figure":
    """Draw what accuracy costs: the largest error of each method against its time, a diagram for each quantity."""
    names = list(dict.fromkeys(row["quantity"] for row in rows))
    with canvas(path, (6.4 * len(names), 5.6), powers=True, layout="constrained") as figure:
        heading = f"What accuracy costs: {title}" if title else "What accuracy costs"
        figure.suptitle(heading, x=0.01, ha="left", fontsize=PAGE_TITLE, weight="bold")
        panels = figure.subplots(1, len(names), squeeze=False, sharey=True)[0]
        labels = [
            label
            for axes, name in zip(panels, names, strict=True)
            for label in _draw(axes, name, [row for row in rows if row["quantity"] == name])
        ]
        panels[0].set_ylabel("largest relative error, against ball arithmetic")
        handles = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(handles))
        settle(figure, labels)
    return figure


def _draw(axes: Any, name: str, rows: list[dict[str, Any]]) -> list[Label]:
    """One quantity; the labels of its points."""
    axes.set(xscale="log", yscale="log", xlabel="time for each design, ns", ylim=(FLOOR / 3, 3.0))
    axes.set_title(name, loc="left", fontsize=TITLE)
    axes.axhspan(FLOOR / 3, EPSILON, color=FAINT, alpha=0.2, lw=0)
    axes.text(0.01, 0.01, "below a double's rounding", transform=axes.transAxes, fontsize=SMALL, color=MUTED)
    labels = []
    for method, pen in PENS.items():
        points = sorted((row for row in rows if row["method"] == method), key=lambda row: float(row["setting"]))
        times = [row["ns_per_design"] for row in points]
        errors = [max(row["error_max"], FLOOR) for row in points]
        axes.plot(times, errors, "-", lw=1.4, ms=5, label=method, **pen)
        texts = [LABELS[method](row) for row in points]
        style, places = {"fontsize": SMALL, "color": pen["color"]}, around(LABEL_DISTANCES)
        labels += [
            Label(axes, text, at, places, style)
            for text, at in zip(texts, zip(times, errors, strict=True), strict=True)
            if text
        ]
        if method == "enclosure":
            asked = [row["setting"] for row in points]
            axes.plot(times, asked, ls="none", mfc="white", ms=5, label="enclosure, error asked for", **pen)
            axes.vlines(times, errors, asked, color=pen["color"], lw=0.8, alpha=0.6)
    axes.set_xlim(left=min(20.0, *(row["ns_per_design"] for row in rows)))
    dress(axes)
    return labels

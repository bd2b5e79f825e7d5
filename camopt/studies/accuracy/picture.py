"""The picture of what accuracy costs: error against time, log-log, the losing methods in it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.drawing.canvas import Target, canvas
from camopt.drawing.labels import Label, around, settle
from camopt.drawing.style import FAINT, HEADING, INK, MUTED, PAGE_TITLE, SERIES, SMALL, dress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camopt.studies.accuracy.table import Costs

PENS: dict[str, dict[str, Any]] = {
    "sampling": {"color": SERIES[1], "marker": "o"},
    "sampling, polished": {"color": SERIES[4], "marker": "s"},
    "enclosure": {"color": SERIES[0], "marker": "D"},
    "50 digits": {"color": INK, "marker": "^"},
}
POINT_LABELS: dict[Any, str] = {
    "50 digits": "any digits",
    ("sampling", 36): "36 angles",
    ("sampling", 360): "360",
    ("sampling", 3600): "3600 angles",
    **{("enclosure", 10.0**-k): f"asked for 1e-{k:02}" for k in (4, 6, 9, 12)},
}
LABEL_DISTANCES = (6.0, 12.0, 20.0, 30.0)  # points: of a label from its point
FLOOR = 3e-17  # errors below a double's rounding are drawn there
EPSILON = 2.2e-16
USUAL_ERROR = 1e-9  # the relative error of a scene that names none


def draw(costs: "Costs", path: Target = None) -> "Figure":
    """Draw what accuracy costs: the largest error of each method against its time, a diagram for each quantity."""
    rows = costs.methods
    names = list(dict.fromkeys(row["quantity"] for row in rows))
    with canvas(path, (4.3 * len(names), 4.6), powers=True, layout="constrained") as figure:
        figure.suptitle(
            f"What accuracy costs: {costs.scene.name}", x=0.01, ha="left", fontsize=PAGE_TITLE, weight="bold"
        )
        panels = figure.subplots(1, len(names), squeeze=False, sharey=True)[0]
        labels: list[Label] = []
        for axes, name in zip(panels, names, strict=True):
            labels += _draw(axes, name, [row for row in rows if row["quantity"] == name])
        panels[0].set_ylabel("largest relative error, against 50 digits")
        handles = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(handles))
        settle(figure, labels)
    return figure


def _draw(axes: Any, name: str, rows: list[dict[str, Any]]) -> list[Label]:
    """One quantity; the labels of its points."""
    from matplotlib.ticker import EngFormatter

    axes.set(xscale="log", yscale="log", xlabel="time for each design", ylim=(FLOOR / 3, 3.0))
    axes.xaxis.set_major_formatter(EngFormatter("s"))
    axes.set_title(f"{name}\n{_told(rows)}", loc="left", fontsize=HEADING)
    axes.axhspan(FLOOR / 3, EPSILON, color=FAINT, alpha=0.2, lw=0)
    axes.text(0.01, 0.01, "below a double's rounding", transform=axes.transAxes, fontsize=SMALL, color=MUTED)
    labels = []
    for method, pen in PENS.items():
        points = sorted((row for row in rows if row["method"] == method), key=lambda row: float(row["setting"]))
        times, errors = (
            [row["ns_per_design"] / 1e9 for row in points],
            [max(row["error_max"], FLOOR) for row in points],
        )
        axes.plot(times, errors, "-", lw=1.4, ms=5, label=method, **pen)
        texts = [POINT_LABELS.get((method, row["setting"]), POINT_LABELS.get(method, "")) for row in points]
        style, places = {"fontsize": SMALL, "color": pen["color"]}, around(LABEL_DISTANCES)
        placed = zip(texts, zip(times, errors, strict=True), strict=True)
        labels += [Label(axes, text, at, places, style) for text, at in placed if text]
    dress(axes)
    return labels


def _told(rows: list[dict[str, Any]]) -> str:
    """What the usual accuracy takes, and how many samples that is; empty where it was not measured."""
    samples = sorted((row["ns_per_design"], row["setting"]) for row in rows if row["method"] == "sampling")
    found = [row["ns_per_design"] for row in rows if (row["method"], row["setting"]) == ("enclosure", USUAL_ERROR)]
    if not samples or not found:
        return ""
    times, angles = zip(*samples, strict=True)
    return f"1e-9, proved, in {found[0] / 1e3:.2g} µs: the time of {np.interp(found[0], times, angles):.0f} samples"

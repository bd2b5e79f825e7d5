"""The picture of response spectra: what is left over in the dwell and how hard the mass is driven, law by law."""

import os
from typing import Any

from camopt.drawing.canvas import canvas
from camopt.drawing.picture import FAINT, INK, MUTED
from camopt.rows import Rows

COLOURS = ("#2a6ca3", "#c0632a", "#3f7d58", "#8a6fae", "#b3261e", "#45525e", "#c2781a", "#0b6e99")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (1, 1.5)), (0, (7, 2, 1.5, 2)))
PANELS = {
    "residual": "Amplitude left over in the dwell, of the lift",
    "acceleration": "Largest acceleration of the mass, lift/t₁²",
}
LEAST = 1e-4  # amplitudes of a smaller share of the lift fall off the picture
SHOWN = (1e-4, 1e-3, 1e-2, 0.1, 1.0)


def plot_spectrum(rows: Rows, path: str | os.PathLike[str]) -> None:
    """Draw the rows of ``spectrum`` to a PNG, SVG or PDF file."""
    with canvas(path, (12.5, 5.6), layout="constrained") as figure:
        damping = float(rows.column("damping_ratio")[0])
        title = f"After a rise in the time t₁: a train of natural period Tₙ, damping ratio {damping:g}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold", color=INK)
        for axes, name in zip(figure.subplots(1, 2), PANELS, strict=True):
            _draw(axes, name, rows)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=8, fontsize=8.5, frameon=False)


def _draw(axes: Any, name: str, rows: Rows) -> None:
    laws, ratios, values = (rows.column(each) for each in ("law", "period_ratio", name))
    for place, law in enumerate(dict.fromkeys(laws.tolist())):
        here = laws == law
        style = {"color": COLOURS[place % len(COLOURS)], "ls": DASHES[place // len(COLOURS) % len(DASHES)]}
        axes.plot(ratios[here], values[here], lw=1.4, label=law, **style)
    axes.set(xlim=(0.0, ratios.max()), xlabel="period ratio t₁/Tₙ")
    axes.locator_params(axis="x", nbins=11)
    if name == "residual":
        axes.set(yscale="log", ylim=(LEAST, 2.0 * max(1.0, float(values.max()))))
        axes.set_yticks(SHOWN, labels=[f"{share:g}" for share in SHOWN])
        axes.minorticks_off()
    else:
        axes.set_ylim(0.0, 1.05 * float(values.max()))
    axes.set_title(PANELS[name], loc="left", fontsize=9.5, color=INK)
    axes.grid(True, which="major", lw=0.4, color=FAINT, alpha=0.6)
    axes.tick_params(length=2.5, colors=MUTED)
    axes.spines[["top", "right"]].set_visible(False)

"""The picture of response spectra: residual vibration and peak acceleration of the mass, law by law."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.drawing.canvas import Target, canvas
from camopt.drawing.style import PAGE_TITLE, dress, pen_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLES = {
    "residual": "Residual amplitude in the dwell, as a share of the lift",
    "acceleration": "Largest acceleration of the mass, in lift/t₁²",
}
LEAST_AMPLITUDE = 1e-4  # amplitudes of a smaller share of the lift fall off the picture
AMPLITUDE_TICKS = (1e-4, 1e-3, 1e-2, 0.1, 1.0)


def draw(what: Mapping[str, Any] | Sequence[Mapping[str, Any]], path: Target = None) -> "Figure":
    """Draw response spectra: residual amplitude in the dwell, and largest acceleration of the mass."""
    spectra = [what] if isinstance(what, Mapping) else what
    with canvas(path, (12.5, 5.6), layout="constrained") as figure:
        damping = {float(each) for spectrum in spectra for each in np.ravel(spectrum["damping_ratio"])}
        ratio = " and ".join(f"{each:g}" for each in sorted(damping))
        title = f"Follower train after a rise in the time t₁: natural period Tₙ, damping ratio {ratio}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        for axes, name in zip(figure.subplots(1, 2), TITLES, strict=True):
            _draw(axes, name, spectra)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=8)
    return figure


def _draw(axes: Any, name: str, spectra: Sequence[Mapping[str, Any]]) -> None:
    ratios, values = (np.concatenate([each[column] for each in spectra]) for column in ("period_ratio", name))
    for place, spectrum in enumerate(spectra):
        law = str(spectrum["law"][0])
        axes.plot(spectrum["period_ratio"], spectrum[name], lw=1.4, label=law, **pen_of(place))
    axes.set(xlim=(0.0, ratios.max()), xlabel="period ratio t₁/Tₙ")
    axes.locator_params(axis="x", nbins=11)
    if name == "residual":
        axes.set(yscale="log", ylim=(LEAST_AMPLITUDE, 2.0 * max(1.0, float(values.max()))))
        axes.set_yticks(AMPLITUDE_TICKS, labels=[f"{share:g}" for share in AMPLITUDE_TICKS])
        axes.minorticks_off()
    else:
        axes.set_ylim(0.0, 1.05 * float(values.max()))
    axes.set_title(TITLES[name], loc="left")
    dress(axes)

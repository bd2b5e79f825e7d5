"""The picture of harmonics: amplitudes of the displacement and of the acceleration, by order."""

from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.drawing.canvas import Target, canvas
from camopt.drawing.style import PAGE_TITLE, dress, pen_of
from camopt.quantities import displacement_unit
from camopt.quantities.unit_systems import shown, shown_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camopt.studies.harmonics import Harmonics

LEAST_SHARE = 1e-6  # of the largest amplitude: smaller ones fall off the picture


def draw(what: "Harmonics", path: Target = None) -> "Figure":
    """Draw the amplitudes of a motion's harmonics."""
    unit = displacement_unit(angular=what.scene.tool_turns)
    amplitudes = (
        (f"Displacement, {shown_unit(unit)}", shown(what.displacement, unit)),
        (f"Acceleration, {shown_unit(what.acceleration_unit)}", shown(what.acceleration, what.acceleration_unit)),
    )
    with canvas(path, (12.5, 5.0), layout="constrained") as figure:
        title = f"{what.scene.name}: harmonics of the motion"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        for axes, (name, values) in zip(figure.subplots(1, 2), amplitudes, strict=True):
            _draw(axes, name, what, values)
    return figure


def draw_in(axes: Any, what: "Harmonics") -> None:
    """Draw the amplitudes of the displacement."""
    unit = displacement_unit(angular=what.scene.tool_turns)
    _draw(axes, f"Displacement, {shown_unit(unit)}", what, shown(what.displacement, unit))


def _draw(axes: Any, name: str, what: "Harmonics", values: Any) -> None:
    largest = float(np.max(values))
    seen = values > LEAST_SHARE * largest
    floor = 10.0 ** np.floor(np.log10(values[seen].min()))
    axes.vlines(what.order[seen], floor, values[seen], lw=2.0, color=pen_of(0)["color"])
    axes.plot(what.order[seen], values[seen], ls="", marker="o", ms=4.0, color=pen_of(0)["color"])
    turn = "" if what.frequency_Hz is None else f", in multiples of {what.frequency_Hz[0]:.6g} Hz"
    axes.set(yscale="log", xlim=(0.0, float(what.order[-1]) + 1.0), xlabel=f"harmonic{turn}")
    axes.set_ylim(floor, 2.0 * largest)
    tens = 10.0 ** np.arange(round(np.log10(floor)), np.floor(np.log10(2.0 * largest)) + 1)
    axes.set_yticks(tens, labels=[f"{each:g}" for each in tens])
    axes.minorticks_off()
    axes.set_title(name, loc="left")
    dress(axes)

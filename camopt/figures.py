"""One picture of one design: the diagrams of its motion, pressure angle and curvature, and the cam to scale."""

import os
import warnings
from collections.abc import Sequence
from math import floor, isfinite, log10
from typing import Any

import numpy as np

from camopt.drawing_cam import draw_disc, draw_groove
from camopt.effects.motion import scale
from camopt.evaluation import excesses, resolve, violations
from camopt.motion.table import DWELL, RETURN, RISE
from camopt.numerics import FloatArray
from camopt.picture import ALARM, COLOURS, FAINT, INK, MUTED, NAMES, PITCH, REFERENCE, Picture
from camopt.points import checked_suffix, whole_file
from camopt.quantities import DERIVATIVES
from camopt.scene import Scene

STYLE: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "camopt",  # the same picture gives the same file
    "font.size": 8,
    "font.family": "DejaVu Sans",
    "text.parse_math": False,
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
SHADES = {RISE: "#e9f1f8", RETURN: "#faefe6", DWELL: "white"}
DEGREES_A_LETTER = 3.6  # that a letter above the diagrams takes
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
CLIP = 4.0  # times the largest pitch curvature, or 1/R_r: where the diagram of curvature is cut off

Values = Sequence[FloatArray]


def plot(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Draw a scene's cam, with its follower and diagrams, to a PNG, SVG or PDF file, as its suffix says.

    Diagrams run over one turn of the cam in deg: displacement, velocity, acceleration and jerk (by time if the
    scene has an rpm, by cam angle if not), pressure angle (contact on the face, for a face square to the
    motion) and curvature. Peaks carry their exact values; jumps are breaks, impulses arrows. A disc cam is
    drawn at cam angle 0, the follower at its lowest; the groove of a cylindrical cam is developed. Lengths in
    mm. The same scene gives the same file, and the file appears only when whole.

    Raises
    ------
    BadInput
        For another suffix.
    OSError
        If the file cannot be written.
    """
    suffix = checked_suffix(path, "--plot", (".png", ".svg", ".pdf"))
    import matplotlib.style

    dates: dict[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with matplotlib.style.context(["default", STYLE], after_reset=True), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script the font lacks
        figure = _figure(Picture(resolve(scene)))
        with whole_file(path) as partial:
            figure.savefig(partial, format=suffix[1:], dpi=160, metadata=dates.get(suffix))


def _figure(picture: Picture) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15.5, 10.0), facecolor="white")
    diagrams, cam = _layout(figure, picture.question.subject.mechanism.grooved)
    _header(figure, picture)
    for axes, draw in zip(diagrams, (_displacement, *[_derivative] * 3, _pressure, _curvature), strict=True):
        draw(axes, picture)
    if not picture.exists:
        cam.set_axis_off()
        cam.text(0.5, 0.5, "this mechanism cannot be put together", ha="center", color=ALARM, fontsize=11)
        return figure
    (draw_groove if picture.question.subject.mechanism.grooved else draw_disc)(cam, picture)
    handles, labels = cam.get_legend_handles_labels()
    place = {"loc": "lower center", "bbox_to_anchor": _legend_place(picture), "frameon": False}
    figure.legend(handles, labels, ncols=min(len(labels), 4), fontsize=8, columnspacing=1.8, **place)
    return figure

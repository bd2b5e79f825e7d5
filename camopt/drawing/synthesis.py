"""Before and after: the cam of a known law and that of free laws, at one scale, and their motions."""

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from camopt.drawing.cam import draw_disc
from camopt.drawing.canvas import KINDS, canvas
from camopt.drawing.groove import draw_groove
from camopt.drawing.picture import COLOURS, FAINT, INK, MUTED, Picture, number
from camopt.effects.motion import scale
from camopt.files import checked_suffix
from camopt.motion import LAWS
from camopt.motion.table import RETURN, RISE
from camopt.quantities import QUANTITIES, motion_quantity
from camopt.question import resolve
from camopt.scene import Scene
from camopt.synthesis.synthesised import Synthesised

BEFORE, AFTER = MUTED, COLOURS[RISE]
SAME = 1e-6  # relative: laws as rough as each other
ROWS = ("displacement", "velocity", "acceleration", "jerk")


def plot_synthesis(
    scene: Scene, known: Mapping[str, dict[str, Any]], result: Synthesised, path: str | os.PathLike[str]
) -> None:
    """Draw the smallest cam of a known law beside that of free laws, to a PNG, SVG or PDF file.

    The known law is the one of the smallest cam among those within the peak factors of the free laws, or of all.

    Raises
    ------
    BadInput
        For another suffix.
    OSError
        If the file cannot be written.
    """
    checked_suffix(path, "--plot", KINDS)
    before, after = Picture(resolve(best_known(scene, known, result))), Picture(resolve(result.scene))
    with canvas(path, (15.5, 9.0)) as figure:
        figure.text(0.04, 0.955, scene.name, fontsize=15, fontweight="bold")
        _cams(figure, before, after)
        _motions(figure, before, after)


def best_known(scene: Scene, known: Mapping[str, dict[str, Any]], result: Synthesised) -> Scene:
    """The scene with the known law of the smallest cam that is no rougher than the free laws, or of all."""
    from camopt.designs import chosen
    from camopt.synthesis.synthesised import peaks_of

    free = peaks_of(result.design, result)
    gentle = [
        row
        for row in known.values()
        if all(
            peaks_of(row, result)[name] <= free[name] * (1 + SAME) for name in ("peak_acceleration", "peak_jerk")
        )
    ]
    row = next(iter(gentle or known.values()), None)
    if row is None:
        return scene
    laws = {"rise": row["law_rise"], "return": row["law_return"]}
    data = chosen(scene, row).to_dict()
    for segment in data["motion"]:
        if segment["segment"] in laws and laws[segment["segment"]] in {**LAWS, **data.get("laws", {})}:
            segment["law"] = laws[segment["segment"]]
    return Scene.from_dict(data, scene.file)


def _cams(figure: Any, before: Picture, after: Picture) -> None:
    """Both cams, in axes of the same limits: discs side by side, developed grooves one above the other."""
    disc = not before.question.subject.mechanism.grooved
    places = [(0.03, 0.06, 0.27, 0.82), (0.31, 0.06, 0.27, 0.82)]
    if not disc:
        places = [(0.07, 0.52, 0.51, 0.34), (0.07, 0.08, 0.51, 0.34)]
    axes = [figure.add_axes(place) for place in places]
    for ax, picture in zip(axes, (before, after), strict=True):
        (draw_disc if disc else draw_groove)(ax, picture)
        if not disc:  # a sheet is far wider than high
            low, high = ax.dataLim.intervaly
            ax.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
    limits = np.array([[*ax.get_xlim(), *ax.get_ylim()] for ax in axes])
    lowest = int(limits[:, 2].argmin())
    cams = zip(axes, places, (before, after), (BEFORE, AFTER), strict=True)
    for each, (ax, place, picture, colour) in enumerate(cams):
        ax.set_position(place)
        ax.set(xlim=(limits[:, 0].min(), limits[:, 1].max()), ylim=(limits[:, 2].min(), limits[:, 3].max()))
        ax.set_aspect("equal", anchor="NW")
        size = float(picture.question.design.size[0])
        word = "base" if disc else "mean"
        title = f"{_laws(picture)}\n{word} radius {number(size)} mm"
        ax.set_title(title, loc="left", fontsize=10.5, color=colour)
        if disc and each != lowest:  # one bar for the scale of both
            ax.lines[-1].remove()
            ax.texts[-1].remove()


def _laws(picture: Picture) -> str:
    """The laws of a picture, those of rises first."""
    return " / ".join(dict.fromkeys(picture.question.programme.law_names(k) for k in (RISE, RETURN)))


def _motions(figure: Any, before: Picture, after: Picture) -> None:
    """Displacement to jerk over the turn, the known laws grey and the free ones in colour."""
    subject = before.question.subject
    whats = [motion_quantity(name, "", angular=subject.angular, timed=bool(subject.omega)) for name in ROWS[1:]]
    units = ["deg" if subject.angular else "mm", *(QUANTITIES[what].unit for what in whats)]
    for order, (name, unit) in enumerate(zip(ROWS, units, strict=True)):
        ax = figure.add_axes((0.655, 0.71 - 0.215 * order, 0.325, 0.175))
        per = scale(subject, order) if order else np.degrees(1.0) if subject.angular else 1.0
        for picture, colour, width in ((before, BEFORE, 1.2), (after, AFTER, 1.7)):
            angles = np.concatenate([*(np.append(a, np.nan) for a in picture.pieces)])
            values = np.concatenate([*(np.append(m[order] * per, np.nan) for m in picture.motion)])
            ax.plot(np.degrees(angles), values, color=colour, lw=width, label=_laws(picture))
        ax.set_title(f"{name.capitalize()}, {unit}", loc="left", fontsize=9, color=INK)
        ax.set(xlim=(0, 360), xticks=range(0, 361, 60))
        ax.grid(True, lw=0.4, color=FAINT, alpha=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(length=2.5, labelbottom=order == 3)
        if order == 0:
            ax.legend(loc="upper right", fontsize=8.5, frameon=False, bbox_to_anchor=(1.0, 1.28), ncols=2)
    ax.set_xlabel("cam angle, deg")

"""The picture of the front page: the main job, its smallest cams, and the cam that new motion laws allow.

`python docs/front.py` writes docs/static/front.png.
"""

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import camopt
from camopt.drawing.style import ALARM, FAINT, INK, MUTED, RC, SERIES

PICTURE = Path(__file__).parent / "static" / "front.png"
SCENE = camopt.find_scene("roller-1000rpm").replace(**{"search.roller_radius": [20]})
SMALLEST = dict(sorted(camopt.optimise(SCENE).by_law.items(), key=lambda item: -item[1]["base_radius_mm"]))
COLOURS = dict(zip(SMALLEST, plt.colormaps["viridis"](np.linspace(0.0, 0.95, len(SMALLEST))), strict=True))


def draw_designs(axes: Axes) -> None:
    """The least pressure angle of each size and law, over the offsets; a dot at the smallest cam."""
    sizes, offsets = (
        grid.ravel() for grid in np.meshgrid(np.linspace(25.0, 110.0, 69), np.linspace(2.0, 14.0, 49))
    )
    for law, best in reversed(SMALLEST.items()):
        table = {"base_radius_mm": sizes, "offset_mm": offsets, "roller_radius_mm": 20.0, "law": law}
        least = camopt.evaluate_designs(SCENE, table).groupby("base_radius_mm").pressure_angle_max_deg.min()
        axes.plot(least, color=COLOURS[law], lw=2, label=f"{law} {best['base_radius_mm']:.1f} mm")
        axes.plot(best["base_radius_mm"], 30.0, "o", color=COLOURS[law], mec="white", ms=8, zorder=3)
    axes.axhspan(30.0, 60.0, color=ALARM, alpha=0.08, lw=0)
    axes.axhline(30.0, color=ALARM, ls="--", lw=1)
    axes.set(xlabel="base radius, mm", ylabel="least pressure angle, deg", xlim=(25, 110), ylim=(18, 42))
    axes.set_title("The smallest cam within 30°, for each motion law")
    axes.legend(loc="upper right")


def draw_cam(axes: Axes, scene: camopt.Scene, **style: Any) -> None:
    """The profile of a cam, filled."""
    cam = camopt.cam_points(scene, step=0.5)
    axes.fill(cam["profile_x_mm"], cam["profile_y_mm"], **style)


def draw_smallest(axes: Axes) -> None:
    """The smallest cam of each law, one behind the other."""
    for law, design in SMALLEST.items():
        draw_cam(axes, design.scene, color=COLOURS[law], ec="white", lw=0.8)
    axes.set_title("These cams at one scale")


def draw_free(axes: Axes) -> None:
    """The best textbook law within the same peaks, and free laws."""
    found, known = camopt.synthesise(SCENE), SMALLEST["poly345"]
    label = f"3-4-5 polynomial {known['base_radius_mm']:.1f} mm"
    draw_cam(axes, known.scene, color=FAINT, ec=MUTED, lw=1, label=label)
    label = f"new laws with its peaks {found.design['base_radius_mm']:.1f} mm"
    draw_cam(axes, found.scene, color=SERIES[0], ec="white", lw=1, label=label)
    angle = np.linspace(0, 2 * np.pi, 361)
    axes.plot(found.bound * np.cos(angle), found.bound * np.sin(angle), color="white", ls="--", lw=1.2)
    axes.plot([], [], color=INK, ls="--", lw=1.2, label=f"no motion has less than {found.bound:.1f} mm")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, -0.12))
    axes.set_title("Computed laws: smaller still")


with plt.rc_context(
    {**RC, "font.size": 9, "axes.titlesize": 10.5, "legend.fontsize": 8.5, "axes.titleweight": "bold"}
):
    figure, panels = plt.subplots(1, 3, figsize=(13, 4.4), layout="constrained", width_ratios=(1.3, 1, 1))
    for axes, draw in zip(panels, (draw_designs, draw_smallest, draw_free), strict=True):
        draw(axes)
    for axes in panels[1:]:
        axes.add_patch(plt.Circle((0, 0), 6, color="white"))
        axes.set_aspect("equal")
        axes.axis("off")
        axes.set(xlim=(-130, 76), ylim=(-128, 76))
    figure.savefig(PICTURE, dpi=100, metadata={"Software": None}, pil_kwargs={"optimize": True})

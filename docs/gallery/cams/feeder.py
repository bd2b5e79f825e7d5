"""
A feeder: the groove of a cylindrical cam
=========================================

The slide takes a part, stops on its way, hands the part to a conveyor at 250 mm/s and returns. A
*constant-velocity* segment matches the conveyor; the moves beside it join with continuous velocity and
acceleration.
"""

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import camopt

scene = camopt.find_scene("feeder-with-stop")
cam = camopt.cam_points(scene, step=1)
radius, width = scene.cam.mean_radius, scene.part.thickness

# %%
# Points of a cylindrical cam are developed: x runs round the cylinder at its mean radius. Rolled up again, they
# are the flanks of the groove.

VIEW = 205  # deg, the side that is seen
middle = (cam["pitch_y_mm"].min() + cam["pitch_y_mm"].max()) / 2


def rolled(x, y):
    return radius * np.cos(x / radius), radius * np.sin(x / radius), y - middle


ax = plt.figure(figsize=(8, 5)).add_subplot(projection="3d", computed_zorder=False, proj_type="ortho")
style = {"rcount": 2, "ccount": 360, "lw": 0, "antialiased": False}
around = np.linspace(0, 2 * np.pi * radius, 181)
ends = np.array([[-width / 2], [width / 2]]) + middle
ax.plot_surface(*rolled(around, ends), color="#c9d6e2", **style)
near = np.cos(cam["pitch_x_mm"] / radius - np.radians(VIEW)) > 0
x, y = (np.array([cam[f"profile_{side}_{axis}_mm"][near] for side in ("left", "right")]) for axis in "xy")
ax.plot_surface(*rolled(x, y), color="#22303c", shade=False, **style)
for share in (1, scene.part.bore / (2 * radius)):  # the face and the bore
    x, y, _ = rolled(around, 0)
    colour = "#e6edf3" if share == 1 else "#8a97a4"
    face = Poly3DCollection([np.column_stack([share * x, share * y, np.full_like(x, width / 2)])], color=colour)
    ax.add_collection3d(face)
ax.set_box_aspect((1, 1, 0.5), zoom=1.5)
ax.view_init(elev=22, azim=VIEW)
ax.axis("off")

# %%
# The groove and the motion in one picture:

camopt.plot(scene)

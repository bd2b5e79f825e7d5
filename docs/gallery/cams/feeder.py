"""
A feeder: the groove of a cylindrical cam
=========================================

The slide takes a part, stops on its way, hands the part to a conveyor at 250 mm/s and returns. A
*constant-velocity* segment matches the conveyor; the moves beside it join with continuous velocity and
acceleration.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("feeder-with-stop")
cam = camopt.cam_points(scene, step=0.5)
radius, deep = scene.cam.mean_radius, scene.part.groove_depth

# %%
# Points of a cylindrical cam are developed: x runs round the cylinder at its mean radius. Rolled up again, they
# are the flanks of the groove.

VIEW = 95  # deg
outer, inner = radius + deep / 2, radius - deep / 2
middle = np.ptp(cam["pitch_y_mm"]) / 2 + cam["pitch_y_mm"].min()
figure = plt.figure(figsize=(8, 5))
ax = figure.add_subplot(projection="3d", computed_zorder=False)


def rolled(x, y, r):
    """A developed point on the cylinder of radius r."""
    return r * np.cos(x / radius), r * np.sin(x / radius), y - middle


turn = np.linspace(0, 2 * np.pi * radius, 120)
edge = np.array([[-50.0], [50.0]]) + middle
ax.plot_surface(*rolled(turn, edge, outer), color="#c9d6e2", shade=True, alpha=0.35, lw=0)
seen = np.cos(cam["pitch_x_mm"] / radius - np.radians(VIEW)) > -0.05  # the near side
for side in ("left", "right"):
    x, y = (np.where(seen, cam[f"profile_{side}_{axis}_mm"], np.nan) for axis in "xy")
    ax.plot(*rolled(x, y, outer), color="C0", lw=2)
    ax.plot(*rolled(x, y, inner), color="C0", lw=0.8, alpha=0.5)
x, y = (np.where(seen, cam[f"pitch_{axis}_mm"], np.nan) for axis in "xy")
ax.plot(*rolled(x, y, outer), color="C1", lw=1.2, ls="-.")
for z in (-50, 50):
    ax.plot(*rolled(turn, np.full_like(turn, z + middle), outer), color="#5f6b76", lw=1)
ax.set_box_aspect((1, 1, 0.5), zoom=1.5)
ax.view_init(elev=22, azim=VIEW)
ax.axis("off")

# %%
# The groove and the motion in one picture:

camopt.plot(scene)

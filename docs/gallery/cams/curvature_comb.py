"""
Where a cam is sharp
====================

A curvature comb: the length of each needle on the profile shows its curvature. Needles point outward where the
profile is convex, and inward where it is hollow. The largest cutter has to fit the hollow flank.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

import camopt

scene = camopt.find_scene("valve-rod-radial")
cam = camopt.cam_points(scene, chord=0.002)
x, y, curvature = cam["profile_x_mm"], cam["profile_y_mm"], cam["profile_curvature_per_mm"]
tips = [end + 250 * curvature * cam[f"profile_normal_{axis}"] for axis, end in (("x", x), ("y", y))]

# %%
# The curvature jumps where the acceleration jumps.

figure, ax = plt.subplots(figsize=(7, 6))
needles = np.stack([np.column_stack([x, y]), np.column_stack(tips)], axis=1)
ax.add_collection(LineCollection(needles, array=curvature, cmap="coolwarm", clim=(-0.06, 0.06), lw=0.8))
ax.plot(*tips, color="#5f6b76", lw=0.6)
ax.fill(x, y, color="#dbe1e7", zorder=0)
ax.plot(x, y, color="#22303c", lw=1.5)
ax.add_patch(plt.Circle((0, 0), scene.cam.shaft_diameter / 2, color="white"))
ax.set_aspect("equal")
ax.axis("off")

# %%
# The sharpest convex part, and the largest cutter or grinding wheel that reaches every hollow:

found = camopt.evaluate(scene)
print(f"least convex radius {found['profile_radius_min_mm']:.3f} mm, cutter {found['cutter_radius_max_mm']:.3f} mm")

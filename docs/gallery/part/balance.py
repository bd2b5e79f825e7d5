"""
Mass, centre of gravity and balance
===================================

A cam is not round, so it shakes its shaft. ``[part]`` gives its thickness and bore. Mass and unbalance follow, and
may be limited.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("belt-matching").replace(
    part={"thickness": 16, "bore": 30, "keyway_width": 8, "keyway_depth": 3.3, "density": 7800},
    outputs=["section", "solid", "wall"],
)
found = camopt.evaluate(scene)
asked = (
    "area_mm2",
    "cam_mass_kg",
    "centre_of_gravity_mm",
    "unbalance_g_mm",
    "cam_inertia_kg_m2",
    "hub_wall_min_mm",
)
{name: round(found[name], 6) for name in asked}

# %%
# The centroid of the profile, and the counterweight that would balance the cam at 60 mm from the axis:

cam = camopt.cam_points(scene)
centroid = np.array([found["centroid_x_mm"], found["centroid_y_mm"]])
figure, ax = plt.subplots(figsize=(7, 6))
ax.fill(cam["profile_x_mm"], cam["profile_y_mm"], color="#c9d6e2", ec="#2a6ca3", lw=1.5)
ax.add_patch(plt.Circle((0, 0), scene.part.bore / 2, color="white", ec="#2a6ca3"))
ax.plot(0, 0, "k+", ms=12)
ax.plot(*centroid, "o", ms=13, mfc="white", mec="k")
ax.plot(*centroid, "kX", ms=7)
ax.annotate("", centroid, (0, 0), arrowprops={"arrowstyle": "-|>", "color": "#d55e00", "lw": 2})
weight = -60 * centroid / np.hypot(*centroid)
ax.plot(*weight, "s", color="#d55e00", ms=14)
label = f"{found['unbalance_g_mm'] / 60 / 1000:.2f} kg"
ax.text(weight[0], weight[1] + 7, label, ha="center", color="#d55e00", fontsize=12)
ax.set_aspect("equal")
ax.axis("off")

"""
The worked cams of textbooks
============================

camopt comes with worked examples of textbooks and with cams of practice. Each is a scene, which every command and
function takes by its name.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

names = [
    *("knife-900rpm-offset", "harmonic-240rpm-offset", "exhaust-valve", "valve-rod-offset"),
    *("roller-1000rpm", "oscillating-roller", "flat-reciprocating", "two-pauses"),
    *("belt-matching", "bucket-valve", "tangent-cam", "indexing-overlap"),
]

# %%
# The profile of each cam with its base circle, and the largest pressure angle.

figure, axes = plt.subplots(3, 4, figsize=(9, 7.5))
colours = plt.colormaps["viridis"](np.linspace(0.15, 0.85, len(names)))
for ax, name, colour in zip(axes.flat, names, colours, strict=True):
    scene = camopt.find_scene(name)
    cam = camopt.cam_points(scene)
    base = cam["profile_radius_mm"].min()
    ax.fill(cam["profile_x_mm"], cam["profile_y_mm"], color=colour)
    ax.add_patch(plt.Circle((0, 0), base, fill=False, color="white", ls="--"))
    ax.add_patch(plt.Circle((0, 0), 0.2 * base, color="white"))
    steepest = camopt.evaluate(scene)["pressure_angle_max_deg"]
    ax.set_title(f"{name}\nbase radius {base:.0f} mm, {steepest:.0f}°")
    ax.set_aspect("equal")
    ax.axis("off")

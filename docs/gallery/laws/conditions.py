"""
Conditions on the way
=====================

The lock bolt of an indexing table has to be out of its bush while the table turns, and to enter slowly. The scene
gives ranges of positions and velocities. The motion has the least mean-square jerk of all that meet them.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("indexing-overlap")
cam = camopt.cam_points(scene)
angle, lift = cam["cam_angle_deg"], cam["displacement_mm"]

# %%
# The bolt keeps out of the red zones.

figure, (above, below) = plt.subplots(2, sharex=True, figsize=(8, 5.5), height_ratios=(3, 2))
curves = {"position": (above, lift), "velocity": (below, np.gradient(lift, np.radians(angle)))}
for condition in scene.motion[1].through:
    for name, (ax, _) in curves.items():
        if window := getattr(condition, name):
            low, high = window
            ax.fill_between(condition.angle, low - 60, low, color="#b3261e", alpha=0.18, lw=0)
            ax.fill_between(condition.angle, high, high + 60, color="#b3261e", alpha=0.18, lw=0)
for k, (name, (ax, values)) in enumerate(curves.items()):
    ax.plot(angle, values, color=f"C{2 * k}", lw=2.5)
    ax.set(ylabel=f"{name}, {('mm', 'mm/rad')[k]}", xlim=(0, 360), ylim=((-2, 38), (-32, 32))[k])
below.set_xlabel("cam angle, deg")

# %%
# Interval arithmetic proves that the motion meets its conditions at every cam angle.

camopt.certify(scene)

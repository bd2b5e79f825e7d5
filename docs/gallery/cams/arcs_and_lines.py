"""
A cam of three arcs
===================

A workshop may give the profile in place of the motion: base circle, flanks and nose, each tangent to the next.
The motion of the follower is then exact on each arc.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("three-arc-valve")
for element in scene.profile:
    print(element.element, element.radius, element.x, element.y)

# %%
# The curvature of the profile tells which arc a point is on.

cam = camopt.cam_points(scene, step=0.25)
curvature = cam["profile_curvature_per_mm"]
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.5), width_ratios=(2, 3))
for radius, colour in zip((16, 80, 6), ("C7", "C0", "C1"), strict=True):
    here = np.abs(1 / curvature - radius) < 1e-6 * radius
    left.plot(*np.where(here, (cam["profile_x_mm"], cam["profile_y_mm"]), np.nan), color=colour, lw=3)
    right.plot(cam["cam_angle_deg"], np.where(here, cam["displacement_mm"], np.nan), color=colour, lw=3)
    left.plot([], [], color=colour, lw=3, label=f"radius {radius} mm")
left.fill(cam["profile_x_mm"], cam["profile_y_mm"], color="C7", alpha=0.12)
left.plot(0, 0, "k+", ms=12)
left.set(aspect="equal", xlabel="mm", ylabel="mm")
left.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, columnspacing=1, handlelength=1)
right.set(xlabel="cam angle, deg", ylabel="lift of the flat tappet, mm", xlim=(0, 360))

# %%
# Where arcs meet the acceleration jumps; its peaks are still exact.

found = camopt.evaluate(scene)
print(f"acceleration {found['acceleration_max_m_s2']:.3f} m/s², face reach {found['face_reach_max_mm']:.4f} mm")

"""
A tool behind a linkage
=======================

The cam turns an arm, the arm drives a four-bar linkage, and the linkage moves the ram of a press. The motion of the
ram is prescribed. The cam compensates for the changing ratio of the linkage.
"""

import matplotlib.pyplot as plt

import camopt

scene = camopt.find_scene("press-ram-by-four-bar")
camopt.plot(scene)

# %%
# The ram has the modified sine that was asked for. The arm in front of the linkage moves in another way, and a cam
# that gave the arm a modified sine would give the ram another acceleration:

tool = camopt.cam_points(scene, step=0.5)
strokes = [each.model_dump() for each in scene.motion]
turned = [each | {"lift": tool["displacement_deg"].max()} if each["lift"] else each for each in strokes]
other = camopt.cam_points(scene.replace(motion=turned, motion_at="follower"), step=0.5)
figure, ax = plt.subplots()
for cam, label in ((tool, "modified sine of the ram"), (other, "modified sine of the arm")):
    ax.plot(cam["cam_angle_deg"], cam["acceleration_m_s2"], label=label)
ax.set(xlabel="cam angle, deg", ylabel="acceleration of the ram, m/s²", xlim=(0, 360))
ax.legend()

# %%
# Of four linkages, that with the smallest cam within all limits:

best = camopt.optimise(scene).best
size, coupler = best["base_radius_mm"], best["train_1_coupler_mm"]
print(f"base radius {size:.3f} mm with a coupler of {coupler:g} mm, held by {', '.join(best['binding'])}")

"""
Undercut: a roller too large for its cam
========================================

For the same motion a larger roller makes the profile sharper. At last the profile has a point, and then it is cut
away. The follower would no longer make the motion, so such a cam is never feasible.
"""

import matplotlib.pyplot as plt

import camopt

scene = camopt.find_scene("exhaust-valve")
PRIME = 30  # mm, the least radius of the pitch curve: base radius and roller radius together

# %%
# Three rollers on the same pitch curve (dash-dot). The last one cuts the nose of its profile away.

figure, axes = plt.subplots(1, 3, figsize=(9.5, 3.3), sharex=True, sharey=True)
for ax, radius in zip(axes, (8, 20, 26), strict=True):
    rolling = scene.replace(**{"follower.roller_radius": radius, "cam.base_radius": PRIME - radius})
    cam, found = camopt.cam_points(rolling, step=0.05), camopt.evaluate(rolling)
    colour = "#b3261e" if found["undercut"] else "C0"
    ax.plot(cam["pitch_x_mm"], cam["pitch_y_mm"], color="#5f6b76", ls="-.", lw=0.9)
    ax.fill(cam["profile_x_mm"], cam["profile_y_mm"], color=colour, alpha=0.3)
    ax.plot(cam["profile_x_mm"], cam["profile_y_mm"], color=colour, lw=1.8)
    at = 1400  # 70° of cam angle, in the dwell
    ax.add_patch(
        plt.Circle((cam["pitch_x_mm"][at], cam["pitch_y_mm"][at]), radius, fill=False, ls=":", color=colour)
    )
    ax.set(aspect="equal", title=f"roller radius {radius} mm\nleast radius {found['profile_radius_min_mm']:.1f} mm")

# %%
# With a limit on the radius of the profile, ``optimise`` chooses the roller and the size together:

limited = scene.replace(
    limits={"curvature_radius": 2, "pressure_angle": 50}, search={"roller_radius": [10, 20, 30, 40]}
)
best = camopt.optimise(limited).best
print(best["roller_radius_mm"], best["base_radius_mm"], best["binding"])

"""
The main job in one picture
===========================

A roller follower rises 50 mm in 120° and returns in 90° at 1000 rev/min, within 30° of pressure angle. How small
can its cam be? The picture compares textbook laws, new laws with the peaks of one of them, and the bound for any
motion.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(**{"search.roller_radius": [20]})
smallest = sorted(camopt.optimise(scene).by_law.values(), key=lambda design: -design["base_radius_mm"])
free = camopt.synthesise(scene)

# %%
# Left, the least pressure angle over the offsets for each size, and a dot at the smallest cam of each law. Then
# these cams at one scale, and the cam of new laws in front of that of the 3-4-5 polynomial, whose peaks they
# have. The dashed circle is the base circle that no motion can go below.

offset, size = (grid.ravel() for grid in np.meshgrid(np.linspace(2, 14, 25), np.linspace(25, 110, 35)))
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.4), width_ratios=(1.3, 1, 1))
colours = plt.colormaps["viridis"](np.linspace(0, 0.95, len(smallest)))
for design, colour in zip(smallest, colours, strict=True):
    law, radius = design["law_rise"], design["base_radius_mm"]
    table = {"base_radius_mm": size, "offset_mm": offset, "roller_radius_mm": 20.0, "law": law}
    steepest = camopt.evaluate_designs(scene, table).groupby("base_radius_mm").pressure_angle_max_deg.min()
    left.plot(steepest, color=colour, lw=2, label=f"{law} {radius:.1f} mm")
    left.plot(radius, 30, "o", color=colour, mec="white", ms=8, zorder=3)
    cam = camopt.cam_points(design.scene)
    middle.fill(cam["profile_x_mm"], cam["profile_y_mm"], color=colour, ec="white", lw=0.8)
    if law == "poly345":
        right.fill(cam["profile_x_mm"], cam["profile_y_mm"], color="C7", alpha=0.5, label=f"{law} {radius:.1f} mm")
left.axhspan(30, 60, color="#b3261e", alpha=0.08, lw=0)
left.set(xlabel="base radius, mm", ylabel="least pressure angle, deg", xlim=(25, 110), ylim=(18, 42))
left.legend(reverse=True)
cam = camopt.cam_points(free.scene)
label = f"new laws, same peaks {free.design['base_radius_mm']:.1f} mm"
right.fill(cam["profile_x_mm"], cam["profile_y_mm"], color="C0", ec="white", label=label)
right.add_patch(plt.Circle((0, 0), free.bound, fill=False, color="white", ls="--"))
right.plot([], [], "k--", lw=1, label=f"no motion has less than {free.bound:.1f} mm")
right.legend(loc="lower center")
left.set_title("The smallest cam of each motion law")
for ax, title in ((middle, "These cams at one scale"), (right, "Computed laws: smaller still")):
    ax.set_title(title)
    ax.add_patch(plt.Circle((0, 0), 6, color="white"))
    ax.set(aspect="equal", xlim=(-130, 76), ylim=(-145, 76))
    ax.axis("off")

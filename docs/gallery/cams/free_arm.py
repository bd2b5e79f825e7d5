"""
An oscillating follower whose arm is free
=========================================

Textbooks give the arm and the place of its pivot. Here both are free. The cam is the smallest within 35° of
pressure angle, with an arm of 60 to 140 mm, and clears a shaft of 25 mm.
"""

import matplotlib.pyplot as plt

import camopt

textbook = camopt.find_scene("oscillating-roller").replace(
    **{"limits": {"pressure_angle": 35, "curvature_radius": 5}, "cam.shaft_diameter": 25}
)
free = {"arm_length": {"start": 60, "stop": 140}, "centre_distance": {"start": 60, "stop": 180}}
before = camopt.optimise(textbook).best
after = camopt.optimise(textbook.replace(search=free)).best
{name: (before[name], after[name]) for name in ("base_radius_mm", "arm_length_mm", "centre_distance_mm", "binding")}

# %%
# The pivot is at the right end of the arm; the follower is at its lowest.

figure, axes = plt.subplots(1, 2, figsize=(9, 4.5), sharex=True, sharey=True)
for ax, design, word in zip(axes, (before, after), ("arm and pivot of the textbook", "both free"), strict=True):
    cam = camopt.cam_points(design.scene)
    roller = (cam["pitch_x_mm"][0], cam["pitch_y_mm"][0])
    ax.fill(cam["profile_x_mm"], cam["profile_y_mm"], color="C0", alpha=0.25)
    ax.plot(cam["profile_x_mm"], cam["profile_y_mm"], color="C0")
    ax.plot([design["centre_distance_mm"], roller[0]], [0, roller[1]], "o-", color="C1", lw=3)
    ax.add_patch(plt.Circle(roller, design["roller_radius_mm"], fill=False, color="C1", lw=1.6))
    ax.add_patch(plt.Circle((0, 0), 12.5, color="white"))
    ax.plot(0, 0, "k+", ms=12)
    ax.set(aspect="equal", title=f"{word}: base radius {design['base_radius_mm']:.2f} mm")

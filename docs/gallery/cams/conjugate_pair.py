"""
Two discs that push both ways
=============================

The feed of a press at 400 rev/min: a rocker with two rollers between two discs on one shaft. One disc pushes it
out, the other one pushes it back, and there is no spring. The arms are a hundredth of a degree too close for the
discs: this is the preload.
"""

import matplotlib.pyplot as plt

import camopt

scene = camopt.find_scene("press-feed-by-pair")
camopt.plot(scene)

# %%
# The more the rollers are squeezed, the higher is the stress. With too little, one of them lets go where the rocker
# is accelerated: its stress is 0 there. Thick lines are the first contact, thin ones the second.

figure, ax = plt.subplots()
for interference, colour in ((0.001, "C3"), (0.005, "C1"), (0.01, "C0")):
    squeezed = scene.replace(**{"drive.interference": interference})
    cam = camopt.cam_points(squeezed, step=0.5)
    for side, width in (("first", 2.2), ("second", 0.9)):
        ax.plot(cam["cam_angle_deg"], cam[f"{side}_contact_stress_MPa"], color=colour, lw=width)
    ax.plot([], [], color=colour, label=f"{interference:g}°")
ax.set(xlabel="cam angle, deg", ylabel="contact stress, MPa", xlim=(0, 360), ylim=(0, 540))
ax.legend(title="interference", ncols=3, loc="upper center")

# %%
# How many times the preload that it takes there is at this speed, and the smallest pair:

ratio = camopt.evaluate(scene.replace(outputs=["pair_preload_ratio"]))["pair_preload_ratio"]
print(f"{ratio:.2f} times the preload that keeps both rollers on their discs")
best = camopt.optimise(scene.replace(**{"search.base_radius": {"start": 40, "stop": 100}})).best
print(f"smallest base radius {best['base_radius_mm']:.3f} mm, held by {', '.join(best['binding'])}")

"""
Wear under a flat face
======================

A flat tappet slides on its cam. Load and sliding distance wear the profile by Archard's law, most on the nose,
which has the least length of profile for its sliding. The halo is the wear, five thousand times enlarged.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("bucket-valve").replace(
    **{
        "follower.dynamics.mass": 0.12,
        "follower.dynamics.spring_rate": 40,
        "follower.dynamics.preload": 300,
        "materials": {"cam": "steel", "follower": "steel", "face_width": 14, "wear_rate": 1e-11},
        "outputs": ["surface", "hertz"],
    }
)
cam = camopt.cam_points(scene, step=0.25)
wear = cam["wear_depth_um"]
print(f"at most {camopt.evaluate(scene)['wear_depth_max_um']:.3f} µm in a million turns")

# %%
# Depth worn off in a million turns, along the profile's normals:

x, y = cam["profile_x_mm"], cam["profile_y_mm"]
out = wear / wear.max() * 6
figure, ax = plt.subplots(figsize=(7, 5.5))
ax.fill(x, y, color="#dbe1e7")
tips = np.stack([x + out * cam["profile_normal_x"], y + out * cam["profile_normal_y"]])
for k in range(len(x) - 1):
    shade = plt.colormaps["inferno"](0.9 - 0.8 * wear[k] / wear.max())
    ax.fill([*x[k : k + 2], *tips[0, k : k + 2][::-1]], [*y[k : k + 2], *tips[1, k : k + 2][::-1]], color=shade)
ax.plot(x, y, color="k", lw=1)
ax.plot(0, 0, "k+", ms=12)
ax.set_aspect("equal")
ax.axis("off")
scale = plt.cm.ScalarMappable(plt.Normalize(0, wear.max()), plt.colormaps["inferno_r"])
figure.colorbar(scale, ax=ax, label="wear in a million turns, µm")

"""
The smallest cam of each motion law
===================================

``optimise`` has no grid. It finds the smallest base radius within the limits, proves it, and names the active
limits.
"""

import matplotlib.pyplot as plt
import pandas as pd

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(**{"search.roller_radius": [20]})
found = camopt.optimise(scene)
table = pd.DataFrame(found.by_law).T.sort_values("base_radius_mm")
table[["base_radius_mm", "offset_mm", "acceleration_max_m_s2", "binding", "proved"]]

# %%
# The cams, one behind the other:

figure, ax = plt.subplots(figsize=(8, 5.5))
colours = plt.colormaps["cividis"].resampled(len(table))
for k, law in enumerate(table.index[::-1]):
    cam = camopt.cam_points(found.by_law[law].scene)
    label = f"{law}: {table.base_radius_mm[law]:.2f} mm"
    ax.fill(cam["profile_x_mm"], cam["profile_y_mm"], color=colours(k), ec="white", lw=1, label=label)
ax.add_patch(plt.Circle((0, 0), 8, color="white"))
ax.set_aspect("equal")
ax.axis("off")
figure.legend(loc="outside right center", title="base radius", reverse=True)

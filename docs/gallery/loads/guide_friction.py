"""
Friction in the guide: efficiency and jamming
=============================================

The pressure angle pushes the follower against its guide. With friction, the further the follower overhangs its
guide, the more force a cam needs, until the follower jams.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("valve-rod-radial").replace(
    **{
        "follower.dynamics": {"mass": 1, "load": 200, "guide_length": 60, "overhang": 60, "friction": 0.1},
        "outputs": ["jamming_margin"],
    }
)

# %%
# The margin 1 − μ·(1 + 2·overhang/guide)·tan β is 1 without friction and 0 where the follower jams.

friction, overhang = np.meshgrid(np.linspace(0.01, 0.3, 12), np.linspace(50, 160, 8))
table = {"friction": friction.ravel(), "overhang_mm": overhang.ravel()}
found = camopt.evaluate_designs(scene, table)
margin = found["jamming_margin"].to_numpy().reshape(friction.shape)
figure, ax = plt.subplots(figsize=(7, 5))
shades = ax.contourf(friction, overhang, margin, levels=np.arange(0, 1.01, 0.1), cmap="YlGnBu", extend="min")
ax.contour(friction, overhang, margin, levels=[0], colors="#b3261e", linewidths=2.5)
ax.text(0.25, 140, "jams", color="#b3261e", fontsize=14, weight="bold", ha="center")
ax.set(xlabel="coefficient of friction", ylabel="overhang, mm (guide of 60 mm)")
figure.colorbar(shades, label="jamming margin")

# %%
# The power that goes into friction:

for value in (0, 0.05, 0.1):
    each = camopt.evaluate(scene.replace(**{"follower.dynamics.friction": value, "outputs": ["power_mean_W"]}))
    print(f"friction {value:4.2f}: mean power {each['power_mean_W']:.2f} W")

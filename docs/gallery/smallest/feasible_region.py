"""
Where cams are feasible
=======================

``evaluate_designs`` evaluates a table of designs at once, and gives the excess of each design over every limit.
Here the designs fill the plane of offset and base radius. The smallest cam of ``optimise`` is in the corner.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(
    **{"search.law": ["cycloidal"], "search.offset": {"start": -40, "stop": 50}, "search.roller_radius": [12]}
)
offset, radius = np.meshgrid(np.linspace(-40, 50, 91), np.linspace(15, 105, 91))
table = {
    "base_radius_mm": radius.ravel(),
    "offset_mm": offset.ravel(),
    "roller_radius_mm": 12.0,
    "law": "cycloidal",
}
found = camopt.evaluate_designs(scene, table)
best = camopt.optimise(scene).best

# %%
# The limits of rise and return on the pressure angle are straight lines in this plane.

figure, ax = plt.subplots(figsize=(7, 5.5))
angle, rise, fall = (
    found[name].to_numpy().reshape(offset.shape)
    for name in ("pressure_angle_max_deg", "excess_pressure_angle", "excess_pressure_angle_return")
)
shades = ax.contourf(offset, radius, angle, levels=range(15, 61, 5), cmap="RdYlBu_r", extend="both")
ax.contour(offset, radius, rise, levels=[0], colors="k")
ax.contour(offset, radius, fall, levels=[0], colors="k", linestyles="--")
ax.plot(best["offset_mm"], best["base_radius_mm"], "*", color="k", ms=14)
figure.colorbar(shades, label="largest pressure angle, deg")
ax.set(xlabel="offset, mm", ylabel="base radius, mm", title="30° on the rise: full line; on the return: dashed")

"""
How the strokes share the turn
==============================

Rise and return have 180° together, in any proportion. ``optimise`` finds the proportion with the smallest cam, and
agrees with a scan of the angles.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("valve-rod-offset").replace(
    **{
        "limits": {"pressure_angle": 30, "pressure_angle_return": 40},
        "cam.shaft_diameter": None,
        "search.offset": {"start": -30, "stop": 30},
    }
)
strokes = [segment.model_dump(exclude_none=True) for segment in scene.motion]
together = strokes[0]["angle"] + strokes[2]["angle"]

# %%
# The search takes the sum from the scene and shares it out:

free = {"angle_rise": {"start": 60, "stop": 140}, "angle_return": {"start": 40, "stop": 120}}
best = camopt.optimise(scene.replace(**{f"search.{key}": value for key, value in free.items()})).best
print(f"base radius {best['base_radius_mm']:.3f} mm, angles {best['angles_deg']}")

# %%
# The smallest cam for each share of the rise:

rises = np.linspace(70, 130, 25)
sizes = []
for rise in rises:
    angles = {0: float(rise), 2: float(together - rise)}
    motion = [stroke | {"angle": angles.get(k, stroke["angle"])} for k, stroke in enumerate(strokes)]
    sizes.append(camopt.optimise(scene.replace(motion=motion)).best["base_radius_mm"])
figure, ax = plt.subplots()
ax.plot(rises, sizes, color="C0")
ax.fill_between(rises, min(sizes) - 5, sizes, color="C0", alpha=0.12)
ax.plot(best["angles_deg"][0], best["base_radius_mm"], "*", color="C1", ms=18)
ax.set(
    xlabel=f"angle of the rise, deg (the return has the rest of {together:g})", ylabel="smallest base radius, mm"
)

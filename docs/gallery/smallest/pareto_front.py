"""
A Pareto front in pandas
========================

A sweep evaluates each design of a grid. Among the designs that meet every limit, the front keeps those that
cannot be improved in one objective without loss in another.
"""

import matplotlib.pyplot as plt

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(
    **{
        "search.base_radius": {"start": 30, "stop": 150, "step": 4},
        "search.offset": {"start": -16, "stop": 24, "step": 4},
        "search.roller_radius": [10, 20],
        "search.law": ["parabolic", "harmonic", "modified-sine", "cycloidal", "poly4567"],
        "limits": {"pressure_angle": 40, "pressure_angle_return": 40, "curvature_radius": 1},
    }
)
swept = camopt.sweep(scene, out="results")
designs, front = camopt.load("results/designs.parquet"), camopt.load("results/pareto.parquet")
swept

# %%
# Small dots are feasible designs, large ones the front: less of everything is better.

figure, ax = plt.subplots(figsize=(8, 5))
ax.plot(designs.base_radius_mm, designs.pressure_angle_max_deg, ".", color="#c3cad1", ms=3, zorder=1)
for law, rows in front.groupby("law_rise"):
    peak = rows.acceleration_max_m_s2.iloc[0]
    ax.scatter(rows.base_radius_mm, rows.pressure_angle_max_deg, s=28, label=f"{law}, {peak:.0f} m/s²", zorder=2)
ax.set(xlabel="base radius, mm", ylabel="largest pressure angle, deg")
ax.legend(title="on the front")

# %%
# Tables know their units, and every row is a scene again.

smallest = front.base_radius_mm.idxmin()
print(front.attrs["units"]["acceleration_max_m_s2"], front.attrs["front"]["hypervolume"])
camopt.scene_of(front, smallest)

"""
What each limit costs
=====================

The price of a limit is the derivative of the smallest size: the mm that one degree more saves. A line with this
slope touches the curve of the smallest cams.
"""

import matplotlib.pyplot as plt
import numpy as np

import camopt

scene = camopt.find_scene("roller-1000rpm").replace(
    **{"search.law": ["cycloidal"], "search.roller_radius": [20], "search.base_radius": {"start": 5, "stop": 400}}
)
found = camopt.optimise(scene)
prices = {price.key: price for price in camopt.prices(found)["cycloidal"]}
for price in prices.values():
    print(f"{price.key:30s} {price.price:7.3f} mm per {price.unit}, to {price.holds_to:.1f} {price.unit}")

# %%
# The smallest cam for each value of one limit, the other one kept at 30°:

figure, ax = plt.subplots()
bounds = np.linspace(20, 50, 16)
for k, (key, price) in enumerate(prices.items()):
    sizes = [camopt.optimise(scene.replace(**{key: bound})).best["base_radius_mm"] for bound in bounds]
    ax.plot(bounds, sizes, "o-", ms=3, color=f"C{k}", label=key)
    near = np.array([24, 36])
    ax.plot(near, found.best["base_radius_mm"] + price.price * (near - 30), color=f"C{k}", ls="--", lw=1)
ax.plot(30, found.best["base_radius_mm"], "ko")
ax.annotate("both at 30°", (30, found.best["base_radius_mm"]), (31, 62), arrowprops={"arrowstyle": "-"})
ax.set(xlabel="limit on the pressure angle, deg", ylabel="smallest base radius, mm")
ax.legend(title="dashed: the price")

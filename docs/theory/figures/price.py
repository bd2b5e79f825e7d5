"""The smallest size over a limit, and the price at one place as the slope there."""

import matplotlib.pyplot as plt
import numpy as np
from roller import SCENE

import camopt
from camopt.show.drawing.style import INK, SERIES, add_grid


def asked(limit):
    free = {"search.offset": {"start": -20, "stop": 20}, "limits.pressure_angle_return": 35}
    return SCENE.replace(**free, **{"limits.pressure_angle": float(limit)})


limits = np.linspace(22, 42, 21)
sizes = [camopt.optimise(asked(limit)).best["base_radius_mm"] for limit in limits]
optimum = camopt.optimise(asked(30))
price = next(p.price for p in camopt.prices(optimum).popitem()[1] if p.key == "limits.pressure_angle")
size = optimum.best["base_radius_mm"]

figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
axes.plot(limits, sizes, color=SERIES[0], lw=1.5)
axes.plot([23, 38], [size + price * (x - 30) for x in (23, 38)], color=SERIES[1], lw=1.1, ls=(0, (5, 3)))
axes.plot(30, size, "o", color=INK, ms=6)
axes.annotate(f"price: {price:.3f} mm per deg".replace("-", "−"), (30, size), (10, 8), textcoords="offset points")
axes.set(xlabel="limit on the pressure angle of the rise, deg", ylabel="smallest base radius, mm")
add_grid(axes)

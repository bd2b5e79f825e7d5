"""Hodographs of the best textbook law and of free laws within the same peaks."""

import matplotlib.pyplot as plt
import numpy as np
from roller import SCENE

import camopt
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.style import FAINT, SERIES, add_grid

wanted = {"limits.pressure_angle": 30, "search.offset": {"start": -20, "stop": 20}}
scene = SCENE.replace(**wanted, **{"synthesis.pieces": 16})
free, known = camopt.synthesise(scene), camopt.optimise(scene).best
T = np.tan(np.radians(30))

figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
for place, (design, motion, name) in enumerate(
    ((known, scene, "cycloidal / modified sine"), (free.design, free.scene, "free laws"))
):
    y, y1, *_ = resolve_design(motion).programme.motion_at(np.linspace(0, 2 * np.pi, 2001))
    e, prime = design["offset_mm"], design["prime_radius_mm"]
    s0 = np.sqrt(prime**2 - e**2)
    axes.plot(y, y1, color=SERIES[place], lw=1.5, label=f"{name}: $R_b$ = {design['base_radius_mm']:.2f} mm")
    axes.plot(-s0, e, "o", color=SERIES[place], ms=6)
    for side in (1, -1):
        axes.plot([-s0, 27], [e, e + side * T * (s0 + 27)], color=SERIES[place], lw=0.8, ls=(0, (5, 3)))
axes.axvline(0, color=FAINT, lw=0.8)
axes.set(xlabel="displacement $y$, mm   (designs: $-s_0$)", ylabel="$y'$, mm per rad   (designs: $e$)")
add_grid(axes)
axes.legend(loc="upper left")

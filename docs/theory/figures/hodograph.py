"""Velocity over displacement, and the tangents from two designs: the steepest is the largest pressure angle."""

import matplotlib.pyplot as plt
import numpy as np
from roller import PROGRAMME

from camopt.show.drawing.style import FAINT, INK, SERIES

y, y1, *_ = PROGRAMME.motion_at(np.linspace(0, 2 * np.pi, 2001))
T = np.tan(np.radians(30))
A, B = (y1 - T * y).max(), (-y1 - T * y).max()
apex = np.array([-(A + B) / (2 * T), (A - B) / 2])

figure, axes = plt.subplots(figsize=(7, 4.2), layout="constrained")
far = -72.0
edges = [A + T * far, -B - T * far]
axes.fill([far, apex[0], far], [edges[0], apex[1], edges[1]], color="#e9f1f8", zorder=0)
for sign, level in ((1, A), (-1, -B)):
    axes.plot([far, 40], [level + sign * T * far, level + sign * T * 40], color=SERIES[0], lw=0.9, ls=(0, (5, 3)))
axes.plot(y, y1, color=INK, lw=1.4)
for s0, lead, colour in ((48.0, 0.0, SERIES[1]), (34.0, 16.0, SERIES[2])):
    slope = (y1 - lead) / (s0 + y)
    k = np.abs(slope).argmax()
    axes.plot([-s0, y[k]], [lead, y1[k]], color=colour, lw=1.2)
    axes.plot([-s0, y[k]], [lead, y1[k]], "o", color=colour, ms=5)
    axes.annotate(
        f"$s_0$ = {s0:g}, $e$ = {lead:g}: {np.degrees(np.arctan(abs(slope[k]))):.1f}°",
        (-s0, lead), (-6, 4), textcoords="offset points", color=colour, ha="right",
    )  # fmt: skip
axes.plot(*apex, "o", mfc="white", mec=SERIES[0], ms=6)
axes.axhline(0, color=FAINT, lw=0.8)
axes.axvline(0, color=FAINT, lw=0.8)
axes.text(12.5, 24, "rise", color=INK, ha="center")
axes.text(12.5, -18, "return", color=INK, ha="center")
axes.text(-71, -6, "within 30°", color=SERIES[0])
axes.set(xlabel="displacement $y$, mm   (designs: $-s_0$)", ylabel="$y'$, mm per rad   (designs: $e$)")
axes.set(xlim=(-72, 34), ylim=(-30, 36))

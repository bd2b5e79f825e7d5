"""The polygon of heights and leads that a limit on the pressure angle allows, and its point next to the origin."""

import matplotlib.pyplot as plt
import numpy as np
from roller import PROGRAMME

from camopt.show.drawing.style import FAINT, INK, MUTED, SERIES

y, y1, *_ = PROGRAMME.motion_at(np.linspace(0, 2 * np.pi, 4001))
T = np.tan(np.radians(30))
A, B = (y1 - T * y).max(), (-y1 - T * y).max()
corner = (A - B) / 2, (A + B) / (2 * T)

figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
leads = np.linspace(-30, 30, 200)
heights = np.maximum((A - leads) / T, (B + leads) / T)
axes.fill_between(leads, heights, 70, color="#e9f1f8", lw=0)
axes.plot(leads, (A - leads) / T, color=SERIES[0], lw=1.1)
axes.plot(leads, (B + leads) / T, color=SERIES[1], lw=1.1)
turn = np.linspace(0, np.pi, 200)
for radius in (np.hypot(*corner), A / T):
    axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=FAINT, lw=1.0)
axes.plot([0, corner[0]], [0, corner[1]], color=MUTED, lw=0.9)
axes.plot(*corner, "o", color=INK, ms=6)
axes.plot(0, A / T, "o", mfc="white", mec=INK, ms=6)
axes.plot(0, 0, "+", color=INK)
axes.annotate(
    f"smallest: $R_p$ = {np.hypot(*corner):.2f} mm, $e$ = {corner[0]:.2f}",
    corner,
    (14, -12),
    textcoords="offset points",
)
axes.annotate(f"without offset: {A / T:.2f} mm", (0, A / T), (-12, 4), textcoords="offset points", ha="right")
axes.text(-18, 58, "rise: $e + T s_0 = A$", color=SERIES[0], ha="right")
axes.text(23, 58, "return: $-e + T s_0 = B$", color=SERIES[1])
axes.set(xlabel="lead $e$, mm", ylabel="height $s_0$, mm", xlim=(-45, 45), ylim=(-2, 68))
axes.set_aspect("equal")

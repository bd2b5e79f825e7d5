"""The built-in laws from rest to rest by their largest velocity and acceleration; jerk as the size of a dot."""

import matplotlib.pyplot as plt
import numpy as np

import camopt
from camopt.model.motion.scca import SCCALaw
from camopt.show.drawing.style import DASHES, FAINT, INK, MUTED, SERIES

NAMES = ["parabolic", "harmonic", "cubic", "modified-sine", "modified-trapezoid"]
NAMES += ["poly345", "cycloidal", "poly4567", "poly56789"]
x = np.linspace(0, 1, 20_001)[1:-1]


def peaks(law):
    return np.abs(law.acceleration(x)).max(), np.abs(law.velocity(x)).max()


figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
shares = np.linspace(0, 1, 41)
family = [peaks(SCCALaw("", (b / 2, 1 - b, b / 2, 0))) for b in shares]
axes.plot(*zip(*family, strict=True), color=FAINT, lw=1.2, ls=DASHES[1], zorder=1)
family = [peaks(SCCALaw("", (b, 0, 1 - b, 0))) for b in shares / 2]
axes.plot(*zip(*family, strict=True), color=FAINT, lw=1.2, zorder=1)
beside = {"parabolic": (6, 5), "modified-trapezoid": (0, 8), "harmonic": (8, -3), "poly56789": (-58, -12)}
for name in NAMES:
    law = camopt.LAWS[name]
    infinite = np.abs(law.acceleration([0.0])[0]) > 0
    a, v = peaks(law)
    axes.plot(a, v, "o", ms=7, mfc="white" if infinite else SERIES[0], mec=SERIES[0])
    axes.annotate(name, (a, v), beside.get(name, (7, -10)), textcoords="offset points", color=INK)
axes.axvline(4, color=MUTED, lw=0.8)
axes.set(xlabel="largest acceleration $C_a$", ylabel="largest velocity $C_v$", xlim=(3.7, 10.2), ylim=(1.4, 2.6))
axes.plot([], [], "o", ms=7, mfc="white", mec=SERIES[0], label="jerk infinite")
axes.plot([], [], "o", ms=7, color=SERIES[0], label="jerk finite")
axes.legend(loc="lower right")

"""
Motion laws compared
====================

The laws that camopt knows, on a stroke of 1 in a time of 1: displacement, velocity, acceleration and jerk.
"""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import camopt

names = ("parabolic", "harmonic", "cycloidal", "poly345", "modified-sine", "modified-trapezoid")
x = np.linspace(1e-9, 1 - 1e-9, 2001)
verbs = ("displacement", "velocity", "acceleration", "jerk")
curves = {name: [getattr(camopt.LAWS[name], verb)(x) for verb in verbs] for name in names}

# %%
# Less acceleration costs more jerk: the parabola has the least acceleration, and impulses of jerk.

figure, axes = plt.subplots(2, 2, figsize=(9, 6), sharex=True)
for k, (ax, verb) in enumerate(zip(axes.flat, verbs, strict=True)):
    for name in names:
        ax.plot(x, curves[name][k], label=name)
    ax.set_title(verb.capitalize())
axes[1, 1].set_ylim(-65, 65)
axes[0, 0].legend()

# %%
# Peaks of all laws that rest at both ends:

peaks = pd.DataFrame(
    {verb: [np.abs(getattr(law, verb)(x)).max() for law in camopt.LAWS.values()] for verb in verbs[1:]},
    index=list(camopt.LAWS),
)
peaks[peaks.velocity < 2.3].sort_values("acceleration").round(3)
